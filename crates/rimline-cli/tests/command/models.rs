//! Model files of each kind: devices agree on the same positions, and every outline closes.

use std::path::Path;

use libtest_mimic::Trial;

use super::archive::compare;
use super::run::{folder, is_long, read_file, rimline};
use super::{Outcome, ensure};
use rimline_testkit::assets;
use rimline_testkit::harness::{on_both, on_files, on_made, on_models};

/// In turn: open, of many parts; moved by a skin and morph targets; quantized; moved by a skin, by nodes, by morph targets;
/// sparse; without sides; a strip of triangles. Files of the same kinds run if long trials are wanted; the library extracts
/// and poses all of them, and `verify` holds all of them against both devices.
const KINDS: [&str; 9] = [
    "AntiqueCamera.glb",
    "CesiumMan_8influences_morph.glb",
    "CesiumMilkTruck_quantized.glb",
    "Fox.glb",
    "InterpolationTest.glb",
    "MorphStressTest.gltf",
    "SimpleSparseAccessor.gltf",
    "moebius.glb",
    "primitive_modes/Mesh_PrimitiveMode_05.gltf",
];

/// The same of the catalogue.
const MADE: [&str; 9] = [
    "parts.glb",
    "skinned_twice_morphed.glb",
    "quantized.glb",
    "skinned_without_indices.glb",
    "interpolations.glb",
    "morphed.gltf",
    "sparse.gltf",
    "sheets.glb",
    "colours_and_modes.glb",
];

pub(crate) fn trials() -> Vec<Trial> {
    let animated = ["skinned_without_indices.glb", "Fox.glb"];
    let mut trials = vec![on_both("models::a_film_plays_the_first_animation", animated, first_animation)];
    if is_long() {
        trials.extend(on_models("models::", agrees_and_closes));
        return trials;
    }
    trials.extend(on_made("models::", MADE, agrees_and_closes));
    trials.extend(on_files("models::", assets(), &KINDS, agrees_and_closes));
    trials
}

const LIGHTS: [&str; 4] = ["--light", "point:3,-5,2e0", "--light", "dir:-.3,1,.2"];

fn agrees_and_closes(file: &Path) -> Outcome {
    let folder = folder();
    let out = |name: &str| folder.path().join(name);
    let extract = |model: &Path, name: &str, options: &[&str]| -> Result<(serde_json::Value, Vec<u8>), String> {
        let target = out(name);
        let mut line = vec!["extract".as_ref(), model.as_os_str(), "--json".as_ref()];
        line.extend(["--out".as_ref(), target.as_os_str()]);
        line.extend(LIGHTS.iter().chain(options).map(AsRef::<std::ffi::OsStr>::as_ref));
        let json = rimline(line).json().map_err(|error| format!("{options:?}: {error}"))?;
        Ok((json, read_file(&target)?))
    };
    let animated = rimline(["info".as_ref(), file.as_os_str(), "--json".as_ref()]).json()?["animations"]
        .as_array()
        .is_some_and(|animations| !animations.is_empty());
    let moment: &[&str] = if animated { &["--animation", "0", "--time", "0.37"] } else { &[] };
    let (json, on_gpu) = extract(file, "gpu.npz", &[moment, &["--device", "gpu"]].concat())?;
    ensure!(json["unclosed_vertices"] == serde_json::json!([0, 0]), "{json}");
    extract(file, "cpu.npz", &[moment, &["--device", "cpu"]].concat())?;
    // The same positions, so the same bits, whoever finds them.
    for device in ["gpu", "cpu"] {
        let (again, kept) = extract(&out("gpu.npz"), "kept.npz", &["--no-weld", "--device", device])?;
        compare(&on_gpu, &kept).map_err(|error| format!("{device}: {error}"))?;
        for key in ["faces", "edges", "silhouette_edges", "unclosed_vertices", "non_finite_faces"] {
            ensure!(json[key] == again[key], "{device}, {key}: {} and {}", json[key], again[key]);
        }
    }
    Ok(())
}

fn first_animation(file: &Path) -> Outcome {
    let folder = folder();
    let model = folder.path().join(file.file_name().ok_or("no name")?);
    std::fs::copy(file, &model).map_err(|error| error.to_string())?;
    let name = model.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let film = |out: &str| folder.run(&format!("film @{name} --size 64x48 --fps 1 --out @{out}"));
    film("first").expect(0, &["0 `Survey`", "2 `Run`", "--animation"])?;
    film("named --animation Survey").expect(0, &[])?;
    for frame in ["0000.png", "0002.png"] {
        let [first, named] = ["first", "named"].map(|film| folder.image(format!("{film}/{frame}")));
        ensure!(first?.bytes == named?.bytes, "{frame} shows something else than the first animation");
    }
    Ok(())
}
