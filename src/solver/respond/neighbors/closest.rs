//! Closest points of what is near, four pairs at a time, and which pairs are and stay too far apart to touch.
//!
//! The closest points themselves are those of [`vertex_face`](crate::solver::detect::proximity::vertex_face) and
//! [`closest_edges`](crate::solver::detect::proximity::closest_edges), to the last bit.

use glam::{BVec4A, Mat4, Vec3, Vec3A, Vec4};

use super::near::{Found, Near};
use crate::solver::detect::Proximity;
use crate::solver::detect::four::{Four, WIDE, each, saturate};

/// How far beyond its ends an edge may be passed, at least, as a share of its length: edges slide within a frame.
const SLACK: f32 = 0.1;

/// Distances are not known better than to this share of the coordinates (dimensionless).
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// The closest points of four pairs.
pub(super) struct Closest {
    /// Weights of the first particles of all, of the second, and so on.
    weights: [Vec4; 4],
    pub(super) distance: Vec4,
    /// Whether it is they that may touch.
    may_touch: BVec4A,
}

/// Finds the closest points of four pairs of one kind.
#[inline(never)]
pub(super) fn find_four<const EDGES: bool>(
    near: &[Near],
    four: [usize; WIDE],
    found: &mut [Found],
    positions: &[Vec4],
    ahead: &[Vec3A],
) {
    let near = each(|lane| &near[four[lane]]);
    let ids = each(|lane| near[lane].particles);
    let now = each(|k| Four::of(each(|lane| positions[ids[lane][k] as usize])));
    let there = each(|k| Four::of(each(|lane| ahead[ids[lane][k] as usize].extend(0.0))));
    let Closest { weights, distance, may_touch } = if EDGES { edges(&now, &there) } else { vertex_faces(&now) };
    let [a, b, c, d] = each(|k| now[k].times(weights[k]));
    let delta = Four::ZERO + a + b + c + d;
    let scale = delta.length_squared().sqrt().recip();
    let normal = delta.times(scale);
    let [a, b, c, d] = each(|k| normal.dot(there[k]));
    let apart = if EDGES { a.min(b) - c.max(d) } else { a - b.max(c).max(d) };
    // Closer than coordinates can tell, two cloths have no side to be on. What a cloth does to itself is rolled back if it was
    // wrong.
    let size = now[0].abs().max(now[1].abs()).max(now[2].abs()).max(now[3].abs());
    let known = distance.cmpgt(ROUNDING * size.x.max(size.y).max(size.z)).bitmask();
    let finite = (scale.cmpgt(Vec4::ZERO) & scale.cmple(Vec4::MAX)).bitmask();
    let reach = Vec4::from_array(each(|lane| near[lane].reach));
    let far = (distance.cmpge(reach) & apart.cmpge(reach)).bitmask();
    let may_touch = may_touch.bitmask();
    let weights = Mat4::from_cols(weights[0], weights[1], weights[2], weights[3]).transpose();
    let normals = Mat4::from_cols(normal.x, normal.y, normal.z, apart).transpose();
    for lane in 0..WIDE {
        let (of, has) = (near[lane], |bits: u32| bits & (1 << lane) != 0);
        let sided = has(finite) && (has(known) || !of.across);
        let of_it = &mut found[four[lane]];
        of_it.may_touch = has(may_touch) && !(sided && has(far));
        if of_it.may_touch {
            let (weights, distance) = (weights.col(lane).to_array(), distance[lane]);
            of_it.pair = Proximity { kind: of.kind, particles: of.particles, weights, distance };
            let at = normals.col(lane);
            (of_it.normal, of_it.apart) = (if sided { at.truncate() } else { Vec3::NAN }, at.w);
            of_it.faces = of.faces;
        }
    }
}

