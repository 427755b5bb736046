//! Where results go: over no input, through links, pipes and devices, whatever killed runs left behind.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::Path;

use super::npz_input::tetrahedron;
use super::own_gltf::{self, Names};
use super::run::{Run, folder, rimline, rimline_with, write_file};
use super::usage::HIDDEN;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("outputs::names_of_other_formats_are_refused", endings),
    ("outputs::a_film_spares_pictures_of_a_longer_one", longer_film),
    ("outputs::a_film_replaces_its_own_pictures", same_film),
    ("outputs::verify_leaves_no_empty_folder", empty_folder),
    ("outputs::a_report_leaves_no_empty_folders", empty_report),
    ("outputs::a_folder_is_no_file", folder_name),
];

/// Contents of a folder by name; empty for an entry that is no regular file.
pub(crate) fn contents(folder: &Path) -> Result<BTreeMap<OsString, Vec<u8>>, String> {
    let mut contents = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(|error| error.to_string())? {
        let entry = entry.map_err(|error| error.to_string())?;
        let is_file = entry.metadata().is_ok_and(|there| there.is_file());
        contents.insert(entry.file_name(), if is_file { fs::read(entry.path()).unwrap_or_default() } else { vec![] });
    }
    Ok(contents)
}

/// The tetrahedron in a folder, and what to extract from it on the CPU.
pub(crate) fn extraction(folder: &Path, out: &Path) -> Result<Vec<OsString>, String> {
    let model = folder.join("model.npz");
    write_file(&model, tetrahedron())?;
    let line = ["extract", "--device", "cpu", "--light", "dir:0,1,0", "--out"].map(OsString::from);
    Ok(line.into_iter().chain([out.into(), model.into()]).collect())
}

/// Ends with this code and message, and leaves the folder as it was.
pub(crate) fn refused(folder: &Path, code: i32, parts: &[&str], run: impl FnOnce() -> Run) -> Outcome {
    let before = contents(folder)?;
    run().expect(code, parts)?;
    ensure!(contents(folder)? == before, "the folder is not as it was: {:?}", contents(folder)?.keys());
    Ok(())
}

fn endings() -> Outcome {
    let folder = folder();
    let model = own_gltf::write(folder.path(), &Names::default())?.to_string_lossy().into_owned();
    let light = ["--light", "dir:0,1,0"];
    let cases: [(&str, &str, &[&str]); 8] = [
        ("draw", "x.jpg", &["x.jpg", ".png"]),
        ("draw", "x.JPEG", &[".png"]),
        ("draw", "x.npz", &[".png"]),
        ("shadow", "x.webp", &[".png"]),
        ("extract", "x.png", &[".npz"]),
        ("extract", "x.glb", &[".npz"]),
        ("film", "model.mp4", &["model.mp4", "folder"]),
        ("film", "model.gif", &["folder"]),
    ];
    for (command, out, parts) in cases {
        let out = folder.path().join(out).to_string_lossy().into_owned();
        let options = if command == "extract" { &light[..] } else { &[] };
        let line = [command, &model, "--out", &out].into_iter().chain(options.iter().copied());
        refused(folder.path(), 2, parts, || rimline(line)).map_err(|error| format!("{command} {out}: {error}"))?;
    }
    // An ending that belongs to no format is a part of the name.
    let line = extraction(folder.path(), &folder.path().join("v1.2"))?;
    rimline(line).expect(0, &[])
}

/// Two pictures of the moving tetrahedron; with further options.
fn film(folder: &Path, out: &Path, frames: &str, variables: &[(&str, &str)]) -> Result<Run, String> {
    let model = own_gltf::write(folder, &Names::default())?;
    let line = ["film", "--size", "32x24", "--frames", frames, "--out"].map(OsString::from);
    Ok(rimline_with(line.into_iter().chain([out.into(), model.into()]), variables))
}

fn longer_film() -> Outcome {
    let folder = folder();
    let out = folder.path().join("frames");
    for (earlier, frames) in [("0002.png", "2"), ("0731.png", "2"), ("00001.png", "2"), ("0001.png", "1")] {
        fs::create_dir(&out).map_err(|error| error.to_string())?;
        for name in ["0000.png", "notes.txt", "12.png", earlier] {
            write_file(out.join(name), "earlier")?;
        }
        refused(&out, 2, &[earlier, "remove"], || film(folder.path(), &out, frames, HIDDEN).expect("there is room"))
            .map_err(|error| format!("{earlier}: {error}"))?;
        fs::remove_dir_all(&out).map_err(|error| error.to_string())?;
    }
    Ok(())
}

fn same_film() -> Outcome {
    let folder = folder();
    let out = folder.path().join("frames");
    for _ in 0..2 {
        film(folder.path(), &out, "2", &[])?.expect(0, &[])?;
        let names: Vec<_> = contents(&out)?.into_keys().collect();
        ensure!(names == ["0000.png", "0001.png"], "{names:?}");
    }
    Ok(())
}

fn empty_folder() -> Outcome {
    let folder = folder();
    let bits = folder.path().join("bits");
    let line = ["verify", "--make", "--device", "no such adapter", "--faces", "8"].map(OsString::from);
    refused(folder.path(), 3, &["no such adapter"], || rimline(line.into_iter().chain([bits.clone().into()])))?;
    // A model that cannot be read.
    let line = ["verify", "--make", "--device", "cpu"].map(OsString::from);
    let run = rimline(line.into_iter().chain([bits.into(), folder.path().join("missing.npz").into()]));
    refused(folder.path(), 1, &["missing.npz"], || run)
}

fn empty_report() -> Outcome {
    let folder = folder();
    let line = ["bench", "--device", "no such adapter", "--report"].map(OsString::from);
    let report = folder.path().join("a/b/report");
    refused(folder.path(), 3, &["no such adapter"], || rimline(line.into_iter().chain([report.into()])))
}

fn folder_name() -> Outcome {
    let folder = folder();
    let mut out = folder.path().join("new").into_os_string();
    out.push("/");
    let line = extraction(folder.path(), Path::new(&out))?;
    refused(folder.path(), 4, &["folder"], || rimline(line))
}
