//! `KHR_node_visibility`: what is hidden has no instances and no lights.

use libtest_mimic::Trial;
use rimline::gltf::GltfWarning;
use serde_json::{Value, json};

use crate::check::warned_once;
use crate::maker::Maker;
use crate::{Outcome, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("visible::hidden_subtrees", subtrees),
        test("visible::faults_below_hidden_nodes_are_warnings", faults),
        test("visible::joints_may_be_hidden", joints),
        test("visible::animated_visibility_is_a_warning", animated),
    ]
}

/// Node 0 is shown, 1 is hidden, 2 is below it and says that it is shown, 3 says nothing.
fn forest() -> Maker {
    let mut maker = Maker::square();
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let node = |name: &str, visibility: Value| {
        let extensions = json!({ "KHR_node_visibility": visibility, "KHR_lights_punctual": { "light": 0 } });
        json!({ "name": name, "mesh": 0, "extensions": extensions })
    };
    maker.json["nodes"] = json!([
        node("a", json!({ "visible": true })),
        node("b", json!({ "visible": false })),
        node("c", json!({ "visible": true })),
        node("d", json!({})),
    ]);
    maker.json["nodes"][1]["children"] = json!([2]);
    maker
}

fn subtrees() -> Outcome {
    for scenes in [json!([]), json!([{ "nodes": [0, 1, 3] }])] {
        let mut maker = forest();
        maker.json["scenes"] = scenes;
        let asset = maker.load()?;
        let names: Vec<_> = asset.model().instances().iter().map(|instance| instance.name()).collect();
        same(&names, &vec![Some("a"), Some("d")], "instances")?;
        same(&asset.light_names(), &names, "lights")?;
        same(&asset.lights(None, 0.0)?.len(), &2, "lights")?;
        same(&(asset.hidden_nodes(), asset.warnings().len()), &(2, 0), "hidden nodes and warnings")?;
        same(&asset.pose(None, 0.0)?.instances().len(), &2, "poses")?;
    }
    Ok(())
}

fn faults() -> Outcome {
    let mut maker = forest();
    maker.mesh(&json!({ "attributes": { "POSITION": 1 } }));
    maker.json["nodes"][2]["mesh"] = json!(1);
    let asset = maker.load()?;
    ensure(matches!(asset.warnings(), [GltfWarning::Damaged { .. }]), || format!("{:?}", asset.warnings()))?;
    maker.json["nodes"][1]["extensions"] = json!({});
    ensure(maker.load().is_err(), || "it is shown now".to_owned())
}

/// A skin moves with nodes that are hidden themselves.
fn joints() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    maker.json["nodes"][1]["translation"] = json!([2, 0, 0]);
    let shown = maker.load()?.pose(None, 0.0)?;
    maker.json["nodes"][1]["extensions"] = json!({ "KHR_node_visibility": { "visible": false } });
    same(&maker.load()?.pose(None, 0.0)?, &shown, "pose")
}

fn animated() -> Outcome {
    let mut maker = forest();
    let input = maker.floats("SCALAR", &[0.0, 1.0]);
    let output = maker.accessor(5121, "SCALAR", 2, &[0, 1]);
    let pointer = "/nodes/1/extensions/KHR_node_visibility/visible";
    maker.animate(1, "pointer", &json!({ "input": input, "output": output, "interpolation": "STEP" }));
    maker.json["animations"][0]["channels"][0]["target"] =
        json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } });
    let asset = maker.load()?;
    warned_once(&asset, &[&format!("animations[0].channels[0]: the pointer {pointer:?} is")])?;
    same(&asset.pose(Some(0), 0.5)?.instances().len(), &2, "instances")
}
