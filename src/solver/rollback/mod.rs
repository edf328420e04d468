//! A tangle that came up within one frame is rolled back: its particles go where they were when nothing crossed.
//!
//! ```text
//!   x ─► x0 + u     x0: where it was when the last frame ended clean; velocity is kept
//!                   u: mean motion since of the cloth that crosses and moved least
//!   x ─► x0         where that is not enough and u is short; goes on as all together did
//!   x ─► R x0 + c   where pins went on: along with those that it crosses ([`pins`])
//! ```
//!
//! What was clean together and moves together is clean, so each look adds the particles that still cross until none do.
//! Contacts and their CCD know the pairs in the next frame. Tangles that were there before, that are held, that came from far,
//! or of cloths that started in the same place are left to [`resolve`](super::resolve).

mod pins;

use core::ops::Range;

use glam::{Vec3, Vec3A, Vec4};

use super::detect::{Crossing, Part, Surface};
use pins::Pins;

/// How much farther a particle may have gone in the frame than the fastest particle of its cloth flew, in mean edges. A
/// particle that was moved farther, by a teleport, is not rolled back.
const FARTHEST_EDGES: f32 = 4.0;

/// How far all together may have moved, in mean edges, for single particles to be left where they were.
const NEAR_EDGES: f32 = 0.25;

/// How far a particle may be from where a frame left it when the next one begins, in mean edges.
const MOVED_EDGES: f32 = 0.01;

/// Frames in a row in which whole cloths stay where they were.
const MOST_STAYS: u32 = 8;

