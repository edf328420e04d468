//! Backstop and maximum distance.

use glam::{Vec3, Vec4};

use super::avoid::FASTEST;
use super::{Skinned, TangledLimits};

impl Skinned {
    /// Brings particles back within their limits at the end of a substep, from the share `s0` of the frame to `s1`. What takes
    /// one farther than its own way and that of its target gives it no speed: a limit that shrinks, a blend, a jump.
    pub fn limit(&self, tangled_limits: &TangledLimits, [s0, s1]: [f32; 2], positions: &mut [Vec4], previous: &mut [Vec4]) {
        if !self.limits(positions.len()) {
            return;
        }
        for (i, (x, old)) in positions.iter_mut().zip(previous).enumerate().filter(|(_, (x, _))| x.w > 0.0) {
            let target = self.target(i, s1);
            let at = x.truncate();
            let to = self.within(i, tangled_limits.distance(self, i), s1, target, at);
            if to == at {
                continue;
            }
            let (back, by) = (to - at, to.distance(at));
            let own = (target - self.target(i, s0)).length() + at.distance(old.truncate());
            *x = to.extend(x.w);
            if by > own {
                *old += (back * (1.0 - own / by)).extend(0.0);
            }
        }
    }

    /// Draws `particles` to their targets in a substep of `h` `[s]`, as a tangle is drawn, and without any speed. The substep
    /// goes from the share `s0` of the frame to `s1`. Call it before forces act, so that the constraints of the cloth take the
    /// others along.
    pub fn draw(&self, particles: &[u32], (s0, s1): (f32, f32), h: f32, positions: &mut [Vec4], previous: &mut [Vec4]) {
        if !self.fits(positions.len()) {
            return;
        }
        for i in particles.iter().map(|p| *p as usize) {
            let (x, target) = (&mut positions[i], self.target(i, s1));
            if x.w > 0.0 {
                let most = FASTEST * h + target.distance(self.target(i, s0));
                let by = (target - x.truncate()).clamp_length_max(most).extend(0.0);
                *x += by;
                previous[i] += by;
            }
        }
    }

    /// Brings particles back within their limits at the end of the frame, without any speed.
    pub(crate) fn limit_silently(&self, tangled_limits: &TangledLimits, positions: &mut [Vec4], previous: &mut [Vec4]) {
        if !self.limits(positions.len()) {
            return;
        }
        for (i, (x, old)) in positions.iter_mut().zip(previous).enumerate().filter(|(_, (x, _))| x.w > 0.0) {
            let at = x.truncate();
            let by = (self.within(i, tangled_limits.distance(self, i), 1.0, self.to[i], at) - at).extend(0.0);
            *x += by;
            *old += by;
        }
    }

    /// Whether any of `count` particles has a limit.
    pub(in crate::solver) fn limits(&self, count: usize) -> bool {
        let any = !self.max_distance.is_empty() || !self.backstop_distance.is_empty() || self.scale < 1.0;
        any && self.fits(count)
    }

