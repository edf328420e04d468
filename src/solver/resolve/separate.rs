//! The cheapest way apart: of a few candidate directions, the one along which the least area has the least way to go.
//!
//! ```text
//!            d ↑        side 0 of a contour goes along d, side 1 against it
//!   ──────────┼───────  side 1    a particle of side 0 that lies behind side 1, seen along d, has t to go;
//!          t  ╎ ╱                 so far around the contour as t stays positive.
//!             ╎╱                      cost(d) = Σ t² A         over both sides
//!             ●   side 0
//! ```
//!
//! A capped version of *Type-Free Global Intersection Analysis* (2026). Candidates are both normals of both sides at the contour. Rays are not cast
//! through a tree: from the face that the contour crosses on, the projection of a particle is found by walking over neighbouring faces.
//! What is chosen is carried out over several iterations, each particle in proportion to its way, and the rest of both sheets follows
//! so far that no edge is strained much: a strip that was stabbed through a sheet is drawn out whole.

use std::collections::BinaryHeap;

use glam::Vec3;

use super::contour::ContourGraph;
use super::gradient::Terms;
use super::latch::Strategy;
use super::share::{load, shares};
use super::shift::Shift;
use super::{Resolver, View};
use crate::solver::rest::NONE;

/// Share of a contour's crossings that a direction must undo.
const COVERED: f32 = 0.8;
/// Steepest change of the way to go along a sheet, in metres per metre, beyond which another sheet was met.
const STEEPEST: f32 = 3.0;
/// Strain of an edge along the direction that the displacements may leave (dimensionless).
const STRAIN: f32 = 0.1;
/// Change of the displacements along an edge across the direction, in metres per metre; it strains by half its square.
const SLOPE: f32 = 0.3;
/// How much cheaper another direction must be than the one taken before.
const HYSTERESIS: f32 = 0.25;
/// Faces walked over at most to find a projection.
const WALK: usize = 64;
/// Room left between the sheets, as a fraction of an edge.
const ROOM: f32 = 0.5;

/// A displacement being carried out.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// By which latches know it.
    pub number: u32,
    /// Iterations left.
    left: u32,
    /// Particle and displacement per iteration [m].
    moves: Vec<(u32, Vec3)>,
}

/// Plans being carried out. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Plans {
    list: Vec<Plan>,
    live: usize,
    last: u32,
    probe: Probe,
    set: Vec<Member>,
}

impl Plans {
    /// Gives all plans up.
    pub fn clear(&mut self) {
        self.live = 0;
    }

    /// Whether a plan is still being carried out.
    pub fn is_live(&self, number: u32) -> bool {
        self.list[..self.live].iter().any(|p| p.number == number)
    }

    /// One iteration of every plan.
    pub fn advance(&mut self, shift: &mut Shift) {
        let mut k = 0;
        while k < self.live {
            let plan = &mut self.list[k];
            for &(v, by) in &plan.moves {
                shift.add(v, by, by.length());
            }
            plan.left -= 1;
            if plan.left == 0 {
                self.live -= 1;
                self.list.swap(k, self.live);
            } else {
                k += 1;
            }
        }
    }
}

/// What is found out about one direction.
#[derive(Clone, Debug, Default)]
struct Probe {
    /// Stamp and way to go [m] by particle and side.
    seen: Vec<[(u32, f32); 2]>,
    stamp: u32,
    /// `(particle, face to start the walk from, most way to go)`
    queue: Vec<(u32, u32, f32)>,
    /// Particles with a way to go, by side.
    behind: [Vec<u32>; 2],
    /// Face that each of them meets.
    meets: [Vec<u32>; 2],
    /// Particles to be settled when the rest of a side follows.
    farthest: BinaryHeap<(u32, u32)>,
    cost: f32,
}

