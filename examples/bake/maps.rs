//! Which painted maps make no sense.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use serde_json::{Value, json};

/// What is wrong with the maps of a cloth, as JSON: a list for each map, empty where all is well.
pub fn judge(app: &App, cloth: Entity, name: &str) -> Value {
    let world = app.world();
    let (limits, drive) = (world.get::<ClothLimits>(cloth), world.get::<ClothDrive>(cloth));
    let mesh = world.get::<Mesh3d>(cloth).and_then(|mesh| world.resource::<Assets<Mesh>>().get(mesh));
    let painted = |map: Option<&ClothMap>| mesh.and_then(|mesh| map?.painted(mesh));
    let mut found = json!({ "cloth": name });
    let maps = [
        ("max_distance", limits.map(|limits| &limits.max_distance)),
        ("backstop_distance", limits.map(|limits| &limits.backstop_distance)),
        ("drive", drive.map(|drive| &drive.frequency)),
    ];
    for (name, map) in maps {
        if let Some(paint) = painted(map) {
            found[name] = json!(paint.map_or_else(|reason| vec![format!("it is to {reason}")], |paint| of(&paint)));
        }
    }
    if let (Some(Ok(most)), Some(Ok(back))) = (
        limits.and_then(|limits| numbers(&limits.max_distance, mesh?)),
        limits.and_then(|limits| numbers(&limits.backstop_distance, mesh?)),
    ) {
        // Where both are given, but for vertices that are pinned to the skin.
        let off = most.iter().zip(&back).filter(|(most, back)| **most >= 1.0e-3 && back >= most).count();
        let free = most.iter().filter(|most| **most >= 1.0e-3).count();
        if off > 0
            && let Some(list) = found["backstop_distance"].as_array_mut()
        {
            list.push(
                format!("it is off at {off} of {free} free vertices, where it is no nearer than the maximum distance").into(),
            );
        }
    }
    found
}

/// What a map comes to at every vertex.
fn numbers(map: &ClothMap, mesh: &Mesh) -> Option<Result<Vec<f32>, String>> {
    match map {
        ClothMap::Off => None,
        ClothMap::Uniform(value) => Some(Ok(vec![*value; mesh.count_vertices()])),
        ClothMap::Painted { low, high, .. } => {
            let number = |paint: f32| low + (high - low) * if paint.is_nan() { 0.0 } else { paint.clamp(0.0, 1.0) };
            map.painted(mesh).map(|paint| paint.map(|paint| paint.into_iter().map(number).collect()))
        }
    }
}

/// What is wrong with what was painted.
fn of(paint: &[f32]) -> Vec<String> {
    let count = |is_so: fn(&f32) -> bool| paint.iter().filter(|value| is_so(value)).count();
    let mut found = Vec::new();
    let mut tell = |count: usize, what: &str| {
        if count > 0 {
            found.push(format!("{count} of {} vertices {what}", paint.len()));
        }
    };
    tell(count(|value| !value.is_finite()), "are not finite and count as 0 or 1");
    tell(count(|value| value.is_finite() && !(0.0..=1.0).contains(value)), "are outside 0 to 1 and are clamped");
    for (value, what) in [(0.0, "it is 0 everywhere"), (1.0, "it is 1 everywhere")] {
        if !paint.is_empty() && paint.iter().all(|paint| *paint == value) {
            found.push(format!("{what}: it was not painted, or not exported"));
        }
    }
    found
}
