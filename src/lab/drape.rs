//! The drape test of Cusick (BS 5058, ISO 9073-9): a round specimen on a smaller disk, and the shadow that it throws.
//!
//! ```text
//! DC = 100 (A - π r²) / (π R² - π r²)      A: shadow from above, what is covered twice counting once
//! ```
//!
//! Nodes are the lobes of its rim: peaks of the radius of the shadow over the angle that stand out from the valleys beside
//! them.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3, Vec3Swizzles, vec2, vec3};

use super::{FRAME_RATE, rate, settle, specimen};
use crate::solver::rest::SourceMesh;
use crate::solver::scene::Scene;
use crate::solver::settings::Fabric;

/// Radius of the disk `[m]`.
pub const DISK: f32 = 0.09;

/// Radius of the specimen `[m]`.
pub const SPECIMEN: f32 = 0.15;

/// What a draped specimen shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drape {
    /// Drape coefficient `[%]`: 100 for a board, 0 for what hangs straight down.
    pub coefficient: f32,
    /// Lobes of the rim.
    pub nodes: u32,
}

/// Lines along which the shadow is measured: an error of less than 0.1 points.
const LINES: usize = 1000;
/// Directions in which the rim is looked for.
const BINS: usize = 720;
/// Width of the Gaussian that smooths the rim `[degrees]`.
const SMOOTHING: f32 = 4.0;
/// How far a node stands out, over what overhangs (dimensionless): 2.4 mm.
const PROMINENCE: f32 = 0.04;

impl Drape {
    /// Judges a sheet of `faces` at `positions` `[m]`, `y` upwards, the axis of the disk through the origin.
    #[must_use]
    pub fn of(positions: &[Vec3], faces: &[[u32; 3]]) -> Self {
        let flat: Vec<Vec2> = positions.iter().map(|p| vec2(p.x, p.z)).collect();
        let reach = 1.02 * flat.iter().map(|p| p.length()).fold(SPECIMEN, f32::max);
        let (disk, whole) = (0.5 * TAU * DISK * DISK, 0.5 * TAU * SPECIMEN * SPECIMEN);
        let coefficient = 100.0 * (shadow(&flat, faces, reach) - disk) / (whole - disk);
        let nodes = peaks(&smooth(&rim(&flat, faces)), PROMINENCE * (SPECIMEN - DISK));
        Self { coefficient, nodes }
    }
}

/// How a drape is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Substeps per second `[Hz]`.
    pub substep_rate: f32,
    /// Frames per second `[Hz]`.
    pub frame_rate: f32,
    /// Longest time until it is judged `[s]`.
    pub longest: f32,
    /// Seed of the noise that it starts with.
    pub seed: u64,
}

impl Run {
    /// A run that holds what is asked on edges of `edge` `[m]`.
    #[must_use]
    pub fn new(edge: f32) -> Self {
        Self { substep_rate: rate(edge), frame_rate: FRAME_RATE, longest: 12.0, seed: 1 }
    }
}

/// Height of the noise that a specimen starts with `[m]`.
const NOISE: f32 = 2.0e-4;

/// A specimen that lies flat, held where the disk is.
#[must_use]
pub fn scene(mesh: &SourceMesh, fabric: &Fabric, run: Run) -> Scene {
    let on_disk = |v: &u32| mesh.positions[*v as usize].length() <= 1.0001 * DISK;
    let pins: Vec<u32> = (0..mesh.positions.len() as u32).filter(on_disk).collect();
    let mut scene = specimen(mesh, fabric, &pins, run.substep_rate);
    let mut rng = fastrand::Rng::with_seed(run.seed);
    let state = &mut scene.cloths[0].sim.state;
    for (x, old) in state.positions.iter_mut().zip(&mut state.previous) {
        if x.w > 0.0 {
            x.y += NOISE * (2.0 * rng.f32() - 1.0);
            old.y = x.y;
        }
    }
    scene
}

/// A specimen that has come to rest.
#[must_use]
pub fn draped(mesh: &SourceMesh, fabric: &Fabric, run: Run) -> Scene {
    let mut scene = scene(mesh, fabric, run);
    settle(&mut scene, run.frame_rate, run.longest);
    scene
}

/// Drapes a specimen and judges it.
#[must_use]
pub fn test(mesh: &SourceMesh, fabric: &Fabric, run: Run) -> Drape {
    judge(&draped(mesh, fabric, run))
}

