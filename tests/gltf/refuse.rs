//! Hand-made bad files: each is refused, with its place.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError};
use rimline::mesh::Weld;
use serde_json::{Value, json};

use crate::maker::{F32, Maker, U8, U16, U32, everything};
use crate::{Outcome, ensure, test};

/// Name, what spoils a square (or a skinned one), and what the error must say.
type Row = (&'static str, fn(&mut Maker), &'static [&'static str]);

const SQUARE: &[Row] = &[
    (
        "version",
        |m| m.json["asset"]["version"] = json!("1.0"),
        &["version 1.0"],
    ),
    (
        "min_version",
        |m| m.json["asset"]["minVersion"] = json!("2.1"),
        &["version 2.1"],
    ),
    (
        "no_asset",
        |m| m.json["asset"] = json!({}),
        &["asset.version is missing"],
    ),
    (
        "wrong_type",
        |m| m.json["nodes"][0]["mesh"] = json!("a"),
        &["nodes[0].mesh", "an index", "\"a\""],
    ),
    (
        "negative_index",
        |m| m.json["nodes"][0]["mesh"] = json!(-1),
        &["nodes[0].mesh", "found -1"],
    ),
    (
        "dangling_mesh",
        |m| m.json["nodes"][0]["mesh"] = json!(5),
        &["nodes[0].mesh is 5", "1 meshes"],
    ),
    (
        "dangling_scene",
        |m| m.json["scene"] = json!(0),
        &["scene is 0", "0 scenes"],
    ),
    (
        "dangling_child",
        |m| m.json["nodes"][0]["children"] = json!([9]),
        &["nodes[0].children[0] is 9", "1 nodes"],
    ),
    (
        "nodes_no_list",
        |m| m.json["nodes"] = json!({}),
        &["nodes", "an array", "an object"],
    ),
    (
        "own_child",
        |m| m.json["nodes"][0]["children"] = json!([0]),
        &["nodes[0]", "ancestor"],
    ),
    (
        "cycle",
        |m| m.json["nodes"] = json!([{}, { "children": [2] }, { "children": [1] }]),
        &["nodes[1]", "ancestor"],
    ),
    (
        "two_parents",
        |m| m.json["nodes"] = json!([{}, { "children": [0] }, { "children": [0] }]),
        &["nodes[0]", "nodes[1]", "nodes[2]"],
    ),
    (
        "child_twice",
        |m| m.json["nodes"] = json!([{ "children": [1, 1] }, {}]),
        &["nodes[1]", "nodes[0] and again"],
    ),
    (
        "matrix_length",
        |m| m.json["nodes"][0]["matrix"] = json!([1, 2]),
        &["nodes[0].matrix", "2 elements, expected 16"],
    ),
    (
        "matrix_row",
        |m| m.json["nodes"][0]["matrix"] = json!(vec![1; 16]),
        &["nodes[0].matrix", "last row"],
    ),
    (
        "rotation",
        |m| m.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
        &["nodes[0].rotation", "no direction"],
    ),
    (
        "mode",
        |m| primitive(m)["mode"] = json!(7),
        &["meshes[0].primitives[0].mode", "found 7"],
    ),
    (
        "component",
        |m| m.json["accessors"][0]["componentType"] = json!(5130),
        &["accessors[0].componentType", "5130"],
    ),
    (
        "count_fraction",
        |m| m.json["accessors"][0]["count"] = json!(1.5),
        &["accessors[0].count", "1.5"],
    ),
    (
        "huge_count",
        |m| m.json["accessors"][0]["count"] = json!(u64::MAX),
        &["accessors[0]", "bufferViews[0]"],
    ),
    (
        "large_count",
        |m| m.json["accessors"][0]["count"] = json!(1_u64 << 40),
        &["accessors[0]", "bufferViews[0]"],
    ),
    (
        "huge_offset",
        |m| m.json["accessors"][0]["byteOffset"] = json!(u64::MAX),
        &["accessors[0]", "bufferViews[0]"],
    ),
    (
        "one_byte_over",
        |m| m.json["accessors"][0]["byteOffset"] = json!(1),
        &["needs 49 bytes", "has 48"],
    ),
    ("huge_zeros", zeros, &["accessors[", "POSITION", "unpacks to more than"]),
    (
        "huge_zero_targets",
        zero_targets,
        &["meshes[0].primitives[0].targets[", "unpacks to more than"],
    ),
    (
        "huge_view",
        |m| m.json["bufferViews"][0]["byteLength"] = json!(u64::MAX),
        &["bufferViews[0]"],
    ),
    (
        "huge_view_offset",
        |m| m.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
        &["bufferViews[0]"],
    ),
    (
        "small_stride",
        |m| m.json["bufferViews"][0]["byteStride"] = json!(0),
        &["byteStride 0", "bufferViews[0]"],
    ),
    (
        "huge_stride",
        |m| m.json["bufferViews"][0]["byteStride"] = json!(u64::MAX),
        &["bufferViews[0]", "has 48"],
    ),
    (
        "indices_type",
        |m| m.json["accessors"][1]["type"] = json!("VEC2"),
        &["accessors[1]", "indices", "U16 Vec2"],
    ),
    (
        "corner_count",
        |m| m.json["accessors"][1]["count"] = json!(5),
        &["meshes[0].primitives[0]", "5 corners"],
    ),
    (
        "index_range",
        |m| set_indices(m, U16, &[0, 1, 2, 0, 2, 4]),
        &["face 1, corner 2", "is 4", "4 vertices"],
    ),
    (
        "restart_u8",
        |m| set_indices(m, U8, &[0, 1, 255]),
        &["index 2 is the primitive restart value 255"],
    ),
    (
        "restart_u16",
        |m| set_indices(m, U16, &[0, 65535, 1]),
        &["index 1 is the primitive restart value 65535"],
    ),
    (
        "restart_u32",
        |m| set_indices(m, U32, &[u32::MAX, 1, 2]),
        &["index 0 is the primitive restart value"],
    ),
    ("strip_range", strip_range, &["index 3 (face 1, corner 1) is 9"]),
    (
        "nan_target",
        nan_target,
        &["meshes[0].primitives[0].targets[0].POSITION, vertex 2", "NaN"],
    ),
    (
        "target_counts",
        target_counts,
        &["meshes[0].primitives[1].targets", "0 elements, expected 1"],
    ),
    (
        "mesh_weights",
        |m| m.json["meshes"][0]["weights"] = json!([1]),
        &["meshes[0].weights", "1 elements, expected 0"],
    ),
    (
        "node_weights",
        |m| m.json["nodes"][0]["weights"] = json!([1]),
        &["nodes[0].weights", "expected 0"],
    ),
    (
        "sparse_order",
        |m| sparse(m, [2, 1]),
        &["accessors[0]", "sparse index 1 is 1"],
    ),
    (
        "sparse_range",
        |m| sparse(m, [2, 4]),
        &["accessors[0]", "sparse index 1 is 4"],
    ),
    (
        "sparse_count",
        sparse_count,
        &["accessors[0]", "it replaces 5 elements of 4"],
    ),
    (
        "extension",
        |m| m.json["extensionsRequired"] = json!(["ACME_fold"]),
        &["ACME_fold", "not supported"],
    ),
    (
        "meshopt",
        meshopt,
        &["EXT_meshopt_compression", "bufferViews[0]", "decompress"],
    ),
    (
        "draco_without_data",
        draco,
        &["KHR_draco_mesh_compression", "meshes[0].primitives[0]", "decompress"],
    ),
    ("no_data", no_data, &["accessors[0]", "buffers[1] has no data"]),
    (
        "web_uri",
        |m| uri(m, "https://example.org/a.bin"),
        &["buffers[0].uri", "https:", "absolute"],
    ),
    (
        "file_uri",
        |m| uri(m, "file:///etc/passwd"),
        &["buffers[0].uri", "absolute"],
    ),
    (
        "network_uri",
        |m| uri(m, "//host/a.bin"),
        &["buffers[0].uri", "absolute"],
    ),
    ("drive_uri", |m| uri(m, "C:/a.bin"), &["buffers[0].uri", "absolute"]),
    ("rooted_uri", |m| uri(m, "/dev/zero"), &["buffers[0].uri", "folder"]),
    ("parent_uri", |m| uri(m, "../a.bin"), &["buffers[0].uri", "folder"]),
    (
        "hidden_parent_uri",
        |m| uri(m, "a/%2e%2e/%2E%2E/a.bin"),
        &["buffers[0].uri", "folder"],
    ),
    (
        "no_folder",
        |m| uri(m, "a.bin"),
        &["buffers[0].uri", "without a folder"],
    ),
    ("empty_uri", |m| uri(m, ""), &["buffers[0].uri", "no file"]),
    ("latin_uri", |m| uri(m, "%ff.bin"), &["buffers[0].uri", "UTF-8"]),
    ("data_comma", |m| uri(m, "data:abc"), &["buffers[0].uri", "comma"]),
    (
        "data_base64",
        |m| uri(m, "data:;base64,AAA*"),
        &["buffers[0].uri", "base64"],
    ),
    (
        "data_short",
        |m| uri(m, "data:;base64,AAAA"),
        &["buffers[0].byteLength", "60 bytes", "only 3"],
    ),
    (
        "instanced_count",
        instanced_count,
        &[
            "nodes[0]",
            "EXT_mesh_gpu_instancing",
            "SCALE has 1 elements, expected 2",
        ],
    ),
    ("texture_index", texture, &["materials[0].normalTexture.index", "true"]),
];

const SKINNED: &[Row] = &[
    (
        "no_weights",
        |m| remove(m, "WEIGHTS_0"),
        &["meshes[0].primitives[0].attributes.WEIGHTS_0 is missing"],
    ),
    (
        "no_joints",
        |m| remove(m, "JOINTS_0"),
        &["meshes[0].primitives[0].attributes.JOINTS_0 is missing"],
    ),
    (
        "unskinned",
        |m| remove_both(m),
        &["nodes[0]", "meshes[0].primitives[0]", "JOINTS_0"],
    ),
    (
        "joints_count",
        |m| m.json["accessors"][2]["count"] = json!(3),
        &["JOINTS_0 has 3 elements, expected 4"],
    ),
    (
        "joints_type",
        |m| m.json["accessors"][2]["componentType"] = json!(5120),
        &["accessors[2]", "JOINTS_0", "I8 Vec4"],
    ),
    (
        "no_skin_joints",
        |m| m.json["skins"][0]["joints"] = json!([]),
        &["skins[0].joints is missing"],
    ),
    (
        "joint_range",
        joint_range,
        &["JOINTS_0, vertex 0 names joint 1", "skins[0] of nodes[0] has 1 joints"],
    ),
    (
        "negative_weight",
        |m| set_weights(m, -0.5),
        &["WEIGHTS_0, vertex 3", "-0.5"],
    ),
    (
        "infinite_weight",
        |m| set_weights(m, f32::INFINITY),
        &["WEIGHTS_0, vertex 3", "inf"],
    ),
    (
        "nan_weight",
        |m| set_weights(m, f32::NAN),
        &["WEIGHTS_0, vertex 3", "NaN"],
    ),
    (
        "binds_count",
        |m| binds(m, &[0.0; 16]),
        &["skins[0].inverseBindMatrices", "1 elements, expected 2"],
    ),
    (
        "binds_row",
        |m| binds(m, &[1.0; 32]),
        &["skins[0].inverseBindMatrices, matrix 0", "last row"],
    ),
    (
        "binds_nan",
        |m| binds(m, &[f32::NAN; 32]),
        &["skins[0].inverseBindMatrices, matrix 0", "not finite"],
    ),
    (
        "instanced",
        instanced_skin,
        &["nodes[0]", "EXT_mesh_gpu_instancing", "skin"],
    ),
];

/// What spoils the animation of [`everything`]: samplers are rotation, cubic translation, step weights.
const ANIMATED: &[Row] = &[
    (
        "sampler",
        |m| animation(m)["channels"][0]["sampler"] = json!(3),
        &["animations[0].channels[0].sampler is 3"],
    ),
    (
        "path",
        |m| animation(m)["channels"][0]["target"] = json!({}),
        &["channels[0].target.path is missing"],
    ),
    (
        "interpolation",
        |m| animation(m)["samplers"][0]["interpolation"] = json!("X"),
        &["samplers[0].interpolation"],
    ),
    (
        "times_order",
        |m| times(m, &[0.0, 1.0, 1.0]),
        &["animations[0].samplers[0]", "key 2 is at 1 s"],
    ),
    (
        "times_nan",
        |m| times(m, &[0.0, f32::NAN, 1.0]),
        &["animations[0].samplers[0]", "time of key 1"],
    ),
    (
        "times_none",
        |m| times(m, &[]),
        &["animations[0].samplers[0]", "no keyframes"],
    ),
    (
        "few_values",
        |m| times(m, &[0.0, 1.0]),
        &["animations[0].samplers[0]", "12 output values for 2 keys"],
    ),
    (
        "values_nan",
        values_nan,
        &["animations[0].samplers[0]", "output of key 1 is not finite"],
    ),
    (
        "values_type",
        |m| animation(m)["samplers"][1]["output"] = json!(0),
        &["animations[0].samplers[1]"],
    ),
    (
        "no_rotation",
        no_rotation,
        &["animations[0].samplers[0]", "rotation of key 2 has no length"],
    ),
    (
        "on_matrix",
        on_matrix,
        &["animations[0].channels[0]", "nodes[1]", "matrix"],
    ),
];

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        test("refuse::control", control),
        test("refuse::devices_and_folders", devices),
        test("refuse::zero_accessors_in_many_places", amplified),
        test("refuse::deep_json", deep),
        test("refuse::not_gltf", not_gltf),
        test("refuse::every_truncation", truncations),
    ];
    let bases: [(&str, &[Row], fn() -> Maker); 3] = [
        ("square", SQUARE, Maker::square),
        ("skinned", SKINNED, || {
            Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0])
        }),
        ("animated", ANIMATED, everything),
    ];
    for (base, rows, make) in bases {
        for &(name, spoil, says) in rows {
            tests.push(test(format!("refuse::{base}::{name}"), move || {
                refused(make, spoil, says)
            }));
        }
    }
    tests
}

