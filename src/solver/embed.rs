//! A fine mesh that is drawn in place of a coarse one that is simulated.
//!
//! ```text
//! F   = [b - a, c - a, n | a]        frame of a triangle, n its unit normal
//! S_f = F_f F_f0⁻¹                   how triangle f moved from where it was at rest
//! p   = Σ w_f S_f p0                 linear blend skinning, with triangles for joints
//! n   = cof(Σ w_f S_f) n0            normals keep what their author gave them
//! w_f ∝ (1 - ((δ_f - δ)/ρ)²)³        δ_f: distance to the triangle, δ: to the nearest; ρ: mean edge
//! ```
//!
//! One triangle for each vertex would show the facets of the coarse mesh; those within an edge blend over them. Triangles count
//! that hang together with the nearest one there, so that a pocket does not follow the leg beneath.

use glam::{Affine3A, Mat3A, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::PointQuery;

use super::raycast::closest_weights;

/// Most triangles that a vertex follows. In a regular mesh, six to thirteen triangles have points within an edge of a given
/// point. The far ones have next to no weight.
const MOST: usize = 8;
/// A vertex with more faces than this is the hub of a fan, whose faces are no neighbours of each other. All pairs of ten
/// thousand faces would take a hundred million steps.
pub(super) const HUB: usize = 64;

/// Which triangles of a coarse mesh each vertex of a fine one follows.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Embedding {
    /// Where the list of each vertex begins, and at last where the last ends; as many as vertices, and one more.
    starts: Vec<u32>,
    /// Triangle and weight (dimensionless); weights of a vertex add up to one.
    influences: Vec<(u32, f32)>,
    /// Distance of the farthest vertex from the coarse mesh `[m]`.
    farthest: f32,
}

impl Embedding {
    /// Hangs vertices at `points` `[m]` on the triangles `faces` of a shape at rest at `positions` `[m]`, whose edges are about
    /// `edge` `[m]` long. `normals` are as many as points, or none; where cloth lies in layers, a vertex follows the one that
    /// faces as it does. None if no triangle has an area or a point is not finite.
    #[must_use]
    pub(crate) fn new(faces: &[[u32; 3]], positions: &[Vec3], edge: f32, points: &[Vec3], normals: &[Vec3]) -> Option<Self> {
        let corners = |face: u32| faces[face as usize].map(|p| positions[p as usize]);
        let normal = |face: u32| {
            let [a, b, c] = corners(face);
            (b - a).cross(c - a)
        };
        let solid = (0..faces.len() as u32).filter(|&face| normal(face) != Vec3::ZERO);
        let bounds = |face: u32| {
            let [a, b, c] = corners(face);
            Aabb::new(a.min(b).min(c), a.max(b).max(c))
        };
        let tree = Bvh::from_iter(BvhBuildStrategy::Ploc, solid.map(|face| (face as usize, bounds(face))));
        let all = tree.root_aabb();
        let reach = edge;
        let mut embedding = Self { starts: vec![0], ..Self::default() };
        let (mut near, mut patch) = (Vec::new(), Vec::new());
        for (v, &point) in points.iter().enumerate() {
            if !point.is_finite() {
                return None;
            }
            let distance = |face: u32| distance(point, corners(face));
            // Nothing is farther than the far corner of the box of all.
            let most = point.distance(all.center()) + all.half_extents().length();
            let place = |face: u32, _| (normal(face) != Vec3::ZERO).then(|| distance(face));
            let (_, least) = tree.find_best(most, |node, _| node.aabb().distance_to_local_point(point, true), place)?;
            near.clear();
            let around = Aabb::new(point, point).loosened(least + reach);
            near.extend(tree.intersect_aabb(&around).map(|face| (face, distance(face))).filter(|(_, d)| *d <= least + reach));
            near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            let faces_as = |face: u32| normals.get(v).is_none_or(|n| n.dot(normal(face)) > 0.0);
            let seed = near.iter().position(|(face, _)| faces_as(*face)).unwrap_or(0);
            let nearest = near.get(seed)?.1;
            grow(&mut near, seed, &mut patch, faces);
            embedding.hang(&patch, nearest, reach);
        }
        Some(embedding)
    }

