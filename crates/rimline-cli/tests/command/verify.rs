//! `rimline verify` where all is right: stress scenes and model files, the same bytes on every device.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::Path;

use libtest_mimic::{Failed, Trial};
use serde_json::Value;

use super::archive::{compare, words_of};
use super::run::{HIDDEN, folder, is_long, read_file, rimline, rimline_with, write_file};
use super::{Outcome, Test, ensure};
use rimline_models::catalogue::GOOD;
use rimline_testkit::assets;
use rimline_testkit::files::GOOD_FILES;

pub(crate) const TESTS: &[Test] = &[("verify::a_device_that_rounds_would_be_noticed", rounded)];

pub(crate) fn trials() -> Vec<Trial> {
    let no_opengl = !has_opengl();
    let trial = |name: &str, test: fn() -> Outcome| {
        Trial::test(format!("verify::{name}"), move || test().map_err(Failed::from))
    };
    vec![
        trial("every_stress_scene_is_the_same_on_every_device", stress_scenes),
        trial("built_in_scenes_have_no_wrong_bits", built_in),
        trial("the_devices_asked_for_are_checked", chosen_devices),
        trial("every_good_file_is_the_same_on_every_device", good_files),
        trial("opengl_finds_the_same_and_draws", opengl).with_ignored_flag(no_opengl),
    ]
}

fn has_opengl() -> bool {
    let adapters = rimline(["devices", "--json"]).json();
    adapters.is_ok_and(|json| {
        let adapters = json["adapters"].as_array().cloned().unwrap_or_default();
        adapters.iter().any(|adapter| adapter["backend"] == "OpenGL" && adapter["usable"] == true)
    })
}

/// Writes a folder to check.
fn make(folder: &Path, options: &[&OsStr]) -> Outcome {
    let line = ["verify".as_ref(), "--make".as_ref(), folder.as_os_str()];
    rimline(line.iter().chain(options)).expect(0, &[])
}

/// Checks a folder and returns the JSON. The command must end with the exit code `code`.
fn check(folder: &Path, options: &[&str], code: i32) -> Result<Value, String> {
    let line = ["verify".as_ref(), folder.as_os_str(), "--json".as_ref()];
    let run = rimline(line.into_iter().chain(options.iter().map(AsRef::as_ref)));
    run.expect(code, &[])?;
    serde_json::from_str(&run.stdout).map_err(|error| format!("{error} in: {}", run.stdout))
}

/// A folder's files.
fn contents(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| error.to_string())?;
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry?;
        Ok((entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path())?))
    };
    entries.map(read).collect::<std::io::Result<_>>().map_err(|error| error.to_string())
}

/// Everything equal, each of `files` files on each device.
fn all_equal(json: &Value, files: usize, devices: usize) -> Outcome {
    ensure!(json["equal"] == true, "not equal: {json:#}");
    let list = json["files"].as_array().ok_or("no files")?;
    ensure!(list.len() == files, "{} files instead of {files}", list.len());
    for file in list {
        let results = file["results"].as_array().ok_or("no results")?;
        ensure!(results.len() == devices && results.iter().all(|result| result["equal"] == true), "{file:#}");
        ensure!(file["lights"].as_u64() > Some(32), "not two batches of lights: {file:#}");
    }
    Ok(())
}

fn devices(json: &Value) -> Vec<String> {
    let list = json["devices"].as_array().cloned().unwrap_or_default();
    list.iter().map(|name| name.as_str().unwrap_or_default().to_owned()).collect()
}

fn built_in() -> Outcome {
    let json = rimline(["verify", "--built-in", "--json"]).json()?;
    ensure!(json["equal"] == true, "{json:#}");
    for device in json["devices"].as_array().filter(|list| !list.is_empty()).ok_or("no devices")? {
        let scenes = device["scenes"].as_array().ok_or("no scenes")?;
        // The viewer's are a figure, five shapes and a band.
        ensure!(scenes.len() == rimline_testkit::stress::names().len() + 7, "{} scenes", scenes.len());
        ensure!(scenes.iter().all(|scene| scene["wrong_bits"] == 0 && scene["pairs"].as_u64() > Some(0)), "{device:#}");
    }
    Ok(())
}

