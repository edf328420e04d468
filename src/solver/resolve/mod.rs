//! Resolve: take crossing surfaces apart.
//!
//! ```text
//! crossings ─► contour graph ─► what was decided for each contour ─► displacements, capped ─► positions and previous together
//! ```
//!
//! One call to [`Resolver::advance`] is one iteration: it moves every tangled particle by at most a fraction of an edge and leaves the
//! cloth to its springs. Positions and previous positions move together, so untangling injects no velocity; what is left of the motion
//! of both sides into each other is taken out as in an inelastic collision.
//!
//! | end type | first | when that makes no progress |
//! |---|---|---|
//! | Closed, Eight, BIBI, BLI, unknown; BBII whose gradients agree | shrink | push, shrink, ..., peel |
//! | BBII, Cross | push | shrink, push, ..., peel |
//! | LL | peel | shrink, peel, ... |

pub mod contour;
pub mod gradient;
pub mod history;
pub mod latch;
pub mod region;

pub use contour::{Contour, ContourGraph, ContourKind};
pub use latch::Strategy;

use glam::{DVec3, Vec3, Vec4};

use crate::solver::detect::{Crossing, Detector, Surface};
use crate::solver::evaluate::Verdict;
use crate::solver::rest::NONE;

use gradient::Terms;
use history::{History, Push};
use latch::Latches;
use region::{Flood, Region};

/// A contour that ends inside a sheet is prolonged to the border over at most this fraction of its length.
const PROLONG: f32 = 1.0;
/// A contour that cuts a sheet in two is shrunk all the same while its gradients agree at least so far.
const COHERENT: f64 = 0.6;
/// Passes of smoothing along the contour when it is peeled.
const PASSES: usize = 16;
/// Most rings that shrinking moves.
const MOST_RINGS: usize = 1000;
/// Most rings that peeling moves.
const PEEL_RINGS: f32 = 8.0;

/// How crossing surfaces are taken apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// The traditional method (1995): remember on which side of each other particles and faces were, and push them back there.
    History,
    /// Each crossing on its own follows the gradient of the contour's length (Volino and Magnenat-Thalmann 2006).
    LocalGradient,
    /// One summed gradient per contour (Wen et al. 2009).
    GlobalGradient,
    /// Per contour, by how it ends: summed gradient with the exact vertex gradient, region push, or gradient along stretches; another of
    /// these when one makes no progress.
    #[default]
    ByEndType,
}

/// Tunables of resolving.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolveSettings {
    /// The method.
    pub method: Method,
    /// Largest displacement of a particle per iteration, as a fraction of the mean edge, of each side when both are equally heavy.
    /// Default 0.1. Smaller is slower; much larger overshoots and folds triangles over.
    pub step: f32,
    /// Iterations without progress after which a contour's strategy is changed; doubled with every change. Default 10.
    pub patience: u32,
    /// Largest growth of the step of a contour that keeps moving in one direction. Default 5. More is faster on deep tangles and tears at
    /// the edges around a pushed region; 1 keeps every step the same.
    pub pace: f32,
    /// How far the motion of a shrinking contour spreads into its sheets, as a fraction of its length. Default 0.5. 0 moves only the
    /// particles at the contour, which the rest of a fine sheet holds back.
    pub spread: f32,
}

impl Default for ResolveSettings {
    fn default() -> Self {
        Self { method: Method::default(), step: 0.1, patience: 10, pace: 5.0, spread: 0.5 }
    }
}

/// Takes tangles apart, one iteration per call. Buffers are reused; nothing is allocated once warm.
#[derive(Clone, Debug, Default)]
pub struct Resolver {
    graph: ContourGraph,
    latches: Latches,
    flood: Flood,
    terms: Vec<Terms>,
    points: Vec<Vec3>,
    pulls: Vec<Vec3>,
    smooth: Vec<Vec3>,
    along: Vec<Vec3>,
    shift: Shift,
    brake: Shift,
    patch: Patch,
    history: History,
    pushes: Vec<Push>,
}

/// Displacements being summed.
#[derive(Clone, Debug, Default)]
struct Shift {
    /// Displacement and cap [m] per particle.
    of: Vec<Vec4>,
    touched: Vec<u32>,
}

impl Shift {
    fn add(&mut self, particle: u32, by: Vec3, cap: f32) {
        let shift = &mut self.of[particle as usize];
        if *shift == Vec4::ZERO {
            self.touched.push(particle);
        }
        *shift = (shift.truncate() + by).extend(shift.w.max(cap));
    }

