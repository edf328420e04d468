//! Recordings: frames of cloth written to files, to be stepped again by another program.

use std::fs::File;
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};

use bevy::ecs::query::QueryData;
use bevy::math::DVec3;
use bevy::prelude::*;

use crate::components::{Cloth, ClothCollision, ClothFailed, ClothHeld, ClothRecovered};
use crate::islands::{ClothIsland, ClothIslands};
use crate::schedule::{self, ClothSystems};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace};
use crate::solver::detect::PartSettings;
use crate::solver::evaluate::Pose;
use crate::solver::recording::{RecordedCloth, Recording, RecordingError};
use crate::solver::skinned::Skinned;
use crate::systems::detect;
use crate::time::{self, ClothTime};

/// Records frames of cloth: those that were held, those in which a cloth blew up or failed, and those that are asked for. A
/// file holds all that decided the frame: send it along with a report of a bug. The program `stress --replay FILE`, or
/// [`Recording::replay`](crate::solver::recording::Recording::replay), steps it again with the same bits.
///
/// While it is there, every frame is kept until it is over, which costs a copy of all cloth. Add it after
/// [`ClothPlugin`](crate::ClothPlugin), to the schedule that that runs in.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn add(app: &mut App) {
/// app.add_plugins(ClothRecorderPlugin);
/// app.insert_resource(ClothRecorder { folder: "recordings".into(), ..default() });
/// # }
/// ```
#[derive(Default)]
pub struct ClothRecorderPlugin;

/// Settings of the recorder: which frames, and where to.
#[derive(Resource, Clone, Debug)]
pub struct ClothRecorder {
    /// The folder of the files; it is made. Default `cloth_recordings`.
    pub folder: PathBuf,
    /// Whether frames are recorded in which a cloth begins to be held. Default true.
    pub held: bool,
    /// Whether frames are recorded in which a cloth blew up or failed. Default true.
    pub recovered: bool,
    /// Most files that are written. Default 16.
    pub most: u32,
    /// Cloths of which a frame is recorded, whatever happens. It is the next in which they move, keep their scale, and meet no
    /// others than in the frame before. No frame in the background is recorded.
    pub next: Vec<Entity>,
}

/// Files that [`ClothRecorder`] wrote.
#[derive(Resource, Clone, Debug, Default)]
pub struct ClothRecordings {
    /// The files that were written.
    pub written: Vec<PathBuf>,
    /// Why a file could not be written. No more files are written until this is taken away.
    pub error: Option<String>,
}

impl Default for ClothRecorder {
    fn default() -> Self {
        Self { folder: "cloth_recordings".into(), held: true, recovered: true, most: 16, next: Vec::new() }
    }
}

/// Why a frame is recorded that is in [`ClothRecorder::next`].
const ASKED_FOR: &str = "asked for";

/// The frame under way.
#[derive(Resource, Default)]
struct UnderWay {
    frames: Vec<(Vec<Entity>, Recording, DVec3)>,
    /// Cloths of which something is to be written, and why.
    wanted: Vec<(Entity, &'static str)>,
}

impl Plugin for ClothRecorderPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ClothRecorder>()
            .init_resource::<ClothRecordings>()
            .init_resource::<UnderWay>()
            .add_observer(|on: On<ClothHeld>, recorder: Res<ClothRecorder>, mut frame: ResMut<UnderWay>| {
                if recorder.held {
                    frame.wanted.push((on.entity, "held"));
                }
            })
            .add_observer(|on: On<ClothRecovered>, recorder: Res<ClothRecorder>, mut frame: ResMut<UnderWay>| {
                if recorder.recovered {
                    frame.wanted.push((on.entity, "recovered"));
                }
            })
            .add_observer(|on: On<ClothFailed>, recorder: Res<ClothRecorder>, mut frame: ResMut<UnderWay>| {
                if recorder.recovered {
                    frame.wanted.push((on.entity, "failed"));
                }
            });
    }

    fn finish(&self, app: &mut App) {
        let schedule = schedule::of(app);
        app.add_systems(
            schedule,
            (
                begin.run_if(time::flows).after(ClothSystems::Prepare).before(ClothSystems::Integrate),
                record_islands
                    .run_if(time::flows)
                    .in_set(ClothSystems::Detect)
                    .after(detect::form_islands)
                    .before(detect::detect),
                end.run_if(time::flows).after(ClothSystems::Respond).before(ClothSystems::Sync),
            ),
        );
    }
}

