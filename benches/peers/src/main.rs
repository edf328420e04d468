//! The same sheet on `bevy_drape`, `bevy_silk` and `rapier3d`, and the same tangles on the two that have contacts between
//! cloths, in one run and on one thread.
//!
//! ```text
//! cargo run --release -- --sizes 16,30,64,128 --frames 300 --runs 3
//! cargo run --release -- --tables tangles --tangle-size 20
//! ```
//!
//! What is compared, and how, is in `README.md`.

mod measure;
mod ours;
mod peer;
mod rapier;
mod report;
mod sheet;
mod silk;
mod tangle;

use std::io::{self, Write};
use std::process::ExitCode;

use drape_scenes::Tangle;
use clap::{Parser, ValueEnum};

use crate::measure::Row;
use crate::peer::{Engine, Peer, Scene};

/// Measures the same cloth on three engines.
#[derive(Parser)]
struct Arguments {
    /// Vertices along each side of the sheet, separated by commas.
    #[arg(long, value_delimiter = ',', default_values_t = [16, 30, 64, 128], value_parser = clap::value_parser!(u32).range(3..=512))]
    sizes: Vec<u32>,
    /// Frames of 1/60 s; the first fifth is not timed.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(5..=100_000))]
    frames: u32,
    /// Tables to print, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = Table::ALL)]
    tables: Vec<Table>,
    /// Vertices along each side of the sheets of a tangle.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(5..=256))]
    tangle_size: u32,
    /// Steps of 1/60 s that a tangle gets, all of them timed.
    #[arg(long, default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    tangle_steps: u32,
    /// Engines to run, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = Engine::ALL)]
    only: Vec<Engine>,
    /// Runs of everything; of each row, the one with the median time is shown.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=99))]
    runs: u32,
    /// Prints a line of JSON instead of each table.
    #[arg(long)]
    json: bool,
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Table {
    /// A sheet that hangs, a sheet on a ball.
    Sheets,
    /// The same where the sheet collides with itself.
    Folds,
    /// Two sheets that start in each other.
    Tangles,
}

impl Table {
    const ALL: [Self; 3] = [Self::Sheets, Self::Folds, Self::Tangles];
}

/// Largest sheet that collides with itself: at 128 x 128 a frame of `rapier3d` takes seconds.
const LARGEST_FOLDS: u32 = 64;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut text = String::new();
    if arguments.tables.contains(&Table::Sheets) || arguments.tables.contains(&Table::Folds) {
        let runs = (1..=arguments.runs).map(|run| measure_all(&arguments, run)).collect();
        let rows = measure::median_rows(runs);
        let timed = measure::timed_frames(arguments.frames);
        text += &if arguments.json {
            format!("{}\n", report::json(&rows, arguments.frames, timed, arguments.runs))
        } else {
            report::tables(&rows, arguments.frames, timed, arguments.runs)
        };
    }
    if arguments.tables.contains(&Table::Tangles) {
        let rows = untangle_all(&arguments);
        let (size, steps) = (arguments.tangle_size, arguments.tangle_steps);
        text += &if arguments.json {
            format!("{}\n", report::tangles_json(&rows, size, steps))
        } else {
            report::tangles(&rows, size, steps)
        };
    }
    // A closed pipe is no reason to panic.
    match io::stdout().write_all(text.as_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

/// Every scene, size and engine once, in the order of the tables.
fn measure_all(arguments: &Arguments, run: u32) -> Vec<Row> {
    let mut rows = Vec::new();
    for scene in Scene::ALL {
        let (table, largest) = if scene.meets_itself() { (Table::Folds, LARGEST_FOLDS) } else { (Table::Sheets, u32::MAX) };
        for &size in arguments.sizes.iter().filter(|&&size| arguments.tables.contains(&table) && size <= largest) {
            for engine in Engine::ALL.into_iter().filter(|engine| arguments.only.contains(engine)) {
                let Some(mut peer) = start(engine, scene, size) else { continue };
                eprintln!("run {run} of {}: {scene} {size} x {size} on {engine}", arguments.runs);
                rows.push(measure::row(engine, scene, size, peer.as_mut(), arguments.frames));
            }
        }
    }
    rows
}

/// Every tangle on every engine, once.
fn untangle_all(arguments: &Arguments) -> Vec<tangle::Row> {
    let mut rows = Vec::new();
    for tangle in Tangle::ALL {
        for engine in Engine::ALL.into_iter().filter(|engine| arguments.only.contains(engine)) {
            eprintln!("{} on {engine}", tangle.name());
            rows.extend(tangle::row(engine, tangle, arguments.tangle_size, arguments.tangle_steps));
        }
    }
    rows
}

/// A scene at rest on an engine; nothing where the engine cannot run it.
fn start(engine: Engine, scene: Scene, size: u32) -> Option<Box<dyn Peer>> {
    match engine {
        Engine::Ours => ours::Ours::new(scene, size).map(|ours| Box::new(ours) as Box<dyn Peer>),
        Engine::Silk => silk::Silk::new(scene, size).map(|silk| Box::new(silk) as Box<dyn Peer>),
        Engine::Rapier => Some(Box::new(rapier::Rapier::new(scene, size))),
    }
}
