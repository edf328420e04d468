//! `ClothCollision`, `ClothUntangling` and `ClothSkipFrame`.

use crate::components::{ClothSkipPolicy, ClothUntanglingMethod};
use crate::inspector::part::Part;
use crate::inspector::setting::{Kind, Scale, Setting};

pub(super) const COLLISION: [Setting; 3] = [
    Setting::new(
        Part::Collision,
        "self_collision",
        "",
        Kind::Switch { get: |s| s.collision.self_collision, set: |s, on| s.collision.self_collision = on },
        [
            "Whether it meets itself: folds on itself and is untangled from itself.",
            "Off: goes through itself, and costs less.",
            "On: costs a look at itself in every frame.",
        ],
    ),
    Setting::new(
        Part::Collision,
        "contact",
        "",
        Kind::Switch { get: |s| s.collision.contact, set: |s, on| s.collision.contact = on },
        [
            "Whether it rests on other cloths and on itself, one thickness apart and with friction.",
            "Off: passes through and is taken apart afterwards.",
            "On: cloths that touch are stepped side by side, with the substeps of the one that needs most.",
        ],
    ),
    Setting::new(
        Part::Collision,
        "garment_layer",
        "",
        Kind::Layer(Scale::whole(i32::MIN as f64, i32::MAX as f64).slider(-5.0, 5.0), |s| Some(&mut s.collision.garment_layer)),
        [
            "Order of clothing: of two that cross, the higher is brought outside; equal ones have no order.",
            "Worn below, as a shirt.",
            "Worn above, as a coat; only the order matters, not the number.",
        ],
    ),
];

pub(super) const UNTANGLE: [Setting; 10] = [
    Setting::new(
        Part::Untangle,
        "enabled",
        "",
        Kind::Switch { get: |s| !s.untangling_disabled, set: |s, on| s.untangling_disabled = !on },
        [
            "Whether it is moved to come apart.",
            "Off: left as it is, and others get off it.",
            "On: costs only while something crosses.",
        ],
    ),
    Setting::new(
        Part::Untangle,
        "method",
        "",
        Kind::Choice {
            options: &["History", "LocalGradient", "GlobalGradient", "ByEndType"],
            get: |s| ClothUntanglingMethod::ALL.iter().position(|m| *m == s.untangle.method),
            set: |s, i| s.untangle.method = ClothUntanglingMethod::ALL.get(i).copied().unwrap_or_default(),
        },
        [
            "How crossings are taken apart: by sides remembered (1995), per crossing (2006), per contour (2009), or per contour by how it ends.",
            "History takes nothing apart that starts tangled; the local gradient stops at straight cuts.",
            "ByEndType tries another way where one makes no progress.",
        ],
    ),
    Setting::new(
        Part::Untangle,
        "iterations",
        "",
        Kind::Count(Scale::whole(0.0, 64.0).slider(0.0, 32.0), |s| Some(&mut s.untangle.iterations)),
        ["Most iterations per frame, while something crosses.", "0 only measures.", "Cost is proportional while tangled."],
    ),
    Setting::new(
        Part::Untangle,
        "step",
        "edges",
        Kind::Number(Scale::real(0.001, 1.0).slider(0.01, 1.0).log(), |s| Some(&mut s.untangle.step)),
        [
            "Largest displacement per iteration, as a fraction of the mean edge.",
            "Slow: tangles are seen for longer.",
            "Overshoots and folds triangles over.",
        ],
    ),
    Setting::new(
        Part::Untangle,
        "pace",
        "",
        Kind::Number(Scale::real(1.0, 50.0).slider(1.0, 20.0), |s| Some(&mut s.untangle.pace)),
        [
            "Largest growth of the step of a contour that keeps moving one way.",
            "Deep tangles take long.",
            "Tears at the edges around a deep tangle.",
        ],
    ),
    Setting::new(
        Part::Untangle,
        "spread",
        "",
        Kind::Number(Scale::real(0.0, 10.0).slider(0.0, 3.0), |s| Some(&mut s.untangle.spread)),
        [
            "How far the motion spreads around a contour, as a fraction of its length.",
            "Only the particles at the contour move, which the rest of a fine cloth holds back.",
            "Moves cloth that has nothing to do with the tangle.",
        ],
    ),
    Setting::new(
        Part::Untangle,
        "stall_iterations",
        "",
        Kind::Count(Scale::whole(1.0, 1000.0).slider(1.0, 200.0).log(), |s| Some(&mut s.untangle.stall_iterations)),
        [
            "Iterations without progress after which something else is tried.",
            "Gives up ways that would have led out.",
            "Stays in dead ends.",
        ],
    ),
    Setting::new(
        Part::Untangle,
        "relaxations",
        "",
        Kind::Count(Scale::whole(0.0, 16.0), |s| Some(&mut s.untangle.relaxations)),
        ["Sweeps of the springs after each iteration.", "Edges around a tangle tear.", "Slows coming apart."],
    ),
    Setting::new(
        Part::Untangle,
        "effort",
        "visits per face",
        Kind::Count(Scale::whole(16.0, 1_000_000.0).slider(16.0, 4096.0).log(), |s| Some(&mut s.untangle.effort)),
        [
            "Most work of a frame beyond what is in proportion to the size of the cloth. What is more goes on in the next frame.",
            "Heaps stay tangled for longer; piles that land hard cross.",
            "Cloth that crosses all over holds up the frame.",
        ],
    ),
    Setting::new(
        Part::Untangle,
        "at_load",
        "",
        Kind::Switch { get: |s| s.untangle.at_load, set: |s, on| s.untangle.at_load = on },
        [
            "Whether a cloth that is tangled in its first frame is taken apart before it is shown. Matters for cloths still to be bound.",
            "Off: comes apart before the eyes of the player.",
            "On: the first frames may take long.",
        ],
    ),
];

