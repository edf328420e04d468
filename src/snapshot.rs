//! Snapshots: what decides the next frame of cloth, to go back to.

use bevy::math::Isometry3d;
use bevy::prelude::*;

use crate::components::{ClothContactEvents, ClothError, ClothImpulse, ClothPins, ClothReport, ClothStatus, ClothTouch};
use crate::groups::{ClothGroup, ClothGroups};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, ClothScratch, ClothShown};
use crate::solver::wind::Wind;
use crate::systems::colliders::ColliderBody;
use crate::systems::couple::CoupledBody;
use crate::systems::grab::Grip;
use crate::systems::inputs::WorldAir;
use crate::systems::sleep::Slumber;

/// The state of cloth between two frames: taken, kept, and gone back to as often as wanted. For rollback in a networked game, for a replay, to try
/// something and take it back.
///
/// It holds what the plugin keeps: particles and their velocities, folds, contacts, tangles, sleep, grips, reports, how far gusts have travelled, and
/// where bodies were in the last frame. What is the app's, the app restores: transforms, settings, the bodies of a physics engine, and time. Then the
/// frames that follow have the same bits as those that followed the first time. Take and restore between two updates, or in one exclusive system
/// that is not within [`ClothSystems`](crate::ClothSystems).
///
/// It lives in memory and is worth something in the world it was taken of only.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// #[derive(Resource)]
/// struct Before(ClothSnapshot);
///
/// fn take(world: &mut World) {
///     let before = ClothSnapshot::take(world);
///     world.insert_resource(Before(before));
/// }
///
/// fn go_back(world: &mut World) {
///     world.resource_scope(|world, before: Mut<Before>| {
///         if let Err(error) = before.0.restore(world) {
///             warn!("{error}");
///         }
///     });
/// }
/// ```
#[derive(Clone)]
pub struct ClothSnapshot {
    /// In the order of entities.
    cloths: Vec<SavedCloth>,
    groups: Vec<ClothGroup>,
    surroundings: Option<Surroundings>,
}

/// The cloths of a [`ClothSnapshot`] that [`ClothSnapshot::restore`] left as they are: despawned, waiting, failed, or bound to another mesh or scale since
/// then.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} cloths of the snapshot were despawned, failed, or have another mesh or scale now, and were left as they are: {cloths:?}", cloths.len())]
pub struct ClothSnapshotError {
    /// Those cloths, in the order of entities.
    pub cloths: Vec<Entity>,
}

#[derive(Clone)]
struct SavedCloth {
    entity: Entity,
    rest: ClothRest,
    particles: ClothParticles,
    inputs: ClothInputs,
    scratch: ClothScratch,
    slumber: Slumber,
    report: ClothReport,
    pins: ClothPins,
    touches: Vec<ClothTouch>,
}

/// What several cloths share.
#[derive(Clone)]
struct Surroundings {
    wind: Wind,
    colliders: Vec<(Entity, Option<Isometry3d>)>,
    coupled: Vec<(Entity, CoupledBody, ClothImpulse)>,
    grips: Vec<(Entity, Grip)>,
}

impl ClothSnapshot {
    /// Of every cloth that is simulated, and of what they share: gusts, bodies and grips.
    #[must_use]
    pub fn take(world: &mut World) -> Self {
        let surroundings = Surroundings {
            wind: world.resource::<WorldAir>().wind.clone(),
            colliders: world.query::<(Entity, &ColliderBody)>().iter(world).map(|(entity, body)| (entity, body.pose)).collect(),
            coupled: {
                let mut coupled = world.query::<(Entity, &CoupledBody, &ClothImpulse)>();
                coupled.iter(world).map(|(entity, body, impulse)| (entity, *body, *impulse)).collect()
            },
            grips: world.query::<(Entity, &Grip)>().iter(world).map(|(entity, grip)| (entity, grip.clone())).collect(),
        };
        Self { surroundings: Some(surroundings), ..Self::of(world, |_| true) }
    }

    /// Of these cloths alone. What they share with others stays as it is when it is restored; contacts with others are found anew then.
    #[must_use]
    pub fn take_of(world: &mut World, cloths: &[Entity]) -> Self {
        Self::of(world, |entity| cloths.contains(&entity))
    }

    fn of(world: &mut World, wanted: impl Fn(Entity) -> bool) -> Self {
        let mut query = world.query::<(
            Entity,
            &ClothRest,
            &ClothParticles,
            &ClothInputs,
            &ClothScratch,
            &Slumber,
            &ClothReport,
            &ClothPins,
            &ClothStatus,
            Option<&ClothContactEvents>,
        )>();
        let mut cloths: Vec<SavedCloth> = query
            .iter(world)
            .filter(|(entity, .., status, _)| wanted(*entity) && **status == ClothStatus::Active)
            .map(|(entity, rest, particles, inputs, scratch, slumber, report, pins, _, events)| SavedCloth {
                entity,
                rest: rest.clone(),
                particles: particles.clone(),
                inputs: inputs.clone(),
                scratch: scratch.clone(),
                slumber: slumber.clone(),
                report: report.clone(),
                pins: pins.clone(),
                touches: events.map_or_else(Vec::new, |events| events.touches.clone()),
            })
            .collect();
        cloths.sort_unstable_by_key(|cloth| cloth.entity);
        let groups = &world.resource::<ClothGroups>().list;
        let groups = groups.iter().filter(|group| group.members.iter().all(|m| find(&cloths, m.entity).is_some())).cloned();
        Self { groups: groups.collect(), cloths, surroundings: None }
    }

