//! `ClothLod`.

use crate::components::ClothDetail;
use crate::inspector::part::Part;
use crate::inspector::setting::{Kind, Scale, Setting};

pub(super) const LOD: [Setting; 4] = [
    Setting::new(
        Part::Lod,
        "enabled",
        "",
        Kind::Switch { get: |s| s.lod.is_some(), set: |s, on| s.lod = on.then_some(s.lod.unwrap_or_default()) },
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
        Kind::Number(Scale::real(0.01, 1.0e6).slider(1.0, 1000.0).log(), |s| s.lod.as_mut().map(|lod| &mut lod.full_within)),
        [
            "Distance up to which it takes all substeps; half of them up to twice that, a quarter beyond.",
            "It stretches more in plain view.",
            "Nothing is saved.",
        ],
    )
    .starts(15.0),
    Setting::new(
        Part::Lod,
        "still_beyond",
        "m",
        Kind::Number(Scale::real(0.01, 1.0e6).slider(1.0, 10_000.0).log(), |s| s.lod.as_mut().map(|lod| &mut lod.still_beyond)),
        [
            "Distance from which on it stands still and is only carried along.",
            "It is seen to stop.",
            "Cloth of a few pixels is simulated.",
        ],
    )
    .starts(150.0),
    Setting::new(
        Part::Lod,
        "unseen",
        "",
        Kind::Choice {
            options: &["Full", "Half", "Quarter", "Still"],
            get: |s| s.lod.and_then(|lod| ClothDetail::ALL.iter().position(|detail| *detail == lod.unseen)),
            set: |s, chosen| {
                if let Some(lod) = &mut s.lod {
                    lod.unseen = ClothDetail::ALL.get(chosen).copied().unwrap_or_default();
                }
            },
        },
        [
            "The most it gets after half a second in which no camera saw it.",
            "Full: only the distance counts.",
            "Still: it comes back into view as it left.",
        ],
    )
    .starts(ClothDetail::Quarter as u8 as f64),
];
