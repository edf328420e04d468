//! No pair passes through itself in a substep.
//!
//! ```text
//!   d0   separation along n at the start > 0     n: unit normal of a plane between the two primitives, where they were
//!   d1   separation along n at the end           d1 > 0: never met, since all move on straight lines
//!   else x1 ─► x0 + u + α (x1 - x0 - u)          u: mean motion of the pair by mass
//!                                                α: the share of the approach that leaves what is to be kept of d0
//! ```
//!
//! Dividing planes are those of Offset Geometric Contact (Chen et al. 2025) and of trust regions, asked for only where a pair
//! would cross one. The mean motion is kept, hence momentum too, and a pile falls at any speed. The motion that is cut off is
//! lost, as in a plastic impact. Pairs share particles, so passes are repeated until none cuts anything.
//!
//! Particles of pairs that still cross are truncated at the planes of all their pairs, a margin before each. Both margins
//! together are the gap that is kept, so two truncated particles do not meet. Half spaces are convex, so one share of the way
//! does for all planes. (Offset Geometric Contact, section 3.5, bounds the length of the way. Layers that slide along each
//! other then stop, and more cloths that are pulled off a table jam.) The way is relative to the mean motion of free particles,
//! or of the bodies that some lie on. Momentum is not kept there.
//!
//! Bodies bear the cloth that lies on them. The mean motion of a pair takes none of its particles farther into a body than the
//! body put it.
//!
//! What is held cannot be cut: what meets it moves as it does, and is as held for what it meets in turn. Between two that are
//! held and close, cloth has nowhere to go.

use glam::{Vec3, Vec4};

use super::Contacts;
use super::cloths::offset_between;
use super::contact::Contact;
use super::ground::Ground;
use super::incidence::Incidence;
use crate::solver::detect::ProximityKind;
use crate::solver::detect::four::Four;
use crate::solver::detect::proximity::{closest_edges, vertex_face};
use crate::solver::effort::Effort;
use crate::solver::scales::TOUCHING;

/// Passes in which pairs keep their mean motion, and all.
const MEAN_PASSES: u8 = 6;
const MOST_PASSES: u8 = 30;
/// In place of a pass: a particle moves with what is held, and nothing else moves it.
const WITH_HELD: u8 = u8::MAX;

/// Distance that is kept, as a share of that at the start, and at least [`TOUCHING`] thicknesses. Much closer, the sides could
/// not be told apart.
const KEPT: f32 = 0.2;

impl Contacts {
    /// Shortens the motion of pairs that would pass through each other, from [`Self::note_start`] to `now` (`[m]`, `w` inverse
    /// mass); whether any. Once `effort` is spent on pairs that are asked again, what still passes is truncated at once.
    pub(crate) fn clamp_motion(&mut self, now: &mut [Vec4], effort: &mut Effort) -> bool {
        self.clamp(now, effort, Among::All, |_, _| false)
    }

    /// As [`Self::clamp_motion`] once more in the same substep: only pairs of what moved since the last time are asked.
    pub(crate) fn clamp_motion_again(&mut self, now: &mut [Vec4], effort: &mut Effort) -> bool {
        self.clamp(now, effort, Among::MovedSinceLast, |_, _| false)
    }

    /// As [`Self::clamp_motion`] where few particles move: only pairs of those are asked. Pairs of which both sides are `free`
    /// (particles of the first and of the second) may pass.
    pub(crate) fn clamp_motion_of_few(
        &mut self,
        now: &mut [Vec4],
        effort: &mut Effort,
        free: impl Fn(&[u32], &[u32]) -> bool,
    ) -> bool {
        self.clamp(now, effort, Among::MovedSinceStart, free)
    }

