//! Deformable models made by code.

use glam::{Affine3A, EulerRot, Quat, Vec3};
use rimline::model::Matrix3x4;
use rimline::{Geometry, GeometryOptions, Influences, Instance, InstancePose, Model, Pose};

use super::random::Random;

/// The row-major rows of a transform.
pub fn rows(transform: Affine3A) -> Matrix3x4 {
    let (m, t) = (transform.matrix3.transpose(), transform.translation);
    let row = |axis: glam::Vec3A, t: f32| [axis.x, axis.y, axis.z, t];
    [row(m.x_axis, t.x), row(m.y_axis, t.y), row(m.z_axis, t.z)]
}

pub fn random_matrix(random: &mut Random) -> Matrix3x4 {
    let scale = Vec3::from([0; 3].map(|_| random.between(-2.0, 2.0)));
    let turn = [0; 3].map(|_| random.between(-3.0, 3.0));
    let turn = Quat::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]);
    let translation = Vec3::from([0; 3].map(|_| random.between(-5.0, 5.0)));
    rows(Affine3A::from_scale_rotation_translation(scale, turn, translation))
}

/// `most_influences` joints a vertex at most, or rigid; `targets` morph targets; source vertices in a scrambled order.
pub fn random_geometry(
    random: &mut Random,
    vertices: usize,
    most_influences: Option<usize>,
    targets: usize,
) -> Geometry {
    let mut offset = |scale: f32| random.direction().map(|c| c * scale);
    let positions: Vec<_> = (0..vertices).map(|_| offset(1.5)).collect();
    let morph_targets = (0..targets).map(|_| (0..vertices).map(|_| offset(0.4)).collect()).collect();
    let influences = most_influences.map(|most| {
        let (mut offsets, mut joints, mut all_weights) = (vec![0], Vec::new(), Vec::new());
        for vertex in 0..vertices {
            // Weights need not lie between 0 and 1, nor sum to 1.
            let scale = [1.0, 1.0, 2.5, -0.75][vertex % 4];
            let count = random.below(most + 1);
            let weights: Vec<_> = (0..count).map(|_| random.between(0.0, 1.0)).collect();
            let sum: f32 = weights.iter().sum();
            joints.extend((0..count).map(|_| random.below(12) as u32));
            all_weights.extend(weights.iter().map(|weight| scale * weight / sum));
            offsets.push(joints.len() as u32);
        }
        Influences::new(offsets, joints, all_weights).expect("the offsets rise")
    });
    let mut source_vertices: Vec<u32> = (0..vertices as u32).map(|v| 3 * v + 1).collect();
    random.shuffle(&mut source_vertices);
    let faces = (0..vertices as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let options = GeometryOptions { name: None, morph_targets, influences, source_vertices: Some(source_vertices) };
    Geometry::new(positions, faces, options).expect("one entry a vertex")
}

/// One geometry rigid, one skinned, one with morph targets, one with everything, and a triangle with a target and with
/// vertices that no joint influences; some of them with several instances.
pub fn random_model(random: &mut Random, vertices: usize) -> Model {
    let geometries = vec![
        random_geometry(random, vertices, None, 0),
        random_geometry(random, vertices / 2 + 3, Some(4), 0),
        random_geometry(random, vertices / 3 + 3, None, 5),
        random_geometry(random, vertices + 1, Some(9), 3),
        random_geometry(random, 3, Some(0), 1),
    ];
    let instances = [3, 0, 1, 2, 3, 4, 0].map(|geometry| Instance::new(geometry, None));
    Model::new(geometries, instances.to_vec()).expect("there are five geometries")
}

/// Random matrices; morph weights zero, small, negative or large.
pub fn random_pose(random: &mut Random, model: &Model) -> Pose {
    let instances = model.placed_geometries().map(|geometry| {
        let palette: Vec<_> = (0..geometry.joints_needed()).map(|_| random_matrix(random)).collect();
        let weights = geometry.morph_targets().iter();
        let weights = weights
            .map(|_| [0.0, -0.0, random.between(-1.0, 1.0), random.between(0.0, 9.0)][random.below(4)])
            .collect();
        InstancePose::new(palette, weights).expect("all is finite").with_faces_turned(false)
    });
    Pose::new(instances.collect())
}

/// A closed tube along x of five joints, each of which bends what comes after it, and its pose at a time.
pub fn bending_tube() -> (Model, impl Fn(f32) -> Pose) {
    const RINGS: u32 = 40;
    const SEGMENTS: u32 = 16;
    const JOINTS: u32 = 5;
    const HALF: f32 = 1.4;
    let (mut offsets, mut joints, mut weights) = (vec![0], Vec::new(), Vec::new());
    let mut positions = Vec::new();
    let mut vertex = |along: f32, radius: f32, turn: f32| {
        positions.push([HALF * (2.0 * along - 1.0), radius * turn.cos(), radius * turn.sin()]);
        let at = along * (JOINTS - 1) as f32;
        let joint = (at as u32).min(JOINTS - 2);
        joints.extend([joint, joint + 1]);
        weights.extend([1.0 - (at - joint as f32), at - joint as f32]);
        offsets.push(joints.len() as u32);
    };
    for ring in 0..RINGS {
        for segment in 0..SEGMENTS {
            let turn = segment as f32 / SEGMENTS as f32 * std::f32::consts::TAU;
            vertex(ring as f32 / (RINGS - 1) as f32, 0.3, turn);
        }
    }
    // The middles of both ends.
    vertex(0.0, 0.0, 0.0);
    vertex(1.0, 0.0, 0.0);
    let [first, last] = [RINGS * SEGMENTS, RINGS * SEGMENTS + 1];
    let mut faces = Vec::new();
    for segment in 0..SEGMENTS {
        let next = (segment + 1) % SEGMENTS;
        for ring in (0..RINGS - 1).map(|ring| ring * SEGMENTS) {
            let [a, b] = [ring + segment, ring + next];
            faces.extend([[a, b, b + SEGMENTS], [a, b + SEGMENTS, a + SEGMENTS]]);
        }
        let end = (RINGS - 1) * SEGMENTS;
        faces.extend([[first, next, segment], [last, end + segment, end + next]]);
    }
    let influences = Influences::new(offsets, joints, weights).expect("two joints a vertex");
    let options = GeometryOptions { influences: Some(influences), ..GeometryOptions::default() };
    let geometry = Geometry::new(positions, faces, options).expect("indices are in range");
    let pose = |time: f32| {
        let mut sum = Affine3A::IDENTITY;
        let palette = (0..JOINTS).map(|joint| {
            let at = Vec3::X * HALF * (2.0 * joint as f32 / (JOINTS - 1) as f32 - 1.0);
            let turn = Quat::from_euler(EulerRot::XYZ, 0.0, 0.6 * (time + joint as f32).sin(), 0.5 * time.cos());
            sum *= Affine3A::from_translation(at) * Affine3A::from_quat(turn) * Affine3A::from_translation(-at);
            sum
        });
        Pose::new(vec![InstancePose::new(palette, Vec::new()).expect("all is finite")])
    };
    (Model::new(vec![geometry], vec![Instance::new(0, None)]).expect("there is one geometry"), pose)
}
