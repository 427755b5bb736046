//! Progress, on a terminal only.

use std::borrow::Cow;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A line on standard error that says what is being done; hidden where that is not a terminal.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    pub(crate) fn start() -> Self {
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
            bar.set_style(style);
        }
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Self(bar)
    }

    /// A bar of so many things to do.
    pub(crate) fn count(things: u64, name: &'static str) -> Self {
        let bar = ProgressBar::new(things);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg}, {eta} left") {
            bar.set_style(style);
        }
        bar.set_message(name);
        Self(bar)
    }

    /// One of them is done.
    pub(crate) fn advance(&self) {
        self.0.inc(1);
    }

    /// Says what is done from now on.
    pub(crate) fn step(&self, what: impl Into<Cow<'static, str>>) {
        self.0.set_message(what);
    }

    /// Runs what prints to the terminal, the line out of its way.
    pub(crate) fn aside<T>(&self, print: impl FnOnce() -> T) -> T {
        self.0.suspend(print)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