impl Probe {
    /// Looks from both sides along one direction; gives up beyond a cost of `most`.
    fn look(&mut self, view: View<'_>, graph: &ContourGraph, set: &[Member], direction: Vec3, most: f32) -> bool {
        self.seen.resize(view.surface.len(), [(0, 0.0); 2]);
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.seen.fill([(0, 0.0); 2]);
            self.stamp = 1;
        }
        self.cost = 0.0;
        for side in 0..2 {
            self.behind[side].clear();
            self.meets[side].clear();
            if !self.flood(view, graph, set, side, if side == 0 { direction } else { -direction }, most) {
                return false;
            }
        }
        let (mut all, mut undone) = (0, 0);
        for (i, side) in nodes(graph, set) {
            let c = &view.crossings[i];
            let moves = |side: usize, run: &[u32]| run.iter().any(|&v| self.way(side, v) > 0.0);
            let (edge, face) = (view.surface.topology.edges[c.edge as usize], view.surface.topology.faces[c.face as usize]);
            all += 1;
            undone += usize::from(moves(side, &edge) || moves(1 - side, &face));
        }
        undone as f32 >= COVERED * all as f32
    }

    fn way(&self, side: usize, v: u32) -> f32 {
        let (stamp, way) = self.seen[v as usize][side];
        if stamp == self.stamp { way } else { 0.0 }
    }

    /// Finds the particles of one side that have a way to go, outwards from the contour.
    fn flood(&mut self, view: View<'_>, graph: &ContourGraph, set: &[Member], side: usize, along: Vec3, most: f32) -> bool {
        let topology = &view.surface.topology;
        let at = |v: u32| view.positions[v as usize].truncate();
        self.queue.clear();
        for (i, of_edge) in nodes(graph, set) {
            let c = &view.crossings[i];
            let [a, b] = topology.edges[c.edge as usize];
            let near = STEEPEST * at(a).distance(at(b));
            if of_edge == side {
                self.queue.extend([a, b].map(|v| (v, c.face, near)));
            } else {
                let face = topology.edge_faces[c.edge as usize][0];
                self.queue.extend(topology.faces[c.face as usize].map(|v| (v, face, near)));
            }
        }
        let mut head = 0;
        while head < self.queue.len() {
            let (v, face, near) = self.queue[head];
            head += 1;
            let seen = &mut self.seen[v as usize][side];
            if seen.0 == self.stamp {
                continue;
            }
            let Some((way, face)) = project(view, at(v), along, face) else { continue };
            if way > near {
                continue;
            }
            *seen = (self.stamp, way);
            if way <= 0.0 {
                continue;
            }
            self.behind[side].push(v);
            self.meets[side].push(face);
            self.cost += way * way * view.surface.areas[v as usize];
            if self.cost > most {
                return false;
            }
            for &(u, _) in topology.around(v) {
                if self.seen[u as usize][side].0 != self.stamp {
                    self.queue.push((u, face, way + STEEPEST * at(u).distance(at(v))));
                }
            }
        }
        true
    }
}

/// Where `point`, moved along a unit direction, meets the sheet of `face` or its neighbours: how far it has to go [m], and the face.
fn project(view: View<'_>, point: Vec3, along: Vec3, face: u32) -> Option<(f32, u32)> {
    let topology = &view.surface.topology;
    let (mut face, mut before) = (face, NONE);
    for _ in 0..WALK {
        let corners = topology.faces[face as usize].map(|v| view.positions[v as usize].truncate());
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let slope = normal.dot(along);
        if slope * slope < 1.0e-4 * normal.length_squared() {
            return None;
        }
        let outside = [0, 1, 2].map(|k: usize| {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            along.dot((to - from).cross(point - from)) * slope.signum()
        });
        let worst = (0..3).min_by(|&a, &b| outside[a].total_cmp(&outside[b]))?;
        if outside[worst] >= -1.0e-6 * slope.abs() {
            return Some((normal.dot(corners[0] - point) / slope, face));
        }
        let edge = topology.face_edges[face as usize][worst];
        let next = topology.edge_faces[edge as usize].into_iter().find(|&f| f != face)?;
        if next == NONE || next == before {
            return None;
        }
        (before, face) = (face, next);
    }
    None
}

