//! A cloth whose mesh is skinned: pinned particles and the animated pose follow the joints.

use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::entity_disabling::Disabled;
use bevy::math::{Affine3A, DVec3, Mat3, Vec4};
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use super::Authored;
use super::placement::{Placement, is_near, seen_from, uniform_scale};
use crate::solver::rest::RestShape;

/// Volume, over that of a box of the same sides, below which skin is pressed flat (dimensionless): its inverse would throw what
/// it carries.
const FLAT: f32 = 0.1;

/// Joints and weights of every particle.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    /// Joints and their inverse bind poses.
    joints: Vec<(Entity, Affine3A)>,
    /// Up to four joints of each particle, with weights that sum to one.
    weights: Vec<([u16; 4], [f32; 4])>,
    /// Positions of the particles in the space of the mesh `[m]`.
    points: Vec<Vec3>,
    /// The joints that carry the cloth as a whole, with weights that sum to one: those of its pins, or of all of it.
    carriers: Vec<(u16, f32)>,
    /// Middle of what they carry `[m]`, in the space of the mesh.
    center: Vec3,
}

/// Most entities between a joint and the joint above it.
const MOST_BETWEEN: usize = 256;

/// The nearest joint above each joint, by number; `parent` of an entity.
pub(crate) fn joints_above(joints: &[Entity], parent: impl Fn(Entity) -> Option<Entity>) -> Vec<Option<usize>> {
    let mut index: EntityHashMap<usize> = EntityHashMap::default();
    for (i, &joint) in joints.iter().enumerate() {
        index.entry(joint).or_insert(i);
    }
    let above = |&joint: &Entity| {
        let mut ancestors = core::iter::successors(parent(joint), |&entity| parent(entity)).take(MOST_BETWEEN);
        ancestors.find_map(|entity| index.get(&entity).copied())
    };
    joints.iter().map(above).collect()
}

/// Transforms of joints and targets; disabled ones still hold.
pub(crate) type Transforms<'w, 's> = Query<'w, 's, &'static GlobalTransform, Allow<Disabled>>;

impl Skin {
    /// Joints and inverse bind poses of a mesh, as far as they go together.
    pub(crate) fn joints(skinned: &SkinnedMesh, bindposes: &SkinnedMeshInverseBindposes) -> Vec<(Entity, Affine3A)> {
        skinned.joints.iter().copied().zip(bindposes.iter().map(|m| Affine3A::from_mat4(*m))).collect()
    }

