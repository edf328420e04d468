//! Rest shapes that several cloths share, and which instance mesh came from which source.

use std::sync::{Arc, Weak};

use bevy::math::Mat3;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use super::Authored;
use crate::solver::rest::{BuildReport, RestError, RestShape, SourceMesh};

/// Rest shapes by mesh and baked scale; forgotten with the last cloth that uses them.
#[derive(Resource, Default)]
pub(crate) struct RestCache {
    shapes: HashMap<(AssetId<Mesh>, [u32; 9]), (Weak<RestShape>, BuildReport)>,
}

impl RestCache {
    /// The shape of a mesh at a scale, built if no cloth has it yet.
    pub fn get_or_build(
        &mut self,
        source: AssetId<Mesh>,
        bake: Mat3,
        authored: &Authored,
    ) -> Result<(Arc<RestShape>, BuildReport), RestError> {
        let key = (source, bake.to_cols_array().map(f32::to_bits));
        if let Some((shape, report)) = self.shapes.get(&key)
            && let Some(shape) = shape.upgrade()
        {
            return Ok((shape, *report));
        }
        let mirrored = bake.determinant() < 0.0;
        let mesh = SourceMesh {
            positions: authored.positions.iter().map(|&p| bake * p).collect(),
            triangles: authored.triangles.iter().map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] }).collect(),
            uvs: authored.uvs.clone(),
        };
        let (shape, report) = RestShape::build(&mesh)?;
        let shape = Arc::new(shape);
        self.shapes.retain(|_, (shape, _)| shape.strong_count() > 0);
        self.shapes.insert(key, (Arc::downgrade(&shape), report));
        Ok((shape, report))
    }

    /// Forgets the shapes of a mesh that changed.
    pub fn forget(&mut self, source: AssetId<Mesh>) {
        self.shapes.retain(|(id, _), _| *id != source);
    }
}

/// Which meshes are ours, and which of the others changed.
#[derive(Resource, Default)]
pub(crate) struct Sources {
    /// Source of each instance mesh.
    authored: HashMap<AssetId<Mesh>, Handle<Mesh>>,
    /// Meshes that were modified since the last frame.
    pub modified: HashSet<AssetId<Mesh>>,
    /// Meshes that arrived since the last frame.
    pub added: HashSet<AssetId<Mesh>>,
}

impl Sources {
    /// The mesh that an instance was made from; the mesh itself if it is none of ours.
    pub fn authored(&self, mesh: &Handle<Mesh>) -> Handle<Mesh> {
        self.authored.get(&mesh.id()).unwrap_or(mesh).clone()
    }

    /// Whether a mesh is an instance of ours.
    pub fn is_instance(&self, mesh: AssetId<Mesh>) -> bool {
        self.authored.contains_key(&mesh)
    }

    pub fn insert(&mut self, instance: AssetId<Mesh>, source: Handle<Mesh>) {
        self.authored.insert(instance, source);
    }

    pub fn remove(&mut self, instance: AssetId<Mesh>) {
        self.authored.remove(&instance);
    }
}
