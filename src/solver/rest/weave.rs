//! The directions of the threads, from texture coordinates: `u` runs along the weft, `v` along the warp.

use glam::{Vec2, Vec3};

use crate::solver::topology::{NONE, Topology};

/// Least area of a triangle in the texture, over the product of its two longer sides there (dimensionless): with less it has no
/// direction.
const LEAST: f32 = 1.0e-4;

/// Directions in the plane of a triangle: unit vectors along the warp and, at a right angle, to the side of the weft. Zero
/// where nothing tells them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Threads {
    pub warp: Vec3,
    pub weft: Vec3,
}

impl Threads {
    /// Of a triangle at `x` `[m]` with texture coordinates `uv`. A mirrored texture has its weft mirrored, as a piece cut from
    /// the other side has.
    pub(super) fn new(x: [Vec3; 3], uv: [Vec2; 3]) -> Option<Self> {
        let (e1, e2) = (x[1] - x[0], x[2] - x[0]);
        let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
        let area = d1.perp_dot(d2);
        let longest = d1.length_squared().max(d2.length_squared()).max((d2 - d1).length_squared());
        if !(area.abs() > LEAST * longest && longest.is_finite()) {
            return None;
        }
        // What moves along the cloth where only `v` grows, and where only `u` does.
        let warp = ((e2 * d1.x - e1 * d2.x) / area).try_normalize()?;
        let along = (e1 * d2.y - e2 * d1.y) / area;
        let weft = (along - warp * along.dot(warp)).try_normalize()?;
        Some(Self { warp, weft })
    }

    /// The same in the plane of another triangle at `x` `[m]` that lies nearly as its own; none where that is no direction.
    pub(super) fn onto(self, x: [Vec3; 3]) -> Self {
        let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or_zero();
        let Some(warp) = self.warp.reject_from_normalized(normal).try_normalize() else { return Self::default() };
        let across = normal.cross(warp);
        Self { warp, weft: if across.dot(self.weft) < 0.0 { -across } else { across } }
    }

    /// Itself, or directions along the edges `d1` and `d2` of a triangle `[m]` where nothing tells any.
    pub(super) fn or_along(self, d1: Vec3, d2: Vec3) -> Self {
        if self.warp != Vec3::ZERO {
            return self;
        }
        let warp = d1.normalize_or_zero();
        Self { warp, weft: d2.reject_from(d1).normalize_or_zero() }
    }

    /// `cos 2φ` and `sin 2φ`, `φ` the angle of `edge` from the warp towards the weft; zero without a direction.
    fn twice(self, edge: Vec3) -> Vec2 {
        let (c, s) = (edge.dot(self.warp), edge.dot(self.weft));
        let square = edge.length_squared().max(f32::MIN_POSITIVE);
        Vec2::new(c * c - s * s, 2.0 * c * s) / square
    }
}

/// `cos 2φ` and `sin 2φ` of each edge of `topology`, with `φ` its angle from the warp towards the weft. It is the mean over its
/// faces, less than a unit vector where they disagree. Empty when there are no `threads`.
pub(super) fn of_edges(topology: &Topology, positions: &[Vec3], threads: &[Threads]) -> Vec<Vec2> {
    if threads.is_empty() {
        return Vec::new();
    }
    let of_edge = |(edge, faces): (&[u32; 2], &[u32; 2])| {
        let way = positions[edge[1] as usize] - positions[edge[0] as usize];
        let beside = || faces.iter().filter(|f| **f != NONE);
        beside().map(|&f| threads[f as usize].twice(way)).sum::<Vec2>() / beside().count().max(1) as f32
    };
    topology.edges.iter().zip(&topology.edge_faces).map(of_edge).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{vec2, vec3};

    #[test]
    fn the_warp_is_where_v_grows_whichever_way_the_triangle_is_mapped() {
        let x = [vec3(0.0, 1.0, 0.0), vec3(2.0, 1.0, 0.0), vec3(0.5, 1.0, 3.0)];
        for (u, v) in
            [(Vec3::X, Vec3::Z), (Vec3::NEG_X, Vec3::Z), (Vec3::Z, Vec3::X), (vec3(1.0, 0.0, 1.0), vec3(-1.0, 0.0, 1.0))]
        {
            let threads = Threads::new(x, x.map(|x| vec2(0.3 * x.dot(u), 0.7 * x.dot(v)))).expect("a direction");
            assert!(threads.warp.distance(v.normalize()) < 1.0e-5, "{threads:?} for u {u}, v {v}");
            assert!(threads.weft.distance(u.normalize()) < 1.0e-5, "{threads:?} for u {u}, v {v}");
            let half = threads.twice(v + u);
            assert!((half - vec2(0.0, 1.0)).length() < 1.0e-5, "{half}");
        }
    }

    #[test]
    fn a_texture_without_area_or_with_bad_numbers_tells_nothing() {
        let x = [Vec3::ZERO, Vec3::X, Vec3::Z];
        for uv in [
            [Vec2::ZERO; 3],
            [Vec2::ZERO, Vec2::ONE, Vec2::splat(2.0)],
            [Vec2::NAN; 3],
            [Vec2::ZERO, Vec2::splat(f32::INFINITY), Vec2::X],
        ] {
            assert_eq!(Threads::new(x, uv), None, "{uv:?}");
        }
    }
}
