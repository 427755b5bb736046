//! Changes that spoil a good file, and texts that the error or the only warning must contain.

use serde_json::{Value, json};

use crate::maker::{Maker, U8, U16, U32};
use Change::{Make, Set};

/// A change of a good file.
#[derive(Clone, Copy)]
pub(crate) enum Change {
    /// Properties, by their paths, are set to JSON, which has single quotes here. An index past the end appends.
    Set(&'static [(&'static str, &'static str)]),
    /// Another change.
    Make(fn(&mut Maker)),
}

/// Name, change, and what the error or warning must say: parts between bars.
pub(crate) type Row = (&'static str, Change, &'static str);

impl Change {
    pub(crate) fn apply(self, maker: &mut Maker) {
        match self {
            Set(properties) => properties.iter().for_each(|(path, json)| set(maker, path, json)),
            Make(change) => change(maker),
        }
    }
}

/// The text has all parts between the bars.
pub(crate) fn says(text: &str, parts: &str) -> bool {
    parts.split('|').all(|part| text.contains(part))
}

pub(crate) fn set(maker: &mut Maker, path: &str, json: &str) {
    let mut at = &mut maker.json;
    for key in path.split(['.', '[']) {
        at = match key.strip_suffix(']') {
            None => &mut at[key],
            Some(index) => {
                let index: usize = index.parse().expect("an index");
                if at.is_null() {
                    *at = json!([]);
                }
                let list = at.as_array_mut().expect("a list");
                list.resize(list.len().max(index + 1), Value::Null);
                &mut list[index]
            }
        };
    }
    *at = serde_json::from_str(&json.replace('\'', "\"")).expect(json);
}

/// These spoil a square.
pub(crate) const SQUARE: &[Row] = &[
    ("version", Set(&[("asset.version", "'1.0'")]), "version 1.0"),
    ("min_version", Set(&[("asset.minVersion", "'2.1'")]), "version 2.1"),
    ("no_asset", Set(&[("asset", "{}")]), "asset.version is missing"),
    ("negative_index", Set(&[("nodes[0].mesh", "-1")]), "nodes[0].mesh|an index|found -1"),
    ("dangling_mesh", Set(&[("nodes[0].mesh", "5")]), "nodes[0].mesh is 5|1 meshes"),
    ("dangling_scene", Set(&[("scene", "0")]), "scene is 0|0 scenes"),
    ("dangling_child", Set(&[("nodes[0].children", "[9]")]), "nodes[0].children[0] is 9|1 nodes"),
    ("nodes_no_list", Set(&[("nodes", "{}")]), "nodes|an array|an object"),
    ("cycle", Set(&[("nodes", "[{}, {'children': [2]}, {'children': [1]}]")]), "nodes[1]|ancestor"),
    ("matrix_length", Set(&[("nodes[0].matrix", "[1, 2]")]), "nodes[0].matrix|2 elements, expected 16"),
    ("mode", Set(&[("meshes[0].primitives[0].mode", "7")]), "meshes[0].primitives[0].mode|found 7"),
    ("component", Set(&[("accessors[0].componentType", "5130")]), "accessors[0].componentType|5130"),
    ("count_fraction", Set(&[("accessors[0].count", "1.5")]), "accessors[0].count|1.5"),
    ("huge_count", Set(&[("accessors[0].count", "18446744073709551615")]), "accessors[0]|bufferViews[0]"),
    ("huge_offset", Set(&[("accessors[0].byteOffset", "18446744073709551615")]), "accessors[0]|bufferViews[0]"),
    ("one_byte_over", Set(&[("accessors[0].byteOffset", "1")]), "needs 49 bytes|has 48"),
    ("huge_view_offset", Set(&[("bufferViews[0].byteOffset", "18446744073709551615")]), "bufferViews[0]"),
    ("small_stride", Set(&[("bufferViews[0].byteStride", "0")]), "byteStride 0|bufferViews[0]"),
    ("huge_stride", Set(&[("bufferViews[0].byteStride", "18446744073709551615")]), "bufferViews[0]|has 48"),
    ("strip_range", Make(|m| set_indices(m, U8, &[0, 1, 2, 9], 5)), "index 3 (face 1, corner 1) is 9"),
    ("target_counts", Set(&[TARGET, (SECOND, "{'attributes': {}}")]), "primitives[1].targets|0 elements, expected 1"),
    ("mesh_weights", Set(&[TARGET, ("meshes[0].weights", "[1, 1]")]), "meshes[0].weights|2 elements, expected 1"),
    ("node_weights", Set(&[TARGET, ("nodes[0].weights", "[1, 1]")]), "nodes[0].weights|2 elements, expected 1"),
    (
        "visibility",
        Set(&[("nodes[0].extensions.KHR_node_visibility.visible", "'no'")]),
        "nodes[0].extensions.KHR_node_visibility.visible|true or false|\"no\"",
    ),
    ("no_center", Set(&[("extensions.CESIUM_RTC", "{}")]), "extensions.CESIUM_RTC.center is missing"),
    ("short_center", Set(&[("extensions.CESIUM_RTC.center", "[1, 2]")]), "CESIUM_RTC.center has 2 elements"),
    ("sparse_order", Make(|m| m.sparse(0, &[2, 1], &[0.0; 6])), "accessors[0]|sparse index 1 is 1"),
    ("sparse_twice", Make(|m| m.sparse(0, &[1, 1], &[0.0; 6])), "accessors[0]|sparse index 1 is 1|must increase"),
    ("sparse_range", Make(|m| m.sparse(0, &[2, 4], &[0.0; 6])), "accessors[0]|sparse index 1 is 4"),
    ("sparse_count", Make(|m| m.sparse(0, &[0; 5], &[0.0; 15])), "accessors[0]|it replaces 5 elements of 4"),
    ("extension", Set(&[("extensionsRequired", "['ACME_fold']")]), "ACME_fold|not supported"),
    ("extension_prefix", Set(&[("extensionsRequired", "['KHR_material']")]), "KHR_material|not supported"),
    ("meshopt", Make(meshopt), "EXT_meshopt_compression|bufferViews[0]|decompress"),
    // The plain data is left out, though the extension is not required.
    (
        "draco_without_data",
        Set(&[
            ("meshes[0].primitives[0].extensions.KHR_draco_mesh_compression", "{'bufferView': 0, 'attributes': {}}"),
            ("accessors[0]", "{'componentType': 5126, 'type': 'VEC3', 'count': 4}"),
        ]),
        "KHR_draco_mesh_compression|meshes[0].primitives[0]|decompress",
    ),
    // The GLB's binary chunk is buffer 0 and no other.
    (
        "no_data",
        Set(&[("buffers", "[{'byteLength': 60}, {'byteLength': 60}]"), ("bufferViews[0].buffer", "1")]),
        "buffers[1] has no data",
    ),
    // No sum of offsets overflows, where no data says how far a view can reach.
    (
        "far_no_data",
        Set(&[
            ("buffers", "[{'byteLength': 60}, {'byteLength': 18446744073709551615}]"),
            ("bufferViews[0]", "{'buffer': 1, 'byteOffset': 18446744073709551615, 'byteLength': 100}"),
            ("accessors[0].byteOffset", "8"),
        ]),
        "buffers[1] has no data",
    ),
    ("web_uri", Make(|m| uri(m, "https://example.org/a.bin")), "buffers[0].uri|https:|absolute"),
    ("network_uri", Make(|m| uri(m, "//host/a.bin")), "buffers[0].uri|absolute"),
    ("drive_uri", Make(|m| uri(m, "C:/a.bin")), "buffers[0].uri|absolute"),
    ("hidden_parent_uri", Make(|m| uri(m, "a/%2e%2e/%2E%2E/a.bin")), "buffers[0].uri|folder"),
    ("no_folder", Make(|m| uri(m, "a.bin")), "buffers[0].uri|without a folder"),
    ("empty_uri", Make(|m| uri(m, "")), "buffers[0].uri|no file"),
    ("latin_uri", Make(|m| uri(m, "%ff.bin")), "buffers[0].uri|UTF-8"),
    ("data_comma", Make(|m| uri(m, "data:abc")), "buffers[0].uri|comma"),
    ("data_base64", Make(|m| uri(m, "data:;base64,AAA*")), "buffers[0].uri|base64"),
    // No view reaches the byte that is missing.
    ("data_short", Make(|m| uri(m, &format!("data:,{}", "A".repeat(59)))), "buffers[0].byteLength|60 bytes|only 59"),
    ("instanced_count", Make(|m| instanced(m, &[1.0; 3])), "nodes[0]|SCALE has 1 elements, expected 2"),
];

/// These spoil a skinned square.
pub(crate) const SKINNED: &[Row] = &[
    ("no_weights", Set(&[(ATTRIBUTES, "{'POSITION': 0, 'JOINTS_0': 2}")]), "attributes.WEIGHTS_0 is missing"),
    ("no_joints", Set(&[(ATTRIBUTES, "{'POSITION': 0, 'WEIGHTS_0': 3}")]), "attributes.JOINTS_0 is missing"),
    ("padded_joints", Set(&[(ATTRIBUTES, "{'POSITION': 0, 'JOINTS_00': 2}")]), "nodes[0]|has no JOINTS_0"),
    ("padded_weights", Set(&[(ATTRIBUTES, "{'POSITION': 0, 'WEIGHTS_00': 3}")]), "nodes[0]|has no JOINTS_0"),
    (
        "padded_set",
        Set(&[(ATTRIBUTES, "{'POSITION': 0, 'JOINTS_00': 2, 'WEIGHTS_00': 3}")]),
        "nodes[0]|has no JOINTS_0",
    ),
    (
        "signed_set",
        Set(&[(ATTRIBUTES, "{'POSITION': 0, 'JOINTS_+0': 2, 'WEIGHTS_+0': 3}")]),
        "nodes[0]|has no JOINTS_0",
    ),
    ("padded_weights", Set(&[(ATTRIBUTES, "{'POSITION': 0, 'WEIGHTS_00': 3}")]), "nodes[0]|has no JOINTS_0"),
    ("unskinned", Set(&[(ATTRIBUTES, "{'POSITION': 0}")]), "nodes[0]|meshes[0].primitives[0]|JOINTS_0"),
    ("joints_count", Set(&[("accessors[2].count", "3")]), "JOINTS_0 has 3 elements, expected 4"),
    ("joints_type", Set(&[("accessors[2].componentType", "5120")]), "accessors[2]|JOINTS_0|I8 Vec4"),
    ("joints_normalised", Set(&[("accessors[2].normalized", "true")]), "JOINTS_0|expected"),
    ("indices_normalised", Set(&[("accessors[1].normalized", "true")]), "indices|expected"),
    ("weights_not_normalised", Set(&[("accessors[3].componentType", "5121")]), "WEIGHTS_0|expected"),
    ("no_skin_joints", Set(&[("skins[0].joints", "[]")]), "skins[0].joints is missing"),
    ("dangling_joint", Set(&[("skins[0].joints", "[7]")]), "skins[0].joints[0] is 7"),
    (
        "joint_range",
        Set(&[("skins[0].joints", "[1]")]),
        "JOINTS_0, vertex 0 names joint 1|skins[0] of nodes[0] has 1 joints",
    ),
    ("later_joint_range", Make(later_joint), "meshes[0].primitives[1].attributes.JOINTS_0|joint 7"),
    ("infinite_weight", Make(|m| set_weights(m, f32::INFINITY)), "WEIGHTS_0, vertex 3|inf"),
    ("nan_weight", Make(|m| set_weights(m, f32::NAN)), "WEIGHTS_0, vertex 3|NaN"),
    ("binds_row", Make(|m| binds(m, &[1.0; 32])), "skins[0].inverseBindMatrices, matrix 0|last row"),
    ("binds_nan", Make(|m| binds(m, &[f32::NAN; 32])), "skins[0].inverseBindMatrices, matrix 0|not finite"),
    ("instanced", Make(|m| instanced(m, &[1.0; 6])), "nodes[0]|EXT_mesh_gpu_instancing|skin"),
    ("mesh", Set(&[("meshes[0]", "{'primitives': 1}")]), "meshes[0].primitives"),
    ("buffer", Set(&[("buffers", "[{'uri': 'none.bin'}]")]), "buffers[0].byteLength is missing"),
    ("scene", Set(&[("scenes", "[{'nodes': [9]}]")]), "scenes[0].nodes[0] is 9"),
    // A joint may be where the scene is not, and then its transform is needed, too.
    ("joint", Set(&[ONLY_SCENE, ("nodes[1].matrix", "[1]")]), "nodes[1].matrix"),
];

/// These spoil the animation of `everything`: samplers are rotation, cubic translation, step weights.
pub(crate) const ANIMATED: &[Row] = &[
    ("sampler", Set(&[("animations[0].channels[0].sampler", "3")]), "animations[0].channels[0].sampler is 3"),
    ("path", Set(&[("animations[0].channels[0].target", "{}")]), "channels[0].target.path is missing"),
    ("interpolation", Set(&[("animations[0].samplers[0].interpolation", "'X'")]), "samplers[0].interpolation"),
    ("channels_no_list", Set(&[("animations[0].channels", "{}")]), "animations[0].channels|an array"),
    ("dangling_node", Set(&[("animations[0].channels[0].target.node", "99")]), "channels[0].target.node is 99"),
    (
        "times_order",
        Make(|m| times(m, &[0.0, 2.0, 1.0])),
        "animations[0].samplers[0]|key 2 is at 1 s, before key 1 at 2 s",
    ),
    ("times_nan", Make(|m| times(m, &[0.0, f32::NAN, 1.0])), "animations[0].samplers[0]|time of key 1"),
    ("times_none", Make(|m| times(m, &[])), "animations[0].samplers[0]|no keyframes"),
    ("few_values", Make(|m| times(m, &[0.0, 1.0])), "animations[0].samplers[0]|12 output values for 2 keys"),
    ("values_nan", Make(|m| turn(m, f32::NAN)), "animations[0].samplers[0]|output of key 1 is not finite"),
    ("no_rotation", Make(|m| turn(m, 0.5)), "animations[0].samplers[0]|rotation of key 2 has no length"),
    ("values_type", Set(&[("animations[0].samplers[1].output", "0")]), "animations[0].samplers[1]"),
    (
        "on_matrix",
        Set(&[("nodes[1]", "{'matrix': [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}")]),
        "animations[0].channels[0]|nodes[1]|matrix",
    ),
];

/// Lights that none can be: each is the only one.
pub(crate) const LIGHTS: &[Row] = &[
    ("no_range", Set(&[(LIGHT, "{'type': 'point', 'range': 0}")]), "lights[0].range"),
    ("intensity", Set(&[(LIGHT, "{'type': 'point', 'intensity': -1}")]), "lights[0].intensity"),
    ("color", Set(&[(LIGHT, "{'type': 'point', 'color': [1, -1, 0]}")]), "lights[0].color"),
    ("outer_angle", Set(&[(LIGHT, "{'type': 'spot', 'spot': {'outerConeAngle': 1.57082}}")]), "spot.outerConeAngle"),
    ("inner_angle", Set(&[(LIGHT, "{'type': 'spot', 'spot': {'innerConeAngle': 1}}")]), "spot.innerConeAngle"),
    ("kind", Set(&[(LIGHT, "{'type': 'area'}")]), "lights[0].type|directional, point or spot"),
    ("dangling", Set(&[("nodes[0].extensions.KHR_lights_punctual.light", "4")]), "punctual.light is 4|2 lights"),
];

/// None of these is needed to show the square.
pub(crate) const UNUSED: &[Row] = &[
    ("material_index", Set(&[("meshes[0].primitives[0].material", "3")]), "primitives[0].material is 3|0 materials"),
    (
        "material_factor",
        Set(&[
            ("materials[0].pbrMetallicRoughness.baseColorFactor", "[1, 2, 3]"),
            ("meshes[0].primitives[0].material", "0"),
        ]),
        "materials[0].pbrMetallicRoughness.baseColorFactor has 3 elements, expected 4",
    ),
    ("color_index", Set(&[(COLOR, "9")]), "attributes.COLOR_0 is 9|2 accessors"),
    ("color_count", Set(&[(COLOR, "1")]), "COLOR_0 has 6 elements, expected 4"),
    (
        "color_format",
        Set(&[("accessors[2]", "{'componentType': 5121, 'type': 'VEC3', 'count': 4}"), (COLOR, "2")]),
        "accessors[2], used as meshes[0].primitives[0].attributes.COLOR_0|U8 Vec3, expected Vec3 or Vec4 of F32",
    ),
    ("skin", Set(&[("skins[0].joints", "[]")]), "skins[0].joints is missing"),
    ("skin_reference", Set(&[("skins[0].joints", "[7]")]), "skins[0].joints[0] is 7"),
    ("skins_no_list", Set(&[("skins", "null")]), "skins|an array|null"),
    (
        "inverse_binds",
        Set(&[
            ("accessors[2]", "{'componentType': 5126, 'type': 'MAT4', 'count': 1}"),
            ("skins[0]", "{'joints': [0], 'inverseBindMatrices': 2}"),
        ]),
        "skins[0].inverseBindMatrices, matrix 0|last row",
    ),
    ("light_extension", Set(&[("extensions.KHR_lights_punctual", "1")]), "KHR_lights_punctual"),
    ("mesh_data", Make(unused_mesh), "meshes[1].primitives[0]|is 9|4 vertices"),
    ("mesh_of_another_scene", Make(other_scene), "meshes[1].primitives[0].attributes.JOINTS_0"),
    ("node_of_another_scene", Set(&[ONLY_SCENE, ("nodes[1].mesh", "9")]), "nodes[1].mesh is 9"),
    ("cycle_of_another_scene", Set(&[ONLY_SCENE, ("nodes[1].children", "[1]")]), "nodes[1]|ancestor"),
    ("skin_of_no_mesh", Set(&[ONLY_SCENE, ("nodes[1].skin", "4")]), "nodes[1].skin is 4"),
    ("another_scene", Set(&[ONLY_SCENE, ("scenes[1].nodes", "[9]")]), "scenes[1].nodes[0] is 9"),
    ("view", Set(&[("bufferViews[2]", "{'buffer': 9, 'byteLength': 1}")]), "bufferViews[2].buffer is 9"),
    ("accessor", Set(&[("accessors[2].componentType", "5130")]), "accessors[2].|type"),
    (
        "joints_without_a_skin",
        Set(&[(ATTRIBUTES, "{'POSITION': 0, 'JOINTS_0': 0}")]),
        "attributes.WEIGHTS_0 is missing",
    ),
    // Points of a mesh that is shown. Their offsets have the wrong type.
    (
        "points",
        Set(&[
            TARGET,
            ("accessors[2]", "{'componentType': 5121, 'type': 'VEC3', 'count': 4}"),
            (SECOND, "{'attributes': {'POSITION': 0}, 'mode': 0, 'targets': [{'POSITION': 2}]}"),
        ]),
        "accessors[2], used as meshes[0].primitives[1].targets[0].POSITION|U8 Vec3",
    ),
    ("name", Set(&[("nodes[0].name", "7")]), "nodes[0].name|a string"),
    ("used_no_list", Set(&[("extensionsUsed", "1")]), "extensionsUsed|an array"),
    // These are read all the same.
    ("rotation", Set(&[("nodes[0].rotation", "[0, 0, 0, 0]")]), "nodes[0].rotation|no rotation"),
    ("mesh_weights", Set(&[("meshes[0].weights", "[1]")]), "meshes[0].weights has 1|no morph targets"),
    ("node_weights", Set(&[("nodes[0].weights", "[1]")]), "nodes[0].weights has 1|no morph targets"),
    (
        "nan_target",
        Make(nan_target),
        "targets[0].POSITION: 1 offsets|first that of vertex 2|while the target's weight is not 0",
    ),
    ("extension", Set(&[("extensionsUsed", "['ACME_fold', 'ACME_fold']")]), "ACME_fold|not read"),
    (
        "child_twice",
        Set(&[("nodes", "[{'children': [1, 1]}, {'mesh': 0}]")]),
        "nodes[1] is a child of nodes[0] and again of nodes[0]",
    ),
];

/// These lose faces, of which so many are left.
pub(crate) const FEWER: &[(Row, usize)] = &[
    (("corners", Set(&[("accessors[1].count", "5")]), "5 corners|last 2 are left out"), 1),
    (("u8", Make(|m| set_indices(m, U8, &[0, 1, 255, 1, 2, 3], 4)), "index 2|value 255|as a restart"), 1),
    (("u16", Make(|m| set_indices(m, U16, &[0, 1, 2, 65535, 1, 2], 4)), "index 3|value 65535|restart"), 1),
    (("u32", Make(|m| set_indices(m, U32, &[u32::MAX, 1, 2], 4)), "index 0|value 4294967295|restart"), 0),
];

/// The square's node is the only one of the only scene.
const ONLY_SCENE: (&str, &str) = ("scenes", "[{'nodes': [0]}]");
const TARGET: (&str, &str) = ("meshes[0].primitives[0].targets", "[{}]");
const SECOND: &str = "meshes[0].primitives[1]";
const ATTRIBUTES: &str = "meshes[0].primitives[0].attributes";
const LIGHT: &str = "extensions.KHR_lights_punctual.lights[0]";
const COLOR: &str = "meshes[0].primitives[0].attributes.COLOR_0";

pub(crate) fn primitive(maker: &mut Maker) -> &mut Value {
    &mut maker.json["meshes"][0]["primitives"][0]
}

/// Adds a copy of the first primitive.
pub(crate) fn copy_primitive(maker: &mut Maker) -> &mut Value {
    let copy = primitive(maker).clone();
    let list = maker.json["meshes"][0]["primitives"].as_array_mut().expect("a list");
    list.push(copy);
    list.last_mut().expect("one was added")
}

pub(crate) fn uri(maker: &mut Maker, uri: &str) {
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len(), "uri": uri }]);
}

