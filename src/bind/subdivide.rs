//! A mesh with its long edges split.
//!
//! ```text
//!     c             c             c             c      edges that are too long are split in the middle,
//!    / \           /|\           / \           / \     and faces by which of theirs are: what is drawn is the
//!   /   \    ─►   / | \    or   /__,x    or   x___x    same surface, and neighbours split the edge that
//!  /     \       /  |  \       / ,'  \       / \ / \   they share alike
//! a───────b     a───x───b     a───────b     a───x───b
//! ```

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use super::read::{read, unreadable};
use crate::components::ClothError;

/// Vertices of a mesh, at most: a length that is wrong by a factor of a thousand would not fit into memory.
pub(crate) const MOST_VERTICES: usize = 50_000;

/// A mesh with its long edges split.
pub(crate) struct Subdivided {
    /// None if no edge is too long.
    pub mesh: Option<Mesh>,
    /// Whether edges are still too long, as there would be [too many](MOST_VERTICES) vertices.
    pub is_cut: bool,
}

/// Splits the edges of a mesh that are longer than `longest` `[m]`.
///
/// # Errors
/// What cannot be read.
pub(crate) fn subdivide(mesh: &Mesh, longest: f32) -> Result<Subdivided, ClothError> {
    let authored = read(mesh)?;
    let vertices = authored.positions.len();
    let Split { triangles, parents, is_cut, .. } = Split::new(authored.positions, authored.triangles, longest);
    if parents.is_empty() {
        return Ok(Subdivided { mesh: None, is_cut });
    }
    let mut finer = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    finer.enable_raytracing = mesh.enable_raytracing;
    for (attribute, values) in mesh.try_attributes().map_err(|error| unreadable(&error))? {
        // Bevy draws none that is not one for each vertex.
        if values.len() == vertices {
            let mut values = values.clone();
            interpolate(attribute, &mut values, &parents);
            finer.insert_attribute(*attribute, values);
        }
    }
    share_joints(&mut finer, vertices, &parents);
    finer.insert_indices(Indices::U32(triangles.concat()));
    if mesh.skinned_mesh_bounds().is_some() {
        // For its skin, where it is not simulated; a vertex in the middle may lie outside of the old box of its joint.
        finer.generate_skinned_mesh_bounds().ok();
    }
    Ok(Subdivided { mesh: Some(finer), is_cut })
}

/// What splitting comes to.
struct Split {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// The ends of the edge that each new vertex is the middle of.
    parents: Vec<[u32; 2]>,
    is_cut: bool,
}

impl Split {
    fn new(positions: Vec<Vec3>, mut triangles: Vec<[u32; 3]>, longest: f32) -> Self {
        let vertices = positions.len() as u32;
        triangles.retain(|corners| corners.iter().all(|v| *v < vertices));
        let mut split = Self { positions, triangles, parents: Vec::new(), is_cut: false };
        while split.halve(longest) {}
        split
    }

    /// Splits what is too long once; whether anything was.
    fn halve(&mut self, longest: f32) -> bool {
        let Self { positions, triangles, parents, .. } = self;
        let mut middles: HashMap<[u32; 2], u32> = HashMap::default();
        let (known, first) = (positions.len(), parents.len());
        for &[a, b, c] in &*triangles {
            for [u, v] in [[a, b], [b, c], [c, a]] {
                let [p, q] = [u, v].map(|v| positions[v as usize]);
                // The same bits for both sides of a seam whose ends lie in the same place. What is not a number has no length,
                // and far from the origin there may be no number in the middle of two.
                let (middle, square) = (0.5 * (p + q), p.distance_squared(q));
                let halves = p.distance_squared(middle).max(q.distance_squared(middle));
                let is_long = square > longest * longest && halves < 0.5 * square && middle.is_finite();
                if is_long && !middles.contains_key(&ordered(u, v)) {
                    middles.insert(ordered(u, v), positions.len() as u32);
                    positions.push(middle);
                    parents.push(ordered(u, v));
                }
            }
        }
        if middles.is_empty() {
            return false;
        }
        if positions.len() > MOST_VERTICES {
            positions.truncate(known);
            parents.truncate(first);
            self.is_cut = true;
            return false;
        }
        let mut finer = Vec::with_capacity(triangles.len() + 2 * middles.len());
        for &corners in &*triangles {
            faces_of(corners, |u, v| middles.get(&ordered(u, v)).copied(), positions, &mut finer);
        }
        self.triangles = finer;
        true
    }
}

