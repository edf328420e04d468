//! Ways apart being carried out: each particle in proportion to its way over several iterations, and the rest of both sheets
//! follows.

use std::collections::BinaryHeap;

use glam::{Quat, Vec3};

use crate::solver::buffer::Buffer;

use super::contour::ContourGraph;
use super::displacements::Displacements;
use super::mass_split::{load, shares};
use super::separation::{Member, Seen, Separation, nodes};
use super::view::View;

/// Strain of an edge along the way that the displacements may leave (dimensionless): a strip that was stabbed through a sheet
/// is drawn out whole.
const STRAIN: f32 = 0.1;
/// Change of the displacements along an edge across the way, in metres per metre; it strains by half its square.
const SLOPE: f32 = 0.3;
/// Room left between the sheets beside their thickness, as a fraction of an edge.
const ROOM: f32 = 0.5;
/// Least room, as a fraction of an edge. It is for sides of one cloth that lie closer at rest: more would push them into the
/// next layer.
const LEAST_ROOM: f32 = 0.02;

/// A displacement being carried out.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Plan {
    /// By which others know it.
    number: u32,
    /// Iterations left.
    left: u32,
    /// Particle and displacement per iteration `[m]`.
    moves: Vec<(u32, Vec3)>,
}

/// Plans being carried out. Buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Plans {
    list: Vec<Plan>,
    live: usize,
    /// Numbers of the live ones, ascending.
    numbers: Vec<u32>,
    last: u32,
    /// Particles to be settled when the rest of a side follows.
    farthest: Buffer<BinaryHeap<(u32, u32)>>,
    /// Edges looked at.
    pub visits: usize,
}

impl Plans {
    /// Gives all plans up.
    pub(super) fn clear(&mut self) {
        self.live = 0;
        self.numbers.clear();
    }

    /// Turns all ways.
    pub(super) fn turn(&mut self, by: Quat) {
        self.list.iter_mut().flat_map(|plan| &mut plan.moves).for_each(|(_, way)| *way = by * *way);
    }

    /// Gives up those that move particles that were `put` elsewhere.
    pub(super) fn give_up(&mut self, put: impl Fn(u32) -> bool) {
        let mut k = 0;
        while k < self.live {
            if self.list[k].moves.iter().any(|&(v, _)| put(v)) {
                self.live -= 1;
                self.list.swap(k, self.live);
            } else {
                k += 1;
            }
        }
        self.count();
    }

    /// Lists the numbers of live plans after some have ended.
    fn count(&mut self) {
        if self.numbers.len() != self.live {
            self.numbers.clear();
            self.numbers.extend(self.list[..self.live].iter().map(|plan| plan.number));
            self.numbers.sort_unstable();
        }
    }

    /// Whether any plan is being carried out.
    pub(super) fn any(&self) -> bool {
        self.live > 0
    }

    /// Particles moved in an iteration, again for each plan that moves them.
    pub(super) fn moves(&self) -> usize {
        self.list[..self.live].iter().map(|plan| plan.moves.len()).sum()
    }

    /// Whether a plan is still being carried out.
    pub(super) fn is_live(&self, number: u32) -> bool {
        self.numbers.binary_search(&number).is_ok()
    }

    /// One iteration of every plan.
    pub(super) fn advance(&mut self, displacements: &mut Displacements) {
        let mut k = 0;
        while k < self.live {
            let plan = &mut self.list[k];
            for &(v, by) in &plan.moves {
                displacements.add(v, by, by.length());
            }
            plan.left -= 1;
            if plan.left == 0 {
                self.live -= 1;
                self.list.swap(k, self.live);
            } else {
                k += 1;
            }
        }
        self.count();
    }

