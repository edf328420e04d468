//! A fabric that is changed while cloth is made of it. Values that could make the cloth jump go to the new ones over a quarter
//! of a second.
//!
//! The change is geometric, so that a hundred times stiffer is as gentle as a hundred times softer. Over a step `dt` of the
//! time `T` that is left, `v' = v (v₁ / v)^(dt / T)`.
//!
//! Bounds of elongation move what they hold, however stiff it is: they let a sheet down that hangs, and draw it up. They go at
//! a speed, `V` at the far end of a cloth of length `L`:
//!
//! ```text
//! raised    b' = b + dt V / L                          until it is out of reach; then it is where it is wanted at once
//! lowered   b' = b - dt min(V / L, (b - b₁) / τ)       from the elongation there is; slowly at the end, where edges go slack
//! ```

use super::scales::RESPONSE_TIME;
use super::settings::Fabric;

/// A cloth longer than this takes as many times longer `[m]`: its end has a longer way.
const LONG: f32 = 2.0;

/// Speed at which a bound of elongation moves the far end of a cloth `[m/s]`.
pub(crate) const RAMP_SPEED: f32 = 0.12;

/// Time `τ` in which a bound that is lowered comes closer to its end by a factor of e `[s]`.
const SETTLE: f32 = 0.5;
/// Least rate at which it does `[1/s]`.
const LEAST_RATE: f32 = 0.005;

/// A bound is out of reach at this many times the worst elongation there is (dimensionless). A bound that holds an edge may be
/// a little exceeded.
const REACH: f32 = 1.25;
/// And by this much more (dimensionless).
const MARGIN: f32 = 0.005;

/// Membrane stiffness that is as good as none `[N/m]`: the way from and to 0 begins and ends here.
const SLACK: f32 = 0.1;
/// Bending stiffness that is as good as none `[N·m]`.
const LIMP: f32 = 1.0e-9;
/// Curvature held by friction that is as good as none `[1/m]`.
const SLIPPERY: f32 = 0.01;
/// Thinnest fabric `[m]`.
const THIN: f32 = 1.0e-4;

/// On the way to a fabric.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Ramp {
    /// Length of the cloth `[m]`.
    length: f32,
    /// None before the first fabric, which is taken as it is.
    target: Option<Fabric>,
    /// Time until it is reached `[s]`.
    left: f32,
}

impl Default for Ramp {
    fn default() -> Self {
        Self::of_length(1.0)
    }
}

impl Ramp {
    /// Of a cloth of that length `[m]`, from one end to the other.
    #[must_use]
    pub(crate) fn of_length(length: f32) -> Self {
        Self { length: length.max(THIN), target: None, left: 0.0 }
    }

    /// Moves `fabric` towards `wanted` for `dt` `[s]`; `worst_edge` is the longest edge over its rest length (dimensionless).
    /// Whether anything changed.
    pub(crate) fn advance(&mut self, fabric: &mut Fabric, wanted: &Fabric, dt: f32, worst_edge: f32) -> bool {
        match &mut self.target {
            None => {
                self.target = Some(wanted.clone());
                return core::mem::replace(fabric, wanted.clone()) != *wanted;
            }
            Some(target) if target != wanted => {
                target.clone_from(wanted);
                self.left = RESPONSE_TIME * (self.length / LONG).max(1.0);
                // From where a bound begins to hold something.
                fabric.strain_limit = fabric.strain_limit.min((worst_edge - 1.0).max(wanted.strain_limit));
                fabric.tether_scale = fabric.tether_scale.min(worst_edge.max(wanted.tether_scale));
            }
            Some(_) => {}
        }
        if fabric == wanted {
            self.left = 0.0;
            return false;
        }
        let share = if self.left > 0.0 { dt / self.left } else { 1.0 };
        self.left = (self.left - dt).max(0.0);
        let way = Way { step: (dt * RAMP_SPEED / self.length).max(0.0), dt };
        let reach = REACH * (worst_edge - 1.0) + MARGIN;
        let tether_scale = way.bound(fabric.tether_scale, wanted.tether_scale, 1.0 + reach);
        // Tethers take the load off the edges: their limit follows, and forces nothing until tethers are where they are wanted.
        let least = if tether_scale > wanted.tether_scale { worst_edge - 1.0 } else { 0.0 };
        let strain_limit = way.bound(fabric.strain_limit, wanted.strain_limit, reach).max(least.min(fabric.strain_limit));
        // Nearly all is all, so that rounding does not cost a frame; and a share that is not a number leaves nothing half way.
        *fabric = if share < 0.999 { between(fabric, wanted, share.max(0.0)) } else { wanted.clone() };
        (fabric.strain_limit, fabric.tether_scale) = (strain_limit, tether_scale);
        true
    }
}

