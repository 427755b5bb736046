//! What each light reaches, pixel centre by pixel centre.

use rimline::gpu::ShadowPipelines;
use rimline::{Counting, wgpu};
use wgpu::{TextureFormat, TextureUsages};

use super::depth::depth_format;
use super::painter::{Onto, Painter, Target};
use super::studio::{Attachments, Studio, Subject, draw_volumes};
use crate::device::Gpu;
use crate::gpu_error::GpuError;

/// 255 lit, 0 not, 128 nothing there.
const MASK: Target = Target { format: TextureFormat::R8Unorm, samples: 1 };

/// Draws masks: of one light or sample at a time.
pub(crate) struct Masks {
    pub(crate) pipelines: ShadowPipelines,
    attachments: Attachments,
    finished: wgpu::Texture,
    dark: Painter,
    lit: Painter,
}

impl Masks {
    pub(crate) fn new(gpu: &Gpu, studio: &Studio<'_>, counting: Counting) -> Result<Self, GpuError> {
        let finished = studio.kit.target("mask", studio.size, MASK.format, MASK.samples, TextureUsages::COPY_SRC);
        let color = finished.create_view(&wgpu::TextureViewDescriptor::default());
        let depth = studio.target("depth", depth_format(&gpu.device), MASK.samples, TextureUsages::empty());
        Ok(Self {
            pipelines: Studio::pipelines(gpu, MASK, counting)?,
            attachments: Attachments { color, depth },
            dark: studio.painter(MASK, "dark", Onto::Nearest, None),
            lit: studio.painter(MASK, "mask", Onto::Lit, None),
            finished,
        })
    }

    /// Records a light's mask and returns its texture.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        studio: &Studio<'_>,
        subject: &Subject<'_>,
        light: usize,
    ) -> Result<&wgpu::Texture, GpuError> {
        let Subject { casters, has_ground, .. } = *subject;
        let grey = 128.0 / 255.0;
        let nothing = wgpu::Color { r: grey, g: grey, b: grey, a: 1.0 };
        let mut pass = self.attachments.pass(encoder, "mask", Some(nothing), None);
        studio.select(&mut pass, light);
        self.dark.paint(&mut pass, casters, light, has_ground);
        draw_volumes(&mut pass, &self.pipelines, casters, light)?;
        studio.select(&mut pass, light);
        self.lit.paint(&mut pass, casters, light, has_ground);
        Ok(&self.finished)
    }
}
