//! Two faces whose boxes meet: their particles and edges are asked how far apart they are.

use glam::{Vec3A, Vec4};

use super::flat::Flatness;
use super::gap::{CYCLE, Gaps, Path, corners, may_pass};
use super::refresh::DRIFT;
use super::{Contacts, Finder, MARGIN, Moment, Touch};
use crate::solver::detect::Surface;
use crate::solver::detect::proximity::{closest_edges, vertex_face};
use crate::solver::detect::tree::Bounds;
use crate::solver::effort::Meter;

/// Visits that it costs to ask two faces, and how far apart two of their primitives are.
const ASK: usize = 3;
pub(super) const PRIMITIVES: usize = 2;

/// Pairs listed for each particle, at most; what comes on top, in cloth that is crushed, is left to untangling.
const MOST_PAIRS: usize = 32;

impl Finder {
    /// What to do with two faces whose boxes meet: their primitives are asked how far apart they are and will be. Whether it is
    /// asked `anew`, of faces nobody has looked for crossings at since they were elsewhere. Says of two faces whether they may
    /// cross now; more than the `meter` allows are not asked, and may.
    pub fn ask<'a>(
        &'a mut self,
        surface: &'a Surface,
        moment: &Moment<'a>,
        tangled: impl Fn(u32) -> f32 + 'a,
        contacts: &'a mut Contacts,
        anew: bool,
        meter: &'a Meter,
    ) -> impl FnMut(u32, u32) -> bool + 'a {
        let &Moment { positions, touch, takes_part, pinned, .. } = moment;
        let (reach, thickest) = (Self::reach(moment), moment.thickest());
        let Self { owns, ahead, longest, flatness, loose, .. } = self;
        let most = MOST_PAIRS * surface.len();
        let mut asked = Asked {
            surface,
            positions,
            ahead,
            touch,
            takes_part,
            pinned,
            owns,
            longest,
            loose,
            flatness,
            tangled,
            contacts,
            reach,
            thickest,
            most,
            anew,
            meter,
        };
        move |f: u32, g: u32| {
            meter.is_spent() || {
                meter.spend(ASK);
                asked.faces(f, g)
            }
        }
    }
}

/// What two faces are asked with.
pub(super) struct Asked<'a, T> {
    pub surface: &'a Surface,
    /// Position `[m]` and, in `w`, inverse mass `[1/kg]` of every particle, and where it is foreseen to be `[m]`.
    pub positions: &'a [Vec4],
    pub ahead: &'a [Vec3A],
    /// Thickness and friction of each cloth, and whether it rests on cloths at all.
    pub touch: &'a [Touch],
    pub takes_part: &'a [bool],
    /// Whether pins hold each particle.
    pub pinned: &'a [bool],
    /// Longest edge of each cloth at rest `[m]`.
    pub longest: &'a [f32],
    /// How much a particle belongs to a tangle (0 to 1, dimensionless).
    pub tangled: T,
    pub contacts: &'a mut Contacts,
    /// Pairs listed, at most.
    pub most: usize,
    /// Corners and edges that each face owns; particles around which cloth may lie over itself; where it hardly bends.
    owns: &'a [u8],
    loose: &'a [bool],
    flatness: &'a mut Flatness,
    /// How close boxes must come `[m]`, and the largest thickness `[m]`.
    reach: f32,
    thickest: f32,
    /// Whether nobody has looked for crossings of the faces since they were elsewhere.
    anew: bool,
    pub meter: &'a Meter,
}

/// One of two faces.
struct Side {
    corners: [u32; 3],
    /// Corners and edges that the face owns.
    owns: u8,
    paths: [Path; 3],
    /// Around the way of each corner, and of all.
    boxes: [Bounds; 3],
    whole: Bounds,
}

impl Side {
    #[inline]
    fn new(t: [u32; 3], owns: u8, paths: [Path; 3]) -> Self {
        let boxes = corners([0, 1, 2], |k: usize| paths[k].bounds());
        let whole = boxes[0].union(boxes[1]).union(boxes[2]);
        Self { corners: t, owns, paths, boxes, whole }
    }

    /// Whether the face owns an edge.
    #[inline]
    fn has_edges(&self) -> bool {
        self.owns & 0b11_1000 != 0
    }
}

