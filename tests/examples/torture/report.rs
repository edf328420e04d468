//! What was seen: counts, the slowest frames, and each kind of failure once.

use std::collections::BTreeMap;
use std::time::Instant;

use drape_tests::attack::case::{Case, Kind};
use drape_tests::attack::play::{Failure, Tally};

/// Slowest cases that are named.
const SLOWEST: usize = 5;

/// Of all cases so far.
pub struct Report {
    /// When it began.
    pub begin: Instant,
    /// Of each kind, one.
    pub failures: BTreeMap<String, u64>,
    cases: [u64; 3],
    frames: u64,
    simulated: u64,
    tangled: u64,
    warnings: u64,
    slowest: Vec<(f32, String)>,
    others: BTreeMap<String, u64>,
    threads: u64,
}

impl Default for Report {
    fn default() -> Self {
        Self {
            begin: Instant::now(),
            failures: BTreeMap::new(),
            cases: [0; 3],
            frames: 0,
            simulated: 0,
            tangled: 0,
            warnings: 0,
            slowest: Vec::new(),
            others: BTreeMap::new(),
            threads: 0,
        }
    }
}

impl Report {
    fn count(&mut self, case: &Case) {
        self.cases[Kind::ALL.iter().position(|kind| *kind == case.kind).unwrap_or(0)] += 1;
    }

    /// A case where everything holds.
    pub fn passed(&mut self, case: &Case, tally: &Tally) {
        self.count(case);
        self.frames += tally.frames;
        self.simulated += tally.simulated;
        self.tangled += tally.tangled;
        self.warnings += tally.warnings;
        self.slowest.push((tally.slowest, case.to_string()));
        self.slowest.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.slowest.truncate(SLOWEST);
        for place in &tally.others {
            *self.others.entry(place.clone()).or_default() += 1;
        }
    }

    /// A case where something does not; the first of its kind is made small and told of at once.
    pub fn failed(&mut self, case: Case, failure: Failure, shrink: impl FnOnce(&Case, &Failure) -> (Case, Failure)) {
        self.count(&case);
        let count = self.failures.entry(failure.kind.clone()).or_default();
        *count += 1;
        if *count == 1 {
            println!("{case} fails: {}", failure.kind);
            let (case, failure) = shrink(&case, &failure);
            tell(&case, &failure);
        } else if *count < 6 {
            println!("{case} fails, too: {}", failure.kind);
        }
    }

    /// Apps that other threads were asked about.
    pub fn threads(&mut self, differ: &Result<u64, String>) {
        match differ {
            Ok(count) => self.threads += count,
            Err(what) => {
                println!("FAILED with other threads: {what}");
                *self.failures.entry("other positions with other threads".into()).or_default() += 1;
            }
        }
    }

    /// Prints all of it.
    pub fn print(&self) {
        let [apps, meshes, files] = self.cases;
        let seconds = self.begin.elapsed().as_secs_f32();
        println!("{apps} apps, {meshes} meshes, {files} files, {} frames in {seconds:.0} s", self.frames);
        println!("{} frames of single cloths, {} of them tangled, {} warnings", self.simulated, self.tangled, self.warnings);
        println!("{} apps have the same positions for 1 and 4 threads", self.threads);
        for (seconds, case) in &self.slowest {
            println!("  a frame of {seconds:.3} s: {case}");
        }
        for (place, count) in &self.others {
            println!("  {count} times a loader panicked, and was caught, at {place}");
        }
        for (kind, count) in &self.failures {
            println!("  FAILED {count} times: {kind}");
        }
    }
}

/// Prints a failure and the line that plays it again.
pub fn tell(case: &Case, failure: &Failure) {
    println!("FAILED {case}\n  {} in frame {}: {}", failure.kind, failure.frame, failure.what);
    failure.told.iter().for_each(|line| println!("    {line}"));
    println!("  cargo run --release --example torture -- --replay \"{case}\"");
}
