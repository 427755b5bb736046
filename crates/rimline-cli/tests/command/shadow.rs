//! Good models have a picture and a mask.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_testkit::assets;
use rimline_testkit::harness::{on_files, on_made, on_models};

use super::pictures::Image;
use super::run::{folder, is_long, rimline};
use super::{Outcome, ensure};

/// Files that differ in how they are drawn: many parts, a skin, flat, no sides, a whole scene. The others run if long trials
/// are wanted.
const DRAWN: [&str; 5] = [
    "CesiumMilkTruck_quantized.glb",
    "Fox.glb",
    "SimpleSparseAccessor.gltf",
    "moebius.glb",
    "subpass_scene_opaque.gltf",
];

/// The same of the catalogue.
const MADE: [&str; 5] = ["quantized.glb", "skinned.glb", "sparse.gltf", "one_sided.glb", "mirrored_scenes.gltf"];

pub(crate) fn trials() -> Vec<Trial> {
    if is_long() {
        return on_models("shadow_models::", any_model);
    }
    let mut trials = on_made("shadow_models::", MADE, any_model);
    trials.extend(on_files("shadow_models::", assets(), &DRAWN, any_model));
    trials
}

fn any_model(file: &Path) -> Outcome {
    let folder = folder();
    let out = ["p.png", "m"].map(|name| folder.path().join(name).into_os_string());
    let [picture, mask] = &out;
    let line = ["shadow".as_ref(), file.as_os_str(), "--size=96x72".as_ref(), "--out".as_ref(), picture];
    rimline(line.into_iter().chain(["--mask".as_ref(), mask.as_os_str()])).expect(0, &[])?;
    let picture = Image::read(Path::new(picture))?;
    ensure!(picture.bytes.iter().any(|&value| value != picture.bytes[0]), "an empty picture");
    let mask = folder.mask("m.0.png")?;
    ensure!(mask.count(0) > 20 && mask.count(255) > 20, "{} dark, {} lit pixels", mask.count(0), mask.count(255));
    Ok(())
}
