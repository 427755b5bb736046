//! Contents of a glTF file other than its meshes.

use rimline::Origin;
use rimline::gltf::{Asset, SceneLight, SceneLightKind, SkippedPrimitives};
use serde_json::{Map, Value, json};

use super::text::{Text, point};
use crate::coordinates;
use crate::failure::Failure;
use crate::input::Input;
use crate::shown::Line;

/// A light at rest and its name. A damaged one has no more.
type NamedLight = (Option<String>, Option<SceneLight>);

pub(super) fn lights(asset: &Asset, input: &Input) -> Result<Vec<NamedLight>, Failure> {
    let lights = asset.each_light(None, 0.0).map_err(|error| Failure::input(&input.file)(error.into()))?;
    let names = asset.light_names().into_iter().map(|name| name.map(str::to_owned));
    Ok(names.zip(lights.into_iter().map(Result::ok)).collect())
}

pub(super) fn json(asset: &Asset, lights: &[NamedLight], value: &mut Map<String, Value>) {
    let skins = asset.skins().iter().map(|skin| json!({ "name": skin.name, "joints": skin.joints }));
    let animations = asset
        .animations()
        .iter()
        .map(|info| json!({ "name": info.name, "duration_seconds": info.duration_s, "channels": info.channels }));
    let lights = lights.iter().map(|(name, light)| {
        let kind = light.as_ref().map(|light| kind_name(light.kind));
        let xyzw = light.as_ref().map(|light| coordinates::light(&light.light, asset.origin()));
        json!({ "name": name, "kind": kind, "xyzw": xyzw })
    });
    let SkippedPrimitives { points, lines, without_position } = asset.skipped();
    let skipped = json!({ "points": points, "lines": lines, "without_position": without_position });
    value.insert("skins".into(), skins.collect());
    value.insert("animations".into(), animations.collect());
    value.insert("lights".into(), lights.collect());
    value.insert("skipped_primitives".into(), skipped);
}

pub(super) fn text(asset: &Asset, lights: &[NamedLight], text: &mut Text) {
    let shown = |name: &Option<String>| name.as_ref().map_or_else(String::new, |name| format!(" \"{}\"", Line(name)));
    let list = |text: &mut Text, name: &str, lines: Vec<String>| {
        text.line(name, lines.len());
        lines.into_iter().enumerate().for_each(|(index, line)| text.more(format!("  {index}{line}")));
    };
    let skins = asset.skins().iter();
    let skins = skins.map(|skin| format!("{}, {} joints", shown(&skin.name), skin.joints));
    list(text, "skins", skins.collect());
    let animations = asset.animations().iter();
    let animations = animations.map(|info| match info.fault {
        Some(_) => format!("{}, damaged", shown(&info.name)),
        None => format!("{}, {} s", shown(&info.name), info.duration_s),
    });
    list(text, "animations", animations.collect());
    let lights = lights.iter().map(|(name, light)| {
        let Some(light) = light else { return format!("{}, damaged", shown(name)) };
        let is_far = light.kind == SceneLightKind::Directional;
        let at = if is_far { "towards" } else { "at" };
        let position = point(light.light.xyz, if is_far { Origin::ZERO } else { asset.origin() });
        format!("{}, {}, {at} {position}", shown(name), kind_name(light.kind))
    });
    list(text, "lights", lights.collect());
    if asset.hidden_nodes() > 0 {
        text.line("hidden", format!("{} nodes, and what is on them", asset.hidden_nodes()));
    }
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
