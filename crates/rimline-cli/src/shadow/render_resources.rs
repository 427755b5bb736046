//! Resources that pictures and masks with shadows share: targets, frame, lights.

use rimline::gpu::ShadowFormat;
use rimline::wgpu;
use wgpu::{TextureFormat, TextureUsages};

use super::depth::depth_format;
use super::frame::Frame;
use super::shaded_lights::ShadedLightData;
use super::shadows::{ShadowMethod, VolumePipelines};
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::pipeline_factory::{PipelineFactory, READ_ONLY, UNIFORM, UNIFORM_AT_OFFSET, color_pass, view};

pub(crate) struct RenderResources<'a> {
    pub(crate) factory: PipelineFactory<'a>,
    pub(super) size: [u32; 2],
    /// The layout of a light, and of a body.
    pub(super) shaded: wgpu::BindGroupLayout,
    pub(super) geometry: wgpu::BindGroupLayout,
    shaded_lights: wgpu::Buffer,
    lamp_group: wgpu::BindGroup,
}

/// The targets of a picture or a mask.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub(super) format: TextureFormat,
    pub(super) samples: u32,
}

/// From a light's data to the next's.
const STRIDE: u64 = 256;

impl<'a> RenderResources<'a> {
    pub(crate) fn new(gpu: &'a Gpu, frame: &Frame, size: [u32; 2], samples: usize) -> Self {
        let factory = PipelineFactory::new(gpu, include_str!("scene.wgsl"), bytemuck::bytes_of(frame));
        let shaded = factory.layout(&[UNIFORM_AT_OFFSET]);
        let geometry = factory.layout(&[UNIFORM, READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY]);
        let shaded_lights = factory.uniform("shaded_lights", &vec![0; STRIDE as usize * samples]);
        let one = wgpu::BufferBinding {
            buffer: &shaded_lights,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<ShadedLightData>() as u64),
        };
        let lamp_group = factory.group(&shaded, &[wgpu::BindingResource::Buffer(one)]);
        Self { factory, size, shaded, geometry, shaded_lights, lamp_group }
    }

    /// Frame and lights, for what is submitted from now on.
    pub(crate) fn set(&self, frame: &Frame, shaded_lights: &[ShadedLightData]) {
        self.factory.set_frame(bytemuck::bytes_of(frame));
        for (place, shaded) in (0..).map(|number| number * STRIDE).zip(shaded_lights) {
            self.factory.gpu.queue.write_buffer(&self.shaded_lights, place, bytemuck::bytes_of(shaded));
        }
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

    pub(super) fn depth(&self, target: Target) -> wgpu::TextureView {
        self.target("depth", depth_format(&self.factory.gpu.device), target.samples, TextureUsages::empty())
    }

    /// Binds a light for pipelines that are taken from now on, and the frame.
    pub(super) fn select(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) {
        pass.set_bind_group(0, &self.factory.frame_group, &[]);
        pass.set_bind_group(1, &self.lamp_group, &[light as u32 * STRIDE as u32]);
    }

    pub(super) fn pipelines(&self, target: Target, method: &ShadowMethod) -> Result<VolumePipelines, GpuError> {
        let gpu = self.factory.gpu;
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
    /// A pass that clears the stencil and goes on with what is there, or clears everything.
    pub(super) fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        clear: Option<wgpu::Color>,
        resolve_target: Option<&wgpu::TextureView>,
    ) -> wgpu::RenderPass<'e> {
        color_pass(encoder, label, (&self.color, resolve_target), clear, Some(&self.depth))
    }
}
