//! Attacks the plugin at random: apps, meshes and files. What fails is made small, and a line plays it again.
//!
//! ```text
//! cargo run --release --example torture -- --apps 10000 --meshes 20000 --files 20000
//! cargo run --release --example torture -- --hours 8
//! cargo run --release --example torture -- --replay "app 1234 frames 60 keep 0,3,17"
//! ```
//!
//! After every frame: no panic, no number that is not finite in what is shown or reported, a warning at most once for what was
//! done, a frame no longer than its work explains. At the end of an app nothing of it is left, and a second run, or another
//! number of threads, has the same positions. A frame that does not end, ends the program.

#![expect(clippy::print_stdout, reason = "a program speaks on its terminal")]

mod arguments;
#[path = "../../../examples/cli/mod.rs"]
mod cli;
mod report;
mod threads;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use arguments::Arguments;
use drape_tests::attack::case::{Case, Kind};
use drape_tests::attack::headless::Options;
use drape_tests::attack::play::Tally;
use drape_tests::attack::shrink::shrink;
use drape_tests::attack::watch;
use report::Report;

/// Time without a frame after which the program ends `[s]`.
const HANGS: u64 = 300;
/// Cases that are played again with other threads: the app of every so many cases.
const THREADS: u64 = 400;

fn main() -> ExitCode {
    let arguments: Arguments = cli::parse("torture");
    if let Some(threads) = arguments.threads {
        return threads::print(&arguments, threads);
    }
    watch::begin(Duration::from_secs(HANGS), |case| {
        println!("FAILED {case}\n  a frame does not end within {HANGS} s");
        std::process::exit(3)
    });
    let options = Options { patience: Some(arguments.patience), ..Options::default() };
    if let Some(line) = &arguments.replay {
        return replay(line, &options);
    }
    let mut report = Report::default();
    for (number, case) in arguments.cases().enumerate() {
        if report.begin.elapsed() > arguments.time() || report.failures.len() >= arguments.most {
            break;
        }
        let twice = case.kind == Kind::App && case.seed.is_multiple_of(4);
        let result = if twice { case.play_twice(&options) } else { case.play(&options) };
        match result {
            Ok(tally) => report.passed(&case, &tally),
            Err(failure) => report.failed(case, failure, |case, failure| shrink(case, failure, &options, SHRINK)),
        }
        if (number as u64).is_multiple_of(THREADS) {
            report.threads(&threads::differ(arguments.seed + number as u64 / THREADS));
        }
    }
    report.print();
    if report.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Longest time to make a failure small.
const SHRINK: Duration = Duration::from_secs(120);

/// Plays a line and tells what is done.
fn replay(line: &str, options: &Options) -> ExitCode {
    let case: Case = match line.parse() {
        Ok(case) => case,
        Err(reason) => {
            cli::complain("torture", &format!("a line to replay {reason}: {line}"));
            return ExitCode::from(2);
        }
    };
    let begin = Instant::now();
    match case.play_twice(options) {
        Ok(Tally { frames, slowest, hash, .. }) => {
            let seconds = begin.elapsed().as_secs_f32();
            println!(
                "{case}: nothing fails in {frames} frames and {seconds:.1} s, the slowest of {slowest:.3} s, hash {hash:016x}"
            );
            ExitCode::SUCCESS
        }
        Err(failure) => {
            report::tell(&case, &failure);
            ExitCode::FAILURE
        }
    }
}
