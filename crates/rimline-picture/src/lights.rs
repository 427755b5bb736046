//! Lights as a picture has them: colour, reach, samples.

use glam::{DVec3, Vec3};
use rimline::gltf::SpotCone;
use rimline::{AreaLight, Light, falloff};

use crate::bounds::SceneBounds;
use crate::camera::Camera;

/// A light that shines on a picture.
#[derive(Clone, Debug)]
pub struct ShadedLight {
    /// Where it is.
    pub light: Light,
    /// Linear red, green and blue, times its intensity.
    pub color: [f32; 3],
    /// Where it ends. Infinite: nowhere; it must be so for a light at infinity.
    pub range: f32,
    /// Where it begins to fade.
    pub begin: f32,
    /// How it fades, as [`falloff`] has it.
    pub exponent: f32,
    /// The cone of a spot.
    pub cone: Option<SpotCone>,
    /// The light itself, or those that stand for its area.
    pub samples: Vec<Light>,
    /// The area that the samples are of.
    pub area: Option<AreaLight>,
    /// The index of the lists of silhouettes that overlays show for all samples together. `None`: overlays show each sample
    /// by itself, and its lists have its index.
    pub shown: Option<u32>,
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
    silhouettes: u32,
    reserved: [f32; 2],
}

impl ShadedLight {
    /// A white light that reaches everything.
    pub fn new(light: Light) -> Self {
        let (range, samples) = (f32::INFINITY, vec![light]);
        Self { light, color: [1.0; 3], range, begin: 0.0, exponent: 1.0, cone: None, samples, area: None, shown: None }
    }

    /// Takes samples of one of several patterns, if the light has an area.
    pub fn take_pattern(&mut self, pattern: usize, patterns: usize) {
        if let Some(area) = &self.area {
            self.samples = area.pattern_samples(self.samples.len(), pattern, patterns);
        }
    }

    /// The position of a light at a point, the direction to another.
    pub fn position_or_direction(&self) -> DVec3 {
        let xyz = vector(self.light.xyz);
        if self.light.w == 0.0 { xyz } else { xyz / f64::from(self.light.w) }
    }

    /// Its samples, as the shadow volumes take them.
    pub fn ranged(&self) -> impl Iterator<Item = Light> + '_ {
        self.samples.iter().map(|light| light.with_range(self.range))
    }

    /// Its samples, as the shaders take them; `first` is the number of the first among those of all `lights`.
    pub(crate) fn data(
        &self,
        camera: &Camera,
        unit: f32,
        first: usize,
        lights: usize,
    ) -> impl Iterator<Item = ShadedLightData> {
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
                density: self.shown.map_or(share, |_| 1.0) / lights as f32,
                axis: self.cone.map_or([0.0; 3], |cone| cone.direction),
                cone_scale,
                cone_offset,
                silhouettes: self.shown.unwrap_or(number as u32) % 32,
                reserved: [0.0; 2],
            }
        })
    }

    /// How much of its light the ground gets at a point, nothing in between.
    pub(crate) fn on_ground(&self, point: Vec3) -> f32 {
        let w = f64::from(self.light.w);
        let towards = vector(self.light.xyz) - w * point.as_dvec3();
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
    pub fn shadow_of(&self, point: [f32; 3], bounds: &SceneBounds) -> [f32; 3] {
        self.shadow_within(point, bounds, self.reach(bounds))
    }

    /// The shadow that a point throws onto the ground, or what lies so many extents along the way there: the point itself
    /// where it throws none or the light does not come, and no more of the way than the light goes.
    pub fn shadow_within(&self, point: [f32; 3], bounds: &SceneBounds, extents: f64) -> [f32; 3] {
        let p = Vec3::from(point).as_dvec3();
        let Light { xyz, w, .. } = self.light;
        let away = f64::from(w) * p - Vec3::from(xyz).as_dvec3();
        let height = p.y - f64::from(bounds.ground);
        let left =
            if w == 0.0 { f64::INFINITY } else { f64::from(self.range) - (p - self.position_or_direction()).length() };
        let is_in_cone = self.cone.is_none_or(|cone| {
            vector(cone.direction).dot(away.normalize_or_zero()) >= f64::from(cone.outer_angle).cos()
        });
        if away.y >= 0.0 || height <= 0.0 || left <= 0.0 || !is_in_cone {
            return point;
        }
        let along: DVec3 = away * (height / -away.y);
        let most = (extents * f64::from(bounds.models.extent())).min(left);
        (p + along.clamp_length_max(most)).as_vec3().into()
    }

    /// How far from a point the picture follows its shadow, in extents. Lights beside the models throw shadows one way;
    /// those among them all around, and the picture is of the models first.
    fn reach(&self, bounds: &SceneBounds) -> f64 {
        const MOST: f64 = 1.3;
        if self.light.w == 0.0 {
            return MOST;
        }
        let (low, high) = (bounds.models.min.as_dvec3(), bounds.models.max.as_dvec3());
        let outside = (self.position_or_direction() - self.position_or_direction().clamp(low, high)).length()
            / f64::from(bounds.models.extent());
        MOST * (2.0 * outside).clamp(0.1, 1.0)
    }
}

