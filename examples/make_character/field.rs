//! Solids as signed distances [m], negative inside, and how they melt together.

use glam::{Vec2, Vec3, vec2};

/// The union of two solids with a fillet of about `fillet` [m].
pub fn melt(a: f32, b: f32, fillet: f32) -> f32 {
    let near = (fillet - (a - b).abs()).max(0.0) / fillet;
    a.min(b) - near * near * fillet * 0.25
}

/// What of `a` is outside of `b`, with a rounded edge.
pub fn carve(a: f32, b: f32, fillet: f32) -> f32 {
    -melt(-a, b, fillet)
}

/// What is in both, with a rounded edge.
pub fn common(a: f32, b: f32, fillet: f32) -> f32 {
    -melt(-a, -b, fillet)
}

/// Smooth step from 0 at `low` to 1 at `high`.
pub fn step(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// An ellipsoid along the axes.
pub fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    let q = p - centre;
    let near = (q / radii).length();
    let slope = (q / (radii * radii)).length();
    if slope < 1.0e-9 { -radii.min_element() } else { near * (near - 1.0) / slope }
}

/// A cone with round ends of radii `r0`, `r1` [m].
pub fn bone(p: Vec3, from: Vec3, to: Vec3, r0: f32, r1: f32) -> f32 {
    let axis = to - from;
    let t = ((p - from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    (p - from - axis * t).length() - (r0 + (r1 - r0) * t)
}

/// A cross-section of a limb: how far along the axis, its centre to the side and to the front,
/// and its radii to the sides, the front and the back [m].
#[derive(Clone, Copy)]
pub struct Section(pub f32, pub [f32; 2], pub [f32; 3]);

/// A limb: ellipses along a straight axis, with smooth outlines through them.
pub struct Limb {
    pub origin: Vec3,
    pub along: Vec3,
    pub side: Vec3,
    pub front: Vec3,
    pub sections: Vec<Section>,
}

impl Limb {
    /// A limb along the line between two points.
    pub fn between(from: Vec3, to: Vec3, front: Vec3, sections: Vec<Section>) -> Self {
        let along = (to - from).normalize();
        let front = front.reject_from(along).normalize();
        Self { origin: from, along, side: front.cross(along) * -1.0, front, sections }
    }

    /// How far along the axis a point is [m].
    pub fn along(&self, p: Vec3) -> f32 {
        (p - self.origin).dot(self.along)
    }

    /// Distance to its surface.
    pub fn distance(&self, p: Vec3) -> f32 {
        let q = p - self.origin;
        let (first, last) = (self.sections[0].0, self.sections[self.sections.len() - 1].0);
        let t = q.dot(self.along);
        let inner = t.clamp(first, last);
        let [cs, cf, side, front, back] = self.section(inner);
        let across = vec2(q.dot(self.side) - cs, q.dot(self.front) - cf);
        let round = ellipse(across, vec2(side, if across.y > 0.0 { front } else { back }));
        let over = (t - inner).abs();
        if over > 0.0 { round.max(0.0).hypot(over) + round.min(0.0) * 0.2 } else { round }
    }

    /// Centre and radii at a place along the axis: a cubic through the sections.
    fn section(&self, t: f32) -> [f32; 5] {
        let all = &self.sections;
        let i = all.partition_point(|s| s.0 <= t).clamp(1, all.len() - 1) - 1;
        let row = |k: usize| {
            let Section(at, [cs, cf], [side, front, back]) = all[k];
            (at, [cs, cf, side, front, back])
        };
        let (t1, v1) = row(i);
        let (t2, v2) = row(i + 1);
        let (t0, v0) = row(i.saturating_sub(1));
        let (t3, v3) = row((i + 2).min(all.len() - 1));
        let s = (t - t1) / (t2 - t1);
        std::array::from_fn(|k| {
            let m1 = (v2[k] - v0[k]) / (t2 - t0) * (t2 - t1);
            let m2 = (v3[k] - v1[k]) / (t3 - t1) * (t2 - t1);
            hermite(v1[k], v2[k], m1, m2, s)
        })
    }
}

/// The cubic from `a` to `b` with slopes `m`, `n` over the unit interval.
pub fn hermite(a: f32, b: f32, m: f32, n: f32, s: f32) -> f32 {
    let (s2, s3) = (s * s, s * s * s);
    a * (2.0 * s3 - 3.0 * s2 + 1.0) + m * (s3 - 2.0 * s2 + s) + b * (3.0 * s2 - 2.0 * s3) + n * (s3 - s2)
}

fn ellipse(p: Vec2, radii: Vec2) -> f32 {
    let near = (p / radii).length();
    let slope = (p / (radii * radii)).length();
    if slope < 1.0e-9 { -radii.min_element() } else { near * (near - 1.0) / slope }
}

/// Direction in which a field grows fastest.
pub fn gradient(field: &dyn Fn(Vec3) -> f32, p: Vec3) -> Vec3 {
    const REACH: f32 = 0.0008;
    let along = |axis: Vec3| field(p + axis * REACH) - field(p - axis * REACH);
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / (2.0 * REACH)
}

/// A point moved onto the surface where the field has a value.
pub fn onto(field: &dyn Fn(Vec3) -> f32, level: f32, mut p: Vec3) -> Vec3 {
    const STEPS: usize = 4;
    const NEAR: f32 = 5.0e-6;
    for _ in 0..STEPS {
        let off = field(p) - level;
        if off.abs() < NEAR {
            break;
        }
        let slope = gradient(field, p);
        p -= slope * (off / slope.length_squared().max(0.05)).clamp(-0.02, 0.02);
    }
    p
}