    /// The same, where the particle of each of the `points` is known. A point follows triangles around its particle and around
    /// their corners, whatever else is near.
    #[must_use]
    pub(crate) fn along(faces: &[[u32; 3]], positions: &[Vec3], edge: f32, points: &[Vec3], particles: &[u32]) -> Option<Self> {
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); positions.len()];
        for (face, corners) in (0..).zip(faces) {
            corners.iter().for_each(|p| around[*p as usize].push(face));
        }
        let corners = |face: u32| faces[face as usize].map(|p| positions[p as usize]);
        let has_area = |face: &u32| {
            let [a, b, c] = corners(*face);
            (b - a).cross(c - a).try_normalize().is_some()
        };
        let mut embedding = Self { starts: vec![0], ..Self::default() };
        let (mut ring, mut near) = (Vec::new(), Vec::new());
        for (&point, &particle) in points.iter().zip(particles) {
            let own = &around[particle as usize];
            let beside = own.iter().flat_map(|face| faces[*face as usize]).map(|p| &around[p as usize]);
            ring.clear();
            ring.extend(own.iter().chain(beside.filter(|faces| faces.len() <= HUB).flatten()).copied().filter(has_area));
            ring.sort_unstable();
            ring.dedup();
            near.clear();
            near.extend(ring.iter().map(|face| (*face, distance(point, corners(*face)))));
            near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            let nearest = near.first().filter(|(_, d)| d.is_finite()).map_or(0.0, |(_, d)| *d);
            if near.is_empty() {
                // It stays with a face that goes nowhere.
                near.push((*own.first()?, 0.0));
            }
            embedding.hang(&near, nearest, edge);
        }
        Some(embedding)
    }

    /// Memory held `[B]`.
    #[must_use]
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.influences[..])
    }

    /// Hangs the next vertex on triangles at these distances `[m]`, in ascending order; that by which others count is
    /// `nearest`.
    fn hang(&mut self, patch: &[(u32, f32)], nearest: f32, reach: f32) {
        self.farthest = self.farthest.max(nearest);
        // The nearest of what is left out has no weight, and so none jumps in as a vertex lies elsewhere.
        let weight = |d: f32| (1.0 - ((d - nearest).max(0.0) / reach).powi(2)).max(0.0).powi(3);
        let base = patch.get(MOST).map_or(0.0, |(_, d)| weight(*d));
        let first = self.influences.len();
        let some = patch.iter().take(MOST).map(|&(face, d)| (face, weight(d) - base));
        self.influences.extend(some.filter(|(_, w)| *w > 0.0));
        if self.influences.len() == first {
            self.influences.extend(patch.first().map(|(face, _)| (*face, 1.0)));
        }
        let sum: f32 = self.influences[first..].iter().map(|(_, w)| w).sum();
        self.influences[first..].iter_mut().for_each(|(_, w)| *w /= sum);
        self.starts.push(self.influences.len() as u32);
    }

    /// Distance of the farthest vertex from the coarse mesh at rest `[m]`.
    #[must_use]
    pub(crate) fn farthest(&self) -> f32 {
        self.farthest
    }

    /// How each vertex moved from where it was at rest, by how the triangles did.
    pub(crate) fn blend<'a>(&'a self, triangles: &'a [Affine3A]) -> impl Iterator<Item = Affine3A> + 'a {
        self.starts.windows(2).map(|range| {
            let mut sum = Affine3A::ZERO;
            for &(face, weight) in &self.influences[range[0] as usize..range[1] as usize] {
                let Some(triangle) = triangles.get(face as usize) else { continue };
                sum.matrix3 += triangle.matrix3 * weight;
                sum.translation += triangle.translation * weight;
            }
            sum
        })
    }
}

/// Distance of a point from a triangle `[m]`.
pub(super) fn distance(point: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let w = closest_weights(point, [a, b, c]);
    (a * w.x + b * w.y + c * w.z).distance(point)
}

/// Gathers what hangs together with the triangle at `seed` among those `near` into `patch`, nearest first.
fn grow(near: &mut Vec<(u32, f32)>, seed: usize, patch: &mut Vec<(u32, f32)>, faces: &[[u32; 3]]) {
    patch.clear();
    patch.push(near.remove(seed));
    let mut at = 0;
    while let Some(&(face, _)) = patch.get(at) {
        let corners = faces[face as usize];
        near.retain(|&other| {
            let touches = faces[other.0 as usize].iter().any(|p| corners.contains(p));
            if touches {
                patch.push(other);
            }
            !touches
        });
        at += 1;
    }
    patch.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
}

