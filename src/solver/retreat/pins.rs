//! What crosses a pin goes where the pin takes it.
//!
//! ```text
//!   x0 ─► c + q (x0 - c0)                 c0, c: centre of the pins that are joined, then and now
//!   Σ (|r|² 1 - r rᵀ) s = Σ r × (p - c)   r = p0 - c0;  s: axis times sine of the turn that brings pins p0 closest to p
//!   q ~ (s, 1 + √(1 - s²))
//! ```
//!
//! Pins are joined by edges between them: each end of a strip that is twisted turns by itself. Of the turn around a straight row of pins nothing
//! is known; it is the least.

use glam::{Mat3, Quat, Vec3, Vec4};

use super::Crossing;
use crate::solver::detect::Surface;

/// Share of its trace that is added to the diagonal of the matrix above (dimensionless): a row of pins leaves it singular.
const LEAST_TURN: f32 = 1.0e-4;

/// How pins that are joined went in the frame.
#[derive(Clone, Copy, Debug)]
struct Ride {
    from: Vec3,
    to: Vec3,
    turn: Quat,
}

/// Rides of pins that cross something, and what rides along.
#[derive(Clone, Debug, Default)]
pub(super) struct Pins {
    rides: Vec<Ride>,
    /// Which of them each particle is on, plus one; 0: none.
    on: Vec<u32>,
    queue: Vec<u32>,
}

impl Pins {
    /// Nothing rides.
    pub fn forget(&mut self) {
        self.rides.clear();
        self.on.clear();
    }

    /// Puts what crosses pins, or what rides along with them, on their ride: from `clean` to `positions` [m].
    pub fn meet(&mut self, surface: &Surface, crossings: &[Crossing], positions: &[Vec4], clean: &[Vec4]) {
        self.on.resize(positions.len(), 0);
        let particles = |c: &Crossing| {
            let (e, f) = (surface.topology.edges[c.edge as usize], surface.topology.faces[c.face as usize]);
            e.into_iter().chain(f)
        };
        for v in crossings.iter().flat_map(particles) {
            if positions[v as usize].w == 0.0 && self.on[v as usize] == 0 {
                self.board(surface, v, positions, clean);
            }
        }
        for crossing in crossings {
            let ride = particles(crossing).map(|v| self.on[v as usize]).max().unwrap_or_default();
            particles(crossing).filter(|&v| positions[v as usize].w > 0.0).for_each(|v| {
                let on = &mut self.on[v as usize];
                *on = if *on == 0 { ride } else { *on };
            });
        }
    }

    /// Where particle `v` rides that was at `clean` [m]; none if it does not.
    pub fn carry(&self, v: usize, clean: Vec3) -> Option<Vec3> {
        let ride = self.rides.get(self.on.get(v)?.checked_sub(1)? as usize)?;
        let to = ride.to + ride.turn * (clean - ride.from);
        to.is_finite().then_some(to)
    }

    /// Puts all pins that are joined to pin `v` on a ride of their own.
    fn board(&mut self, surface: &Surface, v: u32, positions: &[Vec4], clean: &[Vec4]) {
        let number = self.rides.len() as u32 + 1;
        self.queue.clear();
        self.queue.push(v);
        self.on[v as usize] = number;
        let mut next = 0;
        while let Some(&v) = self.queue.get(next) {
            next += 1;
            for &(u, _) in surface.topology.around(v) {
                if positions[u as usize].w == 0.0 && self.on[u as usize] == 0 {
                    self.on[u as usize] = number;
                    self.queue.push(u);
                }
            }
        }
        let all = || self.queue.iter().map(|&v| (clean[v as usize].truncate(), positions[v as usize].truncate()));
        let count = self.queue.len() as f32;
        let (from, to) = all().fold((Vec3::ZERO, Vec3::ZERO), |sum, (from, to)| (sum.0 + from, sum.1 + to));
        let (from, to) = (from / count, to / count);
        let (mut matrix, mut moment, mut trace) = (Mat3::ZERO, Vec3::ZERO, 0.0);
        for (then, now) in all() {
            let r = then - from;
            let square = r.length_squared();
            matrix += Mat3::from_diagonal(Vec3::splat(square)) - Mat3::from_cols(r * r.x, r * r.y, r * r.z);
            moment += r.cross(now - to);
            trace += 2.0 * square;
        }
        let sine = if trace > 0.0 {
            (matrix + Mat3::from_diagonal(Vec3::splat(LEAST_TURN * trace))).inverse() * moment
        } else {
            Vec3::ZERO
        };
        let cosine = (1.0 - sine.length_squared()).max(0.0).sqrt();
        let turn = Quat::from_vec4(sine.extend(1.0 + cosine)).normalize();
        self.rides.push(Ride { from, to, turn });
    }
}
