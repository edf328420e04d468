//! Work that threads share. The solver has no threads of its own: an engine lends it those that it has.

use core::fmt::Debug;

/// Runs jobs on the threads of an engine, as `JobSystem` of Jolt.
///
/// What they compute has the same bits for any number of threads.
pub trait JobSystem: Debug + Send + Sync {
    /// Number of jobs that can run at once, the caller's among them.
    fn concurrency(&self) -> usize;

    /// Calls `job` with each number from 0 to `count - 1`, once, on any thread, in any order. Returns when all have returned, and
    /// passes a panic on. Several islands may call it at once.
    fn run(&self, count: usize, job: &(dyn Fn(usize) + Sync));
}
