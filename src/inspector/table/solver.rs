//! `ClothSolver`.

use crate::components::{ClothMembrane, ClothTeleportMode};
use crate::inspector::part::Part;
use crate::inspector::setting::{Field, Kind, Scale, Setting};

const fn row(name: &'static str, unit: &'static str, scale: Scale, field: Field<f32>, tips: [&'static str; 3]) -> Setting {
    Setting::new(Part::Solver, name, unit, Kind::Number(scale, field), tips)
}

const MEMBRANES: [ClothMembrane; 3] = [ClothMembrane::Auto, ClothMembrane::Springs, ClothMembrane::Triangles];
const MODES: [ClothTeleportMode; 3] = [ClothTeleportMode::None, ClothTeleportMode::Keep, ClothTeleportMode::Reset];

pub(super) const SOLVER: [Setting; 11] = [
    row(
        "substep_rate",
        "Hz",
        Scale::real(30.0, 10_000.0).slider(60.0, 4000.0).log(),
        |s| Some(&mut s.solver.substep_rate),
        [
            "Substeps per second. The one dial for exactness: stiffness, contacts and strain all gain.",
            "Stretches, softens, and lets fast bodies push deep.",
            "Cost is proportional.",
        ],
    ),
    row(
        "inner_rate",
        "Hz",
        Scale::real(30.0, 6000.0).slider(30.0, 6000.0).log(),
        |s| Some(&mut s.solver.inner_rate),
        [
            "Most inner steps per second, which fine meshes take for all but contacts: they drape as their fabric and stretch less.",
            "Fine meshes hang limper than their fabric.",
            "Costs only where edges are shorter than 30 mm.",
        ],
    ),
    row(
        "max_frame",
        "s",
        Scale::real(0.001, 1.0).slider(0.01, 0.5).log(),
        |s| Some(&mut s.solver.max_frame),
        [
            "Longest frame that is simulated; the rest of a longer one is dropped.",
            "Below the length of a frame the cloth runs in slow motion.",
            "A hitch of the game costs a long frame of substeps on top.",
        ],
    ),
    Setting::new(
        Part::Solver,
        "membrane",
        "",
        Kind::Choice {
            options: &["Auto", "Springs", "Triangles"],
            get: |s| MEMBRANES.iter().position(|m| *m == s.solver.membrane),
            set: |s, i| s.solver.membrane = MEMBRANES.get(i).copied().unwrap_or_default(),
        },
        [
            "What holds the cloth together in its plane; Auto takes springs where edges run along the threads, else triangles.",
            "Springs: fast, and stiff against shearing where edges do not run along the threads.",
            "Triangles: the same on every mesh.",
        ],
    ),
    row(
        "gravity_scale",
        "",
        Scale::real(-100.0, 100.0).slider(-2.0, 4.0),
        |s| Some(&mut s.solver.gravity_scale),
        ["Scale of gravity for this cloth.", "Floats, or falls upwards below 0.", "Hangs heavy and stretches."],
    ),
    row(
        "time_scale",
        "",
        Scale::real(0.0, 10.0).slider(0.0, 2.0),
        |s| Some(&mut s.solver.time_scale),
        ["Pace of this cloth over that of its clock.", "0 stops it.", "Costs as many more substeps."],
    ),
    Setting::new(
        Part::Solver,
        "teleport",
        "",
        Kind::Choice {
            options: &["None", "Keep", "Reset"],
            get: |s| MODES.iter().position(|m| *m == s.solver.teleport),
            set: |s, i| s.solver.teleport = MODES.get(i).copied().unwrap_or_default(),
        },
        [
            "What happens when what carries the cloth jumps: dragged along, carried with shape and speed, or started again from rest.",
            "None: a jump drags it through the world.",
            "Reset: it starts flat after every jump.",
        ],
    ),
    row(
        "teleport_distance",
        "m",
        Scale::real(0.001, 1.0e6).slider(0.05, 50.0).log(),
        |s| Some(&mut s.solver.teleport_distance),
        ["Least jump in a frame that counts as a teleport.", "Fast motion counts as jumps.", "Jumps count as fast motion."],
    ),
    row(
        "teleport_angle",
        "rad",
        Scale::real(0.01, core::f64::consts::PI).slider(0.05, core::f64::consts::PI),
        |s| Some(&mut s.solver.teleport_angle),
        [
            "Least turn in a frame that counts as a teleport; 1.05 is 60 degrees.",
            "Fast turns count as jumps.",
            "Only half turns count.",
        ],
    ),
    row(
        "reset_edge_ratio",
        "",
        Scale::real(1.1, 1000.0).slider(1.1, 50.0).log(),
        |s| Some(&mut s.solver.reset_edge_ratio),
        [
            "Edge over rest length beyond which the cloth is taken back to its last good state.",
            "Strong pulls take it back.",
            "A blow-up is seen before it is caught.",
        ],
    ),
    row(
        "max_speed",
        "m/s",
        Scale::real(1.0, 1.0e5).slider(5.0, 1.0e4).log(),
        |s| Some(&mut s.solver.max_speed),
        [
            "Speed beyond which the cloth is taken back to its last good state.",
            "Fast motion takes it back.",
            "A blow-up is seen before it is caught.",
        ],
    ),
];
