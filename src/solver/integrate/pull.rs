//! What is grabbed follows a target, softly and with a bounded force.
//!
//! ```text
//! p = Σ g_i x_i      λ = (target - p) / (Σ g_i² w_i + α / h²),  |λ| <= F h²      x_i += w_i g_i λ        Σ g_i = 1
//! ```
//!
//! XPBD (Macklin et al. 2016, eq. 18, one iteration) with a clamped multiplier. It comes before springs and bodies, so that the
//! cloth follows as a whole and is kept out of what is in its way.

use glam::{Vec3, Vec4};

/// One grip on a cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pull {
    /// Target at the start of the frame `[m]`, in the frame of simulation.
    pub from: Vec3,
    /// Target at the end of the frame `[m]`.
    pub to: Vec3,
    /// Compliance `[m/N]`. 0: as firm as the force allows.
    pub compliance: f32,
    /// Largest force `[N]`.
    pub force: f32,
}

/// All grips on a cloth; buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pulls {
    pulls: Vec<(Pull, usize)>,
    /// Particles and their shares, grip after grip.
    grips: Vec<(u32, f32)>,
}

impl Pulls {
    /// Lets go of everything.
    pub(crate) fn clear(&mut self) {
        self.pulls.clear();
        self.grips.clear();
    }

    /// Adds a grip on particles with shares that add up to one.
    pub(crate) fn add(&mut self, pull: Pull, grip: impl IntoIterator<Item = (u32, f32)>) {
        self.grips.extend(grip);
        self.pulls.push((pull, self.grips.len()));
    }

    /// Targets at the end of the frame `[m]`.
    pub(crate) fn targets(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.pulls.iter().map(|(pull, _)| pull.to)
    }

    /// Begins the frame at other targets `[m]`, where there are as many.
    pub(crate) fn begin_at(&mut self, targets: &[Vec3]) {
        if targets.len() == self.pulls.len() {
            self.pulls.iter_mut().zip(targets).for_each(|((pull, _), from)| pull.from = *from);
        }
    }

    /// How far a grip can move a particle in a frame of `dt` `[s]`, at most `[m]`.
    pub(crate) fn reach(&self, dt: f32, positions: &[Vec4]) -> f32 {
        let (mut first, mut farthest) = (0, 0.0f32);
        for &(pull, end) in &self.pulls {
            let grip = self.grips.get(first..end).unwrap_or(&[]);
            first = end;
            let (mut point, mut mobility, mut most) = (Vec3::ZERO, 0.0, 0.0f32);
            for &(i, share) in grip {
                if let Some(x) = positions.get(i as usize) {
                    point += x.truncate() * share;
                    mobility += x.w * share * share;
                    most = most.max(x.w * share);
                }
            }
            let way = pull.from.distance(point).max(pull.to.distance(point)) * most / mobility;
            // NaN, of what nothing moves, is passed over.
            farthest = farthest.max(way.min(pull.force * most * dt * dt));
        }
        if farthest.is_finite() { farthest } else { 0.0 }
    }

    /// Pulls, at the fraction `s` of the frame at the end of a substep of `h` `[s]`.
    pub(crate) fn solve(&self, s: f32, h: f32, positions: &mut [Vec4]) {
        let mut first = 0;
        for &(pull, end) in &self.pulls {
            let grip = self.grips.get(first..end).unwrap_or(&[]);
            first = end;
            let (mut point, mut mobility) = (Vec3::ZERO, 0.0);
            for &(i, share) in grip {
                if let Some(x) = positions.get(i as usize) {
                    point += x.truncate() * share;
                    mobility += x.w * share * share;
                }
            }
            let way = pull.from.lerp(pull.to, s) - point;
            let push = (way / (mobility + pull.compliance / (h * h))).clamp_length_max(pull.force * h * h);
            if !(mobility > 0.0 && push.is_finite()) {
                continue;
            }
            for &(i, share) in grip {
                if let Some(x) = positions.get_mut(i as usize) {
                    *x += push.extend(0.0) * (x.w * share);
                }
            }
        }
    }
}
