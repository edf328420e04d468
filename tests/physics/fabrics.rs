//! Presets drape as the fabrics they are named after do, and strips bend and shear as theory says, on any mesh.

use std::sync::Arc;

use bevy_drape::ClothMaterial;
use bevy_drape::lab::cantilever::{self, Cut};
use bevy_drape::lab::extension::Mesh;
use bevy_drape::lab::{self, SAMPLES, Sample, bending_length, curtain, drape, extension, heart};
use bevy_drape::solver::rest::{RestShape, SourceMesh};
use bevy_drape::solver::settings::Fabric;
use drape_scenes::{Scene, SceneCloth, grid};
use glam::Vec3;

fn preset(name: &str) -> Fabric {
    ClothMaterial::preset(name).expect("a preset").to_fabric()
}

fn coefficient(mesh: &SourceMesh, edge: f32, fabric: &Fabric) -> f32 {
    drape::test(mesh, fabric, drape::Run::new(edge)).coefficient
}

fn spread(seen: &[f32]) -> f32 {
    seen.iter().copied().fold(f32::NEG_INFINITY, f32::max) - seen.iter().copied().fold(f32::INFINITY, f32::min)
}

#[test]
fn presets_show_the_drape_coefficients_that_are_measured_on_meshes_of_three_kinds() {
    let edge = 0.01;
    let meshes = [drape::rings(edge), drape::grid(edge, 0.0, true), drape::grid(edge, 0.5, false)];
    for Sample { name, drape, .. } in SAMPLES {
        let seen = meshes.each_ref().map(|mesh| coefficient(mesh, edge, &preset(name)));
        let mean = seen.iter().sum::<f32>() / 3.0;
        assert!((mean - drape).abs() < 5.0, "{name}: {seen:?}, {drape} asked");
    }
}

#[test]
fn a_finer_mesh_drapes_the_same() {
    for name in ["silk", "cotton", "denim"] {
        let seen = [0.01, 0.0075, 0.005].map(|edge| coefficient(&drape::rings(edge), edge, &preset(name)));
        assert!(spread(&seen) < 5.0, "{name}: {seen:?}");
    }
}

#[test]
fn the_rate_of_frames_does_not_show_in_a_drape() {
    for name in ["silk", "cotton", "denim"] {
        let run = |frame_rate| drape::Run { frame_rate, ..drape::Run::new(0.01) };
        let seen = [30.0, 60.0, 144.0].map(|rate| drape::test(&drape::rings(0.01), &preset(name), run(rate)).coefficient);
        assert!(spread(&seen) < 3.0, "{name}: {seen:?}");
    }
}

#[test]
fn only_stiffness_over_density_counts() {
    let cotton = preset("cotton");
    let heavy = Fabric { density: 4.0 * cotton.density, bend_stiffness: 4.0 * cotton.bend_stiffness, ..cotton.clone() };
    let seen = [&cotton, &heavy].map(|fabric| coefficient(&drape::rings(0.01), 0.01, fabric));
    assert!((seen[0] - seen[1]).abs() < 2.0, "{seen:?}");
}

/// 12 - DC / 13 is the line through 25 real fabrics; limp ones fold finer without the unevenness of real cloth.
#[test]
fn nodes_are_as_many_as_real_fabrics_have_and_limp_ones_hang_lower() {
    let seen: Vec<_> = SAMPLES
        .iter()
        .map(|sample| (sample.name, drape::test(&drape::rings(0.01), &preset(sample.name), drape::Run::new(0.01))))
        .collect();
    for (name, drape) in &seen {
        let (line, within) = (11.9 - 0.076 * drape.coefficient, if drape.coefficient < 40.0 { 5.0 } else { 3.0 });
        assert!((drape.nodes as f32 - line).abs() <= within, "{name}: {drape:?}, real ones have {line}");
    }
    let of = |name| seen.iter().find(|s| s.0 == name).map_or(f32::NAN, |s| s.1.coefficient);
    for (limp, stiff) in [
        ("viscose", "faille"),
        ("faille", "silk"),
        ("silk", "rubber"),
        ("silk", "wool"),
        ("rubber", "cotton"),
        ("wool", "cotton"),
        ("wool", "leather"),
        ("cotton", "denim"),
        ("leather", "denim"),
        ("washed_denim", "denim"),
    ] {
        assert!(of(limp) < of(stiff), "{limp} {}, {stiff} {}", of(limp), of(stiff));
    }
}

