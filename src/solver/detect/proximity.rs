//! Pairs of primitives, and their closest points.
//!
//! ```text
//!  vertex-face:  closest point  Σ wⱼ cⱼ  of the triangle, after Ericson 2005, section 5.1.5
//!  edge-edge:    closest points of two segments, section 5.1.9; only where both are inside, the ends are vertex-face pairs
//! ```

use glam::Vec3;

/// Which primitives came close.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum ProximityKind {
    /// Particle `particles[0]` and the face of `particles[1..4]`.
    VertexFace,
    /// Edge `particles[0..2]` and edge `particles[2..4]`.
    EdgeEdge,
}

/// Two primitives closer than asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Proximity {
    /// What they are.
    pub kind: ProximityKind,
    /// Their particles.
    pub particles: [u32; 4],
    /// The closest points are `Σ wᵢ xᵢ` of the first primitive and `-Σ wᵢ xᵢ` of the second. So `Σ wᵢ xᵢ` over all four is the
    /// vector from the second's closest point to the first's.
    pub weights: [f32; 4],
    /// Distance `[m]`.
    pub distance: f32,
}

/// Closest points of two edges, ends included (Ericson 2005, section 5.1.9).
pub(crate) fn closest_edges(particles: [u32; 4], at: impl Fn(u32) -> Vec3) -> Proximity {
    let [p, q, r, s] = particles.map(&at);
    let (u, v, w) = (q - p, s - r, p - r);
    let (a, b, c, d, e) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let det = a * c - b * b;
    // Parallel: any point of the first.
    let x = if det > 1.0e-6 * a * c { ((b * e - c * d) / det).clamp(0.0, 1.0) } else { 0.5 };
    let y = ((b * x + e) / c.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    let x = ((b * y - d) / a.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    let distance = (p + u * x).distance(r + v * y);
    Proximity { kind: ProximityKind::EdgeEdge, particles, weights: [1.0 - x, x, y - 1.0, -y], distance }
}

/// Closest point of a triangle to a particle: `particles[0]` against `particles[1..4]`.
pub(crate) fn vertex_face(particles: [u32; 4], at: impl Fn(u32) -> Vec3) -> Proximity {
    let [p, a, b, c] = particles.map(&at);
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    let (bp, cp) = (p - b, p - c);
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let w = if d1 <= 0.0 && d2 <= 0.0 {
        [1.0, 0.0, 0.0]
    } else if d3 >= 0.0 && d4 <= d3 {
        [0.0, 1.0, 0.0]
    } else if d6 >= 0.0 && d5 <= d6 {
        [0.0, 0.0, 1.0]
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        [1.0 - t, t, 0.0]
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        [1.0 - t, 0.0, t]
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        [0.0, 1.0 - t, t]
    } else {
        let sum = va + vb + vc;
        [va / sum, vb / sum, vc / sum]
    };
    let distance = p.distance(a * w[0] + b * w[1] + c * w[2]);
    Proximity { kind: ProximityKind::VertexFace, particles, weights: [1.0, -w[0], -w[1], -w[2]], distance }
}

/// Closest points of two edges; infinitely far unless both are inside, since ends belong to vertex-face pairs.
pub(crate) fn edge_edge(particles: [u32; 4], at: impl Fn(u32) -> Vec3) -> Proximity {
    let [p, q, r, s] = particles.map(&at);
    let (u, v, w) = (q - p, s - r, p - r);
    let (a, b, c, d, e) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let det = a * c - b * b;
    let (x, y) = ((b * e - c * d) / det, (a * e - b * d) / det);
    let inside = det > 1.0e-6 * a * c && x > 0.0 && x < 1.0 && y > 0.0 && y < 1.0;
    let distance = if inside { (p + u * x).distance(r + v * y) } else { f32::INFINITY };
    Proximity { kind: ProximityKind::EdgeEdge, particles, weights: [1.0 - x, x, y - 1.0, -y], distance }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered(seed: u64) -> Vec<Vec3> {
        let mut rng = fastrand::Rng::with_seed(seed);
        (0..4).map(|_| Vec3::new(rng.f32(), rng.f32(), rng.f32())).collect()
    }

    #[test]
    fn the_closest_point_of_a_triangle_beats_all_sampled_points() {
        for seed in 0..500 {
            let x = scattered(seed);
            let found = vertex_face([0, 1, 2, 3], |v| x[v as usize]);
            let sum: Vec3 = (0..4).map(|k| x[k] * found.weights[k]).sum();
            assert!((sum.length() - found.distance).abs() < 1e-5);
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let (a, b) = (i as f32 / 20.0, j as f32 / 20.0);
                    let p = x[1] * a + x[2] * b + x[3] * (1.0 - a - b);
                    assert!(p.distance(x[0]) > found.distance - 1e-5, "seed {seed}");
                }
            }
        }
    }

    #[test]
    fn the_closest_points_of_two_edges_beat_all_sampled_points() {
        for seed in 0..500 {
            let x = scattered(seed);
            let found = edge_edge([0, 1, 2, 3], |v| x[v as usize]);
            if !found.distance.is_finite() {
                continue;
            }
            let sum: Vec3 = (0..4).map(|k| x[k] * found.weights[k]).sum();
            assert!((sum.length() - found.distance).abs() < 1e-4, "seed {seed}: {sum} {}", found.distance);
            for i in 0..=20 {
                for j in 0..=20 {
                    let p = x[0].lerp(x[1], i as f32 / 20.0).distance(x[2].lerp(x[3], j as f32 / 20.0));
                    assert!(p > found.distance - 1e-4, "seed {seed}");
                }
            }
        }
    }
}
