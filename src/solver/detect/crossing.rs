//! Crossings of edges with faces, by orientation signs only.
//!
//! ```text
//! (u, v) crosses (p, q, r)  ⇔  orient(p,q,r,u) ≠ orient(p,q,r,v)  and
//!                               orient(u,v,p,q) = orient(u,v,q,r) = orient(u,v,r,p)
//!
//!              u                       t  = d(u) / (d(u) - d(v)),   d(x) = orient(p, q, r, x)
//!         p____|____r                  wₚ = orient(u,v,q,r) / sum of the three
//!          \   x   /
//!           \_ | _/       Pairs that share a particle are not asked: where surfaces cross at a shared particle,
//!             q|          the contour ends there, in a loop vertex. Faces in one plane do not cross.
//!              v
//! ```

use glam::{BVec3, DVec3, Vec3, Vec3A, Vec4};

use crate::solver::effort::{Effort, Meter};
use crate::solver::topology::NONE;

use super::beside::{are_beside, lies_beside_plane};
use super::four::{Four, WIDE, each};
use super::orient::{Plane, Point, Side, Ties, orient};
use super::parts::Parts;
use super::quiet::QuietPairs;
use super::surface::Surface;
use super::tree::{Meeting, Tree};

/// Visits that it costs to ask whether two faces cross, and those of a crossing, which is worked out, traced and recognized.
pub(crate) const PAIR: usize = 4;
const CROSSING: usize = 64;

/// An edge passing through a face.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Crossing {
    /// The edge.
    pub edge: u32,
    /// The face.
    pub face: u32,
    /// Where along the edge, from its first particle (0) to its second (1).
    pub t: f32,
    /// Weights of the face's corners at the crossing; not negative, sum 1.
    pub weights: [f32; 3],
    /// Whether some of the five orientations are exactly zero. It takes part in the contour like any other: surfaces of aligned
    /// grids can cut straight through each other with nothing but such crossings.
    pub touching: bool,
}

/// Finds crossings. Holds the search tree and reused buffers; allocates nothing once warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Detector {
    pub(super) tree: Tree,
    /// Bit `k` of entry `f`: face `f` asks for its edge `k`. Every edge is asked for by its first face only.
    asks: Vec<u8>,
    /// Cloths without a single free particle; two of them are not asked.
    kinematic: Vec<bool>,
    /// Cloths that move although nothing here moves them.
    moving: Vec<bool>,
    ties: Ties,
    /// Pairs of faces that met a tie.
    doubtful: Vec<(u32, u32)>,
    crossings: Vec<Crossing>,
    parts: Parts,
    /// Work that the last look was `[visits]`.
    visits: usize,
    pub(super) quiet: QuietPairs,
}

impl Detector {
    /// Prepares detection on a surface.
    #[must_use]
    pub fn new(surface: &Surface) -> Self {
        Self::with_tree(surface, Tree::of_surface(surface))
    }

    /// Prepares detection on a surface with its tree.
    #[must_use]
    pub(crate) fn with_tree(surface: &Surface, tree: Tree) -> Self {
        debug_assert_eq!((tree.len(), tree.cloths()), (surface.topology.faces.len(), surface.parts.len()));
        let topology = &surface.topology;
        let asks = topology.face_edges.iter().enumerate().map(|(f, edges)| {
            let first = |k: usize| topology.edge_faces[edges[k] as usize][0] == f as u32;
            (0..3).fold(0, |bits, k| bits | u8::from(first(k)) << k)
        });
        Self {
            tree,
            asks: asks.collect(),
            kinematic: vec![false; surface.parts.len()],
            moving: vec![false; surface.parts.len()],
            ties: Ties::default(),
            doubtful: Vec::new(),
            crossings: Vec::new(),
            parts: Parts::default(),
            visits: 0,
            quiet: QuietPairs::new(surface),
        }
    }

    /// Forgets what was found of cloth that hardly moves: another part of it counts now.
    pub fn forget(&mut self) {
        self.quiet.forget();
    }

    /// Forgets what was found of cloth that hardly moves, of a surface that is some times as large now.
    pub(crate) fn rescale(&mut self, surface: &Surface) {
        self.quiet.rescale(surface);
    }

    /// Finds all crossings at `positions` (`[m]`, `w` inverse mass), sorted by edge, then face.
    ///
    /// A cloth with a particle that is not finite or farther out than 1e6 m takes no part.
    pub fn detect(&mut self, surface: &Surface, positions: &[Vec4]) -> &[Crossing] {
        if positions.len() == surface.len() {
            self.tree.refit(surface, positions, None);
        }
        self.detect_everywhere(surface, positions);
        &self.crossings
    }

