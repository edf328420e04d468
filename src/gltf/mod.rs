//! Cloth authored in a glTF: node and scene extras become components.
//!
//! A node whose extras hold `cloth` makes its mesh a cloth, one that holds `collider` makes it a collider; everything else has
//! defaults. Unknown keys and wrong types give one warning each, which names the file, the node and the key. The rest of the
//! file still works.
//!
//! | node extras | value |
//! |---|---|
//! | `cloth` | `true`, or an object with the keys below |
//! | `cloth.material` | a preset name, a path to a `.cloth.ron` relative to the glTF, or an object with fields of [`ClothMaterial`] |
//! | `cloth.pin` | a list of vertex indices, `"_NAME"` of a float attribute, `"_NAME.g"` of one of its components, or `"color.r"` (`g`, `b`, `a`) |
//! | `cloth.self_collision` | bool, default true: whether it folds on itself and is untangled from itself |
//! | `cloth.layer` | integer, higher lies outside where cloths cross |
//! | `cloth.thickness` | metres |
//! | `cloth.substep_rate` | Hz |
//! | `cloth.max_distance` | metres from the skin; or `[low, high]` over the attribute `_CLOTH_MAXDIST`; or `{"map": "color.g", "low": 0, "high": 0.4}`: [`ClothLimits`](crate::ClothLimits) |
//! | `cloth.backstop` | metres behind the skin, or `true` for 0; or `[low, high]` over `_CLOTH_BACKSTOP`; or `{"distance": …, "radius": …, "map": …}` |
//! | `cloth.drive` | Hz; or `[low, high]` over `_CLOTH_DRIVE`; or `{"frequency": …, "damping_ratio": …, "map": …}`: [`ClothDrive`] |
//! | `cloth.inertia` | share of the motion of its character that it feels; or `"character"`, `"world"`; or `{"linear": …, "angular": …, "max_speed": …, "max_turn": …}`: [`ClothInertia`](crate::ClothInertia) |
//! | `cloth.blend` | how much of it is simulated, 0 to 1: [`ClothBlend`] |
//! | `cloth.warm_up` | seconds that are simulated before it is shown: [`ClothWarmUp`] |
//! | `cloth.decimation` | metres in the space of the mesh: shorter edges are not simulated, and drawn as authored: [`ClothDecimation`] |
//! | `cloth.subdivision` | metres in the space of the mesh: longer edges are split; for meshes of one material: [`ClothSubdivision`] |
//! | `cloth.proxy` | name of the object that is simulated; this one is drawn in its place, and needs no other key: [`ClothRenderMesh`] |
//! | `collider` | `"ball"`, `"capsule"`, `"cuboid"`, `"convex"`, `"trimesh"`, `"plane"`, `"skeleton"`, or `{"shape": …, "friction": …}` |
//! | `collision_memberships` | layers that the cloth or collider belongs to: a number from 0 to 31, or a list; without it layer 0. On a joint they count for the colliders of a body there: [`ClothCollisionLayers`](crate::ClothCollisionLayers) |
//! | `collision_filters` | layers that it touches, as above; without it all |
//!
//! | scene extras | value |
//! |---|---|
//! | `gravity` | `[x, y, z]` `[m/s²]` |
//! | `wind` | `[x, y, z]` `[m/s]` |
//!
//! `"skeleton"` makes a [`ClothBody`] of every skinned mesh at the node or below it, except of cloths. Put it on the mesh of a
//! character, or on its armature.
//!
//! A mesh with several materials, which a glTF stores as one primitive each, becomes one cloth. A [`ClothPiece`] for each
//! material shows it. Pieces hang together where their vertices lie in the same place.
//!
//! Keys of the `cloth` object may also be written flat, as `"cloth.pin"` beside `"cloth"`, for programs that only have flat
//! properties.
//!
//! A `map` names the paint as `cloth.pin` does. A single number beside it is the value at 1, and the value at 0 is zero. A mesh
//! with `_CLOTH_MAXDIST` and no `cloth.max_distance` has that of 0 to 1 m; `false` switches it off.
//!
//! `_CLOTH_PAINT` holds four maps in one colour: red is `_PIN`, green `_CLOTH_MAXDIST`, blue `_CLOTH_BACKSTOP`, alpha
//! `_CLOTH_DRIVE`. Each stands in where the mesh does not have the attribute of its own. Red pins without `cloth.pin`, too.
//!
//! Bevy only reads vertex attributes that are registered before it loads. One line does that:
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy::gltf::GltfPlugin;
//! # fn plugins() -> impl PluginGroup {
//! DefaultPlugins.set(bevy_drape::gltf::cloth_attributes(GltfPlugin::default()))
//! # }
//! ```

