//! The depth of a mesh in a map against rays of the light.

use glam::{DVec2, DVec3};
use rimline::gpu::depth_map::{DepthMapError, MeshDepth};
use rimline::gpu::{DeviceError, PositionBuffer};
use rimline::mesh::Weld;
use rimline::{DepthDirection, Mesh, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{rays, shapes};
use wgpu::TextureFormat::Depth32Float;

use crate::parity::{device_depth, middle};
use crate::scene::{Eye, Rays};
use crate::textures::{read, texture};

pub(crate) const TESTS: &[Test] = &[("the_depth_of_a_mesh_is_that_of_rays", depths)];

pub(crate) const SIDE: u32 = 48;

fn drawn(gpu: &Gpu, shape: &shapes::Shape, light: &ShadowCamera, made: DepthDirection) -> Result<Vec<f32>, String> {
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Keep).map_err(text)?;
    let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    let map = texture(gpu, [SIDE; 2], Depth32Float, &vec![far; (SIDE * SIDE) as usize])?;
    let view = map.create_view(&wgpu::TextureViewDescriptor::default());
    let renderer = MeshDepth::new(&gpu.pipelines, &mesh, Depth32Float, made).map_err(text)?;
    // An offset that no binding may have, and a stride beyond the position.
    let mut words = vec![9.0_f32; 3];
    words.extend(shape.positions.iter().flat_map(|&[x, y, z]| [x, y, z, 7.0, 8.0]));
    let buffer = gpu.storage(&words);
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let short = PositionBuffer { buffer: &buffer, offset: 32, stride: 20 };
        if !matches!(
            renderer.draw(&mut pass, short, light),
            Err(DepthMapError::Device(DeviceError::PositionsTooShort { .. }) | DepthMapError::Depth { .. })
        ) {
            return Err("a buffer that is too short was taken".to_owned());
        }
        renderer.draw(&mut pass, PositionBuffer { offset: 12, ..short }, light).map_err(text)
    })?;
    read(gpu, &map)
}

/// Texels that are wrong, of those where nearby rays tell a bounded depth.
pub(crate) fn wrong(
    triangles: impl Iterator<Item = [DVec3; 3]>,
    light: &ShadowCamera,
    (depths, step): (&[f32], f32),
) -> [usize; 2] {
    let tracer = rays::Tracer::build(triangles.map(|corners| (corners, ())));
    let rays = Rays::new(light, SIDE);
    let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    let seen = |place: DVec2| {
        let (from, direction) = rays.at(place);
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

fn depths() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let shape = shapes::torus(24, 16, 1.5, 0.5);
    for depth in [DepthDirection::Reversed, DepthDirection::Standard] {
        for (far, half_width) in [(None, None), (Some(20.0), None), (Some(20.0), Some(3.0))] {
            for is_relative in [false, true] {
                let place = DVec3::new(2.0, 5.0, 1.0);
                let light = Eye { place, forward: -place, near: 1.0, is_relative, depth, far, half_width }.camera();
                let depths = drawn(&gpu, &shape, &light, depth)?;
                let corner = |v: u32| DVec3::from_array(shape.positions[v as usize].map(f64::from));
                let triangles = || shape.faces.iter().map(|face| face.map(corner));
                let [bad, covered] = wrong(triangles(), &light, (&depths, 1e-6));
                let mut moved = depths;
                moved.rotate_right(3);
                let [noticed, _] = wrong(triangles(), &light, (&moved, 1e-6));
                if bad > 0 || covered < 100 || noticed < 50 {
                    return Err(format!("{depth:?} {far:?} {half_width:?}: {bad} wrong of {covered}; moved {noticed}"));
                }
            }
        }
    }
    let light = crate::stages::camera(DepthDirection::Reversed);
    match drawn(&gpu, &shape, &light, DepthDirection::Standard) {
        Err(message) if message.contains("the light has Reversed depth, and Standard is needed") => Ok(()),
        other => Err(format!("a light of the other direction: {other:?}")),
    }
}
