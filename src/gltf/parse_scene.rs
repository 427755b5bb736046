//! Reads nodes, animations and lights of [`Document`](super::document::Document) from JSON.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DQuat, DVec3};
use gltf::json::animation::{Interpolation, Property};

use super::document::{Animation, ChannelTarget, Instancing, Node, PunctualLight, Sampler, Transform, Trs};
use super::error::GltfError;
use super::json::Json;
use super::lengths::Lengths;
use super::scene_light::SceneLightKind;
use super::transforms::{affine, unit};

pub(super) fn node(json: &Json<'_>, lengths: Lengths) -> Result<Node, GltfError> {
    let light = match json.extension("KHR_lights_punctual")? {
        Some(light) => light.required("light", light.index("light", "lights", lengths.lights)?).map(Some)?,
        None => None,
    };
    let instancing =
        json.extension("EXT_mesh_gpu_instancing")?.map(|extension| instancing(&extension, lengths)).transpose()?;
    Ok(Node {
        name: json.name()?,
        children: json.indices("children", "nodes", lengths.nodes)?,
        transform: transform(json)?,
        mesh: json.index("mesh", "meshes", lengths.meshes)?,
        skin: json.index("skin", "skins", lengths.skins)?,
        weights: json.numbers("weights")?,
        light,
        instancing,
    })
}

fn transform(json: &Json<'_>) -> Result<Transform, GltfError> {
    if let Some(matrix) = json.vector::<16>("matrix")? {
        return affine(matrix, || json.at("matrix")).map(Transform::Matrix);
    }
    let rotation = match json.vector::<4>("rotation")? {
        Some(rotation) => unit(rotation).ok_or_else(|| GltfError::Transform {
            place: json.at("rotation"),
            problem: "the quaternion has no direction; write (0, 0, 0, 1) for no rotation",
        })?,
        None => DQuat::IDENTITY,
    };
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

pub(super) fn light(json: &Json<'_>) -> Result<PunctualLight, GltfError> {
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
        name: json.name()?,
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

pub(super) fn animation(json: &Json<'_>, lengths: Lengths) -> Result<Animation, GltfError> {
    let samplers = json.objects("samplers")?.iter().map(|s| sampler(s, lengths)).collect::<Result<Vec<_>, _>>()?;
    let mut channels = Vec::new();
    for (channel, json) in json.objects("channels")?.iter().enumerate() {
        let sampler = json.required("sampler", json.index("sampler", "samplers", samplers.len())?)?;
        let target = json.required("target", json.object("target")?)?;
        let path = target.required("path", target.string("path")?)?;
        let Some(node) = target.index("node", "nodes", lengths.nodes)? else {
            log::warn!("{}: no target node, so the channel moves nothing", target.path());
            continue;
        };
        let property = match path {
            "translation" => Property::Translation,
            "rotation" => Property::Rotation,
            "scale" => Property::Scale,
            "weights" => Property::MorphTargetWeights,
            other => {
                let path = super::json::shorten(other);
                log::warn!("{}: the path {path:?} is not supported, so the channel moves nothing", target.path());
                continue;
            }
        };
        channels.push(ChannelTarget { channel, sampler, node, property });
    }
    Ok(Animation { name: json.name()?, samplers, channels })
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
