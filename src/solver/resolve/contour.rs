//! The contour graph: crossings linked into intersection curves, their two sides, and how they end.
//!
//! A node is a crossing (edge `e`, face `f`). Each face `g` at `e` forms one segment with `f`. At the segment's other end is
//! the crossing of another edge of `g` with `f` (the walk keeps the side). Or it is that of an edge of `f` with `g` (the walk
//! flips it). That parity tells the two sheets apart even where a cloth crosses itself.
//!
//! ```text
//!      e  ┊g┊  e'            degree: 2 on inner edges, 1 on border edges, one less per loop vertex
//!   ───●──┊─┊──●───  f       loop vertex: f and g share a particle, and their segment ends there
//! ```
//!
//! Kinds of ends after Wicke, Lanker and Gross 2006, *Untangling cloth with boundaries*.

use glam::Vec3;

use crate::solver::detect::{Crossing, Surface};
use crate::solver::topology::NONE;
use crate::solver::verdict::Verdict;

/// How a contour ends, which decides what can take it apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum ContourKind {
    /// No ends.
    Closed,
    /// Both ends in one loop vertex.
    Eight,
    /// Ends in two loop vertices.
    Ll,
    /// Ends on two borders of one sheet: that sheet is pierced, or cuts through.
    Bbii,
    /// Ends on a border of each sheet.
    Bibi,
    /// Ends in a loop vertex and on a border.
    Bli,
    /// Two borders and a loop vertex between them.
    Cross,
    /// Anything else, such as contours at edges with three faces.
    #[default]
    Unknown,
}

impl ContourKind {
    /// Whether such a contour cuts a region off at least one of its sides.
    #[must_use]
    pub(crate) fn separates(self) -> bool {
        matches!(self, Self::Closed | Self::Eight | Self::Ll | Self::Bbii | Self::Cross)
    }
}

/// One intersection curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Contour {
    /// How it ends.
    pub kind: ContourKind,
    /// First of its entries in the list of nodes.
    pub first: u32,
    /// Number of its crossings.
    pub count: u32,
    /// Side that owns the borders of `Bbii` and `Cross`.
    pub border_side: u8,
    /// Up to two particles in which it ends; [`NONE`] where there is none.
    pub loops: [u32; 2],
    /// The crossings at its first two border ends; [`NONE`] where there is none.
    pub border_ends: [u32; 2],
    /// Length of the curve `[m]`.
    pub length: f32,
    /// Mean of its crossings `[m]`.
    pub centre: Vec3,
    /// Mean length at rest of the edges that cross `[m]`.
    pub edge: f32,
    /// Whether all of it is held as it is, by pins or by the skin: nothing is done about it.
    pub authored: bool,
}

/// No link: the edge has no face there, or the segment cannot be followed.
const BORDER: u32 = u32::MAX;
const LOOP: u32 = u32::MAX - 1;
const BROKEN: u32 = u32::MAX - 2;
const FIRST_END: u32 = BROKEN;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct End {
    code: u32,
    vertex: u32,
    side: u8,
    node: u32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Path {
    ends: [End; 2],
    closed: bool,
    root: u32,
    flip: u8,
    contour: u32,
}

/// All contours of one detection. Buffers are reused; nothing is allocated once warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct ContourGraph {
    /// The contours, ordered by their first crossing.
    pub contours: Vec<Contour>,
    /// Crossings grouped by contour, ascending within each.
    pub nodes: Vec<u32>,
    /// Per crossing: to which of the contour's two sides its *edge* belongs, 0 or 1.
    pub side: Vec<u8>,
    /// Per crossing: its contour.
    pub contour_of: Vec<u32>,
    /// Per crossing and face of its edge: linked crossing, or one of the end codes.
    links: Vec<[u32; 2]>,
    loop_vertex: Vec<[u32; 2]>,
    path_of: Vec<u32>,
    paths: Vec<Path>,
    /// First crossing of every edge, [`NONE`] elsewhere; cleared by the crossings that set it.
    first_of_edge: Vec<u32>,
    loops: Vec<(u32, u32)>,
    tallies: Vec<Tally>,
}

