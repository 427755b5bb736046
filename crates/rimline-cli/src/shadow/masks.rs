//! Masks: whether a light reaches the surface at each pixel centre.

use rimline::wgpu;
use wgpu::{TextureFormat, TextureUsages};

use super::depth::depth_format;
use super::receiver_pipelines::{Onto, ReceiverPipelines, Target};
use super::render_resources::{Attachments, DrawInputs, RenderResources};
use super::shadows::{ShadowMethod, VolumePipelines};
use crate::device::Gpu;
use crate::gpu_error::GpuError;

/// 255 lit, 0 not, 128 nothing there.
const MASK: Target = Target { format: TextureFormat::R8Unorm, samples: 1 };

/// Draws masks: of one light or sample at a time.
pub(crate) struct Masks {
    pub(crate) pipelines: VolumePipelines,
    attachments: Attachments,
    finished: wgpu::Texture,
    dark: ReceiverPipelines,
    lit: ReceiverPipelines,
}

impl Masks {
    pub(crate) fn new(gpu: &Gpu, resources: &RenderResources<'_>, method: &ShadowMethod) -> Result<Self, GpuError> {
        let finished =
            resources.factory.target("mask", resources.size, MASK.format, MASK.samples, TextureUsages::COPY_SRC);
        let color = finished.create_view(&wgpu::TextureViewDescriptor::default());
        let depth = resources.target("depth", depth_format(&gpu.device), MASK.samples, TextureUsages::empty());
        Ok(Self {
            pipelines: RenderResources::pipelines(gpu, MASK, method)?,
            attachments: Attachments { color, depth },
            dark: resources.receivers(MASK, "dark", Onto::Nearest, None),
            lit: resources.receivers(MASK, "mask", Onto::Lit, None),
            finished,
        })
    }

    /// Records a light's mask and returns its texture.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &RenderResources<'_>,
        subject: &DrawInputs<'_>,
        light: usize,
    ) -> Result<&wgpu::Texture, GpuError> {
        let DrawInputs { casters, has_ground, .. } = *subject;
        let grey = 128.0 / 255.0;
        let nothing = wgpu::Color { r: grey, g: grey, b: grey, a: 1.0 };
        let mut pass = subject.begin(self.attachments.pass(encoder, "mask", Some(nothing), None));
        resources.select(&mut pass, light);
        self.dark.paint(&mut pass, casters, light, has_ground);
        casters.shadows.draw(&mut pass, &self.pipelines, light)?;
        resources.select(&mut pass, light);
        self.lit.paint(&mut pass, casters, light, has_ground);
        Ok(&self.finished)
    }
}