const fn ordered(a: u32, b: u32) -> [u32; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// The faces that a triangle falls into, by which of its edges have a `middle`.
fn faces_of([a, b, c]: [u32; 3], middle: impl Fn(u32, u32) -> Option<u32>, positions: &[Vec3], faces: &mut Vec<[u32; 3]>) {
    let at = |v: u32| positions[v as usize];
    // Turned until the edge that is split, or that is not, comes first.
    match [middle(a, b), middle(b, c), middle(c, a)] {
        [None, None, None] => faces.push([a, b, c]),
        [Some(x), Some(y), Some(z)] => faces.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]),
        [Some(x), None, None] => faces.extend([[a, x, c], [x, b, c]]),
        [None, Some(x), None] => faces.extend([[b, x, a], [x, c, a]]),
        [None, None, Some(x)] => faces.extend([[c, x, b], [x, a, b]]),
        [None, Some(x), Some(y)] => split_two([a, b, c], [x, y], &at, faces),
        [Some(y), None, Some(x)] => split_two([b, c, a], [x, y], &at, faces),
        [Some(x), Some(y), None] => split_two([c, a, b], [x, y], &at, faces),
    }
}

/// The same where `x`, between `b` and `c`, and `y`, between `c` and `a`, are middles: the quadrilateral below is split along
/// its shorter diagonal.
fn split_two([a, b, c]: [u32; 3], [x, y]: [u32; 2], at: &impl Fn(u32) -> Vec3, faces: &mut Vec<[u32; 3]>) {
    faces.push([x, c, y]);
    let along_a = at(a).distance_squared(at(x)) <= at(b).distance_squared(at(y));
    faces.extend(if along_a { [[a, b, x], [a, x, y]] } else { [[a, b, y], [b, x, y]] });
}

