//! The solids of the figure. It is mirrored: every field is asked at |x|.

use glam::{Vec3, vec3};

use crate::field::{Limb, Section, bone, common, ellipsoid, melt};
use crate::head;
use crate::measures::{ANKLE, ELBOW, SHOULDER, WRIST};

/// The solids that melt into the body.
pub struct Anatomy {
    torso: Limb,
    neck: Limb,
    leg: Limb,
    upper_arm: Limb,
    lower_arm: Limb,
}

impl Default for Anatomy {
    fn default() -> Self {
        let up =
            |origin: Vec3, sections: Vec<Section>| Limb { origin, along: Vec3::Y, side: Vec3::X, front: Vec3::Z, sections };
        Self {
            torso: up(Vec3::ZERO, torso()),
            neck: up(Vec3::ZERO, neck()),
            leg: up(Vec3::ZERO, leg()),
            upper_arm: Limb::between(SHOULDER, ELBOW, Vec3::Z, upper_arm()),
            lower_arm: Limb::between(ELBOW, WRIST, Vec3::Z, lower_arm()),
        }
    }
}

/// Pelvis, waist, rib cage and shoulders; heights are from the ground.
fn torso() -> Vec<Section> {
    vec![
        Section(0.795, [0.0, -0.005], [0.060, 0.040, 0.050]),
        Section(0.830, [0.0, -0.005], [0.115, 0.068, 0.080]),
        Section(0.880, [0.0, -0.004], [0.158, 0.086, 0.098]),
        Section(0.930, [0.0, -0.002], [0.161, 0.094, 0.094]),
        Section(0.990, [0.0, 0.0], [0.145, 0.093, 0.080]),
        Section(1.060, [0.0, 0.0], [0.122, 0.086, 0.074]),
        Section(1.110, [0.0, 0.0], [0.116, 0.082, 0.078]),
        Section(1.180, [0.0, -0.003], [0.124, 0.087, 0.090]),
        Section(1.260, [0.0, -0.006], [0.136, 0.094, 0.099]),
        Section(1.330, [0.0, -0.010], [0.139, 0.090, 0.096]),
        Section(1.390, [0.0, -0.016], [0.132, 0.074, 0.080]),
        Section(1.430, [0.0, -0.020], [0.095, 0.056, 0.060]),
        Section(1.465, [0.0, -0.022], [0.060, 0.046, 0.046]),
    ]
}

fn neck() -> Vec<Section> {
    vec![
        Section(1.400, [0.0, -0.026], [0.066, 0.056, 0.056]),
        Section(1.450, [0.0, -0.022], [0.056, 0.050, 0.052]),
        Section(1.490, [0.0, -0.016], [0.050, 0.048, 0.050]),
        Section(1.540, [0.0, -0.008], [0.050, 0.050, 0.052]),
        Section(1.600, [0.0, -0.004], [0.052, 0.050, 0.054]),
    ]
}

/// Thigh, knee, calf and ankle; heights are from the ground.
fn leg() -> Vec<Section> {
    vec![
        Section(0.050, [0.100, -0.022], [0.034, 0.036, 0.040]),
        Section(0.090, [0.100, -0.022], [0.034, 0.035, 0.040]),
        Section(0.140, [0.100, -0.020], [0.034, 0.034, 0.038]),
        Section(0.220, [0.101, -0.018], [0.043, 0.040, 0.046]),
        Section(0.310, [0.102, -0.016], [0.054, 0.046, 0.062]),
        Section(0.375, [0.101, -0.010], [0.056, 0.048, 0.066]),
        Section(0.440, [0.099, 0.000], [0.052, 0.050, 0.056]),
        Section(0.500, [0.097, 0.008], [0.053, 0.053, 0.054]),
        Section(0.540, [0.096, 0.010], [0.055, 0.056, 0.056]),
        Section(0.620, [0.094, 0.008], [0.064, 0.067, 0.066]),
        Section(0.720, [0.092, 0.004], [0.075, 0.078, 0.078]),
        Section(0.800, [0.091, 0.000], [0.080, 0.083, 0.084]),
        Section(0.870, [0.095, -0.004], [0.078, 0.076, 0.082]),
        Section(0.930, [0.100, -0.006], [0.060, 0.056, 0.060]),
    ]
}

