//! What is warned of: once for each cause, until something is done again.

use std::sync::{Arc, Mutex, PoisonError};

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

impl Log {
    /// Listens to this thread while `act` runs.
    pub fn listen<T>(&self, act: impl FnOnce() -> T) -> T {
        let subscriber = tracing_subscriber::fmt()
            .with_max_level(tracing::Level::WARN)
            .with_ansi(false)
            .without_time()
            .with_writer(self.clone())
            .finish();
        tracing::subscriber::with_default(subscriber, act)
    }

    /// Warnings of the plugin since this was asked last.
    pub fn read(&self) -> Vec<String> {
        let bytes = std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner));
        let text = String::from_utf8_lossy(&bytes);
        text.lines().filter(|line| line.contains("bevy_drape::")).map(str::to_owned).collect()
    }
}

/// Causes that were told of since something was done.
#[derive(Default)]
pub struct Told(Vec<String>);

impl Told {
    /// Something was done: everything may be told again.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The first line of a cause that was told before.
    pub fn again<'a>(&mut self, lines: &'a [String]) -> Option<&'a str> {
        lines.iter().find_map(|line| {
            let cause = cause(line);
            let again = self.0.contains(&cause);
            self.0.push(cause);
            again.then_some(line.as_str())
        })
    }
}

/// A warning without its numbers; names of entities, such as `12v3`, stay.
fn cause(line: &str) -> String {
    let is_entity = |word: &str| {
        word.split_once('v').is_some_and(|(a, b)| [a, b].iter().all(|n| !n.is_empty() && n.bytes().all(|c| c.is_ascii_digit())))
    };
    let is_number = |word: &str| word.bytes().any(|c| c.is_ascii_digit()) || word.contains("NaN") || word.contains("inf");
    let words = line.split(|c: char| c.is_whitespace() || "`(),:".contains(c)).filter(|word| !word.is_empty());
    let words: Vec<&str> = words.map(|word| if !is_entity(word) && is_number(word) { "#" } else { word }).collect();
    words.join(" ")
}
