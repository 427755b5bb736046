//! What a glTF file holds besides its meshes.

use rimline::Origin;
use rimline::gltf::{Asset, SceneLight, SceneLightKind, SkippedPrimitives};
use serde_json::{Map, Value, json};

use super::text::{Text, point};
use crate::coordinates;
use crate::failure::Failure;
use crate::input::Input;
use crate::shown::Line;

/// The file's lights at rest.
pub(super) fn lights(asset: &Asset, input: &Input) -> Result<Vec<SceneLight>, Failure> {
    asset.lights(None, 0.0).map_err(|error| Failure::input(&input.file)(error.into()))
}

pub(super) fn json(asset: &Asset, lights: &[SceneLight], value: &mut Map<String, Value>) {
    let skins = asset.skins().iter().map(|skin| json!({ "name": skin.name, "joints": skin.joints }));
    let animations = asset
        .animations()
        .iter()
        .map(|info| json!({ "name": info.name, "duration_seconds": info.duration_s, "channels": info.channels }));
    let lights = lights
        .iter()
        .map(|light| json!({ "name": light.name, "kind": kind_name(light.kind), "xyzw": coordinates::light(&light.light, asset.origin()) }));
    let SkippedPrimitives { points, lines, without_position } = asset.skipped();
    let skipped = json!({ "points": points, "lines": lines, "without_position": without_position });
    value.insert("skins".into(), skins.collect());
    value.insert("animations".into(), animations.collect());
    value.insert("lights".into(), lights.collect());
    value.insert("skipped_primitives".into(), skipped);
}

pub(super) fn text(asset: &Asset, lights: &[SceneLight], text: &mut Text) {
    let shown = |name: &Option<String>| name.as_ref().map_or_else(String::new, |name| format!(" \"{}\"", Line(name)));
    let list = |text: &mut Text, name: &str, lines: Vec<String>| {
        text.line(name, lines.len());
        lines.into_iter().enumerate().for_each(|(index, line)| text.more(format!("  {index}{line}")));
    };
    let skins = asset.skins().iter();
    let skins = skins.map(|skin| format!("{}, {} joints", shown(&skin.name), skin.joints));
    list(text, "skins", skins.collect());
    let animations = asset.animations().iter();
    let animations = animations.map(|info| format!("{}, {} s", shown(&info.name), info.duration_s));
    list(text, "animations", animations.collect());
    let lights = lights.iter().map(|light| {
        let is_far = light.kind == SceneLightKind::Directional;
        let at = if is_far { "towards" } else { "at" };
        let place = point(light.light.xyz, if is_far { Origin::ZERO } else { asset.origin() });
        format!("{}, {}, {at} {place}", shown(&light.name), kind_name(light.kind))
    });
    list(text, "lights", lights.collect());
    let SkippedPrimitives { points, lines, without_position } = asset.skipped();
    if (points, lines, without_position) != (0, 0, 0) {
        text.line("skipped", format!("{points} point, {lines} line primitives, {without_position} without positions"));
    }
}

fn kind_name(kind: SceneLightKind) -> &'static str {
    match kind {
        SceneLightKind::Directional => "directional",
        SceneLightKind::Point => "point",
        SceneLightKind::Spot => "spot",
        _ => "other",
    }
}