/// From the shoulder to the elbow, biceps to the front.
fn upper_arm() -> Vec<Section> {
    vec![
        Section(-0.035, [0.0, 0.0], [0.042, 0.040, 0.040]),
        Section(0.010, [0.0, 0.0], [0.048, 0.049, 0.049]),
        Section(0.060, [0.0, 0.0], [0.046, 0.049, 0.048]),
        Section(0.130, [0.0, 0.002], [0.043, 0.047, 0.044]),
        Section(0.200, [0.0, 0.002], [0.039, 0.041, 0.040]),
        Section(0.260, [0.0, 0.0], [0.037, 0.036, 0.038]),
        Section(0.290, [0.0, 0.0], [0.037, 0.034, 0.037]),
    ]
}

/// From the elbow to the wrist; flat at the wrist.
fn lower_arm() -> Vec<Section> {
    vec![
        Section(-0.020, [0.0, 0.0], [0.036, 0.034, 0.036]),
        Section(0.020, [0.0, 0.001], [0.038, 0.039, 0.037]),
        Section(0.065, [0.0, 0.002], [0.039, 0.042, 0.039]),
        Section(0.130, [0.0, 0.001], [0.033, 0.037, 0.034]),
        Section(0.200, [0.0, 0.0], [0.025, 0.030, 0.028]),
        Section(0.250, [0.0, 0.0], [0.021, 0.027, 0.026]),
        Section(0.280, [0.0, 0.0], [0.019, 0.027, 0.026]),
    ]
}

/// A point on the left side.
pub fn folded(p: Vec3) -> Vec3 {
    vec3(p.x.abs(), p.y, p.z)
}

impl Anatomy {
    /// Torso without limbs.
    pub fn torso(&self, p: Vec3) -> f32 {
        let p = folded(p);
        let mut d = self.torso.distance(p);
        d = melt(d, ellipsoid(p, vec3(0.070, 1.262, 0.062), vec3(0.060, 0.058, 0.052)), 0.035);
        d = melt(d, ellipsoid(p, vec3(0.076, 0.885, -0.058), vec3(0.078, 0.090, 0.068)), 0.040);
        d = melt(d, ellipsoid(p, vec3(0.075, 1.330, -0.065), vec3(0.060, 0.080, 0.040)), 0.040);
        let slope = bone(p, vec3(0.020, 1.455, -0.028), vec3(0.160, 1.408, -0.022), 0.040, 0.034);
        melt(d, slope, 0.050)
    }

    /// The left arm without its hand, at the folded point.
    pub fn arm(&self, p: Vec3) -> f32 {
        let p = folded(p);
        let d = melt(self.upper_arm.distance(p), self.lower_arm.distance(p), 0.02);
        melt(d, ellipsoid(p, SHOULDER + vec3(0.006, -0.010, 0.0), vec3(0.046, 0.054, 0.052)), 0.03)
    }

    /// The left leg without its foot, at the folded point.
    pub fn leg(&self, p: Vec3) -> f32 {
        self.leg.distance(folded(p))
    }

    /// How far down the upper arm a point is [m].
    pub fn along_upper_arm(&self, p: Vec3) -> f32 {
        self.upper_arm.along(folded(p))
    }

    /// How far down the lower arm a point is [m].
    pub fn along_lower_arm(&self, p: Vec3) -> f32 {
        self.lower_arm.along(folded(p))
    }

    /// Neck alone.
    pub fn neck(&self, p: Vec3) -> f32 {
        self.neck.distance(folded(p))
    }

