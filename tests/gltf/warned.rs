//! Faults that do not refuse a file: in parts that nothing shows, and slips that can be read in one way only.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError, GltfWarning, LoadOptions};
use rimline::mesh::Weld;
use serde_json::json;

use crate::maker::{Maker, U8, U16, everything};
use crate::refuse::primitive;
use crate::refuse_square::set_indices;
use crate::shape::same;
use crate::warned_rows::{Row, SLIPS, UNUSED, scenes};
use crate::{Outcome, check, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        test("warned::control", || same(&Maker::square().load()?.warnings().len(), &0, "warnings of a good file")),
        test("warned::everything_is_known", || same(&everything().load()?.warnings().len(), &0, "warnings")),
        test("warned::zero_padding", zero_padding),
        test("warned::a_buffer_that_only_an_animation_needs", missing_buffer),
        test("warned::a_light_is_refused_once_it_is_asked_for", damaged_light),
        test("warned::the_largest_index_may_be_a_vertex", largest_index),
        test("warned::strips_and_fans_restart", restarts),
        test("warned::a_shared_child_stays_with_the_scene", shared_child),
        test("warned::cameras_are_not_read", cameras),
        test("warned::harmless_extensions", harmless),
        test("warned::needed_parts_are_refused", needed),
        test("warned::many_faults_keep_to_the_limit", many),
    ];
    for (kind, rows) in [("unused", UNUSED), ("slips", SLIPS)] {
        let trial = |&(name, spoil, says, faces): &Row| {
            test(format!("warned::{kind}::{name}"), move || warned(spoil, says, faces))
        };
        tests.extend(rows.iter().map(trial));
    }
    tests
}

fn warned(spoil: fn(&mut Maker), says: &[&str], faces: usize) -> Outcome {
    let mut maker = Maker::square();
    spoil(&mut maker);
    let asset = maker.load()?;
    check::asset(&asset, 0, false)?;
    // Points have a warning of their own.
    let told = asset.warnings().iter().filter(|warning| !matches!(warning, GltfWarning::Skipped(_)));
    let warnings: Vec<String> = told.map(ToString::to_string).collect();
    ensure(warnings.len() == 1, || format!("{} warnings: {warnings:?}", warnings.len()))?;
    let missing: Vec<_> = says.iter().filter(|part| !warnings[0].contains(**part)).collect();
    ensure(missing.is_empty(), || format!("{warnings:?} does not say {missing:?}"))?;
    same(&asset.model().placed_geometries().map(|g| g.faces().len()).sum(), &faces, "faces that are shown")
}

fn zero_padding() -> Outcome {
    let maker = Maker::square();
    for file in [maker.glb(), maker.gltf()] {
        let is_glb = file.starts_with(b"glTF");
        let spoilt = if is_glb {
            let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|byte| file[at + byte]));
            let end = 20 + word(12) as usize;
            let json = [&file[20..end], &[0; 8]].concat();
            crate::maker::glb(&json, &file[end + 8..])
        } else {
            [&file[..], &[0; 3]].concat()
        };
        let asset = Asset::from_slice(&spoilt, None, Weld::Keep)?;
        let bytes = if is_glb { 8 } else { 3 };
        same(&asset.warnings().to_vec(), &vec![GltfWarning::Padding { bytes }], "warnings")?;
        same(asset.model(), maker.load()?.model(), "model")?;
    }
    let error = Asset::from_slice(b"{}\0\0x", None, Weld::Keep).err().map(|error| error.to_string());
    ensure(error.is_some_and(|error| error.contains("JSON")), || "text after zeros".to_owned())
}

