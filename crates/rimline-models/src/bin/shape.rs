//! Writes one of the generated shapes as a glTF binary, to try the command on.
//!
//! `cargo run --release --package rimline-models --bin shape -- blob OUT.glb`

use std::process::ExitCode;

use rimline_bench::shapes::{self, Shape};
use rimline_models::maker::{INDICES, Maker, U32, VERTICES};
use serde_json::json;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, out] = arguments.as_slice() else {
        eprintln!("usage: shape blob|cube|fan|grid|moebius|sheets|sphere|torus OUT.glb");
        return ExitCode::from(2);
    };
    let Some(shape) = by_name(name) else {
        eprintln!("there is no shape `{name}`");
        return ExitCode::from(2);
    };
    if let Err(error) = std::fs::write(out, encode(name, &shape)) {
        eprintln!("cannot write {out}: {error}");
        return ExitCode::FAILURE;
    }
    println!("{out}: {} faces, {} vertices", shape.faces.len(), shape.positions.len());
    ExitCode::SUCCESS
}

fn by_name(name: &str) -> Option<Shape> {
    Some(match name {
        "blob" => shapes::blob(96, 0.75, 11),
        "cube" => shapes::cube(),
        "fan" => shapes::fan(64),
        "grid" => shapes::plane_grid(32, 32),
        "moebius" => shapes::moebius(128, 12),
        "sheets" => shapes::three_sheets(16),
        "sphere" => shapes::sphere(48),
        "torus" => shapes::torus(192, 96, 1.0, 0.4),
        _ => return None,
    })
}

fn encode(name: &str, shape: &Shape) -> Vec<u8> {
    let mut file = Maker::new();
    file.json["asset"]["generator"] = json!("rimline's examples");
    let positions = json!(file.bounded("VEC3", shape.positions.as_flattened()));
    let indices = json!(file.indices(U32, shape.faces.as_flattened()));
    file.bind(&positions, VERTICES);
    file.bind(&indices, INDICES);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    let mesh = file.push("meshes", json!({ "name": name, "primitives": [primitive] }));
    let node = file.push("nodes", json!({ "name": name, "mesh": mesh }));
    file.scene(&[node]);
    file.glb()
}
