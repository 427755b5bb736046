//! Hand-made files: where things stand and which joints move them.

use libtest_mimic::{Failed, Trial};
use rimline::gltf::{Asset, SceneLightKind};
use rimline::{Instance, InstancePose};
use serde_json::json;

use crate::check::{close, like_poser, map, moved};
use crate::maker::Maker;
use crate::{Outcome, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("place::gpu_instances", instances),
        test("place::mirrored_node_turns_faces", mirrored),
        test("place::scenes", scenes),
        test("place::skins", skins),
        test("place::mirrored_joints_are_counted", mirrored_joints),
        test("place::a_mesh_with_and_without_skin", both_ways),
        test("place::lights", lights),
    ]
}

fn instances() -> Outcome {
    let mut maker = Maker::square();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let translations = maker.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
    let turns = maker.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half, 0.0, 0.0, 0.0, 1.0]);
    let scales = maker.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, -1.0]);
    maker.json["nodes"][0] = json!({
        "mesh": 0,
        "translation": [0, 0, 10],
        "extensions": { "EXT_mesh_gpu_instancing": {
            "attributes": { "TRANSLATION": translations, "ROTATION": turns, "SCALE": scales },
        } },
    });
    let pose = maker.load()?.pose(None, 0.0)?;
    let ends = pose.instances().iter().flat_map(|instance| map(&instance.palette()[0], [1.0, 0.0, 0.0]));
    close(&ends.collect::<Vec<_>>(), &[2.0, 0.0, 10.0, 0.0, 4.0, 10.0, 1.0, 0.0, 10.0], 1e-6, "the point (1, 0, 0)")?;
    let turned: Vec<bool> = pose.instances().iter().map(InstancePose::faces_turned).collect();
    same(&turned, &vec![false, false, true], "turned")
}

fn mirrored() -> Outcome {
    let mut maker = Maker::square();
    let faces = |maker: &Maker| -> Result<_, Failed> {
        let asset = maker.load()?;
        Ok(asset.model().mesh(&asset.pose(None, 0.0)?)?.faces().to_vec())
    };
    same(&faces(&maker)?, &vec![[0, 1, 2], [0, 2, 3]], "upright")?;
    maker.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    same(&faces(&maker)?, &vec![[0, 2, 1], [0, 3, 2]], "mirrored")?;
    maker.push("nodes", json!({ "children": [0], "scale": [1, -1, 1] }));
    same(&faces(&maker)?, &vec![[0, 1, 2], [0, 2, 3]], "mirrored twice")
}

fn names(asset: &Asset) -> Vec<&str> {
    asset.model().instances().iter().map(|instance| instance.name().unwrap_or("-")).collect()
}

fn scenes() -> Outcome {
    let mut maker = Maker::square();
    let mesh = maker.json["meshes"][0].clone();
    maker.push("meshes", mesh);
    maker.json["meshes"][1]["name"] = json!("alone");
    maker.json["nodes"] = json!([
        { "mesh": 0, "name": "leaf" },
        { "mesh": 0, "name": "root", "children": [3, 0], "translation": [5, 0, 0] },
        { "mesh": 0, "name": "second" },
        { "mesh": 0, "name": "first leaf" },
    ]);
    let asset = maker.load()?;
    same(&names(&asset), &vec!["root", "first leaf", "leaf", "second", "alone"], "no scenes")?;
    for (instance, x) in [5.0, 5.0, 5.0, 0.0, 0.0].into_iter().enumerate() {
        close(&moved(&asset, instance, [0.0; 3])?, &[x, 0.0, 0.0], 0.0, "origin")?;
    }
    maker.json["scenes"] = json!([{ "nodes": [2] }, { "nodes": [1] }, {}]);
    same(&names(&maker.load()?), &vec!["second"], "the first scene")?;
    maker.json["scene"] = json!(1);
    same(&names(&maker.load()?), &vec!["root", "first leaf", "leaf"], "the default scene")?;
    maker.json["scene"] = json!(2);
    same(&names(&maker.load()?), &vec![], "a scene without nodes")?;
    same(&maker.load()?.model().geometries().len(), &2, "geometries, whatever the scene")
}

