//! Everything the panel can change, read from the world and written back part by part.

use bevy::prelude::*;

use super::part::Part;
use super::wearer;
use crate::components::{
    ClothBlend, ClothBody, ClothBudget, ClothCollision, ClothDrive, ClothGlobalWind, ClothGravity, ClothInertia, ClothLimits,
    ClothLod, ClothMaterial, ClothPins, ClothPriority, ClothSkipFrame, ClothSleep, ClothSleepDisabled, ClothSolver,
    ClothUntangling, ClothUntanglingDisabled, ClothWind,
};
use crate::presets::ClothPreset;

/// Everything the panel can change for one cloth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClothSettings {
    /// What it is made of.
    pub material: ClothMaterial,
    /// How it is simulated.
    pub solver: ClothSolver,
    /// What it meets.
    pub collision: ClothCollision,
    /// How it is taken apart.
    pub untangle: ClothUntangling,
    /// Whether it has [`ClothUntanglingDisabled`].
    pub untangling_disabled: bool,
    /// What is shown meanwhile.
    pub skip: ClothSkipFrame,
    /// When it is left alone.
    pub sleep: ClothSleep,
    /// Whether it has [`ClothSleepDisabled`].
    pub sleep_disabled: bool,
    /// How far it may be from the skin; without, as far as it goes.
    pub limits: Option<ClothLimits>,
    /// How firmly it is drawn to the skin; without, not at all.
    pub drive: Option<ClothDrive>,
    /// How much of it is simulated.
    pub blend: ClothBlend,
    /// How much it feels of the motion of what carries it; without, all.
    pub inertia: Option<ClothInertia>,
    /// The body of the character that wears it; without, there is none.
    pub body: Option<ClothBody>,
    /// What it costs far away; without, as much as near.
    pub lod: Option<ClothLod>,
    /// How much it matters to the budget.
    pub priority: ClothPriority,
    /// Its own wind; without, that of the world.
    pub own_wind: Option<ClothWind>,
    /// Where it is held.
    pub pins: ClothPins,
    /// Wind in the world.
    pub wind: ClothGlobalWind,
    /// Gravity in the world.
    pub gravity: ClothGravity,
    /// What all cloths may cost; without, what they cost.
    pub budget: Option<ClothBudget>,
}

impl ClothSettings {
    /// Every setting at its default, those of a wind of its own included.
    pub(super) fn defaults() -> Self {
        Self { own_wind: Some(ClothWind::default()), ..Self::default() }
    }

    /// Reads a cloth; none when the entity is no cloth. What is not on it counts as its default.
    #[must_use]
    pub fn read(world: &World, cloth: Entity) -> Option<Self> {
        fn part<T: Component + Clone + Default>(of: &EntityRef<'_>) -> T {
            of.get::<T>().cloned().unwrap_or_default()
        }
        let entity = world.get_entity(cloth).ok()?;
        entity.contains::<crate::Cloth>().then(|| Self {
            material: part(&entity),
            solver: part(&entity),
            collision: part(&entity),
            untangle: part(&entity),
            untangling_disabled: entity.contains::<ClothUntanglingDisabled>(),
            skip: part(&entity),
            sleep: part(&entity),
            sleep_disabled: entity.contains::<ClothSleepDisabled>(),
            limits: entity.get::<ClothLimits>().cloned(),
            drive: entity.get::<ClothDrive>().cloned(),
            blend: part(&entity),
            inertia: entity.get::<ClothInertia>().copied(),
            body: wearer::bodies(world, cloth).first().map(|(_, body)| *body),
            lod: entity.get::<ClothLod>().copied(),
            priority: part(&entity),
            own_wind: entity.get::<ClothWind>().copied(),
            pins: part(&entity),
            wind: world.get_resource::<ClothGlobalWind>().copied().unwrap_or_default(),
            gravity: world.get_resource::<ClothGravity>().copied().unwrap_or_default(),
            budget: world.get_resource::<ClothBudget>().copied(),
        })
    }

    /// Writes one part; nothing else is marked as changed.
    pub fn write(&self, part: Part, world: &mut World, cloth: Entity) {
        match part {
            Part::Wind => world.insert_resource(self.wind),
            Part::Gravity => world.insert_resource(self.gravity),
            Part::Budget => match self.budget {
                Some(budget) => world.insert_resource(budget),
                None => {
                    world.remove_resource::<ClothBudget>();
                }
            },
            Part::Body => {
                for (body, _) in wearer::bodies(world, cloth) {
                    if let (Some(settings), Ok(mut entity)) = (self.body, world.get_entity_mut(body)) {
                        put(&mut entity, settings);
                    }
                }
            }
            _ => {
                let Ok(mut entity) = world.get_entity_mut(cloth) else { return };
                match part {
                    Part::Material => put(&mut entity, self.material.clone()),
                    Part::Solver => put(&mut entity, self.solver.clone()),
                    Part::Collision => put(&mut entity, self.collision),
                    Part::Untangle => {
                        put(&mut entity, self.untangle);
                        put_or_remove(&mut entity, self.untangling_disabled.then_some(ClothUntanglingDisabled));
                    }
                    Part::Skip => put(&mut entity, self.skip),
                    Part::Sleep => {
                        put(&mut entity, self.sleep);
                        put_or_remove(&mut entity, self.sleep_disabled.then_some(ClothSleepDisabled));
                    }
                    Part::Limits => put_or_remove(&mut entity, self.limits.clone()),
                    Part::Drive => put_or_remove(&mut entity, self.drive.clone()),
                    Part::Blend => put(&mut entity, self.blend),
                    Part::Inertia => put_or_remove(&mut entity, self.inertia),
                    Part::Lod => put_or_remove(&mut entity, self.lod),
                    Part::Priority => put(&mut entity, self.priority),
                    Part::Pins => put(&mut entity, self.pins.clone()),
                    Part::OwnWind => put_or_remove(&mut entity, self.own_wind),
                    Part::Body | Part::Wind | Part::Gravity | Part::Budget => {}
                }
            }
        }
    }

