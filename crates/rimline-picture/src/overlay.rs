//! Shadow volumes over a picture, translucent.

use rimline::gpu::{Extraction, ExtractorError, include_wgsl, results_bind_group_layout};
use wgpu::{BlendState, CompareFunction, PrimitiveTopology, StencilFaceState};

use crate::bindings::depth_format;
use crate::factory::{PipelineDescriptor, depth_state};
use crate::resources::Resources;
use crate::targets::Target;

/// The shaders of overlays, `volumes` and `edges`. They stand after the library's include for group 2.
pub const OVERLAY: &str = include_str!("overlay.wgsl");

/// A pipeline that draws an overlay in front of the models. `groups` begin with the light.
pub fn overlay_descriptor<'a>(
    resources: &Resources,
    target: Target,
    (name, source): (&'static str, &'a str),
    groups: &'a [&'a wgpu::BindGroupLayout],
) -> PipelineDescriptor<'a> {
    let format = depth_format(&resources.factory.device);
    PipelineDescriptor {
        blend: Some(BlendState::ALPHA_BLENDING),
        samples: target.samples,
        depth: Some(depth_state(format, false, CompareFunction::Greater, StencilFaceState::IGNORE)),
        ..PipelineDescriptor::new(name, source, groups, target.format)
    }
}

/// Draws the sides of shadow volumes and their lines.
#[derive(Debug)]
pub struct VolumeOverlay {
    layout: wgpu::BindGroupLayout,
    passes: [wgpu::RenderPipeline; 2],
}

impl VolumeOverlay {
    /// For a target.
    pub fn new(resources: &Resources, target: Target) -> Self {
        let layout = results_bind_group_layout(&resources.factory.device, wgpu::ShaderStages::VERTEX);
        let source = format!("{}\n{OVERLAY}", include_wgsl(2));
        let groups = [&resources.light, &layout];
        let pipeline = |name, topology| {
            let descriptor = overlay_descriptor(resources, target, (name, &source), &groups);
            resources.factory.pipeline(&PipelineDescriptor { topology, ..descriptor })
        };
        let passes =
            [pipeline("volumes", PrimitiveTopology::TriangleStrip), pipeline("edges", PrimitiveTopology::LineStrip)];
        Self { layout, passes }
    }

    /// Draws the volumes of a light, or of a sample of it. `silhouettes` is the index of its lists in the extraction:
    /// [`ShadedLight::shown`](crate::ShadedLight::shown), or `light` if that is `None`.
    ///
    /// # Errors
    /// [`ExtractorError`] if there are none.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        resources: &Resources,
        extraction: &Extraction,
        [light, silhouettes]: [usize; 2],
    ) -> Result<(), ExtractorError> {
        let group = extraction.bind_group(&self.layout, silhouettes / 32)?;
        resources.select(pass, light);
        pass.set_bind_group(2, &group, &[]);
        for pipeline in &self.passes {
            pass.set_pipeline(pipeline);
            extraction.draw(pass, silhouettes)?;
        }
        Ok(())
    }
}
