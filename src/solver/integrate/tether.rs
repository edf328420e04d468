//! Tethers: no particle is farther from a pin than along the cloth at rest (long-range attachments, Kim et al. 2012).
//!
//! `|x - x_pin| ≤ scale · geodesic distance`. The pin does not move, so a tether costs one particle one projection. A hanging
//! sheet of any resolution carries its weight at once.

use glam::{Mat4, Vec4};

use super::XYZ;
use crate::solver::rest::{LANES, RestShape, geodesic};
use crate::solver::topology::NONE;

/// Groups of touching pins that each get tethers of their own; more groups share one set of shortest tethers.
const ISLANDS: usize = 8;

/// Tethers per particle, to different groups of pins, shortest first.
const PER_PARTICLE: usize = 2;

/// Upper bounds on distances to pins, in batches of four with different free particles.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Tethers {
    particle: Vec<[u32; LANES]>,
    pin: Vec<[u32; LANES]>,
    /// One over the squared geodesic distance at rest `[1/m²]`.
    inverse_square: Vec<Vec4>,
    /// How many lanes hold the shortest tethers, in the order of particles.
    first_rank: usize,
}

impl Tethers {
    /// Memory held `[B]`.
    #[must_use]
    pub(crate) fn bytes(&self) -> usize {
        self.particle.len() * (2 * size_of::<[u32; LANES]>() + size_of::<Vec4>())
    }

    /// Tethers of all particles that `pinned` does not list to the nearest pins of the nearest groups.
    #[must_use]
    pub(crate) fn new(rest: &RestShape, pinned: &[u32]) -> Self {
        let topology = &rest.topology;
        let mut is_pinned = vec![false; topology.particles as usize];
        pinned.iter().for_each(|&p| is_pinned[p as usize] = true);
        let islands = islands(rest, pinned, &is_pinned);
        let fields: Vec<Vec<geodesic::Nearest>> = if islands.len() <= ISLANDS {
            islands.iter().map(|i| geodesic::distances(topology, &rest.positions, i)).collect()
        } else {
            vec![geodesic::distances(topology, &rest.positions, pinned)]
        };

        let mut tethers = Self::default();
        for rank in 0..PER_PARTICLE.min(fields.len()) {
            let mut lane = 0;
            for p in (0..topology.particles).filter(|&p| !is_pinned[p as usize]) {
                let mut found: Vec<geodesic::Nearest> = fields.iter().map(|f| f[p as usize]).collect();
                found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
                let Some(nearest) = found.get(rank).filter(|n| n.source != NONE) else { continue };
                let weight = nearest.distance.powi(2).recip();
                tethers.first_rank += usize::from(rank == 0);
                if lane == 0 {
                    tethers.particle.push([p; LANES]);
                    tethers.pin.push([nearest.source; LANES]);
                    tethers.inverse_square.push(Vec4::splat(weight));
                } else {
                    let batch = tethers.particle.len() - 1;
                    tethers.particle[batch][lane] = p;
                    tethers.pin[batch][lane] = nearest.source;
                    tethers.inverse_square[batch][lane] = weight;
                }
                lane = (lane + 1) % LANES;
            }
        }
        tethers
    }

    /// The largest excess of the tethers of some particles over `scale` times their length at rest, as a share of that length
    /// (dimensionless). Only an excess of more than `least` `[m]` counts; 0 if there is none. Only the shortest tether of each
    /// particle counts, to whose pins it is drawn hardest.
    #[must_use]
    pub(crate) fn excess(&self, particles: impl Iterator<Item = u32>, scale: f32, least: f32, positions: &[Vec4]) -> f32 {
        let mut most = 0.0_f32;
        if scale == f32::INFINITY {
            return most;
        }
        let list = self.particle.as_flattened();
        for p in particles {
            let Ok(i) = list[..self.first_rank].binary_search(&p) else { continue };
            let (batch, lane) = (i / LANES, i % LANES);
            let way = (positions[p as usize] - positions[self.pin[batch][lane] as usize]).truncate().length();
            let excess = way * self.inverse_square[batch][lane].sqrt() - scale;
            // `excess L > least`
            if excess * excess > least * least * self.inverse_square[batch][lane] {
                most = most.max(excess);
            }
        }
        most
    }

    /// Pulls every particle back within `scale` (dimensionless) times its tethers; infinity: none.
    pub(crate) fn solve(&self, scale: f32, positions: &mut [Vec4]) {
        if scale == f32::INFINITY {
            return;
        }
        let shrink = scale.powi(2).recip();
        for ((particle, pin), &inverse_square) in self.particle.iter().zip(&self.pin).zip(&self.inverse_square) {
            let x = particle.map(|i| positions[i as usize]);
            let anchor = pin.map(|i| positions[i as usize]);
            let d: [Vec4; LANES] = std::array::from_fn(|l| x[l] - anchor[l]);
            let m = Mat4::from_cols(d[0], d[1], d[2], d[3]).transpose();
            let square = m.x_axis * m.x_axis + m.y_axis * m.y_axis + m.z_axis * m.z_axis;
            // 1 - L/|d| to second order, as for springs. Most tethers of a hanging cloth are taut: a test would cost more than
            // it saves.
            let u = Vec4::splat(8.0 / 9.0) / (square * (inverse_square * shrink) + Vec4::splat(1.0 / 3.0));
            let back = (Vec4::splat(2.0 / 3.0) - u).max(Vec4::ZERO).to_array();
            for lane in 0..LANES {
                let by = d[lane] * XYZ * back[lane];
                positions[particle[lane] as usize] = x[lane] - by;
            }
        }
    }
}

/// Pins connected by edges between pins.
fn islands(rest: &RestShape, pinned: &[u32], is_pinned: &[bool]) -> Vec<Vec<u32>> {
    let mut seen = vec![false; is_pinned.len()];
    let mut out = Vec::new();
    for &seed in pinned {
        if std::mem::replace(&mut seen[seed as usize], true) {
            continue;
        }
        let mut island = vec![seed];
        let mut head = 0;
        while head < island.len() {
            for &(q, _) in rest.topology.around(island[head]) {
                if is_pinned[q as usize] && !std::mem::replace(&mut seen[q as usize], true) {
                    island.push(q);
                }
            }
            head += 1;
        }
        out.push(island);
    }
    out
}
