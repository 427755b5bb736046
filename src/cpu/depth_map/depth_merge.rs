//! Depth merge: for each texel the nearer of two depths, of one light.

use super::samples::{Key, Samples};
use crate::layout::DepthMapShape;

/// Merges two maps. Each has a depth for each texel.
pub fn depth_merge(shape: &DepthMapShape, maps: [&[f32]; 2]) -> Vec<f32> {
    let samples = maps.map(|depths| Samples { shape, depths, objects: &[] });
    let [width, height] = shape.size;
    let texels = (1..=height).flat_map(|y| (1..=width).map(move |x| [x, y]));
    let nearer = texels.map(|at| samples.map(|map| map.at(at)).into_iter().min().unwrap_or(Key::Far));
    nearer.map(|key| samples[0].depth_of(key)).collect()
}
