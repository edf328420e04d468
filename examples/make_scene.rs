//! Makes `assets/drape.glb`, the scene of the `gltf` example, or a scene for `bake` from an OBJ mesh.
//!
//! ```text
//! cargo run --example make_scene
//! cargo run --example make_scene -- --obj skirt.obj --out skirt.glb
//! ```
//!
//! The file shows the contract: cloth, pins, colliders, gravity and wind are extras of nodes and of the scene.

mod cli;
mod glb;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use drape_scenes::grid;
use glam::{Quat, Vec3, vec3};
use glb::{Glb, Surface};
use serde_json::json;

/// Makes a glTF scene with cloth.
#[derive(Parser)]
struct Arguments {
    /// A mesh whose innermost ring around the y axis is pinned, with a capsule that moves through it.
    #[arg(long)]
    obj: Option<PathBuf>,
    /// The file to write.
    #[arg(long, default_value = "assets/drape.glb")]
    out: PathBuf,
}

fn main() -> ExitCode {
    let arguments: Arguments = cli::parse("make_scene");
    let file = match &arguments.obj {
        Some(path) => std::fs::read_to_string(path)
            .map_err(|error| format!("{} cannot be read: {error}", path.display()))
            .and_then(|text| garment(&text).map_err(|why| format!("{}: {why}", path.display()))),
        None => Ok(curtain()),
    };
    let written = file.and_then(|bytes| {
        std::fs::write(&arguments.out, bytes).map_err(|error| format!("{} cannot be written: {error}", arguments.out.display()))
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            cli::complain("make_scene", &line);
            ExitCode::from(2)
        }
    }
}

/// A curtain in a draught, a ball that swings through it, and a cloth over a box.
fn curtain() -> Vec<u8> {
    let mut glb = Glb::default();
    let linen = glb.material([0.78, 0.70, 0.55], true);
    let teal = glb.material([0.05, 0.30, 0.32], true);
    let stone = glb.material([0.45, 0.44, 0.42], false);
    let wood = glb.material([0.30, 0.18, 0.10], false);

    let mut curtain = sheet(56, 48, |u, v| vec3(1.6 * (u - 0.5), 1.9 - 1.5 * v, 0.10 * (14.0 * u).sin()));
    let pins = (0..56 * 48).map(|i| if i % 48 == 0 && (i / 48) % 5 == 0 { 1.0 } else { 0.0 }).collect();
    curtain.attributes.push(("_PIN", pins));
    let mesh = glb.mesh(&curtain, linen);
    let extras = json!({ "cloth": { "material": "silk", "pin": "_PIN", "thickness": 0.006 } });
    glb.node("Curtain", mesh, Vec3::ZERO, Quat::IDENTITY, extras);

    let mesh = glb.mesh(&ball(0.22, 32), stone);
    let node = glb.node("Ball", mesh, vec3(0.0, 0.9, 1.0), Quat::IDENTITY, json!({ "collider": "ball" }));
    let times: Vec<f32> = (0..=96).map(|i| i as f32 / 24.0).collect();
    let swing: Vec<Vec3> = times.iter().map(|t| vec3(0.15, 0.9, 0.9 * (t * std::f32::consts::FRAC_PI_2).cos())).collect();
    glb.animate(node, &times, &swing);

    let mesh = glb.mesh(&cuboid(vec3(0.3, 0.25, 0.3)), wood);
    glb.node("Box", mesh, vec3(1.5, 0.25, 0.2), Quat::from_rotation_y(0.4), json!({ "collider": "cuboid" }));
    let mesh = glb.mesh(&sheet(60, 60, |u, v| vec3(1.2 * (u - 0.5), 0.0, 1.2 * (v - 0.5))), teal);
    let extras = json!({ "cloth": { "material": "cotton", "thickness": 0.016 } });
    glb.node("Throw", mesh, vec3(1.5, 0.7, 0.2), Quat::IDENTITY, extras);

    let mesh = glb.mesh(&sheet(2, 2, |u, v| vec3(6.0 * (u - 0.5), 0.0, 6.0 * (v - 0.5))), stone);
    glb.node("Floor", mesh, Vec3::ZERO, Quat::IDENTITY, json!({ "collider": { "shape": "plane", "friction": 0.8 } }));
    glb.finish(json!({ "gravity": [0.0, -9.81, 0.0], "wind": [0.6, 0.0, 0.3] }))
}

