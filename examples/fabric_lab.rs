//! The laboratory: tests of textile standards on every preset; measured, asked and published side by side.
//!
//! `cargo run --release --example fabric_lab [-- --edge 0.0075 --fabric cotton --out DIR --picture FILE.png]`: with `--out`
//! each draped specimen is written as an OBJ, with `--picture` their shadows from above are drawn.

mod shadows;

use std::path::PathBuf;

use bevy_drape::ClothMaterial;
use bevy_drape::lab::cantilever::{self, Cut};
use bevy_drape::lab::extension::Mesh;
use bevy_drape::lab::{SAMPLES, bending_length, curtain, drape, extension, heart, rate};
use bevy_drape::solver::settings::Fabric;
use clap::Parser;
use drape_scenes::Scene;
use shadows::Shadow;

/// Measures how fabrics drape, bend, stretch, shear and hang.
#[derive(Parser)]
struct Args {
    /// Edges of the specimens of the drape test [m].
    #[arg(long, default_value_t = 0.0075, value_parser = edge)]
    edge: f32,
    /// Substeps per second of the drape test [Hz]; 14 m/s over the edge without, which needs no inner steps. 360 is the default
    /// of cloth.
    #[arg(long, value_parser = positive)]
    rate: Option<f32>,
    /// Frames per second [Hz].
    #[arg(long, default_value_t = 60.0, value_parser = positive)]
    fps: f32,
    /// Only this preset.
    #[arg(long, value_parser = preset)]
    fabric: Option<&'static str>,
    /// Only the drape test.
    #[arg(long)]
    quick: bool,
    /// Vertices along the height of the finest curtain; each is hung on 16 and 32, too.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(16..=128))]
    curtain: u32,
    /// Folder for the draped specimens, as OBJ.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Picture of the draped specimens from above, as PNG.
    #[arg(long)]
    picture: Option<PathBuf>,
}

/// An edge that a specimen of 0.3 m can be cut into.
fn edge(text: &str) -> Result<f32, String> {
    let edge: f32 = text.parse().map_err(|e: core::num::ParseFloatError| e.to_string())?;
    if (0.001..=0.05).contains(&edge) { Ok(edge) } else { Err("an edge is 0.001 to 0.05 m".into()) }
}

fn positive(text: &str) -> Result<f32, String> {
    let rate: f32 = text.parse().map_err(|e: core::num::ParseFloatError| e.to_string())?;
    if (1.0..=1.0e5).contains(&rate) { Ok(rate) } else { Err("a rate is 1 to 100000 Hz".into()) }
}

fn preset(text: &str) -> Result<&'static str, String> {
    let names = ClothMaterial::PRESETS.map(|(name, _)| name);
    names
        .into_iter()
        .find(|name| name.eq_ignore_ascii_case(text))
        .ok_or_else(|| format!("the presets are {}", names.join(", ")))
}

#[expect(clippy::print_stdout, reason = "its output")]
fn main() -> Result<(), Box<dyn core::error::Error>> {
    let args = Args::parse();
    let mut shadows = Vec::new();
    for sample in SAMPLES.iter().filter(|sample| args.fabric.is_none_or(|only| only == sample.name)) {
        let fabric = ClothMaterial::preset(sample.name).unwrap_or_default().to_fabric();
        let thickness = sample.thickness.map_or("unknown".into(), |t| format!("{:.2} mm", 1000.0 * t));
        println!(
            "{}: {} kg/m², thickness {thickness}, bending length {:.1} mm; drape coefficient asked {} ± {} ({})",
            sample.name,
            fabric.density,
            1000.0 * bending_length(&fabric),
            sample.drape,
            sample.within,
            sample.source
        );
        shadows.extend(drapes(&args, sample.name, &fabric)?.map(|scene| Shadow::of(sample, &scene)));
        if !args.quick {
            strips(&fabric);
            curtains(&fabric, args.curtain);
        }
    }
    if let Some(file) = &args.picture {
        shadows::draw(file, &shadows)?;
    }
    Ok(())
}