mod extras;
mod join;
mod maps;
mod order;
mod proxy;

use bevy::ecs::system::SystemParam;
use bevy::gltf::{GltfExtras, GltfPlugin, GltfSceneExtras};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::mesh::{MeshVertexAttribute, VertexFormat};
use bevy::prelude::*;
use bevy::world_serialization::WorldAssetRoot;

use crate::components::{
    Cloth, ClothBlend, ClothBody, ClothCollider, ClothColliderShape, ClothCollision, ClothDecimation, ClothDrive,
    ClothGlobalWind, ClothGravity, ClothMaterial, ClothMeshFit, ClothPiece, ClothPinSelect, ClothPins, ClothRenderMesh,
    ClothSolver, ClothSubdivision, ClothWarmUp,
};
use crate::presets::{ClothPresetHandle, PresetOverrides};
use crate::schedule::ClothSystems;
use extras::{ClothExtras, ColliderExtras, ColliderFit, MaterialExtras, NodeExtras, Problem};
use join::Joined;
use maps::BackstopExtras;
pub(crate) use order::{VerticesOfFile, keep};

/// The systems, for `plugin.rs` to order: before anything is bound.
pub(crate) fn systems() -> bevy::ecs::schedule::ScheduleConfigs<bevy::ecs::system::ScheduleSystem> {
    (scenes, nodes).chain().in_set(ClothSystems::Prepare)
}

/// Registers the attributes that cloth is painted in with Bevy's glTF loader. `_PIN`, `_CLOTH_MAXDIST`, `_CLOTH_BACKSTOP` and
/// `_CLOTH_DRIVE` are floats, `_CLOTH_PAINT` is a colour of four floats. Call it before the plugin is added.
#[must_use]
pub fn cloth_attributes(plugin: GltfPlugin) -> GltfPlugin {
    let singles = [maps::PIN, maps::MAX_DISTANCE, maps::BACKSTOP, maps::DRIVE];
    register(singles.into_iter().fold(plugin, pin_attribute), maps::PAINT, VertexFormat::Float32x4)
}

/// Tells Bevy's glTF loader of another float attribute that pins or maps name, such as `"_CUFF"`. Call it for each, before the
/// plugin is added; [`cloth_attributes`] does it for those with names of their own.
#[must_use]
pub fn pin_attribute(plugin: GltfPlugin, name: &'static str) -> GltfPlugin {
    register(plugin, name, VertexFormat::Float32)
}

fn register(plugin: GltfPlugin, name: &'static str, format: VertexFormat) -> GltfPlugin {
    // Attributes with one name get one id in every run: FNV-1a, kept apart from Bevy's own small ids.
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
    // The loader compares names without their first underscore.
    let seen = name.strip_prefix('_').unwrap_or(name);
    plugin.add_custom_vertex_attribute(seen, MeshVertexAttribute::new(name, hash | 1 << 63, format))
}

/// Gravity and wind of scenes that were just spawned.
pub(crate) fn scenes(
    added: Query<(Entity, &GltfSceneExtras), Added<GltfSceneExtras>>,
    parents: Query<&ChildOf>,
    roots: Query<&WorldAssetRoot>,
    mut gravity: ResMut<ClothGravity>,
    mut wind: ResMut<ClothGlobalWind>,
) {
    for (entity, extras) in &added {
        let mut problems = Vec::new();
        let scene = extras::scene(&extras.value, &mut problems);
        if let Some(pull) = scene.gravity {
            gravity.0 = pull;
        }
        if let Some(velocity) = scene.wind {
            wind.velocity = velocity;
        }
        warn_all(&file_of(entity, &parents, &roots), "the scene", &problems);
    }
}

