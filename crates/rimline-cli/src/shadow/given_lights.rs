//! Whether lights are those of a depth map that the caller made.

use glam::Vec3;
use rimline::{Light, Origin};

use super::given_map::GivenMap;
use super::shaded_lights::{SceneBounds, ShadedLight};
use crate::coordinates;
use crate::failure::UsageError;

/// Refuses lights that are not the map's.
pub(super) fn check_lights(
    map: &GivenMap,
    lights: &[ShadedLight],
    stage: &SceneBounds,
    origin: Origin,
) -> Result<(), UsageError> {
    /// How far a light may be off, as a share of its distance or of the extent of the models.
    const MOST: f64 = 1e-3;
    /// Extents that count as any distance beyond them, and as a light at infinity.
    const FAR: f64 = 1e9;
    let [shaded] = lights else { return Err(UsageError::DepthLights { count: lights.len() }) };
    let centre = Vec3::from(stage.centre).as_dvec3();
    // In extents from the middle of the models.
    let place = |light: &Light| {
        let towards = Vec3::from(light.xyz).as_dvec3() - f64::from(light.w) * centre;
        let distance = if light.w == 0.0 { FAR } else { towards.length() / f64::from(light.w * stage.extent) };
        towards.normalize_or_zero() * distance.min(FAR)
    };
    let (map, given) = (map.cameras.light(), shaded.light);
    let is_near = (place(&map) - place(&given)).length() <= MOST * place(&given).length().max(1.0);
    if !is_near {
        return Err(UsageError::DepthLightApart { given: spec(&given, origin), map: spec(&map, origin) });
    }
    Ok(())
}

/// A light as it is given on the command line.
fn spec(light: &Light, origin: Origin) -> String {
    let at = |w: f32| coordinates::point(light.xyz, Origin::new(origin.to_array().map(|c| f64::from(w) * c)));
    match light.w {
        0.0 => format!("dir:{}", at(0.0)),
        1.0 => format!("point:{}", at(1.0)),
        w => format!("hom:{},{w}", at(w)),
    }
}
