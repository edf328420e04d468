//! `ClothMaterial`.

use crate::inspector::part::Part;
use crate::inspector::setting::{Field, Kind, Scale, Setting};

const fn row(name: &'static str, unit: &'static str, scale: Scale, field: Field<f32>, tips: [&'static str; 3]) -> Setting {
    Setting::new(Part::Material, name, unit, Kind::Number(scale, field), tips)
}

pub(super) const MATERIAL: [Setting; 18] = [
    row(
        "density",
        "kg/m²",
        Scale::real(0.01, 10.0).slider(0.02, 2.0).log(),
        |s| Some(&mut s.material.density),
        [
            "Mass of a square metre. Silk 0.06, shirt 0.15, jeans 0.4, leather 0.8.",
            "Flutters in any breeze, and stiff springs need a higher substep rate to hold it.",
            "Hangs like lead; wind hardly moves it, and the springs stretch.",
        ],
    ),
    row(
        "stretch_stiffness",
        "N/m",
        Scale::real(0.0, 1.0e7).slider(10.0, 1.0e6).log(),
        |s| Some(&mut s.material.stretch_stiffness),
        [
            "Tension per metre of width along the threads, at a strain of one.",
            "Rubber: it sags until the strain limit holds it.",
            "No visible gain once a substep cannot follow it: raise the substep rate first.",
        ],
    ),
    row(
        "shear_stiffness",
        "N/m",
        Scale::real(0.0, 1.0e7).slider(1.0, 1.0e5).log(),
        |s| Some(&mut s.material.shear_stiffness),
        [
            "Stiffness against shearing: force per metre of width at an angle of one radian. Woven cloth has 20 to 200.",
            "Quads shear freely: drapes finely, but a square may hang as a diamond.",
            "Folds like paper or leather instead of draping.",
        ],
    ),
    row(
        "bend_stiffness",
        "N·m",
        Scale::real(0.0, 1.0).slider(1.0e-7, 1.0e-2).log(),
        |s| Some(&mut s.material.bend_stiffness),
        [
            "Resistance to being bent. Silk 1.5e-6, shirt 1.1e-5, jeans 6e-5.",
            "Crumples into folds as fine as the mesh.",
            "Keeps its shape at rest.",
        ],
    ),
    row(
        "stretch_ratio",
        "",
        Scale::real(0.1, 10.0).log(),
        |s| Some(&mut s.material.stretch_ratio),
        [
            "Stretch stiffness along the warp (v of the texture) over that along the weft (u), their mean being kept.",
            "Gives along the warp.",
            "Gives along the weft.",
        ],
    ),
    row(
        "bend_ratio",
        "",
        Scale::real(0.1, 10.0).log(),
        |s| Some(&mut s.material.bend_ratio),
        [
            "Bending stiffness along the warp (v of the texture) over that along the weft (u), their mean being kept. Woven cloth 0.7 to 2.5.",
            "Its folds run along the weft.",
            "Its folds run along the warp.",
        ],
    ),
    row(
        "warp_angle",
        "rad",
        Scale::real(-core::f64::consts::PI, core::f64::consts::PI),
        |s| Some(&mut s.material.warp_angle),
        [
            "Angle of the warp from v towards u of the texture, as the piece is cut. Shows where a ratio is not 1.",
            "Turned the other way.",
            "0.785 is at 45°.",
        ],
    ),
    row(
        "bend_hysteresis",
        "1/m",
        Scale::real(0.0, 1000.0).slider(1.0, 200.0).log(),
        |s| Some(&mut s.material.bend_hysteresis),
        [
            "Curvature that the friction between yarns holds. Silk 18, wool 25, shirt 40.",
            "Folds open all the way, and the cloth swings.",
            "Stays as it was crumpled, like paper.",
        ],
    ),
    row(
        "damping",
        "1/s",
        Scale::real(0.0, 1000.0).slider(0.01, 100.0).log(),
        |s| Some(&mut s.material.damping),
        ["Rate at which stretching motion inside the fabric decays.", "Quivers after every tug.", "Moves as if in honey."],
    ),
    row(
        "drag",
        "1/s",
        Scale::real(0.0, 100.0).slider(0.001, 20.0).log(),
        |s| Some(&mut s.material.drag),
        [
            "Rate at which every velocity decays, whatever the air does.",
            "Swings for ever where there is no air.",
            "Falls slowly and lags behind what carries it.",
        ],
    ),
    row(
        "strain_limit",
        "",
        Scale::real(0.0, 10.0).slider(0.001, 1.0).log().endless(),
        |s| Some(&mut s.material.strain_limit),
        [
            "Largest elongation of an edge, as a fraction of its length. \"off\" for none.",
            "Cannot give at all: stiff, and it costs substeps to hold.",
            "Stretches like rubber under a load.",
        ],
    ),
    row(
        "thickness",
        "m",
        Scale::real(1.0e-4, 1.0).slider(5.0e-4, 0.05).log(),
        |s| Some(&mut s.material.thickness),
        [
            "Distance kept to bodies, and from centre to centre between layers.",
            "Shows what it lies on, and fast cloth goes through.",
            "Hovers; beyond half an edge of the mesh folds push themselves apart.",
        ],
    ),
    row(
        "static_friction",
        "",
        Scale::real(0.0, 10.0).slider(0.0, 2.0),
        |s| Some(&mut s.material.static_friction),
        ["Coulomb coefficient below which it sticks.", "Slides off everything.", "Sticks like tape."],
    ),
    row(
        "dynamic_friction",
        "",
        Scale::real(0.0, 10.0).slider(0.0, 2.0),
        |s| Some(&mut s.material.dynamic_friction),
        [
            "Coulomb coefficient while it slides.",
            "Once it slides it does not stop.",
            "Above the static one it stops with a jerk.",
        ],
    ),
    row(
        "restitution",
        "",
        Scale::real(0.0, 1.0),
        |s| Some(&mut s.material.restitution),
        [
            "Speed with which it leaves what it struck, over that with which it met it.",
            "Lies where it falls, as fabrics do.",
            "Bounces like a trampoline.",
        ],
    ),
    row(
        "tether_scale",
        "",
        Scale::real(0.1, 10.0).slider(0.5, 3.0).endless(),
        |s| Some(&mut s.material.tether_scale),
        [
            "How far it may hang from a pin, over the distance along the cloth. \"off\" for no tethers.",
            "Below 1 it is drawn up towards its pins.",
            "Long cloth stretches under its own weight before the springs hold it.",
        ],
    ),
    row(
        "drag_coefficient",
        "",
        Scale::real(0.0, 10.0).slider(0.0, 3.0),
        |s| Some(&mut s.material.drag_coefficient),
        [
            "How much wind across the surface takes it along; a flat plate has 1.2.",
            "Wind does nothing.",
            "A sail: light cloth moves with the air.",
        ],
    ),
    row(
        "lift_coefficient",
        "",
        Scale::real(0.0, 10.0).slider(0.0, 3.0),
        |s| Some(&mut s.material.lift_coefficient),
        [
            "How much wind along the surface lifts it; this is what makes a flag flap.",
            "Flags stream without flapping.",
            "Flaps wildly, and may need a higher substep rate.",
        ],
    ),
];