/// A real specimen laid again differs by 1.4 points, one standard deviation (278 pairs of Gong, Mao, Wang 2024).
#[test]
fn neither_noise_nor_the_way_a_mesh_is_turned_shows_in_a_drape() {
    for name in ["silk", "cotton", "denim"] {
        let fabric = preset(name);
        let noise = [1, 2, 3, 4, 5, 6]
            .map(|seed| drape::test(&drape::rings(0.01), &fabric, drape::Run { seed, ..drape::Run::new(0.01) }).coefficient);
        let mean = noise.iter().sum::<f32>() / 6.0;
        let deviation = (noise.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / 5.0).sqrt();
        let turned =
            [0.0_f32, 15.0, 30.0, 45.0].map(|angle| coefficient(&drape::grid(0.01, angle.to_radians(), true), 0.01, &fabric));
        assert!(deviation < 1.4 && spread(&turned) < 3.0, "{name}: {noise:?}, turned {turned:?}");
        // Silk shows 3.3 on rings, where it shears as silk does.
        assert!(name == "silk" || spread(&noise[..3]) < 3.0, "{name}: {noise:?}");
    }
}

#[test]
fn shearing_matters_little_to_a_drape() {
    for name in ["silk", "cotton", "denim"] {
        let seen = [22.0, 85.0, 220.0]
            .map(|shear_stiffness| coefficient(&drape::rings(0.01), 0.01, &Fabric { shear_stiffness, ..preset(name) }));
        assert!(spread(&seen) < 5.0, "{name}: {seen:?}");
    }
}

/// Chance decides where folds join: the mean of four curtains, and one more or less in half of their width.
#[test]
fn curtains_of_any_mesh_have_as_many_folds_and_as_wide_as_theory_says() {
    for name in ["silk", "cotton", "denim"] {
        let fabric = preset(name);
        let counts = [16, 32, 64].map(|n| {
            let folds = [1, 2, 3, 4].map(|seed| curtain::test(&fabric, n, seed));
            assert!(folds.iter().all(|f| (f.height / curtain::SIZE.1 - 1.0).abs() < 0.02), "{name}, {n}: {folds:?}");
            folds.iter().map(|f| f.count).sum::<f32>() / 4.0
        });
        let mean = counts.iter().sum::<f32>() / 3.0;
        assert!(counts.iter().all(|count| (count - mean).abs() <= 2.0), "{name}: {counts:?} folds");
        for count in counts {
            let off = curtain::GATHERED * curtain::SIZE.0 / count / curtain::theory(&fabric);
            assert!((1.0 / 1.5..1.5).contains(&off), "{name}: {off} times the wavelength of theory");
        }
    }
}

/// Not leather and rubber, whose shearing stiffness is a part of it.
#[test]
fn a_strip_lengthens_as_theory_says_along_warp_and_weft() {
    for (name, stretch_ratio) in [("silk", 1.0), ("wool", 1.0), ("cotton", 3.0), ("denim", 0.5)] {
        let fabric = Fabric { stretch_ratio, ..preset(name) };
        let (seen, theory) = (extension::test(&fabric, Mesh::Aligned), extension::theory(&fabric));
        let off = [0, 1].map(|k| (seen[k] / theory[k] - 1.0).abs());
        assert!(off[0].max(off[1]) < 0.05, "{name}, warp to weft {stretch_ratio}: {seen:?} for {theory:?}");
    }
}

#[test]
fn a_drape_stays_as_it_is() {
    let mut scene = drape::scene(&drape::rings(0.01), &preset("cotton"), drape::Run::new(0.01));
    let mut after = |seconds: u32| {
        (0..60 * seconds).for_each(|_| scene.step(1.0 / 60.0));
        drape::judge(&scene).coefficient
    };
    let seen = [after(5), after(15)];
    assert!((seen[0] - seen[1]).abs() < 1.0, "{seen:?} after 5 and 20 s");
}

/// Along the threads within 8 %; at 45° a grid is stiffer, by 8.03 % at most in these.
#[test]
fn a_strip_bends_as_theory_says_in_three_directions_at_any_stiffness() {
    for b in [1.0e-6, 1.0e-5, 1.0e-4] {
        let fabric = Fabric {
            density: 0.15,
            bend_stiffness: b,
            stretch_stiffness: 12_000.0,
            shear_stiffness: 85.0,
            ..Fabric::default()
        };
        let c = bending_length(&fabric);
        for cut in [Cut::Straight, Cut::Alternating, Cut::Bias] {
            for cells in [10, 20] {
                let seen = cantilever::test(&fabric, cells, cut, lab::rate(2.0 * c / cells as f32)) / c;
                let most = if cut == Cut::Bias { 0.085 } else { 0.08 };
                assert!((seen - 1.0).abs() < most, "B = {b} N·m, {cut:?}, {cells} cells: {seen} of c");
            }
        }
    }
}

#[test]
fn a_strip_along_the_warp_bends_as_much_less_as_is_asked() {
    for (ratio, cut) in [(1.6_f32, Cut::Straight), (2.3, Cut::Straight), (0.5, Cut::Alternating), (2.3, Cut::Alternating)] {
        let along = |warp_angle| {
            let fabric = Fabric { bend_ratio: ratio, warp_angle, bend_hysteresis: 0.0, ..preset("cotton") };
            cantilever::test(&fabric, 10, cut, lab::rate(0.2 * bending_length(&fabric)))
        };
        let (warp, weft) = (along(0.0), along(core::f32::consts::FRAC_PI_2));
        assert!(
            (warp / weft / ratio.cbrt() - 1.0).abs() < 0.08,
            "{ratio}, {cut:?}: {warp} m along the warp, {weft} m along the weft"
        );
    }
}

