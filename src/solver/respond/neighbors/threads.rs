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
const WORTH_WAKING: usize = 20_000;

/// How many threads are worth a look that costs so many visits.
pub(super) const fn threads_worth(visits: usize) -> usize {
    1 + visits / WORTH_WAKING
}

/// What the threads work with, and what they found.
#[derive(Debug, Default)]
pub(super) struct Threads {
    workers: Vec<Mutex<Worker>>,
    runs: Vec<Mutex<Run>>,
    pairs: [Vec<(u32, u32)>; 2],
    /// Runs of the last look.
    count: usize,
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
    /// Work of the walk, and of asking leaves `[visits]`.
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
    /// Only those with a marked face.
    pub(super) marked: bool,
    /// What each pair of faces costs besides `[visits]`.
    pub(super) pair: usize,
    /// Pairs that may be listed; where there are as many, a look is one thread's.
    pub(super) room: usize,
    /// When; with the work that may be done.
    pub(super) moment: &'a Moment<'a>,
}

impl Threads {
    /// Asks the leaves of a tree, where it is known of all particles whether they are flat. Returns the visits of the walk and of
    /// asking leaves. None where either is too much, or too many pairs were found. Each thread then did four times
    /// the work that may be done, at most.
    pub(super) fn ask<T: Fn(u32) -> f32 + Sync>(
        &mut self,
        Pool { jobs, threads }: Pool<'_>,
        search: &Search<'_, T>,
        flatness: &Flatness,
        tree: &Tree,
        walk: Walk<'_>,
    ) -> Option<[usize; 2]> {
        let count = RUNS * threads;
        self.workers.resize_with(self.workers.len().max(threads), Mutex::default);
        self.runs.resize_with(self.runs.len().max(count), Mutex::default);
        self.count = count;
        let Self { workers, runs, pairs: [pairs, next], .. } = self;
        let runs = &mut runs[..count];
        pairs.clear();
        pairs.push((0, 0));
        let meter = Effort::UNBOUNDED.meter();
        tree.split(search.surface, NeighborList::reach(walk.moment), walk.marked, PAIRS * count, pairs, next, &meter);
        let each = pairs.len().div_ceil(count);
        // The walk takes the last pair first.
        let pairs_of = |run: usize| {
            let [end, start] = [run, run + 1].map(|n| pairs.len().saturating_sub(n * each));
            &pairs[start..end]
        };
        let [claimed, finished, spent, listed] = [const { AtomicUsize::new(0) }; 4];
        let is_too_much = || {
            let [spent, listed] = [&spent, &listed].map(|sum| sum.load(Ordering::Relaxed));
            listed >= walk.room || !walk.moment.most.allows(spent / 2)
        };
        jobs.run(threads, &|thread| {
            let Some(worker) = workers.get(thread) else { return };
            let worker = &mut *lock(worker);
            worker.laid.forget(search.patches);
            // Where it is too much, nothing of this counts.
            while !is_too_much() {
                let number = claimed.fetch_add(1, Ordering::Relaxed);
                let Some(run) = runs.get(number) else { break };
                let run = &mut *lock(run);
                run.begin(walk.room);
                worker.walk(search, flatness, tree, walk, pairs_of(number), run);
                spent.fetch_add(run.visits.iter().sum(), Ordering::Relaxed);
                listed.fetch_add(run.outcome.pairs.len(), Ordering::Relaxed);
                finished.fetch_add(1, Ordering::Relaxed);
            }
        });
        let mut visits = [meter.spent(), 0];
        for run in runs.iter_mut().map(get) {
            visits.iter_mut().zip(run.visits).for_each(|(sum, visits)| *sum += visits);
        }
        let all = finished.into_inner() == count && listed.into_inner() < walk.room;
        if !(all && visits.iter().all(|&visits| walk.moment.most.allows(visits))) {
            // It held more than a look that counts.
            self.runs.clear();
            return None;
        }
        Some(visits)
    }

    /// What each run of pairs came to, in their order.
    pub(super) fn runs(&mut self) -> impl Iterator<Item = &mut Run> {
        self.runs.iter_mut().take(self.count).map(get)
    }
}

impl Worker {
    /// Asks the leaves of some pairs of nodes, until there is too much work.
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
            if asked.is_spent() || narrow.outcome.room == 0 {
                walked.exhaust();
            }
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
