//! Keys of integers and of one time, animations that are refused, several at once. `tests/deform/poser.rs` holds each
//! interpolation of each property against a poser in `f64`.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError};
use serde_json::json;

use crate::check::{close, like_poser, map};
use crate::maker::Maker;
use crate::{Outcome, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("animate::normalised_integers", integers),
        test("animate::untargeted_channels_are_ignored", untargeted),
        test("animate::bad_times", bad_times),
        test("animate::overflow_is_an_error", overflow),
        test("animate::by_name_before_number", by_name),
        test("animate::several_objects", several),
        test("animate::two_that_move_the_same_property", conflict),
        test("animate::keys_of_one_time_are_a_step", same_times),
    ]
}

/// A square whose node one channel moves.
fn animated(path: &str, interpolation: &str, times: &[f32], kind: &str, output: &[f32]) -> Maker {
    let mut maker = Maker::square();
    let sampler = maker.keys(times, kind, output, interpolation);
    maker.animate(0, path, &sampler);
    maker
}

/// Turns whose lengths are up to 0.7 % off 1, the lowest number included, which counts as −1.
fn integers() -> Outcome {
    for (component, data) in [
        (5120, [0_i16, 0, 60, 111, 0, 0, -128, 0].map(|v| v as i8 as u8).to_vec()),
        (5122, [0_i16, 0, 15480, 28882, 0, 0, -32768, 0].iter().flat_map(|v| v.to_le_bytes()).collect()),
        (5121, vec![0, 0, 120, 225, 0, 0, 255, 0]),
    ] {
        for interpolation in ["LINEAR", "STEP"] {
            let mut maker = Maker::square();
            let input = maker.floats("SCALAR", &[0.0, 1.0]);
            let output = maker.accessor(component, "VEC4", 2, &data);
            maker.json["accessors"][output]["normalized"] = json!(true);
            maker.animate(0, "rotation", &json!({ "input": input, "output": output, "interpolation": interpolation }));
            like_poser(&maker, &[-1.0, 0.0, 0.5, 1.0])?;
        }
    }
    Ok(())
}

fn untargeted() -> Outcome {
    let mut maker = animated("translation", "STEP", &[0.0], "VEC3", &[1.0, 2.0, 3.0]);
    let channels = &mut maker.json["animations"][0]["channels"];
    for target in [
        json!({ "path": "rotation" }),
        json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/nodes/0/scale" } } }),
        json!({ "node": 0, "path": "EXT_other" }),
        json!({ "node": 0, "path": "weights" }),
    ] {
        channels.as_array_mut().expect("a list").push(json!({ "sampler": 0, "target": target }));
    }
    let asset = maker.load()?;
    same(&asset.animations()[0].channels, &1, "channels")?;
    close(&origins(&asset, &[0], 0.0)?, &[1.0, 2.0, 3.0], 0.0, "the one channel")
}

fn bad_times() -> Outcome {
    let asset = Maker::square().load()?;
    same(&asset.pose(None, f32::NAN), &Err(GltfError::Time), "NaN")?;
    same(&asset.pose(Some(3), 0.0), &Err(GltfError::NoAnimation { index: 3, count: 0 }), "no such animation")
}

fn overflow() -> Outcome {
    let mut maker = Maker::square();
    maker.json["nodes"][0]["scale"] = json!([1e300, 1, 1]);
    let message = maker.load()?.pose(None, 0.0).expect_err("1e300 fits no f32").to_string();
    ensure(message.contains("nodes[0]"), || message)
}

fn by_name() -> Outcome {
    let mut maker = Maker::square();
    for name in ["1", "walk", "walk"] {
        maker.push("animations", json!({ "name": name, "samplers": [], "channels": [] }));
    }
    let asset = maker.load()?;
    let found = ["1", "walk", "2", "0", "3", "run", ""].map(|name| asset.animation_index(name));
    same(&found, &[Some(0), Some(1), Some(2), Some(0), None, None, None], "indices")
}