fn refused(make: fn() -> Maker, spoil: fn(&mut Maker), says: &[&str]) -> Outcome {
    let mut maker = make();
    maker.load()?;
    spoil(&mut maker);
    let message = match maker.load() {
        Ok(_) => return Err("it was accepted".into()),
        Err(error) => error.to_string(),
    };
    let missing: Vec<_> = says.iter().filter(|part| !message.contains(**part)).collect();
    ensure(missing.is_empty(), || format!("{message:?} does not say {missing:?}"))
}

fn control() -> Outcome {
    ensure(refused(Maker::square, |_| {}, &[]).is_err(), || {
        "a good file passed as bad".to_owned()
    })?;
    let (_, spoil, _) = SQUARE[0];
    ensure(refused(Maker::square, spoil, &["nodes[3]"]).is_err(), || {
        "a wrong place passed".to_owned()
    })
}

fn primitive(maker: &mut Maker) -> &mut Value {
    &mut maker.json["meshes"][0]["primitives"][0]
}

fn animation(maker: &mut Maker) -> &mut Value {
    &mut maker.json["animations"][0]
}

fn bare(maker: &mut Maker, count: u64) -> usize {
    maker.push(
        "accessors",
        json!({ "componentType": F32, "type": "VEC3", "count": count }),
    )
}

