//! What users were told, so that they are told once.

use std::borrow::Cow;
use std::marker::PhantomData;

use bevy::ecs::world::DeferredWorld;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::utils::prelude::ShortName;

use crate::components::checked::{Checked, Values};

/// Silence before what waits is mentioned `[s]`.
pub(crate) const PATIENCE: f64 = 5.0;

/// Warnings per entity: one for each kind or field.
#[derive(Resource, Default)]
pub(crate) struct Notices {
    told: HashMap<Entity, Vec<Cow<'static, str>>>,
}

impl Notices {
    /// Whether this is the first time; remembers it.
    pub(crate) fn first(&mut self, entity: Entity, kind: impl Into<Cow<'static, str>>) -> bool {
        let kind = kind.into();
        let told = self.told.entry(entity).or_default();
        let first = !told.contains(&kind);
        if first {
            told.push(kind);
        }
        first
    }

    /// Says that a matter is settled: when it comes up again it is said again.
    #[cfg(feature = "presets")]
    pub(crate) fn settle(&mut self, entity: Entity, kind: &str) {
        if let Some(told) = self.told.get_mut(&entity) {
            told.retain(|known| known != kind);
        }
    }

    /// Warns once for each setting of an entity that was clamped.
    pub(crate) fn clamped(&mut self, entity: Entity, name: Option<&Name>, what: &str, checked: &Checked) {
        self.changed(entity, || format!("{what} {}", label(entity, name)), checked);
    }

    /// Warns once for each setting of a resource that was clamped.
    pub(crate) fn clamped_in<R: Resource>(&mut self, checked: &Checked) {
        self.changed(Entity::PLACEHOLDER, || format!("resource `{}`", ShortName::of::<R>()), checked);
    }

    fn changed(&mut self, entity: Entity, of: impl Fn() -> String, checked: &Checked) {
        for (field, values) in checked.changes() {
            if !self.first(entity, field.clone()) {
                continue;
            }
            let of = of();
            match values {
                Some(Values { given, used, range: (low, high), of_length }) => {
                    let length = if of_length { "a length of " } else { "" };
                    warn!(
                        "{of} has `{field}` out of range, which is {low} to {high} (in the unit in brackets in its documentation): \
                         {length}{used} is used in place of {given}"
                    );
                }
                None => {
                    warn!(
                        "{of} has a `{field}` that cannot be used: set numbers that are finite and that its documentation allows"
                    );
                }
            }
        }
    }

    /// Forgets an entity.
    pub(crate) fn forget(&mut self, entity: Entity) {
        self.told.remove(&entity);
    }
}

/// Inserted when users were told that the plugin is missing that inserts `R`.
#[derive(Resource)]
struct Missed<R: Resource>(PhantomData<fn() -> R>);

/// Says once that `C` on an entity has no effect, where the plugin is missing that inserts the resource `R`.
pub(crate) fn needs_plugin<C: Component, R: Resource>(mut world: DeferredWorld<'_>, entity: Entity, plugin: &str) {
    if !world.contains_resource::<R>() && !world.contains_resource::<Missed<R>>() {
        world.commands().insert_resource(Missed::<R>(PhantomData));
        let (component, on) = (ShortName::of::<C>(), label(entity, world.get::<Name>(entity)));
        warn!("`{component}` on {on} has no effect: add `{plugin}` to the app before it is inserted");
    }
}

/// A text from a file as it is shown in a warning: its beginning, if it is long.
#[cfg(feature = "presets")]
pub(crate) fn shortened(text: &str) -> Cow<'_, str> {
    const MOST: usize = 80;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

/// How an entity is called in a warning.
pub(crate) fn label(entity: Entity, name: Option<&Name>) -> String {
    match name {
        Some(name) => format!("`{name}` ({entity})"),
        None => format!("{entity}"),
    }
}
