//! The lights of a file at one time.

use crate::light::Light;

/// The kind of a light in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SceneLightKind {
    /// A light at infinity.
    Directional,
    /// A light at a point that shines to all sides.
    Point,
    /// A light at a point that shines in a cone.
    Spot,
}

/// A light of the file at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// The name of the light, or that of its node.
    pub name: Option<String>,
    /// The light in world space, relative to [`Asset::origin`](super::Asset::origin), without a range. A point or spot light has the node's position and w = 1. A
    /// directional light has the node's +Z at length 1 and w = 0: it shines along −Z, and [`Light`] points towards the
    /// light.
    pub light: Light,
    /// The kind of the light.
    pub kind: SceneLightKind,
    /// Red, green and blue, linear.
    pub color: [f32; 3],
    /// In candela for a point or spot light, in lux for a directional one.
    pub intensity: f32,
    /// The distance where a point or spot light ends, in the unit of the file. Nodes do not scale it. `None`: it does
    /// not end.
    pub range: Option<f32>,
    /// The cone of a spot light. `None` for other lights, and for a node without extent along Z.
    pub cone: Option<SpotCone>,
}

/// The cone of a spot light. It shines fully within the inner angle and not at all beyond the outer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotCone {
    /// The direction in which it shines, in world space, at length 1: the node's −Z.
    pub direction: [f32; 3],
    /// The angle from the direction to where the light begins to fade, in radians.
    pub inner_angle: f32,
    /// The angle from the direction to where the light has faded, in radians. It is at least the inner angle.
    pub outer_angle: f32,
}
