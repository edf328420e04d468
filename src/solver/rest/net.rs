//! A coarse net over the cloth: hubs some edges apart, and links that are as long as the way between two hubs along the cloth.
//!
//! ```text
//!      o---------o        o   hub, a particle like any other
//!     / \  . .  / \       .   particle: moves with the hubs around it, each with a weight, weights sum to one
//!    o---o-----o---o      --  link: no longer than the geodesic distance at rest
//! ```
//!
//! Springs carry a load one edge a sweep; links carry it across many edges at once (hierarchical position based dynamics, Müller 2008).

use glam::Vec3;

use super::Topology;
use super::geodesic::Front;

/// Least distance between hubs, in mean edges (dimensionless). Smaller: more links; larger: more stretch between hubs.
const SPACING: f32 = 5.0;

/// Reach of links and weights, in distances between hubs (dimensionless).
const REACH: f32 = 1.6;

/// Hubs that move a particle, at most.
pub const PER_PARTICLE: usize = 4;

/// Hubs and links of a mesh at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Net {
    /// Least distance between hubs [m].
    pub spacing: f32,
    /// Particle of each hub.
    pub hubs: Vec<u32>,
    /// Hubs that each particle moves with; a hub without weight repeats the first.
    pub around: Vec<[u32; PER_PARTICLE]>,
    /// Weights of these hubs, which sum to 1 (dimensionless).
    pub weights: Vec<[f32; PER_PARTICLE]>,
    /// Pairs of neighbouring hubs.
    pub links: Vec<[u32; 2]>,
    /// Geodesic distance between the two hubs of each link [m].
    pub lengths: Vec<f32>,
}

impl Net {
    /// Hubs spread over `topology`, at rest at `positions` [m] with edges of `mean_edge` [m].
    #[must_use]
    pub fn new(topology: &Topology, positions: &[Vec3], mean_edge: f32) -> Self {
        let n = positions.len();
        let mut net = Self { around: vec![[0; PER_PARTICLE]; n], weights: vec![[0.0; PER_PARTICLE]; n], ..Self::default() };
        let spacing = SPACING * mean_edge;
        net.spacing = spacing;
        let reach = REACH * spacing;
        let mut covered = vec![false; n];
        let mut hub_at = vec![u32::MAX; n];
        let mut front = Front::new(n);
        for p in 0..n as u32 {
            if covered[p as usize] {
                continue;
            }
            let hub = net.hubs.len() as u32;
            net.hubs.push(p);
            hub_at[p as usize] = hub;
            for &(q, distance) in front.run(topology, positions, &[p], reach) {
                covered[q as usize] |= distance < spacing;
                let other = hub_at[q as usize];
                if other < hub {
                    net.links.push([other, hub]);
                    net.lengths.push(distance);
                }
                // The nearest hubs, nearest first.
                let (hubs, weights) = (&mut net.around[q as usize], &mut net.weights[q as usize]);
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
        for (hubs, weights) in net.around.iter_mut().zip(&mut net.weights) {
            let sum: f32 = weights.iter().sum();
            for k in 0..PER_PARTICLE {
                weights[k] /= sum;
                if weights[k] == 0.0 {
                    hubs[k] = hubs[0];
                }
            }
        }
        net
    }
}
