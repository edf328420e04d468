//! A tangle that came up within one frame is rolled back: its particles go where they were when nothing crossed.
//!
//! ```text
//!   x ─► x0 + u     x0: where it was when the last frame ended clean; velocity is kept
//!                   u: motion since of the particle of the contour that moved least
//!   x ─► x0         where that is not enough; goes on with u
//!   x ─► R x0 + c   where pins went on: along with those that it crosses ([`pins`])
//!   all of a cloth ─► R x0 + c, else x0   where none of these is enough; R, c: the rigid motion of all its pins since
//! ```
//!
//! What was clean together and moves together is clean, so each look adds the particles that still cross until none do.
//! Contacts and their CCD know the pairs in the next frame. Tangles that were there before, that are held, that came from far,
//! or of cloths that started in the same place are left to [`resolve`](super::resolve).

mod pins;

use core::ops::Range;

use glam::{Vec3, Vec3A, Vec4};

use super::buffer::Buffer;
use super::detect::{Crossing, Surface};
use super::resolve::ContourGraph;
use super::rigid::Rigid;
use pins::Pins;

/// How much farther a particle may have gone in the frame than the fastest particle of its cloth flew, in mean edges. A
/// particle that was moved farther, by a teleport, is not rolled back.
const FARTHEST_EDGES: f32 = 4.0;

/// How far single particles are put back, in mean edges. Farther, they would tear at their neighbours: the cloth is put back as
/// a whole.
const ALONE_EDGES: f32 = 1.0;

/// Frames in a row in which whole cloths are put back.
const MOST_STAYS: u32 = 8;

/// What crosses: the crossings, and the contours that they are of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tangle<'a> {
    pub surface: &'a Surface,
    pub crossings: &'a [Crossing],
    pub graph: &'a ContourGraph,
}

impl Tangle<'_> {
    /// The particles of each crossing, with the contour that it is of; of those that nothing holds as they are.
    fn particles(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        let topology = &self.surface.topology;
        let of = self.crossings.iter().zip(&self.graph.contour_of).map(|(c, &contour)| (c, contour as usize));
        let free = of.filter(|&(_, contour)| !self.graph.contours[contour].authored);
        free.flat_map(|(crossing, contour)| {
            let (e, f) = (topology.edges[crossing.edge as usize], topology.faces[crossing.face as usize]);
            e.into_iter().chain(f).map(move |v| (contour, v))
        })
    }
}

/// Where everything was when nothing crossed.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Rollback {
    /// Positions `[m]` at the end of the last frame, or where they were carried since. Empty when it did not end clean, or when
    /// no cloth rested on cloths then.
    clean: Vec<Vec4>,
    /// Which particles were rolled back in this frame, and in the one before.
    restored: Vec<bool>,
    was_restored: Vec<bool>,
    /// Motion since then that particles which were rolled back have kept `[m]`.
    kept: Buffer<Vec<Vec3A>>,
    /// Motion since then of the particle of each contour that moved least `[m]`: what rests is not put where what fell on it
    /// went.
    least: Buffer<Vec<Vec3A>>,
    /// Substeps of the frame.
    substeps: f32,
    /// Way of the fastest particle of each cloth in the last substep of the last clean frame `[m]`.
    fastest: Vec<f32>,
    /// How far particles of each cloth may be put back in this frame `[m]`.
    farthest: Vec<f32>,
    /// Whether this frame is to be rolled back, and whether whole cloths were put back.
    rolls_back: bool,
    stayed: bool,
    /// Frames in a row in which they did.
    stays: u32,
    /// Which cloths cross.
    crossed: Vec<bool>,
    pins: Pins,
}

impl Rollback {
    /// Whether a particle was rolled back in the frame that ended last.
    pub(crate) fn was_restored(&self, particle: u32) -> bool {
        self.was_restored.get(particle as usize).is_some_and(|&was_restored| was_restored)
    }

