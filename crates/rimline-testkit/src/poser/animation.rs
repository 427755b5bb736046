//! Animations (glTF 2.0, section 3.11 and appendix C): the properties of nodes at a time.

use std::collections::HashMap;

use serde_json::Value;

use super::document::{Document, Values, index, list};

/// Values that an animation sets, by node and path.
pub(super) type Moved = HashMap<(usize, String), Vec<f64>>;

/// All that animation `number` sets at `time`.
pub(super) fn sample(document: &Document, number: usize, time: f64) -> Moved {
    let animation = &document.json["animations"][number];
    let mut moved = Moved::new();
    for channel in list(&animation["channels"]) {
        let (target, sampler) = (&channel["target"], &animation["samplers"][index(&channel["sampler"])]);
        let (Some(node), Some(path)) = (target["node"].as_u64(), target["path"].as_str()) else {
            continue;
        };
        moved.insert((node as usize, path.to_owned()), value(document, sampler, path == "rotation", time));
    }
    moved
}

/// A sampler's value at a time.
fn value(document: &Document, sampler: &Value, rotation: bool, time: f64) -> Vec<f64> {
    let times = document.accessor(&sampler["input"]).values;
    let Values { values, .. } = document.accessor(&sampler["output"]);
    let interpolation = sampler["interpolation"].as_str().unwrap_or("LINEAR");
    let parts = if interpolation == "CUBICSPLINE" { 3 } else { 1 };
    // Morph weights have as many values a key as there are targets, so the width is not the accessor's.
    let width = values.len() / times.len() / parts;
    // Part 0 is the in-tangent of a spline, 1 its value, 2 its out-tangent.
    let part = |key: usize, part: usize| &values[(key * parts + part) * width..][..width];
    let key_value = |key: usize| part(key, parts / 2);
    let last = times.len() - 1;
    if time <= times[0] {
        return key_value(0).to_vec();
    }
    if time >= times[last] {
        return key_value(last).to_vec();
    }
    let key = (0..last).rev().find(|&key| times[key] <= time).expect("the first key is earlier");
    let duration = times[key + 1] - times[key];
    let t = (time - times[key]) / duration;
    let (from, to) = (key_value(key), key_value(key + 1));
    match interpolation {
        "STEP" => from.to_vec(),
        "CUBICSPLINE" => {
            let (out_tangent, in_tangent) = (part(key, 2), part(key + 1, 0));
            let spline = |c: usize| {
                (2.0 * t.powi(3) - 3.0 * t.powi(2) + 1.0) * from[c]
                    + duration * (t.powi(3) - 2.0 * t.powi(2) + t) * out_tangent[c]
                    + (-2.0 * t.powi(3) + 3.0 * t.powi(2)) * to[c]
                    + duration * (t.powi(3) - t.powi(2)) * in_tangent[c]
            };
            // `Affine::from_trs` brings a rotation to length 1.
            (0..width).map(spline).collect()
        }
        _ if rotation => slerp(from, to, t),
        _ => from.iter().zip(to).map(|(from, to)| (1.0 - t) * from + t * to).collect(),
    }
}

/// Spherical linear interpolation along the shorter arc (C.4).
fn slerp(from: &[f64], to: &[f64], t: f64) -> Vec<f64> {
    let unit = |quaternion: &[f64]| -> Vec<f64> {
        let length = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
        quaternion.iter().map(|c| c / length).collect()
    };
    let (from, to) = (unit(from), unit(to));
    let dot: f64 = from.iter().zip(&to).map(|(a, b)| a * b).sum();
    let angle = dot.abs().min(1.0).acos();
    let (first, second) = if angle.sin() < 1e-6 {
        (1.0 - t, t)
    } else {
        ((angle * (1.0 - t)).sin() / angle.sin(), (angle * t).sin() / angle.sin())
    };
    from.iter().zip(&to).map(|(a, b)| first * a + dot.signum() * second * b).collect()
}