    /// As [`Self::detect`], in a tree that was fitted to `positions`.
    fn detect_everywhere(&mut self, surface: &Surface, positions: &[Vec4]) {
        self.detect_and(surface, positions, 0.0, |tree, met, crosser| {
            tree.pairs_of(met, |f, g| {
                crosser.ask(f, g);
            });
        });
    }

    /// As [`Self::detect`], of cloth that is looked at in every frame: only at what was close where it has hardly moved since.
    pub fn detect_again(&mut self, surface: &Surface, positions: &[Vec4]) -> &[Crossing] {
        if positions.len() != surface.len() {
            return self.detect(surface, positions);
        }
        let mut quiet = core::mem::take(&mut self.quiet);
        let known = quiet.close(positions).is_some_and(|close| self.detect_among(surface, positions, close).is_empty());
        if !known {
            self.tree.refit(surface, positions, None);
            if quiet.begin(surface, positions) {
                self.detect_and(surface, positions, quiet.reach, |tree, met, crosser| {
                    tree.pairs_of(met, |f, g| {
                        quiet.take_in(surface, positions, [f, g]);
                        crosser.ask(f, g);
                    });
                });
                let all = (0..surface.parts.len()).all(|part| !self.is_quarantined(part as u16));
                if all && self.parts.is_whole && self.crossings.is_empty() {
                    quiet.end();
                }
            } else {
                self.detect_everywhere(surface, positions);
            }
        }
        self.quiet = quiet;
        &self.crossings
    }