/// Adds an animation of one channel, from the first value at 0 s to the second at `end`.
fn add(maker: &mut Maker, node: usize, path: &str, end: f32, values: &[f32; 6]) {
    let sampler = maker.keys(&[0.0, end], "VEC3", values, "LINEAR");
    maker.animate(node, path, &sampler);
}

fn two_squares() -> Maker {
    let mut maker = Maker::square();
    maker.push("nodes", json!({ "mesh": 0, "translation": [3, 0, 0] }));
    add(&mut maker, 0, "translation", 1.0, &[0.0, 0.0, 0.0, 0.0, 0.0, 4.0]);
    add(&mut maker, 1, "translation", 2.0, &[3.0, 0.0, 0.0, 3.0, 8.0, 0.0]);
    add(&mut maker, 0, "scale", 1.0, &[1.0, 1.0, 1.0, 3.0, 1.0, 1.0]);
    maker
}

/// Where all squares' origins are.
fn origins(asset: &Asset, animations: &[usize], time: f32) -> Result<Vec<f64>, GltfError> {
    let pose = asset.pose(animations.iter().copied(), time)?;
    Ok(pose.instances().iter().flat_map(|instance| map(&instance.palette()[0], [0.0; 3])).collect())
}

fn several() -> Outcome {
    let asset = two_squares().load()?;
    for (animations, time, expected) in [
        (&[][..], 0.5, [0.0, 0.0, 0.0, 3.0, 0.0, 0.0]),
        (&[0], 0.5, [0.0, 0.0, 2.0, 3.0, 0.0, 0.0]),
        (&[0, 1], 0.5, [0.0, 0.0, 2.0, 3.0, 2.0, 0.0]),
        (&[1, 0, 1], 0.5, [0.0, 0.0, 2.0, 3.0, 2.0, 0.0]),
        // The first one has ended.
        (&[0, 1, 2], 2.0, [0.0, 0.0, 4.0, 3.0, 8.0, 0.0]),
    ] {
        close(&origins(&asset, animations, time)?, &expected, 1e-6, &format!("{animations:?} at {time}"))?;
    }
    let corner = map(&asset.pose(0..3, 0.5)?.instances()[0].palette()[0], [1.0, 0.0, 0.0]);
    close(&corner, &[2.0, 0.0, 2.0], 1e-6, "another property of the same node")?;
    same(&asset.pose([0, 3], 0.0), &Err(GltfError::NoAnimation { index: 3, count: 3 }), "no such animation")
}

fn conflict() -> Outcome {
    let mut maker = two_squares();
    add(&mut maker, 1, "translation", 1.0, &[0.0; 6]);
    let asset = maker.load()?;
    asset.pose(Some(3), 0.0)?;
    let expected = GltfError::SameProperty { first: 1, second: 3, node: 1, property: "translation" };
    same(&asset.pose(0..4, 0.0), &Err(expected.clone()), "pose")?;
    same(&asset.lights(0..4, 0.0), &Err(expected.clone()), "lights")?;
    let message = expected.to_string();
    ensure(message.contains("animations 1 and 3") && message.contains("nodes[1]"), || message.clone())
}

fn same_times() -> Outcome {
    let values = [0.0, 4.0, 100.0, 6.0, 8.0, 9.0];
    for interpolation in ["LINEAR", "STEP", "CUBICSPLINE"] {
        let tangent = if interpolation == "CUBICSPLINE" { &[0.0; 3][..] } else { &[] };
        let keys: Vec<f32> = values.iter().flat_map(|&x| [tangent, &[x, 0.0, 0.0], tangent].concat()).collect();
        let maker = animated("translation", interpolation, &[0.0, 1.0, 1.0, 1.0, 2.0, 2.0], "VEC3", &keys);
        same(&maker.load()?.warnings().len(), &0, "warnings")?;
        like_poser(&maker, &[f32::NEG_INFINITY, -1.0, 1.0_f32.next_down(), 1.0, 1.5, 2.0, 3.0, f32::INFINITY])?;
    }
    Ok(())
}