/// Where everything was when nothing crossed.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Rollback {
    /// Positions `[m]` at the end of the last frame; empty when it did not end clean, or when no cloth rested on cloths then.
    clean: Vec<Vec4>,
    /// Which particles were rolled back in this frame, and in the one before.
    restored: Vec<bool>,
    was_restored: Vec<bool>,
    /// Mean motion since then of the cloth that crosses and moved least `[m]`: what rests is not put where what fell on it
    /// went.
    shared: Vec3A,
    /// Substeps of the frame.
    substeps: f32,
    /// Way of the fastest particle of each cloth in the last substep of the last clean frame `[m]`.
    fastest: Vec<f32>,
    /// How far particles of each cloth may be put back in this frame `[m]`.
    farthest: Vec<f32>,
    /// Whether something was rolled back in this frame, and whether whole cloths stayed.
    rolled_back: bool,
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

    /// Whether it is known where everything was when nothing crossed.
    pub(crate) fn knows(&self) -> bool {
        !self.clean.is_empty()
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
            self.fastest.extend(surface.parts.iter().map(|part| fastest(range(part), positions, previous)));
        }
        self.stays = if self.stayed { self.stays + 1 } else { 0 };
        (self.rolled_back, self.stayed) = (false, false);
    }

    /// Forgets where everything was, if something else than a frame moved cloth `part` since, as a teleport does. The cloth is
    /// to begin the next frame at `positions`, `offset` `[m]` from the frame of the island.
    pub(crate) fn forget_if_moved(&mut self, surface: &Surface, part: usize, positions: &[Vec4], offset: Vec3) {
        let limit = MOVED_EDGES * surface.mean_edge;
        let clean = surface.parts.get(part).and_then(|part| self.clean.get(range(part))).unwrap_or_default();
        let is_elsewhere = |(x, clean): (&Vec4, &Vec4)| {
            !(Vec3A::from_vec4(*x - *clean + offset.extend(0.0)).length_squared() <= limit * limit)
        };
        if positions.len() != clean.len() || positions.iter().zip(clean).any(is_elsewhere) {
            self.clean.clear();
        }
    }

    /// Everything lies `by` `[m]` elsewhere from now on.
    pub(crate) fn carry(&mut self, by: Vec3) {
        self.clean.iter_mut().for_each(|x| *x += by.extend(0.0));
    }

    /// Begins with nothing rolled back; whether anything can be: of the cloths that take part, by number. The frame took as
    /// many `substeps`, the last of which lies between `previous` and `positions` `[m]`.
    pub(crate) fn begin(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        previous: &[Vec4],
        takes_part: &[bool],
        substeps: u32,
    ) -> bool {
        if self.clean.len() != positions.len() {
            return false;
        }
        self.substeps = substeps as f32;
        self.pins.forget();
        self.farthest.clear();
        self.note_crossed(surface, crossings);
        let mut shared: Option<Vec3A> = None;
        for ((i, part), &before) in surface.parts.iter().enumerate().zip(&self.fastest) {
            // What was stopped on its way flew before.
            let flown = fastest(range(part), positions, previous).max(before) * self.substeps;
            let farthest = FARTHEST_EDGES * surface.mean_edge + if flown.is_finite() { flown } else { 0.0 };
            // What no contact keeps apart would have to be rolled back for ever.
            self.farthest.push(if takes_part.get(i) == Some(&true) { farthest } else { 0.0 });
            if !self.crossed[i] {
                continue;
            }
            // Of free particles; of all where none is.
            let held = positions[range(part)].iter().all(|x| x.w == 0.0);
            let (mut sum, mut count) = (Vec3A::ZERO, 0.0);
            for (now, then) in positions[range(part)].iter().zip(&self.clean[range(part)]) {
                let way = Vec3A::from_vec4(*now - *then);
                if (held || now.w > 0.0) && way.is_finite() {
                    (sum, count) = (sum + way, count + 1.0);
                }
            }
            let mean = sum / f32::max(count, 1.0);
            shared = shared.filter(|least| least.length_squared() <= mean.length_squared()).or(Some(mean));
        }
        self.shared = shared.unwrap_or(Vec3A::ZERO);
        true
    }

    /// Takes the particles that cross back; whether there were any that had not been.
    pub(crate) fn restore_relative(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &mut [Vec4],
        previous: &mut [Vec4],
    ) -> bool {
        let mut any = false;
        self.for_each_that_crosses(surface, crossings, positions, |this, v, x| {
            if !std::mem::replace(&mut this.restored[v], true) {
                let by = (this.clean[v] - *x).truncate() + Vec3::from(this.shared);
                *x += by.extend(0.0);
                previous[v] += by.extend(0.0);
                any = true;
            }
        });
        self.rolled_back |= any;
        any
    }

    /// Whether something was rolled back in this frame.
    pub(crate) fn rolled_back(&self) -> bool {
        self.rolled_back
    }

    /// Puts the particles that cross to the very place where they were, unless all have moved far since. A body pushed the
    /// particles that were taken along with all, or rounding made them cross what they touched. They go on as all together did.
    /// Returns whether any was elsewhere.
    pub(crate) fn restore_exactly(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &mut [Vec4],
        previous: &mut [Vec4],
    ) -> bool {
        if self.shared.length() > NEAR_EDGES * surface.mean_edge {
            return false;
        }
        let mean = self.mean();
        self.put(surface, crossings, positions, previous, |this, v| {
            let clean = this.clean[v].truncate();
            Some([clean, clean - mean])
        })
    }

    /// Puts the particles that cross pins, or particles that were put there, where they were, carried on as these pins went
    /// since. Pins cannot be taken back. Whether any was elsewhere.
    pub(crate) fn follow_pins(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &mut [Vec4],
        previous: &mut [Vec4],
    ) -> bool {
        let mut pins = core::mem::take(&mut self.pins);
        pins.meet(surface, crossings, positions, &self.clean);
        let substeps = self.substeps.max(1.0);
        let any = self.put(surface, crossings, positions, previous, |this, v| {
            let clean = this.clean[v].truncate();
            pins.destination(v, clean).map(|to| [to, to.lerp(clean, 1.0 / substeps)])
        });
        self.pins = pins;
        self.rolled_back |= any;
        any
    }

    /// Puts the particles that cross where `place` says: positions now and a substep before `[m]`. Whether any was elsewhere.
    fn put(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        place: impl Fn(&Self, usize) -> Option<[Vec3; 2]>,
    ) -> bool {
        let mut any = false;
        self.for_each_that_crosses(surface, crossings, positions, |this, v, x| {
            let Some([now, before]) = place(this, v).filter(|[now, _]| x.truncate() != *now) else { return };
            this.restored[v] = true;
            *x = now.extend(x.w);
            previous[v] = before.extend(previous[v].w);
            any = true;
        });
        any
    }

    /// Calls `act` with every free particle that crosses and did not come from too far, once for each crossing, and with its
    /// position `[m]`.
    fn for_each_that_crosses(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &mut [Vec4],
        mut act: impl FnMut(&mut Self, usize, &mut Vec4),
    ) {
        let topology = &surface.topology;
        for crossing in crossings {
            let (e, f) = (topology.edges[crossing.edge as usize], topology.faces[crossing.face as usize]);
            for v in e.into_iter().chain(f) {
                let farthest = self.farthest[usize::from(surface.part(v))];
                let v = v as usize;
                let way = Vec3A::from_vec4(positions[v] - self.clean[v]) - self.shared;
                if positions[v].w > 0.0 && way.length_squared() < farthest * farthest {
                    act(self, v, &mut positions[v]);
                }
            }
        }
    }

    /// Way of all together in a substep `[m]`.
    fn mean(&self) -> Vec3 {
        Vec3::from(self.shared / self.substeps.max(1.0))
    }

    /// Puts the cloths that cross where they were, as a whole, and returns whether any was elsewhere. A body pushed particles
    /// that were rolled back, and no other place is known to be clean. No more than a few frames in a row. Velocity is kept,
    /// except that particles that were rolled back go on as all together did: they would do the same again. A cloth that came
    /// from far does not stay.
    pub(crate) fn restore_cloths(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &mut [Vec4],
        previous: &mut [Vec4],
    ) -> bool {
        if self.stays >= MOST_STAYS {
            return false;
        }
        let mean = self.mean();
        let mut any = false;
        self.note_crossed(surface, crossings);
        for (i, part) in surface.parts.iter().enumerate().filter(|(part, _)| self.crossed[*part]) {
            let is_far = |(now, then): (&Vec4, &Vec4)| {
                now.w > 0.0 && Vec3A::from_vec4(*now - *then).length_squared() > self.farthest[i] * self.farthest[i]
            };
            if positions[range(part)].iter().zip(&self.clean[range(part)]).any(is_far) {
                continue;
            }
            for v in range(part) {
                let by = (self.clean[v] - positions[v]).truncate().extend(0.0);
                if positions[v].w > 0.0 && by.is_finite() {
                    any |= by != Vec4::ZERO;
                    positions[v] += by;
                    previous[v] += by;
                    if self.restored[v] {
                        previous[v] = (positions[v].truncate() - mean).extend(previous[v].w);
                    }
                }
            }
        }
        self.stayed |= any;
        any
    }

    /// Notes which cloths are part of a crossing.
    fn note_crossed(&mut self, surface: &Surface, crossings: &[Crossing]) {
        self.crossed.clear();
        self.crossed.resize(surface.parts.len(), false);
        let parts = crossings.iter().flat_map(|c| [surface.part_of_edge(c.edge), surface.part_of_face(c.face)]);
        parts.for_each(|part| self.crossed[usize::from(part)] = true);
    }
}

