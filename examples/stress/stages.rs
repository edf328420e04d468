//! How long each stage of the frame takes, all cloths and what is around them included.

use std::time::Instant;

use bevy::prelude::*;
use bevy_drape::ClothSystems;

/// The stages in the order of the frame.
pub const NAMES: [&str; 7] = ["prepare", "integrate", "detect", "resolve", "evaluate", "respond", "sync"];

/// Times of the last frame.
#[derive(Resource)]
pub struct Stages {
    last: Instant,
    /// Time of each stage [ms].
    pub ms: [f64; NAMES.len()],
}

/// Measures every frame from now on.
pub fn watch(app: &mut App) {
    use ClothSystems::{Detect, Evaluate, Integrate, Prepare, Resolve, Respond, Sync};
    let sets = [Prepare, Integrate, Detect, Resolve, Evaluate, Respond, Sync];
    app.insert_resource(Stages { last: Instant::now(), ms: [0.0; NAMES.len()] });
    let begin = |mut stages: ResMut<Stages>| stages.last = Instant::now();
    app.add_systems(PostUpdate, begin.after(TransformSystems::Propagate).before(Prepare));
    for (stage, set) in sets.into_iter().enumerate() {
        let end = move |mut stages: ResMut<Stages>| {
            let now = Instant::now();
            stages.ms[stage] = now.duration_since(stages.last).as_secs_f64() * 1.0e3;
            stages.last = now;
        };
        match sets.get(stage + 1) {
            Some(next) => app.add_systems(PostUpdate, end.after(set).before(*next)),
            None => app.add_systems(PostUpdate, end.after(set)),
        };
    }
}
