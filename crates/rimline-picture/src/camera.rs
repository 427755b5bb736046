//! The camera of a picture.

use glam::{DQuat, Mat4, Vec3, Vec4};
use rimline::{DepthDirection, Light, ShadowCamera};

use crate::bounds::SceneBounds;

/// A right-handed camera with reversed depth. A perspective one has an infinite far plane and depth `near / distance`.
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
    /// Clip units per unit of view space, of a perspective camera at distance 1.
    pub scale: [f32; 2],
    /// The distance of the near plane.
    pub near: f32,
    /// The distance of the far plane of an orthographic camera. `None`: it is perspective.
    pub far: Option<f32>,
}

impl Camera {
    /// The camera with positions relative to the eye, so that models far from the origin keep their precision.
    pub fn shadow_camera(&self) -> ShadowCamera {
        let [x, y] = [self.scale[0] * self.right, self.scale[1] * self.up].map(|row| row.extend(0.0));
        let [z, w] = match self.far {
            None => [Vec4::new(0.0, 0.0, 0.0, self.near), self.forward.extend(0.0)],
            Some(far) => [(-self.forward).extend(far) / (far - self.near), Vec4::W],
        };
        ShadowCamera {
            view_projection: Mat4::from_cols(x, y, z, w).transpose().to_cols_array_2d(),
            origin: self.eye.into(),
            depth: DepthDirection::Reversed,
        }
    }

    /// A near plane as far away as the models, the nearest of which are so far ahead, and the ground below the eye allow:
    /// depth is then finest.
    pub fn near_plane(&self, bounds: &SceneBounds, nearest: f32) -> f32 {
        let height = self.eye.y - bounds.ground;
        let extent = bounds.models.extent();
        let least = 1e-3 * extent;
        let most = if height > 0.0 { 0.2 * height } else { f32::INFINITY };
        let wanted = if nearest > 0.0 { (0.5 * nearest).min(0.05 * (nearest + extent)) } else { least };
        // So far away that the extent is lost beside the distance, the distance alone counts.
        wanted.min(most).max(1e-6 * nearest.max(least))
    }

    /// The eye as a light, at infinity for an orthographic camera.
    pub fn eye_light(&self) -> Light {
        self.far.map_or(Light::point(self.eye.into()), |_| Light::directional((-self.forward).into()))
    }

    /// The eye; for an orthographic camera a point so far before its near plane that rays from there are about parallel.
    pub fn distant_eye(&self) -> Vec3 {
        self.eye - self.far.map_or(Vec3::ZERO, |far| 1e4 * far * self.forward)
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
