//! A small glTF of the tests' own: a tetrahedron that moves, a light, a texture.

use serde_json::{Value, json};

use super::Outcome;
use super::run::Folder;

/// The tetrahedron's corners and faces.
pub(crate) const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
pub(crate) const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

/// Bytes of its buffer: positions, faces, two key times, two translations.
pub(crate) fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    let floats = |bytes: &mut Vec<u8>, floats: &[f32]| bytes.extend(floats.iter().flat_map(|f| f.to_le_bytes()));
    floats(&mut bytes, CORNERS.as_flattened());
    bytes.extend(FACES.as_flattened().iter().flat_map(|&i| (i as u16).to_le_bytes()));
    floats(&mut bytes, &[0.0, 1.0]);
    floats(&mut bytes, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    bytes
}

/// Its JSON.
pub(crate) fn value() -> Value {
    let view = |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "name": "lamp" }] } },
        "buffers": [{ "uri": "body.bin", "byteLength": buffer().len() }],
        "images": [{ "uri": "skin.png" }],
        "bufferViews": [view(0, 48), view(48, 24), view(72, 8), view(80, 24)],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] },
            { "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" },
            { "bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] },
            { "bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3" },
        ],
        "meshes": [{ "name": "body", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "nodes": [{ "mesh": 0 },
            { "translation": [3, 4, 5], "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "scenes": [{ "nodes": [0, 1] }],
        "scene": 0,
        "animations": [{ "name": "move", "samplers": [{ "input": 2, "output": 3 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] }],
    })
}

/// The same with its buffer in its text.
pub(crate) fn inline() -> Value {
    let mut value = value();
    let data: Vec<String> = buffer().iter().map(|byte| format!("%{byte:02x}")).collect();
    value["buffers"][0]["uri"] = format!("data:application/octet-stream,{}", data.concat()).into();
    value
}

/// Writes a glTF, and something for each file that it names.
pub(crate) fn write(folder: &Folder, file: &str, value: &Value) -> Outcome {
    folder.write(file, value.to_string())?;
    for (list, bytes) in [("buffers", buffer()), ("images", b"a texture".to_vec())] {
        let uri = value[list][0]["uri"].as_str().filter(|uri| !uri.starts_with("data:"));
        uri.map_or(Ok(()), |uri| folder.write(uri, bytes))?;
    }
    Ok(())
}
