//! Surface nets: a mesh of quads around the cells through which a surface goes.

use std::collections::BTreeMap;

use glam::{IVec3, Vec3, ivec3};

use crate::mesh::Mesh;

/// Cells to a side of a block that is skipped as a whole where it is far from the surface.
const BLOCK: i32 = 8;

/// Places of the grid that are tried, as shares of a cell.
const SHIFTS: [Vec3; 5] = [
    Vec3::ZERO,
    Vec3::new(0.31, 0.17, 0.43),
    Vec3::new(0.59, 0.73, 0.23),
    Vec3::new(0.13, 0.47, 0.71),
    Vec3::new(0.83, 0.29, 0.61),
];

/// The surface where a field is zero, within a box, by cells of a size [m]. Triangles face where the field grows.
///
/// Where a surface grazes a plane of the grid, cells may touch one another at an edge alone, and the mesh is no surface
/// there. The grid is then shifted, up to a number of tries: the first place without such edges is taken, or the one with
/// the fewest.
pub fn surface(field: &dyn Fn(Vec3) -> f32, [low, high]: [Vec3; 2], cell: f32, tries: usize) -> Mesh {
    let mut best: Option<(usize, Mesh)> = None;
    for shift in SHIFTS.into_iter().take(tries) {
        let mut mesh = once(field, low - shift * cell, high, cell);
        mesh.keep_largest();
        let bad = mesh.edges().iter().filter(|edge| edge.count > 2).count();
        if best.as_ref().is_none_or(|(least, _)| bad < *least) {
            best = Some((bad, mesh));
        }
        if bad == 0 {
            break;
        }
    }
    best.map(|(_, mesh)| mesh).unwrap_or_default()
}

fn once(field: &dyn Fn(Vec3) -> f32, low: Vec3, high: Vec3, cell: f32) -> Mesh {
    let size = ((high - low) / cell).ceil().as_ivec3() / BLOCK + IVec3::ONE;
    let mut values: BTreeMap<[i32; 3], f32> = BTreeMap::new();
    let place = |c: IVec3| low + c.as_vec3() * cell;
    let mut cells: Vec<IVec3> = Vec::new();
    let reach = cell * BLOCK as f32 * 1.35;
    for bx in 0..size.x {
        for by in 0..size.y {
            for bz in 0..size.z {
                let first = ivec3(bx, by, bz) * BLOCK;
                if field(place(first) + Vec3::splat(cell * BLOCK as f32 / 2.0)).abs() > reach {
                    continue;
                }
                let side = BLOCK + 1;
                let mut inside = vec![0.0; (side * side * side) as usize];
                let at = |x: i32, y: i32, z: i32| ((x * side + y) * side + z) as usize;
                for x in 0..side {
                    for y in 0..side {
                        for z in 0..side {
                            inside[at(x, y, z)] = field(place(first + ivec3(x, y, z)));
                        }
                    }
                }
                for x in 0..BLOCK {
                    for y in 0..BLOCK {
                        for z in 0..BLOCK {
                            let corner = |i: i32| inside[at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2 & 1))];
                            let below = (0..8).filter(|&i| corner(i) < 0.0).count();
                            if below == 0 || below == 8 {
                                continue;
                            }
                            let c = first + ivec3(x, y, z);
                            cells.push(c);
                            for i in 0..8 {
                                values.insert((c + ivec3(i & 1, i >> 1 & 1, i >> 2 & 1)).to_array(), corner(i));
                            }
                        }
                    }
                }
            }
        }
    }
    stitched(&cells, &values, &place)
}

fn stitched(cells: &[IVec3], values: &BTreeMap<[i32; 3], f32>, place: &dyn Fn(IVec3) -> Vec3) -> Mesh {
    let value = |c: IVec3| values.get(&c.to_array()).copied().unwrap_or(1.0);
    let mut mesh = Mesh::default();
    let mut vertex: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    for &c in cells {
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for i in 0..8 {
            for bit in [1, 2, 4] {
                if i & bit != 0 {
                    continue;
                }
                let (a, b) = (c + ivec3(i & 1, i >> 1 & 1, i >> 2 & 1), {
                    let j = i | bit;
                    c + ivec3(j & 1, j >> 1 & 1, j >> 2 & 1)
                });
                let (va, vb) = (value(a), value(b));
                if (va < 0.0) != (vb < 0.0) {
                    sum += place(a).lerp(place(b), va / (va - vb));
                    count += 1.0;
                }
            }
        }
        vertex.insert(c.to_array(), mesh.positions.len() as u32);
        mesh.positions.push(sum / f32::max(count, 1.0));
    }
    for &c in cells {
        for axis in 0..3 {
            let step = IVec3::AXES[axis];
            let (u, v) = (IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]);
            let (va, vb) = (value(c), value(c + step));
            if (va < 0.0) == (vb < 0.0) {
                continue;
            }
            let around = [c - u - v, c - v, c, c - u].map(|n| vertex.get(&n.to_array()).copied());
            let [Some(p), Some(q), Some(r), Some(s)] = around else { continue };
            if va < 0.0 {
                mesh.triangles.extend([[p, q, r], [p, r, s]]);
            } else {
                mesh.triangles.extend([[p, r, q], [p, s, r]]);
            }
        }
    }
    mesh
}
