//! Reads nodes, animations, lights and cameras of [`Document`](super::document::Document) from JSON.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DQuat, DVec3};

use super::camera::CameraProjection;
use super::document::{
    Animation, ChannelTarget, INSTANCED, Interpolation, Mesh, Named, Node, Part, Property, PunctualLight, Sampler, Trs,
    affine, unit,
};
use super::error::GltfError;
use super::info::SceneLightKind;
use super::json::{Json, List, shorten};
use super::parse::Parser;
use super::warning::GltfWarning;

impl Parser<'_> {
    /// The light of a node.
    pub(super) fn light_index(&self, json: &Json<'_>) -> Result<Option<Part<usize>>, GltfError> {
        let index = || match json.extension("KHR_lights_punctual")? {
            Some(light) => light.need_index("light", self.lights).map(Some),
            None => Ok(None),
        };
        Ok(self.warnings.keep(index())?.transpose())
    }

    /// A node without its name and light.
    pub(super) fn node(&self, json: &Json<'_>, meshes: &[Named<Mesh>]) -> Result<Node, GltfError> {
        let children = json.indices("children", self.nodes)?;
        let matrix = json.get("matrix")?.map(|matrix| affine(matrix, || json.path_of("matrix"))).transpose()?;
        let trs = if matrix.is_some() { Trs::default() } else { self.trs(json)? };
        let visibility = json.extension("KHR_node_visibility")?;
        let visible: Option<bool> = visibility.map_or(Ok(None), |visibility| visibility.get("visible"))?;
        let mesh = json.index("mesh", self.meshes)?;
        let skin = json.index("skin", self.skins);
        let weights = json.get("weights");
        let instancing =
            || json.extension("EXT_mesh_gpu_instancing")?.map(|extension| self.instancing(&extension)).transpose();
        let (skin, mut weights, instancing) = if mesh.is_some() {
            (skin?, weights?, instancing()?)
        } else {
            // Without a mesh they do nothing.
            let skin = self.warnings.leave_out(skin)?.flatten();
            (skin, self.warnings.leave_out(weights)?.flatten(), self.warnings.leave_out(instancing())?.flatten())
        };
        let targets = mesh.map_or(Some(0), |mesh| meshes[mesh].part.as_ref().ok().map(|mesh| mesh.targets));
        if let Some(targets) = targets {
            weights = self.weights(weights, targets, || json.path_of("weights"))?;
        }
        let is_hidden = visible == Some(false);
        Ok(Node { children, trs, matrix, mesh, skin, weights, instancing, is_hidden, ..Node::default() })
    }

    fn trs(&self, json: &Json<'_>) -> Result<Trs, GltfError> {
        // Numbers of JSON are finite, so one that is no unit has length 0.
        let unit = json.get("rotation")?.map(unit);
        if unit == Some(None) {
            self.warnings.push(GltfWarning::no_rotation(json.path_of("rotation")))?;
        }
        Ok(Trs {
            translation: json.get("translation")?.map_or(DVec3::ZERO, DVec3::from_array),
            rotation: unit.flatten().unwrap_or(DQuat::IDENTITY),
            scale: json.get("scale")?.map_or(DVec3::ONE, DVec3::from_array),
        })
    }

    fn instancing(&self, json: &Json<'_>) -> Result<[Option<usize>; 3], GltfError> {
        let attributes: Json<'_> = json.need("attributes")?;
        let mut accessors = [None; 3];
        for (accessor, name) in accessors.iter_mut().zip(INSTANCED) {
            *accessor = attributes.index(name, self.accessors)?;
        }
        Ok(accessors)
    }

    pub(super) fn animation(&self, json: &Json<'_>) -> Result<Animation, GltfError> {
        let samplers: Vec<Json<'_>> = json.list("samplers")?;
        let samplers: Vec<_> = samplers.iter().map(|json| self.sampler(json)).collect::<Result<_, _>>()?;
        let list = List { name: "samplers", length: samplers.len() };
        let mut channels = Vec::new();
        for (channel, json) in json.list::<Json<'_>>("channels")?.iter().enumerate() {
            let sampler = json.need_index("sampler", list)?;
            match self.channel_target(&json.need("target")?)? {
                Ok((node, property)) => channels.push(ChannelTarget { channel, sampler, node, property }),
                Err(problem) => self.warnings.push(GltfWarning::channel(&json.path, &problem))?,
            }
        }
        Ok(Animation { samplers, channels })
    }

    /// The target of a channel, or why it moves nothing.
    fn channel_target(&self, target: &Json<'_>) -> Result<Result<(usize, Property), String>, GltfError> {
        let path = target.need("path")?;
        if let Ok(Some(extension)) = target.extension("KHR_animation_pointer")
            && let Ok(Some(pointer)) = extension.get("pointer")
        {
            return Ok(Err(format!("the pointer {:?} is not read", shorten(pointer))));
        }
        let Some(node) = target.index("node", self.nodes)? else {
            return Ok(Err("it has no target node".to_owned()));
        };
        let property = Property::ALL.into_iter().find(|property| property.name() == path);
        Ok(property
            .map(|property| (node, property))
            .ok_or_else(|| format!("the path {:?} is not supported", shorten(path))))
    }

    fn sampler(&self, json: &Json<'_>) -> Result<Sampler, GltfError> {
        let interpolation = match json.get("interpolation")? {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(_) => return Err(json.wrong("interpolation", "LINEAR, STEP or CUBICSPLINE")),
        };
        let accessor = |key: &str| json.need_index(key, self.accessors);
        Ok(Sampler { input: accessor("input")?, output: accessor("output")?, interpolation })
    }
}