/// Particles and faces.
#[inline(always)]
pub(super) fn vertex_faces([p, a, b, c]: &[Four; 4]) -> Closest {
    let (p, a, b, c) = (*p, *a, *b, *c);
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    let (bp, cp) = (p - b, p - c);
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let (none, all) = (Vec4::ZERO, Vec4::ONE);
    let (at_most, at_least) = (|v: Vec4| v.cmple(none), |v: Vec4| v.cmpge(none));
    // The first that holds counts, so the last to be put comes first.
    let sum = va + vb + vc;
    let mut w = [va / sum, vb / sum, vc / sum];
    let mut put = |holds: BVec4A, by: [Vec4; 3]| {
        w = [Vec4::select(holds, by[0], w[0]), Vec4::select(holds, by[1], w[1]), Vec4::select(holds, by[2], w[2])];
    };
    let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    put(at_most(va) & d4.cmpge(d3) & d5.cmpge(d6), [none, all - t, t]);
    let t = d2 / (d2 - d6);
    put(at_most(vb) & at_least(d2) & at_most(d6), [all - t, none, t]);
    let t = d1 / (d1 - d3);
    put(at_most(vc) & at_least(d1) & at_most(d3), [all - t, t, none]);
    put(at_least(d6) & d5.cmple(d6), [none, none, all]);
    put(at_least(d3) & d4.cmple(d3), [none, all, none]);
    put(at_most(d1) & at_most(d2), [all, none, none]);
    let distance = (p - (a.times(w[0]) + b.times(w[1]) + c.times(w[2]))).length_squared().sqrt();
    Closest { weights: [all, -w[0], -w[1], -w[2]], distance, may_touch: BVec4A::TRUE }
}

/// Edges. Only those may touch whose lines come closest inside both, or may do so soon. Where they never do, a particle is
/// closer.
#[inline(always)]
pub(super) fn edges(now: &[Four; 4], there: &[Four; 4]) -> Closest {
    let [p, q, r, s] = *now;
    let (u, v, w) = (q - p, s - r, p - r);
    let (a, b, c, d, e) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let det = a * c - b * b;
    let way = |k: usize| there[k] - now[k];
    let motion = (way(0) + way(1) - way(2) - way(3)).times(Vec4::splat(0.5));
    let slack = Vec4::splat(SLACK) + (motion.length_squared() / a.min(c)).sqrt();
    let (half, one, tiny) = (Vec4::splat(0.5), Vec4::ONE, Vec4::splat(f32::MIN_POSITIVE));
    let inside = |x: Vec4| (x - half * det).abs().cmple((half + slack) * det);
    // Edges that are almost parallel may pass anywhere.
    let may_touch = !det.cmpgt(1.0e-3 * a * c) | (inside(b * e - c * d) & inside(a * e - b * d));
    // Parallel: any point of the first.
    let x = Vec4::select(det.cmpgt(1.0e-6 * a * c), saturate((b * e - c * d) / det), half);
    let y = saturate((b * x + e) / c.max(tiny));
    let x = saturate((b * y - d) / a.max(tiny));
    let distance = ((p + u.times(x)) - (r + v.times(y))).length_squared().sqrt();
    Closest { weights: [one - x, x, y - one, -y], distance, may_touch }
}

#[cfg(test)]
mod tests {
    use super::super::batch::Batch;
    use super::*;
    use crate::solver::detect::ProximityKind;
    use crate::solver::detect::proximity::{closest_edges, vertex_face};

    /// Where a particle is, and where it is foreseen to be.
    #[derive(Clone, Copy)]
    struct Path {
        now: Vec3A,
        ahead: Vec3A,
    }

    /// Whether the lines of two edges come closest inside both, or may do so soon, one pair alone.
    fn may_pass([p, q, r, s]: [Path; 4]) -> bool {
        let (u, v, w) = (q.now - p.now, s.now - r.now, p.now - r.now);
        let (a, b, c, d, e) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
        let det = a * c - b * b;
        let motion = 0.5 * ((p.ahead - p.now) + (q.ahead - q.now) - (r.ahead - r.now) - (s.ahead - s.now));
        let slack = SLACK + (motion.length_squared() / a.min(c)).sqrt();
        let inside = |x: f32| (x - 0.5 * det).abs() <= (0.5 + slack) * det;
        !(det > 1.0e-3 * a * c) || (inside(b * e - c * d) && inside(a * e - b * d))
    }

