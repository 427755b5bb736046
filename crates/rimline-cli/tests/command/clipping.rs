//! A driver that clips slivers wrongly is named, and shadows do without its clipping. Tried on `SwiftShader` where it is
//! installed; `RIMLINE_SWIFTSHADER` names its manifest if it is elsewhere.

use std::path::Path;

use libtest_mimic::{Failed, Trial};
use rimline_testkit::assets;
use rimline_testkit::harness::on_files;
use serde_json::Value;

use super::pictures::Image;
use super::run::{folder, is_long, rimline, rimline_with};
use super::{Outcome, ensure};

pub(crate) fn trials() -> Vec<Trial> {
    let trial = |name: &str, test: fn() -> Outcome| {
        Trial::test(format!("clipping::{name}"), move || test().map_err(Failed::from))
    };
    let no_driver = manifest().is_none();
    let mut trials = vec![
        trial("lavapipe_clips_rightly", lavapipe),
        trial("swiftshader_is_named_if_it_clips_wrongly", named).with_ignored_flag(no_driver),
    ];
    // Where the driver clips, 811 pixels are wrong of the helmet, and 11 of the camera, which takes a fifth of the time.
    let file = if is_long() { "FlightHelmet.glb" } else { "AntiqueCamera.glb" };
    let on_file = on_files("clipping::shadows_on_swiftshader_have_no_specks::", assets(), &[file], specks);
    trials.extend(on_file.into_iter().map(|trial| if no_driver { trial.with_ignored_flag(true) } else { trial }));
    trials
}

/// The manifest of `SwiftShader`.
fn manifest() -> Option<String> {
    let elsewhere = std::env::var("RIMLINE_SWIFTSHADER").ok();
    let manifests = ["/usr/lib/chromium/vk_swiftshader_icd.json", "/usr/lib/chromium-browser/vk_swiftshader_icd.json"];
    elsewhere.into_iter().chain(manifests.map(str::to_owned)).find(|path| std::path::Path::new(path).exists())
}

/// Wrong pixels of an adapter's trial.
fn wrong_clipping(json: &Value, name: &str) -> Option<u64> {
    let mut adapters = json["adapters"].as_array()?.iter();
    adapters.find(|adapter| adapter["name"].as_str().is_some_and(|found| found.contains(name)))?["wrong_clipping"]
        .as_u64()
}

fn lavapipe() -> Outcome {
    let json = rimline(["devices", "--json"]).json()?;
    let is_there = json.to_string().contains("llvmpipe");
    ensure!(!is_there || wrong_clipping(&json, "llvmpipe") == Some(0), "{json}");
    Ok(())
}

fn named() -> Outcome {
    let driver = manifest().ok_or("no SwiftShader")?;
    let variables = [("VK_DRIVER_FILES", driver.as_str())];
    let json = rimline_with(["devices", "--json"], &variables).json()?;
    let wrong = wrong_clipping(&json, "SwiftShader").ok_or_else(|| format!("not tried: {json}"))?;
    let run = rimline_with(["devices"], &variables);
    run.expect(0, &[])?;
    let says = run.stdout.contains(&format!("wrong at {wrong} pixels"));
    ensure!(says == (wrong > 0), "{wrong} wrong pixels, but it says: {}", run.stdout);
    Ok(())
}

/// A point light, and volumes that leave the picture on all sides: pixels that differ from lavapipe's lie at borders of
/// shadow, where the rasterisers' grids tell, and a few beside them.
fn specks(model: &Path) -> Outcome {
    let driver = manifest().ok_or("no SwiftShader")?;
    let most = if is_long() { 10 } else { 6 };
    let folder = folder();
    let mask = |name: &str, variables: &[(&str, &str)]| -> Result<Image, String> {
        let prefix = folder.path().join(name);
        let line = ["shadow".as_ref(), model.as_os_str(), "--light=point:3,4,2".as_ref(), "--size=400x300".as_ref()];
        let line = line.into_iter().chain(["--method=z-fail".as_ref(), "--mask".as_ref(), prefix.as_os_str()]);
        rimline_with(line, variables).expect(0, &[])?;
        folder.mask(format!("{name}.0.png"))
    };
    let right = mask("right", &[])?;
    let found = mask("found", &[("VK_DRIVER_FILES", driver.as_str())])?;
    let is_inner =
        |x: usize, y: usize| (x - 1..x + 2).all(|i| (y - 1..y + 2).all(|j| right.at(i, j) == right.at(x, y)));
    let pixels = (1..399).flat_map(|x| (1..299).map(move |y| (x, y)));
    let wrong: Vec<_> = pixels.filter(|&(x, y)| right.at(x, y) != found.at(x, y)).collect();
    let lone = wrong.iter().filter(|&&(x, y)| is_inner(x, y)).count();
    println!("{} of {} pixels differ, {lone} of them alone", wrong.len(), right.bytes.len());
    ensure!(wrong.len() < 60 && lone < most, "{} pixels differ, {lone} of them alone", wrong.len());
    Ok(())
}
