//! How distances become device depths, in `f64`, rounded once, and the error of the result. docs/numerics/depth-maps.md,
//! "Maps of distances".

use bytemuck::Zeroable;
use glam::{DMat4, DVec3, DVec4};

use super::error::DepthMapError;
use super::view::infinity;
use crate::ShadowCamera;
use crate::layout::DepthMetricView;
use crate::shadow::DepthDirection;

/// The quantity in the texels of an `R32Float` map.
///
/// Distances are in the units of positions. A distance casts nothing if it is +∞, NaN, at the far plane or beyond it;
/// without a far plane, if it is 2¹²⁰ units or more along the axis. It also casts nothing if its device depth rounds to that
/// of the far end; with reversed depth only one below 2⁻¹²⁶ does. A negative distance, or one before the near plane, counts
/// as one at the near plane.
///
/// Distances must be right to one unit in their last place. Add other errors that may make them too short, such as the
/// tolerance at which a marched ray stops before a surface. A boundary that is nearer to the light than the surface shows as
/// specks of shadow on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum DepthMetric {
    /// Device depths, as a depth attachment has them: clip z over clip w.
    #[default]
    Device,
    /// Distances along the axis of view. A perspective camera has them from the plane through the light at right angles to
    /// the axis: clip w over the length by which it grows for each unit. An orthographic matrix has no position, so there
    /// they are from the near plane, at right angles to it.
    AlongAxis,
    /// Distances along the ray through the middle of the texel. A perspective camera has them from the light, where all rays
    /// meet. An orthographic one has them from the near plane, along the direction of its rays.
    AlongRay,
}

/// One unit in the last place, as WGSL counts it.
const U: f64 = 1.0 / 8_388_608.0;
/// Near and far distances that are converted.
const RANGE: [f64; 2] = [1.0 / (1_u128 << 100) as f64, (1_u128 << 100) as f64];
/// The distance from which on nothing casts without a far plane.
const NOTHING: f64 = (1_u128 << 120) as f64;
/// The largest factor by which errors may grow.
const MAX_GROWTH: f64 = 1024.0;
/// The largest share of a depth in the bias. A larger share adds to the constant.
const MAX_SHARE: f64 = 56.0 * U;

/// The rays and planes of a camera. Nearness is 1 at the near plane and 0 at the far end.
struct Planes {
    /// The change of the ray with x and with y, and the ray in the middle. `None` if rays are parallel.
    rays: Option<[DVec3; 3]>,
    /// The change of nearness at infinity with x and y.
    tilt: [f64; 2],
    near: f64,
    /// The far distance, and a scale: nearness is the scale times the way to the far plane, divided by the distance if rays
    /// meet.
    far: Option<[f64; 2]>,
    /// Nearness times distance, without a far plane.
    product: f64,
}

impl Planes {
    fn new(light: &ShadowCamera, metric: DepthMetric) -> Result<Self, DepthMapError> {
        light.check_any_hand().map_err(DepthMapError::Light)?;
        let matrix = light.matrix();
        let inverse: DMat4 = matrix.inverse();
        let planes = match infinity(light, &inverse)? {
            Some(at_infinity) => Self::meeting(light, &matrix, &inverse, at_infinity),
            None => Self::parallel(&matrix, &inverse, metric),
        };
        let [min_distance, max_distance] = RANGE;
        let far = planes.far.map_or(planes.near, |[far, _]| far);
        // If rays meet: the near distance for each unit between the planes, and the sums of rays.
        let close = if planes.rays.is_some() { planes.far.map_or(0.0, |[_, scale]| scale) } else { 0.0 };
        let stretch = planes.rays.map_or(0.0, |rays| stretch(&rays));
        let is_in_range = planes.near <= max_distance && (min_distance..=max_distance).contains(&far);
        let has_near = planes.rays.is_none() || planes.near >= min_distance;
        if is_in_range && has_near && close <= MAX_GROWTH && stretch <= MAX_GROWTH {
            Ok(planes)
        } else {
            Err(DepthMapError::Distances { near: planes.near, far: planes.far.map_or(f64::INFINITY, |[far, _]| far) })
        }
    }

