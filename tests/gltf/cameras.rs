//! Cameras of files: where they are, what they see, and what is wrong with them.

use libtest_mimic::Trial;
use rimline::gltf::{CameraProjection, GltfError, SceneCamera};
use serde_json::{Value, json};

use crate::check::close;
use crate::maker::Maker;
use crate::shape::same;
use crate::{Outcome, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        test("cameras::follow_their_nodes", follow),
        test("cameras::names_are_those_of_nodes_too", names),
        test("cameras::without_a_direction", flat),
    ];
    tests.extend(FAULTS.iter().map(|&fault| test(format!("cameras::{}", fault.0), move || at_fault(fault))));
    tests
}

fn with_camera(camera: Value, node: &Value) -> Maker {
    let mut maker = Maker::square();
    maker.push("cameras", camera);
    let node = maker.push("nodes", node.clone());
    maker.json["nodes"][node]["camera"] = json!(0);
    maker
}

fn cameras(
    maker: &Maker,
    animation: Option<usize>,
    time: f32,
) -> Result<Vec<Result<SceneCamera, GltfError>>, GltfError> {
    maker.load()?.each_camera(animation, time)
}

fn follow() -> Outcome {
    let projection = json!({ "xmag": -2, "ymag": 1.5, "znear": 0, "zfar": 10 });
    let turned = json!({ "children": [3], "rotation": [0, 1, 0, 1], "scale": [1, 5, 2] });
    let mut maker = with_camera(
        json!({ "type": "orthographic", "orthographic": projection }),
        &json!({ "translation": [0, 1, 0] }),
    );
    maker.push("nodes", turned);
    let node = json!({ "camera": 1, "translation": [1, 0, 0] });
    maker.push("nodes", node);
    let perspective = json!({ "yfov": 0.5, "znear": 0.25, "aspectRatio": 2 });
    maker.push("cameras", json!({ "type": "perspective", "perspective": perspective }));
    let keys = maker.keys(&[0.0, 1.0], "VEC3", &[0.0, 1.0, 0.0, 4.0, 1.0, 0.0], "LINEAR");
    maker.animate(1, "translation", &keys);
    let found = cameras(&maker, Some(0), 0.5)?.into_iter().collect::<Result<Vec<_>, _>>()?;
    let [first, second] = &found[..] else { return Err(format!("{found:?}").into()) };
    same(&first.eye, &[2.0, 1.0, 0.0], "an animated place")?;
    let ortho = CameraProjection::Orthographic { xmag: -2.0, ymag: 1.5, znear: 0.0, zfar: 10.0 };
    same(&first.projection, &ortho, "projection")?;
    // Turned by a quarter: its -Z is the world's -X.
    let wide = |vector: [f32; 3]| vector.map(f64::from);
    close(&wide(second.eye), &[0.0, 0.0, -1.0], 1e-6, "eye")?;
    close(&wide(second.forward), &[-1.0, 0.0, 0.0], 1e-6, "forward")?;
    close(&wide(second.up), &[0.0, 1.0, 0.0], 1e-6, "up")?;
    let perspective = CameraProjection::Perspective { yfov: 0.5, aspect_ratio: Some(2.0), znear: 0.25, zfar: None };
    same(&second.projection, &perspective, "projection")
}

const GOOD: &str = "{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 1}}";

fn parsed(text: &str) -> Value {
    serde_json::from_str(&text.replace('\'', "\"")).expect(text)
}

fn names() -> Outcome {
    let mut maker = with_camera(parsed(GOOD), &json!({ "name": "node" }));
    same(&maker.load()?.camera_names(), &vec![Some("node")], "names")?;
    maker.json["cameras"][0]["name"] = json!("camera");
    same(&maker.load()?.camera_names(), &vec![Some("camera")], "names")?;
    let found = cameras(&maker, None, 0.0)?;
    ensure(found[0].as_ref().is_ok_and(|camera| camera.name.as_deref() == Some("camera")), || format!("{found:?}"))?;
    same(&Maker::square().load()?.camera_names(), &vec![], "names")
}

/// The node has no extent along Z.
fn flat() -> Outcome {
    let found = cameras(&with_camera(parsed(GOOD), &json!({ "scale": [1, 1, 0] })), None, 0.0)?;
    ensure(matches!(found[..], [Err(GltfError::NotFinite { .. })]), || format!("{found:?}"))
}

/// A name, a camera, and what its error says.
const FAULTS: &[(&str, &str, &str)] = &[
    ("no_type", "{}", "cameras[0].type is missing"),
    ("unknown_type", "{'type': 'fisheye'}", "cameras[0].type"),
    ("no_object", "5", "cameras[0]"),
    ("no_projection", "{'type': 'orthographic'}", "cameras[0].orthographic is missing"),
    ("zero_yfov", "{'type': 'perspective', 'perspective': {'yfov': 0, 'znear': 1}}", "perspective.yfov"),
    ("wide_yfov", "{'type': 'perspective', 'perspective': {'yfov': 3.2, 'znear': 1}}", "perspective.yfov"),
    ("zero_znear", "{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 0}}", "perspective.znear"),
    (
        "zfar_before_znear",
        "{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 2, 'zfar': 1}}",
        "perspective.zfar",
    ),
    ("huge_znear", "{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 1e300}}", "perspective.znear"),
    ("zero_xmag", "{'type': 'orthographic', 'orthographic': {'xmag': 0, 'ymag': 1, 'znear': 0, 'zfar': 1}}", "xmag"),
    (
        "flat",
        "{'type': 'orthographic', 'orthographic': {'xmag': 1, 'ymag': 1, 'znear': 1, 'zfar': 1}}",
        "orthographic.zfar",
    ),
];

fn at_fault((_, camera, says): (&str, &str, &str)) -> Outcome {
    let found = cameras(&with_camera(parsed(camera), &json!({})), None, 0.0)?;
    let [Err(error @ GltfError::DamagedCamera { node: 1, .. })] = &found[..] else {
        return Err(format!("{found:?}").into());
    };
    ensure(error.to_string().contains(says), || error.to_string())
}