    /// Hand: palm, four fingers and a thumb.
    pub fn hand(&self, p: Vec3) -> f32 {
        let p = folded(p);
        let along = (WRIST - ELBOW).normalize();
        let palm = Vec3::Z.cross(along).normalize();
        let palm = if palm.y > 0.0 { -palm } else { palm };
        let wide = along.cross(palm).normalize();
        let wide = if wide.z < 0.0 { -wide } else { wide };
        let at = |a: f32, w: f32, n: f32| WRIST + along * a + wide * w + palm * n;
        let q = p - at(0.048, 0.0, 0.004);
        let local = vec3(q.dot(along), q.dot(wide), q.dot(palm));
        let mut d = ellipsoid(local, Vec3::ZERO, vec3(0.056, 0.040, 0.019));
        d = melt(d, bone(p, at(-0.01, 0.0, 0.0), at(0.03, 0.0, 0.002), 0.023, 0.022), 0.02);
        let fingers = [(0.030, 0.068, 0.043), (0.0105, 0.078, 0.0145), (-0.0105, 0.073, -0.0145), (-0.0295, 0.056, -0.043)];
        for (start, length, end) in fingers {
            let knuckle = at(0.080 - start * start * 8.0, start, 0.002);
            let middle = at(0.084 + length * 0.5, (start + end) * 0.5, 0.006);
            let tip = at(0.080 + length, end, 0.018);
            let finger = bone(p, knuckle, middle, 0.0098, 0.0088).min(bone(p, middle, tip, 0.0088, 0.0074));
            d = melt(d, finger, 0.008);
        }
        let thumb = bone(p, at(0.022, 0.022, 0.006), at(0.058, 0.050, 0.016), 0.014, 0.0110).min(bone(
            p,
            at(0.058, 0.050, 0.016),
            at(0.092, 0.060, 0.024),
            0.0110,
            0.0085,
        ));
        melt(d, thumb, 0.014)
    }

    /// Boot: foot and ankle.
    pub fn shoe(&self, p: Vec3) -> f32 {
        let p = folded(p);
        let turn = (p.z - ANKLE.z) * 0.06; // feet point a little outward
        let p = vec3(p.x - turn, p.y, p.z);
        let sole = ellipsoid(p, vec3(0.100, 0.020, 0.030), vec3(0.047, 0.042, 0.138));
        let toe = ellipsoid(p, vec3(0.098, 0.026, 0.100), vec3(0.046, 0.034, 0.072));
        let heel = ellipsoid(p, vec3(0.100, 0.036, -0.040), vec3(0.037, 0.046, 0.042));
        let instep = bone(p, vec3(0.100, 0.085, -0.012), vec3(0.099, 0.034, 0.085), 0.038, 0.026);
        let shaft = bone(p, vec3(0.100, 0.060, -0.024), vec3(0.1005, 0.150, -0.022), 0.042, 0.041);
        let d = melt(melt(melt(sole, toe, 0.02), heel, 0.02), instep, 0.03);
        let d = melt(d, shaft, 0.02);
        common(common(d, -p.y, 0.006), p.y - 0.170, 0.006)
    }

    /// All that is skin or thin clothes on it: no hair, no boots.
    pub fn flesh(&self, p: Vec3) -> f32 {
        let mut d = self.trunk(p);
        if p.y < 1.15 && p.x.abs() > 0.4 {
            d = melt(d, self.hand(p), 0.012);
        }
        if p.y > 1.40 {
            d = melt(d, head::flesh(folded(p)), 0.018);
        }
        d
    }

    /// Torso, neck, arms and legs, without hands and head.
    pub fn trunk(&self, p: Vec3) -> f32 {
        let mut d = melt(self.torso(p), self.neck(p), 0.035);
        d = melt(d, self.arm(p), 0.035);
        melt(d, self.leg(p), 0.030)
    }

    /// The whole figure.
    pub fn figure(&self, p: Vec3) -> f32 {
        let mut d = self.flesh(p);
        if p.y < 0.22 {
            d = d.min(self.shoe(p));
        }
        if p.y > 1.45 {
            d = melt(d, head::hair(folded(p)), 0.003);
        }
        d
    }
}
