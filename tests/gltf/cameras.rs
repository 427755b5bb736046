//! Cameras of files: where they are, what they see, and what is wrong with them.

use libtest_mimic::Trial;
use rimline::gltf::{CameraProjection, GltfError, SceneCamera};
use serde_json::json;

use crate::check::close;
use crate::maker::Maker;
use crate::rows::{says, set};
use crate::{Outcome, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("cameras::follow_their_nodes", follow),
        test("cameras::names_are_those_of_nodes_too", names),
        test("cameras::of_hidden_nodes_are_there", hidden),
        test("cameras::without_a_direction", flat),
        test("cameras::of_nodes_of_any_scale", scaled),
        test("cameras::faults", faults),
    ]
}

/// The camera of node 1.
fn with_camera(camera: &str) -> Maker {
    let mut maker = Maker::square();
    set(&mut maker, "cameras[0]", camera);
    set(&mut maker, "nodes[1]", "{'camera': 0, 'name': 'node'}");
    maker
}

fn cameras(maker: &Maker, animation: Option<usize>) -> Result<Vec<Result<SceneCamera, GltfError>>, GltfError> {
    maker.load()?.each_camera(animation, 0.5)
}

fn follow() -> Outcome {
    let mut maker =
        with_camera("{'type': 'orthographic', 'orthographic': {'xmag': -2, 'ymag': 1.5, 'znear': 0, 'zfar': 10}}");
    maker.push("nodes", json!({ "children": [3], "rotation": [0, 1, 0, 1], "scale": [1, 5, 2] }));
    maker.push("nodes", json!({ "camera": 1, "translation": [1, 0, 0] }));
    let perspective = json!({ "yfov": 0.5, "znear": 0.25, "aspectRatio": 2 });
    maker.push("cameras", json!({ "type": "perspective", "perspective": perspective }));
    let keys = maker.keys(&[0.0, 1.0], "VEC3", &[0.0, 1.0, 0.0, 4.0, 1.0, 0.0], "LINEAR");
    maker.animate(1, "translation", &keys);
    let found = cameras(&maker, Some(0))?.into_iter().collect::<Result<Vec<_>, _>>()?;
    let [first, second] = &found[..] else { return Err(format!("{found:?}").into()) };
    same(&first.eye, &[2.0, 1.0, 0.0], "an animated place")?;
    let ortho = CameraProjection::Orthographic { xmag: -2.0, ymag: 1.5, znear: 0.0, zfar: 10.0 };
    same(&first.projection, &ortho, "projection")?;
    // Turned by a quarter: its -Z is the world's -X.
    let axes = [second.eye, second.forward, second.up].concat().into_iter().map(f64::from).collect::<Vec<_>>();
    close(&axes, &[0.0, 0.0, -1.0, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0], 1e-6, "eye, forward and up")?;
    let perspective = CameraProjection::Perspective { yfov: 0.5, aspect_ratio: Some(2.0), znear: 0.25, zfar: None };
    same(&second.projection, &perspective, "projection")
}

const GOOD: &str = "{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 1}}";

fn hidden() -> Outcome {
    let mut maker = with_camera(GOOD);
    set(&mut maker, "nodes[1].extensions.KHR_node_visibility.visible", "false");
    for scenes in [json!([]), json!([{ "nodes": [0, 1] }])] {
        maker.json["scenes"] = scenes;
        let asset = maker.load()?;
        same(&(asset.hidden_nodes(), asset.camera_names()), &(1, vec![Some("node")]), "hidden nodes, and names")?;
        same(&asset.each_camera(None, 0.0)?.iter().filter(|camera| camera.is_ok()).count(), &1, "cameras")?;
    }
    Ok(())
}

fn names() -> Outcome {
    let mut maker = with_camera(GOOD);
    same(&maker.load()?.camera_names(), &vec![Some("node")], "names")?;
    maker.json["cameras"][0]["name"] = json!("camera");
    same(&maker.load()?.camera_names(), &vec![Some("camera")], "names")?;
    let found = cameras(&maker, None)?;
    ensure(found[0].as_ref().is_ok_and(|camera| camera.name.as_deref() == Some("camera")), || format!("{found:?}"))?;
    same(&Maker::square().load()?.camera_names(), &vec![], "names")
}

/// The node has no extent along Z.
fn flat() -> Outcome {
    let mut maker = with_camera(GOOD);
    maker.json["nodes"][1]["scale"] = json!([1, 1, 0]);
    let found = cameras(&maker, None)?;
    ensure(matches!(found[..], [Err(GltfError::NotFinite { .. })]), || format!("{found:?}"))
}

/// Squares of the scale are beyond what a number holds.
fn scaled() -> Outcome {
    for scale in [1e-200, 1e200] {
        let mut maker = with_camera(GOOD);
        maker.json["nodes"][1]["scale"] = json!([scale, scale, scale]);
        let found = cameras(&maker, None)?;
        let [Ok(camera)] = &found[..] else { return Err(format!("{scale:e}: {found:?}").into()) };
        same(&(camera.forward, camera.up), &([0.0, 0.0, -1.0], [0.0, 1.0, 0.0]), &format!("directions, {scale:e}"))?;
    }
    Ok(())
}

/// A camera, and what its error says.
const FAULTS: &[(&str, &str)] = &[
    ("{}", "cameras[0].type is missing"),
    ("{'type': 'fisheye'}", "cameras[0].type"),
    ("5", "cameras[0]"),
    ("{'type': 'orthographic'}", "cameras[0].orthographic is missing"),
    ("{'type': 'perspective', 'perspective': {'yfov': 0, 'znear': 1}}", "perspective.yfov"),
    ("{'type': 'perspective', 'perspective': {'yfov': 3.2, 'znear': 1}}", "perspective.yfov"),
    ("{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 0}}", "perspective.znear"),
    ("{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 2, 'zfar': 1}}", "perspective.zfar"),
    ("{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 1e300}}", "perspective.znear"),
    ("{'type': 'orthographic', 'orthographic': {'xmag': 0, 'ymag': 1, 'znear': 0, 'zfar': 1}}", "xmag"),
    ("{'type': 'orthographic', 'orthographic': {'xmag': 1, 'ymag': 1, 'znear': 1, 'zfar': 1}}", "orthographic.zfar"),
];

fn faults() -> Outcome {
    for (camera, parts) in FAULTS {
        let found = cameras(&with_camera(camera), None)?;
        let [Err(error @ GltfError::DamagedCamera { node: 1, .. })] = &found[..] else {
            return Err(format!("{camera}: {found:?}").into());
        };
        ensure(says(&error.to_string(), parts), || format!("{camera}: {error}"))?;
    }
    Ok(())
}