/// Gives new vertices the mean of their parents. Integers, and formats that Bevy's own attributes and maps do not have, get the
/// value of the first parent.
fn interpolate(attribute: &MeshVertexAttribute, values: &mut VertexAttributeValues, parents: &[[u32; 2]]) {
    use VertexAttributeValues as Values;
    fn mean<const N: usize>(a: [f32; N], b: [f32; N]) -> [f32; N] {
        core::array::from_fn(|k| 0.5 * (a[k] + b[k]))
    }
    fn unit(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
        (Vec3::from(a) + Vec3::from(b)).try_normalize().map_or(a, |normal| normal.to_array())
    }
    fn numbers<T: Copy + Into<u32> + TryFrom<u32>, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
        core::array::from_fn(|k| T::try_from((a[k].into() + b[k].into()) / 2).unwrap_or(a[k]))
    }
    match values {
        Values::Float32x3(of) if attribute.id == Mesh::ATTRIBUTE_NORMAL.id => extend(of, parents, unit),
        Values::Float32x4(of) if attribute.id == Mesh::ATTRIBUTE_TANGENT.id => extend(of, parents, |a, b| {
            let [x, y, z] = unit([a[0], a[1], a[2]], [b[0], b[1], b[2]]);
            [x, y, z, a[3]]
        }),
        Values::Float32(of) => extend(of, parents, |a, b| 0.5 * (a + b)),
        Values::Float32x2(of) => extend(of, parents, mean),
        Values::Float32x3(of) => extend(of, parents, mean),
        Values::Float32x4(of) => extend(of, parents, mean),
        Values::Unorm8x4(of) | Values::Unorm8x4Bgra(of) => extend(of, parents, numbers),
        Values::Unorm8x2(of) => extend(of, parents, numbers),
        Values::Unorm16x4(of) => extend(of, parents, numbers),
        Values::Unorm16x2(of) => extend(of, parents, numbers),
        Values::Uint8(of) | Values::Unorm8(of) => extend(of, parents, |a, _| a),
        Values::Uint8x2(of) => extend(of, parents, |a, _| a),
        Values::Uint8x4(of) => extend(of, parents, |a, _| a),
        Values::Sint8(of) | Values::Snorm8(of) => extend(of, parents, |a, _| a),
        Values::Sint8x2(of) | Values::Snorm8x2(of) => extend(of, parents, |a, _| a),
        Values::Sint8x4(of) | Values::Snorm8x4(of) => extend(of, parents, |a, _| a),
        Values::Uint16(of) | Values::Unorm16(of) => extend(of, parents, |a, _| a),
        Values::Uint16x2(of) => extend(of, parents, |a, _| a),
        Values::Uint16x4(of) => extend(of, parents, |a, _| a),
        Values::Sint16(of) | Values::Snorm16(of) => extend(of, parents, |a, _| a),
        Values::Sint16x2(of) | Values::Snorm16x2(of) => extend(of, parents, |a, _| a),
        Values::Sint16x4(of) | Values::Snorm16x4(of) => extend(of, parents, |a, _| a),
        Values::Float16(of) => extend(of, parents, |a, _| a),
        Values::Float16x2(of) => extend(of, parents, |a, _| a),
        Values::Float16x4(of) => extend(of, parents, |a, _| a),
        Values::Uint32(of) | Values::Unorm10_10_10_2(of) => extend(of, parents, |a, _| a),
        Values::Uint32x2(of) => extend(of, parents, |a, _| a),
        Values::Uint32x3(of) => extend(of, parents, |a, _| a),
        Values::Uint32x4(of) => extend(of, parents, |a, _| a),
        Values::Sint32(of) => extend(of, parents, |a, _| a),
        Values::Sint32x2(of) => extend(of, parents, |a, _| a),
        Values::Sint32x3(of) => extend(of, parents, |a, _| a),
        Values::Sint32x4(of) => extend(of, parents, |a, _| a),
        Values::Float64(of) => extend(of, parents, |a, _| a),
        Values::Float64x2(of) => extend(of, parents, |a, _| a),
        Values::Float64x3(of) => extend(of, parents, |a, _| a),
        Values::Float64x4(of) => extend(of, parents, |a, _| a),
    }
}

/// Appends what is between the values of each two parents, which come before it: there is one for each vertex.
fn extend<T: Copy>(values: &mut Vec<T>, parents: &[[u32; 2]], between: impl Fn(T, T) -> T) {
    for &[a, b] in parents {
        values.push(between(values[a as usize], values[b as usize]));
    }
}

/// Gives new vertices the joints of both parents, of which the four heaviest count.
fn share_joints(mesh: &mut Mesh, vertices: usize, parents: &[[u32; 2]]) {
    let (Some(VertexAttributeValues::Uint16x4(joints)), Some(VertexAttributeValues::Float32x4(weights))) =
        (mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX), mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT))
    else {
        return;
    };
    let (mut joints, mut weights) = (joints.clone(), weights.clone());
    for (v, &ends) in (vertices..).zip(parents) {
        let mut shares: Vec<(u16, f32)> = Vec::with_capacity(8);
        for (joint, weight) in ends.into_iter().flat_map(|end| joints[end as usize].into_iter().zip(weights[end as usize])) {
            match shares.iter_mut().find(|(known, _)| *known == joint) {
                Some((_, share)) => *share += 0.5 * weight,
                None => shares.push((joint, 0.5 * weight)),
            }
        }
        // By number where they weigh the same: not by which parent comes first.
        shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let (all, four): (f32, f32) = (shares.iter().map(|s| s.1).sum(), shares.iter().take(4).map(|s| s.1).sum());
        let scale = if four > 0.0 { all / four } else { 1.0 };
        let share = |k: usize| shares.get(k).copied().unwrap_or_default();
        joints[v] = core::array::from_fn(|k| share(k).0);
        weights[v] = core::array::from_fn(|k| share(k).1 * scale);
    }
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints));
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
}