    /// As [`Self::detect`], in a [tree](Self::tree) that was fitted to `positions`. Calls `also` with every two leaves that
    /// have faces whose boxes come within `margin` `[m]`, to ask about those that may cross. Once an edge is known to cross a
    /// face, `also` is called no more.
    pub(crate) fn detect_and(
        &mut self,
        surface: &Surface,
        positions: &[Vec4],
        margin: f32,
        mut also: impl FnMut(&Tree, &Meeting, &mut Crosser<'_>),
    ) -> &[Crossing] {
        if positions.len() != surface.len() {
            self.crossings.clear();
            return &self.crossings;
        }
        let meter = self.parts.most.meter();
        let mut parts = [true; 2];
        self.cross(surface, positions, &meter, |tree, crosser| {
            parts = tree.go_on(surface, margin, &meter, |tree, met| {
                meter.spend(PAIR * met.count());
                if crosser.found() {
                    tree.pairs_of(met, |f, g| {
                        crosser.ask(f, g);
                    });
                } else {
                    also(tree, met, crosser);
                }
            });
        });
        self.parts.note(self.crossings.len() as u32, parts);
        &self.crossings
    }

    /// As [`Self::detect_and`], where somebody else walked all of the [tree](Self::tree_ref): `asks` are the faces that may
    /// cross, `visits` what the walk was. False where some cross, or where that was too much work: then nothing of it counts.
    pub(crate) fn detect_asked(
        &mut self,
        surface: &Surface,
        positions: &[Vec4],
        mut asks: impl Iterator<Item = [u32; 2]>,
        visits: usize,
    ) -> bool {
        debug_assert!(!self.tree.has_left(), "a walk in parts goes on where it was");
        if positions.len() != surface.len() {
            return false;
        }
        let meter = Effort::UNBOUNDED.meter();
        meter.spend(visits);
        let mut cross = false;
        self.cross(surface, positions, &meter, |_, crosser| cross = asks.any(|[f, g]| crosser.ask(f, g)));
        // Edges that meet a tie are visits, too.
        if cross || !self.parts.most.allows(self.visits) {
            return false;
        }
        self.parts.note(self.crossings.len() as u32, [true; 2]);
        true
    }

    /// Bounds the work of one look: what is more is left to the next one.
    pub fn bound(&mut self, most: Effort) {
        self.parts.most = most;
    }

    /// Whether the last look was at all of the cloth, not at a part of it only.
    #[must_use]
    pub(crate) fn is_whole(&self) -> bool {
        self.parts.is_whole
    }

    /// Number of edges that crossed faces elsewhere, when that was looked at, where the last look was at a part of the cloth
    /// only. At least 1 while some of the cloth was never looked at.
    #[must_use]
    pub fn elsewhere(&self) -> u32 {
        self.parts.elsewhere
    }

    /// Says whether a cloth without an inverse mass moves all the same: of two that do not, crossings are not looked for.
    pub(crate) fn set_moving(&mut self, part: usize, moving: bool) {
        if let Some(of) = self.moving.get_mut(part) {
            *of = moving;
        }
    }

    /// As [`Self::detect`], where only `pairs` of faces can cross.
    pub(crate) fn detect_among(&mut self, surface: &Surface, positions: &[Vec4], pairs: &[[u32; 2]]) -> &[Crossing] {
        let meter = Effort::UNBOUNDED.meter();
        self.cross(surface, positions, &meter, |_, crosser| {
            for four in pairs.chunks(WIDE) {
                let beside = crosser.are_beside(four);
                for (_, &[f, g]) in (0..).zip(four).filter(|(k, _)| beside & (1 << k) == 0) {
                    crosser.ask(f, g);
                }
            }
        });
        self.parts.note_whole();
        &self.crossings
    }

    fn cross(&mut self, surface: &Surface, positions: &[Vec4], meter: &Meter, pairs: impl FnOnce(&mut Tree, &mut Crosser<'_>)) {
        let Self { tree, asks, kinematic, moving, ties, doubtful, crossings, .. } = self;
        for ((part, out), moves) in surface.parts.iter().zip(kinematic.iter_mut()).zip(&*moving) {
            let range = part.range();
            *out = !moves && positions[range].iter().all(|p| p.w == 0.0);
        }
        ties.directions.clear();
        crossings.clear();
        doubtful.clear();
        let fixed = kinematic.iter().any(|&k| k);
        let kinematic = fixed.then_some(kinematic.as_slice());
        pairs(tree, &mut Crosser { surface, positions, asks, kinematic, ties, doubtful, crossings, meter });
        self.visits = meter.spent();
        if !self.doubtful.is_empty() {
            self.cross_doubtful(surface, positions);
        }
        self.crossings.sort_unstable_by_key(|c| (u64::from(c.edge) << 32) | u64::from(c.face));
        // No crossing is found twice: each edge and each face has one owner.
        debug_assert!(self.crossings.windows(2).all(|pair| (pair[0].edge, pair[0].face) < (pair[1].edge, pair[1].face)));
    }

    /// Some points lie exactly in a plane, as borders that are pinned along a line do. Pairs that met such a tie are asked
    /// again, with a direction for each of their particles. Every pair that asks about the same four points met the same tie.
    #[cold]
    fn cross_doubtful(&mut self, surface: &Surface, positions: &[Vec4]) {
        let Self { asks, ties, doubtful, crossings, .. } = self;
        ties.directions.resize(surface.len(), DVec3::ZERO);
        for &(f, g) in doubtful.iter() {
            for v in [f, g].into_iter().flat_map(|face| surface.topology.faces[face as usize]) {
                let direction = &mut ties.directions[v as usize];
                if *direction == DVec3::ZERO {
                    *direction = Ties::direction(normal(surface, positions, v), surface.part(v), v);
                }
            }
        }
        for &(f, g) in doubtful.iter() {
            cross_faces(surface, positions, asks, f, g, ties, crossings);
        }
    }

    /// The crossings found last.
    #[must_use]
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings
    }

    /// Work that the last look was, in visits: what is done about one particle, edge, crossing or pair of faces.
    #[must_use]
    pub fn visits(&self) -> usize {
        self.visits
    }

    /// Whether a cloth was left out of the last detection because a particle of it is not finite or absurdly far away.
    #[must_use]
    pub fn is_quarantined(&self, part: u16) -> bool {
        self.tree.is_quarantined(part)
    }

    /// The search tree, fitted to where everything was at the last look at all of it, or at what had drifted since.
    pub fn tree(&mut self) -> &mut Tree {
        &mut self.tree
    }

    /// The search tree, to be looked at.
    #[must_use]
    pub(crate) fn tree_ref(&self) -> &Tree {
        &self.tree
    }
}

/// Asks faces whether they cross.
#[derive(Debug)]
pub(crate) struct Crosser<'a> {
    surface: &'a Surface,
    positions: &'a [Vec4],
    asks: &'a [u8],
    /// Cloths of which two are not asked, where there are any.
    kinematic: Option<&'a [bool]>,
    ties: &'a mut Ties,
    doubtful: &'a mut Vec<(u32, u32)>,
    crossings: &'a mut Vec<Crossing>,
    meter: &'a Meter,
}

