//! Where cloth touches cloth and bodies, and how hard.
//!
//! Contacts are known between Integrate, which solves them, and Detect, which looks for those of the next frame. They are
//! remembered from then, so that they are still drawn while time stands still.

use bevy::prelude::*;

use super::{ClothDebug, ClothGizmos, place, scale};
use crate::components::Cloth;
use crate::islands::ClothIslands;
use crate::simulation::ClothParticles;
use crate::time::ClothTime;

/// What touched in the last simulated frame, in the world.
#[derive(Resource, Default)]
pub(super) struct Touched {
    /// The closest points `[m]`, the direction of the force on the first, and its strength `[N]`.
    cloth: Vec<([Vec3; 2], Vec3, f32)>,
    /// Where a particle touched a body `[m]`, and the force of the body on it `[N]`.
    bodies: Vec<(Vec3, f32)>,
}

/// Between Integrate and Detect.
pub(super) fn remember(
    time: Res<ClothTime>,
    islands: Res<ClothIslands>,
    cloths: Query<&ClothParticles, With<Cloth>>,
    mut touched: ResMut<Touched>,
) {
    if time.delta_secs() == 0.0 {
        return;
    }
    let Touched { cloth, bodies } = &mut *touched;
    cloth.clear();
    bodies.clear();
    for island in &islands.list {
        let pairs = island.solver.touching_pairs();
        cloth.extend(pairs.map(|pair| (pair.points.map(|x| place(island.origin, x)), pair.normal, pair.force)));
    }
    for particles in &cloths {
        let state = particles.state();
        bodies.extend(particles.sim.memory.body_forces(state).filter_map(|(p, force)| {
            let x = state.positions.get(p as usize)?.truncate();
            Some((place(particles.origin(), x), force))
        }));
    }
}

pub(super) fn draw(debug: Res<ClothDebug>, mut gizmos: Gizmos<ClothGizmos>, touched: Res<Touched>) {
    let longest = debug.length.clamp(0.0, 100.0);
    // Weak forces have short lines, but none so short that it is not seen.
    let length = |share: f32| longest * (0.2 + 0.8 * share);
    for &([first, second], normal, force) in &touched.cloth {
        let share = scale::force(force);
        gizmos.line(first, first + normal * length(share), scale::sequential(share));
        gizmos.line(second, second - normal * length(share), scale::sequential(share));
    }
    for &(at, force) in &touched.bodies {
        let share = scale::force(force);
        gizmos.cross(Isometry3d::from_translation(at), 0.5 * length(share), scale::sequential(share));
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use bevy::gizmos::GizmoPlugin;
    use bevy::mesh::MeshPlugin;
    use bevy::time::TimeUpdateStrategy;

    use super::*;
    use crate::components::{ClothCollider, ClothMaterial};
    use crate::debug::ClothDebugPlugin;
    use crate::plugin::ClothPlugin;

    #[test]
    fn the_force_of_a_body_on_what_lies_still_is_its_weight_and_that_of_cloth_no_more() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, GizmoPlugin));
        app.add_plugins((ClothPlugin::default(), ClothDebugPlugin));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(1.0 / 60.0)));
        app.finish();
        app.cleanup();
        app.world_mut().spawn(ClothCollider::ground());
        for (size, subdivisions, height) in [(1.0, 15, 0.006), (0.5, 6, 0.012)] {
            let mesh = Plane3d::default().mesh().size(size, size).subdivisions(subdivisions).build();
            let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
            let material = ClothMaterial { density: 0.2, ..ClothMaterial::COTTON };
            app.world_mut().spawn((Mesh3d(mesh), Cloth, material, Transform::from_xyz(0.01, height, 0.02)));
        }
        let (mut bodies, mut cloth) = (0.0, 0.0);
        for frame in 0..240 {
            app.update();
            let touched = app.world().resource::<Touched>();
            if frame >= 180 {
                bodies += touched.bodies.iter().map(|(_, force)| force).sum::<f32>() / 60.0;
                cloth += touched.cloth.iter().map(|(_, normal, force)| force * normal.y.abs()).sum::<f32>() / 60.0;
            }
        }
        let weight = |area: f32| area * 0.2 * 9.81;
        // What lies on cloth that lies on a body is carried by that cloth being heavier, and not counted again below it.
        assert!((bodies / weight(1.0) - 1.0).abs() < 0.1, "{bodies} N on {} N", weight(1.0));
        // Of cloth that hardly moves the pushes are spread over two passes, and the mean shows only which contacts bear more.
        assert!(cloth > 0.2 * weight(0.25) && cloth < 1.1 * weight(0.25), "{cloth} N on {} N", weight(0.25));
    }
}
