//! Textures of depth and stencil, and passes that draw into them.

use std::ops::Range;
use std::sync::Arc;

use rimline::gpu::ShadowFormat;
use rimline::gpu::depth_map::DepthMapPipelines;
use rimline::{DepthDirection, ShadowCamera};

use crate::device::Gpu;
use crate::on_gpu::text;
use crate::pipelines::{Drawing, SURFACE, depth, group};

/// Pipelines of volumes of depth maps for eyes of a format, which draw into these bits. Tests share them.
pub fn map_pipelines(gpu: &Gpu, format: &ShadowFormat, bits: Range<u32>) -> Result<Arc<DepthMapPipelines>, String> {
    gpu.kept(&format!("{format:?} {bits:?}"), || {
        DepthMapPipelines::antialiased(&gpu.pipelines, format, bits.clone()).map_err(text)
    })
}

/// A texture of one level, layer and sample, which passes draw into and shaders read.
pub fn texture([width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some("test"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    }
}

/// How a pass begins: with depths and stencils that are loaded or cleared, or read only.
pub type Loads = (Option<wgpu::LoadOp<f32>>, Option<wgpu::LoadOp<u32>>);

/// Depths and stencils that are cleared to 0.
pub const CLEARED: Loads = (Some(wgpu::LoadOp::Clear(0.0)), Some(wgpu::LoadOp::Clear(0)));

/// A pass that draws into depths and stencils alone.
pub fn depth_pass(view: &wgpu::TextureView, (depths, stencils): Loads) -> wgpu::RenderPassDescriptor<'_> {
    let store = wgpu::StoreOp::Store;
    wgpu::RenderPassDescriptor {
        label: Some("test"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: depths.map(|load| wgpu::Operations { load, store }),
            stencil_ops: stencils.map(|load| wgpu::Operations { load, store }),
        }),
        ..Default::default()
    }
}

/// Draws into small depths and stencils of the default format, which are cleared.
pub fn draw_small<T>(gpu: &Gpu, draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> T) -> Result<T, String> {
    let target = gpu.device.create_texture(&texture([8; 2], ShadowFormat::default().depth_stencil));
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    gpu.submit(|encoder| Ok(draw(&mut encoder.begin_render_pass(&depth_pass(&view, CLEARED)))))
}

/// Draws the depth of triangles, three corners each, as a camera sees them. Nothing is left of what was there.
pub fn draw_surfaces(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    camera: &ShadowCamera,
    corners: &[[f32; 3]],
) -> Result<(), String> {
    let (format, samples) = (view.texture().format(), view.texture().sample_count());
    let is_reversed = camera.depth == DepthDirection::Reversed;
    let (nearer, far) =
        if is_reversed { (wgpu::CompareFunction::Greater, 0.0) } else { (wgpu::CompareFunction::Less, 1.0) };
    let pipeline = gpu.kept(&format!("surfaces {format:?} {samples} {is_reversed}"), || {
        let depth_stencil = Some(depth(format, nearer, true));
        Ok(Drawing { source: SURFACE, depth_stencil, samples, ..Drawing::default() }.pipeline(&gpu.device))
    })?;
    let [x, y, z] = camera.origin;
    let words = [camera.view_projection.concat(), vec![x, y, z, 0.0]].concat();
    let buffers = [gpu.storage(&words), gpu.storage(corners)];
    let resources = buffers.each_ref().map(wgpu::Buffer::as_entire_binding);
    let group = group(&gpu.device, &pipeline.get_bind_group_layout(0), resources);
    let stencils = format.has_stencil_aspect().then_some(wgpu::LoadOp::Clear(0));
    let mut pass = encoder.begin_render_pass(&depth_pass(view, (Some(wgpu::LoadOp::Clear(far)), stencils)));
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..corners.len() as u32, 0..1);
    Ok(())
}