    /// Moves both arrays by the capped displacements and forgets them.
    fn apply(&mut self, positions: &mut [Vec4], previous: &mut [Vec4]) {
        for &v in &self.touched {
            let v = v as usize;
            let shift = core::mem::take(&mut self.of[v]);
            if positions[v].w == 0.0 {
                continue;
            }
            let by = shift.truncate().clamp_length_max(shift.w).extend(0.0);
            if by.is_finite() {
                positions[v] += by;
                previous[v] += by;
            }
        }
        self.touched.clear();
    }

    /// Takes the displacements off the previous positions only: they become changes of velocity per substep.
    fn apply_to_velocity(&mut self, positions: &[Vec4], previous: &mut [Vec4]) {
        for &v in &self.touched {
            let by = core::mem::take(&mut self.of[v as usize]).truncate();
            if positions[v as usize].w > 0.0 && by.is_finite() {
                previous[v as usize] -= by.extend(0.0);
            }
        }
        self.touched.clear();
    }
}

/// The particles of the two sides of a contour.
#[derive(Clone, Debug, Default)]
struct Patch {
    seen: Vec<[u32; 2]>,
    /// Ring in which a particle was added to each side.
    ring: Vec<[u16; 2]>,
    now: u16,
    stamp: u32,
    sides: [Vec<u32>; 2],
    /// End of the contour's own particles, then of each ring around them.
    ring_end: [Vec<u32>; 2],
}

impl Patch {
    fn gather(&mut self, surface: &Surface, crossings: &[Crossing], graph: &ContourGraph, contour: usize) {
        self.seen.resize(surface.len(), [0; 2]);
        self.ring.resize(surface.len(), [0; 2]);
        self.now = 0;
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.seen.fill([0; 2]);
            self.stamp = 1;
        }
        for side in &mut self.sides {
            side.clear();
        }
        for &i in graph.nodes_of(contour) {
            let c = &crossings[i as usize];
            let side = usize::from(graph.side[i as usize]);
            for v in surface.topology.edges[c.edge as usize] {
                self.put(side, v);
            }
            for v in surface.topology.faces[c.face as usize] {
                self.put(1 - side, v);
            }
        }
    }

    /// Adds rings of neighbours around both sides at once; a particle falls to the side that is nearer.
    fn grow(&mut self, surface: &Surface, rings: usize) {
        let mut first = [0; 2];
        for side in 0..2 {
            self.ring_end[side].clear();
            self.ring_end[side].push(self.sides[side].len() as u32);
        }
        for _ in 0..rings {
            self.now += 1;
            for (side, first) in first.iter_mut().enumerate() {
                let last = self.sides[side].len();
                for k in *first..last {
                    let v = self.sides[side][k];
                    for &(u, _) in surface.topology.around(v) {
                        if self.seen[u as usize][1 - side] != self.stamp {
                            self.put(side, u);
                        }
                    }
                }
                *first = last;
                self.ring_end[side].push(self.sides[side].len() as u32);
            }
        }
    }

    fn put(&mut self, side: usize, v: u32) {
        let seen = &mut self.seen[v as usize][side];
        if *seen != self.stamp {
            *seen = self.stamp;
            self.ring[v as usize][side] = self.now;
            self.sides[side].push(v);
        }
    }

    /// The ring of a particle on a side: 0 at the contour itself.
    fn order(&self, side: usize, v: u32) -> Option<usize> {
        (self.seen[v as usize][side] == self.stamp).then_some(usize::from(self.ring[v as usize][side]))
    }
}

/// How much each of two bodies moves, sum 2, from their masses: the lighter moves more, one that holds pins only when the other does too.
fn shares(masses: [Load; 2]) -> [f32; 2] {
    let yields = |l: Load| l.mass > 0.0;
    match (yields(masses[0]), yields(masses[1])) {
        (false, false) => [0.0, 0.0],
        (true, false) => [2.0, 0.0],
        (false, true) => [0.0, 2.0],
        (true, true) => match (masses[0].pinned, masses[1].pinned) {
            (false, true) => [2.0, 0.0],
            (true, false) => [0.0, 2.0],
            _ => {
                let sum = masses[0].mass + masses[1].mass;
                [2.0 * masses[1].mass / sum, 2.0 * masses[0].mass / sum]
            }
        },
    }
}

