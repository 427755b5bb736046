//! Resources that pictures and masks with shadows share: targets, frame, lights.

use rimline::gpu::ShadowFormat;
use rimline::wgpu;
use wgpu::{BlendState, ColorWrites, LoadOp, TextureFormat, TextureUsages};

use super::casters::Casters;
use super::depth::depth_format;
use super::frame::Frame;
use super::receiver_pipelines::{Layouts, Onto, ReceiverPipelines, Target};
use super::shaded_lights::ShadedLightData;
use super::shadows::{ShadowMethod, VolumePipelines};
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::pipeline_factory::{PipelineFactory, view};

pub(crate) struct RenderResources<'a> {
    pub(crate) factory: PipelineFactory<'a>,
    pub(super) layouts: Layouts,
    pub(super) size: [u32; 2],
    shaded_lights: wgpu::Buffer,
    lamp_group: wgpu::BindGroup,
}

pub(crate) struct DrawInputs<'a> {
    pub(crate) casters: &'a Casters,
    /// Samples of all lights together.
    pub(crate) samples: usize,
    pub(crate) has_ground: bool,
    /// Only one pixel is drawn, so that the device compiles the shaders.
    pub(crate) is_trial: bool,
}

impl DrawInputs<'_> {
    pub(super) fn begin<'e>(&self, mut pass: wgpu::RenderPass<'e>) -> wgpu::RenderPass<'e> {
        if self.is_trial {
            pass.set_scissor_rect(0, 0, 1, 1);
        }
        pass
    }
}

/// From a light's data to the next's.
const STRIDE: u64 = 256;

impl<'a> RenderResources<'a> {
    pub(crate) fn new(gpu: &'a Gpu, frame: &Frame, size: [u32; 2], samples: usize) -> Self {
        let factory =
            PipelineFactory::new(&gpu.device, &gpu.queue, include_str!("scene.wgsl"), bytemuck::bytes_of(frame));
        let layouts = Layouts::new(&factory);
        let shaded_lights = factory.uniform(&gpu.queue, "shaded_lights", &vec![0; STRIDE as usize * samples]);
        let one = wgpu::BufferBinding {
            buffer: &shaded_lights,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<ShadedLightData>() as u64),
        };
        let lamp_group = factory.group(&layouts.shaded, &[wgpu::BindingResource::Buffer(one)]);
        Self { factory, layouts, size, shaded_lights, lamp_group }
    }

    pub(crate) fn geometry_layout(&self) -> &wgpu::BindGroupLayout {
        &self.layouts.geometry
    }

    /// Frame and lights, for what is submitted from now on.
    pub(crate) fn set(&self, gpu: &Gpu, frame: &Frame, shaded_lights: &[ShadedLightData]) {
        self.factory.set_frame(&gpu.queue, bytemuck::bytes_of(frame));
        for (place, shaded) in (0..).map(|number| number * STRIDE).zip(shaded_lights) {
            gpu.queue.write_buffer(&self.shaded_lights, place, bytemuck::bytes_of(shaded));
        }
    }

    pub(super) fn receivers(
        &self,
        target: Target,
        fragment: &'static str,
        onto: Onto,
        color: (Option<BlendState>, ColorWrites),
    ) -> ReceiverPipelines {
        ReceiverPipelines::new(&self.factory, &self.layouts, target, (fragment, onto), color)
    }

    pub(super) fn target(
        &self,
        label: &str,
        format: TextureFormat,
        samples: u32,
        usage: TextureUsages,
    ) -> wgpu::TextureView {
        view(&self.factory.target(label, self.size, format, samples, usage))
    }

    pub(super) fn select(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) {
        pass.set_bind_group(0, &self.factory.frame_group, &[]);
        pass.set_bind_group(1, &self.lamp_group, &[light as u32 * STRIDE as u32]);
    }

    pub(super) fn pipelines(gpu: &Gpu, target: Target, method: &ShadowMethod) -> Result<VolumePipelines, GpuError> {
        let format = ShadowFormat {
            depth_stencil: depth_format(&gpu.device),
            samples: target.samples,
            colors: vec![Some(target.format)],
            trim: method.from_depth.is_none() && gpu.clips_wrongly(),
            ..ShadowFormat::default()
        };
        VolumePipelines::new(gpu, &format, method)
    }
}

pub(super) struct Attachments {
    pub(super) color: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
}

impl Attachments {
    pub(super) fn new(resources: &RenderResources<'_>, target: Target) -> Self {
        let none = TextureUsages::empty();
        Self {
            color: resources.target("color", target.format, target.samples, none | TextureUsages::COPY_SRC),
            depth: resources.target("depth", depth_format(resources.factory.device), target.samples, none),
        }
    }

    /// A pass that clears the stencil and goes on with what is there, or clears everything.
    pub(super) fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        clear: Option<wgpu::Color>,
        resolve_target: Option<&wgpu::TextureView>,
    ) -> wgpu::RenderPass<'e> {
        let store = wgpu::StoreOp::Store;
        let depth = if clear.is_some() { LoadOp::Clear(0.0) } else { LoadOp::Load };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: clear.map_or(LoadOp::Load, LoadOp::Clear), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: depth, store }),
                stencil_ops: Some(wgpu::Operations { load: LoadOp::Clear(0), store }),
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }
}
