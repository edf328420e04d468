//! Rest shapes that several cloths share, and which instance mesh came from which source.

use std::sync::{Arc, Weak};

use bevy::math::Mat3;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use super::Authored;
use super::placement::multiple;
use crate::solver::rest::{BuildReport, RestError, RestShape, SourceMesh};

/// Rest shapes by mesh and baked scale; forgotten with the last cloth that uses them.
#[derive(Resource, Default)]
pub(crate) struct RestCache {
    shapes: HashMap<(AssetId<Mesh>, [u32; 9]), Known>,
}

/// A rest shape that some cloth has.
struct Known {
    shape: Weak<RestShape>,
    report: BuildReport,
    /// The shape it is a multiple of, with the scale of that; none if it was built itself.
    of: Option<(Arc<RestShape>, Mat3)>,
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
        if let Some(known) = self.shapes.get(&key)
            && let Some(shape) = known.shape.upgrade()
        {
            return Ok((shape, known.report));
        }
        if let Some((shape, known)) = self.scale_another(source, bake) {
            let report = known.report;
            self.keep(key, known);
            return Ok((shape, report));
        }
        let mirrored = bake.determinant() < 0.0;
        let mesh = SourceMesh {
            positions: authored.positions.iter().map(|&p| bake * p).collect(),
            triangles: authored.triangles.iter().map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] }).collect(),
            uvs: authored.uvs.clone(),
        };
        let (shape, report) = RestShape::build(&mesh)?;
        let shape = Arc::new(shape);
        self.keep(key, Known { shape: Arc::downgrade(&shape), report, of: None });
        Ok((shape, report))
    }

    /// The shape of a mesh at a scale that is a multiple of another's, made of what was built: a scale that breathes builds nothing.
    fn scale_another(&self, source: AssetId<Mesh>, bake: Mat3) -> Option<(Arc<RestShape>, Known)> {
        let of_mesh = self.shapes.iter().filter(|((id, _), _)| *id == source);
        let (_, times, of, report) = of_mesh
            .filter_map(|((_, bits), known)| {
                let built = || Some((known.shape.upgrade()?, Mat3::from_cols_array(&bits.map(f32::from_bits))));
                let of = known.of.clone().or_else(built)?;
                Some((*bits, multiple(&bake, &of.1)?, of, known.report))
            })
            // Not the one that is found first: that depends on hashes.
            .min_by_key(|(bits, ..)| *bits)?;
        let shape = Arc::new(of.0.scaled(times)?);
        let known = Known { shape: Arc::downgrade(&shape), report, of: Some(of) };
        Some((shape, known))
    }

    fn keep(&mut self, key: (AssetId<Mesh>, [u32; 9]), known: Known) {
        self.shapes.retain(|_, known| known.shape.strong_count() > 0);
        self.shapes.insert(key, known);
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