    /// Whether any particle was rolled back in the frame that ended last.
    pub(crate) fn restored_any(&self) -> bool {
        self.was_restored.contains(&true)
    }

    /// Whether whole cloths were put back in the frame that ended last.
    pub(crate) fn stayed(&self) -> bool {
        self.stays > 0
    }

    /// Whether it is known where everything was when nothing crossed.
    pub(crate) fn knows(&self) -> bool {
        !self.clean.is_empty()
    }

    /// Whether nothing crossed where all are at these `positions` `[m]`, or within `limit` `[m]` of them.
    #[cfg(test)]
    pub(crate) fn knows_as_clean(&self, positions: &[Vec3], limit: f32) -> bool {
        self.knows() && self.clean.iter().zip(positions).all(|(clean, x)| clean.truncate().distance(*x) < limit)
    }

    /// Notes how a frame ended, whose last substep lies between `previous` and `positions` `[m]`; nothing is known of one that
    /// was not clean.
    pub(crate) fn note(&mut self, surface: &Surface, positions: &[Vec4], previous: &[Vec4], is_clean: bool) {
        self.clean.clear();
        self.restored.resize(positions.len(), false);
        self.was_restored.clone_from(&self.restored);
        self.restored.fill(false);
        if is_clean {
            self.clean.extend_from_slice(positions);
            self.fastest.clear();
            self.fastest.extend(surface.parts.iter().map(|part| fastest(part.range(), positions, previous)));
        }
        debug_assert_eq!([positions.len(), previous.len()], [surface.len(); 2]);
        self.stays = if self.stayed { self.stays + 1 } else { 0 };
        (self.rolls_back, self.stayed) = (false, false);
    }

    /// Forgets where everything was.
    pub(crate) fn forget(&mut self) {
        self.clean.clear();
    }

    /// All cloths were carried as one.
    pub(crate) fn follow(&mut self, motion: &Rigid) {
        self.clean.iter_mut().for_each(|x| *x = motion.point(x.truncate()).extend(x.w));
    }

    /// Begins with nothing rolled back; whether anything can be: of the cloths that take part, by number. The frame took as
    /// many `substeps`, the last of which lies between `previous` and `positions` `[m]`.
    pub(crate) fn begin(
        &mut self,
        surface: &Surface,
        positions: &[Vec4],
        previous: &[Vec4],
        takes_part: &[bool],
        substeps: u32,
    ) -> bool {
        if self.clean.len() != positions.len() {
            return false;
        }
        debug_assert_eq!([previous.len(), self.restored.len()], [positions.len(); 2]);
        debug_assert_eq!(self.fastest.len(), surface.parts.len());
        self.substeps = substeps as f32;
        self.rolls_back = true;
        self.pins.forget();
        self.farthest.clear();
        self.kept.clear();
        self.kept.resize(positions.len(), Vec3A::ZERO);
        for ((i, part), &before) in surface.parts.iter().enumerate().zip(&self.fastest) {
            // What was stopped on its way flew before.
            let flown = fastest(part.range(), positions, previous).max(before) * self.substeps;
            let farthest = FARTHEST_EDGES * surface.mean_edge + if flown.is_finite() { flown } else { 0.0 };
            // What no contact keeps apart would have to be rolled back for ever.
            self.farthest.push(if takes_part.get(i) == Some(&true) { farthest } else { 0.0 });
        }
        true
    }

    /// Takes the particles of each contour back, except for the motion of the one that moved least. Whether there were any that
    /// had kept more.
    pub(crate) fn restore_relative(&mut self, tangle: &Tangle<'_>, positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        let mut any = false;
        let alone = ALONE_EDGES * tangle.surface.mean_edge;
        self.for_each_that_crosses(tangle, positions, |this, v, least, x| {
            let by = (this.clean[v] - *x).truncate() + Vec3::from(least);
            let moves = !this.restored[v] || least.length_squared() < this.kept[v].length_squared();
            if moves && by.length() <= alone {
                this.restored[v] = true;
                this.kept[v] = least;
                *x += by.extend(0.0);
                previous[v] += by.extend(0.0);
                any = true;
            }
        });
        any
    }

