//! A fabric that is changed while cloth is made of it: what could make the cloth jump goes to its new value over a quarter of a second.
//!
//! Geometrically, so that a hundred times stiffer is as gentle as a hundred times softer: over a step `dt` of the time `T` that is left, `v' = v (v₁ / v)^(dt / T)`.
//! A limit of elongation that is lowered starts at the elongation there is and moves likewise as `1 + limit`; one that is raised holds at once, because
//! nothing is drawn to it.

use super::settings::Fabric;

/// Time in which a changed fabric is reached [s].
pub const SLEW_TIME: f32 = 0.25;

/// Membrane stiffness that is as good as none [N/m]: the way from and to 0 begins and ends here.
const SLACK: f32 = 0.1;
/// Bending stiffness that is as good as none [N·m].
const LIMP: f32 = 1.0e-9;
/// Thinnest fabric [m].
const THIN: f32 = 1.0e-4;

/// On the way to a fabric.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slew {
    /// None before the first fabric, which is taken as it is.
    target: Option<Fabric>,
    /// Time until it is reached [s].
    left: f32,
}

impl Slew {
    /// Moves `fabric` towards `wanted` for `dt` [s]; `worst_edge` is the longest edge over its rest length (dimensionless). Whether anything changed.
    pub fn advance(&mut self, fabric: &mut Fabric, wanted: &Fabric, dt: f32, worst_edge: f32) -> bool {
        match &mut self.target {
            None => {
                self.target = Some(wanted.clone());
                self.left = 0.0;
            }
            Some(target) if target != wanted => {
                target.clone_from(wanted);
                self.left = SLEW_TIME;
            }
            Some(_) => {}
        }
        if fabric == wanted {
            self.left = 0.0;
            return false;
        }
        let share = if self.left > 0.0 { dt / self.left } else { 1.0 };
        self.left = (self.left - dt).max(0.0);
        // Nearly all is all, so that rounding does not cost a frame; and a share that is not a number leaves nothing half way.
        *fabric = if share < 0.999 { between(fabric, wanted, share.max(0.0), worst_edge) } else { wanted.clone() };
        true
    }
}

/// A share of the way from one fabric to another. What moves nothing by itself is there at once.
fn between(from: &Fabric, to: &Fabric, share: f32, worst_edge: f32) -> Fabric {
    let go = |a: f32, b: f32, least: f32| toward(a.max(least), b.max(least), share);
    let limit = |a: f32, b: f32| if b < a { toward(a.min(worst_edge.max(b)), b, share) } else { b };
    Fabric {
        density: go(from.density, to.density, 0.0),
        stretch_stiffness: go(from.stretch_stiffness, to.stretch_stiffness, SLACK),
        shear_stiffness: go(from.shear_stiffness, to.shear_stiffness, SLACK),
        bend_stiffness: go(from.bend_stiffness, to.bend_stiffness, LIMP),
        thickness: go(from.thickness, to.thickness, THIN),
        strain_limit: limit(1.0 + from.strain_limit, 1.0 + to.strain_limit) - 1.0,
        tether_scale: limit(from.tether_scale, to.tether_scale),
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

    fn run(slew: &mut Slew, fabric: &mut Fabric, wanted: &Fabric, frames: usize) -> Vec<f32> {
        (0..frames)
            .map(|_| {
                slew.advance(fabric, wanted, FRAME, 1.02);
                fabric.stretch_stiffness
            })
            .collect()
    }

    #[test]
    fn the_first_fabric_is_taken_as_it_is_and_then_nothing_changes() {
        let (mut slew, mut fabric) = (Slew::default(), Fabric::default());
        let wanted = Fabric { density: 3.0, ..Fabric::default() };
        assert!(slew.advance(&mut fabric, &wanted, FRAME, 0.0));
        assert_eq!(fabric, wanted);
        assert!(!slew.advance(&mut fabric, &wanted, FRAME, 1.0));
    }

    #[test]
    fn a_hundred_times_stiffer_or_softer_takes_a_quarter_of_a_second_in_even_steps() {
        for factor in [100.0, 0.01] {
            let (mut slew, mut fabric) = (Slew::default(), Fabric::default());
            slew.advance(&mut fabric, &Fabric::default(), FRAME, 0.0);
            let wanted = Fabric { stretch_stiffness: 2000.0 * factor, ..Fabric::default() };
            let way = run(&mut slew, &mut fabric, &wanted, 15);
            assert_eq!(fabric, wanted, "after {way:?}");
            let step = factor.powf(1.0 / 15.0);
            for pair in way.windows(2) {
                assert!((pair[1] / pair[0] / step - 1.0).abs() < 1.0e-3, "{way:?}");
            }
        }
    }

    #[test]
    fn stiffness_goes_to_nothing_and_comes_back() {
        let (mut slew, mut fabric) = (Slew::default(), Fabric::default());
        slew.advance(&mut fabric, &Fabric::default(), FRAME, 0.0);
        let none = Fabric { stretch_stiffness: 0.0, bend_stiffness: 0.0, ..Fabric::default() };
        let way = run(&mut slew, &mut fabric, &none, 16);
        assert!(way.is_sorted_by(|a, b| a >= b) && way.iter().all(|k| k.is_finite()), "{way:?}");
        assert_eq!(fabric, none);
        let way = run(&mut slew, &mut fabric, &Fabric::default(), 16);
        assert!(way[0] < 1.0 && way.is_sorted(), "{way:?}");
        assert_eq!(fabric, Fabric::default());
    }

    #[test]
    fn a_limit_that_is_lowered_starts_at_the_elongation_there_is() {
        let (mut slew, mut fabric) = (Slew::default(), Fabric::default());
        let free = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, ..Fabric::default() };
        slew.advance(&mut fabric, &free, FRAME, 0.0);
        slew.advance(&mut fabric, &Fabric::default(), FRAME, 1.5);
        assert!(fabric.strain_limit > 0.4 && fabric.strain_limit <= 0.5, "{}", fabric.strain_limit);
        assert!(fabric.tether_scale > 1.4 && fabric.tether_scale <= 1.5, "{}", fabric.tether_scale);
        slew.advance(&mut fabric, &free, FRAME, 1.5);
        assert_eq!(fabric.strain_limit, f32::INFINITY);
    }

    #[test]
    fn no_time_no_change() {
        let (mut slew, mut fabric) = (Slew::default(), Fabric::default());
        slew.advance(&mut fabric, &Fabric::default(), FRAME, 0.0);
        let wanted = Fabric { density: 2.0, ..Fabric::default() };
        slew.advance(&mut fabric, &wanted, 0.0, 1.0);
        assert_eq!(fabric.density, 0.2);
    }
}
