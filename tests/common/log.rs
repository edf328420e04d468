//! What the plugin warns of, line by line.

use std::io::sink;
use std::sync::{Arc, Mutex, Once, PoisonError};

use bevy::log::tracing_subscriber::fmt::MakeWriter;
use bevy::log::{tracing, tracing_subscriber};

/// What was logged and not read yet.
#[derive(Clone, Default)]
pub struct Log(Arc<Mutex<Vec<u8>>>);

impl std::io::Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl<'a> MakeWriter<'a> for Log {
    type Writer = Self;

    fn make_writer(&'a self) -> Self {
        self.clone()
    }
}

/// Whether a warning is of interest is asked once for all threads, by the one that comes by it first.
/// So threads that nobody listens to have to show interest, too.
static EVERY_THREAD: Once = Once::new();

/// Writes warnings, and nothing else, as plain lines.
fn subscriber<W: for<'a> MakeWriter<'a> + Send + Sync + 'static>(writer: W) -> impl tracing::Subscriber + Send + Sync {
    let builder = tracing_subscriber::fmt().with_max_level(tracing::Level::WARN);
    builder.with_ansi(false).without_time().with_writer(writer).finish()
}

impl Log {
    /// Listens to this thread while `act` runs.
    pub fn listen<T>(&self, act: impl FnOnce() -> T) -> T {
        // One that an app has set before does as well.
        EVERY_THREAD.call_once(|| drop(tracing::subscriber::set_global_default(subscriber(sink))));
        tracing::subscriber::with_default(subscriber(self.clone()), act)
    }

    /// Warnings of the plugin since this was asked last.
    pub fn read(&self) -> Vec<String> {
        let bytes = std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner));
        let text = String::from_utf8_lossy(&bytes);
        text.lines().filter(|line| line.contains("bevy_drape")).map(str::to_owned).collect()
    }
}
