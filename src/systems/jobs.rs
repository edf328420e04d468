//! Threads of Bevy's compute pool for an island to share.

use std::sync::{Arc, LazyLock};

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

/// The threads of the compute pool.
pub(super) fn compute_pool() -> Arc<dyn JobSystem> {
    static POOL: LazyLock<Arc<ComputePool>> = LazyLock::new(|| Arc::new(ComputePool));
    POOL.clone()
}