/// Mass [kg] of the free particles of a body, and whether some are pinned.
#[derive(Clone, Copy, Debug, Default)]
struct Load {
    mass: f32,
    pinned: bool,
}

fn load(positions: &[Vec4], particles: impl IntoIterator<Item = u32>) -> Load {
    let mut sum = Load::default();
    for v in particles {
        let w = positions[v as usize].w;
        if w > 0.0 {
            sum.mass += w.recip();
        } else {
            sum.pinned = true;
        }
    }
    sum
}

/// How far the gradients along a contour agree: 1 where all pull one way, 0 where they cancel.
fn coherence(graph: &ContourGraph, terms: &[Terms], contour: usize) -> f64 {
    let (mut sum, mut size) = (DVec3::ZERO, 0.0);
    for &i in graph.nodes_of(contour) {
        let pull = terms[i as usize].pull();
        sum += if graph.side[i as usize] == 0 { pull } else { -pull };
        size += pull.length();
    }
    if size > 0.0 { sum.length() / size } else { 0.0 }
}

/// `d = step g / sqrt(|g|² + 1)`
fn saturate(g: DVec3, step: f32) -> Vec3 {
    (g / (g.length_squared() + 1.0).sqrt()).as_vec3() * step
}

impl Resolver {
    /// Traces the contours of the crossings; call it before [`Self::advance`].
    pub fn analyse(&mut self, surface: &Surface, crossings: &[Crossing], positions: &[Vec4]) -> Verdict {
        let at = |v: u32| positions[v as usize].truncate().as_dvec3();
        self.terms.clear();
        self.terms.extend(crossings.iter().map(|c| Terms::new(&surface.topology, c, gradient::BOUND, at)));
        self.points.clear();
        self.points.extend(self.terms.iter().map(|t| t.point.as_vec3()));
        self.graph.trace(surface, crossings, &self.points, |v| positions[v as usize].truncate());
        Verdict::of(&self.graph, crossings)
    }

    /// The contours traced last.
    #[must_use]
    pub fn graph(&self) -> &ContourGraph {
        &self.graph
    }

