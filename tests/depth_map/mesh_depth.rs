//! Meshes without a triangle in a map, and maps of meshes against rays of the light.

use glam::{DVec2, DVec3};
use rimline::gpu::PositionBuffer;
use rimline::gpu::depth_map::MeshDepth;
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{DepthDirection, Mesh, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{must_fail, rays, same};
use wgpu::TextureFormat::{self, Depth32Float};

use crate::parity::{device_depth, middle};
use crate::scene::Rays;
use crate::stages::camera;
use rimline_testkit::textures::{pass, read, texture};

pub(crate) const TESTS: &[Test] = &[("meshes_without_a_triangle_have_no_depth", without_triangles)];

pub(crate) const SIDE: u32 = 48;

/// The texels of a map after a pass.
pub(crate) fn map(
    gpu: &Gpu,
    format: TextureFormat,
    light: &ShadowCamera,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Result<(), String>,
) -> Result<Vec<f32>, String> {
    let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    let target = texture(gpu, [SIDE; 2], format, &[far; (SIDE * SIDE) as usize])?;
    pass(gpu, &target, (Some(wgpu::LoadOp::Load), None), draw)?;
    read(gpu, &target)
}

/// Texels that are wrong, of those where nearby rays bound the depth.
pub(crate) fn wrong(
    triangles: impl Iterator<Item = [DVec3; 3]>,
    light: &ShadowCamera,
    (depths, step): (&[f32], f32),
) -> [usize; 2] {
    let tracer = rays::Tracer::build(triangles.map(|corners| (corners, ())));
    let rays = Rays::new(light, SIDE);
    let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    let seen = |pixel: DVec2| {
        let (from, direction) = rays.at(pixel);
        let near = tracer.meetings((from, direction)).map(|(t, _)| t).filter(|t| *t > 0.0).min_by(f64::total_cmp);
        near.map_or(far, |t| device_depth(light, from + t * direction))
    };
    let mut counts = [0, 0];
    for (texel, &found) in (0..).zip(depths) {
        let middle = middle(texel, SIDE);
        let around = [[0.0, 0.0], [0.05, 0.05], [-0.05, 0.05], [0.05, -0.05], [-0.05, -0.05]];
        let around = around.map(|offset| seen(middle + DVec2::from_array(offset)));
        let low = around.iter().copied().fold(f32::INFINITY, f32::min);
        let high = around.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        counts[0] += usize::from(found < low - step || found > high + step);
        counts[1] += usize::from(found != far);
    }
    counts
}

/// Meshes without a triangle, and polygons that are walked back, draw nothing.
fn without_triangles() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let light = camera(DepthDirection::Reversed);
    let corners = [[1.0, -3.0, 3.0], [4.0, -3.0, 3.0], [2.5, -3.0, 6.0]];
    let walked_back = PolygonLoops { polygon_loops: &[1], loop_sizes: &[4], loop_corners: &[0, 1, 1, 0] };
    let drawn = |mesh: &Mesh| {
        let buffer = gpu.storage(&corners);
        let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
        let renderer = MeshDepth::new(&gpu.pipelines, mesh, Depth32Float, light.depth).map_err(text)?;
        map(&gpu, Depth32Float, &light, |pass| renderer.draw(pass, positions, &light).map_err(text))
    };
    let nothing = map(&gpu, Depth32Float, &light, |_| Ok(()))?;
    for mesh in [
        Mesh::from_faces(1, vec![[0; 3]]),
        Mesh::from_polygons(&corners, walked_back, Weld::Keep),
        Mesh::from_polygons_by_loop(&corners, walked_back, Weld::Keep),
    ] {
        same("depths", &drawn(&mesh.map_err(text)?)?, &nothing)?;
    }
    let face = Mesh::from_faces(3, vec![[0, 1, 2]]).map_err(text)?;
    must_fail("a face", &same("depths", &drawn(&face)?, &nothing))
}