    /// The nearest place to `at` `[m]` that the limits of particle `i` allow, `most` `[m]` from its target.
    #[inline]
    fn within(&self, i: usize, most: f32, s: f32, target: Vec3, at: Vec3) -> Vec3 {
        let mut to = at;
        if let Some(&behind) = self.backstop_distance.get(i)
            && behind < most
        {
            let (from, now) = (self.normals_from.get(i), self.normals_to.get(i));
            let normal = from.zip(now).map_or(Vec3::ZERO, |(from, now)| from.lerp(*now, s).normalize_or_zero());
            let radius = self.backstop_radius;
            let center = target - normal * (behind + radius);
            let off = to - center;
            if normal != Vec3::ZERO && off.length_squared() < radius * radius {
                to = center + off.try_normalize().unwrap_or(normal) * radius;
            }
        }
        let off = to - target;
        if off.length_squared() > most * most { target + off.normalize_or_zero() * most } else { to }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skinned(distance: f32, backstop: f32) -> Skinned {
        Skinned {
            from: vec![Vec3::ZERO],
            to: vec![Vec3::ZERO],
            normals_from: vec![Vec3::Z],
            normals_to: vec![Vec3::Z],
            max_distance: vec![distance],
            backstop_distance: vec![backstop],
            backstop_radius: 1.0,
            scale: 1.0,
            radius: 1.0,
            damping_ratio: 1.0,
            ..Skinned::default()
        }
    }

    fn limited(skinned: &Skinned, at: Vec3, old: Vec3) -> (Vec3, Vec3) {
        let (mut x, mut previous) = ([at.extend(1.0)], [old.extend(1.0)]);
        skinned.limit(&TangledLimits::default(), [0.0, 1.0], &mut x, &mut previous);
        (x[0].truncate(), x[0].truncate() - previous[0].truncate())
    }

    #[test]
    fn nothing_goes_farther_than_it_may_and_not_deeper_than_the_backstop() {
        let (x, _) = limited(&skinned(0.1, f32::INFINITY), Vec3::X, Vec3::ZERO);
        assert!((x - Vec3::X * 0.1).length() < 1.0e-6, "{x}");
        let (x, _) = limited(&skinned(0.5, 0.05), Vec3::NEG_Z * 0.2, Vec3::ZERO);
        assert!((x - Vec3::NEG_Z * 0.05).length() < 1.0e-6, "{x}");
        // A backstop that is no nearer than the maximum distance is off.
        let (x, _) = limited(&skinned(0.1, 0.1), Vec3::NEG_Z * 0.09, Vec3::ZERO);
        assert_eq!(x, Vec3::NEG_Z * 0.09);
        // The maximum distance has the last word.
        let (x, _) = limited(&skinned(0.02, -0.5), Vec3::ZERO, Vec3::ZERO);
        assert!(x.length() < 0.02 + 1.0e-6, "{x}");
    }

    #[test]
    fn a_limit_takes_speed_and_gives_none() {
        // It flew out at 0.3 m in a substep, from the border: what is left goes along the border.
        let (_, way) = limited(&skinned(0.1, f32::INFINITY), Vec3::X * 0.4, Vec3::X * 0.1);
        assert!(way.length() < 1.0e-6, "{way}");
        // It stood still when the limit shrank.
        let (x, way) = limited(&skinned(0.1, f32::INFINITY), Vec3::X * 0.5, Vec3::X * 0.5);
        assert!((x.x - 0.1).abs() < 1.0e-6 && way.length() < 1.0e-6, "{x} {way}");
    }

    #[test]
    fn what_a_bone_goes_through_is_drawn_to_its_skin_without_speed() {
        let h = 0.01;
        let mut skinned = skinned(1.0, f32::INFINITY);
        skinned.to = vec![Vec3::Y * 0.05];
        let draw = |at: Vec4| {
            let (mut x, mut previous) = ([at], [at - Vec4::Z * 0.01]);
            skinned.draw(&[0], (0.0, 1.0), h, &mut x, &mut previous);
            assert!((x[0] - previous[0]).distance(Vec4::Z * 0.01) < 1.0e-6, "it has the speed that it had");
            x[0]
        };
        // It keeps up with its target, and comes nearer.
        let off = Vec4::from((skinned.to[0], 1.0)) + Vec4::X * 0.3;
        assert!((draw(off).distance(off) - (0.05 + FASTEST * h)).abs() < 1.0e-6);
        assert_eq!(draw(Vec4::new(0.01, 0.05, 0.0, 1.0)).truncate(), skinned.to[0]);
        assert_eq!(draw(Vec4::X * 0.3), Vec4::X * 0.3, "a pin stays");
    }

    #[test]
    fn a_scale_of_nothing_is_a_hard_skin_without_limits_too() {
        let free = Skinned { max_distance: Vec::new(), backstop_distance: Vec::new(), scale: 0.0, ..skinned(0.0, 0.0) };
        let (x, way) = limited(&free, Vec3::ONE, Vec3::ONE);
        assert_eq!((x, way), (Vec3::ZERO, Vec3::ZERO));
    }
}