fn missing_buffer() -> Outcome {
    let mut maker = Maker::square();
    let bytes = maker.bytes.len();
    maker.json["buffers"] = json!([{ "byteLength": bytes }, { "byteLength": 8, "uri": "motion.bin" }]);
    let view = maker.push("bufferViews", json!({ "buffer": 1, "byteLength": 8 }));
    let times =
        maker.push("accessors", json!({ "bufferView": view, "componentType": 5126, "type": "SCALAR", "count": 2 }));
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
    let sampler = json!({ "input": times, "output": 0 });
    maker.push("animations", json!({ "samplers": [sampler], "channels": [channel] }));
    let folder = tempfile::tempdir()?;
    let asset = Asset::from_slice(&maker.glb(), Some(folder.path()), Weld::Keep)?;
    asset.pose(None, 0.0)?;
    // The buffer and the animation are at the same fault, which is said once.
    same(&asset.warnings().len(), &1, "warnings")?;
    match asset.pose(Some(0), 0.0) {
        Err(GltfError::DamagedAnimation { source, .. }) if matches!(*source, GltfError::Read { .. }) => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

fn damaged_light() -> Outcome {
    let mut maker = Maker::square();
    maker.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "area", "name": "panel" }, { "type": "point" }] } });
    for light in [0, 1] {
        let extensions = json!({ "KHR_lights_punctual": { "light": light } });
        maker.push("nodes", json!({ "name": "n", "extensions": extensions }));
    }
    let asset = maker.load()?;
    same(&asset.warnings().len(), &1, "warnings")?;
    same(&asset.light_names(), &vec![Some("panel"), Some("n")], "names")?;
    let each = asset.each_light(None, 0.0)?;
    ensure(matches!(each[..], [Err(GltfError::DamagedLight { node: 1, .. }), Ok(_)]), || format!("{each:?}"))?;
    let all = asset.lights(None, 0.0);
    ensure(matches!(all, Err(GltfError::DamagedLight { node: 1, .. })), || format!("{all:?}"))
}

/// 65,536 vertices of 2-byte indices, and 256 of 1-byte indices.
fn largest_index() -> Outcome {
    for (component, largest) in [(U8, 255_u32), (U16, 65_535)] {
        let mut maker = Maker::square();
        let line: Vec<f32> = (0..=largest).flat_map(|x| [x as f32, (x % 2) as f32, 0.0]).collect();
        let line = maker.floats("VEC3", &line);
        primitive(&mut maker)["attributes"]["POSITION"] = json!(line);
        set_indices(&mut maker, component, &[0, 1, largest, largest, 1, 2]);
        let asset = maker.load()?;
        same(&asset.model().geometries()[0].faces().to_vec(), &vec![[0, 1, largest], [largest, 1, 2]], "faces")?;
        let expected =
            GltfWarning::PrimitiveRestart { mesh: 0, primitive: 0, position: 2, index: largest, is_vertex: true };
        same(&asset.warnings().to_vec(), &vec![expected], "warnings")?;
    }
    Ok(())
}

fn restarts() -> Outcome {
    let indices = [0, 1, 2, 3, 255, 3, 2, 1, 255, 255, 0, 1];
    for (mode, expected) in [
        (5, vec![[0, 1, 2], [1, 3, 2], [3, 2, 1]]),
        (6, vec![[1, 2, 0], [2, 3, 0], [2, 1, 3]]),
        (4, vec![[0, 1, 2], [3, 2, 1]]),
    ] {
        let mut maker = Maker::square();
        set_indices(&mut maker, U8, &indices);
        primitive(&mut maker)["mode"] = json!(mode);
        let asset = maker.load()?;
        same(&asset.model().geometries()[0].faces().to_vec(), &expected, "faces")?;
        ensure(!asset.warnings().is_empty(), || "no warning".to_owned())?;
    }
    Ok(())
}

/// Scene 1 holds node 2, which shares a child with node 1.
fn shared_child() -> Outcome {
    for (scene, at, parent) in [(0, [5.0, 0.0, 0.0], 1), (1, [0.0, 7.0, 0.0], 2)] {
        let mut maker = Maker::square();
        maker.push("nodes", json!({ "children": [0], "translation": [5, 0, 0] }));
        maker.push("nodes", json!({ "children": [0], "translation": [0, 7, 0] }));
        scenes(&mut maker, json!([{ "nodes": [1] }, { "nodes": [2] }]));
        maker.json["scene"] = json!(scene);
        let asset = maker.load()?;
        let pose = asset.pose(None, 0.0)?;
        same(&pose.instances().len(), &1, "instances")?;
        check::close(&check::map(&pose.instances()[0].palette()[0], [0.0; 3]), &at, 0.0, "the child's place")?;
        let expected = GltfWarning::SharedChild { node: 0, parent, other: 3 - parent };
        same(&asset.warnings().to_vec(), &vec![expected], "warnings")?;
    }
    Ok(())
}

