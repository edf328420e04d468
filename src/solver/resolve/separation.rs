//! How far the particles on both sides of some contours have to go until they are through.
//!
//! ```text
//!            d ↑        side 0 goes along d, side 1 against it
//!   ──────────┼───────  side 1    a particle of side 0 that lies behind side 1, seen along d, has `way` to go;
//!        way  ╎ ╱                 so far around the contour as it stays positive.
//!             ╎╱                      cost = Σ way² A         over both sides
//!             ●   side 0
//! ```
//!
//! Or each particle goes along the normal of the face that it meets, where no one direction takes all of one side out
//! ([`Course`]).
//!
//! No ray is cast through a tree. From the face that the contour crosses on, a walk over neighbouring faces finds the
//! projection of a particle. So another sheet in the way is not taken for this one.

use glam::Vec3;

use super::contour::ContourGraph;
use super::view::View;
use crate::solver::topology::NONE;

/// Share of the crossings that a direction must undo.
pub(super) const COVERED: f32 = 0.8;
/// Steepest change of the way to go along a sheet, in metres per metre, beyond which another sheet was met.
const STEEPEST: f32 = 3.0;
/// Smallest cosine at which a face can be met.
const GRAZING: f32 = 0.01;
/// Edges by which the way may be longer than the contour.
const ABOUT: f32 = 4.0;
/// Edges by which a contour may be longer than it is, in what it can cut off.
const LONGER: f32 = 2.0;
/// Faces walked over at most to find a projection.
const WALK: usize = 64;

/// A contour that is looked at together with others; `flip` where its sides are the other way round than theirs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Member {
    pub contour: usize,
    pub flip: u8,
}

/// A particle of a side that may be behind a face of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Stray {
    pub side: usize,
    pub particle: u32,
    pub face: u32,
    /// How far it may be behind it `[m]`.
    pub near: f32,
}

/// Which way sides go apart.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Course {
    /// Side 0 along a unit vector, side 1 against it.
    Along(Vec3),
    /// Each particle along the normal of the face beside what it meets. Side 0 goes along that of side 1, times the first sign.
    /// Side 1 goes along that of side 0, times the second. Around a tube no one direction takes all of one side out.
    Facing([f32; 2]),
}

impl Course {
    fn is_facing(self) -> bool {
        matches!(self, Self::Facing(_))
    }

    /// Unit vector along which a particle of a side goes that is to meet a face, or zero.
    fn of(self, view: View<'_>, side: usize, face: u32) -> Vec3 {
        match self {
            Self::Along(direction) if side == 0 => direction,
            Self::Along(direction) => -direction,
            Self::Facing(signs) => signs[side] * view.facing(face),
        }
    }
}

/// The crossings of some contours, each with the side of its edge.
pub(super) fn nodes<'a>(graph: &'a ContourGraph, set: &'a [Member]) -> impl Iterator<Item = (usize, usize)> + 'a {
    set.iter().flat_map(move |m| {
        let side = move |i: u32| usize::from(graph.side[i as usize] ^ m.flip);
        graph.nodes_of(m.contour).iter().map(move |&i| (i as usize, side(i)))
    })
}

/// Largest area `[m²]` that belongs to contours of a `length` `[m]`, in a mesh with edges of `edge` `[m]`, where it reaches
/// `depth` `[m]` through. It is a strip as wide as they are long. What is larger is a whole sheet that lies close.
pub(super) fn largest_area(length: f32, edge: f32, depth: f32) -> f32 {
    let wide = length + LONGER * edge;
    wide * (wide + depth)
}

/// What is known of a particle on one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Seen {
    pub stamp: u32,
    /// Way to go `[m]`; not positive: none.
    pub way: f32,
    /// In which direction.
    pub along: Vec3,
}

