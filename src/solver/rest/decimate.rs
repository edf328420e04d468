//! A mesh with its short edges collapsed: a cloth that is coarser than what is drawn of it.
//!
//! ```text
//!      w1 ─── w2                w1 ── w2
//!     / \    / \               / │  ╱  \        u goes into its neighbour v, and two faces with it. Vertices that stay keep
//!    v ── u ── w3      ─►     v ─────── w3      their places, so that weights of a skin and maps are as authored
//!     \ /    \ /               \ │  ╲  /
//!      w5 ─── w4                w5 ── w4
//! ```
//!
//! Shortest edges first, in rounds in which no face changes twice, so that it gets coarser evenly. An edge stays where it would
//! fold a face or cut the surface in two (link condition, Dey et al. 1999). So it does where an authored vertex would lie too
//! far from the coarse faces, or one of a border from the coarse border. The bound is the sag of a chord of the length asked
//! for over a radius as long.

use glam::Vec3;

use crate::solver::embed::{HUB, distance};
use crate::solver::scales::ALIGNED;

/// Largest distance of an authored vertex from the coarse mesh, in units of the length asked for (dimensionless). It is the
/// sagitta `e² / 8 R` of a chord `e` over a radius `R = e`.
const SAG: f32 = 1.0 / 8.0;
/// Longest edge that is made, in units of the length asked for (dimensionless): two edges that are just too short, in one.
const LONGEST: f32 = 2.0;
/// Least quality of a face that is made where the faces before were better (dimensionless). At 1 a face is equilateral, at 0.87
/// half a square, at 0.4 isosceles and 0.18 times as high as its base is long.
const QUALITY: f32 = 0.4;

/// What collapsing comes to.
pub(super) struct Decimated {
    /// The faces that are left, and which one each of them was.
    pub triangles: Vec<[u32; 3]>,
    pub of: Vec<u32>,
    /// Into which vertex each went; itself if it stayed.
    pub into: Vec<u32>,
}

/// Collapses edges shorter than `shortest` `[m]` of a mesh without repeated vertices or faces.
pub(super) fn decimate(positions: &[Vec3], triangles: &[[u32; 3]], shortest: f32) -> Decimated {
    let mut mesh = Collapsing::new(positions, triangles, shortest);
    while mesh.round() > 0 {}
    let Collapsing { faces, alive, mut into, .. } = mesh;
    // A vertex went into one that stayed until then.
    for v in 0..into.len() {
        let mut to = into[v];
        while into[to as usize] != to {
            to = into[to as usize];
        }
        into[v] = to;
    }
    let left = || (0_u32..).zip(&faces).zip(&alive).filter(|(_, alive)| **alive).map(|(face, _)| face);
    Decimated { triangles: left().map(|(_, face)| *face).collect(), of: left().map(|(of, _)| of).collect(), into }
}

