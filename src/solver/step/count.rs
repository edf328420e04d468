//! How many substeps a frame takes, and how many inner steps each of them.

use glam::{Vec3, Vec4};

use super::strain::LEAST_LIMIT;
use super::{Memory, Stepped};
use crate::solver::body::Body;
use crate::solver::settings::{Stepping, drape_rate};

/// Most times as many substeps a cloth takes while a body comes through (dimensionless).
pub(super) const MOST_FOR_BODIES: f32 = 8.0;
/// Way of the body in a substep that needs no more, in thicknesses (dimensionless). Say that it is three, and a ball of 0.1 m
/// goes through the middle of a hanging sheet at 5 m/s. It is there before the pull is, and edges around it get many times as
/// long.
const FREE_WAY: f32 = 0.4;

/// How far a heavier body may press cloth in a substep, in the mean over the particles that it touches (dimensionless). It is a
/// share of how much longer the strain limit lets an edge be than at rest. The next substep adds to the stretch that springs
/// cannot draw back in one, and the cloth bears the body no longer.
const PRESSED: f32 = 0.25;
/// Largest strain limit that counts there (dimensionless): springs of what is elastic draw back no sooner.
const ELASTIC: f32 = 0.1;

/// Substeps that a cloth that nothing counts takes for a frame of `dt` `[s]`.
#[must_use]
pub(crate) fn substeps_of(stepping: &Stepping, dt: f32) -> u32 {
    substeps(dt.min(stepping.max_frame), stepping.substep_rate)
}

impl Stepped<'_> {
    /// Substeps that the next frame should take: as many as `stepping` says, or up to eight times as many. More while a body
    /// that is heavier than the cloth and moves much faster than the pins may meet it, or lies on it. `positions` `[m]`: where
    /// the cloth is.
    #[must_use]
    pub(crate) fn substeps(&self, stepping: &Stepping, positions: &[Vec4], memory: &mut Memory) -> u32 {
        let Self { fabric, anchors, input, .. } = *self;
        let count = self.substeps_of_pull(stepping);
        memory.fast_body = false;
        if input.bodies.is_empty() {
            return count;
        }
        // Of bodies that cloth cannot stop, and of others: those may stay.
        let (mut for_fast_body, mut for_heavy_body) = (1, memory.for_heavy_body.max(1));
        // What hangs on a character that runs goes with it.
        let sum: Vec3 = anchors.from.iter().zip(&anchors.to).map(|(from, to)| *to - *from).sum();
        let mean = sum / anchors.particles.len().max(1) as f32;
        // What is lighter than the cloth gives way to it.
        let own = self.mass(memory);
        let mass = |body: &Body| body.rigid.map_or(f32::INFINITY, |slot| memory.coupling.mass(slot));
        // How many times as far a body gets in a substep as it may; what cloth can stop may press it, too.
        let haste = |body: &Body| {
            if body.bone {
                // A dress stretches to 2.5 times its length on who walks, where this is 1.9 thicknesses.
                return body.way_of_bone(mean) / (count as f32 * fabric.thickness);
            }
            let free = FREE_WAY * fabric.thickness;
            let most = if mass(body).is_finite() { free.max(self.most_pressed()) } else { free };
            (body.to.translation - body.from.translation - mean).length() / (count as f32 * most)
        };
        let counts = |body: &Body| mass(body) > own && haste(body) > 1.0 && haste(body).is_finite();
        if !input.bodies.iter().any(counts) {
            return self.at_most(count * for_heavy_body, stepping);
        }
        let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = positions.iter().fold(none, |(low, high), x| (low.min(x.truncate()), high.max(x.truncate())));
        let (low, high) = (low.min(low + mean) - fabric.thickness, high.max(high + mean) + fabric.thickness);
        for (index, body) in input.bodies.iter().enumerate().filter(|(_, body)| counts(body)) {
            let (finite, times) = (mass(body).is_finite(), haste(body).min(MOST_FOR_BODIES).ceil() as u32);
            // What cloth is to stop finds it in small steps already.
            if body.sweeps(low, high) || (finite && memory.contacts.is_near(index)) {
                let most = if finite { &mut for_heavy_body } else { &mut for_fast_body };
                *most = (*most).max(times);
            }
        }
        (memory.fast_body, memory.for_heavy_body) = (for_fast_body > 1, for_heavy_body);
        self.at_most(count * for_heavy_body.max(for_fast_body), stepping)
    }

    /// No more than eight times as many as `stepping` says, however much there is to see to.
    fn at_most(&self, count: u32, stepping: &Stepping) -> u32 {
        count.min(MOST_FOR_BODIES as u32 * substeps_of(stepping, self.input.dt))
    }

    /// Substeps that gravity asks for: as many as `stepping` says, or up to eight times as many. They are more where cloth
    /// would fall by more than an edge in one, `g h² > L`. There its constraints have turned by more than they are long before
    /// they are solved, and tear at each other.
    fn substeps_of_pull(&self, stepping: &Stepping) -> u32 {
        let Self { rest, input, .. } = *self;
        let count = substeps_of(stepping, input.dt);
        let h = input.dt.min(stepping.max_frame) / count as f32;
        let edges = input.gravity.length() * h * h / rest.mean_edge;
        // NaN passes no comparison.
        if edges > 1.0 { count * edges.sqrt().min(MOST_FOR_BODIES).ceil() as u32 } else { count }
    }

    /// How far a heavier body may press the cloth in a substep `[m]`.
    pub(super) fn most_pressed(&self) -> f32 {
        PRESSED * self.fabric.strain_limit.clamp(LEAST_LIMIT, ELASTIC) * self.rest.mean_edge
    }

    /// Mass of the cloth `[kg]`, if bodies take what it does to them; 0 otherwise.
    pub(super) fn mass(&self, memory: &Memory) -> f32 {
        let takes = self.input.bodies.iter().any(|body| body.rigid.is_some());
        if takes { self.fabric.density * memory.factors.area } else { 0.0 }
    }

    /// Inner steps in a substep of `h` `[s]`: as many as tension needs to get along the cloth.
    pub(super) fn inner_steps(&self, stepping: &Stepping, h: f32) -> u32 {
        let rate = drape_rate(self.rest.mean_edge).min(stepping.inner_rate);
        substeps(h, rate)
    }
}

