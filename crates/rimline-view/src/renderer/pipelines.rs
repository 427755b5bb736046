//! Pipelines of the picture, for a number of samples a pixel.

use std::cell::OnceCell;

use rimline::Counting;
use rimline::gpu::{OutlineFormat, OutlinePipeline, ShadowFormat, ShadowPipelines};
use rimline_picture::{Mode, Onto, PicturePipelines, ReceiverPass, Resources, VolumeOverlay, depth_format};
use wgpu::BlendState;

use super::canvas::format;
use super::error::RenderError;
use super::gpu::Gpu;
use super::tiles::Tiles;

/// All pipelines for a number of samples.
pub(super) struct Pipelines {
    pub(super) passes: PicturePipelines,
    pub(super) caps: wgpu::RenderPipeline,
    pub(super) volumes: VolumeOverlay,
    pub(super) outlines: OutlinePipeline,
    shadows: Vec<(Counting, ShadowPipelines)>,
    /// Made when they are first drawn.
    tiles: OnceCell<Tiles>,
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu, resources: &Resources, samples: u32) -> Result<Self, RenderError> {
        let format = format(samples);
        let light = format.light();
        let caps = ReceiverPass::new(light, "caps", Onto::Again);
        let is_depth_multisampled = samples > 1;
        let outlines =
            OutlineFormat { color: format.picture(), depth_stencil: None, samples: 1, is_depth_multisampled };
        Ok(Self {
            passes: PicturePipelines::new(resources, format, Mode::default()),
            caps: ReceiverPass { blend: Some(BlendState::ALPHA_BLENDING), ..caps }.surface_pipeline(resources),
            volumes: VolumeOverlay::new(resources, light),
            outlines: OutlinePipeline::new(&gpu.pipelines, &outlines)?,
            shadows: Vec::new(),
            tiles: OnceCell::new(),
        })
    }

    pub(super) fn samples(&self) -> u32 {
        self.passes.format().samples
    }

    /// Makes what a counting method and a mode need, unless it is there.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        resources: &Resources,
        counting: Counting,
        mode: Mode,
    ) -> Result<(), RenderError> {
        self.passes.set_mode(resources, mode);
        if self.shadows(counting).is_none() {
            let format = ShadowFormat {
                depth_stencil: depth_format(&gpu.device),
                samples: self.samples(),
                colors: Vec::new(),
                ..ShadowFormat::default()
            };
            self.shadows.push((counting, ShadowPipelines::new(&gpu.pipelines, &format, counting)?));
        }
        Ok(())
    }

    /// The pipeline of receivers.
    pub(super) fn tiles(&self, resources: &Resources) -> &Tiles {
        self.tiles.get_or_init(|| Tiles::new(resources, self.passes.format()))
    }

    /// The pipelines of volumes that were prepared.
    pub(super) fn shadows(&self, counting: Counting) -> Option<&ShadowPipelines> {
        self.shadows.iter().find(|(of, _)| *of == counting).map(|(_, pipelines)| pipelines)
    }
}