    /// What a pair comes to, alone.
    fn alone(near: &Near, positions: &[Vec4], ahead: &[Vec3A]) -> Option<(Proximity, Vec3, f32)> {
        let (ids, at) = (near.particles, |v: u32| positions[v as usize].truncate());
        let path = |v: u32| Path { now: Vec3A::from_vec4(positions[v as usize]), ahead: ahead[v as usize] };
        let (pair, first) = match near.kind {
            ProximityKind::VertexFace => (vertex_face(ids, at), 1),
            ProximityKind::EdgeEdge => (closest_edges(ids, at), 2),
        };
        let delta: Vec3 = (0..4).map(|i| at(ids[i]) * pair.weights[i]).sum();
        let size = ids.map(|v| at(v).abs()).into_iter().fold(Vec3::ZERO, Vec3::max).max_element();
        let known = pair.distance > ROUNDING * size || !near.across;
        let normal = delta.try_normalize().filter(|_| known).unwrap_or(Vec3::NAN);
        let along = |v: &u32| Vec3A::from(normal).dot(ahead[*v as usize]);
        let low = ids[..first].iter().map(along).fold(f32::INFINITY, f32::min);
        let apart = low - ids[first..].iter().map(along).fold(f32::NEG_INFINITY, f32::max);
        let passes = near.kind == ProximityKind::VertexFace || may_pass(ids.map(path));
        let far = pair.distance >= near.reach && apart >= near.reach;
        (passes && !far).then_some((pair, normal, apart))
    }

    #[test]
    fn four_pairs_at_once_come_to_the_same_bits_as_each_alone() {
        let mut rng = fastrand::Rng::with_seed(9);
        let (mut found, mut sideless) = ([0; 2], 0);
        for round in 0..3_000 {
            // Coarse coordinates, so that points and edges also coincide, and are parallel.
            let grain = [1.0e-6, 0.25][round % 2];
            let mut point = |size: f32| Vec3::from([(); 3].map(|()| (size * rng.f32() / grain).round() * grain));
            let positions: Vec<Vec4> = (0..24).map(|_| point(1.0).extend(1.0)).collect();
            let ahead: Vec<Vec3A> = positions.iter().map(|x| Vec3A::from(x.truncate() + point(0.3))).collect();
            let mut batch = Batch::default();
            for n in 0..7 {
                let kind = if rng.bool() { ProximityKind::VertexFace } else { ProximityKind::EdgeEdge };
                let mut particles: Vec<u32> = (0..24).collect();
                rng.shuffle(&mut particles);
                let particles = [particles[0], particles[1], particles[2], particles[3]];
                let (reach, across) = (0.5 * rng.f32(), rng.bool());
                batch.push(Near { kind, particles, faces: [n, 0], reach, across });
            }
            batch.find(&positions, &ahead);
            for (near, together) in batch.all() {
                let of = |at: &Found| (at.pair, at.normal, at.apart);
                let together = Some(together).filter(|at| at.may_touch).map(of);
                match (alone(near, &positions, &ahead), together) {
                    // A face or an edge without extent.
                    (Some((pair, ..)), _) if pair.distance.is_nan() => {}
                    (Some((pair, normal, _)), Some(also)) if normal.is_nan() => {
                        assert!(also.0 == pair && also.1.is_nan(), "{pair:?} {also:?}");
                        sideless += 1;
                    }
                    (expected, found) => assert_eq!(expected, found, "{near:?}"),
                }
                found[near.kind as usize] += u32::from(together.is_some());
            }
        }
        assert!(found.iter().all(|&count| count > 1_000) && sideless > 10, "{found:?} {sideless}");
    }
}
