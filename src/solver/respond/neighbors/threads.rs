//! The same look by several threads, with the same bits for any number of them.
//!
//! ```text
//! pair of the root with itself ─► pairs of nodes, in the order of the walk ─► runs of them
//!   run 0 │ run 1 │ run 2 │ …     each walked by the thread that comes to it first
//!         ▼
//!   outcome 0, 1, 2 …             put together in this order: what one thread would have found, as it would have
//! ```
//!
//! One thread stops when there is too much work, or when something crosses. Where that happens, nothing of this counts.

use core::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::batch::Batch;
use super::flat::Flatness;
use super::narrow_phase::{NarrowPhase, Search};
use super::outcome::Outcome;
use super::patch::Laid;
use super::{Moment, NeighborList};
use crate::solver::detect::tree::Tree;
use crate::solver::effort::Effort;
use crate::solver::jobs::JobSystem;

/// Runs of pairs for each thread, so that none waits long for the last; and pairs in each, since the first of a run may hold
/// many faces and the next none.
const RUNS: usize = 4;
const PAIRS: usize = 8;

/// Work for each thread from which on it is worth waking `[visits]`: a visit takes some ten nanoseconds, waking a thread 6 to
/// 90 µs **`[measured]`**.
pub(super) const WORTH_WAKING: usize = 20_000;

/// What the threads work with, and what they found.
#[derive(Debug, Default)]
pub(super) struct Threads {
    workers: Vec<Mutex<Worker>>,
    runs: Vec<Mutex<Run>>,
    pairs: [Vec<(u32, u32)>; 2],
}

/// What a thread works with.
#[derive(Debug, Default)]
struct Worker {
    laid: Laid,
    batch: Batch,
    stack: Vec<(u32, u32)>,
}

/// What a run of pairs came to.
#[derive(Debug, Default)]
pub(super) struct Run {
    pub(super) outcome: Outcome,
    /// Faces that may cross now, in the order in which one thread would have asked them.
    pub(super) asks: Vec<[u32; 2]>,
    /// Visits of the walk, and of asking leaves.
    visits: [usize; 2],
}

/// Threads that share a look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pool<'a> {
    pub(super) jobs: &'a dyn JobSystem,
    /// How many of them.
    pub(super) threads: usize,
}

/// Which leaves are asked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk<'a> {
    /// The pairs of nodes to begin with.
    pub(super) left: &'a [(u32, u32)],
    /// Only those with a marked face.
    pub(super) marked: bool,
    /// Visits that each pair of faces costs besides.
    pub(super) pair: usize,
    /// Pairs that may be listed.
    pub(super) room: usize,
    /// When; with the work that may be done.
    pub(super) moment: &'a Moment<'a>,
}

impl Threads {
    /// Asks the leaves of a tree, where it is known of all particles whether they are flat. Returns the visits of the walk and of
    /// asking leaves. Where either is more than may be done, not all were asked.
    pub(super) fn ask<T: Fn(u32) -> f32 + Sync>(
        &mut self,
        Pool { jobs, threads }: Pool<'_>,
        search: &Search<'_, T>,
        flatness: &Flatness,
        tree: &Tree,
        walk: Walk<'_>,
    ) -> [usize; 2] {
        self.workers.resize_with(threads, Mutex::default);
        self.runs.resize_with(RUNS * threads, Mutex::default);
        let Self { workers, runs, pairs: [pairs, next] } = self;
        pairs.clear();
        pairs.extend_from_slice(walk.left);
        let meter = Effort::UNBOUNDED.meter();
        tree.split(search.surface, NeighborList::reach(walk.moment), walk.marked, PAIRS * runs.len(), pairs, next, &meter);
        let each = pairs.len().div_ceil(runs.len());
        // The walk takes the last pair first.
        let pairs_of = |run: usize| {
            let [end, start] = [run, run + 1].map(|n| pairs.len().saturating_sub(n * each));
            &pairs[start..end]
        };
        let (claimed, spent) = (AtomicUsize::new(0), AtomicUsize::new(0));
        jobs.run(threads, &|thread| {
            let worker = &mut *lock(&workers[thread]);
            worker.laid.forget(search.patches);
            loop {
                let number = claimed.fetch_add(1, Ordering::Relaxed);
                let Some(run) = runs.get(number) else { break };
                let run = &mut *lock(run);
                run.begin(walk.room);
                // Where it is too much already, it does not matter what comes of the rest.
                if !walk.is_too_much(spent.load(Ordering::Relaxed)) {
                    worker.walk(search, flatness, tree, walk, pairs_of(number), run);
                    spent.fetch_add(run.visits.iter().sum(), Ordering::Relaxed);
                }
            }
        });
        let mut visits = [meter.spent(), 0];
        for run in runs.iter_mut().map(get) {
            visits.iter_mut().zip(run.visits).for_each(|(sum, visits)| *sum += visits);
        }
        visits
    }

    /// Whether no more pairs were found than may be listed.
    pub(super) fn fit(&mut self, room: usize) -> bool {
        self.runs().map(|run| run.outcome.pairs.len()).sum::<usize>() < room
    }

    /// What each run of pairs came to, in their order.
    pub(super) fn runs(&mut self) -> impl Iterator<Item = &mut Run> {
        self.runs.iter_mut().map(get)
    }
}

impl Walk<'_> {
    /// Whether the visits of the walk and of asking leaves sum up to more than both may be.
    fn is_too_much(&self, spent: usize) -> bool {
        !self.moment.most.allows(spent / 2)
    }
}

impl Worker {
    /// Asks the leaves of some pairs of nodes.
    fn walk<T: Fn(u32) -> f32>(
        &mut self,
        search: &Search<'_, T>,
        flatness: &Flatness,
        tree: &Tree,
        walk: Walk<'_>,
        pairs: &[(u32, u32)],
        run: &mut Run,
    ) {
        let Self { laid, batch, stack } = self;
        let Run { outcome, asks, visits } = run;
        stack.clear();
        stack.extend_from_slice(pairs);
        batch.clear();
        let [walked, asked] = [walk.moment.most.meter(), walk.moment.most.meter()];
        let mut narrow = NarrowPhase { search, is_flat: |v| flatness.is_known(v), laid, batch, outcome, meter: &asked };
        tree.meetings_of(search.surface, NeighborList::reach(walk.moment), walk.marked, stack, &walked, |tree, met| {
            walked.spend(walk.pair * met.count());
            narrow.leaves(tree, met, |f, g| {
                asks.push([f, g]);
                false
            });
        });
        narrow.finish();
        *visits = [walked.spent(), asked.spent()];
    }
}

impl Run {
    fn begin(&mut self, room: usize) {
        self.outcome.begin(room);
        self.asks.clear();
        self.visits = [0; 2];
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

fn get<T>(of: &mut Mutex<T>) -> &mut T {
    of.get_mut().unwrap_or_else(PoisonError::into_inner)
}