/// A cloth whose frames can be recorded.
#[derive(QueryData)]
struct Recordable {
    entity: Entity,
    name: Option<&'static Name>,
    rest: &'static ClothRest,
    inputs: &'static ClothInputs,
    particles: &'static ClothParticles,
    place: &'static IslandPlace,
}

type Cloths<'w, 's> = Query<'w, 's, Recordable, With<Cloth>>;

/// Keeps what every cloth is before the frame.
fn begin(time: Res<ClothTime>, islands: Res<ClothIslands>, mut frame: ResMut<UnderWay>, cloths: Cloths) {
    let dt = time.delta_secs();
    frame.frames.clear();
    let recording = |cloths: Vec<RecordedCloth>| Recording {
        reason: String::new(),
        cloths,
        island: None,
        together: false,
        untangle: default(),
        carried: Vec3::ZERO,
        dt,
    };
    for island in islands.list.iter().filter(|island| !island.asleep) {
        let entities: Vec<Entity> = island.members.iter().map(|member| member.entity).collect();
        let members: Vec<_> = entities.iter().filter_map(|&entity| cloths.get(entity).ok()).collect();
        // The island of a cloth whose scale changed, or that was bound anew, is still that of what it was.
        let seen = island.members.iter().zip(&members);
        if members.len() != entities.len()
            || !seen.into_iter().all(|(seen, now)| seen.is_as_seen(now.rest, now.particles, now.place))
            || members.iter().any(|cloth| cloth.inputs.background)
        {
            continue;
        }
        let together = island.has_contact();
        let members = members.into_iter().map(|cloth| cloth.record(island.origin, dt)).collect();
        let kept = Recording { island: Some(island.solver.clone()), together, untangle: island.settings, ..recording(members) };
        frame.frames.push((entities, kept, island.origin));
    }
    let is_alone = |cloth: &RecordableItem| {
        cloth.inputs.active && !cloth.inputs.asleep && !cloth.inputs.background && cloth.place.island.is_none()
    };
    for cloth in cloths.iter().filter(is_alone) {
        let origin = cloth.particles.origin;
        frame.frames.push((vec![cloth.entity], recording(vec![cloth.record(origin, dt)]), origin));
    }
}

impl RecordableItem<'_, '_> {
    /// The cloth before its frame of `dt` `[s]`, `origin` where its island is, or the cloth itself, in the world `[m]`.
    fn record(&self, origin: DVec3, dt: f32) -> RecordedCloth {
        let &Self { entity, name, rest, inputs, particles, .. } = self;
        let carrier = inputs.carrier();
        let translation = (Vec3::from(carrier.translation).as_dvec3() - particles.origin).as_vec3();
        let offset = (particles.origin - origin).as_vec3();
        RecordedCloth {
            name: name.map_or_else(|| entity.to_string(), |name| name.as_str().to_owned()),
            rest: rest.0.clone(),
            fabric: inputs.fabric.clone(),
            stepping: inputs.stepping.clone(),
            anchors: inputs.anchors.clone(),
            gravity: inputs.gravity,
            bodies: inputs.bodies.clone(),
            wind: inputs.wind.clone(),
            skinned: Some(inputs.skinned.clone()).filter(Skinned::is_active),
            sim: particles.sim.clone(),
            evaluate: inputs.evaluate,
            limits: inputs.limits,
            pose: inputs.pose(&rest.0, particles.origin).collect(),
            animated: inputs.skin.is_some(),
            stale: inputs.stale,
            carrier: Pose { translation, rotation: carrier.rotation },
            offsets: [offset; 2],
            settings: PartSettings { thickness: inputs.fabric.thickness, ..default() },
            written: particles.written,
            moves: inputs.moves(&particles.sim.recovery),
            clock: dt * inputs.time_scale,
            fixed: false,
            still: false,
            contact: false,
            at_load: false,
            after: Vec::new(),
        }
    }
}

