//! The joints.

use glam::Vec3;

/// A joint at rest: no rotation of its own, only a position.
pub struct Joint {
    /// The node's name.
    pub name: &'static str,
    /// Index of the joint it hangs on, lower than its own.
    pub parent: Option<usize>,
    /// Its position in the figure's space.
    pub at: Vec3,
}

pub const HIPS: usize = 0;
pub const SPINE: usize = 1;
pub const CHEST: usize = 2;
pub const NECK: usize = 3;
pub const HEAD: usize = 4;
// Bones of the left side; see `on`.
pub const UPPER_ARM: usize = 5;
pub const LOWER_ARM: usize = 6;
pub const HAND: usize = 7;
pub const UPPER_LEG: usize = 8;
pub const LOWER_LEG: usize = 9;
pub const FOOT: usize = 10;
pub const TOES: usize = 11;

/// Left is +X: the figure faces +Z.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
}

impl Side {
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// +1 left, −1 right.
    pub fn sign(self) -> f32 {
        if self == Self::Left { 1.0 } else { -1.0 }
    }

    /// A point of the left side, on this side.
    pub fn mirror(self, point: Vec3) -> Vec3 {
        Vec3::new(point.x * self.sign(), point.y, point.z)
    }
}

/// A joint of the left side, on this side.
pub fn on(side: Side, joint: usize) -> usize {
    if side == Side::Left { joint } else { joint + TOES - HEAD }
}

/// Which side a joint belongs to, if any.
pub fn side_of(joint: usize) -> Option<Side> {
    match joint {
        HIPS..=HEAD => None,
        UPPER_ARM..=TOES => Some(Side::Left),
        _ => Some(Side::Right),
    }
}

const fn joint(name: &'static str, parent: usize, at: [f32; 3]) -> Joint {
    Joint { name, parent: Some(parent), at: Vec3::from_array(at) }
}

/// Every joint, parents first.
pub const JOINTS: [Joint; 19] = [
    Joint { name: "hips", parent: None, at: Vec3::new(0.0, 0.95, 0.0) },
    joint("spine", HIPS, [0.0, 1.07, 0.0]),
    joint("chest", SPINE, [0.0, 1.21, -0.01]),
    joint("neck", CHEST, [0.0, 1.46, -0.015]),
    joint("head", NECK, [0.0, 1.55, 0.0]),
    joint("upper_arm.L", CHEST, [0.172, 1.4, -0.015]),
    joint("lower_arm.L", 5, [0.352, 1.185, -0.02]),
    joint("hand.L", 6, [0.512, 0.994, 0.005]),
    joint("upper_leg.L", HIPS, [0.09, 0.9, 0.0]),
    joint("lower_leg.L", 8, [0.1, 0.5, 0.005]),
    joint("foot.L", 9, [0.105, 0.09, -0.025]),
    joint("toes.L", 10, [0.115, 0.03, 0.1]),
    joint("upper_arm.R", CHEST, [-0.172, 1.4, -0.015]),
    joint("lower_arm.R", 12, [-0.352, 1.185, -0.02]),
    joint("hand.R", 13, [-0.512, 0.994, 0.005]),
    joint("upper_leg.R", HIPS, [-0.09, 0.9, 0.0]),
    joint("lower_leg.R", 15, [-0.1, 0.5, 0.005]),
    joint("foot.R", 16, [-0.105, 0.09, -0.025]),
    joint("toes.R", 17, [-0.115, 0.03, 0.1]),
];
