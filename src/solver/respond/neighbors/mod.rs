//! Which pairs may touch before the next frame.
//!
//! Each face is boxed together with where it is foreseen to be, relative to the motion all cloths share. Of two faces whose
//! boxes meet, each asks with the particles and edges it owns. So every pair is asked for once.
//!
//! ```text
//! begin ─► foresee: boxes swept to where each particle will be
//! find  ─► for pairs of leaves whose boxes meet: ask ─► gap of their faces ─► boxes of the particles and edges they own
//!                                                ─► closest ─► list
//! until the next look: strayed ─► update_strayed, within a frame; refresh, at its end
//! ```

mod own;
mod moment;
mod foresee;
mod looked;
mod refresh;
mod strayed;
mod flat;
mod patch;
mod gap;
mod narrow_phase;
mod outcome;
mod threads;
mod near;
mod batch;
mod closest;
mod list;

use glam::{Vec3A, Vec4};

pub(crate) use moment::Moment;

use super::{Contacts, Touch};
use crate::solver::buffer::Buffer;
use crate::solver::detect::crossing::PAIR;
use crate::solver::detect::tree::{Meeting, Tree};
use crate::solver::detect::{Crossing, Detector, Surface};
use crate::solver::effort::Meter;
use crate::solver::rigid::Rigid;
use batch::Batch;
use flat::Flatness;
use looked::Looked;
use narrow_phase::{Known, NarrowPhase, Search};
use outcome::Outcome;
use patch::{Laid, Patches};
use threads::{Pool, Threads, Walk, threads_worth};

/// How much farther than its thickness a pair is looked for, in thicknesses (dimensionless): what accelerates within a frame
/// comes from there.
const MARGIN: f32 = 0.25;

/// Mean way of particles until the next look from which on cloth flutters, in thicknesses (dimensionless).
const FLUTTER: f32 = 2.0;

/// Which face asks for which particle and edge, and how far each particle goes.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct NeighborList {
    /// The faces of each leaf, with what they own.
    patches: Patches,
    /// Where each particle is foreseen to be in the next frame `[m]`, less the motion that all cloths share.
    ahead: Vec<Vec3A>,
    /// Where each particle was at the last look `[m]`.
    start: Vec<Vec3A>,
    /// Where each particle was when the time looked ahead began, a frame or half of one ago `[m]`.
    before: Vec<Vec3A>,
    /// Particles that are elsewhere than foreseen, those that were so at a substep since the last look, and faces with one.
    astray: Vec<bool>,
    shifted: Vec<bool>,
    marked: Vec<bool>,
    /// The motion that all share until the next frame `[m]`.
    shared: Vec3A,
    /// Mean speed at the last look at everything, less what all cloths share `[m/s]`.
    haste: f32,
    /// Each face when it was last looked at.
    faces: Vec<Looked>,
    /// How far each particle has drifted, or will, since the last look `[m]`.
    drift: Vec<f32>,
    /// Where to `[m]`.
    there: Vec<Vec3A>,
    /// Longest edge of each cloth at rest `[m]`.
    longest: Vec<f32>,
    /// Particles around which cloth may lie over itself although normals agree.
    loose: Vec<bool>,
    /// Whether the edges at a particle know all faces around it, as where no more than two faces share an edge.
    has_fans: bool,
    tools: Buffer<Tools>,
    /// What the last look at everything cost, that at what strayed, and the last of both `[visits]`.
    costs: [usize; 2],
    visits: usize,
    /// Whether there was too much of it.
    is_cut: bool,
}

/// What leaves are asked with.
#[derive(Debug, Default)]
struct Tools {
    flatness: Flatness,
    laid: Laid,
    batch: Batch,
    outcome: Outcome,
    threads: Threads,
}

