//! `ClothBlend`, `ClothInertia`, `ClothBody`, `ClothPriority` and `ClothBudget`: what characters and crowds of them have.

use crate::inspector::part::Part;
use crate::inspector::setting::{Kind, Scale, Setting};

const SHARES: Scale = Scale::real(0.0, 1.0);
const SPEEDS: Scale = Scale::real(0.0, 1.0e6).slider(0.0, 30.0).endless();
const TURNS: Scale = Scale::real(0.0, 1.0e6).slider(0.0, 40.0).endless();
const FRICTIONS: Scale = Scale::real(0.0, 10.0).slider(0.0, 1.5);

pub(super) const BLEND: [Setting; 2] = [
    Setting::number(
        Part::Blend,
        "weight",
        "",
        (SHARES, |s| Some(&mut s.blend.weight)),
        [
            "How much of a skinned cloth is simulated.",
            "At 0 it is animated by the GPU, and costs nothing.",
            "At 1 all of it is.",
        ],
        1.0,
    ),
    Setting::number(
        Part::Blend,
        "rate",
        "1/s",
        (Scale::real(0.01, 1000.0).slider(0.1, 100.0).log(), |s| Some(&mut s.blend.rate)),
        ["How fast it fades into its animation, and out of it.", "It lags behind.", "It is seen to snap to its skin."],
        4.0,
    ),
];

pub(super) const INERTIA: [Setting; 5] = [
    Setting::new(
        Part::Inertia,
        "enabled",
        "",
        Kind::Switch { get: |s| s.inertia.is_some(), set: |s, on| s.inertia = on.then_some(s.inertia.unwrap_or_default()) },
        [
            "Whether it may feel less than all the motion of what carries it.",
            "Off: a sprint blows a skirt up.",
            "On: the rows below say how much it feels.",
        ],
    ),
    Setting::number(
        Part::Inertia,
        "linear",
        "",
        (SHARES, |s| s.inertia.as_mut().map(|inertia| &mut inertia.linear)),
        ["Share of the way of the carrier that it feels.", "At 0 it hangs as on a statue.", "At 1 a sprint blows it up."],
        1.0,
    ),
    Setting::number(
        Part::Inertia,
        "angular",
        "",
        (SHARES, |s| s.inertia.as_mut().map(|inertia| &mut inertia.angular)),
        ["Share of the turn of the carrier that it feels.", "At 0 it turns along rigidly.", "At 1 a pirouette flings it out."],
        1.0,
    ),
    Setting::number(
        Part::Inertia,
        "max_speed",
        "m/s",
        (SPEEDS, |s| s.inertia.as_mut().map(|inertia| &mut inertia.max_speed)),
        ["Fastest way that it feels; 8 suits characters.", "It feels no sprint.", "Jumps tear at it."],
        f64::INFINITY,
    ),
    Setting::number(
        Part::Inertia,
        "max_turn",
        "rad/s",
        (TURNS, |s| s.inertia.as_mut().map(|inertia| &mut inertia.max_turn)),
        ["Fastest turn that it feels; 12 suits characters.", "It feels no turn.", "Turns on the spot wind it up."],
        f64::INFINITY,
    ),
];

pub(super) const BODY: [Setting; 3] = [
    Setting::number(
        Part::Body,
        "margin",
        "m",
        (Scale::real(0.0, 1.0).slider(0.0, 0.05), |s| s.body.as_mut().map(|body| &mut body.margin)),
        [
            "Distance that clothes keep from the colliders of the bones, on top of their own thickness.",
            "The body shows through.",
            "Clothes stand off.",
        ],
        0.015_f32 as f64,
    ),
    Setting::number(
        Part::Body,
        "static_friction",
        "",
        (FRICTIONS, |s| s.body.as_mut().map(|body| &mut body.static_friction)),
        ["Friction below which clothes stick to it.", "Clothes slip off shoulders.", "They ride up with the limbs."],
        0.5,
    ),
    Setting::number(
        Part::Body,
        "dynamic_friction",
        "",
        (FRICTIONS, |s| s.body.as_mut().map(|body| &mut body.dynamic_friction)),
        ["Friction while clothes slide on it.", "They slide as on ice.", "They are dragged along."],
        0.4_f32 as f64,
    ),
];

pub(super) const PRIORITY: [Setting; 1] = [Setting::new(
    Part::Priority,
    "priority",
    "",
    Kind::Number(Scale::real(0.0, 1.0e6).slider(0.01, 1000.0).log(), |s| Some(&mut s.priority.0)),
    [
        "How much it matters to the budget, beside its size on the screen.",
        "At 0 it is the first to lose detail.",
        "A hero of 100 keeps its detail until all a hundredth of its size has lost it.",
    ],
)];

pub(super) const BUDGET: [Setting; 2] = [
    Setting::new(
        Part::Budget,
        "enabled",
        "",
        Kind::Switch { get: |s| s.budget.is_some(), set: |s, on| s.budget = on.then_some(s.budget.unwrap_or_default()) },
        [
            "Whether all cloths together may take only so much time.",
            "Off: they take what they take.",
            "On: what matters least gets less detail; what happens then depends on the machine.",
        ],
    ),
    Setting::number(
        Part::Budget,
        "ms",
        "ms",
        (Scale::real(0.01, 1000.0).slider(0.1, 50.0).log(), |s| s.budget.as_mut().map(|budget| &mut budget.ms)),
        ["Time of a frame for all cloths, over all threads.", "Cloth that is looked at stands still.", "Frames are late."],
        4.0,
    ),
];
