//! `ClothGlobalWind`, `ClothWind` and `ClothGravity`.

use crate::components::ClothGlobalWind;
use crate::inspector::part::Part;
use crate::inspector::setting::{Field, Kind, Scale, Setting};

/// Wind that can be felt, from calm to a hurricane `[m/s]`.
const SPEED: Scale = Scale::real(-200.0, 200.0).slider(-30.0, 30.0);
const TURBULENCE: Scale = Scale::real(0.0, 5.0).slider(0.0, 1.5);
const LENGTH: Scale = Scale::real(0.05, 1000.0).slider(0.1, 100.0).log();
const FREQUENCY: Scale = Scale::real(0.0, 20.0).slider(0.0, 5.0);
const SEED: Scale = Scale::whole(0.0, u32::MAX as f64).slider(0.0, 100.0);
const DENSITY: Scale = Scale::real(0.0, 1000.0).slider(0.01, 1000.0).log();

const X: [&str; 3] =
    ["Velocity of the air along x.", "Blows along -x.", "Blows along x; beyond 30 m/s flags need a higher substep rate."];
const Y: [&str; 3] = ["Velocity of the air upwards.", "Presses it down.", "Lifts it up."];
const Z: [&str; 3] =
    ["Velocity of the air along z.", "Blows along -z.", "Blows along z; beyond 30 m/s flags need a higher substep rate."];
const GUSTS: [&str; 3] = [
    "Strength of gusts as a fraction of the speed; open country 0.15, a city 0.3.",
    "Steady, as from a fan.",
    "Storms that turn on the spot.",
];
const SIZE: [&str; 3] = [
    "Size of the largest gusts.",
    "Smaller than the cloth: noise that quivers.",
    "Much larger than the cloth: it swells as a whole.",
];
const OFTEN: [&str; 3] = ["How often the largest gusts change on top of passing by.", "Gusts only pass.", "The wind flickers."];
const SEEDS: [&str; 3] =
    ["Seed of the gusts: the same seed blows the same gusts.", "Other gusts, no weaker.", "Other gusts, no stronger."];
const AIR: [&str; 3] =
    ["Density of the air; 1.225 at sea level, water has 1000.", "0 is vacuum: no wind and no drag.", "Moves as under water."];

#[expect(clippy::too_many_arguments, reason = "a row of the table says each thing once")]
const fn rows(
    part: Part,
    x: Field<f32>,
    y: Field<f32>,
    z: Field<f32>,
    turbulence: Field<f32>,
    length: Field<f32>,
    frequency: Field<f32>,
    seed: Field<u32>,
    density: Field<f32>,
) -> [Setting; 8] {
    [
        Setting::new(part, "velocity.x", "m/s", Kind::Number(SPEED, x), X),
        Setting::new(part, "velocity.y", "m/s", Kind::Number(SPEED, y), Y),
        Setting::new(part, "velocity.z", "m/s", Kind::Number(SPEED, z), Z),
        Setting::new(part, "turbulence", "", Kind::Number(TURBULENCE, turbulence), GUSTS),
        Setting::new(part, "gust_length", "m", Kind::Number(LENGTH, length), SIZE),
        Setting::new(part, "gust_frequency", "Hz", Kind::Number(FREQUENCY, frequency), OFTEN),
        Setting::new(part, "seed", "", Kind::Count(SEED, seed), SEEDS),
        Setting::new(part, "air_density", "kg/m³", Kind::Number(DENSITY, density), AIR),
    ]
}

pub(super) const WIND: [Setting; 8] = rows(
    Part::Wind,
    |s| Some(&mut s.wind.velocity.x),
    |s| Some(&mut s.wind.velocity.y),
    |s| Some(&mut s.wind.velocity.z),
    |s| Some(&mut s.wind.turbulence),
    |s| Some(&mut s.wind.gust_length),
    |s| Some(&mut s.wind.gust_frequency),
    |s| Some(&mut s.wind.seed),
    |s| Some(&mut s.wind.air_density),
);

fn own(settings: &mut crate::inspector::settings::ClothSettings) -> Option<&mut ClothGlobalWind> {
    settings.own_wind.as_mut().map(|wind| &mut wind.0)
}

pub(super) const OWN_WIND: [Setting; 8] = rows(
    Part::OwnWind,
    |s| own(s).map(|w| &mut w.velocity.x),
    |s| own(s).map(|w| &mut w.velocity.y),
    |s| own(s).map(|w| &mut w.velocity.z),
    |s| own(s).map(|w| &mut w.turbulence),
    |s| own(s).map(|w| &mut w.gust_length),
    |s| own(s).map(|w| &mut w.gust_frequency),
    |s| own(s).map(|w| &mut w.seed),
    |s| own(s).map(|w| &mut w.air_density),
);

const PULL: Scale = Scale::real(-1.0e4, 1.0e4).slider(-20.0, 20.0);

pub(super) const GRAVITY: [Setting; 3] = [
    Setting::new(
        Part::Gravity,
        "x",
        "m/s²",
        Kind::Number(PULL, |s| Some(&mut s.gravity.0.x)),
        ["Gravity along x, for every cloth.", "Falls along -x.", "Falls along x."],
    ),
    Setting::new(
        Part::Gravity,
        "y",
        "m/s²",
        Kind::Number(PULL, |s| Some(&mut s.gravity.0.y)),
        [
            "Gravity upwards, for every cloth; -9.81 on Earth, -1.62 on the Moon.",
            "Hangs heavy and stretches.",
            "Falls upwards.",
        ],
    ),
    Setting::new(
        Part::Gravity,
        "z",
        "m/s²",
        Kind::Number(PULL, |s| Some(&mut s.gravity.0.z)),
        ["Gravity along z, for every cloth.", "Falls along -z.", "Falls along z."],
    ),
];
