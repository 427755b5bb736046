//! `det[b − a, c − a, l − w·a]` in `f32`, in the local form and in the plane form. The WGSL is
//! `wgsl/common/determinant.wgsl`.

use crate::layout::LightBatch;

pub(crate) fn difference(p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

/// The cross product `u × v`. For `b − a` and `c − a` it is the normal on the counter-clockwise side.
pub(crate) fn cross_product(u: [f32; 3], v: [f32; 3]) -> [f32; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// `(b − a) × (c − a)`.
pub(crate) fn normal(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    cross_product(difference(b, a), difference(c, a))
}

/// `n · (l − w·a)`.
pub(crate) fn local_form(n: [f32; 3], a: [f32; 3], [x, y, z, w]: [f32; 4]) -> f32 {
    let to_light = [x - w * a[0], y - w * a[1], z - w * a[2]];
    n[0] * to_light[0] + n[1] * to_light[1] + n[2] * to_light[2]
}

/// `n · l + w·e` with `e = −n · a`, for the light as given.
fn plane_form(n: [f32; 3], e: f32, [x, y, z, w]: [f32; 4]) -> f32 {
    n[0] * x + n[1] * y + n[2] * z + e * w
}

/// One bit for each light, set if the light is in front of the face by the local form.
pub(crate) fn local_mask(a: [f32; 3], b: [f32; 3], c: [f32; 3], light_batch: &LightBatch) -> u32 {
    let n = normal(a, b, c);
    let lights = light_batch.lights.iter().take(light_batch.count as usize).enumerate();
    lights.fold(0, |mask, (bit, &light)| mask | u32::from(local_form(n, a, light) > 0.0) << bit)
}

/// One bit for each light, set if the light is in front of the face by the plane form.
pub(crate) fn plane_mask(a: [f32; 3], b: [f32; 3], c: [f32; 3], light_batch: &LightBatch) -> u32 {
    let n = normal(a, b, c);
    let e = -(n[0] * a[0] + n[1] * a[1] + n[2] * a[2]);
    let lights = light_batch.light_bits.iter().take(light_batch.count as usize).enumerate();
    lights.fold(0, |mask, (bit, light)| mask | u32::from(plane_form(n, e, light.map(f32::from_bits)) > 0.0) << bit)
}
