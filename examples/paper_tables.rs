//! Tables 1 and 2 and figure 6 of Wen et al. 2009: two crossing sheets of N x N, average time of the whole frame, the
//! traditional method (1995) against ours; then the same at sizes beyond the paper's.
//!
//! ```text
//! cargo run --release --example paper_tables -- --figure figure_6.png
//! ```
//!
//! The paper does not say how its sheets move. Here each figure is the mean over the eight named tangles, half a second of each
//! from its tangled start; a second row of ours counts only frames in which something crossed. A third table takes the paper's
//! summed gradient for every contour: it leaves what is cut straight through.
#![expect(clippy::print_stdout, reason = "a program for the terminal")]

mod chart;
mod cli;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use bevy_drape::solver::detect::SurfaceError;
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::resolve::{Method, ResolveSettings};
use chart::Chart;
use clap::Parser;
use drape_scenes::{self as scenes, Tangle};

/// Vertices along a side, and the paper's figures for the traditional method and its own [ms per frame] on a Pentium 4 at 2.4
/// GHz.
const PAPER: [(u32, f64, f64); 5] =
    [(10, 9.38, 7.61), (15, 11.16, 9.23), (20, 14.15, 10.49), (25, 15.64, 11.24), (30, 17.12, 12.09)];
/// Sizes beyond the paper's.
const BEYOND: [u32; 3] = [64, 100, 256];
/// Frames of each tangle.
const FRAMES: u32 = 30;
/// Length of a frame [s].
const FRAME: f32 = 1.0 / 60.0;

/// Prints tables 1 and 2 of Wen et al. 2009 beside ours, and draws figure 6.
#[derive(Parser)]
struct Arguments {
    /// Largest number of vertices along a side.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(10..=256))]
    largest: u32,
    /// Runs; of each figure, the smallest counts: other work on the machine only adds.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=99))]
    runs: u32,
    /// Draw figure 6, the paper's and ours, into this PNG file.
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
}

fn main() -> ExitCode {
    match tables(&cli::parse("paper_tables")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            cli::complain("paper_tables", &error.to_string());
            ExitCode::from(2)
        }
    }
}

/// The methods at a size.
struct Row {
    n: u32,
    /// The paper's figures [ms], where it has any.
    paper: Option<(f64, f64)>,
    history: Figures,
    gradient: Figures,
    ours: Figures,
}

/// What a method did at a size.
struct Figures {
    /// Mean time of a frame [ms].
    mean: f64,
    /// Mean time of a frame in which something crossed [ms].
    tangled: f64,
    /// Tangles that are not clean at the end.
    left: u32,
}

fn tables(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    if let Some(path) = &arguments.figure {
        // Before minutes of work.
        std::fs::write(path, []).map_err(|error| format!("{} cannot be written: {error}", path.display()))?;
    }
    let paper = PAPER.into_iter().map(|(n, old, new)| (n, Some((old, new))));
    let sizes = paper.chain(BEYOND.into_iter().map(|n| (n, None))).filter(|(n, _)| *n <= arguments.largest);
    let mut rows = Vec::new();
    for (n, paper) in sizes {
        let [history, gradient, ours] =
            [Method::History, Method::GlobalGradient, Method::ByEndType].map(|method| measure(n, method, arguments.runs));
        rows.push(Row { n, paper, history: history?, gradient: gradient?, ours: ours? });
    }
    println!("Two crossing sheets, average time of a frame [ms]. The paper: Pentium 4, 2.4 GHz, drawing included.");
    println!(
        "Here: {}, one thread, no drawing, 360 substeps per second; mean over {FRAMES} frames of eight tangles.",
        machine()
    );
    print("Table 1. The traditional method (1995)", &rows, |row| row.paper.map(|p| p.0), |row| &row.history);
    print("Table 2. The paper's method (2009); here by end type", &rows, |row| row.paper.map(|p| p.1), |row| &row.ours);
    print("The paper's summed gradient for every contour, whatever its ends", &rows, |_| None, |row| &row.gradient);
    match &arguments.figure {
        Some(path) => figure(&rows, path),
        None => Ok(()),
    }
}

