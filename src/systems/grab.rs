//! Prepare: hands every grip to the solver of its cloth.

use bevy::prelude::*;

use crate::components::checked::Checked;
use crate::components::grip::Grip;
use crate::components::{Cloth, ClothGrab};
use crate::notices::Notices;
use crate::simulation::{ClothParticles, ClothRest};
use crate::solver::integrate::pull::Pull;

/// Largest force over the mass of the free particles `[m/s²]`, twenty times the weight of the cloth. Beyond it, springs that
/// are solved once a substep give way.
const MOST_ACCELERATION: f32 = 20.0 * 9.81;

/// Reads every grip. A cloth that is grabbed does not sleep.
pub(crate) fn grabs(
    mut notices: ResMut<Notices>,
    mut grabs: Query<(Entity, Option<&Name>, &ClothGrab, &mut Grip)>,
    mut cloths: Query<(&ClothRest, &mut ClothParticles), With<Cloth>>,
    mut checked: Local<Checked>,
) {
    for (_, mut particles) in &mut cloths {
        particles.sim.memory.pulls_mut().clear();
    }
    for (entity, name, grab, mut grip) in grabs.iter_mut().sort::<Entity>() {
        checked.clear();
        let (radius, compliance, force) = grab.checked(&mut checked);
        if !grab.target.is_finite() {
            checked.refuse("grab.target");
        }
        notices.clamped(entity, name, "grab", &checked);
        let Ok((rest, mut particles)) = cloths.get_mut(grab.cloth) else { continue };
        let of = (grab.cloth, grab.particles, grab.weights, radius, particles.len());
        if grip.of != Some(of) {
            grip.of = Some(of);
            find(grab, radius, rest, &mut grip.shares);
        }
        if grip.shares.is_empty() || !grab.target.is_finite() {
            continue;
        }
        let from = grip.target.replace(grab.target).unwrap_or(grab.target);
        let [from, to] = [from, grab.target].map(|p| (p.as_dvec3() - particles.origin).as_vec3());
        let mass: f32 = particles.sim.state.positions.iter().filter(|x| x.w > 0.0).map(|x| 1.0 / x.w).sum();
        let force = force.min(MOST_ACCELERATION * mass);
        let pull = Pull { from, to, compliance, force };
        particles.sim.memory.pulls_mut().add(pull, grip.shares.iter().copied());
        particles.disturbed = true;
    }
}

/// Shares of the particles around the point at rest, `(1 - d²/r²)²`, and of its triangle in any case. None when the cloth does
/// not have those particles.
fn find(grab: &ClothGrab, radius: f32, rest: &ClothRest, shares: &mut Vec<(u32, f32)>) {
    shares.clear();
    let shape = rest.shape();
    let Some(corners) = grab.particles.iter().map(|&p| shape.positions.get(p as usize)).collect::<Option<Vec<_>>>() else {
        return;
    };
    let weights = grab.weights.max(Vec3::ZERO);
    let weights = weights / weights.element_sum();
    if !weights.is_finite() {
        return;
    }
    let center: Vec3 = corners.iter().zip(weights.to_array()).map(|(&&x, w)| x * w).sum();
    let fade = |x: &Vec3| (1.0 - x.distance_squared(center) / (radius * radius)).max(0.0).powi(2);
    for (i, x) in (0_u32..).zip(&shape.positions) {
        let own = grab.particles.iter().zip(weights.to_array()).filter(|(p, _)| **p == i).map(|(_, w)| w).sum::<f32>();
        let share = own + if radius > 0.0 { fade(x) } else { 0.0 };
        if share > 0.0 {
            shares.push((i, share));
        }
    }
    let sum: f32 = shares.iter().map(|(_, share)| share).sum();
    shares.iter_mut().for_each(|(_, share)| *share /= sum);
}