/// How triangles of a cloth move from where they were at rest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    /// Inverses of the frames at rest; zero where a triangle has no area.
    rest: Vec<Affine3A>,
    /// How each moved; as many as triangles.
    pub moved: Vec<Affine3A>,
}

impl Triangles {
    /// Those of a shape at rest.
    #[must_use]
    pub(crate) fn new(faces: &[[u32; 3]], positions: &[Vec3]) -> Self {
        let inverse = |face: &[u32; 3]| {
            let frame = frame(face.map(|p| positions[p as usize]));
            if frame.matrix3.determinant() == 0.0 { Affine3A::ZERO } else { frame.inverse() }
        };
        Self { rest: faces.iter().map(inverse).collect(), moved: Vec::new() }
    }

    /// Finds how they moved, from positions `[m]` of the particles, and where `place` takes that.
    pub(crate) fn find(&mut self, faces: &[[u32; 3]], positions: &[Vec3], place: &Affine3A) {
        let now = faces.iter().map(|face| frame(face.map(|p| positions[p as usize])));
        self.moved.clear();
        self.moved.extend(now.zip(&self.rest).map(|(now, rest)| *place * now * *rest));
    }
}

/// The frame of a triangle.
fn frame([a, b, c]: [Vec3; 3]) -> Affine3A {
    let (e, f) = (b - a, c - a);
    let normal = e.cross(f).normalize_or_zero();
    Affine3A { matrix3: Mat3A::from_cols(e.into(), f.into(), normal.into()), translation: a.into() }
}

