//! Lights as the picture has them: place, colour, reach, samples.

use rimline::glam::{DVec3, Vec3};
use rimline::shadow::{RangedLight, falloff};
use rimline::{AreaLight, AreaShape, Light};

use crate::failure::Failure;
use crate::render::camera::{AZIMUTH, Camera};
use crate::shadow::args::ShadowSceneArgs;
use crate::spec::{AreaKind, AreaSpec};

use super::body::Body;

/// A light of the picture.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    pub(crate) light: Light,
    /// Times its intensity.
    pub(crate) color: [f32; 3],
    pub(crate) range: f32,
    begin: f32,
    exponent: f32,
    /// The light itself, or those that stand for its area.
    pub(crate) samples: Vec<Light>,
}

/// As in `scene.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct LampData {
    light: [f32; 4],
    color: [f32; 3],
    range: f32,
    begin: f32,
    exponent: f32,
    bit: u32,
    density: f32,
}

/// A little warm.
const DEFAULT_COLOR: [f32; 3] = [1.0, 0.95, 0.87];

/// Where the models are: what is chosen for lights and camera follows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage {
    pub(crate) centre: [f32; 3],
    pub(crate) extent: f32,
    pub(crate) ground: f32,
}

impl Lamp {
    /// The lights of the command line, or the one that is there by default.
    pub(crate) fn all(args: &ShadowSceneArgs, first: &Body<'_>, stage: &Stage) -> Result<Vec<Self>, Failure> {
        let mut lamps = Vec::new();
        for spec in &args.lights {
            let wanted = std::slice::from_ref(&spec.light);
            for light in first.input.lights(wanted, first.animation(), args.moment.pose.time)? {
                lamps.push(Self {
                    light,
                    color: spec.color.map(|c| c * spec.intensity),
                    range: spec.range,
                    begin: spec.begin,
                    exponent: spec.exponent,
                    samples: vec![light],
                });
            }
        }
        if lamps.is_empty() {
            let light = default_light(args, stage);
            lamps.push(Self {
                light,
                color: DEFAULT_COLOR,
                range: f32::INFINITY,
                begin: 0.0,
                exponent: 1.0,
                samples: vec![light],
            });
        }
        if let Some(area) = args.area {
            for lamp in &mut lamps {
                lamp.spread(area, args.samples, stage);
            }
        }
        Ok(lamps)
    }

    fn spread(&mut self, area: AreaSpec, count: usize, stage: &Stage) {
        let normal = Vec3::from(stage.centre) - self.place();
        let shape = match area {
            AreaSpec::Given(shape) => shape,
            AreaSpec::Chosen(kind) => {
                let radius = 0.1 * if self.light.w == 0.0 { 1.0 } else { normal.length().max(1e-3 * stage.extent) };
                match kind {
                    AreaKind::Rectangle => AreaShape::Rectangle { width: 2.2 * radius, height: 1.4 * radius },
                    AreaKind::Disc => AreaShape::Disc { radius },
                    AreaKind::Sphere => AreaShape::Sphere { radius },
                }
            }
        };
        self.samples = AreaLight { light: self.light, shape, normal: normal.into() }.samples(count);
    }

    fn place(&self) -> Vec3 {
        let xyz = Vec3::from(self.light.xyz);
        if self.light.w == 0.0 { xyz } else { xyz / self.light.w }
    }

    /// Its samples, as the shadow volumes take them.
    pub(crate) fn ranged(&self) -> impl Iterator<Item = RangedLight> + '_ {
        self.samples.iter().map(|&light| RangedLight { light, range: self.range })
    }

    /// Its samples, as the shaders take them; `first` is the number of the first among all.
    pub(crate) fn data(&self, camera: &Camera, first: usize, lamps: usize) -> impl Iterator<Item = LampData> + '_ {
        let eye = camera.eye.as_dvec3();
        let share = 1.0 / self.samples.len() as f32;
        let is_ranged = self.range.is_finite();
        (first..).zip(&self.samples).map(move |(number, light)| {
            let w = f64::from(light.w);
            let from_eye = Vec3::from(light.xyz).as_dvec3() - w * eye;
            // No more than directions and ratios count, and far lights must not overflow.
            let scale = from_eye.abs().max_element().max(w);
            let scale = if w > 0.0 && is_ranged {
                w
            } else if scale > 0.0 {
                scale
            } else {
                1.0
            };
            let [x, y, z] = (from_eye / scale).as_vec3().to_array();
            LampData {
                light: [x, y, z, (w / scale) as f32],
                color: self.color.map(|c| c * share),
                range: if is_ranged { self.range } else { 0.0 },
                begin: self.begin,
                exponent: self.exponent,
                bit: number as u32 % 32,
                density: share / lamps as f32,
            }
        })
    }

    /// How much of its light the ground gets at a place, nothing in between.
    pub(crate) fn on_ground(&self, place: Vec3) -> f32 {
        let towards = Vec3::from(self.light.xyz) - self.light.w * place;
        let share = if self.light.w > 0.0 {
            falloff(towards.length() / self.light.w, self.begin, self.range, self.exponent)
        } else {
            1.0
        };
        share * towards.normalize_or_zero().y.max(0.0)
    }

    /// The shadow that a point throws onto the ground, or as much of the way there as a picture should show.
    pub(crate) fn shadow_of(&self, point: [f32; 3], stage: &Stage) -> [f32; 3] {
        let p = Vec3::from(point).as_dvec3();
        let Light { xyz, w } = self.light;
        let away = f64::from(w) * p - Vec3::from(xyz).as_dvec3();
        let height = p.y - f64::from(stage.ground);
        if away.y >= 0.0 || height <= 0.0 {
            return point;
        }
        let along: DVec3 = away * (height / -away.y);
        let most = 1.3 * f64::from(stage.extent);
        (p + along.clamp_length_max(most)).as_vec3().into()
    }
}

/// To the left of the eye, above, and a little before the models: their shadow falls beside them.
fn default_light(args: &ShadowSceneArgs, stage: &Stage) -> Light {
    let azimuth = AZIMUTH.to_radians() as f32;
    let target = Vec3::from(args.view.target.unwrap_or(stage.centre));
    let level = args.view.eye.map(|eye| (Vec3::from(eye) - target) * Vec3::new(1.0, 0.0, 1.0));
    let backward = level.and_then(Vec3::try_normalize).unwrap_or(Vec3::new(azimuth.sin(), 0.0, azimuth.cos()));
    let right = Vec3::Y.cross(backward);
    let towards = (-0.8 * right + 1.15 * Vec3::Y + 0.42 * backward).normalize();
    Light::point((Vec3::from(stage.centre) + 3.5 * stage.extent * towards).into())
}
