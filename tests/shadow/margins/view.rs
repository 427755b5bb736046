//! A camera in `f64`, from the matrix that the stages get: the near rectangle, and what is seen on it from a light.

use bytemuck::Zeroable;
use glam::{DMat4, DVec3, DVec4};
use rimline::internals::layout::{ShadowLight, ShadowShape, ShadowView};
use rimline::internals::shadow;
use rimline::internals::stages::COUNTING_METHODS;
use rimline::{DepthDirection, Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::uniform;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;

use rimline_testkit::stage_probe::Probe;

/// The camera's matrix and near plane, about its origin.
pub(crate) struct Eye {
    pub(crate) matrix: DMat4,
    inverse: DMat4,
    pub(crate) origin: DVec3,
    /// Height over the near plane, up to a factor.
    pub(crate) plane: DVec4,
    near_z: f64,
}

impl Eye {
    pub(crate) fn new(camera: &ShadowCamera) -> Self {
        let matrix = glam::Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let (plane, near_z) = match camera.depth {
            DepthDirection::Reversed => (matrix.row(3) - matrix.row(2), 1.0),
            DepthDirection::Standard => (matrix.row(2), 0.0),
        };
        Self {
            matrix,
            inverse: matrix.inverse(),
            origin: DVec3::from_array(camera.origin.map(f64::from)),
            plane,
            near_z,
        }
    }

    /// The point of the near plane at these coordinates of the picture, from −1 to 1 within it, about the origin.
    pub(crate) fn near_point(&self, [x, y]: [f64; 2]) -> DVec4 {
        let p = self.inverse * DVec4::new(x, y, self.near_z, 1.0);
        p / p.w
    }

    /// The same in world space.
    pub(crate) fn on_near_plane(&self, at: [f64; 2]) -> DVec3 {
        self.near_point(at).truncate() + self.origin
    }

    /// A point of the near plane within the picture.
    pub(crate) fn on_picture(&self, random: &mut Random) -> DVec3 {
        self.on_near_plane([0, 1].map(|_: i32| f64::from(random.between(-1.0, 1.0))))
    }

    /// Corners of the near rectangle, in order around it, about the origin.
    pub(crate) fn corners(&self) -> [DVec4; 4] {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|corner| self.near_point(corner))
    }

    /// Lowest and highest corner of the near rectangle's box.
    pub(crate) fn near_box(&self) -> [DVec3; 2] {
        let corners = self.corners().map(|corner| corner.truncate() + self.origin);
        corners.into_iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
    }

    /// Height over the near plane in parts of its terms.
    pub(crate) fn height(&self, point: DVec3) -> f64 {
        let terms = self.plane * (point - self.origin).extend(1.0);
        terms.element_sum() / terms.abs().element_sum()
    }

    /// Where on the picture the light, which is a point, has a point, and how far on the way from the light to the near
    /// plane that is: 0 at the light, 1 on the plane.
    pub(crate) fn seen_from_light(&self, light: DVec3, point: DVec3) -> ([f64; 2], f64) {
        let at = |p: DVec3| self.plane.dot((p - self.origin).extend(1.0));
        let (from, to) = (at(light), at(point));
        let part = (from - to) / from;
        let meeting = light + (point - light) / part;
        let clip = self.matrix * (meeting - self.origin).extend(1.0);
        ([clip.x / clip.w, clip.y / clip.w], part)
    }
}

/// The lowest and the highest of some positions.
pub(crate) fn box_of(positions: impl IntoIterator<Item = [f32; 3]>) -> [[f32; 3]; 2] {
    let empty = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    positions.into_iter().fold(empty, |[low, high], p| {
        [std::array::from_fn(|axis| p[axis].min(low[axis])), std::array::from_fn(|axis| p[axis].max(high[axis]))]
    })
}

/// A camera, a light and the positions of a caster.
pub(crate) type Case = (ShadowCamera, Light, Vec<[f32; 3]>);

/// Options of a closed caster without light in the plane of a face.
pub(crate) fn options(counting: u32, is_closed: bool) -> ShadowShape {
    ShadowShape { allow_back_facing: u32::from(is_closed), counting, cull_by_range: 1, ..Zeroable::zeroed() }
}

/// Each light as the stages get it, with what is chosen for the caster.
pub(crate) fn chosen(gpu: &Gpu, shape: ShadowShape, cases: &[Case]) -> Result<Vec<(ShadowView, ShadowLight)>, String> {
    let probe = Probe::of(
        gpu,
        &COUNTING_METHODS,
        [2, 1],
        "let light = choose_by_box(pair.view, pair.light, 1.0, CLOSED, input_position(0u), input_position(1u), false, false);
    out[0] = vec4<f32>(f32(light.casting), f32(light.counting), light.end, light.frustum_near);",
    )?;
    let given = |(camera, light, _): &Case| {
        let view = shadow::view(camera).map_err(text)?;
        Ok((view, shadow::light(camera, &view, *light)))
    };
    let mut seen = cases.iter().map(given).collect::<Result<Vec<_>, String>>()?;
    let inputs: Vec<_> =
        (0..).zip(cases).map(|(number, (_, _, positions))| (number, box_of(positions.iter().copied()))).collect();
    let (shape, statistics) = (uniform(gpu, &shape), gpu.storage(&[0_u32; 13]));
    let bound = [(0, &shape), (6, &statistics)];
    let found = probe.run(gpu, &bound, &seen, &inputs)?;
    for ((_, light), found) in seen.iter_mut().zip(found) {
        let [casting, counting, end, frustum_near] = found[0];
        (light.casting, light.counting) = (casting as u32, counting as u32);
        (light.end, light.frustum_near) = (end, frustum_near);
    }
    Ok(seen)
}

/// The next number above, so many times; below for a negative number.
pub(crate) fn stepped(value: f32, steps: i32) -> f32 {
    let key = |bits: u32| if bits >> 31 == 0 { bits as i32 } else { -((bits & 0x7fff_ffff) as i32) };
    let at = key(value.to_bits()) + steps;
    f32::from_bits(if at < 0 { (-at) as u32 | 1 << 31 } else { at as u32 })
}

/// The least `f32` that is not below, and the largest that is not above.
pub(crate) fn around(value: f64) -> [f32; 2] {
    let near = value as f32;
    let below = if f64::from(near) > value { stepped(near, -1) } else { near };
    let above = if f64::from(near) < value { stepped(near, 1) } else { near };
    [below, above]
}
