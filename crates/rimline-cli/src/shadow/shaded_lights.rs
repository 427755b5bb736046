//! Lights as the picture has them: place, colour, reach, samples.

use crate::render::bounds::Bounds;
use glam::{DVec3, Vec3};
use rimline::falloff;
use rimline::gltf::{SceneLight, SpotCone};
use rimline::internals::light::check_shadow_lights;
use rimline::{AreaLight, AreaShape, Light};

use crate::failure::{Failure, UsageError};
use crate::input::ChosenLight;
use crate::input_args::PlacedView;
use crate::render::camera::{AZIMUTH, Camera};
use crate::shadow::args::ShadowSceneArgs;
use crate::spec::{AreaSpec, LightSpec, ShadedLightSpec, SpecError};

use super::posed_model::PosedModel;

#[derive(Clone, Debug)]
pub(crate) struct ShadedLight {
    pub(crate) light: Light,
    /// Times its intensity.
    pub(crate) color: [f32; 3],
    pub(crate) range: f32,
    begin: f32,
    exponent: f32,
    pub(crate) cone: Option<SpotCone>,
    /// The light itself, or those that stand for its area.
    pub(crate) samples: Vec<Light>,
    area: Option<AreaLight>,
}

/// Layout of `ShadedLight` in `scene.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct ShadedLightData {
    light: [f32; 4],
    color: [f32; 3],
    range: f32,
    begin: f32,
    exponent: f32,
    bit: u32,
    density: f32,
    axis: [f32; 3],
    cone_scale: f32,
    cone_offset: f32,
    reserved: [f32; 3],
}

/// A little warm.
const DEFAULT_COLOR: [f32; 3] = [1.0, 0.95, 0.87];

/// Where the models are: what is chosen for lights and camera follows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SceneBounds {
    pub(crate) centre: [f32; 3],
    pub(crate) extent: f32,
    pub(crate) ground: f32,
    pub(crate) bounds: Bounds,
}

impl ShadedLight {
    /// The lights of the command line, or else `own`, or the one that is there by default.
    pub(crate) fn all(
        args: &ShadowSceneArgs,
        first: &PosedModel<'_>,
        stage: &SceneBounds,
        own: Option<Light>,
    ) -> Result<Vec<Self>, Failure> {
        let mut chosen = Vec::new();
        for spec in &args.lights {
            let wanted = std::slice::from_ref(&spec.light);
            let lights = first.input.chosen_lights(wanted, first.animations, args.posed.pose.time)?;
            check_options(spec, &lights)?;
            chosen.extend(lights.into_iter().map(|light| (spec, light)));
        }
        let of_file = chosen.iter().filter_map(|(_, chosen)| chosen.own.as_ref());
        let brightest = of_file.map(|own| illuminance(own, stage)).fold(0.0, f64::max);
        let mut shaded_lights: Vec<Self> =
            chosen.iter().map(|(spec, chosen)| Self::new(spec, chosen, brightest, stage)).collect();
        if shaded_lights.is_empty() {
            let light = own.unwrap_or_else(|| default_light(&args.view.relative_to(first.input.origin()), stage));
            let spec = ShadedLightSpec { color: Some(DEFAULT_COLOR), ..ShadedLightSpec::new(LightSpec::All) };
            shaded_lights.push(Self::new(&spec, &ChosenLight { light, own: None }, 0.0, stage));
        }
        // Once for every way to cast: depth maps and areas would take such a light for another.
        let lights: Vec<Light> = shaded_lights.iter().map(|shaded| shaded.light).collect();
        check_shadow_lights(&lights, usize::MAX).map_err(UsageError::Lights)?;
        if let Some(area) = args.area {
            for shaded in &mut shaded_lights {
                shaded.spread(area, args.samples(), stage);
            }
        }
        Ok(shaded_lights)
    }

    /// Takes a light's options from the command line, or else from the file. The brightest light of its file counts as 1.
    fn new(spec: &ShadedLightSpec, chosen: &ChosenLight, brightest: f64, stage: &SceneBounds) -> Self {
        let light = chosen.light;
        let own = chosen.own.as_ref();
        let relative = |own| if brightest > 0.0 { (illuminance(own, stage) / brightest) as f32 } else { 0.0 };
        let intensity = spec.intensity.or_else(|| own.map(relative)).unwrap_or(1.0);
        let color = spec.color.or(own.map(|own| own.color)).unwrap_or([1.0; 3]);
        let range = spec.range.or(own.and_then(|own| own.range)).unwrap_or(f32::INFINITY);
        Self {
            light,
            color: color.map(|c| c * intensity),
            range: if light.w == 0.0 { f32::INFINITY } else { range },
            begin: spec.begin.unwrap_or(0.0),
            exponent: spec.exponent.unwrap_or(1.0),
            cone: own.and_then(|own| own.cone),
            samples: vec![light],
            area: None,
        }
    }