fn stress_scenes() -> Outcome {
    let folder = folder();
    let [by_cpu, by_gpu] = ["cpu", "gpu"].map(|name| folder.path().join(name));
    let faces = if is_long() { "100000" } else { "2000" };
    make(&by_cpu, &["--faces".as_ref(), faces.as_ref()])?;
    make(&by_gpu, &["--faces".as_ref(), faces.as_ref(), "--device".as_ref(), "gpu".as_ref()])?;
    let (cpu, gpu) = (contents(&by_cpu)?, contents(&by_gpu)?);
    let scenes = rimline_testkit::stress::names().len();
    ensure!(cpu.len() == scenes && cpu.keys().eq(gpu.keys()), "{:?} and {:?}", cpu.keys(), gpu.keys());
    for (name, bytes) in &cpu {
        compare(bytes, &gpu[name]).map_err(|error| format!("{name}: {error}"))?;
    }
    let json = check(&by_cpu, &[], 0)?;
    let devices = devices(&json);
    ensure!(devices.len() > 1 && devices.last().is_some_and(|name| name == "cpu"), "no GPU: {devices:?}");
    println!("{scenes} scenes of about {faces} faces on {devices:?}");
    all_equal(&json, scenes, devices.len())
}

/// A folder with the largest of the small stress scenes alone; its bytes.
fn one_file(folder: &Path, name: &str) -> Result<Vec<u8>, String> {
    let (made, wanted) = (folder.join("made"), folder.join("one"));
    make(&made, &["--faces".as_ref(), "50".as_ref()])?;
    std::fs::create_dir(&wanted).map_err(|error| error.to_string())?;
    let bytes = contents(&made)?.into_values().max_by_key(Vec::len).ok_or("nothing was made")?;
    write_file(wanted.join(name), &bytes)?;
    Ok(bytes)
}

fn chosen_devices() -> Outcome {
    let folder = folder();
    one_file(folder.path(), "one.npz")?;
    let one = folder.path().join("one");
    let all = devices(&check(&one, &[], 0)?);
    let gpus = devices(&check(&one, &["--device", "gpu"], 0)?);
    ensure!(all.len() > 1 && all[..all.len() - 1] == gpus && all[all.len() - 1] == "cpu", "{all:?} and {gpus:?}");
    let named = devices(&check(&one, &["--device", &gpus[0].to_uppercase()], 0)?);
    ensure!(named.contains(&gpus[0]), "{named:?}");
    for (device, names, gpu) in
        [("all", &all[..], true), ("gpu", &gpus[..], true), ("cpu", &all[all.len() - 1..], false)]
    {
        let run = rimline(["verify".as_ref(), one.as_os_str(), "--device".as_ref(), device.as_ref()]);
        run.expect(0, &[])?;
        for part in ["All equal: 1 file on", "one.npz"].into_iter().chain(names.iter().map(String::as_str)) {
            ensure!(run.stdout.contains(part), "{device}: the table lacks `{part}`: {}", run.stdout);
        }
        ensure!(run.stdout.contains("No GPU was checked") != gpu, "{device}: {}", run.stdout);
    }
    let without = |options: &[&str]| {
        let line = ["verify".as_ref(), one.as_os_str()];
        rimline_with(line.into_iter().chain(options.iter().map(AsRef::<OsStr>::as_ref)), HIDDEN)
    };
    let run = without(&[]);
    run.expect(0, &[])?;
    ensure!(run.stdout.contains("No GPU was checked"), "{}", run.stdout);
    without(&["--device", "gpu"]).expect(3, &["no GPU was found"])
}

