//! Pairs of primitives that come closer than the contact distance.
//!
//! ```text
//!  vertex-face:  closest point  Σ wⱼ cⱼ  of the triangle, after Ericson 2005, section 5.1.5
//!  edge-edge:    closest points of two segments, section 5.1.9; only where both are inside, the ends are vertex-face pairs
//! ```
//!
//! Left out: pairs within [`ProximitySettings::exclude_rings`] edges of each other, and pairs of one cloth that are as close at
//! rest.

use glam::{Vec3, Vec4};

use super::crossing::Detector;
use super::surface::Surface;
use crate::solver::effort::Meter;

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
    /// The closest points are `Σ wᵢ xᵢ` of the first primitive and `-Σ wᵢ xᵢ` of the second: `Σ wᵢ xᵢ` over all four is the
    /// vector from the second's closest point to the first's.
    pub weights: [f32; 4],
    /// Distance `[m]`.
    pub distance: f32,
}

/// What counts as close.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct ProximitySettings {
    /// Contact distance `[m]`.
    pub distance: f32,
    /// Pairs of one cloth within this many edges of each other are left out. Default 2.
    pub exclude_rings: u32,
    /// Whether edge-edge pairs are wanted.
    pub edges: bool,
}

impl Default for ProximitySettings {
    fn default() -> Self {
        Self { distance: 0.005, exclude_rings: 2, edges: true }
    }
}

impl Detector {
    /// Finds close pairs at `positions` (`[m]`, `w` inverse mass), in a fixed order, into `found`. Where there is too much
    /// work, the last pairs are left out.
    pub fn proximities(
        &mut self,
        surface: &Surface,
        positions: &[Vec4],
        settings: &ProximitySettings,
        meter: &Meter,
        found: &mut Vec<Proximity>,
    ) {
        found.clear();
        if positions.len() != surface.len() {
            return;
        }
        self.tree.refit(surface, positions, None);
        let topology = &surface.topology;
        let at = |v: u32| positions[v as usize].truncate();
        let mut near = |pair: Proximity| {
            if pair.distance < settings.distance && !is_excluded(surface, &pair, settings) {
                found.push(pair);
            }
        };
        let mut pair = |f: u32, g: u32| {
            meter.spend(1);
            let (tf, tg) = (topology.faces[f as usize], topology.faces[g as usize]);
            if tf.iter().all(|&v| positions[v as usize].w == 0.0) && tg.iter().all(|&v| positions[v as usize].w == 0.0) {
                return;
            }
            for (t, u) in [(tf, tg), (tg, tf)] {
                for v in t {
                    if !u.contains(&v) {
                        near(vertex_face([v, u[0], u[1], u[2]], at));
                    }
                }
            }
            if settings.edges {
                for i in 0..3 {
                    for j in 0..3 {
                        let (e, h) = ([tf[i], tf[(i + 1) % 3]], [tg[j], tg[(j + 1) % 3]]);
                        if !h.contains(&e[0]) && !h.contains(&e[1]) {
                            let (e, h) = (ordered(e), ordered(h));
                            let (e, h) = if e < h { (e, h) } else { (h, e) };
                            near(edge_edge([e[0], e[1], h[0], h[1]], at));
                        }
                    }
                }
            }
        };
        self.tree.meetings(surface, settings.distance, meter, |tree, met| tree.pairs_of(met, &mut pair));
        // Pairs were met once per pair of faces around them: order them and keep each once.
        found.sort_unstable_by_key(|p| (p.kind as u8, p.particles));
        found.dedup_by_key(|p| (p.kind as u8, p.particles));
    }
}

fn ordered([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn is_excluded(surface: &Surface, pair: &Proximity, settings: &ProximitySettings) -> bool {
    let [a, b, c, d] = pair.particles;
    let (first, second): (&[u32], &[u32]) = match pair.kind {
        ProximityKind::VertexFace => (&[a], &[b, c, d]),
        ProximityKind::EdgeEdge => (&[a, b], &[c, d]),
    };
    surface.part(a) == surface.part(d)
        && (distance_at_rest(surface, pair) < settings.distance
            || first.iter().any(|&v| within(surface, v, second, settings.exclude_rings)))
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

/// Distance of a pair at rest `[m]`.
fn distance_at_rest(surface: &Surface, pair: &Proximity) -> f32 {
    let at = |v: u32| surface.rest[v as usize];
    match pair.kind {
        ProximityKind::VertexFace => vertex_face(pair.particles, at).distance,
        ProximityKind::EdgeEdge => closest_edges(pair.particles, at).distance,
    }
}

/// Whether a particle is at most `rings` edges from one of the targets.
fn within(surface: &Surface, from: u32, targets: &[u32], rings: u32) -> bool {
    targets.contains(&from)
        || (rings > 0 && surface.topology.around(from).iter().any(|&(u, _)| within(surface, u, targets, rings - 1)))
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
