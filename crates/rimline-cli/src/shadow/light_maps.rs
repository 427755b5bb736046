//! The cameras of a light's depth map: one that sees all casters, or six around the light. And the
//! boundaries that the maps have, as they are shown.

use glam::{DMat3, DMat4, DVec3, DVec4, Mat4, Vec3};
use rimline::gpu::depth_map::{DepthMapCube, DepthMapError};
use rimline::{DepthDirection, Light, ShadowCamera, wgpu};
use rimline_picture::filled;

use crate::device::Gpu;

/// One camera, or six around a light that is among the casters, or close to them.
#[derive(Clone, Debug)]
pub(super) struct LightCameras(pub(super) Vec<ShadowCamera>);

/// The tangent of half the angle that one map may see.
const WIDEST: f64 = 2.0;
/// Times the extent of the casters that a light may be away before its rays are taken for parallel.
const FARTHEST: f64 = 1e12;
/// Room beside the casters, as a share of what is seen: a texel and more at the usual sides of maps.
const MARGIN: f64 = 1.02;

impl LightCameras {
    /// Sees `points`, of which there is at least one, with a map of `side` texels or six.
    pub(super) fn new(light: &Light, points: &[[f32; 3]], side: u32) -> Result<Self, DepthMapError> {
        let points = || points.iter().map(|&point| Vec3::from(point).as_dvec3());
        let (low, high) = points()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)));
        // Positions are relative to exactly this float.
        let centre = (low.midpoint(high)).as_vec3();
        let from_centre = || points().map(|point| point - centre.as_dvec3());
        let extent = from_centre().map(DVec3::length).fold(0.0, f64::max).max(1e-30);
        let xyz = Vec3::from(light.xyz).as_dvec3();
        let towards_light = xyz / f64::from(light.w) - centre.as_dvec3();
        // Farther away, the numbers of the camera leave the range of f32, and no texel tells the difference.
        let is_parallel = light.w == 0.0 || towards_light.length() > FARTHEST * extent;
        let towards = if is_parallel { xyz } else { towards_light };
        let around = || Self::around(centre, towards_light, extent, side);
        let Some(forward) = (-towards).try_normalize() else { return around() };
        let right = forward.any_orthonormal_vector();
        let axes = [right, right.cross(forward), forward];
        let distance = if is_parallel { 0.0 } else { towards_light.length() };
        let seen = || from_centre().map(|point| DVec3::from_array(axes.map(|axis| axis.dot(point))));
        let (near, far) =
            seen().fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), p| (near.min(p.z), far.max(p.z)));
        // So flat models have depth, too.
        let room = 0.01 * extent;
        let (near, far) = (near - room, far + room);
        if is_parallel {
            let widths = seen().fold(DVec3::splat(room), |most, p| most.max(p.abs())) * MARGIN;
            let rows = [
                (right / widths.x).extend(0.0),
                (axes[1] / widths.y).extend(0.0),
                (DVec4::W * far - forward.extend(0.0)) / (far - near),
                DVec4::W,
            ];
            return Ok(Self(vec![camera(rows, centre)]));
        }
        let near = near + distance;
        let tangents = seen().map(|p| p.abs() / (p.z + distance)).fold(DVec3::ZERO, DVec3::max) * MARGIN;
        if near <= room || tangents.truncate().max_element() > WIDEST {
            return around();
        }
        let tangents = tangents.max(DVec3::splat(room / (far + distance)));
        let scale = near / (far + distance - near);
        let rows = [
            (right / tangents.x).extend(0.0),
            (axes[1] / tangents.y).extend(0.0),
            (DVec4::W * far - forward.extend(0.0)) * scale,
            forward.extend(distance),
        ];
        Ok(Self(vec![camera(rows, centre)]))
    }

    pub(super) fn is_cube(&self) -> bool {
        self.0.len() > 1
    }

    /// The light: the point that the maps are seen from, or the direction towards it. The cameras have passed their check.
    pub(super) fn light(&self) -> Light {
        let Some(camera) = self.0.first() else { return Light::directional([0.0; 3]) };
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
        if w.truncate() == DVec3::ZERO {
            // The way that keeps x and y; depth grows along it, or falls where it is reversed.
            let way = x.truncate().cross(y.truncate()).normalize_or_zero();
            let is_away = (way.dot(z.truncate()) * w.w > 0.0) == (camera.depth == DepthDirection::Standard);
            return Light::directional((if is_away { -way } else { way }).as_vec3().into());
        }
        // The point where x, y and w are 0.
        let rows = DMat3::from_cols(x.truncate(), y.truncate(), w.truncate()).transpose();
        let position = rows.inverse() * -DVec3::new(x.w, y.w, w.w);
        Light::point((position + Vec3::from(camera.origin).as_dvec3()).as_vec3().into())
    }

    fn around(centre: Vec3, from_centre: DVec3, extent: f64, side: u32) -> Result<Self, DepthMapError> {
        // No camera may have a nearer one.
        let near = (1e-4 * extent).max(1e-33) as f32;
        let position = (centre.as_dvec3() + from_centre).as_vec3().to_array();
        let cameras = DepthMapCube::cameras(position, near, None, DepthDirection::Reversed, side)?;
        Ok(Self(cameras.to_vec()))
    }
}

