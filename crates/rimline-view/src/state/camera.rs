//! The camera: an eye that goes around a target.

use glam::{Vec2, Vec3};
use rimline::gltf::{CameraProjection, SceneCamera};
use rimline_picture::{Bounds, SceneBounds};

/// Degrees to the right of the models' front, which is +Z, and above the ground.
const AZIMUTH: f32 = 33.0;
const ELEVATION: f32 = 20.0;
/// The part of the picture's height or width that the models take at first.
const FILLED: f32 = 0.8;
/// The same for handles of lights.
const FILLED_BY_HANDLES: f32 = 0.93;

/// Where the eye is, as it is steered: around a target, at a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The point that the eye looks at, in world space.
    pub target: Vec3,
    /// Degrees to the right of +Z, from which the eye looks.
    pub azimuth: f32,
    /// Degrees above the horizon, −89 to 89.
    pub elevation: f32,
    /// From the eye to the target.
    pub distance: f32,
    /// The field of view from bottom to top, in degrees.
    pub fov: f32,
}

impl Orbit {
    /// The camera that shows all of a box, and points such as handles of lights, in a picture of this shape, width over
    /// height.
    pub fn showing(bounds: &Bounds, points: &[Vec3], aspect: f32) -> Self {
        let fov = 35.0_f32;
        let mut orbit =
            Self { target: bounds.centre(), azimuth: AZIMUTH, elevation: ELEVATION, distance: bounds.extent(), fov };
        let scale_y = 1.0 / (fov.to_radians() / 2.0).tan();
        let scale = Vec2::new(scale_y / aspect.max(0.01), scale_y);
        let [right, up, forward] = orbit.axes();
        let needed = |point: Vec3, filled: f32| {
            let from = point - orbit.target;
            let sideways = Vec2::new(from.dot(right), from.dot(up)).abs() * scale / filled;
            sideways.max_element() - from.dot(forward)
        };
        let corners = bounds.corners().map(|corner| needed(corner, FILLED)).into_iter();
        let others = points.iter().map(|&point| needed(point, FILLED_BY_HANDLES));
        orbit.distance = corners.chain(others).fold(1e-3 * bounds.extent(), f32::max);
        orbit
    }

    /// The view of a camera of a file on models in `bounds`. It stands upright, looks with perspective, and never
    /// mirrors.
    pub fn of_file(camera: &SceneCamera, bounds: &Bounds) -> Self {
        let (eye, forward) = (Vec3::from(camera.eye), Vec3::from(camera.forward));
        let ahead = (bounds.centre() - eye).dot(forward).max(0.1 * bounds.extent());
        let target = eye + ahead * forward;
        let (fov, distance) = match camera.projection {
            CameraProjection::Perspective { yfov, .. } => (yfov.to_degrees().clamp(1.0, 170.0), ahead),
            // From far away with a narrow field of view, which shows as much.
            CameraProjection::Orthographic { ymag, .. } => (5.0, ymag.abs() / 2.5_f32.to_radians().tan()),
        };
        // Straight up or down, rounding alone decides to which side `forward` points.
        let is_steep = forward.y.abs() > 89_f32.to_radians().sin();
        let ahead_on_level = if is_steep { Vec3::from(camera.up) * -forward.y.signum() } else { forward };
        let azimuth = (-ahead_on_level.x).atan2(-ahead_on_level.z).to_degrees().rem_euclid(360.0);
        let elevation = (-forward.y).clamp(-1.0, 1.0).asin().to_degrees().clamp(-89.0, 89.0);
        Self { target, azimuth, elevation, distance, fov }
    }

    /// Right, up and forward, at right angles, of length 1.
    pub fn axes(&self) -> [Vec3; 3] {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let backward = Vec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos());
        let right = Vec3::new(azimuth.cos(), 0.0, -azimuth.sin());
        [right, backward.cross(right), -backward]
    }

    /// The position of the eye.
    pub fn eye(&self) -> Vec3 {
        self.target - self.distance * self.axes()[2]
    }

    /// Turns around the target, by degrees.
    pub fn turn(&mut self, right: f32, up: f32) {
        self.azimuth = (self.azimuth + right).rem_euclid(360.0);
        self.elevation = (self.elevation + up).clamp(-89.0, 89.0);
    }

    /// Looks around from where the eye is, by degrees: the target moves.
    pub fn look(&mut self, right: f32, up: f32) {
        let eye = self.eye();
        self.turn(-right, -up);
        self.target = eye + self.distance * self.axes()[2];
    }

    /// Moves eye and target: to the right, up and ahead, as the eye sees it.
    pub fn shift(&mut self, by: Vec3) {
        let [right, up, forward] = self.axes();
        self.target += by.x * right + by.y * up + by.z * forward;
    }

    /// Changes the distance by a factor, within a range that depends on the size of the scene.
    pub fn zoom(&mut self, factor: f32, extent: f32) {
        self.distance = (self.distance * factor).clamp(1e-3 * extent, 1e3 * extent);
    }

    /// The camera for a picture of this size, which sees models in `bounds` over a ground at this height.
    pub fn camera(&self, size: [u32; 2], bounds: &Bounds, ground: f32) -> Camera {
        let [right, up, forward] = self.axes();
        let scale_y = 1.0 / (self.fov.to_radians() / 2.0).tan();
        let size = size.map(|side| side.max(1) as f32);
        let scale = [scale_y * size[1] / size[0], scale_y];
        let mut view = rimline_picture::Camera { eye: self.eye(), right, up, forward, scale, near: 1.0, far: None };
        let from_box = (view.eye.clamp(bounds.min, bounds.max) - view.eye).length();
        let ahead = bounds.corners().map(|corner| (corner - view.eye).dot(forward));
        let nearest = ahead.into_iter().fold(f32::INFINITY, f32::min).min(from_box);
        view.near = view.near_plane(&SceneBounds { models: *bounds, ground }, nearest).max(1e-30);
        Camera { view, size: Vec2::from(size) }
    }
}