#[cfg(test)]
mod tests {
    use bevy::math::primitives::{Plane3d, Sphere};

    use super::*;

    const MAP: MeshVertexAttribute = MeshVertexAttribute::new("_MAP", 987, bevy::mesh::VertexFormat::Unorm8x4);

    fn positions(mesh: &Mesh) -> Vec<Vec3> {
        read(mesh).expect("a mesh").positions
    }

    fn area_and_longest(mesh: &Mesh) -> (f32, f32) {
        let authored = read(mesh).expect("a mesh");
        let at = |v: u32| authored.positions[v as usize];
        let area = |&[a, b, c]: &[u32; 3]| 0.5 * (at(b) - at(a)).cross(at(c) - at(a)).length();
        let longest = |&[a, b, c]: &[u32; 3]| at(a).distance(at(b)).max(at(b).distance(at(c))).max(at(c).distance(at(a)));
        let all = &authored.triangles;
        (all.iter().map(area).sum(), all.iter().map(longest).fold(0.0, f32::max))
    }

    #[test]
    fn no_edge_is_longer_and_the_surface_is_the_same() {
        let uneven = {
            let mut mesh = Plane3d::default().mesh().size(1.0, 0.2).subdivisions(1).build();
            let Some(VertexAttributeValues::Float32x3(at)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) else {
                panic!("positions")
            };
            at[4][0] = 0.3;
            mesh
        };
        for mesh in [Plane3d::default().mesh().size(2.0, 1.0).build(), uneven, Sphere::new(0.5).mesh().uv(9, 6)] {
            for longest in [0.3, 0.11, 0.05] {
                let finer = subdivide(&mesh, longest).expect("triangles");
                assert!(!finer.is_cut);
                let finer = finer.mesh.expect("long edges");
                let (before, after) = (area_and_longest(&mesh), area_and_longest(&finer));
                assert!((after.0 / before.0 - 1.0).abs() < 1.0e-4, "{} of {}", after.0, before.0);
                assert!(after.1 <= longest && after.1 > 0.3 * longest, "{} for {longest}", after.1);
                let known = positions(&mesh);
                assert_eq!(positions(&finer)[..known.len()], known, "vertices keep their numbers");
            }
            assert!(subdivide(&mesh, 3.0).expect("triangles").mesh.is_none());
        }
    }

    #[test]
    fn seams_stay_closed() {
        // A ball with a seam of texture coordinates: welded, every edge has two faces.
        let finer = subdivide(&Sphere::new(0.5).mesh().uv(7, 5), 0.2).expect("triangles").mesh.expect("long edges");
        let authored = read(&finer).expect("a mesh");
        let source = crate::solver::rest::SourceMesh {
            positions: authored.positions,
            triangles: authored.triangles,
            ..Default::default()
        };
        let (rest, report) = crate::solver::rest::RestShape::build(&source).expect("a ball");
        assert!((0..rest.topology.edges.len() as u32).all(|e| !rest.topology.is_border(e)), "{report:?}");
    }

