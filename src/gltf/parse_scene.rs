//! Reads nodes, animations and lights of [`Document`](super::document::Document) from JSON.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DQuat, DVec3};
use gltf::json::animation::{Interpolation, Property};

use super::document::{
    Animation, ChannelTarget, Instancing, NamedLight, Node, Part, PunctualLight, Sampler, Transform, Trs,
};
use super::error::GltfError;
use super::json::{Json, shorten};
use super::lengths::Lengths;
use super::scene_light::SceneLightKind;
use super::transforms::{affine, unit};
use super::warning::{GltfWarning, Warnings};

/// Reads a node. An error in its content becomes its fault. A light reference keeps its own fault.
pub(super) fn node(
    json: Result<Json<'_>, GltfError>,
    lengths: Lengths,
    warnings: &Warnings<'_>,
) -> Result<Node, GltfError> {
    let json = match warnings.keep(json)? {
        Ok(json) => json,
        Err(fault) => return Ok(Node { fault: Some(fault), ..Node::default() }),
    };
    let (name, light) = (json.name(warnings)?, light_index(&json, lengths, warnings)?);
    Ok(match warnings.keep(node_content(&json, lengths, warnings))? {
        Ok(node) => Node { name, light, ..node },
        Err(fault) => Node { name, light, fault: Some(fault), ..Node::default() },
    })
}

fn light_index(json: &Json<'_>, lengths: Lengths, warnings: &Warnings<'_>) -> Result<Option<Part<usize>>, GltfError> {
    let index = || match json.extension("KHR_lights_punctual")? {
        Some(light) => light.required("light", light.index("light", "lights", lengths.lights)?).map(Some),
        None => Ok(None),
    };
    Ok(warnings.keep(index())?.transpose())
}

fn node_content(json: &Json<'_>, lengths: Lengths, warnings: &Warnings<'_>) -> Result<Node, GltfError> {
    let children = json.indices("children", "nodes", lengths.nodes)?;
    let transform = transform(json, warnings)?;
    let is_hidden = match json.extension("KHR_node_visibility")? {
        Some(visibility) => visibility.value("visible").is_some() && !visibility.flag("visible")?,
        None => false,
    };
    let mesh = json.index("mesh", "meshes", lengths.meshes)?;
    let skin = json.index("skin", "skins", lengths.skins);
    let weights = json.numbers("weights");
    let instancing =
        || json.extension("EXT_mesh_gpu_instancing")?.map(|extension| instancing(&extension, lengths)).transpose();
    let (skin, weights, instancing) = if mesh.is_some() {
        (skin?, weights?, instancing()?)
    } else {
        // Without a mesh they do nothing.
        let skin = warnings.leave_out(skin)?.flatten();
        (skin, warnings.leave_out(weights)?.flatten(), warnings.leave_out(instancing())?.flatten())
    };
    Ok(Node { name: None, children, transform, mesh, skin, weights, light: None, instancing, is_hidden, fault: None })
}

fn transform(json: &Json<'_>, warnings: &Warnings<'_>) -> Result<Transform, GltfError> {
    if let Some(matrix) = json.vector::<16>("matrix")? {
        return affine(matrix, || json.at("matrix")).map(Transform::Matrix);
    }
    let mut rotation = DQuat::IDENTITY;
    if let Some(given) = json.vector::<4>("rotation")? {
        match unit(given) {
            Some(unit) => rotation = unit,
            // Numbers of JSON are finite, so the length is 0.
            None => warnings.push(GltfWarning::Rotation { place: json.at("rotation") })?,
        }
    }
    Ok(Transform::Trs(Trs {
        translation: json.vector("translation")?.map_or(DVec3::ZERO, DVec3::from_array),
        rotation,
        scale: json.vector("scale")?.map_or(DVec3::ONE, DVec3::from_array),
    }))
}

fn instancing(json: &Json<'_>, lengths: Lengths) -> Result<Instancing, GltfError> {
    let attributes = json.required("attributes", json.object("attributes")?)?;
    let index = |key: &str| attributes.index(key, "accessors", lengths.accessors);
    Ok(Instancing { translation: index("TRANSLATION")?, rotation: index("ROTATION")?, scale: index("SCALE")? })
}

/// Reads a light. An error in it becomes its fault.
pub(super) fn light(json: Result<Json<'_>, GltfError>, warnings: &Warnings<'_>) -> Result<NamedLight, GltfError> {
    let json = match warnings.keep(json)? {
        Ok(json) => json,
        Err(fault) => return Ok(NamedLight { name: None, light: Err(fault) }),
    };
    Ok(NamedLight { name: json.name(warnings)?, light: warnings.keep(light_content(&json))? })
}

