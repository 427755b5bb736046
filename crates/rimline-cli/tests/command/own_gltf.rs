//! A small glTF of the tests' own: a tetrahedron that moves, a light, a texture.

use std::path::Path;

use super::run::write_file;

/// Names of things in the file.
pub(crate) struct Names<'a> {
    pub(crate) mesh: &'a str,
    pub(crate) animation: &'a str,
    pub(crate) light: &'a str,
    pub(crate) texture: &'a str,
    pub(crate) buffer: &'a str,
}

impl Default for Names<'_> {
    fn default() -> Self {
        Self { mesh: "body", animation: "move", light: "lamp", texture: "skin.png", buffer: "body.bin" }
    }
}

/// Bytes of its buffer: positions, faces, two key times, two translations.
pub(crate) fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    let floats = |bytes: &mut Vec<u8>, floats: &[f32]| bytes.extend(floats.iter().flat_map(|f| f.to_le_bytes()));
    floats(&mut bytes, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    bytes.extend([0_u16, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3].iter().flat_map(|i| i.to_le_bytes()));
    floats(&mut bytes, &[0.0, 1.0]);
    floats(&mut bytes, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    bytes
}

/// Its JSON text.
pub(crate) fn text(names: &Names<'_>) -> String {
    value(names).to_string()
}

/// Its JSON.
pub(crate) fn value(names: &Names<'_>) -> serde_json::Value {
    let view =
        |offset: usize, length: usize| serde_json::json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let accessor = |view: usize, component: u32, count: usize, kind: &str| {
        let (least, most) = match view {
            0 => (Some([0.0; 3].to_vec()), Some([1.0; 3].to_vec())),
            2 => (Some(vec![0.0]), Some(vec![1.0])),
            _ => (None, None),
        };
        serde_json::json!({ "bufferView": view, "componentType": component, "count": count, "type": kind,
            "min": least, "max": most })
    };
    let mut value = serde_json::json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "name": names.light }] } },
        "buffers": [{ "uri": names.buffer, "byteLength": buffer().len() }],
        "images": [{ "uri": names.texture }],
        "bufferViews": [view(0, 48), view(48, 24), view(72, 8), view(80, 24)],
        "accessors": [accessor(0, 5126, 4, "VEC3"), accessor(1, 5123, 12, "SCALAR"), accessor(2, 5126, 2, "SCALAR"),
            accessor(3, 5126, 2, "VEC3")],
        "meshes": [{ "name": names.mesh, "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "nodes": [{ "mesh": 0 },
            { "translation": [3, 4, 5], "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "scenes": [{ "nodes": [0, 1] }],
        "scene": 0,
        "animations": [{ "name": names.animation, "samplers": [{ "input": 2, "output": 3 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] }],
    });
    for accessor in value["accessors"].as_array_mut().into_iter().flatten() {
        if let Some(accessor) = accessor.as_object_mut() {
            accessor.retain(|_, value| !value.is_null());
        }
    }
    value
}

/// Writes `body.gltf`, its buffer and something that stands for its texture.
pub(crate) fn write(folder: &Path, names: &Names<'_>) -> Result<std::path::PathBuf, String> {
    let file = folder.join("body.gltf");
    let write = |file: &Path, bytes: &[u8]| write_file(file, bytes);
    write(&file, text(names).as_bytes())?;
    write(&folder.join(names.buffer), &buffer())?;
    write(&folder.join(names.texture), b"a texture")?;
    Ok(file)
}
