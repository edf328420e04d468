//! Tables 1 and 2 of Wen et al. 2009: two crossing sheets of N x N, average time of the whole frame, the traditional method (1995) against ours.
//!
//! ```text
//! cargo run --release --example paper_tables
//! ```
//!
//! The paper does not say how its sheets move. Here each figure is the mean over the eight named tangles, half a second of each from its tangled
//! start; the second column of ours counts only frames in which something crossed.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program for the terminal")]

use std::process::ExitCode;
use std::time::Instant;

use bevy_drape::scenes::{self, Tangle};
use bevy_drape::solver::detect::SurfaceError;
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::group::UntangleSettings;
use bevy_drape::solver::resolve::{Method, ResolveSettings};

/// Vertices along a side, and the paper's figures for the traditional method and its own [ms per frame] on a Pentium 4 at 2.4 GHz.
const PAPER: [(u32, f64, f64); 5] =
    [(10, 9.38, 7.61), (15, 11.16, 9.23), (20, 14.15, 10.49), (25, 15.64, 11.24), (30, 17.12, 12.09)];
/// Sizes beyond the paper's.
const BEYOND: [u32; 3] = [64, 100, 256];
/// Frames of each tangle.
const FRAMES: u32 = 30;
/// Length of a frame [s].
const FRAME: f32 = 1.0 / 60.0;

fn main() -> ExitCode {
    match tables() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("paper_tables: {error}");
            ExitCode::from(2)
        }
    }
}

fn tables() -> Result<(), SurfaceError> {
    println!("Average ms per frame, two crossing sheets. The paper: Pentium 4, 2.4 GHz, with drawing.");
    println!("Here: one thread, no drawing, 360 substeps per second.\n");
    println!("|  sheets | paper 1995 | paper 2009 | here 1995 | here, by end type | here, tangled frames | not clean after |");
    println!("|---|---|---|---|---|---|---|");
    let paper = PAPER.into_iter().map(|(n, old, new)| (n, Some((old, new))));
    for (n, known) in paper.chain(BEYOND.into_iter().map(|n| (n, None))) {
        let history = measure(n, Method::History)?;
        let ours = measure(n, Method::ByEndType)?;
        let cell = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.2}"));
        println!(
            "| {n}x{n} | {} | {} | {:.3} | {:.3} | {:.3} | {} of 8 |",
            cell(known.map(|k| k.0)),
            cell(known.map(|k| k.1)),
            history.mean,
            ours.mean,
            ours.tangled,
            ours.left
        );
    }
    Ok(())
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

fn measure(n: u32, method: Method) -> Result<Figures, SurfaceError> {
    let settings =
        UntangleSettings { resolve: ResolveSettings { method, ..ResolveSettings::default() }, ..UntangleSettings::default() };
    let (mut all, mut dirty, mut left) = ((0.0, 0.0), (0.0, 0.0), 0);
    for tangle in Tangle::ALL {
        let mut scene = scenes::tangle(tangle, n).untangled(settings, EvaluateSettings::default(), false)?;
        for _ in 0..FRAMES {
            let start = Instant::now();
            scene.step(FRAME);
            let ms = start.elapsed().as_secs_f64() * 1.0e3;
            all = (all.0 + ms, all.1 + 1.0);
            let iterated = scene.untangle.as_ref().is_some_and(|u| u.group.iterations() > 0);
            if iterated {
                dirty = (dirty.0 + ms, dirty.1 + 1.0);
            }
        }
        left += u32::from(scene.crossings() > 0);
    }
    Ok(Figures { mean: all.0 / all.1, tangled: dirty.0 / f64::max(dirty.1, 1.0), left })
}
