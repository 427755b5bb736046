//! How long what took.

use std::time::Instant;

use serde_json::{Map, Value};

/// Milliseconds of each stage, in the order they ran.
#[derive(Clone, Debug, Default)]
pub(crate) struct Times(Vec<(&'static str, f64)>);

impl Times {
    pub(crate) fn add(&mut self, stage: &'static str, milliseconds: f64) {
        match self.0.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, sum)) => *sum += milliseconds,
            None => self.0.push((stage, milliseconds)),
        }
    }

    /// Runs a stage and takes its time by the clock.
    pub(crate) fn measure<T>(&mut self, stage: &'static str, run: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = run();
        self.add(stage, begin.elapsed().as_secs_f64() * 1e3);
        result
    }

    /// In a line.
    pub(crate) fn text(&self) -> String {
        let times: Vec<String> =
            self.0.iter().map(|(stage, milliseconds)| format!("{stage} {milliseconds:.1}")).collect();
        times.join(", ")
    }

    /// By stage.
    pub(crate) fn json(&self) -> Map<String, Value> {
        self.0.iter().map(|&(stage, milliseconds)| (stage.to_owned(), milliseconds.into())).collect()
    }
}