/// Weights of any sum, those of 0 at the first joint, for any joint of the others; nodes of skins do not move them; with
/// matrices of the skin and without; two primitives of other joints and targets; weights of targets that nobody states.
fn skins() -> Outcome {
    for weights in
        [[0.5, 0.5, 0.0, 0.0], [1.0, 3.0, 0.0, 0.0], [0.0, 1e-30, 0.0, 0.0], [3e38; 4], [0.0, -0.0, 0.0, 0.0]]
    {
        let unused = if weights[2] == 0.0 { 77 } else { 0 };
        let mut maker = Maker::skinned([1, 0, unused, 0], weights);
        maker.json["nodes"][0]["translation"] = json!([100, 100, 100]);
        maker.json["nodes"][2]["scale"] = json!([2, 2, 2]);
        let joints = maker.accessor(crate::maker::U8, "VEC4", 4, &[0, 1, 1, 0].repeat(4));
        let targets = [1.0, 2.0].map(|by| maker.floats("VEC3", &[by; 12]));
        crate::rows::primitive(&mut maker)["targets"] = json!([{ "POSITION": targets[0] }, {}]);
        let second = crate::rows::copy_primitive(&mut maker);
        second["attributes"]["JOINTS_0"] = json!(joints);
        second["targets"][0]["POSITION"] = json!(targets[1]);
        like_poser(&maker, &[])?;
        let binds = maker.floats("MAT4", &[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1].map(|v| v as f32).repeat(2));
        maker.json["skins"][0]["inverseBindMatrices"] = json!(binds);
        maker.json["meshes"][0]["weights"] = json!([0.25, 0.5]);
        like_poser(&maker, &[])?;
    }
    Ok(())
}

fn mirrored_joints() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    let joint = maker.push("nodes", json!({ "scale": [1, 1, -1] }));
    maker.json["skins"][0]["joints"] = json!([1, 2, joint]);
    let state = |maker: &Maker| -> Result<(bool, usize), Failed> {
        let pose = maker.load()?.pose(None, 0.0)?;
        Ok((pose.instances()[0].faces_turned(), pose.mixed_determinants()))
    };
    same(&state(&maker)?, &(false, 0), "a mirrored joint that no vertex follows")?;
    maker.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    same(&state(&maker)?, &(false, 1), "one of two")?;
    maker.json["nodes"][2]["scale"] = json!([-1, 1, 1]);
    same(&state(&maker)?, &(true, 0), "both")
}

fn both_ways() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [1.0, 0.0, 0.0, 0.0]);
    maker.push("nodes", json!({ "mesh": 0, "translation": [0, 0, 7] }));
    let asset = maker.load()?;
    same(&asset.meshes()[0].geometries, &vec![0, 1], "geometries")?;
    let rigid: Vec<bool> = asset.model().geometries().iter().map(|g| g.influences().is_none()).collect();
    same(&rigid, &vec![false, true], "rigid")?;
    let used: Vec<usize> = asset.model().instances().iter().map(Instance::geometry).collect();
    same(&used, &vec![0, 1], "instances")?;
    like_poser(&maker, &[])
}

fn lights() -> Outcome {
    let mut maker = Maker::square();
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "name": "sun" },
        { "type": "point", "intensity": 3 },
        { "type": "spot", "spot": {} },
        { "type": "point" },
    ] } });
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for (light, name) in [(0, json!("a")), (1, json!("lamp")), (2, json!("torch")), (3, json!(null))] {
        let mut node = json!({
            "translation": [1, 2, 3],
            "scale": [2, 2, 2],
            // A quarter turn about x: z goes to −y.
            "rotation": [half, 0, 0, half],
            "extensions": { "KHR_lights_punctual": { "light": light } },
        });
        if !name.is_null() {
            node["name"] = name;
        }
        maker.push("nodes", node);
    }
    let found = maker.load()?.lights(None, 0.0)?;
    let kinds: Vec<_> = found.iter().map(|light| (light.name.as_deref(), light.kind)).collect();
    let expected = vec![
        (Some("sun"), SceneLightKind::Directional),
        (Some("lamp"), SceneLightKind::Point),
        (Some("torch"), SceneLightKind::Spot),
        (None, SceneLightKind::Point),
    ];
    same(&kinds, &expected, "names and kinds")?;
    let at = [1.0, 2.0, 3.0, 1.0];
    for (light, expected) in found.iter().zip([[0.0, -1.0, 0.0, 0.0], at, at, at]) {
        close(&light.light.to_array().map(f64::from), &expected, 1e-7, "the light")?;
    }
    Ok(())
}