fn good_files() -> Outcome {
    let folder = folder();
    let catalogue = folder.inner("catalogue")?;
    let made = GOOD.iter().map(|good| good.write(&catalogue)).collect::<Result<Vec<_>, _>>();
    let mut models = made.map_err(|error| error.to_string())?;
    models.extend(assets().into_iter().flat_map(|folder| GOOD_FILES.map(|file| folder.join(file))));
    let made = folder.path().join("made");
    let options: Vec<&OsStr> = models.iter().map(AsRef::as_ref).chain(["--faces".as_ref(), "12".as_ref()]).collect();
    make(&made, &options)?;
    let files = contents(&made)?.len();
    ensure!(files > models.len() + rimline_testkit::stress::names().len(), "some are posed twice, but {files} files");
    let json = check(&made, &[], 0)?;
    all_equal(&json, files, devices(&json).len())
}

fn opengl() -> Outcome {
    let folder = folder();
    one_file(folder.path(), "one.npz")?;
    let one = folder.path().join("one");
    let json = check(&one, &["--device", "opengl"], 0)?;
    let devices = devices(&json);
    ensure!(!devices.is_empty() && devices.iter().all(|name| name.contains("OpenGL")), "{devices:?}");
    all_equal(&json, 1, devices.len())?;
    let (model, picture) = (one.join("one.npz"), folder.path().join("picture.png"));
    let line = ["draw".as_ref(), model.as_os_str(), "--device".as_ref(), "opengl".as_ref(), "--out".as_ref()];
    rimline(line.into_iter().chain([picture.as_os_str()])).expect(0, &[])?;
    ensure!(picture.exists(), "no picture");
    // Mesa can be told to offer less, and then it is said what is missing.
    let less = [("MESA_GL_VERSION_OVERRIDE", "4.2"), ("MESA_EXTENSION_OVERRIDE", "-GL_ARB_compute_shader")];
    let shown = rimline_with(["devices"], &less);
    if shown.stdout.contains("it lacks compute shaders") {
        let run = rimline_with(["verify".as_ref(), one.as_os_str()], &less);
        run.expect(0, &[])?;
        ensure!(run.stdout.contains("cannot be used: it lacks compute shaders"), "{}", run.stdout);
        let line = ["verify".as_ref(), one.as_os_str(), "--device".as_ref(), "opengl".as_ref()];
        rimline_with(line, &less).expect(3, &["OpenGL", "it lacks compute shaders"])?;
    } else {
        println!("this OpenGL offers compute shaders whatever it is told, so their lack was not tried");
    }
    Ok(())
}

/// Bits that `f32` arithmetic finds, as a device that is not exact would.
fn rounded() -> Outcome {
    let folder = folder();
    let [made, one] = ["made", "one"].map(|name| folder.path().join(name));
    make(&made, &["--faces".as_ref(), "500".as_ref()])?;
    std::fs::create_dir(&one).map_err(|error| error.to_string())?;
    let plate = made.join("stress-plate-all.npz");
    let lights: Vec<f32> = words_of(&read_file(&plate)?, "lights")?.into_iter().map(f32::from_bits).collect();
    let specs = lights.chunks(4).map(|l| format!("--light=hom:{:?},{:?},{:?},{:?}", l[0], l[1], l[2], l[3]));
    let specs: Vec<String> = specs.collect();
    for (predicate, code) in [("exact", 0), ("fast", 5)] {
        let out = one.join("one.npz");
        let mut line = vec!["extract".as_ref(), plate.as_os_str(), "--no-weld".as_ref(), "--out".as_ref()];
        line.extend([out.as_os_str(), "--device".as_ref(), "cpu".as_ref(), "--predicate".as_ref(), predicate.as_ref()]);
        rimline(line.into_iter().chain(specs.iter().map(AsRef::as_ref))).expect(0, &[])?;
        let json = check(&one, &[], code)?;
        for result in json["files"][0]["results"].as_array().ok_or("no results")? {
            let arrays = result["differences"].as_array().ok_or("no differences")?;
            let has_facing = arrays.iter().any(|difference| difference["array"] == "facing");
            ensure!(has_facing == (predicate == "fast"), "{predicate}: {result:#}");
        }
    }
    Ok(())
}
