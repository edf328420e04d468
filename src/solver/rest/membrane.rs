//! Triangles of the membrane: how each one stretches along the threads and shears between them.

use glam::{Vec3, Vec4};

use super::batch::{LANES, batches};
use super::weave::Threads;
use crate::solver::topology::Topology;

/// One element for each triangle, in batches of four that share no particle. All arrays have one entry per batch; empty without
/// directions of threads.
///
/// Let the edges be `d1 = x1 - x0`, `d2 = x2 - x0`. The columns of the deformation gradient are
/// `F_warp = d1 warp[0] + d2 warp[1]` and `F_weft = d1 weft[0] + d2 weft[1]`. Each is what a unit of length along its thread
/// has become.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Membrane {
    /// The three particles of each triangle.
    pub corners: Vec<[[u32; LANES]; 3]>,
    /// Shares of `d1` and `d2` in `F_warp` `[1/m]`.
    pub warp: Vec<[Vec4; 2]>,
    /// Shares of `d1` and `d2` in `F_weft` `[1/m]`.
    pub weft: Vec<[Vec4; 2]>,
    /// One over the area at rest `[1/m²]`.
    pub inverse_area: Vec<Vec4>,
}

impl Membrane {
    /// Of the faces of `topology` at rest at `positions` `[m]`, with the directions of the threads of each, or of none.
    pub(super) fn new(topology: &Topology, positions: &[Vec3], threads: &[Threads]) -> Self {
        let mut membrane = Self::default();
        if threads.len() != topology.faces.len() {
            return membrane;
        }
        let element = |face: u32| {
            let [d1, d2] = {
                let [a, b, c] = topology.faces[face as usize].map(|p| positions[p as usize]);
                [b - a, c - a]
            };
            let Threads { warp, weft } = threads[face as usize].or_along(d1, d2);
            let [p1, q1, p2, q2] = [d1.dot(warp), d1.dot(weft), d2.dot(warp), d2.dot(weft)];
            let twice_area = p1 * q2 - p2 * q1;
            ([q2, -q1].map(|q| q / twice_area), [-p2, p1].map(|p| p / twice_area), 2.0 / twice_area.abs())
        };
        for batch in batches(topology.particles as usize, &topology.faces) {
            let lanes = batch.map(element);
            let pair =
                |of: &dyn Fn(usize, usize) -> f32| [0, 1].map(|k| Vec4::from_array(std::array::from_fn(|lane| of(lane, k))));
            membrane.corners.push(std::array::from_fn(|k| batch.map(|face| topology.faces[face as usize][k])));
            membrane.warp.push(pair(&|lane, k| lanes[lane].0[k]));
            membrane.weft.push(pair(&|lane, k| lanes[lane].1[k]));
            membrane.inverse_area.push(Vec4::from_array(lanes.map(|lane| lane.2)));
        }
        membrane
    }

    /// Whether nothing tells where the threads are.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Memory held `[B]`.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.corners.len() * (size_of::<[[u32; LANES]; 3]>() + 5 * size_of::<Vec4>())
    }
}
