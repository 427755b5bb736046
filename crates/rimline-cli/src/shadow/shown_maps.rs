//! The boundaries that a light's depth maps have, as they are shown.

use glam::{DMat4, DVec3, DVec4, Mat4, Vec3};
use rimline::{DepthDirection, ShadowCamera, wgpu};

use super::light_maps::LightCameras;
use crate::device::Gpu;

/// Instances of the draws of triangles and of lines. A cell has six vertices in each: two triangles, and of the twelve ends of
/// lines eight, two lines for each triangle.
const INSTANCES: [u32; 2] = [1, 2];

/// Layout of `DepthView` in `depth_volumes.wgsl`.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct DepthView {
    across: [f32; 4],
    up: [f32; 4],
    depth: [f32; 4],
    middle: [f32; 4],
    far_across: [f32; 4],
    far_up: [f32; 4],
    far_middle: [f32; 4],
}

#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct DepthViews {
    size: [u32; 2],
    maps: u32,
    is_reversed: u32,
    capacity: u32,
    unused: [u32; 3],
    views: [DepthView; 6],
}

/// Buffers of the overlay of a light's maps.
pub(super) struct ShownMaps {
    pub(super) views: wgpu::Buffer,
    /// Arguments of the draws of triangles and of lines: of what is listed, then of every cell where a list of walls overflowed.
    pub(super) draws: wgpu::Buffer,
    has_walls: bool,
}

impl ShownMaps {
    pub(super) fn new(gpu: &Gpu, has_walls: bool) -> Self {
        let draws = gpu.buffer("draws of shown depth maps", 64, wgpu::BufferUsages::INDIRECT);
        let of_each = INSTANCES.map(|instances| [0, instances, 0, 0]);
        gpu.queue.write_buffer(&draws, 0, bytemuck::cast_slice(&[of_each, of_each]));
        let views = gpu.buffer("shown depth maps", size_of::<DepthViews>() as u64, wgpu::BufferUsages::UNIFORM);
        Self { views, draws, has_walls }
    }

    /// Takes the maps as the eye sees them, and what `arguments` of the draws say once the commands are done.
    pub(super) fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (cameras, size): (&LightCameras, [u32; 2]),
        eye: &ShadowCamera,
        (arguments, capacity): (&wgpu::Buffer, u32),
    ) {
        let all = &cameras.0;
        let mut views = [DepthView::default(); 6];
        let light = cameras.light();
        let place = (light.w != 0.0).then(|| Vec3::from(light.xyz).as_dvec3() / f64::from(light.w));
        let away = -Vec3::from(light.xyz).as_dvec3();
        for (view, camera) in views.iter_mut().zip(all) {
            *view = depth_view(camera, eye, place, away);
        }
        let is_reversed = u32::from(all.first().is_some_and(|camera| camera.depth == DepthDirection::Reversed));
        // No maps: the list is one of walls.
        let has_walls = self.has_walls;
        let maps = if has_walls { 0 } else { all.len() as u32 };
        let views = DepthViews { size, maps, is_reversed, capacity, unused: [0; 3], views };
        gpu.queue.write_buffer(&self.views, 0, bytemuck::bytes_of(&views));
        for draw in [0, 16] {
            encoder.copy_buffer_to_buffer(arguments, 0, &self.draws, draw, 4);
            if has_walls {
                encoder.copy_buffer_to_buffer(arguments, 16, &self.draws, 32 + draw, 4);
            }
        }
    }
}

/// A map's coordinates in an eye's clip space. `place` is where the map is seen from, if not from infinity; then the rays run
/// `away`.
fn depth_view(camera: &ShadowCamera, eye: &ShadowCamera, place: Option<DVec3>, away: DVec3) -> DepthView {
    let matrix = |camera: &ShadowCamera| Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
    let [origin, eye_origin] = [camera, eye].map(|camera| Vec3::from(camera.origin).as_dvec3());
    let inverse = matrix(camera).inverse();
    let to_eye = matrix(eye);
    let whole = to_eye * DMat4::from_translation(origin - eye_origin) * inverse;
    let ray =
        |of: DVec4| place.map_or(DVec4::ZERO, |place| to_eye * (of.truncate() - of.w * (place - origin)).extend(0.0));
    let near = if camera.depth == DepthDirection::Reversed { 1.0 } else { 0.0 };
    let far_middle = match place {
        Some(_) => ray(inverse.w_axis + near * inverse.z_axis),
        None => to_eye * away.extend(0.0),
    };
    let f32s = |column: DVec4| column.as_vec4().to_array();
    DepthView {
        across: f32s(whole.x_axis),
        up: f32s(whole.y_axis),
        depth: f32s(whole.z_axis),
        middle: f32s(whole.w_axis),
        far_across: f32s(ray(inverse.x_axis)),
        far_up: f32s(ray(inverse.y_axis)),
        far_middle: f32s(far_middle),
    }
}

/// A light's maps, as they are shown.
pub(crate) struct ShownDepths<'a> {
    pub(super) shown: &'a ShownMaps,
    pub(super) cells: &'a wgpu::Buffer,
    /// One map, or six in one.
    pub(super) texture: &'a wgpu::TextureView,
}