    fn clamp(&mut self, now: &mut [Vec4], effort: &mut Effort, among: Among, free: impl Fn(&[u32], &[u32]) -> bool) -> bool {
        let Self { pairs, paired, offsets, start, clamped, newly_inverted, cut, dividers, incidence, ground, .. } = self;
        let start = start.positions.as_slice();
        let before = match among {
            Among::All => None,
            Among::MovedSinceStart => Some(start),
            // Where the last time gave up, all may pass.
            Among::MovedSinceLast => Some(clamped.as_slice()).filter(|clamped| clamped.len() == now.len()),
        };
        let is_free = |pair: &Contact| {
            let (first, second) = pair.particles.split_at(pair.first());
            free(first, second)
        };
        cut.clear();
        cut.resize(now.len(), 0);
        let mut any = before.is_some_and(|before| before != now);
        let mut ways = Ways { start, now, cut, ground, shared: Vec3::ZERO, pass: u8::from(before.is_none()) };
        let mut dividers = Dividers { pairs, offsets, start, known: dividers, is_free };
        if before.is_none() {
            for i in 0..pairs.len() {
                any |= ways.clamp(i, &mut dividers, incidence);
            }
        }
        let mut is_cut = any && before.is_none();
        if any {
            dividers.known.resize(pairs.len(), Vec4::NAN);
            incidence.list(ways.now.len(), pairs);
            // What did not move meets only what did.
            let is_due = |particle: u32| match before {
                Some(before) => before[particle as usize] != ways.now[particle as usize],
                None => ways.is_new(particle),
            };
            (0..ways.now.len() as u32)
                .filter(|&particle| is_due(particle))
                .for_each(|particle| incidence.ask_again(particle, None));
        }
        while any && ways.pass < MOST_PASSES {
            any = false;
            // The work of the first pass grows with the number of pairs only.
            let is_spent = ways.pass > 0 && effort.is_spent();
            ways.pass = if is_spent { ways.pass.max(MEAN_PASSES) + 1 } else { ways.pass + 1 };
            incidence.turn();
            if ways.pass == MEAN_PASSES + 1 {
                // What lies on bodies can only stay with them.
                ways.shared = ways.ground.mean_way().unwrap_or_else(|| shared_motion(paired, ways.start, ways.now));
            }
            // Only what was cut since a pair was asked can change its answer, and what goes with what is held.
            if ways.pass > MEAN_PASSES {
                ways.cut_in(WITH_HELD).for_each(|particle| incidence.ask_again(particle, None));
            }
            let mut next = 0;
            while let Some(i) = incidence.take(next) {
                next = i;
                if ways.pass > 1 {
                    effort.spend(1);
                }
                if ways.clamp(i, &mut dividers, incidence) {
                    (any, is_cut) = (true, true);
                    let cut = pairs[i].particles.into_iter().filter(|&particle| ways.is_new(particle));
                    cut.for_each(|particle| incidence.ask_again(particle, Some(i)));
                }
            }
        }
        clamped.clear();
        if !any {
            clamped.extend_from_slice(now);
            if core::mem::take(newly_inverted) {
                pairs.iter_mut().for_each(|pair| pair.inverted &= pair.was_inverted);
            }
            return is_cut;
        }
        // Some may have passed all the same; the others did not.
        for pair in pairs.iter_mut().filter(|pair| pair.inverted && !pair.was_inverted) {
            let offset = offset_between(pair.parts, offsets);
            let (from, to) = (pair.points(start, offset), pair.points(now, offset));
            pair.inverted = !divides(dividing(pair, &from), pair.first(), &from, &to);
        }
        true
    }

    /// The particles that were stopped.
    pub(crate) fn stopped(&self) -> impl Iterator<Item = usize> + '_ {
        self.cut.iter().enumerate().filter(|(_, cut)| **cut > 0).map(|(particle, _)| particle)
    }
}

/// Which pairs are asked: all, or those of what moved since the substep began or since they were asked last.
#[derive(Clone, Copy)]
enum Among {
    All,
    MovedSinceStart,
    MovedSinceLast,
}

/// The ways of all particles in a substep.
struct Ways<'a> {
    start: &'a [Vec4],
    now: &'a mut [Vec4],
    /// Pass in which the particle was last stopped; 0: not at all; or [`WITH_HELD`].
    cut: &'a mut [u8],
    /// What lies on bodies.
    ground: &'a Ground,
    /// Mean motion that is left to what is bounded `[m]`.
    shared: Vec3,
    pass: u8,
}