impl Crosser<'_> {
    /// Whether something is known to cross.
    #[must_use]
    pub(crate) fn found(&self) -> bool {
        !self.crossings.is_empty()
    }

    /// Which of up to four pairs of faces are sure to lie beside each other, a bit for each.
    #[inline]
    fn are_beside(&self, pairs: &[[u32; 2]]) -> u32 {
        let Some(last) = pairs.len().checked_sub(1) else { return 0 };
        let corners = |side: usize| each(|k| self.surface.topology.faces[pairs[k.min(last)][side] as usize]);
        let at = |of: &[[u32; 3]; WIDE], c: usize| Four::of(each(|k| self.positions[of[k][c] as usize]));
        let [f, g] = [corners(0), corners(1)].map(|of| [at(&of, 0), at(&of, 1), at(&of, 2)]);
        are_beside(&f, &g)
    }

    /// Asks two faces; whether they, or others before, cross.
    #[inline]
    pub(crate) fn ask(&mut self, f: u32, g: u32) -> bool {
        let Self { surface, positions, asks, kinematic, ties, doubtful, crossings, meter } = self;
        let still = |kinematic: &[bool], face: u32| kinematic[usize::from(surface.part_of_face(face))];
        if kinematic.is_some_and(|kinematic| still(kinematic, f) && still(kinematic, g)) {
            return !crossings.is_empty();
        }
        let sure = crossings.len();
        ties.met = false;
        cross_faces(surface, positions, asks, f, g, ties, crossings);
        meter.spend(CROSSING * (crossings.len() - sure));
        if ties.met {
            crossings.truncate(sure);
            doubtful.push((f, g));
        }
        !crossings.is_empty()
    }
}

#[inline]
fn point(positions: &[Vec4], id: u32) -> Point {
    let p = positions[id as usize];
    Point { id, at: DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z)) }
}

/// Unit normal of the surface at a particle; zero where there is none.
fn normal(surface: &Surface, positions: &[Vec4], particle: u32) -> DVec3 {
    let topology = &surface.topology;
    let mut sum = DVec3::ZERO;
    for &(_, edge) in topology.around(particle) {
        for face in topology.edge_faces[edge as usize] {
            if face != NONE {
                let [a, b, c] = topology.faces[face as usize].map(|v| point(positions, v).at);
                sum += (b - a).cross(c - a);
            }
        }
    }
    let normal = sum.normalize_or_zero();
    if normal.is_finite() { normal } else { DVec3::ZERO }
}

/// Asks the edges of two faces against the other face.
#[inline]
fn cross_faces(surface: &Surface, positions: &[Vec4], asks: &[u8], f: u32, g: u32, ties: &mut Ties, out: &mut Vec<Crossing>) {
    let (tf, tg) = (surface.topology.faces[f as usize], surface.topology.faces[g as usize]);
    let shared = [0, 1, 2].map(|i| tf[i] == tg[0] || tf[i] == tg[1] || tf[i] == tg[2]);
    let count = shared.iter().filter(|&&s| s).count();
    if count >= 2
        || (asks[f as usize] | asks[g as usize]) == 0
        || are_apart(positions, tf, tg, (count == 1).then_some(shared), 0.0)
    {
        return;
    }
    let near_g = tg.map(|v| tf.contains(&v));
    if lies_beside_plane(positions, tf, tg, near_g) || lies_beside_plane(positions, tg, tf, shared) {
        return;
    }
    cross_close_faces(surface, positions, asks, [f, g], [tf, tg], [shared, near_g], ties, out);
}

#[expect(clippy::too_many_arguments, reason = "buffers that are borrowed apart from the detector")]
fn cross_close_faces(
    surface: &Surface,
    positions: &[Vec4],
    asks: &[u8],
    [f, g]: [u32; 2],
    [tf, tg]: [[u32; 3]; 2],
    [near_f, near_g]: [[bool; 3]; 2],
    ties: &mut Ties,
    out: &mut Vec<Crossing>,
) {
    let (pf, pg) = (tf.map(|v| point(positions, v)), tg.map(|v| point(positions, v)));
    let Some(sides_f) = sides(&Plane::new(pg[0], pg[1], pg[2]), &pf, near_f, ties) else { return };
    let Some(sides_g) = sides(&Plane::new(pf[0], pf[1], pf[2]), &pg, near_g, ties) else { return };
    let mut cross = |face: u32, corners: &[Point; 3], sides: &[Option<Side>; 3], other: u32, target: &[Point; 3]| {
        for k in 0..3 {
            if asks[face as usize] & (1 << k) == 0 {
                continue;
            }
            let j = (k + 1) % 3;
            // In the direction of the stored edge, smaller particle first.
            let (k, j) = if corners[k].id < corners[j].id { (k, j) } else { (j, k) };
            let (Some(from), Some(to)) = (sides[k], sides[j]) else { continue };
            if from.positive != to.positive {
                let edge = surface.topology.face_edges[face as usize][if (k + 1) % 3 == j { k } else { j }];
                out.extend(cross_edge(edge, corners[k], corners[j], [from, to], other, target, ties));
            }
        }
    };
    cross(f, &pf, &sides_f, g, &pg);
    cross(g, &pg, &sides_g, f, &pf);
}

