//! Survey of the picture: the face seen at each of several positions a pixel, and its depth. Lines ask it which faces
//! may hide them.

use rimline::wgpu;
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, ShaderStages, TextureFormat, TextureUsages};

use rimline_picture::{Pass, PipelineFactory, READ_ONLY, color_pass, depth_state, plain_texture, view};

const FORMAT: TextureFormat = TextureFormat::Rgba16Uint;

/// The nearest is drawn and written.
pub(super) fn nearest() -> wgpu::DepthStencilState {
    depth_state(TextureFormat::Depth32Float, true, wgpu::CompareFunction::Greater, wgpu::StencilFaceState::IGNORE)
}

/// Binding with which shaders read the survey.
pub(super) const SEEN: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// Pictures with more pixels than this, in which faces smaller than pixels are rare, have one texel of the survey a pixel.
const MOST_FINE: u64 = 1 << 23;

/// Texels of the survey along a pixel's side, for a picture of this size.
pub(super) fn scale([width, height]: [u32; 2], most: u32) -> u32 {
    let is_small = u64::from(width) * u64::from(height) <= MOST_FINE && width.max(height) <= most / 2;
    if is_small { 2 } else { 1 }
}

pub(super) struct Survey {
    pub(super) seen: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Survey {
    /// For a picture of this size. `scale`: texels along a pixel's side.
    pub(super) fn new(factory: &PipelineFactory, size: [u32; 2], scale: u32) -> Self {
        let target =
            |label, format, usage| view(&factory.target(label, size.map(|pixels| scale * pixels), format, 1, usage));
        Self {
            seen: target("survey", FORMAT, TextureUsages::TEXTURE_BINDING),
            depth: target("survey depth", TextureFormat::Depth32Float, TextureUsages::empty()),
        }
    }

    /// The pipeline that draws it. `geometry` is the layout of the model's group.
    pub(super) fn pipeline(factory: &PipelineFactory, geometry: &BindGroupLayout) -> wgpu::RenderPipeline {
        let source = include_str!("model.wgsl");
        factory.pipeline(&Pass { depth: Some(nearest()), ..Pass::new("survey", source, &[geometry], FORMAT) })
    }

    pub(super) fn record(
        &self,
        factory: &PipelineFactory,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        geometry: &BindGroup,
        corners: u32,
    ) {
        let nothing = Some(wgpu::Color::TRANSPARENT);
        let mut pass = color_pass(encoder, "survey", (&self.seen, None), nothing, Some(&self.depth));
        factory.draw(&mut pass, pipeline, &[geometry], corners);
    }

    /// The layout of the survey, positions and drawn faces for `lines.wgsl`. Vertex shaders do not see them: what lists
    /// are read by there leaves no room for more storage buffers.
    pub(super) fn layout(factory: &PipelineFactory) -> BindGroupLayout {
        rimline_picture::layout(&factory.device, ShaderStages::FRAGMENT, &[SEEN, READ_ONLY, READ_ONLY])
    }

    /// A group of this layout.
    pub(super) fn group(
        &self,
        factory: &PipelineFactory,
        layout: &BindGroupLayout,
        [positions, faces]: [&wgpu::Buffer; 2],
    ) -> BindGroup {
        let resources =
            [BindingResource::TextureView(&self.seen), positions.as_entire_binding(), faces.as_entire_binding()];
        factory.group(layout, &resources)
    }
}

/// Bits of floats, as OpenGL need not draw onto floats.
const VEIL: TextureFormat = TextureFormat::R32Uint;

/// Places of the survey each way in a square of the finest level; as in `veil.wgsl`.
const SQUARE: u32 = 8;

pub(super) struct Veils {
    /// One texture that vertices and fragments see.
    pub(super) layout: BindGroupLayout,
    finest: wgpu::RenderPipeline,
    coarser: wgpu::RenderPipeline,
}

impl Veils {
    /// `survey` is the layout of the survey's group, as `lines.wgsl` reads it.
    pub(super) fn new(factory: &PipelineFactory, survey: &BindGroupLayout) -> Self {
        let layout = factory.layout(&[SEEN]);
        let pipeline = |name, group| factory.pipeline(&Pass::over(name, include_str!("veil.wgsl"), &[group], VEIL));
        let (finest, coarser) = (pipeline("veil", survey), pipeline("veil_level", &layout));
        Self { layout, finest, coarser }
    }

    /// Records the veils of a survey of this size. Returns the group that lines read the veils with.
    pub(super) fn record(
        &self,
        factory: &PipelineFactory,
        encoder: &mut wgpu::CommandEncoder,
        survey: &BindGroup,
        texels: [u32; 2],
    ) -> BindGroup {
        // Each level has half of the squares of the finer one, and none is left over.
        let size = texels.map(|texels| texels.div_ceil(SQUARE).next_power_of_two());
        let levels = size[0].max(size[1]).ilog2() + 1;
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
        let plain = plain_texture("veils", size, VEIL, usage);
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
            let nothing = Some(wgpu::Color::TRANSPARENT);
            let mut pass = color_pass(encoder, "veils", (&level(target), None), nothing, None);
            factory.draw(&mut pass, pipeline, &[source], 3);
        };
        draw(&self.finest, 0, survey);
        for target in 1..levels {
            draw(&self.coarser, target, &group(&level(target - 1)));
        }
        group(&view(&texture))
    }
}
