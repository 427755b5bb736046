//! Hand-made bad files: each is refused, with its place.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError, GltfWarning, LoadOptions};
use rimline::mesh::Weld;
use rimline_testkit::refusals::{self, refusal};
use serde_json::{Value, json};

use crate::maker::{F32, Maker, U8, everything};
use crate::refuse_moving::{ANIMATED, SKINNED};
use crate::refuse_square::SQUARE;
use crate::{Outcome, ensure, test};

/// Name, what spoils a square (or a skinned one), and what the error must say.
pub(crate) type Row = (&'static str, fn(&mut Maker), &'static [&'static str]);

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        test("refuse::control", control),
        test("refuse::devices_and_folders", devices),
        test("refuse::zero_accessors_in_many_places", amplified),
        test("refuse::more_vertices_than_indices", too_many_vertices),
        test("refuse::deep_json", deep),
        test("refuse::not_gltf", not_gltf),
        test("refuse::every_truncation", truncations),
    ];
    for &(name, spoil, says) in ANIMATED {
        tests.push(test(format!("refuse::animated::{name}"), move || not_played(spoil, says)));
    }
    let bases: [(_, _, fn() -> Maker); 2] = [
        ("square", SQUARE, Maker::square),
        ("skinned", SKINNED, || Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0])),
    ];
    for (base, rows, make) in bases {
        for &(name, spoil, says) in rows {
            tests.push(test(format!("refuse::{base}::{name}"), move || refused(make, spoil, says)));
        }
    }
    tests
}

fn refused(make: fn() -> Maker, spoil: fn(&mut Maker), says: &[&str]) -> Outcome {
    let mut maker = make();
    maker.load()?;
    spoil(&mut maker);
    Ok(refusals::refused([refusal("the spoilt file", maker.load(), refusals::says(says))])?)
}

/// The file loads with a warning and has its pose at rest. The animation is refused once it is asked for.
fn not_played(spoil: fn(&mut Maker), says: &[&str]) -> Outcome {
    let mut maker = everything();
    let rest = maker.load()?.pose(None, 0.0)?;
    spoil(&mut maker);
    let asset = maker.load()?;
    // A row may spoil a node, too.
    let at_rest = asset.pose(None, 0.0)?;
    ensure(at_rest.instances().len() == rest.instances().len(), || "instances".to_owned())?;
    let error = asset.pose(Some(0), 0.0);
    let Err(GltfError::DamagedAnimation { index: 0, source }) = error else {
        return Err(format!("asked for: {error:?}").into());
    };
    refusals::refused([refusal("asked for", Err::<(), _>(GltfError::clone(&source)), refusals::says(says))])?;
    let info = &asset.animations()[0];
    ensure(info.fault.as_ref() == Some(&*source) && info.channels == 0, || format!("{info:?}"))?;
    ensure(asset.lights(Some(0), 0.0).is_err(), || "lights of a damaged animation".to_owned())?;
    let warning = GltfWarning::Damaged { fault: source };
    ensure(asset.warnings().contains(&warning), || format!("{:?}", asset.warnings()))
}

fn control() -> Outcome {
    ensure(refused(Maker::square, |_| {}, &[]).is_err(), || "a good file passed as bad".to_owned())?;
    let (_, spoil, _) = SQUARE[0];
    ensure(refused(Maker::square, spoil, &["nodes[3]"]).is_err(), || "a wrong place passed".to_owned())
}

/// 66,000 instances of 66,000 vertices are more than `u32` indices can name, however small the file.
/// More than indices can name, where memory is no limit.
fn too_many_vertices() -> Outcome {
    let mut maker = Maker::square();
    let count = 66_000;
    let line: Vec<f32> = (0..count).flat_map(|x| [x as f32, 0.0, 0.0]).collect();
    let line = maker.floats("VEC3", &line);
    primitive(&mut maker)["attributes"]["POSITION"] = json!(line);
    let instancing = json!({ "attributes": { "TRANSLATION": line } });
    maker.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": instancing });
    let options = LoadOptions { memory_limit: u64::MAX, ..Weld::Keep.into() };
    let says = refusals::says(&["nodes", "4356000000 vertices", "split"]);
    Ok(refusals::refused([refusal("the line", Asset::from_slice(&maker.glb(), None, options), says)])?)
}

pub(crate) fn primitive(maker: &mut Maker) -> &mut Value {
    &mut maker.json["meshes"][0]["primitives"][0]
}

