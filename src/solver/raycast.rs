//! Where a ray meets a surface, and which of its points is nearest to a place.
//!
//! Every face is asked: shown positions may be held, faded or interpolated, and no search tree is kept of those.

use glam::Vec3;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pick {
    /// Which face.
    pub face: usize,
    /// Weights of its three corners; they add up to one.
    pub weights: Vec3,
    /// Distance to it `[m]`.
    pub distance: f32,
}

/// First face that a ray from `origin` along the unit vector `direction` meets within `farthest` `[m]`, from either side
/// (Möller, Trumbore 1997).
#[must_use]
pub(crate) fn ray(faces: &[[u32; 3]], at: impl Fn(u32) -> Vec3, origin: Vec3, direction: Vec3, farthest: f32) -> Option<Pick> {
    let mut best: Option<Pick> = None;
    let mut limit = farthest;
    for (face, t) in faces.iter().enumerate() {
        let [a, b, c] = t.map(&at);
        let (e, f) = (b - a, c - a);
        let p = direction.cross(f);
        let det = e.dot(p);
        if det == 0.0 {
            continue;
        }
        let s = origin - a;
        let q = s.cross(e);
        let (u, v, distance) = (s.dot(p) / det, direction.dot(q) / det, f.dot(q) / det);
        // What is not a number passes no comparison. On an edge shared by two faces rounding must leave no gap.
        let slack = -1.0e-6;
        if u >= slack && v >= slack && u + v <= 1.0 - slack && distance >= 0.0 && distance <= limit {
            limit = distance;
            best = Some(Pick { face, weights: Vec3::new(1.0 - u - v, u, v), distance });
        }
    }
    best
}

/// Nearest point of a surface to `point`, no farther than `farthest` `[m]`.
#[must_use]
pub(crate) fn nearest(faces: &[[u32; 3]], at: impl Fn(u32) -> Vec3, point: Vec3, farthest: f32) -> Option<Pick> {
    let mut best: Option<Pick> = None;
    let mut limit = farthest * farthest;
    for (face, t) in faces.iter().enumerate() {
        let corners = t.map(&at);
        let weights = closest_weights(point, corners);
        let near = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
        let square = near.distance_squared(point);
        if square <= limit && (best.is_none() || square < limit) {
            limit = square;
            best = Some(Pick { face, weights, distance: square.sqrt() });
        }
    }
    best
}

/// Weights of the corners at the point of a triangle that is nearest to `p` (Ericson 2005, section 5.1.5).
pub(super) fn closest_weights(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return Vec3::X;
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return Vec3::Y;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return Vec3::new(1.0 - v, v, 0.0);
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return Vec3::Z;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return Vec3::new(1.0 - w, 0.0, w);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return Vec3::new(0.0, 1.0 - w, w);
    }
    let sum = va + vb + vc;
    Vec3::new(va, vb, vc) / sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
    const CORNERS: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0), Vec3::Z];

    #[test]
    fn a_ray_meets_the_first_face_in_its_way_from_either_side() {
        for (y, down) in [(2.0, -1.0), (-2.0, 1.0)] {
            let hit = ray(&FACES, |v| CORNERS[v as usize], Vec3::new(0.7, y, 0.2), Vec3::Y * down, 3.0).expect("a hit");
            assert_eq!((hit.face, hit.distance), (0, 2.0));
            assert!(hit.weights.distance(Vec3::new(0.3, 0.5, 0.2)) < 1.0e-6, "{hit:?}");
        }
        let away = ray(&FACES, |v| CORNERS[v as usize], Vec3::new(0.7, 2.0, 0.2), Vec3::Y, 3.0);
        let short = ray(&FACES, |v| CORNERS[v as usize], Vec3::new(0.7, 2.0, 0.2), Vec3::NEG_Y, 1.0);
        assert_eq!((away, short), (None, None));
    }

    #[test]
    fn a_ray_at_a_shared_edge_finds_no_gap() {
        for i in 1..1000 {
            let p = i as f32 / 1000.0;
            let hit = ray(&FACES, |v| CORNERS[v as usize], Vec3::new(p, 0.37, p), Vec3::NEG_Y, 1.0);
            assert!(hit.is_some(), "no hit at {p}");
        }
    }

    #[test]
    fn the_nearest_point_is_as_near_as_any_of_a_dense_sample() {
        for point in [Vec3::new(0.4, 0.3, 0.6), Vec3::new(-1.0, 0.2, 0.5), Vec3::new(2.0, -1.0, 3.0), Vec3::new(0.5, 0.0, -0.4)]
        {
            let hit = nearest(&FACES, |v| CORNERS[v as usize], point, f32::INFINITY).expect("a point");
            let sample = |i: u32| Vec3::new((i % 101) as f32 / 100.0, 0.0, (i / 101) as f32 / 100.0).distance(point);
            let least = (0..101 * 101).map(sample).fold(f32::INFINITY, f32::min);
            assert!((hit.distance - least).abs() < 0.01, "{hit:?} for {least}");
        }
    }
}
