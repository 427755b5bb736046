//! Pictures with shadows, and masks: whether a light, or a sample of it, reaches the surface at each pixel centre.

use rimline::gpu::include_wgsl;
use rimline::wgpu;
use rimline_picture::{
    Attachments, Mode, OVERLAY, Onto, PictureFormat, PicturePipelines, PipelineDescriptor, READ_ONLY, ReceiverPass,
    ReceiverPipelines, Resources, Subject, Surface, Target, Targets, UNIFORM, VolumeOverlay, depth_format, group,
    layout, overlay_descriptor, read_texture, view,
};
use wgpu::{DepthBiasState, PrimitiveTopology, TextureFormat, TextureUsages};

use super::casters::Casters;
use super::light_maps::ShownDepths;
use super::shadows::{RenderResources, ShadowMethod, VolumePipelines};
use crate::device::GpuError;

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
        shows_volumes: bool,
        in_parts: bool,
    ) -> Result<Self, GpuError> {
        let RenderResources { shared, size, .. } = resources;
        let format = PictureFormat { samples: if in_parts { 1 } else { 4 }, in_parts, is_encoded: false };
        let light = format.light();
        Ok(Self {
            pipelines: resources.pipelines(light.samples, method)?,
            passes: PicturePipelines::new(shared, format, mode),
            targets: Targets::new(&shared.factory, format, *size, TextureUsages::empty()),
            overlay: shows_volumes.then(|| match method.from_depth {
                None => Overlay::Volumes(VolumeOverlay::new(shared, light)),
                Some(_) => Overlay::Maps(MapOverlay::new(shared, light)),
            }),
        })
    }

    /// Records the light of a part of the picture. A picture that is not drawn in parts has part 0.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        subject: &DrawInputs<'_>,
        part: usize,
    ) -> Result<(), GpuError> {
        let (pipelines, overlay) = (Some(&self.pipelines), self.overlay.as_ref());
        let subject = DrawInputs { pipelines, overlay, ..*subject };
        self.passes.record(encoder, &subject.casters.resources.shared, &self.targets.attachments[part], &subject)
    }

    /// Records how the light of all parts becomes the picture, and returns its texture.
    pub(crate) fn develop(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &RenderResources<'_>,
    ) -> &wgpu::Texture {
        self.passes.develop(encoder, &resources.shared, &self.targets);
        &self.targets.picture
    }
}

/// The target of a mask: 255 where the light reaches the surface, 0 where it does not, 128 where there is no surface.
const MASK: Target = Target { format: TextureFormat::R8Unorm, samples: 1 };

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

    /// Records the mask of a light, or of a sample of it, and returns its texture. The next mask overwrites it.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        subject: &DrawInputs<'_>,
        light: usize,
    ) -> Result<&wgpu::Texture, GpuError> {
        let subject = DrawInputs { pipelines: Some(&self.pipelines), ..*subject };
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

/// The contents of a picture or a mask: the casters as they were encoded last, and the ground.
#[derive(Clone, Copy)]
pub(crate) struct DrawInputs<'a> {
    pub(crate) casters: &'a Casters<'a>,
    /// The pipelines of the shadow volumes. `None` until [`Pictures::record`] or [`Masks::record`] gives its own.
    pub(super) pipelines: Option<&'a VolumePipelines>,
    /// The overlay over the light. `None` until [`Pictures::record`] gives its own, if it has one.
    pub(super) overlay: Option<&'a Overlay>,
    /// The number of samples of all lights. A light without an area has one.
    pub(crate) samples: usize,
    pub(crate) has_ground: bool,
    /// Only one pixel is drawn: so the driver compiles the shaders before times are taken.
    pub(crate) is_trial: bool,
}

impl Subject for DrawInputs<'_> {
    type Error = GpuError;

    fn lights(&self) -> usize {
        self.samples
    }

    fn has_ground(&self) -> bool {
        self.has_ground
    }

    fn surfaces(&self) -> &[Surface] {
        &self.casters.surfaces
    }

    fn draw_volumes(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), GpuError> {
        self.pipelines.map_or(Ok(()), |pipelines| self.casters.shadows.draw(pass, pipelines, light))
    }

    fn has_overlays(&self) -> bool {
        self.overlay.is_some()
    }

    fn draw_overlays(&self, pass: &mut wgpu::RenderPass<'_>) -> Result<(), GpuError> {
        self.overlay.map_or(Ok(()), |overlay| overlay.draw(pass, self.casters, self.samples))
    }

    fn begin<'e>(&self, mut pass: wgpu::RenderPass<'e>) -> wgpu::RenderPass<'e> {
        if self.is_trial {
            pass.set_scissor_rect(0, 0, 1, 1);
        }
        pass
    }
}

/// A sketch of the volumes of all samples, over the picture.
pub(crate) enum Overlay {
    Volumes(VolumeOverlay),
    Maps(MapOverlay),
}

pub(crate) struct MapOverlay {
    layout: wgpu::BindGroupLayout,
    /// The pipelines of triangles and of lines.
    pipelines: [wgpu::RenderPipeline; 2],
}

impl Overlay {
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        casters: &Casters<'_>,
        samples: usize,
    ) -> Result<(), GpuError> {
        for light in 0..samples {
            match self {
                Self::Volumes(volumes) => {
                    for extraction in casters.shown(light) {
                        volumes.draw(pass, &casters.resources.shared, extraction, [light; 2])?;
                    }
                }
                Self::Maps(maps) => maps.draw(pass, casters, light),
            }
        }
        Ok(())
    }
}

impl MapOverlay {
    fn new(resources: &Resources, target: Target) -> Self {
        let types = [UNIFORM, READ_ONLY, read_texture(wgpu::TextureViewDimension::D2, false)];
        let layout = layout(&resources.factory.device, wgpu::ShaderStages::VERTEX, &types);
        let source = format!("{}\n{OVERLAY}\n{}", include_wgsl(2), include_str!("depth_overlay.wgsl"));
        let groups = [&resources.light, &layout];
        let pipeline = |name, vertex, topology, bias| {
            let descriptor = overlay_descriptor(resources, target, (name, &source), &groups);
            let depth = descriptor.depth.clone().map(|depth| wgpu::DepthStencilState { bias, ..depth });
            resources.factory.pipeline(&PipelineDescriptor { vertex, topology, depth, ..descriptor })
        };
        // The boundary of a map begins on the casters' surfaces. The bias moves it behind them, where they hide it. Depth is
        // reversed, so a negative bias moves away from the eye.
        let behind = DepthBiasState { constant: -64, slope_scale: -4.0, clamp: 0.0 };
        let triangles = pipeline("volumes", "depth_volumes", PrimitiveTopology::TriangleList, behind);
        let lines = pipeline("edges", "depth_edges", PrimitiveTopology::LineList, DepthBiasState::default());
        Self { layout, pipelines: [triangles, lines] }
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, casters: &Casters<'_>, light: usize) {
        let Some(ShownDepths { shown, cells, texture }) = casters.shadows.shown_maps(light) else { return };
        let bound =
            [shown.views.as_entire_binding(), cells.as_entire_binding(), wgpu::BindingResource::TextureView(texture)];
        let resources = &casters.resources.shared;
        resources.select(pass, light);
        pass.set_bind_group(2, &group(&resources.factory.device, &self.layout, &bound), &[]);
        // The listed cells or walls, then every cell.
        for (pipeline, offsets) in self.pipelines.iter().zip([[0, 32], [16, 48]]) {
            pass.set_pipeline(pipeline);
            for offset in offsets {
                pass.draw_indirect(&shown.draws, offset);
            }
        }
    }
}
