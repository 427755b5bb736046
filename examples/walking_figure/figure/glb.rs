//! The figure as a glTF 2.0 binary.

use rimline::glam::{Mat4, Vec3};
use serde_json::{Value, json};

use super::skeleton::{HIPS, JOINTS};
use super::{Figure, walk};

const BYTES: u32 = 5121;
const WORDS: u32 = 5125;
const FLOATS: u32 = 5126;
/// Targets of buffer views.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The whole file.
pub(crate) fn encode(figure: &Figure) -> Vec<u8> {
    let mut data = Data::default();
    let primitive = json!({
        "attributes": {
            "POSITION": positions(&mut data, &figure.positions),
            "NORMAL": data.floats("VEC3", figure.normals.iter().map(Vec3::to_array), Some(VERTICES)),
            "JOINTS_0": joints(&mut data, &figure.joints),
            "WEIGHTS_0": data.floats("VEC4", figure.weights.iter().copied(), Some(VERTICES)),
        },
        "indices": indices(&mut data, &figure.faces),
        "material": 0,
    });
    let inverse_binds = JOINTS
        .iter()
        .map(|joint| Mat4::from_translation(-joint.at).to_cols_array());
    let skin = json!({
        "inverseBindMatrices": data.floats("MAT4", inverse_binds, None),
        "joints": (0..JOINTS.len()).map(|joint| FIRST_JOINT + joint).collect::<Vec<_>>(),
        "skeleton": FIRST_JOINT,
    });
    let animation = animation(&mut data);
    let document = json!({
        "asset": { "version": "2.0", "generator": "rimline, examples/walking_figure" },
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
        "buffers": [{ "byteLength": data.bytes.len() }],
        "bufferViews": data.views,
        "accessors": data.accessors,
    });
    container(document.to_string().into_bytes(), data.bytes)
}

/// Node 0 holds the mesh, the joints follow.
const FIRST_JOINT: usize = 1;

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

fn animation(data: &mut Data) -> Value {
    let keys = walk::keys();
    let times = (0..walk::KEYS).map(|key| [walk::DURATION * key as f32 / (walk::KEYS - 1) as f32]);
    let times = data.floats("SCALAR", times, None);
    data.set_bounds(times, &[0.0], &[walk::DURATION]);
    let hips = data.floats("VEC3", keys.iter().map(|pose| pose.hips.to_array()), None);
    let mut samplers = vec![json!({ "input": times, "output": hips, "interpolation": "LINEAR" })];
    let mut channels = vec![json!({ "sampler": 0, "target": { "node": FIRST_JOINT + HIPS, "path": "translation" } })];
    for joint in 0..JOINTS.len() {
        let rotations = data.floats("VEC4", keys.iter().map(|pose| pose.rotations[joint].to_array()), None);
        let target = json!({ "node": FIRST_JOINT + joint, "path": "rotation" });
        channels.push(json!({ "sampler": samplers.len(), "target": target }));
        samplers.push(json!({ "input": times, "output": rotations, "interpolation": "LINEAR" }));
    }
    json!({ "name": "walk", "samplers": samplers, "channels": channels })
}

fn positions(data: &mut Data, positions: &[Vec3]) -> usize {
    let accessor = data.floats("VEC3", positions.iter().map(Vec3::to_array), Some(VERTICES));
    let bounds =
        |pick: fn(Vec3, Vec3) -> Vec3, start: f32| positions.iter().copied().fold(Vec3::splat(start), pick).to_array();
    let (low, high) = (bounds(Vec3::min, f32::INFINITY), bounds(Vec3::max, f32::NEG_INFINITY));
    data.set_bounds(accessor, &low, &high);
    accessor
}

fn joints(data: &mut Data, joints: &[[u8; 4]]) -> usize {
    data.push("VEC4", BYTES, joints.len(), joints.as_flattened(), Some(VERTICES))
}

fn indices(data: &mut Data, faces: &[[u32; 3]]) -> usize {
    let bytes: Vec<u8> = faces.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    data.push("SCALAR", WORDS, 3 * faces.len(), &bytes, Some(INDICES))
}

/// The binary chunk and what describes it.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    /// An accessor with a view of its own; everything in this file is a multiple of 4 bytes long, so views stay
    /// aligned.
    fn push(&mut self, shape: &str, component: u32, count: usize, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        let accessor =
            json!({ "bufferView": self.views.len(), "componentType": component, "count": count, "type": shape });
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(
        &mut self,
        shape: &str,
        elements: impl Iterator<Item = [f32; N]>,
        target: Option<u32>,
    ) -> usize {
        let bytes: Vec<u8> = elements.flatten().flat_map(f32::to_le_bytes).collect();
        self.push(shape, FLOATS, bytes.len() / (4 * N), &bytes, target)
    }

    fn set_bounds(&mut self, accessor: usize, low: &[f32], high: &[f32]) {
        self.accessors[accessor]["min"] = json!(low);
        self.accessors[accessor]["max"] = json!(high);
    }
}

/// The GLB container: a header, a JSON chunk padded with spaces, a binary chunk padded with zeros.
fn container(mut json: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = Vec::with_capacity(total);
    file.extend_from_slice(b"glTF");
    for word in [2, total as u32, json.len() as u32] {
        file.extend_from_slice(&word.to_le_bytes());
    }
    file.extend_from_slice(b"JSON");
    file.extend_from_slice(&json);
    file.extend_from_slice(&(binary.len() as u32).to_le_bytes());
    file.extend_from_slice(b"BIN\0");
    file.extend_from_slice(&binary);
    file
}