/// The sides of a face.
fn sides_of([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// A mesh whose edges are collapsed.
struct Collapsing {
    points: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    alive: Vec<bool>,
    /// Faces at each vertex.
    around: Vec<Vec<u32>>,
    /// Authored vertices that each stands for, itself among them.
    stands_for: Vec<Vec<u32>>,
    /// Whether each was on a border as authored.
    is_border: Vec<bool>,
    into: Vec<u32>,
    shortest: f32,
}

impl Collapsing {
    fn new(positions: &[Vec3], triangles: &[[u32; 3]], shortest: f32) -> Self {
        // Far away positions have no digits left for squares of distances.
        let origin = positions.first().copied().unwrap_or_default();
        let n = positions.len();
        let mut mesh = Self {
            points: positions.iter().map(|x| *x - origin).collect(),
            faces: triangles.to_vec(),
            alive: vec![true; triangles.len()],
            around: vec![Vec::new(); n],
            stands_for: (0..n as u32).map(|v| vec![v]).collect(),
            is_border: vec![false; n],
            into: (0..n as u32).collect(),
            shortest,
        };
        for (face, corners) in (0..).zip(triangles) {
            corners.iter().for_each(|v| mesh.around[*v as usize].push(face));
        }
        let ordered = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let mut sides: Vec<[u32; 2]> = triangles.iter().flat_map(|face| sides_of(*face)).map(ordered).collect();
        sides.sort_unstable();
        for beside in sides.chunk_by(|one, other| one == other).filter(|beside| beside.len() == 1) {
            beside[0].iter().for_each(|v| mesh.is_border[*v as usize] = true);
        }
        mesh
    }

    fn point(&self, v: u32) -> Vec3 {
        self.points[v as usize]
    }

    fn corners(&self, face: [u32; 3]) -> [Vec3; 3] {
        face.map(|v| self.point(v))
    }

    /// Faces at a vertex, their corners in ascending order: a mirrored mesh gets as coarse, to the bit.
    fn at(&self, v: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.around[v as usize].iter().map(|face| {
            let mut corners = self.faces[*face as usize];
            corners.sort_unstable();
            corners
        })
    }

    /// Neighbours of a vertex, in ascending order, as often as there are faces with both.
    fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut neighbours: Vec<u32> = self.at(v).flatten().filter(|w| *w != v).collect();
        neighbours.sort_unstable();
        neighbours
    }

    /// Collapses short edges that share no face, shortest first; how many.
    fn round(&mut self) -> usize {
        let mut edges: Vec<(u32, [u32; 2])> = Vec::new();
        for face in self.faces.iter().zip(&self.alive).filter(|(_, alive)| **alive).map(|(face, _)| face) {
            for [a, b] in sides_of(*face) {
                let length = self.point(a).distance(self.point(b));
                if length < self.shortest {
                    // Positive numbers have the order of their bits.
                    edges.push((length.to_bits(), [a.min(b), a.max(b)]));
                }
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let mut changed = vec![false; self.faces.len()];
        let mut count = 0;
        for (_, [a, b]) in edges {
            let is_fresh = |v: u32| {
                let around = &self.around[v as usize];
                around.len() <= HUB && around.iter().all(|face| !changed[*face as usize])
            };
            if !(is_fresh(a) && is_fresh(b)) {
                continue;
            }
            let mut ways = [[a, b], [b, a]].map(|[u, v]| (self.quality(u, v), [u, v]));
            if ways[1].0 > ways[0].0 {
                ways.swap(0, 1);
            }
            let way = ways.into_iter().find(|(quality, [u, v])| quality.is_some() && self.stays_near(*u, *v));
            if let Some((_, [u, v])) = way {
                for &face in self.around[u as usize].iter().chain(&self.around[v as usize]) {
                    changed[face as usize] = true;
                }
                self.collapse(u, v);
                count += 1;
            }
        }
        count
    }

    /// Least quality of the faces that are left of those at `u` when it goes into `v` (dimensionless); none where it must not.
    fn quality(&self, u: u32, v: u32) -> Option<f32> {
        let near = self.neighbours(u);
        let shared = near.iter().filter(|w| **w == v).count();
        let is_closed = self.is_fan(u, &near)?;
        if shared != if is_closed { 2 } else { 1 } || self.around[u as usize].len() == shared {
            return None;
        }
        let mut common = near.clone();
        common.dedup();
        let far = self.neighbours(v);
        if common.iter().filter(|w| far.binary_search(w).is_ok()).count() != shared {
            return None;
        }
        let (mut least, mut before) = (f32::INFINITY, f32::INFINITY);
        for was in self.at(u).filter(|face| !face.contains(&v)) {
            let is = was.map(|w| if w == u { v } else { w });
            let [[a, b, c], [d, e, f]] = [was, is].map(|face| self.corners(face));
            let (old, new) = ((b - a).cross(c - a), (e - d).cross(f - d));
            let is_turned = old.dot(new) < ALIGNED * old.length() * new.length();
            let longest = d.distance(e).max(e.distance(f)).max(f.distance(d));
            if is_turned || longest > LONGEST * self.shortest || self.at(v).any(|known| is.iter().all(|w| known.contains(w))) {
                return None;
            }
            (before, least) = (before.min(quality([a, b, c])), least.min(quality([d, e, f])));
        }
        (least > QUALITY || before <= QUALITY).then_some(least)
    }

    /// Whether the faces at `u` are one fan around it, or from border to border (then false), and nothing else. `near`: its
    /// neighbours, as often as there are faces with both.
    fn is_fan(&self, u: u32, near: &[u32]) -> Option<bool> {
        let mut ends = near.chunk_by(|one, other| one == other).filter(|beside| beside.len() == 1).map(|beside| beside[0]);
        let (end, other, more) = (ends.next(), ends.next(), ends.next());
        if other.is_some() != end.is_some() || more.is_some() {
            return None;
        }
        let first = end.or(near.first().copied())?;
        let mut left: Vec<[u32; 3]> = self.at(u).collect();
        let mut at = first;
        while let Some(next) = left.iter().position(|face| face.contains(&at)) {
            at = left.swap_remove(next).into_iter().find(|w| *w != u && *w != at)?;
        }
        (left.is_empty() && at == other.unwrap_or(first)).then_some(end.is_none())
    }

    /// Whether every authored vertex lies near the faces at the vertex that stands for it, when `u` has gone into `v`. Every
    /// one of a border must lie near the border there.
    fn stays_near(&self, u: u32, v: u32) -> bool {
        let most = SAG * self.shortest;
        let mut near = self.neighbours(u);
        near.dedup();
        near.into_iter().all(|w| {
            let stood = if w == v { &self.stands_for[u as usize][..] } else { &[] };
            let stand = || self.stands_for[w as usize].iter().chain(stood).copied().filter(|q| *q != w);
            if stand().next().is_none() {
                return true;
            }
            let of_u = self.at(u).filter(|face| w == v || face.contains(&w));
            let others = self.at(w).filter(|face| !face.contains(&u));
            let after = of_u.filter(|face| !face.contains(&v)).map(|face| face.map(|x| if x == u { v } else { x }));
            let faces: Vec<[u32; 3]> = others.chain(after).collect();
            let is_near = |q: u32| faces.iter().any(|face| distance(self.point(q), self.corners(*face)) <= most);
            if !stand().all(is_near) {
                return false;
            }
            let mut ends: Vec<u32> = faces.iter().flatten().copied().filter(|x| *x != w).collect();
            ends.sort_unstable();
            let border = || ends.chunk_by(|one, other| one == other).filter(|beside| beside.len() == 1).map(|beside| beside[0]);
            let is_at_border = |q: u32| {
                let q = self.point(q);
                border().any(|end| distance(q, [self.point(w), self.point(end), self.point(end)]) <= most)
            };
            border().next().is_none() || stand().filter(|q| self.is_border[*q as usize]).all(is_at_border)
        })
    }

    fn collapse(&mut self, u: u32, v: u32) {
        for face in core::mem::take(&mut self.around[u as usize]) {
            let corners = self.faces[face as usize];
            if corners.contains(&v) {
                self.alive[face as usize] = false;
                for w in corners {
                    self.around[w as usize].retain(|other| *other != face);
                }
            } else {
                self.faces[face as usize] = corners.map(|w| if w == u { v } else { w });
                self.around[v as usize].push(face);
            }
        }
        let stood = core::mem::take(&mut self.stands_for[u as usize]);
        self.stands_for[v as usize].extend(stood);
        self.into[u as usize] = v;
    }
}

/// Quality of a triangle: its area over that of an equilateral one whose sides have the same mean square (dimensionless).
fn quality([a, b, c]: [Vec3; 3]) -> f32 {
    let squares = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    if squares > 0.0 { 2.0 * 3.0_f32.sqrt() * (b - a).cross(c - a).length() / squares } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::solver::rest::SourceMesh;
    use crate::solver::scene::grid;

    /// Shares of edges shorter than that asked for, longest edge in units of that, and least and mean quality.
    fn shape(SourceMesh { positions, .. }: &SourceMesh, made: &Decimated, length: f32) -> (f32, f32, f32, f32) {
        let side = |[a, b, c]: &[u32; 3]| [[*a, *b], [*b, *c], [*c, *a]];
        let of = |[a, b]: [u32; 2]| positions[a as usize].distance(positions[b as usize]);
        let sides: Vec<f32> = made.triangles.iter().flat_map(side).map(of).collect();
        let short = sides.iter().filter(|side| **side < length).count() as f32 / sides.len() as f32;
        let longest = sides.iter().copied().fold(0.0, f32::max) / length;
        let quality = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            2.0 * 3.0_f32.sqrt() * (b - a).cross(c - a).length() / side(t).map(of).iter().map(|l| l * l).sum::<f32>()
        };
        let qualities: Vec<f32> = made.triangles.iter().map(quality).collect();
        let mean = qualities.iter().sum::<f32>() / qualities.len() as f32;
        (short, longest, qualities.iter().copied().fold(1.0, f32::min), mean)
    }

    /// Farthest of the authored vertices from the coarse mesh, and of those of the border from its border, in units of
    /// `length`.
    fn strays(mesh: &SourceMesh, made: &Decimated, length: f32) -> [f32; 2] {
        let sides = |faces: &[[u32; 3]]| -> Vec<[u32; 3]> {
            let mut sides: Vec<[u32; 2]> =
                faces.iter().flat_map(|face| sides_of(*face)).map(|[a, b]| [a.min(b), a.max(b)]).collect();
            sides.sort_unstable();
            sides
                .chunk_by(|a, b| a == b)
                .filter(|beside| beside.len() == 1)
                .map(|beside| [beside[0][0], beside[0][1], beside[0][1]])
                .collect()
        };
        let at = |face: [u32; 3]| face.map(|v| mesh.positions[v as usize]);
        let from = |faces: &[[u32; 3]], v: u32| {
            faces.iter().map(|face| distance(mesh.positions[v as usize], at(*face))).fold(f32::INFINITY, f32::min) / length
        };
        let (border, coarse) = (sides(&mesh.triangles), sides(&made.triangles));
        let all = (0..mesh.positions.len() as u32).step_by(7).map(|v| from(&made.triangles, v));
        [all.fold(0.0, f32::max), border.iter().map(|side| from(&coarse, side[0])).fold(0.0, f32::max)]
    }

    #[test]
    fn a_sheet_gets_as_coarse_as_asked_for_and_keeps_its_outline() {
        for (name, bend) in [("flat", 0.0), ("half a pipe", 1.0), ("half a narrow pipe", 3.0)] {
            let radius = if bend > 0.0 { 1.0 / (core::f32::consts::PI * bend) } else { f32::INFINITY };
            let mesh = grid(100, 100, |u, v| match bend {
                0.0 => vec3(u, 0.0, v),
                _ => vec3(radius * (u / radius).cos(), radius * (u / radius).sin(), v),
            });
            for length in [0.03, 0.05, 0.08] {
                let made = decimate(&mesh.positions, &mesh.triangles, length);
                let vertices = made.into.iter().zip(0..).filter(|(into, v)| **into == *v).count();
                let (short, longest, least, mean) = shape(&mesh, &made, length);
                let [off, out] = strays(&mesh, &made, length);
                let told = format!("{name} {length}: {vertices} vertices, {short}, {longest}, {least}, {mean}, {off}, {out}");
                // A net of equal sides has 1.15 vertices for each square of a side.
                assert!((0.6..1.3).contains(&(vertices as f32 * length * length)), "{told}");
                // Around a pipe that is nearly as narrow as edges are long some have to stay short.
                assert!(short < if length < 0.5 * radius { 0.25 } else { 0.4 }, "{told}");
                assert!(longest <= 2.0 && least >= 0.4 && mean > 0.8, "{told}");
                assert!(off <= 0.126 && out <= 0.126, "{told}");
            }
        }
    }

    #[test]
    fn slender_faces_get_coarser_too() {
        for slenderness in [3, 5, 10] {
            // A skirt: many columns, few rings.
            let mesh = grid(1 + 20 * slenderness, 9, |u, v| vec3(1.6 * u, 0.0, 0.64 * v));
            let made = decimate(&mesh.positions, &mesh.triangles, 0.06);
            let vertices = made.into.iter().zip(0..).filter(|(into, v)| **into == *v).count();
            let (_, longest, _, mean) = shape(&mesh, &made, 0.06);
            let told = format!("{slenderness}: {vertices} of {}, {longest}, {mean}", mesh.positions.len());
            assert!((0.6..1.5).contains(&(vertices as f32 * 0.06 * 0.06 / 1.024)) && longest <= 2.0 && mean > 0.75, "{told}");
        }
    }

    /// Corners are others, no face comes twice, and what went somewhere went to what is there.
    fn assert_is_sound(name: &str, made: &Decimated) {
        let mut faces: Vec<[u32; 3]> = made.triangles.clone();
        faces.iter_mut().for_each(|face| face.sort_unstable());
        faces.sort_unstable();
        assert!(faces.windows(2).all(|two| two[0] != two[1]), "{name}: a face comes twice");
        for [a, b, c] in faces {
            assert!(a != b && b != c, "{name}: {a} {b} {c}");
            assert!([a, b, c].iter().all(|v| made.into[*v as usize] == *v), "{name}: {a} {b} {c} went elsewhere");
        }
        assert!(made.into.iter().all(|to| made.into[*to as usize] == *to), "{name}");
    }

    #[test]
    fn whatever_a_mesh_is_its_parts_stay_and_its_faces_are_sound() {
        let tetrahedron = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let made = decimate(&corners, &tetrahedron, 10.0);
        assert_eq!(made.triangles.len(), 4, "a tetrahedron is as coarse as what is closed can be");
        let made = decimate(&corners[..3], &[[0, 1, 2]], 10.0);
        assert_eq!(made.triangles.len(), 1, "a triangle stays");
        assert_eq!(decimate(&[], &[], 1.0).triangles.len(), 0);

        let mut random = fastrand::Rng::with_seed(4);
        for n in 0..200 {
            // Edges of many faces, fans that share a vertex, holes.
            let count = random.usize(4..60);
            let points: Vec<Vec3> = (0..count).map(|_| vec3(random.f32(), 0.3 * random.f32(), random.f32())).collect();
            let mut faces: Vec<[u32; 3]> = Vec::new();
            for _ in 0..random.usize(1..150) {
                let mut face = [0, 0, 0].map(|_: u32| random.u32(0..count as u32));
                let known = |face: &[u32; 3]| faces.iter().any(|f| face.iter().all(|v| f.contains(v)));
                if face[0] != face[1] && face[1] != face[2] && face[2] != face[0] && !known(&face) {
                    face.rotate_left(n % 3);
                    faces.push(face);
                }
            }
            for length in [0.2, 1.0, f32::MAX] {
                let made = decimate(&points, &faces, length);
                assert_is_sound(&format!("soup {n}"), &made);
                assert!(faces.is_empty() || !made.triangles.is_empty());
            }
        }

        // A fan, in which only its rim gets coarser.
        let count = 20_000;
        let rim = (0..count).map(|i| core::f32::consts::TAU * i as f32 / count as f32).map(|a| vec3(a.cos(), 0.0, a.sin()));
        let points: Vec<Vec3> = core::iter::once(Vec3::ZERO).chain(rim).collect();
        let fan: Vec<[u32; 3]> = (1..count).map(|i| [0, i, i + 1]).collect();
        assert_is_sound("fan", &decimate(&points, &fan, 2.0));

        let sheet = grid(40, 40, |u, v| vec3(u, 0.05 * (9.0 * v).sin(), v));
        for length in [0.0, f32::NAN, 1.0e-6] {
            assert_eq!(decimate(&sheet.positions, &sheet.triangles, length).triangles, sheet.triangles, "{length}");
        }
        let mirrored: Vec<[u32; 3]> = sheet.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        let [one, other] = [&sheet.triangles, &mirrored].map(|faces| decimate(&sheet.positions, faces, 0.07).into);
        assert_eq!(one, other, "a mirrored mesh gets as coarse");
        assert_is_sound("waves", &decimate(&sheet.positions, &sheet.triangles, 0.1));
    }
}
