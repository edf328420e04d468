//! Cloth and physics, both ways: a ball in a net, a plank on a sheet, a flag on a mast that sways.
//!
//! The bodies are avian's. `ClothCoupling::TwoWay` gives them what cloth does to them: the net catches the ball and hangs
//! deeper for it, the sheet bears the plank, and the mast, held upright by its own springs, leans with the pull of the flag.
//! `ClothPlugin::new(FixedPostUpdate)` keeps cloth in lockstep with physics.
//!
//! R drops them again.

use std::f32::consts::FRAC_PI_2;

use avian3d::prelude::*;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_drape::prelude::*;
use drape_stage::{FabricLook, OrbitCamera, Stage, fabric};

/// Height at which net and sheet are hung up [m].
const HEIGHT: f32 = 1.2;
/// Half the length of their sides [m].
const HALF: f32 = 0.8;
/// How deep they sag by themselves [m].
const SAG: f32 = 0.22;
/// Where the net and the sheet are [m].
const NET: Vec3 = Vec3::new(-1.15, HEIGHT, 0.0);
const SHEET: Vec3 = Vec3::new(1.15, HEIGHT, 0.0);
/// Foot of the mast [m], and its height.
const MAST: (Vec3, f32) = (Vec3::new(-0.1, 0.0, -1.5), 2.9);
/// Stiffness with which the mast stands upright [N m/rad].
const UPRIGHT: f32 = 220.0;

fn main() -> AppExit {
    Stage::new("net")
        .camera(OrbitCamera::around(Vec3::new(0.05, 1.15, -0.3), 6.2).from(0.22, 0.30))
        .hint("R: again")
        .report(report)
        .build()
        .add_plugins((PhysicsPlugins::default(), ClothPlugin::new(FixedPostUpdate)))
        .insert_resource(Time::<Fixed>::from_hz(120.0))
        .insert_resource(ClothGlobalWind { turbulence: 0.5, ..ClothGlobalWind::new(Vec3::new(5.0, 0.0, 1.0)) })
        .add_systems(Startup, (floor, hangings, mast, drop))
        .add_systems(FixedUpdate, sway)
        .add_systems(Update, keys)
        .run()
}

/// What R drops again.
#[derive(Component, Clone, Copy)]
struct Dropped;

/// A mast that can lean.
#[derive(Component)]
struct Mast;

/// What net and sheet hang on: it tells how much they pull.
#[derive(Component)]
struct Frame;

fn floor(mut commands: Commands) {
    commands.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), Friction::new(0.8)));
}

fn hangings(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let wood =
        materials.add(StandardMaterial { base_color: Color::srgb(0.55, 0.38, 0.24), perceptual_roughness: 0.5, ..default() });
    let post = meshes.add(Cylinder::new(0.035, HEIGHT));
    let rail = meshes.add(Cylinder::new(0.018, 2.0 * HALF));
    // Open in meshes, so that one sees the ball through it.
    let netting = materials.add(StandardMaterial {
        base_color_texture: Some(images.add(mesh_of_cords())),
        uv_transform: bevy::math::Affine2::from_scale(Vec2::splat(20.0)),
        alpha_mode: AlphaMode::Mask(0.5),
        double_sided: true,
        cull_mode: None,
        perceptual_roughness: 0.9,
        ..default()
    });
    let linen = fabric(&mut images, &mut materials, FabricLook::Linen, Color::srgb(0.16, 0.42, 0.50), 10.0);
    // Both give way: that is how they stop what falls.
    let elastic = ClothMaterial { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, damping: 8.0, ..default() };
    let net = ClothMaterial { density: 0.25, drag_coefficient: 0.3, lift_coefficient: 0.0, ..elastic.clone() };
    let sheet = ClothMaterial { density: 0.3, ..elastic };
    for (place, material, cloth) in [(NET, netting, net), (SHEET, linen, sheet)] {
        let frame =
            commands.spawn((Transform::from_translation(place), Visibility::default(), Frame, ClothCoupling::TwoWay)).id();
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
        for (x, z) in corners {
            commands.spawn((
                Mesh3d(post.clone()),
                MeshMaterial3d(wood.clone()),
                Transform::from_xyz(x * (HALF + 0.02), -0.5 * HEIGHT, z * (HALF + 0.02)),
                ChildOf(frame),
            ));
        }
        for (side, turn) in [(Vec3::X, Quat::from_rotation_x(FRAC_PI_2)), (Vec3::Z, Quat::from_rotation_z(FRAC_PI_2))] {
            for end in [-HALF - 0.02, HALF + 0.02] {
                commands.spawn((
                    Mesh3d(rail.clone()),
                    MeshMaterial3d(wood.clone()),
                    Transform::from_translation(side * end).with_rotation(turn),
                    ChildOf(frame),
                ));
            }
        }
        commands.spawn((
            Mesh3d(meshes.add(sagging()?)),
            MeshMaterial3d(material),
            Transform::from_translation(place),
            Cloth,
            cloth,
            // What a kilogram falls into takes more substeps than a flag, and hangs in the lee.
            ClothSolver { substep_rate: 720.0, ..default() },
            ClothWind::default(),
            ClothPins::where_position(|p| p.x.abs().max(p.z.abs()) > HALF - 0.001).to(frame),
        ));
    }
    Ok(())
}

/// A sheet whose middle hangs lower than its border.
fn sagging() -> Result<Mesh> {
    let mut mesh = Plane3d::default().mesh().size(2.0 * HALF, 2.0 * HALF).subdivisions(38).build();
    if let VertexAttributeValues::Float32x3(points) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION)? {
        for p in points {
            let across = |x: f32| 1.0 - (x / HALF).powi(2);
            p[1] = -SAG * across(p[0]) * across(p[2]);
        }
    }
    mesh.compute_smooth_normals();
    Ok(mesh.with_generated_tangents()?)
}

