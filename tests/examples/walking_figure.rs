//! The demo's figure: closed, skinned as glTF asks, a walk that loops, and a file that holds together.

use std::sync::LazyLock;

use glam::Vec3;
use rimline::Mesh;
use rimline::mesh::Weld;
use rimline_models::figure::{Figure, glb, skeleton::JOINTS, walk};
use serde_json::Value;

static FIGURE: LazyLock<Figure> = LazyLock::new(Figure::new);

fn mesh(positions: &[Vec3]) -> Mesh {
    let positions: Vec<_> = positions.iter().map(Vec3::to_array).collect();
    Mesh::new(&positions, &FIGURE.faces, Weld::Data).expect("a mesh")
}

#[test]
fn one_closed_surface_without_holes_or_handles() {
    let mesh = mesh(&FIGURE.positions);
    assert!(mesh.is_closed(), "{:?}", mesh.edges().counts());
    assert_eq!(mesh.weld_counts().after, FIGURE.positions.len(), "no two vertices at one place");
    assert_eq!(mesh.degenerate_faces(), 0);
    let euler = FIGURE.positions.len() as i64 - mesh.edges().len() as i64 + FIGURE.faces.len() as i64;
    assert_eq!(euler, 2);
    assert!((10_000..=40_000).contains(&FIGURE.faces.len()), "{}", FIGURE.faces.len());
}

#[test]
fn closedness_notices_a_missing_and_a_turned_face() {
    let positions: Vec<_> = FIGURE.positions.iter().map(Vec3::to_array).collect();
    let missing = Mesh::from_faces(positions.len(), FIGURE.faces[1..].to_vec()).expect("a mesh");
    assert_eq!(missing.edges().counts().boundary, 3);
    let mut turned = FIGURE.faces.clone();
    turned[7].swap(0, 1);
    let turned = Mesh::from_faces(positions.len(), turned).expect("a mesh");
    assert_eq!(turned.edges().counts().inconsistent, 3);
}

#[test]
fn faces_and_normals_look_outwards() {
    let mut volume = 0.0;
    for face in &FIGURE.faces {
        let [a, b, c] = face.map(|v| FIGURE.positions[v as usize]);
        volume += a.dot(b.cross(c)) / 6.0;
        let facing = (b - a).cross(c - a).normalize();
        let normal: Vec3 = face.iter().map(|&v| FIGURE.normals[v as usize]).sum();
        assert!(facing.dot(normal) > 0.0, "face {face:?} at {a}");
    }
    // A person's volume in cubic metres.
    assert!((0.04..0.1).contains(&volume), "{volume}");
    assert!(FIGURE.normals.iter().all(|normal| normal.is_normalized()));
}

#[test]
fn weights_sum_to_one_and_name_joints() {
    assert!(JOINTS.len() >= 8);
    let mut used = [false; JOINTS.len()];
    for (joints, weights) in FIGURE.joints.iter().zip(&FIGURE.weights) {
        let sum: f32 = weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-6 && weights.iter().all(|&weight| weight >= 0.0), "{weights:?}");
        for (first, joint) in joints.iter().enumerate() {
            assert!(!joints[..first].contains(joint), "twice the same joint: {joints:?}");
            used[*joint as usize] |= weights[first] > 0.5;
        }
    }
    let idle: Vec<_> = (0..JOINTS.len()).filter(|&j| !used[j]).map(|j| JOINTS[j].name).collect();
    assert!(idle.is_empty(), "joints that move nothing: {idle:?}");
}

#[test]
fn the_walk_loops_and_keeps_its_feet_on_the_ground() {
    let keys = walk::keys();
    assert_eq!(keys.first(), keys.last());
    for (key, pose) in keys.iter().enumerate() {
        let from_rest = walk::from_rest(pose);
        let skinned = FIGURE.positions.iter().enumerate().map(|(v, &point)| {
            let joint_position = |k: usize| from_rest[FIGURE.joints[v][k] as usize].transform_point3(point);
            (0..4).map(|k| joint_position(k) * FIGURE.weights[v][k]).sum()
        });
        let skinned: Vec<Vec3> = skinned.collect();
        let (low, high) =
            skinned.iter().fold((f32::MAX, f32::MIN), |(low, high), point| (low.min(point.y), high.max(point.y)));
        assert!(low.abs() < 0.02 && (1.6..1.8).contains(&high), "key {key}: {low} to {high}");
        assert!(mesh(&skinned).is_closed(), "key {key}");
        let shorter = walk::pose(walk::phase(key) + 0.01);
        let step = |joint: usize| pose.rotations[joint].angle_between(shorter.rotations[joint]);
        assert!((0..JOINTS.len()).all(|joint| step(joint) < 0.2), "key {key}: a jump");
    }
}

/// The JSON and the binary chunk of a GLB.
fn chunks(file: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("4 bytes")) as usize;
    assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
    let json = 20..20 + word(12);
    assert_eq!((&file[16..20], word(12) % 4), (&b"JSON"[..], 0));
    let binary = json.end + 8..json.end + 8 + word(json.end);
    assert_eq!((&file[json.end + 4..json.end + 8], binary.len() % 4), (&b"BIN\0"[..], 0));
    assert_eq!(binary.end, file.len());
    (serde_json::from_slice(&file[json]).expect("JSON"), &file[binary])
}

#[test]
fn the_file_is_a_valid_gltf_binary() {
    let file = glb::encode(&FIGURE);
    let (document, binary) = chunks(&file);
    let number = |value: &Value| value.as_u64().expect("a number") as usize;
    let all = |name: &str| document[name].as_array().expect("an array").clone();
    assert!(number(&document["buffers"][0]["byteLength"]) <= binary.len());
    let mut end = 0;
    for (accessor, view) in all("accessors").iter().zip(all("bufferViews")) {
        let width = match number(&accessor["componentType"]) {
            5121 => 1,
            _ => 4,
        };
        let components = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            _ => 16,
        };
        assert_eq!(number(&view["byteOffset"]), end, "views follow each other");
        assert_eq!(number(&accessor["count"]) * width * components, number(&view["byteLength"]));
        end += number(&view["byteLength"]);
    }
    assert_eq!(end, number(&document["buffers"][0]["byteLength"]));
    assert_eq!(all("skins")[0]["joints"].as_array().map(Vec::len), Some(JOINTS.len()));
    assert_eq!(all("animations")[0]["channels"].as_array().map(Vec::len), Some(JOINTS.len() + 1));
    assert!(glb::encode(&Figure::new()) == file, "the same every time");
}

#[test]
fn the_gltf_crate_accepts_the_file() {
    let read = gltf::Gltf::from_slice(&glb::encode(&FIGURE)).expect("valid glTF");
    let skin = read.skins().next().expect("a skin");
    assert_eq!(skin.joints().count(), JOINTS.len());
    assert_eq!(read.animations().count(), 1);
    assert_eq!(read.default_scene().map(|scene| scene.nodes().count()), Some(2));
}
