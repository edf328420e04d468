//! Rest shapes that several cloths share, and which instance mesh came from which source.

use std::sync::{Arc, Weak};

use bevy::math::Mat3;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, Task};

use super::Authored;
use super::placement::multiple;
use crate::solver::rest::{BuildReport, RestError, RestShape, SourceMesh};

/// Rest shapes by mesh and baked scale; forgotten with the last cloth that uses them.
#[derive(Resource, Default)]
pub(crate) struct RestCache {
    shapes: HashMap<Key, Known>,
    /// What is built in the background, as long as a cloth asks for it.
    tasks: HashMap<Key, Building>,
}

/// Which rest shape: that of a mesh at a scale.
#[derive(Clone, Copy)]
pub(crate) struct RestOf {
    pub source: AssetId<Mesh>,
    /// The scale.
    pub bake: Mat3,
    /// Length below which edges are collapsed, in the space of the mesh `[m]`; 0: none.
    pub shortest_edge: f32,
}

impl RestOf {
    fn key(&self) -> Key {
        // A zero has no sign: one that turns would be another scale in every frame.
        (self.form(), self.bake.to_cols_array().map(|x| (x + 0.0).to_bits()))
    }

    fn form(&self) -> Form {
        (self.source, self.shortest_edge.to_bits())
    }
}

/// A mesh, and bits of the length below which its edges are collapsed.
type Form = (AssetId<Mesh>, u32);

/// The same with its baked scale, by bits.
type Key = (Form, [u32; 9]);

/// What building comes to.
type Built = Result<(Arc<RestShape>, BuildReport), RestError>;

/// A rest shape that is built in the background.
struct Building {
    /// What it is built of.
    authored: Arc<Authored>,
    task: Task<Built>,
    built: Option<Built>,
    /// Whether the mesh was written since, with what it was before or with something else.
    written: bool,
    /// Whether a cloth asked for it since the last [`RestCache::forget_unasked`].
    asked: bool,
}

impl Building {
    fn begin(pool: &AsyncComputeTaskPool, authored: Authored, asked: RestOf) -> Self {
        let authored = Arc::new(authored);
        let of = Arc::clone(&authored);
        let task = pool.spawn(async move {
            let built = build(&of, &asked);
            // An island would make it while everything waits.
            if let Ok((shape, _)) = &built {
                shape.tree_topology();
            }
            built
        });
        Self { authored, task, built: None, written: false, asked: true }
    }

    /// What it came to, if it is done; it was asked for.
    fn ask(&mut self) -> Option<&Built> {
        self.asked = true;
        self.built = self.built.take().or_else(|| check_ready(&mut self.task));
        self.built.as_ref()
    }
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
    pub(crate) fn get_or_build(&mut self, of: &RestOf, authored: &Authored) -> Built {
        // Nobody may have been told yet that the mesh is another.
        let vertices = authored.positions.len();
        let fits = |built: &Built| built.as_ref().map_or(true, |(shape, _)| shape.particle_of_vertex.len() == vertices);
        if let Some(known) = self.get(of).filter(fits) {
            return known;
        }
        let built = build(authored, of);
        self.remember(of.key(), &built);
        built
    }

    /// Whether the shape of a mesh at a scale is there, or will not be. Otherwise it is being built in the background, from now
    /// on if `begin` gives a mesh for it.
    pub(crate) fn is_ready(&mut self, of: &RestOf, begin: impl FnOnce() -> Option<Authored>) -> bool {
        let (form, key) = (of.form(), of.key());
        if let Some(building) = self.tasks.get_mut(&key) {
            if building.ask().is_none() {
                return false;
            }
            if !core::mem::take(&mut building.written) {
                return true;
            }
            let Some((pool, authored)) = AsyncComputeTaskPool::try_get().zip(begin()) else {
                self.tasks.remove(&key);
                return true;
            };
            let fits = authored == *building.authored;
            if !fits {
                *building = Building::begin(pool, authored, *of);
            }
            return fits;
        }
        if self.get(of).is_some() {
            return true;
        }
        // Of a scale that changes meanwhile, what is built will be a multiple of it, or it is built at once.
        let mut others = self.tasks.iter_mut().filter(|((other, _), building)| *other == form && !building.written);
        if let Some(((_, bits), building)) = others.next() {
            if multiple(&of.bake, &Mat3::from_cols_array(&bits.map(f32::from_bits))).is_none() {
                return true;
            }
            let (other, built) = ((form, *bits), building.ask().cloned());
            if let Some(built) = &built {
                self.remember(other, built);
            }
            return built.is_some();
        }
        let Some((pool, authored)) = AsyncComputeTaskPool::try_get().zip(begin()) else { return true };
        self.tasks.insert(key, Building::begin(pool, authored, *of));
        false
    }

