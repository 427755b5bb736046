//! Counting tests.

use std::process::ExitCode;

/// Counts of the tests and checks of a run.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Summary {
    /// Passed, failed, and ignored by name.
    counts: [usize; 3],
    /// All that test binaries said since the last [`Self::tests_ended`].
    new_tests: usize,
    /// Ignored ones that stand for tests on model files, whose folder is missing.
    without_files: usize,
    gpu_tests: usize,
    /// Lines to show again at the end.
    notes: Vec<String>,
    errors: Vec<String>,
}

impl Summary {
    /// Counts what a line of a test binary's output says.
    pub(crate) fn read(&mut self, line: &str) {
        if let Some(counts) = line.strip_prefix("test result: ") {
            // "ok. 6 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.03s"
            let words: Vec<_> = counts.split([' ', ';', '.']).filter(|word| !word.is_empty()).collect();
            for pair in words.windows(2) {
                if let Some(of) = ["passed", "failed", "ignored"].iter().position(|word| *word == pair[1]) {
                    let count: usize = pair[0].parse().unwrap_or(0);
                    self.counts[of] += count;
                    self.new_tests += count;
                }
            }
        } else if line.trim_end().ends_with("... ignored") && line.contains("real files ") {
            self.without_files += 1;
        } else if let Some(count) = line.strip_prefix("gpu tests: ") {
            self.gpu_tests += count.trim().parse::<usize>().unwrap_or(0);
            self.notes.push(line.into());
        } else if line.starts_with("adapter: ") {
            self.notes.push(line.into());
        }
    }

    /// Ends the reading of test binaries: whether cargo was content, whether there was any test, and, if tests on the GPU
    /// are among those that were asked for, whether there was one.
    pub(crate) fn tests_ended(&mut self, succeeded: bool, needs_gpu_tests: bool) {
        let has_tests = std::mem::take(&mut self.new_tests) > 0;
        if !succeeded && self.counts[1] == 0 {
            self.fail("the tests ended badly, though none is reported as failed: see above");
        }
        if succeeded && !has_tests {
            self.fail("no test has such a name");
        }
        if needs_gpu_tests && self.gpu_tests == 0 {
            self.fail("no GPU test ran");
        }
    }

    /// Counts a check of this program's own.
    pub(crate) fn check(&mut self, name: &str, outcome: Result<(), String>) {
        println!("check {name} ... {}", if outcome.is_ok() { "ok" } else { "FAILED" });
        match outcome {
            Ok(()) => self.counts[0] += 1,
            Err(error) => self.fail(&format!("{name}: {error}")),
        }
    }

    /// Adds the tests that ran on another driver.
    pub(crate) fn add(&mut self, driver: &str, other: Self) {
        self.note(&format!("on {driver}: {}", other.last_line()));
        self.counts.iter_mut().zip(other.counts).for_each(|(count, more)| *count += more);
        self.without_files += other.without_files;
        self.gpu_tests += other.gpu_tests;
        self.errors.extend(other.errors.into_iter().map(|error| format!("on {driver}: {error}")));
    }

    /// Something to show at the end.
    pub(crate) fn note(&mut self, note: &str) {
        self.notes.push(note.into());
    }

    /// Counts a failure that is no test's.
    pub(crate) fn fail(&mut self, error: &str) {
        self.counts[1] += 1;
        self.errors.push(error.into());
    }

    fn last_line(&self) -> String {
        let [passed, failed, skipped] = self.counts;
        format!("{passed} passed, {failed} failed, {skipped} skipped")
    }

    /// Why tests were skipped.
    fn why_skipped(&self) -> Option<String> {
        let (files, others) = (self.without_files, self.counts[2].saturating_sub(self.without_files));
        (self.counts[2] > 0).then(|| {
            format!(
                "skipped: {files} groups of tests on real models, whose folder is not there (RIMLINE_ASSETS); {others} long \
                 trials (cargo xtask test --long) and tests of drivers that are not installed"
            )
        })
    }

    /// Shows notes, errors and, as the last line, the counts; all on standard output, so that they stay in this order.
    pub(crate) fn finish(&self) -> ExitCode {
        println!();
        let errors = self.errors.iter().map(|error| format!("error: {error}"));
        let lines = self.notes.iter().cloned().chain(errors).chain(self.why_skipped()).chain([self.last_line()]);
        for line in lines {
            println!("{line}");
        }
        if self.counts[1] == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

#[cfg(test)]
mod tests {
    use super::Summary;

    fn summary(lines: &[&str], succeeded: bool) -> Summary {
        let mut summary = Summary::default();
        for line in lines {
            summary.read(line);
        }
        summary.tests_ended(succeeded, true);
        summary
    }

    const RESULT: &str =
        "test result: ok. 6 passed; 0 failed; 2 ignored; 0 measured; 0 filtered out; finished in 0.03s";

    #[test]
    fn results_of_all_binaries_add_up() {
        let failed = "test result: FAILED. 20 passed; 3 failed; 0 ignored; 0 measured; 1 filtered out; finished in 9s";
        let all = summary(&[RESULT, "adapter: llvmpipe", "gpu tests: 20", failed], false);
        assert_eq!(all.last_line(), "26 passed, 3 failed, 2 skipped");
        assert_eq!(all.notes, ["adapter: llvmpipe", "gpu tests: 20"]);
    }

    #[test]
    fn the_reason_for_skipping_is_said() {
        let ignored =
            ["test [gpu] file real files      ... ignored", "test long ... ignored", "test real files ... ok"];
        let why = summary(&[&ignored[..], &[RESULT]].concat(), true).why_skipped();
        assert!(why.is_some_and(|why| why.contains("1 groups") && why.contains("1 long")));
        assert_eq!(summary(&["gpu tests: 1"], true).why_skipped(), None);
    }

    #[test]
    fn a_run_without_gpu_tests_fails() {
        assert_eq!(summary(&[RESULT], true).last_line(), "6 passed, 1 failed, 2 skipped");
        assert_eq!(summary(&[RESULT, "gpu tests: 0"], true).last_line(), "6 passed, 1 failed, 2 skipped");
    }

    #[test]
    fn tests_of_a_target_need_no_gpu_but_a_test() {
        let mut of_target = Summary::default();
        of_target.read(RESULT);
        of_target.tests_ended(true, false);
        assert_eq!(of_target.last_line(), "6 passed, 0 failed, 2 skipped");
        // The next target has no test of that name.
        of_target.read("test result: ok. 0 passed; 0 failed; 0 ignored; 0 measured; 90 filtered out; finished in 0s");
        of_target.tests_ended(true, false);
        assert_eq!(of_target.last_line(), "6 passed, 1 failed, 2 skipped");
    }

    #[test]
    fn a_crash_without_a_failed_test_fails() {
        let crashed = summary(&["gpu tests: 4", RESULT], false);
        assert_eq!(crashed.last_line(), "6 passed, 1 failed, 2 skipped");
    }
}
