//! Steps a recorded frame again.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use bevy_drape::solver::recording::{Recording, RecordingError};

use crate::cli;

/// Steps a recorded frame again; the exit code is 1 when a bit differs.
pub fn replay(path: &Path) -> ExitCode {
    let read = File::open(path).map_err(RecordingError::from).and_then(|file| Recording::read(BufReader::new(file)));
    let mut recording = match read {
        Ok(recording) => recording,
        Err(error) => {
            cli::complain("stress", &format!("{}: {error}", path.display()));
            return ExitCode::from(2);
        }
    };
    let start = Instant::now();
    let replay = recording.replay();
    let particles: usize = recording.cloths.iter().map(|cloth| cloth.after.len()).sum();
    let line = serde_json::json!({
        "reason": recording.reason,
        "cloths": recording.cloths.iter().map(|cloth| &cloth.name).collect::<Vec<_>>(),
        "particles": particles,
        "frame_ms": start.elapsed().as_secs_f64() * 1.0e3,
        "same_bits": replay.differ == 0,
        "particles_that_differ": replay.differ,
        "farthest": replay.farthest,
        "crossings": replay.crossings,
        "held": replay.held,
        "recovered": replay.recovered,
        "worst_edge": replay.worst_edge,
    });
    println!("{line}");
    if replay.differ == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
