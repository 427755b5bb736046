//! Cases, oracles and devices that Rimline's tests share. Nothing here is part of the library, and it is not published.
#![allow(clippy::missing_errors_doc, clippy::missing_panics_doc, reason = "comparators fail and panic by design")]
#![allow(missing_docs, reason = "fields of fixtures say by their names what they are")]

pub mod band;
pub mod cases;
pub mod choices;
pub mod cluster_cases;
pub mod cluster_meshes;
pub mod clusters;
pub mod device;
pub mod dispatch;
pub mod files;
pub mod frame_classes;
pub mod frames;
pub mod goldens;
#[cfg(feature = "harness")]
pub mod harness;
pub mod models;
pub mod mutate;
pub mod on_gpu;
mod one_caster;
pub mod oracle;
pub mod pairs;
pub mod passes;
pub mod polygon_oracle;
pub mod polygons;
pub mod poser;
pub mod predicates;
pub mod probe;
pub mod range_cases;
pub mod refusals;
pub mod scenes;
pub mod shadow_cases;
pub mod shadow_oracle;
pub mod shells;
pub mod stage_probe;
pub mod textures;
pub mod turns;

pub use one_caster::{OneCaster, OneFrame};
pub use rimline_bench::record::{IDENTITY, made_anew};
pub use rimline_bench::{error_metrics, pipelines, random, rays, shapes, slivers, stress};

use std::path::PathBuf;

use rimline::Light;

/// The folder of model files beside the checkout, if it is there.
pub fn assets() -> Option<PathBuf> {
    let folder = std::env::var_os("RIMLINE_ASSETS")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets"), PathBuf::from);
    folder.is_dir().then_some(folder)
}

/// The folder of small files after public reports, which is beside that of the models, if it is there.
pub fn shared_cases() -> Option<PathBuf> {
    assets().map(|folder| folder.with_file_name("cases")).filter(|folder| folder.is_dir())
}

/// Fails with the first index at which two slices differ, and their number.
pub fn same<T: PartialEq + std::fmt::Debug>(what: &str, got: &[T], expected: &[T]) -> Result<(), String> {
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
pub fn lights(random: &mut random::Random, count: usize) -> Vec<Light> {
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

/// Any finite number, by its bits.
pub(crate) fn any_finite(random: &mut random::Random) -> f32 {
    loop {
        let value = f32::from_bits(random.next_u64() as u32);
        if value.is_finite() {
            return value;
        }
    }
}

/// A negative control: a comparator must not pass what was perturbed.
pub fn must_fail<T>(what: &str, outcome: &Result<T, String>) -> Result<(), String> {
    match outcome {
        Ok(_) => Err(format!("negative control: {what} went unnoticed")),
        Err(_) => Ok(()),
    }
}

/// Whether the heavier counts were asked for, `RIMLINE_LONG=1`.
pub fn is_long() -> bool {
    std::env::var_os("RIMLINE_LONG").is_some_and(|value| value == "1")
}
