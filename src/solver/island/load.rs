//! Untangling before the first frame: cloths that start in each other are taken apart before anyone sees them.
//!
//! ```text
//! (advance ─► springs ─► look)*       first by end type, then by region, then along more directions, until clean or spent
//! ```
//!
//! No time passes and no velocity comes of it. What is more than the work of a frame goes on in the next ones, between which
//! time does pass.

use glam::{Vec3, Vec4};

use super::{Island, Member, UntangleSettings};
use crate::solver::rest::RestShape;
use crate::solver::verdict::{Escalation, Verdict};

/// Iterations at load, at most.
const AT_LOAD: u32 = 300;

/// Iterations between two looks at whether to try something stronger.
const PORTION: u32 = 16;

/// What untangling at load did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
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

/// Brings every edge halfway to its length at rest, in order; what to sweep the springs with before the first step has prepared
/// any.
fn relax_edges(rest: &RestShape, positions: &mut [Vec4]) {
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

impl Island {
    /// Takes the cloths apart before the first frame, in at most `most` iterations, whatever work that is.
    pub fn untangle_at_load(&mut self, settings: &UntangleSettings, most: u32, cloths: &mut [Member<'_>]) -> LoadReport {
        let known = cloths.len().min(self.surface.parts.len());
        let cloths = &mut cloths[..known];
        for (part, m) in cloths.iter().enumerate() {
            self.gather_member(part, m);
        }
        let start: Vec<Vec3> = self.positions.iter().map(|p| p.truncate()).collect();
        let mut report = LoadReport { before: self.detect_gathered(), ..LoadReport::default() };
        report.after = report.before;
        let mut moved = false;
        let mut goes_on = true;
        while goes_on {
            self.untangler.resolver.effort = self.most;
            goes_on = self.load(settings, most, &mut report, cloths);
            moved |= self.moved;
        }
        self.moved = moved;
        let way = |(now, start): (&Vec4, &Vec3)| now.truncate().distance(*start);
        report.farthest = self.positions.iter().zip(&start).map(way).fold(0.0, f32::max);
        for (part, m) in cloths.iter_mut().enumerate() {
            self.scatter(part, &mut m.sim.state, m.offset);
        }
        report
    }

    /// Begins to take apart the tangles that are to be taken apart at load, or goes on with it. It stops where the work of a
    /// frame is spent.
    pub(super) fn load_in_frame(&mut self, settings: &UntangleSettings, cloths: &[Member<'_>]) {
        let begins = cloths.iter().any(|m| m.at_load && m.sim.display.is_new());
        let known = self.loading.take().or_else(|| begins.then(LoadReport::default));
        if let Some(mut report) = known.filter(|_| !self.total.is_clean()) {
            self.loading = self.load(settings, AT_LOAD, &mut report, cloths).then_some(report);
        }
    }

    /// Takes the gathered cloth apart, as far as the work of a frame allows, in at most `most` iterations. Those that the
    /// report counts already are included. Returns whether there is more to be done.
    fn load(&mut self, settings: &UntangleSettings, most: u32, report: &mut LoadReport, cloths: &[Member<'_>]) -> bool {
        let mut relax = |part: usize, positions: &mut [Vec4]| {
            if let Some(m) = cloths.get(part) {
                relax_edges(m.cloth.rest, positions);
            }
        };
        let (mut moved, mut goes_on) = (false, true);
        while goes_on && report.iterations < most {
            self.escalate(match 3 * report.iterations / most {
                0 => Escalation::None,
                1 => Escalation::Regions,
                _ => Escalation::Candidates,
            });
            self.inspect_layers();
            let portion = UntangleSettings { iterations: PORTION.min(most - report.iterations), ..*settings };
            self.take_apart(&portion, &mut relax);
            moved |= self.has_moved();
            let taken = self.iterations();
            report.iterations += taken;
            report.after = self.detect_gathered();
            goes_on = taken > 0;
            if self.untangler.resolver.effort.is_spent() {
                break;
            }
        }
        self.escalate(Escalation::None);
        self.moved |= moved;
        goes_on && report.iterations < most
    }
}
