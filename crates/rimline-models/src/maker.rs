//! glTF files made by code.

use rimline::gltf::{Asset, GltfError, LoadOptions};
use rimline::mesh::Weld;
use rimline_bench::shapes::Shape;
use serde_json::{Value, json};

pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// Targets of views.
pub const VERTICES: u32 = 34962;
pub const INDICES: u32 = 34963;

/// Four corners of a square in the plane z = 0.
pub const SQUARE: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];

/// A file being made: its JSON and its only buffer.
#[derive(Clone)]
pub struct Maker {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl Default for Maker {
    fn default() -> Self {
        Self::new()
    }
}

impl Maker {
    pub fn new() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), bytes: Vec::new() }
    }

    /// Appends to one of the file's lists and gives the index there.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, data: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(data);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": data.len() }))
    }

    pub fn accessor(&mut self, component: u32, kind: &str, count: usize, data: &[u8]) -> usize {
        let view = self.view(data);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    pub fn floats(&mut self, kind: &str, data: &[f32]) -> usize {
        let bytes: Vec<u8> = data.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(F32, kind, data.len() / width(kind), &bytes)
    }

    /// [`Self::floats`] with the bounds that positions and key times must have.
    pub fn bounded(&mut self, kind: &str, data: &[f32]) -> usize {
        let accessor = self.floats(kind, data);
        let bounds = |pick: fn(f32, f32) -> f32, start: f32| {
            let axis = |axis: usize| data.iter().skip(axis).step_by(width(kind)).copied().fold(start, pick);
            (0..width(kind)).map(axis).collect::<Vec<f32>>()
        };
        self.json["accessors"][accessor]["min"] = json!(bounds(f32::min, f32::INFINITY));
        self.json["accessors"][accessor]["max"] = json!(bounds(f32::max, f32::NEG_INFINITY));
        accessor
    }

    /// States the target of an accessor's view.
    pub fn bind(&mut self, accessor: &Value, target: u32) {
        let index = |value: &Value| value.as_u64().expect("an index") as usize;
        let view = index(&self.json["accessors"][index(accessor)]["bufferView"]);
        self.json["bufferViews"][view]["target"] = json!(target);
    }

    /// Indices, which this component type must hold.
    pub fn indices(&mut self, component: u32, data: &[u32]) -> usize {
        let size = match component {
            U8 => 1,
            U16 => 2,
            _ => 4,
        };
        let bytes: Vec<u8> = data.iter().flat_map(|v| v.to_le_bytes()[..size].to_vec()).collect();
        self.accessor(component, "SCALAR", data.len(), &bytes)
    }

    /// An accessor of this number of `VEC3` of floats without bytes, all zeros.
    pub fn zeros(&mut self, count: u64) -> usize {
        self.push("accessors", json!({ "componentType": F32, "type": "VEC3", "count": count }))
    }

    /// Other values for some elements of an accessor of floats.
    pub fn sparse(&mut self, accessor: usize, elements: &[u16], values: &[f32]) {
        let indices = self.view(&elements.iter().flat_map(|at| at.to_le_bytes()).collect::<Vec<u8>>());
        let values = self.view(&values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>());
        self.json["accessors"][accessor]["sparse"] = json!({
            "count": elements.len(),
            "indices": { "bufferView": indices, "componentType": U16 },
            "values": { "bufferView": values },
        });
    }

    /// A sampler of an animation. The values are of this accessor type.
    pub fn keys(&mut self, times: &[f32], kind: &str, values: &[f32], interpolation: &str) -> Value {
        let (input, output) = (self.floats("SCALAR", times), self.floats(kind, values));
        json!({ "input": input, "output": output, "interpolation": interpolation })
    }

    /// An animation of one channel.
    pub fn animate(&mut self, node: usize, path: &str, sampler: &Value) {
        let channel = json!({ "sampler": 0, "target": { "node": node, "path": path } });
        self.push("animations", json!({ "samplers": [sampler], "channels": [channel] }));
    }

    /// Corners of a shape's faces and the positions that they name: a primitive.
    pub fn primitive(&mut self, shape: &Shape, component: u32) -> Value {
        let positions = self.floats("VEC3", shape.positions.as_flattened());
        let indices = self.indices(component, shape.faces.as_flattened());
        json!({ "attributes": { "POSITION": positions }, "indices": indices })
    }

    /// A scene, which is shown.
    pub fn scene(&mut self, nodes: &[usize]) {
        let scene = self.push("scenes", json!({ "nodes": nodes }));
        self.json["scene"] = json!(scene);
    }

    /// A mesh of one primitive.
    pub fn mesh(&mut self, primitive: &Value) -> usize {
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// A square of two triangles at node 0. There is no scene, so that all nodes are shown.
    pub fn square() -> Self {
        let mut maker = Self::new();
        let positions = maker.floats("VEC3", &SQUARE);
        let indices = maker.indices(U16, &[0, 1, 2, 0, 2, 3]);
        let mesh = maker.mesh(&json!({ "attributes": { "POSITION": positions }, "indices": indices }));
        maker.push("nodes", json!({ "mesh": mesh }));
        maker
    }

    /// A square whose vertices follow two joints, the nodes 1 and 2, with the given weights, the same for all vertices.
    pub fn skinned(joints: [u8; 4], weights: [f32; 4]) -> Self {
        let mut maker = Self::square();
        let joints = maker.accessor(U8, "VEC4", 4, &joints.repeat(4));
        let weights = maker.floats("VEC4", &weights.repeat(4));
        let attributes = &mut maker.json["meshes"][0]["primitives"][0]["attributes"];
        attributes["JOINTS_0"] = json!(joints);
        attributes["WEIGHTS_0"] = json!(weights);
        maker.json["nodes"][0]["skin"] = json!(0);
        maker.push("nodes", json!({ "translation": [1, 0, 0] }));
        maker.push("nodes", json!({ "translation": [0, 10, 0] }));
        maker.push("skins", json!({ "joints": [1, 2] }));
        maker
    }

    fn with_buffer(&self, uri: Option<String>) -> Value {
        let mut value = self.json.clone();
        if !self.bytes.is_empty() && value["buffers"].is_null() {
            value["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
            if let Some(uri) = uri {
                value["buffers"][0]["uri"] = json!(uri);
            }
        }
        value
    }

    pub fn glb(&self) -> Vec<u8> {
        glb(self.with_buffer(None).to_string().as_bytes(), &self.bytes)
    }

    /// The asset as JSON with a data URI, unless its JSON has `buffers` already.
    pub fn gltf(&self) -> Vec<u8> {
        use base64::Engine as _;
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        self.with_buffer(Some(uri)).to_string().into_bytes()
    }

    /// Loads it without welding, in at most 256 MiB.
    pub fn load(&self) -> Result<Asset, GltfError> {
        let options = LoadOptions { memory_limit: 256 << 20, ..Weld::Keep.into() };
        Asset::from_slice(&self.glb(), None, options)
    }
}

/// The components of the accessor types that are made here: `SCALAR`, `VEC3`, `VEC4`, and `MAT4` for any other name.
fn width(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 16,
    }
}

/// The same faces, each with corners of its own.
pub fn flat(shape: &Shape) -> Shape {
    let corners = shape.faces.as_flattened().iter();
    let positions: Vec<_> = corners.map(|&vertex| shape.positions[vertex as usize]).collect();
    let faces = (0..shape.faces.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    Shape { positions, faces }
}

/// A GLB of the two chunks.
pub fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let (mut json, mut binary) = (json.to_vec(), binary.to_vec());
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut file = b"glTF".to_vec();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    for word in [2, length as u32, json.len() as u32] {
        file.extend(word.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(json);
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

/// A small file that uses nearly everything the loader reads: a skinned and morphed mesh with two influence sets, a
/// quantised sparse mesh instanced on the GPU, lights, and all interpolations.
pub fn everything() -> Maker {
    let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.25, 0.0, 0.0]);
    complete_skinned_mesh(&mut maker);
    let node = add_quantized_fans(&mut maker);
    maker.push(
        "cameras",
        json!({ "name": "eye", "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1, "zfar": 9 } }),
    );
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "name": "lamp" }] } });
    maker.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_lights_punctual", "KHR_mesh_quantization"]);
    maker.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    add_animation(&mut maker, node);
    maker.push("scenes", json!({ "nodes": [0, 1, 2, node] }));
    maker.json["scene"] = json!(0);
    maker
}