    /// Makes a plan of the ways found last between the sides of some contours, in steps of at most `step` `[m]`. Returns its
    /// number, never 0.
    pub(super) fn carry_out(
        &mut self,
        view: View<'_>,
        graph: &ContourGraph,
        set: &[Member],
        separation: &mut Separation,
        step: f32,
    ) -> u32 {
        let Self { list, live, numbers, last, farthest, visits } = self;
        if *live == list.len() {
            list.push(Plan::default());
        }
        let plan = &mut list[*live];
        *live += 1;
        *last = last.wrapping_add(1).max(1);
        plan.number = *last;
        numbers.push(*last);
        plan.moves.clear();
        let room = (ROOM * separation.edge + thickness(view, separation))
            .min(apart_at_rest(view, graph, set).max(LEAST_ROOM * separation.edge));
        share_ways(view, separation);
        *visits += (0..2).map(|side| follow(view, separation, side, room, farthest)).sum::<usize>();
        let share = shares([0, 1].map(|s: usize| load(view.positions, separation.behind[s].iter().copied())));
        let mut longest = 0.0_f32;
        for (side, share) in share.into_iter().enumerate() {
            if share == 0.0 {
                continue;
            }
            for &v in &separation.behind[side] {
                let Seen { way, along, .. } = separation.seen[v as usize][side];
                let by = 0.5 * share * way * along;
                longest = longest.max(by.length());
                plan.moves.push((v, by));
            }
        }
        plan.left = ((longest / step).ceil() as u32).max(1);
        let each = (plan.left as f32).recip();
        plan.moves.iter_mut().for_each(|m| m.1 *= each);
        plan.number
    }
}

/// How far apart the sides of some contours are at rest where they cross `[m]`; infinitely where they are of two cloths.
fn apart_at_rest(view: View<'_>, graph: &ContourGraph, set: &[Member]) -> f32 {
    let rest = |v: u32| view.surface.rest[v as usize];
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, _) in nodes(graph, set) {
        let c = &view.crossings[i];
        if view.surface.part_of_edge(c.edge) != view.surface.part_of_face(c.face) {
            return f32::INFINITY;
        }
        let [a, b] = view.surface.topology.edges[c.edge as usize].map(rest);
        let corners = view.surface.topology.faces[c.face as usize].map(rest);
        let on_face: Vec3 = corners.into_iter().zip(c.weights).map(|(x, w)| x * w).sum();
        sum += a.lerp(b, c.t).distance(on_face);
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { f32::INFINITY }
}

/// Largest thickness of the two sides `[m]`.
fn thickness(view: View<'_>, separation: &Separation) -> f32 {
    let of = |v: &u32| view.surface.parts[usize::from(view.surface.part(*v))].thickness;
    separation.behind.iter().filter_map(|b| b.first()).map(of).fold(0.0, f32::max)
}

/// Gives the faces that are met the way of what meets them, for a side that cannot be seen along the direction.
fn share_ways(view: View<'_>, separation: &mut Separation) {
    let Separation { seen, stamp, behind, meets, .. } = separation;
    for side in 0..2 {
        // Only of what was found by looking, not of what was added here.
        for k in 0..meets[side].len() {
            let Seen { way, along, .. } = seen[behind[side][k] as usize][side];
            for v in view.surface.topology.faces[meets[side][k] as usize] {
                let known = &mut seen[v as usize][1 - side];
                if known.stamp != *stamp || known.way <= 0.0 {
                    behind[1 - side].push(v);
                    *known = Seen { stamp: *stamp, way, along: -along };
                } else if way > known.way {
                    known.way = way;
                }
            }
        }
    }
}

/// Lengthens every way by `room` `[m]` and lets the rest of the side follow, so far that no edge is strained much. Returns how
/// many edges were looked at.
fn follow(view: View<'_>, separation: &mut Separation, side: usize, room: f32, farthest: &mut BinaryHeap<(u32, u32)>) -> usize {
    let at = |v: u32| view.positions[v as usize].truncate();
    let Separation { seen, stamp, behind, .. } = separation;
    farthest.clear();
    for &v in &behind[side] {
        let way = &mut seen[v as usize][side].way;
        *way += room;
        farthest.push((way.to_bits(), v));
    }
    behind[side].clear();
    let mut visits = 0;
    // Farthest first, so that each particle is settled once (Dijkstra). Positive floats are in the order of their bits.
    while let Some((bits, v)) = farthest.pop() {
        let Seen { way, along, .. } = seen[v as usize][side];
        if way.to_bits() != bits {
            continue;
        }
        behind[side].push(v);
        let around = view.surface.topology.around(v);
        visits += around.len();
        for &(u, _) in around {
            let edge = at(u) - at(v);
            let (on, across) = (edge.dot(along).abs(), edge.reject_from_normalized(along).length());
            let way = way - STRAIN * on - SLOPE * across;
            let known = &mut seen[u as usize][side];
            if way > 0.0 && (known.stamp != *stamp || way > known.way) {
                let along = if known.stamp == *stamp && known.way > 0.0 { known.along } else { along };
                *known = Seen { stamp: *stamp, way, along };
                farthest.push((way.to_bits(), u));
            }
        }
    }
    visits
}