/// What is found out about a way apart. Buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Separation {
    pub seen: Vec<[Seen; 2]>,
    pub stamp: u32,
    queue: Vec<(u32, u32, f32)>,
    /// Particles with a way to go, by side.
    pub behind: [Vec<u32>; 2],
    /// Face that each of them meets.
    pub meets: [Vec<u32>; 2],
    /// Mean length at rest of the edges that cross `[m]`.
    pub edge: f32,
    /// Length of the contours `[m]`.
    length: f32,
    /// Longest way that is meant `[m]`: what is farther through than the contour is long is something else.
    farthest: f32,
    /// Area that has a way to go, by side, and the largest that may `[m²]`.
    area: [f32; 2],
    largest: f32,
    /// Share of the crossings of the contours that the ways undo.
    pub undone: f32,
    /// Area times squared way `[m⁴]`.
    pub cost: f32,
    /// Pinned particles that were looked at and meet faces that are pinned, too, and those of them that have a way to go.
    pub pins: [u32; 2],
    /// Particles and crossings looked at.
    pub visits: usize,
}

impl Separation {
    /// Looks from both sides, side 0 along the direction and side 1 against it, at faces that face it at all. Gives up beyond a
    /// cost of `most`. Returns whether the ways undo the contours.
    pub(super) fn look(&mut self, view: View<'_>, graph: &ContourGraph, set: &[Member], course: Course, most: f32) -> bool {
        self.begin(view, graph, set);
        self.largest = largest_area(self.length, self.edge, self.length + ABOUT * self.edge);
        self.look_along(view, graph, set, &[], course, most);
        !(self.pins[1] > 0 && course.is_facing())
            && self.cost <= most
            && self.undone >= COVERED
            && self.area.iter().all(|&a| a <= self.largest)
    }

    /// The same from strays, too, whatever it costs.
    pub(super) fn look_from(&mut self, view: View<'_>, graph: &ContourGraph, set: &[Member], strays: &[Stray], course: Course) {
        self.begin(view, graph, set);
        self.largest = f32::INFINITY;
        self.look_along(view, graph, set, strays, course, f32::INFINITY);
    }

    /// Measures the contours.
    fn begin(&mut self, view: View<'_>, graph: &ContourGraph, set: &[Member]) {
        let contours = || set.iter().map(|m| &graph.contours[m.contour]);
        let count: u32 = contours().map(|c| c.count).sum();
        let edges: f32 = contours().map(|c| c.edge * c.count as f32).sum();
        self.edge = if count > 0 { edges / count as f32 } else { view.surface.mean_edge };
        self.length = contours().map(|c| c.length).sum();
    }

