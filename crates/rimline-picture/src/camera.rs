//! The camera of a picture.

use glam::{DQuat, Mat4, Vec3, Vec4};
use rimline::{DepthDirection, Light, ShadowCamera};

use crate::bounds::SceneBounds;

/// A right-handed camera with reversed depth. A perspective one has an infinite far plane and depth `near / distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The position of the eye in world space.
    pub eye: Vec3,
    /// To the right of the picture. This and the next two have length 1 and are at right angles.
    pub right: Vec3,
    /// To its top.
    pub up: Vec3,
    /// Into it.
    pub forward: Vec3,
    /// Clip units per unit of view space, of a perspective camera at distance 1. Above 0.
    pub scale: [f32; 2],
    /// The distance of the near plane, above 0 for a perspective camera.
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

    /// A near plane for a perspective camera, before the models, which begin `nearest` ahead, and before the ground that is
    /// seen. A far one makes depth fine. It may cut what is nearer than a thousandth of the models' extent if `nearest` is 0
    /// or less, and otherwise what is nearer than a millionth of `nearest` or a billionth of the extent.
    pub fn near_plane(&self, bounds: &SceneBounds, nearest: f32) -> f32 {
        let height = self.eye.y - bounds.ground;
        let extent = bounds.models.extent();
        let least = 1e-3 * extent;
        // How far the picture's steepest ray falls while it goes a distance of 1 ahead. It meets the ground first.
        let steepest = self.right.y.abs() / self.scale[0] + self.up.y.abs() / self.scale[1] - self.forward.y;
        let most = if height > 0.0 { 0.2 * height * (4.5 / steepest.max(4.5)) } else { f32::INFINITY };
        let wanted = if nearest > 0.0 { (0.5 * nearest).min(0.05 * (nearest + extent)) } else { least };
        // However near the ground or a model is, depths stay in the range of floats.
        wanted.min(most).max(1e-6 * nearest.max(least))
    }

    /// The same camera, if it is orthographic with a far plane no farther than needed: depth is coarse where that plane is
    /// far beyond all that is seen. `beyond`: how far behind the models, and behind the ground below their middle, anything
    /// is seen, in extents of the models.
    #[must_use]
    pub fn with_nearer_far_plane(&self, bounds: &SceneBounds, beyond: f32) -> Self {
        let models = bounds.models;
        let ahead = |point: Vec3| (point - self.eye).dot(self.forward);
        let under = ahead(models.centre().with_y(bounds.ground));
        let farthest = models.corners().map(ahead).into_iter().fold(under.max(0.0), f32::max);
        // From far away distances round by more than the extent.
        let end = (farthest + beyond * models.extent()).max(1.000_01 * farthest).max(2.0 * self.near);
        Self { far: self.far.map(|far| far.min(end)), ..*self }
    }

    /// The eye as a light, at infinity for an orthographic camera.
    pub fn eye_light(&self) -> Light {
        self.far.map_or(Light::point(self.eye.into()), |_| Light::directional((-self.forward).into()))
    }

    /// The eye; for an orthographic camera a point behind it, 10,000 times as far away as the far plane. Rays from there are
    /// about parallel, unless the picture is much wider than the far plane is away.
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

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::bounds::Bounds;

    #[test]
    fn the_ground_that_is_seen_is_beyond_the_near_plane() {
        let models = Bounds { min: Vec3::new(-15.0, 0.0, -15.0), max: Vec3::new(15.0, 9.0, 15.0) };
        let (bounds, eye) = (SceneBounds { models, ground: 0.0 }, Vec3::new(0.0, 1.5, 25.0));
        let angles = [-40.0_f32, 0.0, 5.0, 20.0, 45.0, 90.0];
        for (down, aside) in angles.into_iter().flat_map(|down| angles.map(|aside| (down, aside))) {
            let turn = Quat::from_rotation_x(-down.to_radians()) * Quat::from_rotation_z(aside.to_radians());
            let [right, up, forward] = [Vec3::X, Vec3::Y, Vec3::NEG_Z].map(|axis| turn * axis);
            for fov in [35.0_f32, 120.0, 150.0, 160.0, 170.0, 179.0] {
                let scale_y = (0.5 * fov.to_radians()).tan().recip();
                let scale = [0.75 * scale_y, scale_y];
                let near = Camera { eye, right, up, forward, scale, near: 1.0, far: None }.near_plane(&bounds, 10.0);
                for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
                    let ray = forward + x / scale[0] * right + y / scale[1] * up;
                    assert!(eye.y + near * ray.y > 0.0, "{fov}°, {down}° down, {aside}° aside: {near}");
                }
            }
        }
    }

    #[test]
    fn a_far_plane_is_no_farther_than_what_is_seen() {
        let bounds = SceneBounds { models: Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE }, ground: -20.0 };
        for (near, far, forward, expected) in [
            (0.5, 12.0, Vec3::NEG_Z, 12.0),
            (0.5, 1e9, Vec3::NEG_Z, 15.0),
            (0.5, 1e9, Vec3::NEG_Y, 24.0),
            // It looks away.
            (0.0, f32::MAX, Vec3::Z, 4.0),
            (7.0, 1e9, Vec3::Z, 14.0),
        ] {
            let (eye, right, up) = (Vec3::new(0.0, 0.0, 10.0), Vec3::X, Vec3::X.cross(forward));
            let camera = Camera { eye, right, up, forward, scale: [1.0; 2], near, far: Some(far) };
            let found = camera.with_nearer_far_plane(&bounds, 2.0);
            assert_eq!(found, Camera { far: Some(expected), ..camera });
            assert_eq!(found.shadow_camera().check(), Ok(()));
        }
        for distance in [1e8, 1e20] {
            let eye = Vec3::new(0.0, 0.0, distance);
            let (right, up, forward) = (Vec3::X, Vec3::Y, Vec3::NEG_Z);
            let camera = Camera { eye, right, up, forward, scale: [1.0; 2], near: 0.5, far: Some(f32::MAX) };
            assert!(camera.with_nearer_far_plane(&bounds, 2.0).far > Some(distance + 1.0), "{distance}");
        }
    }
}
