//! How far away what lies behind everything seen in a part of the picture is hidden. Lines ask it before they ask the survey.

use rimline::wgpu;
use wgpu::{BindGroup, BindGroupLayout, BindingResource, PrimitiveTopology, TextureFormat, TextureUsages};

use super::passes::color_pass;
use super::survey::SEEN;
use crate::render::pipeline_factory::{Pass, PipelineFactory};

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
        let pipeline = |name, group| {
            factory.pipeline(&Pass {
                name,
                vertex: name,
                source: include_str!("veil.wgsl"),
                groups: &[group],
                topology: PrimitiveTopology::TriangleList,
                format: FORMAT,
                blend: None,
                samples: 1,
                write: wgpu::ColorWrites::ALL,
                depth: None,
                constants: &[],
            })
        };
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
        let [width, height] = places.map(|places| places.div_ceil(SQUARE).next_power_of_two());
        let levels = width.max(height).ilog2() + 1;
        let texture = factory.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("veils"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let level = |level| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            })
        };
        let group = |view: &wgpu::TextureView| factory.group(&self.layout, &[BindingResource::TextureView(view)]);
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
        group(&texture.create_view(&wgpu::TextureViewDescriptor::default()))
    }
}
