//! A frame of a cloth that no island steps, as one function; [`Island::run`](crate::solver::island::Island::run) steps those
//! that touch.
//!
//! ```text
//! begin ─► (constrain ─► project)* ─► finish
//!
//! begin      count substeps · damp · list what is near of bodies · judge how far it is stretched
//! constrain  wind · predict · pins · drive · bends · bounds on lengths · springs or triangles · what pins do to bodies
//! project    keep the cloth out of bodies, and within the limits of the skin
//! finish     air · slow what is stuck · shorten what is overlong · is it settling?
//! ```

mod prepare;
mod count;
mod begin;
mod constrain;
mod forces;
mod advance;
mod inner;
mod hold;
mod tighten;
mod project;
mod finish;
mod shorten;
mod heavy_body;
mod settling;
mod strain;
mod displace;
mod factors;
mod memory;
mod frame;

use glam::Vec3;

pub(crate) use count::substeps_of;
pub(crate) use displace::displace;
pub use hold::relax;
pub use memory::Memory;
pub use prepare::prepare;

use super::anchors::Anchors;
use super::body::Body;
use super::rest::RestShape;
use super::settings::{Fabric, Stepping};
use super::skinned::Skinned;
use super::state::ClothState;
use super::wind::Wind;

/// Advances one cloth by one frame. [`prepare`] must have been called.
pub fn step(
    rest: &RestShape,
    fabric: &Fabric,
    stepping: &Stepping,
    anchors: &Anchors,
    input: &FrameInput<'_>,
    state: &mut ClothState,
    memory: &mut Memory,
) -> StepReport {
    let cloth = Stepped { rest, fabric, anchors, input: *input };
    let state = &mut state.as_mut();
    cloth.begin(stepping, None, state, memory);
    while cloth.constrain(state, memory) {
        cloth.project(state, memory);
    }
    cloth.finish(false, state, memory).unwrap_or_default()
}

/// What a cloth is stepped with. [`step`] does all of a frame. Cloths that touch each other go through it side by side. They
/// are kept apart before bodies push them, and rub after that.
#[derive(Clone, Copy, Debug)]
pub struct Stepped<'a> {
    /// Rest shape.
    pub rest: &'a RestShape,
    /// Material.
    pub fabric: &'a Fabric,
    /// Pins.
    pub anchors: &'a Anchors,
    /// Inputs of the frame.
    pub input: FrameInput<'a>,
}

/// Inputs of one frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameInput<'a> {
    /// Length of the frame `[s]`; 0, less or not a number: nothing moves. Of an infinite one the longest frame is simulated.
    pub dt: f32,
    /// Gravity `[m/s²]`.
    pub gravity: Vec3,
    /// Bodies, in the frame of simulation.
    pub bodies: &'a [Body],
    /// Wind at the cloth, in the frame of simulation.
    pub wind: &'a Wind,
    /// What the skin asks of it, if it has one that does.
    pub skinned: Option<&'a Skinned>,
}

/// What one frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct StepReport {
    /// Substeps taken.
    pub substeps: u32,
    /// Time beyond [`Stepping::max_frame`] that was not simulated `[s]`.
    pub lost_time: f32,
    /// Largest edge length over rest length after the frame (dimensionless); infinite when a position is not finite.
    pub worst_edge: f32,
    /// Mean edge length over rest length after the frame (dimensionless).
    pub mean_edge: f32,
    /// Particles and faces that touched a body in the last substep.
    pub body_contacts: u32,
    /// Inner steps in each substep.
    pub inner_steps: u32,
    /// Share of the bending stiffness that the substeps held (dimensionless): 1, unless the mesh is very fine for them.
    pub bend_held: f32,
}
