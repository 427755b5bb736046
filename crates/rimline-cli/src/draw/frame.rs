//! The frame's uniform.

use rimline::mesh::Bounds;

use crate::render::camera::Camera;
use crate::render::{centre, extent};

/// As in `frame.wgsl`.
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
    places: u32,
    show_boundary: u32,
    reserved: [u32; 2],
}

impl Frame {
    /// With so many places each way a pixel in the survey.
    pub(super) fn new(camera: &Camera, size: [u32; 2], bounds: &Bounds, places: u32, show_boundary: bool) -> Self {
        let extent = extent(bounds);
        let [min, max] = [bounds.min, bounds.max];
        let [x, _, z] = centre(bounds);
        Self {
            eye: camera.eye.into(),
            near: camera.near,
            right: camera.right.into(),
            scale_x: camera.scale[0],
            up: camera.up.into(),
            scale_y: camera.scale[1],
            forward: camera.forward.into(),
            // 2.75 pixels wide at 960 pixels of height, and never too thin to see.
            half_line: (size[1] as f32 / 700.0).clamp(0.9, 4.0),
            size: size.map(|pixels| pixels as f32),
            extent,
            ground: min[1],
            ground_centre: [x, z],
            ground_half: 0.5 * (max[0] - min[0]).max(max[2] - min[2]) + 0.3 * extent,
            shadow_height: 0.3 * extent,
            places,
            show_boundary: u32::from(show_boundary),
            reserved: [0; 2],
        }
    }

    pub(super) fn places(&self) -> u32 {
        self.places
    }

    /// The eye is above the ground, so the ground is seen.
    pub(super) fn sees_ground(&self) -> bool {
        self.eye[1] > self.ground
    }
}
