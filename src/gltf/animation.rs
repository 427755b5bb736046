//! Animations: channels that move nodes and morph weights.

use super::curve::Curve;
use super::document::{ChannelTarget, Part, Property, Sampler, checked, unit};
use super::error::GltfError;
use super::info::AnimationInfo;
use super::reader::{self, Reader};
use super::warning::GltfWarning;

/// A curve and the property that it moves.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) node: usize,
    pub(super) property: Property,
    pub(super) curve: Curve,
}

/// The channels of an animation, or its fault.
pub(super) type LoadedAnimation = Part<Vec<Channel>>;

/// Reads all animations of the document.
pub(super) fn load(reader: &Reader<'_>) -> Result<(Vec<LoadedAnimation>, Vec<AnimationInfo>), GltfError> {
    let (mut loaded, mut infos) = (Vec::new(), Vec::new());
    for (a, animation) in reader.document.animations.iter().enumerate() {
        let found = reader.warnings.keep(load_one(reader, a))?;
        let channels = found.as_ref().map_or(&[][..], |channels| channels);
        let last_key = |channel: &Channel| channel.curve.times.last().copied();
        infos.push(AnimationInfo {
            name: animation.name.clone(),
            duration_s: channels.iter().filter_map(last_key).fold(0.0, f32::max),
            channels: channels.len(),
            fault: found.as_ref().err().map(|fault| GltfError::clone(fault)),
        });
        loaded.push(found);
    }
    Ok((loaded, infos))
}

fn load_one(reader: &Reader<'_>, index: usize) -> Result<Vec<Channel>, GltfError> {
    let animation = checked(&reader.document.animations[index].part)?;
    let mut channels = Vec::new();
    for target in &animation.channels {
        channels.extend(channel(reader, index, target, &animation.samplers[target.sampler])?);
    }
    Ok(channels)
}

/// Reads a channel. Returns `None` where the target has nothing to move.
fn channel(
    reader: &Reader<'_>,
    animation: usize,
    target: &ChannelTarget,
    sampler: &Sampler,
) -> Result<Option<Channel>, GltfError> {
    let &ChannelTarget { channel, node, property, .. } = target;
    let json_path = format!("animations[{animation}].channels[{channel}]");
    let moved = &reader.document.nodes[node];
    if property != Property::Weights && moved.matrix.is_some() {
        let problem = "which has a matrix; give it translation, rotation and scale instead";
        return Err(GltfError::invalid(json_path, format!(" moves nodes[{node}], {problem}")));
    }
    let (width, format) = match property {
        Property::Weights => (moved.mesh.map_or(0, |mesh| reader.document.targets(mesh)), reader::MORPH_WEIGHTS),
        Property::Rotation => (4, reader::ROTATIONS),
        Property::Translation | Property::Scale => (3, reader::VECTORS),
    };
    if width == 0 {
        let problem = format!("nodes[{node}] has no morph targets");
        reader.warnings.push(GltfWarning::channel(&json_path, &problem))?;
        return Ok(None);
    }
    // Charges the channel, in a list that doubles, and a key's values while it is read and when it is sampled.
    reader.budget.charge(1, 3 * size_of::<Channel>() as u64 + 64 * width as u64, &|| json_path.clone())?;
    let &Sampler { input, output, interpolation } = sampler;
    let json_path = format!("animations[{animation}].samplers[{}]", target.sampler);
    let times = reader.floats(input, reader::TIMES, &format!("{json_path}.input"))?;
    check_times(&times).map_err(|problem| GltfError::invalid(&*json_path, problem))?;
    let values = reader.floats(output, format, &format!("{json_path}.output"))?;
    let curve = Curve { times, values, width, interpolation };
    check_values(&curve, property).map_err(|problem| GltfError::invalid(json_path, problem))?;
    Ok(Some(Channel { node, property, curve }))
}

/// Equal times make a step.
fn check_times(times: &[f32]) -> Result<(), String> {
    if times.is_empty() {
        return Err(": there are no keyframes".to_owned());
    }
    if let Some(key) = times.iter().position(|t| !t.is_finite()) {
        return Err(format!(": the time of key {key} is not finite"));
    }
    match times.windows(2).position(|pair| pair[0] > pair[1]) {
        Some(key) => Err(format!(": key {} is at {} s, before key {key} at {} s", key + 1, times[key + 1], times[key])),
        None => Ok(()),
    }
}

fn check_values(curve: &Curve, property: Property) -> Result<(), String> {
    let (Curve { times, values, .. }, stride) = (curve, curve.stride());
    if Some(values.len()) != times.len().checked_mul(stride) {
        return Err(format!(": {} output values for {} keys of {stride} each", values.len(), times.len()));
    }
    if let Some(value) = values.iter().position(|v| !v.is_finite()) {
        return Err(format!(": the output of key {} is not finite", value / stride));
    }
    let no_rotation = |&key: &usize| curve.value(key).try_into().is_ok_and(|value| unit(value).is_none());
    match (0..times.len()).find(no_rotation).filter(|_| property == Property::Rotation) {
        Some(key) => Err(format!(": the rotation of key {key} has no length")),
        None => Ok(()),
    }
}
