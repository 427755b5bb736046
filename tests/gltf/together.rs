//! Several animations at once, and keys of one time.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError};
use serde_json::json;

use crate::check::{close, map};
use crate::maker::Maker;
use crate::shape::same;
use crate::{Outcome, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("together::animations_of_several_objects", several),
        test("together::two_that_move_the_same_property", conflict),
        test("together::keys_of_one_time_are_a_step", steps),
    ]
}

/// Adds an animation of one channel, from the first value at 0 s to the second at `end`.
fn animate(maker: &mut Maker, node: usize, path: &str, end: f32, values: &[f32; 6]) {
    let (input, output) = (maker.floats("SCALAR", &[0.0, end]), maker.floats("VEC3", values));
    let channel = json!({ "sampler": 0, "target": { "node": node, "path": path } });
    maker.push("animations", json!({ "samplers": [{ "input": input, "output": output }], "channels": [channel] }));
}

fn two_squares() -> Maker {
    let mut maker = Maker::square();
    maker.push("nodes", json!({ "mesh": 0, "translation": [3, 0, 0] }));
    animate(&mut maker, 0, "translation", 1.0, &[0.0, 0.0, 0.0, 0.0, 0.0, 4.0]);
    animate(&mut maker, 1, "translation", 2.0, &[3.0, 0.0, 0.0, 3.0, 8.0, 0.0]);
    animate(&mut maker, 0, "scale", 1.0, &[1.0, 1.0, 1.0, 3.0, 1.0, 1.0]);
    maker
}

/// Where both squares' origins are.
fn origins(asset: &Asset, animations: &[usize], time: f32) -> Result<Vec<[f64; 3]>, GltfError> {
    let pose = asset.pose(animations.iter().copied(), time)?;
    Ok(pose.instances().iter().map(|instance| map(&instance.palette()[0], [0.0; 3])).collect())
}

fn several() -> Outcome {
    let asset = two_squares().load()?;
    for (animations, time, expected) in [
        (&[][..], 0.5, [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]),
        (&[0], 0.5, [[0.0, 0.0, 2.0], [3.0, 0.0, 0.0]]),
        (&[0, 1], 0.5, [[0.0, 0.0, 2.0], [3.0, 2.0, 0.0]]),
        (&[1, 0, 1], 0.5, [[0.0, 0.0, 2.0], [3.0, 2.0, 0.0]]),
        // The first one has ended.
        (&[0, 1, 2], 2.0, [[0.0, 0.0, 4.0], [3.0, 8.0, 0.0]]),
    ] {
        let found = origins(&asset, animations, time)?;
        close(found.as_flattened(), expected.as_flattened(), 1e-6, &format!("{animations:?} at {time}"))?;
    }
    let corner = map(&asset.pose(0..3, 0.5)?.instances()[0].palette()[0], [1.0, 0.0, 0.0]);
    close(&corner, &[2.0, 0.0, 2.0], 1e-6, "another property of the same node")?;
    let missing = asset.pose([0, 3], 0.0);
    ensure(missing == Err(GltfError::NoAnimation { index: 3, count: 3 }), || format!("{missing:?}"))
}

fn conflict() -> Outcome {
    let mut maker = two_squares();
    animate(&mut maker, 1, "translation", 1.0, &[0.0; 6]);
    let asset = maker.load()?;
    asset.pose(Some(3), 0.0)?;
    let expected = GltfError::SameProperty { first: 1, second: 3, node: 1, property: "translation" };
    let found = asset.pose(0..4, 0.0);
    ensure(found.as_ref() == Err(&expected), || format!("{found:?}"))?;
    ensure(asset.lights(0..4, 0.0) == Err(expected.clone()), || "lights".to_owned())?;
    let message = expected.to_string();
    ensure(message.contains("animations 1 and 3") && message.contains("nodes[1]"), || message.clone())
}

fn steps() -> Outcome {
    let times = [0.0, 1.0, 1.0, 1.0, 2.0, 2.0];
    let values = [0.0, 4.0, 100.0, 6.0, 8.0, 9.0];
    for interpolation in ["LINEAR", "STEP", "CUBICSPLINE"] {
        let mut maker = Maker::square();
        let input = maker.floats("SCALAR", &times);
        let is_spline = interpolation == "CUBICSPLINE";
        let key =
            |&x: &f32| if is_spline { vec![0.0, 0.0, 0.0, x, 0.0, 0.0, 0.0, 0.0, 0.0] } else { vec![x, 0.0, 0.0] };
        let output = maker.floats("VEC3", &values.iter().flat_map(key).collect::<Vec<f32>>());
        let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
        let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
        maker.push("animations", json!({ "samplers": [sampler], "channels": [channel] }));
        let asset = maker.load()?;
        same(&asset.warnings().len(), &0, "warnings")?;
        let before = f32::from_bits(1.0_f32.to_bits() - 1);
        let early = if interpolation == "STEP" { 0.0 } else { 4.0 };
        let middle = if interpolation == "STEP" { 6.0 } else { 7.0 };
        for (time, x) in [(-1.0, 0.0), (before, early), (1.0, 6.0), (1.5, middle), (2.0, 9.0), (3.0, 9.0)] {
            let found = origins(&asset, &[0], time)?[0];
            close(&found, &[x, 0.0, 0.0], 1e-6, &format!("{interpolation} at {time}"))?;
        }
    }
    Ok(())
}