impl ContourGraph {
    /// Sums up the contours that are not authored.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        self.contours.iter().filter(|contour| !contour.authored).for_each(|contour| verdict.add(contour));
        verdict
    }

    /// Takes contours for authored of which every particle is `held` where it is.
    pub(crate) fn leave_held(&mut self, surface: &Surface, crossings: &[Crossing], held: impl Fn(u32) -> bool) {
        let topology = &surface.topology;
        for k in 0..self.contours.len() {
            let is_held = |&node: &u32| {
                let Crossing { edge, face, .. } = crossings[node as usize];
                topology.edges[edge as usize].iter().chain(&topology.faces[face as usize]).all(|v| held(*v))
            };
            self.contours[k].authored = self.nodes_of(k).iter().all(is_held);
        }
    }

    /// Links the crossings (sorted by edge, then face) at `points` `[m]`.
    pub fn trace(&mut self, surface: &Surface, crossings: &[Crossing], points: &[Vec3], at: impl Fn(u32) -> Vec3) {
        self.link(surface, crossings);
        self.walk_all(surface, crossings);
        self.join_at_loops();
        self.group();
        self.classify();
        self.measure(surface, crossings, points, at);
        debug_assert!(self.is_consistent(crossings.len()));
    }

    /// Whether each of so many `crossings` is of one contour, and whatever is named is there.
    fn is_consistent(&self, crossings: usize) -> bool {
        let is_crossing = |&i: &u32| (i as usize) < crossings;
        let Self { contours, nodes, side, contour_of, links, .. } = self;
        let mut runs = contours.iter().scan(0, |next, c| Some(c.first == core::mem::replace(next, c.first + c.count)));
        let whole = |k: usize| self.nodes_of(k).iter().all(|&i| contour_of[i as usize] as usize == k);
        [nodes.len(), side.len(), contour_of.len(), links.len()] == [crossings; 4]
            && runs.all(|follows| follows)
            && contours.last().map_or(0, |c| c.first + c.count) as usize == crossings
            && nodes.iter().all(is_crossing)
            && (0..contours.len()).all(whole)
            && links.iter().flatten().all(|link| *link >= FIRST_END || is_crossing(link))
            && contours.iter().flat_map(|c| &c.border_ends).all(|end| *end == NONE || is_crossing(end))
    }

    /// The crossings of a contour.
    #[must_use]
    pub(crate) fn nodes_of(&self, contour: usize) -> &[u32] {
        let c = &self.contours[contour];
        &self.nodes[c.first as usize..(c.first + c.count) as usize]
    }

    /// The linked neighbours of a crossing, at most two.
    pub fn linked(&self, crossing: usize) -> impl Iterator<Item = u32> + '_ {
        self.links[crossing].into_iter().filter(|&l| l < FIRST_END)
    }

    /// How many of a crossing's two segments end in a loop vertex.
    #[must_use]
    pub fn loops_at(&self, crossing: usize) -> usize {
        self.links[crossing].iter().filter(|&&l| l == LOOP).count()
    }

    /// How many segments could not be followed although faces are there; 0 on a mesh without edges of three faces.
    #[must_use]
    pub fn broken(&self) -> usize {
        self.links.iter().flatten().filter(|&&l| l == BROKEN).count()
    }

    fn link(&mut self, surface: &Surface, crossings: &[Crossing]) {
        let topology = &surface.topology;
        self.first_of_edge.resize(topology.edges.len(), NONE);
        for (i, c) in crossings.iter().enumerate().rev() {
            self.first_of_edge[c.edge as usize] = i as u32;
        }
        self.links.clear();
        self.loop_vertex.clear();
        for c in crossings {
            let mut link = [BORDER; 2];
            let mut vertex = [NONE; 2];
            for k in 0..2 {
                let g = topology.edge_faces[c.edge as usize][k];
                if g == NONE {
                    continue;
                }
                let same = topology.face_edges[g as usize].into_iter().filter(|&e| e != c.edge);
                let other = topology.face_edges[c.face as usize];
                let found = same
                    .filter_map(|e| self.find(crossings, e, c.face))
                    .chain(other.into_iter().filter_map(|e| self.find(crossings, e, g)))
                    .next();
                if let Some(next) = found {
                    link[k] = next;
                    continue;
                }
                let (a, b) = (topology.faces[c.face as usize], topology.faces[g as usize]);
                if let Some(v) = a.into_iter().find(|v| b.contains(v)) {
                    link[k] = LOOP;
                    vertex[k] = v;
                } else {
                    link[k] = BROKEN;
                }
            }
            self.links.push(link);
            self.loop_vertex.push(vertex);
        }
        for c in crossings {
            self.first_of_edge[c.edge as usize] = NONE;
        }
    }

    fn find(&self, crossings: &[Crossing], edge: u32, face: u32) -> Option<u32> {
        let first = self.first_of_edge[edge as usize];
        if first == NONE {
            return None;
        }
        // Mostly an edge crosses one face; one that crosses thousands is searched in steps that double.
        let from_here = &crossings[first as usize..];
        let is_before = |c: &Crossing| (c.edge, c.face) < (edge, face);
        let mut past = 1;
        while from_here.get(past).is_some_and(is_before) {
            past *= 2;
        }
        let at = from_here[..from_here.len().min(past + 1)].partition_point(is_before);
        from_here.get(at).filter(|c| (c.edge, c.face) == (edge, face)).map(|_| first + at as u32)
    }

    fn walk_all(&mut self, surface: &Surface, crossings: &[Crossing]) {
        let n = crossings.len();
        self.path_of.clear();
        self.path_of.resize(n, NONE);
        self.side.clear();
        self.side.resize(n, 0);
        self.paths.clear();
        for i in 0..n {
            for k in 0..2 {
                if self.path_of[i] == NONE && self.links[i][k] >= FIRST_END {
                    self.walk(surface, crossings, i, k);
                }
            }
        }
        for i in 0..n {
            if self.path_of[i] == NONE {
                self.walk(surface, crossings, i, 0);
            }
        }
    }

    /// Follows the curve from crossing `start`, leaving it by the slot that is not `enter`.
    fn walk(&mut self, surface: &Surface, crossings: &[Crossing], start: usize, enter: usize) {
        let id = self.paths.len() as u32;
        let mut path = Path { root: id, ..Path::default() };
        path.ends[0] = self.end(start, enter, 0);
        let (mut node, mut out, mut side) = (start, 1 - enter, 0u8);
        loop {
            self.path_of[node] = id;
            self.side[node] = side;
            let next = self.links[node][out];
            if next >= FIRST_END {
                path.ends[1] = self.end(node, out, side);
                break;
            }
            if next as usize == start && path.ends[0].code < FIRST_END {
                path.closed = true;
                break;
            }
            if self.path_of[next as usize] != NONE {
                path.ends[1] = End { code: BROKEN, vertex: NONE, side, node: node as u32 };
                break;
            }
            let (here, there) = (&crossings[node], &crossings[next as usize]);
            let g = surface.topology.edge_faces[here.edge as usize][out];
            let flips = there.face != here.face;
            let through = if flips { here.face } else { g };
            let enter = surface.topology.edge_faces[there.edge as usize].iter().position(|&x| x == through);
            side ^= u8::from(flips);
            node = next as usize;
            let Some(enter) = enter else {
                // A third face of an edge is not listed there: the walk ends as at a border.
                self.path_of[node] = id;
                self.side[node] = side;
                path.ends[1] = End { code: BROKEN, vertex: NONE, side, node: node as u32 };
                break;
            };
            out = 1 - enter;
        }
        self.paths.push(path);
    }

    fn end(&self, node: usize, slot: usize, side: u8) -> End {
        End { code: self.links[node][slot], vertex: self.loop_vertex[node][slot], side, node: node as u32 }
    }

    /// Paths that end in the same loop vertex are one contour; where both reach a border, the borders are put on one side.
    fn join_at_loops(&mut self) {
        self.loops.clear();
        for (i, path) in self.paths.iter().enumerate() {
            if !path.closed {
                self.loops.extend(path.ends.iter().filter(|e| e.code == LOOP).map(|e| (e.vertex, i as u32)));
            }
        }
        self.loops.sort_unstable();
        for k in 1..self.loops.len() {
            let ((v, a), (w, b)) = (self.loops[k - 1], self.loops[k]);
            if v != w {
                continue;
            }
            let (ra, rb) = (self.root(a), self.root(b));
            if ra == rb {
                continue;
            }
            let (keep, gone) = (ra.min(rb), ra.max(rb));
            let flip = match (self.border_of(a), self.border_of(b)) {
                (Some(x), Some(y)) => x ^ y,
                _ => 0,
            };
            let gone = &mut self.paths[gone as usize];
            (gone.root, gone.flip) = (keep, flip);
        }
        for path in 0..self.paths.len() as u32 {
            self.root(path);
        }
    }

    /// The first path of the contour that a path belongs to. It and all on the way there are led to it at once, with their
    /// flips.
    fn root(&mut self, path: u32) -> u32 {
        let (mut root, mut flip) = (path, 0);
        while self.paths[root as usize].root != root {
            flip ^= self.paths[root as usize].flip;
            root = self.paths[root as usize].root;
        }
        let mut next = path;
        while next != root {
            let path = &mut self.paths[next as usize];
            (next, path.root) = (path.root, root);
            flip ^= core::mem::replace(&mut path.flip, flip);
        }
        root
    }

    /// The side of a path's border; [`Self::root`] must have been asked for it.
    fn border_of(&self, path: u32) -> Option<u8> {
        let path = &self.paths[path as usize];
        path.ends.iter().find(|e| e.code == BORDER && !path.closed).map(|e| e.side ^ path.flip)
    }

    /// Numbers the contours by their first crossing, which is put on side 0, and groups the crossings.
    fn group(&mut self) {
        self.contours.clear();
        self.contour_of.clear();
        for path in &mut self.paths {
            path.contour = NONE;
        }
        for i in 0..self.path_of.len() {
            let root = self.paths[self.path_of[i] as usize].root as usize;
            if self.paths[root].contour == NONE {
                self.paths[root].contour = self.contours.len() as u32;
                self.contours.push(Contour { loops: [NONE; 2], border_ends: [NONE; 2], ..Contour::default() });
            }
            let contour = self.paths[root].contour;
            self.contour_of.push(contour);
            self.contours[contour as usize].count += 1;
        }
        let mut first = 0;
        for c in &mut self.contours {
            c.first = first;
            first += c.count;
            c.count = 0;
        }
        self.nodes.clear();
        self.nodes.resize(self.path_of.len(), 0);
        for i in 0..self.path_of.len() {
            let c = &mut self.contours[self.contour_of[i] as usize];
            self.nodes[(c.first + c.count) as usize] = i as u32;
            c.count += 1;
            self.side[i] ^= self.paths[self.path_of[i] as usize].flip;
        }
        for k in 0..self.contours.len() {
            let first = self.nodes[self.contours[k].first as usize] as usize;
            self.contours[k].border_side = self.side[first];
        }
        for (side, &contour) in self.side.iter_mut().zip(&self.contour_of) {
            *side ^= self.contours[contour as usize].border_side;
        }
    }

    fn classify(&mut self) {
        self.tallies.clear();
        self.tallies.resize(self.contours.len(), Tally::default());
        for path in self.paths.iter().filter(|p| !p.closed) {
            let contour = self.paths[path.root as usize].contour as usize;
            let (c, tally) = (&mut self.contours[contour], &mut self.tallies[contour]);
            for end in path.ends {
                match end.code {
                    LOOP if c.loops.contains(&end.vertex) => {}
                    LOOP => {
                        if let Some(free) = c.loops.iter_mut().find(|l| **l == NONE) {
                            *free = end.vertex;
                        }
                        tally.loops += 1;
                    }
                    BORDER => {
                        tally.borders[usize::from(end.side ^ path.flip ^ c.border_side)] += 1;
                        if let Some(free) = c.border_ends.iter_mut().find(|l| **l == NONE) {
                            *free = end.node;
                        }
                    }
                    _ => tally.broken = true,
                }
            }
        }
        for (c, tally) in self.contours.iter_mut().zip(&self.tallies) {
            c.border_side = u8::from(tally.borders[1] > 0);
            c.kind = tally.kind();
        }
    }

    fn measure(&mut self, surface: &Surface, crossings: &[Crossing], points: &[Vec3], at: impl Fn(u32) -> Vec3) {
        for k in 0..self.contours.len() {
            let c = self.contours[k];
            let (mut length, mut sum, mut edges) = (0.0, Vec3::ZERO, 0.0);
            for &i in &self.nodes[c.first as usize..(c.first + c.count) as usize] {
                let p = points[i as usize];
                sum += p;
                let [a, b] = surface.topology.edges[crossings[i as usize].edge as usize].map(|v| surface.rest[v as usize]);
                edges += a.distance(b);
                for (&link, &vertex) in self.links[i as usize].iter().zip(&self.loop_vertex[i as usize]) {
                    if link == LOOP {
                        length += p.distance(at(vertex));
                    } else if link < FIRST_END && link > i {
                        length += p.distance(points[link as usize]);
                    }
                }
            }
            self.contours[k].length = length;
            self.contours[k].centre = sum / c.count.max(1) as f32;
            self.contours[k].edge = edges / c.count.max(1) as f32;
        }
    }
}

/// The ends of a contour, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Tally {
    loops: u32,
    borders: [u32; 2],
    broken: bool,
}

impl Tally {
    fn kind(self) -> ContourKind {
        let [a, b] = self.borders;
        match (self.loops, a.max(b), a.min(b)) {
            _ if self.broken => ContourKind::Unknown,
            (0, 0, 0) => ContourKind::Closed,
            (1, 0, 0) => ContourKind::Eight,
            (2, 0, 0) => ContourKind::Ll,
            (0, 2, 0) => ContourKind::Bbii,
            (0, 1, 1) => ContourKind::Bibi,
            (1, 1, 0) => ContourKind::Bli,
            (1, 2, 0) => ContourKind::Cross,
            _ => ContourKind::Unknown,
        }
    }
}
impl Verdict {
    /// Takes in a contour.
    pub(in crate::solver) fn add(&mut self, contour: &Contour) {
        self.crossings += contour.count;
        self.contours += 1;
        self.contour_length += contour.length;
        self.regions += u32::from(contour.kind.separates());
    }
}
