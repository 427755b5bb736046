//! Every good model file: devices agree on the same positions, and every outline closes.

use std::path::Path;

use libtest_mimic::Trial;

use super::archive::compare;
use super::run::{folder, on_asset, rimline};
use super::{Outcome, ensure};
use rimline_measure::files::GOOD_FILES;

pub(crate) fn trials() -> Vec<Trial> {
    GOOD_FILES.iter().map(|file| on_asset("models", file, agrees_and_closes)).collect()
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
        Ok((json, std::fs::read(&target).map_err(|error| error.to_string())?))
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
