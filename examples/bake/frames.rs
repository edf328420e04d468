//! What a frame is written as: an OBJ per cloth, and what it did.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use bevy::prelude::*;
use bevy_drape::prelude::*;
use serde_json::json;

pub fn unwritable(path: &Path, error: &std::io::Error) -> String {
    format!("{} cannot be written: {error}", path.display())
}

/// Writes every cloth of this frame.
pub fn write_frame(app: &mut App, names: &BTreeMap<Entity, String>, frame: u32, out: &Path) -> Result<(), String> {
    for (&entity, name) in names {
        let (Some(rest), Some(particles)) = (app.world().get::<ClothRest>(entity), app.world().get::<ClothParticles>(entity))
        else {
            return Err(format!("{name} is gone in frame {frame}"));
        };
        let mut text = String::new();
        for p in particles.shown_positions() {
            if !p.is_finite() {
                return Err(format!("{name} has a position that is not finite in frame {frame}"));
            }
            // Writing to a string cannot fail.
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for [a, b, c] in &rest.shape().topology.faces {
            let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
        }
        let path = out.join(format!("{name}_{frame:05}.obj"));
        std::fs::write(&path, text).map_err(|error| unwritable(&path, &error))?;
    }
    Ok(())
}

/// What the frame did, per cloth.
pub fn describe(app: &mut App, names: &BTreeMap<Entity, String>, frame: u32, elapsed: f64) -> serde_json::Value {
    let cloths: Vec<serde_json::Value> = names
        .iter()
        .filter_map(|(&entity, name)| {
            let report = app.world().get::<ClothReport>(entity)?;
            Some(json!({
                "name": name,
                "worst_edge": report.worst_edge,
                "substeps": report.substeps,
                "body_contacts": report.body_contacts,
                "contacts": report.contacts,
                "crossings": report.crossings,
                "contours": report.contours,
                "contour_length": report.contour_length,
                "held": report.held,
                "stage_ms": {
                    "integrate": report.integrate_ms,
                    "detect": report.detect_ms,
                    "resolve": report.resolve_ms,
                    "evaluate": report.evaluate_ms,
                    "respond": report.respond_ms,
                },
                "restores": report.restores,
                "resets": report.resets,
            }))
        })
        .collect();
    json!({ "frame": frame, "frame_ms": elapsed, "cloths": cloths })
}
