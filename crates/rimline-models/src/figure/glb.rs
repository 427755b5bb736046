//! The figure as a glTF 2.0 binary.

use glam::{Mat4, Vec3};
use serde_json::{Value, json};

use super::skeleton::{HIPS, JOINTS};
use super::{Figure, walk};
use crate::maker::{INDICES, Maker, U8, U32, VERTICES};

/// Node 0 holds the mesh, the joints follow.
const FIRST_JOINT: usize = 1;

/// The whole file.
pub fn encode(figure: &Figure) -> Vec<u8> {
    let mut file = Maker::new();
    file.json["asset"]["generator"] = json!("rimline's examples");
    let positions: Vec<f32> = figure.positions.iter().flat_map(Vec3::to_array).collect();
    let attributes = [
        ("POSITION", file.bounded("VEC3", &positions)),
        ("NORMAL", floats(&mut file, "VEC3", figure.normals.iter().map(Vec3::to_array))),
        ("JOINTS_0", file.accessor(U8, "VEC4", figure.joints.len(), figure.joints.as_flattened())),
        ("WEIGHTS_0", floats(&mut file, "VEC4", figure.weights.iter().copied())),
    ];
    let mut primitive = json!({ "indices": file.indices(U32, figure.faces.as_flattened()), "material": 0 });
    file.bind(&primitive["indices"], INDICES);
    for (name, accessor) in attributes {
        primitive["attributes"][name] = json!(accessor);
        file.bind(&primitive["attributes"][name], VERTICES);
    }
    file.push("meshes", json!({ "name": "figure", "primitives": [primitive] }));
    let inverse_binds = JOINTS.map(|joint| Mat4::from_translation(-joint.at).to_cols_array());
    let inverse_binds = floats(&mut file, "MAT4", inverse_binds);
    let joints: Vec<usize> = (0..JOINTS.len()).map(|joint| FIRST_JOINT + joint).collect();
    file.push("skins", json!({ "inverseBindMatrices": inverse_binds, "joints": joints, "skeleton": FIRST_JOINT }));
    let animation = animation(&mut file);
    file.push("animations", animation);
    let clay = json!({ "baseColorFactor": [0.78, 0.69, 0.6, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8 });
    file.push("materials", json!({ "name": "clay", "pbrMetallicRoughness": clay }));
    file.json["nodes"] = json!(nodes());
    file.scene(&[0, FIRST_JOINT]);
    file.glb()
}

/// An accessor of vectors or matrices.
fn floats<const N: usize>(file: &mut Maker, kind: &str, elements: impl IntoIterator<Item = [f32; N]>) -> usize {
    file.floats(kind, &elements.into_iter().flatten().collect::<Vec<_>>())
}

fn nodes() -> Vec<Value> {
    let mut nodes = vec![json!({ "name": "figure", "mesh": 0, "skin": 0 })];
    for (index, joint) in JOINTS.iter().enumerate() {
        let children: Vec<_> = (0..JOINTS.len())
            .filter(|&child| JOINTS[child].parent == Some(index))
            .map(|child| FIRST_JOINT + child)
            .collect();
        let mut node = json!({ "name": joint.name, "translation": walk::offset(index).to_array() });
        if !children.is_empty() {
            node["children"] = json!(children);
        }
        nodes.push(node);
    }
    nodes
}

fn animation(file: &mut Maker) -> Value {
    let keys = walk::keys();
    let times: [f32; walk::KEYS] = std::array::from_fn(|key| walk::DURATION * walk::phase(key));
    let times = file.bounded("SCALAR", &times);
    let hips = floats(file, "VEC3", keys.iter().map(|pose| pose.hips.to_array()));
    let mut samplers = vec![json!({ "input": times, "output": hips, "interpolation": "LINEAR" })];
    let mut channels = vec![json!({ "sampler": 0, "target": { "node": FIRST_JOINT + HIPS, "path": "translation" } })];
    for joint in 0..JOINTS.len() {
        let rotations = floats(file, "VEC4", keys.iter().map(|pose| pose.rotations[joint].to_array()));
        let target = json!({ "node": FIRST_JOINT + joint, "path": "rotation" });
        channels.push(json!({ "sampler": samplers.len(), "target": target }));
        samplers.push(json!({ "input": times, "output": rotations, "interpolation": "LINEAR" }));
    }
    json!({ "name": "walk", "samplers": samplers, "channels": channels })
}
