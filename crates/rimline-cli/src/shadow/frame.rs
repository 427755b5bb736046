//! The frame's uniform and the shadow volumes' camera.

use glam::{Mat4, Vec3, Vec4};
use rimline::{DepthDirection, ShadowCamera};

use super::shaded_lights::{SceneBounds, ShadedLight};
use crate::render::camera::Camera;

/// Layout of `Frame` in `scene.wgsl`.
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
    per_unit: f32,
    pitch: f32,
    first: [f32; 2],
}

/// Ambient light: of all lights' together, and what the ground throws back.
const AMBIENT: f32 = 0.27;
const GROUND: Vec3 = Vec3::new(0.80, 0.79, 0.77);

impl Frame {
    /// `reach` is how far from below the models their shadows lie.
    pub(crate) fn new(
        camera: &Camera,
        size: [u32; 2],
        part: &Part,
        stage: &SceneBounds,
        shaded_lights: &[ShadedLight],
        reach: f32,
    ) -> Self {
        let total: Vec3 = shaded_lights.iter().map(|shaded| Vec3::from(shaded.color)).sum();
        let brightest = if total.max_element() > 0.0 { total.max_element() } else { 1.0 };
        let ambient = AMBIENT * brightest * Vec3::new(0.86, 0.95, 1.08);
        let ([x, _, z], ground) = (stage.centre, stage.ground);
        let under = Vec3::new(x, ground, z);
        // No shadow fades with the ground.
        let begin = (1.8 * stage.extent).max(1.1 * reach);
        let far = 2.6 * begin;
        let unit = unit(camera, stage);
        let in_units = |length: f32| (f64::from(length) / f64::from(unit)) as f32;
        let around = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|side| under + far * side);
        // The backdrop is as bright as the lit ground, so that the ground fades into it unseen.
        let lit = |shaded: &ShadedLight| {
            let share = around.iter().map(|&place| shaded.on_ground(place)).sum::<f32>() / 4.0;
            share * Vec3::from(shaded.color)
        };
        let backdrop = GROUND * (ambient + shaded_lights.iter().map(lit).sum::<Vec3>());
        let mut view_projection = Mat4::from_cols_array_2d(&part_camera(camera, part).view_projection);
        view_projection.w_axis *= unit.recip();
        Self {
            view_projection: view_projection.to_cols_array_2d(),
            eye: camera.eye.into(),
            ground: in_units(ground - camera.eye.y),
            right: camera.right.into(),
            scale_x: camera.scale[0],
            up: camera.up.into(),
            scale_y: camera.scale[1],
            forward: camera.forward.into(),
            exposure: 1.12 / ((1.0 + AMBIENT) * brightest),
            ambient: ambient.into(),
            fade_begin: in_units(begin),
            backdrop: backdrop.into(),
            fade_end: 3.3 * in_units(begin),
            size: size.map(|pixels| pixels as f32),
            centre: [x - camera.eye.x, z - camera.eye.z].map(in_units),
            per_unit: unit.recip(),
            pitch: part.pitch,
            first: part.first,
        }
    }

    /// The eye is above the ground, so the ground is seen.
    pub(crate) fn sees_ground(&self) -> bool {
        self.ground < 0.0
    }
}

/// The unit of distances where light is computed: a power of two of about the scene's size. It keeps squares of
/// distances within the range of floats, for models of any size.
pub(crate) fn unit(camera: &Camera, stage: &SceneBounds) -> f32 {
    let from_centre = (camera.eye - Vec3::from(stage.centre)).abs().max_element();
    let size = stage.extent.max(from_centre).max((camera.eye.y - stage.ground).abs());
    // Its reciprocal is a normal number, too.
    let most = 2.0_f32.powi(126);
    f32::from_bits(size.to_bits() & 0x7f80_0000).clamp(most.recip(), most)
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
        view_projection: Mat4::from_cols(x, y, z, w).transpose().to_cols_array_2d(),
        origin: camera.eye.into(),
        depth: DepthDirection::Reversed,
    }
}

