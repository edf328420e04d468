//! `ClothLimits` and `ClothDrive`: how a cloth follows the skin.

use crate::components::ClothMap;
use crate::inspector::part::Part;
use crate::inspector::setting::{Kind, Scale, Setting};

/// What a map is: its variants, in the order of the code.
const MAP: &[&str] = &["Off", "Uniform", "Painted"];

fn variant(map: &ClothMap) -> usize {
    match map {
        ClothMap::Off => 0,
        ClothMap::Uniform(_) => 1,
        ClothMap::Painted { .. } => 2,
    }
}

/// Makes a map one of its variants. It keeps its number; one that was off begins with `start`, one that was not painted is over
/// `attribute`.
fn choose(map: &mut ClothMap, chosen: usize, attribute: &str, start: f64) {
    let number = high(map).map_or(start as f32, |number| *number);
    match (chosen, &*map) {
        (0, _) => *map = ClothMap::Off,
        (1, _) => *map = ClothMap::Uniform(number),
        (_, ClothMap::Painted { .. }) => {}
        _ => *map = ClothMap::attribute(attribute, 0.0, number),
    }
}

/// Where the paint is 0.
fn low(map: &mut ClothMap) -> Option<&mut f32> {
    match map {
        ClothMap::Painted { low, .. } => Some(low),
        ClothMap::Off | ClothMap::Uniform(_) => None,
    }
}

/// Where the paint is 1; what is not painted has that everywhere.
fn high(map: &mut ClothMap) -> Option<&mut f32> {
    match map {
        ClothMap::Off => None,
        ClothMap::Uniform(high) | ClothMap::Painted { high, .. } => Some(high),
    }
}

/// Where maps begin that were off.
const DISTANCE: f64 = 0.25;
const BACKSTOP: f64 = 0.0;
const FREQUENCY: f64 = 4.0;

const DISTANCES: Scale = Scale::real(0.0, 100.0).slider(0.0, 1.0);
const BACKSTOPS: Scale = Scale::real(-1.0, 1.0).slider(-0.1, 0.2);
const RADII: Scale = Scale::real(0.01, 1000.0).slider(0.02, 50.0).log();
const FREQUENCIES: Scale = Scale::real(0.0, 60.0).slider(0.0, 20.0);

pub(super) const LIMITS: [Setting; 10] = [
    Setting::new(
        Part::Limits,
        "enabled",
        "",
        Kind::Switch {
            get: |s| s.limits.is_some(),
            set: |s, on| s.limits = on.then(|| s.limits.take().unwrap_or_default()),
        },
        [
            "Whether it may only go so far from where the animated skin would take it.",
            "Off: only pins hold it.",
            "On: the maps below say how far.",
        ],
    ),
    Setting::new(
        Part::Limits,
        "max_distance",
        "",
        Kind::Choice {
            options: MAP,
            get: |s| s.limits.as_ref().map(|limits| variant(&limits.max_distance)),
            set: |s, chosen| {
                if let Some(limits) = &mut s.limits {
                    choose(&mut limits.max_distance, chosen, "_CLOTH_MAXDIST", DISTANCE);
                }
            },
        },
        [
            "Farthest distance from the skin: none, one for all, or painted. Chosen here, the paint is the attribute _CLOTH_MAXDIST.",
            "Off: as far as the fabric lets it.",
            "Painted: from low to high, by what was painted.",
        ],
    )
    .starts(0.0),
    Setting::number(
        Part::Limits,
        "max_distance.low",
        "m",
        (DISTANCES, |s| s.limits.as_mut().and_then(|limits| low(&mut limits.max_distance))),
        [
            "Farthest distance from the skin where the paint is 0.",
            "Below 1 mm it is pinned to the skin there.",
            "It goes through the body there.",
        ],
        0.0,
    ),
    Setting::number(
        Part::Limits,
        "max_distance.high",
        "m",
        (DISTANCES, |s| s.limits.as_mut().and_then(|limits| high(&mut limits.max_distance))),
        [
            "Farthest distance from the skin where the paint is 1; everywhere when nothing is painted.",
            "It hardly moves of its own.",
            "It goes through the body.",
        ],
        DISTANCE,
    ),
    Setting::new(
        Part::Limits,
        "backstop_distance",
        "",
        Kind::Choice {
            options: MAP,
            get: |s| s.limits.as_ref().map(|limits| variant(&limits.backstop_distance)),
            set: |s, chosen| {
                if let Some(limits) = &mut s.limits {
                    choose(&mut limits.backstop_distance, chosen, "_CLOTH_BACKSTOP", BACKSTOP);
                }
            },
        },
        [
            "How far it may sink behind the skin: without end, one for all, or painted. Chosen here, the paint is the attribute _CLOTH_BACKSTOP.",
            "Off: it sinks into a body that has no colliders.",
            "Painted: from low to high, by what was painted.",
        ],
    )
    .starts(0.0),
    Setting::number(
        Part::Limits,
        "backstop_distance.low",
        "m",
        (BACKSTOPS, |s| s.limits.as_mut().and_then(|limits| low(&mut limits.backstop_distance))),
        [
            "How far it may sink behind the skin where the paint is 0.",
            "Below 0 it is held off the skin.",
            "It sinks in; off where it is no less than the maximum distance.",
        ],
        0.0,
    ),
    Setting::number(
        Part::Limits,
        "backstop_distance.high",
        "m",
        (BACKSTOPS, |s| s.limits.as_mut().and_then(|limits| high(&mut limits.backstop_distance))),
        [
            "How far it may sink behind the skin where the paint is 1; everywhere when nothing is painted.",
            "Below 0 it is held off the skin.",
            "It sinks in; off where it is no less than the maximum distance.",
        ],
        BACKSTOP,
    ),
    Setting::number(
        Part::Limits,
        "backstop_radius",
        "m",
        (RADII, |s| s.limits.as_mut().map(|limits| &mut limits.backstop_radius)),
        [
            "Radius of the ball behind the skin; 0.1 suits limbs.",
            "It slips off the ball to the side and sinks in.",
            "Nearly a plane: it is held off where the body curves away.",
        ],
        1.0,
    ),
    Setting::number(
        Part::Limits,
        "scale",
        "",
        (Scale::real(0.0, 10.0).slider(0.0, 2.0), |s| s.limits.as_mut().map(|limits| &mut limits.scale)),
        ["What the maximum distance is multiplied by.", "At 0 the cloth is its skin.", "It goes farther than was painted."],
        1.0,
    ),
    Setting::new(
        Part::Limits,
        "avoid_bodies",
        "",
        Kind::Choice {
            options: &["no", "yes"],
            get: |s| s.limits.as_ref().map(|limits| usize::from(limits.avoid_bodies)),
            set: |s, chosen| {
                if let Some(limits) = &mut s.limits {
                    limits.avoid_bodies = chosen != 0;
                }
            },
        },
        [
            "Whether places on the skin are taken out of bodies before they limit.",
            "No: cloth is held where a leg is.",
            "Yes: it goes around the leg.",
        ],
    )
    .starts(1.0),
];

