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

    /// Cuts `items` into runs of at least a few thousand and calls `work(first index, run)` on each, at the same time.
    /// Returns what the calls returned, in order.
    pub(super) fn share<T: Send, R: Send>(self, items: &mut [T], work: impl Fn(usize, &mut [T]) -> R + Sync) -> Vec<R> {
        const LEAST: usize = 4096;
        let run = items.len().div_ceil(self.count()).max(LEAST);
        if run >= items.len() {
            return vec![work(0, items)];
        }
        std::thread::scope(|scope| {
            let work = &work;
            let workers: Vec<_> = items
                .chunks_mut(run)
                .enumerate()
                .map(|(index, items)| scope.spawn(move || work(index * run, items)))
                .collect();
            workers
                .into_iter()
                .map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                .collect()
        })
    }
}

impl Default for Threads {
    fn default() -> Self {
        Self::all()
    }
}