/// How far from below the models' middle the shadows of points on the ground lie, or the points that throw none; at most 60
/// extents of the models.
pub fn reach(lights: &[ShadedLight], points: &[[f32; 3]], bounds: &SceneBounds) -> f32 {
    const MOST: f64 = 60.0;
    let centre = bounds.models.centre();
    let from_centre = |[a, _, b]: [f32; 3]| (a - centre.x).hypot(b - centre.z);
    let shadows =
        lights.iter().flat_map(|shaded| points.iter().map(|&point| shaded.shadow_within(point, bounds, MOST)));
    shadows.map(from_centre).fold(0.0, f32::max).min(MOST as f32 * bounds.models.extent())
}

fn vector(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Scale and offset of the cosine that make the square root of a cone's share, as `KHR_lights_punctual` recommends.
fn cone_ramp(cone: SpotCone) -> [f32; 2] {
    let [inner, outer] = [cone.inner_angle, cone.outer_angle].map(|angle| f64::from(angle).cos());
    let scale = (inner - outer).max(1e-3).recip();
    [scale, -outer * scale].map(|c| c as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Bounds;

    const SCENE: SceneBounds =
        SceneBounds { models: Bounds { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) }, ground: 0.0 };

    #[test]
    fn shadows_are_followed_far_from_beside_and_little_from_among_the_models() {
        let far = |light| {
            let [x, _, z] = ShadedLight::new(light).shadow_of([0.5, 1.0, 0.0], &SCENE);
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
            shaded.shadow_of([0.5, 1.0, 0.0], &SCENE)
        };
        let above = || ShadedLight::new(Light::point([0.5, 4.0, 0.0]));
        assert_eq!(at(above(), f32::INFINITY), [0.5, 0.0, 0.0]);
        assert_eq!(at(above(), 3.5), [0.5, 0.5, 0.0]);
        assert_eq!(at(above(), 2.0), [0.5, 1.0, 0.0]);
        let cone = SpotCone { direction: [1.0, 0.0, 0.0], inner_angle: 0.1, outer_angle: 0.5 };
        assert_eq!(at(ShadedLight { cone: Some(cone), ..above() }, f32::INFINITY), [0.5, 1.0, 0.0]);
    }

    #[test]
    fn silhouettes_count_from_the_first_of_their_batch() {
        let (eye, right, up, forward) = (Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_Z);
        let camera = Camera { eye, right, up, forward, scale: [1.0; 2], near: 0.1, far: None };
        for (shown, expected) in [(None, 1), (Some(3), 3), (Some(34), 2)] {
            let shaded = ShadedLight { shown, ..ShadedLight::new(Light::directional([0.0, 1.0, 0.0])) };
            let found: Vec<u32> = shaded.data(&camera, 1.0, 33, 40).map(|data| data.silhouettes).collect();
            assert_eq!(found, [expected], "{shown:?}");
        }
    }

    #[test]
    fn cones_are_whole_within_and_nothing_beyond() {
        let [scale, offset] = cone_ramp(SpotCone { direction: [0.0, -1.0, 0.0], inner_angle: 0.3, outer_angle: 0.6 });
        let share = |angle: f32| (angle.cos() * scale + offset).clamp(0.0, 1.0);
        assert!(share(0.29) == 1.0 && share(0.45) > 0.1 && share(0.45) < 0.9 && share(0.61) == 0.0);
    }
}
