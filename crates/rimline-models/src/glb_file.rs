//! A glTF 2.0 binary in the making: its data, what describes the data, and the container around both.

use serde_json::{Value, json};

const WORDS: u32 = 5125;
const FLOATS: u32 = 5126;
const INDICES: u32 = 34963;
/// The target of views of vertex data.
pub const VERTICES: u32 = 34962;

/// The binary chunk and its views and accessors.
#[derive(Default)]
pub struct GlbFile {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl GlbFile {
    /// An accessor with a view of its own; `bytes` are a multiple of 4 long, so views stay aligned.
    pub fn accessor(&mut self, shape: &str, component: u32, bytes: &[u8], target: Option<u32>) -> usize {
        let components = match shape {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let width = if matches!(component, WORDS | FLOATS) { 4 } else { 1 };
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.accessors.push(json!({
            "bufferView": self.views.len(),
            "componentType": component,
            "count": bytes.len() / (components * width),
            "type": shape,
        }));
        self.views.push(view);
        self.bytes.extend_from_slice(bytes);
        self.accessors.len() - 1
    }

    /// Scalars, vectors or matrices, by their number of components.
    pub fn floats<const N: usize>(
        &mut self,
        elements: impl IntoIterator<Item = [f32; N]>,
        target: Option<u32>,
    ) -> usize {
        let bytes: Vec<u8> = elements.into_iter().flatten().flat_map(f32::to_le_bytes).collect();
        let shape = match N {
            1 => "SCALAR",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        self.accessor(shape, FLOATS, &bytes, target)
    }

    /// [`Self::floats`] with the bounds that positions and key times must have.
    pub fn bounded<const N: usize>(&mut self, elements: &[[f32; N]], target: Option<u32>) -> usize {
        let accessor = self.floats(elements.iter().copied(), target);
        let bounds = |pick: fn(f32, f32) -> f32, start| {
            let axis = |axis: usize| elements.iter().map(|element| element[axis]).fold(start, pick);
            (0..N).map(axis).collect::<Vec<f32>>()
        };
        self.accessors[accessor]["min"] = json!(bounds(f32::min, f32::INFINITY));
        self.accessors[accessor]["max"] = json!(bounds(f32::max, f32::NEG_INFINITY));
        accessor
    }

    /// The corners of triangles.
    pub fn indices(&mut self, faces: &[[u32; 3]]) -> usize {
        let bytes: Vec<u8> = faces.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor("SCALAR", WORDS, &bytes, Some(INDICES))
    }

    /// The whole file: `document` with what this knows filled in.
    pub fn finish(self, mut document: Value) -> Vec<u8> {
        document["asset"] = json!({ "version": "2.0", "generator": "rimline's examples" });
        document["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        document["bufferViews"] = json!(self.views);
        document["accessors"] = json!(self.accessors);
        container(document.to_string().into_bytes(), &self.bytes)
    }
}

/// A header, a JSON chunk padded with spaces, and a binary chunk.
fn container(mut json: Vec<u8>, binary: &[u8]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
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
    file.extend_from_slice(binary);
    file
}