fn zeros(maker: &mut Maker) {
    let zeros = bare(maker, 3_000_000_000);
    primitive(maker)["attributes"]["POSITION"] = json!(zeros);
}

fn zero_targets(maker: &mut Maker) {
    let zeros = bare(maker, 100_000);
    primitive(maker)["attributes"]["POSITION"] = json!(zeros);
    primitive(maker)["targets"] = json!(vec![json!({}); 1000]);
}

fn set_indices(maker: &mut Maker, component: u32, indices: &[u32]) {
    let indices = maker.indices(component, indices);
    primitive(maker)["indices"] = json!(indices);
}

fn strip_range(maker: &mut Maker) {
    set_indices(maker, U8, &[0, 1, 2, 9]);
    primitive(maker)["mode"] = json!(5);
}

fn nan_target(maker: &mut Maker) {
    let mut offsets = [0.0; 12];
    offsets[7] = f32::NAN;
    let target = maker.floats("VEC3", &offsets);
    primitive(maker)["targets"] = json!([{ "POSITION": target }]);
}

fn target_counts(maker: &mut Maker) {
    let other = primitive(maker).clone();
    primitive(maker)["targets"] = json!([{}]);
    maker.json["meshes"][0]["primitives"]
        .as_array_mut()
        .expect("a list")
        .push(other);
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

/// As gltfpack -c writes it: the view's own buffer is a fallback without data.
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
    maker.json["accessors"][0]
        .as_object_mut()
        .expect("an object")
        .remove("bufferView");
}

