//! Sharp edges of surfaces made of triangles: what lies between particles that all lie on it.
//!
//! ```text
//!        n1  n2       two triangles at an edge, bent by θ:  an edge e of cloth across it sags by e θ / 4 at most
//!        |  /
//!   -----*·           the border of a surface, and an edge of more than two triangles, are sharp
//!         \ θ
//! ```
//!
//! Of a solid only those that stick out count.

use std::sync::Arc;

use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::shape::{HeightField, Shape, SharedShape, TriMesh, Triangle, TypedShape};

/// Sharp edges are found in a box this much longer on every side than the requested one (dimensionless). So they stay valid for
/// a while.
const WIDER: f32 = 0.25;
/// Most sharp edges that are taken of one surface in a frame, in their order: beyond that particles have to do.
const MOST: usize = 4096;

/// A sharp edge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct FeatureEdge {
    pub(super) a: Vec3,
    pub(super) b: Vec3,
}

impl FeatureEdge {
    /// Of an edge whose ends come in any order, and with either zero.
    fn new(a: Vec3, b: Vec3) -> Self {
        let (a, b) = (a + Vec3::ZERO, b + Vec3::ZERO);
        if bits(a) <= bits(b) { Self { a, b } } else { Self { a: b, b: a } }
    }

    /// What orders them: the same in every frame.
    pub(super) fn key(&self) -> [u32; 6] {
        let ([a, b, c], [d, e, f]) = (bits(self.a), bits(self.b));
        [a, b, c, d, e, f]
    }
}

fn bits(p: Vec3) -> [u32; 3] {
    p.to_array().map(f32::to_bits)
}

/// One side of an edge.
#[derive(Clone, Copy, Debug)]
struct Half {
    feature_edge: FeatureEdge,
    normal: Vec3,
    /// The corner across.
    corner: Vec3,
}

/// The sharp edges of a part of a shape in a box.
#[derive(Clone)]
struct Known {
    shape: SharedShape,
    /// Number of the body and of its part.
    part: [u32; 2],
    /// Cosine below which an edge is sharp (dimensionless), and the box in which all that are were found `[m]`.
    flat: f32,
    within: Aabb,
    feature_edges: Vec<FeatureEdge>,
    /// Whether it was asked for in this frame.
    used: bool,
}

impl core::fmt::Debug for Known {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Known")
            .field("part", &self.part)
            .field("feature_edges", &self.feature_edges.len())
            .finish_non_exhaustive()
    }
}

/// Finds sharp edges, and knows those of shapes that stay. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct FeatureEdges {
    halves: Vec<Half>,
    known: Vec<Known>,
}

impl FeatureEdges {
    /// Begins a frame: edges that the last one did not ask for are forgotten.
    pub(super) fn begin(&mut self) {
        self.known.retain_mut(|known| core::mem::take(&mut known.used));
    }

    /// Appends the sharp edges of a part of a shape, which is `surface`, in the box `near` `[m]`, in order. Sharp edges are
    /// bent by an angle whose cosine is below `flat`.
    pub(super) fn near(
        &mut self,
        (shape, part, surface): (&SharedShape, [u32; 2], &dyn Shape),
        near: &Aabb,
        flat: f32,
        found: &mut Vec<FeatureEdge>,
    ) {
        let of = |known: &Known| Arc::ptr_eq(&known.shape.0, &shape.0) && known.part == part;
        let place = self.known.iter().position(of).unwrap_or_else(|| {
            let (within, feature_edges) = (Aabb::new_invalid(), Vec::new());
            self.known.push(Known { shape: shape.clone(), part, flat, within, feature_edges, used: false });
            self.known.len() - 1
        });
        let known = &self.known[place];
        if known.flat != flat || !known.within.contains(near) {
            let mut feature_edges = core::mem::take(&mut self.known[place].feature_edges);
            let within = near.loosened(WIDER * near.extents().max_element());
            feature_edges.clear();
            match surface.as_typed_shape() {
                TypedShape::TriMesh(mesh) => self.of_mesh(mesh, &within, flat, &mut feature_edges),
                TypedShape::HeightField(field) => self.of_heights(field, &within, flat, &mut feature_edges),
                _ => {}
            }
            let known = &mut self.known[place];
            (known.flat, known.within, known.feature_edges) = (flat, within, feature_edges);
        }
        let known = &mut self.known[place];
        known.used = true;
        let meets = |c: &&FeatureEdge| (c.a.min(c.b).cmple(near.maxs) & c.a.max(c.b).cmpge(near.mins)).all();
        found.extend(known.feature_edges.iter().filter(meets).take(MOST));
    }

    /// As [`Self::near`], of a mesh.
    fn of_mesh(&mut self, mesh: &TriMesh, near: &Aabb, flat: f32, found: &mut Vec<FeatureEdge>) {
        self.halves.clear();
        for i in mesh.bvh().intersect_aabb(near) {
            self.add(&mesh.triangle(i));
        }
        self.sort_out(flat, mesh.pseudo_normals_if_oriented().is_some(), found);
    }

