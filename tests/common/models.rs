//! Deformable models made by code.

use rimline::glam::{Affine3A, EulerRot, Quat, Vec3};
use rimline::model::Matrix3x4;
use rimline::{Geometry, Influences, Instance, InstancePose, Model, Pose};

use super::random::Random;

/// The row-major rows of a transform.
pub(crate) fn rows(transform: Affine3A) -> Matrix3x4 {
    let (m, t) = (transform.matrix3.transpose(), transform.translation);
    let row = |axis: rimline::glam::Vec3A, t: f32| [axis.x, axis.y, axis.z, t];
    [row(m.x_axis, t.x), row(m.y_axis, t.y), row(m.z_axis, t.z)]
}

pub(crate) fn random_matrix(random: &mut Random) -> Matrix3x4 {
    let scale = Vec3::from([0; 3].map(|_| random.between(-2.0, 2.0)));
    let turn = [0; 3].map(|_| random.between(-3.0, 3.0));
    let turn = Quat::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]);
    let translation = Vec3::from([0; 3].map(|_| random.between(-5.0, 5.0)));
    rows(Affine3A::from_scale_rotation_translation(scale, turn, translation))
}

/// `most_influences` joints a vertex at most, or rigid; `targets` morph targets; source vertices in a scrambled order.
pub(crate) fn random_geometry(
    random: &mut Random,
    vertices: usize,
    most_influences: Option<usize>,
    targets: usize,
) -> Geometry {
    let mut offset = |scale: f32| random.direction().map(|c| c * scale);
    let positions: Vec<_> = (0..vertices).map(|_| offset(1.5)).collect();
    let morph_targets = (0..targets).map(|_| (0..vertices).map(|_| offset(0.4)).collect()).collect();
    let influences = most_influences.map(|most| {
        let mut influences = Influences { offsets: vec![0], ..Default::default() };
        for _ in 0..vertices {
            let count = random.below(most + 1);
            let weights: Vec<_> = (0..count).map(|_| random.between(0.0, 1.0)).collect();
            let sum: f32 = weights.iter().sum();
            influences.joints.extend((0..count).map(|_| random.below(12) as u32));
            influences.weights.extend(weights.iter().map(|weight| weight / sum));
            influences.offsets.push(influences.joints.len() as u32);
        }
        influences
    });
    let mut source_vertices: Vec<u32> = (0..vertices as u32).map(|v| 3 * v + 1).collect();
    random.shuffle(&mut source_vertices);
    Geometry {
        name: None,
        faces: (0..vertices as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
        positions,
        morph_targets,
        influences,
        source_vertices,
    }
}

/// One geometry rigid, one skinned, one with morph targets, one with everything; some of them at several places.
pub(crate) fn random_model(random: &mut Random, vertices: usize) -> Model {
    let geometries = vec![
        random_geometry(random, vertices, None, 0),
        random_geometry(random, vertices / 2 + 3, Some(4), 0),
        random_geometry(random, vertices / 3 + 3, None, 5),
        random_geometry(random, vertices + 1, Some(9), 3),
        random_geometry(random, 3, Some(0), 1),
    ];
    let instances = [3, 0, 1, 2, 3, 4, 0].map(|geometry| Instance { geometry, name: None });
    Model { geometries, instances: instances.to_vec() }
}

/// Random matrices; morph weights zero, small, negative or large.
pub(crate) fn random_pose(random: &mut Random, model: &Model) -> Pose {
    let instances = model.instances.iter().map(|instance| {
        let geometry = &model.geometries[instance.geometry];
        let palette = (0..geometry.joints_needed()).map(|_| random_matrix(random)).collect();
        let weights = geometry.morph_targets.iter();
        InstancePose {
            palette,
            morph_weights: weights
                .map(|_| [0.0, -0.0, random.between(-1.0, 1.0), random.between(0.0, 9.0)][random.below(4)])
                .collect(),
            turned: false,
        }
    });
    Pose { instances: instances.collect(), mixed_determinants: 0 }
}
