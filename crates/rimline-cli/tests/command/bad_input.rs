//! Model files that are bad by design: a typed error with its place, no panic, no result.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_models::catalogue::{BAD, Fate};
use rimline_testkit::assets;
use rimline_testkit::harness::{on_files, on_made};

use super::run::{folder, is_empty, rimline};
use super::{Outcome, ensure};

const FILES: &[&str] = &[
    "bad/BoxDraco.gltf",
    "bad/IndexOutOfRange.gltf",
    "bad/chunk_too_big.glb",
    "bad/index_buffer_oob.gltf",
    "bad/indices_invalid_format.gltf",
    "bad/invalid_json_chunk.glb",
    "bad/missing_bin/missing_bin.gltf",
    "bad/morph_attribute_invalid_count.gltf",
    "bad/node_loop.gltf",
    "bad/own_box_truncated.glb",
    "bad/position_accessor_invalid_format.gltf",
    "bad/truncated_chunk_data.glb",
    "bad/unresolved_positions.gltf",
];

/// Files of whose scene nothing is left: `info` describes them with a warning.
const EMPTY: &[&str] = &[
    "bad/bufferview_invalid_length.gltf",
    "bad/ibm_invalid_count.gltf",
    "bad/invalid-buffer-view-index.gltf",
    "bad/joints_weights_complex.gltf",
    "bad/primitive_no_position.gltf",
];

/// Files with a warning: the error is in nothing that is drawn, or the file can be read all the same.
const WARNED: &[&str] = &[
    "bad/BoxWithInfinites.glb",
    "bad/badUint.gltf",
    "bad/index_buffer_primitive_restart.gltf",
    "bad/own_box_nan_position.glb",
];

pub(crate) fn trials() -> Vec<Trial> {
    let mut trials = on_made("bad_input::", BAD.iter().map(|bad| bad.name), |file| {
        match BAD.iter().find(|bad| file.ends_with(bad.name)).ok_or("no row")?.fate {
            Fate::Refused => refused(file),
            Fate::Empty => empty(file),
            Fate::Warned => warned(file),
        }
    });
    trials.extend(on_files("bad_input::", assets(), &[FILES, EMPTY, WARNED].concat(), |file| {
        let is_of = |files: &[&str]| files.iter().any(|name| file.ends_with(name));
        if is_of(FILES) {
            refused(file)
        } else if is_of(EMPTY) {
            empty(file)
        } else {
            warned(file)
        }
    }));
    trials
}

fn warned(file: &Path) -> Outcome {
    let folder = folder();
    let out = folder.path().join("out.npz");
    let line = ["extract", "--light", "dir:0,1,0", "--device", "cpu", "--out"].map(AsRef::as_ref);
    let run = rimline(line.into_iter().chain([out.as_os_str(), file.as_os_str()]));
    run.expect(0, &["rimline: warning: ", &file.display().to_string()])?;
    ensure!(out.is_file(), "there is no result");
    Ok(())
}

const EXTRACT: &[&str] = &["extract", "--light", "dir:0,1,0", "--device", "cpu"];

fn empty(file: &Path) -> Outcome {
    rimline(["info".as_ref(), file.as_os_str()]).expect(0, &["rimline: warning: "])?;
    refused_by(file, &[EXTRACT, &["draw"]])
}

fn refused(file: &Path) -> Outcome {
    refused_by(file, &[EXTRACT, &["draw"], &["info"]])
}

fn refused_by(file: &Path, options: &[&[&str]]) -> Outcome {
    let folder = folder();
    let model = file.as_os_str();
    let out = folder.path().join("out");
    for options in options {
        let mut line: Vec<_> = options.iter().map(AsRef::as_ref).collect();
        line.push(model);
        if options[0] != "info" {
            line.extend(["--out".as_ref(), out.as_os_str()]);
        }
        let run = rimline(line);
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        run.expect(1, &["rimline: error: ", &name])?;
        // The place: something after the file's name.
        let detail = run.stderr.rsplit_once(&format!("{name}: ")).map_or("", |(_, detail)| detail.trim());
        ensure!(detail.len() > 20, "the message says too little: {}", run.stderr);
    }
    is_empty(folder.path())
}
