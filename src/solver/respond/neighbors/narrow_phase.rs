//! Two leaves whose boxes meet: the particles and edges of their faces are asked how far apart they are.

use core::ops::Range;

use glam::{Vec3A, Vec4};

use super::batch::{BATCH, Batch};
use super::gap::{may_cross, near, way};
use super::near::{Near, rest_matters};
use super::outcome::Outcome;
use super::patch::{Laid, Patches, boxes_within};
use super::refresh::CLOSE;
use super::{MARGIN, Moment, NeighborList};
use crate::solver::body::Touch;
use crate::solver::detect::tree::{LEAF, LeafRef, Meeting, Tree, lanes};
use crate::solver::detect::{ProximityKind, Surface};
use crate::solver::effort::Meter;

/// Visits that it costs to ask two faces, and how far apart two of their primitives are.
const ASK: usize = 3;
const PRIMITIVES: usize = 2;

/// What leaves are asked in: the same for all that ask.
pub(super) struct Search<'a, T> {
    pub(super) surface: &'a Surface,
    /// Position `[m]` and, in `w`, inverse mass `[1/kg]` of every particle, and where it is foreseen to be `[m]`.
    pub(super) positions: &'a [Vec4],
    pub(super) ahead: &'a [Vec3A],
    /// Thickness and friction of each cloth, and whether it rests on cloths at all.
    pub(super) touch: &'a [Touch],
    pub(super) takes_part: &'a [bool],
    /// Whether pins hold each particle.
    pub(super) pinned: &'a [bool],
    /// Longest edge of each cloth at rest `[m]`.
    longest: &'a [f32],
    /// Particles around which cloth may lie over itself.
    loose: &'a [bool],
    pub(super) patches: &'a Patches,
    /// Pairs on the wrong side, sorted.
    inverted: &'a [(u8, [u32; 4])],
    /// How much a particle belongs to a tangle (0 to 1, dimensionless).
    pub(super) tangled: T,
    /// How close boxes must come `[m]`, and the largest thickness `[m]`.
    reach: f32,
    thickest: f32,
    /// Whether the last look for crossings saw the faces elsewhere.
    anew: bool,
}

impl<T> Search<'_, T> {
    /// Whether a pair is on the wrong side.
    pub(super) fn is_inverted(&self, kind: ProximityKind, particles: [u32; 4]) -> bool {
        !self.inverted.is_empty() && self.inverted.binary_search(&(kind as u8, particles)).is_ok()
    }
}

/// What is known of a surface, for a [`Search`].
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    pub(super) ahead: &'a [Vec3A],
    pub(super) longest: &'a [f32],
    pub(super) loose: &'a [bool],
    pub(super) patches: &'a Patches,
}

impl<'a> Known<'a> {
    /// What leaves are asked in whose boxes meet. `anew`: whether the last look for crossings saw the faces elsewhere.
    pub(super) fn search<T: Fn(u32) -> f32>(
        self,
        surface: &'a Surface,
        moment: &Moment<'a>,
        tangled: T,
        inverted: &'a [(u8, [u32; 4])],
        anew: bool,
    ) -> Search<'a, T> {
        let &Moment { positions, touch, takes_part, pinned, .. } = moment;
        let (reach, thickest) = (NeighborList::reach(moment), moment.thickest());
        let Self { ahead, longest, loose, patches } = self;
        Search {
            surface,
            positions,
            ahead,
            touch,
            takes_part,
            pinned,
            longest,
            loose,
            patches,
            inverted,
            tangled,
            reach,
            thickest,
            anew,
        }
    }
}

/// What leaves are asked with, by one thread.
pub(super) struct NarrowPhase<'a, T, F> {
    pub(super) search: &'a Search<'a, T>,
    /// Whether the cloth hardly bends around a particle.
    pub(super) is_flat: F,
    pub(super) laid: &'a mut Laid,
    /// What is near, until it is [listed](Self::finish).
    pub(super) batch: &'a mut Batch,
    pub(super) outcome: &'a mut Outcome,
    /// More than it allows is not asked, and may cross.
    pub(super) meter: &'a Meter,
}