fn cameras() -> Outcome {
    let mut maker = Maker::square();
    maker.json["cameras"] = json!([{ "type": "fisheye" }, 5]);
    maker.json["nodes"][0]["camera"] = json!(77);
    same(&maker.load()?.warnings().len(), &0, "warnings")
}

fn harmless() -> Outcome {
    let mut maker = Maker::square();
    maker.json["extensionsUsed"] =
        json!(["KHR_materials_unlit", "EXT_texture_webp", "KHR_node_visibility", "CESIUM_RTC"]);
    same(&maker.load()?.warnings().len(), &0, "warnings")?;
    maker.json["extensionsUsed"] = json!(["KHR_materials_unlit", "ACME_b", "ACME_a"]);
    let names = |warning: &GltfWarning| match warning {
        GltfWarning::Extension { name } => name.clone(),
        other => other.to_string(),
    };
    let found: Vec<String> = maker.load()?.warnings().iter().map(names).collect();
    same(&found, &vec!["ACME_b".to_owned(), "ACME_a".to_owned()], "warnings")
}

/// The same faults as of unused parts, where the scene needs the part.
fn needed() -> Outcome {
    for (list, part, says) in [
        ("skins", json!({ "joints": [7] }), "skins[0].joints[0] is 7"),
        ("skins", json!(3), "skins[0]"),
        ("meshes", json!({ "primitives": 1 }), "meshes[0].primitives"),
        ("nodes", json!({ "mesh": 9 }), "nodes[0].mesh is 9"),
        ("accessors", json!({ "componentType": 5130, "count": 4, "type": "VEC3" }), "accessors[0].componentType"),
        ("bufferViews", json!({ "buffer": 9, "byteLength": 1 }), "bufferViews[0].buffer is 9"),
        ("buffers", json!({ "uri": "none.bin" }), "buffers[0].byteLength is missing"),
        ("scenes", json!({ "nodes": [9] }), "scenes[0].nodes[0] is 9"),
    ] {
        let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
        scenes(&mut maker, json!([{ "nodes": [0, 1, 2] }]));
        maker.load()?;
        if list == "buffers" {
            maker.json["buffers"] = json!([{}]);
        }
        maker.json[list][0] = part;
        let text = maker.json.to_string();
        let loaded =
            if list == "buffers" { Asset::from_slice(text.as_bytes(), None, Weld::Keep) } else { maker.load() };
        let message = loaded.err().map(|error| error.to_string()).unwrap_or_default();
        ensure(message.contains(says), || format!("{list}: {message:?} does not say {says:?}"))?;
    }
    // A joint may be where the scene is not, and then its place is needed, too.
    let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    scenes(&mut maker, json!([{ "nodes": [0] }]));
    maker.json["nodes"][1]["matrix"] = json!([1]);
    let message = maker.load().err().map(|error| error.to_string()).unwrap_or_default();
    ensure(message.contains("nodes[1].matrix"), || message.clone())
}

/// A small file of very many faults takes no more memory than it may.
fn many() -> Outcome {
    let mut maker = Maker::square();
    maker.json["animations"] = json!(vec![5; 200_000]);
    let options = LoadOptions { memory_limit: 64 << 20, ..Weld::Keep.into() };
    match Asset::from_slice(&maker.glb(), None, options) {
        Err(GltfError::TooLarge { what, .. }) => ensure(what.contains("warnings"), || what.clone()),
        other => Err(format!("{:?}", other.map(|asset| asset.warnings().len())).into()),
    }
}