    fn spread(&mut self, area: AreaSpec, count: usize, stage: &SceneBounds) {
        let normal = vector(stage.centre) - self.place();
        let distance = normal.length().max(1e-3 * f64::from(stage.extent));
        let shape = match area {
            AreaSpec::Given(shape) => shape,
            AreaSpec::Chosen(shape) => {
                let by = (AREA_RADIUS * if self.light.w == 0.0 { 1.0 } else { distance }) as f32;
                match shape {
                    AreaShape::Rectangle { width, height } => {
                        AreaShape::Rectangle { width: width * by, height: height * by }
                    }
                    AreaShape::Disc { radius } => AreaShape::Disc { radius: radius * by },
                    AreaShape::Sphere { radius } => AreaShape::Sphere { radius: radius * by },
                }
            }
        };
        let normal = normal.normalize_or_zero().as_vec3().into();
        let area = AreaLight { light: self.light, shape, normal };
        self.samples = area.samples(count);
        self.area = Some(area);
    }

    pub(crate) fn take_pattern(&mut self, pattern: usize, patterns: usize) {
        if let Some(area) = &self.area {
            self.samples = area.pattern_samples(self.samples.len(), pattern, patterns);
        }
    }

    fn place(&self) -> DVec3 {
        let xyz = vector(self.light.xyz);
        if self.light.w == 0.0 { xyz } else { xyz / f64::from(self.light.w) }
    }

    /// Its samples, as the shadow volumes take them.
    pub(crate) fn ranged(&self) -> impl Iterator<Item = Light> + '_ {
        self.samples.iter().map(|light| light.with_range(self.range))
    }

    /// Its samples, as the shaders take them; `first` is the number of the first among all.
    pub(crate) fn data(
        &self,
        camera: &Camera,
        unit: f32,
        first: usize,
        shaded_lights: usize,
    ) -> impl Iterator<Item = ShadedLightData> + '_ {
        let eye = camera.eye.as_dvec3();
        let share = 1.0 / self.samples.len() as f32;
        let unit = f64::from(unit);
        let [cone_scale, cone_offset] = self.cone.map_or([0.0, 1.0], cone_ramp);
        (first..).zip(&self.samples).map(move |(number, light)| {
            let w = f64::from(light.w);
            let from_eye = (vector(light.xyz) - w * eye) / unit;
            // No more than directions and ratios count, and far lights must not overflow.
            let largest = from_eye.abs().max_element().max(w);
            let scale = if largest > 0.0 { largest } else { 1.0 };
            let [x, y, z] = (from_eye / scale).as_vec3().to_array();
            // Shaders compare lengths with the light's distance times its w, so lengths get the same factor.
            let reach = |distance: f32| (f64::from(distance) / unit * (w / scale)).min(1e38) as f32;
            ShadedLightData {
                light: [x, y, z, (w / scale) as f32],
                color: self.color.map(|c| c * share),
                range: if self.range.is_finite() { reach(self.range).max(f32::MIN_POSITIVE) } else { 0.0 },
                begin: reach(self.begin),
                exponent: self.exponent,
                bit: number as u32 % 32,
                density: share / shaded_lights as f32,
                axis: self.cone.map_or([0.0; 3], |cone| cone.direction),
                cone_scale,
                cone_offset,
                reserved: [0.0; 3],
            }
        })
    }

    /// How much of its light the ground gets at a place, nothing in between.
    pub(crate) fn on_ground(&self, place: Vec3) -> f32 {
        let w = f64::from(self.light.w);
        let towards = vector(self.light.xyz) - w * place.as_dvec3();
        let direction = towards.normalize_or_zero();
        let distance = if w > 0.0 { towards.length() / w } else { 0.0 };
        let within = self.cone.map_or(1.0, |cone| {
            let [scale, offset] = cone_ramp(cone);
            let cosine = -vector(cone.direction).dot(direction) as f32;
            (cosine * scale + offset).clamp(0.0, 1.0).powi(2)
        });
        falloff(distance as f32, self.begin, self.range, self.exponent) * within * direction.y.max(0.0) as f32
    }

    /// The shadow that a point throws onto the ground, or as much of the way there as a picture should show.
    pub(crate) fn shadow_of(&self, point: [f32; 3], stage: &SceneBounds) -> [f32; 3] {
        self.shadow_within(point, stage, self.reach(stage))
    }

    /// The shadow that a point throws onto the ground, or what lies so many extents along the way there: the point itself
    /// where the light does not come, and no more of the way than the light goes.
    pub(crate) fn shadow_within(&self, point: [f32; 3], stage: &SceneBounds, extents: f64) -> [f32; 3] {
        let p = Vec3::from(point).as_dvec3();
        let Light { xyz, w, .. } = self.light;
        let away = f64::from(w) * p - Vec3::from(xyz).as_dvec3();
        let height = p.y - f64::from(stage.ground);
        let left = if w == 0.0 { f64::INFINITY } else { f64::from(self.range) - (p - self.place()).length() };
        let is_in_cone = self.cone.is_none_or(|cone| {
            vector(cone.direction).dot(away.normalize_or_zero()) >= f64::from(cone.outer_angle).cos()
        });
        if away.y >= 0.0 || height <= 0.0 || left <= 0.0 || !is_in_cone {
            return point;
        }
        let along: DVec3 = away * (height / -away.y);
        let most = (extents * f64::from(stage.extent)).min(left);
        (p + along.clamp_length_max(most)).as_vec3().into()
    }

    /// How far from a point the picture follows its shadow, in extents. Lights beside the models throw shadows one way;
    /// those among them all around, and the picture is of the models first.
    fn reach(&self, stage: &SceneBounds) -> f64 {
        const MOST: f64 = 1.3;
        if self.light.w == 0.0 {
            return MOST;
        }
        let (low, high) = (vector(stage.bounds.min), vector(stage.bounds.max));
        let outside = (self.place() - self.place().clamp(low, high)).length() / f64::from(stage.extent);
        MOST * (2.0 * outside).clamp(0.1, 1.0)
    }
}