    /// The same of a height field.
    fn of_heights(&mut self, field: &HeightField, near: &Aabb, flat: f32, found: &mut Vec<FeatureEdge>) {
        self.halves.clear();
        field.map_elements_in_local_aabb(near, &mut |_, triangle| self.add(triangle));
        self.sort_out(flat, false, found);
    }

    fn add(&mut self, triangle: &Triangle) {
        let Triangle { a, b, c } = *triangle;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for (from, to, corner) in [(a, b, c), (b, c, a), (c, a, b)] {
            self.halves.push(Half { feature_edge: FeatureEdge::new(from, to), normal, corner });
        }
    }

    fn sort_out(&mut self, flat: f32, solid: bool, found: &mut Vec<FeatureEdge>) {
        self.halves.sort_unstable_by_key(|half| (half.feature_edge.key(), bits(half.corner)));
        for halves in self.halves.chunk_by(|a, b| a.feature_edge == b.feature_edge) {
            let sharp = match halves {
                [one, other] => {
                    // Wound alike the normals agree where it is flat; else one of them is turned round.
                    let over = one.normal.dot(other.corner - one.feature_edge.a);
                    let under = other.normal.dot(one.corner - one.feature_edge.a);
                    let cosine = one.normal.dot(other.normal) * if over * under < 0.0 { -1.0 } else { 1.0 };
                    cosine < flat && !(solid && over > 0.0)
                }
                _ => true,
            };
            if sharp && halves.iter().all(|half| half.normal != Vec3::ZERO) {
                found.extend(halves.first().map(|half| half.feature_edge));
            }
        }
    }
}

/// Cosine of the angle that is flat enough for edges of `edge` `[m]` that may sag by `sag` `[m]`.
pub(super) fn flat(edge: f32, sag: f32) -> f32 {
    let angle = 4.0 * sag / edge.max(f32::MIN_POSITIVE);
    // cos θ = 1 - θ²/2 + θ⁴/24 - …: low by less than a hundredth up to 90°, where it is cut off.
    (1.0 - 0.5 * angle * angle).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::body::shape;

    fn everything() -> Aabb {
        Aabb::new(Vec3::splat(-10.0), Vec3::splat(10.0))
    }

    #[test]
    fn a_box_of_triangles_has_twelve_sharp_edges_and_its_diagonals_are_flat() {
        let (vertices, triangles) = parry3d::shape::Cuboid::new(Vec3::new(0.3, 0.2, 0.1)).to_trimesh();
        for shape in [shape::trimesh(vertices.clone(), triangles.clone()), shape::solid_trimesh(vertices, triangles)] {
            let shape = shape.unwrap();
            let mut found = Vec::new();
            FeatureEdges::default().of_mesh(shape.as_trimesh().unwrap(), &everything(), 0.9, &mut found);
            assert_eq!(found.len(), 12, "{found:?}");
        }
    }

    #[test]
    fn what_is_known_of_a_shape_is_what_is_found_anew_wherever_it_is_asked_for() {
        let heights: Vec<f32> = (0..400).map(|i| 0.3 * fastrand::Rng::with_seed(i).f32()).collect();
        let shape = shape::heightfield(20, 20, &heights, Vec3::splat(4.0)).unwrap();
        let mut kept = FeatureEdges::default();
        for k in 0..40 {
            let centre = Vec3::new(-1.5 + 0.08 * k as f32, 0.5, 0.3);
            let near = Aabb::from_half_extents(centre, Vec3::splat(0.6));
            let (mut known, mut anew) = (Vec::new(), Vec::new());
            kept.begin();
            kept.near((&shape, [0, 0], &*shape.0), &near, 0.9, &mut known);
            FeatureEdges::default().near((&shape, [0, 0], &*shape.0), &near, 0.9, &mut anew);
            assert!(known == anew && !known.is_empty(), "box {k}: {} known, {} anew", known.len(), anew.len());
        }
        assert_eq!(kept.known.len(), 1);
        kept.begin();
        kept.begin();
        assert!(kept.known.is_empty(), "nobody asked for it");
    }

    #[test]
    fn a_flat_field_has_its_border_and_a_ridge_its_crest() {
        for (height, sharp) in [(0.0, 16), (0.5, 20)] {
            let heights: Vec<f32> = (0..25).map(|i| if i / 5 == 2 { height } else { 0.0 }).collect();
            let field = shape::heightfield(5, 5, &heights, Vec3::ONE).unwrap();
            let mut found = Vec::new();
            FeatureEdges::default().of_heights(field.as_heightfield().unwrap(), &everything(), 0.2, &mut found);
            assert_eq!(found.len(), sharp, "height {height}: {found:?}");
        }
    }
}