/// Keeps what changed in the islands since the cloths were stepped; what meets others than before cannot be stepped again, and
/// is dropped.
fn record_islands(islands: Res<ClothIslands>, mut frame: ResMut<UnderWay>, cloths: Cloths) {
    frame.frames.retain_mut(|(entities, recording, origin)| {
        let mine = |island: &&ClothIsland| island.members.iter().any(|member| entities.contains(&member.entity));
        let Some(island) = islands.list.iter().find(mine) else { return recording.island.is_none() };
        let same = island.members.iter().map(|member| member.entity).eq(entities.iter().copied());
        if !same || recording.island.is_none() || island.built {
            return false;
        }
        recording.carried = (*origin - island.origin).as_vec3();
        recording.untangle = island.settings;
        for (member, cloth) in island.members.iter().zip(&mut recording.cloths) {
            let collision = member.collision;
            if let Ok(now) = cloths.get(member.entity) {
                cloth.offsets[1] = (now.particles.origin - island.origin).as_vec3();
            }
            let ClothCollision { garment_layer, self_collision, .. } = collision;
            cloth.settings = PartSettings { garment_layer, self_collision, thickness: member.thickness };
            (cloth.fixed, cloth.still) = (member.fixed, member.still);
            (cloth.contact, cloth.at_load) = (collision.contact, member.at_load);
        }
        true
    });
}

/// Writes what is wanted of the frame.
fn end(
    mut recorder: ResMut<ClothRecorder>,
    mut recordings: ResMut<ClothRecordings>,
    mut frame: ResMut<UnderWay>,
    cloths: Query<&ClothParticles, With<Cloth>>,
) {
    let next = core::mem::take(&mut recorder.bypass_change_detection().next);
    let mut wanted = core::mem::take(&mut frame.bypass_change_detection().wanted);
    wanted.extend(next.into_iter().map(|entity| (entity, ASKED_FOR)));
    // Cloths that meet are one frame, and one file.
    let mut recorded: Vec<Entity> = Vec::new();
    for (entity, reason) in wanted {
        if recorded.contains(&entity) {
            continue;
        }
        let Some(at) = frame.frames.iter().position(|(entities, ..)| entities.contains(&entity)) else {
            if reason == ASKED_FOR && cloths.contains(entity) {
                recorder.bypass_change_detection().next.push(entity);
            }
            continue;
        };
        let (entities, mut recording, _) = frame.frames.swap_remove(at);
        recorded.extend(&entities);
        if recordings.error.is_some() || recordings.written.len() >= recorder.most as usize {
            continue;
        }
        recording.reason = reason.to_owned();
        for (cloth, entity) in recording.cloths.iter_mut().zip(entities) {
            cloth.after = cloths.get(entity).map_or_else(|_| Vec::new(), |particles| particles.sim.state.positions.clone());
        }
        match write(&recording, &recorder.folder) {
            Ok(path) => {
                info!("a frame of cloth that was {reason} is in {}", path.display());
                recordings.written.push(path);
            }
            Err(error) => {
                let folder = recorder.folder.display();
                warn!(
                    "no frame was written to {folder} ({error}), and no more are: set `ClothRecorder::folder`, and take `ClothRecordings::error` away"
                );
                recordings.error = Some(error.to_string());
            }
        }
    }
}

/// Writes to a file of its own, whatever earlier runs left in the folder.
fn write(recording: &Recording, folder: &Path) -> Result<PathBuf, RecordingError> {
    std::fs::create_dir_all(folder)?;
    for number in 0u32.. {
        let path = folder.join(format!("{number:04}_{}.drape", recording.reason.replace(' ', "_")));
        match File::create_new(&path) {
            Ok(file) => {
                return match recording.write(BufWriter::new(file)) {
                    Ok(()) => Ok(path),
                    Err(error) => {
                        std::fs::remove_file(&path).ok();
                        Err(error)
                    }
                };
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error.into()),
        }
    }
    Err(RecordingError::Io(ErrorKind::AlreadyExists.into()))
}