/// Cloths and colliders of nodes that were just spawned. What an app, or the node that this one is a clone of, has put on it
/// stays.
pub(crate) fn nodes(
    mut commands: Commands,
    added: Query<(Entity, &GltfExtras, Option<&Name>, Option<&Children>), Added<GltfExtras>>,
    meshes: Query<&Mesh3d>,
    nodes: Nodes,
    mut assets: ResMut<Assets<Mesh>>,
    mut known: Local<join::Known>,
    server: Option<Res<AssetServer>>,
) {
    // Which nodes are drawn in place of which.
    let proxies: Vec<(Entity, Result<Entity, Problem>)> = added
        .iter()
        .filter_map(|(entity, extras, ..)| {
            Some((entity, nodes.simulated(entity, &extras::node(&extras.value, &mut Vec::new()).proxy?)))
        })
        .collect();
    for (entity, extras, name, children) in &added {
        let mut problems = Vec::new();
        let node = extras::node(&extras.value, &mut problems);
        if node == NodeExtras::default() && problems.is_empty() {
            continue;
        }
        let file = file_of(entity, &nodes.parents, &nodes.roots);
        let primitives: Vec<Entity> = if meshes.contains(entity) {
            vec![entity]
        } else {
            children.into_iter().flatten().copied().filter(|child| meshes.contains(*child)).collect()
        };
        let fit = node.collider.as_ref().map(|collider| collider.fit);
        let lone_plane = fit == Some(ColliderFit::Mesh(ClothMeshFit::HalfSpace));
        if primitives.is_empty() && node.cloth.is_some() {
            problems.push(Problem::new("cloth", "needs a mesh on the node"));
        }
        if primitives.is_empty() && matches!(fit, Some(ColliderFit::Mesh(_))) && !lone_plane {
            problems.push(Problem::new("collider", "needs a mesh on the node to be fitted to"));
        }
        match proxies.iter().find(|(drawn, _)| *drawn == entity) {
            None => {}
            Some((_, Err(problem))) => problems.push(problem.clone()),
            Some((_, Ok(cloth))) => {
                for &primitive in &primitives {
                    commands.entity(primitive).try_insert_if_new(ClothRenderMesh { cloth: *cloth });
                }
            }
        }
        if let Some(cloth) = &node.cloth {
            let is_proxy = proxies.iter().any(|(_, of)| of.as_ref().is_ok_and(|of| *of == entity));
            let listed = matches!(&cloth.pin, Some(ClothPinSelect::Vertices(vertices)) if !vertices.is_empty());
            if listed && primitives.len() > 1 && primitives.iter().any(|p| nodes.orders.contains(*p)) {
                let what = "lists vertices but a primitive of several has no normals, so that its vertices are numbered anew: \
                            export normals, or pin by attribute or colour";
                problems.push(Problem::new("cloth.pin", what));
            }
            let own: Vec<&Mesh> = primitives.iter().filter_map(|p| assets.get(&meshes.get(*p).ok()?.0)).collect();
            let joined = (primitives.len() > 1 && own.len() == primitives.len()).then(|| join::join(&own));
            if let Some(Ok(Joined { mesh, firsts })) = joined {
                let pin = cloth.pin.as_ref();
                make_cloth(&mut commands, (entity, Some(&mesh)), cloth, pin, &file, server.as_deref(), &mut problems);
                let skin = primitives.first().and_then(|p| nodes.skinned.get(*p).ok()).cloned();
                let mut bearer = commands.entity(entity);
                bearer.try_insert_if_new(Mesh3d(known.find(&mut assets, mesh)));
                if let Some(skin) = skin {
                    bearer.try_insert_if_new(skin);
                }
                for (&primitive, first) in primitives.iter().zip(firsts) {
                    if is_proxy {
                        commands.entity(primitive).try_remove::<(Mesh3d, SkinnedMesh)>();
                    } else {
                        commands.entity(primitive).try_insert_if_new(ClothPiece { cloth: entity, first });
                    }
                }
            } else {
                if let Some(Err(error)) = joined {
                    let what = format!(
                        "is on a mesh with {} primitives that cannot be joined ({error}): each becomes a cloth of its own",
                        primitives.len()
                    );
                    problems.push(Problem::new("cloth", what));
                }
                for &primitive in &primitives {
                    let mesh = meshes.get(primitive).ok().and_then(|mesh| assets.get(&mesh.0));
                    let renumbered = nodes.orders.get(primitive).ok().and_then(|order| order.renumber(cloth.pin.as_ref()));
                    let pin = renumbered.as_ref().or(cloth.pin.as_ref());
                    // What is not drawn has no material: the mesh goes to the node.
                    let bearer = if is_proxy && primitives.len() == 1 { entity } else { primitive };
                    make_cloth(&mut commands, (bearer, mesh), cloth, pin, &file, server.as_deref(), &mut problems);
                    if bearer != primitive {
                        if let Ok(mesh) = meshes.get(primitive) {
                            commands.entity(bearer).try_insert_if_new(mesh.clone());
                        }
                        if let Ok(skin) = nodes.skinned.get(primitive) {
                            commands.entity(bearer).try_insert_if_new(skin.clone());
                        }
                        commands.entity(primitive).try_remove::<(Mesh3d, SkinnedMesh)>();
                    }
                }
            }
        }
        if let Some(layers) = node.layers {
            // A joint hands them on to what is fitted to it.
            for bearer in core::iter::once(entity).chain(primitives.iter().copied()) {
                commands.entity(bearer).try_insert_if_new(layers);
            }
        }
        match node.collider {
            None => {}
            Some(ColliderExtras { fit: ColliderFit::Skeleton, friction }) => {
                let body = ClothBody::default();
                let body = friction.map_or(body, |friction| body.with_friction(friction));
                let bodies = nodes.bodies_below(entity);
                if bodies.is_empty() {
                    let what = "is `skeleton` and needs a skinned mesh, which is no cloth, at the node or below it: \
                                export the mesh with its armature, or choose another shape";
                    problems.push(Problem::new("collider", what));
                }
                for bearer in bodies {
                    let mut bearer = commands.entity(bearer);
                    bearer.try_insert_if_new(body);
                    if let Some(layers) = node.layers {
                        bearer.try_insert_if_new(layers);
                    }
                }
            }
            Some(ColliderExtras { fit: ColliderFit::Mesh(fit), friction }) => {
                let collider = ClothCollider::new(ClothColliderShape::Mesh(fit));
                let collider = match friction {
                    Some(friction) => collider.with_friction(friction),
                    None => collider,
                };
                let bearers = if lone_plane { std::slice::from_ref(&entity) } else { &primitives[..] };
                for &bearer in bearers {
                    commands.entity(bearer).try_insert_if_new(collider.clone());
                }
            }
        }
        let node_name = name.map_or_else(|| entity.to_string(), |n| format!("`{n}`"));
        warn_all(&file, &format!("node {node_name}"), &problems);
    }
}

