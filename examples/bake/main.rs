//! Simulates the cloths of a glTF scene without a window and writes each as one OBJ file per frame.
//!
//! ```text
//! cargo run --example bake -- assets/drape.glb --frames 240 --out bake
//! cargo run --example bake -- assets/character.glb --report --only Cape,Skirt --clip Walk,Run
//! ```
//!
//! `OUT/<node>_<frame>.obj` holds the welded mesh in world space [m], frame 0 as authored; `OUT/report.json` what each frame
//! did. The exit code is 0 only if all was written; a file that cannot be simulated is one line on stderr and exit code 2.
//!
//! `--report` is for who makes clothes: it says per cloth and clip where the skin lies inside bodies, which edges it stretches
//! too far, which painted maps make no sense, and how the cloth fared. It writes no OBJ.

mod clip;
#[path = "../cli/mod.rs"]
mod cli;
mod frames;
mod lines;
mod maps;
mod report;
mod scene;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use bevy_drape::prelude::*;
use clap::Parser;
use serde_json::json;

use frames::{describe, unwritable, write_frame};

/// Simulates the cloths of a glTF scene and writes each as one OBJ file per frame.
#[derive(Parser)]
struct Arguments {
    /// The scene, a .glb or .gltf file.
    scene: PathBuf,
    /// Frames to simulate; with --report, of each clip.
    #[arg(long, default_value_t = 240)]
    frames: u32,
    /// Frames per second of simulated time.
    #[arg(long, default_value_t = 60.0, value_parser = rate)]
    fps: f64,
    /// Substeps per second [Hz] of cloths that have the default rate; more than in a game, since nobody waits [default: 2400;
    /// with --report that of a game].
    #[arg(long, value_parser = substeps)]
    substep_rate: Option<f32>,
    /// How crossing cloths are taken apart; the default is what each cloth asks for.
    #[arg(long, value_parser = cli::method)]
    method: Option<ClothUntanglingMethod>,
    /// Folder to write to; made if it is not there.
    #[arg(long, default_value = "bake")]
    out: PathBuf,
    /// Says what is wrong with skinned cloth, clip by clip, in place of writing it.
    #[arg(long)]
    report: bool,
    /// Clips of the report, by name [default: all].
    #[arg(long, value_delimiter = ',', requires = "report")]
    clip: Vec<String>,
    /// Nodes whose cloth is simulated; those of other cloths are left out [default: all].
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
}

/// Substeps of a bake per second [Hz].
const BAKED: f32 = 2400.0;

fn rate(text: &str) -> Result<f64, String> {
    let fps: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (1.0..=10_000.0).contains(&fps) { Ok(fps) } else { Err("must be between 1 and 10000".into()) }
}

fn substeps(text: &str) -> Result<f32, String> {
    let rate: f32 = text.parse().map_err(|_| "not a number".to_string())?;
    if (30.0..=10_000.0).contains(&rate) { Ok(rate) } else { Err("must be between 30 and 10000".into()) }
}

fn main() -> ExitCode {
    let arguments: Arguments = cli::parse("bake");
    let done = if arguments.report { report::report(&arguments) } else { bake(&arguments) };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            cli::complain("bake", &line);
            ExitCode::from(2)
        }
    }
}

fn bake(arguments: &Arguments) -> Result<(), String> {
    let mut app = scene::app(arguments, true)?;
    scene::load(&mut app, &arguments.scene, None)?;
    scene::refine(&mut app, arguments.substep_rate.unwrap_or(BAKED), arguments.method);
    std::fs::create_dir_all(&arguments.out).map_err(|error| unwritable(&arguments.out, &error))?;

    let names = scene::names(&mut app);
    let mut report = Vec::new();
    write_frame(&mut app, &names, 0, &arguments.out)?;
    scene::start(&mut app);
    for frame in 1..=arguments.frames {
        let begin = Instant::now();
        (0..scene::updates(arguments.fps)).for_each(|_| app.update());
        let elapsed = begin.elapsed().as_secs_f64() * 1.0e3;
        report.push(describe(&mut app, &names, frame, elapsed));
        write_frame(&mut app, &names, frame, &arguments.out)?;
    }
    let path = arguments.out.join("report.json");
    let report = json!({ "fps": arguments.fps, "frames": report });
    std::fs::write(&path, format!("{report:#}\n")).map_err(|error| unwritable(&path, &error))
}