impl Tools {
    /// Begins to ask leaves, by one thread.
    fn one_thread<'a, T: Fn(u32) -> f32>(
        &'a mut self,
        search: &'a Search<'a, T>,
        room: usize,
        meter: &'a Meter,
    ) -> NarrowPhase<'a, T, impl FnMut(u32) -> bool> {
        let Self { flatness, laid, batch, outcome, .. } = self;
        let &Search { surface, positions, ahead, patches, .. } = search;
        laid.forget(patches);
        batch.clear();
        outcome.begin(room);
        let is_flat = |v| flatness.holds(v, surface, positions, ahead);
        NarrowPhase { search, is_flat, laid, batch, outcome, meter }
    }

    /// Asks leaves, by several threads. Returns the visits of the walk and of asking leaves; none where that was too much work,
    /// or found more than may be listed.
    fn ask_by_threads<T: Fn(u32) -> f32 + Sync>(
        &mut self,
        pool: Pool<'_>,
        search: &Search<'_, T>,
        tree: &Tree,
        walk: Walk<'_>,
    ) -> Option<[usize; 2]> {
        self.flatness.find_all(search.surface, search.positions, search.ahead);
        self.threads.ask(pool, search, &self.flatness, tree, walk)
    }
}

impl NeighborList {
    /// Finds the pairs that may touch within `dt` `[s]`. `tangled` says how much a particle belongs to a tangle (0 to 1),
    /// within which there is no right side.
    pub(crate) fn find(
        &mut self,
        surface: &Surface,
        tree: &mut Tree,
        moment: &Moment<'_>,
        dt: f32,
        tangled: impl Fn(u32) -> f32 + Sync,
        contacts: &mut Contacts,
    ) {
        self.begin(surface, tree, moment, dt, contacts);
        self.ask_leaves(surface, tree, moment, tangled, contacts, false);
    }

