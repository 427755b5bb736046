//! Camera, depth direction and counting method of shadow volumes.

use glam::{DMat4, DVec3, DVec4, Mat4, Vec3};

use crate::Light;
use crate::layout::{ShadowLight, ShadowView};
use crate::origin::power_of_two_below;

/// Value of [`ShadowLight::casting`]: no face casts.
pub const CAST_NOTHING: u32 = 0;
/// Value of [`ShadowLight::casting`]: back-facing faces cast.
pub const CAST_BACK_FACING: u32 = 1;
/// Value of [`ShadowLight::casting`]: every face casts.
pub const CAST_EVERY: u32 = 2;
/// Value of [`ShadowLight::counting`]: z-pass.
pub const COUNT_Z_PASS: u32 = 0;
/// Value of [`ShadowLight::counting`]: ZP+.
pub const COUNT_ZP_PLUS: u32 = 1;
/// Value of [`ShadowLight::counting`]: z-fail.
pub const COUNT_Z_FAIL: u32 = 2;
/// Value of [`crate::layout::ShadowShape::counting`]: z-pass or ZP+, chosen for each caster, light and view.
pub const COUNT_AUTO: u32 = 3;
/// Value of [`ShadowLight::counting`]: ZP+ as published.
pub const COUNT_ZP_PLUS_2005: u32 = 4;

/// The counting method: how the stencil buffer counts the shadow volumes that contain a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Counting {
    /// The GPU chooses for each caster, light and view: z-pass where the caster's box shows that no face lies between the
    /// light and the near rectangle, else ZP+. It is right from every camera.
    #[default]
    Auto,
    /// Counts what passes the depth test (Heidmann 1991). It is wrong where a volume reaches the near rectangle.
    ZPass,
    /// z-pass that begins with near caps: casting faces, projected from the light onto the near plane (after Hornus et
    /// al. 2005). The same functions clip sides and caps. See docs/numerics/shadow-volumes.md.
    ZpPlus,
    /// ZP+ as Hornus et al. published it in 2005, for comparison: the matrix of the light's frustum computes the near
    /// caps, side vertices before the near plane move to their position in the cap, and corrective quads close the
    /// gaps. A caster is counted by z-fail for a light where the near plane cuts both ends of a side (its case D),
    /// where faces may be excluded (by the caller, not finite, in the light's plane), or where it is not in the depth
    /// buffer. The method is not right from every camera, takes perspective cameras only, and needs what z-fail needs.
    /// [`Self::Auto`] never chooses it.
    #[doc(hidden)]
    ZpPlus2005,
    /// Counts what fails the depth test, with light and dark caps (Everitt and Kilgard 2002). It needs an infinite far
    /// plane or `Features::DEPTH_CLIP_CONTROL`, and a depth pass with the bits of the include's `rimline_clip`, or of
    /// `CasterPositions::Rigid` for rigid casters that are moved. With a far plane, volumes are drawn unclipped. Casting
    /// faces that the near plane cuts may then show specks of shadow.
    ZFail,
}

#[cfg(feature = "gpu")]
impl Counting {
    /// Whether this is ZP+ as published.
    pub(crate) const fn is_zp_plus_2005(self) -> bool {
        matches!(self, Self::ZpPlus2005)
    }

    /// Whether z-fail may be used.
    pub(crate) const fn may_fail(self) -> bool {
        matches!(self, Self::ZFail) || self.is_zp_plus_2005()
    }

    pub(crate) const fn code(self) -> u32 {
        match self {
            Self::ZPass => COUNT_Z_PASS,
            Self::ZpPlus => COUNT_ZP_PLUS,
            Self::ZFail => COUNT_Z_FAIL,
            Self::Auto => COUNT_AUTO,
            Self::ZpPlus2005 => COUNT_ZP_PLUS_2005,
        }
    }
}

/// The end of clip space's depth that is near.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthDirection {
    /// Near is 1 and far is 0. The larger depth is nearer.
    #[default]
    Reversed,
    /// Near is 0 and far is 1. The smaller depth is nearer.
    Standard,
}

