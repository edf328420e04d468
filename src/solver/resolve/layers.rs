//! The order of layers of clothing: of two cloths, the one with the larger number is worn outside.
//!
//! ```text
//!        ↑ normals       ── 1 ──  ●          inner and outer face the same way: what of the outer one lies behind the inner one
//!    ════╪═══════════════ 0 ══════╪══  ⇒     goes out along the inner one's normals, and the inner one goes in.
//!        ● ── 1 ──────────────────┘
//! ```
//!
//! Where cloths of different layers cross, their order decides, whatever would be shorter: each particle goes along the normal of what it has to
//! pass. Cloths that lie in the wrong order without crossing are found by looking along the normals of a few particles in every iteration. Where
//! pins hold both on the wrong side of each other nothing could come of it, and the order is not asked for.

use glam::{Vec3, Vec4};

use super::between::cloths;
use super::contour::ContourGraph;
use super::plan::Plans;
use super::separate::{AGREE, ONE_WAY, agreement, facing, facing_at, mean};
use super::separation::{Course, Member, Stray};
use super::{Resolver, View};
use crate::solver::detect::Surface;
use crate::solver::detect::tree::Tree;
use crate::solver::topology::NONE;

/// So many particles are looked at per iteration, and one in so many at least.
const SAMPLES: u32 = 64;
const STRIDE: u32 = 61;
/// Share of the particles looked at of a cloth that must be on the wrong side without a crossing.
const MANY: f32 = 0.1;
/// How far is looked for a cloth on the wrong side, in thicknesses and in edges; the larger counts.
const REACH: [f32; 2] = [10.0, 4.0];

/// Which side of a contour the inner cloth is on: pairs are named the outer one first.
const INNER: usize = 1;

/// Share of the pins met on the way that must hold both cloths in another order for it to be theirs.
const HELD: f32 = 0.5;

/// Share of the crossings that moving one way must undo.
const UNDONE: f32 = 0.8;

/// Two cloths whose order is being restored.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Pair {
    /// The outer and the inner cloth.
    cloths: [u16; 2],
    /// What is being done; 0: nothing.
    plan: u32,
    /// Whether pins hold them in another order.
    held: bool,
}

/// What is being done about the order of layers. Buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Layers {
    pub plans: Plans,
    pairs: Vec<Pair>,
    /// Particles found on the wrong side, with their outer and inner cloths.
    strays: Vec<([u16; 2], Stray)>,
    of_pair: Vec<Stray>,
    counts: Vec<u32>,
    turn: u32,
    /// Whether to look at all particles at once.
    pub thorough: bool,
}

impl Layers {
    /// Gives everything up.
    pub fn clear(&mut self) {
        self.plans.clear();
        self.pairs.clear();
        self.strays.clear();
    }

    /// Whether there is something to be done.
    pub fn any(&self) -> bool {
        self.plans.any() || !self.strays.is_empty()
    }

    /// Looks for cloths on the wrong side of each other, as seen from some of their particles. The tree must fit the positions, to a tenth
    /// of an edge.
    pub fn patrol(&mut self, surface: &Surface, tree: &mut Tree, positions: &[Vec4]) {
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
                let layer = surface.parts[usize::from(other)].layer;
                let is_wrong = if side == 0 { layer < mine.layer } else { layer > mine.layer };
                if is_wrong {
                    let pair = if side == 0 { [part, other] } else { [other, part] };
                    // Projected along the normal of the face, the way may be a little longer.
                    let near = share * reach / AGREE + surface.mean_edge;
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
    mine.dot(normal) >= AGREE * mine.length()
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
fn ordered(surface: &Surface, [a, b]: [u16; 2]) -> Option<[u16; 2]> {
    let [x, y] = [a, b].map(|p| surface.parts[usize::from(p)].layer);
    match x.cmp(&y) {
        core::cmp::Ordering::Greater => Some([a, b]),
        core::cmp::Ordering::Less => Some([b, a]),
        core::cmp::Ordering::Equal => None,
    }
}

/// The way out of the outer cloth: where the inner one faces, if that is about the same all along, else each particle its own. None where the cloths
/// face opposite ways: what one goes by would drive the other out, too.
fn outward(view: View<'_>, graph: &ContourGraph, set: &[Member], strays: &[Stray]) -> Option<Course> {
    // A stray of the inner cloth only knows the outer one; where it lies on the wrong side they face the same way.
    let mean = mean(facing_at(view, graph, set, INNER).chain(strays.iter().map(|s| facing(view, s.face))));
    if mean.length() > ONE_WAY {
        return Some(Course::Along(mean.normalize_or_zero()));
    }
    (agreement(view, graph, set) > -AGREE).then_some(Course::Facing([1.0, -1.0]))
}

impl Resolver {
    /// Plans how cloths get into the order of their layers, in steps of at most `step` `[m]`.
    pub(super) fn order(&mut self, view: View<'_>, step: f32) {
        let Self { graph, between, layers: Layers { plans, pairs, strays, of_pair, .. }, separation, set, .. } = self;
        pairs.retain(|p| plans.is_live(p.plan));
        let at_contours = (0..graph.contours.len()).filter_map(|k| ordered(view.surface, cloths(view, graph, k)?));
        for cloths in at_contours.chain(strays.iter().map(|s| s.0)) {
            if pairs.iter().any(|p| p.cloths == cloths) {
                continue;
            }
            set.clear();
            set.extend(between.of(cloths));
            of_pair.clear();
            of_pair.extend(strays.iter().filter(|s| s.0 == cloths).map(|s| s.1));
            let (mut plan, mut held) = (0, false);
            if let Some(course) = outward(view, graph, set, of_pair) {
                separation.look_from(view, graph, set, of_pair, course);
                held = separation.pins[1] as f32 >= HELD * (separation.pins[0].max(1)) as f32;
                if !held && separation.cost > 0.0 && (set.is_empty() || separation.undone >= UNDONE) {
                    plan = plans.carry_out(view, graph, set, separation, step);
                }
            }
            pairs.push(Pair { cloths, plan, held });
        }
        // What nothing is done about is as good as in order.
        strays.retain(|s| pairs.iter().any(|p| p.cloths == s.0 && p.plan != 0));
    }

    /// Cloths whose order of layers is not that of their pins, and is let be: the one that is to be outside first.
    pub fn overruled_layers(&self) -> impl Iterator<Item = [u16; 2]> + '_ {
        self.layers.pairs.iter().filter(|p| p.held).map(|p| p.cloths)
    }

    /// Whether the order of layers takes care of a contour.
    pub(super) fn is_ordered(&self, view: View<'_>, contour: usize) -> bool {
        let pairs = &self.layers.pairs;
        let pair = cloths(view, &self.graph, contour).and_then(|c| ordered(view.surface, c));
        pair.is_some_and(|c| pairs.iter().any(|p| p.cloths == c && p.plan != 0))
    }
}
