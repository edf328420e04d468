//! Eyeballs: spheres with a dark iris, in the sockets of the head.

use std::f32::consts::{PI, TAU};

use glam::vec3;

use crate::glb::skinned::SkinnedSurface;
use crate::head::{EYE, EYE_RADIUS};
use crate::skeleton::{HEAD, mirrored};

/// Around and from the pupil to the back.
const COLUMNS: u32 = 20;
const ROWS: u32 = 10;
/// Half the angle that the iris takes [rad].
const IRIS: f32 = 0.56;

/// Adds the vertices of both eyes; triangles of the whites and of the irises come back.
pub fn add(surface: &mut SkinnedSurface) -> [Vec<[u32; 3]>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    for side in 0..2 {
        let centre = mirrored(EYE, side);
        let first = surface.positions.len() as u32;
        for row in 0..=ROWS {
            // The third row is the rim of the iris.
            let angle =
                if row <= 3 { IRIS * row as f32 / 3.0 } else { IRIS + (PI - IRIS) * (row - 3) as f32 / (ROWS - 3) as f32 };
            for column in 0..COLUMNS {
                let around = TAU * column as f32 / COLUMNS as f32;
                let normal = vec3(angle.sin() * around.cos(), angle.sin() * around.sin(), angle.cos());
                surface.positions.push(centre + normal * EYE_RADIUS);
                surface.normals.push(normal);
                surface.colors.push([1.0; 4]);
                surface.joints.push([HEAD as u8, 0, 0, 0]);
                surface.weights.push([1.0, 0.0, 0.0, 0.0]);
            }
        }
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let at = |r: u32, c: u32| first + r * COLUMNS + c % COLUMNS;
                let [a, b, c, d] = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
                let part = &mut parts[usize::from(row < 3)];
                if row > 0 {
                    part.push([a, c, d]);
                }
                if row + 1 < ROWS {
                    part.push([a, b, c]);
                }
            }
        }
    }
    parts
}
