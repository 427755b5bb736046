//! Changes that spoil a square without a need to refuse it, and texts that the warning must contain.

use serde_json::{Value, json};

use crate::maker::{Maker, SQUARE, U8, U16, U32};
use crate::refuse::primitive;
use crate::refuse_square::set_indices;

/// Name, what spoils a square, what the one warning must say, and how many faces are left.
pub(crate) type Row = (&'static str, fn(&mut Maker), &'static [&'static str], usize);

/// None of these is needed to show the square.
pub(crate) const UNUSED: &[Row] = &[
    ("skin", |m| add(m, "skins", json!({ "joints": [] })), &["skins[0].joints is missing"], 2),
    ("skin_reference", |m| add(m, "skins", json!({ "joints": [7] })), &["skins[0].joints[0] is 7"], 2),
    ("skins_no_list", |m| m.json["skins"] = Value::Null, &["skins", "an array", "null"], 2),
    ("skin_no_object", |m| add(m, "skins", json!(3)), &["skins[0]", "an object"], 2),
    ("inverse_binds", unused_skin, &["skins[0].inverseBindMatrices, matrix 0", "last row"], 2),
    ("animations_no_list", |m| m.json["animations"] = json!({}), &["animations", "an array"], 2),
    ("light", |m| light(m, &json!({ "type": "area" })), &["lights[0].type", "directional, point or spot"], 2),
    ("light_extension", |m| m.json["extensions"] = json!({ "KHR_lights_punctual": 1 }), &["KHR_lights_punctual"], 2),
    ("light_of_a_node", dangling_light, &["nodes[0].extensions.KHR_lights_punctual.light is 4", "0 lights"], 2),
    ("mesh", |m| other_mesh(m, json!({ "primitives": 1 })), &["meshes[1].primitives", "an array"], 2),
    ("mesh_no_object", |m| other_mesh(m, json!(1)), &["meshes[1]", "an object"], 2),
    ("mesh_data", unused_mesh, &["meshes[1].primitives[0]", "is 9", "4 vertices"], 2),
    ("mesh_of_another_scene", other_scene, &["meshes[1].primitives[0].attributes.JOINTS_0"], 2),
    ("node_of_another_scene", |m| other_node(m, json!({ "mesh": 9 })), &["nodes[1].mesh is 9"], 2),
    ("cycle_of_another_scene", |m| other_node(m, json!({ "children": [1] })), &["nodes[1]", "ancestor"], 2),
    ("another_scene", |m| scenes(m, json!([{ "nodes": [0] }, { "nodes": [9] }])), &["scenes[1].nodes[0] is 9"], 2),
    ("accessor", |m| add(m, "accessors", json!({ "componentType": 5130 })), &["accessors[2].", "type"], 2),
    ("view", |m| add(m, "bufferViews", json!({ "buffer": 9, "byteLength": 1 })), &["bufferViews[2].buffer is 9"], 2),
    ("long_view", |m| add(m, "bufferViews", json!({ "buffer": 0, "byteLength": 999 })), &["bufferViews[2]", "999"], 2),
    ("joints_without_a_skin", |m| attribute(m, "JOINTS_0"), &["attributes.WEIGHTS_0 is missing"], 2),
    ("points", points, &["accessors[2], used as meshes[0].primitives[1].targets[0].POSITION", "U8 Vec3"], 2),
    ("texture", texture, &["materials[0].normalTexture.index", "true"], 2),
    ("name", |m| m.json["nodes"][0]["name"] = json!(7), &["nodes[0].name", "a string"], 2),
    ("skin_of_no_mesh", |m| other_node(m, json!({ "skin": 4 })), &["nodes[1].skin is 4"], 2),
    ("used_no_list", |m| m.json["extensionsUsed"] = json!(1), &["extensionsUsed", "an array"], 2),
];

/// These are read all the same.
pub(crate) const SLIPS: &[Row] = &[
    ("rotation", |m| m.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]), &["nodes[0].rotation", "no rotation"], 2),
    ("corners", |m| m.json["accessors"][1]["count"] = json!(5), &["5 corners", "last 2 are left out"], 1),
    (
        "mesh_weights",
        |m| m.json["meshes"][0]["weights"] = json!([1]),
        &["meshes[0].weights has 1", "no morph targets"],
        2,
    ),
    (
        "node_weights",
        |m| m.json["nodes"][0]["weights"] = json!([1]),
        &["nodes[0].weights has 1", "no morph targets"],
        2,
    ),
    ("restart_u8", |m| set_indices(m, U8, &[0, 1, 255, 1, 2, 3]), &["index 2", "value 255", "as a restart"], 1),
    ("restart_u16", |m| set_indices(m, U16, &[0, 1, 2, 65535, 1, 2]), &["index 3", "value 65535", "restart"], 1),
    ("restart_u32", |m| set_indices(m, U32, &[u32::MAX, 1, 2]), &["index 0", "value 4294967295", "restart"], 0),
    ("nan_position", |m| positions(m, 7, f32::NAN), &["primitives[0].attributes.POSITION: 1 positions", "vertex 2"], 2),
    ("infinite_position", |m| positions(m, 0, f32::INFINITY), &["attributes.POSITION: 1 positions", "vertex 0"], 2),
    ("nan_target", nan_target, &["targets[0].POSITION: 1 offsets", "first that of vertex 2"], 2),
    ("extension", |m| m.json["extensionsUsed"] = json!(["ACME_fold", "ACME_fold"]), &["ACME_fold", "not read"], 2),
    ("child_twice", child_twice, &["nodes[1] is a child of nodes[0] and again of nodes[0]"], 2),
];

