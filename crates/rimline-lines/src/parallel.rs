//! Blocks of work on several threads, with progress and an end at the caller's wish.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rimline::cpu::Threads;

/// Calls `work` for each number below `count` and returns the results in order, the same for any number of threads. The calling
/// thread calls `tick` with how many were begun. `None` if that ended it.
pub(crate) fn blocks<R: Send>(
    threads: Threads,
    count: usize,
    work: impl Fn(usize) -> R + Sync,
    tick: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Option<Vec<R>> {
    let (next, is_ended) = (AtomicUsize::new(0), AtomicBool::new(false));
    let take = || {
        let block = next.fetch_add(1, Ordering::Relaxed);
        (block < count && !is_ended.load(Ordering::Relaxed)).then_some(block)
    };
    let run_blocks = |tick: &mut dyn FnMut(usize) -> ControlFlow<()>| {
        let mut done = Vec::new();
        while let Some(block) = take() {
            if tick(block).is_break() {
                is_ended.store(true, Ordering::Relaxed);
                break;
            }
            done.push((block, work(block)));
        }
        done
    };
    let mut results = std::thread::scope(|scope| {
        let others = threads.count().min(count).saturating_sub(1);
        let run_blocks = &run_blocks;
        let run = move || run_blocks(&mut |_| ControlFlow::Continue(()));
        // Threads that the system does not start leave their blocks to the others.
        let workers: Vec<_> =
            (0..others).map_while(|_| std::thread::Builder::new().spawn_scoped(scope, run).ok()).collect();
        let mut results = run_blocks(tick);
        for worker in workers {
            results.extend(worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        results
    });
    results.sort_unstable_by_key(|&(block, _)| block);
    (!is_ended.into_inner()).then(|| results.into_iter().map(|(_, result)| result).collect())
}

/// The same for ranges of at most `size` items that make up `count`.
pub(crate) fn ranges<R: Send>(
    threads: Threads,
    count: usize,
    size: usize,
    work: impl Fn(std::ops::Range<usize>) -> R + Sync,
) -> Vec<R> {
    let range = |block: usize| block * size..((block + 1) * size).min(count);
    let found = blocks(threads, count.div_ceil(size), |block| work(range(block)), &mut |_| ControlFlow::Continue(()));
    found.unwrap_or_default()
}