/// A garment from an OBJ file, held at the ring of vertices nearest to the y axis, and an animated capsule through it.
fn garment(text: &str) -> Result<Vec<u8>, String> {
    let mut surface = read_obj(text)?;
    let low = surface.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = surface.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let centre = (low + high) / 2.0;
    surface.positions.iter_mut().for_each(|p| *p -= vec3(centre.x, low.y, centre.z));
    let radius = |p: &Vec3| p.x.hypot(p.z);
    let inner = surface.positions.iter().map(radius).fold(f32::INFINITY, f32::min);
    let outer = surface.positions.iter().map(radius).fold(0.0, f32::max);
    let pinned: Vec<usize> = (0..surface.positions.len()).filter(|&i| radius(&surface.positions[i]) < inner * 1.02).collect();

    let mut glb = Glb::default();
    let cloth = glb.material([0.5, 0.1, 0.12], true);
    let stone = glb.material([0.45, 0.44, 0.42], false);
    let mesh = glb.mesh(&surface, cloth);
    let height = outer + 0.2;
    let extras = json!({ "cloth": { "material": "cotton", "pin": pinned } });
    glb.node("Garment", mesh, vec3(0.0, height, 0.0), Quat::IDENTITY, extras);
    let capsule = capsule(0.12 * outer, 0.6 * outer, 24);
    let mesh = glb.mesh(&capsule, stone);
    let node = glb.node("Leg", mesh, Vec3::ZERO, Quat::IDENTITY, json!({ "collider": "capsule" }));
    let times: Vec<f32> = (0..=120).map(|i| i as f32 / 24.0).collect();
    let walk: Vec<Vec3> = times
        .iter()
        .map(|t| vec3(0.35 * outer * (2.0 * t).sin(), height - 0.55 * outer, 0.35 * outer * (2.0 * t).cos()))
        .collect();
    glb.animate(node, &times, &walk);
    Ok(glb.finish(json!({ "gravity": [0.0, -9.81, 0.0] })))
}

/// Vertices and triangulated faces of an OBJ file.
fn read_obj(text: &str) -> Result<Surface, String> {
    let mut surface = Surface::default();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let bad = |what: &str| format!("line {}: {what}", number + 1);
        match words.next() {
            Some("v") => {
                let p: Vec<f32> = words.take(3).filter_map(|w| w.parse().ok()).collect();
                let &[x, y, z] = p.as_slice() else { return Err(bad("a vertex needs three numbers")) };
                surface.positions.push(vec3(x, y, z));
            }
            Some("f") => {
                let face: Option<Vec<u32>> = words.map(|w| w.split('/').next()?.parse::<u32>().ok()?.checked_sub(1)).collect();
                let face = face.filter(|f| f.len() >= 3).ok_or_else(|| bad("a face needs three vertices counted from 1"))?;
                surface.triangles.extend((1..face.len() - 1).map(|k| [face[0], face[k], face[k + 1]]));
            }
            _ => {}
        }
    }
    let count = surface.positions.len() as u32;
    if surface.triangles.is_empty() || surface.triangles.iter().flatten().any(|&v| v >= count) {
        return Err("no faces, or faces with vertices that are not there".into());
    }
    Ok(surface)
}

fn sheet(columns: u32, rows: u32, point: impl Fn(f32, f32) -> Vec3) -> Surface {
    let mesh = grid(columns, rows, point);
    let uvs = (0..columns)
        .flat_map(|i| (0..rows).map(move |j| [i as f32 / (columns - 1) as f32, j as f32 / (rows - 1) as f32]))
        .collect();
    Surface { positions: mesh.positions, uvs, triangles: mesh.triangles, attributes: Vec::new() }
}

fn ball(radius: f32, rings: u32) -> Surface {
    capsule(radius, 0.0, rings)
}

/// A capsule along y: `straight` is the length of its cylinder [m].
fn capsule(radius: f32, straight: f32, rings: u32) -> Surface {
    use std::f32::consts::{PI, TAU};
    sheet(rings * 2 + 1, rings + 1, |u, v| {
        let (turn, down) = (TAU * u, PI * v);
        let shift = if v < 0.5 { straight } else { -straight } / 2.0;
        vec3(-turn.cos() * down.sin(), down.cos(), turn.sin() * down.sin()) * radius + vec3(0.0, shift, 0.0)
    })
}

fn cuboid(half: Vec3) -> Surface {
    let mut surface = Surface::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0f32] {
            let mut normal = Vec3::ZERO;
            normal[axis] = sign;
            let side = Vec3::ONE - normal.abs();
            let across = if axis == 1 { Vec3::X } else { Vec3::Y };
            let along = normal.cross(across);
            debug_assert!((across.abs() + along.abs() - side).length() < 1.0e-6);
            let first = surface.positions.len() as u32;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                surface.positions.push((normal + across * a + along * b) * half);
            }
            surface.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    surface
}