impl<T: Fn(u32) -> f32> Asked<'_, T> {
    /// Lists what may touch of faces `f` and `g`, and the faces if they may cross; whether they may cross now.
    #[inline]
    fn faces(&mut self, f: u32, g: u32) -> bool {
        let (surface, positions, ahead) = (self.surface, self.positions, self.ahead);
        let (tf, tg) = (surface.topology.faces[f as usize], surface.topology.faces[g as usize]);
        // Faces of a fan that hardly bends are hardly closer than at rest.
        if let Some(&v) = tf.iter().find(|&&v| tg.contains(&v) && self.flatness.holds(v, surface, positions, ahead)) {
            // Nor do they cross, unless cloth is cut or sewn there.
            let may_cross = self.loose[v as usize];
            if self.anew && may_cross {
                self.contacts.close.push([f, g]);
            }
            return may_cross;
        }
        let path = |v: u32| Path { now: Vec3A::from_vec4(positions[v as usize]), ahead: ahead[v as usize] };
        let (pf, pg) = (corners(tf, path), corners(tg, path));
        // A thick cloth does not make the others look farther.
        let reach = if self.touch.len() == 1 { self.reach } else { self.reach_of(tf[0], tg[0]) };
        let gaps = Gaps::between(&pf, &pg);
        if gaps.exceed(reach, gaps.now.min(gaps.ahead)) {
            return false;
        }
        // What drifts no farther does not meet.
        let may_cross = !gaps.exceed(3.0 * DRIFT * MARGIN * self.thickest, gaps.now);
        if may_cross {
            self.contacts.close.push([f, g]);
        }
        let wide = Vec3A::splat(reach);
        let sides = [Side::new(tf, self.owns[f as usize], pf), Side::new(tg, self.owns[g as usize], pg)];
        self.ask_corners(&sides, wide, [f, g]);
        if sides.iter().all(Side::has_edges) {
            self.ask_edges(&sides, wide, [f, g]);
        }
        may_cross
    }

    /// How close the boxes of faces at particles `u` and `v` must come `[m]`.
    #[inline]
    fn reach_of(&self, u: u32, v: u32) -> f32 {
        let [a, b] = [u, v].map(|v| self.touch[usize::from(self.surface.part(v))].thickness);
        (1.0 + MARGIN) * 0.5 * (a + b)
    }

    /// Asks for the corners that each face owns with the other face.
    #[inline]
    fn ask_corners(&mut self, [f, g]: &[Side; 2], wide: Vec3A, faces: [u32; 2]) {
        let positions = self.positions;
        let at = |v: u32| positions[v as usize].truncate();
        for (side, other) in [(f, g), (g, f)] {
            let u = other.corners;
            for (k, (corner, own)) in side.corners.into_iter().zip(&side.boxes).enumerate() {
                if side.owns & (1 << k) != 0 && !u.contains(&corner) && own.meets(&other.whole, wide) {
                    self.list(vertex_face([corner, u[0], u[1], u[2]], at), 1, faces);
                }
            }
        }
    }

    /// Asks for the edges that one face owns with those that the other owns.
    #[inline]
    fn ask_edges(&mut self, [f, g]: &[Side; 2], wide: Vec3A, faces: [u32; 2]) {
        let positions = self.positions;
        let at = |v: u32| positions[v as usize].truncate();
        for (i, next) in CYCLE {
            let e = [f.corners[i], f.corners[next]];
            let edge = f.boxes[i].union(f.boxes[next]);
            if f.owns & (8 << i) == 0 || !edge.meets(&g.whole, wide) {
                continue;
            }
            for (j, next_j) in CYCLE {
                let h = [g.corners[j], g.corners[next_j]];
                if g.owns & (8 << j) != 0
                    && !h.contains(&e[0])
                    && !h.contains(&e[1])
                    && g.boxes[j].union(g.boxes[next_j]).meets(&edge, wide)
                    && may_pass([f.paths[i], f.paths[next]], [g.paths[j], g.paths[next_j]])
                {
                    self.list(closest_edges([e[0], e[1], h[0], h[1]], at), 2, faces);
                }
            }
        }
    }
}
