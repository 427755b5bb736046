//! The camera of a picture.

use glam::{DQuat, Mat4, Vec3, Vec4};
use rimline::{DepthDirection, ShadowCamera};

/// A right-handed perspective camera with an infinite far plane and reversed depth, `near / distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The position of the eye in world space.
    pub eye: Vec3,
    /// To the right of the picture; of length 1, like the next two.
    pub right: Vec3,
    /// To its top.
    pub up: Vec3,
    /// Into it.
    pub forward: Vec3,
    /// Clip units per unit of view space at distance 1.
    pub scale: [f32; 2],
    /// The distance of the near plane.
    pub near: f32,
}

impl Camera {
    /// The camera with positions relative to the eye, so that models far from the origin keep their precision.
    pub fn shadow_camera(&self) -> ShadowCamera {
        let rows = [
            (self.scale[0] * self.right).extend(0.0),
            (self.scale[1] * self.up).extend(0.0),
            Vec4::new(0.0, 0.0, 0.0, self.near),
            self.forward.extend(0.0),
        ];
        let [x, y, z, w] = rows;
        ShadowCamera {
            view_projection: Mat4::from_cols(x, y, z, w).transpose().to_cols_array_2d(),
            origin: self.eye.into(),
            depth: DepthDirection::Reversed,
        }
    }

    /// The same camera, turned by degrees about a vertical axis, seen from above against the clock.
    #[must_use]
    pub fn turned(&self, axis: Vec3, degrees: f64) -> Self {
        let turn = |v: Vec3| (DQuat::from_rotation_y(degrees.to_radians()) * v.as_dvec3()).as_vec3();
        Self {
            eye: axis + turn(self.eye - axis),
            right: turn(self.right),
            up: turn(self.up),
            forward: turn(self.forward),
            ..*self
        }
    }
}