/// A second influence set, colours, a morph target and inverse bind matrices.
fn complete_skinned_mesh(maker: &mut Maker) {
    let joints = maker.accessor(U8, "VEC4", 4, &[1, 0, 0, 0].repeat(4));
    let weights = maker.accessor(U8, "VEC4", 4, &[255, 0, 0, 0].repeat(4));
    maker.json["accessors"][weights]["normalized"] = json!(true);
    let offsets = maker.floats("VEC3", &[0.5; 12]);
    let colors = maker.accessor(U8, "VEC4", 4, &[0, 51, 102, 255].repeat(4));
    maker.json["accessors"][colors]["normalized"] = json!(true);
    let material = maker.push("materials", json!({ "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 0.25, 1] } }));
    let primitive = &mut maker.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["COLOR_0"] = json!(colors);
    primitive["material"] = json!(material);
    primitive["attributes"]["JOINTS_1"] = json!(joints);
    primitive["attributes"]["WEIGHTS_1"] = json!(weights);
    primitive["targets"] = json!([{ "POSITION": offsets }]);
    maker.json["meshes"][0]["weights"] = json!([0.25]);
    let identity: Vec<f32> = (0..16).map(|i| if i % 5 == 0 { 1.0 } else { 0.0 }).collect();
    let binds = maker.floats("MAT4", &identity.repeat(2));
    maker.json["skins"][0]["inverseBindMatrices"] = json!(binds);
}

/// A quantised sparse mesh, and a node with instances of it, a light and a camera. Returns the node.
fn add_quantized_fans(maker: &mut Maker) -> usize {
    let fan: Vec<u8> = [0_i16, 0, 0, 0, 32767, 0, 0, 0, 32767, 32767, 0, 0, 0, 32767, 0, 0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let quantized = maker.accessor(5122, "VEC3", 4, &fan);
    let view = maker.json["accessors"][quantized]["bufferView"].clone();
    maker.json["bufferViews"][view.as_u64().unwrap() as usize]["byteStride"] = json!(8);
    maker.json["accessors"][quantized]["normalized"] = json!(true);
    let (at, to) = (maker.view(&[3]), maker.view(&[0, 0, 0, 0x40, 0, 0x40]));
    maker.json["accessors"][quantized]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": at, "componentType": U8 },
        "values": { "bufferView": to },
    });
    let fan = maker.mesh(&json!({ "attributes": { "POSITION": quantized }, "mode": 6 }));
    let translations = maker.floats("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
    maker.push(
        "nodes",
        json!({
            "mesh": fan,
            "name": "fans",
            "extensions": {
                "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translations } },
                "KHR_lights_punctual": { "light": 0 },
            },
            "camera": 0,
        }),
    )
}

/// An animation of all interpolations, also of the node.
fn add_animation(maker: &mut Maker, node: usize) {
    let times = maker.floats("SCALAR", &[0.5, 1.0, 2.5]);
    let turns = maker.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8, 0.6, 0.0, 0.0, -0.8]);
    let moves = maker.floats("VEC3", &[0.5; 27]);
    let weights = maker.floats("SCALAR", &[0.0, 1.0, -1.0]);
    maker.push(
        "animations",
        json!({
            "name": "all",
            "samplers": [
                { "input": times, "output": turns },
                { "input": times, "output": moves, "interpolation": "CUBICSPLINE" },
                { "input": times, "output": weights, "interpolation": "STEP" },
            ],
            "channels": [
                { "sampler": 0, "target": { "node": 1, "path": "rotation" } },
                { "sampler": 1, "target": { "node": node, "path": "translation" } },
                { "sampler": 2, "target": { "node": 0, "path": "weights" } },
            ],
        }),
    );
}
