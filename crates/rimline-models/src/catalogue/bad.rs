//! Files with a fault, each a square with something wrong.

use serde_json::json;

use super::{Bad, Fate};
use crate::maker::{F32, Maker, SQUARE, U8, U16};

use Fate::{Empty, Refused, Warned};

/// All of them.
pub const BAD: &[Bad] = &[
    bad("draco.glb", draco, Refused, &["KHR_draco_mesh_compression", "decompress"]),
    bad("index_out_of_range.glb", index_out_of_range, Refused, &["face 1, corner 2", "is 77", "4 vertices"]),
    bad("no_accessor.glb", no_accessor, Refused, &["meshes[0].primitives[0].attributes.POSITION is 9", "2 accessors"]),
    bad("float_indices.glb", |m| retype(m, 1, "SCALAR"), Refused, &["meshes[0].primitives[0].indices", "F32 Scalar"]),
    bad("vec4_positions.glb", |m| retype(m, 0, "VEC4"), Refused, &["attributes.POSITION", "F32 Vec4"]),
    bad("short_target.glb", short_target, Refused, &["targets[0].POSITION", "3 elements, expected 4"]),
    bad("node_loop.glb", |m| m.json["nodes"][0]["children"] = json!([0]), Refused, &["nodes[0]", "ancestor"]),
    bad("missing_bin.gltf", missing_bin, Refused, &["cannot read", "missing.bin"]),
    broken("no_json.glb", |file| file[20] = b'x', &["JSON"]),
    broken("truncated.glb", |file| file.truncate(file.len() - 20), &["byte 8"]),
    broken("chunk_too_big.glb", |file| file[14] = 0xff, &["byte 12"]),
    broken("chunk_truncated.glb", chunk_truncated, &["states 60 bytes, there are 40"]),
    bad("view_too_long.glb", view_too_long, Refused, &["bufferViews[0]", "4800 bytes"]),
    bad("view_too_long_unshown.glb", view_too_long, Empty, &["bufferViews[0]", "4800 bytes"]),
    bad("no_view.glb", no_view, Refused, &["accessors[0].bufferView is 9", "2 bufferViews"]),
    bad("no_view_unshown.glb", no_view, Empty, &["accessors[0].bufferView is 9", "2 bufferViews"]),
    bad("few_binds.glb", few_binds, Refused, &["skins[0].inverseBindMatrices", "1 elements, expected 2"]),
    bad("few_binds_unshown.glb", few_binds, Empty, &["skins[0].inverseBindMatrices", "1 elements, expected 2"]),
    bad("weights.glb", weights, Refused, &["primitives[0].attributes.WEIGHTS_0, vertex 0", "weight -0.5"]),
    bad("weights_unshown.glb", weights, Empty, &["meshes[0].primitives[0].attributes.WEIGHTS_0", "weight -"]),
    bad("no_position.glb", no_position, Empty, &["1 primitives without positions"]),
    bad("nan.glb", |m| corner(m, f32::NAN), Warned, &["attributes.POSITION: 1 positions", "vertex 1"]),
    bad("infinite.glb", |m| corner(m, f32::NEG_INFINITY), Warned, &["attributes.POSITION: 1 positions", "vertex 1"]),
    bad("negative_index.glb", negative_index, Warned, &["baseColorTexture.index", "found -1"]),
    bad("restart.glb", restart, Warned, &["meshes[0].primitives[0]", "restart value 255"]),
];

const fn bad(name: &'static str, change: fn(&mut Maker), fate: Fate, says: &'static [&'static str]) -> Bad {
    Bad { name, change, damage: |_| (), fate, says }
}

/// A file whose bytes are damaged.
const fn broken(name: &'static str, damage: fn(&mut Vec<u8>), says: &'static [&'static str]) -> Bad {
    Bad { name, change: |_| (), damage, fate: Refused, says }
}

fn draco(maker: &mut Maker) {
    maker.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": { "POSITION": 0 } } });
    maker.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    maker.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
}

fn index_out_of_range(maker: &mut Maker) {
    let indices = maker.indices(U16, &[0, 1, 2, 0, 2, 77]);
    maker.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
}

fn no_accessor(maker: &mut Maker) {
    maker.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9);
}

/// Another type of an accessor, for which there are enough bytes.
fn retype(maker: &mut Maker, accessor: usize, kind: &str) {
    let view = maker.json["accessors"][accessor]["bufferView"].clone();
    maker.json["accessors"][accessor] = json!({ "bufferView": view, "componentType": F32, "type": kind, "count": 3 });
}

fn short_target(maker: &mut Maker) {
    let target = maker.floats("VEC3", &[0.5; 9]);
    maker.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
}

fn missing_bin(maker: &mut Maker) {
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len(), "uri": "missing.bin" }]);
}

/// The file's header has the right length, the last chunk's has not.
fn chunk_truncated(file: &mut Vec<u8>) {
    file.truncate(file.len() - 20);
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
}

fn view_too_long(maker: &mut Maker) {
    maker.json["bufferViews"][0]["byteLength"] = json!(4800);
}

fn no_view(maker: &mut Maker) {
    maker.json["accessors"][0]["bufferView"] = json!(9);
}

fn few_binds(maker: &mut Maker) {
    *maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    let binds = maker.floats("MAT4", &[1.0; 16]);
    maker.json["skins"][0]["inverseBindMatrices"] = json!(binds);
}

/// Negative ones, and one for a joint that is not there.
fn weights(maker: &mut Maker) {
    *maker = Maker::skinned([0, 1, 9, 0], [0.5, -0.5, 0.25, 0.0]);
}

fn no_position(maker: &mut Maker) {
    maker.json["meshes"][0]["primitives"][0]["attributes"] = json!({});
}

/// One face has a corner with this coordinate, one has not.
fn corner(maker: &mut Maker, coordinate: f32) {
    let mut positions = SQUARE;
    positions[4] = coordinate;
    let positions = maker.floats("VEC3", &positions);
    maker.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
}

fn negative_index(maker: &mut Maker) {
    maker.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": -1 } } }]);
    maker.json["meshes"][0]["primitives"][0]["material"] = json!(0);
}

/// Two strips in one, which glTF forbids.
fn restart(maker: &mut Maker) {
    let indices = maker.indices(U8, &[0, 1, 2, 255, 0, 2, 3]);
    let primitive = &mut maker.json["meshes"][0]["primitives"][0];
    primitive["indices"] = json!(indices);
    primitive["mode"] = json!(5);
}