    /// None when the mesh has no joints or weights that can be used.
    pub(crate) fn new(mesh: &Mesh, authored: &Authored, rest: &RestShape, joints: Vec<(Entity, Affine3A)>) -> Option<Self> {
        let Ok(VertexAttributeValues::Uint16x4(indices)) = mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
            return None;
        };
        let Ok(VertexAttributeValues::Float32x4(amounts)) = mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT) else {
            return None;
        };
        let particles = rest.positions.len();
        let mut skin = Self {
            joints,
            weights: vec![([0; 4], [1.0, 0.0, 0.0, 0.0]); particles],
            points: vec![Vec3::ZERO; particles],
            carriers: Vec::new(),
            center: Vec3::ZERO,
        };
        // Backwards, so that of welded vertices the first one counts; isolated ones, and those that went into another, never
        // do.
        let isolated: Vec<u32> = rest.isolated.iter().map(|(v, _)| *v).collect();
        for (v, &particle) in rest.particle_of_vertex.iter().enumerate().rev() {
            let (Some(&index), Some(&amount), Some(&point)) = (indices.get(v), amounts.get(v), authored.positions.get(v))
            else {
                continue;
            };
            if isolated.binary_search(&(v as u32)).is_ok() || rest.is_gone(v as u32) {
                continue;
            }
            let sum: f32 = amount.iter().sum();
            // With one below 0 the others could be of any size.
            let is_mean = sum > 0.0 && sum.is_finite() && amount.iter().all(|weight| *weight >= 0.0);
            // Where a weight is 0 exporters leave any index.
            let known = |(&joint, weight): (&u16, f32)| weight == 0.0 || usize::from(joint) < skin.joints.len();
            if is_mean && index.iter().zip(amount.iter().copied()).all(known) {
                skin.weights[particle as usize] = (index, amount.map(|w| w / sum));
            }
            skin.points[particle as usize] = point;
        }
        Some(skin)
    }

    /// Finds the joints that carry the cloth as a whole: by the weights of the particles that are `pinned`, or of all where
    /// none is.
    pub(crate) fn find_carriers(&mut self, pinned: &[u32]) {
        let all: Vec<u32> = if pinned.is_empty() { (0..self.points.len() as u32).collect() } else { pinned.to_vec() };
        let mut sums = vec![0.0f32; self.joints.len()];
        let mut center = Vec3::ZERO;
        for &particle in &all {
            let (joints, weights) = self.weights[particle as usize];
            for (joint, weight) in joints.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
                sums[usize::from(joint)] += weight;
            }
            center += self.points[particle as usize];
        }
        let count = all.len().max(1) as f32;
        let carriers = (0..).zip(&sums).filter(|(_, sum)| **sum > 0.0).map(|(joint, sum)| (joint, *sum / count));
        (self.carriers, self.center) = (carriers.collect(), center / count);
    }

    /// Where the skin is as a whole: as its [carriers](Self::find_carriers) turn it, in their mean, and move the middle of what
    /// they carry. Its scale is even. None where a joint is gone, flat or not finite.
    pub(crate) fn placement(&self, transforms: &Transforms) -> Option<Placement> {
        self.placement_by(|joint| {
            let (joint, inverse_bind) = self.joints.get(usize::from(joint))?;
            Some(transforms.get(*joint).ok()?.affine() * *inverse_bind)
        })
    }

    /// As [`Self::placement`], where joints have these skinning matrices as seen from `origin` `[m]`.
    pub(crate) fn placement_of(&self, matrices: &[Affine3A], origin: DVec3) -> Option<Placement> {
        self.placement_by(|joint| {
            let mut matrix = *matrices.get(usize::from(joint))?;
            matrix.translation = (origin + matrix.translation.as_dvec3()).as_vec3a();
            Some(matrix)
        })
    }

    fn placement_by(&self, matrix: impl Fn(u16) -> Option<Affine3A>) -> Option<Placement> {
        let (mut turn, mut scale, mut at) = (Vec4::ZERO, 0.0, Vec3::ZERO);
        for &(joint, weight) in &self.carriers {
            let affine = matrix(joint)?;
            let placement = Placement::of(&affine)?;
            let rotation = Vec4::from(placement.rotation);
            // Of the two quaternions of a rotation the one on the same side.
            turn += rotation * if rotation.dot(turn) < 0.0 { -weight } else { weight };
            scale += uniform_scale(&placement.bake) * weight;
            at += affine.transform_point3(self.center) * weight;
        }
        let rotation = Quat::from_vec4(turn.try_normalize()?);
        let translation = at - rotation * (scale * self.center);
        Some(Placement { rotation, translation, bake: Mat3::from_diagonal(Vec3::splat(scale)) })
    }

    /// Whether a joint moves a particle.
    pub(crate) fn moves_with(&self, joint: u16) -> bool {
        let moves = |(&of, &weight): (&u16, &f32)| of == joint && weight > 0.0;
        self.weights.iter().any(|(joints, weights)| joints.iter().zip(weights).any(moves))
    }

    /// How the skin moved at a particle, from one set of matrices to another. None where it is pressed flat, or was.
    pub(crate) fn motion(&self, [from, to]: [&[Affine3A]; 2], particle: usize) -> Option<Affine3A> {
        let (joints, weights) = self.weights.get(particle)?;
        let blend = |matrices: &[Affine3A]| {
            let mut sum = Affine3A::ZERO;
            for (&joint, &weight) in joints.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                let matrix = matrices.get(usize::from(joint))?;
                sum.matrix3 += matrix.matrix3 * weight;
                sum.translation += matrix.translation * weight;
            }
            Some(sum)
        };
        let (from, to) = (blend(from)?, blend(to)?);
        let (volume, sides) = (from.matrix3.determinant(), from.matrix3);
        let usual = sides.x_axis.length() * sides.y_axis.length() * sides.z_axis.length();
        (volume.abs() > FLAT * usual).then(|| to * from.inverse())
    }

    /// The joint that carries most of the cloth.
    pub(crate) fn main_joint(&self) -> Option<Entity> {
        let most = self.carriers.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        self.joints.get(usize::from(most.0)).map(|(joint, _)| *joint)
    }

    /// The inverse bind pose of a joint; none for what is no joint of the skin.
    pub(crate) fn inverse_bind(&self, joint: Entity) -> Option<Affine3A> {
        self.joints.iter().find(|(known, _)| *known == joint).map(|(_, inverse_bind)| *inverse_bind)
    }

    /// Its joints.
    pub(crate) fn entities(&self) -> impl Iterator<Item = Entity> {
        self.joints.iter().map(|(joint, _)| *joint)
    }

    /// The number of a joint; none for what is no joint of the skin.
    pub(crate) fn index(&self, joint: Entity) -> Option<u16> {
        (0..).zip(&self.joints).find(|(_, (known, _))| *known == joint).map(|(index, _)| index)
    }

    /// Where a joint is in the bind pose, in the space of the mesh.
    pub(crate) fn bind(&self, joint: u16) -> Affine3A {
        self.joints.get(usize::from(joint)).map_or(Affine3A::IDENTITY, |(_, inverse_bind)| inverse_bind.inverse())
    }

    /// Positions of the particles in the bind pose, in the space of the mesh `[m]`.
    pub(crate) fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Middle of what carries the cloth `[m]`, in the space of the mesh.
    pub(crate) fn center(&self) -> Vec3 {
        self.center
    }

    /// Skinning matrices as seen from `origin`; a joint that is gone or not finite keeps its last one. False if there was none
    /// yet.
    pub(crate) fn matrices(&self, transforms: &Transforms, origin: DVec3, matrices: &mut Vec<Affine3A>) -> bool {
        skinning_matrices(&self.joints, transforms, origin, matrices)
    }

    /// Skinned position of a particle.
    pub(crate) fn pose(&self, matrices: &[Affine3A], particle: usize) -> Vec3 {
        let (Some((joints, weights)), Some(&point)) = (self.weights.get(particle), self.points.get(particle)) else {
            return Vec3::ZERO;
        };
        let place = |(&joint, &weight): (&u16, &f32)| match matrices.get(usize::from(joint)) {
            Some(matrix) if weight != 0.0 => matrix.transform_point3(point) * weight,
            _ => Vec3::ZERO,
        };
        joints.iter().zip(weights).map(place).sum()
    }

    /// Direction of a normal of a particle, as the skin turns it; of any length. By cofactors, which do not ask for an inverse:
    /// skin that is pressed flat has none.
    pub(crate) fn turn(&self, matrices: &[Affine3A], particle: usize, normal: Vec3) -> Vec3 {
        let Some((joints, weights)) = self.weights.get(particle) else { return normal };
        let place = |(&joint, &weight): (&u16, &f32)| match matrices.get(usize::from(joint)) {
            Some(matrix) if weight != 0.0 => Mat3::from(matrix.matrix3) * weight,
            _ => Mat3::ZERO,
        };
        let Mat3 { x_axis: x, y_axis: y, z_axis: z } =
            joints.iter().zip(weights).map(place).fold(Mat3::ZERO, |sum, matrix| sum + matrix);
        y.cross(z) * normal.x + z.cross(x) * normal.y + x.cross(y) * normal.z
    }
}