/// A perspective camera, and the size of its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The camera.
    pub view: rimline_picture::Camera,
    /// Width and height in pixels.
    pub size: Vec2,
}

impl Camera {
    /// The pixel that shows a point, from the upper left corner of the picture. `None` if it is not beyond the near plane.
    pub fn project(&self, point: Vec3) -> Option<Vec2> {
        let view = &self.view;
        let from_eye = point - view.eye;
        let ahead = from_eye.dot(view.forward);
        let ndc = Vec2::new(from_eye.dot(view.right), from_eye.dot(view.up)) * Vec2::from(view.scale) / ahead;
        (ahead > view.near).then(|| (ndc * Vec2::new(0.5, -0.5) + 0.5) * self.size)
    }

    /// The direction from the eye through a pixel, with length 1 along its view.
    pub fn ray(&self, pixel: Vec2) -> Vec3 {
        let view = &self.view;
        let ndc = (pixel / self.size - 0.5) * Vec2::new(2.0, -2.0) / Vec2::from(view.scale);
        ndc.x * view.right + ndc.y * view.up + view.forward
    }

    /// The length of a pixel at a distance ahead of 1.
    pub fn pixel(&self) -> f32 {
        2.0 / (self.view.scale[1] * self.size.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Bounds = Bounds { min: Vec3::new(9.0, 9.0, 9.0), max: Vec3::new(11.0, 11.0, 11.0) };

    #[test]
    fn all_of_a_box_is_seen_at_first() {
        for size in [[900, 300], [300, 900], [1280, 800]] {
            let orbit = Orbit::showing(&BOX, &[], size[0] as f32 / size[1] as f32);
            let camera = orbit.camera(size, &BOX, 9.0);
            for corner in BOX.corners() {
                let pixel = camera.project(corner).expect("it is before the eye");
                assert!(pixel.cmpge(Vec2::ZERO).all() && pixel.cmple(camera.size).all(), "{size:?}: {pixel}");
                let back = camera.view.eye + camera.ray(pixel) * (corner - camera.view.eye).dot(camera.view.forward);
                assert!((back - corner).length() < 1e-3, "{corner} {back}");
            }
        }
    }

    #[test]
    fn a_camera_that_looks_straight_up_or_down_keeps_its_up() {
        for azimuth in [30.0, 150.0, 300.0] {
            let level = Orbit { elevation: 0.0, azimuth, ..Orbit::showing(&BOX, &[], 1.0) }.axes()[2];
            for (forward, up) in [(Vec3::NEG_Y, level), (Vec3::Y, -level)] {
                // Rounding tips it to the other side.
                let forward = (forward - 1e-7 * level).into();
                let projection =
                    CameraProjection::Perspective { yfov: 0.5, aspect_ratio: None, znear: 0.1, zfar: None };
                let camera = SceneCamera { name: None, eye: [10.0, 0.0, 10.0], forward, up: up.into(), projection };
                let found = Orbit::of_file(&camera, &BOX);
                assert!((found.azimuth - azimuth).abs() < 0.01, "{azimuth}: {found:?}");
                assert!(found.axes()[1].dot(up) > 0.99, "{azimuth}: {found:?}");
            }
        }
    }

    #[test]
    fn looking_around_keeps_the_eye_and_turning_keeps_the_target() {
        let mut orbit = Orbit::showing(&BOX, &[], 1.0);
        let (eye, target) = (orbit.eye(), orbit.target);
        orbit.turn(50.0, 20.0);
        assert_eq!(orbit.target, target);
        orbit.turn(-50.0, -20.0);
        orbit.look(10.0, -7.0);
        assert!((orbit.eye() - eye).length() < 1e-4 && (orbit.target - target).length() > 0.1);
    }

    #[test]
    fn shadow_volumes_can_be_drawn_from_everywhere() {
        for elevation in [-89.0, 0.0, 89.0] {
            let mut orbit = Orbit { elevation, ..Orbit::showing(&BOX, &[], 1.6) };
            for _ in 0..2 {
                assert_eq!(orbit.camera([1280, 800], &BOX, 9.0).view.shadow_camera().check(), Ok(()));
                orbit.zoom(1e-9, 2.0);
            }
        }
    }
}