/// How a bound of elongation may move in a frame.
struct Way {
    /// At most (dimensionless).
    step: f32,
    /// Length of the frame `[s]`.
    dt: f32,
}

impl Way {
    /// A bound a frame later; beyond `reach` it holds nothing (dimensionless).
    fn bound(&self, from: f32, to: f32, reach: f32) -> f32 {
        let Self { step, dt } = *self;
        if to < from {
            let rate = ((from - to) / SETTLE).max(LEAST_RATE);
            // Of a cloth that blew up nothing is known.
            if from.is_finite() { (from - step.min(rate * dt)).max(to) } else { to }
        } else if step > 0.0 && (from + step > reach || !reach.is_finite()) {
            to
        } else {
            (from + step).min(to)
        }
    }
}

/// A share of the way from one fabric to another. What moves nothing by itself is there at once.
fn between(from: &Fabric, to: &Fabric, share: f32) -> Fabric {
    let go = |a: f32, b: f32, least: f32| toward(a.max(least), b.max(least), share);
    Fabric {
        density: go(from.density, to.density, 0.0),
        stretch_stiffness: go(from.stretch_stiffness, to.stretch_stiffness, SLACK),
        shear_stiffness: go(from.shear_stiffness, to.shear_stiffness, SLACK),
        bend_stiffness: go(from.bend_stiffness, to.bend_stiffness, LIMP),
        stretch_ratio: go(from.stretch_ratio, to.stretch_ratio, 0.0),
        bend_ratio: go(from.bend_ratio, to.bend_ratio, 0.0),
        bend_hysteresis: go(from.bend_hysteresis, to.bend_hysteresis, SLIPPERY),
        thickness: go(from.thickness, to.thickness, THIN),
        ..to.clone()
    }
}

