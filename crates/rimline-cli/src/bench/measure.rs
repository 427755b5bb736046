//! Interleaved measuring: every contender runs once a round, so that a drift of the machine's speed hits all alike.

use std::time::{Duration, Instant};

use crate::failure::Failure;

/// One run of one contender.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sample {
    /// By the clock, from the first call to the result's being there.
    pub(crate) wall_ms: f64,
    /// From the beginning of the first stage to the end of the last as the GPU's timestamps have it.
    pub(crate) gpu_ms: Option<f64>,
    /// Each stage's share.
    pub(crate) stages: Vec<(&'static str, f64)>,
}

impl Sample {
    /// The GPU's own time where it is known, else the clock's.
    pub(crate) fn time_ms(&self) -> f64 {
        self.gpu_ms.unwrap_or(self.wall_ms)
    }
}

/// How often a row is measured: as often as fits into its time, within bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounds {
    pub(crate) least: usize,
    pub(crate) most: usize,
    pub(crate) time: Duration,
}

/// Work that runs once a round.
pub(crate) type Contender<'a, T = Sample> = Box<dyn FnMut() -> Result<T, Failure> + 'a>;

/// Runs all contenders in turn, once to warm up and then counted, every other round backwards, so that none always
/// follows the same. Returns the samples of each, or `None` if `is_stopped` said so before the last round was over.
pub(crate) fn interleave<T>(
    rounds: Rounds,
    mut contenders: Vec<Contender<'_, T>>,
    is_stopped: impl Fn() -> bool,
) -> Result<Option<Vec<Vec<T>>>, Failure> {
    let count = contenders.len();
    let mut samples: Vec<Vec<T>> = (0..count).map(|_| Vec::new()).collect();
    let mut run = |index: usize| if is_stopped() { Ok(None) } else { contenders[index]().map(Some) };
    let mut round_time = Duration::ZERO;
    for index in 0..count {
        // The first run compiles and allocates; a later one is what a round will take.
        let mut last = Duration::ZERO;
        for _ in 0..3 {
            let begin = Instant::now();
            if run(index)?.is_none() {
                return Ok(None);
            }
            last = begin.elapsed();
            // A run this long needs no further warm-up.
            if last > rounds.time / 8 {
                break;
            }
        }
        round_time += last;
    }
    let fitting = rounds.time.as_secs_f64() / round_time.as_secs_f64().max(1e-9);
    for round in 0..(fitting as usize).clamp(rounds.least, rounds.most) {
        for at in 0..count {
            let index = if round % 2 == 0 { at } else { count - 1 - at };
            match run(index)? {
                Some(sample) => samples[index].push(sample),
                None => return Ok(None),
            }
        }
    }
    Ok(Some(samples))
}

/// Order statistics of some values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Summary {
    pub(crate) median: f64,
    /// First and third quartile.
    pub(crate) quartiles: (f64, f64),
    /// Lowest and highest.
    pub(crate) range: (f64, f64),
    pub(crate) count: usize,
}

impl Summary {
    /// `None` of no values.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (&low, &high) = (sorted.first()?, sorted.last()?);
        let quantile = |q: f64| {
            let place = q * (sorted.len() - 1) as f64;
            let [below, above] = [place.floor(), place.ceil()].map(|index| sorted[index as usize]);
            below + (above - below) * place.fract()
        };
        let quartiles = (quantile(0.25), quantile(0.75));
        Some(Self { median: quantile(0.5), quartiles, range: (low, high), count: sorted.len() })
    }
}

#[cfg(test)]
mod tests {
    use std::cell::{Cell, RefCell};

    use super::*;

    #[test]
    fn quantiles_lie_where_they_should() {
        let summary = Summary::of([5.0, 1.0, 3.0, 2.0, 4.0]).expect("there are values");
        assert_eq!((summary.median, summary.quartiles, summary.range), (3.0, (2.0, 4.0), (1.0, 5.0)));
        assert_eq!(Summary::of([1.0, 2.0]).map(|summary| summary.median), Some(1.5));
        assert_eq!(Summary::of([]), None);
    }

    #[test]
    fn contenders_take_turns_and_stop() {
        let order = RefCell::new(String::new());
        let contender = |name: char| -> Contender<'_> {
            let order = &order;
            Box::new(move || {
                order.borrow_mut().push(name);
                Ok(Sample::default())
            })
        };
        let rounds = Rounds { least: 3, most: 3, time: Duration::from_secs(3600) };
        let samples = interleave(rounds, vec![contender('a'), contender('b')], || false).expect("none fails");
        assert_eq!(samples.expect("nothing stopped it").iter().map(Vec::len).collect::<Vec<_>>(), [3, 3]);
        assert_eq!(order.take(), "aaabbbabbaab");
        let asked = Cell::new(0);
        let stop = || asked.replace(asked.get() + 1) == 7;
        let stopped = interleave(rounds, vec![contender('a'), contender('b')], stop).expect("none fails");
        assert!(stopped.is_none());
        assert_eq!(order.take(), "aaabbba");
    }
}
