//! Skinned figures that walk.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec3};
use rimline::{Geometry, GeometryOptions, Influences, InstancePose, ModelError, Pose};

use crate::shapes::{self, Shape};

const SPEED: f32 = 1.25;
const STEPS: f32 = 0.9;
const FRAMES: f32 = 30.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct Walker {
    pub(super) at: Vec3,
    /// About +Y, from +Z.
    pub(super) heading: f32,
    /// How far into its cycle it begins.
    pub(super) phase: f32,
}

/// All walkers after so many frames.
pub(super) fn pose(walkers: &[Walker], frame: usize) -> Result<Pose, ModelError> {
    let seconds = frame as f32 / FRAMES;
    let pose = |walker: &Walker| {
        let turn = Quat::from_rotation_y(walker.heading);
        let at = walker.at + turn * Vec3::Z * SPEED * seconds;
        let palette = joints(walker.phase + STEPS * seconds);
        let transform = Affine3A::from_rotation_translation(turn, at);
        InstancePose::new(palette.map(|joint| transform * joint), Vec::new())
    };
    Ok(Pose::new(walkers.iter().map(pose).collect::<Result<_, _>>()?))
}

/// A ball around this holds a figure that walks.
pub(super) const MIDDLE: Vec3 = Vec3::new(0.0, 0.9, 0.0);
pub(super) const RADIUS: f32 = 1.0;

/// A part of the body: a closed tube from end to end. Its first half moves with the first joint, its second half with the
/// second one.
struct Tube {
    ends: [Vec3; 2],
    radius: f32,
    joints: [u32; 2],
}

/// Joints: the trunk, then for each side thigh, shank, upper arm, forearm.
const JOINTS: usize = 9;
const HIP: f32 = 0.92;
const KNEE: f32 = 0.5;
const SHOULDER: f32 = 1.42;
const ELBOW: f32 = 1.12;
const LEG: f32 = 0.11;
const ARM: f32 = 0.27;
/// Corners around a tube, and rings along it: six tubes have 4,032 faces.
const AROUND: u32 = 16;
const RINGS: u32 = 21;

fn tubes() -> Vec<Tube> {
    let tube = |x: f32, [high, low]: [f32; 2], radius: f32, joints| Tube {
        ends: [Vec3::new(x, high, 0.0), Vec3::new(x, low, 0.0)],
        radius,
        joints,
    };
    let mut tubes = vec![tube(0.0, [1.5, 0.82], 0.19, [0, 0]), tube(0.0, [1.78, 1.48], 0.11, [0, 0])];
    for (side, first) in [(1.0, 1), (-1.0, 5)] {
        tubes.push(tube(side * LEG, [HIP + 0.08, 0.02], 0.085, [first, first + 1]));
        tubes.push(tube(side * ARM, [SHOULDER + 0.06, 0.8], 0.055, [first + 2, first + 3]));
    }
    tubes
}

/// The figure at rest, facing +Z.
pub(super) fn walker_mesh() -> Result<Geometry, ModelError> {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    let (mut offsets, mut joints, mut weights) = (vec![0], Vec::new(), Vec::new());
    for Tube { ends, radius, joints: [upper, lower] } in tubes() {
        let Shape { positions: around, faces: between } = shapes::globe(AROUND, RINGS + 1);
        let first = positions.len() as u32;
        // Y and Z change roles, which turns faces around.
        faces.extend(between.iter().map(|[a, b, c]| [a, c, b].map(|vertex| first + vertex)));
        for [x, y, z] in around {
            let along = z.acos() / PI;
            let round = (1.0 - (2.0 * along - 1.0).abs().powi(5)).sqrt();
            let at = ends[0].lerp(ends[1], along) + radius * round * Vec3::new(x, 0.0, y).normalize_or_zero();
            positions.push(at.to_array());
            // It bends within a fifth of its length.
            let share = ((along - 0.5) / 0.2 + 0.5).clamp(0.0, 1.0);
            joints.extend([upper, lower]);
            weights.extend([1.0 - share, share]);
            offsets.push(joints.len() as u32);
        }
    }
    let influences = Some(Influences::new(offsets, joints, weights)?);
    Geometry::new(positions, faces, GeometryOptions { influences, ..GeometryOptions::default() })
}

/// Where the joints take the figure at a part of a cycle.
fn joints(phase: f32) -> [Affine3A; JOINTS] {
    let mut joints = [Affine3A::IDENTITY; JOINTS];
    // A turn about an axis across the body. Forward is a negative angle.
    let turn = |height: f32, angle: f32| {
        let at = Vec3::Y * height;
        Affine3A::from_translation(at) * Affine3A::from_rotation_x(angle) * Affine3A::from_translation(-at)
    };
    joints[0] = Affine3A::from_translation(0.02 * (2.0 * TAU * phase).cos() * Vec3::Y);
    for (first, phase) in [(1, phase), (5, phase + 0.5)] {
        let swing = (TAU * phase).sin();
        joints[first] = joints[0] * turn(HIP, -0.45 * swing);
        joints[first + 1] = joints[first] * turn(KNEE, 0.35 + 0.35 * (TAU * phase).cos());
        joints[first + 2] = joints[0] * turn(SHOULDER, 0.4 * swing);
        joints[first + 3] = joints[first + 2] * turn(ELBOW, -0.3);
    }
    joints
}

#[cfg(test)]
mod tests {
    use rimline::cpu::{Threads, deform};
    use rimline::{Instance, Model};

    use super::*;

    #[test]
    fn a_ball_holds_a_walker() {
        let geometry = walker_mesh().expect("a figure");
        assert_eq!(geometry.faces().len(), 4032);
        let model = Model::new(vec![geometry], vec![Instance::new(0, None)]).expect("a model");
        let walker = Walker { at: Vec3::X, heading: 2.0, phase: 0.3 };
        for frame in 0..40 {
            let pose = pose(&[walker], frame).expect("a pose");
            let positions = deform(&model, &pose, 0.0, None, Threads::default()).expect("it fits");
            let at = walker.at + Quat::from_rotation_y(walker.heading) * Vec3::Z * SPEED * frame as f32 / FRAMES;
            let is_in = |&position: &[f32; 3]| (Vec3::from(position) - at - MIDDLE).length() < RADIUS;
            assert!(positions.iter().all(is_in), "frame {frame}");
        }
    }
}