fn camera([x, y, z, w]: [DVec4; 4], origin: Vec3) -> ShadowCamera {
    ShadowCamera {
        view_projection: DMat4::from_cols(x, y, z, w).transpose().as_mat4().to_cols_array_2d(),
        origin: origin.to_array(),
        depth: DepthDirection::Reversed,
    }
}

/// Instances of the draws of triangles and of lines. A cell has six vertices in each: two triangles, and of the twelve
/// ends of lines eight, two lines for each triangle.
const INSTANCES: [u32; 2] = [1, 2];

/// Layout of `DepthView` in `depth_overlay.wgsl`.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct DepthView {
    /// Across, up, depth and middle.
    whole: [[f32; 4]; 4],
    /// Across, up and middle.
    far: [[f32; 4]; 3],
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
pub(crate) struct ShownMaps {
    pub(super) views: wgpu::Buffer,
    /// Arguments of the draws of triangles and of lines: of what is listed, then of every cell where a list of walls
    /// overflowed.
    pub(super) draws: wgpu::Buffer,
    has_walls: bool,
}

impl ShownMaps {
    pub(super) fn new(gpu: &Gpu, has_walls: bool) -> Self {
        let of_each = INSTANCES.map(|instances| [0, instances, 0, 0]);
        let (on, draws) = ((&gpu.device, &gpu.queue), [of_each, of_each]);
        let draws = filled(on, "draws of shown maps", bytemuck::cast_slice(&draws), wgpu::BufferUsages::INDIRECT);
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
        let light_position = (light.w != 0.0).then(|| Vec3::from(light.xyz).as_dvec3() / f64::from(light.w));
        let away = -Vec3::from(light.xyz).as_dvec3();
        for (view, camera) in views.iter_mut().zip(all) {
            *view = depth_view(camera, eye, light_position, away);
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

/// A map's coordinates in an eye's clip space. `light_position` is where the map is seen from. `None`: from infinity, and the
/// rays run `away`, which counts only then.
fn depth_view(camera: &ShadowCamera, eye: &ShadowCamera, light_position: Option<DVec3>, away: DVec3) -> DepthView {
    let matrix = |camera: &ShadowCamera| Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
    let [origin, eye_origin] = [camera, eye].map(|camera| Vec3::from(camera.origin).as_dvec3());
    let inverse = matrix(camera).inverse();
    let to_eye = matrix(eye);
    let whole = to_eye * DMat4::from_translation(origin - eye_origin) * inverse;
    let ray = |of: DVec4| {
        light_position.map_or(DVec4::ZERO, |light_position| {
            to_eye * (of.truncate() - of.w * (light_position - origin)).extend(0.0)
        })
    };
    let near = if camera.depth == DepthDirection::Reversed { 1.0 } else { 0.0 };
    let far_middle = match light_position {
        Some(_) => ray(inverse.w_axis + near * inverse.z_axis),
        None => to_eye * away.extend(0.0),
    };
    let far = [ray(inverse.x_axis), ray(inverse.y_axis), far_middle];
    DepthView { whole: whole.as_mat4().to_cols_array_2d(), far: far.map(|column| column.as_vec4().to_array()) }
}

/// A light's maps as they are shown.
pub(crate) struct ShownDepths<'a> {
    pub(super) shown: &'a ShownMaps,
    /// The list of cells.
    pub(super) cells: &'a wgpu::Buffer,
    /// One map, or six in one.
    pub(super) texture: &'a wgpu::TextureView,
}

#[cfg(test)]
mod tests {
    use rimline_picture::Bounds;

    use super::*;

    fn corners(half: f32, at: [f32; 3]) -> Vec<[f32; 3]> {
        let at = Vec3::from(at);
        Bounds { min: at - half, max: at + half }.corners().map(|corner| corner.to_array()).to_vec()
    }

    #[test]
    fn a_light_is_where_its_maps_look_from() {
        let points = corners(1.0, [10.0, 0.0, 0.0]);
        for light in [
            Light::point([10.0, 5.0, 0.0]),
            Light::point([13.0, 1.0, 4.0]),
            Light::point([10.5, 0.1, 0.0]),
            Light::directional([0.3, 1.0, -2.0]),
            Light::directional([0.0, -1.0, 0.0]),
        ] {
            let cameras = LightCameras::new(&light, &points, 64).unwrap();
            let found = cameras.light();
            let unit = |light: &Light| {
                Vec3::from(light.xyz) / if light.w == 0.0 { Vec3::from(light.xyz).length() } else { 1.0 }
            };
            assert_eq!(found.w, light.w, "{light:?}");
            assert!((unit(&found) - unit(&light)).length() < 1e-4, "{light:?}: {found:?}");
            // Negative control: depth the other way round is seen from the other side.
            let [camera] = cameras.0[..] else { continue };
            let other = LightCameras(vec![ShadowCamera { depth: DepthDirection::Standard, ..camera }]).light();
            assert_eq!((unit(&other) - unit(&light)).length() > 1.0, light.w == 0.0, "{light:?}: {other:?}");
        }
    }

    /// All points are in the picture, between the near and the far plane.
    fn sees(camera: &ShadowCamera, points: &[[f32; 3]]) -> bool {
        let matrix = glam::Mat4::from_cols_array_2d(&camera.view_projection);
        points.iter().all(|&point| {
            let clip = matrix * (Vec3::from(point) - Vec3::from(camera.origin)).extend(1.0);
            let [x, y, z] = [clip.x, clip.y, clip.z].map(|c| c / clip.w);
            clip.w > 0.0 && x.abs() < 1.0 && y.abs() < 1.0 && z > 0.0 && z < 1.0
        })
    }

    #[test]
    fn a_light_outside_has_one_map_that_sees_all() {
        let points = corners(1.0, [10.0, 0.0, 0.0]);
        for light in [
            Light::point([10.0, 5.0, 0.0]),
            Light::point([13.0, 1.0, 4.0]),
            Light::point([10.0, 1e6, 0.0]),
            Light::directional([0.3, 1.0, -2.0]),
            Light::homogeneous([1.0, 2.0, 3.0, 1e-42]),
        ] {
            let [camera] = LightCameras::new(&light, &points, 64).unwrap().0[..] else {
                panic!("{light:?} has a cube")
            };
            assert!(sees(&camera, &points), "{light:?}");
            assert!(!sees(&camera, &corners(1.0, [14.0, 9.0, 0.0])), "negative control: {light:?}");
        }
        // Flat, and seen edge-on.
        let flat: Vec<_> = points.iter().map(|&[x, _, z]| [x, 0.0, z]).collect();
        for light in [Light::point([20.0, 0.0, 0.0]), Light::directional([1.0, 0.0, 0.0])] {
            let [camera] = LightCameras::new(&light, &flat, 64).unwrap().0[..] else { panic!("{light:?} has a cube") };
            assert!(sees(&camera, &flat), "{light:?}");
        }
    }

    #[test]
    fn a_light_among_the_casters_has_a_cube() {
        let points = corners(1.0, [0.0; 3]);
        for position in [[0.0; 3], [0.5, 0.9, 0.0], [0.0, 1.2, 0.0]] {
            let cameras = LightCameras::new(&Light::point(position), &points, 64);
            assert!(cameras.is_ok_and(|cameras| cameras.is_cube()), "{position:?}");
        }
    }
}
