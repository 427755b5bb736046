//! Slices shared out to threads.

use std::num::NonZeroUsize;

/// How many threads a twin may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threads(NonZeroUsize);

impl Threads {
    /// The calling thread alone.
    pub const ONE: Self = Self(NonZeroUsize::MIN);

    /// `count` threads, at least one.
    pub fn new(count: usize) -> Self {
        Self(NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN))
    }

    /// As many as the machine runs at a time.
    pub fn all() -> Self {
        std::thread::available_parallelism().map_or(Self::ONE, Self)
    }

    /// How many.
    pub fn count(self) -> usize {
        self.0.get()
    }

    /// Cuts `items` into a run a thread and calls `work` on each, at the same time. Returns what the calls returned. For
    /// work of a nanosecond an item, so runs are long.
    pub(crate) fn map<T: Sync, R: Send>(self, items: &[T], work: impl Fn(&[T]) -> R + Sync) -> Vec<R> {
        let mut runs: Vec<&[T]> = items.chunks(items.len().div_ceil(self.count()).max(1 << 18)).collect();
        share_runs(runs.iter_mut(), |run| work(run))
    }

    /// Cuts `items` into runs of at least a few thousand and calls `work(first index, run)` on each, at the same time.
    /// Returns what the calls returned, in order.
    pub(crate) fn share<T: Send, R: Send>(self, items: &mut [T], work: impl Fn(usize, &mut [T]) -> R + Sync) -> Vec<R> {
        self.share_runs_of(LEAST, items, work)
    }

    /// The same in runs of at least `least` items, at least one.
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

/// Calls `work` on each run, the first on the calling thread and each other on one of its own.
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

/// Items below which a thread of their own does not pay.
const LEAST: usize = 4096;

impl Default for Threads {
    fn default() -> Self {
        Self::all()
    }
}
