//! Runs jobs on all threads at the same time. Pipelines are compiled so.

/// Runs each job once, in no order: on the calling thread and on others, in all as many as the machine has, but no more
/// threads than jobs. Where no other thread can be started, the calling one runs all jobs.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn together<J: Sync>(jobs: &[J], run: impl Fn(&J) + Sync) {
    use std::sync::atomic::{AtomicUsize, Ordering};

    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            run(job);
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 1..threads.min(jobs.len()) {
            // The jobs of a thread that cannot be started are left for the others.
            let _ = std::thread::Builder::new().name("rimline".into()).spawn_scoped(scope, work);
        }
        work();
    });
}

/// Runs each job once, in order, on the calling thread: a browser's device belongs to one thread.
#[cfg(target_family = "wasm")]
pub(crate) fn together<J>(jobs: &[J], run: impl Fn(&J)) {
    jobs.iter().for_each(run);
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::together;

    #[test]
    fn each_job_runs_once() {
        for count in [0, 1, 2, 100] {
            let jobs: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
            together(&jobs, |job| _ = job.fetch_add(1, Ordering::Relaxed));
            assert!(jobs.iter().all(|job| job.load(Ordering::Relaxed) == 1));
        }
    }
}