fn range(part: &Part) -> Range<usize> {
    part.particles.start as usize..part.particles.end as usize
}

/// Longest way of a free particle `[m]`.
fn fastest(range: Range<usize>, positions: &[Vec4], previous: &[Vec4]) -> f32 {
    let ways = positions[range.clone()].iter().zip(&previous[range]).filter(|(now, _)| now.w > 0.0);
    ways.map(|(now, old)| Vec3A::from_vec4(*now - *old).length_squared()).fold(0.0, f32::max).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::solver::detect::{Detector, PartRef};
    use crate::solver::topology::Topology;

    /// A triangle, and a smaller one whose corner is above it.
    fn surface() -> (Surface, Vec<Vec4>) {
        let topology = Topology::new(3, vec![[0, 1, 2]]);
        let lower = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let upper = [vec3(0.2, 0.2, 0.1), vec3(0.4, 0.2, 0.3), vec3(0.2, 0.4, 0.3)];
        let part = |rest| PartRef { topology: &topology, rest, layer: 0, self_collision: true, thickness: 0.01 };
        let surface = Surface::new(&[part(&lower), part(&upper)]).expect("two cloths");
        (surface, lower.into_iter().chain(upper).map(|x| x.extend(1.0)).collect())
    }

    /// A rollback that knows where all was before it went 0.04 m in 4 substeps, the corner through the other triangle.
    fn after_a_frame(takes_part: bool) -> (Surface, Vec<Vec4>, Rollback, Detector, Vec<Vec4>, Vec<Vec4>) {
        let (surface, clean) = surface();
        let mut rollback = Rollback::default();
        rollback.note(&surface, &clean, &clean, true);
        let mut positions: Vec<Vec4> = clean.iter().map(|x| *x + Vec4::X * 0.04).collect();
        positions[3].z = -0.1;
        let previous: Vec<Vec4> = positions.iter().map(|x| *x - Vec4::X * 0.01).collect();
        let mut detector = Detector::new(&surface);
        let crossings = detector.detect(&surface, &positions);
        assert_eq!(crossings.len(), 2);
        assert!(rollback.begin(&surface, crossings, &positions, &previous, &[takes_part; 2], 4));
        (surface, clean, rollback, detector, positions, previous)
    }

    #[test]
    fn what_crosses_goes_back_with_all_and_then_to_its_very_place() {
        let (surface, clean, mut rollback, mut detector, mut positions, mut previous) = after_a_frame(true);
        assert!(
            rollback.restore_relative(&surface, detector.crossings(), &mut positions, &mut previous) && rollback.rolled_back()
        );
        assert!(positions[3].distance(clean[3] + Vec4::X * 0.04) < 1e-6, "{}", positions[3]);
        assert!(detector.detect(&surface, &positions).is_empty());
        // Pushed through again, it was taken already.
        positions[3].z = -0.1;
        detector.detect(&surface, &positions);
        assert!(!rollback.restore_relative(&surface, detector.crossings(), &mut positions, &mut previous));
        assert!(rollback.restore_exactly(&surface, detector.crossings(), &mut positions, &mut previous));
        assert_eq!(positions[3], clean[3]);
        assert!((positions[3] - previous[3]).distance(Vec4::X * 0.01) < 1e-6, "goes on as all did");
        assert!(!rollback.restore_exactly(&surface, detector.crossings(), &mut positions, &mut previous), "is there");
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
        let mut detector = Detector::new(&surface);
        let crossings = detector.detect(&surface, &positions).to_vec();
        assert!(!crossings.is_empty() && rollback.begin(&surface, &crossings, &positions, &previous, &[true; 2], 4));
        assert!(!rollback.restore_exactly(&surface, &crossings, &mut positions, &mut previous), "it is where it was");
        assert!(rollback.follow_pins(&surface, &crossings, &mut positions, &mut previous) && rollback.rolled_back());
        assert!(detector.detect(&surface, &positions).is_empty());
        for v in 3..6 {
            let (expected, way) = (turn * clean[v].truncate(), (positions[v] - previous[v]).truncate());
            assert!(positions[v].truncate().distance(expected) < 1.0e-3, "{} instead of {expected}", positions[v]);
            assert!(way.distance(0.25 * (positions[v] - clean[v]).truncate()) < 1.0e-6, "goes on as the pins did: {way}");
        }
    }

    #[test]
    fn whole_cloths_stay_for_a_few_frames_at_most() {
        let (surface, clean, mut rollback, mut detector, mut positions, mut previous) = after_a_frame(true);
        let crossing = positions.clone();
        for frame in 0..=MOST_STAYS {
            positions.clone_from(&crossing);
            let stayed = rollback.restore_cloths(&surface, detector.crossings(), &mut positions, &mut previous);
            assert_eq!(stayed, frame < MOST_STAYS, "frame {frame}");
            assert_eq!(positions, if stayed { clean.clone() } else { crossing.clone() });
            rollback.note(&surface, &clean, &clean, true);
            let crossings = detector.detect(&surface, &crossing);
            assert!(rollback.begin(&surface, crossings, &crossing, &previous, &[true; 2], 4));
        }
    }

    #[test]
    fn cloth_that_no_contact_keeps_apart_is_not_taken_back() {
        let (surface, _, mut rollback, detector, mut positions, mut previous) = after_a_frame(false);
        assert!(!rollback.restore_relative(&surface, detector.crossings(), &mut positions, &mut previous));
        assert!(!rollback.rolled_back());
    }
}