pub(crate) fn set_indices(maker: &mut Maker, component: u32, indices: &[u32], mode: u32) {
    let indices = maker.indices(component, indices);
    primitive(maker)["indices"] = json!(indices);
    primitive(maker)["mode"] = json!(mode);
}

/// Influences in a second primitive, of which the joints are out of range.
fn later_joint(maker: &mut Maker) {
    let joints = maker.accessor(U8, "VEC4", 4, &[0, 7, 0, 0].repeat(4));
    copy_primitive(maker)["attributes"]["JOINTS_0"] = json!(joints);
}

/// Two instances, which have these scales.
fn instanced(maker: &mut Maker, scales: &[f32]) {
    let (translations, scales) = (maker.floats("VEC3", &[0.0; 6]), maker.floats("VEC3", scales));
    maker.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translations, "SCALE": scales } } });
}

/// The output of gltfpack -c: the view's own buffer is a fallback without data.
fn meshopt(maker: &mut Maker) {
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len() }, { "byteLength": 48 }]);
    maker.json["bufferViews"][0] = json!({
        "buffer": 1,
        "byteLength": 48,
        "extensions": { "EXT_meshopt_compression": { "buffer": 0, "byteLength": 48, "byteStride": 12, "count": 4 } },
    });
    maker.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
}

