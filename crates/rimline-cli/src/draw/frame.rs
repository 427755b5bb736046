//! The frame's uniform.

use glam::DVec3;
use rimline::mesh::Bounds;

use super::region::{Region, corners};
use crate::render::camera::Camera;
use crate::render::{centre, extent};

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

    /// Where a model within `bounds` can be in a picture.
    pub(super) fn region(&self, bounds: &Bounds) -> Region {
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let place = |corner: DVec3| {
            let from_eye = corner - vector(self.eye);
            let ahead = from_eye.dot(vector(self.forward));
            if ahead <= f64::from(self.near) {
                // The model may be anywhere.
                return [f64::NAN; 2];
            }
            let x = from_eye.dot(vector(self.right)) * f64::from(self.scale_x) / ahead;
            let y = from_eye.dot(vector(self.up)) * f64::from(self.scale_y) / ahead;
            let [width, height] = self.size.map(f64::from);
            [(0.5 + 0.5 * x) * width, (0.5 - 0.5 * y) * height]
        };
        // Rounding comes to less than a pixel.
        Region::around(corners(bounds).map(place), 2.0, self.size.map(|pixels| pixels as u32))
    }

    /// Where a model within `bounds` can be in a square contact map of so many pixels, or `margin` pixels beside.
    pub(super) fn region_on_ground(&self, bounds: &Bounds, margin: f64, pixels: u32) -> Region {
        let half = f64::from(self.ground_half);
        let place = |corner: DVec3| {
            let [x, z] = self.ground_centre.map(f64::from);
            [0.5 + 0.5 * (corner.x - x) / half, 0.5 - 0.5 * (corner.z - z) / half].map(|c| c * f64::from(pixels))
        };
        Region::around(corners(bounds).map(place), margin + 2.0, [pixels; 2])
    }

    /// The eye is above the ground, so the ground is seen.
    pub(super) fn sees_ground(&self) -> bool {
        self.eye[1] > self.ground
    }
}
