//! The order of layers of clothing: of two cloths, the one with the larger number is worn outside.
//!
//! ```text
//!        ↑ normals       ── 1 ──  ●         inner and outer face the same way: what of the outer one lies behind the inner one
//!    ════╪═══════════════ 0 ══════╪══  ⇒    goes out along the inner one's normals, and the inner one goes in.
//!        ● ── 1 ──────────────────┘
//! ```
//!
//! Where cloths of different layers cross, their order decides, whatever would be shorter: each particle goes along the normal
//! of what it has to pass. Cloths that lie in the wrong order without crossing are found by looking along the normals of a few
//! particles in every iteration. Where pins hold both on the wrong side of each other nothing could come of it, and the order
//! is not asked for.

use glam::{Vec3, Vec4};

use super::plan::Plans;
use super::separation::Stray;
use crate::solver::detect::Surface;
use crate::solver::detect::tree::Tree;
use crate::solver::scales::ALIGNED;
use crate::solver::topology::NONE;

/// Particles looked at per iteration, and the largest stride between them: a larger surface has more particles looked at.
const SAMPLES: u32 = 64;
const STRIDE: u32 = 61;
/// Share of the particles looked at of a cloth that must be on the wrong side without a crossing.
const MANY: f32 = 0.1;
/// How far is looked for a cloth on the wrong side, in thicknesses and in edges; the larger counts.
const REACH: [f32; 2] = [10.0, 4.0];

/// Two cloths whose order is being restored.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pair {
    /// The outer and the inner cloth.
    pub cloths: [u16; 2],
    /// What is being done; 0: nothing.
    pub plan: u32,
    /// Whether pins hold them in another order.
    pub held: bool,
}

/// What is being done about the order of layers. Buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Layers {
    pub plans: Plans,
    pub pairs: Vec<Pair>,
    /// Particles found on the wrong side, with their outer and inner cloths.
    pub strays: Vec<([u16; 2], Stray)>,
    pub of_pair: Vec<Stray>,
    counts: Vec<u32>,
    turn: u32,
    /// Whether to look at all particles at once.
    pub thorough: bool,
}

impl Layers {
    /// Gives everything up.
    pub(super) fn clear(&mut self) {
        self.plans.clear();
        self.pairs.clear();
        self.strays.clear();
    }

    /// Whether there is something to be done.
    pub(super) fn any(&self) -> bool {
        self.plans.any() || !self.strays.is_empty()
    }

    /// Looks for cloths on the wrong side of each other, as seen from some of their particles. The tree must fit the positions,
    /// to a tenth of an edge.
    pub(super) fn patrol(&mut self, surface: &Surface, tree: &mut Tree, positions: &[Vec4]) {
        self.strays.clear();
        // Pins may have changed.
        self.pairs.retain(|p| !p.held);
        let some = (surface.len() as u32 / SAMPLES).clamp(1, STRIDE);
        let stride = if core::mem::take(&mut self.thorough) { 1 } else { some };
        self.turn = self.turn.wrapping_add(1);
        for v in (self.turn % stride..surface.len() as u32).step_by(stride as usize) {
            let at = positions[v as usize].truncate();
            let part = surface.part(v);
            let normal = normal(surface, positions, v);
            if tree.is_quarantined(part) || normal == Vec3::ZERO {
                continue;
            }
            let mine = &surface.parts[usize::from(part)];
            let reach = (REACH[0] * mine.thickness).max(REACH[1] * surface.mean_edge);
            for side in 0..2 {
                let path = if side == 0 { reach * normal } else { -reach * normal };
                let mut nearest = (1.0, NONE);
                tree.along(at, path, |face| {
                    if !surface.topology.faces[face as usize].contains(&v)
                        && let Some(share) = hit(surface, positions, at, path, face)
                        && (share, face) < nearest
                    {
                        nearest = (share, face);
                    }
                });
                let (share, face) = nearest;
                if face == NONE || !faces_as(surface, positions, face, normal) {
                    // What lies beyond another fold belongs there.
                    continue;
                }
                let other = surface.part_of_face(face);
                let layer = surface.parts[usize::from(other)].garment_layer;
                let is_wrong = if side == 0 { layer < mine.garment_layer } else { layer > mine.garment_layer };
                if is_wrong {
                    let pair = if side == 0 { [part, other] } else { [other, part] };
                    // Projected along the normal of the face, the way may be a little longer.
                    let near = share * reach / ALIGNED + surface.mean_edge;
                    self.strays.push((pair, Stray { side, particle: v, face, near }));
                }
            }
        }
        // The rim of a cloth may curl around another one.
        self.counts.clear();
        self.counts.resize(surface.parts.len(), 0);
        for (_, stray) in &self.strays {
            self.counts[usize::from(surface.part(stray.particle))] += 1;
        }
        let counts = &self.counts;
        let many = |part: u16| {
            let part = usize::from(part);
            let asked = surface.parts[part].particles.len() as f32 / stride as f32;
            counts[part] as f32 >= (MANY * asked).max(2.0)
        };
        self.strays.retain(|(pair, _)| pair.iter().any(|&p| many(p)));
    }
}

/// Unit normal of the surface at a particle; zero where there is none.
fn normal(surface: &Surface, positions: &[Vec4], particle: u32) -> Vec3 {
    let topology = &surface.topology;
    let faces = topology.around(particle).iter().flat_map(|&(_, e)| topology.edge_faces[e as usize]).filter(|&f| f != NONE);
    let sum: Vec3 = faces
        .map(|f| {
            let [a, b, c] = topology.faces[f as usize].map(|v| positions[v as usize].truncate());
            (b - a).cross(c - a)
        })
        .sum();
    if sum.is_finite() { sum.normalize_or_zero() } else { Vec3::ZERO }
}

/// Whether a face faces about the way `normal` does.
fn faces_as(surface: &Surface, positions: &[Vec4], face: u32, normal: Vec3) -> bool {
    let [a, b, c] = surface.topology.faces[face as usize].map(|v| positions[v as usize].truncate());
    let mine = (b - a).cross(c - a);
    mine.dot(normal) >= ALIGNED * mine.length()
}

/// Where along `path` a face is met, as a fraction.
fn hit(surface: &Surface, positions: &[Vec4], from: Vec3, path: Vec3, face: u32) -> Option<f32> {
    let [a, b, c] = surface.topology.faces[face as usize].map(|v| positions[v as usize].truncate());
    let normal = (b - a).cross(c - a);
    let share = (a - from).dot(normal) / path.dot(normal);
    let x = from + share * path;
    let inside = [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| (q - p).cross(x - p).dot(normal) >= 0.0);
    (inside && share > 0.0 && share < 1.0).then_some(share)
}

/// The outer and the inner one of two cloths; none if they have no order.
pub(super) fn ordered(surface: &Surface, [a, b]: [u16; 2]) -> Option<[u16; 2]> {
    let [x, y] = [a, b].map(|p| surface.parts[usize::from(p)].garment_layer);
    match x.cmp(&y) {
        core::cmp::Ordering::Greater => Some([a, b]),
        core::cmp::Ordering::Less => Some([b, a]),
        core::cmp::Ordering::Equal => None,
    }
}
