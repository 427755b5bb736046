//! Files whose vertices or nodes move.

use std::ops::Range;

use rimline_bench::shapes::{self, Shape};
use serde_json::{Value, json};

use super::still::{add_node, alone, quantized as in_integers};
use crate::maker::{F32, Maker, U8, U16, U32, flat};

const JOINTS: usize = 5;
/// Key times.
const TIMES: [f32; 3] = [0.25, 1.0, 3.5];
/// The last one is on the other side of the sphere from the second, so the shorter arc goes to its opposite.
const TURNS: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8, 0.6, 0.0, 0.0, -0.8];

/// Adds an animation that moves a path of several nodes by the same keys.
fn animate(maker: &mut Maker, name: &str, nodes: Range<usize>, path: &str, interpolation: &str, keys: &[f32]) {
    let kind = match path {
        "rotation" => "VEC4",
        "weights" => "SCALAR",
        _ => "VEC3",
    };
    // Tangents before and after each key.
    let width = keys.len() / TIMES.len();
    let around = |key: &[f32]| [&vec![0.25; width], key, &vec![-0.5; width]].concat();
    let output = match interpolation {
        "CUBICSPLINE" => keys.chunks(width).flat_map(around).collect(),
        _ => keys.to_vec(),
    };
    let sampler = maker.keys(&TIMES, kind, &output, interpolation);
    let channels: Vec<_> =
        nodes.map(|node| json!({ "sampler": 0, "target": { "node": node, "path": path } })).collect();
    maker.push("animations", json!({ "name": name, "samplers": [sampler], "channels": channels }));
}

/// Integers of both kinds, one mesh at several nodes, which move.
pub(super) fn quantized() -> Maker {
    let mut maker = Maker::new();
    let ring = in_integers(&mut maker, &shapes::torus(16, 10, 0.7, 0.3), 32767.0, true);
    let ball = in_integers(&mut maker, &shapes::sphere(5), 5000.0, false);
    let nodes = [
        add_node(&mut maker, std::slice::from_ref(&ring), json!({ "scale": [2, 2, 2] })),
        add_node(&mut maker, &[ball, ring], json!({ "translation": [0, 3, 0], "scale": [2e-4, 2e-4, 2e-4] })),
        maker.push("nodes", json!({ "mesh": 0, "translation": [4, 0, 0] })),
        maker.push("nodes", json!({ "mesh": 0, "translation": [-4, 0, 0] })),
    ];
    maker.scene(&nodes);
    maker.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    maker.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    animate(&mut maker, "wheels", 2..4, "rotation", "LINEAR", &TURNS);
    maker
}

/// An animation for each property and interpolation.
pub(super) fn interpolations() -> Maker {
    let mut maker = Maker::new();
    let translations = [0.0, 0.0, 0.0, 1.0, 2.0, 0.0, -1.0, 0.5, 3.0];
    let scales = [1.0, 1.0, 1.0, 2.0, 0.5, 1.0, 0.5, 1.5, -1.0];
    let paths = [("translation", &translations[..]), ("rotation", &TURNS), ("scale", &scales)];
    for (row, (path, keys)) in paths.into_iter().enumerate() {
        for (column, interpolation) in ["STEP", "LINEAR", "CUBICSPLINE"].into_iter().enumerate() {
            let cube = maker.primitive(&shapes::cube(), U8);
            let node = add_node(&mut maker, &[cube], json!({ "translation": [4 * column, 4 * row, 0] }));
            animate(&mut maker, &format!("{path} {interpolation}"), node..node + 1, path, interpolation, keys);
        }
    }
    maker.scene(&[0, 1, 2, 3, 4, 5, 6, 7, 8]);
    maker
}

