//! `ClothLod`.

use crate::components::ClothDetail;
use crate::inspector::setting::{Kind, Part, Scale, Setting};

pub(super) const LOD: [Setting; 4] = [
    Setting::new(
        Part::Lod,
        "enabled",
        "",
        Kind::Switch(|s| Some(&mut s.lod.enabled)),
        [
            "Whether it takes fewer substeps far from the cameras, and when none sees it.",
            "Off: it costs as much far away as in front of the camera.",
            "On: what happens depends on who looks.",
        ],
    ),
    Setting::new(
        Part::Lod,
        "full_within",
        "m",
        Kind::Number(Scale::real(0.01, 1.0e6).slider(1.0, 1000.0).log(), |s| Some(&mut s.lod.full_within)),
        [
            "Distance up to which it takes all substeps; half of them up to twice that, a quarter beyond.",
            "It stretches more in plain view.",
            "Nothing is saved.",
        ],
    ),
    Setting::new(
        Part::Lod,
        "still_beyond",
        "m",
        Kind::Number(Scale::real(0.01, 1.0e6).slider(1.0, 10_000.0).log(), |s| Some(&mut s.lod.still_beyond)),
        [
            "Distance from which on it stands still and is only carried along.",
            "It is seen to stop.",
            "Cloth of a few pixels is simulated.",
        ],
    ),
    Setting::new(
        Part::Lod,
        "unseen",
        "",
        Kind::Choice {
            options: &["Full", "Half", "Quarter", "Still"],
            get: |s| ClothDetail::ALL.iter().position(|detail| *detail == s.lod.unseen),
            set: |s, chosen| s.lod.unseen = ClothDetail::ALL.get(chosen).copied().unwrap_or_default(),
        },
        [
            "The most it gets after half a second in which no camera saw it.",
            "Full: only the distance counts.",
            "Still: it comes back into view as it left.",
        ],
    ),
];