impl<T: Fn(u32) -> f32, F: FnMut(u32) -> bool> NarrowPhase<'_, T, F> {
    /// Asks for what may touch of the faces of two leaves. `cross` is called with faces that may cross now, and returns whether
    /// something does. Then no more pairs are asked for, and `cross` is called with all faces that are left.
    pub(crate) fn leaves(&mut self, tree: &Tree, met: &Meeting, mut cross: impl FnMut(u32, u32) -> bool) {
        if self.meter.is_spent() {
            tree.pairs_of(met, |f, g| _ = cross(f, g));
            return;
        }
        self.meter.spend(ASK * met.count());
        let (a, b) = (tree.leaf(met.leaves[0]), tree.leaf(met.leaves[1]));
        let (u, v) = (a.corners[0][0], b.corners[0][0]);
        // A thick cloth does not make the others look farther.
        let search = self.search;
        let reach = if search.touch.len() == 1 { search.reach } else { self.reach_of(u, v) };
        let [flat, loose] = if met.joined { self.flat(a, b, met) } else { [[0; LEAF]; 2] };
        let [may, close, asked] = self.gaps(tree, met, &flat, reach);
        if (may, loose) == ([0; LEAF], [0; LEAF]) {
            return;
        }
        if may != [0; LEAF] {
            self.laid.fit(search.patches, met.leaves[1], search.positions, search.ahead);
        }
        let across = search.surface.part(u) != search.surface.part(v);
        let pair = Pair { leaves: [a, b], numbers: met.leaves, reach, across, joined: met.joined };
        for i in (0..a.faces.len()).filter(|&i| may[i] | loose[i] != 0) {
            if may[i] != 0 {
                pair.take(self, i, u32::from(may[i]));
            }
            for k in lanes(u32::from(close[i] | loose[i])) {
                let faces = [a.faces[i], b.faces[k]];
                if close[i] & (1 << k) != 0 || search.anew {
                    self.outcome.close.push(faces);
                }
                if (asked[i] | loose[i]) & (1 << k) != 0 && cross(faces[0], faces[1]) {
                    self.let_go(&pair, met, [i, k], cross);
                    return;
                }
            }
            if self.batch.len() >= BATCH {
                self.finish();
            }
        }
    }

    /// Asks no more after the pair of faces `at`, which cross.
    #[cold]
    fn let_go(&mut self, pair: &Pair<'_>, met: &Meeting, [i, k]: [usize; 2], mut cross: impl FnMut(u32, u32) -> bool) {
        let [a, b] = pair.leaves;
        // Noted together with what comes after it in its row.
        self.batch.retain(|near| near.faces[0] != a.faces[i] || !b.faces[k + 1..].contains(&near.faces[1]));
        for (row, &hits) in met.hits.iter().enumerate().skip(i) {
            let rest = if row == i { !1 << k } else { !0 };
            lanes(u32::from(hits) & rest).for_each(|k| _ = cross(a.faces[row], b.faces[k]));
        }
    }

    /// Lists what may touch of all that is near.
    pub(crate) fn finish(&mut self) {
        let &Search { surface, positions, ahead, touch, longest, .. } = self.search;
        self.batch.find(positions, ahead);
        self.batch.find_at_rest(&surface.rest, |found| rest_matters(surface, touch, longest, found));
        for i in 0..self.batch.len() {
            if self.batch.found(i).may_touch {
                let found = *self.batch.found(i);
                self.meter.spend(PRIMITIVES);
                self.list(&found);
            }
        }
        self.batch.clear();
    }

    /// How close the boxes of faces at particles `u` and `v` must come `[m]`.
    #[inline]
    fn reach_of(&self, u: u32, v: u32) -> f32 {
        let Search { surface, touch, .. } = self.search;
        let [a, b] = [u, v].map(|v| touch[usize::from(surface.part(v))].thickness);
        (1.0 + MARGIN) * 0.5 * (a + b)
    }

    /// Which faces of two leaves that meet lie in one fan that hardly bends: they are hardly closer than at rest. And which of
    /// them may cross all the same, as cloth is cut or sewn there.
    #[inline]
    fn flat(&mut self, a: LeafRef<'_>, b: LeafRef<'_>, met: &Meeting) -> [[u8; LEAF]; 2] {
        let [mut flat, mut loose] = [[0; LEAF]; 2];
        for (i, corners) in a.corners.iter().enumerate() {
            for k in lanes(u32::from(met.hits[i])) {
                let mut shared = corners.iter().filter(|v| b.corners[k].contains(v));
                if let Some(&v) = shared.find(|&&v| (self.is_flat)(v)) {
                    flat[i] |= 1 << k;
                    loose[i] |= u8::from(self.search.loose[v as usize]) << k;
                }
            }
        }
        [flat, loose]
    }

    /// Which faces of two leaves that meet, except those that are `flat`, may come within `reach` `[m]`. Which are so close
    /// that they may cross before they are looked at again, and which of these may cross now.
    #[inline]
    fn gaps(&mut self, tree: &Tree, met: &Meeting, flat: &[u8; LEAF], reach: f32) -> [[u8; LEAF]; 3] {
        let [mut may, mut close, mut cross] = [[0; LEAF]; 3];
        let [a, b] = met.leaves;
        if met.hits == *flat {
            return [may, close, cross];
        }
        let &Search { positions, ahead: there, thickest, .. } = self.search;
        let lanes = self.laid.lanes(tree, b, positions, there);
        let within = CLOSE * thickest;
        for (i, &t) in tree.leaf(a).corners.iter().enumerate() {
            let hits = met.hits[i] & !flat[i];
            if hits != 0 {
                let now = [positions[t[0] as usize], positions[t[1] as usize], positions[t[2] as usize]];
                let ahead = [there[t[0] as usize], there[t[1] as usize], there[t[2] as usize]];
                [may[i], close[i]] = near(now, ahead, lanes, hits, reach, within);
                cross[i] = may_cross(now, lanes, close[i]);
            }
        }
        [may, close, cross]
    }
}

