//! Hand-made files: where things stand and which joints move them.

use libtest_mimic::{Failed, Trial};
use rimline::gltf::{Asset, SceneLightKind};
use rimline::internals::model::influence_range;
use rimline::{Instance, InstancePose};
use serde_json::json;

use crate::check::{close, map, posed};
use crate::maker::{Maker, everything};
use crate::shape::same;
use crate::{Outcome, check, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("place::gpu_instances", instances),
        test("place::mirrored_node_turns_faces", mirrored),
        test("place::scenes", scenes),
        test("place::weights_are_normalised", weights),
        test("place::zero_weights_follow_the_first_joint", zero_weights),
        test("place::skin_ignores_its_node", skin_ignores_its_node),
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
    let asset = maker.load()?;
    let pose = asset.pose(None, 0.0)?;
    same(&pose.instances().len(), &3, "instances")?;
    let ends = [[2.0, 0.0, 10.0], [0.0, 4.0, 10.0], [1.0, 0.0, 10.0]];
    for (instance, end) in pose.instances().iter().zip(ends) {
        close(&map(&instance.palette()[0], [1.0, 0.0, 0.0]), &end, 1e-6, "the point (1, 0, 0)")?;
    }
    let turned: Vec<bool> = pose.instances().iter().map(InstancePose::faces_turned).collect();
    same(&turned, &vec![false, false, true], "turned")
}

fn mirrored() -> Outcome {
    let mut maker = Maker::square();
    let upright = maker.load()?;
    let faces =
        |asset: &Asset| -> Result<_, Failed> { Ok(asset.model().mesh(&asset.pose(None, 0.0)?)?.faces().to_vec()) };
    same(&faces(&upright)?, &vec![[0, 1, 2], [0, 2, 3]], "upright")?;
    maker.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    same(&faces(&maker.load()?)?, &vec![[0, 2, 1], [0, 3, 2]], "mirrored")
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
        { "mesh": 0, "name": "root", "children": [0], "translation": [5, 0, 0] },
        { "mesh": 0, "name": "second" },
    ]);
    let asset = maker.load()?;
    same(&names(&asset), &vec!["root", "leaf", "second", "alone"], "no scenes")?;
    let pose = asset.pose(None, 0.0)?;
    for (instance, x) in pose.instances().iter().zip([5.0, 5.0, 0.0, 0.0]) {
        close(&map(&instance.palette()[0], [0.0; 3]), &[x, 0.0, 0.0], 0.0, "origin")?;
    }
    maker.json["scenes"] = json!([{ "nodes": [2] }, { "nodes": [1] }, {}]);
    same(&names(&maker.load()?), &vec!["second"], "the first scene")?;
    maker.json["scene"] = json!(1);
    same(&names(&maker.load()?), &vec!["root", "leaf"], "the default scene")?;
    maker.json["scene"] = json!(2);
    same(&names(&maker.load()?), &vec![], "a scene without nodes")?;
    same(&maker.load()?.model().geometries().len(), &2, "geometries, whatever the scene")
}

fn weights() -> Outcome {
    for (given, expected) in [
        ([1.0, 3.0, 0.0, 0.0], vec![(0, 0.25), (1, 0.75)]),
        ([0.0, 1e-30, 0.0, 0.0], vec![(1, 1.0)]),
        ([3e38, 3e38, 3e38, 3e38], vec![(0, 0.25), (1, 0.25), (0, 0.25), (0, 0.25)]),
    ] {
        let asset = Maker::skinned([0, 1, 0, 0], given).load()?;
        let influences = asset.model().geometries()[0].influences().cloned().ok_or("rigid")?;
        let range = influence_range(&influences, 2);
        let found: Vec<(u32, f32)> = range.map(|i| (influences.joints()[i], influences.weights()[i])).collect();
        same(&found, &expected, &format!("{given:?}"))?;
    }
    // The second set comes first in the file, but not in the list.
    let asset = everything().load()?;
    let influences = asset.model().geometries()[0].influences().cloned().ok_or("rigid")?;
    same(&influences.joints()[influence_range(&influences, 1)].to_vec(), &vec![0, 1, 1], "two sets")?;
    let total: f32 = 1.75;
    let expected: Vec<f32> = [0.5, 0.25, 1.0].iter().map(|w| w / total).collect();
    same(&influences.weights()[influence_range(&influences, 1)].to_vec(), &expected, "their weights")
}

