//! What a cloth costs, and what the budget leaves of it.

use crate::components::{ClothDetail, ClothReport};

/// Least time between two changes of one cloth, unless it falls again `[s]`.
const SETTLED: f32 = 1.0;
/// Time over which costs are averaged `[s]`.
const AVERAGED: f32 = 0.25;

/// What a cloth costs, and what the budget leaves of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Share {
    /// What the budget leaves.
    pub detail: ClothDetail,
    /// Time since that changed `[s]`.
    settled_for: f32,
    /// Whether that was to less detail.
    has_fallen: bool,
    /// What it costs in a frame whatever its substeps, and what all of its substeps cost `[ms]`; none: not measured yet.
    pub cost: Option<[f32; 2]>,
    /// Share of its substeps that it took in the last frame (dimensionless).
    pub taken: f32,
}

impl Default for Share {
    fn default() -> Self {
        Self { detail: ClothDetail::Full, settled_for: SETTLED, has_fallen: false, cost: None, taken: 1.0 }
    }
}

impl Share {
    /// Takes in what the last frame cost, `dt` `[s]` after the one before.
    pub(crate) fn measure(&mut self, report: &ClothReport, dt: f32) {
        self.settled_for += dt;
        if report.substeps == 0 || !(self.taken > 0.0) {
            return;
        }
        let fixed = report.detect_ms + report.resolve_ms + report.evaluate_ms + report.respond_ms + report.sync_ms;
        let now = [fixed, report.integrate_ms / self.taken];
        let part = (dt / AVERAGED).min(1.0);
        let cost = self.cost.get_or_insert(now);
        for (mean, now) in cost.iter_mut().zip(now) {
            *mean += (now - *mean) * part;
        }
    }

    /// Whether its cost is known, and it did not change for a while: it may be given more detail.
    pub(crate) fn may_rise(&self) -> bool {
        self.settled_for >= SETTLED && self.cost.is_some()
    }

    /// Whether it may be given less: at once after it was given less, since that is no flicker.
    pub(crate) fn may_fall(&self) -> bool {
        (self.settled_for >= SETTLED || self.has_fallen) && self.cost.is_some()
    }

    /// Leaves another level.
    pub(crate) fn change(&mut self, detail: ClothDetail) {
        (self.has_fallen, self.detail, self.settled_for) = (detail > self.detail, detail, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ClothDetail::{Half, Quarter, Still};

    /// Lets time pass in which it costs something `[s]`.
    fn pass(share: &mut Share, seconds: f32) {
        share.measure(&ClothReport { substeps: 6, integrate_ms: 1.0, ..ClothReport::default() }, seconds);
    }

    #[test]
    fn what_fell_may_fall_again_at_once_and_rise_after_a_second() {
        let mut share = Share::default();
        assert!(!share.may_fall() && !share.may_rise(), "its cost is not known");
        pass(&mut share, 0.1);
        assert!(share.may_fall() && share.may_rise());
        share.change(Half);
        pass(&mut share, 0.1);
        assert!(share.may_fall() && !share.may_rise());
        share.change(Still);
        pass(&mut share, 1.0);
        assert!(share.may_fall() && share.may_rise());
        share.change(Quarter);
        pass(&mut share, 0.9);
        assert!(!share.may_fall() && !share.may_rise(), "it has just risen");
        pass(&mut share, 0.1);
        assert!(share.may_fall() && share.may_rise());
    }
}