/// Mean normals of the two sides along some contours.
fn normals(view: View<'_>, graph: &ContourGraph, terms: &[Terms], set: &[Member]) -> [Vec3; 2] {
    let mut sum = [Vec3::ZERO; 2];
    for (i, side) in nodes(graph, set) {
        sum[1 - side] += terms[i].normal.as_vec3();
        for face in view.surface.topology.edge_faces[view.crossings[i].edge as usize] {
            if face != NONE {
                let [a, b, c] = view.surface.topology.faces[face as usize].map(|v| view.positions[v as usize].truncate());
                sum[side] += 0.5 * (b - a).cross(c - a).normalize_or_zero();
            }
        }
    }
    sum.map(Vec3::normalize_or_zero)
}

/// A contour that is separated together with others; `flip` where its sides are the other way round than theirs.
#[derive(Clone, Copy, Debug)]
struct Member {
    contour: usize,
    flip: u8,
}

/// The crossings of some contours, each with the side of its edge.
fn nodes<'a>(graph: &'a ContourGraph, set: &'a [Member]) -> impl Iterator<Item = (usize, usize)> + 'a {
    set.iter().flat_map(move |m| {
        let side = move |i: u32| usize::from(graph.side[i as usize] ^ m.flip);
        graph.nodes_of(m.contour).iter().map(move |&i| (i as usize, side(i)))
    })
}

/// The cloths on the two sides of a contour.
fn cloths(view: View<'_>, graph: &ContourGraph, contour: usize) -> Option<[u16; 2]> {
    let &i = graph.nodes_of(contour).first()?;
    let c = &view.crossings[i as usize];
    let (a, b) = (view.surface.part_of_edge(c.edge), view.surface.part_of_face(c.face));
    Some(if graph.side[i as usize] == 0 { [a, b] } else { [b, a] })
}

impl Resolver {
    /// Plans the cheapest separation of a contour, to be carried out in steps of at most `step` [m], together with all other contours
    /// between the same two cloths if one direction undoes them all. Returns whether there is one.
    pub(super) fn separate(&mut self, view: View<'_>, contour: usize, step: f32) -> bool {
        let graph = &self.graph;
        let mut set = core::mem::take(&mut self.plans.set);
        set.clear();
        if let Some([a, b]) = cloths(view, graph, contour).filter(|c| c[0] != c[1]) {
            set.extend((0..graph.contours.len()).filter_map(|k| {
                let pair = cloths(view, graph, k)?;
                (pair == [a, b] || pair == [b, a]).then(|| Member { contour: k, flip: u8::from(pair != [a, b]) })
            }));
        }
        let mut done = set.len() > 1 && self.separate_all(view, &set, step);
        if !done {
            set.clear();
            set.push(Member { contour, flip: 0 });
            done = self.separate_all(view, &set, step);
        }
        self.plans.set = set;
        done
    }

    fn separate_all(&mut self, view: View<'_>, set: &[Member], step: f32) -> bool {
        let Self { graph, terms, plans, latches, .. } = self;
        let [n, m] = normals(view, graph, terms, set);
        let (mut best, mut least) = (None, f32::INFINITY);
        let before = set.iter().fold(Vec3::ZERO, |sum, m| {
            let latch = &latches.now[m.contour];
            let weight = if latch.plan > 0 { graph.contours[m.contour].count as f32 } else { 0.0 };
            sum + latch.heading * if m.flip == 0 { weight } else { -weight }
        });
        for (k, direction) in [before.normalize_or_zero(), n, -n, m, -m].into_iter().enumerate() {
            if direction != Vec3::ZERO && plans.probe.look(view, graph, set, direction, least) {
                (best, least) = (Some(direction), plans.probe.cost * if k == 0 { HYSTERESIS } else { 1.0 });
            }
        }
        let Some(direction) = best else { return false };
        plans.probe.look(view, graph, set, direction, f32::INFINITY);
        plans.carry_out(view, direction, step);
        for member in set {
            let latch = &mut latches.now[member.contour];
            if latch.strategy != Strategy::Separate {
                latch.turn_to(Strategy::Separate);
            }
            latch.progress(plans.probe.cost);
            latch.heading = if member.flip == 0 { direction } else { -direction };
            latch.plan = plans.last;
        }
        true
    }
}