/// Two leaves that meet.
struct Pair<'a> {
    leaves: [LeafRef<'a>; 2],
    numbers: [u32; 2],
    /// How close boxes must come `[m]`.
    reach: f32,
    /// Whether they are of two cloths, and whether they may share particles.
    across: bool,
    joined: bool,
}

impl Pair<'_> {
    /// Notes what is near of face `i` of the first leaf and the `faces` of the second, a bit for each. Of two faces first the
    /// corners that each owns with the other face, then the edges that both own. What shares a particle is not.
    #[inline]
    fn take<T, F>(&self, asked: &mut NarrowPhase<'_, T, F>, i: usize, faces: u32) {
        let &Search { patches, positions, ahead, .. } = asked.search;
        let NarrowPhase { laid, batch, .. } = asked;
        let &Self { leaves: [a, b], numbers, reach, across, joined } = self;
        let [[corners, edges], [their_corners, their_edges]] = numbers.map(|leaf| patches.owned(leaf));
        let [corner_boxes, edge_boxes] = laid.boxes(patches, numbers[1]);
        let (mine, wide, t) = (edges.of_face(i), Vec3A::splat(reach), a.corners[i]);
        let way = |v: u32| way(positions, ahead, v);
        // What comes close to the face, and to each corner and edge that it owns.
        let theirs = boxes_within(corner_boxes, &way(t[0]).union(way(t[1])).union(way(t[2])), reach);
        let [mut corner_met, mut edge_met] = [[0; 3]; 2];
        for (met, &[v, _]) in corner_met.iter_mut().zip(&corners.ends[corners.of_face(i)]) {
            *met = b.within(&way(v), wide);
        }
        for (met, &[u, v]) in edge_met.iter_mut().zip(&edges.ends[mine.clone()]) {
            *met = boxes_within(edge_boxes, &way(u).union(way(v)), reach);
        }
        for k in lanes(faces) {
            let (u, faces) = (b.corners[k], [a.faces[i], b.faces[k]]);
            let mut note = |kind, particles| batch.push(Near { kind, particles, faces, reach, across });
            for (&[v, _], met) in corners.ends[corners.of_face(i)].iter().zip(corner_met) {
                if met & (1 << k) != 0 && !(joined && u.contains(&v)) {
                    note(ProximityKind::VertexFace, [v, u[0], u[1], u[2]]);
                }
            }
            for j in bits(theirs, their_corners.of_face(k)) {
                let [v, _] = their_corners.ends[j];
                if !(joined && t.contains(&v)) {
                    note(ProximityKind::VertexFace, [v, t[0], t[1], t[2]]);
                }
            }
            for (e, met) in edges.ends[mine.clone()].iter().zip(edge_met) {
                for j in bits(met, their_edges.of_face(k)) {
                    let h = their_edges.ends[j];
                    if !(joined && (h.contains(&e[0]) || h.contains(&e[1]))) {
                        note(ProximityKind::EdgeEdge, [e[0], e[1], h[0], h[1]]);
                    }
                }
            }
        }
    }
}

/// The bits in a range that are set, in ascending order.
#[inline]
fn bits(of: u32, range: Range<usize>) -> impl Iterator<Item = usize> {
    lanes(of & ((1 << range.end) - (1 << range.start)))
}
