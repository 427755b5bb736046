//! Properties of every asset that loads, and comparisons, each with a negative control.

use libtest_mimic::Trial;
use rimline::Transform;
use rimline::gltf::{Asset, Colors, GltfError, GltfWarning};
use rimline::internals::model::influence_range;
use rimline::model::{Geometry, GeometryOptions, Influences, Instance, InstancePose, Model, ModelError, Pose};

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
    sound(model, true)
}

/// The same. Positions and offsets are finite if they must be.
fn sound(model: &Model, must_be_finite: bool) -> Outcome {
    for (g, geometry) in model.geometries().iter().enumerate() {
        let vertices = geometry.positions().len();
        let finite = |list: &[[f32; 3]]| !must_be_finite || list.as_flattened().iter().all(|c| c.is_finite());
        ensure(finite(geometry.positions()), || format!("geometry {g}: position"))?;
        let in_range = geometry.faces().as_flattened().iter().all(|&v| (v as usize) < vertices);
        ensure(in_range, || format!("geometry {g}: face index"))?;
        ensure(geometry.source_vertices().len() == vertices, || format!("geometry {g}: source vertices"))?;
        for target in geometry.morph_targets() {
            let good = target.len() == vertices && finite(target);
            ensure(good, || format!("geometry {g}: morph target"))?;
        }
        if let Some(influences) = geometry.influences() {
            let offsets = influences.offsets();
            let entries = influences.joints().len();
            let good = offsets.len() == vertices + 1
                && offsets.first() == Some(&0)
                && offsets.last() == Some(&(entries as u32))
                && offsets.is_sorted()
                && influences.weights().len() == entries;
            ensure(good, || format!("geometry {g}: influence offsets"))?;
            for v in 0..vertices {
                let total: f64 =
                    influences.weights()[influence_range(influences, v)].iter().map(|&w| f64::from(w)).sum();
                ensure((total - 1.0).abs() < 1e-5, || format!("geometry {g}: vertex {v} weighs {total}"))?;
            }
        }
    }
    for (i, instance) in model.instances().iter().enumerate() {
        let drawn = model.geometries().get(instance.geometry()).is_some_and(|g| !g.faces().is_empty());
        ensure(drawn, || format!("instance {i}: geometry"))?;
    }
    Ok(())
}

/// One pose an instance, palettes as long as the joints need, all finite.
pub(crate) fn pose(model: &Model, pose: &Pose) -> Outcome {
    ensure(pose.instances().len() == model.instances().len(), || "instances".to_owned())?;
    for (i, (geometry, pose)) in model.placed_geometries().zip(pose.instances()).enumerate() {
        let enough = match geometry.influences() {
            None => pose.palette().len() == 1,
            Some(influences) => influences.joints().iter().all(|&j| (j as usize) < pose.palette().len()),
        };
        ensure(enough, || format!("instance {i}: palette of {}", pose.palette().len()))?;
        ensure(pose.morph_weights().len() == geometry.morph_targets().len(), || format!("instance {i}: weights"))?;
        let mut values = pose
            .palette()
            .iter()
            .flat_map(|matrix| matrix.rows())
            .flatten()
            .chain(pose.morph_weights().iter().copied());
        ensure(values.all(f32::is_finite), || format!("instance {i}: not finite"))?;
    }
    Ok(())
}