impl Ways<'_> {
    /// The particles that were last stopped in a pass, or [`WITH_HELD`].
    fn cut_in(&self, pass: u8) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(self.cut.iter()).filter(move |(_, cut)| **cut == pass).map(|(particle, _)| particle)
    }

    /// Whether a particle was stopped in this pass.
    fn is_new(&self, particle: u32) -> bool {
        self.cut[particle as usize] >= self.pass
    }

    /// Whether something had to be cut of pair number `i`.
    #[inline]
    fn clamp<F: Fn(&Contact) -> bool>(&mut self, i: usize, dividers: &mut Dividers<'_, F>, incidence: &Incidence) -> bool {
        let pair = &dividers.pairs[i];
        if pair.was_inverted {
            return false;
        }
        let offset = offset_between(pair.parts, dividers.offsets);
        let (from, to) = (pair.points(self.start, offset), pair.points(self.now, offset));
        // Mostly the direction of the contact divides them.
        !divides(pair.normal, pair.first(), &from, &to)
            && !(dividers.is_free)(pair)
            && self.cut(i, [&from, &to], dividers, incidence)
    }

    #[cold]
    fn cut<F: Fn(&Contact) -> bool>(
        &mut self,
        i: usize,
        [from, to]: [&[Vec4; 4]; 2],
        dividers: &mut Dividers<'_, F>,
        incidence: &Incidence,
    ) -> bool {
        let (n, gap) = dividers.of(i);
        let pair = &dividers.pairs[i];
        let first = pair.first();
        // They never meet; or they started in the same place, and have no side to stay on.
        if !(gap > 0.0) || separation(n, first, to) > 0.0 {
            return false;
        }
        let motion: [Vec3; 4] = std::array::from_fn(|i| to[i].truncate() - from[i].truncate());
        let held = [0, 1, 2, 3].map(|i| !(to[i].w > 0.0) || self.cut[pair.particles[i] as usize] == WITH_HELD);
        let any_held = held.contains(&true);
        let at_last = self.pass > MEAN_PASSES;
        let mut mean = if any_held || !at_last { mean_motion(&motion, to, held) } else { self.shared };
        if !any_held && !at_last {
            mean = self.onto_ground(mean, &pair.particles);
        }
        let way = motion.map(|m| n.dot(m - mean));
        let closing = way[..first].iter().map(|w| -w).fold(0.0, f32::max) + way[first..].iter().copied().fold(0.0, f32::max);
        let share = closable(gap, pair.thickness) / closing;
        // NaN passes no comparison.
        if !(closing > 0.0 && (at_last || share < 1.0)) {
            return false;
        }
        let (mut any, goes_along) = (false, at_last && any_held);
        for k in (0..4).filter(|&k| !held[k]) {
            let particle = pair.particles[k] as usize;
            if at_last && !goes_along && self.cut[particle] > MEAN_PASSES {
                // It is truncated already.
                continue;
            }
            let own = motion[k] - mean;
            let left = if goes_along {
                Vec3::ZERO
            } else if at_last {
                dividers.truncate(pair.particles[k], own, incidence)
            } else {
                own * share
            };
            let end = from[k].truncate() + mean + left;
            let is_cut = end != to[k].truncate() && (!at_last || left != own);
            if goes_along || is_cut {
                let offset = if k < first { offset_between(pair.parts, dividers.offsets) } else { Vec3::ZERO };
                self.now[particle] = (end - offset).extend(to[k].w);
                self.cut[particle] = if goes_along { WITH_HELD } else { self.pass };
                any = true;
            }
        }
        any
    }

    /// A `mean` motion `[m]` that takes no particle of a pair farther into a body than that put it.
    fn onto_ground(&self, mut mean: Vec3, particles: &[u32; 4]) -> Vec3 {
        // Twice, as normals at a corner differ.
        for _ in 0..2 {
            for (normal, floor) in particles.iter().flat_map(|&particle| self.ground.of(particle)) {
                let normal = Vec3::from(normal);
                mean += normal * (floor - normal.dot(mean)).max(0.0);
            }
        }
        mean
    }
}

/// What divided the primitives of all pairs when the substep began.
struct Dividers<'a, F> {
    pairs: &'a [Contact],
    /// From the frame of simulation of each cloth to that of the island `[m]`.
    offsets: &'a [Vec3],
    start: &'a [Vec4],
    /// For each pair, the unit normal of a plane between the two primitives, and in `w` how far they are apart along it `[m]`.
    /// Not a number for pairs that were not asked for, and empty until one is asked for again.
    known: &'a mut Vec<Vec4>,
    /// Whether a pair may pass.
    is_free: F,
}

