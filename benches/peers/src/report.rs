//! Rows as Markdown tables or as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::measure::Row;
use crate::peer::{Engine, Scene};
use crate::tangle;

/// Size at which engines are compared, if it was run.
const COMPARED: u32 = 64;

/// One engine against ours, in one scene at one size.
struct Ratio {
    scene: Scene,
    size: u32,
    engine: Engine,
    /// Its time of a frame over ours (dimensionless).
    frame: f64,
    /// Its time per spring over ours (dimensionless).
    spring: f64,
    /// Its time per constraint over ours (dimensionless).
    constraint: f64,
    /// Its worst edge.
    edge: f64,
    /// Our worst edge.
    our_edge: f64,
}

/// A table per scene, then the ratios.
pub fn tables(rows: &[Row], frames: u32, timed: u32, runs: u32) -> String {
    let mut text = format!(
        "Frames of 1/60 s: {frames}, of which the last {timed} are timed, on every engine and size. \
         Runs: {runs}; of each row the one with the median time.\n"
    );
    for scene in Scene::ALL {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.scene == scene).collect();
        if !rows.is_empty() {
            table(&mut text, scene, &rows);
        }
    }
    for ratio in ratios(rows) {
        // Writing to a `String` cannot fail.
        let _ = write!(
            text,
            "\n{} {}²: {} takes {:.2} x our time for a frame, {:.2} x per spring, {:.2} x per constraint; worst edge {:.2}, ours {:.2}.",
            ratio.scene, ratio.size, ratio.engine, ratio.frame, ratio.spring, ratio.constraint, ratio.edge, ratio.our_edge
        );
    }
    text.push('\n');
    text
}

fn table(text: &mut String, scene: Scene, rows: &[&Row]) {
    let (last, rule) = if scene.has_ball() { ("drop [m] | gap [mm]", "---:|---:") } else { ("drop [m]", "---:") };
    let _ = writeln!(
        text,
        "\n{scene}\n\n\
         | N | engine | ms p50 | ms p95 | ns per spring | ns per constraint | springs | constraints | worst edge | mean edge | worst spring | {last} |\n\
         |---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|{rule}|"
    );
    for row in rows {
        let _ = write!(
            text,
            "| {} | {} | {:.3} | {:.3} | {:.2} | {:.2} | {} | {} | {:.3} | {:.4} | {:.3} | {:.3} |",
            row.size,
            row.engine,
            row.p50,
            row.p95,
            row.per_spring,
            row.per_constraint,
            row.solved.springs,
            row.solved.all,
            row.edge.worst,
            row.edge.mean,
            row.spring.worst,
            row.drop
        );
        if let Some(gap) = row.gap {
            let _ = write!(text, " {:.1} |", gap * 1.0e3);
        }
        text.push('\n');
    }
}

/// The tangles, then what they cost on other engines over ours.
pub fn tangles(rows: &[tangle::Row], size: u32, steps: u32) -> String {
    let mut text = format!(
        "\ntangles, sheets of about {size} x {size}, {steps} steps of 1/60 s\n\n\
         | scene | engine | crossings at the start | steps to clean | left at the end | ms per step | ms per step, tangled | ms p95 | ms until clean |\n\
         |---|---|---:|---:|---:|---:|---:|---:|---:|\n"
    );
    for row in rows {
        let clean = row.clean.map_or("-".into(), |step| step.to_string());
        let total = row.clean.map_or("-".into(), |_| format!("{:.2}", row.total));
        // Writing to a `String` cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {clean} | {} | {:.3} | {:.3} | {:.3} | {total} |",
            row.tangle.name(),
            row.engine,
            row.start,
            row.left,
            row.mean,
            row.tangled,
            row.p95
        );
    }
    for (engine, mean, cleared, pairs) in tangle_ratios(rows) {
        let _ =
            writeln!(text, "\n{engine}: {cleared} of {pairs} clean; a step takes {mean:.1} x ours, over all scenes and steps.");
    }
    text
}

/// One line with every tangle.
pub fn tangles_json(rows: &[tangle::Row], size: u32, steps: u32) -> Value {
    let line = |row: &tangle::Row| {
        json!({
            "scene": row.tangle.name(),
            "engine": row.engine.to_string(),
            "crossings_at_start": row.start,
            "steps_to_clean": row.clean,
            "crossings_left": row.left,
            "step_ms_mean": row.mean,
            "step_ms_tangled": row.tangled,
            "step_ms_p95": row.p95,
        })
    };
    json!({ "size": size, "steps": steps, "tangles": rows.iter().map(line).collect::<Vec<_>>() })
}

/// Per other engine: its mean step over ours, tangles cleared, tangles run.
fn tangle_ratios(rows: &[tangle::Row]) -> Vec<(Engine, f64, usize, usize)> {
    let mean = |engine: Engine| {
        let times: Vec<f64> = rows.iter().filter(|row| row.engine == engine).map(|row| row.mean).collect();
        times.iter().sum::<f64>() / times.len().max(1) as f64
    };
    let of = |engine: Engine| rows.iter().filter(move |row| row.engine == engine);
    Engine::ALL
        .into_iter()
        .filter(|&engine| of(engine).count() > 0)
        .map(|engine| {
            let cleared = of(engine).filter(|row| row.clean.is_some()).count();
            (engine, mean(engine) / mean(Engine::Ours), cleared, of(engine).count())
        })
        .collect()
}

/// One line with everything. Numbers that are not finite are null.
pub fn json(rows: &[Row], frames: u32, timed: u32, runs: u32) -> Value {
    let rows_json = rows.iter().map(|row| {
        json!({
            "scene": row.scene.to_string(),
            "size": row.size,
            "engine": row.engine.to_string(),
            "frame_ms_p50": row.p50,
            "frame_ms_p95": row.p95,
            "spring_ns": row.per_spring,
            "constraint_ns": row.per_constraint,
            "springs": row.solved.springs,
            "constraints": row.solved.all,
            "worst_edge": row.edge.worst,
            "mean_edge": row.edge.mean,
            "worst_spring": row.spring.worst,
            "mean_spring": row.spring.mean,
            "drop": row.drop,
            "gap": row.gap,
        })
    });
    let ratios_json = ratios(rows).into_iter().map(|ratio| {
        json!({
            "scene": ratio.scene.to_string(),
            "size": ratio.size,
            "engine": ratio.engine.to_string(),
            "frame": ratio.frame,
            "spring": ratio.spring,
            "constraint": ratio.constraint,
        })
    });
    json!({
        "frames": frames,
        "timed": timed,
        "runs": runs,
        "rows": rows_json.collect::<Vec<_>>(),
        "ratios_to_ours": ratios_json.collect::<Vec<_>>(),
    })
}

/// Every other engine against ours at [`COMPARED`], or at the last size when that was not run.
fn ratios(rows: &[Row]) -> Vec<Ratio> {
    let Some(last) = rows.last() else { return Vec::new() };
    let size = if rows.iter().any(|row| row.size == COMPARED) { COMPARED } else { last.size };
    let mut ratios = Vec::new();
    for row in rows.iter().filter(|row| row.size == size && row.engine != Engine::Ours) {
        let ours = rows.iter().find(|r| r.size == size && r.scene == row.scene && r.engine == Engine::Ours);
        if let Some(ours) = ours {
            ratios.push(Ratio {
                scene: row.scene,
                size,
                engine: row.engine,
                frame: row.p50 / ours.p50,
                spring: row.per_spring / ours.per_spring,
                constraint: row.per_constraint / ours.per_constraint,
                edge: row.edge.worst,
                our_edge: ours.edge.worst,
            });
        }
    }
    ratios
}
