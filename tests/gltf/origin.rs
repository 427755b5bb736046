//! Files whose coordinates are too large for `f32`: poses, lights and cameras relative to an origin.

use libtest_mimic::{Failed, Trial};
use rimline::Origin;
use rimline::gltf::Asset;
use serde_json::json;

use crate::check::{close, moved};
use crate::maker::{Maker, U16, everything};
use crate::{Outcome, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("origin::nodes_are_composed_in_f64", composed),
        test("origin::skins_morphs_and_animations_move_alike", moving),
        test("origin::what_f32_lost_in_the_file_is_said", stored),
        test("origin::cesium_rtc_is_where_the_scene_is", center),
    ]
}

/// Coordinates of a survey.
const FAR: [f64; 3] = [392_143.517, 34.128, -5_820_467.702];

/// A square of a fifth, turned by a quarter about Y and shifted, in a node that is far away.
fn far() -> Maker {
    let mut maker = Maker::square();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    maker.json["nodes"][0]["scale"] = json!([0.2, 0.2, 0.2]);
    maker.json["nodes"][0]["translation"] = json!([0.017, 0.0, -0.002]);
    maker.push(
        "nodes",
        json!({ "translation": FAR, "rotation": [0, half, 0, half], "children": [0], "camera": 0,
            "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
    );
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    maker.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }));
    maker
}

