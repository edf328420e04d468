//! A cloth that is grabbed, dragged and thrown with the mouse.
//!
//! Left: grab, drag and throw. Right-click: a blast. Without a window a script grabs the cloth, lifts it off its ball, and
//! throws it.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use drape_stage::{FabricLook, OrbitCamera, Stage, fabric, hand};

/// Where the ball lies [m].
const BALL: Vec3 = Vec3::new(0.0, 0.35, 0.0);
/// Radius of the ball [m].
const RADIUS: f32 = 0.35;
/// What a blast gives to the whole cloth [N·s], and how far it reaches [m].
const BLAST: (f32, f32) = (1.0, 0.6);

/// The script of a run without a window: when it grabs, when it lets go, and the velocity of its hand at the end [s, s, m/s].
const SCRIPT: (f32, f32, Vec3) = (1.0, 2.2, Vec3::new(1.2, 1.2, 0.0));

fn main() -> AppExit {
    Stage::new("grab")
        .camera(OrbitCamera::around(Vec3::new(0.1, 0.5, 0.0), 3.2).from(0.35, 0.3))
        .hint("Left: grab, drag, throw    Right-click: a blast")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), hand::plugin))
        .add_systems(Startup, setup)
        .add_observer(blast)
        .add_systems(Update, script.run_if(not(any_with_component::<Window>)))
        .run()
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let sheet = Plane3d::default().mesh().size(1.2, 1.2).subdivisions(46).build().with_generated_tangents()?;
    commands.spawn((
        Mesh3d(meshes.add(sheet)),
        MeshMaterial3d(fabric(&mut images, &mut materials, FabricLook::Cotton, Color::srgb(0.85, 0.55, 0.15), 8.0)),
        Transform::from_translation(BALL + Vec3::Y * (RADIUS + 0.05)),
        Cloth,
        ClothDraggable::default(),
        ClothMaterial::COTTON,
    ));
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(RADIUS - 0.005).mesh().uv(64, 32))),
        MeshMaterial3d(materials.add(Color::srgb(0.55, 0.55, 0.58))),
        Transform::from_translation(BALL),
        ClothCollider::ball(RADIUS),
    ));
    commands.spawn(ClothCollider::ground());
    Ok(())
}

/// A right-click is a blast on the side of the cloth that is seen.
fn blast(press: On<Pointer<Press>>, camera: Single<&GlobalTransform, With<Camera>>, mut cloths: Query<&mut ClothParticles>) {
    if press.button != PointerButton::Secondary {
        return;
    }
    if let (Ok(mut particles), Some(point)) = (cloths.get_mut(press.entity), press.hit.position) {
        let towards = (camera.translation() - point).normalize_or(Vec3::Y);
        particles.apply_explosion(point + 0.1 * towards, BLAST.0, BLAST.1);
    }
}

/// Grabs the cloth on top of the ball, lifts it, and throws it.
fn script(
    mut commands: Commands,
    mut grip: Local<Option<Entity>>,
    mut thrown: Local<bool>,
    time: Res<Time>,
    cloths: ClothQuery,
    mut grips: Query<&mut ClothGrab>,
) {
    let (grabs_at, throws_at, velocity) = SCRIPT;
    let now = time.elapsed_secs();
    match *grip {
        None if now >= grabs_at && !*thrown => {
            let above = Ray3d::new(BALL + Vec3::new(0.05, 2.0, 0.05), Dir3::NEG_Y);
            *grip = cloths.cast_ray(above, 20.0).map(|hit| commands.spawn(ClothGrab::at(&hit)).id());
        }
        Some(held) if now < throws_at => {
            if let Ok(mut grab) = grips.get_mut(held) {
                // Faster and faster.
                let share = (now - grabs_at) / (throws_at - grabs_at);
                grab.target += velocity * (2.0 * share * time.delta_secs());
            }
        }
        Some(held) => {
            commands.entity(held).despawn();
            (*grip, *thrown) = (None, true);
        }
        None => {}
    }
}

fn report(cloth: Single<(&ClothReport, &ClothParticles)>) -> String {
    let (report, particles) = *cloth;
    let far = particles.world_positions().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    format!("worst edge {:.3} of rest, farthest particle at x = {far:.2} m", report.worst_edge)
}
