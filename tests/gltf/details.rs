//! Details of the specification, each with a file that only this detail decides. Each test catches a change of the loader
//! that no other test notices.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use libtest_mimic::{Failed, Trial};
use rimline::gltf::{Asset, SceneLight};
use rimline::mesh::Weld;
use rimline_testkit::refusals::{self, refusal};
use serde_json::{Value, json};

use crate::check::{close, moved, said};
use crate::maker::{Maker, SQUARE, U8, U16};
use crate::rows::{copy_primitive, primitive, set};
use crate::shape::same;
use crate::{Outcome, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("details::duration_is_the_last_key_of_all_channels", duration),
        test("details::a_buffer_one_byte_short", one_byte_short),
        test("details::data_uris_in_capitals", capitals),
        test("details::byte_order_mark", byte_order_mark),
        test("details::other_joints_are_other_vertices", other_joints),
        test("details::other_targets_are_other_vertices", other_targets),
        test("details::children_keep_their_order", children),
        test("details::joints_out_of_range_in_a_later_primitive", later_joint),
        test("details::extras_are_not_read", extras),
        test("details::quaternions_of_any_length", quaternions),
        test("details::last_rows_up_to_rounding", last_rows),
        test("details::lights", lights),
        test("details::joints_that_a_palette_needs", joints_needed),
        test("details::sparse_offsets", sparse_offsets),
        test("details::normalised_where_it_must_be", normalised),
    ]
}

fn refused(maker: &Maker, parts: &[&str]) -> Outcome {
    Ok(refusals::refused([refusal("the file", maker.load(), refusals::says(parts))])?)
}

fn duration() -> Outcome {
    let mut maker = Maker::square();
    let [long, short] = [3.0, 2.0].map(|end| maker.keys(&[0.0, end], "VEC3", &[0.0; 6], "LINEAR"));
    maker.animate(0, "translation", &long);
    let samplers = json!([long, short]);
    maker.json["animations"][0]["samplers"] = samplers;
    set(&mut maker, "animations[0].channels[1]", "{'sampler': 1, 'target': {'node': 0, 'path': 'scale'}}");
    same(&maker.load()?.animations()[0].duration_s, &3.0, "duration")
}

/// No view reaches the byte that is missing, and the buffer is refused for it.
fn one_byte_short() -> Outcome {
    let mut maker = Maker::square();
    let uri = format!("data:,{}", "A".repeat(maker.bytes.len()));
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len() + 1, "uri": uri }]);
    refused(&maker, &["buffers[0].byteLength"])?;
    maker.json["buffers"][0]["byteLength"] = json!(maker.bytes.len());
    // The letters are no good indices, so it gets that far.
    refused(&maker, &["meshes[0].primitives[0]: index 0", "4 vertices"])
}

/// Scheme and parameters of a URI are the same in capitals (RFC 3986, section 3.1; RFC 2045, section 6.1).
fn capitals() -> Outcome {
    let maker = Maker::square();
    let text = String::from_utf8(maker.gltf()).map_err(|error| error.to_string())?;
    let loud = text.replace("data:application/octet-stream;base64,", "DATA:application/octet-stream;BASE64,");
    ensure(loud != text, || "nothing was changed".to_owned())?;
    let asset = Asset::from_slice(loud.as_bytes(), None, Weld::Keep)?;
    same(asset.model(), maker.load()?.model(), "model")
}

fn byte_order_mark() -> Outcome {
    let maker = Maker::square();
    let text = [&b"\xef\xbb\xbf"[..], &maker.gltf()].concat();
    same(Asset::from_slice(&text, None, Weld::Keep)?.model(), maker.load()?.model(), "model")
}

fn other_joints() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [1.0, 0.0, 0.0, 0.0]);
    let joints = maker.accessor(U8, "VEC4", 4, &[1, 0, 0, 0].repeat(4));
    copy_primitive(&mut maker)["attributes"]["JOINTS_0"] = json!(joints);
    let asset = maker.load()?;
    let influences = asset.model().geometries()[0].influences().ok_or("no influences")?;
    same(&influences.joints().to_vec(), &vec![0, 0, 0, 0, 1, 1, 1, 1], "joints")
}

fn other_targets() -> Outcome {
    let mut maker = Maker::square();
    let targets = [1.0, 2.0].map(|by| maker.floats("VEC3", &[by; 12]));
    primitive(&mut maker)["targets"] = json!([{ "POSITION": targets[0] }]);
    copy_primitive(&mut maker)["targets"] = json!([{ "POSITION": targets[1] }]);
    let found = maker.load()?.model().geometries()[0].morph_targets().to_vec();
    same(&found, &vec![[vec![[1.0; 3]; 4], vec![[2.0; 3]; 4]].concat()], "offsets")
}

fn children() -> Outcome {
    let mut maker = Maker::square();
    maker.json["nodes"] = json!([
        { "name": "top", "mesh": 0, "children": [2, 1] },
        { "name": "b", "mesh": 0 },
        { "name": "a", "mesh": 0, "children": [3] },
        { "name": "below a", "mesh": 0 },
    ]);
    let asset = maker.load()?;
    let names: Vec<_> = asset.model().instances().iter().filter_map(|instance| instance.name()).collect();
    same(&names, &vec!["top", "a", "below a", "b"], "instances")
}

fn later_joint() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    let joints = maker.accessor(U8, "VEC4", 4, &[0, 7, 0, 0].repeat(4));
    copy_primitive(&mut maker)["attributes"]["JOINTS_0"] = json!(joints);
    refused(&maker, &["meshes[0].primitives[1].attributes.JOINTS_0", "joint 7"])
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

