//! Head, face and hair of the figure, at folded points.

use glam::{Vec3, vec3};

use crate::field::{bone, carve, common, ellipsoid, melt};

/// Centre of the left eyeball [m].
pub const EYE: Vec3 = vec3(0.0315, 1.634, 0.0715);
/// Radius of an eyeball [m].
pub const EYE_RADIUS: f32 = 0.0135;
/// Where the lips meet [m].
pub const MOUTH: Vec3 = vec3(0.0, 1.5665, 0.093);

/// Skull, jaw, nose, brow, lips and ears.
pub fn flesh(p: Vec3) -> f32 {
    let mut d = ellipsoid(p, vec3(0.0, 1.660, -0.012), vec3(0.074, 0.090, 0.094));
    d = melt(d, ellipsoid(p, vec3(0.0, 1.610, 0.030), vec3(0.062, 0.074, 0.062)), 0.030);
    d = melt(d, bone(p, vec3(0.046, 1.590, 0.004), vec3(0.012, 1.541, 0.064), 0.019, 0.0160), 0.038);
    d = melt(d, ellipsoid(p, vec3(0.0, 1.542, 0.072), vec3(0.017, 0.014, 0.014)), 0.024);
    d = melt(d, ellipsoid(p, vec3(0.040, 1.600, 0.060), vec3(0.020, 0.018, 0.016)), 0.026); // cheek bone
    d = melt(d, bone(p, vec3(0.0, 1.655, 0.084), vec3(0.046, 1.654, 0.066), 0.007, 0.006), 0.020); // brow
    d = carve(d, ellipsoid(p, EYE + vec3(0.001, -0.001, 0.014), vec3(0.0205, 0.0115, 0.016)), 0.010); // socket
    let lid = ellipsoid(p, EYE + vec3(0.0, 0.0, -0.0012), Vec3::splat(EYE_RADIUS + 0.0018));
    let slit = ellipsoid(p, EYE + vec3(0.001, -0.0005, 0.016), vec3(0.0150, 0.0047, 0.016));
    d = melt(d, carve(lid, slit, 0.002), 0.005);
    d = carve(d, slit, 0.002);
    d = melt(d, nose(p), 0.010);
    d = melt(d, ellipsoid(p, vec3(0.0, 1.5700, 0.0855), vec3(0.021, 0.0056, 0.0082)), 0.007); // lips
    d = melt(d, ellipsoid(p, vec3(0.0, 1.5620, 0.0848), vec3(0.016, 0.0060, 0.0085)), 0.006);
    d = carve(d, bone(p, vec3(0.0, 1.5660, 0.0985), vec3(0.024, 1.5668, 0.087), 0.0020, 0.0015), 0.003);
    melt(d, ear(p), 0.005)
}

fn nose(p: Vec3) -> f32 {
    let ridge = bone(p, vec3(0.0, 1.642, 0.085), vec3(0.0, 1.600, 0.1055), 0.0060, 0.0070);
    let wing = ellipsoid(p, vec3(0.0085, 1.5945, 0.0970), vec3(0.0066, 0.0064, 0.0095));
    melt(ridge, wing, 0.008)
}

fn ear(p: Vec3) -> f32 {
    let shell = ellipsoid(p, vec3(0.0770, 1.622, -0.006), vec3(0.0070, 0.029, 0.018));
    let lobe = ellipsoid(p, vec3(0.0740, 1.597, 0.000), vec3(0.0060, 0.010, 0.009));
    carve(melt(shell, lobe, 0.008), ellipsoid(p, vec3(0.0845, 1.625, -0.003), vec3(0.0045, 0.018, 0.010)), 0.004)
}

/// Swept back hair with a bun.
pub fn hair(p: Vec3) -> f32 {
    let crown = ellipsoid(p, vec3(0.0, 1.663, -0.016), vec3(0.0835, 0.0985, 0.1035));
    let nape = ellipsoid(p, vec3(0.0, 1.602, -0.050), vec3(0.066, 0.066, 0.058));
    let cap = melt(crown, nape, 0.03);
    let line = hairline(p);
    let cap = common(cap, line, 0.006);
    let bun = ellipsoid(p, vec3(0.0, 1.708, -0.120), vec3(0.046, 0.042, 0.038));
    melt(cap, bun, 0.012)
}

/// Below zero where hair grows: above a line from the forehead over the ears to the nape.
fn hairline(p: Vec3) -> f32 {
    let z = p.z;
    let front = 1.716 - 2.2 * p.x * p.x;
    let side = 1.622;
    let back = 1.556;
    let height = if z > 0.0 {
        let t = (z / 0.085).min(1.2);
        side + (front - side) * t * t * (3.0 - 2.0 * t).max(0.0)
    } else {
        let t = (-z / 0.080).min(1.0);
        side + (back - side) * t * t * (3.0 - 2.0 * t)
    };
    (height - p.y) * 0.7
}
