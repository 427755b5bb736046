//! The one way to measure: all contenders run in turn, round by round, so that a drift of the machine's speed hits each
//! of them as much.

use std::time::{Duration, Instant};

use crate::{Error, Host};

/// A quantity that is measured of a contender in a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// Milliseconds of the whole work that has this name, such as a frame.
    Time(&'static str),
    /// Milliseconds of a stage or pass, which is a part of it.
    Stage(&'static str),
    /// A number of something, such as bytes.
    Count(&'static str),
}

pub type Sample = Vec<(Metric, f64)>;

pub fn times<const N: usize>(times: [(&'static str, f64); N]) -> Sample {
    times.map(|(name, ms)| (Metric::Time(name), ms)).into()
}

pub type Contender<'a> = Box<dyn FnMut() -> Result<Sample, Error> + 'a>;

/// How many rounds are measured: as many as fit into `time`, but from `least` to `most`. Runs that warm up are not part of
/// `time`.
#[derive(Clone, Copy, Debug)]
pub struct Rounds {
    pub least: usize,
    pub most: usize,
    pub time: Duration,
}

impl Rounds {
    pub fn exactly(count: usize) -> Self {
        Self { least: count, most: count, time: Duration::ZERO }
    }
}

/// Runs each contender to warm up, three times at most and no more often than it is counted, then all of them in turn in each
/// round. Every other round goes backwards, so that no contender always follows the same one. Returns the samples of each
/// contender, one a round.
pub fn interleave(
    rounds: Rounds,
    mut contenders: Vec<Contender<'_>>,
    host: &dyn Host,
) -> Result<Vec<Vec<Sample>>, Error> {
    let count = contenders.len();
    let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); count];
    let mut run = |index: usize| if host.is_stopped() { Err(Error::Stopped) } else { contenders[index]() };
    let mut round_time = Duration::ZERO;
    for index in 0..count {
        // The first run compiles and allocates; a later one is what a round will take.
        let mut last = Duration::ZERO;
        for _ in 0..rounds.most.clamp(1, 3) {
            let begin = Instant::now();
            run(index)?;
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
            samples[index].push(run(index)?);
        }
    }
    Ok(samples)
}

/// Milliseconds that some work takes.
pub fn clock(work: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    work();
    begin.elapsed().as_secs_f64() * 1e3
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    pub median: f64,
    pub quartiles: [f64; 2],
    pub range: [f64; 2],
    pub count: usize,
}

impl Summary {
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (&low, &high) = (sorted.first()?, sorted.last()?);
        let quantile = |q: f64| {
            let rank = q * (sorted.len() - 1) as f64;
            let [below, above] = [rank.floor(), rank.ceil()].map(|index| sorted[index as usize]);
            below + (above - below) * rank.fract()
        };
        let quartiles = [quantile(0.25), quantile(0.75)];
        Some(Self { median: quantile(0.5), quartiles, range: [low, high], count: sorted.len() })
    }
}

#[cfg(test)]
mod tests {
    use std::cell::{Cell, RefCell};

    use super::*;

    #[test]
    fn quantiles_lie_where_they_should() {
        let summary = Summary::of([5.0, 1.0, 3.0, 2.0, 4.0]).expect("there are values");
        assert_eq!((summary.median, summary.quartiles, summary.range), (3.0, [2.0, 4.0], [1.0, 5.0]));
        assert_eq!(Summary::of([1.0, 2.0]).map(|summary| summary.median), Some(1.5));
        assert_eq!(Summary::of([]), None);
    }

    struct StopsAt(Cell<usize>);

    impl Host for StopsAt {
        fn is_stopped(&self) -> bool {
            self.0.replace(self.0.get().wrapping_sub(1)) == 0
        }
    }

    #[test]
    fn contenders_take_turns_and_stop() {
        let order = RefCell::new(String::new());
        let contender = |name: char| -> Contender<'_> {
            let order = &order;
            Box::new(move || {
                order.borrow_mut().push(name);
                Ok(Sample::new())
            })
        };
        let rounds = Rounds { least: 3, most: 3, time: Duration::from_secs(3600) };
        let samples = interleave(rounds, vec![contender('a'), contender('b')], &()).expect("none fails");
        assert_eq!(samples.iter().map(Vec::len).collect::<Vec<_>>(), [3, 3]);
        assert_eq!(order.take(), "aaabbbabbaab");
        let once = Rounds { least: 1, most: 1, ..rounds };
        interleave(once, vec![contender('a'), contender('b')], &()).expect("none fails");
        assert_eq!(order.take(), "abab");
        let host = StopsAt(Cell::new(7));
        let stopped = interleave(rounds, vec![contender('a'), contender('b')], &host);
        assert!(matches!(stopped, Err(Error::Stopped)));
        assert_eq!(order.take(), "aaabbba");
    }
}
