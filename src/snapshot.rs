//! Snapshots: what decides the next frame of cloth, to go back to.

use bevy::ecs::world::WorldId;
use bevy::math::{DVec3, Isometry3d};
use bevy::prelude::*;

use crate::components::fitted::{ColliderBody, CoupledBody};
use crate::components::grip::Grip;
use crate::components::{ClothContacts, ClothError, ClothPins, ClothReaction, ClothReport, ClothStatus};
use crate::islands::{ClothIsland, ClothIslands};
use crate::simulation::{
    Binding, ClothInputs, ClothParticles, ClothRest, ClothShown, IslandPlace, Slumber, WaitingSince, WorldAir,
};
use crate::solver::wind::Wind;
use crate::systems::skin::exchange;
use crate::time::ClothTime;

/// The state of cloth between two frames: captured, kept, and gone back to as often as wanted. For rollback in a networked
/// game, for a replay, to try something and take it back.
///
/// It holds what the plugin keeps: particles and their velocities, folds, contacts, tangles, sleep, what grips hold, and
/// reports. It also holds how far gusts have travelled, and where bodies were in the last frame. The app restores what is its
/// own: transforms and parents, settings, grips ([`ClothGrab`](crate::ClothGrab)), the bodies of a physics engine, and time.
/// Then the frames that follow have the same bits as those that followed the first time. Write only what differs
/// ([`set_if_neq`](bevy::prelude::DetectChangesMut::set_if_neq)): cloth that sleeps wakes when a setting is written. It does
/// not hold what cameras saw, nor what frames will cost: do without `ClothLod` and `ClothBudget` where bits matter.
///
/// Capture and restore between two updates, or in an exclusive system before
/// [`ClothSystems::Prepare`](crate::ClothSystems::Prepare) or after [`ClothSystems::Sync`](crate::ClothSystems::Sync). A
/// snapshot lives in memory, and only the world it is of can be restored from it; for save games there is
/// [`ClothPose`](crate::ClothPose).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// #[derive(Resource)]
/// struct Before(ClothSnapshot);
///
/// fn capture(world: &mut World) {
///     let before = ClothSnapshot::capture(world);
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
    islands: Vec<ClothIsland>,
    surroundings: Option<Surroundings>,
    world: WorldId,
}

/// The cloths of a [`ClothSnapshot`] that [`ClothSnapshot::restore`] left as they are: despawned, bound to another mesh or
/// scale since then, or of another world.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "left as they are: {cloths:?}, which were despawned since the snapshot, have another mesh or scale, or are of another world"
)]
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
    place: IslandPlace,
    slumber: Slumber,
    report: ClothReport,
    contacts: ClothContacts,
    /// Whether it had faded into its skin.
    on_skin: bool,
    /// What queries see, and its origin `[m]`.
    shown: (Vec<Vec3>, DVec3),
}

/// What several cloths share.
#[derive(Clone)]
struct Surroundings {
    time: ClothTime,
    wind: Wind,
    colliders: Vec<(Entity, Option<Isometry3d>)>,
    coupled: Vec<(Entity, CoupledBody, ClothReaction)>,
    grips: Vec<(Entity, Grip)>,
    #[cfg(feature = "avian")]
    physics: crate::avian::Seen,
}

impl ClothSnapshot {
    /// Of every cloth that is simulated, and of what they share: gusts, bodies and grips. Cloth that waits or failed is not in
    /// it. Empty without [`ClothPlugin`](crate::ClothPlugin).
    #[must_use]
    pub fn capture(world: &mut World) -> Self {
        Self { surroundings: Surroundings::of(world), ..Self::of(world, |_| true) }
    }

    /// Of those of these entities that are cloth that is simulated. What they share with others stays as it is when it is
    /// restored; contacts with others are found anew then.
    #[must_use]
    pub fn capture_of(world: &mut World, cloths: &[Entity]) -> Self {
        Self::of(world, |entity| cloths.contains(&entity))
    }

    fn of(world: &mut World, wanted: impl Fn(Entity) -> bool) -> Self {
        let mut query = world.query::<(
            Entity,
            &ClothRest,
            &ClothParticles,
            &ClothInputs,
            &IslandPlace,
            &Slumber,
            &ClothReport,
            &ClothShown,
            &ClothStatus,
            Option<&Binding>,
            Option<&ClothContacts>,
        )>();
        let mut cloths: Vec<SavedCloth> = query
            .iter(world)
            .filter(|(entity, .., status, _, _)| wanted(*entity) && **status == ClothStatus::Active)
            .map(|(entity, rest, particles, inputs, place, slumber, report, shown, _, binding, contacts)| SavedCloth {
                entity,
                rest: rest.clone(),
                particles: particles.clone(),
                inputs: inputs.clone(),
                place: place.clone(),
                slumber: slumber.clone(),
                report: report.clone(),
                contacts: contacts.cloned().unwrap_or_default(),
                on_skin: binding.is_some_and(|binding| binding.on_skin),
                shown: (shown.particles.clone(), shown.origin),
            })
            .collect();
        cloths.sort_unstable_by_key(|cloth| cloth.entity);
        let is_saved = |entity: Entity| cloths.binary_search_by_key(&entity, |cloth| cloth.entity).is_ok();
        let islands = world.get_resource::<ClothIslands>().map_or(&[][..], |islands| &islands.list);
        // What is under way in the background has the contacts of its island: they are found anew.
        let islands = islands.iter().filter(|island| island.is_built() && island.members.iter().all(|m| is_saved(m.entity)));
        let islands = islands.cloned().collect();
        Self { islands, cloths, surroundings: None, world: world.id() }
    }

