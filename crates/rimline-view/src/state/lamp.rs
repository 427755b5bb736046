//! Lights of the viewer.

use glam::Vec3;
use rimline::gltf::{SceneLight, SpotCone};
use rimline::{AreaLight, AreaShape, Cone, Light};
use rimline_picture::Bounds;

/// Whether a light is at a point or at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampKind {
    /// At a point in world space.
    Point(Vec3),
    /// At infinity, in this direction from the scene, of length 1.
    Sun(Vec3),
}

/// A light of the viewer.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// Where it is.
    pub kind: LampKind,
    /// Linear red, green and blue.
    pub color: [f32; 3],
    /// A factor of the colour.
    pub intensity: f32,
    /// The distance at which a light at a point ends. `None`: it does not.
    pub range: Option<f32>,
    /// The direction in which a spot shines, of length 1, and the angle from there to where it has faded, in radians. A light
    /// at infinity ignores it.
    pub cone: Option<(Vec3, f32)>,
    /// The radius of the sphere that it shines from. A light at infinity has its sphere at distance 1. `None`: it shines
    /// from one point.
    pub radius: Option<f32>,
    /// Whether it shines.
    pub is_on: bool,
}

/// Lights that stand for a light with an area.
pub(crate) const AREA_SAMPLES: usize = 16;

/// Colours of the first lights; then from the beginning again.
const COLORS: [[f32; 3]; 6] = [
    [1.0, 0.93, 0.80],
    [0.42, 0.62, 1.0],
    [1.0, 0.50, 0.28],
    [0.55, 0.95, 0.60],
    [0.95, 0.48, 0.75],
    [0.75, 0.72, 1.0],
];

/// Lights that there may be at a time.
pub(crate) const MAX_LAMPS: usize = 8;

/// Directions of as many lights as there may be, from the middle of the models: +X is right, +Y up, +Z towards the front.
const DIRECTIONS: [Vec3; MAX_LAMPS] = [
    Vec3::new(-0.62, 1.25, 0.95),
    Vec3::new(1.25, 0.85, 0.35),
    Vec3::new(0.25, 1.0, -1.15),
    Vec3::new(-1.2, 0.7, -0.3),
    Vec3::new(0.9, 1.3, 0.9),
    Vec3::new(-0.2, 1.6, 0.1),
    Vec3::new(1.0, 0.9, -0.9),
    Vec3::new(-0.8, 1.1, -0.9),
];

impl Lamp {
    /// The light with this number around models in `bounds`. Those of eight numbers in a row are apart.
    pub fn around(bounds: &Bounds, number: usize) -> Self {
        let direction = DIRECTIONS[number % DIRECTIONS.len()].normalize();
        Self {
            kind: LampKind::Point(bounds.centre() + 1.05 * bounds.extent() * direction),
            color: COLORS[number % COLORS.len()],
            intensity: if number == 0 { 1.0 } else { 0.6 },
            range: None,
            cone: None,
            radius: None,
            is_on: true,
        }
    }

    /// The lights of a file around models in `bounds`. The brightest there counts as 1, and each does if all are dark.
    pub(super) fn all_of_file(lights: &[SceneLight], bounds: &Bounds) -> Vec<Self> {
        let illuminance = |light: &SceneLight| {
            if light.light.w == 0.0 {
                return light.intensity;
            }
            let distance = (Vec3::from(light.light.xyz) - bounds.centre()).length().max(0.5 * bounds.extent());
            light.intensity / (distance * distance)
        };
        let brightest = lights.iter().map(illuminance).fold(0.0, f32::max);
        // All may be dark, and squares of small distances are 0.
        let share = |light| Some(illuminance(light) / brightest).filter(|share| share.is_finite()).unwrap_or(1.0);
        lights.iter().map(|light| Self::of_file(light, share(light))).collect()
    }

    /// A light of a file, with `intensity` as its share of the brightest one's. Where a spot begins to fade is not kept.
    pub fn of_file(light: &SceneLight, intensity: f32) -> Self {
        let xyz = Vec3::from(light.light.xyz);
        let kind = if light.light.w == 0.0 { LampKind::Sun(xyz.normalize_or(Vec3::Y)) } else { LampKind::Point(xyz) };
        let cone = light.cone.map(|cone| (Vec3::from(cone.direction), cone.outer_angle));
        Self { kind, color: light.color, intensity, range: light.range, cone, radius: None, is_on: true }
    }

    /// The light as the library takes it.
    pub fn light(&self) -> Light {
        match self.kind {
            LampKind::Sun(towards) => Light::directional(towards.to_array()),
            LampKind::Point(at) => {
                let light = Light::point(at.to_array()).with_range(self.range.unwrap_or(f32::INFINITY));
                match self.cone {
                    Some((axis, angle)) => light.with_cone(Cone::new(axis.to_array(), angle)),
                    None => light,
                }
            }
        }
    }

    /// The cone of a spot, which begins to fade at four fifths of its angle.
    pub(crate) fn spot_cone(&self) -> Option<SpotCone> {
        let (LampKind::Point(_), Some((axis, outer_angle))) = (self.kind, self.cone) else { return None };
        Some(SpotCone { direction: axis.into(), inner_angle: 0.8 * outer_angle, outer_angle })
    }

