//! The frame's uniform, and the parts of a picture whose pixels take turns.

use glam::{Mat4, Vec3};
use rimline::ShadowCamera;

use crate::bounds::SceneBounds;
use crate::camera::Camera;
use crate::lights::{ShadedLight, ShadedLightData};

/// Layout of `Frame` in `scene.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Frame {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 3],
    ground: f32,
    right: [f32; 3],
    fade_slope: f32,
    up: [f32; 3],
    pitch: f32,
    forward: [f32; 3],
    exposure: f32,
    ambient: [f32; 3],
    per_unit: f32,
    backdrop: [f32; 3],
    is_parallel: u32,
    size: [f32; 2],
    centre: [f32; 2],
    first: [f32; 2],
    aside_step: [f32; 2],
    aside: [f32; 2],
    reserved: [u32; 2],
}

/// The share of all lights' light that is ambient.
const AMBIENT: f32 = 0.27;
/// The share of light that the ground throws back: `ALBEDO` of `ground.wgsl`.
const GROUND: Vec3 = Vec3::new(0.80, 0.79, 0.77);

/// A scene as a picture shows it.
#[derive(Clone, Copy, Debug)]
pub struct SceneView<'a> {
    /// The camera of the whole picture.
    pub camera: &'a Camera,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Pixels that are drawn.
    pub part: &'a Part,
    /// Where the models are.
    pub bounds: &'a SceneBounds,
    /// The lights.
    pub lights: &'a [ShadedLight],
    /// How far from below the models their shadows lie, as [`reach`](crate::reach) has it.
    pub reach: f32,
}

impl SceneView<'_> {
    pub(crate) fn frame(&self) -> Frame {
        let Self { camera, size, part, bounds: &SceneBounds { models, ground }, lights, reach } = *self;
        let total: Vec3 = lights.iter().map(|shaded| Vec3::from(shaded.color)).sum();
        let brightest = if total.max_element() > 0.0 { total.max_element() } else { 1.0 };
        let ambient = AMBIENT * brightest * Vec3::new(0.86, 0.95, 1.08);
        let under = models.centre().with_y(ground);
        // No shadow fades with the ground, which has faded at 3.3 times this distance.
        let begin = (1.8 * models.extent()).max(1.1 * reach);
        let far = 2.6 * begin;
        let unit = self.unit();
        let in_units = |length: f32| (f64::from(length) / f64::from(unit)) as f32;
        let around = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|side| under + far * side);
        // The backdrop is as bright as the lit ground, so that the ground fades into it unseen.
        let lit = |shaded: &ShadedLight| {
            let share = around.iter().map(|&point| shaded.on_ground(point)).sum::<f32>() / 4.0;
            share * Vec3::from(shaded.color)
        };
        let backdrop = GROUND * (ambient + lights.iter().map(lit).sum::<Vec3>());
        // From pixels drawn to clip space, divided by its scale; rows go down.
        let aside = [(0, 1.0), (1, -1.0)].map(|(axis, sign)| {
            let [size, pitch, first] = [size[axis] as f32, part.pitch, part.first[axis]].map(f64::from);
            let per_scale = sign / f64::from(camera.scale[axis]);
            let start = 2.0 * (first - 0.5 * pitch) / size - 1.0;
            [2.0 * pitch / size * per_scale, start * per_scale].map(|c| c as f32)
        });
        let mut view_projection = Mat4::from_cols_array_2d(&self.shadow_camera().view_projection);
        if camera.far.is_none() {
            view_projection.w_axis *= unit.recip();
        } else {
            // Clip space is the same, of positions that are in units.
            for axis in [&mut view_projection.x_axis, &mut view_projection.y_axis, &mut view_projection.z_axis] {
                *axis *= unit;
            }
        }
        Frame {
            view_projection: view_projection.to_cols_array_2d(),
            eye: camera.eye.into(),
            ground: in_units(ground - camera.eye.y),
            right: camera.right.into(),
            fade_slope: (f64::from(unit) / (2.3 * f64::from(begin))) as f32,
            up: camera.up.into(),
            pitch: part.pitch,
            forward: camera.forward.into(),
            exposure: 1.12 / ((1.0 + AMBIENT) * brightest),
            ambient: ambient.into(),
            per_unit: unit.recip(),
            backdrop: backdrop.into(),
            is_parallel: u32::from(camera.far.is_some()),
            size: size.map(|pixels| pixels as f32),
            centre: [under.x - camera.eye.x, under.z - camera.eye.z].map(in_units),
            first: part.first,
            aside_step: aside.map(|[step, _]| step),
            aside: aside.map(|[_, start]| start),
            reserved: [0; 2],
        }
    }

    /// The uniforms of all lights' samples.
    pub(crate) fn light_data(&self) -> Vec<ShadedLightData> {
        let (unit, count) = (self.unit(), self.lights.len());
        let mut data = Vec::new();
        for shaded in self.lights {
            data.extend(shaded.data(self.camera, unit, data.len(), count));
        }
        data
    }

    /// Whether the eye is above the ground and may see it. An orthographic camera must look down.
    pub fn sees_ground(&self) -> bool {
        let is_above = self.camera.far.is_none() || self.camera.forward.y < -1e-6;
        is_above && self.frame().ground < 0.0
    }

    /// The camera of the part that is drawn, for shadow volumes.
    pub fn shadow_camera(&self) -> ShadowCamera {
        let whole = self.camera.shadow_camera();
        ShadowCamera {
            view_projection: (self.part.clip * Mat4::from_cols_array_2d(&whole.view_projection)).to_cols_array_2d(),
            ..whole
        }
    }

    /// The unit of distances where light is computed: a power of two of about the scene's size. It keeps squares of
    /// distances within the range of floats, for models of any size.
    fn unit(&self) -> f32 {
        let SceneBounds { models, ground } = self.bounds;
        let from_centre = (self.camera.eye - models.centre()).abs().max_element();
        let size = models.extent().max(from_centre).max((self.camera.eye.y - ground).abs());
        // Its reciprocal is a normal number, too.
        let most = 2.0_f32.powi(126);
        f32::from_bits(size.to_bits() & 0x7f80_0000).clamp(most.recip(), most)
    }
}

