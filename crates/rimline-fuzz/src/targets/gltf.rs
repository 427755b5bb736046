//! glTF from memory: loading, posing and meshing.

use rimline::gltf::{Asset, LoadOptions};
use rimline::mesh::Weld;
use rimline_models::maker::{Maker, everything};
use rimline_testkit::random::Random;
use serde_json::{Value, json};

use rimline_testkit::mutate;

/// A file may take this much memory; a worker's address space is much larger.
const MEMORY_LIMIT: u64 = 256 << 20;

pub(crate) struct Seeds(Vec<(Value, Vec<u8>)>);

impl Seeds {
    pub(crate) fn new() -> Self {
        let makers = [
            everything(),
            everything(),
            Maker::square(),
            Maker::skinned([0, 1, 0, 1], [0.25; 4]),
            animated(),
            instanced(),
            sparse(),
            strip(),
            hidden(),
        ];
        Self(makers.into_iter().map(|maker| mutate::split_gltf(&maker.glb())).collect())
    }

    pub(crate) fn case(&self, random: &mut Random) -> Vec<u8> {
        let (mut json, mut binary) = self.0[random.below(self.0.len())].clone();
        for _ in 0..=random.below(3) {
            match random.below(8) {
                0..=3 => mutate::value(&mut json, random),
                4 => {
                    // A part of another file.
                    let (other, _) = &self.0[random.below(self.0.len())];
                    let keys: Vec<_> = other.as_object().into_iter().flat_map(|map| map.keys()).collect();
                    let key = keys[random.below(keys.len())];
                    if json.is_object() {
                        json[key] = other[key].clone();
                    }
                }
                5 => {}
                _ => mutate::bytes(&mut binary, random),
            }
        }
        let is_glb = random.below(6) != 0;
        mutate::gltf(&json, &binary, is_glb, random)
    }
}

fn animated() -> Maker {
    let mut maker = Maker::square();
    let times = maker.floats("SCALAR", &[0.0, 0.5, 2.0]);
    let translations = maker.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 3.0, 0.0]);
    let turns = maker.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5]);
    let sampler = |output: usize, kind: &str| json!({ "input": times, "output": output, "interpolation": kind });
    let channel = |sampler: u32, path: &str| json!({ "sampler": sampler, "target": { "node": 0, "path": path } });
    let animation = json!({
        "samplers": [sampler(translations, "LINEAR"), sampler(turns, "STEP")],
        "channels": [channel(0, "translation"), channel(1, "rotation"), channel(0, "scale")],
    });
    maker.push("animations", animation);
    maker
}

fn instanced() -> Maker {
    let mut maker = Maker::square();
    let translations = maker.floats("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    maker.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translations } } });
    maker.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    maker
}

fn sparse() -> Maker {
    let mut maker = Maker::square();
    maker.sparse(0, &[1, 2], &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    maker
}

fn strip() -> Maker {
    let mut maker = Maker::new();
    let positions = maker.zeros(6);
    for mode in [4, 5, 6] {
        maker.mesh(&json!({ "attributes": { "POSITION": positions }, "mode": mode }));
        let mesh = maker.json["meshes"].as_array().map_or(0, Vec::len) - 1;
        maker.push("nodes", json!({ "mesh": mesh, "scale": [1, -1, 1] }));
    }
    maker
}

/// Hidden and shared nodes, and two animations.
fn hidden() -> Maker {
    let mut maker = animated();
    maker.json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": { "visible": true } });
    maker.push("nodes", json!({ "children": [0], "extensions": { "KHR_node_visibility": { "visible": false } } }));
    maker.push("nodes", json!({ "children": [0], "rotation": [0, 0, 0, 0] }));
    maker.json["scenes"] = json!([{ "nodes": [2] }, { "nodes": [1] }]);
    let again = maker.json["animations"][0].clone();
    maker.push("animations", again);
    maker
}

pub(crate) fn run(bytes: &[u8]) -> Result<bool, String> {
    let weld = [Weld::Data, Weld::Position, Weld::Keep][bytes.len() % 3];
    let options = LoadOptions { memory_limit: MEMORY_LIMIT, ..weld.into() };
    let asset = match Asset::from_slice(bytes, None, options) {
        Ok(asset) => asset,
        Err(error) if error.to_string().len() > 2000 => return Err(format!("a long message: {error}")),
        Err(_) => return Ok(false),
    };
    if let Some(warning) = asset.warnings().iter().map(ToString::to_string).find(|warning| warning.len() > 2000) {
        return Err(format!("a long warning: {warning}"));
    }
    let animations = asset.animations().len().min(2);
    // None, each alone, and all together.
    for playing in
        std::iter::once(0..0).chain((0..animations).map(|one| one..one + 1)).chain(std::iter::once(0..animations))
    {
        for time in [0.0, 0.3, 1e30, -1.0] {
            // Lights and poses may be refused; what is made must be sound.
            match asset.each_light(playing.clone(), time) {
                Ok(lights) if lights.len() != asset.light_names().len() => {
                    return Err("lights without names".to_owned());
                }
                _ => {}
            }
            let Ok(pose) = asset.pose(playing.clone(), time) else { continue };
            let Ok(mesh) = asset.model().mesh(&pose) else { continue };
            let vertices = asset.model().vertex_count();
            if mesh.faces().iter().flatten().any(|&vertex| vertex as usize >= vertices) {
                return Err("a face names a vertex that is not there".to_owned());
            }
        }
    }
    Ok(true)
}