    /// Whether this frame is to be rolled back.
    pub(crate) fn rolls_back(&self) -> bool {
        self.rolls_back
    }

    /// Puts the particles that cross to the very place where they were. A body pushed the particles that were taken along, or
    /// rounding made them cross what they touched. They go on with the motion of the one that moved least. Returns whether any
    /// was elsewhere.
    pub(crate) fn restore_exactly(&mut self, tangle: &Tangle<'_>, positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        let (alone, substeps) = (ALONE_EDGES * tangle.surface.mean_edge, self.substeps.max(1.0));
        self.put(tangle, positions, previous, |this, v, x, least| {
            let clean = this.clean[v].truncate();
            (x.distance(clean) <= alone).then(|| [clean, clean - Vec3::from(least / substeps)])
        })
    }

    /// Puts the particles that cross pins, or particles that were put there, where they were, carried on as these pins went
    /// since. Pins cannot be taken back. Whether any was elsewhere.
    pub(crate) fn follow_pins(&mut self, tangle: &Tangle<'_>, positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        let mut pins = core::mem::take(&mut self.pins);
        pins.meet(tangle.surface, tangle.crossings, positions, &self.clean);
        let substeps = self.substeps.max(1.0);
        let any = self.put(tangle, positions, previous, |this, v, _, _| {
            let clean = this.clean[v].truncate();
            pins.destination(v, clean).map(|to| [to, to.lerp(clean, 1.0 / substeps)])
        });
        self.pins = pins;
        any
    }

    /// Puts the particles that cross where `place` says: positions now and a substep before `[m]`. Whether any was elsewhere.
    fn put(
        &mut self,
        tangle: &Tangle<'_>,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        place: impl Fn(&Self, usize, Vec3, Vec3A) -> Option<[Vec3; 2]>,
    ) -> bool {
        let mut any = false;
        self.for_each_that_crosses(tangle, positions, |this, v, least, x| {
            let at = x.truncate();
            let Some([now, before]) = place(this, v, at, least).filter(|[now, _]| at != *now) else { return };
            this.restored[v] = true;
            *x = now.extend(x.w);
            previous[v] = before.extend(previous[v].w);
            any = true;
        });
        any
    }

    /// Calls `act` with every free particle that crosses and did not come from too far, once for each crossing. `act` gets the
    /// motion of the particle of its contour that moved least, and its position `[m]`.
    fn for_each_that_crosses(
        &mut self,
        tangle: &Tangle<'_>,
        positions: &mut [Vec4],
        mut act: impl FnMut(&mut Self, usize, Vec3A, &mut Vec4),
    ) {
        debug_assert!(self.knows_all_of(tangle, positions));
        let mut least = core::mem::take(&mut *self.least);
        least.clear();
        least.resize(tangle.graph.contours.len(), Vec3A::INFINITY);
        for (contour, v) in tangle.particles() {
            let v = v as usize;
            let motion = if self.restored[v] { self.kept[v] } else { Vec3A::from_vec4(positions[v] - self.clean[v]) };
            if motion.length_squared() < least[contour].length_squared() {
                least[contour] = motion;
            }
        }
        for (contour, v) in tangle.particles() {
            let farthest = self.farthest[usize::from(tangle.surface.part(v))];
            let v = v as usize;
            let way = Vec3A::from_vec4(positions[v] - self.clean[v]) - least[contour];
            if positions[v].w > 0.0 && way.length_squared() < farthest * farthest {
                act(self, v, least[contour], &mut positions[v]);
            }
        }
        *self.least = least;
    }