    /// Lets go of what was built in the background and no cloth asks for any more.
    pub(crate) fn forget_unasked(&mut self) {
        self.tasks.retain(|_, building| core::mem::take(&mut building.asked));
    }

    /// The shape of a mesh at a scale, if a cloth has it, or if it is a multiple of one that a cloth has.
    fn get(&mut self, of: &RestOf) -> Option<Built> {
        let key = of.key();
        if let Some(known) = self.shapes.get(&key)
            && let Some(shape) = known.shape.upgrade()
        {
            return Some(Ok((shape, known.report)));
        }
        let built = self.tasks.get(&key).filter(|building| !building.written).and_then(|building| building.built.clone());
        if let Some(built) = built {
            self.remember(key, &built);
            return Some(built);
        }
        let (shape, known) = self.scale_another(of)?;
        let report = known.report;
        self.keep(key, known);
        Some(Ok((shape, report)))
    }

    /// Remembers what was built.
    fn remember(&mut self, key: Key, built: &Built) {
        if let Ok((shape, report)) = built {
            self.keep(key, Known { shape: Arc::downgrade(shape), report: *report, of: None });
        }
    }

    /// The shape of a mesh at a scale that is a multiple of another's, made of what was built: a scale that breathes builds
    /// nothing.
    fn scale_another(&self, asked: &RestOf) -> Option<(Arc<RestShape>, Known)> {
        let of_mesh = self.shapes.iter().filter(|((form, _), _)| *form == asked.form());
        let (_, times, of, report) = of_mesh
            .filter_map(|((_, bits), known)| {
                let built = || Some((known.shape.upgrade()?, Mat3::from_cols_array(&bits.map(f32::from_bits))));
                let of = known.of.clone().or_else(built)?;
                Some((*bits, multiple(&asked.bake, &of.1)?, of, known.report))
            })
            // Not the one that is found first: that depends on hashes.
            .min_by_key(|(bits, ..)| *bits)?;
        let shape = Arc::new(of.0.scaled(times)?);
        let known = Known { shape: Arc::downgrade(&shape), report, of: Some(of) };
        Some((shape, known))
    }

    fn keep(&mut self, key: Key, known: Known) {
        self.shapes.retain(|_, known| known.shape.strong_count() > 0);
        self.shapes.insert(key, known);
    }

    /// Forgets the shapes of a mesh that was written. Builds that are under way go on: a write need not change the mesh, and a
    /// mesh written in every frame would never be built.
    pub(crate) fn forget_shapes(&mut self, source: AssetId<Mesh>) {
        self.shapes.retain(|((id, _), _), _| *id != source);
        self.tasks.iter_mut().filter(|(((id, _), _), _)| *id == source).for_each(|(_, building)| building.written = true);
    }

    /// Forgets a mesh that is gone.
    pub(crate) fn forget(&mut self, source: AssetId<Mesh>) {
        self.shapes.retain(|((id, _), _), _| *id != source);
        self.tasks.retain(|((id, _), _), _| *id != source);
    }
}

/// A mesh at a scale.
fn baked(authored: &Authored, bake: Mat3) -> SourceMesh {
    let mirrored = bake.determinant() < 0.0;
    SourceMesh {
        positions: authored.positions.iter().map(|&p| bake * p).collect(),
        triangles: authored.triangles.iter().map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] }).collect(),
        uvs: authored.uvs.clone(),
    }
}

fn build(authored: &Authored, of: &RestOf) -> Built {
    let mesh = baked(authored, of.bake);
    let built = if of.shortest_edge > 0.0 {
        RestShape::build_decimated(&mesh, &authored.positions, of.shortest_edge)
    } else {
        RestShape::build(&mesh)
    };
    built.map(|(shape, report)| (Arc::new(shape), report))
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
    pub(crate) fn authored(&self, mesh: &Handle<Mesh>) -> Handle<Mesh> {
        self.authored.get(&mesh.id()).unwrap_or(mesh).clone()
    }

    /// Whether a mesh is an instance of ours.
    pub(crate) fn is_instance(&self, mesh: AssetId<Mesh>) -> bool {
        self.authored.contains_key(&mesh)
    }

    pub(crate) fn insert(&mut self, instance: AssetId<Mesh>, source: Handle<Mesh>) {
        self.authored.insert(instance, source);
    }

    pub(crate) fn remove(&mut self, instance: AssetId<Mesh>) {
        self.authored.remove(&instance);
    }
}
