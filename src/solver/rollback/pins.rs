//! What crosses a pin goes where the pin takes it.
//!
//! ```text
//!   x0 ─► c + q (x0 - c0)     the rigid motion of the pins that are joined
//! ```
//!
//! Pins are joined by a few edges between them: each end of a strip that is twisted turns by itself, and a rail bends.

use glam::{Vec3, Vec4};

use super::Crossing;
use crate::solver::detect::Surface;
use crate::solver::rigid::Rigid;

/// Edges from a pin that is crossed to the farthest that it is joined to.
const RINGS: u32 = 12;

/// Rides of pins that cross something, and what rides along.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pins {
    rides: Vec<Rigid>,
    /// Which of them each particle is on, plus one; 0: none.
    on: Vec<u32>,
    queue: Vec<u32>,
}

impl Pins {
    /// Nothing rides.
    pub(super) fn forget(&mut self) {
        self.rides.clear();
        self.on.clear();
    }

    /// Puts what crosses pins, or what rides along with them, on their ride: from `clean` to `positions` `[m]`.
    pub(super) fn meet(&mut self, surface: &Surface, crossings: &[Crossing], positions: &[Vec4], clean: &[Vec4]) {
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

    /// Where particle `v` rides that was at `clean` `[m]`; none if it does not.
    pub(super) fn destination(&self, v: usize, clean: Vec3) -> Option<Vec3> {
        let ride = self.rides.get(self.on.get(v)?.checked_sub(1)? as usize)?;
        let to = ride.point(clean);
        to.is_finite().then_some(to)
    }

    /// Puts the pins that are joined to pin `v` on a ride of their own.
    fn board(&mut self, surface: &Surface, v: u32, positions: &[Vec4], clean: &[Vec4]) {
        let number = self.rides.len() as u32 + 1;
        self.queue.clear();
        self.queue.push(v);
        self.on[v as usize] = number;
        let mut first = 0;
        for _ in 0..RINGS {
            let ring = first..self.queue.len();
            first = ring.end;
            for i in ring {
                for &(u, _) in surface.topology.around(self.queue[i]) {
                    if positions[u as usize].w == 0.0 && self.on[u as usize] == 0 {
                        self.on[u as usize] = number;
                        self.queue.push(u);
                    }
                }
            }
        }
        let all = || self.queue.iter().map(|&v| (clean[v as usize].truncate(), positions[v as usize].truncate()));
        self.rides.push(Rigid::fit(all));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Quat, Vec3, Vec4, vec3};

    use super::*;
    use crate::solver::detect::PartRef;
    use crate::solver::topology::Topology;

    fn surface(topology: &Arc<Topology>, rest: &[Vec3]) -> Surface {
        let part = PartRef { topology, rest, garment_layer: 0, self_collision: true, thickness: 0.01 };
        Surface::new(&[part]).expect("a cloth")
    }

    /// A strip of three by two pins is turned as a whole. Returns how far the corners of its first face end from where they
    /// ride.
    fn miss(axis: Vec3, degrees: f32) -> f32 {
        let topology = Arc::new(Topology::new(6, vec![[0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 5, 4]]));
        let rest: Vec<Vec3> = (0u8..6).map(|i| vec3(f32::from(i % 3) * 0.5, f32::from(i / 3) * 0.4, 0.0)).collect();
        let surface = surface(&topology, &rest);
        let turn = Quat::from_axis_angle(axis.normalize(), degrees.to_radians());
        let clean: Vec<Vec4> = rest.iter().map(|x| x.extend(0.0)).collect();
        let positions: Vec<Vec4> = rest.iter().map(|x| (turn * *x + Vec3::X).extend(0.0)).collect();
        let mut pins = Pins::default();
        let crossing = Crossing { edge: 0, face: 0, t: 0.5, weights: [1.0 / 3.0; 3], touching: false };
        pins.meet(&surface, &[crossing], &positions, &clean);
        let misses = (0..6).map(|v| pins.destination(v, rest[v]).map_or(f32::NAN, |to| to.distance(positions[v].truncate())));
        misses.fold(0.0, f32::max)
    }

    #[test]
    fn a_ride_goes_where_its_pins_went() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, vec3(1.0, 1.0, 0.3), vec3(-0.2, 0.5, 1.0)] {
            for (degrees, bound) in [(0.0, 1.0e-6), (2.0, 1.0e-5), (10.0, 1.0e-5), (30.0, 1.0e-5), (60.0, 1.0e-3)] {
                let miss = miss(axis, degrees);
                assert!(miss <= bound, "{degrees}° about {axis}: {miss} m");
            }
        }
    }

    #[test]
    fn pins_beyond_a_few_rings_ride_by_themselves() {
        let n = 2 * RINGS + 2;
        let triangles =
            (0..n - 1).map(|i| [2 * i, 2 * i + 2, 2 * i + 1]).chain((0..n - 1).map(|i| [2 * i + 1, 2 * i + 2, 2 * i + 3]));
        let topology = Arc::new(Topology::new(2 * n, triangles.collect()));
        let rest: Vec<Vec3> = (0..2 * n).map(|i| vec3((i / 2) as f32, (i % 2) as f32, 0.0)).collect();
        let surface = surface(&topology, &rest);
        let clean: Vec<Vec4> = rest.iter().map(|x| x.extend(0.0)).collect();
        let mut positions = clean.clone();
        // Its far end goes up.
        positions[2 * n as usize - 1].z = 1.0;
        let mut pins = Pins::default();
        let crossing = Crossing { edge: 0, face: 0, t: 0.5, weights: [1.0 / 3.0; 3], touching: false };
        pins.meet(&surface, &[crossing], &positions, &clean);
        assert_eq!(pins.destination(0, rest[0]), Some(rest[0]));
        assert_eq!(pins.destination(2 * n as usize - 1, rest[0]), None);
    }
}
