//! What is wrong with skinned cloth, clip by clip: lines for who makes clothes, and JSON.

use std::time::Instant;

use bevy::ecs::system::SystemState;
use bevy::prelude::*;
use bevy_drape::ClothSolver;
use serde_json::{Value, json};

use crate::clip::{Asked, Clip};
use crate::frames::{describe, unwritable};
use crate::{Arguments, lines, maps, scene};

/// Plays every clip that was asked for, each from the start, and tells of them.
pub fn report(arguments: &Arguments) -> Result<(), String> {
    let known = scene::clips(arguments);
    let asked = if arguments.clip.is_empty() { &known } else { &arguments.clip };
    if let Some(clip) = asked.iter().find(|clip| !known.contains(clip)) {
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        return Err(format!("{} has no clip `{clip}`, only {known}", arguments.scene.display()));
    }
    // A file without clips is looked at, too.
    let asked: Vec<Option<&str>> =
        if asked.is_empty() { vec![None] } else { asked.iter().map(|clip| Some(clip.as_str())).collect() };
    std::fs::create_dir_all(&arguments.out).map_err(|error| unwritable(&arguments.out, &error))?;
    let (mut frames, mut clips, mut painted) = (Vec::new(), Vec::new(), Vec::new());
    for (number, clip) in asked.into_iter().enumerate() {
        let mut app = scene::app(arguments, number == 0)?;
        scene::load(&mut app, &arguments.scene, clip)?;
        let rate = arguments.substep_rate.unwrap_or(ClothSolver::default().substep_rate);
        scene::refine(&mut app, rate, arguments.method);
        let names = scene::names(&mut app);
        if number == 0 {
            painted = names.iter().map(|(&cloth, name)| maps::judge(&app, cloth, name)).collect();
            painted.iter().for_each(lines::maps);
        }
        scene::start(&mut app);
        let clip = clip.unwrap_or("no clip");
        let mut looks: Vec<Clip> = names.iter().map(|(&cloth, name)| Clip::new(cloth, name, clip)).collect();
        for frame in 1..=arguments.frames {
            let begin = Instant::now();
            (0..scene::updates(arguments.fps)).for_each(|_| app.update());
            let elapsed = begin.elapsed().as_secs_f64() * 1.0e3;
            let mut line = describe(&mut app, &names, frame, elapsed);
            line["clip"] = clip.into();
            frames.push(line);
            look(&mut app, &mut looks, frame, arguments.fps);
        }
        for look in looks {
            let look = look.describe();
            lines::clip(&look);
            clips.push(look);
        }
    }
    let path = arguments.out.join("report.json");
    let report: Value = json!({ "fps": arguments.fps, "maps": painted, "clips": clips, "frames": frames });
    std::fs::write(&path, format!("{report:#}\n")).map_err(|error| unwritable(&path, &error))
}

fn look(app: &mut App, looks: &mut [Clip], frame: u32, fps: f64) {
    let mut state: SystemState<Asked> = SystemState::new(app.world_mut());
    if let Ok(asked) = state.get(app.world()) {
        looks.iter_mut().for_each(|look| look.look(&asked, frame, fps));
    }
}
