//! Faults that do not refuse a file: in parts that nothing shows, and slips that can be read in one way only.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError, GltfWarning, LoadOptions};
use rimline::mesh::Weld;
use serde_json::json;

use crate::check::{close, moved, said, warned_once};
use crate::maker::{Maker, U8, U16, everything, glb};
use crate::rows::{FEWER, Row, UNUSED, primitive, says, set_indices};
use crate::{Outcome, check, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        test("warned::good_files", good),
        test("warned::zero_padding", zero_padding),
        test("warned::a_buffer_that_only_an_animation_needs", missing_buffer),
        test("warned::the_largest_index_may_be_a_vertex", largest_index),
        test("warned::strips_and_fans_restart", restarts),
        test("warned::a_shared_child_stays_with_the_scene", shared_child),
        test("warned::extensions", extensions),
        test("warned::many_faults_keep_to_the_limit", many),
    ];
    let rows = UNUSED.iter().map(|row| (row, 2)).chain(FEWER.iter().map(|(row, faces)| (row, *faces)));
    tests.extend(rows.map(|(row, faces)| test(format!("warned::{}", row.0), move || warned(row, faces))));
    tests
}

fn warned(&(_, change, parts): &Row, faces: usize) -> Outcome {
    let mut maker = Maker::square();
    change.apply(&mut maker);
    let asset = maker.load()?;
    check::asset(&asset, 0, false)?;
    // Points have a warning of their own.
    let others = asset.warnings().iter().filter(|warning| !matches!(warning, GltfWarning::Skipped(_)));
    let warnings: Vec<String> = others.map(ToString::to_string).collect();
    ensure(warnings.len() == 1 && says(&warnings[0], parts), || format!("{warnings:?}, expected one with {parts:?}"))?;
    same(&asset.model().placed_geometries().map(|g| g.faces().len()).sum(), &faces, "faces that are shown")
}

/// No warnings, nor of cameras that nobody asks for.
fn good() -> Outcome {
    let mut cameras = Maker::square();
    cameras.json["cameras"] = json!([{ "type": "fisheye" }, 5]);
    cameras.json["nodes"][0]["camera"] = json!(77);
    for maker in [Maker::square(), everything(), cameras] {
        same(&said(&maker.load()?), &vec![], "warnings")?;
    }
    Ok(())
}

fn zero_padding() -> Outcome {
    let mut maker = Maker::square();
    let text = [&maker.gltf()[..], &[0; 3]].concat();
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len() }]);
    let binary = glb(&[maker.json.to_string().as_bytes(), &[0; 8]].concat(), &maker.bytes);
    for (file, zeros) in [(text, "3 zero bytes"), (binary, "8 zero bytes")] {
        let asset = Asset::from_slice(&file, None, Weld::Keep)?;
        warned_once(&asset, &[zeros])?;
        same(asset.model(), maker.load()?.model(), "model")?;
    }
    let error = Asset::from_slice(b"{}\0\0x", None, Weld::Keep).err().map(|error| error.to_string());
    ensure(error.is_some_and(|error| error.contains("JSON")), || "text after zeros".to_owned())
}

fn missing_buffer() -> Outcome {
    let mut maker = Maker::square();
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len() }, { "byteLength": 8, "uri": "motion.bin" }]);
    let view = maker.push("bufferViews", json!({ "buffer": 1, "byteLength": 8 }));
    let times =
        maker.push("accessors", json!({ "bufferView": view, "componentType": 5126, "type": "SCALAR", "count": 2 }));
    maker.animate(0, "translation", &json!({ "input": times, "output": 0 }));
    let folder = tempfile::tempdir()?;
    let asset = Asset::from_slice(&maker.glb(), Some(folder.path()), Weld::Keep)?;
    asset.pose(None, 0.0)?;
    // The buffer and the animation are at the same fault, which is said once.
    same(&asset.warnings().len(), &1, "warnings")?;
    let asked = asset.pose(Some(0), 0.0);
    let is_read = |source: &GltfError| matches!(source, GltfError::Read { .. });
    let is_right = matches!(&asked, Err(GltfError::DamagedAnimation { source, .. }) if is_read(source));
    ensure(is_right, || format!("{asked:?}"))
}

/// 65,536 vertices of 2-byte indices, and 256 of 1-byte indices.
fn largest_index() -> Outcome {
    for (component, largest) in [(U8, 255_u32), (U16, 65_535)] {
        let mut maker = Maker::square();
        let line: Vec<f32> = (0..=largest).flat_map(|x| [x as f32, (x % 2) as f32, 0.0]).collect();
        let line = maker.floats("VEC3", &line);
        primitive(&mut maker)["attributes"]["POSITION"] = json!(line);
        set_indices(&mut maker, component, &[0, 1, largest, largest, 1, 2], 4);
        let asset = maker.load()?;
        same(&asset.model().geometries()[0].faces().to_vec(), &vec![[0, 1, largest], [largest, 1, 2]], "faces")?;
        let value = format!("index 2 is the primitive restart value {largest}, which glTF forbids");
        warned_once(&asset, &[&value, "; it is read as a vertex"])?;
    }
    Ok(())
}

fn restarts() -> Outcome {
    for (mode, expected) in [
        (5, vec![[0, 1, 2], [1, 3, 2], [3, 2, 1]]),
        (6, vec![[1, 2, 0], [2, 3, 0], [2, 1, 3]]),
        (4, vec![[0, 1, 2], [3, 2, 1]]),
    ] {
        let mut maker = Maker::square();
        set_indices(&mut maker, U8, &[0, 1, 2, 3, 255, 3, 2, 1, 255, 255, 0, 1], mode);
        let asset = maker.load()?;
        same(&asset.model().geometries()[0].faces().to_vec(), &expected, "faces")?;
        ensure(!asset.warnings().is_empty(), || "no warning".to_owned())?;
    }
    Ok(())
}

/// Scene 1 holds node 2, which shares a child with node 1.
fn shared_child() -> Outcome {
    for (scene, at, [parent, other]) in [(0, [5.0, 0.0, 0.0], [1, 2]), (1, [0.0, 7.0, 0.0], [2, 1])] {
        let mut maker = Maker::square();
        maker.push("nodes", json!({ "children": [0], "translation": [5, 0, 0] }));
        maker.push("nodes", json!({ "children": [0], "translation": [0, 7, 0] }));
        maker.json["scenes"] = json!([{ "nodes": [1] }, { "nodes": [2] }]);
        maker.json["scene"] = json!(scene);
        let asset = maker.load()?;
        same(&asset.model().instances().len(), &1, "instances")?;
        close(&moved(&asset, 0, [0.0; 3])?, &at, 0.0, "the child's position")?;
        warned_once(&asset, &[&format!("nodes[0] is a child of nodes[{parent}] and again of nodes[{other}];")])?;
    }
    Ok(())
}

/// Extensions that change no shape are known, and others are named.
fn extensions() -> Outcome {
    let mut maker = Maker::square();
    maker.json["extensionsUsed"] =
        json!(["KHR_materials_unlit", "EXT_texture_webp", "ACME_b", "KHR_node_visibility", "CESIUM_RTC", "ACME_a"]);
    maker.json["extensionsRequired"] = json!(["KHR_materials_unlit", "KHR_texture_transform", "KHR_xmp_json_ld"]);
    let expected = ["ACME_b", "ACME_a"].map(|name| GltfWarning::Extension { name: name.to_owned() });
    same(&maker.load()?.warnings().to_vec(), &expected.to_vec(), "warnings")
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
