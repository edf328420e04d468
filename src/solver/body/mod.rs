//! Bodies that push the cloth: shapes with the pose they had and the pose they have.
//!
//! ```text
//!  frame:    gather                 every body and every particle that could meet this frame (swept boxes)
//!            faces                  for bodies finer than the mesh: its faces that could meet them too
//!  substep:  project   sample  ->   signed distance and normal of the shape, in the body's own space
//!                      sweep   ->   only when the particle could have crossed: first touch along its path
//!                      respond ->   push out, recovery without velocity
//!            faces     nearest ->   the same for the nearest point of a face, shared out to its particles
//!            friction               of particles, then of faces, when all is pushed out
//! ```
//!
//! All geometry happens in the space of the body. A particle goes from `q0 = X(s0)⁻¹ x_previous` to `q1 = X(s1)⁻¹ x`, where
//! `X(s)` is the body's pose at the fraction `s` of the frame. In that space the body stands still. So one path covers a cloth
//! that falls on a body, a body that is driven through a cloth, and everything between. `q1 - q0` is the motion relative to the
//! surface that friction needs, rotation included.

mod advance;
mod contacts;
mod feature_edges;
mod depth;
mod distance;
mod faces;
mod friction;
mod geometry;
mod ground;
mod provisional;
mod motion;
mod nearest;
mod pierce;
mod pinch;
mod respond;
mod squeeze;
pub mod shape;
mod snug;
mod sweep;
mod take_out;
#[cfg(test)]
mod tests;
mod touch;

use std::sync::Arc;

use glam::Vec3;

pub(crate) use contacts::{Approach, BodyContacts};
pub use depth::depths;
pub(crate) use faces::{FaceContacts, Sheet};
pub(crate) use friction::{Friction, slip};
pub(crate) use ground::{Bearing, BodyContext};
pub use parry3d::math::Pose;
pub use parry3d::shape::SharedShape;
pub(crate) use pierce::Pierced;
pub(crate) use pinch::Pinches;
pub(crate) use provisional::Provisional;
pub(crate) use respond::{IMPACT_SPEED, Plane, Projection, mean_load, push_out};
pub use shape::ShapeError;
pub(crate) use snug::Snug;
pub(super) use take_out::take_out;
pub use touch::Touch;

/// A rigid body as one cloth sees it in one frame.
///
/// Its maker has dropped sensors, disabled bodies and bodies that the cloth's layers do not meet. It has baked the scale into
/// the shape ([`shape::scaled`]).
#[derive(Clone, Debug)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Body {
    /// The shape, in the body's own space `[m]`.
    pub shape: SharedShape,
    /// Pose at the start of the frame, in the cloth's frame of simulation `[m]`. A body whose poses are not finite is skipped.
    pub from: Pose,
    /// Pose at the end of the frame `[m]`. Equal to `from` for a body at rest.
    pub to: Pose,
    /// Static friction coefficient (dimensionless). Default 0.5, range 0 to 10. Combined with the fabric's by the geometric
    /// mean.
    pub static_friction: f32,
    /// Dynamic friction coefficient (dimensionless). Default 0.4, range 0 to 10.
    pub dynamic_friction: f32,
    /// Distance kept to the shape on top of the fabric's thickness `[m]`. Default 0, range 0 to 1.
    pub margin: f32,
    /// The body of the cloth's [`Coupling`](super::couple::Coupling) that is given what the cloth does to this shape. Default
    /// none: cloth does nothing to it.
    pub rigid: Option<u32>,
    /// Whether it is a bone of the character that wears the cloth: it moves along with it, and has a volume.
    pub bone: bool,
    /// The particles of the cloth that were made closer to it than thickness and margin ask for. They are kept as far away as
    /// they were then.
    pub snug: Option<Arc<Snug>>,
}

/// Gives what is known `of` bodies their new numbers, and forgets bodies without one. The order stays.
fn renumber<T>(known: &mut Vec<T>, of: impl Fn(&mut T) -> &mut u32, number: impl Fn(u32) -> Option<u32>) {
    known.retain_mut(|known| {
        let body = of(known);
        number(*body).is_some_and(|now| {
            *body = now;
            true
        })
    });
}

impl Body {
    /// A body with default friction and no margin that moves from one pose to another in the frame.
    #[must_use]
    pub fn new(shape: SharedShape, from: Pose, to: Pose) -> Self {
        Self { shape, from, to, static_friction: 0.5, dynamic_friction: 0.4, margin: 0.0, rigid: None, bone: false, snug: None }
    }

    /// By how much nearer than `keep` `[m]` a particle may be, as it was made.
    #[inline]
    pub(crate) fn inset(&self, particle: u32, keep: f32) -> f32 {
        self.snug.as_ref().map_or(0.0, |snug| snug.inset(particle, keep))
    }

    /// Whether the box around its way in the frame meets that between `low` and `high` `[m]`. False where a pose is not finite.
    pub(crate) fn sweeps(&self, low: Vec3, high: Vec3) -> bool {
        let (Some(from), Some(to)) = (motion::valid(self.from), motion::valid(self.to)) else { return false };
        let (swept, bulge, _) = motion::swept_box(&*self.shape.0, &from, &to);
        (swept.mins - bulge).cmple(high).all() && (swept.maxs + bulge).cmpge(low).all()
    }

    /// Way of a bone in the frame relative to cloth that goes `along` `[m]`. By its fastest corner: a forearm that turns about
    /// its elbow is fast at the hand.
    pub(crate) fn way_of_bone(&self, along: Vec3) -> f32 {
        let (Some(from), Some(to)) = (motion::valid(self.from), motion::valid(self.to)) else { return 0.0 };
        let corners = self.shape.compute_local_aabb().vertices();
        let way = |corner: &Vec3| (to * *corner - from * *corner - along).length();
        corners.iter().map(way).fold(0.0, f32::max)
    }

    /// A body at rest.
    #[must_use]
    pub fn at_rest(shape: SharedShape, pose: Pose) -> Self {
        Self::new(shape, pose, pose)
    }
}
