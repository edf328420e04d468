//! The coarse level: hubs are no farther from each other than along the cloth, and the cloth between them moves with them.
//!
//! A link is an upper bound, `|d| <= (1 + limit / 2) L`. It is solved as a rigid constraint between hubs of the mass
//! `M_i = Σ_p w_pi m_p`. So `Δx_p = Σ_i w_pi Δ_i` keeps the momentum of the cloth. Slack links do nothing: folds and wrinkles
//! are the cloth's own.

use glam::Vec4;

use crate::solver::rest::{CoarseMesh, RestShape, geodesic};

/// Passes over all links in a substep.
const PASSES: u32 = 2;

/// Masses and corrections of hubs.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct CoarseLevel {
    /// Inverse mass of each hub `[1/kg]`; 0: pinned.
    inverse_mass: Vec<f32>,
    /// How much of its hubs' moves each particle takes: 0 at a pin, 1 from one distance between hubs on (dimensionless).
    freedom: Vec<f32>,
    /// Where each hub goes in this substep `[m]`.
    moves: Vec<Vec4>,
}

impl CoarseLevel {
    /// Memory held `[B]`.
    #[must_use]
    pub(crate) fn bytes(&self) -> usize {
        self.inverse_mass.len() * (size_of::<f32>() + size_of::<Vec4>()) + size_of_val(&self.freedom[..])
    }

    /// Must follow a change of the rigid pins.
    pub(crate) fn hold(&mut self, rest: &RestShape, pinned: &[u32]) {
        self.freedom.clear();
        self.freedom.resize(rest.positions.len(), 1.0);
        let near = rest.coarse.spacing;
        for &(p, distance) in geodesic::Front::new(rest.positions.len()).run(&rest.topology, &rest.positions, pinned, near) {
            self.freedom[p as usize] = distance / near;
        }
    }

    /// Recomputes masses from the inverse masses in `w` of `positions`.
    pub(crate) fn update(&mut self, mesh: &CoarseMesh, positions: &[Vec4]) {
        self.inverse_mass.clear();
        self.inverse_mass.resize(mesh.hubs.len(), 0.0);
        self.moves.clear();
        self.moves.resize(mesh.hubs.len(), Vec4::ZERO);
        for ((x, hubs), weights) in positions.iter().zip(&mesh.around).zip(&mesh.weights) {
            let mass = if x.w > 0.0 { x.w.recip() } else { 0.0 };
            for (&hub, weight) in hubs.iter().zip(weights) {
                self.inverse_mass[hub as usize] += mass * weight;
            }
        }
        for (mass, &p) in self.inverse_mass.iter_mut().zip(&mesh.hubs) {
            *mass = if *mass > 0.0 { self.freedom[p as usize] / *mass } else { 0.0 };
        }
    }

    /// Draws hubs together that are farther apart than the strain limit allows, and the cloth with them.
    pub(crate) fn solve(&mut self, mesh: &CoarseMesh, strain_limit: f32, positions: &mut [Vec4]) {
        let slack = (1.0 + 0.5 * strain_limit).powi(2);
        let mut moved = false;
        for _ in 0..PASSES {
            for (&[a, b], &length) in mesh.links.iter().zip(&mesh.lengths) {
                let (a, b) = (a as usize, b as usize);
                let hub = |i: usize| positions[mesh.hubs[i] as usize] + self.moves[i];
                let d = (hub(b) - hub(a)).with_w(0.0);
                let q = d.length_squared() / (length * length * slack);
                let w = self.inverse_mass[a] + self.inverse_mass[b];
                if q > 1.0 && w > 0.0 {
                    let by = d * ((1.0 - q.sqrt().recip()) / w);
                    self.moves[a] += by * self.inverse_mass[a];
                    self.moves[b] -= by * self.inverse_mass[b];
                    moved = true;
                }
            }
        }
        if !moved {
            return;
        }
        for (((x, hubs), weights), &freedom) in positions.iter_mut().zip(&mesh.around).zip(&mesh.weights).zip(&self.freedom) {
            if x.w > 0.0 {
                let [a, b, c, d] = hubs.map(|hub| self.moves[hub as usize]);
                *x += (a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]) * freedom;
            }
        }
        self.moves.fill(Vec4::ZERO);
    }
}
