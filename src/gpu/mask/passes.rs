//! Attachments of masks, and passes that draw into them.

use super::pipelines::{layout, tried};
use crate::gpu::common::bindings::texture;
use crate::gpu::common::pipelines::{Pipelines, group};
use crate::gpu::shadow::errors::ShadowError;
use crate::shadow::DepthDirection;

/// An attachment that Rimline owns.
#[derive(Clone, Debug)]
pub(super) struct Attachment {
    size: [u32; 2],
    format: wgpu::TextureFormat,
    samples: u32,
    pub(super) view: wgpu::TextureView,
    /// The bind group of a colour attachment.
    pub(super) group: Option<wgpu::BindGroup>,
}

impl Attachment {
    /// The cached attachment, or a new one if it has other properties.
    pub(super) fn of(
        cached: &mut Option<Self>,
        shared: &Pipelines,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        samples: u32,
    ) -> Result<Self, ShadowError> {
        let is_same = |made: &Self| (made.size, made.format, made.samples) == (size, format, samples);
        let attachment = match cached.take().filter(is_same) {
            Some(attachment) => attachment,
            None => tried(shared.device(), ["textures of masks", ""], || Self::new(shared, size, format, samples))?,
        };
        Ok(cached.insert(attachment).clone())
    }

    fn new(shared: &Pipelines, size: [u32; 2], format: wgpu::TextureFormat, samples: u32) -> Self {
        let (device, [width, height]) = (shared.device(), size);
        let is_read = format.has_color_aspect();
        let read = if is_read { wgpu::TextureUsages::TEXTURE_BINDING } else { wgpu::TextureUsages::empty() };
        let made = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("mask"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | read,
            view_formats: &[],
        });
        let view = made.create_view(&wgpu::TextureViewDescriptor::default());
        let group = is_read.then(|| group(device, "mask bits", &layout(shared, samples > 1), &[texture(&view)]));
        Self { size, format, samples, view, group }
    }
}

/// A layer of a target.
pub(super) fn layer_view(target: &wgpu::Texture, base_array_layer: u32) -> wgpu::TextureView {
    target.create_view(&wgpu::TextureViewDescriptor {
        label: Some("mask"),
        dimension: Some(wgpu::TextureViewDimension::D2),
        mip_level_count: Some(1),
        base_array_layer,
        array_layer_count: Some(1),
        ..wgpu::TextureViewDescriptor::default()
    })
}

fn zero(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}

/// Begins a pass that clears and writes a layer of the target.
pub(super) fn draw_into<'e>(encoder: &'e mut wgpu::CommandEncoder, view: &wgpu::TextureView) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("masks"),
        color_attachments: &[Some(zero(view))],
        ..wgpu::RenderPassDescriptor::default()
    })
}

/// Begins the pass of a batch of lights, with bits and stencil at 0. The first batch clears the depth, and the last one
/// discards it.
pub(super) fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    bits: Option<&wgpu::TextureView>,
    depth_stencil: &wgpu::TextureView,
    depth: DepthDirection,
    [is_first, is_last]: [bool; 2],
) -> wgpu::RenderPass<'e> {
    let far = if depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    let load = if is_first { wgpu::LoadOp::Clear(far) } else { wgpu::LoadOp::Load };
    let store = if is_last { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
    let stencil = wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Discard };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("mask bits"),
        color_attachments: &[bits.map(zero)],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth_stencil,
            depth_ops: Some(wgpu::Operations { load, store }),
            stencil_ops: Some(stencil),
        }),
        ..wgpu::RenderPassDescriptor::default()
    })
}

/// Draws only these pixels: x, y, width and height.
pub(super) fn scissor(pass: &mut wgpu::RenderPass<'_>, [x, y, width, height]: [u32; 4]) {
    pass.set_scissor_rect(x, y, width, height);
}

/// The rectangle around two.
pub(super) fn around([x, y, width, height]: [u32; 4], other: [u32; 4]) -> [u32; 4] {
    let [left, top] = [x.min(other[0]), y.min(other[1])];
    [left, top, (x + width).max(other[0] + other[2]) - left, (y + height).max(other[1] + other[3]) - top]
}