    /// Puts the cloths that cross back as a whole, each along with its pins since. Where these moved as one, its edges stay as
    /// long as they were. Whether any was elsewhere. No more than a few frames in a row. Velocity is kept, except that particles
    /// that were rolled back go on with what they had kept, or with the pins: they would do the same again. A cloth that came
    /// from far, or would go far, stays where it is: of pins nearly in a row, a bend looks like a turn.
    pub(crate) fn follow_pins_whole(&mut self, tangle: &Tangle<'_>, positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        self.put_whole(tangle, positions, previous, |this, part, positions| {
            let all = || this.clean[part.clone()].iter().zip(&positions[part.clone()]);
            let pins = || all().filter(|(_, now)| now.w == 0.0).map(|(before, now)| (before.truncate(), now.truncate()));
            // Nothing fits no pins, and pins at rest change no bit.
            if pins().any(|(before, now)| now != before) { Rigid::fit(pins) } else { Rigid::shift(Vec3::ZERO) }
        })
    }

    /// The same, to the very place where each was: no other is known to be clean.
    pub(crate) fn restore_whole(&mut self, tangle: &Tangle<'_>, positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        self.put_whole(tangle, positions, previous, |_, _, _| Rigid::shift(Vec3::ZERO))
    }

    /// Puts the cloths that cross where they were, moved as `motion` says of the particles of each.
    fn put_whole(
        &mut self,
        tangle: &Tangle<'_>,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        motion: impl Fn(&Self, Range<usize>, &[Vec4]) -> Rigid,
    ) -> bool {
        if self.stays >= MOST_STAYS {
            return false;
        }
        debug_assert!(self.knows_all_of(tangle, positions));
        let mut any = false;
        let substeps = self.substeps.max(1.0);
        self.note_crossed(tangle);
        for (i, part) in tangle.surface.parts.iter().enumerate().filter(|(part, _)| self.crossed[*part]) {
            let motion = motion(self, part.range(), positions);
            let is_far = |(now, then): (&Vec4, &Vec4)| {
                let (then, most) = (then.truncate(), self.farthest[i] * self.farthest[i]);
                let is_far = |at: Vec3| at.distance_squared(then) > most;
                now.w > 0.0 && (is_far(now.truncate()) || is_far(motion.point(then)))
            };
            if positions[part.range()].iter().zip(&self.clean[part.range()]).any(is_far) {
                continue;
            }
            for v in part.range() {
                let clean = self.clean[v].truncate();
                let to = motion.point(clean);
                let by = (to - positions[v].truncate()).extend(0.0);
                if positions[v].w > 0.0 && by.is_finite() {
                    any |= by != Vec4::ZERO;
                    positions[v] += by;
                    previous[v] += by;
                    if self.restored[v] {
                        let way = if to == clean { self.kept[v].into() } else { to - clean };
                        previous[v] = positions[v].truncate().extend(previous[v].w) - (way / substeps).extend(0.0);
                    }
                }
            }
        }
        self.stayed |= any;
        any
    }

    /// Whether each crossing has a contour, and each particle of one a place where it was.
    fn knows_all_of(&self, tangle: &Tangle<'_>, positions: &[Vec4]) -> bool {
        let Tangle { surface, crossings, graph } = tangle;
        let known = [self.clean.len(), self.restored.len(), self.kept.len()];
        known == [positions.len(); 3]
            && (self.farthest.len(), graph.contour_of.len()) == (surface.parts.len(), crossings.len())
            && tangle.particles().all(|(contour, v)| contour < graph.contours.len() && (v as usize) < positions.len())
    }

    /// Notes which cloths are part of a crossing.
    fn note_crossed(&mut self, tangle: &Tangle<'_>) {
        self.crossed.clear();
        self.crossed.resize(tangle.surface.parts.len(), false);
        tangle.particles().for_each(|(_, v)| self.crossed[usize::from(tangle.surface.part(v))] = true);
    }
}

