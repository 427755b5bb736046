//! A walk on the spot, one cycle of two steps that ends as it began.
//!
//! Joint angles over the cycle follow the usual curves of gait analysis, smoothed and a little enlarged.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec3};

use super::skeleton::{
    CHEST, FOOT, HAND, HEAD, HIPS, JOINTS, LOWER_ARM, LOWER_LEG, NECK, SPINE, Side, TOES, UPPER_ARM, UPPER_LEG, on,
};

/// Seconds a cycle.
pub const DURATION: f32 = 1.1;
/// Poses a cycle in the file, the last like the first.
pub const KEYS: usize = 25;

/// The joints' rotations against their rest, and where the hips are.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    pub rotations: [Quat; JOINTS.len()],
    pub hips: Vec3,
}

// Degrees at every tenth of a cycle, which begins as the leg's own heel strikes. The hip's are forward, the knee's
// back, the ankle's and the toes' up.
const HIP: [f32; 10] = [27.0, 23.0, 13.0, 2.0, -8.0, -14.0, -7.0, 13.0, 27.0, 30.0];
const KNEE: [f32; 10] = [6.0, 17.0, 15.0, 8.0, 7.0, 18.0, 43.0, 60.0, 45.0, 13.0];
const ANKLE: [f32; 10] = [3.0, -4.0, 3.0, 7.0, 9.0, 1.0, -17.0, -9.0, 2.0, 5.0];
const TOE: [f32; 10] = [10.0, 1.0, 0.0, 0.0, 6.0, 24.0, 20.0, 4.0, 0.0, 6.0];

/// How far the arms come down from their rest, in degrees.
const ARMS_DOWN: f32 = 31.0;
/// How far the trunk leans forward, in degrees.
const LEAN: f32 = 4.0;

/// The key poses.
pub fn keys() -> [Pose; KEYS] {
    std::array::from_fn(|key| pose(phase(key % (KEYS - 1))))
}

/// How far a key pose is into the cycle, from 0 to 1.
pub fn phase(key: usize) -> f32 {
    key as f32 / (KEYS - 1) as f32
}

/// The pose at `phase` of the cycle, from 0 to 1; the left heel strikes at 0.
pub fn pose(phase: f32) -> Pose {
    let mut pose = joints_turned(phase);
    pose.hips.y += ground_offset(phase);
    pose
}

/// The joints' matrices: from rest, each in the figure's space, to the figure's space as posed.
pub fn from_rest(pose: &Pose) -> [Affine3A; JOINTS.len()] {
    let mut globals = [Affine3A::IDENTITY; JOINTS.len()];
    for (index, joint) in JOINTS.iter().enumerate() {
        globals[index] = match joint.parent {
            None => Affine3A::from_rotation_translation(pose.rotations[index], pose.hips),
            Some(parent) => globals[parent] * Affine3A::from_rotation_translation(pose.rotations[index], offset(index)),
        };
    }
    std::array::from_fn(|index| globals[index] * Affine3A::from_translation(-JOINTS[index].at))
}

/// A joint's position from its parent's at rest.
pub fn offset(joint: usize) -> Vec3 {
    let Some(parent) = JOINTS[joint].parent else {
        return JOINTS[joint].at;
    };
    JOINTS[joint].at - JOINTS[parent].at
}

fn joints_turned(phase: f32) -> Pose {
    let mut pose = Pose { rotations: [Quat::IDENTITY; JOINTS.len()], hips: JOINTS[HIPS].at };
    // 1 as the left leg is foremost, −1 as the right one is; and 1 as the left leg alone carries.
    let stride = (TAU * (phase + 0.05)).cos();
    let stance = (TAU * (phase - 0.25)).cos();
    pose.hips.x = 0.014 * stance;
    // The pelvis goes with the foremost leg and sinks on the side of the swinging one; the chest answers.
    pose.rotations[HIPS] = turned([LEAN * 0.4, -5.0 * stride, 3.0 * stance]);
    pose.rotations[SPINE] = turned([LEAN * 0.3, 5.0 * stride, -2.5 * stance]);
    pose.rotations[CHEST] = turned([LEAN * 0.3, 6.0 * stride, -1.5 * stance]);
    pose.rotations[NECK] = turned([-LEAN * 0.4, -3.0 * stride, 0.5 * stance]);
    pose.rotations[HEAD] = turned([-LEAN * 0.5, -3.0 * stride, 0.5 * stance]);
    for side in Side::BOTH {
        turn_leg(&mut pose, side, if side == Side::Left { phase } else { phase + 0.5 });
        // The legs do not follow the pelvis' turn and tilt.
        let hips = turned([0.0, -5.0 * stride, 3.0 * stance]);
        let leg = &mut pose.rotations[on(side, UPPER_LEG)];
        *leg = hips.inverse() * *leg;
        turn_arm(&mut pose, side, -side.sign() * stride);
    }
    pose
}

