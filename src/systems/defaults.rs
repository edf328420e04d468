//! Settings that are removed from a cloth are its defaults again.

use bevy::prelude::*;

use crate::components::Cloth;

/// Inserts the default of a component that a cloth requires, and that was removed from it.
pub(crate) fn on_remove<C: Component + Default>(removed: On<Remove, C>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.queue_silenced(|mut entity: EntityWorldMut| {
            if entity.contains::<Cloth>() && !entity.contains::<C>() {
                entity.insert(C::default());
            }
        });
    }
}
