//! Small files after public reports, and what is right for each.
//!
//! They are in a folder beside that of the shared models. Other tests have files made by code for each of these situations.

use std::path::Path;

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError};
use rimline::mesh::Weld;
use rimline_testkit::harness::on_files;
use rimline_testkit::shared_cases;

use crate::shape::same;
use crate::{Outcome, check, ensure};

/// File, what its only warning must say, if there is one, and what else holds.
type Row = (&'static str, Option<&'static str>, fn(&Asset) -> Outcome);

const ROWS: &[Row] = &[
    ("n4_skin.glb", Some("skins[0].inverseBindMatrices, matrix 0"), |asset| shown(asset, 12)),
    ("n4_light.glb", Some("extensions.KHR_lights_punctual.lights[0].type"), |asset| shown(asset, 12)),
    ("j7_matrix_animated.glb", Some("nodes[0], which has a matrix"), animated_matrix),
    ("j17_zero_quat.glb", Some("nodes[0].rotation"), |asset| shown(asset, 12)),
    ("j18_weights_no_targets.glb", Some("meshes[0].weights has 1 morph weights"), |asset| shown(asset, 12)),
    ("k_nan.glb", NOT_FINITE, |asset| shown(asset, 12)),
    ("k_inf.glb", NOT_FINITE, |asset| shown(asset, 12)),
    ("k_unused.glb", NOT_FINITE, |asset| shown(asset, 12)),
    ("k_not_in_scene.glb", NOT_FINITE, |asset| shown(asset, 0)),
    // Two neighbouring keys have one time: a step, and no fault.
    ("n4_keys.glb", None, |_| Ok(())),
    ("b10_hidden.glb", None, |asset| {
        same(&(asset.model().instances().len(), asset.hidden_nodes()), &(1, 1), "instances and hidden nodes")
    }),
    ("n2_per_object.glb", None, per_object),
    ("j13_unnamed_lights.glb", None, |asset| {
        same(&asset.light_names(), &vec![None, None], "names")?;
        same(&asset.lights(None, 0.0)?.len(), &2, "lights")
    }),
];
const NOT_FINITE: Option<&str> = Some("attributes.POSITION: 1 positions are infinite or NaN");

pub(crate) fn tests() -> Vec<Trial> {
    let names: Vec<_> = ROWS.iter().map(|row| row.0).collect();
    on_files("cases::", shared_cases(), &names, run)
}

fn run(path: &Path) -> Outcome {
    let (_, says, holds) = ROWS.iter().find(|row| path.ends_with(row.0)).ok_or("no row")?;
    let asset = Asset::open(path, Weld::Data)?;
    check::asset(&asset, usize::MAX, false)?;
    let warnings = check::said(&asset);
    let one = says.map_or(warnings.is_empty(), |says| warnings.len() == 1 && warnings[0].contains(says));
    ensure(one, || format!("{warnings:?}, expected {says:?}"))?;
    holds(&asset)
}

fn shown(asset: &Asset, faces: usize) -> Outcome {
    same(&asset.model().placed_geometries().map(|g| g.faces().len()).sum(), &faces, "faces that are shown")
}

/// It is refused once it is asked for.
fn animated_matrix(asset: &Asset) -> Outcome {
    shown(asset, 12)?;
    let found = asset.pose(Some(0), 0.5);
    ensure(matches!(found, Err(GltfError::DamagedAnimation { index: 0, .. })), || format!("{found:?}"))
}

fn per_object(asset: &Asset) -> Outcome {
    for (animations, x) in [(0..2, 5.0), (0..1, 0.0)] {
        let pose = asset.pose(animations, 1.0)?;
        let positions = pose.instances().iter().map(|instance| check::map(&instance.palette()[0], [0.0; 3]));
        same(&positions.collect(), &vec![[0.0, 0.0, 4.0], [3.0, x, 0.0]], "one or both move")?;
    }
    Ok(())
}