fn print(title: &str, rows: &[Row], paper: impl Fn(&Row) -> Option<f64>, here: impl Fn(&Row) -> &Figures) {
    let line = |name: &str, cell: &dyn Fn(&Row) -> String| {
        println!("| {name} | {} |", rows.iter().map(cell).collect::<Vec<_>>().join(" | "));
    };
    println!("\n{title}\n");
    line("sheets", &|row| format!("{0}x{0}", row.n));
    println!("|---|{}", "---:|".repeat(rows.len()));
    line("paper", &|row| paper(row).map_or("-".into(), |ms| format!("{ms:.2}")));
    line("here", &|row| format!("{:.3}", here(row).mean));
    line("here, tangled frames only", &|row| format!("{:.3}", here(row).tangled));
    line("here, still tangled after", &|row| format!("{} of {}", here(row).left, Tangle::ALL.len()));
}

/// The best of some runs.
fn measure(n: u32, method: Method, runs: u32) -> Result<Figures, SurfaceError> {
    let mut best = run(n, method)?;
    for _ in 1..runs {
        let next = run(n, method)?;
        (best.mean, best.tangled) = (best.mean.min(next.mean), best.tangled.min(next.tangled));
    }
    Ok(best)
}

fn run(n: u32, method: Method) -> Result<Figures, SurfaceError> {
    let settings =
        UntangleSettings { resolve: ResolveSettings { method, ..ResolveSettings::default() }, ..UntangleSettings::default() };
    let (mut all, mut dirty, mut left) = ((0.0, 0.0), (0.0, 0.0), 0);
    for tangle in Tangle::ALL {
        let mut scene = scenes::tangle(tangle, n).untangled(settings, EvaluateSettings::default(), false)?.without_contact();
        for _ in 0..FRAMES {
            let start = Instant::now();
            scene.step(FRAME);
            let ms = start.elapsed().as_secs_f64() * 1.0e3;
            all = (all.0 + ms, all.1 + 1.0);
            let iterated = scene.untangle.as_ref().is_some_and(|u| u.island.iterations() > 0);
            if iterated {
                dirty = (dirty.0 + ms, dirty.1 + 1.0);
            }
        }
        left += u32::from(scene.crossings() > 0);
    }
    Ok(Figures { mean: all.0 / all.1, tangled: dirty.0 / f64::max(dirty.1, 1.0), left })
}

/// The processor, if the system tells.
fn machine() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = known.lines().find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1));
    name.unwrap_or("this machine").trim().into()
}

/// Figure 6 twice: with the paper's figures, and with ours at the paper's sizes.
fn figure(rows: &[Row], path: &Path) -> Result<(), Box<dyn Error>> {
    let axes = ["vertices along each side of a sheet", "average time of a frame [ms]"];
    let theirs = |of: fn((f64, f64)) -> f64| rows.iter().filter_map(|r| Some((f64::from(r.n), of(r.paper?)))).collect();
    let here = |of: fn(&Row) -> f64| rows.iter().filter(|r| r.paper.is_some()).map(|r| (f64::from(r.n), of(r))).collect();
    let paper = vec![("traditional (1995)", theirs(|p| p.0)), ("the paper's (2009)", theirs(|p| p.1))];
    let ours: Vec<(&str, Vec<(f64, f64)>)> = vec![
        ("traditional (1995)", here(|r| r.history.mean)),
        ("by end type, tangled frames only", here(|r| r.ours.tangled)),
        ("by end type", here(|r| r.ours.mean)),
    ];
    let top = ours.iter().flat_map(|(_, points)| points).map(|p| p.1).fold(0.0, f64::max);
    let charts = [
        Chart { title: "The paper: Pentium 4, 2.4 GHz, with drawing".into(), axes, top: 24.0, lines: paper },
        Chart { title: format!("Here: {}, no drawing", machine()), axes, top: 1.4 * top, lines: ours },
    ];
    chart::draw(&charts, path)
}
