//! Resolve: take crossing surfaces apart.
//!
//! ```text
//! crossings ─► contour graph ─► what was decided for each contour ─► displacements, capped ─► positions and previous together
//! ```
//!
//! One call to [`Resolver::advance`] is one iteration. It moves every tangled particle by at most a fraction of an edge and
//! leaves the cloth to its springs. Positions and previous positions move together, so untangling injects no velocity. The
//! remaining motion of both sides into each other is taken out as in an inelastic collision.
//!
//! | end type | first | when that makes no progress |
//! |---|---|---|
//! | BBII, BIBI, Closed, long LL | translate | region push (BIBI, Closed: global gradient), then in turn |
//! | short LL | gradient of stretches | global gradient, gradient of stretches, ... |
//! | Cross | region push | global gradient, region push, ..., gradient of stretches |
//! | Eight, BLI, unknown | global gradient | region push, global gradient, ..., gradient of stretches |
//! | any, between two layers of clothing | into their order | |

pub(crate) mod contour;
pub(crate) mod gradient;
#[cfg(feature = "research")]
pub(crate) mod history;
pub(crate) mod tracked;
pub(crate) mod region;
mod between;
mod approach;
mod facing;
mod layers;
mod order;
mod mark;
mod nearest;
mod patch;
mod stretch_gradient;
mod plan;
mod separation;
mod region_push;
mod translate;
mod mass_split;
mod displacements;
mod global_gradient;
mod turns;
mod view;
mod votes;

pub use contour::{Contour, ContourGraph, ContourKind};
pub use gradient::Terms;
pub use tracked::Strategy;

use glam::{Vec3, Vec4};

use crate::solver::buffer::Buffer;
use crate::solver::detect::{Crossing, Detector, Surface};
use crate::solver::effort::Effort;
use crate::solver::rigid::Rigid;
use crate::solver::verdict::{Escalation, Verdict};

use between::Between;
use displacements::Displacements;
#[cfg(feature = "research")]
use history::{History, Push};
use layers::Layers;
use patch::Patch;
use plan::Plans;
use region::Flood;
use separation::{Member, Separation};
use tracked::TrackedContours;
use view::View;

/// Crossings of a contour between two loop vertices from which on its sides are sheets, not creases.
const LONG: u32 = 32;

/// Edges of a region for which a push may stall one iteration longer: a region gathers pace, the longer the more edges it hangs
/// on.
const EDGES_A_STALL: u32 = 4;

/// Switches of strategy after each of which a contour may stall twice as long.
const MOST_DOUBLINGS: u32 = 4;

/// Of this number of switches from a region push, one is to the gradient of stretches.
const STRETCH_EVERY: u32 = 4;

/// How crossing surfaces are taken apart; the methods of others, to compare with, are there with the feature `research`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum Method {
    /// The traditional method (1995): remember on which side of each other particles and faces were, and push them back there.
    #[cfg(feature = "research")]
    History,
    /// Each crossing on its own follows the gradient of the contour's length (Volino and Magnenat-Thalmann 2006).
    #[cfg(feature = "research")]
    LocalGradient,
    /// One summed gradient per contour (Wen et al. 2009).
    #[cfg(feature = "research")]
    GlobalGradient,
    /// Per contour, by how it ends: the cheapest way apart, region push, summed gradient with the exact vertex gradient, or
    /// gradient along stretches. Another of these is used when one makes no progress. Layers of clothing come into their order.
    #[default]
    ByEndType,
}

impl Method {
    /// Whether it goes by sides that it remembers, not by crossings.
    #[must_use]
    pub(crate) const fn remembers_sides(self) -> bool {
        #[cfg(feature = "research")]
        return matches!(self, Self::History);
        #[cfg(not(feature = "research"))]
        false
    }
}