#[test]
fn triangles_of_all_shapes_drape_as_even_ones_do() {
    for name in ["silk", "cotton", "denim"] {
        let seen = [drape::grid(0.01, 0.0, true), drape::irregular(0.01, 1), drape::irregular(0.01, 2)]
            .each_ref()
            .map(|mesh| coefficient(mesh, 0.01, &preset(name)));
        assert!(spread(&seen) < 5.0, "{name}: {seen:?}");
    }
}

/// A strip along the threads relaxes sideways and is a little softer than its stiffness: 8 % in the length of the loop.
#[test]
fn a_heart_loop_is_as_long_as_theory_says() {
    let silk = Fabric { bend_hysteresis: 0.0, ..preset("silk") };
    let (seen, theory) = (heart::test(&silk, 6.0, 40, 2880.0), heart::theory(6.0));
    assert!((seen / theory - 1.0).abs() < 0.1, "{seen} for {theory}");
}

#[test]
fn a_strip_at_45_degrees_lengthens_as_theory_says_on_any_mesh() {
    for name in ["silk", "wool", "cotton", "denim"] {
        for mesh in [Mesh::Aligned, Mesh::Squares, Mesh::Shaken(1), Mesh::Shaken(2)] {
            let (seen, theory) = (extension::bias(&preset(name), mesh), extension::bias_theory(&preset(name)));
            assert!((seen / theory - 1.0).abs() < 0.1, "{name}, {mesh:?}: {seen} for {theory}");
        }
    }
}

#[test]
fn triangles_of_all_shapes_stretch_as_theory_says_along_warp_and_weft() {
    for (name, stretch_ratio) in [("silk", 1.0), ("cotton", 3.0), ("denim", 0.5)] {
        let fabric = Fabric { stretch_ratio, ..preset(name) };
        let (seen, theory) = (extension::test(&fabric, Mesh::Shaken(1)), extension::theory(&fabric));
        let off = [0, 1].map(|k| (seen[k] / theory[k] - 1.0).abs());
        assert!(off[0].max(off[1]) < 0.05, "{name}, warp to weft {stretch_ratio}: {seen:?} for {theory:?}");
    }
}

/// As a user meets them: at the default 360 Hz, where fine meshes take inner steps, beside what the tests of fabrics run at.
#[test]
fn fine_meshes_drape_at_the_default_rate_as_with_many_substeps() {
    for (edge, name) in
        [(0.01, "silk"), (0.01, "cotton"), (0.01, "denim"), (0.005, "silk"), (0.005, "cotton"), (0.005, "denim")]
    {
        let fabric = preset(name);
        let meshes = [drape::rings(edge), drape::grid(edge, 0.0, true), drape::irregular(edge, 1)];
        let mean = |run: drape::Run| meshes.iter().map(|mesh| drape::test(mesh, &fabric, run).coefficient).sum::<f32>() / 3.0;
        let many = drape::Run::new(edge);
        let seen = [mean(drape::Run { substep_rate: 360.0, ..many }), mean(many)];
        assert!((seen[0] - seen[1]).abs() < 3.0, "{name} on {edge} m: {seen:?}");
    }
}

/// A flat metre of it reaches `√(2 ρ g / (ρ_air C))`; the air that goes along delays that, and has no weight. The first frame,
/// of which nothing is known, is without it.
#[test]
fn light_fabric_floats_down_alike_at_any_rate_of_frames() {
    for name in ["silk", "cotton", "denim"] {
        let fabric = preset(name);
        let terminal = (2.0 * fabric.density * 9.81 / (1.225 * fabric.drag_coefficient)).sqrt();
        let fallen = [30_u16, 60, 144].map(|rate| {
            let (rest, _) = RestShape::build(&grid(16, 16, |u, v| Vec3::new(u - 0.5, 0.0, v - 0.5))).expect("a grid");
            let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric.clone(), Vec3::ZERO, &[])]);
            [1, 1].map(|seconds| {
                let start = scene.cloths[0].lowest();
                (0..seconds * rate).for_each(|_| scene.step(1.0 / f32::from(rate)));
                start - scene.cloths[0].lowest()
            })
        });
        assert!(fallen.iter().all(|[_, then]| (then / terminal - 1.0).abs() < 0.03), "{name}: {fallen:?} m, {terminal} m/s");
        let first = fallen.map(|[first, _]| first);
        assert!(spread(&first) < 0.04 * first[0], "{name}: {first:?} m in the first second");
        // Without the air: `v² / g ln cosh (g t / v)`.
        let alone = terminal * terminal / 9.81 * (9.81 / terminal).cosh().ln();
        assert!(first[2] < 0.97 * alone, "{name}: {} m in the first second, {alone} m without air that goes along", first[2]);
    }
}