    /// The cloths in it, in the order of entities.
    pub fn cloths(&self) -> impl Iterator<Item = Entity> + '_ {
        self.cloths.iter().map(|cloth| cloth.entity)
    }

    /// Puts its cloths back. Cloths that are not in it stay as they are, and so does what was spawned since; no event is sent.
    ///
    /// # Errors
    /// [`ClothSnapshotError`] names the cloths that could not be put back; all others were.
    pub fn restore(&self, world: &mut World) -> Result<(), ClothSnapshotError> {
        let (known, lost): (Vec<&SavedCloth>, Vec<_>) = self.cloths.iter().partition(|cloth| cloth.fits(world));
        for cloth in &known {
            cloth.restore(world);
        }
        if let Some(surroundings) = &self.surroundings {
            surroundings.restore(world);
        }
        let is_known = |entity: Entity| known.binary_search_by_key(&entity, |cloth| cloth.entity).is_ok();
        let mut groups = world.resource_mut::<ClothGroups>();
        groups.list.retain(|group| !group.members.iter().any(|member| is_known(member.entity)));
        groups.list.extend(self.groups.iter().filter(|group| group.members.iter().all(|m| is_known(m.entity))).cloned());
        groups.list.sort_by_key(|group| group.members.first().map(|member| member.entity));
        let places: Vec<(Entity, (u32, u32))> = (0..)
            .zip(&groups.list)
            .flat_map(|(group, list)| (0..).zip(&list.members).map(move |(part, member)| (member.entity, (group, part))))
            .collect();
        for mut scratch in world.query::<&mut ClothScratch>().iter_mut(world) {
            scratch.group = None;
        }
        for (entity, place) in places {
            if let Some(mut scratch) = world.get_mut::<ClothScratch>(entity) {
                scratch.group = Some(place);
            }
        }
        if lost.is_empty() {
            Ok(())
        } else {
            Err(ClothSnapshotError { cloths: lost.iter().map(|cloth| cloth.entity).collect() })
        }
    }
}

impl core::fmt::Debug for ClothSnapshot {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("ClothSnapshot").field("cloths", &self.cloths().collect::<Vec<_>>()).finish_non_exhaustive()
    }
}

fn find(cloths: &[SavedCloth], entity: Entity) -> Option<&SavedCloth> {
    cloths.binary_search_by_key(&entity, |cloth| cloth.entity).ok().map(|at| &cloths[at])
}

impl SavedCloth {
    /// Whether the cloth is still there, simulated, and of the same shape at rest.
    fn fits(&self, world: &World) -> bool {
        world.get_entity(self.entity).is_ok_and(|cloth| {
            cloth.get::<ClothRest>().is_some_and(|rest| rest.is_shared_with(&self.rest))
                && cloth.get::<ClothStatus>() == Some(&ClothStatus::Active)
                && cloth.contains::<ClothParticles>()
                && !cloth.contains::<ClothError>()
        })
    }

    fn restore(&self, world: &mut World) {
        let mut cloth = world.entity_mut(self.entity);
        put(&mut cloth, &self.particles);
        put(&mut cloth, &self.inputs);
        put(&mut cloth, &self.scratch);
        put(&mut cloth, &self.slumber);
        put(&mut cloth, &self.report);
        // Other pins are bound anew, to the cloth as it was.
        if let Some(mut pins) = cloth.get_mut::<ClothPins>().filter(|pins| **pins != self.pins) {
            pins.set_changed();
        }
        if let Some(mut shown) = cloth.get_mut::<ClothShown>() {
            (shown.forced, shown.still) = (true, false);
        }
        if let Some(mut events) = cloth.get_mut::<ClothContactEvents>() {
            events.touches.clone_from(&self.touches);
        }
    }
}

impl Surroundings {
    fn restore(&self, world: &mut World) {
        world.resource_mut::<WorldAir>().wind.clone_from(&self.wind);
        for (entity, pose) in &self.colliders {
            if let Some(mut body) = world.get_mut::<ColliderBody>(*entity) {
                body.pose = *pose;
            }
        }
        for (entity, body, impulse) in &self.coupled {
            let Ok(mut entity) = world.get_entity_mut(*entity) else { continue };
            put(&mut entity, body);
            put(&mut entity, impulse);
        }
        for (entity, grip) in &self.grips {
            if let Ok(mut entity) = world.get_entity_mut(*entity) {
                put(&mut entity, grip);
            }
        }
    }
}

fn put<T: Component<Mutability = bevy::ecs::component::Mutable> + Clone>(entity: &mut EntityWorldMut, value: &T) {
    if let Some(mut now) = entity.get_mut::<T>() {
        now.clone_from(value);
    }
}