#[cfg(feature = "gpu")]
impl DepthDirection {
    /// The comparison that nearer depths pass.
    pub(crate) fn nearer(self) -> wgpu::CompareFunction {
        match self {
            Self::Reversed => wgpu::CompareFunction::Greater,
            Self::Standard => wgpu::CompareFunction::Less,
        }
    }
}

/// The camera that shadow volumes are drawn for.
///
/// Its matrix takes positions less [`Self::origin`] to wgpu's clip space: x to the right, y up, and depth from 0 to 1.
/// A matrix whose y points down, or whose x points to the left, makes a mirror image, for which the pipelines need
/// another [front face](crate::gpu::ShadowFormat::front_face). [`Self::from_matrix`] finds the depth direction, and
/// [`ShadowFormat::of_camera`](crate::gpu::ShadowFormat::of_camera) the rest.
///
/// ```
/// use glam::Vec3;
/// use glam::camera::rh::{proj::directx, view::look_at_mat4};
/// use rimline::gpu::ShadowFormat;
/// use rimline::{DepthDirection, ShadowCamera};
///
/// let (eye, target) = (Vec3::new(0.0, 2.0, 5.0), Vec3::ZERO);
///
/// // Depth from 0 to 1 with a far plane, `Mat4::perspective_rh` in older versions of glam:
/// let projection = directx::perspective(1.0, 16.0 / 9.0, 0.1, 100.0);
/// let matrix = projection * look_at_mat4(eye, target, Vec3::Y);
/// let camera = ShadowCamera::from_matrix(matrix.to_cols_array_2d(), [0.0; 3])?;
/// assert_eq!(camera.depth, DepthDirection::Standard);
/// // Pipelines for it. z-fail then needs `Features::DEPTH_CLIP_CONTROL`.
/// let format = ShadowFormat::of_camera(&camera)?;
/// assert!(format.has_far_plane);
///
/// // Reversed depth without a far plane, the default of `ShadowFormat`; positions relative to the eye:
/// let projection = directx::perspective_infinite_reverse(1.0, 16.0 / 9.0, 0.1);
/// let matrix = projection * look_at_mat4(Vec3::ZERO, target - eye, Vec3::Y);
/// let camera = ShadowCamera::from_matrix(matrix.to_cols_array_2d(), eye.to_array())?;
/// assert_eq!(ShadowFormat::of_camera(&camera)?, ShadowFormat::default());
///
/// // An orthographic camera must say its depth direction:
/// let projection = directx::orthographic(-2.0, 2.0, -1.0, 1.0, 0.1, 100.0);
/// let view_projection = (projection * look_at_mat4(eye, target, Vec3::Y)).to_cols_array_2d();
/// let camera = ShadowCamera { view_projection, origin: [0.0; 3], depth: DepthDirection::Standard };
/// camera.check()?;
/// # Ok::<(), rimline::CameraError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowCamera {
    /// Maps positions less [`Self::origin`] to clip space, with y up and depth from 0 to 1. Four columns. The camera is
    /// perspective or orthographic.
    pub view_projection: [[f32; 4]; 4],
    /// The point that positions are relative to, in their space. Set it to zero for a plain view-projection matrix. Far
    /// from the world's origin, set it to the eye's position and use a view without translation; this keeps the
    /// precision. Where positions themselves are too far away for `f32`, see [`Origin`](crate::Origin).
    pub origin: [f32; 3],
    /// Which depth is near.
    pub depth: DepthDirection,
}

