//! Changes that spoil a skinned square or an animation, and texts that the error must contain.

use serde_json::{Value, json};

use crate::maker::Maker;
use crate::refuse::{Row, instanced, primitive};

pub(crate) const SKINNED: &[Row] = &[
    ("no_weights", |m| remove(m, "WEIGHTS_0"), &["meshes[0].primitives[0].attributes.WEIGHTS_0 is missing"]),
    ("no_joints", |m| remove(m, "JOINTS_0"), &["meshes[0].primitives[0].attributes.JOINTS_0 is missing"]),
    ("unskinned", |m| remove_both(m), &["nodes[0]", "meshes[0].primitives[0]", "JOINTS_0"]),
    ("joints_count", |m| m.json["accessors"][2]["count"] = json!(3), &["JOINTS_0 has 3 elements, expected 4"]),
    (
        "joints_type",
        |m| m.json["accessors"][2]["componentType"] = json!(5120),
        &["accessors[2]", "JOINTS_0", "I8 Vec4"],
    ),
    ("no_skin_joints", |m| m.json["skins"][0]["joints"] = json!([]), &["skins[0].joints is missing"]),
    ("joint_range", joint_range, &["JOINTS_0, vertex 0 names joint 1", "skins[0] of nodes[0] has 1 joints"]),
    ("negative_weight", |m| set_weights(m, -0.5), &["WEIGHTS_0, vertex 3", "-0.5"]),
    ("infinite_weight", |m| set_weights(m, f32::INFINITY), &["WEIGHTS_0, vertex 3", "inf"]),
    ("nan_weight", |m| set_weights(m, f32::NAN), &["WEIGHTS_0, vertex 3", "NaN"]),
    ("binds_count", |m| binds(m, &[0.0; 16]), &["skins[0].inverseBindMatrices", "1 elements, expected 2"]),
    ("binds_row", |m| binds(m, &[1.0; 32]), &["skins[0].inverseBindMatrices, matrix 0", "last row"]),
    ("binds_nan", |m| binds(m, &[f32::NAN; 32]), &["skins[0].inverseBindMatrices, matrix 0", "not finite"]),
    ("instanced", instanced_skin, &["nodes[0]", "EXT_mesh_gpu_instancing", "skin"]),
];

/// Changes that spoil the animation of [`everything`]: samplers are rotation, cubic translation, step weights.
pub(crate) const ANIMATED: &[Row] = &[
    ("sampler", |m| animation(m)["channels"][0]["sampler"] = json!(3), &["animations[0].channels[0].sampler is 3"]),
    ("path", |m| animation(m)["channels"][0]["target"] = json!({}), &["channels[0].target.path is missing"]),
    ("interpolation", |m| animation(m)["samplers"][0]["interpolation"] = json!("X"), &["samplers[0].interpolation"]),
    (
        "times_order",
        |m| times(m, &[0.0, 2.0, 1.0]),
        &["animations[0].samplers[0]", "key 2 is at 1 s, before key 1 at 2 s"],
    ),
    ("no_object", |m| m.json["animations"][0] = json!(5), &["animations[0]", "an object"]),
    ("channels_no_list", |m| animation(m)["channels"] = json!({}), &["animations[0].channels", "an array"]),
    (
        "dangling_node",
        |m| animation(m)["channels"][0]["target"]["node"] = json!(99),
        &["channels[0].target.node is 99"],
    ),
    ("times_nan", |m| times(m, &[0.0, f32::NAN, 1.0]), &["animations[0].samplers[0]", "time of key 1"]),
    ("times_none", |m| times(m, &[]), &["animations[0].samplers[0]", "no keyframes"]),
    ("few_values", |m| times(m, &[0.0, 1.0]), &["animations[0].samplers[0]", "12 output values for 2 keys"]),
    ("values_nan", values_nan, &["animations[0].samplers[0]", "output of key 1 is not finite"]),
    ("values_type", |m| animation(m)["samplers"][1]["output"] = json!(0), &["animations[0].samplers[1]"]),
    ("no_rotation", no_rotation, &["animations[0].samplers[0]", "rotation of key 2 has no length"]),
    ("on_matrix", on_matrix, &["animations[0].channels[0]", "nodes[1]", "matrix"]),
];

fn animation(maker: &mut Maker) -> &mut Value {
    &mut maker.json["animations"][0]
}

fn instanced_skin(maker: &mut Maker) {
    instanced(maker, &[1.0; 6]);
}

fn remove(maker: &mut Maker, attribute: &str) {
    primitive(maker)["attributes"].as_object_mut().expect("an object").remove(attribute);
}

fn remove_both(maker: &mut Maker) {
    remove(maker, "JOINTS_0");
    remove(maker, "WEIGHTS_0");
}

fn joint_range(maker: &mut Maker) {
    maker.json["skins"][0]["joints"] = json!([1]);
}

fn set_weights(maker: &mut Maker, last: f32) {
    let mut weights = [1.0; 16];
    weights[15] = last;
    let weights = maker.floats("VEC4", &weights);
    primitive(maker)["attributes"]["WEIGHTS_0"] = json!(weights);
}

fn binds(maker: &mut Maker, matrices: &[f32]) {
    let binds = maker.floats("MAT4", matrices);
    maker.json["skins"][0]["inverseBindMatrices"] = json!(binds);
}

fn times(maker: &mut Maker, times: &[f32]) {
    let times = maker.floats("SCALAR", times);
    animation(maker)["samplers"][0]["input"] = json!(times);
}

fn rotations(maker: &mut Maker, at: usize, value: f32) {
    let mut rotations = [0.0; 12];
    rotations[3] = 1.0;
    rotations[7] = 1.0;
    rotations[at] = value;
    let rotations = maker.floats("VEC4", &rotations);
    animation(maker)["samplers"][0]["output"] = json!(rotations);
}

fn values_nan(maker: &mut Maker) {
    rotations(maker, 5, f32::NAN);
}

fn no_rotation(maker: &mut Maker) {
    rotations(maker, 5, 0.5);
}

fn on_matrix(maker: &mut Maker) {
    let identity: Vec<u32> = (0..16).map(|i| u32::from(i % 5 == 0)).collect();
    maker.json["nodes"][1] = json!({ "matrix": identity });
}