pub(super) const DRIVE: [Setting; 5] = [
    Setting::new(
        Part::Drive,
        "enabled",
        "",
        Kind::Switch { get: |s| s.drive.is_some(), set: |s, on| s.drive = on.then(|| s.drive.take().unwrap_or_default()) },
        [
            "Whether springs draw it to where the animated skin would take it.",
            "Off: only its fabric keeps its shape.",
            "On: the map below says how firmly.",
        ],
    ),
    Setting::new(
        Part::Drive,
        "frequency",
        "",
        Kind::Choice {
            options: MAP,
            get: |s| s.drive.as_ref().map(|drive| variant(&drive.frequency)),
            set: |s, chosen| {
                if let Some(drive) = &mut s.drive {
                    choose(&mut drive.frequency, chosen, "_CLOTH_DRIVE", FREQUENCY);
                }
            },
        },
        [
            "Frequency of the springs to the skin: none, one for all, or painted. Chosen here, the paint is the attribute _CLOTH_DRIVE.",
            "Off: there are no springs.",
            "Painted: from low to high, by what was painted.",
        ],
    )
    .starts(0.0),
    Setting::number(
        Part::Drive,
        "frequency.low",
        "Hz",
        (FREQUENCIES, |s| s.drive.as_mut().and_then(|drive| low(&mut drive.frequency))),
        ["Frequency of the springs where the paint is 0.", "At 0 there is no spring there.", "It is nearly stiff there."],
        0.0,
    ),
    Setting::number(
        Part::Drive,
        "frequency.high",
        "Hz",
        (FREQUENCIES, |s| s.drive.as_mut().and_then(|drive| high(&mut drive.frequency))),
        [
            "Frequency of the springs where the paint is 1; everywhere when nothing is painted. 1 is languid, 4 firm, 15 nearly stiff.",
            "It sags: at 1 Hz by 0.25 m.",
            "It moves as the skin does.",
        ],
        FREQUENCY,
    ),
    Setting::number(
        Part::Drive,
        "damping_ratio",
        "",
        (Scale::real(0.0, 10.0).slider(0.0, 2.0), |s| s.drive.as_mut().map(|drive| &mut drive.damping_ratio)),
        [
            "Damping of the springs over critical damping, at which nothing overshoots.",
            "It swings about the skin for long.",
            "It lags behind, and creeps to the skin.",
        ],
        1.0,
    ),
];
