//! One character in her clothes.

use bevy::prelude::*;
use bevy_drape::ClothCollider;
use serde_json::{Map, Value, json};

use crate::arguments::Arguments;
use crate::figure;
use crate::worn::Worn;

/// Fewest frames before those that are timed: clothes fall into shape.
const SETTLE: u32 = 60;

/// Dresses a character and lets her move; what her clothes cost.
pub fn run(arguments: &Arguments) -> Result<Value, String> {
    let (mut app, bound) = figure::cast(arguments, [Transform::IDENTITY].into_iter())?;
    (0..arguments.warm_up().max(SETTLE)).for_each(|_| app.update());
    let mut worn = Worn::default();
    for frame in 1..=arguments.frames {
        app.update();
        worn.note(frame, &mut app);
    }
    let mut line = Map::new();
    line.insert("scene".into(), "character".into());
    line.insert("outfit".into(), json!(arguments.outfit));
    line.insert("clip".into(), json!(arguments.clip));
    line.insert("threads".into(), arguments.threads.into());
    let mut colliders = app.world_mut().query_filtered::<(), With<ClothCollider>>();
    line.insert("colliders".into(), colliders.iter(app.world()).count().into());
    line.insert("bind_s".into(), bound.into());
    worn.describe(&mut app, &mut line);
    Ok(Value::Object(line))
}
