//! Times one sheet on one engine.

use std::time::Instant;

use crate::peer::{BALL_RADIUS, Engine, Peer, Scene, Solved};
use crate::sheet::{self, Strain};

/// A line of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Engine.
    pub engine: Engine,
    /// Scene.
    pub scene: Scene,
    /// Vertices along each side.
    pub size: u32,
    /// Median time of a frame [ms].
    pub p50: f64,
    /// 95th percentile [ms].
    pub p95: f64,
    /// Median over the frames of time over springs solved [ns].
    pub per_spring: f64,
    /// Median over the frames of time over all constraints solved [ns].
    pub per_constraint: f64,
    /// Constraints solved in the last frame.
    pub solved: Solved,
    /// Edges of the grid at the end.
    pub edge: Strain,
    /// All that the engine itself holds at a distance against stretch and shear, at the end.
    pub spring: Strain,
    /// Lowest vertex below where the sheet started [m]; where it hangs that is the height of the pins.
    pub drop: f64,
    /// Closest vertex to the ball [m].
    pub gap: Option<f64>,
}

/// One frame.
struct Time {
    /// All of it [ms].
    frame: f64,
    /// Over the springs solved [ns].
    spring: f64,
    /// Over all constraints solved [ns].
    constraint: f64,
}

/// The first fifth of `frames` is warm-up and the first swing.
pub fn timed_frames(frames: u32) -> u32 {
    frames - frames / 5
}

/// Steps a sheet through all frames and reads it off.
pub fn row(engine: Engine, scene: Scene, size: u32, peer: &mut dyn Peer, frames: u32) -> Row {
    let rest = peer.positions();
    let (edges, springs) = (sheet::grid_edges(size), peer.springs());
    let overhead = peer.overhead();
    let mut times = Vec::new();
    let mut solved = Solved::default();
    for _ in 0..frames {
        let start = Instant::now();
        solved = peer.step();
        let time = (start.elapsed().as_secs_f64() - overhead).max(0.0);
        times.push(Time {
            frame: time * 1.0e3,
            spring: time * 1.0e9 / solved.springs.max(1) as f64,
            constraint: time * 1.0e9 / solved.all.max(1) as f64,
        });
    }
    let timed = &times[(frames - timed_frames(frames)) as usize..];
    let column = |value: fn(&Time) -> f64, percent| percentile(timed.iter().map(value).collect(), percent);
    let now = peer.positions();
    Row {
        engine,
        scene,
        size,
        p50: column(|t| t.frame, 50),
        p95: column(|t| t.frame, 95),
        per_spring: column(|t| t.spring, 50),
        per_constraint: column(|t| t.constraint, 50),
        solved,
        edge: sheet::strain(&edges, &rest, &now),
        spring: sheet::strain(&springs, &rest, &now),
        drop: sheet::drop(&rest, &now),
        gap: scene.has_ball().then(|| sheet::gap(BALL_RADIUS, &now)),
    }
}

/// Of the same row in several runs, the one with the median time.
pub fn median_rows(runs: Vec<Vec<Row>>) -> Vec<Row> {
    let rows = runs.iter().map(Vec::len).min().unwrap_or(0);
    let same = (0..rows).map(|i| {
        let mut same: Vec<&Row> = runs.iter().map(|run| &run[i]).collect();
        same.sort_by(|a, b| a.p50.total_cmp(&b.p50));
        same[(same.len() - 1) / 2].clone()
    });
    same.collect()
}

/// The value below which `percent` of `values` lie; 0 for none.
pub fn percentile(mut values: Vec<f64>, percent: usize) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get((values.len() * percent / 100).min(values.len().saturating_sub(1))).copied().unwrap_or(0.0)
}
