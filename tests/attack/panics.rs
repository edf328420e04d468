//! Panics, caught with the place where they began.

use std::panic::{AssertUnwindSafe, Location, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once, PoisonError};

static CATCHING: AtomicBool = AtomicBool::new(false);
static FIRST: Mutex<Option<Panic>> = Mutex::new(None);

/// A panic.
#[derive(Clone, Debug)]
pub struct Panic {
    /// File and line.
    pub place: String,
    /// What it says.
    pub says: String,
}

/// Runs `act`; or the first panic in it, in any thread.
///
/// # Errors
/// If it panics.
pub fn caught<T>(act: impl FnOnce() -> T) -> Result<T, Panic> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !CATCHING.load(Ordering::SeqCst) {
                return before(info);
            }
            let place = info.location().map_or_else(|| "?".into(), place);
            let says = info.payload_as_str().unwrap_or("?").chars().take(600).collect();
            first().get_or_insert(Panic { place, says });
        }));
    });
    *first() = None;
    CATCHING.store(true, Ordering::SeqCst);
    let done = catch_unwind(AssertUnwindSafe(act));
    CATCHING.store(false, Ordering::SeqCst);
    done.map_err(|_| seen().unwrap_or_else(|| Panic { place: "?".into(), says: "a panic without words".into() }))
}

/// The first panic since [`caught`] began, even if somebody else caught it.
pub fn seen() -> Option<Panic> {
    first().take()
}

fn first() -> std::sync::MutexGuard<'static, Option<Panic>> {
    FIRST.lock().unwrap_or_else(PoisonError::into_inner)
}

/// File and line, without the folders before the crate.
fn place(at: &Location) -> String {
    let file = at.file().replace('\\', "/");
    let file =
        file.rsplit_once("/registry/src/").map_or(file.as_str(), |(_, file)| file.split_once('/').map_or(file, |(_, f)| f));
    format!("{file}:{}", at.line())
}
