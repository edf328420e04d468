//! Respond: cloth rests on cloth, and folds on itself.
//!
//! ```text
//! where it moved NeighborList::find       boxes swept by the motion foreseen ─► pairs that may touch, each with its side
//! each substep   Contacts::touch          closest points again ─► what touches, pushed one thickness apart
//!                Contacts::solve          the same in more passes ─► friction of the last substep
//!                Contacts::apply_friction when bodies have pushed, too: what still slips is held
//!                Contacts::apply_restitution what met fast gets its speed apart
//!                Contacts::clamp_motion   what would still pass through is stopped on its way
//! ```
//!
//! A pair keeps its side. A particle that went through a face, and not around it, is brought back to the front, where it was.
//! So one look a frame, or two where cloth flutters, is enough, as long as it sees everything that can be met before the next.
//! It holds until something drifts by the margin, or a face turns. Pairs of a tangle have no right side; they are left to
//! [`resolve`](crate::solver::resolve), which stops at cloth that has no part in the tangle.
//!
//! Distances are between centres: the thickness of a pair is the mean of those of its two cloths.

mod cloths;
mod constraint;
mod contact;
mod neighbors;
mod ground;
mod ccd;
mod incidence;
mod loads;
mod depth;
#[cfg(feature = "debug")]
mod touching;

use core::ops::Range;

use glam::{Quat, Vec3, Vec3A, Vec4};

use crate::solver::body::{Bearing, Touch};
use crate::solver::buffer::{Buffer, keep_room};
use crate::solver::detect::Surface;
use cloths::{Cloths, offset_of};
use constraint::Constraint;
use contact::{Contact, Particles};
use depth::Depths;
use ground::Ground;
use incidence::Incidence;
use loads::{Borne, Load, Loads};
pub(crate) use neighbors::{Moment, NeighborList};
#[cfg(feature = "debug")]
pub(crate) use touching::Touching;

/// Pairs that may touch before the next frame. Positions are those of all particles of an island, each in the frame of
/// simulation of its cloth.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Contacts {
    pairs: Vec<Contact>,
    /// What those bear that touched in the last substep, in their order.
    borne: Vec<Borne>,
    /// Whether each particle was part of a pair since the last look at everything.
    paired: Vec<bool>,
    /// From the frame of simulation of each cloth to that of the island `[m]`.
    offsets: Vec<Vec3>,
    /// Constraints of pairs that met fast in the last substep, and how fast each is to part `[m/s]`.
    impacts: Buffer<Vec<(u32, f32)>>,
    start: Buffer<Start>,
    /// Positions when the CCD of this substep had nothing more to cut `[m]`; empty before, and where it gave up.
    clamped: Buffer<Vec<Vec4>>,
    /// Pass of the CCD in which each particle was last stopped.
    cut: Buffer<Vec<u8>>,
    /// What divides each pair when the substep begins, where the CCD asks again.
    dividers: Buffer<Vec<Vec4>>,
    /// The pairs of each particle, where the CCD asks again.
    incidence: Buffer<Incidence>,
    depths: Depths,
    /// What bodies bear in the substep.
    ground: Buffer<Ground>,
    /// Whether a pair may have got on the wrong side in this substep.
    newly_inverted: bool,
    /// Pairs that were kept at the last look since they are on the wrong side.
    inverted: Vec<(u8, [u32; 4])>,
    /// What pairs bore that the last look forgot.
    loads: Loads,
    /// Faces that are close, or may come close: no others can cross before the next look.
    close: Vec<[u32; 2]>,
    /// Whether primitives lay in the same place at the last look.
    coincide: bool,
    /// What keeps apart those that touch in a substep, in their order.
    constraints: Buffer<Vec<Constraint>>,
    /// The last substep `[s]`.
    substep: f32,
}

/// Where all particles are when a substep begins, whatever is done to velocities since.
#[derive(Debug, Default)]
struct Start {
    /// `xyz` position `[m]`, `w` inverse mass `[1/kg]`.
    positions: Vec<Vec4>,
    /// Where they were the time of a substep before `[m]`.
    previous: Vec<Vec4>,
    /// One over that time `[1/s]`; 0 before the first substep.
    per_second: f32,
}

impl Start {
    /// Velocity of a particle `[m/s]`.
    fn velocity(&self, particle: usize) -> Vec3A {
        Vec3A::from_vec4(self.positions[particle] - self.previous[particle]) * self.per_second
    }
}

/// Speed at which pairs that are closer than their thickness are taken apart `[m/s]`.
const RECOVERY_SPEED: f32 = 0.5;

/// Passes over the pairs that touch in a substep. With one, a heap of ten sheets on a ball trembles for ever at 140 mm/s (root
/// mean square). With two it does at 90, with three at 19, with four at 14, with six at 11.
const PASSES: u32 = 6;