/// Longest way of a free particle `[m]`.
fn fastest(range: Range<usize>, positions: &[Vec4], previous: &[Vec4]) -> f32 {
    let ways = positions[range.clone()].iter().zip(&previous[range]).filter(|(now, _)| now.w > 0.0);
    ways.map(|(now, old)| Vec3A::from_vec4(*now - *old).length_squared()).fold(0.0, f32::max).sqrt()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::vec3;

    use super::*;
    use crate::solver::detect::PartRef;
    use crate::solver::resolve::Untangler;
    use crate::solver::topology::Topology;

    fn look<'a>(untangler: &'a mut Untangler, surface: &'a Surface, positions: &[Vec4]) -> Tangle<'a> {
        untangler.look(surface, positions);
        Tangle { surface, crossings: untangler.detector.crossings(), graph: untangler.resolver.graph() }
    }

    /// A triangle, and a smaller one whose corner is above it.
    fn surface() -> (Surface, Vec<Vec4>) {
        let topology = Arc::new(Topology::new(3, vec![[0, 1, 2]]));
        let lower = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let upper = [vec3(0.2, 0.2, 0.1), vec3(0.4, 0.2, 0.3), vec3(0.2, 0.4, 0.3)];
        let part = |rest| PartRef { topology: &topology, rest, garment_layer: 0, self_collision: true, thickness: 0.01 };
        let surface = Surface::new(&[part(&lower), part(&upper)]).expect("two cloths");
        (surface, lower.into_iter().chain(upper).map(|x| x.extend(1.0)).collect())
    }

    /// A rollback that knows where all was before it went 0.04 m in 4 substeps, the corner through the other triangle.
    fn after_a_frame(takes_part: bool) -> (Surface, Vec<Vec4>, Rollback, Untangler, Vec<Vec4>, Vec<Vec4>) {
        let (surface, clean) = surface();
        let mut rollback = Rollback::default();
        rollback.note(&surface, &clean, &clean, true);
        let mut positions: Vec<Vec4> = clean.iter().map(|x| *x + Vec4::X * 0.04).collect();
        positions[3].z = -0.1;
        let previous: Vec<Vec4> = positions.iter().map(|x| *x - Vec4::X * 0.01).collect();
        let mut untangler = Untangler::new(&surface);
        assert_eq!(look(&mut untangler, &surface, &positions).crossings.len(), 2);
        assert!(rollback.begin(&surface, &positions, &previous, &[takes_part; 2], 4));
        (surface, clean, rollback, untangler, positions, previous)
    }

    #[test]
    fn what_crosses_goes_back_with_all_and_then_to_its_very_place() {
        let (surface, clean, mut rollback, mut untangler, mut positions, mut previous) = after_a_frame(true);
        let tangle = look(&mut untangler, &surface, &positions);
        assert!(rollback.restore_relative(&tangle, &mut positions, &mut previous) && rollback.rolls_back());
        assert!(positions[3].distance(clean[3] + Vec4::X * 0.04) < 1e-6, "{}", positions[3]);
        assert!(look(&mut untangler, &surface, &positions).crossings.is_empty());
        // Pushed through again, it was taken already.
        positions[3].z = -0.1;
        let tangle = look(&mut untangler, &surface, &positions);
        assert!(!rollback.restore_relative(&tangle, &mut positions, &mut previous));
        assert!(rollback.restore_exactly(&tangle, &mut positions, &mut previous));
        assert_eq!(positions[3], clean[3]);
        assert!((positions[3] - previous[3]).distance(Vec4::X * 0.01) < 1e-6, "goes on as all did");
        assert!(!rollback.restore_exactly(&tangle, &mut positions, &mut previous), "is there");
    }

    #[test]
    fn what_fell_on_cloth_at_rest_goes_back_and_that_stays_whatever_the_rest_of_it_does() {
        // One cloth: a triangle at rest, one that falls through it, and one that is far away by now.
        let topology = Arc::new(Topology::new(9, vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]]));
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let rest: Vec<Vec3> = [Vec3::ZERO, vec3(0.1, 0.1, 0.1), Vec3::splat(3.0)]
            .into_iter()
            .zip([1.0, 0.5, 1.0])
            .flat_map(|(at, size)| corners.map(|x| at + size * x))
            .collect();
        let part = PartRef { topology: &topology, rest: &rest, garment_layer: 0, self_collision: true, thickness: 0.01 };
        let surface = Surface::new(&[part]).expect("a cloth");
        let clean: Vec<Vec4> = rest.iter().map(|x| x.extend(1.0)).collect();
        let mut rollback = Rollback::default();
        rollback.note(&surface, &clean, &clean, true);
        let mut positions = clean.clone();
        positions[3].z -= 0.2;
        positions[6..].iter_mut().for_each(|x| x.z -= 2.0);
        let mut previous = clean.clone();
        let mut untangler = Untangler::new(&surface);
        let tangle = look(&mut untangler, &surface, &positions);
        assert!(!tangle.crossings.is_empty() && rollback.begin(&surface, &positions, &previous, &[true], 4));
        assert!(rollback.restore_relative(&tangle, &mut positions, &mut previous));
        assert_eq!(positions[..6], clean[..6]);
        assert!(look(&mut untangler, &surface, &positions).crossings.is_empty());
    }

    #[test]
    fn single_particles_go_back_by_an_edge_at_most_and_farther_with_all_of_their_cloth() {
        let (surface, clean, mut rollback, mut untangler, mut positions, mut previous) = after_a_frame(true);
        positions[3].z = clean[3].z - 1.01 * surface.mean_edge;
        let tangle = look(&mut untangler, &surface, &positions);
        assert!(!tangle.crossings.is_empty());
        let there = positions[3];
        rollback.restore_relative(&tangle, &mut positions, &mut previous);
        rollback.restore_exactly(&tangle, &mut positions, &mut previous);
        assert_eq!(positions[3], there);
        assert!(rollback.restore_whole(&tangle, &mut positions, &mut previous));
        assert!(positions.iter().zip(&clean).all(|(x, clean)| x.distance(*clean) < 1e-6), "{positions:?}");
    }

    #[test]
    fn what_pins_went_through_goes_along_with_them() {
        let (surface, mut clean) = surface();
        clean[..3].iter_mut().for_each(|x| x.w = 0.0);
        clean[3].z = 0.02;
        let mut rollback = Rollback::default();
        rollback.note(&surface, &clean, &clean, true);
        // Its pins turn the lower triangle by 0.2 radians, through the corner.
        let turn = glam::Quat::from_rotation_x(0.2);
        let mut positions = clean.clone();
        positions[..3].iter_mut().for_each(|x| *x = (turn * x.truncate()).extend(0.0));
        let mut previous = positions.clone();
        let mut untangler = Untangler::new(&surface);
        let tangle = look(&mut untangler, &surface, &positions);
        assert!(!tangle.crossings.is_empty() && rollback.begin(&surface, &positions, &previous, &[true; 2], 4));
        assert!(!rollback.restore_exactly(&tangle, &mut positions, &mut previous), "it is where it was");
        assert!(rollback.follow_pins(&tangle, &mut positions, &mut previous));
        assert!(look(&mut untangler, &surface, &positions).crossings.is_empty());
        for v in 3..6 {
            let (expected, way) = (turn * clean[v].truncate(), (positions[v] - previous[v]).truncate());
            assert!(positions[v].truncate().distance(expected) < 1.0e-3, "{} instead of {expected}", positions[v]);
            assert!(way.distance(0.25 * (positions[v] - clean[v]).truncate()) < 1.0e-6, "goes on as the pins did: {way}");
        }
    }

    #[test]
    fn whole_cloths_stay_for_a_few_frames_at_most() {
        let (surface, clean, mut rollback, mut untangler, mut positions, mut previous) = after_a_frame(true);
        let crossing = positions.clone();
        let tangle = look(&mut untangler, &surface, &positions);
        for frame in 0..=MOST_STAYS {
            positions.clone_from(&crossing);
            let stayed = rollback.restore_whole(&tangle, &mut positions, &mut previous);
            assert_eq!(stayed, frame < MOST_STAYS, "frame {frame}");
            assert_eq!(positions, if stayed { clean.clone() } else { crossing.clone() });
            rollback.note(&surface, &clean, &clean, true);
            assert!(rollback.begin(&surface, &crossing, &previous, &[true; 2], 4));
        }
    }

    #[test]
    fn whole_cloths_go_back_along_with_their_pins() {
        let (surface, mut clean) = surface();
        clean[5].w = 0.0;
        let mut rollback = Rollback::default();
        rollback.note(&surface, &clean, &clean, true);
        // Its pin takes the upper triangle aside, and its corner goes through the lower one.
        let mut positions = clean.clone();
        positions[3].z = -0.1;
        positions[5] += Vec4::X * 0.02;
        let mut untangler = Untangler::new(&surface);
        let mut previous = positions.clone();
        let tangle = look(&mut untangler, &surface, &positions);
        assert!(!tangle.crossings.is_empty() && rollback.begin(&surface, &positions, &previous, &[true; 2], 4));
        assert!(rollback.follow_pins_whole(&tangle, &mut positions, &mut previous));
        assert_eq!(positions[..3], clean[..3]);
        for v in 3..5 {
            assert!(positions[v].distance(clean[v] + Vec4::X * 0.02) < 1.0e-6, "{positions:?}");
        }
        assert!(look(&mut untangler, &surface, &positions).crossings.is_empty());
    }

    #[test]
    fn a_bend_of_pins_in_a_row_does_not_throw_the_cloth() {
        // Two strips, one through the other; the upper one hangs from a row of pins that bends.
        let topology = Arc::new(Topology::new(4, vec![[0, 1, 3], [1, 2, 3]]));
        let rest = [Vec3::ZERO, vec3(0.2, 0.0, 0.01), vec3(0.4, 0.0, 0.0), vec3(0.2, 1.2, 0.0)];
        let lower = rest.map(|x| x + vec3(0.0, 0.0, -0.2));
        let part = |rest| PartRef { topology: &topology, rest, garment_layer: 0, self_collision: true, thickness: 0.01 };
        let surface = Surface::new(&[part(&lower), part(&rest)]).expect("two cloths");
        let mut clean: Vec<Vec4> = lower.into_iter().chain(rest).map(|x| x.extend(1.0)).collect();
        clean[4..7].iter_mut().for_each(|x| x.w = 0.0);
        let mut rollback = Rollback::default();
        rollback.note(&surface, &clean, &clean, true);
        let mut positions = clean.clone();
        positions[5].y += 0.005;
        positions[5].z -= 0.005;
        positions[7].z -= 0.3;
        let (mut previous, mut untangler) = (positions.clone(), Untangler::new(&surface));
        let tangle = look(&mut untangler, &surface, &positions);
        assert!(!tangle.crossings.is_empty() && rollback.begin(&surface, &positions, &previous, &[true; 2], 4));
        rollback.farthest.fill(0.4);
        let crossing = positions[7];
        rollback.follow_pins_whole(&tangle, &mut positions, &mut previous);
        assert_eq!(positions[7], crossing, "pins that bend look like {:?}", positions[7]);
        assert!(rollback.restore_whole(&tangle, &mut positions, &mut previous));
        assert!(positions[7].distance(clean[7]) < 1.0e-6);
    }

    #[test]
    fn cloth_that_no_contact_keeps_apart_is_not_taken_back() {
        let (surface, _, mut rollback, mut untangler, mut positions, mut previous) = after_a_frame(false);
        let tangle = look(&mut untangler, &surface, &positions);
        assert!(!rollback.restore_relative(&tangle, &mut positions, &mut previous));
        assert!(!rollback.restore_whole(&tangle, &mut positions, &mut previous));
    }
}
