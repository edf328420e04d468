//! Which cloths can meet: they are looked at together, as one surface.
//!
//! Two cloths can meet when their boxes, widened by thickness, motion and an edge, overlap; an island is everything that is
//! linked so. Cloths that are together part only when boxes twice as wide are apart. Islands and their members are in the order
//! of entities, so that nothing depends on the order of archetypes or threads.

use core::cmp::Reverse;
use std::sync::Arc;

use bevy::math::{DVec3, Vec4};
use bevy::prelude::*;
use bevy::tasks::Task;

use crate::components::{ClothCollision, ClothCollisionLayers, ClothReport};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace};
use crate::solver::detect::tree::TreeTopology;
use crate::solver::detect::{PartRef, PartSettings};
use crate::solver::island::{Island, Stage, UntangleSettings};
use crate::solver::resolve::ContourKind;
use crate::solver::rest::RestShape;
use crate::solver::state::ClothState;
use crate::solver::verdict::Verdict;

/// Farthest coordinate from a cloth's origin at which it is looked at `[m]`.
const FARTHEST: f64 = 1.0e6;
/// How much wider the boxes are of cloths that are together already.
const STAY: f64 = 2.0;

/// Cloths that can meet, and where they cross.
#[derive(Resource, Default)]
pub struct ClothIslands {
    /// In the order of their first members.
    pub(crate) list: Vec<ClothIsland>,
    before: Vec<ClothIsland>,
    candidates: Vec<Candidate>,
    by_x: Vec<u32>,
    root: Vec<u32>,
    order: Vec<u32>,
    members: Vec<Member>,
    builds: u64,
}

/// Cloths that can meet.
#[derive(Clone, Default)]
pub(crate) struct ClothIsland {
    pub members: Vec<Member>,
    pub solver: Island,
    pub settings: UntangleSettings,
    /// Whether all of them sleep or stand still.
    pub asleep: bool,
    /// Origin of the frame of the island in the world `[m]`.
    pub origin: DVec3,
    /// Time spent on each [`Stage`] `[ms]`.
    pub times: [f32; Stage::FRAME.len()],
    /// What the frame before it was formed took on all stages `[ms]`.
    pub last_ms: f32,
    /// Whether it was built in this frame.
    #[cfg(feature = "record")]
    pub built: bool,
    /// Whether its members are stepped side by side in this frame.
    pub together: bool,
    pub background: Background,
}

/// Frames of an island in the background.
#[derive(Default)]
pub(crate) struct Background {
    /// Whether its frames run there.
    pub is_on: bool,
    /// The frame under way. It has the solver of the island.
    pub frame: Option<Task<BackgroundFrame>>,
    /// Length of the frame that was done just now `[s]`.
    pub done: Option<f32>,
    /// What the last frame came to, and how many pairs touched, while the next has the solver.
    pub total: Verdict,
    pub touching: u32,
}

impl Clone for Background {
    /// What is under way stays with the island.
    fn clone(&self) -> Self {
        Self { frame: None, ..*self }
    }
}

/// A frame of an island that is stepped in the background, with all that it takes.
pub(crate) struct BackgroundFrame {
    pub island: ClothIsland,
    /// Its members.
    pub cloths: Vec<BackgroundCloth>,
    /// Length of the frame `[s]`.
    pub dt: f32,
}

/// A cloth in the background.
pub(crate) struct BackgroundCloth {
    pub rest: ClothRest,
    pub inputs: ClothInputs,
    pub particles: ClothParticles,
    pub report: ClothReport,
    /// Its particles as the frame began.
    pub start: ClothState,
    /// How much of [`ClothInputs::waited`] the frame covers `[s]`.
    pub waited: f32,
    /// Whether time passes for it.
    pub live: bool,
}

impl ClothIsland {
    /// Whether it has a solver for its members: it has none while a frame is under way in the background, or before the first.
    pub(crate) fn is_built(&self) -> bool {
        self.solver.surface().parts.len() == self.members.len()
    }

    /// The verdict on all of its cloths together.
    pub(crate) fn total(&self) -> Verdict {
        if self.is_built() { self.solver.total() } else { self.background.total }
    }

