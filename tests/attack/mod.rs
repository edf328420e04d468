//! The random attack: apps, meshes and files made from a number, and what must hold whatever they are.
//!
//! ```text
//! seed ── plan: what is done, as data ── play: does it in an app ── check: after every frame
//!                    └──────── shrink: leaves out what a failure does not need ◂──┘
//! ```

pub mod wild;
pub mod shapes;
pub mod damage;
pub mod mirror;
pub mod plan;
pub mod headless;
pub mod stage;
pub mod actors;
pub mod clothes;
pub mod physics;
pub mod deeds;
pub mod places;
pub mod watch;
pub mod check;
pub mod log;
pub mod panics;
pub mod play;
pub mod edits;
pub mod texts;
pub mod glb;
pub mod files;
pub mod case;
pub mod shrink;
