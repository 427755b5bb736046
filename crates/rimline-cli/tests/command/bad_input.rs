//! Model files that are bad by design: a typed error with its place, no panic, no result.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_models::catalogue::{BAD, Fate};
use rimline_testkit::harness::on_made;

use super::run::{folder, is_empty, rimline};
use super::{Outcome, ensure};

/// Files of each fate, refused by what they hold and by what they lack. `tests/gltf/bad.rs` has all.
const FILES: [&str; 6] =
    ["draco.glb", "truncated.glb", "missing_bin.gltf", "view_too_long_unshown.glb", "no_position.glb", "nan.glb"];

pub(crate) fn trials() -> Vec<Trial> {
    on_made("bad_input::", FILES, |file| match BAD.iter().find(|bad| file.ends_with(bad.name)).ok_or("no row")?.fate {
        Fate::Refused => refused(file),
        Fate::Empty => empty(file),
        Fate::Warned => warned(file),
    })
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
