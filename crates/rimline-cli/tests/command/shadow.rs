//! Shadows: masks whose values are known, pictures, and what is said of them.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_testkit::shapes;

use super::makers::npz_model;
use super::pictures::{Image, apart};
use super::run::{Folder, folder, is_long, rimline};
use super::{Outcome, Test, ensure};
use rimline_testkit::assets;
use rimline_testkit::harness::{on_files, on_made, on_models};

pub(crate) const TESTS: &[Test] = &[
    ("shadow::masks_of_lights_with_an_area_are_shares", area),
    ("shadow::a_folder_has_one_film_at_a_time", films),
    ("shadow::pictures_do_not_depend_on_scale", scale),
];

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

/// Good models have a picture and a mask.
pub(crate) fn trials() -> Vec<Trial> {
    if is_long() {
        return on_models("shadow_models::", any_model);
    }
    let mut trials = on_made("shadow_models::", MADE, any_model);
    trials.extend(on_files("shadow_models::", assets(), &DRAWN, any_model));
    trials
}

/// A folder with a cube of side 2 that floats a unit over the ground.
pub(crate) fn with_cube() -> Result<Folder, String> {
    let folder = folder();
    let cube = npz_model(&shapes::cube(), 1.0, [0.0, 2.0, 0.0]);
    folder.write("cube.npz", cube)?;
    Ok(folder)
}

/// The eye looks level from a height, so that the middle row is the horizon; the cube is in the middle.
const VIEW: &str = "--ground 0 --eye 0,2,12 --target 0,2,0 --fov 60 --size 160x120 --light point:0,9,0";

fn area() -> Outcome {
    let folder = with_cube()?;
    folder.run(&format!("shadow @cube.npz {VIEW} --area disc:1 --samples 8 --mask @m")).expect(0, &[])?;
    let mask = folder.image("m.0.png")?;
    ensure!(mask.at(80, 77) == 0 && mask.at(80, 115) == 255 && mask.at(10, 10) == 128, "the middle is not as without");
    let shares: Vec<u8> = (0..=8_u32).map(|lit| ((510 * lit + 8) / 16) as u8).collect();
    let other = mask.bytes.iter().find(|value| **value != 128 && !shares.contains(value));
    ensure!(other.is_none(), "{other:?} is no share of 8 samples");
    let soft = mask.bytes.iter().filter(|value| shares[1..8].contains(value) && **value != 128).count();
    // Without an area there are none, as every mask of one light shows.
    ensure!(soft > 40, "{soft} pixels of penumbra");
    Ok(())
}

fn scale() -> Outcome {
    let folder = folder();
    let mut drawn = Vec::new();
    // Powers of two leave every position as exact as it was. Squares of some are no numbers any more, or zero.
    let all = [1.0, 2.0_f32.powi(-100), 1e19, 1e37, 2.0_f32.powi(64), 2.0_f32.powi(120), 1e-30];
    let scales = if is_long() { &all[..] } else { &all[..4] };
    for &scale in scales {
        folder.write("cube.npz", npz_model(&shapes::cube(), scale, [0.0, 2.0 * scale, 0.0]))?;
        let mut images = Vec::new();
        let light = format!("--light point:{},{},{},range={}", 3.0 * scale, 6.0 * scale, 4.0 * scale, 9.0 * scale);
        for (picture, options) in
            ["", &format!("{light} --light dir:1,2,1 --volumes"), "--area disc --samples 2"].iter().enumerate()
        {
            folder
                .run(&format!("shadow @cube.npz --size 96x72 {options} --out @p.png"))
                .expect(0, &[])
                .map_err(|error| format!("{scale:e}, {picture}: {error}"))?;
            images.push(folder.image("p.png")?.bytes);
        }
        drawn.push(images);
    }
    for (scale, images) in scales.iter().zip(&drawn) {
        for (picture, (image, first)) in images.iter().zip(&drawn[0]).enumerate() {
            let different = apart([image, first], 1, 2)?;
            ensure!(different <= 60, "{scale:e}, {picture}: {different} bytes differ");
        }
    }
    // The comparison can fail.
    let different = apart([&drawn[0][0], &drawn[0][1]], 1, 2)?;
    ensure!(different > 1000, "another light changes {different} bytes only");
    Ok(())
}

fn any_model(file: &Path) -> Outcome {
    let folder = folder();
    let (out, mask) = (folder.path().join("p.png"), folder.path().join("m"));
    let mut line = vec!["shadow".into(), file.as_os_str().to_owned()];
    line.extend(["--size", "96x72", "--out"].map(Into::into));
    line.extend([out.as_os_str().to_owned(), "--mask".into(), mask.into_os_string()]);
    rimline(line).expect(0, &[])?;
    let picture = Image::read(&out)?;
    ensure!(picture.bytes.iter().any(|&value| value != picture.bytes[0]), "an empty picture");
    let mask = folder.mask("m.0.png")?;
    ensure!(mask.count(0) > 20 && mask.count(255) > 20, "{} dark, {} lit pixels", mask.count(0), mask.count(255));
    Ok(())
}

/// The second film begins while the first one is under way.
fn films() -> Outcome {
    let folder = with_cube()?;
    let mut first = std::process::Command::new(env!("CARGO_BIN_EXE_rimline"))
        .arg("film")
        .arg(folder.path().join("cube.npz"))
        .args(["--frames", "400", "--size", "64x48", "--out"])
        .arg(folder.path().join("film"))
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .map_err(|error| error.to_string())?;
    let claim = folder.path().join("film/.rimline-film.part");
    for _ in 0..1000 {
        if claim.exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let second = folder.run("film @cube.npz --frames 2 --size 64x48 --out @film");
    let _ = first.kill();
    first.wait().map_err(|error| error.to_string())?;
    second.expect(2, &["another film", "choose another folder"])
}
