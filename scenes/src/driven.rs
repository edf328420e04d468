//! Two sheets as they are after one was driven through the other: what the paper's pictures show the end of.

use core::f32::consts::{FRAC_PI_2, TAU};

use glam::{Vec3, vec3};

use bevy_drape::solver::rest::SourceMesh;

/// Length and width of the sheet that was driven `[m]`.
const SIDES: (f32, f32) = (1.1, 0.7);
/// Where along it the flap begins to bend down, and the radius of the bend `[m]`.
const FLAP: (f32, f32) = (0.74, 0.05);
/// Height above the flat sheet, of the middle and of the waves `[m]`.
const WAVES: (f32, f32) = (0.042, 0.07);

/// A flat sheet of 1 m x 1 m and one driven through it, each of about `n` x `n` vertices: waves that pierce it in several
/// places, and a flap that cuts straight through, for which no gradient is anything but 0.
///
/// ```text
///    ╭─╮   ╭─╮  ╭─╮           z
///  ──┼─┼───┼─┼──┼─│──  flat   │
///      ╰───╯ ╰──╯ │           └── x
///                 │ flap
/// ```
#[must_use]
pub fn driven(n: u32) -> [SourceMesh; 2] {
    let (length, width) = SIDES;
    let flat = super::grid(n, n, |u, v| vec3(u - 0.5, v - 0.5, 0.0));
    let columns = (length * (n.max(2) - 1) as f32).round() as u32 + 1;
    let rows = (width * (n.max(2) - 1) as f32).round() as u32 + 1;
    [flat, super::grid(columns, rows, |u, v| fold(u * length, (v - 0.5) * width))]
}

/// The point at `s` along the driven sheet and `y` across it `[m]`.
fn fold(s: f32, y: f32) -> Vec3 {
    let ((bend, radius), (height, amplitude)) = (FLAP, WAVES);
    let fade = ((bend - s) / 0.15).clamp(0.0, 1.0);
    let wave = amplitude * fade * (TAU * (s / 0.37 + 0.06)).sin() * (TAU * (y / 0.62 + 0.2)).cos();
    let angle = ((s - bend) / radius).clamp(0.0, FRAC_PI_2);
    let straight = (s - bend - radius * FRAC_PI_2).max(0.0);
    let x = s.min(bend) + radius * angle.sin() - 0.49;
    vec3(x, y + 0.013, height + wave - radius * (1.0 - angle.cos()) - straight)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{Scene, SceneCloth, fabric};
    use bevy_drape::solver::evaluate::EvaluateSettings;
    use bevy_drape::solver::island::UntangleSettings;
    use bevy_drape::solver::resolve::{Method, ResolveSettings};
    use bevy_drape::solver::rest::RestShape;

    /// Crossings at the start and after two seconds.
    fn untangled(method: Method, n: u32) -> (u32, u32) {
        let cloth = |mesh| {
            let (rest, _) = RestShape::build(&mesh).unwrap_or_default();
            SceneCloth::new(Arc::new(rest), fabric(), Vec3::ZERO, &[])
        };
        let settings = UntangleSettings { resolve: ResolveSettings { method, ..Default::default() }, ..Default::default() };
        let scene = Scene { gravity: Vec3::ZERO, ..Scene::new(driven(n).map(cloth).into()) };
        let Ok(mut scene) = scene.untangled(UntangleSettings { iterations: 0, ..settings }, EvaluateSettings::default(), false)
        else {
            panic!("no surface");
        };
        scene.step(1.0 / 60.0);
        let start = scene.crossings();
        if let Some(untangle) = &mut scene.untangle {
            untangle.settings = settings;
        }
        (0..120).for_each(|_| scene.step(1.0 / 60.0));
        (start, scene.crossings())
    }

    #[test]
    fn the_method_of_2006_stops_mostly_separated_and_by_end_type_goes_on_to_the_end() {
        for n in [15, 20, 30] {
            let (start, left) = untangled(Method::LocalGradient, n);
            assert!(left > 0 && 3 * left <= start, "2006 at {n}: {start} crossings, {left} left");
            let (start, left) = untangled(Method::ByEndType, n);
            assert!(left == 0, "by end type at {n}: {start} crossings, {left} left");
        }
    }
}
