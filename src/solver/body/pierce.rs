//! Cloth that a bone goes through: an arm in a cape, where the skin of the cape does not heed the arm.
//!
//! ```text
//!          .-"-.
//!   x ----(-----)---- x    an edge far longer than at rest, with its middle in the bone: its ends are on both sides
//!          '-.-'
//! ```
//!
//! Nothing can bring the ends together as long as the bone pushes them apart. So it does not: it meets neither of them until
//! they are out of it. Those that the skin has outside of the bone, and has limits for, it draws through it, as a tangle is
//! drawn ([`Skinned::draw`]).
//!
//! The skin may hold a particle so close to a bone that no place within its limit keeps the distance. Such a particle is kept
//! only as far away as it may go:
//!
//! ```text
//!   kept = min(thickness + margin, distance of the target + maximum distance from it)
//! ```

use glam::{Vec3, Vec3A, Vec4};
use parry3d::bounding_volume::BoundingVolume;

use super::geometry::{for_each_geometry, half_thickness};
use super::{Body, motion, renumber};
use crate::solver::buffer::Buffer;
use crate::solver::rest::Springs;
use crate::solver::settings::Fabric;
use crate::solver::skinned::{Skinned, TangledLimits};

/// Elongation beyond which an edge is looked at, in strain limits (dimensionless).
const STRETCHED: f32 = 5.0;

/// A particle that a part of a bone does not meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pair {
    pub(super) body: u32,
    pub(super) part: u32,
    pub(super) particle: u32,
}

/// A particle that its skin holds nearer to a part of a bone than is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Held {
    pub(super) pair: Pair,
    /// By how much nearer it may be `[m]`.
    pub(super) inset: f32,
}

/// What bones go through, what skins hold at them, and buffers to find it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pierced {
    /// Sorted.
    pairs: Vec<Pair>,
    before: Buffer<Vec<Pair>>,
    held: Vec<Held>,
    /// Particles of pairs that have their targets outside, and those of which one is inside, as the skin goes through the bone,
    /// too; sorted.
    drawn: Vec<u32>,
    inside: Buffer<Vec<u32>>,
    /// Ends of edges that are far too long.
    edges: Buffer<Vec<[u32; 2]>>,
    planes: Buffer<Vec<Vec4>>,
}

impl Pierced {
    /// Sorted.
    pub(super) fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// What skins hold closer to bones than is kept, by body and part.
    pub(super) fn held(&self) -> &[Held] {
        &self.held
    }

    /// The particles of pairs that have their targets outside of the bone, sorted: the skin [draws](Skinned::draw) them through
    /// it to where they belong.
    pub(crate) fn drawn(&self) -> &[u32] {
        &self.drawn
    }

    /// Bodies have other numbers now, in the same order, or none.
    pub(crate) fn renumber(&mut self, number: impl Fn(u32) -> Option<u32>) {
        renumber(&mut self.pairs, |pair| &mut pair.body, number);
    }

