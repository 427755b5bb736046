//! Choose: for each light, the faces of the caster that cast and the counting method, from the caster's box alone.

use glam::Vec3;

use super::pyramid::{SLACK, height_size, misses_pyramid};
use super::seen::{Bounds, is_unseen, out_of_range};
use super::shadow::{dot_3, light_side, near_plane, placed};
use crate::layout::{ShadowLight, ShadowShape, ShadowView};
use crate::shadow::{
    CAST_AVERTED, CAST_EVERY, CAST_NOTHING, COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005,
};

/// Sets `casting`, `counting`, `end`, `frustum_near` and `excludes` of each light, for the caster whose box is `bounds` (of
/// [`super::bounds::bounds`]). `zeros` tells whether any light lies in the plane of a face.
pub fn choose(shape: &ShadowShape, view: &ShadowView, bounds: [u32; 7], zeros: bool, lights: &mut [ShadowLight]) {
    choose_beside_twisted(shape, view, bounds, zeros, 0, lights);
}

/// The same where polygons are L-twisted for the lights that have a bit in `twisted`. Lights whose numbers differ by 32 share a
/// bit.
pub fn choose_beside_twisted(
    shape: &ShadowShape,
    view: &ShadowView,
    bounds: [u32; 7],
    zeros: bool,
    twisted: u32,
    lights: &mut [ShadowLight],
) {
    for (number, light) in lights.iter_mut().enumerate() {
        choose_light(shape, view, bounds, zeros, twisted >> (number % 32) & 1 != 0, light);
    }
}

fn choose_light(
    shape: &ShadowShape,
    view: &ShadowView,
    bounds: [u32; 7],
    zeros: bool,
    is_cut: bool,
    light: &mut ShadowLight,
) {
    (light.casting, light.counting, light.end) = (CAST_NOTHING, COUNT_Z_PASS, 0.0);
    light.excludes = 0;
    let [.., has_holes] = bounds;
    let Some(caster) = Bounds::of(bounds) else { return };
    let is_reached = shape.skip_unreached == 0 || !out_of_range(light, caster);
    if !is_reached || (shape.skip_unseen != 0 && is_unseen(view, light, caster)) {
        return;
    }
    let light_is_inside = light_meets(light, caster);
    light.excludes = u32::from(has_holes != 0 || is_cut || (light_is_inside && zeros));
    // A caster with holes is not closed. Averted faces suffice if light and eye are outside the caster:
    // docs/numerics/casting-faces.md, "Which faces cast".
    let is_outside = !boxes_meet(view, caster) && !light_is_inside;
    let averted_suffice = shape.averted != 0 && shape.proxies == 0 && has_holes == 0 && !is_cut && is_outside;
    light.casting = if averted_suffice { CAST_AVERTED } else { CAST_EVERY };
    if shape.counting == COUNT_ZP_PLUS_2005 {
        light.frustum_near = frustum_near(view, light, caster);
    }
    light.counting = match shape.counting {
        COUNT_AUTO if misses_pyramid(view, light, &caster.corners()) => COUNT_Z_PASS,
        COUNT_AUTO => COUNT_ZP_PLUS,
        // The published method knows no excluded faces, and no caster that is not in the depth buffer.
        COUNT_ZP_PLUS_2005 if light.excludes != 0 || shape.proxies != 0 => COUNT_Z_FAIL,
        asked => asked,
    };
    let may_end = matches!(light.counting, COUNT_Z_PASS | COUNT_Z_FAIL);
    if may_end && shape.end_at_range != 0 && light.range > 0.0 && light.light[3] > 0.0 {
        light.end = (distance_below(light, caster) / light.range).min(1.0);
    }
}

/// A lower bound of the distance from the light to the box.
fn distance_below(light: &ShadowLight, Bounds { low, high }: Bounds) -> f32 {
    let [x, y, z, w] = light.light;
    let place = Vec3::new(x, y, z) / w;
    let slack = SLACK * low.abs().max(high.abs()).max(place.abs());
    let d = ((low - place).max(place - high) - slack).max(Vec3::ZERO);
    length_of(d) * (1.0 - SLACK)
}

/// The largest side is factored out, because squares may overflow.
fn length_of(d: Vec3) -> f32 {
    let size = d.x.max(d.y).max(d.z);
    if size <= 0.0 {
        return 0.0;
    }
    let e = d / size;
    size * dot_3(e, e).sqrt()
}

/// The near end of the light's frustum in the published ZP+.
fn frustum_near(view: &ShadowView, light: &ShadowLight, caster: Bounds) -> f32 {
    let [x, y, z, w] = light.light;
    if w > 0.0 {
        let place = Vec3::new(x, y, z) / w;
        let place = placed(view, place.to_array());
        let farthest = (Vec3::from(view.near_min) - place).abs().max((Vec3::from(view.near_max) - place).abs());
        return (distance_below(light, caster) / length_of(farthest)).clamp(0.001, 0.99);
    }
    let (normal, constant) = near_plane(view);
    let highest = caster.corners().into_iter().fold(0.0_f32, |highest, corner| {
        let place = placed(view, corner);
        let height = dot_3(normal, place) + constant;
        let slack = SLACK * height_size(view, place.abs());
        highest.max(light_side(light) * height + slack)
    });
    if highest > 0.0 { highest } else { 1.0 }
}

/// Whether the box, moved to the camera's frame, meets the box of the near rectangle, with slack.
fn boxes_meet(view: &ShadowView, Bounds { low, high }: Bounds) -> bool {
    (0..3).all(|axis| {
        let [x, y, z, w] = view.placement[axis];
        let row = Vec3::new(x, y, z);
        let (a, b) = (row * low, row * high);
        let (begin, end) = (dot_3(a.min(b), Vec3::ONE) + w, dot_3(a.max(b), Vec3::ONE) + w);
        let (near_min, near_max) = (view.near_min[axis], view.near_max[axis]);
        let size = dot_3(row.abs(), low.abs().max(high.abs())) + w.abs();
        let slack = SLACK * size.max(near_min.abs().max(near_max.abs()));
        begin - slack <= near_max && end + slack >= near_min
    })
}

/// Whether the light may be in the box, with slack. A light at infinity is not. Values are multiplied by w, so that
/// nothing overflows.
fn light_meets(light: &ShadowLight, Bounds { low, high }: Bounds) -> bool {
    let [x, y, z, w] = light.light;
    let (place, low, high) = (Vec3::new(x, y, z), w * low, w * high);
    let slack = SLACK * low.abs().max(high.abs()).max(place.abs());
    w > 0.0 && (low - slack).cmple(place).all() && (high + slack).cmpge(place).all()
}