    /// Pairs of its cloths that touch.
    pub(crate) fn touching(&self) -> u32 {
        if self.is_built() { self.solver.contacts().touching() } else { self.background.touching }
    }

    /// Builds the solver anew for its members. Without one they go through each other.
    pub(crate) fn build(&mut self) {
        self.solver = build(&self.members).unwrap_or_default();
    }

    /// Whether its cloths rest on each other, or on themselves, so that they are stepped side by side.
    pub(crate) fn has_contact(&self) -> bool {
        self.members.iter().any(|member| member.collision.contact)
    }

    /// What a stage of the last frame cost `[ms]`, shared by the cloths by their particles: cloth `part`.
    pub(crate) fn cost(&self, stage: Stage, part: usize) -> f32 {
        let surface = self.solver.surface();
        let share = surface.parts.get(part).map_or(0.0, |p| p.particles.len() as f32 / surface.len().max(1) as f32);
        share * self.times[stage as usize]
    }
}

/// A cloth as its island was built from it.
#[derive(Clone)]
pub(crate) struct Member {
    pub entity: Entity,
    pub rest: Arc<RestShape>,
    pub collision: ClothCollision,
    pub thickness: f32,
    /// Whether untangling does not move it.
    pub fixed: bool,
    /// Whether nothing does: it is paused or was stopped, or is carried along.
    pub still: bool,
    /// Whether it was carried from one place to another in this frame.
    pub rode: bool,
    /// Whether it sleeps.
    pub asleep: bool,
    /// Whether it is to be taken apart at once in its first frame.
    pub at_load: bool,
}

impl Member {
    /// Whether a surface built from `other` will do: settings may differ, and it may be some times as large.
    fn fits(&self, other: &Self) -> bool {
        self.entity == other.entity && (Arc::ptr_eq(&self.rest, &other.rest) || self.rest.is_multiple_of(&other.rest))
    }

    /// Whether a cloth is as its island saw it last: of the same shape at rest, and bound no later.
    pub(crate) fn is_as_seen(&self, rest: &ClothRest, particles: &ClothParticles, place: &IslandPlace) -> bool {
        Arc::ptr_eq(&rest.0, &self.rest) && particles.len() == rest.0.positions.len() && place.island.is_some()
    }
}

/// A cloth that may meet something.
struct Candidate {
    member: Member,
    settings: UntangleSettings,
    layers: ClothCollisionLayers,
    origin: DVec3,
    low: DVec3,
    high: DVec3,
    /// How much wider its box is `[m]`.
    margin: f64,
    /// Whether it is stepped in the background.
    background: bool,
    /// Island of the last frame.
    last: Option<u32>,
}

impl Candidate {
    fn meets(&self, other: &Self) -> bool {
        let together = self.last.is_some() && self.last == other.last;
        let margin = DVec3::splat((self.margin + other.margin) * if together { STAY } else { 1.0 });
        self.layers.touches(other.layers)
            && (self.low - margin).cmple(other.high).all()
            && (other.low - margin).cmple(self.high).all()
    }
}

