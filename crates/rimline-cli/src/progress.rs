//! Progress, on a terminal only.

use std::borrow::Cow;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::output::is_quiet;
#[cfg(feature = "bench")]
use crate::output::note;
use crate::shown::Line;

/// A line on standard error that says what is being done; hidden where that is not a terminal.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    pub(crate) fn start() -> Self {
        Self::with(ProgressBar::new_spinner(), "{spinner} {msg} {elapsed}")
    }

    #[cfg(feature = "bench")]
    pub(crate) fn rows(count: usize) -> Self {
        Self::with(ProgressBar::new(count as u64), "{wide_bar} {pos}/{len}, {eta} left: {msg}")
    }

    fn with(bar: ProgressBar, template: &str) -> Self {
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        if is_quiet() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Self(bar)
    }

    pub(crate) fn pictures(count: u64) -> Self {
        Self::with(ProgressBar::new(count), "{wide_bar} {pos}/{len} pictures, {eta} left")
    }

    pub(crate) fn picture_done(&self) {
        self.0.inc(1);
    }

    pub(crate) fn step(&self, what: impl Into<Cow<'static, str>>) {
        self.0.set_message(Line(what.into()).to_string());
    }

    /// Counts a row as done; where there is no terminal for a bar, a line says so.
    #[cfg(feature = "bench")]
    pub(crate) fn advance(&self, what: &str) {
        self.0.inc(1);
        if self.0.is_hidden() {
            note(&format!("{}/{} {what}", self.0.position(), self.0.length().unwrap_or_default()));
        }
    }

    pub(crate) fn is_shown(&self) -> bool {
        !self.0.is_hidden()
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