/// Judges the first cloth of a scene.
#[must_use]
pub fn judge(scene: &Scene) -> Drape {
    let cloth = &scene.cloths[0];
    let positions: Vec<Vec3> = cloth.sim.state.positions.iter().map(|x| x.truncate()).collect();
    Drape::of(&positions, &cloth.rest.topology.faces)
}

/// Area of the union of triangles and the disk `[m²]`, along scan lines.
fn shadow(points: &[Vec2], faces: &[[u32; 3]], reach: f32) -> f32 {
    let step = 2.0 * reach / LINES as f32;
    let mut spans: Vec<Vec<[f32; 2]>> = vec![Vec::new(); LINES];
    for face in faces {
        let [a, b, c] = face.map(|p| points[p as usize]);
        let (low, high) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let line = |y: f32| ((y + reach) / step - 0.5).clamp(0.0, LINES as f32 - 1.0);
        let (from, to) = (line(low).floor() as usize, line(high).ceil() as usize);
        for (k, line) in spans.iter_mut().enumerate().take(to + 1).skip(from) {
            let y = (k as f32 + 0.5) * step - reach;
            let mut span = [f32::INFINITY, f32::NEG_INFINITY];
            for (p, q) in [(a, b), (b, c), (c, a)] {
                if (p.y <= y) != (q.y <= y) {
                    let x = p.x + (y - p.y) / (q.y - p.y) * (q.x - p.x);
                    span = [span[0].min(x), span[1].max(x)];
                }
            }
            if span[1] > span[0] {
                line.push(span);
            }
        }
    }
    let mut length = 0.0_f64;
    for (k, line) in spans.iter_mut().enumerate() {
        let y = (k as f32 + 0.5) * step - reach;
        if y.abs() < DISK {
            let half = (DISK * DISK - y * y).sqrt();
            line.push([-half, half]);
        }
        line.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut end = f32::NEG_INFINITY;
        for &[from, to] in line.iter() {
            if to > end {
                length += f64::from(to - from.max(end));
                end = to;
            }
        }
    }
    (length * f64::from(step)) as f32
}

/// Largest radius of the shadow in each direction `[m]`, at least the disk's.
fn rim(points: &[Vec2], faces: &[[u32; 3]]) -> Vec<f32> {
    let mut radius = vec![DISK; BINS];
    let step = TAU / BINS as f32;
    for face in faces {
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (mut a, mut b) = (points[face[i] as usize], points[face[j] as usize]);
            if a.length().max(b.length()) <= DISK {
                continue;
            }
            if a.perp_dot(b) < 0.0 {
                (a, b) = (b, a);
            }
            let from = a.to_angle();
            let to = from + a.perp_dot(b).atan2(a.dot(b));
            for k in (from / step).ceil() as i32..=(to / step).floor() as i32 {
                let way = Vec2::from_angle(k as f32 * step);
                // Where the ray meets a + u (b - a).
                let across = (b - a).perp_dot(way);
                let u = -a.perp_dot(way) / across;
                if across != 0.0 && (0.0..=1.0).contains(&u) {
                    let bin = &mut radius[k.rem_euclid(BINS as i32) as usize];
                    *bin = bin.max(a.lerp(b, u).dot(way));
                }
            }
        }
    }
    radius
}

/// A closed curve, smoothed.
fn smooth(radius: &[f32]) -> Vec<f32> {
    let n = radius.len() as i32;
    let sigma = SMOOTHING / 360.0 * n as f32;
    let reach = (3.0 * sigma) as i32 + 1;
    let weight = |k: i32| (-0.5 * (k as f32 / sigma).powi(2)).exp();
    let total: f32 = (-reach..=reach).map(weight).sum();
    let at = |i: i32| (-reach..=reach).map(|k| weight(k) * radius[(i + k).rem_euclid(n) as usize]).sum::<f32>() / total;
    (0..n).map(at).collect()
}

/// Peaks of a closed curve that stand out by at least `prominence` from the valleys beside them.
fn peaks(radius: &[f32], prominence: f32) -> u32 {
    let low = (0..radius.len()).min_by(|&a, &b| radius[a].total_cmp(&radius[b])).unwrap_or(0);
    let around = radius.iter().cycle().skip(low).take(radius.len() + 1);
    let (mut count, mut top, mut valley, mut rising) = (0, f32::NEG_INFINITY, f32::INFINITY, false);
    for &r in around {
        if rising {
            top = top.max(r);
            if r <= top - prominence {
                (count, rising, valley) = (count + 1, false, r);
            }
        } else {
            valley = valley.min(r);
            if r >= valley + prominence {
                (rising, top) = (true, r);
            }
        }
    }
    count
}