    /// Finds what bones go through as the frame begins. `worst`: length of the worst edge over that at rest.
    pub(crate) fn find(
        &mut self,
        bodies: &[Body],
        skinned: Option<(&Skinned, &TangledLimits)>,
        fabric: &Fabric,
        springs: &Springs,
        worst: f32,
        positions: &[Vec4],
    ) {
        let Self { pairs, before, held, drawn, inside, edges, planes } = self;
        drawn.clear();
        inside.clear();
        let longest = 1.0 + STRETCHED * fabric.strain_limit;
        core::mem::swap(pairs, &mut **before);
        pairs.clear();
        held.clear();
        edges.clear();
        if worst > longest {
            let is_long = |&(a, b, inverse_square): &(usize, usize, f32)| {
                (positions[a] - positions[b]).truncate().length_squared() * inverse_square > longest * longest
            };
            edges.extend(springs.each().filter(is_long).map(|(a, b, _)| [a as u32, b as u32]));
        }
        let skinned = skinned.filter(|(skinned, _)| skinned.limits(positions.len()));
        if before.is_empty() && edges.is_empty() && skinned.is_none() {
            return;
        }
        for (b, body) in (0_u32..).zip(bodies).filter(|(_, body)| body.bone) {
            let Some(pose) = motion::valid(body.from) else { continue };
            let keep = fabric.thickness + body.margin;
            for_each_geometry(&*body.shape.0, planes, |part, local, shape, geometry| {
                let at = pose * local;
                let near = shape.compute_aabb(&at).loosened(keep);
                let is_within = |x: Vec4, inset: f32, reach: f32| {
                    let x = x.truncate();
                    let may_be = near.mins.cmple(x).all() && near.maxs.cmpge(x).all();
                    may_be && geometry.sample(Vec3A::from(at.inverse_transform_point(x)), reach).distance + inset < reach
                };
                let first = before.partition_point(|pair| (pair.body, pair.part) < (b, part));
                let known = before[first..].iter().take_while(|pair| (pair.body, pair.part) == (b, part));
                let is_still = |pair: &&Pair| {
                    let inset = body.inset(pair.particle, keep);
                    positions.get(pair.particle as usize).is_some_and(|x| is_within(*x, inset, keep))
                };
                let first_pair = pairs.len();
                pairs.extend(known.filter(is_still));
                for &[a, c] in &**edges {
                    let ends = [a, c].map(|p| positions[p as usize]);
                    let inset = body.inset(a, keep).min(body.inset(c, keep));
                    if is_within(0.5 * (ends[0] + ends[1]), inset, 0.0) {
                        pairs.extend([a, c].map(|particle| Pair { body: b, part, particle }));
                    }
                }
                // Where its target is at the end of the frame, and the bone too.
                if let (Some((skinned, tangled_limits)), Some(pose)) = (skinned, motion::valid(body.to)) {
                    let (at, most) = (pose * local, keep + half_thickness(shape));
                    let sample = |target: Vec3| geometry.sample(Vec3A::from(at.inverse_transform_point(target)), keep);
                    // What has no limit goes where it likes.
                    for &Pair { particle, .. } in
                        pairs[first_pair..].iter().filter(|pair| skinned.distance(pair.particle as usize) < f32::INFINITY)
                    {
                        let is_outside = sample(skinned.to[particle as usize]).distance > 0.0;
                        if is_outside { &mut *drawn } else { &mut **inside }.push(particle);
                    }
                    let near = shape.compute_aabb(&at).loosened(keep);
                    for (i, target) in skinned.to.iter().enumerate() {
                        let is_near = near.mins.cmple(*target).all() && near.maxs.cmpge(*target).all();
                        let free = tangled_limits.distance(skinned, i);
                        if !is_near || positions[i].w == 0.0 || free >= most {
                            continue;
                        }
                        let inset = keep - sample(*target).distance - free;
                        if inset > 0.0 {
                            held.push(Held { pair: Pair { body: b, part, particle: i as u32 }, inset });
                        }
                    }
                }
            });
        }
        pairs.sort_unstable();
        pairs.dedup();
        inside.sort_unstable();
        drawn.retain(|p| inside.binary_search(p).is_err());
        drawn.sort_unstable();
        drawn.dedup();
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;
    use parry3d::math::Pose;
    use parry3d::shape::SharedShape;

    use super::*;
    use crate::solver::rest::{RestShape, SourceMesh};

    /// A strip along x with edges of 30 mm at rest, and one of the shape given between two rows.
    fn strip(gap: f32) -> (Springs, Vec<Vec4>) {
        let at = |i: u32, gap: f32| [0.0, 0.03].map(|z| vec3(0.03 * i as f32 + if i > 1 { gap } else { 0.0 }, 0.0, z));
        let rest: Vec<Vec3> = (0..4).flat_map(|i| at(i, 0.0)).collect();
        let faces = (0..3).flat_map(|i| [[2 * i, 2 * i + 1, 2 * i + 2], [2 * i + 1, 2 * i + 3, 2 * i + 2]]).collect();
        let (rest, _) =
            RestShape::build(&SourceMesh { positions: rest, triangles: faces, ..SourceMesh::default() }).expect("a strip");
        let order = |p: usize| rest.particle_of_vertex.iter().position(|q| *q as usize == p).unwrap_or(0) as u32;
        let now = (0..8)
            .map(|p| {
                let v = order(p);
                at(v / 2, gap)[v as usize % 2].extend(1.0)
            })
            .collect();
        (rest.springs.clone(), now)
    }

    /// An arm of a radius of 50 mm, with its axis along z at a place on x `[m]`.
    fn arm(x: f32) -> [Body; 1] {
        let pose = Pose::from_translation(Vec3::X * x);
        [Body { bone: true, ..Body::at_rest(SharedShape::capsule_z(0.2, 0.05), pose) }]
    }

    #[test]
    fn an_arm_meets_none_of_the_cloth_on_both_sides_of_it_until_it_has_left() {
        let (fabric, mut pierced) = (Fabric::default(), Pierced::default());
        let (springs, torn) = strip(0.11);
        let worst = crate::solver::integrate::spring::strain(&springs, &torn).0;
        pierced.find(&arm(0.1), None, &fabric, &springs, worst, &torn);
        assert_eq!(pierced.pairs().len(), 4, "{:?}", pierced.pairs());
        // The edges came together in the arm.
        let (_, whole) = strip(0.0);
        pierced.find(&arm(0.045), None, &fabric, &springs, 1.0, &whole);
        assert_eq!(pierced.pairs().len(), 4, "{:?}", pierced.pairs());
        pierced.find(&arm(0.3), None, &fabric, &springs, 1.0, &whole);
        assert!(pierced.pairs().is_empty());
    }

    #[test]
    fn cloth_that_an_arm_goes_through_is_drawn_to_where_the_skin_is_outside() {
        let (fabric, mut pierced) = (Fabric::default(), Pierced::default());
        let (springs, torn) = strip(0.11);
        let worst = crate::solver::integrate::spring::strain(&springs, &torn).0;
        let mut drawn = |target: Vec3| {
            let targets: Vec<Vec3> = vec![target; torn.len()];
            let skinned =
                Skinned { from: targets.clone(), to: targets, max_distance: vec![1.0; torn.len()], ..Skinned::of_radius(0.1) };
            let skinned = (&skinned, &TangledLimits::default());
            pierced.find(&arm(0.1), Some(skinned), &fabric, &springs, worst, &torn);
            assert_eq!(pierced.pairs().len(), 4);
            pierced.drawn().len()
        };
        assert_eq!(drawn(Vec3::Y), 4);
        assert_eq!(drawn(Vec3::X * 0.1), 0, "the skin goes through the arm, too");
        pierced.find(&arm(0.1), None, &fabric, &springs, worst, &torn);
        assert_eq!((pierced.pairs().len(), pierced.drawn().len()), (4, 0), "of what no skin limits nothing is known");
    }

    #[test]
    fn what_is_stretched_elsewhere_or_lies_on_a_bone_meets_it() {
        let (fabric, mut pierced) = (Fabric::default(), Pierced::default());
        let (springs, torn) = strip(0.11);
        let worst = crate::solver::integrate::spring::strain(&springs, &torn).0;
        pierced.find(&arm(0.5), None, &fabric, &springs, worst, &torn);
        assert!(pierced.pairs().is_empty());
        let (_, whole) = strip(0.0);
        pierced.find(&arm(0.045), None, &fabric, &springs, 1.0, &whole);
        assert!(pierced.pairs().is_empty(), "it only began inside");
        // What is no bone is not let through.
        let [body] = arm(0.1);
        pierced.find(&[Body { bone: false, ..body }], None, &fabric, &springs, worst, &torn);
        assert!(pierced.pairs().is_empty());
    }
}
