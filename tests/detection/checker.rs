//! Counts crossings without any of the library's own geometry: every edge against every face whose box it may meet, in f64.
//!
//! Shares no code with the detector, so that one can be tested with the other.

use glam::{DVec3, Vec3};

/// Crossings of edges with faces that share no particle with them, sorted; an edge is its two particles, smaller first. Pairs whose
/// orientations are zero to rounding are left out.
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
    // Sweep along x: faces by where they begin, edges by where they end.
    let mut order: Vec<(u32, (Vec3, Vec3))> = faces.iter().enumerate().map(|(f, t)| (f as u32, spans(t))).collect();
    order.sort_by(|a, b| a.1.0.x.total_cmp(&b.1.0.x));
    let widest = order.iter().map(|(_, (low, high))| high.x - low.x).fold(0.0, f32::max);
    let mut found = Vec::new();
    for edge in edges {
        let (low, high) = spans(&edge);
        let first = order.partition_point(|(_, (from, _))| from.x < low.x - widest);
        for (f, (from, to)) in order[first..].iter().take_while(|(_, (from, _))| from.x <= high.x) {
            let face = faces[*f as usize];
            let meet = to.cmpge(low).all() && from.cmple(high).all();
            if meet && !face.contains(&edge[0]) && !face.contains(&edge[1]) && crosses(edge.map(at), face.map(at)) {
                found.push((edge, *f));
            }
        }
    }
    found.sort_unstable();
    found
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
