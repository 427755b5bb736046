//! Changes that spoil a square, and texts that the error must contain.

use serde_json::json;

use crate::maker::{Maker, U8, U16};
use crate::refuse::{Row, bare, instanced, primitive, uri};

pub(crate) const SQUARE: &[Row] = &[
    ("version", |m| m.json["asset"]["version"] = json!("1.0"), &["version 1.0"]),
    ("min_version", |m| m.json["asset"]["minVersion"] = json!("2.1"), &["version 2.1"]),
    ("no_asset", |m| m.json["asset"] = json!({}), &["asset.version is missing"]),
    ("wrong_type", |m| m.json["nodes"][0]["mesh"] = json!("a"), &["nodes[0].mesh", "an index", "\"a\""]),
    ("negative_index", |m| m.json["nodes"][0]["mesh"] = json!(-1), &["nodes[0].mesh", "found -1"]),
    ("dangling_mesh", |m| m.json["nodes"][0]["mesh"] = json!(5), &["nodes[0].mesh is 5", "1 meshes"]),
    ("dangling_scene", |m| m.json["scene"] = json!(0), &["scene is 0", "0 scenes"]),
    ("dangling_child", |m| m.json["nodes"][0]["children"] = json!([9]), &["nodes[0].children[0] is 9", "1 nodes"]),
    ("nodes_no_list", |m| m.json["nodes"] = json!({}), &["nodes", "an array", "an object"]),
    ("own_child", |m| m.json["nodes"][0]["children"] = json!([0]), &["nodes[0]", "ancestor"]),
    ("cycle", |m| m.json["nodes"] = json!([{}, { "children": [2] }, { "children": [1] }]), &["nodes[1]", "ancestor"]),
    (
        "matrix_length",
        |m| m.json["nodes"][0]["matrix"] = json!([1, 2]),
        &["nodes[0].matrix", "2 elements, expected 16"],
    ),
    ("matrix_row", |m| m.json["nodes"][0]["matrix"] = json!(vec![1; 16]), &["nodes[0].matrix", "last row"]),
    ("mode", |m| primitive(m)["mode"] = json!(7), &["meshes[0].primitives[0].mode", "found 7"]),
    ("component", |m| m.json["accessors"][0]["componentType"] = json!(5130), &["accessors[0].componentType", "5130"]),
    ("count_fraction", |m| m.json["accessors"][0]["count"] = json!(1.5), &["accessors[0].count", "1.5"]),
    ("huge_count", |m| m.json["accessors"][0]["count"] = json!(u64::MAX), &["accessors[0]", "bufferViews[0]"]),
    ("large_count", |m| m.json["accessors"][0]["count"] = json!(1_u64 << 40), &["accessors[0]", "bufferViews[0]"]),
    ("huge_offset", |m| m.json["accessors"][0]["byteOffset"] = json!(u64::MAX), &["accessors[0]", "bufferViews[0]"]),
    ("one_byte_over", |m| m.json["accessors"][0]["byteOffset"] = json!(1), &["needs 49 bytes", "has 48"]),
    ("huge_zeros", zeros, &["accessors[", "POSITION", "more than the limit of"]),
    ("huge_zero_targets", zero_targets, &["meshes[0].primitives[0].targets[", "more than the limit of"]),
    ("huge_view", |m| m.json["bufferViews"][0]["byteLength"] = json!(u64::MAX), &["bufferViews[0]"]),
    ("huge_view_offset", |m| m.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX), &["bufferViews[0]"]),
    ("small_stride", |m| m.json["bufferViews"][0]["byteStride"] = json!(0), &["byteStride 0", "bufferViews[0]"]),
    ("huge_stride", |m| m.json["bufferViews"][0]["byteStride"] = json!(u64::MAX), &["bufferViews[0]", "has 48"]),
    ("indices_type", |m| m.json["accessors"][1]["type"] = json!("VEC2"), &["accessors[1]", "indices", "U16 Vec2"]),
    ("index_range", |m| set_indices(m, U16, &[0, 1, 2, 0, 2, 4]), &["face 1, corner 2", "is 4", "4 vertices"]),
    ("strip_range", strip_range, &["index 3 (face 1, corner 1) is 9"]),
    ("target_counts", target_counts, &["meshes[0].primitives[1].targets", "0 elements, expected 1"]),
    ("mesh_weights", |m| weights(m, "meshes"), &["meshes[0].weights", "2 elements, expected 1"]),
    ("node_weights", |m| weights(m, "nodes"), &["nodes[0].weights", "2 elements, expected 1"]),
    ("visibility", visibility, &["nodes[0].extensions.KHR_node_visibility.visible", "true or false", "\"no\""]),
    ("sparse_order", |m| sparse(m, [2, 1]), &["accessors[0]", "sparse index 1 is 1"]),
    ("sparse_twice", |m| sparse(m, [1, 1]), &["accessors[0]", "sparse index 1 is 1", "must increase"]),
    ("sparse_range", |m| sparse(m, [2, 4]), &["accessors[0]", "sparse index 1 is 4"]),
    ("sparse_count", sparse_count, &["accessors[0]", "it replaces 5 elements of 4"]),
    ("extension", |m| m.json["extensionsRequired"] = json!(["ACME_fold"]), &["ACME_fold", "not supported"]),
    ("meshopt", meshopt, &["EXT_meshopt_compression", "bufferViews[0]", "decompress"]),
    ("draco_without_data", draco, &["KHR_draco_mesh_compression", "meshes[0].primitives[0]", "decompress"]),
    ("no_data", no_data, &["accessors[0]", "buffers[1] has no data"]),
    ("web_uri", |m| uri(m, "https://example.org/a.bin"), &["buffers[0].uri", "https:", "absolute"]),
    ("file_uri", |m| uri(m, "file:///etc/passwd"), &["buffers[0].uri", "absolute"]),
    ("network_uri", |m| uri(m, "//host/a.bin"), &["buffers[0].uri", "absolute"]),
    ("drive_uri", |m| uri(m, "C:/a.bin"), &["buffers[0].uri", "absolute"]),
    ("rooted_uri", |m| uri(m, "/dev/zero"), &["buffers[0].uri", "folder"]),
    ("parent_uri", |m| uri(m, "../a.bin"), &["buffers[0].uri", "folder"]),
    ("hidden_parent_uri", |m| uri(m, "a/%2e%2e/%2E%2E/a.bin"), &["buffers[0].uri", "folder"]),
    ("no_folder", |m| uri(m, "a.bin"), &["buffers[0].uri", "without a folder"]),
    ("empty_uri", |m| uri(m, ""), &["buffers[0].uri", "no file"]),
    ("latin_uri", |m| uri(m, "%ff.bin"), &["buffers[0].uri", "UTF-8"]),
    ("data_comma", |m| uri(m, "data:abc"), &["buffers[0].uri", "comma"]),
    ("data_base64", |m| uri(m, "data:;base64,AAA*"), &["buffers[0].uri", "base64"]),
    ("data_short", |m| uri(m, "data:;base64,AAAA"), &["buffers[0].byteLength", "60 bytes", "only 3"]),
    ("instanced_count", instanced_count, &["nodes[0]", "EXT_mesh_gpu_instancing", "SCALE has 1 elements, expected 2"]),
];

