//! One closed mesh of very many faces, and a light that circles above it.

use glam::Vec3;
use rimline::Light;
use rimline_bench::shapes;

use super::setting::{Casters, Setting};
use crate::render::camera::Camera;
use crate::shadow::frame::shadow_camera;

const IDENTITY: rimline::Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A sphere of radius 1 with at least so many faces, but for rounding.
pub(super) fn setting(faces: usize) -> Setting {
    let shape = shapes::sphere((faces as f64 / 8.0).sqrt().round() as u32);
    // So high that the eye is never in shadow.
    let lights = vec![Light::point([0.0, 5.0, -3.0])];
    let [right, up, forward] = [Vec3::X, Vec3::Y, Vec3::NEG_Z];
    let camera = Camera { eye: Vec3::new(0.0, 0.0, 3.5), right, up, forward, scale: [2.0; 2], near: 0.1 };
    Setting {
        pairs_in_range: lights.len(),
        casters: Casters::Rigid { shapes: vec![shape], placed: vec![(0, IDENTITY)] },
        lights,
        camera: shadow_camera(&camera),
        ground: None,
        turn: 0.05,
        drift: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sphere_has_about_as_many_faces_as_asked() {
        for faces in [1 << 16, 100_000, 1 << 20] {
            let found = setting(faces).casters.faces();
            assert!(found.abs_diff(faces) < faces / 20, "{found} for {faces}");
        }
    }
}