/// Why shadow volumes cannot be drawn for a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// The matrix or the origin has an infinite or NaN component, or the matrix is singular.
    #[error("the camera's matrix is singular or not finite")]
    Singular,
    /// The near plane is not at right angles to the direction in which w grows.
    #[error("the camera's near plane is oblique; clip w must be constant on it")]
    Oblique,
    /// The depth direction of an orthographic matrix cannot be found: both of its planes could be the near one.
    #[error(
        "the camera's matrix is orthographic, and such a matrix does not tell which depth is near; make the `ShadowCamera` \
         with its `depth`"
    )]
    Orthographic,
    /// Near and far are the wrong way round. This cannot be detected for an orthographic camera.
    #[error("the near plane lies behind the camera; is depth reversed, as `depth` says?")]
    Backwards,
    /// The matrix makes a mirror image, as one does whose y points down. Near caps would be counted against the sides.
    #[error(
        "the camera's matrix makes a mirror image, for example because its y points down; clip space has y up, so change \
         the sign of its row of y (pipelines that are made for mirror images have `FrontFace::Cw`)"
    )]
    Mirrored,
    /// A perspective camera's near plane is nearer than 2⁻¹¹⁰, or clip w is below that there. Depths of what lies farther
    /// away would leave the normal range of `f32`.
    #[error(
        "the near plane is so near that depths leave the normal range of 32-bit floats; move it away, to a distance of \
         8e-34 at least"
    )]
    DepthRange,
}

/// The least distance of a near plane, and the least clip w there: 2⁻¹¹⁰. Depth at a distance of 1 then has 16 bits above
/// the least normal number. Devices flush what is below, in slopes of depth and in products with the near plane.
const LEAST_NEAR: f64 = f64::from_bits((1023 - 110) << 52);

impl ShadowCamera {
    /// The camera of a perspective matrix, four columns, for positions less `origin`. The depth direction is that of
    /// the matrix. It may make a mirror image and may have a far plane.
    ///
    /// # Errors
    /// [`CameraError`] for an orthographic matrix, which does not tell its depth direction, and for one of which no
    /// camera is made: singular, with an oblique near plane, with a near plane behind the eye, or with one so near that
    /// depths leave the normal range of `f32`.
    pub fn from_matrix(view_projection: [[f32; 4]; 4], origin: [f32; 3]) -> Result<Self, CameraError> {
        let with = |depth| Self { view_projection, origin, depth };
        let [reversed, standard] = [DepthDirection::Reversed, DepthDirection::Standard].map(with);
        match (reversed.view(), standard.view()) {
            (Ok(_), Ok(_)) => Err(CameraError::Orthographic),
            (Ok(_), Err(_)) => Ok(reversed),
            (Err(_), Ok(_)) => Ok(standard),
            // The other direction says nothing about the matrix.
            (Err(CameraError::Backwards), Err(error)) | (Err(error), Err(_)) => Err(error),
        }
    }

    /// Whether the far plane is at a finite distance; [`crate::gpu::ShadowFormat::has_far_plane`] takes this value. A
    /// matrix has no far plane only where that plane lies exactly at infinity. The smallest tilt of the plane may clip
    /// points at infinity.
    pub fn has_far_plane(&self) -> bool {
        let matrix = self.matrix();
        let (depth, w) = (matrix.row(2), matrix.row(3));
        let [far, opposite] = match self.depth {
            DepthDirection::Reversed => [depth, DVec4::ZERO],
            DepthDirection::Standard => [w, depth],
        };
        far.truncate() != opposite.truncate()
    }

    /// Checks that shadow volumes can be drawn for this camera, with pipelines of the default
    /// [front face](crate::gpu::ShadowFormat::front_face).
    ///
    /// # Errors
    /// [`CameraError`] for a singular matrix, an oblique near plane, near and far the wrong way round, a matrix that
    /// mirrors, or a near plane so near that depths leave the normal range of `f32`.
    pub fn check(&self) -> Result<(), CameraError> {
        self.view()?;
        if self.mirrors() { Err(CameraError::Mirrored) } else { Ok(()) }
    }

    /// The same, but mirror images are allowed, as for depth maps and the cameras that see them.
    #[cfg(any(feature = "gpu", test))]
    pub(crate) fn check_any_hand(&self) -> Result<(), CameraError> {
        self.view().map(drop)
    }

    /// Whether the matrix makes a mirror image, as one does whose y points down: counter-clockwise triangles are clockwise
    /// on the screen. It has no meaning for cameras that [`Self::check`] refuses for another reason than
    /// [`CameraError::Mirrored`].
    pub fn mirrors(&self) -> bool {
        (self.matrix().determinant() > 0.0) != (self.depth == DepthDirection::Reversed)
    }