/// How many parts of a picture there are.
pub const PARTS: usize = 16;
/// Pixels of the picture from one of a part's to the next.
const PITCH: u32 = 2;
/// Where in a pixel, as multisampling has it.
const SAMPLES: [[f32; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// Which pixels of the picture are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Pixels of the picture from one to the next.
    pub(crate) pitch: f32,
    /// Where the first one's centre is.
    pub(crate) first: [f32; 2],
    /// From the picture's clip space to the part's.
    pub(crate) clip: Mat4,
}

impl Part {
    /// All pixels.
    pub const WHOLE: Self = Self { pitch: 1.0, first: [0.5; 2], clip: Mat4::IDENTITY };

    /// The part with this number, below [`PARTS`]. Each four that follow each other, from 0 on, share a pixel: their patterns
    /// are most unlike.
    pub fn of(size: [u32; 2], part: usize) -> Self {
        let (pixel, sample) = (part / 4, SAMPLES[part % 4]);
        Self::starting_at(size, [(pixel & 1) as f32 + sample[0], (pixel >> 1) as f32 + sample[1]])
    }

    /// The middles of squares of four pixels. Where the picture has an odd number of rows or columns, the last squares reach
    /// over its border.
    pub fn halved(size: [u32; 2]) -> Self {
        Self::starting_at(size, [0.5 * PITCH as f32; 2])
    }

    /// Pixels that begin with one whose centre is there.
    fn starting_at(size: [u32; 2], first: [f32; 2]) -> Self {
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

    /// Width and height of a part of a picture.
    pub fn size(size: [u32; 2]) -> [u32; 2] {
        size.map(|pixels| pixels.div_ceil(PITCH))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Bounds;

    #[test]
    fn units_are_powers_of_two_of_about_the_scenes_size() {
        for (extent, eye, expected) in [
            (3.0, 0.0, 2.0),
            (3.0, 9.0, 8.0),
            (1e-30, 0.0, 2.0_f32.powi(-100)),
            (3e38, 0.0, 2.0_f32.powi(126)),
            (1e-42, 0.0, 2.0_f32.powi(-126)),
        ] {
            let models = Bounds { min: Vec3::splat(-0.5 * extent), max: Vec3::splat(0.5 * extent) };
            let eye = Vec3::new(eye, 0.0, 0.0);
            let camera = Camera {
                eye,
                right: Vec3::X,
                up: Vec3::Y,
                forward: Vec3::NEG_Z,
                scale: [1.0; 2],
                near: 1.0,
                far: None,
            };
            let bounds = SceneBounds { models, ground: 0.0 };
            let (camera, bounds, part) = (&camera, &bounds, &Part::WHOLE);
            let found = SceneView { camera, size: [9; 2], part, bounds, lights: &[], reach: 0.0 }.unit();
            assert_eq!(found, expected, "{extent:e}, {eye}");
        }
    }

    #[test]
    fn a_pixel_drawn_shows_its_position_in_the_picture() {
        for size in [[960, 720], [101, 33], [1, 1]] {
            for part in (0..PARTS).map(|number| Part::of(size, number)).chain([Part::halved(size)]) {
                let drawn = Part::size(size).map(|pixels| pixels as f32);
                for pixel in [[0.0, 0.0], [drawn[0] - 1.0, drawn[1] - 1.0]] {
                    let position = [0, 1].map(|axis| part.pitch * pixel[axis] + part.first[axis]);
                    let [x, y] = [0, 1].map(|axis| 2.0 * position[axis] / size[axis] as f32 - 1.0);
                    let clip = part.clip.project_point3(Vec3::new(x, -y, 0.5));
                    let found = [0.5 * (clip.x + 1.0) * drawn[0] - 0.5, 0.5 * (1.0 - clip.y) * drawn[1] - 0.5];
                    let error = (found[0] - pixel[0]).abs().max((found[1] - pixel[1]).abs());
                    assert!(error < 1e-3, "{size:?}, {part:?}: {found:?} instead of {pixel:?}");
                }
            }
        }
    }
}