    fn meeting(light: &ShadowCamera, matrix: &DMat4, inverse: &DMat4, at_infinity: DVec3) -> Self {
        let nearness = match light.depth {
            DepthDirection::Reversed => at_infinity,
            DepthDirection::Standard => DVec3::Z - at_infinity,
        };
        // Clip w is the distance along the axis times this.
        let growth = matrix.row(3).truncate().length();
        let product = 1.0 / (inverse.z_axis.w * growth).abs();
        let position = inverse.z_axis.truncate() / inverse.z_axis.w;
        let ray = |of: DVec4| growth * (of.truncate() - of.w * position);
        let behind = -nearness.z;
        Self {
            rays: Some([ray(inverse.x_axis), ray(inverse.y_axis), ray(inverse.w_axis)]),
            tilt: [nearness.x, nearness.y],
            near: product / (1.0 + behind),
            far: light.has_far_plane().then(|| [product / behind, behind]),
            product,
        }
    }

    fn parallel(matrix: &DMat4, inverse: &DMat4, metric: DepthMetric) -> Self {
        let clip_w = matrix.w_axis.w.abs();
        let far = match metric {
            DepthMetric::AlongRay => inverse.z_axis.truncate().length() * clip_w,
            _ => clip_w / matrix.row(2).truncate().length(),
        };
        Self { rays: None, tilt: [0.0; 2], near: 0.0, far: Some([far, 1.0 / far]), product: 0.0 }
    }
}

/// A bound of the sum of the lengths of a ray's terms, as a multiple of the ray's length.
fn stretch(rays: &[DVec3; 3]) -> f64 {
    rays.iter().map(|ray| ray.length()).sum()
}

/// The parameters that convert distances of a metric to device depths, for a map of `size` texels.
pub(super) fn metric_view(
    light: &ShadowCamera,
    size: [u32; 2],
    metric: DepthMetric,
) -> Result<DepthMetricView, DepthMapError> {
    if metric == DepthMetric::Device {
        return light.check_any_hand().map_err(DepthMapError::Light).map(|()| DepthMetricView::zeroed());
    }
    let planes = Planes::new(light, metric)?;
    let [width, height] = size.map(f64::from);
    let [across, down, middle] = planes.rays.unwrap_or([DVec3::ZERO; 3]);
    let f32s = |ray: DVec3, tilt: f64| ray.extend(tilt).as_vec4().to_array();
    let [far, scale] = planes.far.unwrap_or([planes.product, 1.0]);
    let rounded_far = far as f32;
    let far_remainder = if planes.far.is_some() { (far - f64::from(rounded_far)) as f32 } else { 0.0 };
    Ok(DepthMetricView {
        across: f32s(across / width, planes.tilt[0] / width),
        down: f32s(-down / height, -planes.tilt[1] / height),
        middle: f32s(middle, 0.0),
        far: rounded_far,
        far_remainder,
        has_far: f32::from(u8::from(planes.far.is_some())),
        scale: scale as f32,
        min_distance: (planes.near / 2.0) as f32,
        max_distance: (if planes.far.is_some() { 2.0 * far } else { NOTHING }) as f32,
        metric: match (metric, planes.rays) {
            (DepthMetric::AlongRay, Some(_)) => 2,
            _ => 1,
        },
        is_parallel: u32::from(planes.rays.is_none()),
    })
}

/// The error of the depths of a converted map: a share of the depth, which may be negative, and a constant.
///
/// # Errors
/// [`DepthMapError`] if the camera is refused.
pub fn metric_steps(light: &ShadowCamera, metric: DepthMetric) -> Result<[f64; 2], DepthMapError> {
    if metric == DepthMetric::Device {
        return Ok([0.0; 2]);
    }
    let planes = Planes::new(light, metric)?;
    // The share applies to the nearness, the constant everywhere.
    let [share, constant] = match &planes.rays {
        None => [5.0 * U, U],
        Some(rays) => {
            let distance = if metric == DepthMetric::AlongRay { (4.0 * stretch(rays) + 12.0) * U } else { U };
            let behind = planes.far.map_or(0.0, |[_, behind]| behind);
            let tilt: f64 = planes.tilt.iter().map(|tilt| tilt.abs()).sum();
            [9.0 * U + distance, (behind + tilt) * distance + 4.0 * U * tilt]
        }
    };
    Ok(match light.depth {
        DepthDirection::Reversed => [share.min(MAX_SHARE), constant + (share - MAX_SHARE).max(0.0)],
        DepthDirection::Standard => [-share.min(MAX_SHARE), constant + share + U / 2.0],
    })
}