/// The same for a part of the picture.
pub(super) fn part_camera(camera: &Camera, part: &Part) -> ShadowCamera {
    let whole = shadow_camera(camera);
    ShadowCamera {
        view_projection: (part.clip * Mat4::from_cols_array_2d(&whole.view_projection)).to_cols_array_2d(),
        ..whole
    }
}

/// How many there are.
pub(crate) const PARTS: usize = 16;
/// Pixels of the picture from one of a part's to the next.
const PITCH: u32 = 2;
/// Where in a pixel, as multisampling has it.
const PLACES: [[f32; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// Which pixels of the picture are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// Pixels of the picture from one to the next.
    pub(super) pitch: f32,
    /// Where the first one's centre is.
    pub(super) first: [f32; 2],
    /// From the picture's clip space to the part's.
    pub(super) clip: Mat4,
}

impl Part {
    pub(crate) const WHOLE: Self = Self { pitch: 1.0, first: [0.5; 2], clip: Mat4::IDENTITY };

    /// Parts that follow each other share a pixel: their patterns are most unlike.
    pub(crate) fn of(size: [u32; 2], part: usize) -> Self {
        let (pixel, place) = (part / 4, PLACES[part % 4]);
        let first = [(pixel & 1) as f32 + place[0], (pixel >> 1) as f32 + place[1]];
        let pitch = PITCH as f32;
        let along = |axis: usize| {
            let (all, drawn) = (size[axis] as f32, Self::size(size)[axis] as f32);
            let scale = all / (pitch * drawn);
            (scale, scale + (1.0 - 2.0 * first[axis] / pitch) / drawn - 1.0)
        };
        let ((scale_x, move_x), (scale_y, move_y)) = (along(0), along(1));
        let clip = Mat4::from_translation(Vec3::new(move_x, -move_y, 0.0))
            * Mat4::from_scale(Vec3::new(scale_x, scale_y, 1.0));
        Self { pitch, first, clip }
    }

    pub(crate) fn size(size: [u32; 2]) -> [u32; 2] {
        size.map(|pixels| pixels.div_ceil(PITCH))
    }
}

#[cfg(test)]
mod tests {
    use crate::render::bounds::Bounds;

    use super::*;

    #[test]
    fn units_are_powers_of_two_of_about_the_scenes_size() {
        let camera =
            |eye: Vec3| Camera { eye, right: Vec3::X, up: Vec3::Y, forward: Vec3::NEG_Z, scale: [1.0; 2], near: 1.0 };
        let stage = |extent| SceneBounds {
            centre: [0.0; 3],
            extent,
            ground: 0.0,
            bounds: Bounds { min: [0.0; 3], max: [extent; 3] },
        };
        for (extent, eye, expected) in [
            (3.0, 0.0, 2.0),
            (3.0, 9.0, 8.0),
            (1e-30, 0.0, 2.0_f32.powi(-100)),
            (3e38, 0.0, 2.0_f32.powi(126)),
            (1e-42, 0.0, 2.0_f32.powi(-126)),
        ] {
            let found = unit(&camera(Vec3::new(eye, 0.0, 0.0)), &stage(extent));
            assert_eq!(found, expected, "{extent:e}, {eye}");
        }
    }

    #[test]
    fn a_pixel_drawn_shows_its_place_in_the_picture() {
        for size in [[960, 720], [101, 33], [1, 1]] {
            for number in 0..PARTS {
                let part = Part::of(size, number);
                let drawn = Part::size(size).map(|pixels| pixels as f32);
                for pixel in [[0.0, 0.0], [drawn[0] - 1.0, drawn[1] - 1.0]] {
                    let place = [0, 1].map(|axis| part.pitch * pixel[axis] + part.first[axis]);
                    let [x, y] = [0, 1].map(|axis| 2.0 * place[axis] / size[axis] as f32 - 1.0);
                    let clip = part.clip.project_point3(Vec3::new(x, -y, 0.5));
                    let found = [0.5 * (clip.x + 1.0) * drawn[0] - 0.5, 0.5 * (1.0 - clip.y) * drawn[1] - 0.5];
                    let error = (found[0] - pixel[0]).abs().max((found[1] - pixel[1]).abs());
                    assert!(error < 1e-3, "{size:?}, part {number}: {found:?} instead of {pixel:?}");
                }
            }
        }
    }
}
