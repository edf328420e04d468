//! How far faces and edges are apart, now and at the next look, as far as that is quickly told.

use glam::Vec3A;

use crate::solver::detect::tree::Bounds;

/// How far beyond its ends an edge may be passed, at least, as a share of its length: edges slide within a frame.
const SLACK: f32 = 0.1;

/// The corners of a face, each with the next.
pub(super) const CYCLE: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// As `map`, which is not always inlined.
#[inline(always)]
pub(super) fn corners<T: Copy, U>([a, b, c]: [T; 3], of: impl Fn(T) -> U) -> [U; 3] {
    [of(a), of(b), of(c)]
}

/// Where a particle is, and where it is foreseen to be `[m]`.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Path {
    pub(super) now: Vec3A,
    pub(super) ahead: Vec3A,
}

impl Path {
    #[inline]
    pub(super) fn bounds(self) -> Bounds {
        Bounds { min: self.now.min(self.ahead), max: self.now.max(self.ahead) }
    }
}

/// How far two faces are apart along the line between their centres, now and ahead, times its length `[m²]`.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Gaps {
    pub(super) now: f32,
    pub(super) ahead: f32,
    /// Square of that length `[m²]`.
    square: f32,
}

impl Gaps {
    #[inline]
    pub(super) fn between(f: &[Path; 3], g: &[Path; 3]) -> Self {
        let axis = (f[0].now + f[1].now + f[2].now) - (g[0].now + g[1].now + g[2].now);
        let apart = |of: fn(&Path) -> Vec3A| {
            let origin = of(&g[0]);
            let along = |p: &Path| (of(p) - origin).dot(axis);
            along(&f[0]).min(along(&f[1])).min(along(&f[2])) - along(&g[1]).max(along(&g[2])).max(0.0)
        };
        Self { now: apart(|p| p.now), ahead: apart(|p| p.ahead), square: axis.length_squared() }
    }

    /// Whether a gap is wider than `reach` `[m]`.
    #[inline]
    pub(super) fn exceed(&self, reach: f32, gap: f32) -> bool {
        gap > 0.0 && gap * gap > reach * reach * self.square
    }
}

/// Whether the lines of two edges come closest inside both, or may do so soon. Where they never do, a particle is closer.
#[inline]
pub(super) fn may_pass([p, q]: [Path; 2], [r, s]: [Path; 2]) -> bool {
    let (u, v, w) = (q.now - p.now, s.now - r.now, p.now - r.now);
    let (a, b, c, d, e) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let det = a * c - b * b;
    let motion = 0.5 * ((p.ahead - p.now) + (q.ahead - q.now) - (r.ahead - r.now) - (s.ahead - s.now));
    let slack = SLACK + (motion.length_squared() / a.min(c)).sqrt();
    let inside = |x: f32| (x - 0.5 * det).abs() <= (0.5 + slack) * det;
    // Edges that are almost parallel may pass anywhere.
    !(det > 1.0e-3 * a * c) || (inside(b * e - c * d) && inside(a * e - b * d))
}
