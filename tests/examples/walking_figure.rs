//! The demo's figure: closed, skinned as glTF asks, a walk that loops, and a file that holds together.

use std::sync::LazyLock;

use glam::Vec3;
use rimline::Mesh;
use rimline::mesh::Weld;
use rimline_models::figure::{Figure, glb, skeleton::JOINTS, walk};

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

/// By a reader of other hands.
#[test]
fn the_file_holds_all_of_it() {
    let file = glb::encode(&FIGURE);
    assert!(glb::encode(&Figure::new()) == file, "the same every time");
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file).expect("valid glTF");
    let blob = blob.expect("a binary chunk");
    let primitive = document.meshes().flat_map(|mesh| mesh.primitives()).next().expect("a primitive");
    let reader = primitive.reader(|_| Some(&*blob));
    let vectors = |read: &mut dyn Iterator<Item = [f32; 3]>| read.map(Vec3::from).collect::<Vec<_>>();
    assert!(vectors(&mut reader.read_positions().expect("positions")) == FIGURE.positions);
    assert!(vectors(&mut reader.read_normals().expect("normals")) == FIGURE.normals);
    assert!(reader.read_indices().expect("faces").into_u32().eq(FIGURE.faces.iter().flatten().copied()));
    assert!(reader.read_joints(0).expect("joints").into_u16().eq(FIGURE.joints.iter().map(|of| of.map(u16::from))));
    assert!(reader.read_weights(0).expect("weights").into_f32().eq(FIGURE.weights.iter().copied()));
    let skin = document.skins().next().expect("a skin");
    let binds = skin.reader(|_| Some(&*blob)).read_inverse_bind_matrices().map(Iterator::count);
    assert_eq!((skin.joints().count(), binds), (JOINTS.len(), Some(JOINTS.len())));
    let animation = document.animations().next().expect("an animation");
    assert_eq!(animation.channels().count(), JOINTS.len() + 1);
    for channel in animation.channels() {
        let times = channel.reader(|_| Some(&*blob)).read_inputs().expect("times");
        assert_eq!(times.fold(0.0, f32::max), walk::DURATION);
    }
    assert_eq!(document.default_scene().map(|scene| scene.nodes().count()), Some(2));
}
