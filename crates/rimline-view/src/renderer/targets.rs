//! Textures that a picture is drawn into.

use super::error::RenderError;
use super::gpu::Gpu;
use super::pipelines::{LIGHT, PICTURE, Shared};

/// The targets of a picture of one size.
pub(super) struct Targets {
    pub(super) size: [u32; 2],
    pub(super) samples: u32,
    pub(super) color: wgpu::TextureView,
    /// The mean of the samples, if there are several.
    pub(super) resolved: Option<wgpu::TextureView>,
    pub(super) depth: wgpu::TextureView,
    /// The same without its stencil, for shaders.
    pub(super) depth_only: wgpu::TextureView,
    /// Binds the light, for what makes a picture of it.
    pub(super) light: wgpu::BindGroup,
    pub(super) picture: wgpu::Texture,
    pub(super) picture_view: wgpu::TextureView,
}

impl Targets {
    pub(super) fn new(gpu: &Gpu, shared: &Shared, size: [u32; 2], samples: u32) -> Result<Self, RenderError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let [width, height] = size;
        if width.max(height) > limit {
            return Err(RenderError::Size { width, height, limit });
        }
        let texture = |label, format, sample_count, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let whole = wgpu::TextureViewDescriptor::default();
        let read = wgpu::TextureUsages::TEXTURE_BINDING;
        let color = texture("light", LIGHT, samples, read).create_view(&whole);
        let resolved = (samples > 1).then(|| texture("resolved", LIGHT, 1, read).create_view(&whole));
        let depth = texture("depth", gpu.depth_format(), samples, read);
        let depth_only = wgpu::TextureViewDescriptor { aspect: wgpu::TextureAspect::DepthOnly, ..whole.clone() };
        let picture = texture("picture", PICTURE, 1, read | wgpu::TextureUsages::COPY_SRC);
        let light = wgpu::BindingResource::TextureView(resolved.as_ref().unwrap_or(&color));
        Ok(Self {
            size,
            samples,
            light: gpu.group(&shared.light, &[light]),
            color,
            resolved,
            depth_only: depth.create_view(&depth_only),
            depth: depth.create_view(&whole),
            picture_view: picture.create_view(&whole),
            picture,
        })
    }

    /// Bytes of all textures.
    pub(super) fn bytes(&self) -> u64 {
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        let resolved = if self.resolved.is_some() { 8 } else { 0 };
        pixels * (u64::from(self.samples) * (8 + 8) + resolved + 4)
    }

    /// A pass onto light and depth: clears both, or goes on with what is there. The stencil is cleared in any case.
    pub(super) fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        clear: bool,
        resolve: bool,
    ) -> wgpu::RenderPass<'e> {
        let store = wgpu::StoreOp::Store;
        let (color, depth) = if clear {
            (wgpu::LoadOp::Clear(wgpu::Color::BLACK), wgpu::LoadOp::Clear(0.0))
        } else {
            (wgpu::LoadOp::Load, wgpu::LoadOp::Load)
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: self.resolved.as_ref().filter(|_| resolve),
                ops: wgpu::Operations { load: color, store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: depth, store }),
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store }),
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }

    /// A pass onto the picture: clears it, or goes on with what is there.
    pub(super) fn finish<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        clear: bool,
    ) -> wgpu::RenderPass<'e> {
        let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.picture_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }
}
