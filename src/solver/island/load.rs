//! Untangling before the first frame: cloths that start in each other are taken apart before anyone sees them.
//!
//! ```text
//! (advance ─► springs ─► look)*       first by end type, then by region, then along more directions, until clean or spent
//! ```
//!
//! No time passes and no velocity comes of it.

use glam::{Vec3, Vec4};

use super::evaluate::{Resort, Verdict};
use super::group::{Group, UntangleSettings};
use super::rest::RestShape;

/// Iterations between two looks at whether to try something stronger.
const PORTION: u32 = 16;

/// What untangling at load did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadReport {
    /// As it came.
    pub before: Verdict,
    /// As it is.
    pub after: Verdict,
    /// Iterations taken.
    pub iterations: u32,
    /// Largest displacement of a particle `[m]`.
    pub farthest: f32,
}

/// Brings every edge halfway to its length at rest, in order; what to sweep the springs with before the first step has prepared any.
pub fn relax_edges(rest: &RestShape, positions: &mut [Vec4]) {
    if positions.len() != rest.positions.len() {
        return;
    }
    for &[a, b] in &rest.topology.edges {
        let (a, b) = (a as usize, b as usize);
        let (edge, sum) = ((positions[b] - positions[a]).truncate(), positions[a].w + positions[b].w);
        let (now, then) = (edge.length(), rest.positions[a].distance(rest.positions[b]));
        if sum > 0.0 && now > 0.0 {
            let by = 0.5 * (1.0 - then / now) / sum * edge;
            positions[a] += (positions[a].w * by).extend(0.0);
            positions[b] -= (positions[b].w * by).extend(0.0);
        }
    }
}

impl Group {
    /// Takes what was gathered apart in at most `most` iterations; give it back with [`Group::scatter`]. `relax` sweeps the springs of a
    /// cloth, given its number and its positions; [`relax_edges`] does.
    pub fn untangle_at_load(
        &mut self,
        settings: &UntangleSettings,
        most: u32,
        mut relax: impl FnMut(usize, &mut [Vec4]),
    ) -> LoadReport {
        let start: Vec<Vec3> = self.positions().iter().map(|p| p.truncate()).collect();
        let mut report = LoadReport { before: self.detect(), ..LoadReport::default() };
        let mut moved = false;
        while report.iterations < most {
            self.escalate(match 3 * report.iterations / most {
                0 => Resort::None,
                1 => Resort::Regions,
                _ => Resort::Candidates,
            });
            self.inspect_layers();
            let portion = UntangleSettings { iterations: PORTION.min(most - report.iterations), ..*settings };
            self.resolve(&portion, &mut relax);
            moved |= self.has_moved();
            let taken = self.iterations();
            report.iterations += taken;
            report.after = self.detect();
            if taken == 0 {
                break;
            }
        }
        self.escalate(Resort::None);
        self.keep_moved(moved);
        let way = |(now, start): (&Vec4, &Vec3)| now.truncate().distance(*start);
        report.farthest = self.positions().iter().zip(&start).map(way).fold(0.0, f32::max);
        report
    }
}
