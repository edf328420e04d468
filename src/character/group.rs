//! Which vertices belong to which joint.
//!
//! ```text
//!   dominant   joint with the largest weight of each vertex
//!   merge      deepest joints first: a group that is too small goes to the parent
//! ```

use glam::{Affine3A, Vec3};

use super::fit::{FitSettings, SkinnedBody};
use super::shape::inverse;

/// Largest coordinate of a vertex that counts `[m]`; shapes take no larger one.
const LARGEST: f32 = 1.0e6;

/// Vertices that one joint moves.
#[derive(Debug)]
pub(super) struct Group {
    /// Index of the joint.
    pub joint: usize,
    /// Positions in the space of the mesh `[m]`.
    pub points: Vec<Vec3>,
    /// The joint's place in the space of the mesh `[m]`.
    pub origin: Vec3,
    /// Places of the nearest joints below that have a group of their own `[m]`.
    pub below: Vec<Vec3>,
}

/// Groups of a body, by index of their joint. Each has at least one point.
pub(super) fn groups(body: &SkinnedBody, settings: &FitSettings) -> Vec<Group> {
    let parents = parents(body);
    let mut points = by_dominant_joint(body);
    let least = settings.least_share * height(&points);
    let bones: Vec<Option<Affine3A>> = body.inverse_binds.iter().map(inverse).collect();
    let small = |points: &[Vec3], joint: usize| {
        points.len() < settings.least_vertices || diagonal(points) < least || bones.get(joint).is_none_or(Option::is_none)
    };
    for joint in deepest_first(&parents) {
        if let Some(parent) = parents[joint]
            && small(&points[joint], joint)
        {
            let given = std::mem::take(&mut points[joint]);
            points[parent].extend(given);
        }
    }
    // What no parent took: strays, unless it is all there is.
    let large: Vec<bool> = points.iter().enumerate().map(|(joint, points)| !small(points, joint)).collect();
    let any = large.contains(&true);
    let mut groups: Vec<Group> = Vec::new();
    for joint in 0..points.len() {
        let kept = if any { large[joint] } else { !points[joint].is_empty() };
        if let Some(bone) = bones[joint].filter(|_| kept) {
            let origin = Vec3::from(bone.translation) * body.unit;
            groups.push(Group { joint, points: std::mem::take(&mut points[joint]), origin, below: Vec::new() });
        }
    }
    for i in 0..groups.len() {
        let owner = above(&parents, groups[i].joint).find_map(|joint| groups.iter().position(|group| group.joint == joint));
        if let Some(owner) = owner {
            let origin = groups[i].origin;
            groups[owner].below.push(origin);
        }
    }
    groups
}

/// The parent of each joint, without those out of range and without cycles.
fn parents(body: &SkinnedBody) -> Vec<Option<usize>> {
    let count = body.inverse_binds.len();
    let parent = |joint: usize| body.parents.get(joint).copied().flatten().filter(|&parent| parent < count);
    let mut parents: Vec<Option<usize>> = (0..count).map(parent).collect();
    for joint in 0..count {
        // Whoever is above itself becomes a root.
        if above(&parents, joint).any(|other| other == joint) {
            parents[joint] = None;
        }
    }
    parents
}

/// Joints above one, the nearest first.
fn above(parents: &[Option<usize>], joint: usize) -> impl Iterator<Item = usize> {
    let up = |joint: usize| parents.get(joint).copied().flatten();
    std::iter::successors(up(joint), move |&joint| up(joint)).take(parents.len())
}

/// All joints, those with most joints above first.
fn deepest_first(parents: &[Option<usize>]) -> Vec<usize> {
    let mut joints: Vec<usize> = (0..parents.len()).collect();
    joints.sort_by_cached_key(|&joint| std::cmp::Reverse(above(parents, joint).count()));
    joints
}

/// Points of each joint `[m]`.
fn by_dominant_joint(body: &SkinnedBody) -> Vec<Vec<Vec3>> {
    let mut points = vec![Vec::new(); body.inverse_binds.len()];
    for (joint, point) in usable(body) {
        points[joint].push(point);
    }
    points
}

/// Vertices that count: the joint that moves each most, and its place in the space of the mesh `[m]`.
pub(super) fn usable<'a>(body: &SkinnedBody<'a>) -> impl Iterator<Item = (usize, Vec3)> + use<'a> {
    let (count, unit) = (body.inverse_binds.len(), body.unit);
    let vertices = body.positions.iter().zip(body.joints).zip(body.weights).filter(move |_| unit.is_normal() && unit > 0.0);
    vertices.filter_map(move |((&position, joints), weights)| {
        let point = position * unit;
        let near = point.is_finite() && point.abs().max_element() <= LARGEST;
        dominant(joints, weights, count).filter(|_| near).map(|joint| (joint, point))
    })
}

/// The joint of most weight, of equal ones the first; weights of one joint in several slots add up.
fn dominant(joints: &[u16; 4], weights: &[f32; 4], count: usize) -> Option<usize> {
    let counts = |joint: u16, weight: f32| usize::from(joint) < count && weight > 0.0 && weight.is_finite();
    let total = |joint: u16| -> f32 {
        joints.iter().zip(weights).filter(|&(&other, &weight)| other == joint && counts(other, weight)).map(|(_, w)| w).sum()
    };
    let mut best = None;
    for (&joint, &weight) in joints.iter().zip(weights) {
        if counts(joint, weight) && best.is_none_or(|(_, most)| total(joint) > most) {
            best = Some((usize::from(joint), total(joint)));
        }
    }
    best.map(|(joint, _)| joint)
}

/// The longest side of the box around all points `[m]`: the height of a body, or the span of its arms.
fn height(points: &[Vec<Vec3>]) -> f32 {
    extent(points.iter().flatten()).max_element()
}

fn diagonal(points: &[Vec3]) -> f32 {
    extent(points.iter()).length()
}

fn extent<'a>(points: impl Iterator<Item = &'a Vec3>) -> Vec3 {
    let (low, high) = points.fold((Vec3::MAX, Vec3::MIN), |(low, high), &p| (low.min(p), high.max(p)));
    (high - low).max(Vec3::ZERO)
}