impl<F: Fn(&Contact) -> bool> Dividers<'_, F> {
    /// The unit normal of a plane between the primitives of pair number `i`, and how far they are apart along it `[m]`.
    fn of(&mut self, i: usize) -> (Vec3, f32) {
        if let Some(known) = self.known.get(i).filter(|known| !known.w.is_nan()) {
            return (known.truncate(), known.w);
        }
        let pair = &self.pairs[i];
        let from = self.points(pair);
        let n = dividing(pair, &from);
        let gap = separation(n, pair.first(), &from);
        if let Some(known) = self.known.get_mut(i) {
            *known = n.extend(gap);
        }
        (n, gap)
    }

    /// What is left of the `own` way `[m]` of a particle, so that it stays on its side of what divides any of its pairs.
    fn truncate(&mut self, particle: u32, own: Vec3, incidence: &Incidence) -> Vec3 {
        let mut share = 1.0f32;
        for i in incidence.of(particle) {
            let pair = &self.pairs[i];
            if pair.was_inverted || (self.is_free)(pair) {
                continue;
            }
            let (n, gap) = self.of(i);
            let Some(k) = pair.particles.iter().position(|&p| p == particle).filter(|_| gap > 0.0) else { continue };
            let first = pair.first();
            let margin = 0.5 * (gap - closable(gap, pair.thickness));
            let room = (room(n, k, first, &self.points(pair)) - margin).max(0.0);
            let towards = if k < first { -n.dot(own) } else { n.dot(own) };
            if towards > room {
                share = share.min(room / towards);
            }
        }
        own * share
    }

    /// Where a pair was when the substep began `[m]`.
    fn points(&self, pair: &Contact) -> [Vec4; 4] {
        pair.points(self.start, offset_between(pair.parts, self.offsets))
    }
}

/// Whether a plane with unit normal `n` divides the two primitives all the way.
#[inline]
fn divides(n: Vec3, first: usize, from: &[Vec4; 4], to: &[Vec4; 4]) -> bool {
    separation(n, first, from) > 0.0 && separation(n, first, to) > 0.0
}

/// How far the first primitive, `first` points, lies beyond the second along `n` `[m]`; of what is not a number nothing is
/// known.
#[inline]
fn separation(n: Vec3, first: usize, points: &[Vec4; 4]) -> f32 {
    let (low, high) = facing(Four::of(*points).dot(Four::splat(n.into())).to_array(), first);
    low - high
}

/// The lowest of the first primitive, and the highest of the second, of heights of their points `[m]`.
#[inline]
fn facing([a, b, c, d]: [f32; 4], first: usize) -> (f32, f32) {
    let (low, high) = (f32::INFINITY.min(a), f32::NEG_INFINITY.max(c).max(d));
    if first == 1 { (low, high.max(b)) } else { (low.min(b), high) }
}

/// How far point `k` is from the plane with normal `n` halfway between the two primitives `[m]`.
fn room(n: Vec3, k: usize, first: usize, points: &[Vec4; 4]) -> f32 {
    let heights = points.map(|x| n.dot(x.truncate()));
    let (low, high) = facing(heights, first);
    let height = heights[k] - 0.5 * (low + high);
    if k < first { height } else { -height }
}

/// Unit normal of a plane between the two primitives. Where the closest points are inside, it is that of the face, or across
/// both edges, which stays exact however close they are. Else it points from one closest point to the other.
fn dividing(pair: &Contact, from: &[Vec4; 4]) -> Vec3 {
    let at = from.map(|x| x.truncate() - from[0].truncate());
    let [p, q, r, s] = at;
    let (near, inside, across) = match pair.kind {
        ProximityKind::VertexFace => {
            let near = vertex_face([0, 1, 2, 3], |i| at[i as usize]);
            (near, near.weights[1..].iter().all(|w| *w < 0.0), (r - q).cross(s - q))
        }
        ProximityKind::EdgeEdge => {
            let near = closest_edges([0, 1, 2, 3], |i| at[i as usize]);
            (near, near.weights.iter().all(|w| *w != 0.0), (q - p).cross(s - r))
        }
    };
    let side = across.dot(p - r);
    let across = across.normalize_or_zero();
    if inside && across != Vec3::ZERO && side != 0.0 {
        return across * side.signum();
    }
    let delta: Vec3 = (0..4).map(|i| at[i] * near.weights[i]).sum();
    delta.try_normalize().unwrap_or(pair.normal)
}

