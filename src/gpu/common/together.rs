//! Runs jobs on several threads at the same time. Pipelines are compiled so.

/// The number of threads that may use the device at the same time. A context of OpenGL has one: others wait for it, and wgpu
/// panics in a thread that waits longer than 6 seconds.
pub(crate) fn threads(device: &wgpu::Device) -> usize {
    if device.adapter_info().backend == wgpu::Backend::Gl {
        return 1;
    }
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Runs each job once, in no order: on the calling thread and on others, in all so many, but no more than jobs. Where no
/// other thread can be started, the calling one runs all jobs.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn together<J: Sync>(threads: usize, jobs: &[J], run: impl Fn(&J) + Sync) {
    use std::sync::atomic::{AtomicUsize, Ordering};

    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            run(job);
        }
    };
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
pub(crate) fn together<J>(_: usize, jobs: &[J], run: impl Fn(&J)) {
    jobs.iter().for_each(run);
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::together;

    #[test]
    fn each_job_runs_once() {
        for (threads, count) in [1, 4].into_iter().flat_map(|threads| [0, 1, 2, 100].map(|count| (threads, count))) {
            let jobs: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
            let caller = std::thread::current().id();
            together(threads, &jobs, |job| {
                job.fetch_add(1, Ordering::Relaxed);
                assert!(threads > 1 || std::thread::current().id() == caller);
            });
            assert!(jobs.iter().all(|job| job.load(Ordering::Relaxed) == 1));
        }
    }
}
