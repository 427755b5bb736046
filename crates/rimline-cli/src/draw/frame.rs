//! The frame's uniform, and where in a target there is anything to do for a model. Elsewhere passes would write what
//! was cleared.

use glam::DVec3;
use rimline::wgpu;
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

    /// Where a model within `bounds` can be in a picture.
    pub(super) fn region(&self, bounds: &Bounds) -> Region {
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let to_pixel = |corner: DVec3| {
            let from_eye = corner - vector(self.eye);
            let ahead = from_eye.dot(vector(self.forward));
            if ahead <= f64::from(self.near) {
                // The model may be anywhere.
                return [f64::NAN; 2];
            }
            let shrinking = if self.far > 0.0 { 1.0 } else { ahead };
            let x = from_eye.dot(vector(self.right)) * f64::from(self.scale_x) / shrinking;
            let y = from_eye.dot(vector(self.up)) * f64::from(self.scale_y) / shrinking;
            let [width, height] = self.size.map(f64::from);
            [(0.5 + 0.5 * x) * width, (0.5 - 0.5 * y) * height]
        };
        // Rounding comes to less than a pixel.
        Region::around(bounds.corners().map(|c| to_pixel(c.as_dvec3())), 2.0, self.size.map(|pixels| pixels as u32))
    }

    /// Where a model within `bounds` can be in a square contact map of so many pixels, or `margin` pixels beside.
    pub(super) fn region_on_ground(&self, bounds: &Bounds, margin: f64, pixels: u32) -> Region {
        let half = f64::from(self.ground_half);
        let to_pixel = |corner: DVec3| {
            let [x, z] = self.ground_centre.map(f64::from);
            [0.5 + 0.5 * (corner.x - x) / half, 0.5 - 0.5 * (corner.z - z) / half].map(|c| c * f64::from(pixels))
        };
        Region::around(bounds.corners().map(|c| to_pixel(c.as_dvec3())), margin + 2.0, [pixels; 2])
    }

    pub(super) fn sees_ground(&self) -> bool {
        self.eye[1] > self.ground
    }
}

/// A rectangle of pixels: its lower corner, and the one past it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    first: [u32; 2],
    end: [u32; 2],
}

impl Region {
    /// Around pixel positions, `margin` wider on each side, within a target of this size. All of it, if one of them is not
    /// finite.
    pub(super) fn around(points: impl IntoIterator<Item = [f64; 2]>, margin: f64, size: [u32; 2]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            if point.iter().any(|c| !c.is_finite()) {
                return Self { first: [0; 2], end: size };
            }
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        // From float to integer is within the range of the integer.
        let first = [0, 1].map(|axis| ((low[axis] - margin).floor() as u32).min(size[axis]));
        let end = [0, 1].map(|axis| ((high[axis] + margin).ceil() as u32).min(size[axis]).max(first[axis]));
        Self { first, end }
    }

    /// Keeps to it what a pass draws from now on. Nothing need be drawn if it returns `false`: there is no pixel.
    pub(super) fn keep(self, pass: &mut wgpu::RenderPass<'_>) -> bool {
        let [width, height] = [0, 1].map(|axis| self.end[axis] - self.first[axis]);
        let is_there = width > 0 && height > 0;
        if is_there {
            pass.set_scissor_rect(self.first[0], self.first[1], width, height);
        }
        is_there
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_hold_what_they_are_around_and_stay_in_the_target() {
        let around = |points: &[[f64; 2]], margin| Region::around(points.iter().copied(), margin, [100, 50]);
        let region = |first, end| Region { first, end };
        assert_eq!(around(&[[10.5, 20.0], [30.25, 25.5]], 2.0), region([8, 18], [33, 28]));
        assert_eq!(around(&[[-1e30, 20.0], [1e30, 25.0]], 0.0), region([0, 20], [100, 25]));
        assert_eq!(around(&[[10.0, f64::NAN], [30.0, 25.0]], 0.0), region([0, 0], [100, 50]));
        assert_eq!(around(&[[f64::INFINITY, 1.0]], 0.0), region([0, 0], [100, 50]));
        // Beside the target.
        assert_eq!(around(&[[150.0, 20.0], [160.0, 30.0]], 0.0), region([100, 20], [100, 30]));
    }
}
