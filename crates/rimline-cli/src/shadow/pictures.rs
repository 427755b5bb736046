//! Pictures with shadows, and masks: whether a light reaches the surface at each pixel centre.

use rimline::wgpu;
use rimline_picture::{
    Attachments, Mode, Onto, PictureFormat, PicturePipelines, ReceiverPass, ReceiverPipelines, Subject as _, Target,
    Targets, depth_format, view,
};
use wgpu::{TextureFormat, TextureUsages};

use super::draw_inputs::DrawInputs;
use super::overlay::Overlay;
use super::render_resources::RenderResources;
use super::shadows::{ShadowMethod, VolumePipelines};
use crate::gpu_error::GpuError;

pub(crate) struct Pictures {
    pub(crate) pipelines: VolumePipelines,
    passes: PicturePipelines,
    targets: Targets,
    overlay: Option<Overlay>,
}

impl Pictures {
    pub(crate) fn new(
        resources: &RenderResources<'_>,
        method: &ShadowMethod,
        mode: Mode,
        volumes: bool,
        in_parts: bool,
    ) -> Result<Self, GpuError> {
        let RenderResources { shared, size, .. } = resources;
        let format = PictureFormat { samples: if in_parts { 1 } else { 4 }, in_parts, is_encoded: false };
        let light = format.light();
        Ok(Self {
            pipelines: resources.pipelines(light.samples, method)?,
            passes: PicturePipelines::new(shared, format, mode),
            targets: Targets::new(&shared.factory, format, *size, TextureUsages::empty()),
            overlay: volumes.then(|| Overlay::new(shared, light, method.from_depth.is_some())),
        })
    }

    /// Records the whole picture's light, or a part's.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        subject: &DrawInputs<'_>,
        part: usize,
    ) -> Result<(), GpuError> {
        let subject = DrawInputs { drawn: Some((&self.pipelines, self.overlay.as_ref())), ..*subject };
        self.passes.record(encoder, &subject.casters.resources.shared, &self.targets.attachments[part], &subject)
    }

    /// Records how the light becomes a picture, and returns its texture.
    pub(crate) fn develop(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &RenderResources<'_>,
    ) -> &wgpu::Texture {
        self.passes.develop(encoder, &resources.shared, &self.targets);
        &self.targets.picture
    }
}

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
    pub(crate) fn new(resources: &RenderResources<'_>, method: &ShadowMethod) -> Result<Self, GpuError> {
        let RenderResources { gpu, shared, size } = resources;
        let target = |label, format, usage| shared.factory.target(label, *size, format, MASK.samples, usage);
        let finished = target("mask", MASK.format, TextureUsages::COPY_SRC);
        let depth = target("depth", depth_format(&gpu.device), TextureUsages::empty());
        let receivers = |name, onto| ReceiverPipelines::new(shared, ReceiverPass::new(MASK, name, onto));
        Ok(Self {
            pipelines: resources.pipelines(MASK.samples, method)?,
            attachments: Attachments { color: view(&finished), resolved: None, depth: view(&depth) },
            dark: receivers("dark", Onto::Nearest),
            lit: receivers("mask", Onto::Lit),
            finished,
        })
    }

    /// Records a light's mask and returns its texture.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        subject: &DrawInputs<'_>,
        light: usize,
    ) -> Result<&wgpu::Texture, GpuError> {
        let subject = DrawInputs { drawn: Some((&self.pipelines, None)), ..*subject };
        let grey = 128.0 / 255.0;
        let nothing = wgpu::Color { r: grey, g: grey, b: grey, a: 1.0 };
        let mut pass = subject.begin(self.attachments.pass(encoder, "mask", Some(nothing)));
        let shared = &subject.casters.resources.shared;
        self.dark.paint(&mut pass, shared, &subject, light);
        drop(pass);
        subject.draw_volumes(&mut subject.begin(self.attachments.count_pass(encoder)), light)?;
        let mut pass = subject.begin(self.attachments.pass(encoder, "mask", None));
        self.lit.paint(&mut pass, shared, &subject, light);
        drop(pass);
        Ok(&self.finished)
    }
}