    /// Its matrix, in `f64`.
    pub(crate) fn matrix(&self) -> DMat4 {
        Mat4::from_cols_array_2d(&self.view_projection).as_dmat4()
    }

    /// The point that positions are relative to, in `f64`.
    pub(crate) fn origin_point(&self) -> DVec3 {
        Vec3::from_array(self.origin).as_dvec3()
    }

    /// The camera as the GPU needs it.
    pub(crate) fn view(&self) -> Result<ShadowView, CameraError> {
        let matrix = self.matrix();
        let inverse = matrix.inverse();
        if !inverse.is_finite() || !self.origin_point().is_finite() || matrix.determinant() == 0.0 {
            return Err(CameraError::Singular);
        }
        let (depth, w) = (matrix.row(2), matrix.row(3));
        let (near_z, plane) = match self.depth {
            DepthDirection::Reversed => (1.0, w - depth),
            DepthDirection::Standard => (0.0, depth),
        };
        let length = plane.truncate().length();
        if length == 0.0 {
            // This depth lies only at infinity.
            return Err(CameraError::Backwards);
        }
        let plane = plane / length;
        let growth = w.truncate().dot(plane.truncate());
        let aside = (w.truncate() - growth * plane.truncate()).length();
        if aside > 1e-4 * w.truncate().length() {
            return Err(CameraError::Oblique);
        }
        let near_w = w.w - growth * plane.w;
        // Where w shrinks behind the plane, the plane is the far plane. The two planes of an orthographic camera cannot
        // be distinguished.
        if near_w <= 0.0 || growth < 0.0 {
            return Err(CameraError::Backwards);
        }
        // An orthographic camera has a constant w, and a constant distance between depths.
        if growth > 0.0 && near_w.min(near_w / growth) < LEAST_NEAR {
            return Err(CameraError::DepthRange);
        }
        let (mut near_min, mut near_max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
            let corner = inverse * (DVec4::new(x, y, near_z, 1.0) * near_w);
            let position = corner.truncate() / corner.w;
            near_min = near_min.min(position);
            near_max = near_max.max(position);
        }
        if !near_min.is_finite() || !near_max.is_finite() {
            return Err(CameraError::Singular);
        }
        let [x, y, z] = self.origin;
        Ok(ShadowView {
            view_projection: self.view_projection,
            near_plane: plane.as_vec4().to_array(),
            placement: [[1.0, 0.0, 0.0, -x], [0.0, 1.0, 0.0, -y], [0.0, 0.0, 1.0, -z]],
            near_min: near_min.as_vec3().to_array(),
            near_w: near_w as f32,
            near_max: near_max.as_vec3().to_array(),
            near_z: near_z as f32,
        })
    }

    /// The light as this camera sees it. The stages that choose have not run: `casting` and `counting` are 0. `view` is
    /// [`Self::view`] of this camera. The result has no meaning for a light that is all zeros or not finite.
    pub(crate) fn light(&self, view: &ShadowView, light: Light) -> ShadowLight {
        let range = light.range;
        let given = light.to_array().map(f64::from);
        // Multiplying a position by a w that is a power of two is exact. Where w is none, the light's position is rounded.
        let mantissa = if given[3] == 0.0 { 1.0 } else { given[3].abs() / power_of_two_below(given[3]) };
        let given = given.map(|c| c / mantissa);
        let largest = given.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
        let scale = power_of_two_below(largest).recip();
        let scaled = given.map(|c| c * scale);
        // The shaders see the values that f32 holds.
        let light = scaled.map(|c| c as f32);
        let [x, y, z, w] = light.map(f64::from);
        let from_origin = (DVec3::new(x, y, z) - w * self.origin_point()).extend(w);
        let matrix = self.matrix();
        let plane = DVec4::from_array(view.near_plane.map(f64::from));
        let height = plane.dot(from_origin);
        let clip = matrix * from_origin;
        // Hornus et al. 2005, section 3.1, without its rotation: w is positive between light and near plane.
        let side = if height < 0.0 { -1.0 } else { 1.0 };
        let frustum = |row: usize| (side * (height * matrix.row(row) - clip[row] * plane)).as_vec4().to_array();
        ShadowLight {
            light,
            clip: clip.as_vec4().to_array(),
            frustum_x: frustum(0),
            frustum_y: frustum(1),
            frustum_w: frustum(3),
            height: height as f32,
            range: if range.is_finite() { range } else { 0.0 },
            scale: (scale / mantissa) as f32,
            ..bytemuck::Zeroable::zeroed()
        }
    }
}

