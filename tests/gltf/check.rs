//! Properties of every asset that loads, and comparisons, each with a negative control.

use libtest_mimic::Trial;
use rimline::Transform;
use rimline::cpu::{self, Threads};
use rimline::gltf::{Asset, Colors, GltfError, GltfWarning};
use rimline::model::{Geometry, GeometryOptions, Influences, Instance, Model, ModelError};
use rimline_testkit::poser::{self, gltf::File};

use crate::maker::Maker;
use crate::{Outcome, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![test("check::control", control)]
}

/// Constructors of models leave these open: all is finite if it must be, weights sum to 1, instances have faces.
fn sound(model: &Model, must_be_finite: bool) -> Outcome {
    for (g, geometry) in model.geometries().iter().enumerate() {
        let mut vectors = geometry.morph_targets().iter().flatten().chain(geometry.positions()).flatten();
        ensure(!must_be_finite || vectors.all(|c| c.is_finite()), || format!("geometry {g}: position or offset"))?;
        let Some(influences) = geometry.influences() else { continue };
        for v in 0..geometry.positions().len() {
            let weights = &influences.weights()[influences.range(v)];
            let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
            ensure((total - 1.0).abs() < 1e-5, || format!("geometry {g}: vertex {v} weighs {total}"))?;
        }
    }
    ensure(model.placed_geometries().all(|geometry| !geometry.faces().is_empty()), || "nothing is placed".to_owned())
}

/// An asset's model, and poses and lights at several times of its first animations. Poses may be refused only as not
/// finite, and only if `lenient`.
pub(crate) fn asset(asset: &Asset, animations: usize, lenient: bool) -> Outcome {
    let is_infinite = |warning: &GltfWarning| matches!(warning, GltfWarning::NonFinite { .. });
    sound(asset.model(), !asset.warnings().iter().any(is_infinite))?;
    for (g, geometry) in asset.model().geometries().iter().enumerate() {
        let Some(Colors { faces, vertices }) = asset.colors(g) else { continue };
        let counts = [faces.as_ref().map_or(0, Vec::len), vertices.as_ref().map_or(0, Vec::len)];
        let of = [geometry.faces().len(), geometry.positions().len()];
        let are_right = counts.into_iter().zip(of).all(|(found, all)| found == 0 || found == all);
        ensure(are_right && counts != [0, 0], || format!("geometry {g}: {counts:?} colours of {of:?}"))?;
        let mut all = faces.iter().chain(vertices).flatten().flatten();
        ensure(all.all(|c| (0.0..=1.0).contains(c)), || format!("geometry {g}: a colour"))?;
    }
    let is_damaged = |animation: Option<usize>| animation.is_some_and(|a| asset.animations()[a].fault.is_some());
    let check = |animation, time| match asset.pose(animation, time) {
        Err(GltfError::DamagedAnimation { .. }) if is_damaged(animation) => Ok(()),
        Ok(found) => {
            asset.model().check(&found)?;
            for camera in asset.each_camera(animation, time).iter().flatten().flatten() {
                let numbers = [camera.eye, camera.forward, camera.up].concat();
                ensure(numbers.iter().all(|c| c.is_finite()), || format!("{camera:?}"))?;
            }
            let lights = asset.lights(animation, time);
            let is_good = matches!(lights, Ok(_) | Err(GltfError::DamagedLight { .. }));
            ensure(lenient || is_good, || format!("lights at {time}: {lights:?}"))
        }
        Err(GltfError::NotFinite { .. }) if lenient => Ok(()),
        Err(error) => Err(format!("animation {animation:?} at {time}: {error}").into()),
    };
    check(None, 0.0)?;
    for (index, info) in asset.animations().iter().enumerate().take(animations) {
        for part in [-1.0, 0.0, 0.123, 0.5, 0.99, 1.0, 2.0, f32::INFINITY] {
            check(Some(index), if part.is_finite() { info.duration_s * part } else { part })?;
        }
    }
    Ok(())
}