/// Tunables of resolving.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct ResolveSettings {
    /// The method.
    pub method: Method,
    /// Largest displacement of a particle per iteration, as a fraction of the mean edge, of each side when both are equally
    /// heavy. Default 0.1. Smaller is slower; much larger overshoots and folds triangles over.
    pub step: f32,
    /// Iterations without progress after which a contour's strategy is changed; doubled with every change. Default 10.
    pub stall_iterations: u32,
    /// Largest growth of the step of a contour that keeps moving in one direction. Default 5. More is faster on deep tangles
    /// and tears at the edges around a pushed region; 1 keeps every step the same.
    pub pace: f32,
    /// How far the motion of a shrinking contour spreads into its sheets, as a fraction of its length. Default 0.5. 0 moves
    /// only the particles at the contour, which the rest of a fine sheet holds back.
    pub spread: f32,
}

impl Default for ResolveSettings {
    fn default() -> Self {
        Self { method: Method::default(), step: 0.1, stall_iterations: 10, pace: 5.0, spread: 0.5 }
    }
}

/// Takes tangles apart, one iteration per call. Buffers are reused; nothing is allocated once warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Resolver {
    graph: ContourGraph,
    between: Between,
    tracked: TrackedContours,
    flood: Flood,
    terms: Buffer<Vec<Terms>>,
    points: Vec<Vec3>,
    pulls: Buffer<Vec<Vec3>>,
    smooth: Buffer<Vec<Vec3>>,
    along: Buffer<Vec<Vec3>>,
    /// How far particles go in this iteration `[m]`.
    displacements: Buffer<Displacements>,
    /// What is taken from their motion into each other, over a substep `[m]`.
    approach: Buffer<Displacements>,
    patch: Patch,
    escalation: Escalation,
    layers: Layers,
    plans: Plans,
    separation: Separation,
    set: Buffer<Vec<Member>>,
    /// Work of this frame.
    pub(crate) effort: Effort,
    /// Contours that the last iteration put off, and the edge at which the first of them begins: the next one goes on there.
    deferred: u32,
    next: u32,
    #[cfg(feature = "research")]
    history: History,
    #[cfg(feature = "research")]
    pushes: Vec<Push>,
}

impl Resolver {
    /// All cloths were carried as one: what is under way goes on in the new direction.
    pub(crate) fn follow(&mut self, motion: &Rigid) {
        self.plans.turn(motion.turn);
        self.layers.plans.turn(motion.turn);
        self.tracked.follow(motion);
    }

    /// Traces the contours of the crossings; call it before [`Self::advance`].
    pub(crate) fn analyse(&mut self, surface: &Surface, crossings: &[Crossing], positions: &[Vec4]) -> Verdict {
        let at = |v: u32| positions[v as usize].truncate().as_dvec3();
        self.terms.clear();
        self.terms.extend(crossings.iter().map(|c| Terms::new(&surface.topology, c, gradient::BOUND, at)));
        self.points.clear();
        self.points.extend(self.terms.iter().map(|t| t.point.as_vec3()));
        self.graph.trace(surface, crossings, &self.points, |v| positions[v as usize].truncate());
        self.graph.verdict()
    }

    /// The contours traced last.
    #[must_use]
    pub fn graph(&self) -> &ContourGraph {
        &self.graph
    }

    /// The points `[m]` of the crossings analysed last.
    #[must_use]
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Gives up ways apart that are being carried out for particles that are not where they were any more.
    pub(crate) fn give_up_plans(&mut self, moved: impl Fn(u32) -> bool) {
        self.plans.give_up(moved);
    }

    /// Uses stronger means from now on.
    pub(crate) fn escalate(&mut self, escalation: Escalation) {
        self.escalation = escalation;
    }

    /// The stronger means in use.
    #[must_use]
    pub fn escalation(&self) -> Escalation {
        self.escalation
    }

    /// Whether cloths are on their way to the other side of each other, as their layers ask for.
    #[must_use]
    pub(crate) fn orders_layers(&self) -> bool {
        self.layers.any()
    }

    /// Looks at the order of layers of all particles in the next iteration, not only of a few.
    pub(crate) fn inspect_layers(&mut self) {
        self.layers.thorough = true;
    }