/// The share of a light's intensity that arrives at `distance`, from 1 to 0 (Bergeron 1986). All lengths are in one
/// unit.
///
/// * Up to `begin` (his `Dec_Begin`) it is 1.
/// * From `end` on (his `Light_End`, the light's range) it is 0.
/// * Between them it is `((end − distance) / (end − begin))` to the power of `exponent` (his `Decrease`), which is not
///   negative. An exponent of 1 is linear.
///
/// With an infinite `end` it is 1 everywhere. With `begin` beyond `end` it is a step at `end`.
#[must_use]
pub fn falloff(distance: f32, begin: f32, end: f32, exponent: f32) -> f32 {
    if end == f32::INFINITY {
        return 1.0;
    }
    if distance >= end {
        return 0.0;
    }
    if distance <= begin {
        return 1.0;
    }
    let left = (end - distance) / (end - begin);
    if left > 0.0 { left.min(1.0).powf(exponent) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::camera::rh::proj::directx::{
        orthographic, perspective, perspective_infinite, perspective_infinite_reverse,
    };
    use glam::camera::rh::view::look_at_mat4;
    use glam::{Vec4, Vec4Swizzles};
    use rimline_testkit::random::Random;

    const REVERSED: DepthDirection = DepthDirection::Reversed;
    const STANDARD: DepthDirection = DepthDirection::Standard;

    /// A camera at the origin that looks along −z. `z` and `w` are the rows of z and w in clip space.
    fn camera(z: [f32; 4], w: [f32; 4], depth: DepthDirection) -> ShadowCamera {
        let rows = [[2.0, 0.0, 0.0, 0.0], [0.0, 4.0, 0.0, 0.0], z, w];
        ShadowCamera {
            view_projection: Mat4::from_cols_array_2d(&rows).transpose().to_cols_array_2d(),
            origin: [0.0; 3],
            depth,
        }
    }

    fn mat(camera: ShadowCamera) -> Mat4 {
        Mat4::from_cols_array_2d(&camera.view_projection)
    }

    const PERSPECTIVE: [f32; 4] = [0.0, 0.0, -1.0, 0.0];
    const PARALLEL: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

    /// The near plane is at 0.5, the far plane at 8.5 or at infinity.
    fn cameras() -> [ShadowCamera; 6] {
        [
            camera([0.0, 0.0, 0.0, 0.5], PERSPECTIVE, REVERSED),
            camera([0.0, 0.0, -1.0, -0.5], PERSPECTIVE, STANDARD),
            camera([0.0, 0.0, 0.0625, 0.531_25], PERSPECTIVE, REVERSED),
            camera([0.0, 0.0, -1.0625, -0.531_25], PERSPECTIVE, STANDARD),
            camera([0.0, 0.0, 0.125, 1.0625], PARALLEL, REVERSED),
            camera([0.0, 0.0, -0.125, -0.0625], PARALLEL, STANDARD),
        ]
    }

    #[test]
    fn views_know_their_near_plane() {
        for (number, camera) in cameras().into_iter().enumerate() {
            let view = camera.view().expect("a good camera");
            assert_eq!(view.near_plane, [0.0, 0.0, -1.0, -0.5], "{number}");
            let near_w = if number < 4 { 0.5 } else { 1.0 };
            let near_z = if camera.depth == REVERSED { 1.0 } else { 0.0 };
            assert_eq!((view.near_w, view.near_z), (near_w, near_z), "{number}");
            let half = [near_w / 2.0, near_w / 4.0];
            assert_eq!(view.near_min, [-half[0], -half[1], -0.5], "{number}");
            assert_eq!(view.near_max, [half[0], half[1], -0.5], "{number}");
        }
    }

    #[test]
    fn far_planes_are_no_infinity() {
        let expected = [false, false, true, true, true, true];
        assert_eq!(cameras().map(|camera| camera.has_far_plane()), expected);
        // The camera's position and direction do not matter.
        let view = look_at_mat4(Vec3::new(3.0, -7.0, 1e3), Vec3::new(0.1, 0.2, 0.3), Vec3::Y);
        let moved =
            cameras().map(|camera| ShadowCamera { view_projection: (mat(camera) * view).to_cols_array_2d(), ..camera });
        assert_eq!(moved.map(|camera| camera.has_far_plane()), expected);
        let camera =
            |matrix: Mat4, depth| ShadowCamera { view_projection: matrix.to_cols_array_2d(), origin: [0.0; 3], depth };
        for (matrix, depth, expected) in [
            (perspective(1.0, 1.5, 0.1, 100.0), STANDARD, true),
            (perspective(1.0, 1.5, 100.0, 0.1), REVERSED, true),
            (perspective_infinite(1.0, 1.5, 0.1), STANDARD, false),
            (perspective_infinite_reverse(1.0, 1.5, 0.1), REVERSED, false),
        ] {
            assert_eq!(camera(matrix * view, depth).has_far_plane(), expected);
            assert!(camera(matrix * view, depth).view().is_ok());
        }
    }

    #[test]
    fn the_origin_moves_the_near_rectangle_and_the_light() {
        for camera in cameras() {
            let moved = ShadowCamera { origin: [100.0, -20.0, 3.0], ..camera };
            let (view, moved_view) = (camera.view().expect("good"), moved.view().expect("good"));
            for axis in 0..3 {
                // The near rectangle is in the camera's frame.
                assert_eq!(moved_view.near_min[axis], view.near_min[axis]);
                assert_eq!(moved_view.placement[axis][3], -moved.origin[axis]);
            }
            let at = |position: Vec3| Light::point(position.to_array());
            let light = camera.light(&view, at(Vec3::new(1.0, 2.0, -3.0)));
            let moved_light = moved.light(&moved_view, at(Vec3::new(101.0, -18.0, 0.0)));
            // Each light has its own power of two as a scale.
            let point = |light: &ShadowLight| {
                (Vec4::from_array(light.clip) / light.light[3], light.height / light.light[3], light.range)
            };
            assert_eq!(point(&light), point(&moved_light));
            assert_eq!(point(&light).1, 2.5);
            assert_eq!(point(&light).0.xy().to_array(), [2.0, 8.0]);
        }
    }

    #[test]
    fn lights_have_a_weight_that_is_a_power_of_two() {
        let camera = cameras()[0];
        let view = camera.view().expect("good");
        let light = |light: Light| camera.light(&view, light.with_range(2.0));
        let given = light(Light::homogeneous([9.0, 3.0, -6.0, 3.0]));
        assert_eq!(given.light, [1.5, 0.5, -1.0, 0.5]);
        assert_eq!((given.height, given.range), (0.75, 2.0));
        assert_eq!(light(Light::directional([0.0, 3.0, 4.0])).light, [0.0, 0.75, 1.0, 0.0]);
        assert_eq!(light(Light::directional([0.0, 3.0, 4.0])).height, -1.0);
        assert_eq!(camera.light(&view, Light::point([0.0; 3])).range, 0.0);
    }

    #[test]
    fn cameras_that_cannot_serve_are_typed_errors() {
        let error = |camera: ShadowCamera| camera.view().expect_err("a bad camera");
        let infinite = cameras()[0];
        let good = mat(infinite);
        let with = |matrix: Mat4| error(ShadowCamera { view_projection: matrix.to_cols_array_2d(), ..infinite });
        assert_eq!(with(Mat4::ZERO), CameraError::Singular);
        assert_eq!(with(good * f32::NAN), CameraError::Singular);
        assert_eq!(with(good * Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0))), CameraError::Singular);
        let origin = [0.0, f32::INFINITY, 0.0];
        assert_eq!(error(ShadowCamera { origin, ..infinite }), CameraError::Singular);
        assert_eq!(error(camera([0.3, 0.0, 0.0, 0.5], PERSPECTIVE, REVERSED)), CameraError::Oblique);
        assert_eq!(error(camera([0.3, 0.0, -1.0, -0.5], PERSPECTIVE, STANDARD)), CameraError::Oblique);
        let backwards = |camera: ShadowCamera, depth| error(ShadowCamera { depth, ..camera });
        // In each the near plane is at infinity or behind the camera, or the far plane is taken for the near one.
        assert_eq!(backwards(infinite, STANDARD), CameraError::Backwards);
        assert_eq!(backwards(cameras()[1], REVERSED), CameraError::Backwards);
        assert_eq!(backwards(cameras()[2], STANDARD), CameraError::Backwards);
        assert_eq!(backwards(cameras()[3], REVERSED), CameraError::Backwards);
        assert_eq!(error(camera([0.0, 0.0, -1.0, 0.5], PERSPECTIVE, STANDARD)), CameraError::Backwards);
    }

    #[test]
    fn mirror_images_are_refused() {
        for (number, camera) in cameras().into_iter().enumerate() {
            assert_eq!(camera.check(), Ok(()), "{number}");
            // A turn by half a circle is no mirror.
            let turned = Mat4::from_scale(Vec3::new(-1.0, -1.0, 1.0)) * mat(camera);
            assert_eq!(ShadowCamera { view_projection: turned.to_cols_array_2d(), ..camera }.check(), Ok(()));
            for flip in [Vec3::new(1.0, -1.0, 1.0), Vec3::new(-1.0, 1.0, 1.0)] {
                let matrix = Mat4::from_scale(flip) * mat(camera);
                let mirrored = ShadowCamera { view_projection: matrix.to_cols_array_2d(), ..camera };
                assert_eq!(mirrored.check(), Err(CameraError::Mirrored), "{number}, {flip}");
                assert_eq!(mirrored.check_any_hand(), Ok(()), "{number}");
            }
        }
    }

    /// Points and a triangle before the eye tell: the depth direction, and whether a matrix mirrors.
    fn seen(matrix: Mat4, eye: Vec3, view: Mat4) -> (DepthDirection, bool) {
        let to_world = view.as_dmat4().inverse();
        let ndc = |x: f64, y: f64, z: f64| {
            let world = to_world * DVec4::new(x, y, -z, 1.0) - eye.as_dvec3().extend(0.0);
            let clip = matrix.as_dmat4() * world;
            clip.truncate() / clip.w
        };
        let depth = if ndc(0.0, 0.0, 25.0).z > ndc(0.0, 0.0, 26.0).z { REVERSED } else { STANDARD };
        let [a, b, c] = [ndc(0.0, 0.0, 25.0), ndc(1.0, 0.0, 25.0), ndc(0.0, 1.0, 25.0)];
        (depth, (b - a).truncate().perp_dot((c - a).truncate()) < 0.0)
    }

    #[test]
    fn cameras_are_found_in_their_matrices() {
        let mut random = Random::new(91);
        for number in 0..4000 {
            let (near, far) = (random.between(0.01, 10.0), random.between(30.0, 1e4));
            let has_far_plane = number & 1 == 1;
            let projection = match number & 3 {
                0 => perspective_infinite(1.0, 1.5, near),
                1 => perspective(1.0, 1.5, near, far),
                2 => perspective_infinite_reverse(1.0, 1.5, near),
                _ => perspective(1.0, 1.5, far, near),
            };
            let flip = Vec3::new(1.0 - f32::from(number & 4 != 0) * 2.0, 1.0 - f32::from(number & 8 != 0) * 2.0, 1.0);
            let scale = 2.0_f32.powi(random.below(20) as i32 - 10);
            let eye = Vec3::from_array(random.direction()) * random.between(0.0, 100.0);
            let towards = Vec3::from_array(random.direction());
            let view = look_at_mat4(eye, eye + towards, towards.any_orthonormal_vector());
            // Relative to the world's origin, or to the eye.
            let (placement, origin) =
                if number & 16 == 0 { (view, Vec3::ZERO) } else { (Mat4 { w_axis: Vec4::W, ..view }, eye) };
            let clip = Mat4::from_scale(flip) * (projection * scale);
            let found =
                |clip: Mat4| ShadowCamera::from_matrix((clip * placement).to_cols_array_2d(), origin.to_array());
            let camera = found(clip).unwrap_or_else(|error| panic!("{number}: {error}"));
            let (depth, mirrors) = seen(clip * placement, origin, view);
            assert_eq!((camera.depth, camera.mirrors()), (depth, mirrors), "{number}");
            assert_eq!(camera.has_far_plane(), has_far_plane, "{number}");
            assert_eq!(camera.check(), if mirrors { Err(CameraError::Mirrored) } else { Ok(()) }, "{number}");
            // The same with near and far exchanged, seen in a mirror, and behind the eye.
            let exchanged = Mat4::from_cols_array_2d(&[
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, -1.0, 0.0],
                [0.0, 0.0, 1.0, 1.0],
            ]);
            assert_ne!(found(exchanged * clip).map(|camera| camera.depth), Ok(depth), "{number}");
            let mirrored = found(Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0)) * clip);
            assert_ne!(mirrored.map(|camera| camera.mirrors()), Ok(mirrors), "{number}");
            // The far plane, which here may be taken for the near one, is found with less precision.
            assert!(matches!(found(clip * -1.0), Err(CameraError::Backwards | CameraError::Oblique)), "{number}");
            for [near, far] in [[near, far], [far, near]] {
                let matrix = Mat4::from_scale(flip) * orthographic(-2.0, 2.0, -1.0, 1.0, near, far);
                assert_eq!(found(matrix), Err(CameraError::Orthographic), "{number}");
            }
        }
    }

    #[test]
    fn near_planes_must_leave_depth_normal() {
        let near = |near: f32, scale: f32, depth| {
            let z = if depth == REVERSED { [0.0, 0.0, 0.0, near] } else { [0.0, 0.0, -1.0, -near] };
            let rows = [[2.0, 0.0, 0.0, 0.0], [0.0, 4.0, 0.0, 0.0], z, PERSPECTIVE].map(|row| row.map(|c| c * scale));
            let view_projection = Mat4::from_cols_array_2d(&rows).transpose().to_cols_array_2d();
            ShadowCamera { view_projection, origin: [0.0; 3], depth }.check()
        };
        for depth in [REVERSED, STANDARD] {
            for good in [1e-33, 1e-30, 0.1, 1e30] {
                assert_eq!(near(good, 1.0, depth), Ok(()), "{good:e}");
            }
            for bad in [7e-34, 1e-35, 1e-36, 1e-38, 1e-44] {
                assert_eq!(near(bad, 1.0, depth), Err(CameraError::DepthRange), "{bad:e}");
            }
        }
        // The same plane in clip coordinates that are too small, and one that is too near in large ones.
        assert_eq!(near(1e-5, 1e-30, REVERSED), Err(CameraError::DepthRange));
        assert_eq!(near(1e-36, 1e6, REVERSED), Err(CameraError::DepthRange));
    }

    #[test]
    fn lights_end_at_their_range() {
        assert_eq!([0.0, 1.0, 2.0, 3.0, 4.0].map(|d| falloff(d, 1.0, 3.0, 2.0)), [1.0, 1.0, 0.25, 0.0, 0.0]);
        assert_eq!(falloff(1e30, 1.0, f32::INFINITY, 2.0), 1.0);
        // No distance to fall over: a step.
        assert_eq!([1.9, 2.0, 2.1].map(|d| falloff(d, 2.0, 2.0, 1.0)), [1.0, 0.0, 0.0]);
        // It begins beyond its end: also a step, dark from there on.
        assert_eq!([2.9, 3.0, 3.5, 5.0].map(|d| falloff(d, 4.0, 3.0, 1.0)), [1.0, 0.0, 0.0, 0.0]);
    }
}