fn zero_weights() -> Outcome {
    let asset = Maker::skinned([1, 0, 77, 0], [0.0, -0.0, 0.0, 0.0]).load()?;
    let influences = asset.model().geometries()[0].influences().cloned().ok_or("rigid")?;
    same(&influences.joints().to_vec(), &vec![1; 4], "joints")?;
    same(&influences.weights().to_vec(), &vec![1.0; 4], "weights")?;
    let pose = asset.pose(None, 0.0)?;
    let corner = posed(&asset.model().geometries()[0], &pose.instances()[0])[0];
    close(&corner, &[0.0, 10.0, 0.0], 0.0, "the corner")
}

fn skin_ignores_its_node() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    maker.json["nodes"][0]["translation"] = json!([100, 100, 100]);
    maker.json["nodes"][2]["scale"] = json!([2, 2, 2]);
    let columns = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1].map(|v| v as f32);
    let binds = maker.floats("MAT4", &columns.repeat(2));
    let corner = |maker: &Maker| -> Result<[f64; 3], Failed> {
        let asset = maker.load()?;
        let pose = asset.pose(None, 0.0)?;
        same(&pose.instances()[0].palette().len(), &2, "palette")?;
        Ok(posed(&asset.model().geometries()[0], &pose.instances()[0])[1])
    };
    // The corner (1, 0, 0) by joints at (1, 0, 0) and, doubled, at (0, 10, 0).
    close(&corner(&maker)?, &[0.5 * 2.0 + 0.5 * 2.0, 5.0, 0.0], 1e-6, "no inverse bind matrices")?;
    maker.json["skins"][0]["inverseBindMatrices"] = json!(binds);
    close(&corner(&maker)?, &[0.5 * 5.0 + 0.5 * 8.0, 5.0, 0.0], 1e-6, "with them")
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
    let model = asset.model();
    let rigid: Vec<bool> = model.geometries().iter().map(|g| g.influences().is_none()).collect();
    same(&rigid, &vec![false, true], "rigid")?;
    let pose = asset.pose(None, 0.0)?;
    check::pose(model, &pose)?;
    let used: Vec<usize> = model.instances().iter().map(Instance::geometry).collect();
    same(&used, &vec![0, 1], "instances")?;
    close(&map(&pose.instances()[1].palette()[0], [0.0; 3]), &[0.0, 0.0, 7.0], 0.0, "the rigid one")
}

fn lights() -> Outcome {
    let mut maker = Maker::square();
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "name": "sun" },
        { "type": "point", "intensity": 3 },
        { "type": "spot", "spot": {} },
    ] } });
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let node = |light: usize, name: &str| {
        json!({
            "name": name,
            "translation": [1, 2, 3],
            "scale": [2, 2, 2],
            // A quarter turn about x: z goes to −y.
            "rotation": [half, 0, 0, half],
            "extensions": { "KHR_lights_punctual": { "light": light } },
        })
    };
    for (light, name) in [(0, "a"), (1, "lamp"), (2, "torch")] {
        maker.push("nodes", node(light, name));
    }
    let found = maker.load()?.lights(None, 0.0)?;
    let kinds: Vec<_> = found.iter().map(|light| (light.name.as_deref(), light.kind)).collect();
    let expected = vec![
        (Some("sun"), SceneLightKind::Directional),
        (Some("lamp"), SceneLightKind::Point),
        (Some("torch"), SceneLightKind::Spot),
    ];
    same(&kinds, &expected, "names and kinds")?;
    for (light, expected) in found.iter().zip([[0.0, -1.0, 0.0, 0.0], [1.0, 2.0, 3.0, 1.0], [1.0, 2.0, 3.0, 1.0]]) {
        close(&light.light.to_array().map(f64::from), &expected, 1e-7, "the light")?;
    }
    Ok(())
}