fn add(maker: &mut Maker, list: &str, value: Value) {
    maker.push(list, value);
}

fn unused_skin(maker: &mut Maker) {
    let binds = maker.floats("MAT4", &[0.0; 16]);
    maker.push("skins", json!({ "joints": [0], "inverseBindMatrices": binds }));
}

fn light(maker: &mut Maker, light: &Value) {
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
}

fn dangling_light(maker: &mut Maker) {
    maker.json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 4 } });
}

pub(crate) fn scenes(maker: &mut Maker, scenes: Value) {
    maker.json["scenes"] = scenes;
}

/// A node that the only scene does not hold.
fn other_node(maker: &mut Maker, node: Value) {
    scenes(maker, json!([{ "nodes": [0] }]));
    maker.push("nodes", node);
}

fn other_mesh(maker: &mut Maker, mesh: Value) {
    scenes(maker, json!([{ "nodes": [0] }]));
    maker.push("meshes", mesh);
}

fn unused_mesh(maker: &mut Maker) {
    scenes(maker, json!([{ "nodes": [0] }]));
    let indices = maker.indices(U8, &[0, 1, 9]);
    maker.mesh(&json!({ "attributes": { "POSITION": 0 }, "indices": indices }));
}

/// A skinned mesh whose joints are none, in a scene that is not shown.
fn other_scene(maker: &mut Maker) {
    scenes(maker, json!([{ "nodes": [0] }, { "nodes": [1] }]));
    let joints = maker.accessor(U8, "VEC4", 4, &[9; 16]);
    let weights = maker.floats("VEC4", &[1.0; 16]);
    let mesh =
        maker.mesh(&json!({ "attributes": { "POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights }, "mode": 5 }));
    maker.push("skins", json!({ "joints": [0] }));
    maker.push("nodes", json!({ "mesh": mesh, "skin": 0 }));
}

fn attribute(maker: &mut Maker, name: &str) {
    primitive(maker)["attributes"][name] = json!(0);
}

/// Points of a mesh that is shown. Their offsets have the wrong type.
fn points(maker: &mut Maker) {
    let short = maker.accessor(U8, "VEC3", 4, &[0; 12]);
    let mut points = json!({ "attributes": { "POSITION": 0 }, "mode": 0 });
    points["targets"] = json!([{ "POSITION": short }]);
    primitive(maker)["targets"] = json!([{}]);
    maker.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(points);
}

fn texture(maker: &mut Maker) {
    maker.json["materials"] = json!([{ "normalTexture": { "index": true } }]);
}

fn positions(maker: &mut Maker, at: usize, value: f32) {
    let mut positions = SQUARE;
    positions[at] = value;
    let positions = maker.floats("VEC3", &positions);
    primitive(maker)["attributes"]["POSITION"] = json!(positions);
}

fn nan_target(maker: &mut Maker) {
    let mut offsets = [0.0; 12];
    offsets[7] = f32::NAN;
    let target = maker.floats("VEC3", &offsets);
    primitive(maker)["targets"] = json!([{ "POSITION": target }]);
}

fn child_twice(maker: &mut Maker) {
    maker.json["nodes"] = json!([{ "children": [1, 1] }, { "mesh": 0 }]);
}