/// How much of a `gap` of a pair may close in a substep, both `[m]`.
#[inline]
fn closable(gap: f32, thickness: f32) -> f32 {
    (gap - (KEPT * gap).max(TOUCHING * thickness)).max(0.0)
}

/// Mean motion by mass `[m]`; of what is held if something is.
fn mean_motion(motion: &[Vec3; 4], to: &[Vec4; 4], held: [bool; 4]) -> Vec3 {
    let any_held = held.contains(&true);
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for ((motion, x), held) in motion.iter().zip(to).zip(held) {
        let mass = if any_held { f32::from(held) } else { 1.0 / x.w };
        sum += *motion * mass;
        total += mass;
    }
    sum / total
}

/// Mean motion by mass of all that is free and part of a pair `[m]`.
fn shared_motion(paired: &[bool], start: &[Vec4], now: &[Vec4]) -> Vec3 {
    let (mut sum, mut mass) = (Vec3::ZERO, 0.0);
    for ((now, start), _) in now.iter().zip(start).zip(paired).filter(|((now, _), paired)| **paired && now.w > 0.0) {
        let way = (*now - *start).truncate() / now.w;
        if way.is_finite() {
            (sum, mass) = (sum + way, mass + now.w.recip());
        }
    }
    if mass > 0.0 { sum / mass } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use glam::{Vec3A, vec3};

    use super::*;

    /// A particle over or beside a face, or two edges, at random, and where they would go.
    fn pair(rng: &mut fastrand::Rng, kind: ProximityKind) -> (Contact, Vec<Vec4>, Vec<Vec4>) {
        let mut point = |size: f32| (vec3(rng.f32(), rng.f32(), rng.f32()) - 0.5) * size;
        let from: Vec<Vec3> = (0..4).map(|_| point(1.0)).collect();
        let to: Vec<Vec3> = from.iter().map(|x| *x + point(3.0)).collect();
        let pair = Contact::bare(kind, 0.01);
        let mass = |x: &Vec3| x.extend(1.0);
        (pair, from.iter().map(mass).collect(), to.iter().map(mass).collect())
    }

    impl Contacts {
        /// These pairs, at the start of a substep.
        fn of_pairs(pairs: &[Contact], start: &[Vec4]) -> Self {
            let mut contacts = Self { pairs: pairs.to_vec(), paired: vec![true; start.len()], ..Self::default() };
            contacts.note_start(start, start, 0.0);
            contacts
        }
    }

    fn effort() -> Effort {
        Effort::UNBOUNDED
    }

    /// Signed volume of the tetrahedron: its sign changes where the four meet in a plane.
    fn volume(x: &[Vec4]) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| x[i].truncate().as_dvec3());
        (b - a).cross(c - a).dot(d - a)
    }

    /// How far apart the two primitives are `[m]`.
    fn distance(kind: ProximityKind, x: &[Vec4]) -> f32 {
        let at = |i: u32| x[i as usize].truncate();
        match kind {
            ProximityKind::VertexFace => vertex_face([0, 1, 2, 3], at).distance,
            ProximityKind::EdgeEdge => closest_edges([0, 1, 2, 3], at).distance,
        }
    }

    #[test]
    fn what_a_pin_pushes_takes_along_what_it_meets_in_turn() {
        let triangle = |size: f32, z: f32| [vec3(-size, -size, z), vec3(size, -size, z), vec3(0.0, size, z)];
        let start: Vec<Vec4> = [(1.0, 0.0), (5.0, -0.1), (25.0, -0.2)]
            .iter()
            .flat_map(|&(size, z)| triangle(size, z).map(|x| x.extend(1.0)))
            .chain([vec3(0.0, 0.0, 0.1).extend(0.0)])
            .collect();
        let mut now = start.clone();
        now[9].z -= 2.0;
        let on = |particle: u32, face: u32| Contact {
            particles: [particle, face, face + 1, face + 2],
            ..Contact::bare(ProximityKind::VertexFace, 0.01)
        };
        let pairs = [(9, 0), (0, 3), (1, 3), (2, 3), (3, 6), (4, 6), (5, 6)].map(|(particle, face)| on(particle, face));
        let mut contacts = Contacts::of_pairs(&pairs, &start);
        assert!(contacts.clamp_motion(&mut now, &mut effort()));
        let height = |i: usize| now[i].z;
        assert_eq!(height(9), -1.9, "a pin goes where it is told");
        for (below, above) in [(0..3, 9..10), (3..6, 0..3), (6..9, 3..6)] {
            let (highest, lowest) = (below.map(height).fold(f32::MIN, f32::max), above.map(height).fold(f32::MAX, f32::min));
            assert!(highest < lowest, "{highest} is not below {lowest}");
        }
    }

    #[test]
    fn what_falls_on_cloth_that_lies_on_a_body_does_not_push_it_in() {
        let face = [vec3(-1.0, 0.0, -1.0), vec3(1.0, 0.0, -1.0), vec3(0.0, 0.0, 1.0)];
        let start: Vec<Vec4> = [vec3(0.0, 0.1, 0.0)].iter().chain(&face).map(|x| x.extend(1.0)).collect();
        for lies in [false, true] {
            let mut now = start.clone();
            now[0].y -= 2.0;
            let mut contacts = Contacts::of_pairs(&[Contact::bare(ProximityKind::VertexFace, 0.01)], &start);
            if lies {
                (1..4).for_each(|v| contacts.ground.add(v, Vec3A::Y, Vec3A::ZERO, Vec3A::ZERO));
            }
            assert!(contacts.clamp_motion(&mut now, &mut effort()));
            let height = |i: usize| now[i].y;
            let (lowest, highest) = (1..4).map(height).fold((f32::MAX, f32::MIN), |(a, b), y| (a.min(y), b.max(y)));
            assert!(height(0) > highest, "{} is not above {highest}", height(0));
            assert_eq!(lowest < -0.1, !lies, "{lowest}");
        }
    }

    #[test]
    fn layers_that_are_squeezed_keep_their_order_and_go_on() {
        // Five layers of 3 particles, the outer ones squeezed together, those between flung about.
        let mut rng = fastrand::Rng::with_seed(11);
        for _ in 0..200 {
            let triangle = |size: f32, z: f32| [vec3(-size, -size, z), vec3(size, -size, z), vec3(0.0, size, z)];
            let start: Vec<Vec4> =
                (0..5u8).map(f32::from).flat_map(|i| triangle(1.0 + i, 0.1 * i)).map(|x| x.extend(1.0)).collect();
            let way = |i: usize, fling: f32| {
                if i < 3 {
                    0.5
                } else if i < 12 {
                    fling
                } else {
                    -0.5
                }
            };
            let mut now: Vec<Vec4> =
                start.iter().enumerate().map(|(i, x)| *x + Vec4::Z * way(i, 2.0 * rng.f32() - 1.0)).collect();
            let on = |particle: u32, face: u32| Contact {
                particles: [particle, face, face + 1, face + 2],
                ..Contact::bare(ProximityKind::VertexFace, 0.01)
            };
            let pairs: Vec<_> = (0..4).flat_map(|layer| (0..3).map(move |k| on(3 * layer + k, 3 * layer + 3))).collect();
            assert!(Contacts::of_pairs(&pairs, &start).clamp_motion(&mut now, &mut effort()));
            for layer in 0..4 {
                let face = |k: usize| now[3 * layer + 3 + k].truncate();
                let normal = (face(1) - face(0)).cross(face(2) - face(0));
                for k in 0..3 {
                    let above = normal.dot(now[3 * layer + k].truncate() - face(0));
                    assert!(above < 0.0, "layer {layer} is through");
                }
            }
            let moved = now.iter().zip(&start).filter(|(a, b)| a.distance(**b) > 1.0e-3).count();
            assert!(moved > 10, "only {moved} of 15 moved");
        }
    }

    /// A particle between two faces that are not quite parallel. Whatever its way, it stays on its side of both. Along them it
    /// goes on.
    #[test]
    fn what_is_truncated_stays_on_its_side_and_goes_on_along_it() {
        let mut rng = fastrand::Rng::with_seed(17);
        let face = |z: f32, slope: f32| [(-9.0, -9.0), (9.0, -9.0), (0.0, 9.0)].map(|(x, y)| vec3(x, y, z + slope * x));
        for _ in 0..1_000 {
            let mut slope = || 0.002 * (rng.f32() - 0.5);
            let faces = [face(-0.01, slope()), face(0.01, slope())];
            let start: Vec<Vec4> = [Vec3::ZERO].iter().chain(faces.as_flattened()).map(|x| x.extend(1.0)).collect();
            let on = |face: u32| Contact {
                particles: [0, face, face + 1, face + 2],
                ..Contact::bare(ProximityKind::VertexFace, 0.01)
            };
            let pairs = [on(1), on(4)];
            let (mut incidence, mut known) = (Incidence::default(), vec![Vec4::NAN; 2]);
            incidence.list(start.len(), &pairs);
            let is_free = |_: &Contact| false;
            let mut dividers = Dividers { pairs: &pairs, offsets: &[], start: &start, known: &mut known, is_free };
            let steep = if rng.bool() { 1.0 } else { 0.005 };
            let way = vec3(rng.f32() - 0.5, rng.f32() - 0.5, steep * (rng.f32() - 0.5));
            let left = dividers.truncate(0, way, &incidence);
            for face in faces {
                let normal = (face[1] - face[0]).cross(face[2] - face[0]).normalize();
                let [before, after] = [Vec3::ZERO, left].map(|x| normal.dot(x - face[0]));
                assert!(before * after > 0.0 && after.abs() > 0.59 * before.abs(), "{way} became {left}: {before}, {after}");
            }
            assert!(steep == 1.0 || left.distance(way) < 0.01, "{way} became {left}");
        }
    }

    #[test]
    fn pairs_of_what_moved_are_clamped_as_all_pairs_are() {
        let mut rng = fastrand::Rng::with_seed(13);
        let mut cut = 0;
        for _ in 0..500 {
            let mut point = |size: f32| (vec3(rng.f32(), rng.f32(), rng.f32()) - 0.5) * size;
            let start: Vec<Vec4> = (0..24).map(|_| point(1.0).extend(1.0)).collect();
            let end: Vec<Vec4> = (0..24).map(|i| start[i] + if i < 4 { point(2.0).extend(0.0) } else { Vec4::ZERO }).collect();
            let mut all: [u32; 24] = core::array::from_fn(|i| i as u32);
            let pairs: Vec<Contact> = (0..40)
                .map(|n| {
                    let kind = if n % 2 == 0 { ProximityKind::VertexFace } else { ProximityKind::EdgeEdge };
                    rng.shuffle(&mut all);
                    Contact { particles: [all[0], all[1], all[2], all[3]], ..Contact::bare(kind, 0.01) }
                })
                .collect();
            let clamped = |few: bool| {
                let (mut now, mut contacts) = (end.clone(), Contacts::of_pairs(&pairs, &start));
                let any = if few {
                    contacts.clamp_motion_of_few(&mut now, &mut effort(), |_, _| false)
                } else {
                    contacts.clamp_motion(&mut now, &mut effort())
                };
                (any, now, contacts.stopped().collect::<Vec<_>>())
            };
            let all = clamped(false);
            assert_eq!(clamped(true), all);
            cut += all.2.len();
        }
        assert!(cut > 500, "{cut}");
    }

    #[test]
    fn pairs_of_what_moved_since_are_clamped_as_all_pairs_are() {
        let mut rng = fastrand::Rng::with_seed(19);
        let (mut cut, mut known) = (0, 0);
        for _ in 0..500 {
            let mut point = |size: f32| (vec3(rng.f32(), rng.f32(), rng.f32()) - 0.5) * size;
            // Two of them are pins.
            let start: Vec<Vec4> = (0..24_u8).map(|i| point(1.0).extend(f32::from(i > 1))).collect();
            let end: Vec<Vec4> = start.iter().map(|x| *x + point(0.5).extend(0.0)).collect();
            let then: Vec<Vec4> = (0..24).map(|i| if i < 4 { point(1.0).extend(0.0) } else { Vec4::ZERO }).collect();
            let mut all: [u32; 24] = core::array::from_fn(|i| i as u32);
            let pairs: Vec<Contact> = (0..20)
                .map(|n| {
                    let kind = if n % 2 == 0 { ProximityKind::VertexFace } else { ProximityKind::EdgeEdge };
                    rng.shuffle(&mut all);
                    Contact { particles: [all[0], all[1], all[2], all[3]], ..Contact::bare(kind, 0.01) }
                })
                .collect();
            let mut clamped = |again: bool| {
                let (mut now, mut contacts) = (end.clone(), Contacts::of_pairs(&pairs, &start));
                contacts.clamp_motion(&mut now, &mut effort());
                known += u32::from(!contacts.clamped.is_empty());
                now.iter_mut().zip(&then).for_each(|(x, by)| *x += *by);
                let any = if again {
                    contacts.clamp_motion_again(&mut now, &mut effort())
                } else {
                    contacts.clamp_motion(&mut now, &mut effort())
                };
                (any, now, contacts.stopped().collect::<Vec<_>>())
            };
            let all = clamped(false);
            assert_eq!(clamped(true), all);
            cut += all.2.len();
        }
        assert!(cut > 500 && known > 900, "{cut} {known}");
    }

    #[test]
    fn pairs_of_two_frames_of_simulation_are_stopped_where_they_are() {
        let mut rng = fastrand::Rng::with_seed(9);
        let offset = vec3(0.5, -1.0, 0.25);
        let mut cut = 0;
        for n in 0..2_000 {
            let kind = if n % 2 == 0 { ProximityKind::VertexFace } else { ProximityKind::EdgeEdge };
            let (pair, start, end) = pair(&mut rng, kind);
            let elsewhere = |x: &[Vec4], by: Vec3| -> Vec<Vec4> {
                let is_first = |i: usize| i < pair.first();
                x.iter().enumerate().map(|(i, x)| if is_first(i) { *x + by.extend(0.0) } else { *x }).collect()
            };
            let mut now = end.clone();
            Contacts::of_pairs(&[pair], &start).clamp_motion(&mut now, &mut effort());
            let mut own = elsewhere(&end, -offset);
            let mut apart = Contacts::of_pairs(&[pair], &elsewhere(&start, -offset));
            apart.set_offsets([offset, Vec3::ZERO].into_iter());
            apart.clamp_motion(&mut own, &mut effort());
            let farthest = elsewhere(&own, offset).iter().zip(&now).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            assert!(farthest < 1.0e-4, "{n} {kind:?}: {farthest}");
            cut += u32::from(now != end);
        }
        assert!(cut > 200, "{cut}");
    }

    #[test]
    fn nothing_meets_on_its_way_and_momentum_is_kept() {
        let mut rng = fastrand::Rng::with_seed(7);
        let (mut cut, mut met) = (0, 0);
        for n in 0..20_000 {
            let kind = if n % 2 == 0 { ProximityKind::VertexFace } else { ProximityKind::EdgeEdge };
            let (pair, start, end) = pair(&mut rng, kind);
            let apart = distance(kind, &start);
            if apart < 2e-3 {
                continue;
            }
            let nearest = |to: &[Vec4]| {
                let at =
                    |i: u16| -> Vec<Vec4> { start.iter().zip(to).map(|(a, b)| a.lerp(*b, f32::from(i) / 400.0)).collect() };
                (0..=400).map(|i| distance(kind, &at(i))).fold(f32::INFINITY, f32::min)
            };
            let passes = |to: &[Vec4]| nearest(to) < 2e-3 && volume(&start) * volume(to) < 0.0;
            met += u32::from(passes(&end));
            let mut now = end.clone();
            Contacts::of_pairs(&[pair], &start).clamp_motion(&mut now, &mut effort());
            if now == end {
                assert!(!passes(&now), "{n} {kind:?}");
            } else {
                let nearest = nearest(&now);
                assert!(nearest > 0.99 * KEPT * apart, "{n} {kind:?}: {nearest} left of {apart}");
            }
            cut += u32::from(now != end);
            let momentum = |x: &[Vec4]| x.iter().map(|x| x.truncate()).sum::<Vec3>();
            assert!(momentum(&now).distance(momentum(&end)) < 1e-4);
        }
        assert!(met > 500 && cut >= met, "{met} of which would have met, {cut} cut");
    }
}