/// How often pairs that met fast are given their speed, there and back. Two sheets of 20² that meet flat at 1 m/s and do not
/// bounce part at 0.17 m/s after one pass. After three they part at 0.04, after six at 0.003. Sheets of 12² part at 0.38
/// without any.
const RESTITUTION_PASSES: u32 = 3;

impl Contacts {
    /// Forgets all pairs.
    pub(crate) fn clear(&mut self) {
        self.incidence.forget();
        self.paired.fill(false);
        self.pairs.clear();
        self.borne.clear();
        self.inverted.clear();
        self.close.clear();
        self.constraints.clear();
        self.impacts.clear();
        self.ground.begin(0, 0);
    }

    /// Forgets all pairs except those on the wrong side, which would take it for the right one.
    fn begin(&mut self) {
        self.coincide = false;
        let (close, listed, touching) = (self.close.len(), self.pairs.len(), self.borne.len());
        self.forget_all_but(|pair| pair.inverted);
        let Self { pairs, paired, .. } = self;
        paired.fill(false);
        pairs.iter().for_each(|pair| note_paired(paired, pair.particles));
        self.note_inverted();
        self.close.clear();
        self.ground.begin(0, 0);
        // What is brought up to date grows by what comes close, until the next look at everything.
        keep_room(&mut self.close, close);
        keep_room(&mut self.pairs, listed);
        keep_room(&mut self.borne, touching);
        keep_room(&mut self.impacts, touching);
        keep_room(&mut self.constraints, touching);
        self.loads.reserve(touching);
    }

    /// Says of pairs with a particle that was `put` back to where it belongs that they are on the right side.
    pub(crate) fn clear_inverted(&mut self, put: impl Fn(u32) -> bool) {
        for pair in self.pairs.iter_mut().filter(|pair| pair.inverted) {
            pair.inverted = !pair.particles.iter().any(|&p| put(p));
        }
    }

    /// Whether primitives lay in the same place at the last look, so that the side on which they belong is not known.
    #[must_use]
    pub(crate) fn coincide(&self) -> bool {
        self.coincide
    }

    /// Faces that are close, or may come close before the next look.
    #[must_use]
    pub(crate) fn close_faces(&self) -> &[[u32; 2]] {
        &self.close
    }

    /// Number of pairs that may touch.
    #[must_use]
    pub(crate) fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether nothing can touch.
    #[must_use]
    pub(crate) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Pairs that touched in the last substep.
    #[must_use]
    pub(crate) fn touching(&self) -> u32 {
        self.bearing().count() as u32
    }

