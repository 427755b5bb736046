//! Lights of the command line and of files, as a picture has them.

use glam::{DVec3, Vec3};
use rimline::gltf::{SceneLight, SpotCone};
use rimline::internals::light::check_shadow_lights;
use rimline::{AreaLight, AreaShape, Light, Origin};
use rimline_picture::{SceneBounds, ShadedLight};

use crate::coordinates::relative;
use crate::failure::{Failure, UsageError};
use crate::input::ChosenLight;
use crate::input_args::PlacedView;
use crate::render::camera::AZIMUTH;
use crate::shadow::args::ShadowSceneArgs;
use crate::spec::{AreaSpec, LightSpec, ShadedLightSpec, SpecError};

use super::posed_model::PosedModel;

/// A little warm.
const DEFAULT_COLOR: [f32; 3] = [1.0, 0.95, 0.87];

/// The lights of the command line, or else `file_light`, or the one that is there by default.
pub(crate) fn shaded_lights(
    args: &ShadowSceneArgs,
    (first, view): (&PosedModel<'_>, &PlacedView),
    stage: &SceneBounds,
    file_light: Option<Light>,
) -> Result<Vec<ShadedLight>, Failure> {
    let mut chosen = Vec::new();
    for spec in &args.lights {
        let wanted = std::slice::from_ref(&spec.light);
        let lights = first.input.chosen_lights(wanted, first.animations, args.posed.pose.time)?;
        check_options(spec, &lights)?;
        chosen.extend(lights.into_iter().map(|light| (spec, light)));
    }
    let of_file = chosen.iter().filter_map(|(_, chosen)| chosen.of_file.as_ref());
    let brightest = of_file.map(|of_file| illuminance(of_file, stage)).fold(0.0, f64::max);
    let origin = first.input.origin();
    let mut shaded_lights = Vec::new();
    for (spec, chosen) in &chosen {
        shaded_lights.push(ShadedLight {
            cone: cone(spec, chosen, stage, origin).map_err(|problem| lamp_options(chosen, problem))?,
            ..shaded(spec, chosen, brightest, stage)
        });
    }
    if shaded_lights.is_empty() {
        let light = file_light.unwrap_or_else(|| default_light(view, stage));
        let spec = ShadedLightSpec { color: Some(DEFAULT_COLOR), ..ShadedLightSpec::new(LightSpec::All) };
        shaded_lights.push(shaded(&spec, &ChosenLight { light, of_file: None }, 0.0, stage));
    }
    // Once for every way to cast: depth maps and areas would take such a light for another.
    let lights: Vec<Light> = shaded_lights.iter().map(|shaded| shaded.light).collect();
    check_shadow_lights(&lights, usize::MAX).map_err(UsageError::Lights)?;
    let sphere = |radius| AreaSpec::Given(AreaShape::Sphere { radius });
    let areas = chosen.iter().map(|(spec, _)| spec.radius.map(sphere)).chain([None]);
    for (shaded, area) in shaded_lights.iter_mut().zip(areas) {
        if let Some(area) = area.or(args.area) {
            spread(shaded, area, args.samples(), stage);
        }
    }
    Ok(shaded_lights)
}

/// Takes a light's options from the command line, or else from the file. The brightest light of its file counts as 1.
fn shaded(spec: &ShadedLightSpec, chosen: &ChosenLight, brightest: f64, stage: &SceneBounds) -> ShadedLight {
    let light = chosen.light;
    let of_file = chosen.of_file.as_ref();
    let relative = |of_file| if brightest > 0.0 { (illuminance(of_file, stage) / brightest) as f32 } else { 0.0 };
    let intensity = spec.intensity.or_else(|| of_file.map(relative)).unwrap_or(1.0);
    let color = spec.color.or(of_file.map(|of_file| of_file.color)).unwrap_or([1.0; 3]);
    let range = spec.range.or(of_file.and_then(|of_file| of_file.range)).unwrap_or(f32::INFINITY);
    ShadedLight {
        color: color.map(|c| c * intensity),
        range: if light.w == 0.0 { f32::INFINITY } else { range },
        begin: spec.begin.unwrap_or(0.0),
        exponent: spec.exponent.unwrap_or(1.0),
        ..ShadedLight::new(light)
    }
}

/// The cone of a spot: from the command line, or else from the file.
fn cone(
    spec: &ShadedLightSpec,
    chosen: &ChosenLight,
    stage: &SceneBounds,
    origin: Origin,
) -> Result<Option<SpotCone>, SpecError> {
    let of_file = chosen.of_file.as_ref().and_then(|of_file| of_file.cone);
    let given = spec.cone.filter(|_| chosen.light.w != 0.0).map(|angles| angles.map(f32::to_radians));
    let Some([inner_angle, outer_angle]) = given.or(of_file.map(|cone| [cone.inner_angle, cone.outer_angle])) else {
        return Ok(None);
    };
    let direction = match (spec.target, of_file) {
        (None, Some(cone)) => cone.direction,
        (target, _) => {
            let target = target.map_or(stage.models.centre(), |target| relative(target, origin).into());
            let way = target.as_dvec3() - ShadedLight::new(chosen.light).position_or_direction();
            way.try_normalize().ok_or(SpecError::TargetAtLight)?.as_vec3().into()
        }
    };
    Ok(Some(SpotCone { direction, inner_angle, outer_angle }))
}

fn spread(shaded: &mut ShadedLight, area: AreaSpec, count: usize, stage: &SceneBounds) {
    let normal = stage.models.centre().as_dvec3() - shaded.position_or_direction();
    let distance = normal.length().max(1e-3 * f64::from(stage.models.extent()));
    let shape = match area {
        AreaSpec::Given(shape) => shape,
        AreaSpec::Chosen(shape) => {
            let by = (AREA_RADIUS * if shaded.light.w == 0.0 { 1.0 } else { distance }) as f32;
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
    let area = AreaLight { light: shaded.light, shape, normal };
    shaded.samples = area.samples(count);
    shaded.area = Some(area);
}

/// The default size of a light with an area, over its distance: soft, and its samples' shadows run together.
const AREA_RADIUS: f64 = 0.04;

fn vector(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Illuminance of the file's light at the middle of the models, in lux, on a surface perpendicular to its rays. It
/// ignores range and cone. Lights among the models count as half their extent away.
fn illuminance(light: &SceneLight, stage: &SceneBounds) -> f64 {
    let intensity = f64::from(light.intensity);
    if light.light.w == 0.0 {
        return intensity;
    }
    let distance = (vector(light.light.xyz) - stage.models.centre().as_dvec3())
        .length()
        .max(0.5 * f64::from(stage.models.extent()));
    intensity / (distance * distance)
}

fn lamp_options(light: &ChosenLight, problem: SpecError) -> UsageError {
    match &light.of_file {
        Some(of_file) => UsageError::LampOptions { name: of_file.name.clone().unwrap_or_default(), problem },
        None => UsageError::Lamp(problem),
    }
}

/// Refuses options that none of the lights that they are given to can have.
fn check_options(spec: &ShadedLightSpec, lights: &[ChosenLight]) -> Result<(), UsageError> {
    let mut first = None;
    let mut wrong = 0;
    for chosen in lights {
        let Err(problem) = spec.check(chosen.light, chosen.of_file.as_ref()) else { continue };
        wrong += 1;
        let is_grave = matches!(problem, SpecError::BeginBeyondRange { .. });
        if is_grave || first.is_none() {
            first = Some(lamp_options(chosen, problem));
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
    let target = view.target.map_or(stage.models.centre().as_dvec3(), vector);
    let towards_eye = match (view.eye, view.side, &view.camera) {
        (Some(eye), ..) => vector(eye) - target,
        (_, Some(side), _) => DVec3::from(side.directions().0),
        (.., Some(camera)) => -vector(camera.forward),
        _ => DVec3::ZERO,
    };
    let level = (towards_eye * DVec3::new(1.0, 0.0, 1.0)).try_normalize();
    let backward = level.unwrap_or(DVec3::new(azimuth.sin(), 0.0, azimuth.cos()));
    let right = DVec3::Y.cross(backward);
    let towards = (-0.8 * right + 1.15 * DVec3::Y + 0.42 * backward).normalize();
    let position = stage.models.centre().as_dvec3() + 3.5 * f64::from(stage.models.extent()) * towards;
    Light::point(position.as_vec3().into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec;
    use rimline_picture::Bounds;

    const STAGE: SceneBounds =
        SceneBounds { models: Bounds { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) }, ground: 0.0 };

    fn chosen(light: Light, intensity: f32, range: Option<f32>) -> ChosenLight {
        let kind = rimline::gltf::SceneLightKind::Point;
        ChosenLight {
            light,
            of_file: Some(SceneLight { name: None, light, kind, color: [1.0; 3], intensity, range, cone: None }),
        }
    }

    #[test]
    fn the_files_brightest_light_counts_as_1() {
        let spec = spec::shaded("file:all").expect("a good light");
        let [near, far] = [2.0, 4.0].map(|x| chosen(Light::point([x, 1.0, 0.0]), 80.0, None));
        let brightest = near.of_file.as_ref().map_or(0.0, |of_file| illuminance(of_file, &STAGE));
        let color = |chosen| shaded(&spec, chosen, brightest, &STAGE).color;
        assert_eq!((color(&near), color(&far)), ([1.0; 3], [0.25; 3]));
        assert_eq!(
            illuminance(&chosen(Light::directional([0.0, 3.0, 0.0]), 7.0, None).of_file.expect("own"), &STAGE),
            7.0
        );
        let dark = shaded(&spec, &chosen(Light::point([9.0; 3]), 0.0, None), 0.0, &STAGE);
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
}