/// Nodes and the skinned meshes among them.
#[derive(SystemParam)]
pub(crate) struct Nodes<'w, 's> {
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    extras: Query<'w, 's, &'static GltfExtras>,
    names: Query<'w, 's, &'static Name>,
    orders: Query<'w, 's, &'static VerticesOfFile>,
    skinned: Query<'w, 's, &'static SkinnedMesh>,
    roots: Query<'w, 's, &'static WorldAssetRoot>,
}

impl Nodes<'_, '_> {
    /// Skinned meshes at a node or below it that are no cloth.
    fn bodies_below(&self, node: Entity) -> Vec<Entity> {
        let all = core::iter::once(node).chain(self.children.iter_descendants(node));
        all.filter(|&entity| self.skinned.contains(entity) && !self.is_cloth(entity)).collect()
    }

    /// Whether a mesh is to be a cloth, by the extras of its own or of its node.
    fn is_cloth(&self, mesh: Entity) -> bool {
        let node = self.parents.get(mesh).ok().map(ChildOf::parent);
        let is_cloth = |entity| {
            let extras = self.extras.get(entity).ok();
            // Its problems are told with its own node.
            extras.is_some_and(|extras| extras::node(&extras.value, &mut Vec::new()).cloth.is_some())
        };
        core::iter::once(mesh).chain(node).any(is_cloth)
    }
}