const POLICIES: &[&str] = &["Bounded", "UntilClean", "Off"];
/// Frames that [`ClothSkipPolicy::UntilClean`] starts with in the panel.
const UNTIL_CLEAN: u32 = 30;

pub(super) const SKIP: [Setting; 5] = [
    Setting::new(
        Part::Skip,
        "policy",
        "",
        Kind::Choice {
            options: POLICIES,
            get: |s| {
                Some(match s.skip.policy {
                    ClothSkipPolicy::Bounded => 0,
                    ClothSkipPolicy::UntilClean { .. } => 1,
                    ClothSkipPolicy::Off => 2,
                })
            },
            set: |s, i| {
                s.skip.policy = match (i, s.skip.policy) {
                    (0, _) => ClothSkipPolicy::Bounded,
                    (1, before @ ClothSkipPolicy::UntilClean { .. }) => before,
                    (1, _) => ClothSkipPolicy::UntilClean { max: UNTIL_CLEAN },
                    _ => ClothSkipPolicy::Off,
                }
            },
        },
        [
            "What is drawn while it is tangled; time is never skipped.",
            "Off: crossings are seen at once.",
            "UntilClean: the whole cloth sticks until it is clean.",
        ],
    ),
    Setting::new(
        Part::Skip,
        "max",
        "frames",
        Kind::Count(Scale::whole(0.0, u32::MAX as f64).slider(1.0, 600.0).log(), |s| match &mut s.skip.policy {
            ClothSkipPolicy::UntilClean { max } => Some(max),
            ClothSkipPolicy::Bounded | ClothSkipPolicy::Off => None,
        }),
        ["Most frames held in a row until clean.", "Crossings are seen sooner.", "The cloth sticks for as long."],
    )
    .starts(UNTIL_CLEAN as f64),
    Setting::new(
        Part::Skip,
        "max_held_frames",
        "frames",
        Kind::Count(Scale::whole(0.0, 30.0), |s| Some(&mut s.skip.max_held_frames)),
        ["Most frames held in a row, if bounded.", "Short tangles are seen.", "The cloth visibly sticks."],
    ),
    Setting::new(
        Part::Skip,
        "max_held_time",
        "s",
        Kind::Number(Scale::real(0.0, 1.0), |s| Some(&mut s.skip.max_held_time)),
        ["Most time held in any second, if bounded.", "Tangles that come back are seen.", "The cloth visibly sticks."],
    ),
    Setting::new(
        Part::Skip,
        "fade",
        "s",
        Kind::Number(Scale::real(0.0, 10.0).slider(0.0, 1.0), |s| Some(&mut s.skip.fade)),
        ["Time over which what was held fades into the live shape.", "It snaps there.", "It drifts where it should move."],
    ),
];