/// A disk of radius [`SPECIMEN`] in rings, its warp along z, of triangles with edges of about `edge` `[m]`, one ring at
/// [`DISK`].
#[must_use]
pub fn rings(edge: f32) -> SourceMesh {
    let inner = (DISK / edge).round().max(1.0) as u32;
    let outer = ((SPECIMEN - DISK) / edge).round().max(1.0) as u32;
    let radius = |k: u32| {
        if k <= inner { DISK * k as f32 / inner as f32 } else { DISK + (SPECIMEN - DISK) * (k - inner) as f32 / outer as f32 }
    };
    let mut mesh = SourceMesh { positions: vec![Vec3::ZERO], ..SourceMesh::default() };
    let mut before = (0u32, 1u32);
    for k in 1..=inner + outer {
        let count = 6 * k;
        let start = mesh.positions.len() as u32;
        // Half a step turned against the ring before, so that there is no seam.
        let at = |j: u32| Vec2::from_angle(TAU * (j as f32 + 0.5 * (k % 2) as f32) / count as f32) * radius(k);
        mesh.positions.extend((0..count).map(|j| vec3(at(j).x, 0.0, at(j).y)));
        let phase = |(count, k): (u32, u32), j: u32| (j as f32 + 0.5 * (k % 2) as f32) / count as f32;
        let (mut i, mut j) = (0, 0);
        let (first, inside) = before;
        // Zipped by angle.
        while i < inside || j < count {
            let (a, b) = (first + i % inside, start + j % count);
            let outer_next = start + (j + 1) % count;
            let step_outer =
                inside == 1 || i >= inside || (j < count && phase((count, k), j + 1) <= phase((inside, k - 1), i + 1));
            if step_outer {
                mesh.triangles.push([a, outer_next, b]);
                j += 1;
            } else {
                mesh.triangles.push([a, first + (i + 1) % inside, b]);
                i += 1;
            }
            if inside == 1 && j == count {
                break;
            }
        }
        before = (start, count);
    }
    mesh.uvs = mesh.positions.iter().map(|p| p.xz()).collect();
    mesh
}