/// Whether a plane across the line between the centres has the faces on different sides, at least `gap` `[m]` apart, a shared
/// particle aside. This test is cheap, and dismisses almost all neighbours in a smooth sheet.
#[inline]
pub(super) fn are_apart(positions: &[Vec4], f: [u32; 3], g: [u32; 3], shared: Option<[bool; 3]>, gap: f32) -> bool {
    let at = |v: u32| Vec3A::from_vec4(positions[v as usize]);
    let (a, b) = ([at(f[0]), at(f[1]), at(f[2])], [at(g[0]), at(g[1]), at(g[2])]);
    let origin = b[0];
    let axis = (a[0] + a[1] + a[2]) - (b[0] + b[1] + b[2]);
    let along = |p: Vec3A| (p - origin).dot(axis);
    let (a, b) = (Vec3::new(along(a[0]), along(a[1]), along(a[2])), Vec3::new(0.0, along(b[1]), along(b[2])));
    // Rounding of the dot products is some 1e-6 of the scale of its terms.
    let slack = 1.0e-4 * a.abs().max(b.abs()).max_element() + f32::MIN_POSITIVE;
    let slack = if gap > 0.0 { slack + gap * axis.length() } else { slack };
    let Some(shared) = shared else { return a.min_element() > b.max_element() + slack };
    // The shared particle is where one side ends and the other begins.
    let (mine, others) = (BVec3::from_array(shared), BVec3::from_array(g.map(|v| f.contains(&v))));
    let border = Vec3::select(mine, a, Vec3::ZERO).element_sum();
    let (low, high) = (Vec3::select(mine, Vec3::INFINITY, a), Vec3::select(others, Vec3::NEG_INFINITY, b));
    low.min_element() > border + slack && high.max_element() < border - slack
}

/// Sides of three points, `None` for one shared with the plane. Returns nothing when no crossing is possible, as all points are
/// clear of the plane on one side, or all lie in it.
#[inline]
fn sides(plane: &Plane, points: &[Point; 3], shared: [bool; 3], ties: &mut Ties) -> Option<[Option<Side>; 3]> {
    let mut sides = [None; 3];
    let (mut above, mut below) = (true, true);
    for k in 0..3 {
        if !shared[k] {
            let Some(side) = plane.clear_side(points[k]) else { return doubtful_sides(plane, points, shared, ties) };
            above &= side.positive;
            below &= !side.positive;
            sides[k] = Some(side);
        }
    }
    if above || below { None } else { Some(sides) }
}

#[cold]
fn doubtful_sides(plane: &Plane, points: &[Point; 3], shared: [bool; 3], ties: &mut Ties) -> Option<[Option<Side>; 3]> {
    if (0..3).all(|k| shared[k] || plane.holds(points[k])) {
        return None;
    }
    Some([0, 1, 2].map(|k: usize| if shared[k] { None } else { Some(plane.side(points[k], ties)) }))
}

/// Asks the edge `(u, v)`, whose ends lie on different sides of the plane of `face`, whether it passes inside the face.
fn cross_edge(
    edge: u32,
    u: Point,
    v: Point,
    ends: [Side; 2],
    face: u32,
    &[p, q, r]: &[Point; 3],
    ties: &mut Ties,
) -> Option<Crossing> {
    let around = [orient(u, v, q, r, ties), orient(u, v, r, p, ties), orient(u, v, p, q, ties)];
    if around[0].positive != around[1].positive || around[1].positive != around[2].positive {
        return None;
    }
    Some(Crossing {
        edge,
        face,
        t: parameter(ends[0].value, ends[1].value),
        weights: weights(around.map(|s| s.value)),
        touching: around.iter().chain(&ends).any(|s| s.tie),
    })
}

fn parameter(from: f64, to: f64) -> f32 {
    let t = from / (from - to);
    if t.is_finite() { t.clamp(0.0, 1.0) as f32 } else { 0.5 }
}

fn weights(around: [f64; 3]) -> [f32; 3] {
    let sign = around.iter().sum::<f64>().signum();
    let w = around.map(|a| (a * sign).max(0.0));
    let sum: f64 = w.iter().sum();
    if sum > 0.0 { w.map(|w| (w / sum) as f32) } else { [1.0 / 3.0; 3] }
}