fn turn_leg(pose: &mut Pose, side: Side, phase: f32) {
    let about_x = |degrees: f32| turned([degrees, 0.0, 0.0]);
    // Turned out a little, as feet are.
    pose.rotations[on(side, UPPER_LEG)] = turned([-curve(&HIP, phase), 4.0 * side.sign(), 0.0]);
    pose.rotations[on(side, LOWER_LEG)] = about_x(curve(&KNEE, phase));
    pose.rotations[on(side, FOOT)] = about_x(-curve(&ANKLE, phase));
    pose.rotations[on(side, TOES)] = about_x(-curve(&TOE, phase));
}

/// `swing` is 1 with the arm foremost, −1 with it hindmost.
fn turn_arm(pose: &mut Pose, side: Side, swing: f32) {
    let lower = turned([0.0, 0.0, -ARMS_DOWN * side.sign()]);
    // The elbow bends about an axis across the body as the arm hangs; at rest that axis is tilted with the arm.
    let hanging = |bend: Quat| lower.inverse() * bend * lower;
    pose.rotations[on(side, UPPER_ARM)] = turned([2.0 - 22.0 * swing, 0.0, 0.0]) * lower;
    let inwards = turned([0.0, -14.0 * side.sign(), 0.0]);
    pose.rotations[on(side, LOWER_ARM)] = hanging(inwards * turned([-24.0 - 11.0 * swing, 0.0, 0.0]));
    pose.rotations[on(side, HAND)] = hanging(turned([-6.0 - 4.0 * swing, 0.0, 4.0 * side.sign()]));
}

/// Degrees about X, then Y, then Z as seen from the joint's parent.
fn turned(degrees: [f32; 3]) -> Quat {
    let [x, y, z] = degrees.map(f32::to_radians);
    Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x)
}

/// How far the hips have to rise or sink for the lower foot to stand on the ground, smoothed over the cycle.
fn ground_offset(phase: f32) -> f32 {
    const WINDOW: [f32; 5] = [-0.04, -0.02, 0.0, 0.02, 0.04];
    let sum: f32 = WINDOW.iter().map(|shift| -lowest(phase + shift)).sum();
    sum / WINDOW.len() as f32
}

fn lowest(phase: f32) -> f32 {
    // Where the left sole touches: heel, ball, tip.
    const SOLE: [(usize, Vec3); 3] = [
        (FOOT, Vec3::new(0.105, 0.0, -0.07)),
        (FOOT, Vec3::new(0.114, 0.0, 0.095)),
        (TOES, Vec3::new(0.118, 0.0, 0.175)),
    ];
    let from_rest = from_rest(&joints_turned(phase));
    Side::BOTH
        .into_iter()
        .flat_map(|side| SOLE.map(|(joint, point)| from_rest[on(side, joint)].transform_point3(side.mirror(point)).y))
        .fold(f32::INFINITY, f32::min)
}

/// A smooth periodic curve through the ten values (Catmull and Rom).
fn curve(values: &[f32; 10], phase: f32) -> f32 {
    let key_time = phase.rem_euclid(1.0) * 10.0;
    let first = key_time as usize;
    let t = key_time - first as f32;
    let [a, b, c, d] = [9, 0, 1, 2].map(|step| values[(first + step) % 10]);
    let tangents = [(c - a) / 2.0, (d - b) / 2.0];
    let (bend, turn) = (3.0 * (c - b) - 2.0 * tangents[0] - tangents[1], 2.0 * (b - c) + tangents[0] + tangents[1]);
    b + t * (tangents[0] + t * (bend + t * turn))
}