    /// What a file holds of it: the material, what differs from its default, limits, drive, and a wind of its own. Sleep,
    /// blend, inertia, level of detail, priority, pins, the body, the world, and whether it is untangled at all are not in
    /// files.
    #[must_use]
    pub fn preset(&self) -> ClothPreset {
        fn changed<T: Clone + Default + PartialEq>(part: &T) -> Option<T> {
            (*part != T::default()).then(|| part.clone())
        }
        ClothPreset {
            material: self.material.clone(),
            solver: changed(&self.solver),
            collision: changed(&self.collision),
            untangle: changed(&self.untangle),
            skip_frame: changed(&self.skip),
            limits: self.limits.clone(),
            drive: self.drive.clone(),
            wind: self.own_wind.map(|wind| wind.0),
        }
    }

    /// Takes over what belongs to the cloth alone: all except pins, body and world.
    pub(super) fn take(&mut self, other: &Self) {
        let Self { pins, body, wind, gravity, budget, .. } = self;
        let (pins, body, budget) = (core::mem::take(pins), *body, *budget);
        *self = Self { pins, body, wind: *wind, gravity: *gravity, budget, ..other.clone() };
    }
}

/// Parts that [`ClothSettings::take`] takes over.
pub(super) const OWN: [Part; 13] = [
    Part::Material,
    Part::Solver,
    Part::Collision,
    Part::Untangle,
    Part::Skip,
    Part::Sleep,
    Part::Limits,
    Part::Drive,
    Part::Blend,
    Part::Inertia,
    Part::Lod,
    Part::Priority,
    Part::OwnWind,
];

fn put<T: Component<Mutability = bevy::ecs::component::Mutable>>(entity: &mut EntityWorldMut<'_>, value: T) {
    match entity.get_mut::<T>() {
        Some(mut at) => *at = value,
        None => {
            entity.insert(value);
        }
    }
}

fn put_or_remove<T: Component<Mutability = bevy::ecs::component::Mutable>>(entity: &mut EntityWorldMut<'_>, value: Option<T>) {
    match value {
        Some(value) => put(entity, value),
        None => {
            entity.remove::<T>();
        }
    }
}

/// Settings under the hands of the user, and which parts were changed.
#[derive(Clone, Debug)]
pub(super) struct Edit {
    pub settings: ClothSettings,
    touched: Vec<Part>,
}

impl Edit {
    pub(super) fn new(settings: ClothSettings) -> Self {
        Self { settings, touched: Vec::new() }
    }

    /// Marks a part as changed.
    pub(super) fn touch(&mut self, part: Part) {
        if !self.touched.contains(&part) {
            self.touched.push(part);
        }
    }

    /// Takes over what a file holds, as a cloth with a [`ClothPresetHandle`](crate::ClothPresetHandle) does: the rest stays.
    pub(super) fn take(&mut self, preset: ClothPreset) {
        let ClothPreset { material, solver, collision, untangle, skip_frame, limits, drive, wind } = preset;
        let own = &mut self.settings;
        own.material = material;
        let mut given = vec![Part::Material];
        if let Some(solver) = solver {
            own.solver = solver;
            given.push(Part::Solver);
        }
        if let Some(collision) = collision {
            own.collision = collision;
            given.push(Part::Collision);
        }
        if let Some(untangle) = untangle {
            own.untangle = untangle;
            given.push(Part::Untangle);
        }
        if let Some(skip) = skip_frame {
            own.skip = skip;
            given.push(Part::Skip);
        }
        if let Some(limits) = limits {
            own.limits = Some(limits);
            given.push(Part::Limits);
        }
        if let Some(drive) = drive {
            own.drive = Some(drive);
            given.push(Part::Drive);
        }
        if let Some(wind) = wind {
            own.own_wind = Some(ClothWind(wind));
            given.push(Part::OwnWind);
        }
        given.into_iter().for_each(|part| self.touch(part));
    }

    /// Writes what was changed.
    pub(super) fn write(&self, world: &mut World, cloth: Entity) {
        for &part in &self.touched {
            self.settings.write(part, world, cloth);
        }
    }
}
