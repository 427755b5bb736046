//! State of nodes at one time: their transforms and morph weights, as animations set them.

use std::collections::HashMap;

use glam::{DAffine3, DQuat, DVec3};
use gltf::json::animation::Property;

use super::animation::Channel;
use super::document::Transform;
use crate::model::Matrix3x4;

/// World matrices and morph weights of the nodes at one time.
pub(super) struct State {
    pub(super) world: Vec<DAffine3>,
    /// Only for nodes whose weights an animation moves.
    pub(super) weights: HashMap<usize, Vec<f64>>,
}

/// Sets the property that a channel moves.
pub(super) fn apply(
    channel: &Channel,
    time: f64,
    transforms: &mut [Transform],
    weights: &mut HashMap<usize, Vec<f64>>,
) {
    let value = channel.curve.sample(time, channel.property == Property::Rotation);
    if channel.property == Property::MorphTargetWeights {
        weights.insert(channel.node, value);
        return;
    }
    // An animation that moves a node with a matrix is at fault, and is not played.
    let Transform::Trs(trs) = &mut transforms[channel.node] else {
        return;
    };
    match (channel.property, &value[..]) {
        (Property::Translation, &[x, y, z]) => trs.translation = DVec3::new(x, y, z),
        (Property::Scale, &[x, y, z]) => trs.scale = DVec3::new(x, y, z),
        (Property::Rotation, &[x, y, z, w]) => trs.rotation = DQuat::from_xyzw(x, y, z, w),
        _ => {}
    }
}

/// The name of a property, as a channel's path has it.
pub(super) fn property_name(property: Property) -> &'static str {
    match property {
        Property::Translation => "translation",
        Property::Rotation => "rotation",
        Property::Scale => "scale",
        Property::MorphTargetWeights => "weights",
    }
}

/// The rows of the matrix, rounded to `f32`.
pub(super) fn rows(matrix: &DAffine3) -> Matrix3x4 {
    let DAffine3 { matrix3, translation } = matrix;
    [0, 1, 2]
        .map(|row| [matrix3.x_axis[row], matrix3.y_axis[row], matrix3.z_axis[row], translation[row]].map(|c| c as f32))
}
