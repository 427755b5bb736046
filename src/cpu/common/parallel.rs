//! Distributes slices over threads.

use std::num::NonZeroUsize;
use std::sync::{Mutex, PoisonError};

/// The most threads that a function uses, the calling one among them. It uses fewer where the work is small or the system
/// starts no more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threads(NonZeroUsize);

impl Threads {
    /// Only the calling thread.
    pub const ONE: Self = Self(NonZeroUsize::MIN);

    /// `count` threads, but at least one.
    pub fn new(count: usize) -> Self {
        Self(NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN))
    }

    /// The number of threads that the process may run at the same time, or one if it is unknown.
    pub fn all() -> Self {
        std::thread::available_parallelism().map_or(Self::ONE, Self)
    }

    /// The number of threads.
    pub fn count(self) -> usize {
        self.0.get()
    }

    /// Cuts `items` into at most one run for each thread and calls `work` on all runs at the same time. Returns the results of
    /// the runs in order. It is meant for work of about a nanosecond for each item, so a run but the last has 262,144 or more.
    pub(crate) fn map<T: Sync, R: Send>(self, items: &[T], work: impl Fn(&[T]) -> R + Sync) -> Vec<R> {
        share_runs(items.chunks(items.len().div_ceil(self.count()).max(1 << 18)), work)
    }

    /// Cuts `items` into runs of at least [`LEAST`], as [`Self::share_runs_of`] does.
    pub(crate) fn share<T: Send, R: Send>(self, items: &mut [T], work: impl Fn(usize, &mut [T]) -> R + Sync) -> Vec<R> {
        self.share_runs_of(LEAST, items, work)
    }

    /// Cuts `items` into at most one run for each thread, of one length, at least `least`; only the last may be shorter. Calls
    /// `work(index of the first item, run)` on all runs at the same time. Returns the results of the runs in order.
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

/// Calls `work` on each run, on the calling thread and on one more for each further run. Runs whose threads the system does not
/// start are left for the others. Returns the results in order.
fn share_runs<T: Send, R: Send>(runs: impl ExactSizeIterator<Item = T> + Send, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let others = runs.len().saturating_sub(1);
    let runs = Mutex::new(runs.enumerate());
    let next = || runs.lock().unwrap_or_else(PoisonError::into_inner).next();
    let take = || std::iter::from_fn(next).map(|(index, run)| (index, work(run))).collect::<Vec<_>>();
    let mut results = std::thread::scope(|scope| {
        let start = |_| std::thread::Builder::new().spawn_scoped(scope, take).ok();
        let workers: Vec<_> = (0..others).map_while(start).collect();
        let mut results = take();
        for worker in workers {
            results.extend(worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        results
    });
    results.sort_unstable_by_key(|&(index, _)| index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// With fewer items a further thread costs more than it saves.
const LEAST: usize = 4096;

impl Default for Threads {
    fn default() -> Self {
        Self::all()
    }
}
