//! The same with another number of threads: there is one pool of threads in a process, so the program runs itself.

use std::process::{Command, ExitCode};

use crate::arguments::Arguments;
use drape_tests::attack::case::{Case, Kind};
use drape_tests::attack::headless::Options;

/// Apps that are asked about at once.
const APPS: u64 = 8;
/// Frames of each.
const FRAMES: u32 = 60;

/// Prints what apps come to with so many threads.
pub fn print(arguments: &Arguments, threads: usize) -> ExitCode {
    let options = Options { threads: Some(threads), ..Options::default() };
    for seed in first(arguments.seed)..first(arguments.seed) + APPS {
        let case = Case { frames: FRAMES, ..Case::new(Kind::App, seed) };
        match case.play(&options) {
            Ok(tally) if tally.by_clock => println!("app {seed} by the clock"),
            Ok(tally) => println!("app {seed} hash {:016x}", tally.hash),
            Err(failure) => println!("app {seed} fails: {}", failure.kind),
        }
    }
    ExitCode::SUCCESS
}

/// The first app of a number: others than those that are played in this process.
fn first(number: u64) -> u64 {
    (number << 20) + 500_000
}

/// How many apps come to the same with 1 and 4 threads.
///
/// # Errors
/// The first that does not.
pub fn differ(number: u64) -> Result<u64, String> {
    let lines = |threads: usize| {
        let this = std::env::current_exe().map_err(|error| error.to_string())?;
        let arguments = ["--seed", &number.to_string(), "--threads", &threads.to_string()].map(str::to_owned);
        let output = Command::new(this).args(arguments).output().map_err(|error| error.to_string())?;
        if !output.status.success() {
            return Err(format!("{threads} threads, apps from {}: {}", first(number), output.status));
        }
        Ok(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect::<Vec<_>>())
    };
    let [one, four] = [lines(1)?, lines(4)?];
    match one.iter().zip(&four).find(|(a, b)| a != b) {
        Some((one, four)) => Err(format!("`{one}` with 1 thread, `{four}` with 4")),
        None if one.len() == four.len() => Ok(one.iter().filter(|line| line.contains("hash")).count() as u64),
        None => Err(format!("{} and {} lines", one.len(), four.len())),
    }
}
