//! `.cloth.ron` files that are right, before they are changed.

/// One with everything in it.
const WHOLE: &str = r#"(
    material: (density: 0.15, stretch_stiffness: 12000.0, bend_stiffness: 3e-5, strain_limit: inf, thickness: 0.002, bend_ratio: 2.0),
    solver: (substep_rate: 600.0, max_frame: 0.1, membrane: Triangles, teleport: Reset, gravity_scale: 1.0, time_scale: 1.0),
    collision: (self_collision: true, contact: false, garment_layer: 2),
    untangle: (method: ByEndType, iterations: 9, stall_iterations: 10, effort: 512, at_load: true),
    skip_frame: (policy: UntilClean(max: 9), max_held_frames: 5, fade: 0.25),
    limits: (max_distance: Painted(paint: Attribute("_CLOTH_PAINT.g"), low: 0.01, high: 0.3), backstop_distance: Uniform(0.02), scale: 0.5),
    drive: (frequency: Painted(paint: Color(A), low: 0, high: 4), damping_ratio: 0.5),
    wind: Some((velocity: (1.0, 0.0, 2.0), turbulence: 0.3, seed: 7)), // a breeze
)"#;

/// The text of a number.
pub fn text(number: u64) -> &'static str {
    match number % 4 {
        0 => include_str!("../../assets/fabrics/cotton.cloth.ron"),
        1 => include_str!("../../assets/fabrics/rubber.cloth.ron"),
        _ => WHOLE,
    }
}
