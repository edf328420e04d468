//! Threads of Bevy's compute pool for islands to share.

use bevy::tasks::ComputeTaskPool;

use crate::solver::jobs::JobSystem;

#[derive(Debug)]
struct ComputePool;

impl JobSystem for ComputePool {
    fn concurrency(&self) -> usize {
        ComputeTaskPool::get().thread_num()
    }

    fn run(&self, count: usize, job: &(dyn Fn(usize) + Sync)) {
        ComputeTaskPool::get().scope(|scope| {
            for number in 1..count {
                scope.spawn(async move { job(number) });
            }
            job(0);
        });
    }
}

/// Threads that each of so many islands may share. None where the islands themselves keep all threads busy: who waits for a
/// job of one island would begin with the frame of another.
pub(super) fn spare(islands: usize) -> Option<&'static dyn JobSystem> {
    (islands < ComputePool.concurrency()).then_some(&ComputePool)
}
