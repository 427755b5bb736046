//! Figures and rocks on the ground that all move, under lights that reach them all, before an eye that sees all shadows: what
//! skipping costs where it spares nothing.

use glam::Vec3;
use rimline::Light;
use rimline_bench::shapes;

use super::super::casters::field::CasterMesh;
use super::setting::{Casters, Setting};
use crate::render::camera::Camera;
use crate::shadow::frame::shadow_camera;

/// From a caster to the next, in units of which a figure is 3 wide.
const PITCH: f32 = 6.0;

pub(super) fn setting(casters: usize) -> Setting {
    // 4,000 faces, and 5,780, which are in clusters.
    let shapes = vec![CasterMesh::Figure.shape(), shapes::blob(27, 0.4, 3)];
    let columns = (casters as f32).sqrt().ceil().max(1.0) as usize;
    let rows = casters.div_ceil(columns);
    let line = |index: usize, count: usize| PITCH * (index as f32 - 0.5 * (count - 1) as f32);
    let placed: Vec<_> = (0..casters)
        .map(|number| {
            let [x, z] = [line(number % columns, columns), line(number / columns, rows)];
            (number % 2, [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, z]])
        })
        .collect();
    let lights: Vec<Light> = [[0.2, 1.0, 0.3], [-0.3, 1.0, 0.1], [0.1, 1.0, -0.3], [-0.2, 1.0, -0.2], [0.0, 1.0, 0.1]]
        .map(Light::directional)
        .into();
    let width = PITCH * columns as f32;
    let eye = Vec3::new(0.0, width + 6.0, 0.3 * width + 2.0);
    let forward = -eye.normalize();
    let camera = Camera { eye, right: Vec3::X, up: Vec3::X.cross(forward), forward, scale: [1.4; 2], near: 0.1 };
    Setting {
        pairs_in_range: placed.len() * lights.len(),
        casters: Casters::Rigid { shapes, placed },
        lights,
        camera: shadow_camera(&camera),
        ground: Some(0.0),
        turn: 0.0,
        drift: 0.01,
    }
}
