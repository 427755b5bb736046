//! Running tests that need a device: the adapter's name and the number of GPU tests are printed for the run's summary.

use libtest_mimic::{Arguments, Failed, Trial};

use crate::device::Gpu;

/// A test's name and body.
pub type Test = (&'static str, fn() -> Result<(), String>);

/// Trials of tests on the GPU.
pub fn gpu_trials(tests: impl IntoIterator<Item = Test>) -> Vec<Trial> {
    let trial = |(name, test): Test| Trial::test(name, move || test().map_err(Failed::from)).with_kind("gpu");
    tests.into_iter().map(trial).collect()
}

/// The name of the adapter that tests run on, or why there is none.
pub fn adapter_name() -> String {
    Gpu::shared().map_or_else(|error| error, |gpu| gpu.name.clone())
}

/// Runs GPU tests and exits. Without an adapter they fail; none is passed over.
pub fn run(trials: Vec<Trial>) -> ! {
    println!("adapter: {}", adapter_name());
    println!("gpu tests: {}", trials.iter().filter(|trial| !trial.has_ignored_flag()).count());
    let conclusion = libtest_mimic::run(&Arguments::from_args(), trials);
    Gpu::close();
    conclusion.exit();
}