fn zeros(maker: &mut Maker) {
    let zeros = bare(maker, 3_000_000_000);
    primitive(maker)["attributes"]["POSITION"] = json!(zeros);
}

fn zero_targets(maker: &mut Maker) {
    let zeros = bare(maker, 100_000);
    primitive(maker)["attributes"]["POSITION"] = json!(zeros);
    primitive(maker)["targets"] = json!(vec![json!({}); 1000]);
}

pub(crate) fn set_indices(maker: &mut Maker, component: u32, indices: &[u32]) {
    let indices = maker.indices(component, indices);
    primitive(maker)["indices"] = json!(indices);
}

fn strip_range(maker: &mut Maker) {
    set_indices(maker, U8, &[0, 1, 2, 9]);
    primitive(maker)["mode"] = json!(5);
}

fn target_counts(maker: &mut Maker) {
    let other = primitive(maker).clone();
    primitive(maker)["targets"] = json!([{}]);
    maker.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(other);
}

fn sparse(maker: &mut Maker, at: [u8; 2]) {
    let (indices, values) = (maker.view(&at), maker.view(&[0; 24]));
    maker.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "componentType": U8 },
        "values": { "bufferView": values },
    });
}

fn sparse_count(maker: &mut Maker) {
    sparse(maker, [0, 1]);
    maker.json["accessors"][0]["sparse"]["count"] = json!(5);
}

/// The output of gltfpack -c: the view's own buffer is a fallback without data.
fn meshopt(maker: &mut Maker) {
    let bytes = maker.bytes.len();
    maker.json["buffers"] = json!([{ "byteLength": bytes }, { "byteLength": 48 }]);
    maker.json["bufferViews"][0] = json!({
        "buffer": 1,
        "byteLength": 48,
        "extensions": { "EXT_meshopt_compression": { "buffer": 0, "byteLength": 48, "byteStride": 12, "count": 4 } },
    });
    maker.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
}

/// The GLB's binary chunk is buffer 0 and no other.
fn no_data(maker: &mut Maker) {
    let bytes = maker.bytes.len();
    maker.json["buffers"] = json!([{ "byteLength": bytes }, { "byteLength": bytes }]);
    maker.json["bufferViews"][0]["buffer"] = json!(1);
}

fn draco(maker: &mut Maker) {
    primitive(maker)["extensions"] = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } });
    maker.json["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
}

fn instanced_count(maker: &mut Maker) {
    instanced(maker, &[1.0; 3]);
}

fn weights(maker: &mut Maker, list: &str) {
    primitive(maker)["targets"] = json!([{}]);
    maker.json[list][0]["weights"] = json!([1, 1]);
}

fn visibility(maker: &mut Maker) {
    maker.json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": { "visible": "no" } });
}
