//! Distributes slices over threads.

use std::num::NonZeroUsize;

/// The number of threads that a function may use. It panics if the system cannot start them: on `wasm32` without threads, use
/// [`Self::ONE`] or [`Self::all`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threads(NonZeroUsize);

impl Threads {
    /// Only the calling thread.
    pub const ONE: Self = Self(NonZeroUsize::MIN);

    /// `count` threads, but at least one.
    pub fn new(count: usize) -> Self {
        Self(NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN))
    }

    /// The number of threads that the machine runs at the same time, or one if it is unknown.
    pub fn all() -> Self {
        std::thread::available_parallelism().map_or(Self::ONE, Self)
    }

    /// The number of threads.
    pub fn count(self) -> usize {
        self.0.get()
    }

    /// Cuts `items` into one run for each thread and calls `work` on all runs at the same time. Returns the results in
    /// order. It is meant for work of about a nanosecond for each item, so runs are long.
    pub(crate) fn map<T: Sync, R: Send>(self, items: &[T], work: impl Fn(&[T]) -> R + Sync) -> Vec<R> {
        let mut runs: Vec<&[T]> = items.chunks(items.len().div_ceil(self.count()).max(1 << 18)).collect();
        share_runs(runs.iter_mut(), |run| work(run))
    }

    /// Cuts `items` into runs of at least a few thousand and calls `work(first index, run)` on all runs at the same
    /// time. Returns the results in order.
    pub(crate) fn share<T: Send, R: Send>(self, items: &mut [T], work: impl Fn(usize, &mut [T]) -> R + Sync) -> Vec<R> {
        self.share_runs_of(LEAST, items, work)
    }

    /// Does the same with runs of at least `least` items.
    pub(crate) fn share_runs_of<T: Send, R: Send>(
        self,
        least: usize,
        items: &mut [T],
        work: impl Fn(usize, &mut [T]) -> R + Sync,
    ) -> Vec<R> {
        let run = items.len().div_ceil(self.count()).max(least).max(1);
        share_runs(items.chunks_mut(run).enumerate(), |(index, items)| work(index * run, items))
    }
}

/// Calls `work` on each run: the first on the calling thread, the others on further threads.
fn share_runs<T: Send, R: Send>(mut runs: impl Iterator<Item = T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let Some(first) = runs.next() else { return Vec::new() };
    std::thread::scope(|scope| {
        let work = &work;
        let workers: Vec<_> = runs.map(|run| scope.spawn(move || work(run))).collect();
        let mut results = vec![work(first)];
        results.extend(
            workers.into_iter().map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))),
        );
        results
    })
}

/// With fewer items a further thread costs more than it saves.
const LEAST: usize = 4096;

impl Default for Threads {
    fn default() -> Self {
        Self::all()
    }
}
