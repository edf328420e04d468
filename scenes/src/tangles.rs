//! The eight named tangles: two sheets that start in each other. What takes which of them apart is the measure of an untangling
//! method.

use glam::{DQuat, DVec3, Vec3};

use bevy_drape::solver::rest::SourceMesh;

/// Two sheets in each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tangle {
    /// A shallow dent through a flat sheet: one closed contour.
    Dent,
    /// A deep dent: a closed contour.
    DeepDent,
    /// The corner of a sheet through the middle of another: the contour has two ends on one border.
    Corner,
    /// Two sheets that overlap at their borders: an end on a border of each.
    BorderOverlap,
    /// A strip stabbed straight through a sheet: no translation makes the contour shorter.
    StripStab,
    /// The same at an angle.
    TiltedStrip,
    /// A sheet that cuts another in two.
    FullCut,
    /// Two wavy sheets: five contours.
    Waves,
}

impl Tangle {
    /// All of them, in the order of the published comparison.
    pub const ALL: [Self; 8] = [
        Self::Dent,
        Self::DeepDent,
        Self::Corner,
        Self::BorderOverlap,
        Self::StripStab,
        Self::TiltedStrip,
        Self::FullCut,
        Self::Waves,
    ];

    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dent => "dent",
            Self::DeepDent => "deep dent",
            Self::Corner => "corner",
            Self::BorderOverlap => "border overlap",
            Self::StripStab => "strip stab",
            Self::TiltedStrip => "tilted strip",
            Self::FullCut => "full cut",
            Self::Waves => "waves",
        }
    }

    /// The two sheets of about `n` x `n` vertices, tangled `[m]`.
    #[must_use]
    pub fn meshes(self, n: u32) -> [SourceMesh; 2] {
        let v = DVec3::new;
        let turn = |p: DVec3, axis: DVec3, angle: f64| DQuat::from_axis_angle(axis.normalize(), angle) * p;
        let bell = |a: f64, b: f64| (-18.0 * ((a - 0.5).powi(2) + (b - 0.5).powi(2))).exp();
        let n = n.max(2);
        // Of a 13 x 13 sheet's spacing.
        let scaled = |k: u32| ((f64::from(k) - 1.0) * (f64::from(n) - 1.0) / 12.0).round() as u32 + 1;
        let strip = |f: &dyn Fn(f64, f64) -> DVec3| grid(scaled(9), scaled(5), f);
        let flat = grid(n, n, |a, b| v(a - 0.5, b - 0.5, 0.0));
        let second = match self {
            Self::Dent => grid(n, n, |a, b| v(a - 0.487, b - 0.513, 0.06 - 0.16 * bell(a, b))),
            Self::DeepDent => grid(n, n, |a, b| v(a - 0.487, b - 0.513, 0.06 - 0.46 * bell(a, b))),
            Self::Corner => grid(n, n, |a, b| v(0.01, 0.02, -0.3) + turn(v((a + b) * 0.5, (a - b) * 0.5, 0.0), DVec3::Y, -1.0)),
            Self::BorderOverlap => {
                grid(n, n, |a, b| v(0.55, 0.21, 0.02) + turn(v(a - 0.5, b - 0.5, 0.0), v(1.0, 0.3, 0.0), 0.35))
            }
            Self::StripStab => strip(&|a, b| v(0.017 + 0.03 * b, (b - 0.5) * 0.35 + 0.01, a * 0.9 - 0.3)),
            Self::TiltedStrip => strip(&|a, b| v(0.017 + 0.5 * (a - 0.33), (b - 0.5) * 0.35 + 0.01, a * 0.9 - 0.3)),
            Self::FullCut => grid(n, n, |a, b| v(0.03 + 0.05 * (3.0 * b).sin(), 1.3 * (b - 0.5) + 0.01, a - 0.3)),
            Self::Waves => {
                let first = grid(n, n, |a, b| v(a - 0.5, b - 0.5, 0.06 * (9.0 * a).sin() * (7.0 * b).cos()));
                let wave = |a: f64, b: f64| 0.02 + 0.08 * (6.0 * a + 1.0).sin() * (8.0 * b + 0.5).cos();
                return [first, grid(n, n, |a, b| v(a - 0.49, b - 0.51, wave(a, b)))];
            }
        };
        [flat, second]
    }
}

/// As [`super::grid`], computed in double precision.
fn grid(columns: u32, rows: u32, point: impl Fn(f64, f64) -> DVec3) -> SourceMesh {
    let mut mesh = super::grid(columns, rows, |_, _| Vec3::ZERO);
    let (columns, rows) = (columns.max(2), rows.max(2));
    for (k, to) in mesh.positions.iter_mut().enumerate() {
        let (i, j) = (k as u32 / rows, k as u32 % rows);
        *to = point(f64::from(i) / f64::from(columns - 1), f64::from(j) / f64::from(rows - 1)).as_vec3();
    }
    mesh
}