    /// The lights that stand for this one: itself, or samples of its area.
    pub fn sources(&self) -> Vec<Self> {
        let Some(radius) = self.radius else { return vec![self.clone()] };
        let area = AreaLight { light: self.light(), shape: AreaShape::Sphere { radius }, normal: [0.0, 1.0, 0.0] };
        let source = |light: Light| {
            let xyz = Vec3::from(light.xyz);
            let kind = match self.kind {
                LampKind::Point(_) => LampKind::Point(xyz),
                LampKind::Sun(towards) => LampKind::Sun(xyz.normalize_or(towards)),
            };
            Self { kind, intensity: self.intensity / AREA_SAMPLES as f32, radius: None, ..self.clone() }
        };
        area.samples(AREA_SAMPLES).into_iter().map(source).collect()
    }

    /// Colour times intensity.
    pub fn shine(&self) -> Vec3 {
        Vec3::from(self.color) * self.intensity
    }

    /// The colour at full brightness, from 0 to 1 as the screen takes it.
    pub(crate) fn shown_color(&self) -> [f32; 3] {
        let brightest = self.color.iter().copied().fold(1e-6, f32::max);
        self.color.map(|c| (c / brightest).powf(1.0 / 2.2))
    }

    /// The point of its handle: the light itself, or for a light at infinity a point in its direction, near the models.
    pub fn handle(&self, bounds: &Bounds) -> Vec3 {
        match self.kind {
            LampKind::Point(at) => at,
            LampKind::Sun(towards) => bounds.centre() + sun_distance(bounds) * towards,
        }
    }

    /// The point that a spot is aimed at: on its axis, nearest to the middle of the models, but at least a little ahead.
    pub fn target(&self, bounds: &Bounds) -> Option<Vec3> {
        let (LampKind::Point(at), Some((axis, _))) = (self.kind, self.cone) else { return None };
        Some(at + (bounds.centre() - at).dot(axis).max(0.25 * bounds.extent()) * axis)
    }

    /// Aims a spot at a point. Others stay as they are.
    pub fn aim(&mut self, target: Vec3) {
        if let (LampKind::Point(at), Some((axis, _))) = (self.kind, &mut self.cone) {
            *axis = (target - at).normalize_or(*axis);
        }
    }

    /// Makes a light at a point a spot that is aimed at the middle of the models, or lets it shine all around again.
    pub fn set_spot(&mut self, is_spot: bool, bounds: &Bounds) {
        self.cone = is_spot.then_some((Vec3::NEG_Y, 25.0_f32.to_radians()));
        self.aim(bounds.centre());
    }

    /// Moves its handle. A spot stays aimed at the same point.
    pub fn move_to(&mut self, handle: Vec3, bounds: &Bounds) {
        let target = self.target(bounds);
        self.kind = match self.kind {
            LampKind::Point(_) => LampKind::Point(handle),
            LampKind::Sun(towards) => LampKind::Sun((handle - bounds.centre()).normalize_or(towards)),
        };
        if let Some(target) = target {
            self.aim(target);
        }
    }

    /// Makes a light at a point one at infinity in the same direction from the models, and the other way round. Its sphere
    /// looks as large from the middle of the models, up to a radius of 1 at infinity.
    pub fn change_kind(&mut self, bounds: &Bounds) {
        let handle = self.handle(bounds);
        let distance = handle.distance(bounds.centre());
        (self.kind, self.radius) = match self.kind {
            LampKind::Sun(_) => (LampKind::Point(handle), self.radius.map(|radius| radius * distance)),
            LampKind::Point(at) => {
                let towards = (at - bounds.centre()).normalize_or(Vec3::Y);
                (LampKind::Sun(towards), self.radius.map(|radius| (radius / distance).min(1.0)))
            }
        };
    }
}

/// How far from the middle of the models the handles of lights at infinity are.
pub(crate) fn sun_distance(bounds: &Bounds) -> f32 {
    bounds.extent()
}

#[cfg(test)]
mod tests {
    use rimline::gltf::SceneLightKind;

    use super::*;

    #[test]
    fn a_light_that_changes_its_kind_looks_as_large() {
        let bounds = Bounds { min: Vec3::splat(-50.0), max: Vec3::splat(50.0) };
        for (at, radius, of_sun) in [(512.0, 16.0, 0.03125), (8.0, 50.0, 1.0), (0.0, 50.0, 1.0)] {
            let kind = LampKind::Point(Vec3::new(0.0, at, 0.0));
            let mut lamp = Lamp { kind, radius: Some(radius), ..Lamp::around(&bounds, 0) };
            lamp.change_kind(&bounds);
            assert_eq!((lamp.kind, lamp.radius), (LampKind::Sun(Vec3::Y), Some(of_sun)));
            lamp.change_kind(&bounds);
            assert_eq!((lamp.kind, lamp.radius), (LampKind::Point(100.0 * Vec3::Y), Some(100.0 * of_sun)));
        }
    }

    #[test]
    fn lights_of_a_file_are_as_bright_as_their_shares() {
        for (size, intensities, shares) in
            [(1.0, [4.0, 1.0], [1.0, 0.25]), (1.0, [0.0, 0.0], [1.0, 1.0]), (1e-30, [4.0, 1.0], [1.0, 1.0])]
        {
            let lights = intensities.map(|intensity| SceneLight {
                name: None,
                light: Light::point([0.0, size, 0.0]),
                kind: SceneLightKind::Point,
                color: [1.0; 3],
                intensity,
                range: None,
                cone: None,
            });
            let bounds = Bounds { min: Vec3::splat(-size), max: Vec3::splat(size) };
            let found: Vec<f32> = Lamp::all_of_file(&lights, &bounds).iter().map(|lamp| lamp.intensity).collect();
            assert_eq!(found, shares, "{size}: {intensities:?}");
        }
    }
}
