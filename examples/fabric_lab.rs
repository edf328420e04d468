//! The laboratory: tests of textile standards on every preset, measured beside what was asked.
//!
//! `cargo run --release --example fabric_lab [-- --edge 0.0075 --fabric cotton --out DIR]`: with `--out` each draped specimen is written as an OBJ.

use std::path::PathBuf;

use bevy_drape::ClothMaterial;
use bevy_drape::lab::cantilever::{self, Cut};
use bevy_drape::lab::{DRAPES, bending_length, drape, extension, heart, rate};
use bevy_drape::solver::settings::Fabric;
use clap::Parser;

/// Measures how fabrics drape, bend and shear.
#[derive(Parser)]
struct Args {
    /// Edges of the specimens of the drape test [m].
    #[arg(long, default_value_t = 0.0075, value_parser = edge)]
    edge: f32,
    /// Substeps per second of the drape test [Hz]; as many as the mesh needs without.
    #[arg(long)]
    rate: Option<f32>,
    /// Frames per second [Hz].
    #[arg(long, default_value_t = 60.0)]
    fps: f32,
    /// Only this preset.
    #[arg(long)]
    fabric: Option<String>,
    /// Only the drape test.
    #[arg(long)]
    quick: bool,
    /// Folder for the draped specimens, as OBJ.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// An edge that a specimen of 0.3 m can be cut into.
fn edge(text: &str) -> Result<f32, String> {
    let edge: f32 = text.parse().map_err(|e: core::num::ParseFloatError| e.to_string())?;
    if (0.001..=0.05).contains(&edge) { Ok(edge) } else { Err("an edge is 0.001 to 0.05 m".into()) }
}

#[expect(clippy::print_stdout, reason = "its output")]
fn main() -> std::io::Result<()> {
    let args = Args::parse();
    let meshes = [
        ("rings", drape::rings(args.edge)),
        ("grid", drape::grid(args.edge, 0.0, false)),
        ("alternating", drape::grid(args.edge, 0.0, true)),
        ("turned 30°", drape::grid(args.edge, 30_f32.to_radians(), true)),
    ];
    for (name, material) in ClothMaterial::PRESETS {
        if args.fabric.as_ref().is_some_and(|only| !only.eq_ignore_ascii_case(name)) {
            continue;
        }
        let fabric = material.to_fabric();
        let asked = DRAPES.iter().find(|d| d.0 == name).map_or(f32::NAN, |d| d.1);
        println!("{name}: c {:.1} mm, drape coefficient asked {asked}", 1000.0 * bending_length(&fabric));
        let standard = drape::Run::new(args.edge);
        let run = drape::Run { substep_rate: args.rate.unwrap_or(standard.substep_rate), frame_rate: args.fps, ..standard };
        for (kind, mesh) in &meshes {
            let scene = drape::draped(mesh, &fabric, run);
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
        }
        if args.quick {
            continue;
        }
        let elastic = Fabric { bend_hysteresis: 0.0, ..fabric.clone() };
        let c = bending_length(&fabric);
        for cut in [Cut::Straight, Cut::Alternating, Cut::Bias] {
            let seen = |fabric: &Fabric| cantilever::test(fabric, 10, cut, rate(0.2 * c)) / c;
            println!("  cantilever, {cut:?}: {:.3} of c; with the friction of its yarns {:.3}", seen(&elastic), seen(&fabric));
        }
        println!(
            "  heart loop of 6 c: l/L {:.3}, theory {:.3}",
            heart::test(&elastic, 6.0, 40, rate(0.15 * c)),
            heart::theory(6.0)
        );
        println!(
            "  bias extension: {:.2} %, theory {:.2}",
            100.0 * extension::test(&fabric),
            100.0 * extension::theory(&fabric)
        );
    }
    Ok(())
}

fn obj(scene: &bevy_drape::scenes::Scene) -> String {
    let cloth = &scene.cloths[0];
    let vertices = cloth.state.positions.iter().map(|x| format!("v {} {} {}\n", x.x, x.y, x.z));
    let faces = cloth.rest.topology.faces.iter().map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1));
    vertices.chain(faces).collect()
}