fn light_content(json: &Json<'_>) -> Result<PunctualLight, GltfError> {
    let kind = match json.required("type", json.string("type")?)? {
        "directional" => SceneLightKind::Directional,
        "point" => SceneLightKind::Point,
        "spot" => SceneLightKind::Spot,
        _ => return Err(json.wrong("type", "directional, point or spot")),
    };
    let color = json.vector("color")?.unwrap_or([1.0; 3]);
    let intensity = json.number("intensity")?.unwrap_or(1.0);
    let range = json.number("range")?;
    if color.iter().any(|&c| c < 0.0) {
        return Err(json.wrong("color", "three numbers of 0 or more"));
    }
    if intensity < 0.0 {
        return Err(json.wrong("intensity", "a number of 0 or more"));
    }
    if range.is_some_and(|range| range <= 0.0) {
        return Err(json.wrong("range", "a number of more than 0"));
    }
    let single = |value: f64| (value as f32).min(f32::MAX);
    Ok(PunctualLight {
        kind,
        color: color.map(single),
        intensity: single(intensity),
        // A range has no meaning at infinity.
        range: range.filter(|_| kind != SceneLightKind::Directional).map(|range| single(range).max(f32::MIN_POSITIVE)),
        cone: (kind == SceneLightKind::Spot).then(|| cone(json)).transpose()?,
    })
}

/// The inner and outer angle of a spot light's cone.
fn cone(json: &Json<'_>) -> Result<[f32; 2], GltfError> {
    /// How far rounding on export may take half the cone's angle past a right angle.
    const TOLERANCE: f64 = 1e-5;
    let Some(spot) = json.object("spot")? else { return Ok([0.0, FRAC_PI_4 as f32]) };
    let inner = spot.number("innerConeAngle")?.unwrap_or(0.0);
    let outer = spot.number("outerConeAngle")?.unwrap_or(FRAC_PI_4);
    if !(outer > 0.0 && outer <= FRAC_PI_2 + TOLERANCE) {
        return Err(spot.wrong("outerConeAngle", "an angle of more than 0 and at most a quarter turn, in radians"));
    }
    // A cone without a soft rim has two equal angles, though the extension asks for a smaller inner one.
    if !(inner >= 0.0 && inner <= outer) {
        return Err(spot.wrong("innerConeAngle", "an angle from 0 to that of the outer cone, in radians"));
    }
    Ok([inner, outer].map(|angle| angle.min(FRAC_PI_2) as f32))
}

/// Reads an animation. An error in it becomes its fault.
pub(super) fn animation(
    json: Result<Json<'_>, GltfError>,
    lengths: Lengths,
    warnings: &Warnings<'_>,
) -> Result<Animation, GltfError> {
    let json = match warnings.keep(json)? {
        Ok(json) => json,
        Err(fault) => return Ok(Animation { fault: Some(fault), ..Animation::default() }),
    };
    let name = json.name(warnings)?;
    Ok(match warnings.keep(animation_content(&json, lengths, warnings))? {
        Ok(animation) => Animation { name, ..animation },
        Err(fault) => Animation { name, fault: Some(fault), ..Animation::default() },
    })
}

fn animation_content(json: &Json<'_>, lengths: Lengths, warnings: &Warnings<'_>) -> Result<Animation, GltfError> {
    let samplers = json.objects("samplers")?.iter().map(|s| sampler(s, lengths)).collect::<Result<Vec<_>, _>>()?;
    let mut channels = Vec::new();
    for (channel, json) in json.objects("channels")?.iter().enumerate() {
        let sampler = json.required("sampler", json.index("sampler", "samplers", samplers.len())?)?;
        let target = json.required("target", json.object("target")?)?;
        match channel_target(&target, lengths)? {
            Ok((node, property)) => channels.push(ChannelTarget { channel, sampler, node, property }),
            Err(problem) => warnings.push(GltfWarning::Channel { place: json.path().to_owned(), problem })?,
        }
    }
    Ok(Animation { name: None, samplers, channels, fault: None })
}

/// The target of a channel, or why it moves nothing.
fn channel_target(target: &Json<'_>, lengths: Lengths) -> Result<Result<(usize, Property), String>, GltfError> {
    let path = target.required("path", target.string("path")?)?;
    if let Ok(Some(extension)) = target.extension("KHR_animation_pointer")
        && let Ok(Some(pointer)) = extension.string("pointer")
    {
        return Ok(Err(format!("the pointer {:?} is not read", shorten(pointer))));
    }
    let Some(node) = target.index("node", "nodes", lengths.nodes)? else {
        return Ok(Err("it has no target node".to_owned()));
    };
    let property = property(path).map(|property| (node, property));
    Ok(property.ok_or_else(|| format!("the path {:?} is not supported", shorten(path))))
}

fn property(path: &str) -> Option<Property> {
    Some(match path {
        "translation" => Property::Translation,
        "rotation" => Property::Rotation,
        "scale" => Property::Scale,
        "weights" => Property::MorphTargetWeights,
        _ => return None,
    })
}

fn sampler(json: &Json<'_>, lengths: Lengths) -> Result<Sampler, GltfError> {
    let accessor = |key: &str| json.required(key, json.index(key, "accessors", lengths.accessors)?);
    let interpolation = match json.string("interpolation")? {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(_) => return Err(json.wrong("interpolation", "LINEAR, STEP or CUBICSPLINE")),
    };
    Ok(Sampler { input: accessor("input")?, output: accessor("output")?, interpolation })
}