    /// Particles, weights, unit normal towards the first and mean of push over mobility per substep `[kg·m]` of every pair that
    /// touched in the last substep.
    pub(crate) fn pushes(&self) -> impl Iterator<Item = ([u32; 4], [f32; 4], Vec3, f32)> + '_ {
        self.bearing().map(|(pair, load)| (pair.particles, pair.weights, pair.normal, load.drive))
    }

    /// The pairs that touched in the last substep, and what each bears.
    fn bearing(&self) -> impl Iterator<Item = (&Contact, &Load)> + '_ {
        let touching = self.borne.iter().filter(|borne| borne.load.push > 0.0);
        touching.filter_map(|borne| Some((self.pairs.get(borne.pair as usize)?, &borne.load)))
    }

    /// Makes room for the particles of a surface.
    fn fit(&mut self, surface: &Surface) {
        self.paired.resize(surface.len(), false);
        self.offsets.resize(surface.parts.len(), Vec3::ZERO);
        self.depths.fit(surface.len());
        // So that lists do not grow where cloth begins to fold.
        let particles = surface.len();
        self.close.reserve(particles.saturating_sub(self.close.len()));
        self.pairs.reserve(particles.saturating_sub(self.pairs.len()));
        self.loads.fit(particles);
        self.inverted.reserve((particles / 8).saturating_sub(self.inverted.len()));
    }

    /// Lists the pairs that are on the other side than they belong: a new look would take the wrong side for theirs.
    fn note_inverted(&mut self) {
        self.inverted.clear();
        let Self { pairs, inverted, .. } = self;
        inverted.extend(pairs.iter().filter(|p| p.inverted).map(|p| (p.kind as u8, p.particles)));
        inverted.sort_unstable();
    }

    /// Forgets all pairs except those to `keep`, and notes what the others bear.
    fn forget_all_but(&mut self, keep: impl Fn(&Contact) -> bool) {
        let Self { pairs, borne, loads, constraints, impacts, incidence, .. } = self;
        // They index pairs.
        incidence.forget();
        constraints.clear();
        impacts.clear();
        loads.clear();
        let (mut number, mut kept) = (0, 0);
        let (mut next, mut kept_borne) = (0, 0);
        pairs.retain(|pair| {
            let keep = keep(pair);
            if let Some(&Borne { load, .. }) = borne.get(next).filter(|borne| borne.pair == number) {
                next += 1;
                if keep {
                    borne[kept_borne] = Borne { pair: kept, load };
                    kept_borne += 1;
                } else if load.push > 0.0 {
                    loads.note(pair.kind, pair.particles, load);
                }
            }
            number += 1;
            kept += u32::from(keep);
            keep
        });
        borne.truncate(kept_borne);
    }

    /// Lets go of particles that have not lain on anything for a while; once a substep.
    pub(crate) fn age_support(&mut self) {
        self.depths.age();
    }

    /// Says that a particle lies on a body. Cloth on top of it gives way, and the CCD moves it no farther into the body that is
    /// `bearing` it.
    pub(crate) fn touch_ground(&mut self, particle: u32, bearing: Option<Bearing>) {
        self.depths.ground(particle);
        let v = particle as usize;
        if let Some(Bearing { at, normal, way }) = bearing.filter(|_| self.paired.get(v) == Some(&true))
            && let Some(start) = self.start.positions.get(v)
        {
            self.ground.add(particle, normal, way, at - Vec3A::from_vec4(*start));
        }
    }

    /// Takes in where the frame of simulation of each cloth is in that of the island `[m]`.
    pub(crate) fn set_offsets(&mut self, offsets: impl Iterator<Item = Vec3>) {
        self.offsets.clear();
        self.offsets.extend(offsets);
    }

    /// All cloths were turned as one, `by` that.
    pub(crate) fn turn(&mut self, by: Quat) {
        self.pairs.iter_mut().for_each(|pair| pair.normal = by * pair.normal);
        self.borne.iter_mut().for_each(|borne| borne.load.tangent_push = by * borne.load.tangent_push);
    }

    /// Where the frame of simulation of a cloth is in that of the island `[m]`.
    pub(crate) fn offset(&self, part: u16) -> Vec3 {
        offset_of(part, &self.offsets)
    }

    /// Lists a pair, with what it bore when it was listed before.
    #[inline]
    fn push(&mut self, pair: Contact) {
        self.incidence.forget();
        note_paired(&mut self.paired, pair.particles);
        let load = self.loads.of(pair.kind, pair.particles);
        if load.push > 0.0 {
            self.borne.push(Borne { pair: self.pairs.len() as u32, load });
        }
        self.pairs.push(pair);
    }

    /// Begins a substep: notes where all are (`[m]`, `w` inverse mass), and where they were a time of `h` `[s]` before `[m]`.
    pub(crate) fn note_start(&mut self, positions: &[Vec4], previous: &[Vec4], h: f32) {
        let n = positions.len();
        positions.clone_into(&mut self.start.positions);
        previous.clone_into(&mut self.start.previous);
        self.start.per_second = if h > 0.0 { h.recip() } else { 0.0 };
        // For the CCD, which mostly needs none of them.
        self.ground.begin(n, self.paired.iter().filter(|paired| **paired).count());
        self.clamped.clear();
        self.clamped.reserve(n);
        self.dividers.clear();
        self.dividers.reserve(self.pairs.len());
        self.incidence.reserve(n, self.pairs.len());
    }

    /// The time since the positions before is another for these particles: a `share` of their way is what they went in that of
    /// the others.
    pub(crate) fn scale_motion(&mut self, particles: Range<usize>, share: f32) {
        let Start { positions, previous, .. } = &mut *self.start;
        for (old, x) in previous[particles.clone()].iter_mut().zip(&positions[particles]) {
            *old = *x + (*old - *x) * share;
        }
    }

    /// Finds the pairs that touch at the end of a substep of `h` `[s]`, and pushes each apart. `fabrics` are of the cloths.
    /// What lies below, along `gravity`, carries what lies on it. `now` and `old`: positions, and those at the start of the
    /// substep, of all particles (`[m]`, `w` inverse mass).
    pub(crate) fn touch(&mut self, h: f32, fabrics: &[Touch], gravity: Vec3, now: &mut [Vec4], old: &mut [Vec4]) {
        let ratio = if self.substep > 0.0 { (h / self.substep) * (h / self.substep) } else { 1.0 };
        self.substep = h;
        let (up, recovery) = (-gravity.normalize_or_zero(), RECOVERY_SPEED * h);
        let Self { pairs, borne, depths, constraints, offsets, newly_inverted, .. } = self;
        *newly_inverted = false;
        debug_assert!(borne.is_sorted_by(|a, b| a.pair < b.pair), "loads are found in the order of pairs");
        constraints.clear();
        let (cloths, mut borne) = (Cloths { offsets, touch: fabrics }, borne.iter().peekable());
        for (i, pair) in (0..).zip(pairs) {
            let load = borne.next_if(|borne| borne.pair == i).map(|borne| borne.load.scaled(ratio)).unwrap_or_default();
            let touched = pair.touch(i, load, &mut Particles { now, old, depths, cloths, up });
            *newly_inverted |= pair.inverted && !pair.was_inverted;
            if let Some(mut constraint) = touched {
                constraint.bring_out(recovery, now, old);
                constraints.push(constraint);
            }
        }
    }

    /// Pushes the pairs that [touch](Self::touch) until pushes have gone around.
    pub(crate) fn solve(&mut self, now: &mut [Vec4], old: &[Vec4]) {
        let Self { borne, start, impacts, constraints, .. } = self;
        constraints.iter_mut().for_each(|constraint| constraint.note_start(old));
        for _ in 1..PASSES {
            constraints.iter_mut().for_each(|constraint| constraint.push_apart(now));
        }
        impacts.clear();
        borne.clear();
        for (i, constraint) in (0..).zip(&mut **constraints) {
            constraint.warm_start(now);
            borne.push(constraint.borne());
            impacts.extend(constraint.impact(|p| start.velocity(p)).map(|apart| (i, apart)));
        }
        debug_assert!(self.is_consistent());
    }

    /// Pushes pairs that touched in the substep apart again, when something has moved them since.
    pub(crate) fn push_apart(&mut self, now: &mut [Vec4]) {
        self.constraints.iter_mut().for_each(|constraint| constraint.push_apart(now));
    }

    /// Whether pairs are of known particles, their weights add up to zero, and normals have a length of one.
    fn is_consistent(&self) -> bool {
        self.borne.iter().all(|borne| (borne.pair as usize) < self.pairs.len())
            && self.bearing().all(|(pair, _)| {
                pair.particles.iter().all(|&p| self.paired.get(p as usize) == Some(&true))
                    && pair.weights.iter().sum::<f32>().abs() < 1.0e-4
                    && (pair.normal.length() - 1.0).abs() < 1.0e-3
            })
    }

    /// Holds pairs that slip, when bodies have pushed, too.
    pub(crate) fn apply_friction(&mut self, now: &mut [Vec4], old: &[Vec4]) {
        let Self { borne, constraints, .. } = self;
        for (constraint, borne) in constraints.iter_mut().zip(borne) {
            constraint.apply_friction(now, old);
            borne.load.tangent_push = constraint.tangent_push;
        }
    }

    /// Gives pairs that met fast in the last substep their speed apart; nothing moves.
    pub(crate) fn apply_restitution(&mut self, now: &[Vec4], old: &mut [Vec4]) {
        let Self { constraints, impacts, .. } = self;
        // There and back, as pairs share particles.
        for _ in 0..RESTITUTION_PASSES {
            for &(i, apart) in impacts.iter().chain(impacts.iter().rev()) {
                constraints[i as usize].apply_restitution(apart * self.substep, now, old);
            }
        }
        impacts.clear();
    }
}

