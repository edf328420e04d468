//! Particles and faces that come closer than a distance, except those of one cloth within [`RINGS`] edges of each other, or as
//! close at rest.

use glam::Vec4;

use super::crossing::Detector;
use super::proximity::{Proximity, vertex_face};
use super::surface::Surface;
use crate::solver::effort::Meter;

/// Edges from a particle to a face of the same cloth within which the two are left out.
const RINGS: u32 = 2;

impl Detector {
    /// Finds the pairs within `distance` `[m]` at `positions` (`[m]`, `w` inverse mass), in a fixed order, into `found`. Where
    /// there is too much work, those that come last are left out.
    pub(crate) fn close_pairs(
        &mut self,
        surface: &Surface,
        positions: &[Vec4],
        distance: f32,
        meter: &Meter,
        found: &mut Vec<Proximity>,
    ) {
        found.clear();
        if positions.len() != surface.len() {
            return;
        }
        self.tree.refit(surface, positions, None);
        let faces = &surface.topology.faces;
        let at = |v: u32| positions[v as usize].truncate();
        let mut pair = |f: u32, g: u32| {
            meter.spend(1);
            let (tf, tg) = (faces[f as usize], faces[g as usize]);
            if tf.iter().chain(&tg).all(|&v| positions[v as usize].w == 0.0) {
                return;
            }
            for (t, u) in [(tf, tg), (tg, tf)] {
                for v in t.into_iter().filter(|v| !u.contains(v)) {
                    let pair = vertex_face([v, u[0], u[1], u[2]], at);
                    if pair.distance < distance && !is_excluded(surface, &pair, distance) {
                        found.push(pair);
                    }
                }
            }
        };
        self.tree.meetings(surface, distance, meter, |tree, met| tree.pairs_of(met, &mut pair));
        // Pairs were met once per face around the particle: order them and keep each once.
        found.sort_unstable_by_key(|pair| pair.particles);
        found.dedup_by_key(|pair| pair.particles);
    }
}

fn is_excluded(surface: &Surface, pair: &Proximity, distance: f32) -> bool {
    let [p, face @ ..] = pair.particles;
    let at_rest = || vertex_face(pair.particles, |v| surface.rest[v as usize]).distance;
    surface.part(p) == surface.part(face[0]) && (at_rest() < distance || within(surface, p, &face, RINGS))
}

/// Whether a particle is at most `rings` edges from one of the targets.
fn within(surface: &Surface, from: u32, targets: &[u32], rings: u32) -> bool {
    targets.contains(&from)
        || (rings > 0 && surface.topology.around(from).iter().any(|&(u, _)| within(surface, u, targets, rings - 1)))
}
