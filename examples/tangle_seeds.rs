//! Random tangles, each from a number: what share comes apart within so many frames, with 95 % intervals (Wilson).
//!
//! ```sh
//! cargo run --release --example tangle_seeds -- --seeds 1000
//! ```

#![expect(clippy::print_stdout, reason = "the table is the purpose")]

mod cli;

use std::thread;

use bevy_drape::solver::island::UntangleSettings;
use clap::Parser;
use drape_scenes::{Seed, SeedKind, SeedRun};
use serde_json::json;

/// Frames of 1/60 s after which is counted.
const WITHIN: [u32; 4] = [30, 60, 120, 300];
/// Growth of the contours' length over 30 frames that counts as growing.
const GROWING: f32 = 1.05;

#[derive(Parser)]
#[command(about = "Takes random tangles apart and prints what share was clean after so many frames.")]
struct Arguments {
    /// How many tangles.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// The first of them.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Every sheet collides with itself, not only in self-tangles.
    #[arg(long)]
    self_collision: bool,
    /// Prints JSON instead of a table.
    #[arg(long)]
    json: bool,
}

struct Row {
    seed: u64,
    kind: SeedKind,
    run: SeedRun,
}

impl Row {
    fn is_clean_within(&self, frames: u32) -> bool {
        self.run.clean_after.is_some_and(|after| after <= frames)
    }
}

fn main() {
    let arguments: Arguments = cli::parse("tangle_seeds");
    let rows = run_all(&arguments);
    let tangled: Vec<&Row> = rows.iter().filter(|r| r.run.start > 0).collect();
    let kinds = SeedKind::ALL.map(|kind| (kind.name(), tangled.iter().copied().filter(|r| r.kind == kind).collect()));
    let closed = tangled.iter().copied().filter(|r| r.run.closed).collect();
    let mut islands: Vec<(&str, Vec<&Row>)> = kinds.into();
    islands.extend([("closed contours", closed), ("all", tangled.clone())]);
    let seeds = |of: &dyn Fn(&Row) -> bool| tangled.iter().filter(|r| of(r)).map(|r| r.seed).collect::<Vec<_>>();
    let failed = seeds(&|r| r.run.clean_after.is_none());
    let grown = seeds(&|r| r.run.growth > GROWING);
    let clean = rows.len() - tangled.len();
    if arguments.json {
        let shares = islands.iter().map(|(name, rows)| {
            let within =
                WITHIN.map(|frames| json!({ "frames": frames, "clean": count(rows, frames), "wilson": wilson(rows, frames) }));
            json!({ "name": name, "tangles": rows.len(), "within": within })
        });
        println!(
            "{}",
            json!({ "islands": shares.collect::<Vec<_>>(), "clean_at_start": clean, "failed": failed, "grown": grown })
        );
        return;
    }
    println!("{:16} {:>7}  share clean within so many frames [95 % interval]", "", "tangles");
    print!("{:24}", "");
    WITHIN.iter().for_each(|frames| print!("  {frames:<20}"));
    println!();
    for (name, rows) in &islands {
        print!("{name:16} {:7}", rows.len());
        for frames in WITHIN {
            let [low, high] = wilson(rows, frames).map(|p| 100.0 * p);
            print!("  {:5.1} [{low:5.1}, {high:5.1}]", 100.0 * count(rows, frames) as f64 / rows.len().max(1) as f64);
        }
        println!();
    }
    println!("not tangled at the start: {clean}");
    println!("seeds still tangled after {} frames: {failed:?}", WITHIN[3]);
    println!("seeds whose contours grew by more than 5 % within 30 frames: {grown:?}");
}

/// One tangle after the other, on all processors.
fn run_all(arguments: &Arguments) -> Vec<Row> {
    let threads = thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let last = arguments.first + arguments.seeds;
    let share =
        |k: u64| (arguments.first + k..last).step_by(threads as usize).filter_map(|seed| row(seed, arguments)).collect();
    let share = &share;
    let mut rows: Vec<Row> = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|k| scope.spawn(move || -> Vec<Row> { share(k) })).collect();
        workers.into_iter().filter_map(|w| w.join().ok()).flatten().collect()
    });
    rows.sort_unstable_by_key(|r| r.seed);
    rows
}

fn row(number: u64, arguments: &Arguments) -> Option<Row> {
    let seed = Seed::new(number);
    let run = seed.run(UntangleSettings::default(), arguments.self_collision, WITHIN[3])?;
    Some(Row { seed: number, kind: seed.kind, run })
}

fn count(rows: &[&Row], frames: u32) -> usize {
    rows.iter().filter(|r| r.is_clean_within(frames)).count()
}

/// The 95 % interval of a share (Wilson 1927).
fn wilson(rows: &[&Row], frames: u32) -> [f64; 2] {
    let (n, z) = (rows.len().max(1) as f64, 1.96);
    let p = count(rows, frames) as f64 / n;
    let centre = p + z * z / (2.0 * n);
    let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    [centre - half, centre + half].map(|x| x / (1.0 + z * z / n))
}
