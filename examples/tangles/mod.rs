//! What the two examples about untangling share: sheets from the scenes, curves drawn as lines, words about how far a tangle
//! has come apart.
#![allow(dead_code, reason = "each example uses a part")]

pub mod ghost;
pub mod label;
pub mod state;
pub mod three_states;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy::ui::IsDefaultUiCamera;
use bevy_drape::debug::{ClothDebug, ClothDebugPlugin, ClothGizmos};
use bevy_drape::prelude::*;
use bevy_drape::solver::rest::SourceMesh;
use state::{Most, State};

/// Draws curves, the panel and labels.
pub fn plugin(app: &mut App) {
    // Unless the command line asks for something else.
    let asked = app.world().get_resource::<ClothDebug>().is_some_and(|debug| *debug != ClothDebug::none());
    if !app.is_plugin_added::<ClothDebugPlugin>() {
        app.add_plugins(ClothDebugPlugin);
    }
    if !asked {
        app.insert_resource(ClothDebug::only(["contours"]));
    }
    app.add_systems(Startup, (panel, pen))
        .add_systems(PostStartup, adopt)
        .add_systems(Update, (three_states::curves, state::remember))
        .add_systems(PostUpdate, label::place.after(TransformSystems::Propagate));
}

/// Words that change.
#[derive(Component)]
pub struct Panel;

/// Colour of words.
pub const INK: Color = Color::srgb(0.08, 0.08, 0.10);

fn panel(mut commands: Commands) {
    commands.spawn((
        Panel,
        Text::default(),
        TextFont { font_size: FontSize::Px(15.0), ..default() },
        TextColor(INK),
        Node { position_type: PositionType::Absolute, bottom: px(12), left: px(12), ..default() },
    ));
}

/// Panel and labels belong to the camera of the stage, with or without a window.
fn adopt(mut commands: Commands, cameras: Query<Entity, With<Camera3d>>) {
    cameras.iter().for_each(|camera| {
        commands.entity(camera).insert(IsDefaultUiCamera);
    });
}

/// Lines are thick and in front of everything.
fn pen(mut store: ResMut<GizmoConfigStore>) {
    let (config, _) = store.config_mut::<ClothGizmos>();
    (config.line.width, config.depth_bias) = (3.5, -1.0);
}

/// What a cloth has to say about itself and what it cost, which no two runs agree on.
pub fn line_with_time(report: &ClothReport, most: &Most) -> String {
    let ms = report.integrate_ms + report.detect_ms + report.resolve_ms + report.evaluate_ms + report.respond_ms;
    format!("{} ({ms:.2} ms)", line(report, most))
}

/// What a cloth has to say about itself.
pub fn line(report: &ClothReport, most: &Most) -> String {
    let state = State::of(report.crossings, most.0);
    let since = if report.crossings > 0 { format!(" for {:.2} s", report.tangled_for) } else { String::new() };
    let held = if report.held { format!(", {} held frames", report.held_frames) } else { String::new() };
    format!("{state}{since}, {}{held}", counts(report))
}

/// What crosses.
pub fn counts(report: &ClothReport) -> String {
    let plural = |n: u32, one: &str| if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") };
    let (crossings, curves) = (plural(report.crossings, "crossing"), plural(report.contours, "curve"));
    format!("{crossings}, {curves}, {:.0} cm", 100.0 * report.contour_length)
}

/// What is up in the formulas lies along z; here it lies along y.
pub fn upright() -> Quat {
    Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2)
}

/// A mesh for one of the solver, which is a grid: its texture follows the columns and rows, once along the longer side.
pub fn grid_mesh(source: &SourceMesh) -> Mesh {
    // The first quad has the corners 0, 1, rows and rows + 1.
    let rows = source.triangles.first().map_or(1, |t| t.iter().copied().max().unwrap_or(1)) as usize;
    let columns = source.positions.len() / rows;
    let cells = (rows.max(columns) - 1) as f32;
    mesh(source, |i| [(i / rows) as f32 / cells, (i % rows) as f32 / cells])
}

fn mesh(source: &SourceMesh, coordinates: impl Fn(usize) -> [f32; 2]) -> Mesh {
    let positions: Vec<[f32; 3]> = source.positions.iter().map(Vec3::to_array).collect();
    let uvs: Vec<[f32; 2]> = (0..positions.len()).map(coordinates).collect();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(source.triangles.iter().flat_map(|&[a, b, c]| [a, c, b]).collect()))
        .with_computed_smooth_normals();
    mesh.clone().with_generated_tangents().unwrap_or(mesh)
}
