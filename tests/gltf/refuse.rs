//! Hand-made bad files: each is refused, with its JSON path.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError, GltfWarning, LoadOptions};
use rimline::mesh::Weld;
use serde_json::json;

use crate::maker::{Maker, everything};
use crate::rows::{ANIMATED, Change, LIGHTS, Row, SKINNED, SQUARE, primitive, says, set, uri};
use crate::{Outcome, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        test("refuse::control", control),
        test("refuse::devices_and_folders", devices),
        test("refuse::more_vertices_than_indices", too_many_vertices),
        test("refuse::more_bytes_than_numbers", too_many_bytes),
        test("refuse::deep_json", deep),
        test("refuse::every_truncation", truncations),
    ];
    let mut add = |base: &str, rows: &'static [Row], run: fn(&Row) -> Outcome| {
        tests.extend(rows.iter().map(|row| test(format!("refuse::{base}::{}", row.0), move || run(row))));
    };
    add("square", SQUARE, |row| refused(Maker::square(), row));
    add("skinned", SKINNED, |row| refused(Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]), row));
    add("animated", ANIMATED, not_played);
    add("lights", LIGHTS, not_lit);
    tests
}

fn ends_with<T: std::fmt::Debug>(found: &Result<T, &GltfError>, parts: &str) -> Outcome {
    let is_right = found.as_ref().is_err_and(|error| says(&error.to_string(), parts));
    ensure(is_right, || format!("{found:?}, expected {parts:?}"))
}

fn refused(mut maker: Maker, &(_, change, parts): &Row) -> Outcome {
    maker.load()?;
    change.apply(&mut maker);
    ends_with(&maker.load().as_ref(), parts)
}

/// The file loads with a warning and has its pose at rest. The animation is refused once it is asked for.
fn not_played(&(_, change, parts): &Row) -> Outcome {
    let mut maker = everything();
    let rest = maker.load()?.pose(None, 0.0)?;
    change.apply(&mut maker);
    let asset = maker.load()?;
    // A row may spoil a node, too.
    let at_rest = asset.pose(None, 0.0)?;
    ensure(at_rest.instances().len() == rest.instances().len(), || "instances".to_owned())?;
    let error = asset.pose(Some(0), 0.0);
    let Err(GltfError::DamagedAnimation { index: 0, source }) = error else {
        return Err(format!("asked for: {error:?}").into());
    };
    ends_with(&Err::<(), _>(&*source), parts)?;
    let info = &asset.animations()[0];
    ensure(info.fault.as_ref() == Some(&*source) && info.channels == 0, || format!("{info:?}"))?;
    ensure(asset.lights(Some(0), 0.0).is_err(), || "lights of a damaged animation".to_owned())?;
    let warning = GltfWarning::Damaged { fault: source };
    ensure(asset.warnings().contains(&warning), || format!("{:?}", asset.warnings()))
}

/// The file loads with a warning. The light of node 0 is refused once it is asked for, and the one of node 1 is not.
fn not_lit(&(_, change, parts): &Row) -> Outcome {
    let mut maker = Maker::square();
    set(&mut maker, "extensions.KHR_lights_punctual.lights", "[{'type': 'point'}, {'type': 'point'}]");
    set(&mut maker, "nodes[0].extensions.KHR_lights_punctual.light", "0");
    set(&mut maker, "nodes[1]", "{'name': 'good', 'extensions': {'KHR_lights_punctual': {'light': 1}}}");
    ensure(maker.load()?.lights(None, 0.0)?.len() == 2, || "good lights".to_owned())?;
    change.apply(&mut maker);
    let asset = maker.load()?;
    ensure(matches!(asset.warnings(), [GltfWarning::Damaged { .. }]), || format!("{:?}", asset.warnings()))?;
    let each = asset.each_light(None, 0.0)?;
    ensure(matches!(each[..], [Err(GltfError::DamagedLight { node: 0, .. }), Ok(_)]), || format!("{each:?}"))?;
    ensure(asset.light_names() == [None, Some("good")], || format!("{:?}", asset.light_names()))?;
    ends_with(&asset.lights(None, 0.0).as_ref(), parts)
}

fn control() -> Outcome {
    let nothing = ("nothing", Change::Set(&[]), "");
    ensure(refused(Maker::square(), &nothing).is_err(), || "a good file passed as bad".to_owned())?;
    ensure(not_lit(&nothing).is_err(), || "good lights passed as bad".to_owned())?;
    let (name, change, _) = SQUARE[0];
    ensure(refused(Maker::square(), &(name, change, "nodes[3]")).is_err(), || "a wrong path passed".to_owned())
}

/// 66,000 instances of 66,000 vertices are more than `u32` indices can name, however small the file. Memory is no limit
/// here.
fn too_many_vertices() -> Outcome {
    let mut maker = Maker::square();
    let line: Vec<f32> = (0..66_000).flat_map(|x| [x as f32, 0.0, 0.0]).collect();
    let line = maker.floats("VEC3", &line);
    primitive(&mut maker)["attributes"]["POSITION"] = json!(line);
    let instancing = json!({ "attributes": { "TRANSLATION": line } });
    maker.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": instancing });
    let options = LoadOptions { memory_limit: u64::MAX, ..Weld::Keep.into() };
    ends_with(&Asset::from_slice(&maker.glb(), None, options).as_ref(), "nodes|4356000000 vertices|split")
}

/// No sum of bytes overflows where memory is no limit.
fn too_many_bytes() -> Outcome {
    let mut maker = Maker::square();
    let zeros = maker.zeros(1 << 62);
    primitive(&mut maker)["attributes"]["POSITION"] = json!(zeros);
    let options = LoadOptions { memory_limit: u64::MAX, ..Weld::Keep.into() };
    let result = Asset::from_slice(&maker.glb(), None, options);
    ensure(matches!(result, Err(GltfError::TooLarge { .. })), || format!("{result:?}"))
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
        let options = LoadOptions { allow_outside: true, ..Weld::Keep.into() };
        let result = Asset::from_slice(&maker.glb(), Some(folder.path()), options);
        ensure(matches!(result, Err(GltfError::Read { .. })), || format!("allowed: {result:?}"))?;
    }
    Ok(())
}

/// Values in each other are refused. A chain of nodes may be as deep as it likes.
fn deep() -> Outcome {
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let text = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        let result = Asset::from_slice(text.as_bytes(), None, Weld::Keep);
        ensure(matches!(result, Err(GltfError::Json(_))), || "deep JSON".to_owned())?;
    }
    let mut maker = Maker::square();
    maker.json["nodes"] = (1..50_000).map(|child| json!({ "children": [child] })).collect();
    maker.push("nodes", json!({ "mesh": 0, "translation": [1, 0, 0] }));
    let asset = maker.load()?;
    ensure(asset.pose(None, 0.0)?.instances().len() == 1, || "instances".to_owned())
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
