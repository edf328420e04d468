//! Prepare: which meshes arrived or changed, except by our own writing.

use bevy::prelude::*;

use crate::bind::{RestCache, Sources};

/// Reads the asset events of meshes.
pub(crate) fn watch(mut events: MessageReader<AssetEvent<Mesh>>, mut sources: ResMut<Sources>, mut cache: ResMut<RestCache>) {
    if !(sources.modified.is_empty() && sources.added.is_empty() && events.is_empty()) {
        sources.modified.clear();
        sources.added.clear();
    }
    for event in events.read() {
        match *event {
            AssetEvent::Modified { id } if !sources.is_instance(id) => {
                sources.modified.insert(id);
                cache.forget_shapes(id);
            }
            AssetEvent::Added { id } | AssetEvent::LoadedWithDependencies { id } if !sources.is_instance(id) => {
                sources.added.insert(id);
            }
            AssetEvent::Removed { id } => {
                sources.remove(id);
                cache.forget(id);
            }
            _ => {}
        }
    }
}
