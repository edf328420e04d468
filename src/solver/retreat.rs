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

/// How far a particle may have gone in the frame, relative to the shared motion, in mean edges, and beyond that as far as the fastest particle flies in a frame: what was moved
/// farther, by a teleport, is not taken back.
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
    /// Farthest way back [m].
    farthest: f32,
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

    /// Begins with nothing taken back; whether anything can be. `substeps` of each cloth make up the frame, and the last of them lies between `previous` and `positions` [m].
    pub fn begin(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        previous: &[Vec4],
        substeps: impl Fn(usize) -> f32,
    ) -> bool {
        if self.clean.len() != positions.len() {
            return false;
        }
        let crosses =
            |part: u16| crossings.iter().any(|c| [surface.part_of_edge(c.edge), surface.part_of_face(c.face)].contains(&part));
        let (mut shared, mut fastest) = (None, 0.0f32);
        for (i, part) in surface.parts.iter().enumerate().filter(|(part, _)| crosses(*part as u16)) {
            let range = part.particles.start as usize..part.particles.end as usize;
            let (mut sum, mut count, mut speed) = (Vec3A::ZERO, 0.0, 0.0f32);
            for ((now, old), then) in positions[range.clone()].iter().zip(&previous[range.clone()]).zip(&self.clean[range]) {
                let way = Vec3A::from_vec4(*now - *then);
                if now.w > 0.0 && way.is_finite() {
                    (sum, count) = (sum + way, count + 1.0);
                    speed = speed.max(Vec3A::from_vec4(*now - *old).length_squared());
                }
            }
            let mean = sum / f32::max(count, 1.0);
            shared = shared.filter(|least: &Vec3A| least.length_squared() <= mean.length_squared()).or(Some(mean));
            fastest = fastest.max(speed.sqrt() * substeps(i));
        }
        self.shared = shared.unwrap_or(Vec3A::ZERO);
        self.farthest = FARTHEST_EDGES * surface.mean_edge + if fastest.is_finite() { fastest } else { 0.0 };
        true
    }

    /// Takes the particles that cross back; whether there were any that had not been.
    pub fn take(&mut self, surface: &Surface, crossings: &[Crossing], positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        let topology = &surface.topology;
        let mut any = false;
        for crossing in crossings {
            let (e, f) = (topology.edges[crossing.edge as usize], topology.faces[crossing.face as usize]);
            for v in e.into_iter().chain(f).map(|v| v as usize) {
                let by = self.shared - Vec3A::from_vec4(positions[v] - self.clean[v]);
                if positions[v].w > 0.0
                    && self.frames[v] < MOST_FRAMES
                    && by.length_squared() < self.farthest * self.farthest
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

    /// Puts the cloths that cross where they were, as a whole, and says whether it did: a body pushed what was taken back, or it crosses elsewhere, and nothing else is known to be clean.
    /// Velocity is kept but that of what was taken back, which would do the same again. What came from far does not stay.
    pub fn stay(&mut self, surface: &Surface, crossings: &[Crossing], positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        let crosses =
            |part: u16| crossings.iter().any(|c| [surface.part_of_edge(c.edge), surface.part_of_face(c.face)].contains(&part));
        let mut any = false;
        for (_, part) in (0_u16..).zip(&surface.parts).filter(|(part, _)| crosses(*part)) {
            let range = part.particles.start as usize..part.particles.end as usize;
            let way = |(now, then): (&Vec4, &Vec4)| Vec3A::from_vec4(*now - *then).length_squared();
            if positions[range.clone()]
                .iter()
                .zip(&self.clean[range.clone()])
                .map(way)
                .any(|way| way > self.farthest * self.farthest)
            {
                continue;
            }
            any = true;
            for v in range {
                let by = (self.clean[v] - positions[v]).truncate().extend(0.0);
                if positions[v].w > 0.0 && by.is_finite() {
                    positions[v] += by;
                    previous[v] += by;
                    if self.taken[v] {
                        previous[v] = positions[v].with_w(previous[v].w);
                    }
                }
            }
        }
        self.stayed |= any;
        any
    }
}
