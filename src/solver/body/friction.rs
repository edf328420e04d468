//! Friction: what slips along a body is held, when all that pushes has pushed.
//!
//! ```text
//!   push      cloth off cloth; particles, edges and faces out of bodies          λ: what each contact was pushed
//!   friction  t (1 - min(μ λ / |t|, 1)),  t: what is left of its way along its plane
//! ```
//!
//! *Coulomb's law* (Macklin et al. 2014, "Unified particle physics", eq. 24) on the tangential part `t` of `q1 - q0`, with the
//! normal load `λ`: `t = 0` if `|t| <= μs λ`, else `t (1 - min(μd λ / |t|, 1))`. The springs of a resting particle lift it off
//! and press it down from substep to substep. So `λ` is the running mean of the push, not the push of this substep, and still
//! acts within a thin band over the plane. The mean of the load is the mean of the pushes, hence the mean friction is
//! Coulomb's.
//!
//! *Last*, as in the velocity pass of Müller et al. 2020, "Detailed rigid body simulation with extended position based
//! dynamics": all pushes are known then. Cloth above draws a particle just below the edge of a table into its side. The edge of
//! the table then pushes the edge of the cloth out, and the particle leaves the side. With friction before that push it would
//! stick there, however hard it is drawn. Edges of a cloth of 30² that is pulled off a table get 20 to 40 times as long
//! **`[measured]`**.

use glam::Vec3A;

/// Friction coefficients of one body and one fabric (dimensionless).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Friction {
    pub(crate) fixed: f32,
    pub(crate) sliding: f32,
}

impl Friction {
    /// Geometric mean of both partners; what is not a number counts as 0.
    pub(crate) fn between(body: (f32, f32), fabric: (f32, f32)) -> Self {
        let in_range = |x: f32| if x.is_finite() { x.clamp(0.0, 10.0) } else { 0.0 };
        let mean = |a, b| (in_range(a) * in_range(b)).sqrt();
        let sliding = mean(body.1, fabric.1);
        Self { fixed: mean(body.0, fabric.0).max(sliding), sliding }
    }

    /// How much of the way `slip` `[m]` along a surface is taken back under a load `[m]`.
    #[inline]
    pub(crate) fn hold(self, slip: Vec3A, load: f32) -> Vec3A {
        let length2 = slip.length_squared();
        let most = self.fixed * load;
        if length2 <= most * most { slip } else { slip * (self.sliding * load / length2.sqrt()).min(1.0) }
    }

    /// Both coefficients times `factor`.
    pub(super) fn times(self, factor: f32) -> Self {
        Self { fixed: self.fixed * factor, sliding: self.sliding * factor }
    }
}

/// The part of a way that is along a surface.
#[inline]
pub(crate) fn slip(normal: Vec3A, way: Vec3A) -> Vec3A {
    way - normal * normal.dot(way)
}
