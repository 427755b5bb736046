//! The pyramid between a light and the near rectangle. The WGSL is `wgsl/shadow/visibility.wgsl`.

use glam::{Vec3, Vec4};

use super::shadow::{corner, dot_3, light_side, near_plane, placed};
use crate::layout::{ShadowLight, ShadowView};

/// The relative slack of all tests in the stages that choose. It is larger than the rounding error of the tests; see
/// docs/numerics/shadow-volumes.md, "Slack of culling".
pub(crate) const SLACK: f32 = 4e-6;

/// Whether a point is outside a plane, from its `value` there. `size` bounds the terms whose sum is the value.
pub(crate) fn is_out(value: f32, size: f32) -> bool {
    value < -SLACK * size
}

/// The values of the pyramid's planes at a position, and bounds on the terms whose sums they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PyramidPlanes {
    /// Left, right, bottom, top; negative outside.
    value: [f32; 4],
    size: [f32; 4],
    /// Negative on the far side of the near plane as seen from the light.
    depth: f32,
    depth_size: f32,
}

/// Bounds on the terms whose sums are a position's clip coordinates.
pub(crate) fn clip_size(view: &ShadowView, q: Vec3) -> Vec4 {
    let [x, y, z, w] = view.view_projection.map(|column| Vec4::from_array(column).abs());
    x * q.x + y * q.y + z * q.z + w
}

pub(crate) fn height_size(view: &ShadowView, q: Vec3) -> f32 {
    let (normal, constant) = near_plane(view);
    dot_3(normal.abs(), q) + constant.abs()
}

fn pyramid_planes(view: &ShadowView, light: &ShadowLight, position: [f32; 3]) -> PyramidPlanes {
    let s = light_side(light);
    let v = corner(view, light, position);
    let q = placed(view, position).abs();
    let size = clip_size(view, q);
    let height = height_size(view, q);
    let (at_light, weight) = (Vec4::from_array(light.clip), light.light[3]);
    let xy = s * (v.near * light.height - at_light * v.height);
    let w = s * view.near_w * (light.height - weight * v.height);
    let xy_size = size * light.height.abs() + at_light.abs() * height;
    let w_size = view.near_w * (light.height.abs() + weight * height);
    PyramidPlanes {
        value: [w + xy.x, w - xy.x, w + xy.y, w - xy.y],
        size: [w_size + xy_size.x, w_size + xy_size.x, w_size + xy_size.y, w_size + xy_size.y],
        depth: s * v.height,
        depth_size: height,
    }
}

/// Whether all positions are outside one of the pyramid's planes.
pub(crate) fn misses_pyramid(view: &ShadowView, light: &ShadowLight, positions: &[[f32; 3]]) -> bool {
    let (mut out, mut beyond) = ([true; 4], true);
    for &position in positions {
        let planes = pyramid_planes(view, light, position);
        for ((out, value), size) in out.iter_mut().zip(planes.value).zip(planes.size) {
            *out &= is_out(value, size);
        }
        beyond &= is_out(planes.depth, planes.depth_size);
    }
    out.contains(&true) || beyond
}
