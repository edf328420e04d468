//! The three states of the paper's figures 4 and 5, side by side: above with the method of 2006, below with ours.
//!
//! Every cell is a pair of sheets of its own from the same start. What reaches the state of its column is kept as a picture:
//! left as it is, taken apart until most of it is done, taken apart for good.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_drape::ClothIslands;
use bevy_drape::debug::{ClothGizmos, contour_color};
use bevy_drape::prelude::*;
use bevy_drape::solver::resolve::ContourKind;
use drape_scenes as scenes;

use super::label::label;
use super::state::State;
use super::{counts, grid_mesh, upright};

/// Methods, from above, and what they are called.
const ROWS: [(ClothUntanglingMethod, &str); 2] =
    [(ClothUntanglingMethod::LocalGradient, "2006: local gradient"), (ClothUntanglingMethod::ByEndType, "ours: by end type")];
/// States, from the left.
const COLUMNS: [State; 3] = [State::Tangled, State::MostlySeparated, State::Separated];
/// Distance between columns and between rows, and the height of the lower row [m].
const APART: (f32, f32, f32) = (1.5, 1.12, 0.62);

/// The middle of the picture [m].
pub const MIDDLE: Vec3 = Vec3::new(0.0, APART.2 + 0.5 * APART.1 - 0.02, 0.0);

/// Part of the picture that must go when another takes its place.
#[derive(Component, Clone, Copy)]
pub struct Prop;

/// A pair of sheets that goes on until it has reached a state; the words below it carry this.
#[derive(Component)]
pub struct Cell {
    until: State,
    at: Vec3,
    /// None once they are a picture.
    sheets: Option<[Entity; 2]>,
    /// Where they crossed then [m].
    curves: Vec<(ContourKind, [Vec3; 2])>,
    /// The most that ever crossed.
    most: u32,
    /// When nothing crossed any more [s].
    clean: Option<f32>,
}

/// Spawns all cells, of sheets of `n` x `n` vertices in two materials.
pub fn spawn(commands: &mut Commands, meshes: &mut Assets<Mesh>, materials: [Handle<StandardMaterial>; 2], n: u32) {
    let sheets = scenes::driven(n).map(|sheet| meshes.add(grid_mesh(&sheet)));
    let (across, up, low) = APART;
    for (row, (method, name)) in ROWS.into_iter().enumerate() {
        let height = low + up * (1 - row) as f32;
        for (column, until) in COLUMNS.into_iter().enumerate() {
            let at = Vec3::new(across * (column as f32 - 1.0), height, 0.0);
            let untangle = ClothUntangling::default().with_method(method);
            // The first is only measured.
            let untangle = if column == 0 { ClothUntangling { iterations: 0, ..untangle } } else { untangle };
            let pair = [0, 1].map(|k| {
                // As in the paper, nothing keeps the sheets from crossing.
                let only = ClothCollision { self_collision: false, contact: false, ..default() };
                let cloth = (Cloth, ClothMaterial::COTTON, untangle, only, ClothSkipFrame::OFF);
                let place = Transform::from_translation(at).with_rotation(Quat::from_rotation_y(0.45) * upright());
                let pins = if k == 0 { ClothPins::where_position(|p| p.x.abs().min(p.y.abs()) > 0.499) } else { default() };
                commands.spawn((cloth, Mesh3d(sheets[k].clone()), MeshMaterial3d(materials[k].clone()), place, pins)).id()
            });
            let cell = Cell { until, at, sheets: Some(pair), curves: Vec::new(), most: 0, clean: None };
            commands.spawn((Prop, cell, label(at - 0.34 * Vec3::Y, "", 12.0)));
        }
        commands.spawn((Prop, label(Vec3::new(0.0, height + 0.42, 0.0), name, 16.0)));
    }
}

/// Says what crosses, and makes a picture of what has reached its state.
pub fn watch(
    mut commands: Commands,
    mut cells: Query<(&mut Cell, &mut Text)>,
    sheets: Query<(&ClothReport, &Mesh3d, &MeshMaterial3d<StandardMaterial>, &Transform)>,
    islands: Res<ClothIslands>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    for (mut cell, _) in &mut cells {
        let report = cell.sheets.and_then(|pair| sheets.get(pair[0]).ok()).map_or(0, |sheet| sheet.0.crossings);
        cell.most = cell.most.max(report);
    }
    // All started alike, but only where nothing is taken apart is that still to be seen after the first frame.
    let most = cells.iter().map(|(cell, _)| cell.most).max().unwrap_or(0);
    for (mut cell, mut text) in &mut cells {
        let Some(pair) = cell.sheets else { continue };
        let Ok((report, ..)) = sheets.get(pair[0]) else { continue };
        if report.time == 0.0 {
            continue;
        }
        let state = State::of(report.crossings, most);
        cell.clean = (state == State::Separated).then(|| cell.clean.unwrap_or(report.time));
        let after = if cell.until == State::Tangled { 0.0 } else { cell.clean.unwrap_or(report.time) };
        let still = if cell.until == State::Separated && cell.clean.is_none() { "still " } else { "" };
        text.0 = format!("{still}{state}\n{}\nafter {after:.2} s", counts(report));
        // Those that shall come apart for good go on: they must stay so.
        if state >= cell.until && cell.until != State::Separated {
            let here = |[end, _]: &[Vec3; 2]| ((end - cell.at).abs().xy() * 2.0).cmplt(Vec2::new(APART.0, APART.1)).all();
            let curves = islands.contours().map(|(kind, ends)| (kind, ends.map(DVec3::as_vec3)));
            let curves = curves.filter(|(_, ends)| here(ends)).collect();
            cell.curves = curves;
            for sheet in pair {
                if let Ok((_, mesh, material, place)) = sheets.get(sheet)
                    && let Some(mesh) = meshes.get(&mesh.0).cloned()
                {
                    commands.spawn((Prop, Mesh3d(meshes.add(mesh)), material.clone(), *place));
                }
                commands.entity(sheet).despawn();
            }
            cell.sheets = None;
        }
    }
}

/// Where the sheets of pictures cross.
pub fn curves(mut gizmos: Gizmos<ClothGizmos>, cells: Query<&Cell>) {
    for (kind, [from, to]) in cells.iter().flat_map(|cell| &cell.curves) {
        gizmos.line(*from, *to, contour_color(*kind));
    }
}

/// What every cell says, in one line each.
pub fn report(labels: Query<&Text, With<Cell>>) -> String {
    labels.iter().map(|text| text.0.replace('\n', ", ") + "\n").collect()
}