    /// The cloths in it, in the order of entities.
    pub fn cloths(&self) -> impl Iterator<Item = Entity> + '_ {
        self.cloths.iter().map(|cloth| cloth.entity)
    }

    /// Puts its cloths back, those that failed since, too. Cloths that are not in it stay as they are, and so does what was
    /// spawned since; no event is sent.
    ///
    /// # Errors
    /// [`ClothSnapshotError`] names the cloths that could not be put back; all others were.
    pub fn restore(&self, world: &mut World) -> Result<(), ClothSnapshotError> {
        let is_here = world.id() == self.world;
        let (known, lost): (Vec<&SavedCloth>, Vec<_>) = self.cloths.iter().partition(|cloth| is_here && cloth.fits(world));
        for cloth in &known {
            cloth.restore(world);
        }
        if let Some(surroundings) = self.surroundings.as_ref().filter(|_| is_here) {
            surroundings.restore(world);
        }
        self.regroup(world, |entity| known.binary_search_by_key(&entity, |cloth| cloth.entity).is_ok());
        if lost.is_empty() {
            Ok(())
        } else {
            Err(ClothSnapshotError { cloths: lost.iter().map(|cloth| cloth.entity).collect() })
        }
    }

    /// Puts the islands back all of whose members were restored, in place of those in which any was.
    fn regroup(&self, world: &mut World, is_restored: impl Fn(Entity) -> bool) {
        let Some(mut islands) = world.get_resource_mut::<ClothIslands>() else { return };
        islands.list.retain(|island| !island.members.iter().any(|member| is_restored(member.entity)));
        islands.list.extend(self.islands.iter().filter(|island| island.members.iter().all(|m| is_restored(m.entity))).cloned());
        islands.list.sort_by_key(|island| island.members.first().map(|member| member.entity));
        let mut places: Vec<(Entity, (u32, u32))> = (0..)
            .zip(&islands.list)
            .flat_map(|(island, list)| (0..).zip(&list.members).map(move |(part, member)| (member.entity, (island, part))))
            .collect();
        places.sort_unstable();
        for (entity, mut place, mut slumber) in world.query::<(Entity, &mut IslandPlace, &mut Slumber)>().iter_mut(world) {
            let island = places.binary_search_by_key(&entity, |(entity, _)| *entity).ok().map(|at| places[at].1);
            // What it rested on may be gone.
            slumber.roused |= place.island.is_some() && island.is_none();
            place.island = island;
        }
    }
}

impl core::fmt::Debug for ClothSnapshot {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("ClothSnapshot").field("cloths", &self.cloths().collect::<Vec<_>>()).finish_non_exhaustive()
    }
}

impl SavedCloth {
    /// Whether the cloth is still there, and of the same shape at rest.
    fn fits(&self, world: &World) -> bool {
        world.get_entity(self.entity).is_ok_and(|cloth| {
            cloth.get::<ClothRest>().is_some_and(|rest| rest.is_shared_with(&self.rest)) && cloth.contains::<ClothParticles>()
        })
    }

    fn restore(&self, world: &mut World) {
        let mut cloth = world.entity_mut(self.entity);
        cloth.remove::<(ClothError, WaitingSince)>();
        if cloth.get::<Binding>().is_some_and(|binding| binding.on_skin != self.on_skin) {
            exchange(&mut cloth, self.on_skin);
        }
        put(&mut cloth, &ClothStatus::Active);
        put(&mut cloth, &self.particles);
        put(&mut cloth, &self.inputs);
        put(&mut cloth, &self.place);
        put(&mut cloth, &self.slumber);
        put(&mut cloth, &self.report);
        put(&mut cloth, &self.contacts);
        // Other pins than these are bound anew, to the cloth as it was.
        if let Some(mut pins) = cloth.get_mut::<ClothPins>().filter(|pins| **pins != self.inputs.pins) {
            pins.set_changed();
        }
        if let Some(mut shown) = cloth.get_mut::<ClothShown>() {
            shown.particles.clone_from(&self.shown.0);
            shown.origin = self.shown.1;
            (shown.forced, shown.still) = (true, false);
        }
    }
}

impl Surroundings {
    fn of(world: &mut World) -> Option<Self> {
        let (time, wind) = (*world.get_resource::<ClothTime>()?, world.get_resource::<WorldAir>()?.wind.clone());
        let mut coupled = world.query::<(Entity, &CoupledBody, &ClothReaction)>();
        Some(Self {
            time,
            wind,
            colliders: world.query::<(Entity, &ColliderBody)>().iter(world).map(|(entity, body)| (entity, body.pose)).collect(),
            coupled: coupled.iter(world).map(|(entity, body, reaction)| (entity, *body, *reaction)).collect(),
            grips: world.query::<(Entity, &Grip)>().iter(world).map(|(entity, grip)| (entity, grip.clone())).collect(),
            #[cfg(feature = "avian")]
            physics: world.get_resource::<crate::avian::Seen>().copied().unwrap_or_default(),
        })
    }

    fn restore(&self, world: &mut World) {
        world.insert_resource(self.time);
        #[cfg(feature = "avian")]
        world.insert_resource(self.physics);
        if let Some(mut air) = world.get_resource_mut::<WorldAir>() {
            air.wind.clone_from(&self.wind);
        }
        for (entity, pose) in &self.colliders {
            if let Some(mut body) = world.get_mut::<ColliderBody>(*entity) {
                body.pose = *pose;
            }
        }
        for (entity, body, reaction) in &self.coupled {
            let Ok(mut entity) = world.get_entity_mut(*entity) else { continue };
            put(&mut entity, body);
            put(&mut entity, reaction);
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
