//! The seven contour units: a sheet that crosses itself in one curve, one for each way such a curve can end (after Wicke,
//! Lanker and Gross 2006).

use core::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Vec3, vec3};

use bevy_drape::solver::rest::SourceMesh;

/// A sheet that crosses itself in one curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Folded over, with a dent through the layer below: the curve has no ends.
    Closed,
    /// A dart whose upper side dips through the lower one from the tip on and comes up again: both ends in the tip.
    Eight,
    /// A crease rolled through itself over a part of its length: an end in a loop vertex on either side.
    Ll,
    /// Folded over, with a tongue stabbed through the layer below: both ends on the borders of the tongue.
    Bbii,
    /// The same, off to the side: an end on the border of the tongue, the other on that of the layer below.
    Bibi,
    /// A dart whose sides cross from the tip on: an end in the tip, the other on a border.
    Bli,
    /// A dart whose upper side dips through the lower one from the tip to the rim: two ends on one border, the tip between
    /// them.
    Cross,
}

impl Unit {
    /// All of them: those that close first, then those with borders.
    pub const ALL: [Self; 7] = [Self::Closed, Self::Eight, Self::Ll, Self::Bbii, Self::Bibi, Self::Bli, Self::Cross];

    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Eight => "eight",
            Self::Ll => "LL",
            Self::Bbii => "BBII",
            Self::Bibi => "BIBI",
            Self::Bli => "BLI",
            Self::Cross => "cross",
        }
    }

    /// The sheet, about 1 m wide and of about `n` x 2`n` vertices `[m]`; z is up.
    #[must_use]
    pub fn mesh(self, n: u32) -> SourceMesh {
        let n = n.max(4);
        let grid = |point: &dyn Fn(f32, f32) -> Vec3| super::grid(2 * n, n, point);
        match self {
            Self::Closed => grid(&|u, v| folded(u, v, &Tongue { width: 1.0, shift: 0.0, dent: 0.34, bent: false })),
            Self::Bbii => grid(&|u, v| folded(u, v, &Tongue { width: 0.5, shift: 0.02, dent: 0.0, bent: true })),
            Self::Bibi => grid(&|u, v| folded(u, v, &Tongue { width: 0.5, shift: 0.41, dent: 0.0, bent: true })),
            Self::Ll => grid(&|u, v| rolled(1.1 * (u - 0.5), 0.8 * (v - 0.47))),
            Self::Eight => grid(&|u, v| dart(u, v, 0.85, |x, slope| x * dip(slope) + 0.55 * (x - 0.45).max(0.0))),
            Self::Bli => grid(&|u, v| dart(u, v, 0.85, |x, slope| 0.55 * x * (slope + 0.05))),
            Self::Cross => grid(&|u, v| dart(u, v, 0.85, |x, slope| x * dip(slope))),
        }
    }
}

/// The part of a folded sheet that lies above.
struct Tongue {
    /// Its width over that of the part below.
    width: f32,
    /// How far it lies to the side `[m]`.
    shift: f32,
    /// Depth of a dent in it `[m]`.
    dent: f32,
    /// Whether its end is bent down.
    bent: bool,
}

