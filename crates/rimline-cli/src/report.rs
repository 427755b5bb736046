//! Parts that the reports of `extract`, `query` and `shadow` share: lines, JSON, and the times of stages.

use std::fmt::{Display, Write as _};
use std::time::Instant;

use rimline::Origin;
use rimline::gpu::{DeviceError, StageTimer};
use serde_json::{Map, Value};

use crate::coordinates::{add_origin, origin_text};
use crate::device::Gpu;

#[derive(Default)]
pub(crate) struct Lines(pub(crate) String);

impl Lines {
    pub(crate) fn line(&mut self, name: &str, value: impl Display) {
        let _ = writeln!(self.0, "{name:<18} {value}");
    }

    pub(crate) fn origin(&mut self, origin: Origin) {
        if let Some(origin) = origin_text(origin, "what is written is relative to it") {
            self.line("origin", origin);
        }
    }

    pub(crate) fn times(&mut self, times: &Times) {
        self.line("milliseconds", times.sums());
        self.line("by stage", times.text());
    }
}

/// A report for programs: `report` and the keys that all three have. Keys may be added, but never change or go; only names
/// of stages may.
pub(crate) fn json(mut report: Value, origin: Origin, times: &Times) -> String {
    let [set_up, work] = times.set_up_and_work();
    report["milliseconds"] = times.json().into();
    report["set_up_milliseconds"] = set_up.into();
    report["work_milliseconds"] = work.into();
    add_origin(&mut report, origin);
    format!("{report:#}\n")
}

/// The number of each light. For more than eight lights: those of the first eight, and the sum of all.
pub(crate) fn per_light(counts: &[usize]) -> String {
    let (shown, more) = first_lights(counts);
    if more { format!("{shown}, … ({} for {} lights)", counts.iter().sum::<usize>(), counts.len()) } else { shown }
}

/// The numbers of the first eight lights, and whether there are more.
pub(crate) fn first_lights(counts: &[usize]) -> (String, bool) {
    const SHOWN: usize = 8;
    let shown: Vec<String> = counts.iter().take(SHOWN).map(usize::to_string).collect();
    (shown.join(", "), counts.len() > SHOWN)
}

/// Stages that prepare the device for the others: they open it, make buffers and pipelines, and compile shaders.
const SET_UP: [&str; 4] = ["device", "prepare", "pipelines", "compile"];

/// The name for all stages of the device together, where it has no timestamps, or meaningless ones.
const ALL_STAGES: &str = "stages";

/// Milliseconds of each stage, summed over its runs, in the order of first runs. `None`: only [`ALL_STAGES`] is known.
#[derive(Clone, Debug, Default)]
pub(crate) struct Times(Vec<(&'static str, Option<f64>)>);

impl Times {
    pub(crate) fn add(&mut self, stage: &'static str, milliseconds: f64) {
        match self.0.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, sum)) => *sum = Some(sum.unwrap_or(0.0) + milliseconds),
            None => self.0.push((stage, Some(milliseconds))),
        }
    }

    /// Adds the times of the stages that `timer` timed. They must have run. Without a timer, or where its timestamps have
    /// no meaning, adds `all` as [`ALL_STAGES`]: their time together by a clock of the CPU.
    pub(crate) fn add_stages(&mut self, gpu: &Gpu, timer: Option<&StageTimer>, all: f64) -> Result<(), DeviceError> {
        let Some(timer) = timer else {
            self.add(ALL_STAGES, all);
            return Ok(());
        };
        match timer.read(&gpu.device, &gpu.queue) {
            Ok(times) => times.stages.into_iter().for_each(|(stage, milliseconds)| self.add(stage, milliseconds)),
            Err(error) if error.is_clock() => {
                for stage in timer.stages() {
                    if self.0.iter().all(|(name, _)| *name != stage) {
                        self.0.push((stage, None));
                    }
                }
                self.add(ALL_STAGES, all);
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }

    pub(crate) fn measure<T>(&mut self, stage: &'static str, run: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = run();
        self.add(stage, begin.elapsed().as_secs_f64() * 1e3);
        result
    }

    pub(crate) fn set_up_and_work(&self) -> [f64; 2] {
        let sum = |is_set_up: bool| {
            let stages = self.0.iter().filter(|(stage, _)| SET_UP.contains(stage) == is_set_up);
            stages.filter_map(|(_, milliseconds)| *milliseconds).sum()
        };
        [sum(true), sum(false)]
    }

    pub(crate) fn sums(&self) -> String {
        let [set_up, work] = self.set_up_and_work();
        format!("set-up {set_up:.1}, work {work:.1}")
    }

    pub(crate) fn text(&self) -> String {
        let times: Vec<String> =
            self.0.iter().filter_map(|(stage, ms)| ms.map(|ms| format!("{stage} {ms:.1}"))).collect();
        times.join(", ")
    }

    pub(crate) fn json(&self) -> Map<String, Value> {
        self.0.iter().map(|&(stage, milliseconds)| (stage.to_owned(), milliseconds.into())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_up_and_work_are_apart() {
        let mut times = Times::default();
        for (stage, milliseconds) in
            [("load", 1.0), ("compile", 32.0), ("facing", 2.0), ("device", 64.0), ("facing", 4.0)]
        {
            times.add(stage, milliseconds);
        }
        assert_eq!(times.set_up_and_work(), [96.0, 7.0]);
        assert_eq!(times.sums(), "set-up 96.0, work 7.0");
    }
}
