//! A tangle that came up within one frame is taken back: its particles go where they were when nothing crossed.
//!
//! ```text
//!   x ─► x0 + u     x0: where it was when the last frame ended clean; u: mean motion since of the cloth that crosses and moved least; velocity is kept
//! ```
//!
//! What was clean together and moves together is clean, so each look adds the particles that still cross until none do. Contacts and their guard know the
//! pairs in the next frame. Tangles that were there before, that are held, that came from far, or of cloths that
//! started in the same place are left to [`resolve`](super::resolve).

use glam::{Vec3A, Vec4};

use super::detect::{Crossing, Surface};

/// How far a particle may have gone in the frame, relative to the shared motion, in mean edges: what was moved farther, by a teleport, is not taken back.
const FARTHEST_EDGES: f32 = 4.0;

/// Frames in a row in which a particle is taken back: what is pressed through for seconds has to be taken apart.
const MOST_FRAMES: u8 = 120;

/// Frames in a row in which whole cloths stay where they were.
const MOST_STAYS: u32 = 8;

/// Where everything was when nothing crossed.
#[derive(Clone, Debug, Default)]
pub struct Retreat {
    /// Positions [m] at the end of the last frame; empty when it did not end clean.
    clean: Vec<Vec4>,
    taken: Vec<bool>,
    /// Frames in a row in which each particle was taken back.
    frames: Vec<u8>,
    /// Mean motion since then of the cloth that crosses and moved least [m]: what rests is not put where what fell on it went.
    shared: Vec3A,
    /// Whether something was taken back in this frame, and whether whole cloths stayed.
    retreats: bool,
    stayed: bool,
    /// Frames in a row in which they did.
    stays: u32,
}

impl Retreat {
    /// Whether a particle was taken back in the frame that ended last.
    pub fn took(&self, particle: u32) -> bool {
        self.frames.get(particle as usize).is_some_and(|&frames| frames > 0)
    }

    /// Notes how a frame ended; nothing is known of one that was not clean.
    pub fn note(&mut self, positions: &[Vec4], is_clean: bool) {
        self.clean.clear();
        self.frames.resize(positions.len(), 0);
        self.taken.resize(positions.len(), false);
        for (frames, taken) in self.frames.iter_mut().zip(&mut self.taken) {
            *frames = if std::mem::take(taken) { frames.saturating_add(1) } else { 0 };
        }
        if is_clean {
            self.clean.extend_from_slice(positions);
        }
        self.stays = if self.stayed { self.stays + 1 } else { 0 };
        (self.retreats, self.stayed) = (false, false);
    }

    /// Begins with nothing taken back; whether anything can be.
    pub fn begin(&mut self, surface: &Surface, crossings: &[Crossing], positions: &[Vec4]) -> bool {
        if self.clean.len() != positions.len() {
            return false;
        }
        let crosses =
            |part: u16| crossings.iter().any(|c| [surface.part_of_edge(c.edge), surface.part_of_face(c.face)].contains(&part));
        let ways = (0_u16..).zip(&surface.parts).filter(|(part, _)| crosses(*part)).map(|(_, part)| {
            let range = part.particles.start as usize..part.particles.end as usize;
            let (mut sum, mut count) = (Vec3A::ZERO, 0.0);
            for (now, then) in positions[range.clone()].iter().zip(&self.clean[range]) {
                let way = Vec3A::from_vec4(*now - *then);
                if now.w > 0.0 && way.is_finite() {
                    (sum, count) = (sum + way, count + 1.0);
                }
            }
            sum / f32::max(count, 1.0)
        });
        self.shared = ways.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(Vec3A::ZERO);
        true
    }

    /// Takes the particles that cross back; whether there were any that had not been.
    pub fn take(&mut self, surface: &Surface, crossings: &[Crossing], positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        let topology = &surface.topology;
        let farthest = FARTHEST_EDGES * surface.mean_edge;
        let mut any = false;
        for crossing in crossings {
            let (e, f) = (topology.edges[crossing.edge as usize], topology.faces[crossing.face as usize]);
            for v in e.into_iter().chain(f).map(|v| v as usize) {
                let by = self.shared - Vec3A::from_vec4(positions[v] - self.clean[v]);
                if positions[v].w > 0.0
                    && self.frames[v] < MOST_FRAMES
                    && by.length_squared() < farthest * farthest
                    && !std::mem::replace(&mut self.taken[v], true)
                {
                    let by = by.extend(0.0);
                    positions[v] += by;
                    previous[v] += by;
                    any = true;
                }
            }
        }
        self.retreats |= any;
        any
    }

    /// Whether something was taken back in this frame, and whole cloths may stay where they were.
    pub fn may_stay(&self) -> bool {
        self.retreats && self.stays < MOST_STAYS
    }

    /// Puts the cloths that cross where they were, as a whole; velocity is kept. A body pushed what was taken back, and nothing else is known to be clean.
    pub fn stay(&mut self, surface: &Surface, crossings: &[Crossing], positions: &mut [Vec4], previous: &mut [Vec4]) {
        self.stayed = true;
        for (part, range) in (0_u16..).zip(surface.parts.iter().map(|part| part.particles.clone())) {
            if !crossings.iter().any(|c| [surface.part_of_edge(c.edge), surface.part_of_face(c.face)].contains(&part)) {
                continue;
            }
            for v in range.start as usize..range.end as usize {
                let by = (self.clean[v] - positions[v]).truncate().extend(0.0);
                if positions[v].w > 0.0 && by.is_finite() {
                    positions[v] += by;
                    previous[v] += by;
                }
            }
        }
    }
}