pub(super) fn light(json: &Json<'_>) -> Result<PunctualLight, GltfError> {
    let kind = match json.need("type")? {
        "directional" => SceneLightKind::Directional,
        "point" => SceneLightKind::Point,
        "spot" => SceneLightKind::Spot,
        _ => return Err(json.wrong("type", "directional, point or spot")),
    };
    let color = json.get("color")?.unwrap_or([1.0; 3]);
    let intensity = json.get("intensity")?.unwrap_or(1.0);
    let range: Option<f64> = json.get("range")?;
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
    let Some(spot): Option<Json<'_>> = json.get("spot")? else { return Ok([0.0, FRAC_PI_4 as f32]) };
    let inner = spot.get("innerConeAngle")?.unwrap_or(0.0);
    let outer = spot.get("outerConeAngle")?.unwrap_or(FRAC_PI_4);
    if !(outer > 0.0 && outer <= FRAC_PI_2 + TOLERANCE) {
        return Err(spot.wrong("outerConeAngle", "an angle of more than 0 and at most a quarter turn, in radians"));
    }
    // A cone without a soft rim has two equal angles, though the extension asks for a smaller inner one.
    if !(inner >= 0.0 && inner <= outer) {
        return Err(spot.wrong("innerConeAngle", "an angle from 0 to that of the outer cone, in radians"));
    }
    Ok([inner, outer].map(|angle| angle.min(FRAC_PI_2) as f32))
}

/// A camera without its name.
pub(super) fn projection(json: &Json<'_>) -> Result<CameraProjection, GltfError> {
    let kind = json.need("type")?;
    let section: Json<'_> = match kind {
        "perspective" | "orthographic" => json.need(kind)?,
        _ => return Err(json.wrong("type", "perspective or orthographic")),
    };
    let checked = |key: &str, expected: &str, is_right: &dyn Fn(f32) -> bool, value: f64| {
        let value = value as f32;
        if value.is_finite() && is_right(value) { Ok(value) } else { Err(section.wrong(key, expected)) }
    };
    let positive = |key: &str, value: f64| checked(key, "a number of more than 0", &|value| value > 0.0, value);
    let behind = |near: f32, value: f64| checked("zfar", "a distance beyond znear", &|far| far > near, value);
    if kind == "perspective" {
        let is_angle = |angle: f32| angle > 0.0 && angle < std::f32::consts::PI;
        let znear = positive("znear", section.need("znear")?)?;
        return Ok(CameraProjection::Perspective {
            yfov: checked(
                "yfov",
                "an angle of more than 0 and less than a half turn, in radians",
                &is_angle,
                section.need("yfov")?,
            )?,
            aspect_ratio: section.get("aspectRatio")?.map(|ratio| positive("aspectRatio", ratio)).transpose()?,
            znear,
            zfar: section.get("zfar")?.map(|far| behind(znear, far)).transpose()?,
        });
    }
    let half = |key: &str| checked(key, "a number that is not 0", &|half| half != 0.0, section.need(key)?);
    let znear = checked("znear", "a distance of 0 or more", &|near| near >= 0.0, section.need("znear")?)?;
    Ok(CameraProjection::Orthographic {
        xmag: half("xmag")?,
        ymag: half("ymag")?,
        znear,
        zfar: behind(znear, section.need("zfar")?)?,
    })
}
