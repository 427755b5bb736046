//! The matrices from a depth map to a camera, in `f64`, rounded once. docs/numerics/depth-maps.md.

use glam::{DMat4, DVec3, DVec4};

use super::error::DepthMapError;
use crate::ShadowCamera;
use crate::layout::DepthMapView;
use crate::shadow::DepthDirection;

/// The error of depths in the coarsest of some formats, four steps between neighbouring depths: a share of the depth, and
/// a constant.
pub(crate) fn steps(formats: impl IntoIterator<Item = wgpu::TextureFormat>, depth: DepthDirection) -> [f64; 2] {
    use wgpu::TextureFormat::{Depth16Unorm, Depth32Float, Depth32FloatStencil8, R32Float};
    let of = |format: wgpu::TextureFormat| match (format, depth) {
        (Depth16Unorm, _) => [0.0, 4.0 / 65_536.0],
        // A step of a float is up to 2⁻²³ of it. Floats from ½ to 1 have the steps of 24 bits.
        (Depth32Float | Depth32FloatStencil8 | R32Float, DepthDirection::Reversed) => [4.0 / 8_388_608.0, 0.0],
        _ => [0.0, 4.0 / 16_777_216.0],
    };
    let all = formats.into_iter().map(of);
    all.fold([0.0; 2], |max: [f64; 2], steps| [0, 1].map(|index| max[index].max(steps[index])))
}

/// The eye's matrix, with depths moved away by the error of its depth buffer.
fn eye_matrix(eye: &ShadowCamera, format: wgpu::TextureFormat) -> DMat4 {
    let [share, constant] = steps([format], eye.depth);
    let mut rows = eye.matrix().transpose();
    rows.z_axis = match eye.depth {
        DepthDirection::Reversed => (1.0 - share) * rows.z_axis - constant * rows.w_axis,
        DepthDirection::Standard => rows.z_axis + constant * rows.w_axis,
    };
    rows.transpose()
}

/// The depth at infinity of a perspective map: factors of x and y in device coordinates, and a constant. `None` for a light
/// at infinity.
pub(super) fn infinity(light: &ShadowCamera, inverse: &DMat4) -> Result<Option<DVec3>, DepthMapError> {
    if light.matrix().row(3).truncate() == DVec3::ZERO {
        return Ok(None);
    }
    let far = match light.depth {
        DepthDirection::Reversed => 0.0,
        DepthDirection::Standard => 1.0,
    };
    if !light.has_far_plane() {
        return Ok(Some(DVec3::new(0.0, 0.0, far)));
    }
    let w = inverse.row(3);
    let depth = -DVec3::new(w.x, w.y, w.w) / w.z;
    let is_behind = |[x, y]: [f64; 2]| {
        let at_infinity = depth.dot(DVec3::new(x, y, 1.0));
        !(if light.depth == DepthDirection::Reversed { at_infinity < far } else { at_infinity > far })
    };
    if [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].into_iter().any(is_behind) {
        return Err(DepthMapError::FarPlane);
    }
    Ok(Some(depth))
}

/// How the boundary of a map is moved.
#[derive(Clone, Copy, Debug)]
pub struct Placing {
    /// Rows of the lattice before the first texel.
    pub border: f64,
    /// The offset across and down, in texels.
    pub jitter: [f64; 2],
    /// The bias away from the light, in multiples of the depth difference over a texel in each direction.
    pub slope_bias: f64,
}

/// The light's matrix, moved by the jitter.
fn moved_matrix(light: &ShadowCamera, size: [u32; 2], placing: &Placing) -> DMat4 {
    let ([width, height], [across, down]) = (size.map(f64::from), placing.jitter);
    let jitter = DVec3::new(2.0 * across / width, -2.0 * down / height, 0.0);
    DMat4::from_translation(-jitter) * light.matrix()
}

/// Columns from x and y on the near rectangle of an eye, from -1 to 1, to the lattice of a map and the depth in it:
/// homogeneous.
pub(super) fn near_columns(
    (light, size): (&ShadowCamera, [u32; 2]),
    (eye, format): (&ShadowCamera, wgpu::TextureFormat),
    placing: &Placing,
) -> [DVec4; 3] {
    let [width, height] = size.map(f64::from);
    // From the light's clip space to the lattice, where texel (0, 0) is behind the border.
    let lattice = DMat4::from_cols(
        DVec4::new(width / 2.0, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -height / 2.0, 0.0, 0.0),
        DVec4::Z,
        DVec4::new((width - 1.0) / 2.0 + placing.border, (height - 1.0) / 2.0 + placing.border, 0.0, 1.0),
    );
    let between = DMat4::from_translation(eye.origin_point() - light.origin_point());
    let near = lattice * moved_matrix(light, size, placing) * between * eye_matrix(eye, format).inverse();
    let near_z = if eye.depth == DepthDirection::Reversed { 1.0 } else { 0.0 };
    [near.x_axis, near.y_axis, near_z * near.z_axis + near.w_axis]
}

/// The view of a map of `size` texels, for an eye whose depth buffer has the format `format`. Depths of the map have an
/// error: a share of the depth, and a constant.
pub(crate) fn depth_map_view(
    (light, size): (&ShadowCamera, [u32; 2]),
    error: [f64; 2],
    (eye, format): (&ShadowCamera, wgpu::TextureFormat),
    placing: &Placing,
) -> Result<DepthMapView, DepthMapError> {
    light.check_any_hand().map_err(DepthMapError::Light)?;
    eye.check_any_hand().map_err(DepthMapError::Camera)?;
    let [width, height] = size.map(f64::from);
    let (to_light, to_eye) = (moved_matrix(light, size, placing), eye_matrix(eye, format));
    let inverse = to_light.inverse();
    let infinity = infinity(light, &inverse)?;
    let between = DMat4::from_translation(light.origin_point() - eye.origin_point());
    let to_clip = to_eye * between * inverse;
    // Directions do not depend on the origins.
    let ray = |depth: f64, of: DVec4| to_eye * (of + depth * inverse.z_axis).truncate().extend(0.0);
    let [far_across, far_down, far_middle] = if let Some(depth) = infinity {
        [ray(depth.x, inverse.x_axis) / width, -ray(depth.y, inverse.y_axis) / height, ray(depth.z, inverse.w_axis)]
    } else {
        let away = if light.depth == DepthDirection::Reversed { -1.0 } else { 1.0 };
        [DVec4::ZERO, DVec4::ZERO, ray(away, DVec4::ZERO)]
    };
    let [near_across, near_up, near_middle] = near_columns((light, size), (eye, format), placing);
    let f32s = |column: DVec4| column.as_vec4().to_array();
    let [share, constant] = error.map(|error| error as f32);
    let depth = infinity.unwrap_or(DVec3::ZERO);
    Ok(DepthMapView {
        across: f32s(to_clip.x_axis / width),
        down: f32s(-to_clip.y_axis / height),
        depth: f32s(to_clip.z_axis),
        middle: f32s(to_clip.w_axis),
        far_across: f32s(far_across),
        far_down: f32s(far_down),
        far_middle: f32s(far_middle),
        near_across: f32s(near_across),
        near_up: f32s(near_up),
        near_middle: f32s(near_middle),
        infinity: f32s(DVec4::new(
            depth.x / width,
            -depth.y / height,
            depth.z,
            f64::from(u8::from(infinity.is_none())),
        )),
        bias: [placing.slope_bias as f32, share, constant, 0.0],
    })
}
