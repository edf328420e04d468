//! The app, and the entities in it that have a number.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::ecs::resource::IsResource;
use bevy::mesh::skinning::SkinnedMeshInverseBindposes;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::{ClothPreset, ClothSnapshot};
use fastrand::Rng;

use super::headless::{self, Options};
use super::mirror::{self, Kind};
use super::plan::{Action, Plan, SLOTS, Setup, Step};
use super::{actors, clothes, deeds, physics, places};

/// An app under attack.
pub struct Stage {
    /// The app.
    pub app: App,
    /// Whether it runs in the fixed schedule.
    pub fixed: bool,
    /// Entities by number; none, or one that is gone.
    pub slots: [Option<Entity>; SLOTS],
    /// Whether avian moves bodies.
    pub physics: bool,
    /// Bodies of avian.
    pub bodies: Vec<Entity>,
    /// Joints and second cloths: despawned in the end.
    pub belongings: Vec<Entity>,
    /// Snapshots that were taken.
    pub snapshots: Vec<ClothSnapshot>,
    /// Meshes that the attack made: nobody says that they are finite.
    pub made: HashSet<AssetId<Mesh>>,
    /// Components.
    pub kinds: Vec<Kind>,
    /// Whether the clock of the machine decides something: then two runs differ.
    pub by_clock: bool,
    start: Counts,
}

/// What must not become more and more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Entities, without resources.
    pub entities: usize,
    /// Meshes.
    pub meshes: usize,
    /// Inverse bind poses of skins.
    pub skins: usize,
    /// Presets.
    pub presets: usize,
}

impl Counts {
    /// Of a world.
    pub fn of(world: &mut World) -> Self {
        let entities = world.query_filtered::<(), (Without<IsResource>, Allow<Disabled>)>().iter(world).count();
        let count = |n: Option<usize>| n.unwrap_or(0);
        Self {
            entities,
            meshes: count(world.get_resource::<Assets<Mesh>>().map(Assets::len)),
            skins: count(world.get_resource::<Assets<SkinnedMeshInverseBindposes>>().map(Assets::len)),
            presets: count(world.get_resource::<Assets<ClothPreset>>().map(Assets::len)),
        }
    }
}

impl Stage {
    /// An app of a plan.
    pub fn new(plan: &Plan, options: &Options) -> Self {
        let Setup { fixed, physics, .. } = plan.setup;
        // Nobody says that avian does the same twice.
        Self { fixed, physics, by_clock: physics, ..Self::of(headless::app(&plan.setup, options)) }
    }

    /// An app where nothing has happened yet.
    pub fn of(mut app: App) -> Self {
        let start = Counts::of(app.world_mut());
        let kinds = mirror::kinds(app.world());
        Self {
            app,
            fixed: false,
            slots: [None; SLOTS],
            physics: false,
            bodies: Vec::new(),
            belongings: Vec::new(),
            snapshots: Vec::new(),
            made: HashSet::default(),
            kinds,
            by_clock: false,
            start,
        }
    }

    /// The world.
    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// The entity of a number, if it is there.
    pub fn live(&self, slot: usize) -> Option<Entity> {
        self.slots[slot].filter(|entity| self.app.world().get_entity(*entity).is_ok())
    }

    /// That, or another entity that is there: a joint, or whatever comes first.
    pub fn some(&self, slot: usize) -> Entity {
        let first = || (0..SLOTS).find_map(|slot| self.live(slot));
        self.live(slot).or_else(first).unwrap_or(Entity::PLACEHOLDER)
    }

    /// Gives an entity a number; what had it is despawned.
    pub fn enter(&mut self, slot: usize, entity: Entity) {
        if let Some(before) = self.slots[slot].replace(entity) {
            self.world().try_despawn(before).ok();
        }
    }

    /// Adds a mesh that the attack made.
    pub fn add(&mut self, mesh: Mesh) -> Handle<Mesh> {
        let handle = self.world().resource_mut::<Assets<Mesh>>().add(mesh);
        self.made.insert(handle.id());
        handle
    }

    /// Does what is planned; says what it was.
    pub fn perform(&mut self, step: &Step) -> String {
        let rng = &mut Rng::with_seed(step.seed);
        let (slot, other) = (step.slot, step.other);
        match step.action {
            Action::Cloth => clothes::cloth(self, slot, other, false, rng),
            Action::Strange => clothes::cloth(self, slot, other, true, rng),
            Action::Tangle => clothes::tangle(self, slot, rng),
            Action::Skinned => clothes::skinned(self, slot, other, rng),
            Action::Character => actors::character(self, slot, rng),
            Action::Body if self.physics && rng.bool() => physics::body(self, rng),
            Action::Body => actors::body(self, slot, rng),
            Action::Thing => actors::thing(self, slot, other, rng),
            Action::Despawn => places::despawn(self, slot, rng),
            Action::Swap => deeds::swap(self, slot, other, rng),
            Action::Disable => places::disable(self, slot, rng),
            Action::Clone => places::clone(self, slot, other, rng),
            Action::Reparent => places::reparent(self, slot, other, rng),
            Action::Move => places::shift(self, slot, rng),
            Action::Dance => places::dance(self, slot, rng),
            Action::Scale => places::scale(self, slot, rng),
            Action::Nowhere => places::nowhere(self, slot, rng),
            Action::Put => deeds::put(self, slot, other, rng),
            Action::Take => deeds::take(self, slot, rng),
            Action::Poke => deeds::poke(self, slot, other, rng),
            Action::Method => deeds::method(self, slot, rng),
            Action::World => deeds::world(self, rng),
            Action::Clock => deeds::clock(self, rng),
            Action::State => deeds::state(self, slot, rng),
            Action::Kick => deeds::kick(self, slot, rng),
            Action::Ask => deeds::ask(self, slot, rng),
            Action::Snapshot => deeds::snapshot(self, slot, rng),
            Action::Bare => places::bare(self, slot),
            Action::Clear => self.clear(),
        }
    }

    /// Despawns everything.
    pub fn clear(&mut self) -> String {
        let slots = std::mem::take(&mut self.slots);
        let entities: Vec<Entity> =
            slots.into_iter().flatten().chain(self.belongings.drain(..)).chain(self.bodies.drain(..)).collect();
        for entity in entities {
            self.world().try_despawn(entity).ok();
        }
        self.snapshots.clear();
        "everything is despawned".into()
    }

    /// Despawns everything and says what is left of it after some frames.
    pub fn left(&mut self) -> Option<String> {
        self.clear();
        self.world().resource_mut::<Time<Virtual>>().unpause();
        self.world().resource_mut::<Time<Virtual>>().set_relative_speed(1.0);
        self.world().remove_resource::<ClothBudget>();
        headless::frame_length(&mut self.app, headless::FRAME);
        (0..4).for_each(|_| self.app.update());
        let left = Counts::of(self.app.world_mut());
        (left != self.start).then(|| format!("{left:?} are left of {:?}", self.start))
    }
}
