//! Depth metric: a depth map from a map of distances.

use glam::{Vec3, Vec4};

use super::samples::{Key, Samples};
use crate::layout::{DepthMapShape, DepthMetricView};

/// How much longer a ray is than its component along the axis.
fn ray_length(view: &DepthMetricView, [x, y]: [f32; 2]) -> f32 {
    let [across, down, middle] = [view.across, view.down, view.middle].map(|v| Vec4::from_array(v).truncate());
    let ray: Vec3 = across * x + down * y + middle;
    (ray.x * ray.x + ray.y * ray.y + ray.z * ray.z).sqrt()
}

/// The depth of a distance. `None` where nothing casts.
fn depth_at(shape: &DepthMapShape, view: &DepthMetricView, given: f32, steps: [f32; 2]) -> Option<f32> {
    let ahead = if given.is_sign_negative() { 0.0 } else { given };
    let distance = if view.metric == 2 { ahead / ray_length(view, steps) } else { ahead };
    if given.is_nan() || distance >= view.most {
        return None;
    }
    let along = distance.max(view.least);
    let to_far = (view.head - view.has_far * along) + view.rest;
    let scaled = view.scale * to_far / if view.is_parallel == 1 { 1.0 } else { along };
    let nearness = scaled + (view.across[3] * steps[0] + view.down[3] * steps[1]);
    Some(if shape.is_reversed == 1 { nearness } else { 1.0 - nearness })
}

/// Converts a map. It has a device depth or a distance for each texel, as `view` says.
pub fn depth_metric(shape: &DepthMapShape, view: &DepthMetricView, given: &[f32]) -> Vec<f32> {
    let samples = Samples { shape, depths: given, objects: &[] };
    let width = shape.size[0].max(1);
    let middle = |index: u32, side: u32| f64::from(2 * index + 1) - f64::from(side);
    let key = |(texel, &given): (u32, &f32)| {
        if view.metric == 0 {
            return samples.key(given);
        }
        let (column, row) = (texel % width, texel / width);
        let steps = [middle(column, width) as f32, middle(row, shape.size[1]) as f32];
        depth_at(shape, view, given, steps).map_or(Key::Far, |depth| samples.key(depth))
    };
    (0..).zip(given).map(|texel| samples.depth_of(key(texel))).collect()
}
