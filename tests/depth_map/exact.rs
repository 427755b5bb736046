//! Vertices of boundaries in `f64`, by independent code, and what floats may be off by. docs/numerics/depth-maps.md,
//! "Rounding of positions".

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};
use rimline::{DepthDirection, ShadowCamera};
use wgpu::TextureFormat;

use crate::boundary::sample;
use crate::maps::Map;

/// A rounding of WGSL: one unit in the last place, of a number anywhere in its binade.
pub(crate) const ROUNDING: f64 = 1.0 / 8_388_608.0;
/// Factor for products of small errors. `FLUSHED`: bound on results that are flushed to 0.
const HIGHER: f64 = 1.001;
const FLUSHED: f64 = 1e-36;

fn matrix(camera: &ShadowCamera) -> DMat4 {
    Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4()
}

/// By Cramer's rule.
fn solve(matrix: DMat4, right: DVec4) -> DVec4 {
    let all = matrix.determinant();
    let with = |axis: usize| {
        let mut columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis];
        columns[axis] = right;
        DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]).determinant() / all
    };
    DVec4::new(with(0), with(1), with(2), with(3))
}

/// The share and the constant that depths of a format move by.
pub(crate) fn steps(format: TextureFormat, depth: DepthDirection) -> [f64; 2] {
    let is_float = [TextureFormat::R32Float, TextureFormat::Depth32Float, TextureFormat::Depth32FloatStencil8];
    match depth {
        _ if format == TextureFormat::Depth16Unorm => [0.0, 0.5_f64.powi(14)],
        DepthDirection::Reversed if is_float.contains(&format) => [0.5_f64.powi(21), 0.0],
        _ => [0.0, 0.5_f64.powi(22)],
    }
}

/// A value and the most that floats may be off it, component by component.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    pub(crate) value: DVec4,
    pub(crate) bound: DVec4,
}

impl Held {
    /// How much of the bound something found is off by: more than 1 is wrong.
    pub(crate) fn share(&self, found: [f32; 4]) -> f64 {
        let off = (DVec4::from_array(found.map(f64::from)) - self.value).abs();
        let shares = off / self.bound;
        if shares.is_nan() { f64::INFINITY } else { shares.max_element() }
    }
}

/// Depths that are moved away from the light, in `f64`.
pub(crate) struct Moves {
    /// Multiples of the depth difference over a texel in each direction.
    pub(crate) slope_bias: f64,
    pub(crate) steps: [f64; 2],
    /// Boundaries that are moved sideways have slopes that are measured to one side.
    pub(crate) spread: bool,
}

impl Moves {
    fn slope(&self, map: &Map, at: [i64; 2], step: [i64; 2]) -> f64 {
        let depth = |count: i64| sample(map, at[0] + count * step[0], at[1] + count * step[1]);
        let difference = |from: i64, to: i64| Some(depth(to)? - depth(from)?);
        if self.spread {
            // A slope goes on over two texels to one side.
            let side = |sign: i64| {
                let (first, second) = (difference(0, sign)?, difference(sign, 2 * sign)?);
                Some(first.abs().min(second.abs()))
            };
            return side(-1).unwrap_or(0.0).max(side(1).unwrap_or(0.0));
        }
        match (difference(-1, 0), difference(0, 1)) {
            (Some(before), Some(after)) if before * after > 0.0 => before.abs().min(after.abs()),
            _ => 0.0,
        }
    }

    /// The moved depth of a texel, and what floats may be off by; `None` where it casts nothing.
    pub(crate) fn depth(&self, map: &Map, [x, y]: [i64; 2]) -> Option<(f64, f64)> {
        let depth = sample(map, x, y)?;
        let to_far = if map.is_reversed { depth } else { 1.0 - depth };
        let slopes = self.slope(map, [x, y], [1, 0]) + self.slope(map, [x, y], [0, 1]);
        let by = (self.slope_bias * slopes + self.steps[0] * depth + self.steps[1]).min(to_far / 2.0);
        let moved = if map.is_reversed { depth - by } else { depth + by };
        // A difference, the sum of both, its product, two sums; and the sum with the depth.
        Some((moved, ROUNDING * HIGHER * (5.0 * by + moved.abs())))
    }
}