    /// As [`Self::find`] where nothing is tangled, and looks for crossings at the same pairs of faces. From the first crossing on
    /// it looks for nothing else.
    pub(crate) fn find_and_detect<'a>(
        &mut self,
        surface: &Surface,
        detector: &'a mut Detector,
        moment: &Moment<'_>,
        dt: f32,
        contacts: &mut Contacts,
    ) -> &'a [Crossing] {
        self.begin(surface, detector.tree(), moment, dt, contacts);
        // A walk in parts is one thread's.
        let pool = self.to_wake(moment, false).filter(|_| detector.is_whole() && !detector.tree_ref().has_left());
        let inverted = core::mem::take(&mut contacts.inverted);
        let (known, tools) = self.parts();
        let search = known.search(surface, moment, |_| 0.0, &inverted, false);
        let (room, meter) = (Outcome::room(surface.len(), contacts), moment.most.meter());
        let walk = Walk { marked: false, pair: PAIR, room, moment };
        let asked = pool.and_then(|pool| tools.ask_by_threads(pool, &search, detector.tree_ref(), walk));
        let clean = asked.filter(|&[walked, _]| {
            let asks = tools.threads.runs().flat_map(|run| run.asks.iter().copied());
            detector.detect_asked(surface, moment.positions, asks, walked)
        });
        if let Some([_, asked]) = clean {
            meter.spend(asked);
            tools.threads.runs().for_each(|run| run.outcome.drain_into(contacts));
        } else {
            let mut narrow = tools.one_thread(&search, room, &meter);
            detector.detect_and(surface, moment.positions, Self::reach(moment), |tree, met, crosser| {
                narrow.leaves(tree, met, |f, g| crosser.ask(f, g));
                narrow.outcome.drain_into(contacts);
            });
            narrow.finish();
            narrow.outcome.drain_into(contacts);
        }
        contacts.inverted = inverted;
        self.note_cost(&meter, false);
        detector.crossings()
    }

    /// Prepares for looking at all pairs that may touch within `dt` `[s]`: the tree is fitted to where particles are and are
    /// foreseen to be.
    fn begin(&mut self, surface: &Surface, tree: &mut Tree, moment: &Moment<'_>, dt: f32, contacts: &mut Contacts) {
        contacts.begin();
        contacts.fit(surface);
        self.foresee(surface, moment, dt);
        tree.refit(surface, moment.positions, Some(&self.ahead));
    }

    /// Asks the leaves of a tree for what may touch: all, or `anew` those with a face that is [marked](Tree::mark).
    fn ask_leaves(
        &mut self,
        surface: &Surface,
        tree: &mut Tree,
        moment: &Moment<'_>,
        tangled: impl Fn(u32) -> f32 + Sync,
        contacts: &mut Contacts,
        anew: bool,
    ) {
        let (pool, inverted) = (self.to_wake(moment, anew), core::mem::take(&mut contacts.inverted));
        let (known, tools) = self.parts();
        let search = known.search(surface, moment, tangled, &inverted, anew);
        let (room, meter) = (Outcome::room(surface.len(), contacts), moment.most.meter());
        let walk = Walk { marked: anew, pair: 0, room, moment };
        let asked = pool.and_then(|pool| tools.ask_by_threads(pool, &search, tree, walk));
        if let Some(visits) = asked.map(|visits| visits.iter().sum()).filter(|&visits| moment.most.allows(visits)) {
            meter.spend(visits);
            tools.threads.runs().for_each(|run| run.outcome.drain_into(contacts));
        } else {
            let mut narrow = tools.one_thread(&search, room, &meter);
            let mut ask = |tree: &Tree, met: &Meeting| {
                narrow.leaves(tree, met, |_, _| false);
                narrow.outcome.drain_into(contacts);
            };
            if anew {
                tree.meetings_with(surface, Self::reach(moment), &meter, &mut ask);
            } else {
                tree.meetings(surface, Self::reach(moment), &meter, &mut ask);
            }
            narrow.finish();
            narrow.outcome.drain_into(contacts);
        }
        contacts.inverted = inverted;
        self.note_cost(&meter, anew);
    }

    /// Threads to share a look with, at everything or at what `strayed`: as many as are worth waking, if it will cost as much as
    /// the last one.
    fn to_wake<'a>(&self, moment: &Moment<'a>, strayed: bool) -> Option<Pool<'a>> {
        let jobs = moment.jobs?;
        let threads = threads_worth(self.costs[usize::from(strayed)]).min(jobs.concurrency());
        (threads > 1 && self.has_fans && !self.is_cut).then_some(Pool { jobs, threads })
    }

    /// Whether looks cost so much that threads are worth waking.
    #[must_use]
    pub(crate) fn is_worth_sharing(&self) -> bool {
        self.costs.iter().any(|&cost| threads_worth(cost) > 1)
    }

    /// What is known, and what leaves are asked with.
    fn parts(&mut self) -> (Known<'_>, &mut Tools) {
        let Self { ahead, longest, loose, patches, tools, .. } = self;
        tools.flatness.forget(ahead.len());
        (Known { ahead, longest, loose, patches }, tools)
    }

    /// Notes what a look cost, at everything or at what `strayed`.
    fn note_cost(&mut self, meter: &Meter, strayed: bool) {
        (self.visits, self.is_cut) = (meter.spent(), meter.is_spent());
        self.costs[usize::from(strayed)] = self.visits;
    }

    /// Whether pairs were left out at the last look, since there was too much work.
    #[must_use]
    pub(crate) fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Work that the last look was, in [visits](crate::solver::effort).
    #[must_use]
    pub(crate) fn visits(&self) -> usize {
        self.visits
    }

    /// How far ahead to look `[s]` when the next look at everything is due in `dt` `[s]`. It is half of that where cloth
    /// flutters, as boxes swept half as far meet a third of the faces. It is a whole number of substeps of `h` `[s]`.
    #[must_use]
    pub(crate) fn horizon(&self, dt: f32, h: f32, touch: &[Touch]) -> f32 {
        let thickest = touch.iter().map(|t| t.thickness).fold(0.0, f32::max);
        if self.haste * dt > FLUTTER * thickest { (h * (0.5 * dt / h - 1.0e-3).ceil()).min(dt) } else { dt }
    }

    /// Where each particle was at the end of the last frame, or when the time looked ahead began within this one `[m]`.
    pub(crate) fn before(&self) -> &[Vec3A] {
        &self.before
    }

    /// Takes everything that is known along on a motion of all cloths.
    pub(crate) fn follow(&mut self, motion: &Rigid) {
        let points = [&mut self.before, &mut self.start, &mut self.ahead].into_iter().flatten();
        points.for_each(|x| *x = motion.point((*x).into()).into());
        self.shared = motion.turn * self.shared;
        self.faces.iter_mut().for_each(|face| face.normal = motion.turn * face.normal);
    }

    /// Notes where all particles are `[m]` at the end of a frame, or of the time looked ahead within one. The next look tells
    /// by it how far their motion lasts.
    pub(crate) fn note(&mut self, positions: &[Vec4]) {
        self.before.iter_mut().zip(positions).for_each(|(before, &x)| *before = Vec3A::from_vec4(x));
    }

    /// How close boxes must come for their faces to be asked `[m]`.
    #[must_use]
    pub(crate) fn reach(moment: &Moment<'_>) -> f32 {
        (1.0 + MARGIN) * moment.thickest()
    }
}
