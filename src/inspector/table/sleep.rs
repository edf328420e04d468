//! `ClothSleep`.

use crate::inspector::part::Part;
use crate::inspector::setting::{Kind, Scale, Setting};

pub(super) const SLEEP: [Setting; 3] = [
    Setting::new(
        Part::Sleep,
        "enabled",
        "",
        Kind::Switch { get: |s| !s.sleep_disabled, set: |s, on| s.sleep_disabled = !on },
        [
            "Whether it may fall asleep at rest: it is then neither stepped nor written until something wakes it.",
            "Off: it costs as much at rest as in motion.",
            "On: what wakes it is wind, gravity, settings, pins, bodies and cloths that change.",
        ],
    ),
    Setting::new(
        Part::Sleep,
        "threshold",
        "m/s",
        Kind::Number(Scale::real(0.0, 1.0).slider(0.001, 0.2).log(), |s| Some(&mut s.sleep.threshold)),
        ["Speed below which a particle is at rest.", "0 never lets it sleep.", "It stops in mid-swing."],
    ),
    Setting::new(
        Part::Sleep,
        "delay",
        "s",
        Kind::Number(Scale::real(0.05, 60.0).slider(0.05, 10.0).log(), |s| Some(&mut s.sleep.delay)),
        [
            "Time for which all particles have to be at rest.",
            "It sleeps at the turning point of a slow swing.",
            "It costs for longer after it came to rest.",
        ],
    ),
];