impl ClothIslands {
    /// Segments of all intersection curves in the world `[m]`, each with how its curve ends; as of the last look. None of cloth
    /// that is stepped in the background.
    pub fn contours(&self) -> impl Iterator<Item = (ContourKind, [DVec3; 2])> + '_ {
        self.list.iter().flat_map(|island| {
            let place = |p: Vec3| island.origin + p.as_dvec3();
            let contours = island.solver.contours();
            let kind = |contour: usize| contours.get(contour).map(|c| c.kind).unwrap_or_default();
            island.solver.segments().map(move |(contour, ends)| (kind(contour), ends.map(place)))
        })
    }

    /// The members of each island, in the order of entities.
    pub fn members(&self) -> impl Iterator<Item = impl Iterator<Item = Entity> + '_> + '_ {
        self.list.iter().map(|island| island.members.iter().map(|m| m.entity))
    }

    /// How many islands were built so far. An island is built for other members than before, or for a new shape at rest that is
    /// no multiple of the one before. No setting builds one.
    #[must_use]
    pub fn builds(&self) -> u64 {
        self.builds
    }

    /// Forgets the contacts of an island: it is built anew from its cloths.
    pub(crate) fn forget(&mut self, island: u32) {
        if let Some(island) = self.list.get_mut(island as usize) {
            island.members.clear();
        }
    }

    /// Forgets who could meet whom.
    pub(crate) fn begin(&mut self) {
        self.candidates.clear();
    }

    /// Adds a cloth; one with a position that is not finite or absurdly far out meets nothing. Returns its box in the world
    /// `[m]`, and writes how far that went since the last look.
    pub(crate) fn add(
        &mut self,
        member: Member,
        inputs: &ClothInputs,
        particles: &ClothParticles,
        layers: ClothCollisionLayers,
        (last, last_box): (Option<u32>, Option<(DVec3, DVec3)>),
        motion: &mut f64,
    ) -> Option<(DVec3, DVec3)> {
        let (low, high) = match last_box {
            Some(last) if member.asleep => last,
            _ => bounds(&particles.sim.state).map(|(low, high)| (low + particles.origin, high + particles.origin))?,
        };
        // While its frame is under way it goes as far as in the last one, for all that is known.
        if !inputs.under_way {
            *motion = last_box.map_or(0.0, |(a, b)| (low - a).abs().max((high - b).abs()).max_element());
        }
        let margin = f64::from(member.thickness + member.rest.mean_edge) + *motion;
        let (settings, origin, background) = (inputs.untangle, particles.origin, inputs.background);
        self.candidates.push(Candidate { member, settings, layers, origin, low, high, margin, background, last });
        Some((low, high))
    }

    /// Links what can meet and builds the islands that are new or changed. `place` is told each member's island, its number
    /// there, and whether it is roused: it sleeps where another does not.
    pub(crate) fn form(&mut self, mut place: impl FnMut(Entity, u32, u32, bool)) {
        self.candidates.sort_unstable_by_key(|c| c.member.entity);
        self.link();
        let Self { list, before, candidates, root, order, members, builds, .. } = self;
        order.clear();
        order.extend(0..candidates.len() as u32);
        order.sort_unstable_by_key(|&i| (root[i as usize], i));
        core::mem::swap(list, before);
        list.clear();
        let mut before = before.drain(..).peekable();
        for run in order.chunk_by(|&a, &b| root[a as usize] == root[b as usize]) {
            let of = |i: &u32| &candidates[*i as usize];
            let free = run.iter().map(|i| &of(i).member).any(|m| !m.fixed || (!m.still && m.collision.contact));
            let Some(first) = run.first().map(of) else { continue };
            if !free || (run.len() == 1 && !first.member.collision.self_collision) {
                continue;
            }
            members.clear();
            members.extend(run.iter().map(|i| of(i).member.clone()));
            // Lower indices first, of which most entities were spawned earlier.
            let rank = |c: &&Candidate| (c.settings.iterations, Reverse(c.member.entity.index_u32()));
            let best = run.iter().map(of).filter(|c| !c.member.fixed).max_by_key(rank).unwrap_or(first);
            while before.next_if(|old| old.members.first().is_none_or(|m| m.entity < first.member.entity)).is_some() {}
            let background = run.iter().map(of).any(|c| c.background);
            // What is under way in the background is of these very shapes, seen from there.
            let fits = |old: &ClothIsland, [a, b]: [&Member; 2]| {
                a.fits(b) && (old.is_built() || (background && Arc::ptr_eq(&a.rest, &b.rest) && old.origin == first.origin))
            };
            let old = before.next_if(|old| {
                old.members.len() == members.len() && old.members.iter().zip(members.iter()).all(|(a, b)| fits(old, [a, b]))
            });
            #[cfg(feature = "record")]
            let known = old.is_some();
            let mut island = if let Some(mut island) = old {
                for (part, (old, new)) in island.members.iter().zip(members.iter()).enumerate() {
                    if !Arc::ptr_eq(&old.rest, &new.rest) {
                        island.solver.rescale(part, &new.rest.positions);
                    }
                }
                island.members.clone_from(members);
                let built = island.is_built();
                for (part, member) in members.iter().enumerate() {
                    let ClothCollision { garment_layer, self_collision, .. } = member.collision;
                    let thickness = member.thickness;
                    if built {
                        island.solver.tune(part, PartSettings { garment_layer, self_collision, thickness });
                    }
                }
                if island.origin != first.origin {
                    island.solver.carry((island.origin - first.origin).as_vec3());
                }
                island
            } else {
                // In the background it is built there.
                let unbuilt = background.then(Island::default);
                let Some(solver) = unbuilt.or_else(|| build(members)) else { continue };
                *builds += 1;
                ClothIsland { solver, members: members.clone(), ..ClothIsland::default() }
            };
            island.background.is_on = background;
            (island.settings, island.origin) = (best.settings, first.origin);
            island.last_ms = core::mem::take(&mut island.times).iter().sum();
            island.together = false;
            #[cfg(feature = "record")]
            {
                island.built = !known;
            }
            island.asleep = island.members.iter().all(|m| m.asleep || (m.still && !m.rode));
            for (part, member) in island.members.iter().enumerate() {
                place(member.entity, list.len() as u32, part as u32, member.asleep && !island.asleep);
            }
            list.push(island);
        }
    }

    /// Joins what overlaps: sweep along x, then union of sets with the smallest number as root.
    fn link(&mut self) {
        let Self { candidates, by_x, root, .. } = self;
        root.clear();
        root.extend(0..candidates.len() as u32);
        let from = |i: u32| candidates[i as usize].low.x - STAY * candidates[i as usize].margin;
        let to = |i: u32| candidates[i as usize].high.x + STAY * candidates[i as usize].margin;
        by_x.clear();
        by_x.extend(0..candidates.len() as u32);
        by_x.sort_unstable_by(|&a, &b| from(a).total_cmp(&from(b)).then(a.cmp(&b)));
        for (k, &a) in by_x.iter().enumerate() {
            for &b in by_x[k + 1..].iter().take_while(|&&b| from(b) <= to(a)) {
                if candidates[a as usize].meets(&candidates[b as usize]) {
                    let (ra, rb) = (find(root, a), find(root, b));
                    root[ra.max(rb) as usize] = ra.min(rb);
                }
            }
        }
        for i in 0..root.len() as u32 {
            root[i as usize] = find(root, i);
        }
    }
}