pub(crate) fn bare(maker: &mut Maker, count: u64) -> usize {
    maker.push("accessors", json!({ "componentType": F32, "type": "VEC3", "count": count }))
}

pub(crate) fn uri(maker: &mut Maker, uri: &str) {
    let bytes = maker.bytes.len();
    maker.json["buffers"] = json!([{ "byteLength": bytes, "uri": uri }]);
}

pub(crate) fn instanced(maker: &mut Maker, scales: &[f32]) {
    let (places, scales) = (maker.floats("VEC3", &[0.0; 6]), maker.floats("VEC3", scales));
    maker.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places, "SCALE": scales } } });
}

/// A name that leads to something without an end, or to no file at all.
fn devices() -> Outcome {
    let folder = tempfile::tempdir()?;
    std::fs::create_dir(folder.path().join("folder"))?;
    for path in [folder.path().join("folder"), folder.path().join("none"), "/dev/zero".into()] {
        let result = Asset::open(&path, Weld::Keep);
        ensure(matches!(result, Err(GltfError::Read { .. })), || format!("{}: {result:?}", path.display()))?;
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/dev/zero", folder.path().join("endless"))?;
        let mut maker = Maker::square();
        uri(&mut maker, "endless");
        let load = |allow_outside| {
            let options = LoadOptions { allow_outside, ..Weld::Keep.into() };
            Asset::from_slice(&maker.glb(), Some(folder.path()), options)
        };
        let (result, allowed) = (load(false), load(true));
        ensure(matches!(result, Err(GltfError::Outside { .. })), || format!("{result:?}"))?;
        ensure(matches!(allowed, Err(GltfError::Read { .. })), || format!("allowed: {allowed:?}"))?;
    }
    Ok(())
}

/// Each accessor is small, all together are not.
fn amplified() -> Outcome {
    let mut maker = Maker::square();
    let zeros = bare(&mut maker, 60_000);
    let mesh = json!({ "primitives": [{ "attributes": { "POSITION": zeros } }] });
    maker.json["meshes"] = json!(vec![mesh; 5000]);
    let many = maker.load().map(|_| ());
    ensure(matches!(many, Err(GltfError::TooLarge { .. })), || format!("meshes: {many:?}"))?;
    let mut maker = Maker::square();
    let indices = maker.indices(U8, &vec![0; 30_000]);
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": indices });
    maker.json["meshes"][0]["primitives"] = json!(vec![primitive; 5000]);
    let many = maker.load().map(|_| ());
    ensure(matches!(many, Err(GltfError::TooLarge { .. })), || format!("primitives: {many:?}"))?;
    let mut maker = Maker::skinned([0; 4], [1.0; 4]);
    maker.json["skins"][0]["joints"] = json!(vec![1; 20_000]);
    maker.json["nodes"].as_array_mut().expect("a list").extend(vec![json!({ "mesh": 0, "skin": 0 }); 2000]);
    let many = maker.load().map(|_| ());
    ensure(matches!(many, Err(GltfError::TooLarge { .. })), || format!("palettes: {many:?}"))
}

fn deep() -> Outcome {
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let text = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        let result = Asset::from_slice(text.as_bytes(), None, Weld::Keep);
        ensure(matches!(result, Err(GltfError::Json(_))), || "deep JSON".to_owned())?;
    }
    // A chain of nodes may be as deep as it likes.
    let mut maker = Maker::square();
    let chain: Vec<Value> = (1..50_000).map(|child| json!({ "children": [child] })).collect();
    maker.json["nodes"] = json!(chain);
    maker.push("nodes", json!({ "mesh": 0, "translation": [1, 0, 0] }));
    let asset = maker.load()?;
    ensure(asset.pose(None, 0.0)?.instances().len() == 1, || "instances".to_owned())
}

fn not_gltf() -> Outcome {
    for bytes in [&b""[..], b"glT", b"glTF", b"glTF\x02\0\0\0\0\0\0\0", b"{}", b"[]", b"\xff\xfe", b"ply\n", b"null"] {
        let result = Asset::from_slice(bytes, None, Weld::Keep);
        ensure(result.is_err(), || format!("{bytes:?} was accepted"))?;
    }
    Ok(())
}

fn truncations() -> Outcome {
    for file in [everything().glb(), everything().gltf()] {
        for length in 0..file.len() {
            let result = Asset::from_slice(&file[..length], None, Weld::Keep);
            ensure(result.is_err(), || format!("the first {length} bytes were accepted"))?;
        }
    }
    Ok(())
}