/// As [`Skin::matrices`], before there is a skin.
pub(crate) fn skinning_matrices(
    joints: &[(Entity, Affine3A)],
    transforms: &Transforms,
    origin: DVec3,
    matrices: &mut Vec<Affine3A>,
) -> bool {
    let complete = matrices.len() == joints.len();
    if !complete {
        matrices.clear();
    }
    for (i, (joint, inverse_bind)) in joints.iter().enumerate() {
        let skinning = |joint: &GlobalTransform| seen_from(&joint.affine(), origin) * *inverse_bind;
        match (transforms.get(*joint).ok().map(skinning).filter(is_near), complete) {
            (Some(matrix), true) => matrices[i] = matrix,
            (Some(matrix), false) => matrices.push(matrix),
            (None, true) => {}
            (None, false) => return false,
        }
    }
    !joints.is_empty()
}

#[cfg(test)]
mod tests {
    use bevy::asset::RenderAssetUsages;
    use bevy::mesh::{Indices, PrimitiveTopology};

    use super::*;
    use crate::bind::read;
    use crate::solver::rest::SourceMesh;

    #[test]
    fn weights_that_are_no_mean_leave_a_vertex_to_its_first_joint() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let weights = [[1.0, 1.0, 0.0, 0.0], [1.0e38, -1.0e38, 1.0e-6, 0.0], [f32::NAN, 1.0, 0.0, 0.0]];
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; 3]))
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights.to_vec())
            .with_inserted_indices(Indices::U32(vec![0, 1, 2]));
        let authored = read(&mesh).expect("a mesh");
        let source = SourceMesh { positions: authored.positions.clone(), triangles: vec![[0, 1, 2]], ..Default::default() };
        let (rest, _) = RestShape::build(&source).expect("a shape");
        let joints = vec![(Entity::PLACEHOLDER, Affine3A::IDENTITY); 2];
        let skin = Skin::new(&mesh, &authored, &rest, joints).expect("a skin");
        let matrices = [Vec3::ZERO, Vec3::Y].map(Affine3A::from_translation);
        let posed = [0, 1, 2].map(|v| skin.pose(&matrices, rest.particle_of_vertex[v] as usize));
        assert_eq!(posed, [Vec3::new(0.0, 0.5, 0.0), Vec3::X, Vec3::Y]);
    }
}
