//! What must hold of every asset that loads, and comparisons, each with a negative control.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, PoseError};
use rimline::model::{Geometry, InstancePose, Matrix3x4, Model, Pose};

use crate::{Outcome, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("check::model_control", model_control),
        test("check::pose_control", pose_control),
        test("check::close_control", close_control),
    ]
}

/// Indices in range, lists of equal length, positions finite.
pub(crate) fn model(model: &Model) -> Outcome {
    for (g, geometry) in model.geometries.iter().enumerate() {
        let vertices = geometry.positions.len();
        let finite = |list: &[[f32; 3]]| list.as_flattened().iter().all(|c| c.is_finite());
        ensure(finite(&geometry.positions), || format!("geometry {g}: position"))?;
        let in_range = geometry.faces.as_flattened().iter().all(|&v| (v as usize) < vertices);
        ensure(in_range, || format!("geometry {g}: face index"))?;
        ensure(geometry.source_vertices.len() == vertices, || format!("geometry {g}: source vertices"))?;
        for target in &geometry.morph_targets {
            let good = target.len() == vertices && finite(target);
            ensure(good, || format!("geometry {g}: morph target"))?;
        }
        if let Some(influences) = &geometry.influences {
            let offsets = &influences.offsets;
            let entries = influences.joints.len();
            let good = offsets.len() == vertices + 1
                && offsets.first() == Some(&0)
                && offsets.last() == Some(&(entries as u32))
                && offsets.is_sorted()
                && influences.weights.len() == entries;
            ensure(good, || format!("geometry {g}: influence offsets"))?;
            for v in 0..vertices {
                let total: f64 = influences.weights[influences.range(v)].iter().map(|&w| f64::from(w)).sum();
                ensure((total - 1.0).abs() < 1e-5, || format!("geometry {g}: vertex {v} weighs {total}"))?;
            }
        }
    }
    for (i, instance) in model.instances.iter().enumerate() {
        let drawn = model.geometries.get(instance.geometry).is_some_and(|g| !g.faces.is_empty());
        ensure(drawn, || format!("instance {i}: geometry"))?;
    }
    Ok(())
}

/// One pose an instance, palettes as long as the joints need, all finite.
pub(crate) fn pose(model: &Model, pose: &Pose) -> Outcome {
    ensure(pose.instances.len() == model.instances.len(), || "instances".to_owned())?;
    for (i, (instance, pose)) in model.instances.iter().zip(&pose.instances).enumerate() {
        let geometry = &model.geometries[instance.geometry];
        let enough = match &geometry.influences {
            None => pose.palette.len() == 1,
            Some(influences) => influences.joints.iter().all(|&j| (j as usize) < pose.palette.len()),
        };
        ensure(enough, || format!("instance {i}: palette of {}", pose.palette.len()))?;
        ensure(pose.morph_weights.len() == geometry.morph_targets.len(), || format!("instance {i}: weights"))?;
        let mut values = pose.palette.iter().flatten().flatten().chain(&pose.morph_weights);
        ensure(values.all(|v| v.is_finite()), || format!("instance {i}: not finite"))?;
    }
    Ok(())
}

/// An asset's model, and poses and lights at several times of its first animations. Poses may be refused only as not
/// finite, and only if `lenient`.
pub(crate) fn asset(asset: &Asset, animations: usize, lenient: bool) -> Outcome {
    model(asset.model())?;
    let check = |animation, time| match asset.pose(animation, time) {
        Ok(found) => {
            pose(asset.model(), &found)?;
            ensure(lenient || asset.lights(animation, time).is_ok(), || format!("lights at {time}"))
        }
        Err(PoseError::NotFinite { .. }) if lenient => Ok(()),
        Err(error) => Err(format!("animation {animation:?} at {time}: {error}").into()),
    };
    check(None, 0.0)?;
    for (index, info) in asset.animations().iter().enumerate().take(animations) {
        for part in [-1.0, 0.0, 0.123, 0.5, 0.99, 1.0, 2.0] {
            check(Some(index), info.duration_s * part)?;
        }
        check(Some(index), f32::INFINITY)?;
    }
    Ok(())
}