/// The default size of a light with an area, over its distance: soft, and its samples' shadows run together.
const AREA_RADIUS: f64 = 0.04;

fn vector(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Illuminance of the file's light at the middle of the models, in lux, on a surface perpendicular to its rays. It
/// ignores range and cone. Lights among the models count as half their extent away.
fn illuminance(own: &SceneLight, stage: &SceneBounds) -> f64 {
    let intensity = f64::from(own.intensity);
    if own.light.w == 0.0 {
        return intensity;
    }
    let distance = (vector(own.light.xyz) - vector(stage.centre)).length().max(0.5 * f64::from(stage.extent));
    intensity / (distance * distance)
}

/// Scale and offset of the cosine that make the square root of a cone's share, as `KHR_lights_punctual` recommends.
fn cone_ramp(cone: SpotCone) -> [f32; 2] {
    let [inner, outer] = [cone.inner_angle, cone.outer_angle].map(|angle| f64::from(angle).cos());
    let scale = (inner - outer).max(1e-3).recip();
    [scale, -outer * scale].map(|c| c as f32)
}

/// Refuses options that none of the lights that they are given to can have.
fn check_options(spec: &ShadedLightSpec, lights: &[ChosenLight]) -> Result<(), UsageError> {
    let mut first = None;
    let mut wrong = 0;
    for ChosenLight { light, own } in lights {
        let Err(problem) = spec.check(*light, own.as_ref().and_then(|own| own.range)) else { continue };
        wrong += 1;
        let is_grave = matches!(problem, SpecError::BeginBeyondRange { .. });
        if is_grave || first.is_none() {
            let name = own.as_ref().and_then(|own| own.name.clone()).unwrap_or_default();
            first = Some(UsageError::LampOptions { name, problem });
        }
        if is_grave {
            wrong = lights.len();
            break;
        }
    }
    // With `file:all`, options apply to the lights that can have them.
    first.filter(|_| wrong == lights.len()).map_or(Ok(()), Err)
}

/// To the left of the eye, above, and a little before the models: their shadow falls beside them.
fn default_light(view: &PlacedView, stage: &SceneBounds) -> Light {
    let azimuth = AZIMUTH.to_radians();
    let target = vector(view.target.unwrap_or(stage.centre));
    let level = view.eye.map(|eye| (vector(eye) - target) * DVec3::new(1.0, 0.0, 1.0));
    let backward = level.and_then(DVec3::try_normalize).unwrap_or(DVec3::new(azimuth.sin(), 0.0, azimuth.cos()));
    let right = DVec3::Y.cross(backward);
    let towards = (-0.8 * right + 1.15 * DVec3::Y + 0.42 * backward).normalize();
    let place = vector(stage.centre) + 3.5 * f64::from(stage.extent) * towards;
    Light::point(place.as_vec3().into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec;

    const STAGE: SceneBounds = SceneBounds {
        centre: [0.0, 1.0, 0.0],
        extent: 2.0,
        ground: 0.0,
        bounds: Bounds { min: [-1.0, 0.0, -1.0], max: [1.0, 2.0, 1.0] },
    };

    fn chosen(light: Light, intensity: f32, range: Option<f32>) -> ChosenLight {
        let kind = rimline::gltf::SceneLightKind::Point;
        ChosenLight {
            light,
            own: Some(SceneLight { name: None, light, kind, color: [1.0; 3], intensity, range, cone: None }),
        }
    }

    fn shaded(light: Light) -> ShadedLight {
        let spec = spec::shaded("file:all").expect("a good light");
        ShadedLight::new(&spec, &chosen(light, 1.0, None), 1.0, &STAGE)
    }

    #[test]
    fn shadows_are_followed_far_from_beside_and_little_from_among_the_models() {
        let far = |light| {
            let [x, _, z] = shaded(light).shadow_of([0.5, 1.0, 0.0], &STAGE);
            f64::from(x - 0.5).hypot(f64::from(z))
        };
        assert!(far(Light::directional([-9.0, 1.0, 0.0])) > 2.0);
        assert!(far(Light::point([-90.0, 11.0, 0.0])) > 2.0);
        assert!(far(Light::point([0.0, 1.001, 0.0])) < 0.3);
    }

    #[test]
    fn shadows_end_where_the_light_does() {
        let at = |mut shaded: ShadedLight, range: f32| {
            shaded.range = range;
            shaded.shadow_of([0.5, 1.0, 0.0], &STAGE)
        };
        let above = || shaded(Light::point([0.5, 4.0, 0.0]));
        assert_eq!(at(above(), f32::INFINITY), [0.5, 0.0, 0.0]);
        assert_eq!(at(above(), 3.5), [0.5, 0.5, 0.0]);
        assert_eq!(at(above(), 2.0), [0.5, 1.0, 0.0]);
        let cone = SpotCone { direction: [1.0, 0.0, 0.0], inner_angle: 0.1, outer_angle: 0.5 };
        assert_eq!(at(ShadedLight { cone: Some(cone), ..above() }, f32::INFINITY), [0.5, 1.0, 0.0]);
    }

    #[test]
    fn the_files_brightest_light_counts_as_1() {
        let spec = spec::shaded("file:all").expect("a good light");
        let [near, far] = [2.0, 4.0].map(|x| chosen(Light::point([x, 1.0, 0.0]), 80.0, None));
        let brightest = near.own.as_ref().map_or(0.0, |own| illuminance(own, &STAGE));
        let color = |chosen| ShadedLight::new(&spec, chosen, brightest, &STAGE).color;
        assert_eq!((color(&near), color(&far)), ([1.0; 3], [0.25; 3]));
        assert_eq!(illuminance(&chosen(Light::directional([0.0, 3.0, 0.0]), 7.0, None).own.expect("own"), &STAGE), 7.0);
        let dark = ShadedLight::new(&spec, &chosen(Light::point([9.0; 3]), 0.0, None), 0.0, &STAGE);
        assert_eq!(dark.color, [0.0; 3]);
    }

    #[test]
    fn options_serve_those_lights_of_a_file_that_can_have_them() {
        let (point, sun) = (Light::point([1.0; 3]), Light::directional([1.0; 3]));
        let check =
            |text: &str, lights: &[ChosenLight]| check_options(&spec::shaded(text).expect(text), lights).is_ok();
        let both = [chosen(point, 1.0, Some(5.0)), chosen(sun, 1.0, None)];
        assert!(check("file:all,range=3", &both) && check("file:all,begin=3", &both));
        assert!(!check("file:all,range=3", &both[1..]) && !check("file:all,begin=3", &both[1..]));
        assert!(!check("file:all,begin=6", &both));
    }

    #[test]
    fn cones_are_whole_within_and_nothing_beyond() {
        let [scale, offset] = cone_ramp(SpotCone { direction: [0.0, -1.0, 0.0], inner_angle: 0.3, outer_angle: 0.6 });
        let share = |angle: f32| (angle.cos() * scale + offset).clamp(0.0, 1.0);
        assert!(share(0.29) == 1.0 && share(0.45) > 0.1 && share(0.45) < 0.9 && share(0.61) == 0.0);
    }
}