fn set_weights(maker: &mut Maker, last: f32) {
    let mut weights = [1.0; 16];
    weights[15] = last;
    let weights = maker.floats("VEC4", &weights);
    primitive(maker)["attributes"]["WEIGHTS_0"] = json!(weights);
}

fn binds(maker: &mut Maker, matrices: &[f32]) {
    maker.json["skins"][0]["inverseBindMatrices"] = json!(maker.floats("MAT4", matrices));
}

fn times(maker: &mut Maker, times: &[f32]) {
    maker.json["animations"][0]["samplers"][0]["input"] = json!(maker.floats("SCALAR", times));
}

/// Three turns. The second has this component, too, and the third has none.
fn turn(maker: &mut Maker, value: f32) {
    let turns = maker.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, value, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    maker.json["animations"][0]["samplers"][0]["output"] = json!(turns);
}

fn unused_mesh(maker: &mut Maker) {
    maker.scene(&[0]);
    let indices = maker.indices(U8, &[0, 1, 9]);
    maker.mesh(&json!({ "attributes": { "POSITION": 0 }, "indices": indices }));
}

/// A skinned mesh whose joints are none, in a scene that is not shown.
fn other_scene(maker: &mut Maker) {
    maker.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }]);
    let joints = maker.accessor(U8, "VEC4", 4, &[9; 16]);
    let weights = maker.floats("VEC4", &[1.0; 16]);
    let attributes = json!({ "POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights });
    let mesh = maker.mesh(&json!({ "attributes": attributes, "mode": 5 }));
    maker.push("skins", json!({ "joints": [0] }));
    maker.push("nodes", json!({ "mesh": mesh, "skin": 0 }));
}

fn nan_target(maker: &mut Maker) {
    let mut offsets = [0.0; 12];
    offsets[7] = f32::NAN;
    let target = maker.floats("VEC3", &offsets);
    primitive(maker)["targets"] = json!([{ "POSITION": target }]);
}