impl Memory {
    /// Whether a body that cloth cannot stop, and that moves much faster than its pins, may meet it in the frame to come.
    #[must_use]
    pub(crate) fn meets_fast_body(&self) -> bool {
        self.fast_body
    }
}

/// Substeps of equal length in a frame of `dt` `[s]` at `rate` `[Hz]`: at least one, and not one more for rounding.
pub(super) fn substeps(dt: f32, rate: f32) -> u32 {
    ((dt * rate - 1.0e-3).ceil() as u32).max(1)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Vec3, vec3};

    use crate::solver::evaluate::EvaluateSettings;
    use crate::solver::island::UntangleSettings;
    use crate::solver::rest::RestShape;
    use crate::solver::scene::{GRAVITY, Scene, SceneCloth, grid};
    use crate::solver::settings::Fabric;

    /// A square of 16² vertices and `size` `[m]`, held at two corners.
    fn hang(size: f32, gravity: Vec3) -> Scene {
        let mesh = grid(16, 16, |u, v| size * vec3(u - 0.5, 0.0, v - 0.5));
        let rest = Arc::new(RestShape::build(&mesh).expect("a sheet").0);
        let scene = Scene { gravity, ..Scene::new(vec![SceneCloth::new(rest, Fabric::default(), Vec3::ZERO, &[0, 15])]) };
        scene.untangled(UntangleSettings::default(), EvaluateSettings::default(), true).expect("a sheet")
    }

    #[test]
    fn tiny_cloth_hangs_under_a_hundred_times_gravity_as_it_is_made() {
        for size in [0.001, 0.01, 0.1] {
            let mut scene = hang(size, 100.0 * GRAVITY);
            let mut worst = 0.0f32;
            for frame in 0..90 {
                scene.step(1.0 / 60.0);
                if frame > 60 {
                    worst = worst.max(scene.cloths[0].report.worst_edge);
                }
            }
            let (x, lowest) = (scene.crossings(), scene.cloths[0].lowest() / size);
            assert!(worst < 1.2 && x == 0 && lowest < -0.9 && lowest > -1.3, "{size} m: edge {worst}, {x} cross, at {lowest}");
        }
    }

    #[test]
    fn only_cloth_that_falls_by_more_than_an_edge_takes_more_substeps() {
        let substeps = |size: f32, times: f32| {
            let mut scene = hang(size, times * GRAVITY);
            scene.step(1.0 / 60.0);
            scene.cloths[0].report.substeps
        };
        assert_eq!([1.0, 0.1, 0.01].map(|size| substeps(size, 1.0)), [6; 3]);
        assert_eq!(substeps(1.0, 100.0), 6);
        assert_eq!(substeps(0.01, 100.0), 24, "7.6 mm in a substep, edges of 0.8 mm");
        assert_eq!([100.0, 1.0e6].map(|times| substeps(0.001, times)), [48; 2], "no more than eight times");
        assert_eq!(substeps(0.001, f32::NAN), 6);
    }
}
