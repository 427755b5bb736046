//! The frame's uniform and the shadow volumes' camera.

use rimline::glam::{Mat4, Vec3, Vec4};
use rimline::shadow::{DepthDirection, ShadowCamera};

use super::lamps::{Lamp, Stage};
use crate::render::camera::Camera;

/// As in `scene.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Frame {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 3],
    ground: f32,
    right: [f32; 3],
    scale_x: f32,
    up: [f32; 3],
    scale_y: f32,
    forward: [f32; 3],
    exposure: f32,
    ambient: [f32; 3],
    fade_begin: f32,
    backdrop: [f32; 3],
    fade_end: f32,
    size: [f32; 2],
    centre: [f32; 2],
}

/// Ambient light: of all lights' together, and what the ground throws back.
const AMBIENT: f32 = 0.27;
const GROUND: Vec3 = Vec3::new(0.80, 0.79, 0.77);

impl Frame {
    pub(crate) fn new(camera: &Camera, size: [u32; 2], stage: &Stage, lamps: &[Lamp]) -> Self {
        let total: Vec3 = lamps.iter().map(|lamp| Vec3::from(lamp.color)).sum();
        let brightest = if total.max_element() > 0.0 { total.max_element() } else { 1.0 };
        let ambient = AMBIENT * brightest * Vec3::new(0.86, 0.95, 1.08);
        let ([x, _, z], ground) = (stage.centre, stage.ground);
        let under = Vec3::new(x, ground, z);
        let far = 4.6 * stage.extent;
        let around = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|side| under + far * side);
        // As bright as the lit ground, so that it fades into the backdrop unseen.
        let lit = |lamp: &Lamp| {
            let share = around.iter().map(|&place| lamp.on_ground(place)).sum::<f32>() / 4.0;
            share * Vec3::from(lamp.color)
        };
        let backdrop = GROUND * (ambient + lamps.iter().map(lit).sum::<Vec3>());
        Self {
            view_projection: shadow_camera(camera).view_projection.to_cols_array_2d(),
            eye: camera.eye.into(),
            ground: ground - camera.eye.y,
            right: camera.right.into(),
            scale_x: camera.scale[0],
            up: camera.up.into(),
            scale_y: camera.scale[1],
            forward: camera.forward.into(),
            exposure: 1.12 / ((1.0 + AMBIENT) * brightest),
            ambient: ambient.into(),
            fade_begin: 1.8 * stage.extent,
            backdrop: backdrop.into(),
            fade_end: 6.0 * stage.extent,
            size: size.map(|pixels| pixels as f32),
            centre: [x - camera.eye.x, z - camera.eye.z],
        }
    }

    /// The eye is above the ground, so the ground is seen.
    pub(crate) fn sees_ground(&self) -> bool {
        self.ground < 0.0
    }
}

/// The camera with positions relative to the eye, so that models far from the origin keep their precision.
pub(crate) fn shadow_camera(camera: &Camera) -> ShadowCamera {
    let rows = [
        (camera.scale[0] * camera.right).extend(0.0),
        (camera.scale[1] * camera.up).extend(0.0),
        Vec4::new(0.0, 0.0, 0.0, camera.near),
        camera.forward.extend(0.0),
    ];
    let [x, y, z, w] = rows;
    ShadowCamera {
        view_projection: Mat4::from_cols(x, y, z, w).transpose(),
        origin: camera.eye,
        depth: DepthDirection::Reversed,
    }
}