    /// The points [m] of the crossings analysed last.
    #[must_use]
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// What is being done about each contour of [`Self::graph`].
    pub fn strategies(&self) -> impl Iterator<Item = Strategy> + '_ {
        self.latches.now.iter().map(|l| l.strategy)
    }

    /// One iteration on the crossings analysed last: moves `positions` and `previous` together.
    pub fn advance(
        &mut self,
        surface: &Surface,
        detector: &mut Detector,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        settings: &ResolveSettings,
    ) {
        if positions.len() != surface.len() || previous.len() != surface.len() {
            return;
        }
        self.shift.of.resize(surface.len(), Vec4::ZERO);
        self.brake.of.resize(surface.len(), Vec4::ZERO);
        if settings.method == Method::History {
            self.remember(surface, detector, positions, settings.step);
            self.shift.apply(positions, previous);
            return;
        }
        if self.graph.contours.is_empty() {
            self.latches.clear();
            return;
        }
        let by_type = settings.method == Method::ByEndType;
        let (graph, terms) = (&self.graph, &self.terms);
        self.latches.carry(detector.crossings(), graph, 2.0 * surface.mean_edge, |k| match graph.contours[k].kind {
            ContourKind::Cross if by_type => Strategy::Push,
            ContourKind::Bbii if by_type && coherence(graph, terms, k) < COHERENT => Strategy::Push,
            ContourKind::Ll if by_type => Strategy::Peel,
            _ => Strategy::Shrink,
        });
        for latch in self.latches.now.iter_mut().filter(|_| by_type) {
            // A region needs a while to gather pace, the longer the more edges it hangs on.
            let edges = if latch.strategy == Strategy::Push { latch.longest / surface.mean_edge } else { 0.0 };
            if latch.stale > (settings.patience + edges as u32 / 4) << latch.turns.min(4) {
                let pushable =
                    matches!(latch.kind, ContourKind::Bbii | ContourKind::Cross | ContourKind::Bibi | ContourKind::Closed);
                latch.turn_to(match latch.strategy {
                    Strategy::Shrink if pushable => Strategy::Push,
                    Strategy::Push if latch.turns % 4 != 3 => Strategy::Shrink,
                    Strategy::Shrink | Strategy::Push => Strategy::Peel,
                    Strategy::Peel => Strategy::Shrink,
                });
            }
        }
        for k in 0..self.graph.contours.len() {
            let crossings = detector.crossings();
            let step = settings.step * self.mean_edge(surface, crossings, k);
            match settings.method {
                Method::History => {}
                Method::LocalGradient => self.shrink_each(surface, crossings, positions, k, step),
                Method::GlobalGradient => self.shrink(surface, crossings, positions, k, step, false, settings),
                Method::ByEndType if self.latches.now[k].strategy == Strategy::Peel => {
                    self.peel(surface, crossings, positions, k, settings.pace * step, settings);
                }
                Method::ByEndType => {
                    let pushed = self.latches.now[k].strategy == Strategy::Push
                        && self.push(surface, crossings, positions, k, step, settings);
                    if !pushed {
                        self.shrink(surface, crossings, positions, k, step, true, settings);
                    }
                    self.stop_approach(surface, crossings, positions, previous, k);
                }
            }
        }
        self.brake.apply_to_velocity(positions, previous);
        self.shift.apply(positions, previous);
    }

    /// The traditional method.
    fn remember(&mut self, surface: &Surface, detector: &mut Detector, positions: &[Vec4], step: f32) {
        let thickness = surface.parts.iter().map(|p| p.thickness).fold(0.0, f32::max);
        let reach = thickness + 0.5 * surface.mean_edge;
        self.history.pushes(surface, detector, positions, reach, thickness, &mut self.pushes);
        for &(v, by) in &self.pushes {
            self.shift.add(v, by, step * surface.mean_edge);
        }
    }

    /// Removes the velocity with which the two sides of a contour run deeper into each other, and no other. The exchange is that of a
    /// perfectly inelastic collision along the direction of separation: momentum stays, energy does not grow.
    fn stop_approach(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        previous: &[Vec4],
        contour: usize,
    ) {
        let latch = self.latches.now[contour];
        let out = latch.heading.normalize_or_zero();
        let first = if latch.strategy == Strategy::Push && latch.side == 1 { 1 } else { 0 };
        self.patch.gather(surface, crossings, &self.graph, contour);
        let velocity = |side: usize| {
            let (mut sum, mut mass) = (Vec3::ZERO, 0.0);
            for &v in &self.patch.sides[side] {
                let v = v as usize;
                let m = if positions[v].w > 0.0 { positions[v].w.recip() } else { 0.0 };
                sum += m * (positions[v] - previous[v]).truncate();
                mass += m;
            }
            if mass > 0.0 { sum / mass } else { Vec3::ZERO }
        };
        let approach = -(velocity(first) - velocity(1 - first)).dot(out);
        if approach.is_nan() || approach <= 0.0 {
            return;
        }
        let share = shares([first, 1 - first].map(|s| load(positions, self.patch.sides[s].iter().copied())));
        for (k, side) in [first, 1 - first].into_iter().enumerate() {
            let by = 0.5 * share[k] * approach * if k == 0 { out } else { -out };
            for &v in &self.patch.sides[side] {
                self.brake.add(v, by, 0.0);
            }
        }
    }

    /// Mean rest length [m] of the edges of a contour.
    fn mean_edge(&self, surface: &Surface, crossings: &[Crossing], contour: usize) -> f32 {
        let nodes = self.graph.nodes_of(contour);
        let sum: f32 = nodes
            .iter()
            .map(|&i| {
                let [a, b] = surface.topology.edges[crossings[i as usize].edge as usize].map(|v| v as usize);
                surface.rest[a].distance(surface.rest[b])
            })
            .sum();
        sum / nodes.len().max(1) as f32
    }

    /// Every crossing for itself.
    fn shrink_each(&mut self, surface: &Surface, crossings: &[Crossing], positions: &[Vec4], contour: usize, step: f32) {
        for &i in self.graph.nodes_of(contour) {
            let c = &crossings[i as usize];
            let edge = surface.topology.edges[c.edge as usize];
            let face = surface.topology.faces[c.face as usize];
            let [on_edge, on_face] = shares([load(positions, edge), load(positions, face)]);
            let d = saturate(self.terms[i as usize].pull(), step);
            for v in edge {
                self.shift.add(v, on_edge * d, on_edge * step);
            }
            for v in face {
                self.shift.add(v, -on_face * d, on_face * step);
            }
        }
    }

    /// The whole contour as one: summed gradient, uniform over the patch, and the exact vertex gradient.
    fn shrink(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        contour: usize,
        step: f32,
        exact: bool,
        settings: &ResolveSettings,
    ) {
        self.patch.gather(surface, crossings, &self.graph, contour);
        let share = shares([0, 1].map(|s: usize| load(positions, self.patch.sides[s].iter().copied())));
        let mut g = DVec3::ZERO;
        for &i in self.graph.nodes_of(contour) {
            let pull = self.terms[i as usize].pull();
            g += if self.graph.side[i as usize] == 0 { pull } else { -pull };
        }
        let (step, d) = if exact {
            let motion = self.latches.now[contour].steer(saturate(g, 1.0), settings.pace, latch::INERTIA);
            (step * self.latches.now[contour].pace, step * motion)
        } else {
            (step, saturate(g, step))
        };
        if exact {
            let rings = ((settings.spread * self.latches.now[contour].longest / surface.mean_edge) as usize).min(MOST_RINGS);
            self.patch.grow(surface, rings);
            for (side, share) in share.into_iter().enumerate() {
                let along = if side == 0 { d } else { -d };
                for ring in 0..rings {
                    let fall = 1.0 - (ring + 1) as f32 / (rings + 1) as f32;
                    let ends = &self.patch.ring_end[side];
                    for &v in &self.patch.sides[side][ends[ring] as usize..ends[ring + 1] as usize] {
                        self.shift.add(v, share * fall * along, share * step);
                    }
                }
            }
        }
        for &i in self.graph.nodes_of(contour) {
            let (c, terms) = (&crossings[i as usize], &self.terms[i as usize]);
            let side = usize::from(self.graph.side[i as usize]);
            let (on_edge, on_face) = (share[side], share[1 - side]);
            let along = if side == 0 { d } else { -d };
            let (pull, tilt) =
                if exact { ((terms.r - terms.s).as_vec3() * step, terms.s.as_vec3() * step) } else { (Vec3::ZERO, Vec3::ZERO) };
            for (v, w) in surface.topology.edges[c.edge as usize].into_iter().zip([1.0 - c.t, c.t]) {
                self.shift.add(v, on_edge * (along + w * pull), on_edge * step);
            }
            for (v, w) in surface.topology.faces[c.face as usize].into_iter().zip(c.weights) {
                self.shift.add(v, on_face * (-along + w * tilt), on_face * step);
            }
        }
    }

    /// Weighs every particle by how much it belongs to a tangle: 1 in the regions and around the contours analysed last, falling to 0
    /// over `rings` rings of neighbours.
    pub fn mark(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        rings: usize,
        weights: &mut Vec<f32>,
    ) {
        weights.clear();
        weights.resize(surface.len(), 0.0);
        for k in 0..self.graph.contours.len() {
            self.patch.gather(surface, crossings, &self.graph, k);
            for side in 0..2 {
                if self.graph.contours[k].kind.separates()
                    && self.region(surface, crossings, positions, k, side as u8, NONE).is_some()
                {
                    for &v in self.flood.region() {
                        self.patch.put(side, v);
                    }
                }
            }
            self.patch.grow(surface, rings);
            for side in 0..2 {
                let (particles, ends) = (&self.patch.sides[side], &self.patch.ring_end[side]);
                let mut ring = 0;
                for (i, &v) in particles.iter().enumerate() {
                    while i >= ends[ring] as usize {
                        ring += 1;
                    }
                    let weight = &mut weights[v as usize];
                    *weight = weight.max(1.0 - ring as f32 / (rings + 1) as f32);
                }
            }
        }
    }

    /// Like [`Self::shrink`], with the gradient summed over a stretch of the contour around each crossing: for curves on which the sum over
    /// everything cancels.
    fn peel(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        contour: usize,
        step: f32,
        settings: &ResolveSettings,
    ) {
        self.patch.gather(surface, crossings, &self.graph, contour);
        let share = shares([0, 1].map(|s: usize| load(positions, self.patch.sides[s].iter().copied())));
        let Self { graph, terms, pulls, smooth, along, shift, patch, .. } = self;
        let nodes = graph.nodes_of(contour);
        let sign = |i: u32| if graph.side[i as usize] == 0 { 1.0 } else { -1.0 };
        pulls.resize(graph.side.len(), Vec3::ZERO);
        smooth.resize(graph.side.len(), Vec3::ZERO);
        for &i in nodes {
            pulls[i as usize] = sign(i) * terms[i as usize].pull().as_vec3();
        }
        for _ in 0..PASSES {
            for &i in nodes {
                let around: Vec3 = graph.linked(i as usize).map(|j| pulls[j as usize]).sum();
                smooth[i as usize] = pulls[i as usize] * 0.5 + around * 0.25;
            }
            for &i in nodes {
                pulls[i as usize] = smooth[i as usize];
            }
        }
        // A mean over some 2 sqrt(PASSES) crossings, back to a sum.
        let scale = 2.0 * (PASSES as f32).sqrt();
        along.resize(surface.len(), Vec3::ZERO);
        for side in 0..2 {
            for &v in &patch.sides[side] {
                along[v as usize] = Vec3::ZERO;
            }
        }
        for &i in nodes {
            let (c, t) = (&crossings[i as usize], &terms[i as usize]);
            let side = usize::from(graph.side[i as usize]);
            let d = sign(i) * saturate((pulls[i as usize] * scale).as_dvec3(), step);
            for v in surface.topology.edges[c.edge as usize] {
                along[v as usize] += d;
            }
            for v in surface.topology.faces[c.face as usize] {
                along[v as usize] -= d;
            }
            for (v, w) in surface.topology.edges[c.edge as usize].into_iter().zip([1.0 - c.t, c.t]) {
                shift.add(v, share[side] * w * (t.r - t.s).as_vec3() * step, share[side] * step);
            }
            for (v, w) in surface.topology.faces[c.face as usize].into_iter().zip(c.weights) {
                shift.add(v, share[1 - side] * w * t.s.as_vec3() * step, share[1 - side] * step);
            }
        }
        let rings = (settings.spread * graph.contours[contour].length / surface.mean_edge).min(PEEL_RINGS) as usize;
        patch.grow(surface, rings);
        for (side, share) in share.into_iter().enumerate() {
            let ends = &patch.ring_end[side];
            let mut ring = 0;
            for (k, &v) in patch.sides[side].iter().enumerate() {
                while k >= ends[ring] as usize {
                    ring += 1;
                }
                if ring > 0 {
                    // The mean of what the inner ring does.
                    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
                    for &(u, _) in surface.topology.around(v) {
                        if patch.order(side, u).is_some_and(|r| r < ring) {
                            sum += along[u as usize];
                            count += 1.0;
                        }
                    }
                    along[v as usize] = sum / f32::max(count, 1.0);
                } else {
                    along[v as usize] = along[v as usize].clamp_length_max(step);
                }
                let fall = 1.0 - ring as f32 / (rings + 1) as f32;
                shift.add(v, share * fall * along[v as usize], share * step);
            }
        }
    }

    /// Cuts a sheet along a contour: edges of odd parity on `side`, loop vertices, and where the contour ends inside the sheet a
    /// prolongation to the nearest border. `None` when there is no way to close the cut.
    fn cut(&mut self, surface: &Surface, crossings: &[Crossing], contour: usize, side: u8) -> Option<()> {
        let c = self.graph.contours[contour];
        let both = c.kind == ContourKind::Ll;
        self.flood.begin(surface);
        for &i in self.graph.nodes_of(contour) {
            if both || self.graph.side[i as usize] == side {
                self.flood.toggle(crossings[i as usize].edge);
            }
        }
        c.loops.into_iter().for_each(|v| self.flood.cut_at(v));
        if c.kind == ContourKind::Bibi {
            let end = c.border_ends.into_iter().find(|&n| n != NONE && self.graph.side[n as usize] != side)?;
            let most = (PROLONG * c.length / surface.mean_edge) as usize + 2;
            self.flood.prolong(surface, crossings[end as usize].face, most)?;
        }
        Some(())
    }

    /// The region to push on a side, smaller first.
    fn region(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        contour: usize,
        side: u8,
        seed: u32,
    ) -> Option<Region> {
        self.cut(surface, crossings, contour, side)?;
        let nodes = self.graph.nodes_of(contour);
        let mut edges = nodes.iter().map(|&i| crossings[i as usize].edge);
        let start = edges.find(|&e| self.flood.can_start(surface, e))?;
        self.flood.smaller(surface, positions, start, (seed != NONE).then_some(seed))
    }

    /// Pushes the smaller region that a contour cuts off back through it; `false` when there is none.
    fn push(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        contour: usize,
        step: f32,
        settings: &ResolveSettings,
    ) -> bool {
        let c = self.graph.contours[contour];
        let latch::Latch { side: latched, seed, .. } = self.latches.now[contour];
        let side = match c.kind {
            ContourKind::Bbii | ContourKind::Cross => c.border_side,
            ContourKind::Bli | ContourKind::Unknown => return false,
            ContourKind::Ll => 0,
            _ if latched < 2 => latched,
            _ => {
                let sizes = [0, 1]
                    .map(|side| self.region(surface, crossings, positions, contour, side, seed).map(|r| (r.pinned, r.area)));
                match sizes {
                    [Some(a), Some(b)] => u8::from(b < a),
                    [None, Some(_)] => 1,
                    _ => 0,
                }
            }
        };
        let Some(region) = self.region(surface, crossings, positions, contour, side, seed) else { return false };
        self.latches.now[contour].side = side;
        self.latches.now[contour].progress(region.area);
        let nodes = self.graph.nodes_of(contour);
        let mut sum = DVec3::ZERO;
        for &i in nodes {
            let e = crossings[i as usize].edge;
            if (self.graph.side[i as usize] != side && c.kind != ContourKind::Ll) || !self.flood.is_cut(e) {
                continue;
            }
            let [a, b] = surface.topology.edges[e as usize];
            let inside = match (self.flood.contains(a), self.flood.contains(b)) {
                (true, false) => a,
                (false, true) => b,
                _ => continue,
            };
            let terms = &self.terms[i as usize];
            let depth = (positions[inside as usize].truncate().as_dvec3() - terms.point).dot(terms.normal);
            sum += depth.signum() * terms.normal;
        }
        let direction = -sum.normalize_or_zero().as_vec3();
        if direction == Vec3::ZERO {
            return false;
        }
        // The particle that comes through last marks the region.
        let along = |v: &u32| positions[*v as usize].truncate().dot(direction);
        let deepest = self.flood.region().iter().min_by(|a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
        self.latches.now[contour].seed = deepest.copied().unwrap_or(NONE);
        let motion = step * self.latches.now[contour].steer(direction, settings.pace, 0.0);
        // The other cloth gives way as a whole.
        let node = nodes[0] as usize;
        let on = |which: u8| {
            let c = &crossings[node];
            let v = if self.graph.side[node] == which {
                surface.topology.edges[c.edge as usize][0]
            } else {
                surface.topology.faces[c.face as usize][0]
            };
            usize::from(surface.part(v))
        };
        let other = &surface.parts[on(1 - side)].particles;
        let mine = Load { mass: region.mass, pinned: region.pinned };
        let theirs = if on(0) == on(1) { Load::default() } else { load(positions, other.clone()) };
        // A small piece of a heavy cloth is still heavy cloth: weigh it by its density, too.
        let density = (mine.mass / self.flood.region().len() as f32) / (theirs.mass / other.len() as f32);
        let mine = if density.is_finite() { Load { mass: mine.mass * density, ..mine } } else { mine };
        let share = shares([mine, theirs]).map(|s| 0.5 * s);
        if share[0] > 0.0 {
            for &v in self.flood.region() {
                self.shift.add(v, share[0] * motion, motion.length());
            }
        }
        if share[1] > 0.0 {
            for v in other.clone() {
                self.shift.add(v, -share[1] * motion, motion.length());
            }
        }
        true
    }
}

/// Detection and resolution of one surface together.
#[derive(Clone, Debug, Default)]
pub struct Untangler {
    /// Finds crossings.
    pub detector: Detector,
    /// Takes them apart.
    pub resolver: Resolver,
}

impl Untangler {
    /// Prepares a surface.
    #[must_use]
    pub fn new(surface: &Surface) -> Self {
        Self { detector: Detector::new(surface), resolver: Resolver::default() }
    }

    /// Detects crossings and traces contours without moving anything.
    pub fn look(&mut self, surface: &Surface, positions: &[Vec4]) -> Verdict {
        let crossings = self.detector.detect(surface, positions);
        self.resolver.analyse(surface, crossings, positions)
    }

    /// One iteration: looks, then moves `positions` and `previous` together. The verdict is that of the positions as they came.
    pub fn iterate(
        &mut self,
        surface: &Surface,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        settings: &ResolveSettings,
    ) -> Verdict {
        let verdict = self.look(surface, positions);
        self.resolver.advance(surface, &mut self.detector, positions, previous, settings);
        verdict
    }
}
