//! Which pairs may touch before the next frame.
//!
//! Each face is boxed together with where it is foreseen to be, relative to the motion all cloths share. Of two faces whose boxes meet, each asks with
//! the particles and edges it owns, so that every pair is asked for once.

use glam::{Vec3, Vec3A, Vec4};

use super::contact::Contact;
use super::{Contacts, Touch};
use crate::solver::body::Friction;
use crate::solver::detect::proximity::{edge_edge, distance_at_rest, vertex_face};
use crate::solver::detect::{Proximity, Surface};
use crate::solver::detect::tree::Tree;
use crate::solver::rest::NONE;

/// How much farther than its thickness a pair is looked for, in thicknesses (dimensionless): what accelerates within a frame comes from there.
const MARGIN: f32 = 0.5;

/// Pairs of one cloth are kept no farther apart than this share of their distance at rest.
const REST_SHARE: f32 = 0.7;

/// Which face asks for which particle and edge, and how far each particle goes.
#[derive(Clone, Debug, Default)]
pub struct Finder {
    /// Bits 0 to 2: corners the face owns; bits 3 to 5: its edges.
    owns: Vec<u8>,
    /// Way [m] of each particle until the next frame, beyond what all cloths share.
    motion: Vec<Vec3A>,
    /// Longest edge of each cloth at rest [m].
    longest: Vec<f32>,
}

impl Finder {
    /// Prepares finding on a surface.
    #[must_use]
    pub fn new(surface: &Surface) -> Self {
        let topology = &surface.topology;
        let mut owns = vec![0; topology.faces.len()];
        let mut owned = vec![false; surface.len()];
        for (f, t) in topology.faces.iter().enumerate() {
            for (k, &v) in t.iter().enumerate() {
                if !std::mem::replace(&mut owned[v as usize], true) {
                    owns[f] |= 1 << k;
                }
                if topology.edge_faces[topology.face_edges[f][k] as usize][0] == f as u32 {
                    owns[f] |= 8 << k;
                }
            }
        }
        let length = |e: u32| {
            let [a, b] = topology.edges[e as usize].map(|v| surface.rest[v as usize]);
            a.distance(b)
        };
        let longest = surface.parts.iter().map(|part| part.edges.clone().map(length).fold(0.0, f32::max)).collect();
        Self { owns, motion: vec![Vec3A::ZERO; surface.len()], longest }
    }

    /// Finds the pairs that may touch within `dt` [s]. `positions` and `previous` [m] of the last substep, its length [s] for each cloth in `substep`; `left_out`
    /// says of a particle that it takes no part.
    pub fn find(
        &mut self,
        surface: &Surface,
        tree: &mut Tree,
        positions: &[Vec4],
        previous: &[Vec4],
        substep: &[f32],
        touch: &[Touch],
        dt: f32,
        left_out: impl Fn(u32) -> bool,
        contacts: &mut Contacts,
    ) {
        contacts.clear();
        contacts.slots.resize(surface.len(), NONE);
        self.foresee(surface, positions, previous, substep, dt);
        let thickest = touch.iter().map(|t| t.thickness).fold(0.0, f32::max);
        tree.refit(surface, positions);
        tree.sweep(surface, positions, &self.motion);
        let topology = &surface.topology;
        let Self { owns, motion, longest } = self;
        let at = |v: u32| positions[v as usize].truncate();
        let mut ask = |pair: Proximity| {
            let [a, .., d] = pair.particles;
            let (p, q) = (surface.part(a), surface.part(d));
            let (mine, other) = (&touch[usize::from(p)], &touch[usize::from(q)]);
            let thickness = 0.5 * (mine.thickness + other.thickness);
            let ids = pair.particles;
            let foreseen: Vec3A = (0..4).map(|i| motion[ids[i] as usize] * pair.weights[i]).sum();
            let reach = (1.0 + MARGIN) * thickness + foreseen.length();
            if !(pair.distance < reach) || ids.iter().all(|&v| positions[v as usize].w == 0.0) || ids.iter().any(|&v| left_out(v)) {
                return;
            }
            let mut thickness = thickness;
            if p == q {
                let near = thickness / REST_SHARE + 2.0 * longest[usize::from(p)];
                if surface.rest[a as usize].distance_squared(surface.rest[d as usize]) < near * near {
                    thickness = thickness.min(REST_SHARE * distance_at_rest(surface, &pair));
                    if thickness <= 0.0 || pair.distance >= (1.0 + MARGIN) * thickness + foreseen.length() {
                        return;
                    }
                }
            }
            let delta: Vec3 = (0..4).map(|i| at(ids[i]) * pair.weights[i]).sum();
            contacts_push(contacts, &pair, delta, thickness, mine, other);
        };
        tree.pairs(surface, (1.0 + MARGIN) * thickest, |f, g| {
            let (tf, tg) = (topology.faces[f as usize], topology.faces[g as usize]);
            for (own, t, u) in [(owns[f as usize], tf, tg), (owns[g as usize], tg, tf)] {
                for k in 0..3 {
                    if own & (1 << k) != 0 && !u.contains(&t[k]) {
                        ask(vertex_face([t[k], u[0], u[1], u[2]], at));
                    }
                }
            }
            for i in (0..3).filter(|i| owns[f as usize] & (8 << i) != 0) {
                for j in (0..3).filter(|j| owns[g as usize] & (8 << j) != 0) {
                    let (e, h) = ([tf[i], tf[(i + 1) % 3]], [tg[j], tg[(j + 1) % 3]]);
                    if !h.contains(&e[0]) && !h.contains(&e[1]) {
                        ask(edge_edge([e[0], e[1], h[0], h[1]], at));
                    }
                }
            }
        });
    }

    /// Takes the motion of the last substep for that of the next frame, and what all cloths share away from it.
    fn foresee(&mut self, surface: &Surface, positions: &[Vec4], previous: &[Vec4], substep: &[f32], dt: f32) {
        let mut mean = Vec3A::ZERO;
        for (part, &h) in surface.parts.iter().zip(substep) {
            let scale = if h > 0.0 { dt / h } else { 0.0 };
            for v in part.particles.start as usize..part.particles.end as usize {
                self.motion[v] = Vec3A::from_vec4(positions[v] - previous[v]) * scale;
                mean += self.motion[v];
            }
        }
        mean /= surface.len().max(1) as f32;
        for motion in &mut self.motion {
            *motion -= mean;
        }
    }
}

fn contacts_push(contacts: &mut Contacts, pair: &Proximity, delta: Vec3, thickness: f32, mine: &Touch, other: &Touch) {
    let normal = delta.normalize_or_zero();
    // Exactly in touch there is no side to be on.
    if normal == Vec3::ZERO {
        return;
    }
    let friction = Friction::between(
        (mine.static_friction, mine.dynamic_friction),
        (other.static_friction, other.dynamic_friction),
    );
    let slots = pair.particles.map(|v| contacts.slot(v));
    contacts.pairs.push(Contact { kind: pair.kind, slots, weights: pair.weights, normal, thickness, friction, load: 0.0 });
}
