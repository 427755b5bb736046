//! Animations: channels that move nodes and morph weights.

use gltf::json::animation::Property;

use super::curve::Curve;
use super::document::{ChannelTarget, Document, Part, Transform};
use super::error::GltfError;
use super::formats;
use super::info::AnimationInfo;
use super::reader::Reader;
use super::transforms::unit;
use super::warning::GltfWarning;

/// The curves of an animation.
#[derive(Debug)]
pub(super) struct LoadedAnimation {
    pub(super) channels: Vec<Channel>,
}

/// A curve and the property that it moves.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) node: usize,
    pub(super) property: Property,
    pub(super) curve: Curve,
}

/// Reads all animations of the document, each with its fault.
pub(super) fn load(reader: &Reader<'_>) -> Result<(Vec<Part<LoadedAnimation>>, Vec<AnimationInfo>), GltfError> {
    let mut loaded = Vec::new();
    let mut infos = Vec::new();
    for (a, animation) in reader.document.animations.iter().enumerate() {
        let found = reader.warnings.keep(load_one(reader, a))?;
        let channels = found.as_ref().map_or(&[][..], |found| &found.channels[..]);
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

fn load_one(reader: &Reader<'_>, index: usize) -> Result<LoadedAnimation, GltfError> {
    let animation = &reader.document.animations[index];
    if let Some(fault) = &animation.fault {
        return Err(GltfError::clone(fault));
    }
    let mut channels = Vec::new();
    for target in &animation.channels {
        channels.extend(channel(reader, index, target)?);
    }
    Ok(LoadedAnimation { channels })
}

/// Reads a channel. Returns `None` where the target has nothing to move.
fn channel(reader: &Reader<'_>, animation: usize, target: &ChannelTarget) -> Result<Option<Channel>, GltfError> {
    let &ChannelTarget { node, property, .. } = target;
    let place = format!("animations[{animation}].channels[{}]", target.channel);
    let weights = property == Property::MorphTargetWeights;
    if !weights && matches!(reader.document.nodes[node].transform, Transform::Matrix(_)) {
        return Err(GltfError::AnimatedMatrix { place, node });
    }
    let width = match property {
        Property::MorphTargetWeights => morph_targets(reader.document, node),
        Property::Rotation => 4,
        _ => 3,
    };
    if width == 0 {
        let problem = format!("nodes[{node}] has no morph targets");
        reader.warnings.push(GltfWarning::Channel { place, problem })?;
        return Ok(None);
    }
    // Charges the channel, in a list that doubles, and a key's values while it is read and when it is sampled.
    reader.charge(1, 3 * size_of::<Channel>() as u64 + 64 * width as u64, &|| place.clone())?;
    let curve = curve(reader, animation, target, width)?;
    Ok(Some(Channel { node, property, curve }))
}

fn morph_targets(document: &Document, node: usize) -> usize {
    document.nodes[node].mesh.map_or(0, |mesh| document.meshes[mesh].targets)
}

fn curve(reader: &Reader<'_>, animation: usize, target: &ChannelTarget, width: usize) -> Result<Curve, GltfError> {
    let sampler = &reader.document.animations[animation].samplers[target.sampler];
    let place = format!("animations[{animation}].samplers[{}]", target.sampler);
    let bad = |problem: String| GltfError::Keyframes { place: place.clone(), problem };
    let times = reader.floats(sampler.input, formats::TIMES, &format!("{place}.input"))?;
    if times.is_empty() {
        return Err(bad("there are no keyframes".to_owned()));
    }
    // Equal times make a step.
    let unordered = |pair: &[f32]| pair[0] > pair[1];
    if let Some(key) = times.iter().position(|t| !t.is_finite()) {
        return Err(bad(format!("the time of key {key} is not finite")));
    }
    if let Some(key) = times.windows(2).position(unordered) {
        let (a, b) = (times[key], times[key + 1]);
        return Err(bad(format!("key {} is at {b} s, before key {key} at {a} s", key + 1)));
    }
    let format = match target.property {
        Property::MorphTargetWeights => formats::MORPH_WEIGHTS,
        Property::Rotation => formats::ROTATIONS,
        _ => formats::VECTORS,
    };
    let values = reader.floats(sampler.output, format, &format!("{place}.output"))?;
    let stride = Curve::stride(sampler.interpolation, width);
    if Some(values.len()) != times.len().checked_mul(stride) {
        let (count, keys) = (values.len(), times.len());
        return Err(bad(format!("{count} output values for {keys} keys of {stride} each")));
    }
    if let Some(value) = values.iter().position(|v| !v.is_finite()) {
        return Err(bad(format!("the output of key {} is not finite", value / stride)));
    }
    let curve = Curve { times, values, width, interpolation: sampler.interpolation };
    let no_rotation = |&key: &usize| {
        let value: Result<[f64; 4], _> = curve.value(key).try_into();
        value.is_ok_and(|value| unit(value).is_none())
    };
    if target.property == Property::Rotation
        && let Some(key) = (0..curve.times.len()).find(no_rotation)
    {
        return Err(bad(format!("the rotation of key {key} has no length")));
    }
    Ok(curve)
}