/// A disk of radius [`SPECIMEN`] cut from a square grid with edges of `edge` `[m]`. The grid is turned by `angle` `[rad]`, its
/// warp with it. Diagonals run all one way, or alternate. Vertices near the rim and near the edge of the disk are moved onto
/// them.
#[must_use]
pub fn grid(edge: f32, angle: f32, alternating: bool) -> SourceMesh {
    const SNAP: f32 = 0.3;
    let n = (SPECIMEN / edge).ceil() as i32 + 1;
    let width = 2 * n + 1;
    let index = |i: i32, j: i32| ((i + n) * width + j + n) as usize;
    let mut vertex = vec![None; (width * width) as usize];
    let mut mesh = SourceMesh::default();
    for (i, j) in (-n..=n).flat_map(|i| (-n..=n).map(move |j| (i, j))) {
        let p = Vec2::from_angle(angle).rotate(vec2(i as f32, j as f32) * edge);
        let r = p.length();
        if r <= SPECIMEN + SNAP * edge {
            let circle = [DISK, SPECIMEN].into_iter().find(|c| (r - c).abs() < SNAP * edge);
            let p = p * circle.map_or(1.0, |c| c / r);
            vertex[index(i, j)] = Some(mesh.positions.len() as u32);
            mesh.positions.push(vec3(p.x, 0.0, p.y));
        }
    }
    for (i, j) in (-n..n).flat_map(|i| (-n..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [(i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)].map(|(i, j)| vertex[index(i, j)]);
        let cuts = [[[a, b, c], [b, d, c]], [[a, b, d], [a, d, c]]];
        let turned = usize::from(alternating && (i + j).rem_euclid(2) == 1);
        let whole = |cut: &[[Option<u32>; 3]; 2]| -> Vec<[u32; 3]> {
            cut.iter().filter_map(|[a, b, c]| Some([(*a)?, (*b)?, (*c)?])).collect()
        };
        // At the rim only one of the four triangles may be there.
        let first = whole(&cuts[turned]);
        mesh.triangles.extend(if first.is_empty() { whole(&cuts[1 - turned]) } else { first });
    }
    mesh.uvs = mesh.positions.iter().map(|p| Vec2::from_angle(-angle).rotate(p.xz())).collect();
    mesh
}

/// The disk of [`grid`] with its vertices shaken by up to 0.3 edges, those on the circles along them. Each quad is cut along
/// its shorter diagonal: no two triangles are alike.
#[must_use]
pub fn irregular(edge: f32, seed: u64) -> SourceMesh {
    const SHAKEN: f32 = 0.3;
    let mut mesh = grid(edge, 0.0, false);
    let mut rng = fastrand::Rng::with_seed(seed);
    for p in &mut mesh.positions {
        let r = p.length();
        let way = Vec2::new(2.0 * rng.f32() - 1.0, 2.0 * rng.f32() - 1.0) * (SHAKEN * edge);
        *p += vec3(way.x, 0.0, way.y);
        if let Some(circle) = [DISK, SPECIMEN].into_iter().find(|circle| (r - circle).abs() < 1.0e-5) {
            *p *= circle / p.length();
        }
    }
    // Two halves of a quad follow each other.
    let mut k = 0;
    while k + 1 < mesh.triangles.len() {
        let ([a, b, c], [b2, d, c2]) = (mesh.triangles[k], mesh.triangles[k + 1]);
        let at = |v: u32| mesh.positions[v as usize];
        if (b, c) == (b2, c2) {
            if at(a).distance(at(d)) < at(b).distance(at(c)) {
                mesh.triangles[k] = [a, b, d];
                mesh.triangles[k + 1] = [a, d, c];
            }
            k += 1;
        }
        k += 1;
    }
    mesh.uvs = mesh.positions.iter().map(|p| p.xz()).collect();
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drape of the rings with their points moved to `shape(radius, angle)`: radius and height `[m]`.
    fn judged(shape: impl Fn(f32, f32) -> (f32, f32)) -> Drape {
        let mesh = rings(0.0025);
        let points: Vec<Vec3> = mesh
            .positions
            .iter()
            .map(|p| {
                let (r, angle) = (p.length(), p.z.atan2(p.x));
                let (r, y) = shape(r, angle);
                vec3(r * angle.cos(), y, r * angle.sin())
            })
            .collect();
        Drape::of(&points, &mesh.triangles)
    }

    #[test]
    fn flat_is_a_hundred_straight_down_is_none_and_lobes_are_counted() {
        let flat = judged(|r, _| (r, 0.0));
        assert!((flat.coefficient - 100.0).abs() < 0.3 && flat.nodes == 0, "{flat:?}");
        let down = judged(|r, _| (r.min(DISK), 0.0));
        assert!(down.coefficient.abs() < 0.3 && down.nodes == 0, "{down:?}");
        for (lobes, mean, swing) in [(4, 0.12, 0.01), (7, 0.115, 0.012), (11, 0.11, 0.006)] {
            let out = |angle: f32| mean - DISK + swing * (lobes as f32 * angle).cos();
            let lobed =
                judged(|r, angle| (if r <= DISK { r } else { DISK + out(angle) * (r - DISK) / (SPECIMEN - DISK) }, 0.0));
            let want = 100.0 * (mean * mean + 0.5 * swing * swing - DISK * DISK) / (SPECIMEN * SPECIMEN - DISK * DISK);
            assert!((lobed.coefficient - want).abs() < 0.3 && lobed.nodes == lobes, "{lobed:?} for {want} with {lobes} lobes");
        }
        // Out to 13 cm, then back under itself: what is covered twice counts once.
        let under = judged(|r, _| if r <= 0.13 { (r, 0.0) } else { (0.26 - r, -0.01) });
        let want = 100.0 * (0.13f32.powi(2) - DISK * DISK) / (SPECIMEN * SPECIMEN - DISK * DISK);
        assert!((under.coefficient - want).abs() < 0.5, "{under:?} for {want}");
    }

    #[test]
    fn every_mesh_covers_the_specimen_and_has_vertices_on_the_edge_of_the_disk() {
        let meshes = [rings(0.01), grid(0.01, 0.3, false), grid(0.0075, 0.0, true), irregular(0.01, 1)];
        for mesh in &meshes {
            let flat = Drape::of(&mesh.positions, &mesh.triangles);
            assert!((flat.coefficient - 100.0).abs() < 4.0, "{flat:?}");
            let on_edge = mesh.positions.iter().filter(|p| (p.length() - DISK).abs() < 1.0e-5).count();
            assert!(on_edge > 20, "{on_edge} vertices");
        }
    }
}
