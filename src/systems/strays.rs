//! Prepare: warns once of a component that has no effect, because another one is missing beside it.

use bevy::prelude::*;
use bevy::utils::prelude::ShortName;

use crate::notices::{Notices, PATIENCE, label};

/// Warns of entities that were given `C` and have had no `Needed` for a while.
pub(crate) fn tell<C: Component, Needed: Component>(
    time: Res<Time<Real>>,
    mut notices: ResMut<Notices>,
    mut strays: Local<Vec<(Entity, f64)>>,
    added: Query<Entity, (Added<C>, Without<Needed>)>,
    still: Query<Option<&Name>, (With<C>, Without<Needed>)>,
) {
    let now = time.elapsed_secs_f64();
    strays.extend(added.iter().map(|entity| (entity, now)));
    strays.retain(|&(entity, since)| {
        let Ok(name) = still.get(entity) else { return false };
        if now - since <= PATIENCE {
            return true;
        }
        let (component, needed) = (ShortName::of::<C>(), ShortName::of::<Needed>());
        if notices.first(entity, component.0) {
            warn!("`{component}` on {} has no effect: insert `{needed}` on the same entity, too", label(entity, name));
        }
        false
    });
}
