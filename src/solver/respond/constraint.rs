//! What keeps a pair apart in a substep: solved in several passes, with the closest points and the normal that it had in the
//! first.
//!
//! ```text
//!   C   = n · δ - t               δ = Σ wᵢ xᵢ, t: thickness
//!   Δxᵢ = sᵢ n (C* - C)           sᵢ = wᵢ mᵢ⁻¹ / Σ wⱼ² mⱼ⁻¹
//!   C*  = 0, or below where the pair began the substep closer: recovered at a limited speed, without velocity
//! ```
//!
//! The sum is no less than `mᵢ⁻¹ / 16`, so that in a pass no particle goes farther than four times `C`. A push that is cut
//! short goes on in the next pass. Pushes of all passes add up. After them the pair begins with the friction of the last
//! substep (warm starting). When bodies have pushed, too, friction acts on the way of the whole substep, under the mean of all
//! pushes. Recovery and friction are those of bodies ([`push_out`], [`Friction::hold`]), for `δ` in place of a particle.
//!
//! Pairs share particles, and push each of them more often than is needed. Pairs that met fast are then given the speed apart
//! of their restitution; without restitution they are given none. This is the velocity pass of Müller et al. 2020, "Detailed
//! rigid body simulation with extended position based dynamics", section 3.6.

use glam::{Vec3, Vec3A, Vec4};

use super::loads::{Borne, Load};
use crate::solver::body::{Friction, IMPACT_SPEED, Plane, mean_load, push_out, slip};
use crate::solver::scales::TOUCHING;

/// The closest point of the first primitive less that of the second `[m]`.
#[inline]
pub(super) fn sum(weights: &[f32; 4], points: &[Vec4; 4]) -> Vec3 {
    (points[0] * weights[0] + points[1] * weights[1] + points[2] * weights[2] + points[3] * weights[3]).truncate()
}

/// What keeps a pair apart in a substep. See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Constraint {
    /// Which pair it is of.
    pub pair: u32,
    /// Its particles, and the weights of the closest points.
    pub particles: [u32; 4],
    pub weights: [f32; 4],
    /// How far each particle goes when the closest points part by one (dimensionless).
    pub shares: [f32; 4],
    /// How far a unit push moves the closest points apart `[1/kg]`.
    pub mobility: f32,
    /// From the frame of simulation of the first primitive to that of the second `[m]`.
    pub offset: Vec3,
    /// Across the unit vector towards the first primitive, one thickness from the second.
    pub plane: Plane,
    pub friction: Friction,
    /// Speed apart after an impact over that of approach before (dimensionless); none on the wrong side.
    pub restitution: Option<f32>,
    /// The height over the plane that the passes after the first keep `[m]`: 0, or where the substep began below it.
    pub floor: f32,
    /// Mean push of the substeps before `[m]`, and mean of what all pushes of one did, push over mobility `[kg·m]`: see
    /// [`Load`].
    pub load: f32,
    pub drive: f32,
    /// What it was pushed in this one `[m]`.
    pub push: f32,
    /// What friction pushes along the plane `[m]`: in the substep before, until it is [applied](Self::apply_friction).
    pub tangent_push: Vec3,
}

// They are passed over several times in a substep: two lines of a cache.
const _: () = assert!(size_of::<Constraint>() == 128);

impl Constraint {
    /// The first pass: pushes the pair apart. An overlap from before the substep is recovered by at most `recovery` `[m]`.
    #[inline]
    pub(super) fn bring_out(&mut self, recovery: f32, now: &mut [Vec4], old: &mut [Vec4]) {
        let (start, end) = (self.delta(old), self.delta(now));
        let out = push_out(self.plane, start, end, end, recovery, 0.0);
        let step = out.end - end;
        if !(step.is_finite() && out.shift.is_finite()) {
            return;
        }
        self.push += out.push;
        self.move_by(step, now);
        self.move_by(out.shift, old);
    }

