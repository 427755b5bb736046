//! What tests share: a seeded generator, comparators, files.

#![allow(dead_code, reason = "each test binary uses its part")]

pub(crate) mod band;
pub(crate) mod cases;
pub(crate) mod device;
pub(crate) mod files;
pub(crate) mod models;
pub(crate) mod oracle;
pub(crate) mod predicates;
pub(crate) mod random;
pub(crate) mod scenes;
pub(crate) mod shadow_cases;
pub(crate) mod shadow_oracle;

use std::path::PathBuf;

use rimline::Light;

/// The folder of model files beside the checkout, if it is there.
pub(crate) fn assets() -> Option<PathBuf> {
    let folder = std::env::var_os("RIMLINE_ASSETS")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/assets"), PathBuf::from);
    folder.is_dir().then_some(folder)
}

/// Fails with the first place at which two slices differ, and how many there are.
pub(crate) fn same<T: PartialEq + std::fmt::Debug>(what: &str, got: &[T], expected: &[T]) -> Result<(), String> {
    if got.len() != expected.len() {
        return Err(format!("{what}: {} items, expected {}", got.len(), expected.len()));
    }
    let mut different = (0..got.len()).filter(|&i| got[i] != expected[i]);
    match different.next() {
        None => Ok(()),
        Some(i) => Err(format!(
            "{what}: item {i} is {:?}, expected {:?}; {} of {} differ",
            got[i],
            expected[i],
            1 + different.count(),
            got.len()
        )),
    }
}

/// `count` lights around a mesh of about unit size: points near and far, directions, other weights.
pub(crate) fn lights(random: &mut random::Random, count: usize) -> Vec<Light> {
    (0..count)
        .map(|index| {
            let [x, y, z] = random.direction().map(|c| c * random.between(0.1, 6.0));
            match index % 4 {
                0 | 3 => Light::point([x, y, z]),
                1 => Light::directional([x, y, z]),
                _ => Light::homogeneous([x, y, z, random.between(0.2, 3.0)]),
            }
        })
        .collect()
}

/// A negative control: a comparator must not pass what was perturbed.
pub(crate) fn must_fail<T>(what: &str, outcome: &Result<T, String>) -> Result<(), String> {
    match outcome {
        Ok(_) => Err(format!("negative control: {what} went unnoticed")),
        Err(_) => Ok(()),
    }
}

/// Whether the heavier counts were asked for, `RIMLINE_LONG=1`.
pub(crate) fn is_long() -> bool {
    std::env::var_os("RIMLINE_LONG").is_some_and(|value| value == "1")
}
