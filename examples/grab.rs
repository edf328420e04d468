//! A cloth that is grabbed, dragged and thrown with the mouse.
//!
//! Left: grab, drag and throw. Right-click: a blast. Without a window a script grabs the cloth, lifts it off its ball, and throws it.

mod stage;

use bevy::prelude::*;
use bevy_drape::prelude::*;
use stage::hand::{Hand, REACH, pointer, ray};
use stage::{FabricLook, OrbitCamera, Stage, fabric};

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
        .add_plugins(ClothPlugin::default())
        .init_resource::<Hand>()
        .add_systems(Startup, setup)
        .add_systems(Update, (pointer, blast).run_if(any_with_component::<Window>))
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

/// A blast on the side of the cloth that is seen.
fn blast(
    window: Single<&Window>,
    camera: Single<(&Camera, &GlobalTransform)>,
    buttons: Res<ButtonInput<MouseButton>>,
    mut ask: ParamSet<(ClothQuery, Query<&mut ClothParticles>)>,
) {
    if !buttons.just_pressed(MouseButton::Right) {
        return;
    }
    let Some(hit) = ray(&window, *camera).and_then(|ray| ask.p0().cast_ray(ray, REACH)) else { return };
    if let Ok(mut particles) = ask.p1().get_mut(hit.entity) {
        let towards = (camera.1.translation() - hit.point).normalize_or(Vec3::Y);
        particles.apply_explosion(hit.point + 0.1 * towards, BLAST.0, BLAST.1);
    }
}

/// Grabs the cloth on top of the ball, lifts it, and throws it.
fn script(
    mut commands: Commands,
    mut hand: ResMut<Hand>,
    mut thrown: Local<bool>,
    time: Res<Time>,
    cloths: ClothQuery,
    mut grips: Query<&mut ClothGrab>,
) {
    let (grabs_at, throws_at, velocity) = SCRIPT;
    let now = time.elapsed_secs();
    match hand.0 {
        None if now >= grabs_at && !*thrown => {
            let above = Ray3d::new(BALL + Vec3::new(0.05, 2.0, 0.05), Dir3::NEG_Y);
            hand.0 = cloths.cast_ray(above, REACH).map(|hit| (commands.spawn(ClothGrab::at(&hit)).id(), hit.distance));
        }
        Some((grip, _)) if now < throws_at => {
            if let Ok(mut grab) = grips.get_mut(grip) {
                // Faster and faster.
                let share = (now - grabs_at) / (throws_at - grabs_at);
                grab.target += velocity * (2.0 * share * time.delta_secs());
            }
        }
        Some((grip, _)) => {
            commands.entity(grip).despawn();
            (hand.0, *thrown) = (None, true);
        }
        None => {}
    }
}

fn report(cloth: Single<(&ClothReport, &ClothParticles)>) -> String {
    let (report, particles) = *cloth;
    let far = particles.world_positions().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    format!("worst edge {:.3} of rest, farthest particle at x = {far:.2} m", report.worst_edge)
}