/// Notes that particles are part of a pair.
fn note_paired(paired: &mut [bool], particles: [u32; 4]) {
    particles.iter().for_each(|&p| paired[p as usize] = true);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::detect::ProximityKind;

    #[test]
    fn what_pairs_bear_stays_with_them_when_others_are_forgotten_and_comes_back_when_they_are_found_again() {
        let pair = |v: u32| Contact { particles: [v, 10, 11, 12], ..Contact::bare(ProximityKind::VertexFace, 0.01) };
        let load = |push: f32| Load { push, ..Load::default() };
        let mut contacts = Contacts { paired: vec![true; 13], ..Contacts::default() };
        contacts.loads.fit(13);
        (0..5).for_each(|v| contacts.push(pair(v)));
        contacts.borne.extend([(0, 0.5), (1, 1.5), (3, 3.5)].map(|(pair, push)| Borne { pair, load: load(push) }));
        contacts.forget_all_but(|pair| [1, 2, 3].contains(&pair.particles[0]));
        let bear =
            |contacts: &Contacts| -> Vec<_> { contacts.bearing().map(|(pair, load)| (pair.particles[0], load.push)).collect() };
        assert_eq!(bear(&contacts), [(1, 1.5), (3, 3.5)]);
        [4, 0].into_iter().for_each(|v| contacts.push(pair(v)));
        assert_eq!(bear(&contacts), [(1, 1.5), (3, 3.5), (0, 0.5)]);
        assert_eq!(contacts.borne.iter().map(|borne| borne.pair).collect::<Vec<_>>(), [0, 2, 4]);
    }
}