fn find(root: &[u32], mut i: u32) -> u32 {
    while root[i as usize] != i {
        i = root[i as usize];
    }
    i
}

fn build(members: &[Member]) -> Option<Island> {
    let parts: Vec<(PartRef<'_>, &Arc<TreeTopology>)> = members
        .iter()
        .map(|Member { rest, collision, thickness, .. }| {
            let (topology, positions) = (&rest.topology, &rest.positions);
            let ClothCollision { garment_layer, self_collision, .. } = *collision;
            (PartRef { topology, rest: positions, garment_layer, self_collision, thickness: *thickness }, rest.tree_topology())
        })
        .collect();
    match Island::new(&parts) {
        Ok(island) => Some(island),
        Err(error) => {
            let first = members.first().map_or(Entity::PLACEHOLDER, |member| member.entity);
            warn_once!(
                "{} cloths that can meet, {first} the first of them, go through each other: {error}. Put some of them on other \
                 `ClothCollisionLayers`",
                members.len()
            );
            None
        }
    }
}

/// Box of the particles around the cloth's origin `[m]`; none if one of them is nowhere.
fn bounds(state: &ClothState) -> Option<(DVec3, DVec3)> {
    let (mut low, mut high, mut sum) = (Vec4::INFINITY, Vec4::NEG_INFINITY, Vec4::ZERO);
    for &x in &state.positions {
        low = low.min(x);
        high = high.max(x);
        // Minimum and maximum may pass over what is not a number; a sum does not.
        sum += x;
    }
    let (low, high) = (low.truncate().as_dvec3(), high.truncate().as_dvec3());
    let near = sum.truncate().is_finite() && low.min_element() >= -FARTHEST && high.max_element() <= FARTHEST;
    near.then_some((low, high))
}
