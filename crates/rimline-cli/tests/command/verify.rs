//! `rimline verify` of model files, the same bytes on every device; and OpenGL. Other cases are in data/verify.txt.

use std::sync::OnceLock;

use libtest_mimic::{Failed, Trial};
use rimline_models::catalogue::GOOD;
use rimline_testkit::assets;
use rimline_testkit::files::GOOD_FILES;
use serde_json::Value;

use super::makers::tetrahedron;
use super::run::{folder, is_long, rimline};
use super::{Outcome, ensure};

/// Checked only in long trials: the largest, but for the scallop of 120,000 faces, which is always checked.
const LARGE: [&str; 3] = ["FlightHelmet.glb", "SheenCloth.glb", "spot_catmull_big.glb"];

pub(crate) fn trials() -> Vec<Trial> {
    let good =
        Trial::test("verify::every_good_file_is_the_same_on_every_device", || good_files().map_err(Failed::from));
    let opengl = Trial::test("verify::opengl_finds_the_same_and_draws", || opengl().map_err(Failed::from));
    vec![good, opengl.with_ignored_flag(!has_opengl())]
}

/// Whether `rimline devices` finds OpenGL usable. Asks once, because the command draws a trial picture on every adapter.
pub(crate) fn has_opengl() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let devices = rimline(["devices", "--json"]).json().unwrap_or_default();
        let is_usable = |adapter: &Value| adapter["backend"] == "OpenGL" && adapter["usable"] == true;
        devices["adapters"].as_array().is_some_and(|adapters| adapters.iter().any(is_usable))
    })
}

fn good_files() -> Outcome {
    let folder = folder();
    let catalogue = folder.inner("catalogue")?;
    let made = GOOD.iter().map(|good| good.write(&catalogue)).collect::<Result<Vec<_>, _>>();
    let mut models = made.map_err(|error| error.to_string())?;
    let real = GOOD_FILES.into_iter().filter(|file| is_long() || !LARGE.contains(file));
    models.extend(assets().into_iter().flat_map(|folder| real.clone().map(move |file| folder.join(file))));
    let made = folder.path().join("made");
    let line = ["verify".as_ref(), "--make".as_ref(), made.as_os_str(), "--faces=12".as_ref()];
    rimline(line.into_iter().chain(models.iter().map(AsRef::as_ref))).expect(0, &[])?;
    let json = folder.run("verify @made --json").json()?;
    let [files, devices] = ["files", "devices"].map(|key| json[key].as_array().map_or(0, Vec::len));
    let scenes = rimline_testkit::stress::names().len();
    ensure!(devices > 1, "no GPU was checked");
    // A model with an animation has a second file, posed within it.
    let posed = GOOD.iter().filter(|good| good.parts[3] > 0).count();
    ensure!(files >= models.len() + scenes + posed, "{files} files of {} models and {scenes} scenes", models.len());
    for file in json["files"].as_array().ok_or("no files")? {
        let results = file["results"].as_array().ok_or("no results")?;
        ensure!(results.len() == devices && results.iter().all(|result| result["equal"] == true), "{file:#}");
        ensure!(file["lights"].as_u64() > Some(32), "not two batches of lights: {file:#}");
    }
    Ok(())
}

fn opengl() -> Outcome {
    let folder = folder();
    folder.inner("one")?;
    folder.write("m.npz", tetrahedron())?;
    folder
        .run("extract @m.npz --device cpu --light point:1,2,3 --light dir:1,0,2 --out @one/one.npz")
        .expect(0, &[])?;
    let found = folder.run("verify @one --device opengl");
    found.expect(0, &[])?;
    ensure!(found.stdout.contains("OpenGL"), "{}", found.stdout);
    folder.run("draw @m.npz --device opengl --out @p.png").expect(0, &[])?;
    // Variables make Mesa offer less. The command then says what is missing.
    let less = [("MESA_GL_VERSION_OVERRIDE", "4.2"), ("MESA_EXTENSION_OVERRIDE", "-GL_ARB_compute_shader")];
    let with_less = |words: &[&str]| super::run::rimline_with(words, &less);
    if !with_less(&["devices"]).stdout.contains("it lacks compute shaders") {
        println!("this OpenGL offers compute shaders whatever it is told, so their lack was not tried");
        return Ok(());
    }
    let one = folder.path().join("one").to_string_lossy().into_owned();
    let found = with_less(&["verify", &one]);
    found.expect(0, &[])?;
    ensure!(found.stdout.contains("cannot be used: it lacks compute shaders"), "{}", found.stdout);
    with_less(&["verify", &one, "--device", "opengl"]).expect(3, &["OpenGL", "it lacks compute shaders"])
}