    /// One iteration on the crossings analysed last: moves `positions` and `previous` together. Returns whether something was
    /// to be moved.
    pub fn advance(
        &mut self,
        surface: &Surface,
        detector: &mut Detector,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        settings: &ResolveSettings,
    ) -> bool {
        if positions.len() != surface.len() || previous.len() != surface.len() {
            return false;
        }
        self.displacements.of.resize(surface.len(), Vec4::ZERO);
        self.approach.of.resize(surface.len(), Vec4::ZERO);
        #[cfg(feature = "research")]
        if settings.method.remembers_sides() {
            self.remember(surface, detector, positions, settings.step);
            self.displacements.apply(positions, previous);
            return true;
        }
        let layered =
            settings.method == Method::ByEndType && surface.parts.windows(2).any(|p| p[0].garment_layer != p[1].garment_layer);
        if layered {
            self.layers.patrol(surface, detector.tree(), positions);
        } else {
            self.layers.clear();
        }
        debug_assert_eq!(self.graph.contour_of.len(), detector.crossings().len(), "analysed last");
        self.deferred = 0;
        if self.graph.contours.is_empty() && !self.layers.any() {
            self.tracked.clear();
            self.plans.clear();
            self.next = 0;
            return false;
        }
        let view = View { surface, crossings: detector.crossings(), positions };
        self.choose(view, settings);
        self.between.take_in(view, &self.graph);
        if layered {
            self.order(view, settings.pace * settings.step * surface.mean_edge);
            if self.graph.contours.is_empty() && !self.layers.any() {
                return false;
            }
        }
        self.undo_contours(view, previous, settings);
        self.advance_plans();
        self.approach.apply_to_velocity(positions, previous);
        self.displacements.apply(positions, previous);
        true
    }

    /// One more iteration without a look, if plans take care of every contour analysed last; whether they do.
    pub(crate) fn carry_on(&mut self, positions: &mut [Vec4], previous: &mut [Vec4]) -> bool {
        let planned = |l: &tracked::TrackedContour| l.strategy == Strategy::Translate && self.plans.is_live(l.plan);
        if self.layers.any() || self.tracked.now.is_empty() || !self.tracked.now.iter().all(planned) {
            return false;
        }
        self.effort.spend(self.plans.moves());
        self.advance_plans();
        self.displacements.apply(positions, previous);
        true
    }

    /// One iteration of every plan.
    fn advance_plans(&mut self) {
        self.layers.plans.advance(&mut self.displacements);
        self.plans.advance(&mut self.displacements);
    }

    /// Does to a contour what was decided.
    fn undo(&mut self, view: View<'_>, previous: &[Vec4], contour: usize, step: f32, settings: &ResolveSettings) {
        if self.graph.contours[contour].authored || self.is_ordered(view, contour) {
            return;
        }
        if self.tracked.now[contour].strategy == Strategy::StretchGradient {
            self.follow_stretch_gradient(view, contour, settings.pace * step, settings);
            return;
        }
        let done = self.translates(view, contour, step, settings)
            || (self.tracked.now[contour].strategy == Strategy::RegionPush && self.push_region(view, contour, step, settings));
        if !done {
            self.follow_global_gradient(view, contour, step, true, settings);
        }
        self.stop_approach(view, previous, contour);
    }

    /// Whether a contour is being translated apart, by a plan made before or now.
    fn translates(&mut self, view: View<'_>, contour: usize, step: f32, settings: &ResolveSettings) -> bool {
        let tracked = self.tracked.now[contour];
        if tracked.strategy != Strategy::Translate {
            return false;
        }
        if self.plans.is_live(tracked.plan) {
            return true;
        }
        if tracked.stalled < settings.stall_iterations && self.translate_apart(view, contour, settings.pace * step) {
            return true;
        }
        let tracked = &mut self.tracked.now[contour];
        tracked.switch_to(if matches!(tracked.kind, ContourKind::Bibi | ContourKind::Closed) {
            Strategy::GlobalGradient
        } else {
            Strategy::RegionPush
        });
        false
    }