fn composed() -> Outcome {
    let mut asset = far().load()?;
    same(&asset.origin(), &Origin::ZERO, "no origin before one is set")?;
    let origin = asset.suggested_origin(None, 0.0)?;
    let [ox, oy, oz] = origin.to_array();
    ensure([ox, oy, oz].iter().zip(FAR).all(|(c, at)| (c - at).abs() < 1.0), || format!("{origin:?} is not near"))?;
    // A quarter turn about Y takes x to −z and z to x.
    let world = |x: f64, y: f64| [FAR[0] - 0.002, FAR[1] + 0.2 * y, FAR[2] - 0.017 - 0.2 * x];
    let before = moved(&asset, 0, [1.0, 1.0, 0.0])?;
    asset.set_origin(origin);
    same(&asset.suggested_origin(None, 0.0)?, &origin, "it does not depend on what is set")?;
    for [x, y] in [[0.0_f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        let expected = world(x.into(), y.into());
        let found = moved(&asset, 0, [x, y, 0.0])?;
        close(&found, &[expected[0] - ox, expected[1] - oy, expected[2] - oz], 1e-7, "a corner")?;
    }
    let light = asset.lights(None, 0.0)?[0].light;
    same(&light.xyz, &origin.position(FAR), "the light")?;
    let eye = asset.each_camera(None, 0.0)?.remove(0)?.eye;
    same(&eye, &origin.position(FAR), "the camera")?;
    // Without an origin the corner is off by more than a tenth of the square.
    let expected = world(1.0, 1.0);
    let off = (0..3).map(|axis| (before[axis] - expected[axis]).abs()).fold(0.0, f64::max);
    ensure(off > 0.02, || format!("negative control: off by {off}"))?;
    let extent = asset.extent(None, 0.0)?.ok_or("there is a square")?;
    let [low, high] = extent.bounds;
    close(&low, &world(1.0, 0.0), 1e-9, "the lowest corner")?;
    close(&high, &world(0.0, 1.0), 1e-9, "the highest corner")?;
    ensure(extent.rounding < 1e-6, || format!("{extent:?}"))?;
    asset.set_origin(Origin::ZERO);
    let lost = asset.extent(None, 0.0)?.ok_or("there is a square")?.rounding;
    ensure((0.2..0.3).contains(&lost), || format!("f32 loses {lost} there"))
}

/// All positions of a file in `f64`, from the matrices and weights of its pose.
fn deformed(asset: &Asset, animation: Option<usize>, time: f32) -> Result<Vec<[f64; 3]>, Failed> {
    let (pose, threads) = (asset.pose(animation, time)?, rimline::cpu::Threads::all());
    let found = rimline::cpu::deform(asset.model(), &pose, 0.0, None, threads)?;
    Ok(found.into_iter().map(|position| position.map(f64::from)).collect())
}

/// The same file near zero and far away: what is relative to the origin differs by less than a hundredth of a millimetre.
fn moving() -> Outcome {
    let near = everything();
    let mut far = near.clone();
    let roots: Vec<usize> = (0..far.json["nodes"].as_array().map_or(0, Vec::len)).collect();
    let root = far.push("nodes", json!({ "translation": FAR, "children": roots }));
    far.json["scenes"][0]["nodes"] = json!([root]);
    let (near, mut far) = (near.load()?, far.load()?);
    same(&near.suggested_origin(None, 0.0)?, &Origin::ZERO, "an origin near zero")?;
    for (animation, time) in [(None, 0.0), (Some(0), 0.7), (Some(0), 2.0)] {
        let origin = far.suggested_origin(animation, time)?;
        ensure(!origin.is_zero(), || format!("no origin at {time}"))?;
        far.set_origin(origin);
        let shift: Vec<f64> = FAR.iter().zip(origin.to_array()).map(|(position, origin)| position - origin).collect();
        let (expected, found) = (deformed(&near, animation, time)?, deformed(&far, animation, time)?);
        same(&found.len(), &expected.len(), "vertices")?;
        for (found, expected) in found.iter().zip(&expected) {
            let expected: Vec<f64> = expected.iter().zip(&shift).map(|(c, shift)| c + shift).collect();
            close(found, &expected, 1e-5, "a vertex")?;
        }
        let [low, high] = far.extent(animation, time)?.ok_or("there are vertices")?.bounds;
        let world = found.iter().map(|vertex| [0, 1, 2].map(|axis| vertex[axis] + origin.to_array()[axis]));
        let is_in = |vertex: [f64; 3]| (0..3).all(|i| vertex[i] >= low[i] - 1e-5 && vertex[i] <= high[i] + 1e-5);
        ensure(world.clone().all(is_in), || format!("{low:?} to {high:?} does not hold all at {time}"))?;
        let (expected, found) = (near.lights(animation, time)?, far.lights(animation, time)?);
        for (found, expected) in found.iter().zip(&expected) {
            let at: Vec<f64> = expected.light.xyz.iter().zip(&shift).map(|(c, shift)| f64::from(*c) + shift).collect();
            close(&found.light.xyz.map(f64::from), &at, 1e-5, "a light")?;
            same(&found.cone, &expected.cone, "its cone")?;
        }
    }
    Ok(())
}

/// Positions that are far away in the file's own `f32`: they are used bit for bit, and their possible error is stated.
fn stored() -> Outcome {
    let mut maker = Maker::new();
    let corners = [[392_142.0, 34.0, -5_820_467.0], [392_144.5, 34.0, -5_820_467.0], [392_142.0, 36.0, -5_820_467.0]];
    // No face has the last vertex.
    let positions = maker.floats("VEC3", [&corners[..], &[[0.0; 3]]].concat().as_flattened());
    let indices = maker.indices(U16, &[0, 1, 2]);
    let mesh = maker.mesh(&json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    maker.push("nodes", json!({ "mesh": mesh }));
    let mut asset = maker.load()?;
    let origin = asset.suggested_origin(None, 0.0)?;
    asset.set_origin(origin);
    let [ox, oy, oz] = origin.to_array();
    ensure(!origin.is_zero(), || "no origin".to_owned())?;
    same(&deformed(&asset, None, 0.0)?[1], &[392_144.5 - ox, 34.0 - oy, -5_820_467.0 - oz], "a vertex")?;
    let rounding = asset.extent(None, 0.0)?.ok_or("there is a triangle")?.rounding;
    ensure((0.25..0.3).contains(&rounding), || format!("{rounding}"))
}

fn center() -> Outcome {
    let mut maker = far();
    let mut expected = maker.load()?;
    // The node's position is the center, and the node stands at zero.
    maker.json["nodes"][1]["translation"] = json!([0.0, 0.0, 0.0]);
    maker.json["extensions"]["CESIUM_RTC"] = json!({ "center": FAR });
    maker.json["extensionsUsed"] = json!(["CESIUM_RTC", "KHR_lights_punctual"]);
    maker.json["extensionsRequired"] = json!(["CESIUM_RTC"]);
    let mut found = maker.load()?;
    let origin = expected.suggested_origin(None, 0.0)?;
    same(&found.suggested_origin(None, 0.0)?, &origin, "the origin")?;
    expected.set_origin(origin);
    found.set_origin(origin);
    close(&moved(&found, 0, [1.0; 3])?, &moved(&expected, 0, [1.0; 3])?, 1e-6, "a corner")?;
    let position = |asset: &Asset| asset.lights(None, 0.0).map(|lights| lights[0].light.xyz.map(f64::from));
    close(&position(&found)?, &position(&expected)?, 1e-6, "the light")?;
    // A mesh that no node names is moved, too.
    maker.json["nodes"] = json!([]);
    let mut alone = maker.load()?;
    alone.set_origin(origin);
    let [ox, oy, oz] = origin.to_array();
    close(&moved(&alone, 0, [0.0; 3])?, &[FAR[0] - ox, FAR[1] - oy, FAR[2] - oz], 1e-6, "a mesh without a node")
}