    #[test]
    fn what_vertices_have_is_interpolated() {
        let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]]);
        mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        mesh.insert_attribute(MAP, VertexAttributeValues::Unorm8x4(vec![[0, 0, 0, 255], [200; 4], [0; 4]]));
        let joints = vec![[0, 1, 2, 3], [4, 5, 0, 0], [7, 0, 0, 0]];
        mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints));
        mesh.insert_attribute(
            Mesh::ATTRIBUTE_JOINT_WEIGHT,
            vec![[0.4, 0.3, 0.2, 0.1], [0.6, 0.4, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]],
        );
        // The longest edge alone.
        let finer = subdivide(&mesh, 1.05).expect("triangles").mesh.expect("a long edge");
        assert_eq!(finer.count_vertices(), 4);
        let value = |attribute: MeshVertexAttribute| {
            finer.attribute(attribute).map(VertexAttributeValues::get_bytes).map(<[u8]>::to_vec)
        };
        assert!(
            value(Mesh::ATTRIBUTE_UV_0).is_some_and(|bytes| bytes.ends_with(&[0.5f32, 0.5].map(f32::to_le_bytes).concat()))
        );
        assert!(value(MAP).is_some_and(|bytes| bytes.ends_with(&[100; 4])));
        let Some(VertexAttributeValues::Float32x3(normals)) = finer.attribute(Mesh::ATTRIBUTE_NORMAL) else {
            panic!("normals")
        };
        assert!(Vec3::from(normals[3]).is_normalized() && normals[3][1] > 0.7);
        let Some(VertexAttributeValues::Uint16x4(joints)) = finer.attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
            panic!("joints")
        };
        let Some(VertexAttributeValues::Float32x4(weights)) = finer.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT) else {
            panic!("weights")
        };
        assert_eq!((joints[3], weights[3]), ([7, 4, 5, 0], [0.5, 0.3, 0.2, 0.0]));
    }

    #[test]
    fn a_length_that_is_far_too_short_ends_and_says_so() {
        let plane = Plane3d::default().mesh().size(10.0, 10.0).build();
        let finer = subdivide(&plane, 1.0e-4).expect("triangles");
        assert!(finer.is_cut && finer.mesh.is_some_and(|mesh| mesh.count_vertices() <= MOST_VERTICES));
        // Of one that is as large already and short enough nothing is said.
        let large = Plane3d::default().mesh().size(1.0, 1.0).subdivisions(230).build();
        let as_it_was = subdivide(&large, 0.1).expect("triangles");
        assert!(large.count_vertices() > MOST_VERTICES && !as_it_was.is_cut && as_it_was.mesh.is_none());
    }

    #[test]
    fn what_is_no_number_or_past_the_end_is_left_out() {
        let mut broken = Plane3d::default().mesh().size(10.0, 10.0).build();
        broken.insert_indices(Indices::U32(vec![0, 1, 2, 7, 8, 9, 1, 2, 3]));
        let split = subdivide(&broken, 5.0).expect("triangles").mesh.expect("long edges");
        assert!(read(&split).expect("triangles").triangles.iter().flatten().all(|v| (*v as usize) < split.count_vertices()));
        let Some(VertexAttributeValues::Float32x3(at)) = broken.attribute_mut(Mesh::ATTRIBUTE_POSITION) else {
            panic!("positions")
        };
        (at[0], at[1], at[2]) = ([f32::NAN; 3], [f32::INFINITY; 3], [3.0e38; 3]);
        assert!(
            subdivide(&broken, 1.0)
                .expect("triangles")
                .mesh
                .is_none_or(|mesh| positions(&mesh)[4..].iter().all(|p| p.is_finite()))
        );
        // Two neighbouring numbers have none between them.
        let Some(VertexAttributeValues::Float32x3(at)) = broken.attribute_mut(Mesh::ATTRIBUTE_POSITION) else {
            panic!("positions")
        };
        let next = 1.0e6f32.next_up();
        (at[0], at[1], at[2], at[3]) = ([1.0e6, 0.0, 0.0], [next, 0.0, 0.0], [1.0e6, 0.0, 0.01], [next, 0.0, 0.01]);
        assert!(subdivide(&broken, 0.05).expect("triangles").mesh.is_none());
    }

    #[test]
    fn an_attribute_that_is_not_one_for_each_vertex_goes() {
        for count in [1, 3, 5, 100] {
            let mut mesh = Plane3d::default().mesh().size(1.0, 1.0).build();
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, vec![[0.5; 2]; count]);
            mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(vec![[0; 4]; count]));
            mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0, 0.0, 0.0, 0.0]; count]);
            let finer = subdivide(&mesh, 0.2).expect("triangles").mesh.expect("long edges");
            let gone = [Mesh::ATTRIBUTE_UV_1, Mesh::ATTRIBUTE_JOINT_INDEX, Mesh::ATTRIBUTE_JOINT_WEIGHT];
            assert!(gone.into_iter().all(|attribute| finer.attribute(attribute).is_none()), "{count}");
            assert_eq!(finer.attribute(Mesh::ATTRIBUTE_UV_0).map(VertexAttributeValues::len), Some(finer.count_vertices()));
        }
    }
}
