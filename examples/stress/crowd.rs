//! Many characters before a camera, and what a budget leaves of them.

use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::system::SystemState;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_drape::ClothSkinQuery;
use bevy_drape::prelude::*;
use serde_json::{Map, Value, json};

use crate::arguments::Arguments;
use crate::figure::{self, RATE};
use crate::worn::Worn;

/// Distance between neighbours [m]: they never touch.
const APART: f32 = 2.0;
/// Where the camera is, before the first row [m].
const CAMERA: Vec3 = Vec3::new(0.0, 1.7, 3.0);
/// Fewest frames before those that are timed: a budget has a second.
const SETTLE: u32 = 60;
/// Frames after a change of detail in which what jumps does so for it.
const AFTER: u32 = 2;

/// Dresses a crowd and lets it move; what its clothes cost.
pub fn run(arguments: &Arguments) -> Result<Value, String> {
    let side = (arguments.characters as f32).sqrt().ceil().max(1.0) as u32;
    let places = (0..arguments.characters).map(|i| {
        let (x, z) = ((i % side) as f32 - 0.5 * (side - 1) as f32, -((i / side) as f32));
        Transform::from_xyz(APART * x, 0.0, APART * z)
    });
    let (mut app, bound) = figure::cast(arguments, places)?;
    app.world_mut().spawn((Camera3d::default(), Transform::from_translation(CAMERA)));
    let (mut worn, mut watch) = (Worn::default(), Watch::default());
    let mut state = SystemState::new(app.world_mut());
    for _ in 0..arguments.warm_up().max(SETTLE) {
        app.update();
        watch.look(&mut app, &mut state);
    }
    watch.forget();
    for frame in 1..=arguments.frames {
        app.update();
        worn.note(frame, &mut app);
        watch.look(&mut app, &mut state);
    }
    let mut line = Map::new();
    line.insert("scene".into(), "crowd".into());
    line.insert("outfit".into(), json!(arguments.outfit));
    line.insert("clip".into(), json!(arguments.clip));
    line.insert("characters".into(), arguments.characters.into());
    line.insert("threads".into(), arguments.threads.into());
    line.insert("budget_ms".into(), json!(arguments.budget));
    line.insert("bind_s".into(), bound.into());
    worn.describe(&mut app, &mut line);
    watch.describe(arguments.frames, &mut line);
    Ok(Value::Object(line))
}

/// What is asked of every cloth after a frame.
type Shown<'w, 's> =
    SystemState<(Query<'w, 's, (Entity, &'static ClothReport, &'static ClothParticles), With<Cloth>>, ClothSkinQuery<'w, 's>)>;

/// A cloth as it was.
#[derive(Default)]
struct Before {
    detail: ClothDetail,
    /// Frames since that changed.
    since: u32,
    shown: Vec<DVec3>,
    places: Vec<DVec3>,
    /// How far each particle went in the frame before [m].
    ways: Vec<f64>,
}

/// Watches levels of detail, and particles that jump.
#[derive(Default)]
struct Watch {
    cloths: EntityHashMap<Before>,
    levels: [u32; ClothDetail::ALL.len()],
    changes: u32,
    /// Fewest frames between two changes of one cloth.
    soonest: Option<u32>,
    /// Longest jumps [m]: where the detail had just changed, and elsewhere.
    jumps: [f64; 2],
}

impl Watch {
    /// Takes in the frame that is shown. A jump is how much farther a particle went than the skin beneath it and itself in the
    /// frame before.
    fn look(&mut self, app: &mut App, state: &mut Shown) {
        self.levels = default();
        let Ok((cloths, skins)) = state.get(app.world()) else { return };
        for (cloth, report, particles) in &cloths {
            self.levels[report.detail as usize] += 1;
            let shown: Vec<DVec3> = particles.shown_positions().collect();
            let places: Vec<DVec3> = skins.places(cloth).into_iter().flatten().collect();
            let before = self.cloths.entry(cloth).or_default();
            before.since += 1;
            if before.detail != report.detail {
                self.changes += 1;
                self.soonest = Some(self.soonest.map_or(before.since, |soonest| soonest.min(before.since)));
                (before.detail, before.since) = (report.detail, 0);
            }
            let ways: Vec<f64> = shown.iter().zip(&before.shown).map(|(now, then)| now.distance(*then)).collect();
            let kind = usize::from(before.since > AFTER);
            for (i, way) in ways.iter().enumerate() {
                let (Some(own), Some(now), Some(then)) = (before.ways.get(i), places.get(i), before.places.get(i)) else {
                    continue;
                };
                self.jumps[kind] = self.jumps[kind].max(way - own - now.distance(*then));
            }
            (before.shown, before.places, before.ways) = (shown, places, ways);
        }
    }

    /// Counts from now on.
    fn forget(&mut self) {
        (self.changes, self.soonest, self.jumps) = (0, None, [0.0; 2]);
    }

    fn describe(&self, frames: u32, line: &mut Map<String, Value>) {
        let levels =
            ClothDetail::ALL.iter().map(|detail| (format!("{detail:?}").to_lowercase(), json!(self.levels[*detail as usize])));
        line.insert("detail".into(), Value::Object(levels.collect()));
        let seconds = f64::from(frames) / f64::from(RATE);
        line.insert("changes_per_second".into(), json!(f64::from(self.changes) / seconds));
        line.insert("soonest_change_s".into(), json!(self.soonest.map(|frames| frames as f32 / RATE)));
        line.insert("jump_on_change".into(), json!(self.jumps[0]));
        line.insert("jump_elsewhere".into(), json!(self.jumps[1]));
    }
}