/// Two cords that cross, and nothing between them.
fn mesh_of_cords() -> Image {
    const SIZE: u32 = 64;
    let texel = |i: u32| {
        let (x, y) = (i % SIZE, i / SIZE);
        let off = |a: u32| (a as f32 + 0.5 - 0.5 * SIZE as f32).abs() / SIZE as f32;
        let thread = off(x).min(off(y));
        let shade = (230.0 - 700.0 * thread) as u8;
        if thread < 0.085 { [shade, shade, shade - 20, 255] } else { [200, 200, 185, 0] }
    };
    let mut image = Image::new(
        bevy::render::render_resource::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
        bevy::render::render_resource::TextureDimension::D2,
        (0..SIZE * SIZE).flat_map(texel).collect(),
        bevy::render::render_resource::TextureFormat::Rgba8UnormSrgb,
        bevy::asset::RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = bevy::image::ImageSampler::Descriptor(bevy::image::ImageSamplerDescriptor {
        address_mode_u: bevy::image::ImageAddressMode::Repeat,
        address_mode_v: bevy::image::ImageAddressMode::Repeat,
        ..bevy::image::ImageSamplerDescriptor::linear()
    });
    image
}

fn mast(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let steel = materials.add(StandardMaterial {
        base_color: Color::srgb(0.75, 0.76, 0.78),
        metallic: 0.8,
        perceptual_roughness: 0.35,
        ..default()
    });
    let (foot, height) = MAST;
    let size = Vec2::new(1.5, 0.95);
    let mast = commands
        .spawn((
            Mesh3d(meshes.add(Cylinder::new(0.03, height))),
            MeshMaterial3d(steel),
            Transform::from_translation(foot + Vec3::Y * (0.5 * height)),
            // It turns about its foot, and nothing but its flag and its springs moves it.
            RigidBody::Dynamic,
            LockedAxes::TRANSLATION_LOCKED.lock_rotation_y(),
            Mass(6.0),
            AngularInertia::new(Vec3::new(1.0, 0.1, 1.0) * (6.0 * height * height / 3.0)),
            CenterOfMass::new(0.0, -0.5 * height, 0.0),
            AngularDamping(1.5),
            TransformInterpolation,
            ClothCoupling::TwoWay,
            Mast,
        ))
        .id();
    let flag = Plane3d::new(Vec3::Z, size / 2.0).mesh().subdivisions(40).build().with_generated_tangents()?;
    commands.spawn((
        Mesh3d(meshes.add(flag)),
        MeshMaterial3d(fabric(
            &mut images,
            &mut materials,
            FabricLook::Stripes(Color::srgb(0.95, 0.94, 0.90)),
            Color::srgb(0.72, 0.08, 0.10),
            2.0,
        )),
        Transform::from_translation(foot + Vec3::new(0.5 * size.x + 0.03, height - 0.5 * size.y - 0.03, 0.0)),
        Cloth,
        ClothMaterial::COTTON,
        ClothPins::where_position(move |p| p.x < -0.499 * size.x).to(mast),
    ));
    Ok(())
}

/// Springs in the socket of the mast turn it upright.
fn sway(mut masts: Query<(Forces, &Rotation), With<Mast>>) {
    for (mut forces, rotation) in &mut masts {
        let lean = (rotation.0 * Vec3::Y).cross(Vec3::Y);
        forces.apply_torque(UPRIGHT * lean);
    }
}

fn drop(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let rubber = StandardMaterial { base_color: Color::srgb(0.85, 0.30, 0.08), perceptual_roughness: 0.45, ..default() };
    let wood = StandardMaterial { base_color: Color::srgb(0.72, 0.52, 0.32), perceptual_roughness: 0.6, ..default() };
    let body = (RigidBody::Dynamic, ClothCoupling::TwoWay, TransformInterpolation, AngularDamping(0.3), Dropped);
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.2).mesh().uv(64, 32))),
        MeshMaterial3d(materials.add(rubber)),
        Transform::from_translation(NET + Vec3::new(0.1, 0.75, 0.05)),
        Collider::sphere(0.2),
        Mass(1.0),
        body,
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cuboid::new(0.85, 0.05, 0.22))),
        MeshMaterial3d(materials.add(wood)),
        Transform::from_translation(SHEET + Vec3::new(-0.1, 0.45, 0.0)).with_rotation(Quat::from_euler(
            EulerRot::YZX,
            0.5,
            0.3,
            0.1,
        )),
        Collider::cuboid(0.85, 0.05, 0.22),
        Mass(1.0),
        body,
    ));
}

fn keys(mut commands: Commands, keys: Res<ButtonInput<KeyCode>>, dropped: Query<Entity, With<Dropped>>) {
    if keys.just_pressed(KeyCode::KeyR) {
        dropped.iter().for_each(|body| commands.entity(body).despawn());
        commands.run_system_cached(drop);
    }
}

fn report(frames: Query<&ClothReaction, With<Frame>>, dropped: Query<(&Position, &LinearVelocity), With<Dropped>>) -> String {
    let frames = frames.iter().map(|reaction| format!("a frame bears {:.2} N\n", -reaction.force().y));
    let bodies = dropped.iter().map(|(at, v)| format!("a body of 1 kg at {:.3} m moves at {:.3} m/s\n", at.y, v.length()));
    frames.chain(bodies).collect()
}