    fn look_along(
        &mut self,
        view: View<'_>,
        graph: &ContourGraph,
        set: &[Member],
        strays: &[Stray],
        course: Course,
        most: f32,
    ) {
        let strays_reach = strays.iter().map(|s| s.near).fold(0.0, f32::max);
        self.farthest = strays_reach.max(self.length + ABOUT * self.edge);
        self.seen.resize(view.surface.len(), [Seen::default(); 2]);
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.seen.fill([Seen::default(); 2]);
            self.stamp = 1;
        }
        (self.cost, self.undone, self.area, self.pins) = (0.0, 0.0, [0.0; 2], [0; 2]);
        for side in 0..2 {
            self.behind[side].clear();
            self.meets[side].clear();
            self.start(view, graph, set, side);
            let strays = strays.iter().filter(|s| s.side == side);
            self.queue.extend(strays.map(|s| (s.particle, s.face, s.near)));
            let goes_on = self.flood(view, side, course, most);
            self.visits += self.queue.len();
            if !goes_on {
                return;
            }
        }
        let (mut all, mut undone) = (0_u32, 0_u32);
        for (i, side) in nodes(graph, set) {
            let c = &view.crossings[i];
            let moves = |side: usize, run: &[u32]| run.iter().any(|&v| self.way(side, v) > 0.0);
            let (edge, face) = (view.surface.topology.edges[c.edge as usize], view.surface.topology.faces[c.face as usize]);
            all += 1;
            let along = course.of(view, side, c.face);
            let moves = moves(side, &edge) || moves(1 - side, &face) || self.lift(view, side, along, edge, c.face);
            undone += u32::from(moves);
        }
        self.visits += all as usize;
        self.undone = undone as f32 / f32::max(all as f32, 1.0);
    }

    /// An edge may pass an edge of a face while no particle of either is behind the other. Gives the ends of such an edge the
    /// way until the two edges meet.
    fn lift(&mut self, view: View<'_>, side: usize, along: Vec3, edge: [u32; 2], face: u32) -> bool {
        let at = |v: u32| view.positions[v as usize].truncate();
        let [p, q] = edge.map(at);
        let corners = view.surface.topology.faces[face as usize].map(at);
        let way = (0..3).filter_map(|k| pass([p, q], [corners[k], corners[(k + 1) % 3]], along)).fold(0.0, f32::max);
        if !(way > 0.0 && way <= self.farthest.min(STEEPEST * p.distance(q))) {
            return false;
        }
        for v in edge {
            self.seen[v as usize][side] = Seen { stamp: self.stamp, way, along };
            self.behind[side].push(v);
            self.meets[side].push(face);
            self.cost += way * way * view.surface.areas[v as usize];
        }
        true
    }

    /// Way that a particle of a side has to go `[m]`.
    pub(super) fn way(&self, side: usize, v: u32) -> f32 {
        let seen = self.seen[v as usize][side];
        if seen.stamp == self.stamp { seen.way } else { 0.0 }
    }

    /// Puts the particles at the contours into the queue.
    fn start(&mut self, view: View<'_>, graph: &ContourGraph, set: &[Member], side: usize) {
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
    }

    /// Finds the particles of one side that have a way to go, outwards from those in the queue.
    fn flood(&mut self, view: View<'_>, side: usize, course: Course, most: f32) -> bool {
        let topology = &view.surface.topology;
        let at = |v: u32| view.positions[v as usize].truncate();
        let mut head = 0;
        while head < self.queue.len() {
            let (v, face, near) = self.queue[head];
            head += 1;
            let seen = &mut self.seen[v as usize][side];
            if seen.stamp == self.stamp {
                continue;
            }
            let along = course.of(view, side, face);
            let Some((way, face)) = project(view, at(v), along, face) else { continue };
            if !(way <= near.min(self.farthest)) {
                continue;
            }
            *seen = Seen { stamp: self.stamp, way, along };
            let is_pinned = |v: u32| view.positions[v as usize].w == 0.0;
            if is_pinned(v) && topology.faces[face as usize].into_iter().any(is_pinned) {
                self.pins[0] += 1;
                self.pins[1] += u32::from(way > 0.0);
            }
            if way <= 0.0 {
                continue;
            }
            self.behind[side].push(v);
            self.meets[side].push(face);
            self.cost += way * way * view.surface.areas[v as usize];
            self.area[side] += view.surface.areas[v as usize];
            if self.cost > most || self.area[side] > self.largest {
                return false;
            }
            for &(u, _) in topology.around(v) {
                if self.seen[u as usize][side].stamp != self.stamp {
                    self.queue.push((u, face, way + STEEPEST * at(u).distance(at(v))));
                }
            }
        }
        true
    }
}

/// How far an edge has to go along a unit direction until it meets another, if it does `[m]`.
fn pass([p, q]: [Vec3; 2], [r, s]: [Vec3; 2], along: Vec3) -> Option<f32> {
    let (u, v, w) = (q - p, s - r, r - p);
    let across = u.cross(v);
    let slope = along.dot(across);
    let (x, y) = (w.dot(v.cross(along)) / slope, w.dot(u.cross(along)) / slope);
    let meets = |x: f32| (0.0..=1.0).contains(&x);
    (slope.abs() > GRAZING * across.length() && meets(x) && meets(y)).then(|| w.dot(across) / slope)
}

/// Where `point`, moved along a unit direction, meets the sheet of `face` or its neighbours: how far it has to go `[m]`, and
/// the face.
fn project(view: View<'_>, point: Vec3, along: Vec3, face: u32) -> Option<(f32, u32)> {
    let topology = &view.surface.topology;
    let (mut face, mut before) = (face, NONE);
    for _ in 0..WALK {
        let corners = topology.faces[face as usize].map(|v| view.positions[v as usize].truncate());
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let slope = normal.dot(along);
        if !(slope.abs() > GRAZING * normal.length()) {
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
