//! `cargo xtask test --drivers`: the tests of bits on every driver that this machine has.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::packages::Manager;
use crate::summary::Summary;
use crate::test::BENCH;
use crate::{process, test, vulkan};

/// Tests that compare results bit by bit with the CPU's.
const TESTS: [&str; 4] = ["extract_gpu", "polygon_gpu", "query_gpu", "scene_gpu"];
/// Targets of which not all results are the same on every driver, and a text in the names of tests whose results are:
/// goldens of walls, the stage `stencil_bound` against whole numbers, and depth that masks copy. Goldens of whole shadow
/// volumes are not among them: they have near caps and choices, whose rounding is left to the driver.
const GOLDENS: [(&str, &str); 3] =
    [("depth_map_gpu", "are_the_goldens"), ("shadow_gpu", "stencil_bound"), ("mask_gpu", "depth_survives_the_copy")];
/// The tests that take `SwiftShader` minutes, not more.
const QUICK: [&str; 2] = ["extract_gpu", "scene_gpu"];

/// Tests that make pipelines for many devices. `SwiftShader` had not compiled those of both after eleven minutes.
const SLOW_ON_SWIFTSHADER: [&str; 2] =
    ["shadow_depth_on_small_limits_and_any_stride", "shadow_depth_does_not_depend_on_skipping_or_splitting"];

/// The packages and features of `cargo xtask test`, so that nothing is built twice.
const EVERYTHING: [&str; 4] = ["--workspace", "--exclude", BENCH, "--all-features"];

/// Where browsers keep the manifest of `SwiftShader`, which no Vulkan loader looks for.
const BROWSERS: [&str; 4] =
    ["/usr/lib/chromium", "/usr/lib/chromium-browser", "/usr/lib64/chromium-browser", "/opt/google/chrome"];

/// A driver, and the environment in which it is the only one.
struct Driver {
    name: String,
    variables: Vec<(&'static str, OsString)>,
}

impl Driver {
    /// The driver that these variables leave, if it has an adapter.
    fn of(variables: Vec<(&'static str, OsString)>) -> Option<Self> {
        let devices = process::built("rimline");
        let said = process::output(Command::new(devices).args(["devices", "--json"]).envs(variables.clone())).ok()?;
        Some(Self { name: first_adapter(&said)?, variables })
    }

    /// Runs these tests on it, and of the targets of `goldens` the tests whose names have the text.
    fn test(&self, summary: &mut Summary, tests: &[&str], goldens: &[(&str, &str)]) {
        println!("\n{}", self.name);
        let mut driver_summary = Summary::default();
        let mut skipped = Vec::new();
        if self.name.contains("SwiftShader") {
            skipped.extend(SLOW_ON_SWIFTSHADER.iter().flat_map(|test| ["--skip", test]));
            summary.note(&format!("on SwiftShader without {}", SLOW_ON_SWIFTSHADER.join(" and ")));
        }
        self.run(&mut driver_summary, tests, &skipped);
        for (test, text) in goldens {
            self.run(&mut driver_summary, &[test], &[text]);
        }
        summary.add(&self.name, driver_summary);
    }

    fn run(&self, driver_summary: &mut Summary, tests: &[&str], arguments: &[&str]) {
        let mut command = process::cargo(["test", "--no-fail-fast"]);
        command.args(EVERYTHING).args(tests.iter().flat_map(|test| ["--test", test])).arg("--").args(arguments);
        command.envs(self.variables.clone());
        let outcome = process::run_looking(&mut command, |line| driver_summary.read(line));
        if let Err(error) = &outcome {
            driver_summary.fail(error);
        }
        driver_summary.tests_ended(outcome.unwrap_or(false), true);
    }
}

/// Runs the tests of bits on each driver and counts them in `summary`.
pub(crate) fn add_all(summary: &mut Summary) {
    test::ensure_driver(summary);
    if let Err(error) = build() {
        summary.fail(&error);
        return;
    }
    let drivers = found();
    if drivers.is_empty() {
        summary.fail("no driver has an adapter");
    }
    for driver in drivers {
        driver.test(summary, &TESTS, &GOLDENS);
    }
}

/// Runs quick tests on `SwiftShader`, a second Vulkan driver with a compiler of its own. Where it is not there and cannot be
/// installed, a note says so.
pub(crate) fn add_swiftshader(summary: &mut Summary) {
    if swiftshader().is_none()
        && let Some(manager) = Manager::of_this_system()
        && let Err(error) = manager.install("SwiftShader", manager.swiftshader)
    {
        println!("{error}");
    }
    let driver = swiftshader().and_then(|manifest| Driver::of(by_manifest(manifest)));
    match driver {
        Some(driver) => driver.test(summary, &QUICK, &[]),
        None => summary.note("SwiftShader is not installed, so nothing ran on a second driver"),
    }
}

/// The command, which lists adapters, and the tests.
fn build() -> Result<(), String> {
    let mut build = process::cargo(["build", "--bin", "rimline"]);
    let tests = TESTS.iter().chain(GOLDENS.iter().map(|(test, _)| test));
    process::run(build.args(EVERYTHING).args(tests.flat_map(|test| ["--test", test])))
}

/// One driver for each adapter's name and backend.
fn found() -> Vec<Driver> {
    let manifests = vulkan::manifests().into_iter().chain(swiftshader());
    let candidates = manifests.map(by_manifest).chain([vec![("WGPU_BACKEND", "gl".into())]]);
    let mut names = BTreeSet::new();
    candidates.filter_map(Driver::of).filter(|driver| names.insert(driver.name.clone())).collect()
}

fn by_manifest(manifest: PathBuf) -> Vec<(&'static str, OsString)> {
    vec![("WGPU_BACKEND", "vulkan".into()), ("VK_DRIVER_FILES", manifest.into())]
}

fn swiftshader() -> Option<PathBuf> {
    BROWSERS.iter().map(|folder| Path::new(folder).join("vk_swiftshader_icd.json")).find(|path| path.exists())
}

/// Name and backend of the first adapter in what `rimline devices --json` prints.
fn first_adapter(json: &str) -> Option<String> {
    let text = |key: &str| json.split_once(&format!("\"{key}\":"))?.1.split('"').nth(1);
    Some(format!("{} ({})", text("name")?, text("backend")?))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_first_adapter_is_read() {
        let json =
            r#"{"adapters": [{"name": "llvmpipe (LLVM 15)", "backend": "Vulkan"}, {"name": "b", "backend": "Gl"}]}"#;
        assert_eq!(super::first_adapter(json).as_deref(), Some("llvmpipe (LLVM 15) (Vulkan)"));
        assert_eq!(super::first_adapter(r#"{"adapters": []}"#), None);
    }
}
