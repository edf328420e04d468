//! What the two examples about untangling share: sheets from the scenes, curves drawn as lines, a panel of text.
#![allow(dead_code, reason = "each example uses a part")]

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy::ui::IsDefaultUiCamera;
use bevy_drape::ClothGroups;
use bevy_drape::prelude::*;
use bevy_drape::solver::rest::SourceMesh;

/// Draws curves and the panel.
pub fn plugin(app: &mut App) {
    app.add_systems(Startup, (panel, pen)).add_systems(PostStartup, adopt).add_systems(Update, curves);
}

/// Words that change.
#[derive(Component)]
pub struct Panel;

fn panel(mut commands: Commands) {
    commands.spawn((
        Panel,
        Text::default(),
        TextFont { font_size: FontSize::Px(15.0), ..default() },
        TextColor(Color::srgb(0.08, 0.08, 0.10)),
        Node { position_type: PositionType::Absolute, bottom: px(12), left: px(12), ..default() },
    ));
}

/// The panel belongs to the camera of the stage, with or without a window.
fn adopt(mut commands: Commands, cameras: Query<Entity, With<Camera3d>>) {
    cameras.iter().for_each(|camera| {
        commands.entity(camera).insert(IsDefaultUiCamera);
    });
}

/// Lines are thick and in front of everything.
fn pen(mut store: ResMut<GizmoConfigStore>) {
    let (config, _) = store.config_mut::<DefaultGizmoConfigGroup>();
    (config.line.width, config.depth_bias) = (5.0, -1.0);
}

/// Every intersection curve as a line, each in a colour of its own.
fn curves(mut gizmos: Gizmos, groups: Option<Res<ClothGroups>>) {
    for (curve, [from, to]) in groups.iter().flat_map(|groups| groups.contours()) {
        let color = Color::hsl(curve as f32 * 137.5 % 360.0, 1.0, 0.5);
        gizmos.line(from.as_vec3(), to.as_vec3(), color);
    }
}

/// What a cloth has to say about itself.
pub fn line(report: &ClothReport) -> String {
    let ClothReport { crossings, contours, contour_length, tangled_for, .. } = report;
    let state = if *crossings == 0 { "clean".into() } else { format!("tangled for {tangled_for:.2} s") };
    let held = if report.held { ", held" } else { "" };
    let ms = report.integrate_ms + report.detect_ms + report.resolve_ms + report.evaluate_ms;
    format!("{crossings} crossings, {contours} curves, {:.1} cm: {state}{held} ({ms:.2} ms)", 100.0 * contour_length)
}

/// A mesh with texture coordinates for one of the solver.
pub fn mesh(source: &SourceMesh, coordinates: impl Fn(usize) -> [f32; 2]) -> Mesh {
    let positions: Vec<[f32; 3]> = source.positions.iter().map(Vec3::to_array).collect();
    let uvs: Vec<[f32; 2]> = (0..positions.len()).map(coordinates).collect();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(source.triangles.iter().flat_map(|&[a, b, c]| [a, c, b]).collect()))
        .with_computed_smooth_normals();
    mesh.clone().with_generated_tangents().unwrap_or(mesh)
}