/// Two primitives of eight targets, one sparse and one of zeros; weights of both signs, in each interpolation.
pub(super) fn morphed() -> Maker {
    let mut maker = Maker::new();
    let primitives: Vec<Value> = [shapes::cube(), shapes::sphere(3)]
        .iter()
        .map(|shape| {
            let mut primitive = maker.primitive(shape, U16);
            let targets = (0..8).map(|target| {
                let count = shape.positions.len();
                let offset = |&[x, y, z]: &[f32; 3]| [y * (0.1 * target as f32), 0.3 * x, 0.2 * z * x];
                let offsets: Vec<f32> = shape.positions.iter().flat_map(offset).collect();
                match target {
                    3 | 7 => maker.zeros(count as u64),
                    _ => maker.floats("VEC3", &offsets),
                }
            });
            let targets: Vec<usize> = targets.collect();
            maker.sparse(targets[3], &[1, 5], &[0.5, 0.0, -0.5, 0.0, 0.75, 0.0]);
            primitive["targets"] = targets.into_iter().map(|target| json!({ "POSITION": target })).collect();
            primitive
        })
        .collect();
    let node = add_node(&mut maker, &primitives, json!({ "weights": [0.5, -0.5, 0.0, 1.0, 0.25, -2.0, 0.0, 1.0] }));
    maker.json["meshes"][0]["weights"] = json!([1, 1, 1, 1, 1, 1, 1, 1]);
    maker.scene(&[node]);
    let keys: Vec<f32> = (0..24).map(|at| (at * 5 % 7) as f32 / 3.0 - 1.0).collect();
    for interpolation in ["STEP", "LINEAR", "CUBICSPLINE"] {
        animate(&mut maker, interpolation, node..node + 1, "weights", interpolation, &keys);
    }
    maker
}

/// A closed body along y from −2 to 2.
fn body() -> Shape {
    let mut shape = shapes::globe(12, 14);
    shape.positions.iter_mut().for_each(|p| *p = [p[1], 2.0 * p[2], p[0]]);
    shape
}

/// A vertex follows the two joints that it is between, and a third a little. The sum of its weights need not be 1.
fn influences([_, y, _]: [f32; 3]) -> ([u8; 4], [f32; 4]) {
    let lower = ((y + 2.0) as usize).min(JOINTS - 2);
    let upper = y + 2.0 - lower as f32;
    let sum = [1.0, 0.18, 1.76][lower % 3];
    let weights = [0.9 * (1.0 - upper), 0.9 * upper, 0.1, 0.0].map(|weight| sum * weight);
    ([lower, lower + 1, (lower + 3) % JOINTS, 0].map(|joint| joint as u8), weights)
}

/// A primitive whose influences are in one set, or halved in each of two.
fn influenced(maker: &mut Maker, shape: &Shape, sets: usize) -> Value {
    let mut primitive = maker.primitive(shape, U16);
    for set in 0..sets {
        let (mut joints, mut weights) = (Vec::new(), Vec::new());
        for &position in &shape.positions {
            let (mut set_joints, mut shares) = influences(position);
            set_joints.rotate_right(set);
            shares.rotate_right(set);
            joints.extend(set_joints);
            weights.extend(shares.map(|share| share / sets as f32));
        }
        let joints = maker.accessor(U8, "VEC4", shape.positions.len(), &joints);
        primitive["attributes"][format!("JOINTS_{set}")] = json!(joints);
        primitive["attributes"][format!("WEIGHTS_{set}")] = json!(maker.floats("VEC4", &weights));
    }
    primitive
}

/// A chain of joints along the body, below a node with these properties, and its skin.
fn skeleton(maker: &mut Maker, mut root: Value) -> usize {
    let first = maker.json["nodes"].as_array().map_or(0, Vec::len) + 1;
    root["children"] = json!([first]);
    maker.push("nodes", root);
    let mut binds = Vec::new();
    for joint in 0..JOINTS {
        let y = if joint == 0 { -2.0 } else { 1.0 };
        let node = maker.push("nodes", json!({ "translation": [0.0, y, 0.0] }));
        if joint + 1 < JOINTS {
            maker.json["nodes"][node]["children"] = json!([node + 1]);
        }
        binds.extend([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0 - joint as f32, 0.0, 1.0]);
    }
    let binds = maker.floats("MAT4", &binds);
    let joints: Vec<usize> = (first..first + JOINTS).collect();
    maker.push("skins", json!({ "joints": joints, "inverseBindMatrices": binds }))
}