    /// Notes where the pair was when the substep began: nothing moves that after the first pass.
    pub(super) fn note_start(&mut self, old: &[Vec4]) {
        self.floor = self.plane.gap(self.delta(old)).min(0.0);
    }

    /// As [`Self::bring_out`] without recovery, in the passes after it.
    #[inline]
    pub(super) fn push_apart(&mut self, now: &mut [Vec4]) {
        let (end, normal) = (self.delta(now), self.plane.normal());
        let gap = self.plane.gap(end);
        if gap >= self.floor {
            return;
        }
        let to = end + normal * (self.floor - gap);
        let step = to - end;
        if step.is_finite() {
            self.push += normal.dot(step).max(0.0);
            self.move_by(step, now);
        }
    }

    /// Applies the friction of the last substep, at most what static friction bears under all pushes (warm starting).
    #[inline]
    pub(super) fn warm_start(&mut self, now: &mut [Vec4]) {
        let along = slip(self.plane.normal(), self.tangent_push.into());
        let push = along.clamp_length_max(self.friction.fixed * self.mean_load());
        self.tangent_push = push.into();
        self.move_by(-push, now);
    }

    /// Applies friction for the way of the whole substep; none to a pair that has come apart since. If the remaining load of
    /// such a pair bore friction, folds of crumpled sheets on a floor would sometimes give by up to 20 mm. Without it they give
    /// by 0.6 **`[measured]`**.
    #[inline]
    pub(super) fn apply_friction(&mut self, now: &mut [Vec4], old: &[Vec4]) {
        let (end, before) = (self.delta(now), Vec3A::from(self.tangent_push));
        let mut push = Vec3A::ZERO;
        if self.plane.gap(end) < TOUCHING * self.plane.offset {
            let slipped = slip(self.plane.normal(), end - self.delta(old));
            push = self.friction.hold(before + slipped, self.mean_load());
        }
        if push.is_finite() {
            self.move_by(before - push, now);
            self.tangent_push = push.into();
        }
    }

    /// Mean push `[m]`, this substep included.
    #[inline]
    pub(super) fn mean_load(&self) -> f32 {
        mean_load(self.load, self.push)
    }

    /// What the pair bears, this substep included.
    #[inline]
    pub(super) fn borne(&self) -> Borne {
        let drive = mean_load(self.drive, self.push / self.mobility);
        Borne { pair: self.pair, load: Load { push: self.mean_load(), drive, tangent_push: self.tangent_push } }
    }

    /// How fast a pair is to part that met fast `[m/s]`: what its restitution makes of the velocities with which the substep
    /// began. None of one that did not, however hard springs press it together, or that was not pushed.
    #[inline]
    pub(super) fn impact(&self, velocity: impl Fn(usize) -> Vec3A) -> Option<f32> {
        let approach = -self.along(self.particles.map(|p| velocity(p as usize)));
        (self.push > 0.0 && approach > IMPACT_SPEED).then_some(self.restitution? * approach)
    }

    /// Gives a pair its way `apart` `[m]` in the substep, and moves nothing.
    pub(super) fn apply_restitution(&self, apart: f32, positions: &[Vec4], previous: &mut [Vec4]) {
        let way = self.along(self.particles.map(|p| Vec3A::from_vec4(positions[p as usize] - previous[p as usize])));
        let by = self.plane.normal() * (way - apart);
        if by.is_finite() {
            self.move_by(by, previous);
        }
    }

    /// From the closest point of the second primitive to that of the first `[m]`.
    #[inline]
    fn delta(&self, points: &[Vec4]) -> Vec3A {
        Vec3A::from(sum(&self.weights, &self.particles.map(|p| points[p as usize]))) + Vec3A::from(self.offset)
    }

    /// How far apart four vectors are along the normal, the closest points of either side.
    fn along(&self, of: [Vec3A; 4]) -> f32 {
        (0..4).map(|i| self.weights[i] * self.plane.normal().dot(of[i])).sum()
    }

