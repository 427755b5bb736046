//! The frame's uniform.

use rimline_picture::{Bounds, Camera};

/// Layout of `Frame` in `frame.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Frame {
    eye: [f32; 3],
    near: f32,
    right: [f32; 3],
    scale_x: f32,
    up: [f32; 3],
    scale_y: f32,
    forward: [f32; 3],
    half_line: f32,
    size: [f32; 2],
    extent: f32,
    ground: f32,
    ground_centre: [f32; 2],
    ground_half: f32,
    shadow_height: f32,
    pub(super) survey_scale: u32,
    show_boundary: u32,
    far: f32,
    is_colored: u32,
}

impl Frame {
    /// `survey_scale`: texels of the survey along a pixel's side.
    pub(super) fn new(
        camera: &Camera,
        size: [u32; 2],
        bounds: &Bounds,
        survey_scale: u32,
        [show_boundary, is_colored]: [bool; 2],
    ) -> Self {
        let (extent, centre) = (bounds.extent(), bounds.centre());
        let [min, max] = [bounds.min, bounds.max];
        Self {
            eye: camera.eye.into(),
            // The survey has shares of it.
            near: camera.far.map_or(camera.near, |far| camera.near.max(1e-4 * far)),
            right: camera.right.into(),
            scale_x: camera.scale[0],
            up: camera.up.into(),
            scale_y: camera.scale[1],
            forward: camera.forward.into(),
            // 2.75 pixels wide at 960 pixels of height, and never too thin to see.
            half_line: (size[1] as f32 / 700.0).clamp(0.9, 4.0),
            size: size.map(|pixels| pixels as f32),
            extent,
            ground: min.y,
            ground_centre: [centre.x, centre.z],
            ground_half: 0.5 * (max.x - min.x).max(max.z - min.z) + 0.3 * extent,
            shadow_height: 0.3 * extent,
            survey_scale,
            show_boundary: u32::from(show_boundary),
            far: camera.far.unwrap_or(0.0),
            is_colored: u32::from(is_colored),
        }
    }

    /// Width and height of the part of a square contact map of so many pixels, around its middle, that the shadow of a
    /// model within `bounds` can be in, `margin` pixels on each side included. The rest stays as it was cleared.
    pub(super) fn contact_part(&self, bounds: &Bounds, margin: f32, pixels: u32) -> [u32; 2] {
        let centre = bounds.centre();
        let farthest = (bounds.max - centre).max(centre - bounds.min);
        [farthest.x, farthest.z].map(|far| {
            let part = far / self.ground_half * pixels as f32 + 2.0 * margin;
            (part.ceil() as u32).min(pixels)
        })
    }

    pub(super) fn sees_ground(&self) -> bool {
        self.eye[1] > self.ground
    }
}