    /// Recognizes the contours, chooses a strategy for each new one, and another for those that made no progress.
    fn choose(&mut self, view: View<'_>, settings: &ResolveSettings) {
        let by_type = settings.method == Method::ByEndType;
        let graph = &self.graph;
        self.tracked.carry(view.crossings, graph, |k| match graph.contours[k].kind {
            // Around the loop vertex of a cross both sides are one.
            ContourKind::Cross if by_type => Strategy::RegionPush,
            ContourKind::Bbii | ContourKind::Bibi | ContourKind::Closed if by_type => Strategy::Translate,
            ContourKind::Ll if by_type && graph.contours[k].count >= LONG => Strategy::Translate,
            ContourKind::Ll if by_type => Strategy::StretchGradient,
            _ => Strategy::GlobalGradient,
        });
        for tracked in self.tracked.now.iter_mut().filter(|l| by_type && l.escalation < self.escalation) {
            tracked.switch_to(if self.escalation == Escalation::Regions && tracked.kind.separates() {
                Strategy::RegionPush
            } else {
                Strategy::Translate
            });
            tracked.escalation = self.escalation;
        }
        let tracked = self.tracked.now.iter_mut().zip(&graph.contours);
        for (tracked, contour) in tracked.filter(|(l, _)| by_type && l.strategy != Strategy::Translate) {
            let edges = if tracked.strategy == Strategy::RegionPush { tracked.longest / contour.edge } else { 0.0 };
            if tracked.stalled
                > (settings.stall_iterations + edges as u32 / EDGES_A_STALL) << tracked.switches.min(MOST_DOUBLINGS)
            {
                let pushable =
                    matches!(tracked.kind, ContourKind::Bbii | ContourKind::Cross | ContourKind::Bibi | ContourKind::Closed);
                tracked.switch_to(match tracked.strategy {
                    Strategy::GlobalGradient if pushable => Strategy::RegionPush,
                    Strategy::RegionPush if tracked.switches % STRETCH_EVERY != STRETCH_EVERY - 1 => Strategy::GlobalGradient,
                    Strategy::GlobalGradient | Strategy::RegionPush => Strategy::StretchGradient,
                    Strategy::StretchGradient | Strategy::Translate => Strategy::GlobalGradient,
                });
            }
        }
    }

    /// The traditional method.
    #[cfg(feature = "research")]
    fn remember(&mut self, surface: &Surface, detector: &mut Detector, positions: &[Vec4], step: f32) {
        let thickness = surface.parts.iter().map(|p| p.thickness).fold(0.0, f32::max);
        let reach = thickness + 0.5 * surface.mean_edge;
        let meter = self.effort.meter();
        self.history.pushes(surface, detector, positions, (reach, thickness), &meter, &mut self.pushes);
        self.effort.spend(meter.spent());
        for &(v, by) in &self.pushes {
            self.displacements.add(v, by, step * surface.mean_edge);
        }
    }
}

/// Detection and resolution of one surface together.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Untangler {
    /// Finds crossings.
    pub detector: Detector,
    /// Takes them apart.
    pub resolver: Resolver,
}

impl Untangler {
    /// Prepares a surface.
    #[must_use]
    pub fn new(surface: &Surface) -> Self {
        Self { detector: Detector::new(surface), resolver: Resolver::default() }
    }

    /// Detects crossings and traces contours without moving anything.
    pub fn look(&mut self, surface: &Surface, positions: &[Vec4]) -> Verdict {
        let crossings = self.detector.detect(surface, positions);
        self.resolver.analyse(surface, crossings, positions)
    }

    /// Leaves contours that are held as they are out of account, all of whose particles are `held`; the verdict on the others.
    pub(crate) fn leave_held(&mut self, surface: &Surface, held: impl Fn(u32) -> bool) -> Verdict {
        self.resolver.graph.leave_held(surface, self.detector.crossings(), held);
        self.resolver.graph.verdict()
    }

    /// As [`Self::look`], of cloth that is looked at in every frame.
    pub(crate) fn look_again(&mut self, surface: &Surface, positions: &[Vec4]) -> Verdict {
        let crossings = self.detector.detect_again(surface, positions);
        self.resolver.analyse(surface, crossings, positions)
    }

    /// One iteration: looks, then moves `positions` and `previous` together. The verdict is that of the positions as they came.
    pub fn iterate(
        &mut self,
        surface: &Surface,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        settings: &ResolveSettings,
    ) -> Verdict {
        let verdict = self.look(surface, positions);
        self.resolver.advance(surface, &mut self.detector, positions, previous, settings);
        verdict
    }
}