fn make_cloth(
    commands: &mut Commands,
    (entity, mesh): (Entity, Option<&Mesh>),
    extras: &ClothExtras,
    pin: Option<&ClothPinSelect>,
    file: &SourceFile,
    server: Option<&AssetServer>,
    problems: &mut Vec<Problem>,
) {
    if let Some(mesh) = mesh {
        maps::tell_of_idle(mesh, extras.backstop.is_some(), extras.drive.is_some(), problems);
    }
    let max_distance = extras.max_distance.clone().map(|map| maps::over(mesh, map));
    let backstop = extras.backstop.clone().map(|given| BackstopExtras { distance: maps::over(mesh, given.distance), ..given });
    let drive = extras.drive.clone().map(|given| ClothDrive { frequency: maps::over(mesh, given.frequency), ..given });
    let mut material = ClothMaterial::default();
    let mut entity = commands.entity(entity);
    match &extras.material {
        None => {}
        Some(MaterialExtras::Given(given)) => material = given.as_ref().clone(),
        Some(MaterialExtras::File(path)) => match (server, &file.0) {
            (Some(server), Some(gltf)) => match gltf.resolve_embed_str(path) {
                Ok(path) => {
                    let overrides = PresetOverrides {
                        thickness: extras.thickness,
                        substep_rate: extras.substep_rate,
                        self_collision: extras.self_collision,
                        garment_layer: extras.layer,
                        max_distance: max_distance.clone(),
                        backstop: backstop.clone().map(|given| (given.distance, given.radius)),
                        drive: drive.clone(),
                    };
                    entity.try_insert_if_new((ClothPresetHandle(server.load(path)), overrides));
                }
                Err(error) => problems.push(Problem::new("cloth.material", format!("is not a path: {error}"))),
            },
            _ => problems.push(Problem::new("cloth.material", "is a path, but the scene was not loaded from a file")),
        },
    }
    if let Some(thickness) = extras.thickness {
        material.thickness = thickness;
    }
    let mut solver = ClothSolver::default();
    if let Some(rate) = extras.substep_rate {
        solver.substep_rate = rate;
    }
    let pins = maps::pins(mesh, pin).map_or(ClothPins::NONE, ClothPins::from);
    let collision = ClothCollision {
        self_collision: extras.self_collision.unwrap_or(true),
        garment_layer: extras.layer.unwrap_or(0),
        ..default()
    };
    entity.try_insert_if_new((Cloth, material, solver, pins, collision));
    if let Some(limits) = maps::limits(mesh, max_distance.as_ref(), backstop.as_ref()) {
        entity.try_insert_if_new(limits);
    }
    if let Some(drive) = drive.filter(|drive| !drive.frequency.is_off()) {
        entity.try_insert_if_new(drive);
    }
    if let Some(inertia) = extras.inertia {
        entity.try_insert_if_new(inertia);
    }
    if let Some(longest_edge) = extras.subdivision {
        entity.try_insert_if_new(ClothSubdivision { longest_edge });
    }
    if let Some(shortest_edge) = extras.decimation {
        entity.try_insert_if_new(ClothDecimation { shortest_edge });
    }
    if let Some(weight) = extras.blend {
        entity.try_insert_if_new(ClothBlend { weight, ..default() });
    }
    if let Some(seconds) = extras.warm_up {
        entity.try_insert_if_new(ClothWarmUp { seconds });
    }
}

/// The file a scene was loaded from, if any.
pub(crate) struct SourceFile(Option<bevy::asset::AssetPath<'static>>);

impl core::fmt::Display for SourceFile {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match &self.0 {
            Some(path) => write!(f, "{}", path.clone().without_label()),
            None => f.write_str("a scene without a file"),
        }
    }
}

fn file_of(entity: Entity, parents: &Query<&ChildOf>, roots: &Query<&WorldAssetRoot>) -> SourceFile {
    let root = core::iter::once(entity).chain(parents.iter_ancestors(entity)).find_map(|e| roots.get(e).ok());
    SourceFile(root.and_then(|root| root.0.path()).map(|path| path.clone().into_owned().without_label().into_owned()))
}

fn warn_all(file: &SourceFile, place: &str, problems: &[Problem]) {
    for Problem { key, what } in problems {
        warn!("{file}: {place}: `{key}` {what}");
    }
}