/// From a map to the clip space of an eye.
pub(crate) struct Exact {
    /// Columns of x and y in device coordinates of the light, of the depth, and of 1.
    columns: [DVec4; 4],
    /// The same for directions away from the light: of x, y and 1.
    far: [DVec4; 3],
    size: DVec2,
    jitter: DVec2,
}

impl Exact {
    /// `jitter` in parts of a texel, right and down.
    pub(crate) fn new(
        (light, size): (&ShadowCamera, [u32; 2]),
        (eye, format): (&ShadowCamera, TextureFormat),
        jitter: [f64; 2],
    ) -> Self {
        let origin = |camera: &ShadowCamera| DVec3::from_array(camera.origin.map(f64::from));
        let apart = origin(light) - origin(eye);
        let [share, constant] = steps(format, eye.depth);
        let to_eye = matrix(eye);
        let moved = |clip: DVec4| {
            let z = match eye.depth {
                DepthDirection::Reversed => clip.z - share * clip.z - constant * clip.w,
                DepthDirection::Standard => clip.z + constant * clip.w,
            };
            DVec4::new(clip.x, clip.y, z, clip.w)
        };
        let to_eye =
            DMat4::from_cols(moved(to_eye.x_axis), moved(to_eye.y_axis), moved(to_eye.z_axis), moved(to_eye.w_axis));
        let project = |point: DVec4| to_eye * (point.truncate() + point.w * apart).extend(point.w);
        let inverse = [DVec4::X, DVec4::Y, DVec4::Z, DVec4::W].map(|unit| solve(matrix(light), unit));
        let columns = inverse.map(project);
        let size = DVec2::from_array(size.map(f64::from));
        let rows = matrix(light).transpose();
        let is_parallel = rows.w_axis.truncate() == DVec3::ZERO;
        let [x, y, z, one] = inverse;
        // Where the third of four homogeneous coordinates has to be for w = 0.
        let infinity = (!is_parallel).then(|| DVec3::new(-x.w, -y.w, -one.w) / z.w);
        let direction = |point: DVec4| to_eye * point.truncate().extend(0.0);
        let far = if let Some(depth) = infinity {
            [direction(x + depth.x * z), direction(y + depth.y * z), direction(one + depth.z * z)]
        } else {
            let away = if light.depth == DepthDirection::Reversed { -1.0 } else { 1.0 };
            [DVec4::ZERO, DVec4::ZERO, direction(away * z)]
        };
        Self { columns, far, size, jitter: DVec2::from_array(jitter) }
    }

    /// The device coordinates of a position in texels, of which (0, 0) is the middle of the first: its sum, and its terms.
    fn device(&self, texel: DVec2) -> (DVec2, DVec2) {
        let twice = 2.0 * texel + 1.0 - self.size;
        let at = DVec2::new(twice.x, -twice.y) / self.size;
        let jitter = 2.0 * DVec2::new(self.jitter.x, -self.jitter.y) / self.size;
        (at + jitter, at.abs())
    }

    /// The vertex at a position in texels, with a depth and what it may be off by; far without. `positions` is what the
    /// position itself may be off by, in texels.
    pub(crate) fn vertex(&self, texel: DVec2, depth: Option<(f64, f64)>, positions: f64) -> Held {
        let (at, size) = self.device(texel);
        let jitter = 2.0 * DVec2::new(self.jitter.x, -self.jitter.y) / self.size;
        let off = 2.0 * positions / self.size;
        let (value, terms, moved) = if let Some((depth, depth_off)) = depth {
            let [x, y, z, one] = self.columns;
            let middle = one + jitter.x * x + jitter.y * y;
            let terms = size.x * x.abs() + size.y * y.abs() + depth.abs() * z.abs() + middle.abs();
            let moved = depth_off * z.abs() + off.x * x.abs() + off.y * y.abs();
            (at.x * x + at.y * y + depth * z + one, terms, moved)
        } else {
            let [x, y, one] = self.far;
            let middle = one + jitter.x * x + jitter.y * y;
            let terms = size.x * x.abs() + size.y * y.abs() + middle.abs();
            (at.x * x + at.y * y + one, terms, off.x * x.abs() + off.y * y.abs())
        };
        // A term's column, its product, and three sums.
        Held { value, bound: HIGHER * (5.0 * ROUNDING * terms + moved) + FLUSHED }
    }
}