fn last_rows() -> Outcome {
    for (off, good) in [(0.0, true), (9e-6, true), (2e-5, false), (1e-3, false)] {
        for entry in [3, 7, 11, 15] {
            let mut maker = Maker::square();
            let mut matrix: Vec<f64> = (0..16).map(|i| if i % 5 == 0 { 1.0 } else { 0.0 }).collect();
            matrix[entry] -= off;
            maker.json["nodes"][0]["matrix"] = json!(matrix);
            if good {
                close(
                    &moved(&maker.load()?, 0, [1.0, 2.0, 3.0])?,
                    &[1.0, 2.0, 3.0],
                    0.0,
                    "the last row is as good as exact",
                )?;
            } else {
                refused(&maker, &["nodes[0].matrix", "last row"])?;
            }
        }
    }
    Ok(())
}

/// A light on a node of this scale.
fn light(light: &Value, scale: [f32; 3]) -> Result<SceneLight, Failed> {
    let mut maker = Maker::new();
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let extensions = json!({ "KHR_lights_punctual": { "light": 0 } });
    maker.push("nodes", json!({ "scale": scale, "extensions": extensions }));
    Ok(maker.load()?.lights(None, 0.0)?.remove(0))
}

/// Lights as files give them, up to the edge of what is allowed, and with properties left out.
fn lights() -> Outcome {
    let colour = |given: Value| {
        let SceneLight { color, intensity, range, .. } = light(&given, [2.0; 3])?;
        Ok::<_, Failed>((color, intensity, range))
    };
    same(&colour(json!({ "type": "point" }))?, &([1.0; 3], 1.0, None), "a plain light")?;
    let warm = json!({ "type": "spot", "color": [1, 0.5, 0], "intensity": 40, "range": 7 });
    same(&colour(warm)?, &([1.0, 0.5, 0.0], 40.0, Some(7.0)), "a warm one")?;
    let sun = json!({ "type": "directional", "range": 3, "intensity": 2 });
    same(&colour(sun)?, &([1.0; 3], 2.0, None), "a range at infinity")?;
    let bright = json!({ "type": "point", "intensity": 1e300, "range": 1e-300, "color": [1e300, 0, 0] });
    let expected = ([f32::MAX, 0.0, 0.0], f32::MAX, Some(f32::MIN_POSITIVE));
    same(&colour(bright)?, &expected, "one that f32 does not hold")?;
    for (spot, angles) in [
        (json!({}), Some([0.0, FRAC_PI_4])),
        (json!({ "innerConeAngle": 0.25, "outerConeAngle": 0.5 }), Some([0.25, 0.5])),
        // Without a soft rim.
        (json!({ "innerConeAngle": 0.5, "outerConeAngle": 0.5 }), Some([0.5, 0.5])),
        // Half a turn, rounded up on export.
        (json!({ "outerConeAngle": f64::from(FRAC_PI_2) + 9e-6 }), Some([0.0, FRAC_PI_2])),
    ] {
        let cone = light(&json!({ "type": "spot", "spot": spot }), [1.0, 1.0, 5.0])?.cone;
        same(&cone.map(|cone| [cone.inner_angle, cone.outer_angle]), &angles, "angles of a cone")?;
        same(&cone.map(|cone| cone.direction), &Some([0.0, 0.0, -1.0]), "its direction, of a stretched node")?;
    }
    same(&light(&json!({ "type": "point" }), [1.0; 3])?.cone, &None, "no cone")?;
    same(&light(&json!({ "type": "spot" }), [1.0, 1.0, 0.0])?.cone, &None, "the cone of a flat node")
}

fn joints_needed() -> Outcome {
    let needed = |maker: &Maker| maker.load().map(|asset| asset.model().geometries()[0].joints_needed());
    same(&needed(&Maker::square())?, &1, "rigid")?;
    same(&needed(&Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]))?, &2, "two joints")?;
    let mut none = Maker::skinned([0; 4], [1.0; 4]);
    primitive(&mut none)["mode"] = json!(0);
    same(&needed(&none)?, &0, "skinned without vertices")
}

/// Both byte offsets of sparse data; the values' view has a stranger before them, the indices', too.
fn sparse_offsets() -> Outcome {
    let mut maker = Maker::square();
    let indices = maker.view(&[3, 0, 1, 0, 2, 0]);
    let values: Vec<u8> =
        [9.0_f32, 9.0, 9.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let values = maker.view(&values);
    maker.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "byteOffset": 2, "componentType": U16 },
        "values": { "bufferView": values, "byteOffset": 12 },
    });
    let mut expected = SQUARE.as_chunks().0.to_vec();
    expected[1] = [4.0, 5.0, 6.0];
    expected[2] = [7.0, 8.0, 9.0];
    same(&maker.load()?.model().geometries()[0].positions().to_vec(), &expected, "positions")
}

/// Joints and indices are never normalised, weights of integers always are.
fn normalised() -> Outcome {
    let with = |accessor: &str, normalized: bool| {
        let mut maker = Maker::skinned([0, 1, 0, 0], [1.0, 0.0, 0.0, 0.0]);
        let weights = maker.accessor(U8, "VEC4", 4, &[255, 0, 0, 0].repeat(4));
        maker.json["accessors"][weights]["normalized"] = json!(true);
        let primitive = primitive(&mut maker);
        primitive["attributes"]["WEIGHTS_0"] = json!(weights);
        let at = if accessor == "indices" { &primitive["indices"] } else { &primitive["attributes"][accessor] };
        let at = at.as_u64().expect("an index") as usize;
        maker.json["accessors"][at]["normalized"] = json!(normalized);
        maker
    };
    for (accessor, right) in [("JOINTS_0", false), ("WEIGHTS_0", true), ("indices", false)] {
        with(accessor, right).load()?;
        refused(&with(accessor, !right), &[accessor, "expected"])?;
    }
    Ok(())
}
