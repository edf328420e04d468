//! Shows what is held as a ghost: while the last clean shape is shown in place of a tangled one, that shape becomes translucent
//! and the live one is drawn as well.

use bevy::math::DVec3;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_drape::ClothRest;
use bevy_drape::prelude::*;

/// How much of what lies behind a ghost it hides.
const OPACITY: f32 = 0.28;
/// A cloth is held where what is shown is farther than this from where it is [m].
const APART: f64 = 1.0e-4;

/// A cloth, what it looks like, and what is drawn while it is held.
#[derive(Component)]
pub struct Haunted {
    solid: Handle<StandardMaterial>,
    ghost: Handle<StandardMaterial>,
    live: Entity,
}

/// Gives every cloth a double for its live shape.
pub fn conjure(
    mut commands: Commands,
    cloths: Query<(Entity, &Mesh3d, &MeshMaterial3d<StandardMaterial>), (With<Cloth>, Without<Haunted>)>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (cloth, mesh, solid) in &cloths {
        let (Some(mesh), Some(look)) = (meshes.get(&mesh.0).cloned(), materials.get(&solid.0).cloned()) else { continue };
        let look = StandardMaterial {
            base_color: look.base_color.with_alpha(OPACITY),
            alpha_mode: AlphaMode::Blend,
            diffuse_transmission: 0.0,
            ..look
        };
        let ghost = materials.add(look);
        let live = commands.spawn((Mesh3d(meshes.add(mesh)), solid.clone(), Transform::IDENTITY, Visibility::Hidden)).id();
        commands.entity(cloth).insert(Haunted { solid: solid.0.clone(), ghost, live });
    }
}

/// Draws the live shape where another is held.
pub fn appear(
    cloths: Query<(&Haunted, &ClothParticles, &ClothRest, &mut MeshMaterial3d<StandardMaterial>), With<Cloth>>,
    mut doubles: Query<(&Mesh3d, &mut Visibility), Without<Cloth>>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    for (haunted, particles, rest, mut material) in cloths {
        let Ok((mesh, mut visibility)) = doubles.get_mut(haunted.live) else { continue };
        let mut pairs = particles.world_positions().zip(particles.shown_positions());
        let held = pairs.any(|(live, shown)| live.distance(shown) > APART);
        let look = if held { &haunted.ghost } else { &haunted.solid };
        if material.0 != *look {
            material.0 = look.clone();
        }
        visibility.set_if_neq(if held { Visibility::Visible } else { Visibility::Hidden });
        if held && let Some(mut mesh) = meshes.get_mut(&mesh.0) {
            let live: Vec<Vec3> = particles.world_positions().map(DVec3::as_vec3).collect();
            follow(&mut mesh, &live, &rest.shape().particle_of_vertex);
        }
    }
}

/// Ends the double of a cloth that is gone.
pub fn banish(gone: On<Remove, Haunted>, haunted: Query<&Haunted>, mut commands: Commands) {
    if let Ok(haunted) = haunted.get(gone.entity) {
        commands.entity(haunted.live).try_despawn();
    }
}

/// Puts the vertices of a mesh where their particles are [m].
fn follow(mesh: &mut Mesh, particles: &[Vec3], particle_of_vertex: &[u32]) {
    if let Ok(VertexAttributeValues::Float32x3(positions)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION) {
        for (to, &p) in positions.iter_mut().zip(particle_of_vertex) {
            *to = particles.get(p as usize).copied().unwrap_or_default().to_array();
        }
        mesh.compute_smooth_normals();
    }
}