fn toward(from: f32, to: f32, share: f32) -> f32 {
    if from == to { to } else { from * ((to / from).ln() * share).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: f32 = 1.0 / 60.0;

    fn run(ramp: &mut Ramp, fabric: &mut Fabric, wanted: &Fabric, frames: usize) -> Vec<f32> {
        (0..frames)
            .map(|_| {
                ramp.advance(fabric, wanted, FRAME, 1.02);
                fabric.stretch_stiffness
            })
            .collect()
    }

    #[test]
    fn the_first_fabric_is_taken_as_it_is_and_then_nothing_changes() {
        let (mut ramp, mut fabric) = (Ramp::default(), Fabric::default());
        let wanted = Fabric { density: 3.0, ..Fabric::default() };
        assert!(ramp.advance(&mut fabric, &wanted, FRAME, 0.0));
        assert_eq!(fabric, wanted);
        assert!(!ramp.advance(&mut fabric, &wanted, FRAME, 1.0));
    }

    #[test]
    fn a_hundred_times_stiffer_or_softer_takes_a_quarter_of_a_second_in_even_steps() {
        for factor in [100.0, 0.01] {
            let (mut ramp, mut fabric) = (Ramp::default(), Fabric::default());
            ramp.advance(&mut fabric, &Fabric::default(), FRAME, 0.0);
            let wanted = Fabric { stretch_stiffness: 2000.0 * factor, ..Fabric::default() };
            let way = run(&mut ramp, &mut fabric, &wanted, 15);
            assert_eq!(fabric, wanted, "after {way:?}");
            let step = factor.powf(1.0 / 15.0);
            for pair in way.windows(2) {
                assert!((pair[1] / pair[0] / step - 1.0).abs() < 1.0e-3, "{way:?}");
            }
        }
    }

    #[test]
    fn stiffness_goes_to_nothing_and_comes_back() {
        let (mut ramp, mut fabric) = (Ramp::default(), Fabric::default());
        ramp.advance(&mut fabric, &Fabric::default(), FRAME, 0.0);
        let none = Fabric { stretch_stiffness: 0.0, bend_stiffness: 0.0, ..Fabric::default() };
        let way = run(&mut ramp, &mut fabric, &none, 16);
        assert!(way.is_sorted_by(|a, b| a >= b) && way.iter().all(|k| k.is_finite()), "{way:?}");
        assert_eq!(fabric, none);
        let way = run(&mut ramp, &mut fabric, &Fabric::default(), 16);
        assert!(way[0] < 1.0 && way.is_sorted(), "{way:?}");
        assert_eq!(fabric, Fabric::default());
    }

    #[test]
    fn a_limit_that_is_lowered_starts_at_the_elongation_there_is() {
        let (mut ramp, mut fabric) = (Ramp::default(), Fabric::default());
        let free = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, ..Fabric::default() };
        ramp.advance(&mut fabric, &free, FRAME, 0.0);
        ramp.advance(&mut fabric, &Fabric::default(), FRAME, 1.5);
        assert!(fabric.strain_limit > 0.4 && fabric.strain_limit <= 0.5, "{}", fabric.strain_limit);
        assert!(fabric.tether_scale > 1.4 && fabric.tether_scale <= 1.5, "{}", fabric.tether_scale);
    }

    /// The limit and the scale of tethers, frame by frame, until they are where they are wanted.
    fn bounds(ramp: &mut Ramp, fabric: &mut Fabric, wanted: &Fabric, worst_edge: impl Fn(&Fabric) -> f32) -> Vec<[f32; 2]> {
        let mut way = Vec::new();
        while fabric != wanted {
            ramp.advance(fabric, wanted, FRAME, worst_edge(fabric));
            way.push([fabric.strain_limit, fabric.tether_scale]);
            assert!(way.len() < 10_000, "never there: {fabric:?}");
        }
        way
    }

    #[test]
    fn a_bound_that_holds_something_is_raised_at_a_speed_until_it_is_out_of_reach() {
        let (mut ramp, mut fabric) = (Ramp::of_length(2.0), Fabric::default());
        ramp.advance(&mut fabric, &Fabric::default(), FRAME, 0.0);
        let free = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, ..Fabric::default() };
        // It stretches as far as it may, up to 20 %.
        let way = bounds(&mut ramp, &mut fabric, &free, |fabric| 1.0 + fabric.strain_limit.min(0.2));
        let most = 1.01 * FRAME * RAMP_SPEED / 2.0;
        for pair in way.windows(2) {
            for (a, b, held) in [(pair[0][0], pair[1][0], 0.2), (pair[0][1] - 1.0, pair[1][1] - 1.0, 0.2)] {
                assert!(b == f32::INFINITY && a > held || b - a <= most, "from {a} to {b}");
            }
        }
    }

    #[test]
    fn one_that_is_lowered_goes_ever_slower_and_arrives() {
        let (mut ramp, mut fabric) = (Ramp::of_length(2.0), Fabric::default());
        let free = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, ..Fabric::default() };
        ramp.advance(&mut fabric, &free, FRAME, 0.0);
        // Edges bear less the more tethers hold.
        let wanted = Fabric::default();
        let way = bounds(&mut ramp, &mut fabric, &wanted, |fabric| fabric.tether_scale.min(1.2));
        let most = 1.01 * FRAME * RAMP_SPEED / 2.0;
        for pair in way.windows(2) {
            let steps = [0, 1].map(|k| pair[0][k] - pair[1][k]);
            assert!(steps.iter().all(|step| (0.0..=most).contains(step)), "{pair:?}");
        }
        let [last, end] = [way[way.len() - 2][1], way[way.len() - 1][1]];
        assert!(last - end < 0.2 * most, "{last} to {end}");
        assert!((way.len() as f32) < 8.0 / FRAME, "{} frames", way.len());
    }

    #[test]
    fn a_limit_that_holds_nothing_is_raised_at_once() {
        let (mut ramp, mut fabric) = (Ramp::default(), Fabric::default());
        ramp.advance(&mut fabric, &Fabric::default(), FRAME, 0.0);
        let free = Fabric { strain_limit: f32::INFINITY, ..Fabric::default() };
        ramp.advance(&mut fabric, &free, FRAME, 1.02);
        assert_eq!(fabric.strain_limit, f32::INFINITY);
    }

    #[test]
    fn numbers_that_are_none_leave_nothing_half_way() {
        for worst in [f32::INFINITY, f32::NAN] {
            let (mut ramp, mut fabric) = (Ramp::default(), Fabric::default());
            let free = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, ..Fabric::default() };
            ramp.advance(&mut fabric, &free, FRAME, 0.0);
            let mut frames = 0;
            while fabric != Fabric::default() && frames < 1000 {
                ramp.advance(&mut fabric, &Fabric::default(), FRAME, worst);
                frames += 1;
            }
            assert!(frames < 1000, "{fabric:?} at a worst edge of {worst}");
        }
    }

    #[test]
    fn no_time_no_change() {
        let (mut ramp, mut fabric) = (Ramp::default(), Fabric::default());
        ramp.advance(&mut fabric, &Fabric::default(), FRAME, 0.0);
        let wanted = Fabric { density: 2.0, ..Fabric::default() };
        ramp.advance(&mut fabric, &wanted, 0.0, 1.0);
        assert_eq!(fabric.density, 0.2);
    }
}