/// How a matrix turns normals: its cofactors, which ask for no inverse.
#[must_use]
pub(crate) fn cofactors(matrix: &Mat3A) -> Mat3A {
    let Mat3A { x_axis: x, y_axis: y, z_axis: z } = *matrix;
    Mat3A::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3Swizzles, vec3};

    use super::*;
    use crate::solver::rest::{RestShape, SourceMesh};
    use crate::solver::scene::grid;

    fn shape(n: u32, at: impl Fn(f32, f32) -> Vec3) -> RestShape {
        RestShape::build(&grid(n, n, at)).expect("a grid").0
    }

    fn hung(rest: &RestShape, points: &[Vec3], normals: &[Vec3]) -> Option<Embedding> {
        Embedding::new(&rest.topology.faces, &rest.positions, rest.mean_edge, points, normals)
    }

    fn flat(u: f32, v: f32) -> Vec3 {
        vec3(u, 0.0, v)
    }

    /// Where the points of a fine grid, `height` above a coarse one of `n` by `n`, go when that goes `to`.
    fn drawn(n: u32, height: f32, to: impl Fn(Vec3) -> Vec3) -> (Vec<Vec3>, Vec<Vec3>) {
        let rest = shape(n, flat);
        let points: Vec<Vec3> = grid(40, 40, |u, v| flat(u, v) + Vec3::Y * height).positions;
        let embedding = hung(&rest, &points, &[]).expect("a mesh");
        let mut triangles = Triangles::new(&rest.topology.faces, &rest.positions);
        let now: Vec<Vec3> = rest.positions.iter().map(|p| to(*p)).collect();
        triangles.find(&rest.topology.faces, &now, &Affine3A::IDENTITY);
        let placed = embedding.blend(&triangles.moved).zip(&points).map(|(moved, p)| moved.transform_point3(*p)).collect();
        (points, placed)
    }

    #[test]
    fn a_mesh_at_rest_stays_and_one_that_turns_turns() {
        let turn = Affine3A::from_rotation_translation(Quat::from_rotation_x(1.0), vec3(1.0, 2.0, 3.0));
        for motion in [Affine3A::IDENTITY, turn] {
            let (points, placed) = drawn(7, 0.02, |p| motion.transform_point3(p));
            for (p, q) in points.iter().zip(placed) {
                assert!(motion.transform_point3(*p).distance(q) < 1.0e-5, "{p} at {q}");
            }
        }
    }

    #[test]
    fn facets_of_a_bent_sheet_do_not_show() {
        // A quarter of a cylinder of ten coarse edges: facets turn by 9 degrees.
        let radius = core::f32::consts::FRAC_2_PI;
        let bend = |p: Vec3| vec3(radius * (p.x / radius).sin(), radius * (p.x / radius).cos() - radius, p.z);
        let (_, placed) = drawn(11, 0.0, bend);
        let row: Vec<Vec3> = placed.iter().filter(|p| (p.z - 19.0 / 39.0).abs() < 1.0e-3).copied().collect();
        let turn = |w: &[Vec3]| (w[1] - w[0]).xy().angle_to((w[2] - w[1]).xy()).abs().to_degrees();
        let most = row.windows(3).map(turn).fold(0.0, f32::max);
        assert!(most < 6.0, "turns by {most} degrees from edge to edge, 2.3 on the cylinder");
        let off =
            row.iter().map(|p| (p.xy() - glam::vec2(0.0, -radius)).length() - radius).fold(0.0, |a, b| f32::max(a, b.abs()));
        assert!(off < 0.003, "{off} m from the cylinder, whose facets are 1.9 mm deep");
    }

    #[test]
    fn a_vertex_between_layers_follows_the_one_that_faces_as_it_does() {
        let one = grid(6, 6, flat);
        let other = grid(6, 6, |u, v| vec3(1.0 - u, 0.02, v));
        let count = one.positions.len() as u32;
        let both = SourceMesh {
            positions: [one.positions, other.positions].concat(),
            triangles: one.triangles.iter().copied().chain(other.triangles.iter().map(|t| t.map(|v| v + count))).collect(),
            ..SourceMesh::default()
        };
        let rest = RestShape::build(&both).expect("two sheets").0;
        let up = |face: u32| {
            let [a, b, c] = rest.topology.faces[face as usize].map(|p| rest.positions[p as usize]);
            ((b - a).cross(c - a).y > 0.0, a.y)
        };
        for normal in [Vec3::Y, Vec3::NEG_Y] {
            // Nearer to the other layer.
            let lower = up(0);
            let faces_up = if lower.0 { 0.0 } else { 0.02 };
            let wanted = if normal.y > 0.0 { faces_up } else { 0.02 - faces_up };
            let embedding = hung(&rest, &[vec3(0.5, 0.02 - wanted, 0.5)], &[normal]).expect("a mesh");
            for (face, _) in &embedding.influences {
                assert_eq!(up(*face).1, wanted, "faces {normal}");
            }
        }
    }

    #[test]
    fn each_layer_of_a_garment_follows_itself_however_near_the_other_is() {
        // Nearer than a coarse sheet is to a fine one.
        let gap = 1.0e-3;
        let wave = |u: f32, v: f32| vec3(u, 0.02 * (20.0 * u).sin() * (15.0 * v).sin(), v);
        let [one, other] = [0.0, gap].map(|up| grid(100, 100, |u, v| wave(u, v) + Vec3::Y * up));
        let count = one.positions.len();
        let both = SourceMesh {
            positions: [one.positions, other.positions].concat(),
            triangles: one
                .triangles
                .iter()
                .copied()
                .chain(other.triangles.iter().map(|t| t.map(|v| v + count as u32)))
                .collect(),
            ..SourceMesh::default()
        };
        let rest = RestShape::build_decimated(&both, &both.positions, 0.05).expect("two sheets").0;
        assert!(rest.positions.len() < count / 10);
        let fine = rest.fine.as_ref().expect("it is coarser");
        // The second layer is drawn away.
        let mut second = vec![false; rest.positions.len()];
        rest.particle_of_vertex[count..].iter().for_each(|p| second[*p as usize] = true);
        let away = |second: bool| if second { Vec3::Y } else { Vec3::ZERO };
        let now: Vec<Vec3> = rest.positions.iter().zip(&second).map(|(x, second)| *x + away(*second)).collect();
        let mut triangles = Triangles::new(&rest.topology.faces, &rest.positions);
        triangles.find(&rest.topology.faces, &now, &Affine3A::IDENTITY);
        for (v, moved) in fine.embedding.blend(&triangles.moved).enumerate() {
            let to = both.positions[v] + away(v >= count);
            assert!(moved.transform_point3(both.positions[v]).distance(to) < 1.0e-4, "vertex {v}");
        }
    }

    #[test]
    fn what_is_far_or_no_number_is_told() {
        let rest = shape(4, flat);
        let far = hung(&rest, &[vec3(50.0, 30.0, 0.0)], &[]).expect("a mesh");
        assert!(far.farthest() > 50.0 && far.influences.len() <= MOST, "{far:?}");
        assert_eq!(hung(&rest, &[Vec3::NAN], &[]), None);
        assert_eq!(hung(&rest, &[], &[]).map(|none| none.starts), Some(vec![0]));
    }
}