/// An asset's model, and poses and lights at several times of its first animations. Poses may be refused only as not
/// finite, and only if `lenient`.
pub(crate) fn asset(asset: &Asset, animations: usize, lenient: bool) -> Outcome {
    let is_infinite = |warning: &GltfWarning| matches!(warning, GltfWarning::NonFinite { .. });
    sound(asset.model(), !asset.warnings().iter().any(is_infinite))?;
    for (g, geometry) in asset.model().geometries().iter().enumerate() {
        let Some(Colors { faces, vertices }) = asset.colors(g) else { continue };
        let counts = [faces.as_ref().map_or(0, Vec::len), vertices.as_ref().map_or(0, Vec::len)];
        let is_right = |(found, all): (usize, usize)| found == 0 || found == all;
        let of = [geometry.faces().len(), geometry.positions().len()];
        let are_right = counts.into_iter().zip(of).all(is_right);
        ensure(are_right && counts != [0, 0], || format!("geometry {g}: {counts:?} colours of {of:?}"))?;
        let mut all = faces.iter().chain(vertices).flatten().flatten();
        ensure(all.all(|c| (0.0..=1.0).contains(c)), || format!("geometry {g}: a colour"))?;
    }
    let is_damaged = |animation: Option<usize>| animation.is_some_and(|a| asset.animations()[a].fault.is_some());
    let check = |animation, time| match asset.pose(animation, time) {
        Err(GltfError::DamagedAnimation { .. }) if is_damaged(animation) => Ok(()),
        Ok(found) => {
            pose(asset.model(), &found)?;
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
        for part in [-1.0, 0.0, 0.123, 0.5, 0.99, 1.0, 2.0] {
            check(Some(index), info.duration_s * part)?;
        }
        check(Some(index), f32::INFINITY)?;
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

/// All vertices of an instance in world space, in `f64`.
pub(crate) fn posed(geometry: &Geometry, pose: &InstancePose) -> Vec<[f64; 3]> {
    (0..geometry.positions().len())
        .map(|v| {
            let mut point = geometry.positions()[v];
            for (target, weight) in geometry.morph_targets().iter().zip(pose.morph_weights()) {
                point = std::array::from_fn(|c| point[c] + weight * target[v][c]);
            }
            let Some(influences) = geometry.influences() else {
                return map(&pose.palette()[0], point);
            };
            let mut sum = [0.0; 3];
            for entry in influence_range(influences, v) {
                let moved = map(&pose.palette()[influences.joints()[entry] as usize], point);
                let weight = f64::from(influences.weights()[entry]);
                sum = std::array::from_fn(|c| sum[c] + weight * moved[c]);
            }
            sum
        })
        .collect()
}

/// The first geometry of a model and its first instance's index, to be spoilt.
struct Parts {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    targets: Vec<Vec<[f32; 3]>>,
    influences: [Vec<u32>; 2],
    weights: Vec<f32>,
    geometry: usize,
}

impl Parts {
    fn of(model: &Model) -> Result<Self, String> {
        let geometry = &model.geometries()[0];
        let influences = geometry.influences().ok_or("rigid")?;
        Ok(Self {
            positions: geometry.positions().to_vec(),
            faces: geometry.faces().to_vec(),
            targets: geometry.morph_targets().to_vec(),
            influences: [influences.offsets().to_vec(), influences.joints().to_vec()],
            weights: influences.weights().to_vec(),
            geometry: 0,
        })
    }

    fn build(self) -> Result<Model, ModelError> {
        let [offsets, joints] = self.influences;
        let influences = Some(Influences::new(offsets, joints, self.weights)?);
        let options = GeometryOptions { morph_targets: self.targets, influences, ..GeometryOptions::default() };
        let geometry = Geometry::new(self.positions, self.faces, options)?;
        Model::new(vec![geometry, Geometry::default()], vec![Instance::new(self.geometry, None)])
    }
}

/// A change that spoils the parts, and whether a constructor refuses them then.
type Spoiler = (fn(&mut Parts), bool);

/// Spoilt parts are refused by a constructor or by the check, whichever comes first.
fn model_control() -> Outcome {
    let good = crate::maker::everything().load()?;
    model(good.model())?;
    model(&Parts::of(good.model())?.build()?)?;
    let spoilers: [Spoiler; 7] = [
        (|p| p.positions[0][1] = f32::NAN, false),
        (|p| p.faces[0][2] = 1000, true),
        (|p| p.targets[0].truncate(1), true),
        (|p| p.weights[0] += 0.1, false),
        (|p| p.influences[0][1] += 1000, true),
        (|p| p.geometry = 99, true),
        (|p| p.geometry = 1, false),
    ];
    for (s, (spoil, at_once)) in spoilers.iter().enumerate() {
        let mut parts = Parts::of(good.model())?;
        spoil(&mut parts);
        let built = parts.build();
        let noticed = built.as_ref().map_or(*at_once, |bad| !at_once && model(bad).is_err());
        ensure(noticed, || format!("spoiler {s} went unnoticed"))?;
    }
    Ok(())
}

fn pose_control() -> Outcome {
    let asset = crate::maker::everything().load()?;
    let good = asset.pose(None, 0.0)?;
    pose(asset.model(), &good)?;
    let first = &good.instances()[0];
    let (palette, weights) = (first.palette().to_vec(), first.morph_weights().to_vec());
    let with_first = |palette: Vec<Transform>, weights| {
        let mut instances = good.instances().to_vec();
        instances[0] = InstancePose::new(palette, weights)?;
        Ok::<_, ModelError>(Pose::new(instances))
    };
    pose(asset.model(), &with_first(palette.clone(), weights.clone())?)?;
    for (s, bad) in [
        with_first(palette[..1].to_vec(), weights.clone())?,
        with_first(palette.clone(), [&weights[..], &[0.0]].concat())?,
        Pose::new(good.instances()[..1].to_vec()),
    ]
    .iter()
    .enumerate()
    {
        ensure(pose(asset.model(), bad).is_err(), || format!("spoiler {s} went unnoticed"))?;
    }
    let mut infinite = palette;
    let mut rows = infinite[1].rows();
    rows[2][3] = f32::INFINITY;
    infinite[1] = rows.into();
    ensure(with_first(infinite, weights).is_err(), || "an infinite matrix was accepted".to_owned())
}

fn close_control() -> Outcome {
    close(&[1.0, 2.0], &[1.0, 2.0 + 1e-9], 1e-8, "near")?;
    ensure(close(&[1.0, 2.0], &[1.0, 2.0 + 1e-7], 1e-8, "").is_err(), || "1e-7 went unnoticed".to_owned())?;
    ensure(close(&[f64::NAN], &[1.0], 1.0, "").is_err(), || "NaN went unnoticed".to_owned())?;
    ensure(close(&[1.0], &[1.0, 1.0], 1.0, "").is_err(), || "a short list went unnoticed".to_owned())
}
