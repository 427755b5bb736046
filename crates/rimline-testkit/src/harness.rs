//! Running tests that need a device: the adapter's name and the number of GPU tests are printed for the run's summary.
//! Running tests on model files.

use std::path::{Path, PathBuf};

use libtest_mimic::{Arguments, Failed, Trial};
use rimline_models::catalogue::GOOD;

use crate::assets;
use crate::device::Gpu;
use crate::files::{GOOD_FILES, made};

/// A test's name and body.
pub type Test = (&'static str, fn() -> Result<(), String>);

/// Trials of tests on the GPU.
pub fn gpu_trials(tests: impl IntoIterator<Item = Test>) -> Vec<Trial> {
    let trial = |(name, test): Test| Trial::test(name, move || test().map_err(Failed::from)).with_kind("gpu");
    tests.into_iter().map(trial).collect()
}

/// A trial for each of these files in a folder. Without the folder there is one instead, which is ignored; `cargo xtask
/// test` counts those that are named so.
pub fn on_files<E: Into<Failed>>(
    prefix: &str,
    folder: Option<PathBuf>,
    files: &[&str],
    test: impl Fn(&Path) -> Result<(), E> + Clone + Send + 'static,
) -> Vec<Trial> {
    let Some(folder) = folder else {
        return vec![Trial::test(format!("{prefix}real files"), || Ok(())).with_ignored_flag(true)];
    };
    let trial = |file: &&str| {
        let (path, test) = (folder.join(file), test.clone());
        Trial::test(format!("{prefix}{file}"), move || test(&path).map_err(Into::into))
    };
    files.iter().map(trial).collect()
}

/// A trial for each of these files of the catalogue.
pub fn on_made<E: Into<Failed>>(
    prefix: &str,
    names: impl IntoIterator<Item = &'static str>,
    test: impl Fn(&Path) -> Result<(), E> + Clone + Send + 'static,
) -> Vec<Trial> {
    let trial = |name: &'static str| {
        let test = test.clone();
        Trial::test(format!("{prefix}{name}"), move || test(&made(name)?.path).map_err(Into::into))
    };
    names.into_iter().map(trial).collect()
}

/// A trial for each good file, of the catalogue and real.
pub fn on_models<E: Into<Failed>>(
    prefix: &str,
    test: impl Fn(&Path) -> Result<(), E> + Clone + Send + 'static,
) -> Vec<Trial> {
    let mut trials = on_made(prefix, GOOD.iter().map(|good| good.name), test.clone());
    trials.extend(on_files(prefix, assets(), &GOOD_FILES, test));
    trials
}

/// A trial on a file of the catalogue, then on a real one, if the folder of real models is there.
pub fn on_both<E: Into<Failed>>(
    name: &str,
    [generated, real]: [&'static str; 2],
    test: impl Fn(&Path) -> Result<(), E> + Send + 'static,
) -> Trial {
    let run = move || {
        let file = made(generated)?;
        let paths = [Some(file.path.clone()), assets().map(|folder| folder.join(real))];
        paths.into_iter().flatten().try_for_each(|path| {
            test(&path).map_err(|error| {
                let error: Failed = error.into();
                Failed::from(format!("{}: {}", path.display(), error.message().unwrap_or_default()))
            })
        })
    };
    Trial::test(name, run)
}

/// The name of the adapter that tests run on, or why there is none.
pub fn adapter_name() -> String {
    Gpu::shared().map_or_else(|error| error, |gpu| gpu.name.clone())
}

/// Runs GPU tests and exits. Without an adapter they fail.
pub fn run(trials: Vec<Trial>) -> ! {
    println!("adapter: {}", adapter_name());
    println!("gpu tests: {}", trials.iter().filter(|trial| !trial.has_ignored_flag()).count());
    let conclusion = libtest_mimic::run(&Arguments::from_args(), trials);
    Gpu::close();
    conclusion.exit();
}
