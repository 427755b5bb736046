//! A body that throws shadows, on the GPU.

use rimline::ShadowCamera;
use rimline::gpu::{
    Extraction, Extractor, ExtractorOptions, ShadowDrawError, ShadowFrame, ShadowOptions, ShadowPipelines,
    ShadowVolumes, StageTimer,
};
use rimline::{Light, Mesh, wgpu};

use super::posed_model::PosedModel;
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::normals;
use crate::render::pipeline_factory::PipelineFactory;

/// Front and back of the first, second … body; then from the beginning again.
const CLAYS: [[[f32; 3]; 2]; 4] = [
    [[0.62, 0.60, 0.565], [0.50, 0.33, 0.24]],
    [[0.36, 0.49, 0.56], [0.58, 0.40, 0.29]],
    [[0.60, 0.42, 0.31], [0.33, 0.45, 0.51]],
    [[0.46, 0.54, 0.38], [0.58, 0.40, 0.29]],
];

/// What a body needs to be drawn and to throw shadows.
pub(crate) struct Caster {
    pub(crate) extractor: Extractor,
    pub(crate) volumes: ShadowVolumes,
    /// What the last encode left to draw.
    shadows: Option<ShadowFrame>,
    extraction: Option<Extraction>,
    clay: wgpu::Buffer,
    faces: wgpu::Buffer,
    pub(crate) corners: u32,
    /// With a word of facing masks each.
    pub(crate) groups: Vec<wgpu::BindGroup>,
}

pub(crate) fn extractor_options(max_lights: usize) -> ExtractorOptions {
    ExtractorOptions { max_lights, ..ExtractorOptions::default() }
}

pub(crate) fn shadow_options() -> ShadowOptions {
    ShadowOptions { bound_counts: true, ..ShadowOptions::default() }
}

impl Caster {
    pub(crate) fn new(
        gpu: &Gpu,
        factory: &PipelineFactory<'_>,
        pipelines: &ShadowPipelines,
        mesh: &Mesh,
        number: usize,
        max_lights: usize,
    ) -> Result<Self, GpuError> {
        let extractor = Extractor::new(&gpu.pipelines, mesh, extractor_options(max_lights))?;
        let volumes = ShadowVolumes::new(pipelines, &extractor, shadow_options())?;
        let clay = CLAYS[number % CLAYS.len()].map(|[r, g, b]| [r, g, b, 0.0]);
        Ok(Self {
            extractor,
            volumes,
            shadows: None,
            extraction: None,
            clay: factory.uniform(&gpu.queue, "clay", bytemuck::cast_slice(&clay)),
            faces: factory.buffer(&gpu.queue, "drawn faces", bytemuck::cast_slice(mesh.faces())),
            corners: 3 * mesh.faces().len() as u32,
            groups: Vec::new(),
        })
    }

    /// The bind groups for where the body is now.
    pub(crate) fn place(
        &mut self,
        gpu: &Gpu,
        factory: &PipelineFactory<'_>,
        layout: &wgpu::BindGroupLayout,
        body: &PosedModel<'_>,
    ) {
        let normals = normals::corner_normals(&body.world, body.scene.mesh.faces());
        let normals = factory.buffer(&gpu.queue, "normals", bytemuck::cast_slice(&normals));
        let positions = body.positions.buffer();
        let group = |facing: &wgpu::Buffer| {
            let buffers = [&self.clay, positions.buffer, &self.faces, &normals, facing];
            factory.group(layout, &buffers.map(wgpu::Buffer::as_entire_binding))
        };
        self.groups = self.extractor.results().facing.iter().map(group).collect();
    }

    /// Records extraction and choice.
    pub(crate) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        body: &PosedModel<'_>,
        camera: &ShadowCamera,
        lights: &[Light],
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        let extraction = self.extractor.encode(encoder, body.positions.buffer(), lights, timer.as_deref_mut())?;
        self.shadows = Some(self.volumes.encode(encoder, &extraction, camera, timer)?);
        self.extraction = Some(extraction);
        Ok(())
    }

    /// What the last encode extracted.
    pub(crate) fn extraction(&self) -> Option<&Extraction> {
        self.extraction.as_ref()
    }

    /// Draws the volume of a light, as it was encoded.
    pub(crate) fn draw_volume(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        light: usize,
    ) -> Result<(), ShadowDrawError> {
        self.shadows.as_ref().map_or(Ok(()), |shadows| shadows.draw(pass, pipelines, light))
    }
}
