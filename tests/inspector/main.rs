//! The panel, driven as a user does: by the names of its widgets. One binary, because linking Bevy is what takes long.

use drape_tests::common;

mod actions;
mod cost;
mod drag;
mod files;
mod live;
mod numbers;
mod panel;
mod rows;