/// A strip folded over.
///
/// ```text
///     ╭───────────╮
///     │  tongue   │ radius
///   ──┼───────────╯
/// ```
fn folded(u: f32, v: f32, tongue: &Tongue) -> Vec3 {
    const LENGTH: f32 = 0.9;
    const RADIUS: f32 = 0.1;
    const BEND: f32 = 0.04;
    let arc = PI * RADIUS;
    let s = u * (2.0 * LENGTH + arc);
    let turn = ((s - LENGTH) / RADIUS).clamp(0.0, PI);
    let above = turn / PI;
    let back = (s - LENGTH - arc).max(0.0);
    // The end goes down in a quarter of a circle and then straight.
    let until = if tongue.bent { 0.45 } else { LENGTH };
    let angle = ((back - until) / BEND).clamp(0.0, FRAC_PI_2);
    let down = (back - until - BEND * FRAC_PI_2).max(0.0);
    let width = 0.7 * (1.0 + (tongue.width - 1.0) * above);
    let (a, b) = (back / LENGTH - 0.55, v - 0.5);
    let dent = tongue.dent * (-18.0 * (a * a + b * b)).exp() * f32::from(back > 0.0);
    let x = s.min(LENGTH) + RADIUS * turn.sin() - back.min(until) - BEND * angle.sin() - 0.45;
    let z = RADIUS * (1.0 - turn.cos()) - dent - BEND * (1.0 - angle.cos()) - down;
    vec3(x, width * (v - 0.5) + tongue.shift * above + 0.007, z)
}

/// A crease that is rolled through itself where `c > 0`: the curve `(v², v³ - c v)` crosses itself at `v = ± sqrt c`.
fn rolled(x: f32, v: f32) -> Vec3 {
    let c = 0.09 * (1.0 - (x / 0.38).powi(2)) + 0.01 * (TAU * x).sin();
    vec3(x, 2.0 * v * v - 0.2, 3.0 * v * (v * v - c) + 0.02 * x)
}

/// Below 0 around the middle, above it at both sides.
fn dip(slope: f32) -> f32 {
    0.9 * slope * slope - 0.11
}

/// A paper dart with its tip in the origin: a flat lower side, a fin, and an upper side of height `height(x, y / x)` that is
/// `reach` as long.
///
/// ```text
///        ╱│ upper
///   tip ╱_│ fin
///       ╲ │
///        ╲│ lower
/// ```
fn dart(u: f32, v: f32, reach: f32, height: impl Fn(f32, f32) -> f32) -> Vec3 {
    const WIDE: f32 = 0.6;
    const FIN: f32 = 0.12;
    let side = (1.0 - FIN) / 2.0;
    let (lower, fin, upper) =
        ((u / side).min(1.0), ((u - side) / FIN).clamp(0.0, 1.0), ((u - side - FIN) / side).clamp(0.0, 1.0));
    let length = 1.0 + (reach - 1.0) * fin;
    let x = length * v;
    // What is above lies a little to the side: no edge above another.
    let slope = WIDE * (2.0 * lower - 1.0) - 2.0 * WIDE * upper + 0.013 * fin;
    vec3(x - 0.5, x * slope, fin * height(x, slope))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_drape::solver::detect::{PartRef, Surface};
    use bevy_drape::solver::resolve::{ContourKind, Untangler};
    use bevy_drape::solver::rest::RestShape;

    #[test]
    fn every_unit_crosses_itself_in_one_contour_of_its_kind() {
        let kinds = [
            ContourKind::Closed,
            ContourKind::Eight,
            ContourKind::Ll,
            ContourKind::Bbii,
            ContourKind::Bibi,
            ContourKind::Bli,
            ContourKind::Cross,
        ];
        for n in [12, 20, 30] {
            for (unit, kind) in Unit::ALL.into_iter().zip(kinds) {
                let (rest, _) = RestShape::build(&unit.mesh(n)).unwrap_or_default();
                let part = PartRef {
                    topology: &rest.topology,
                    rest: &rest.positions,
                    garment_layer: 0,
                    self_collision: true,
                    thickness: 0.005,
                };
                let Ok(surface) = Surface::new(&[part]) else { panic!("{unit:?} is no surface") };
                let mut untangler = Untangler::new(&surface);
                let positions: Vec<_> = rest.positions.iter().map(|p| p.extend(1.0)).collect();
                untangler.look(&surface, &positions);
                let found: Vec<_> = untangler.resolver.graph().contours.iter().map(|c| (c.kind, c.count)).collect();
                assert!(matches!(found[..], [(k, _)] if k == kind), "{unit:?} at {n}: {found:?}");
            }
        }
    }
}
