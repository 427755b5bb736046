//! Medians, spreads, and the machine's name.

use std::time::Duration;

/// Times of one method on one mesh.
#[derive(Default)]
pub(crate) struct Samples(Vec<Duration>);

impl Samples {
    pub(crate) fn push(&mut self, time: Duration) {
        let index = self.0.partition_point(|&t| t < time);
        self.0.insert(index, time);
    }

    /// The middle time; zero if there is none.
    pub(crate) fn median(&self) -> Duration {
        self.0.get(self.0.len() / 2).copied().unwrap_or_default()
    }

    /// Median, least and most in milliseconds, and the ratio of `reference` to the median: table cells.
    pub(crate) fn row(&self, reference: Duration) -> String {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let [least, most] = [self.0.first(), self.0.last()].map(|t| ms(t.copied().unwrap_or_default()));
        let median = ms(self.median());
        let ratio = ms(reference) / median;
        format!("{median:.1} | {least:.1} | {most:.1} | {ratio:.2}")
    }
}

/// Name of the processor, where it can be read, its number of threads, and its architecture.
pub(crate) fn cpu_name() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info
        .lines()
        .find_map(|line| line.strip_prefix("model name"))
        .map_or("unknown", |rest| rest.trim_start_matches([':', ' ', '\t']));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{name}, {threads} threads, {}", std::env::consts::ARCH)
}