fn uri(maker: &mut Maker, uri: &str) {
    let bytes = maker.bytes.len();
    maker.json["buffers"] = json!([{ "byteLength": bytes, "uri": uri }]);
}

fn instanced(maker: &mut Maker, scales: &[f32]) {
    let (places, scales) = (maker.floats("VEC3", &[0.0; 6]), maker.floats("VEC3", scales));
    maker.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places, "SCALE": scales } } });
}

fn instanced_count(maker: &mut Maker) {
    instanced(maker, &[1.0; 3]);
}

fn instanced_skin(maker: &mut Maker) {
    instanced(maker, &[1.0; 6]);
}

fn texture(maker: &mut Maker) {
    maker.json["materials"] = json!([{ "normalTexture": { "index": true } }]);
}

fn remove(maker: &mut Maker, attribute: &str) {
    primitive(maker)["attributes"]
        .as_object_mut()
        .expect("an object")
        .remove(attribute);
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

/// A name that leads to something without an end, or to no file at all.
fn devices() -> Outcome {
    let folder = tempfile::tempdir()?;
    std::fs::create_dir(folder.path().join("folder"))?;
    for path in [
        folder.path().join("folder"),
        folder.path().join("none"),
        "/dev/zero".into(),
    ] {
        let result = Asset::open(&path, Weld::Keep);
        ensure(matches!(result, Err(GltfError::Read { .. })), || {
            format!("{path:?}: {result:?}")
        })?;
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/dev/zero", folder.path().join("endless"))?;
        let mut maker = Maker::square();
        uri(&mut maker, "endless");
        let result = Asset::from_slice(&maker.glb(), Some(folder.path()), Weld::Keep);
        ensure(matches!(result, Err(GltfError::Read { .. })), || format!("{result:?}"))?;
    }
    Ok(())
}

/// Each accessor is small, all together are not.
fn amplified() -> Outcome {
    let mut maker = Maker::square();
    let zeros = bare(&mut maker, 60_000);
    let mesh = json!({ "primitives": [{ "attributes": { "POSITION": zeros } }] });
    maker.json["meshes"] = json!(vec![mesh; 5000]);
    let many = maker.load().map(|_| ());
    ensure(matches!(many, Err(GltfError::TooMuch { .. })), || {
        format!("meshes: {many:?}")
    })?;
    let mut maker = Maker::square();
    let indices = maker.indices(U8, &[0; 30_000]);
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": indices });
    maker.json["meshes"][0]["primitives"] = json!(vec![primitive; 5000]);
    let many = maker.load().map(|_| ());
    ensure(matches!(many, Err(GltfError::TooMuch { .. })), || {
        format!("primitives: {many:?}")
    })?;
    let mut maker = Maker::skinned([0; 4], [1.0; 4]);
    maker.json["skins"][0]["joints"] = json!(vec![1; 20_000]);
    maker.json["nodes"]
        .as_array_mut()
        .expect("a list")
        .extend(vec![json!({ "mesh": 0, "skin": 0 }); 2000]);
    let many = maker.load().map(|_| ());
    ensure(matches!(many, Err(GltfError::TooMuch { .. })), || {
        format!("palettes: {many:?}")
    })
}

fn deep() -> Outcome {
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let text = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        let result = Asset::from_slice(text.as_bytes(), None, Weld::Keep);
        ensure(matches!(result, Err(GltfError::Json(_))), || "deep JSON".to_owned())?;
    }
    // A chain of nodes may be as deep as it likes.
    let mut maker = Maker::square();
    let chain: Vec<Value> = (1..50_000).map(|child| json!({ "children": [child] })).collect();
    maker.json["nodes"] = json!(chain);
    maker.push("nodes", json!({ "mesh": 0, "translation": [1, 0, 0] }));
    let asset = maker.load()?;
    ensure(asset.pose(None, 0.0)?.instances.len() == 1, || "instances".to_owned())
}

fn not_gltf() -> Outcome {
    for bytes in [
        &b""[..],
        b"glT",
        b"glTF",
        b"glTF\x02\0\0\0\0\0\0\0",
        b"{}",
        b"[]",
        b"\xff\xfe",
        b"ply\n",
        b"null",
    ] {
        let result = Asset::from_slice(bytes, None, Weld::Keep);
        ensure(result.is_err(), || format!("{bytes:?} was accepted"))?;
    }
    Ok(())
}

fn truncations() -> Outcome {
    for file in [everything().glb(), everything().gltf()] {
        for length in 0..file.len() {
            let result = Asset::from_slice(&file[..length], None, Weld::Keep);
            ensure(result.is_err(), || format!("the first {length} bytes were accepted"))?;
        }
    }
    Ok(())
}