impl Plans {
    /// Makes a plan of what was found last.
    fn carry_out(&mut self, view: View<'_>, direction: Vec3, step: f32) {
        let Self { list, live, last, probe, .. } = self;
        if *live == list.len() {
            list.push(Plan::default());
        }
        let plan = &mut list[*live];
        *live += 1;
        *last = last.wrapping_add(1);
        plan.number = *last;
        plan.moves.clear();
        let room = ROOM * view.surface.mean_edge + thickness(view, probe);
        probe.share_ways(view);
        (0..2).for_each(|side| probe.follow(view, side, direction, room));
        let share = shares([0, 1].map(|s: usize| load(view.positions, probe.behind[s].iter().copied())));
        let mut longest = 0.0_f32;
        for (side, share) in share.into_iter().enumerate() {
            let by = 0.5 * share * if side == 0 { direction } else { -direction };
            if by == Vec3::ZERO {
                continue;
            }
            for &v in &probe.behind[side] {
                let way = by * probe.way(side, v);
                longest = longest.max(way.length());
                plan.moves.push((v, way));
            }
        }
        plan.left = ((longest / step).ceil() as u32).max(1);
        let each = (plan.left as f32).recip();
        plan.moves.iter_mut().for_each(|m| m.1 *= each);
    }
}

/// Largest thickness of the two sides [m].
fn thickness(view: View<'_>, probe: &Probe) -> f32 {
    let of = |v: &u32| view.surface.parts[usize::from(view.surface.part(*v))].thickness;
    probe.behind.iter().filter_map(|b| b.first()).map(of).fold(0.0, f32::max)
}

impl Probe {
    /// Gives the faces that are met the way of what meets them, for a side that cannot be seen along the direction.
    fn share_ways(&mut self, view: View<'_>) {
        let Self { seen, stamp, behind, meets, .. } = self;
        let met = [0, 1].map(|side: usize| meets[side].len());
        for side in 0..2 {
            for k in 0..met[side] {
                let way = seen[behind[side][k] as usize][side].1;
                for v in view.surface.topology.faces[meets[side][k] as usize] {
                    let known = &mut seen[v as usize][1 - side];
                    if known.0 != *stamp || known.1 <= 0.0 {
                        behind[1 - side].push(v);
                        *known = (*stamp, way);
                    } else if way > known.1 {
                        known.1 = way;
                    }
                }
            }
        }
    }

    /// Lengthens every way by `room` [m] and lets the rest of the side follow, so far that no edge is strained much.
    fn follow(&mut self, view: View<'_>, side: usize, along: Vec3, room: f32) {
        let at = |v: u32| view.positions[v as usize].truncate();
        let Self { seen, stamp, behind, farthest, .. } = self;
        farthest.clear();
        for &v in &behind[side] {
            let way = &mut seen[v as usize][side].1;
            *way += room;
            farthest.push((way.to_bits(), v));
        }
        behind[side].clear();
        // Farthest first, so that each particle is settled once (Dijkstra). Positive floats are in the order of their bits.
        while let Some((bits, v)) = farthest.pop() {
            if seen[v as usize][side].1.to_bits() != bits {
                continue;
            }
            behind[side].push(v);
            for &(u, _) in view.surface.topology.around(v) {
                let edge = at(u) - at(v);
                let (on, across) = (edge.dot(along).abs(), edge.reject_from_normalized(along).length());
                let way = f32::from_bits(bits) - STRAIN * on - SLOPE * across;
                let known = &mut seen[u as usize][side];
                if way > 0.0 && (known.0 != *stamp || way > known.1) {
                    *known = (*stamp, way);
                    farthest.push((way.to_bits(), u));
                }
            }
        }
    }
}
