//! Early tests of a box and its shadow: whether a light reaches the box, and whether a camera may see its shadow.

use glam::Vec3;

use super::bounds::unordered;
use super::pyramid::{SLACK, clip_size, height_size, is_out};
use super::shadow::{corner, dot_3, near_plane, placed};
use crate::layout::{ShadowLight, ShadowView};

/// A box by its lowest and its highest corner.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
}

impl Bounds {
    /// The box of words as [`super::bounds::bounds`] has them, if any face is finite.
    pub(super) fn of([low_x, low_y, low_z, high_x, high_y, high_z, _]: [u32; 7]) -> Option<Self> {
        let low = Vec3::from([low_x, low_y, low_z].map(|bits| unordered(!bits)));
        let high = Vec3::from([high_x, high_y, high_z].map(unordered));
        (high_x != 0).then_some(Self { low, high })
    }

    pub(super) fn corners(self) -> [[f32; 3]; 8] {
        std::array::from_fn(|number| {
            std::array::from_fn(|axis| if number >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] })
        })
    }
}

/// Whether the whole box is beyond the light's range.
pub(super) fn out_of_range(light: &ShadowLight, Bounds { low, high }: Bounds) -> bool {
    let [x, y, z, w] = light.light;
    if light.range <= 0.0 || w <= 0.0 {
        return false;
    }
    let place = Vec3::new(x, y, z) / w;
    let d = (low - place).max(place - high).max(Vec3::ZERO);
    // The largest side is factored out, because squares may overflow.
    let size = d.x.max(d.y).max(d.z.max(light.range));
    let r = light.range / size;
    let e = d / size;
    dot_3(e, e) > r * r * (1.0 + SLACK)
}

/// Whether the whole volume of the box is outside the left, right, bottom, top or near plane of the camera.
pub(super) fn is_unseen(view: &ShadowView, light: &ShadowLight, caster: Bounds) -> bool {
    let (mut out, mut before) = ([true; 4], true);
    for position in caster.corners() {
        let v = corner(view, light, position);
        let q = placed(view, position).abs();
        let away = extrusion_size(view, light, position);
        let (size, far_size) = (clip_size(view, q), clip_size(view, away));
        let sides = |c: glam::Vec4| [c.w + c.x, c.w - c.x, c.w + c.y, c.w - c.y];
        let sizes = |c: glam::Vec4| [c.w + c.x, c.w + c.x, c.w + c.y, c.w + c.y];
        let near = sides(v.near).into_iter().zip(sizes(size));
        let far = sides(v.far).into_iter().zip(sizes(far_size));
        for ((out, near), far) in out.iter_mut().zip(near).zip(far) {
            *out &= is_out(near.0, near.1) && is_out(far.0, far.1);
        }
        let rise_size = far_size.w + dot_3(near_plane(view).0.abs(), away);
        before &= is_out(v.height, height_size(view, q)) && is_out(v.far_height, rise_size);
    }
    out.contains(&true) || before
}

/// Bounds on the terms whose sums are the vector from the light to a position.
fn extrusion_size(view: &ShadowView, light: &ShadowLight, position: [f32; 3]) -> Vec3 {
    let [x, y, z, weight] = light.light;
    let terms = (weight * Vec3::from(position)).abs() + Vec3::new(x, y, z).abs();
    Vec3::from(view.placement.map(|[x, y, z, _]| dot_3(Vec3::new(x, y, z).abs(), terms)))
}