/// A file of one skinned primitive, whose node is 0 and whose joints are 2 to 6, and two animations.
fn one_skin(make: impl FnOnce(&mut Maker) -> Value) -> Maker {
    let mut maker = Maker::new();
    let primitive = make(&mut maker);
    add_node(&mut maker, &[primitive], json!({ "skin": 0 }));
    skeleton(&mut maker, json!({ "translation": [0, 2, 0] }));
    maker.scene(&[0, 1]);
    animate(&mut maker, "Survey", 2..2 + JOINTS, "rotation", "LINEAR", &TURNS);
    animate(&mut maker, "Walk", 3..4, "scale", "CUBICSPLINE", &[1.0, 1.0, 1.0, 0.5, 2.0, 1.0, 1.5, 1.0, 0.75]);
    maker
}

/// A thing that hangs on a joint, too.
pub(super) fn skinned() -> Maker {
    let mut maker = one_skin(|maker| influenced(maker, &body(), 1));
    let cube = maker.primitive(&shapes::cube(), U8);
    let thing = add_node(&mut maker, &[cube], json!({ "translation": [1, 0, 0], "scale": [0.25, 0.25, 0.25] }));
    maker.json["nodes"][4]["children"] = json!([5, thing]);
    maker
}

/// Eight influences a vertex, and a morph target.
pub(super) fn skinned_twice_morphed() -> Maker {
    let mut maker = one_skin(|maker| {
        let shape = body();
        let mut primitive = influenced(maker, &shape, 2);
        let offsets: Vec<f32> = shape.positions.iter().flat_map(|&[x, _, z]| [0.5 * x, 0.1, 0.5 * z]).collect();
        primitive["targets"] = json!([{ "POSITION": maker.floats("VEC3", &offsets) }]);
        primitive
    });
    maker.json["meshes"][0]["weights"] = json!([0.5]);
    maker
}

/// Corners in the order of faces, which only welding joins.
pub(super) fn without_indices() -> Maker {
    let mut maker = one_skin(|maker| {
        let mut primitive = influenced(maker, &flat(&body()), 1);
        primitive.as_object_mut().expect("an object").remove("indices");
        primitive
    });
    animate(&mut maker, "Run", 4..6, "rotation", "STEP", &TURNS);
    maker
}

/// One mesh with four skeletons; its vertices are interleaved, with weights in bytes.
pub(super) fn skinned_instances() -> Maker {
    let shape = body();
    let mut bytes = Vec::new();
    for &position in &shape.positions {
        let (joints, weights) = influences(position);
        bytes.extend(position.iter().flat_map(|axis| axis.to_le_bytes()));
        bytes.extend(joints);
        bytes.extend(weights.map(|weight| (weight * 144.0).round() as u8));
    }
    let mut maker = alone(&Shape { positions: Vec::new(), ..shape.clone() }, U32);
    let view = maker.view(&bytes);
    maker.json["bufferViews"][view]["byteStride"] = json!(20);
    let mut within = |offset: usize, component: u32, kind: &str| {
        maker.push(
            "accessors",
            json!({ "bufferView": view, "byteOffset": offset, "componentType": component, "type": kind,
                "count": shape.positions.len(), "normalized": offset == 16 }),
        )
    };
    let attributes = json!({
        "POSITION": within(0, F32, "VEC3"), "JOINTS_0": within(12, U8, "VEC4"), "WEIGHTS_0": within(16, U8, "VEC4"),
    });
    maker.json["meshes"][0]["primitives"][0]["attributes"] = attributes;
    let mut roots = Vec::new();
    for instance in 0..4 {
        let skin = skeleton(&mut maker, json!({ "translation": [3 * instance, instance, 0] }));
        let node = if instance == 0 { 0 } else { maker.push("nodes", json!({ "mesh": 0 })) };
        maker.json["nodes"][node]["skin"] = json!(skin);
        let joints = maker.json["skins"][skin]["joints"][0].as_u64().expect("an index") as usize;
        roots.extend([node, joints - 1]);
    }
    maker.json["scenes"][0]["nodes"] = json!(roots);
    let second = maker.json["skins"][1]["joints"][0].as_u64().expect("an index") as usize;
    animate(&mut maker, "bend", second..second + JOINTS, "rotation", "CUBICSPLINE", &TURNS);
    maker
}
