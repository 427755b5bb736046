//! The figure as a glTF 2.0 binary.

use glam::{Mat4, Vec3};
use serde_json::{Value, json};

use super::skeleton::{HIPS, JOINTS};
use super::{Figure, walk};
use crate::glb_file::{GlbFile, VERTICES};

/// Node 0 holds the mesh, the joints follow.
const FIRST_JOINT: usize = 1;
/// Accessors' component type of joint indices.
const BYTES: u32 = 5121;

/// The whole file.
pub fn encode(figure: &Figure) -> Vec<u8> {
    let mut file = GlbFile::default();
    let positions: Vec<_> = figure.positions.iter().map(Vec3::to_array).collect();
    let primitive = json!({
        "attributes": {
            "POSITION": file.bounded(&positions, Some(VERTICES)),
            "NORMAL": file.floats(figure.normals.iter().map(Vec3::to_array), Some(VERTICES)),
            "JOINTS_0": file.accessor("VEC4", BYTES, figure.joints.as_flattened(), Some(VERTICES)),
            "WEIGHTS_0": file.floats(figure.weights.iter().copied(), Some(VERTICES)),
        },
        "indices": file.indices(&figure.faces),
        "material": 0,
    });
    let inverse_binds = JOINTS.map(|joint| Mat4::from_translation(-joint.at).to_cols_array());
    let skin = json!({
        "inverseBindMatrices": file.floats(inverse_binds, None),
        "joints": (0..JOINTS.len()).map(|joint| FIRST_JOINT + joint).collect::<Vec<_>>(),
        "skeleton": FIRST_JOINT,
    });
    let animation = animation(&mut file);
    file.finish(json!({
        "scene": 0,
        "scenes": [{ "nodes": [0, FIRST_JOINT] }],
        "nodes": nodes(),
        "meshes": [{ "name": "figure", "primitives": [primitive] }],
        "skins": [skin],
        "animations": [animation],
        "materials": [{
            "name": "clay",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.78, 0.69, 0.6, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8,
            },
        }],
    }))
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

fn animation(file: &mut GlbFile) -> Value {
    let keys = walk::keys();
    let times = std::array::from_fn::<_, { walk::KEYS }, _>(|key| [walk::DURATION * walk::phase(key)]);
    let times = file.bounded(&times, None);
    let hips = file.floats(keys.iter().map(|pose| pose.hips.to_array()), None);
    let mut samplers = vec![json!({ "input": times, "output": hips, "interpolation": "LINEAR" })];
    let mut channels = vec![json!({ "sampler": 0, "target": { "node": FIRST_JOINT + HIPS, "path": "translation" } })];
    for joint in 0..JOINTS.len() {
        let rotations = file.floats(keys.iter().map(|pose| pose.rotations[joint].to_array()), None);
        let target = json!({ "node": FIRST_JOINT + joint, "path": "rotation" });
        channels.push(json!({ "sampler": samplers.len(), "target": target }));
        samplers.push(json!({ "input": times, "output": rotations, "interpolation": "LINEAR" }));
    }
    json!({ "name": "walk", "samplers": samplers, "channels": channels })
}
