//! Puts the floor, the lights and the camera in place.

use super::{
    environment, floor, hint, light,
    orbit::{self, OrbitCamera, PointerTaken},
    quality::Quality,
    shutter::Film,
};
use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    image::{CompressedImageFormatSupport, CompressedImageFormats},
    light::{DirectionalLightShadowMap, GlobalAmbientLight},
    prelude::*,
    render::{
        camera::{MipBias, TemporalJitter},
        view::{ColorGrading, ColorGradingGlobal, ColorGradingSection},
    },
};

/// The stage in a window.
pub fn window(app: &mut App, camera: OrbitCamera, quality: Quality, words: String) {
    stage(app, camera, quality);
    app.init_resource::<PointerTaken>()
        .add_systems(PreStartup, move |mut commands: Commands| hint::spawn(&mut commands, &words))
        .add_systems(Update, ((orbit::yield_to_panels, orbit::turn).chain(), hint::pause));
}

/// The stage in front of a film.
pub fn studio(app: &mut App, camera: OrbitCamera, quality: Quality) {
    let film = Film::new(&mut app.world_mut().resource_mut::<Assets<Image>>(), quality.size);
    app.insert_resource(film).insert_resource(quality.words());
    stage(app, camera, quality);
}

/// No stage, but a camera for examples that look for it.
pub fn dark(app: &mut App, camera: OrbitCamera) {
    app.insert_resource(CompressedImageFormatSupport(CompressedImageFormats::NONE))
        .init_resource::<PointerTaken>()
        .add_systems(PreStartup, move |mut commands: Commands| {
            commands.spawn((camera, camera.transform()));
        });
}

/// What windows and films have in common.
fn stage(app: &mut App, camera: OrbitCamera, quality: Quality) {
    app.insert_resource(quality)
        .insert_resource(DirectionalLightShadowMap { size: quality.shadow_map })
        .insert_resource(GlobalAmbientLight { brightness: 0.0, ..default() })
        .insert_resource(ClearColor(Color::LinearRgba(LinearRgba::from_vec3(environment::HORIZON))))
        .init_resource::<PointerTaken>()
        .add_systems(
            PreStartup,
            move |mut commands: Commands,
                  mut meshes: ResMut<Assets<Mesh>>,
                  mut materials: ResMut<Assets<StandardMaterial>>,
                  mut images: ResMut<Assets<Image>>,
                  film: Option<Res<Film>>| {
                // Radiance 1 is white before the tone mapping.
                let brightness = 1.0 / Exposure::default().exposure();
                floor::spawn(&mut commands, &mut meshes, &mut materials, &mut images);
                light::spawn(&mut commands, &quality, brightness);
                let mut eye = commands.spawn((
                    eye(camera, &quality),
                    environment::light(&mut images, light::unshadowed(&quality), brightness),
                    environment::backdrop(&mut images, brightness),
                ));
                if let Some(film) = film {
                    eye.insert((film.target(), TemporalJitter::default(), MipBias(quality.mip_bias)));
                    eye.insert(Camera { is_active: false, ..default() });
                }
            },
        )
        .add_systems(PostUpdate, (orbit::place, light::follow).before(TransformSystems::Propagate));
}

/// A little more colour and contrast than the tone mapping leaves.
fn grading() -> ColorGrading {
    let section = ColorGradingSection { contrast: 1.015, ..default() };
    ColorGrading {
        global: ColorGradingGlobal { post_saturation: 1.08, ..default() },
        shadows: section,
        midtones: section,
        highlights: section,
    }
}

/// The camera itself.
fn eye(camera: OrbitCamera, quality: &Quality) -> impl Bundle {
    let lens = PerspectiveProjection { fov: 0.6, near: 0.05, ..default() };
    (
        Camera3d::default(),
        Hdr,
        Projection::Perspective(lens),
        camera,
        camera.transform(),
        quality.msaa,
        quality.shadow_filter,
        Tonemapping::TonyMcMapface,
        DebandDither::Enabled,
        grading(),
        DistanceFog { color: Color::LinearRgba(LinearRgba::from_vec3(environment::HORIZON)), ..default() },
    )
}
