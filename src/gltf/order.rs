//! The order of vertices in a glTF file, where Bevy's loader changes it.
//!
//! Of a primitive without normals the loader splits every triangle off, so that each can have a normal of its own. Corner `k`
//! of the mesh is then vertex `indices[k]` of the file, which is what pins by index mean.

use std::sync::Arc;

use bevy::ecs::world::EntityWorldMut;
use bevy::gltf::extensions::{ErasedGltfExtensionHandler, GltfExtensionHandler, GltfExtensionHandlers};
use bevy::mesh::MeshVertexAttribute;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::tasks::ConditionalSendFuture;
use gltf::Semantic;

use crate::components::ClothPinSelect;

/// Vertex of the file of each vertex of the mesh, on an entity whose mesh the loader numbered anew.
#[derive(Component, Clone, Debug, Default, Reflect)]
#[reflect(Component, Default, Clone, Debug)]
pub(crate) struct VerticesOfFile(Vec<u32>);

impl VerticesOfFile {
    /// Pins by index, by those of the mesh; none for other pins.
    pub(crate) fn renumber(&self, pin: Option<&ClothPinSelect>) -> Option<ClothPinSelect> {
        let Some(ClothPinSelect::Vertices(pinned)) = pin else { return None };
        // One beyond the end of the file is beyond that of the mesh, which warns of it.
        let end = self.0.iter().max().map_or(0, |last| last + 1);
        let beyond = pinned.iter().filter(|&&v| v >= end).map(|v| v - end + self.0.len() as u32);
        let corners = (0..).zip(&self.0).filter(|(_, of)| pinned.contains(of)).map(|(corner, _)| corner);
        Some(ClothPinSelect::Vertices(corners.chain(beyond).collect()))
    }
}

/// Asks Bevy's glTF loader to keep the order of primitives without normals.
pub(crate) fn keep(app: &mut App) {
    let handlers = app.world_mut().get_resource_or_init::<GltfExtensionHandlers>();
    handlers.0.write_blocking().push(Box::new(Orders::default()));
    app.register_type::<VerticesOfFile>();
}

/// Orders of the primitives without normals of one file, by mesh and primitive.
#[derive(Clone, Default)]
struct Orders(HashMap<(usize, usize), Arc<[u32]>>);

impl GltfExtensionHandler for Orders {
    fn dyn_clone(&self) -> Box<dyn ErasedGltfExtensionHandler> {
        Box::new(self.clone())
    }

    fn on_gltf_primitive(
        &mut self,
        _: &mut bevy::asset::LoadContext<'_>,
        _: &gltf::Gltf,
        mesh: &gltf::Mesh<'_>,
        primitive: &gltf::Primitive<'_>,
        buffers: &[Vec<u8>],
        _: &HashMap<Box<str>, MeshVertexAttribute>,
        _: bool,
        _: bool,
        _: &mut Option<Mesh>,
    ) -> impl ConditionalSendFuture<Output = ()> {
        let is_bare = primitive.mode() == gltf::mesh::Mode::Triangles && primitive.get(&Semantic::Normals).is_none();
        if is_bare {
            let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
            let indices: Option<Arc<[u32]>> = reader.read_indices().map(|indices| indices.into_u32().collect());
            // Without indices the order stays.
            let count = primitive.get(&Semantic::Positions).map_or(0, |positions| positions.count() as u32);
            self.0.insert((mesh.index(), primitive.index()), indices.unwrap_or_else(|| (0..count).collect()));
        }
        async {}
    }

    fn on_spawn_mesh_and_material(
        &mut self,
        _: &mut bevy::asset::LoadContext<'_>,
        primitive: &gltf::Primitive<'_>,
        mesh: &gltf::Mesh<'_>,
        _: &gltf::Material<'_>,
        entity: &mut EntityWorldMut<'_>,
        _: &str,
    ) {
        if let Some(order) = self.0.get(&(mesh.index(), primitive.index())) {
            entity.insert(VerticesOfFile(order.to_vec()));
        }
    }
}
