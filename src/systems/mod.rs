//! One short system per stage: query, call the solver, record. [`crate::plugin`] orders them.

pub(crate) mod background;
pub(crate) mod bind;
pub(crate) mod budget;
pub(crate) mod carriers;
pub(crate) mod character;
pub(crate) mod colliders;
pub(crate) mod couple;
pub(crate) mod defaults;
pub(crate) mod detect;
pub(crate) mod drawn;
pub(crate) mod evaluate;
pub(crate) mod grab;
pub(crate) mod inputs;
pub(crate) mod integrate;
mod islands;
mod jobs;
pub(crate) mod lod;
pub(crate) mod pieces;
pub(crate) mod poses;
pub(crate) mod release;
pub(crate) mod render_mesh;
pub(crate) mod resolve;
pub(crate) mod respond;
pub(crate) mod skeleton;
pub(crate) mod skin;
pub(crate) mod sleep;
pub(crate) mod sources;
pub(crate) mod strays;
pub(crate) mod subdivide;
pub(crate) mod sync;
pub(crate) mod touch;
pub(crate) mod warm_up;

use bevy::platform::time::Instant;

/// Starts to measure; the result tells how long ago that was `[ms]`.
fn stopwatch() -> impl Fn() -> f32 {
    let start = Instant::now();
    move || start.elapsed().as_secs_f32() * 1.0e3
}
