//! Small files after public reports, and what is right for each.
//!
//! They are in a folder beside that of the shared models. Other tests have files made by code for each of these situations.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError, GltfWarning};
use rimline::mesh::Weld;
use rimline_testkit::shared_cases;

use crate::shape::same;
use crate::{Outcome, check, ensure, test};

/// File, what its only warning must say, and the faces that are shown.
const WARNED: &[(&str, &str, usize)] = &[
    ("n4_skin.glb", "skins[0].inverseBindMatrices, matrix 0", 12),
    ("n4_light.glb", "extensions.KHR_lights_punctual.lights[0].type", 12),
    ("j7_matrix_animated.glb", "nodes[0], which has a matrix", 12),
    ("j17_zero_quat.glb", "nodes[0].rotation", 12),
    ("j18_weights_no_targets.glb", "meshes[0].weights has 1 morph weights", 12),
    ("k_nan.glb", "attributes.POSITION: 1 positions are infinite or NaN", 12),
    ("k_inf.glb", "attributes.POSITION: 1 positions are infinite or NaN", 12),
    ("k_unused.glb", "attributes.POSITION: 1 positions are infinite or NaN", 12),
    ("k_not_in_scene.glb", "attributes.POSITION: 1 positions are infinite or NaN", 0),
];

pub(crate) fn tests() -> Vec<Trial> {
    if shared_cases().is_none() {
        return vec![test("cases::real files", || Ok(())).with_ignored_flag(true)];
    }
    let mut tests = vec![
        test("cases::n4_keys.glb", keys),
        test("cases::j7_is_refused_once_it_is_asked_for", animated_matrix),
        test("cases::b10_hidden.glb", hidden),
        test("cases::n2_per_object.glb", per_object),
        test("cases::j13_unnamed_lights.glb", unnamed_lights),
    ];
    tests.extend(
        WARNED.iter().map(|&(name, says, faces)| test(format!("cases::{name}"), move || warned(name, says, faces))),
    );
    tests
}

fn open(name: &str) -> Result<Asset, String> {
    Asset::open(shared_cases().ok_or("there are no cases")?.join(name), Weld::Data)
        .map_err(|error| format!("{name}: {error}"))
}

fn warned(name: &str, says: &str, faces: usize) -> Outcome {
    let asset = open(name)?;
    check::asset(&asset, usize::MAX, false)?;
    let warnings = check::said(&asset);
    ensure(warnings.len() == 1 && warnings[0].contains(says), || format!("{name}: {warnings:?}"))?;
    same(&asset.model().placed_geometries().map(|g| g.faces().len()).sum(), &faces, "faces that are shown")
}

/// Two neighbouring keys have one time: a step, and no fault.
fn keys() -> Outcome {
    let asset = open("n4_keys.glb")?;
    same(&asset.warnings().len(), &0, "warnings")?;
    check::asset(&asset, usize::MAX, false)
}

fn animated_matrix() -> Outcome {
    let found = open("j7_matrix_animated.glb")?.pose(Some(0), 0.5);
    ensure(matches!(found, Err(GltfError::DamagedAnimation { index: 0, .. })), || format!("{found:?}"))
}

fn hidden() -> Outcome {
    let asset = open("b10_hidden.glb")?;
    same(&(asset.model().instances().len(), asset.hidden_nodes()), &(1, 1), "instances and hidden nodes")?;
    same(&asset.warnings().len(), &0, "warnings")
}

fn per_object() -> Outcome {
    let asset = open("n2_per_object.glb")?;
    let places = |pose: rimline::Pose| -> Vec<[f64; 3]> {
        pose.instances().iter().map(|instance| check::map(&instance.palette()[0], [0.0; 3])).collect()
    };
    let found = places(asset.pose(0..2, 1.0)?);
    same(&found, &vec![[0.0, 0.0, 4.0], [3.0, 5.0, 0.0]], "both move")?;
    same(&places(asset.pose(Some(0), 1.0)?), &vec![[0.0, 0.0, 4.0], [3.0, 0.0, 0.0]], "one moves")
}

fn unnamed_lights() -> Outcome {
    let asset = open("j13_unnamed_lights.glb")?;
    same(&asset.light_names(), &vec![None, None], "names")?;
    let warnings: Vec<&GltfWarning> = asset.warnings().iter().collect();
    ensure(warnings.is_empty(), || format!("{warnings:?}"))?;
    same(&asset.lights(None, 0.0)?.len(), &2, "lights")
}
