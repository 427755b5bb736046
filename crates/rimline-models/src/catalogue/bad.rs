//! Files with a fault, each a square with something wrong.

use serde_json::{Value, json};

use super::{Bad, Fate};
use crate::maker::{F32, Maker, U8, U16, glb};

use Fate::{Empty, Refused, Warned};

/// All of them.
pub const BAD: &[Bad] = &[
    bad("draco.glb", draco, Refused, &["KHR_draco_mesh_compression", "decompress"]),
    bad("index_out_of_range.glb", index_out_of_range, Refused, &["meshes[0].primitives[0]", "is 77", "4 vertices"]),
    bad("no_accessor.glb", no_accessor, Refused, &["meshes[0].primitives[0].attributes.POSITION is 9", "2 accessors"]),
    bad("float_indices.glb", float_indices, Refused, &["meshes[0].primitives[0].indices", "F32 Scalar"]),
    bad("vec4_positions.glb", vec4_positions, Refused, &["attributes.POSITION", "F32 Vec4"]),
    bad("short_target.glb", short_target, Refused, &["targets[0].POSITION", "3 elements, expected 4"]),
    bad("node_loop.glb", node_loop, Refused, &["nodes[0]", "ancestor"]),
    bad("missing_bin.gltf", missing_bin, Refused, &["cannot read", "missing.bin"]),
    bad("no_json.glb", || glb(b"no JSON", &[]), Refused, &["JSON"]),
    bad("truncated.glb", || shortened(20), Refused, &["byte 8"]),
    bad("chunk_too_big.glb", chunk_too_big, Refused, &["byte 12"]),
    bad("chunk_truncated.glb", chunk_truncated, Refused, &["byte"]),
    bad("view_too_long.glb", || view_too_long().glb(), Refused, &["bufferViews[0]", "4800 bytes"]),
    bad("view_too_long_unshown.glb", || unshown(view_too_long()), Empty, &["bufferViews[0]", "4800 bytes"]),
    bad("no_view.glb", || no_view().glb(), Refused, &["accessors[0].bufferView is 9", "2 bufferViews"]),
    bad("no_view_unshown.glb", || unshown(no_view()), Empty, &["accessors[0].bufferView is 9", "2 bufferViews"]),
    bad("few_binds.glb", || few_binds().glb(), Refused, &["skins[0].inverseBindMatrices", "1 elements, expected 2"]),
    bad(
        "few_binds_unshown.glb",
        || unshown(few_binds()),
        Empty,
        &["skins[0].inverseBindMatrices", "1 elements, expected 2"],
    ),
    bad("weights.glb", || weights().glb(), Refused, &["meshes[0].primitives[0].attributes.WEIGHTS_0", "weight -"]),
    bad(
        "weights_unshown.glb",
        || unshown(weights()),
        Empty,
        &["meshes[0].primitives[0].attributes.WEIGHTS_0", "weight -"],
    ),
    bad("no_position.glb", no_position, Empty, &["1 primitives without positions"]),
    bad("nan.glb", || corner(f32::NAN), Warned, &["attributes.POSITION", "infinite or NaN"]),
    bad("infinite.glb", || corner(f32::NEG_INFINITY), Warned, &["attributes.POSITION", "infinite or NaN"]),
    bad("negative_index.glb", negative_index, Warned, &["baseColorTexture.index", "found -1"]),
    bad("restart.glb", restart, Warned, &["meshes[0].primitives[0]", "restart value 255"]),
];

const fn bad(name: &'static str, make: fn() -> Vec<u8>, fate: Fate, says: &'static [&'static str]) -> Bad {
    Bad { name, make, fate, says }
}

/// A square with a change to its JSON.
fn with(change: impl FnOnce(&mut Value)) -> Maker {
    let mut maker = Maker::square();
    change(&mut maker.json);
    maker
}

fn changed(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    with(change).glb()
}

/// The file with a scene of nothing.
fn unshown(mut maker: Maker) -> Vec<u8> {
    maker.scene(&[]);
    maker.glb()
}

fn draco() -> Vec<u8> {
    changed(|json| {
        json["meshes"][0]["primitives"][0]["extensions"] =
            json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": { "POSITION": 0 } } });
        json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    })
}

fn index_out_of_range() -> Vec<u8> {
    let mut maker = Maker::square();
    let indices = maker.indices(U16, &[0, 1, 2, 0, 2, 77]);
    maker.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    maker.glb()
}

fn no_accessor() -> Vec<u8> {
    changed(|json| json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9))
}

fn float_indices() -> Vec<u8> {
    changed(|json| {
        json["accessors"][1]["componentType"] = json!(F32);
        json["accessors"][1]["count"] = json!(3);
    })
}

fn vec4_positions() -> Vec<u8> {
    changed(|json| {
        json["accessors"][0]["type"] = json!("VEC4");
        json["accessors"][0]["count"] = json!(3);
    })
}

fn short_target() -> Vec<u8> {
    let mut maker = Maker::square();
    let target = maker.floats("VEC3", &[0.5; 9]);
    maker.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
    maker.glb()
}

fn node_loop() -> Vec<u8> {
    changed(|json| {
        json["nodes"] = json!([{ "mesh": 0, "children": [1] }, { "children": [0] }]);
        json["scenes"] = json!([{ "nodes": [0] }]);
    })
}

fn missing_bin() -> Vec<u8> {
    let mut maker = Maker::square();
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len(), "uri": "missing.bin" }]);
    maker.gltf()
}

/// A binary that ends too early.
fn shortened(by: usize) -> Vec<u8> {
    let mut file = Maker::square().glb();
    file.truncate(file.len() - by);
    file
}

fn chunk_too_big() -> Vec<u8> {
    let mut file = Maker::square().glb();
    file[12..16].copy_from_slice(&0x00ff_fff0_u32.to_le_bytes());
    file
}

/// The header says so, too, but the last chunk does not.
fn chunk_truncated() -> Vec<u8> {
    let mut file = shortened(20);
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    file
}

fn view_too_long() -> Maker {
    with(|json| json["bufferViews"][0]["byteLength"] = json!(4800))
}

fn no_view() -> Maker {
    with(|json| json["accessors"][0]["bufferView"] = json!(9))
}

fn few_binds() -> Maker {
    let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    let binds = maker.floats("MAT4", &[1.0; 16]);
    maker.json["skins"][0]["inverseBindMatrices"] = json!(binds);
    maker
}

/// Negative ones, for a joint that is not there, too.
fn weights() -> Maker {
    Maker::skinned([0, 1, 9, 0], [0.5, -0.5, 0.25, 0.0])
}

fn no_position() -> Vec<u8> {
    changed(|json| json["meshes"][0]["primitives"][0]["attributes"] = json!({}))
}

/// One face has a corner with this coordinate, one has not.
fn corner(coordinate: f32) -> Vec<u8> {
    let mut maker = Maker::square();
    let mut positions = crate::maker::SQUARE;
    positions[4] = coordinate;
    let positions = maker.floats("VEC3", &positions);
    maker.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
    maker.glb()
}

fn negative_index() -> Vec<u8> {
    changed(|json| {
        json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": -1 } } }]);
        json["meshes"][0]["primitives"][0]["material"] = json!(0);
    })
}

/// Two strips in one, which glTF forbids.
fn restart() -> Vec<u8> {
    let mut maker = Maker::square();
    let indices = maker.indices(U8, &[0, 1, 2, 255, 0, 2, 3]);
    let primitive = &mut maker.json["meshes"][0]["primitives"][0];
    primitive["indices"] = json!(indices);
    primitive["mode"] = json!(5);
    maker.glb()
}