/// The same up to a tolerance.
pub(crate) fn close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) -> Outcome {
    let near = found.len() == expected.len()
        && found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance * b.abs().max(1.0));
    ensure(near, || format!("{what}: {found:?}, expected {expected:?}"))
}

/// Maps a point.
pub(crate) fn map(matrix: &Matrix3x4, point: [f32; 3]) -> [f64; 3] {
    matrix.map(|row| {
        let products = row.iter().zip([point[0], point[1], point[2], 1.0]);
        products.map(|(a, b)| f64::from(*a) * f64::from(b)).sum()
    })
}

/// All vertices of an instance in world space, in `f64`.
pub(crate) fn posed(geometry: &Geometry, pose: &InstancePose) -> Vec<[f64; 3]> {
    (0..geometry.positions.len())
        .map(|v| {
            let mut point = geometry.positions[v];
            for (target, weight) in geometry.morph_targets.iter().zip(&pose.morph_weights) {
                point = std::array::from_fn(|c| point[c] + weight * target[v][c]);
            }
            let Some(influences) = &geometry.influences else {
                return map(&pose.palette[0], point);
            };
            let mut sum = [0.0; 3];
            for entry in influences.range(v) {
                let moved = map(&pose.palette[influences.joints[entry] as usize], point);
                let weight = f64::from(influences.weights[entry]);
                sum = std::array::from_fn(|c| sum[c] + weight * moved[c]);
            }
            sum
        })
        .collect()
}

fn model_control() -> Outcome {
    let good = crate::maker::everything().load()?;
    model(good.model())?;
    let spoilers: [fn(&mut Model); 6] = [
        |m| m.geometries[0].positions[0][1] = f32::NAN,
        |m| m.geometries[0].faces[0][2] = 1000,
        |m| m.geometries[0].morph_targets[0].truncate(1),
        |m| m.geometries[0].influences.as_mut().unwrap().weights[0] += 0.1,
        |m| m.geometries[0].influences.as_mut().unwrap().offsets[1] += 1000,
        |m| m.instances[0].geometry = 99,
    ];
    for (s, spoil) in spoilers.iter().enumerate() {
        let mut bad = good.model().clone();
        spoil(&mut bad);
        ensure(model(&bad).is_err(), || format!("spoiler {s} went unnoticed"))?;
    }
    Ok(())
}

fn pose_control() -> Outcome {
    let asset = crate::maker::everything().load()?;
    let good = asset.pose(None, 0.0)?;
    pose(asset.model(), &good)?;
    let spoilers: [fn(&mut Pose); 4] = [
        |p| p.instances[0].palette.truncate(1),
        |p| p.instances[0].palette[1][2][3] = f32::INFINITY,
        |p| p.instances[0].morph_weights.push(0.0),
        |p| p.instances.truncate(1),
    ];
    for (s, spoil) in spoilers.iter().enumerate() {
        let mut bad = good.clone();
        spoil(&mut bad);
        ensure(pose(asset.model(), &bad).is_err(), || format!("spoiler {s} went unnoticed"))?;
    }
    Ok(())
}

fn close_control() -> Outcome {
    close(&[1.0, 2.0], &[1.0, 2.0 + 1e-9], 1e-8, "near")?;
    ensure(close(&[1.0, 2.0], &[1.0, 2.0 + 1e-7], 1e-8, "").is_err(), || "1e-7 went unnoticed".to_owned())?;
    ensure(close(&[f64::NAN], &[1.0], 1.0, "").is_err(), || "NaN went unnoticed".to_owned())?;
    ensure(close(&[1.0], &[1.0, 1.0], 1.0, "").is_err(), || "a short list went unnoticed".to_owned())
}
