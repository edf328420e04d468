//! Detect: where surfaces cross, and where they come close.
//!
//! Cloths are concatenated into one [`Surface`], so that a cloth meeting another and a cloth meeting itself are the same
//! question.
//!
//! ```text
//! positions ─► Tree::refit ─► pairs of faces whose boxes meet ─► orientation signs ─► crossings, sorted
//! ```

mod quiet;
#[cfg(feature = "research")]
mod close;
pub(super) mod beside;
pub(super) mod four;
pub(crate) mod crossing;
pub(crate) mod orient;
mod parts;
pub(crate) mod proximity;
pub(super) mod seams;
pub(crate) mod surface;
pub(crate) mod tree;

pub use crossing::{Crossing, Detector};
pub use proximity::{Proximity, ProximityKind};
pub use surface::{Part, PartRef, PartSettings, Surface, SurfaceError};
