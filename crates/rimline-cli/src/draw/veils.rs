//! How far away what lies behind everything seen in a part of the picture is hidden. Lines ask it before they ask the survey.

use rimline::wgpu;
use wgpu::{BindGroup, BindGroupLayout, BindingResource, TextureFormat, TextureUsages};

use super::survey::SEEN;
use crate::render::pipeline_factory::{Pass, PipelineFactory, color_pass, plain_texture, view};

/// Bits of floats, as OpenGL need not draw onto floats.
const FORMAT: TextureFormat = TextureFormat::R32Uint;

/// Places of the survey each way in a square of the finest level; as in `veil.wgsl`.
const SQUARE: u32 = 8;

/// The pipelines that draw veils.
pub(super) struct Veils {
    /// One texture that vertices and fragments see.
    pub(super) layout: BindGroupLayout,
    finest: wgpu::RenderPipeline,
    coarser: wgpu::RenderPipeline,
}

impl Veils {
    /// `survey` is the layout of the survey's group, as `lines.wgsl` reads it.
    pub(super) fn new(factory: &PipelineFactory<'_>, survey: &BindGroupLayout) -> Self {
        let layout = factory.layout(&[SEEN]);
        let pipeline = |name, group| factory.pipeline(&Pass::new(name, include_str!("veil.wgsl"), &[group], FORMAT));
        let (finest, coarser) = (pipeline("veil", survey), pipeline("veil_level", &layout));
        Self { layout, finest, coarser }
    }

    /// Records the veils of a survey with so many places each way. Returns the group that lines read the veils with.
    pub(super) fn record(
        &self,
        factory: &PipelineFactory<'_>,
        encoder: &mut wgpu::CommandEncoder,
        survey: &BindGroup,
        places: [u32; 2],
    ) -> BindGroup {
        // Each level has half of the squares of the finer one, and none is left over.
        let size = places.map(|places| places.div_ceil(SQUARE).next_power_of_two());
        let levels = size[0].max(size[1]).ilog2() + 1;
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
        let plain = plain_texture("veils", size, FORMAT, usage);
        let texture = factory.device.create_texture(&wgpu::TextureDescriptor { mip_level_count: levels, ..plain });
        let level = |level| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            })
        };
        let group = |of: &wgpu::TextureView| factory.group(&self.layout, &[BindingResource::TextureView(of)]);
        let mut draw = |pipeline: &wgpu::RenderPipeline, target: u32, source: &BindGroup| {
            let load = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
            let mut pass = color_pass(encoder, "veils", &level(target), None, load, None);
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &factory.frame_group, &[]);
            pass.set_bind_group(1, source, &[]);
            pass.draw(0..3, 0..1);
        };
        draw(&self.finest, 0, survey);
        for target in 1..levels {
            draw(&self.coarser, target, &group(&level(target - 1)));
        }
        group(&view(&texture))
    }
}
