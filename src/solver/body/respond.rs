//! What a touched particle does: it is pushed out, and bounces only if its fabric does. Then [friction](super::friction) holds
//! it.
//!
//! ```text
//!        n        gap   g(q) = n · q - c          (c: the plane at one thickness from the surface)
//!        ^        push  Δn   = max(0, g* - g(q1)),        g* = 0                    if g(q0) >= 0
//!   -----|----- c                                         g* = min(0, g(q0) + v h)  if g(q0) <  0
//!   ~~~~~~~~~~~ surface
//! ```
//!
//! *No bounce.* Velocity is `(q1 - q0) / h`. A particle that was outside (`g0 >= 0`) ends on the plane with the approaching
//! velocity `-g0 / h`: a plastic impact. A particle that was inside already (`g0 < 0`: overlap at the start, a teleported body)
//! is brought out at the speed `v = RECOVERY_SPEED` at most. `q0` is moved out with it, so that the recovery itself leaves no
//! velocity (the split impulses of Catto 2006, in position form).
//!
//! *Bounce.* With a restitution `e` above 0, a particle may come in from outside with more than [`IMPACT_SPEED`], by `a` in the
//! substep. It then goes to `g0 + e a`, so its velocity is `e a / h` away from the surface. The impulse `(1 + e) a m / h` is in
//! the push that moves bodies and bears friction. It turns where it was when the substep began. Only what its speed brings in
//! counts: what springs press on a body does not bounce.

use glam::{Vec3, Vec3A};

/// Speed at which particles that start inside a body are brought out `[m/s]`. Range 0.1 to 10: lower, an overlap stays
/// visible; higher, springs of the cloth are stretched by it.
const RECOVERY_SPEED: f32 = 1.0;

/// Share of the newest push in the running mean of the load (dimensionless), range 0.05 to 1. At 1 friction flickers with the
/// springs.
const LOAD_SHARE: f32 = 0.25;

/// Speed of approach up to which nothing bounces `[m/s]`: what rests is pulled in by its springs and by gravity in every
/// substep.
pub(crate) const IMPACT_SPEED: f32 = 0.25;

/// The contact plane `n · q = c`; with a normal of zero nothing is below it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Plane {
    normal: Vec3,
    /// `c` `[m]`.
    pub(crate) offset: f32,
}

impl Plane {
    /// The plane across a unit normal, `offset` `[m]` from the origin along it.
    #[inline]
    pub(crate) fn new(normal: Vec3A, offset: f32) -> Self {
        Self { normal: normal.into(), offset }
    }

    /// The unit normal, out of what it bounds.
    #[inline]
    pub(crate) fn normal(&self) -> Vec3A {
        self.normal.into()
    }

    /// Signed height of a point over the plane `[m]`.
    #[inline]
    pub(crate) fn gap(&self, q: Vec3A) -> f32 {
        self.normal().dot(q) - self.offset
    }
}

/// Which projection of a substep it is. The second recovers nothing, as the relax stage of `Box2D` v3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Projection {
    /// Takes loads into their means, and recovers overlaps from before the substep.
    #[default]
    First,
    /// Adds to loads: of surfaces, for particles.
    Relax,
}

impl Projection {
    /// The mean `load` `[m]` after a `push` `[m]` in this projection.
    #[inline]
    pub(crate) fn load(self, load: f32, push: f32) -> f32 {
        match self {
            Self::First => mean_load(load, push),
            Self::Relax if load > 0.0 => load + LOAD_SHARE * push,
            // What met nothing before has no mean yet.
            Self::Relax => push,
        }
    }

    /// How far an overlap is brought out in a substep of `h` `[s]`, at most `[m]`.
    pub(crate) fn recovery(self, h: f32) -> f32 {
        match self {
            Self::First => RECOVERY_SPEED * h,
            Self::Relax => 0.0,
        }
    }
}

/// Running mean of a load `[m]`, after a substep in which it was `push` `[m]`.
#[inline]
pub(crate) fn mean_load(load: f32, push: f32) -> f32 {
    if load > 0.0 { load + LOAD_SHARE * (push - load) } else { push }
}

/// Where a particle and its previous position go that is pushed out, in body space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pushed {
    /// Where it ends the substep `[m]`, and the way that its previous position takes `[m]`.
    pub(crate) end: Vec3A,
    pub(crate) shift: Vec3A,
    /// Push of this substep without what recovery lifted it `[m]`.
    pub(crate) push: f32,
}

/// Pushes a particle out to the plane. All arguments are in `[m]`:
/// - `start`, `wanted`: its way in this substep.
/// - `end`: where a sweep stopped it; equal to `wanted` without one.
/// - `recovery`: how far at most an overlap is brought out.
/// - `rise`: how far over where it began what bounces ends; 0 where it does not bounce.
#[inline]
pub(crate) fn push_out(plane: Plane, start: Vec3A, wanted: Vec3A, end: Vec3A, recovery: f32, rise: f32) -> Pushed {
    let n = plane.normal();
    let gap_start = plane.gap(start);
    let target = if gap_start < 0.0 {
        (gap_start + recovery).min(0.0)
    } else if rise > 0.0 && plane.gap(wanted) < 0.0 {
        gap_start + rise
    } else {
        0.0
    };
    let gap_end = plane.gap(end);
    // A sweep has put the end on the plane; without one it may be under it.
    let swept = plane.gap(wanted) < gap_end;
    let out = if target > 0.0 {
        target
    } else if swept {
        gap_end.min(target)
    } else {
        gap_end.max(target)
    };
    let end = end + n * (out - gap_end);
    // Only what recovery lifted: a particle that its own cloth pulls out keeps its velocity.
    let pushed = n.dot(end - wanted).max(0.0);
    let lift = if gap_start < 0.0 { (out - gap_start).max(0.0).min(pushed) } else { 0.0 };
    Pushed { end, shift: n * lift, push: (pushed - lift).max(0.0) }
}
