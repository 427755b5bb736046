//! Resources that pictures and masks with shadows share, on a device of the command.

use rimline::gpu::ShadowFormat;
use rimline_picture::{Resources, depth_format};

use super::shadows::{ShadowMethod, VolumePipelines};
use crate::device::Gpu;
use crate::gpu_error::GpuError;

pub(crate) struct RenderResources<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) shared: Resources,
    pub(super) size: [u32; 2],
}

impl<'a> RenderResources<'a> {
    /// For pictures of this size, with so many samples of lights.
    pub(crate) fn new(gpu: &'a Gpu, size: [u32; 2], samples: usize) -> Self {
        Self { gpu, shared: Resources::new((&gpu.device, &gpu.queue), samples), size }
    }

    /// Pipelines of volumes for so many samples a pixel.
    pub(super) fn pipelines(&self, samples: u32, method: &ShadowMethod) -> Result<VolumePipelines, GpuError> {
        let format = ShadowFormat {
            depth_stencil: depth_format(&self.gpu.device),
            samples,
            colors: Vec::new(),
            trim: method.from_depth.is_none() && self.gpu.clips_wrongly(),
            ..ShadowFormat::default()
        };
        VolumePipelines::new(self.gpu, &format, method)
    }
}
