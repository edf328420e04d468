//! Impulses from outside: they change velocities, and a particle that is held stays.

use glam::{Vec3, Vec4};

use super::settings::Stepping;
use super::state::ClothState;

/// Largest change of a velocity `[m/s]`.
pub(crate) const FASTEST: f32 = 100.0;
/// Substep of a cloth that was not stepped yet `[s]`: the default.
pub(crate) fn first_substep() -> f32 {
    Stepping::default().substep_rate.recip()
}

/// Gives `impulse` `[N·s]` to the particles within `radius` `[m]` of `point` `[m]`, as one piece. Each gets the velocity
/// `J f / Σ m f`, with `f = (1 - d²/r²)²`. Returns how many particles took part.
pub(crate) fn impulse(state: &mut ClothState, point: Vec3, impulse: Vec3, radius: f32) -> u32 {
    let share = |x: &Vec4| falloff((x.truncate() - point).length_squared(), radius);
    let mass: f32 = state.positions.iter().filter(|x| x.w > 0.0).map(|x| share(x) / x.w).sum();
    let velocity = impulse / mass;
    if !(mass > 0.0 && velocity.is_finite()) {
        return 0;
    }
    kick(state, |x| velocity * share(&x))
}

/// Blows the particles within `radius` `[m]` away from `center` `[m]`. Each gets the velocity `J f / M`, with `M` the mass of
/// all free particles and `f = (1 - d²/r²)²`. So `impulse` `[N·s]` is the sum of the magnitudes if all were at `center`.
/// Directions differ: the net impulse is smaller. Returns how many particles took part.
pub(crate) fn explosion(state: &mut ClothState, center: Vec3, impulse: f32, radius: f32) -> u32 {
    let mass: f32 = state.positions.iter().filter(|x| x.w > 0.0).map(|x| 1.0 / x.w).sum();
    let speed = impulse / mass;
    if !(mass > 0.0 && speed.is_finite()) {
        return 0;
    }
    kick(state, |x| {
        let away = x.truncate() - center;
        away.normalize_or_zero() * (speed * falloff(away.length_squared(), radius))
    })
}

fn falloff(distance_squared: f32, radius: f32) -> f32 {
    let radius = radius.max(0.0);
    let left = (1.0 - distance_squared / (radius * radius)).max(0.0);
    left * left
}

/// Adds to velocities `[m/s]`, at most [`FASTEST`] each.
fn kick(state: &mut ClothState, velocity: impl Fn(Vec4) -> Vec3) -> u32 {
    if !(state.substep > 0.0) {
        state.substep = first_substep();
    }
    let mut count = 0;
    for (&x, old) in state.positions.iter().zip(&mut state.previous) {
        let change = velocity(x).clamp_length_max(FASTEST);
        if x.w > 0.0 && change != Vec3::ZERO && change.is_finite() {
            *old -= (change * state.substep).extend(0.0);
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(n: usize) -> ClothState {
        let positions: Vec<Vec4> = (0..n).map(|i| Vec4::new(i as f32 * 0.1, 0.0, 0.0, 10.0)).collect();
        ClothState { previous: positions.clone(), positions, substep: 0.002, ..ClothState::default() }
    }

    #[test]
    fn an_impulse_is_given_whole_to_what_is_within_reach_and_free() {
        let mut state = row(11);
        state.positions[5].w = 0.0;
        let j = Vec3::new(0.1, 0.2, -0.3);
        let count = impulse(&mut state, Vec3::new(0.5, 0.0, 0.0), j, 0.35);
        let momentum: Vec3 = (0..11).filter(|&i| state.positions[i].w > 0.0).map(|i| state.velocity(i) * 0.1).sum();
        assert_eq!(count, 6);
        assert!(momentum.distance(j) < 1.0e-4 * j.length(), "{momentum} for {j}");
        assert_eq!(state.velocity(5), Vec3::ZERO);
    }

    #[test]
    fn an_explosion_pushes_away_and_fades_with_distance() {
        let mut state = row(11);
        let count = explosion(&mut state, Vec3::new(0.0, -0.1, 0.0), 1.0, 0.6);
        let speeds: Vec<f32> = (0..11).map(|i| state.velocity(i).length()).collect();
        assert!(count == 6 && speeds.windows(2).all(|w| w[1] <= w[0]), "{count} {speeds:?}");
        assert!(speeds[0] > 0.5 && state.velocity(0).y > 0.0, "{speeds:?}");
    }

    #[test]
    fn nonsense_does_nothing() {
        let mut state = row(4);
        let before = state.clone();
        for (j, r) in [(Vec3::NAN, 1.0), (Vec3::X, 0.0), (Vec3::X, -1.0), (Vec3::X, f32::NAN), (Vec3::INFINITY, 1.0)] {
            assert_eq!(impulse(&mut state, Vec3::ZERO, j, r), 0, "{j} {r}");
            assert_eq!(explosion(&mut state, Vec3::ZERO, j.x, r), 0, "{j} {r}");
        }
        assert_eq!(state, before);
    }
}
