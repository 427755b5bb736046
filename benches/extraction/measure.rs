//! Interleaved measuring: every contender runs once a round, so that a drift of the machine's speed hits all alike.

use std::time::Instant;

/// Milliseconds of one contender, a value a round.
#[derive(Clone, Debug, Default)]
pub(crate) struct Times(Vec<f64>);

impl Times {
    pub(crate) fn median(&self) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// The lowest and the highest value.
    pub(crate) fn spread(&self) -> (f64, f64) {
        self.0.iter().fold((f64::INFINITY, 0.0), |(low, high), &ms| (low.min(ms), high.max(ms)))
    }

    /// The median of the ratios to `other`, round by round.
    pub(crate) fn ratio_to(&self, other: &Self) -> f64 {
        Self(self.0.iter().zip(&other.0).map(|(own, other)| own / other).collect()).median()
    }
}

/// A contender's name and what it does, returning its milliseconds.
pub(crate) type Contender<'a> = (String, Box<dyn FnMut() -> f64 + 'a>);

/// Runs all contenders in turn, once to warm up and `rounds` times counted.
pub(crate) fn interleave(rounds: usize, contenders: Vec<Contender<'_>>) -> Vec<(String, Times)> {
    let (names, mut runs): (Vec<_>, Vec<_>) = contenders.into_iter().unzip();
    let mut times = vec![Times::default(); runs.len()];
    runs.iter_mut().for_each(|run| _ = run());
    for _ in 0..rounds {
        for (run, times) in runs.iter_mut().zip(&mut times) {
            times.0.push(run());
        }
    }
    names.into_iter().zip(times).collect()
}

/// Milliseconds that `work` takes by the wall clock.
pub(crate) fn wall_ms(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}
