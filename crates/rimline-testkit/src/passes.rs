//! Textures of depth and stencil, and passes that draw into them.

use rimline::gpu::ShadowFormat;

use crate::device::Gpu;

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
