//! Details of the specification, each with a file that only this detail decides.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use libtest_mimic::{Failed, Trial};
use rimline::gltf::SceneLight;
use serde_json::{Value, json};

use crate::check::{close, moved, said};
use crate::maker::Maker;
use crate::rows::{says, set};
use crate::{Outcome, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("details::duration_is_the_last_key_of_all_channels", duration),
        test("details::extras_are_not_read", extras),
        test("details::quaternions_of_any_length", quaternions),
        test("details::last_rows_up_to_rounding", last_rows),
        test("details::lights", lights),
    ]
}

fn duration() -> Outcome {
    let mut maker = Maker::square();
    let [long, short] = [3.0, 2.0].map(|end| maker.keys(&[0.0, end], "VEC3", &[0.0; 6], "LINEAR"));
    maker.animate(0, "translation", &long);
    maker.json["animations"][0]["samplers"] = json!([long, short]);
    set(&mut maker, "animations[0].channels[1]", "{'sampler': 1, 'target': {'node': 0, 'path': 'scale'}}");
    same(&maker.load()?.animations()[0].duration_s, &3.0, "duration")
}

fn extras() -> Outcome {
    let mut maker = Maker::square();
    set(&mut maker, "materials[0].extras.aTexture.index", "-1");
    same(&said(&maker.load()?), &vec![], "warnings")
}

/// Their squares are beyond what a number holds.
fn quaternions() -> Outcome {
    for length in [1e-200, 1e200, 1.0] {
        let mut maker = Maker::square();
        maker.json["nodes"][0]["rotation"] = json!([0.0, 0.0, 0.6 * length, 0.8 * length]);
        // Twice the angle of cosine 0.8: cosine 0.28, sine 0.96.
        close(&moved(&maker.load()?, 0, [1.0, 0.0, 0.0])?, &[0.28, 0.96, 0.0], 1e-6, &format!("length {length}"))?;
    }
    Ok(())
}

/// A last row that is off by rounding is as good as the exact one.
fn last_rows() -> Outcome {
    for (off, is_good) in [(0.0, true), (9e-6, true), (2e-5, false), (1e-3, false)] {
        for entry in [3, 7, 11, 15] {
            let mut maker = Maker::square();
            let mut matrix: Vec<f64> = (0..16).map(|i| if i % 5 == 0 { 1.0 } else { 0.0 }).collect();
            matrix[entry] -= off;
            maker.json["nodes"][0]["matrix"] = json!(matrix);
            match maker.load() {
                Ok(asset) if is_good => close(&moved(&asset, 0, [1.0, 2.0, 3.0])?, &[1.0, 2.0, 3.0], 0.0, "a point")?,
                Err(error) if !is_good && says(&error.to_string(), "nodes[0].matrix|last row") => {}
                other => return Err(format!("entry {entry}, {off} off: {other:?}").into()),
            }
        }
    }
    Ok(())
}

/// A light on a node of this scale.
fn light(light: &Value, scale: [f64; 3]) -> Result<SceneLight, Failed> {
    let mut maker = Maker::new();
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let extensions = json!({ "KHR_lights_punctual": { "light": 0 } });
    maker.push("nodes", json!({ "scale": scale, "extensions": extensions }));
    Ok(maker.load()?.lights(None, 0.0)?.remove(0))
}

/// Lights as files give them, up to the edge of what is allowed, and with properties left out.
fn lights() -> Outcome {
    for (given, expected) in [
        (json!({ "type": "point" }), ([1.0; 3], 1.0, None)),
        (
            json!({ "type": "spot", "color": [1, 0.5, 0], "intensity": 40, "range": 7 }),
            ([1.0, 0.5, 0.0], 40.0, Some(7.0)),
        ),
        // A range at infinity.
        (json!({ "type": "directional", "range": 3, "intensity": 2 }), ([1.0; 3], 2.0, None)),
        // More and less than `f32` holds.
        (
            json!({ "type": "point", "intensity": 1e300, "range": 1e-300, "color": [1e300, 0, 0] }),
            ([f32::MAX, 0.0, 0.0], f32::MAX, Some(f32::MIN_POSITIVE)),
        ),
    ] {
        let SceneLight { color, intensity, range, .. } = light(&given, [2.0; 3])?;
        same(&(color, intensity, range), &expected, &given.to_string())?;
    }
    for (spot, angles) in [
        (json!({}), [0.0, FRAC_PI_4]),
        (json!({ "innerConeAngle": 0.25, "outerConeAngle": 0.5 }), [0.25, 0.5]),
        // Without a soft rim.
        (json!({ "innerConeAngle": 0.5, "outerConeAngle": 0.5 }), [0.5, 0.5]),
        // Half a turn, rounded up on export.
        (json!({ "outerConeAngle": f64::from(FRAC_PI_2) + 9e-6 }), [0.0, FRAC_PI_2]),
    ] {
        let cone = light(&json!({ "type": "spot", "spot": spot }), [1.0, 1.0, 5.0])?.cone.ok_or("no cone")?;
        same(&[cone.inner_angle, cone.outer_angle], &angles, "angles of a cone")?;
        same(&cone.direction, &[0.0, 0.0, -1.0], "its direction, of a stretched node")?;
    }
    // Squares of the scale are beyond what a number holds.
    for scale in [1e-200, 1e200] {
        let cone = light(&json!({ "type": "spot" }), [scale; 3])?.cone;
        same(&cone.map(|cone| cone.direction), &Some([0.0, 0.0, -1.0]), &format!("spot light, {scale:e}"))?;
        let sun = light(&json!({ "type": "directional" }), [scale; 3])?.light;
        same(&sun.to_array(), &[0.0, 0.0, 1.0, 0.0], &format!("directional light, {scale:e}"))?;
    }
    let none = [light(&json!({ "type": "point" }), [1.0; 3])?, light(&json!({ "type": "spot" }), [1.0, 1.0, 0.0])?];
    ensure(none.iter().all(|light| light.cone.is_none()), || format!("cones of a point and of a flat node: {none:?}"))
}