/// The triangles are those of the poser, which reads the file by itself: at rest, and at these times of the first animation.
pub(crate) fn like_poser(maker: &Maker, times: &[f32]) -> Outcome {
    let mut maker = maker.clone();
    if maker.json["scenes"].is_null() {
        let nodes: Vec<usize> = (0..maker.json["nodes"].as_array().map_or(0, Vec::len)).collect();
        maker.scene(&nodes);
    }
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("made.glb");
    std::fs::write(&path, maker.glb())?;
    let (asset, file) = (maker.load()?, File::open(&path)?);
    let moments = [(None, 0.0)].into_iter().chain(times.iter().map(|&time| (Some(0), time)));
    for (animation, time) in moments {
        let pose = asset.pose(animation, time)?;
        let positions = cpu::deform(asset.model(), &pose, 0.0, None, Threads::ONE)?;
        let (found, expected) = (poser::corners(asset.model(), &positions), file.corners(animation, time));
        poser::compare(&format!("{animation:?} at {time}"), &found, &expected)?;
        ensure(!found.is_empty(), || "no triangles".to_owned())?;
    }
    Ok(())
}

/// The warnings.
pub(crate) fn said(asset: &Asset) -> Vec<String> {
    asset.warnings().iter().map(ToString::to_string).collect()
}

/// One warning, which has all of these parts.
pub(crate) fn warned_once(asset: &Asset, parts: &[&str]) -> Outcome {
    let warnings = said(asset);
    let one = warnings.len() == 1 && parts.iter().all(|part| warnings[0].contains(part));
    ensure(one, || format!("{warnings:?}, expected one with {parts:?}"))
}

/// Where an instance of a file at rest takes a point.
pub(crate) fn moved(asset: &Asset, instance: usize, point: [f32; 3]) -> Result<[f64; 3], GltfError> {
    Ok(map(&asset.pose(None, 0.0)?.instances()[instance].palette()[0], point))
}

/// The same up to a tolerance.
pub(crate) fn close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) -> Outcome {
    let near = found.len() == expected.len()
        && found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance * b.abs().max(1.0));
    ensure(near, || format!("{what}: {found:?}, expected {expected:?}"))
}

/// Maps a point.
pub(crate) fn map(matrix: &Transform, point: [f32; 3]) -> [f64; 3] {
    matrix.rows().map(|row| {
        let products = row.iter().zip([point[0], point[1], point[2], 1.0]);
        products.map(|(a, b)| f64::from(*a) * f64::from(b)).sum()
    })
}

fn control() -> Outcome {
    let model = |x: f32, weight: f32, faces: &[[u32; 3]]| {
        let influences = Some(Influences::new(vec![0, 1, 2, 3], vec![0; 3], vec![1.0, 1.0, weight])?);
        let options = GeometryOptions { influences, ..GeometryOptions::default() };
        let geometry = Geometry::new(vec![[0.0, x, 0.0]; 3], faces.to_vec(), options)?;
        Model::new(vec![geometry], vec![Instance::new(0, None)])
    };
    let face = [[0, 1, 2]];
    sound(&model(0.0, 1.0, &face)?, true)?;
    sound(&model(f32::NAN, 1.0, &face)?, false)?;
    let spoilt = [model(f32::NAN, 1.0, &face), model(0.0, 1.1, &face), model(0.0, 1.0, &[])];
    for (s, bad) in spoilt.into_iter().collect::<Result<Vec<_>, ModelError>>()?.iter().enumerate() {
        ensure(sound(bad, true).is_err(), || format!("spoiler {s} went unnoticed"))?;
    }
    close(&[1.0, 2.0], &[1.0, 2.0 + 1e-9], 1e-8, "near")?;
    for far in [&[1.0, 2.0 + 1e-7][..], &[1.0, f64::NAN], &[1.0]] {
        ensure(close(far, &[1.0, 2.0], 1e-8, "").is_err(), || format!("{far:?} went unnoticed"))?;
    }
    Ok(())
}