/// The drape test on meshes of all kinds; the specimen of the first.
#[expect(clippy::print_stdout, reason = "its output")]
fn drapes(args: &Args, name: &str, fabric: &Fabric) -> std::io::Result<Option<Scene>> {
    let standard = drape::Run::new(args.edge);
    let run = drape::Run { substep_rate: args.rate.unwrap_or(standard.substep_rate), frame_rate: args.fps, ..standard };
    let mut first = None;
    for (kind, mesh) in [
        ("rings", drape::rings(args.edge)),
        ("grid", drape::grid(args.edge, 0.0, false)),
        ("alternating", drape::grid(args.edge, 0.0, true)),
        ("turned 30°", drape::grid(args.edge, 30_f32.to_radians(), true)),
        ("irregular", drape::irregular(args.edge, 1)),
    ] {
        let scene = drape::draped(&mesh, fabric, run);
        let seen = drape::judge(&scene);
        println!(
            "  drape, {kind}: {:.1} %, {} nodes (line of real fabrics {:.1})",
            seen.coefficient,
            seen.nodes,
            11.9 - 0.076 * seen.coefficient
        );
        if let Some(folder) = &args.out {
            std::fs::create_dir_all(folder)?;
            std::fs::write(folder.join(format!("{name}_{}.obj", kind.replace(' ', "_"))), obj(&scene))?;
        }
        first.get_or_insert(scene);
    }
    Ok(first)
}

/// Strips that bend, and strips under load.
#[expect(clippy::print_stdout, reason = "its output")]
fn strips(fabric: &Fabric) {
    let elastic = Fabric { bend_hysteresis: 0.0, ..fabric.clone() };
    let even = Fabric { bend_ratio: 1.0, ..elastic.clone() };
    let c = bending_length(fabric);
    for cut in [Cut::Straight, Cut::Alternating, Cut::Bias] {
        let seen = |fabric: &Fabric| cantilever::test(fabric, 10, cut, rate(0.2 * c)) / c;
        println!("  cantilever, {cut:?}: {:.3} of c; with warp, weft and friction of yarns {:.3}", seen(&even), seen(fabric));
    }
    let loops = (heart::test(&even, 6.0, 40, rate(0.15 * c)), heart::theory(6.0));
    println!("  heart loop of 6 c: l/L {:.3}, theory {:.3}", loops.0, loops.1);
    let bias = 100.0 * extension::bias_theory(fabric);
    let [warp, weft] = extension::theory(fabric).map(|e| 100.0 * e);
    for mesh in [Mesh::Aligned, Mesh::Squares, Mesh::Shaken(1)] {
        let seen = 100.0 * extension::bias(fabric, mesh);
        println!("  bias extension at {} N/m, {mesh:?}: {seen:.2} %, theory {bias:.2}", extension::BIAS_LOAD);
        let seen = extension::test(fabric, mesh).map(|e| 100.0 * e);
        println!(
            "  stretch at {} N/m, {mesh:?}: warp {:.2} %, theory {warp:.2}; weft {:.2}, theory {weft:.2}",
            extension::LOAD,
            seen[0],
            seen[1]
        );
    }
}

#[expect(clippy::print_stdout, reason = "its output")]
fn curtains(fabric: &Fabric, finest: u32) {
    let theory = curtain::theory(fabric);
    let mut meshes = vec![16, 32, finest];
    meshes.sort_unstable();
    meshes.dedup();
    for n in meshes {
        let folds = curtain::test(fabric, n, 1);
        println!(
            "  curtain of {n} vertices: {:.1} folds, wavelength {:.2} m, theory {theory:.2}; height {:.3} m of {}",
            folds.count,
            folds.wavelength,
            folds.height,
            curtain::SIZE.1
        );
    }
}

fn obj(scene: &Scene) -> String {
    let cloth = &scene.cloths[0];
    let vertices = cloth.sim.state.positions.iter().map(|x| format!("v {} {} {}\n", x.x, x.y, x.z));
    let faces = cloth.rest.topology.faces.iter().map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1));
    vertices.chain(faces).collect()
}
