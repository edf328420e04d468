//! A frame that never ends is found, too: another thread ends the program and says what it was at.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

static AT: Mutex<Option<(Instant, String)>> = Mutex::new(None);

/// Says what is being done from now on; nothing, if none.
pub fn at(what: Option<String>) {
    *AT.lock().unwrap_or_else(PoisonError::into_inner) = what.map(|what| (Instant::now(), what));
}

/// The frame goes on: the time begins anew.
pub fn alive() {
    if let Some((since, _)) = &mut *AT.lock().unwrap_or_else(PoisonError::into_inner) {
        *since = Instant::now();
    }
}

/// Watches from a thread of its own; `end` is called once when nothing was heard for so long.
pub fn begin(patience: Duration, end: impl FnOnce(&str) + Send + 'static) {
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let at = AT.lock().unwrap_or_else(PoisonError::into_inner).clone();
            if let Some((since, what)) = at
                && since.elapsed() > patience
            {
                return end(&what);
            }
        }
    });
}