    /// Parts the closest points by a way `[m]`.
    #[inline]
    fn move_by(&self, way: Vec3A, points: &mut [Vec4]) {
        let way = Vec3::from(way).extend(0.0);
        for (&p, share) in self.particles.iter().zip(self.shares) {
            points[p as usize] += way * share;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    /// Two particles of 1 kg that are kept 1 m apart. The upper one comes 0.1 m too close in a substep, and goes 0.04 m aside.
    fn over(friction: f32) -> (Constraint, Vec<Vec4>, Vec<Vec4>) {
        let constraint = Constraint {
            pair: 0,
            particles: [0, 1, 1, 1],
            weights: [1.0, -1.0, 0.0, 0.0],
            shares: [0.5, -0.5, 0.0, 0.0],
            mobility: 2.0,
            offset: Vec3::ZERO,
            plane: Plane::new(Vec3A::Y, 1.0),
            friction: Friction { fixed: friction, sliding: friction },
            restitution: Some(0.5),
            floor: 0.0,
            load: 0.0,
            drive: 0.0,
            push: 0.0,
            tangent_push: Vec3::ZERO,
        };
        let old = vec![vec3(0.0, 1.0, 0.0).extend(1.0), Vec4::W];
        (constraint, vec![vec3(0.04, 0.9, 0.0).extend(1.0), Vec4::W], old)
    }

    #[test]
    fn pushes_of_all_passes_bear_friction_and_keep_momentum() {
        // Pushed by 0.1 in the first pass; the third one finds 0.05 more.
        let slipped = |friction: f32| {
            let (mut constraint, mut now, mut old) = over(friction);
            constraint.bring_out(0.0, &mut now, &mut old);
            now[0].y -= 0.05;
            constraint.push_apart(&mut now);
            constraint.push_apart(&mut now);
            constraint.apply_friction(&mut now, &old);
            assert!((constraint.push - 0.15).abs() < 1.0e-6 && (now[0].y - now[1].y - 1.0).abs() < 1.0e-6);
            let sum = now[0] + now[1];
            assert!((sum.x - 0.04).abs() < 1.0e-6 && (sum.y - 0.85).abs() < 1.0e-6, "{sum}");
            now[0].x - now[1].x
        };
        assert!((slipped(0.2) - (0.04 - 0.2 * 0.15)).abs() < 1.0e-6, "it slides under 0.15, and not under 0.1");
        assert!(slipped(0.3).abs() < 1.0e-6, "it sticks");
    }

    #[test]
    fn friction_of_the_substep_before_is_part_of_what_the_load_bears() {
        let (mut constraint, mut now, mut old) = over(0.2);
        constraint.tangent_push = Vec3::X * 0.015;
        constraint.bring_out(0.0, &mut now, &mut old);
        constraint.warm_start(&mut now);
        assert!((now[0].x - now[1].x - 0.025).abs() < 1.0e-6, "it begins with it: {now:?}");
        constraint.apply_friction(&mut now, &old);
        assert!((now[0].x - now[1].x - 0.02).abs() < 1.0e-6, "no more than 0.2 of 0.1 in all: {now:?}");
        assert!((constraint.tangent_push.x - 0.02).abs() < 1.0e-6);
        // Drawn apart since: nothing holds it.
        now[0].y += 0.2;
        constraint.apply_friction(&mut now, &old);
        assert!((now[0].x - now[1].x - 0.04).abs() < 1.0e-6 && constraint.tangent_push == Vec3::ZERO, "{now:?}");
    }

    #[test]
    fn what_began_too_close_is_brought_out_without_speed() {
        let (mut constraint, mut now, mut old) = over(0.0);
        now[0].y = 0.9;
        old[0].y = 0.9;
        constraint.bring_out(0.02, &mut now, &mut old);
        constraint.note_start(&old);
        constraint.push_apart(&mut now);
        let gap = |x: &[Vec4]| x[0].y - x[1].y;
        assert!((gap(&now) - 0.92).abs() < 1.0e-6 && (gap(&old) - 0.92).abs() < 1.0e-6, "{now:?} {old:?}");
        assert_eq!(constraint.push, 0.0, "it bears nothing");
    }
}
