//! A picture of an eye whose depth buffer is given: the stencil after the volumes of a depth map.

use std::ops::Range;
use std::sync::Arc;

use rimline::gpu::ShadowFormat;
use rimline::gpu::depth_map::{DepthMap, DepthMapFrame, DepthMapOptions, DepthMapPipelines, DepthMapVolumes};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use wgpu::TextureFormat;

use crate::textures::{depth_view, texture};

/// Input of a picture: a map of a light, and the depths that an eye sees.
pub(crate) struct Picture<'a> {
    pub(crate) map: &'a wgpu::Texture,
    pub(crate) objects: Option<&'a wgpu::Texture>,
    pub(crate) light: ShadowCamera,
    pub(crate) eye: ShadowCamera,
    /// Depths of the pixels of a square picture, row by row.
    pub(crate) depths: &'a [f32],
    pub(crate) side: u32,
    pub(crate) options: DepthMapOptions,
    /// The bits of the stencil that are drawn into.
    pub(crate) bits: Range<u32>,
}

/// Pipelines for eyes with this direction of depth, which draw into these bits. Tests share them.
pub(crate) fn pipelines(gpu: &Gpu, depth: DepthDirection, bits: Range<u32>) -> Result<Arc<DepthMapPipelines>, String> {
    gpu.kept(&format!("{depth:?} {bits:?}"), || {
        let format = ShadowFormat { depth, ..Default::default() };
        DepthMapPipelines::antialiased(&gpu.pipelines, &format, bits.clone()).map_err(text)
    })
}

impl Picture<'_> {
    /// The stencil of each pixel, from 0 on.
    pub(crate) fn stencil(&self, gpu: &Gpu) -> Result<Vec<u8>, String> {
        let pipelines = pipelines(gpu, self.eye.depth, self.bits.clone())?;
        let size = [self.map.width(), self.map.height()];
        let mut volumes = DepthMapVolumes::new(&pipelines, size, self.options).map_err(text)?;
        stencil_of(gpu, &pipelines, (self.side, self.depths), |encoder| {
            let objects = self.objects.map(|objects| objects.create_view(&wgpu::TextureViewDescriptor::default()));
            let map = DepthMap { texture: &depth_view(self.map), light: self.light, objects: objects.as_ref() };
            volumes.encode(encoder, &map, &self.eye).map_err(text)
        })
    }
}

/// The stencil of each pixel of a square picture with these depths, from 0 on, after a frame.
pub(crate) fn stencil_of(
    gpu: &Gpu,
    pipelines: &DepthMapPipelines,
    (side, depths): (u32, &[f32]),
    encode: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<DepthMapFrame, String>,
) -> Result<Vec<u8>, String> {
    stencil_after(gpu, (side, depths), |encoder| {
        let frame = encode(encoder)?;
        Ok(move |pass: &mut wgpu::RenderPass<'_>| frame.draw(pass, pipelines).map_err(text))
    })
}

/// The same, after any draws.
pub(crate) fn stencil_after<F: FnOnce(&mut wgpu::RenderPass<'_>) -> Result<(), String>>(
    gpu: &Gpu,
    (side, depths): (u32, &[f32]),
    encode: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<F, String>,
) -> Result<Vec<u8>, String> {
    let target = texture(gpu, [side; 2], TextureFormat::Depth24PlusStencil8, depths)?;
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let row = side.next_multiple_of(256);
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("stencil"),
        size: u64::from(row * side),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    gpu.submit(|encoder| {
        let draw = encode(encoder)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("volumes"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: None,
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
            }),
            ..Default::default()
        });
        draw(&mut pass)?;
        drop(pass);
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { aspect: wgpu::TextureAspect::StencilOnly, ..target.as_image_copy() },
            wgpu::TexelCopyBufferInfo {
                buffer: &copy,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
            },
            target.size(),
        );
        Ok(())
    })?;
    let bytes: Vec<u8> = gpu.read(&copy, (row * side) as usize)?;
    Ok(bytes.chunks(row as usize).flat_map(|row| row[..side as usize].to_vec()).collect())
}
