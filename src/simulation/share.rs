//! What a cloth costs, and what the budget leaves of it.

use crate::components::{ClothDetail, ClothReport};

/// Least time between two changes of one cloth, unless it falls again `[s]`.
const SETTLED: f32 = 1.0;
/// Time over which costs are averaged `[s]`.
const AVERAGED: f32 = 0.25;
/// Most that a frame counts for, over the mean of those before (dimensionless). A stall of the machine is no cost of the cloth.
/// It would keep the cloth still for ever, since still cloth is not measured.
const OUTLIER: f32 = 2.0;

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
    /// For how long that was measured `[s]`.
    measured_for: f32,
    /// Share of its substeps that it took in the last frame (dimensionless).
    pub taken: f32,
    /// Frames of the app that its last frame covers (dimensionless): more than one where it ran in the background.
    pub frames: f32,
    /// Whether its frames are to run in the background.
    pub to_background: bool,
}

impl Default for Share {
    fn default() -> Self {
        Self {
            detail: ClothDetail::Full,
            settled_for: SETTLED,
            has_fallen: false,
            cost: None,
            measured_for: 0.0,
            taken: 1.0,
            frames: 1.0,
            to_background: false,
        }
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
        let now = [fixed, report.integrate_ms / (self.taken * self.frames)];
        let cost = self.cost.get_or_insert(now);
        let sum = |cost: [f32; 2]| cost[0] + cost[1];
        self.measured_for += dt;
        if self.measured_for <= AVERAGED {
            // The first frames load and warm up.
            if sum(now) < sum(*cost) {
                *cost = now;
            }
            return;
        }
        let part = (dt / AVERAGED).min(1.0);
        let most = OUTLIER * sum(*cost);
        // By a coarse clock the first frames may have cost nothing, and twice of that is nothing for ever.
        let counts = if most > 0.0 && sum(now) > most { most / sum(now) } else { 1.0 };
        for (mean, now) in cost.iter_mut().zip(now) {
            *mean += (counts * now - *mean) * part;
        }
    }

    /// Whether its cost is known.
    pub(crate) fn is_known(&self) -> bool {
        self.measured_for > AVERAGED
    }

    /// Whether its cost is known, and it did not change for a while: it may be given more detail.
    pub(crate) fn may_rise(&self) -> bool {
        self.settled_for >= SETTLED && self.is_known()
    }

    /// Whether it may be given less: at once after it was given less, since that is no flicker.
    pub(crate) fn may_fall(&self) -> bool {
        (self.settled_for >= SETTLED || self.has_fallen) && self.is_known()
    }

    /// Leaves everything, as without a budget; what it costs stays known.
    pub(crate) fn lift(&mut self) {
        let Self { cost, measured_for, taken, frames, .. } = *self;
        *self = Self { cost, measured_for, taken, frames, ..Self::default() };
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

    /// A frame of `seconds` that costs 1 ms.
    fn pass(share: &mut Share, seconds: f32) {
        frame(share, seconds, 1.0);
    }

    fn frame(share: &mut Share, seconds: f32, integrate_ms: f32) {
        share.measure(&ClothReport { substeps: 6, integrate_ms, ..ClothReport::default() }, seconds);
    }

    #[test]
    fn a_frame_that_stalls_is_no_cost_and_one_that_lasts_is() {
        let mut share = Share::default();
        frame(&mut share, 0.02, 50.0);
        (0..20).for_each(|_| frame(&mut share, 0.02, 1.0));
        let cost = |share: &Share| share.cost.map(|[fixed, steps]| fixed + steps).expect("it was measured");
        assert!((cost(&share) - 1.0).abs() < 1.0e-3, "{}: the first frame loads", cost(&share));
        frame(&mut share, 0.02, 100.0);
        assert!(cost(&share) < 1.1, "{}: the machine stalled for a frame", cost(&share));
        (0..50).for_each(|_| frame(&mut share, 0.02, 3.0));
        assert!((cost(&share) - 3.0).abs() < 0.15, "{}: for a second it cost 3 ms", cost(&share));
    }

    #[test]
    fn what_cost_nothing_by_a_coarse_clock_is_measured_later() {
        let mut share = Share::default();
        (0..20).for_each(|_| frame(&mut share, 0.02, 0.0));
        (0..100).for_each(|_| frame(&mut share, 0.02, 1.0));
        let cost: f32 = share.cost.expect("it was measured").iter().sum();
        assert!((cost - 1.0).abs() < 0.05, "{cost}");
    }

    #[test]
    fn what_fell_may_fall_again_at_once_and_rise_after_a_second() {
        let mut share = Share::default();
        pass(&mut share, 0.2);
        assert!(!share.may_fall() && !share.may_rise(), "its cost is not known");
        pass(&mut share, 0.2);
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
