//! A coarse level over the cloth: hubs some edges apart, and links that are as long as the way between two hubs along the
//! cloth.
//!
//! ```text
//!      o---------o        o   hub, a particle like any other
//!     / \  . .  / \       .   particle: moves with the hubs around it, each with a weight, weights sum to one
//!    o---o-----o---o      --  link: no longer than the geodesic distance at rest
//! ```
//!
//! Springs carry a load one edge a sweep; links carry it across many edges at once (hierarchical position based dynamics,
//! Müller 2008).

use glam::Vec3;

use super::geodesic::Front;
use crate::solver::topology::Topology;

/// Least distance between hubs, in mean edges (dimensionless). Smaller: more links; larger: more stretch between hubs.
const SPACING: f32 = 5.0;

/// Reach of links and weights, in distances between hubs (dimensionless).
const REACH: f32 = 1.6;

/// Hubs that move a particle, at most.
pub(super) const PER_PARTICLE: usize = 4;

/// Hubs and links of a mesh at rest.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct CoarseMesh {
    /// Least distance between hubs `[m]`.
    pub spacing: f32,
    /// Particle of each hub.
    pub hubs: Vec<u32>,
    /// Hubs that each particle moves with; a hub without weight repeats the first.
    pub around: Vec<[u32; PER_PARTICLE]>,
    /// Weights of these hubs, which sum to 1 (dimensionless).
    pub weights: Vec<[f32; PER_PARTICLE]>,
    /// Pairs of neighbouring hubs.
    pub links: Vec<[u32; 2]>,
    /// Geodesic distance between the two hubs of each link `[m]`.
    pub lengths: Vec<f32>,
}

impl CoarseMesh {
    /// Hubs spread over `topology`, at rest at `positions` `[m]` with edges of `mean_edge` `[m]`.
    #[must_use]
    pub fn new(topology: &Topology, positions: &[Vec3], mean_edge: f32) -> Self {
        let n = positions.len();
        let mut mesh = Self { around: vec![[0; PER_PARTICLE]; n], weights: vec![[0.0; PER_PARTICLE]; n], ..Self::default() };
        let spacing = SPACING * mean_edge;
        mesh.spacing = spacing;
        let reach = REACH * spacing;
        let mut covered = vec![false; n];
        let mut hub_at = vec![u32::MAX; n];
        let mut front = Front::new(n);
        for p in 0..n as u32 {
            if covered[p as usize] {
                continue;
            }
            let hub = mesh.hubs.len() as u32;
            mesh.hubs.push(p);
            hub_at[p as usize] = hub;
            for &(q, distance) in front.run(topology, positions, &[p], reach) {
                covered[q as usize] |= distance < spacing;
                let other = hub_at[q as usize];
                if other < hub {
                    mesh.links.push([other, hub]);
                    mesh.lengths.push(distance);
                }
                // The nearest hubs, nearest first.
                let (hubs, weights) = (&mut mesh.around[q as usize], &mut mesh.weights[q as usize]);
                let weight = (1.0 - distance / reach).powi(2);
                let rank = weights.iter().position(|w| weight > *w);
                if let Some(rank) = rank {
                    weights[rank..].rotate_right(1);
                    hubs[rank..].rotate_right(1);
                    weights[rank] = weight;
                    hubs[rank] = hub;
                }
            }
        }
        for (hubs, weights) in mesh.around.iter_mut().zip(&mut mesh.weights) {
            let sum: f32 = weights.iter().sum();
            for k in 0..PER_PARTICLE {
                weights[k] /= sum;
                if weights[k] == 0.0 {
                    hubs[k] = hubs[0];
                }
            }
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::super::{RestShape, SourceMesh};

    #[test]
    fn every_particle_moves_with_hubs_and_no_link_is_shorter_than_the_straight_way() {
        // Two strips that do not touch.
        let mut mesh = SourceMesh::default();
        for strip in 0..2u32 {
            for i in 0..60u32 {
                let first = mesh.positions.len() as u32;
                mesh.positions.extend([0.0, 1.0].map(|z| glam::Vec3::new(i as f32, 3.0 * strip as f32, z)));
                if i > 0 {
                    mesh.triangles.extend([[first - 2, first - 1, first], [first - 1, first + 1, first]]);
                }
            }
        }
        let Ok((rest, _)) = RestShape::build(&mesh) else { panic!("a valid mesh") };
        let mesh = &rest.coarse;
        for (p, weights) in mesh.weights.iter().enumerate() {
            let sum: f32 = weights.iter().sum();
            assert!((sum - 1.0).abs() < 1.0e-5, "particle {p}: weights sum to {sum}");
            let away = rest.positions[mesh.hubs[mesh.around[p][0] as usize] as usize].distance(rest.positions[p]);
            assert!(away <= mesh.spacing, "particle {p}: its nearest hub is {away} m away");
        }
        for (link, length) in mesh.links.iter().zip(&mesh.lengths) {
            let [a, b] = link.map(|hub| rest.positions[mesh.hubs[hub as usize] as usize]);
            assert!(*length >= 0.999 * a.distance(b) && a.y == b.y, "{length} m from {a} to {b}");
        }
        assert!(mesh.links.len() + 2 >= mesh.hubs.len(), "{} links for {} hubs", mesh.links.len(), mesh.hubs.len());
    }
}
