//! Sheets in the wind: the force of theory, its terminal velocity, no harm from storms and bad numbers.

use glam::{Vec3, Vec4};

use super::*;

const H: f32 = 1.0 / 480.0;

/// A sheet of `n x n` particles of 1 m² in the plane across `up`, and its faces.
fn sheet(n: usize, density: f32, velocity: Vec3) -> (Vec<Vec4>, Vec<Vec4>, Vec<[u32; 3]>) {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for i in 0..n {
        for j in 0..n {
            positions.push(Vec4::new(i as f32, 0.0, j as f32, 0.0) / (n - 1) as f32);
        }
    }
    let mut mass = vec![0.0_f32; n * n];
    for i in 0..n - 1 {
        for j in 0..n - 1 {
            let a = (i * n + j) as u32;
            let b = a + n as u32;
            for face in [[a, a + 1, b], [b, a + 1, b + 1]] {
                faces.push(face);
                for corner in face {
                    mass[corner as usize] += density / (6.0 * ((n - 1) * (n - 1)) as f32);
                }
            }
        }
    }
    for (p, m) in positions.iter_mut().zip(mass) {
        p.w = 1.0 / m;
    }
    let previous = positions.iter().map(|p| (p.truncate() - velocity * H).extend(0.0)).collect();
    (positions, previous, faces)
}

/// Mean force on the sheet `[N]`.
fn force(wind: &Wind, fabric: Aerodynamics, velocity: Vec3) -> Vec3 {
    let (positions, previous, faces) = sheet(9, 0.2, velocity);
    let mut acc = vec![Vec4::ZERO; positions.len()];
    WindForces::default().apply(wind, fabric, &faces, &positions, &previous, H, 0.0, &mut acc);
    acc.iter().zip(&positions).map(|(a, p)| a.truncate() / p.w).sum()
}

fn steady(velocity: Vec3) -> Wind {
    Wind { velocity, ..Wind::STILL }
}

#[test]
fn the_force_is_that_of_a_plate_and_grows_with_the_square_of_the_relative_speed() {
    let plate = Aerodynamics { drag: 1.2, lift: 0.6 };
    let at = |v: Vec3| force(&steady(v), plate, Vec3::ZERO);
    let theory = 0.5 * 1.225 * 1.2 * 25.0;
    let across = at(Vec3::Y * 5.0);
    assert!((across - Vec3::Y * theory).length() < 1.0e-3 * theory, "{across} N, theory {theory} N");
    let twice = at(Vec3::Y * 10.0);
    assert!((twice.y / across.y - 4.0).abs() < 1.0e-3, "twice the speed: {} times the force", twice.y / across.y);
    let moving = force(&steady(Vec3::Y * 2.0), plate, Vec3::Y * -3.0);
    assert!((moving - across).length() < 1.0e-2, "only the relative speed counts: {moving} and {across}");
    // At 45 degrees: drag ½ρ C_D A v² cos, lift ½ρ C_L A v² cos sin across the wind.
    let slanted = at(Vec3::new(5.0, 5.0, 0.0) / 2.0_f32.sqrt());
    let along = Vec3::new(1.0, 1.0, 0.0).normalize();
    let (drag, lift) = (slanted.dot(along), slanted.dot(Vec3::new(-1.0, 1.0, 0.0).normalize()));
    let pressure = 0.5 * 1.225 * 25.0;
    assert!((drag - pressure * 1.2 * 0.5_f32.sqrt()).abs() < 1.0e-2, "drag {drag}");
    assert!((lift - pressure * 0.6 * 0.5).abs() < 1.0e-2, "lift {lift}");
    assert!(at(Vec3::X * 5.0).length() < 1.0e-6, "wind along the sheet");
}

#[test]
fn still_air_slows_cloth_and_no_air_does_not() {
    let drag = force(&Wind::STILL, Aerodynamics::default(), Vec3::Y * -3.0);
    assert!(drag.y > 1.0, "{drag}");
    assert_eq!(force(&Wind::NONE, Aerodynamics::default(), Vec3::Y * -3.0), Vec3::ZERO);
}

/// Speed after `seconds` of a sheet that moves as a whole.
fn run(wind: &Wind, density: f32, gravity: f32, hold_steps: u32, seconds: f32, mut each: impl FnMut(f32)) -> f32 {
    let (mut positions, mut previous, faces) = sheet(5, density, Vec3::ZERO);
    let mut forces = WindForces::default();
    let mut acc = vec![Vec4::ZERO; positions.len()];
    let steps = (seconds / H) as u32;
    let mut speed = 0.0;
    for step in 0..steps {
        if step % hold_steps == 0 {
            acc.fill(Vec4::ZERO);
            forces.apply(wind, Aerodynamics::default(), &faces, &positions, &previous, H, hold_steps as f32 * H, &mut acc);
        }
        for ((x, prev), a) in positions.iter_mut().zip(&mut previous).zip(&acc) {
            let next = *x + (*x - *prev).truncate().extend(0.0) + (*a + Vec4::Y * -gravity) * (H * H);
            *prev = *x;
            *x = next;
        }
        speed = (positions[7] - previous[7]).y / H;
        each(speed);
    }
    speed
}

#[test]
fn a_falling_sheet_reaches_its_terminal_velocity() {
    for density in [0.1_f32, 0.3, 1.0] {
        let theory = (2.0 * density * 9.81 / (1.225 * 1.2)).sqrt();
        let speed = -run(&Wind::STILL, density, 9.81, 4, 5.0, |_| {});
        assert!((speed / theory - 1.0).abs() < 0.01, "{density} kg/m²: {speed} m/s, theory {theory} m/s");
    }
}

#[test]
fn a_storm_of_60_metres_per_second_never_throws_light_cloth_faster_than_itself() {
    for hold in [1, 4, 8, 48] {
        let mut fastest = 0.0_f32;
        let end = run(&steady(Vec3::Y * 60.0), 0.1, 0.0, hold, 1.0, |v| fastest = fastest.max(v));
        assert!(fastest < 60.2 && end > 55.0, "held {hold} substeps: up to {fastest} m/s, at the end {end} m/s");
    }
}

#[test]
fn bad_numbers_give_no_force_and_no_panic() {
    let (mut positions, previous, faces) = sheet(4, 0.2, Vec3::ZERO);
    positions[3] = Vec4::new(f32::NAN, 0.0, f32::INFINITY, 1.0);
    positions[0].w = 0.0;
    let mut acc = vec![Vec4::ZERO; positions.len()];
    for velocity in [Vec3::splat(f32::NAN), Vec3::splat(f32::MAX), Vec3::Y * 20.0] {
        let mut wind = Wind { velocity, turbulence: Turbulence { intensity: f32::NAN, ..Turbulence::NONE }, ..Wind::STILL };
        wind.advance(0.1);
        WindForces::default().apply(&wind, Aerodynamics::default(), &faces, &positions, &previous, H, H, &mut acc);
        let past_the_end = [faces[0], [0, 1, 999]];
        let mut none = vec![Vec4::ZERO; positions.len()];
        let plate = Aerodynamics::default();
        WindForces::default().apply(&wind, plate, &past_the_end, &positions, &previous, H, H, &mut none);
        assert!(none.iter().all(|a| *a == Vec4::ZERO), "{none:?}");
    }
    assert!(acc.iter().all(|a| a.is_finite()), "{acc:?}");
    assert_eq!(acc[0], Vec4::ZERO, "a pinned particle was accelerated");
    assert!(acc[5].y > 0.0, "{}", acc[5]);
}
