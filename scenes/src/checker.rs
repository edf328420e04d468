//! Counts crossings without any of the library's own geometry: every edge against every face that is listed in the same cells
//! of a grid, in f64.
//!
//! Shares no code with the detector, so that one can be tested with the other.

use glam::{DVec3, IVec3, Vec3};

/// Crossings of edges with faces that share no particle with them, sorted; an edge is its two particles, smaller first. Pairs
/// whose orientations are zero to rounding are left out.
#[must_use]
pub fn crossings(positions: &[Vec3], faces: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let at = |v: u32| positions[v as usize].as_dvec3();
    let mut edges: Vec<[u32; 2]> = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.iter_mut().for_each(|e| e.sort_unstable());
    edges.sort_unstable();
    edges.dedup();
    let spans = |ids: &[u32]| {
        let low = ids.iter().map(|&v| positions[v as usize]).reduce(Vec3::min).unwrap_or_default();
        let high = ids.iter().map(|&v| positions[v as usize]).reduce(Vec3::max).unwrap_or_default();
        (low, high)
    };
    let boxes: Vec<(Vec3, Vec3)> = faces.iter().map(|t| spans(t)).collect();
    let grid = Grid::new(&boxes);
    let mut found = Vec::new();
    for edge in edges {
        let (low, high) = spans(&edge);
        grid.near((low, high), |f| {
            let (from, to) = boxes[f as usize];
            let face = faces[f as usize];
            let meet = to.cmpge(low).all() && from.cmple(high).all();
            if meet && !face.contains(&edge[0]) && !face.contains(&edge[1]) && crosses(edge.map(at), face.map(at)) {
                found.push((edge, f));
            }
        });
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Which boxes reach into which cell; cells share buckets, so that the space has no end.
struct Grid {
    side: f32,
    /// Where the boxes of each bucket begin in `boxes`; one more at the end.
    starts: Vec<u32>,
    boxes: Vec<u32>,
}

impl Grid {
    fn new(boxes: &[(Vec3, Vec3)]) -> Self {
        let widths = boxes.iter().map(|(low, high)| (*high - *low).max_element());
        let side = (widths.sum::<f32>() / boxes.len().max(1) as f32).max(1.0e-6);
        let mut grid = Self { side, starts: vec![0; (2 * boxes.len()).next_power_of_two() + 1], boxes: Vec::new() };
        let mut listed: Vec<(usize, u32)> = Vec::new();
        for (&span, i) in boxes.iter().zip(0..) {
            listed.extend(grid.cells(span).map(|cell| (grid.bucket(cell), i)));
        }
        listed.sort_unstable();
        listed.dedup();
        listed.iter().for_each(|(bucket, _)| grid.starts[bucket + 1] += 1);
        for i in 1..grid.starts.len() {
            grid.starts[i] += grid.starts[i - 1];
        }
        grid.boxes.extend(listed.iter().map(|(_, i)| i));
        grid
    }

    fn cells(&self, (low, high): (Vec3, Vec3)) -> impl Iterator<Item = IVec3> + use<> {
        let (low, high) = ((low / self.side).floor().as_ivec3(), (high / self.side).floor().as_ivec3());
        (low.x..=high.x)
            .flat_map(move |x| (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| IVec3::new(x, y, z))))
    }

    fn bucket(&self, cell: IVec3) -> usize {
        let mix = cell.as_uvec3().wrapping_mul(glam::uvec3(73_856_093, 19_349_663, 83_492_791));
        (mix.x ^ mix.y ^ mix.z) as usize & (self.starts.len() - 2)
    }

    /// Visits the boxes near another, some of them more than once.
    fn near(&self, span: (Vec3, Vec3), mut visit: impl FnMut(u32)) {
        for cell in self.cells(span) {
            let bucket = self.bucket(cell);
            let (from, to) = (self.starts[bucket] as usize, self.starts[bucket + 1] as usize);
            self.boxes[from..to].iter().for_each(|&i| visit(i));
        }
    }
}

fn crosses([u, v]: [DVec3; 2], [p, q, r]: [DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let ends = [volume(p, q, r, u), volume(p, q, r, v)];
    let around = [volume(u, v, p, q), volume(u, v, q, r), volume(u, v, r, p)];
    let size = (v - u).length() * (q - p).length() * (r - p).length();
    if ends.iter().chain(&around).any(|x| x.abs() < 1.0e-12 * size) {
        return false;
    }
    ends[0] * ends[1] < 0.0 && around[0] * around[1] > 0.0 && around[1] * around[2] > 0.0
}
