//! What the picture shows at each sample: the face and its depth. Lines ask it which faces may hide them.

use rimline::wgpu;
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, ShaderStages, TextureFormat, TextureUsages};

use super::picture::{SAMPLES, color_pass, depth_test};
use crate::render::kit::{Kit, Pass};

const FORMAT: TextureFormat = TextureFormat::Rgba16Uint;

/// What shaders read the survey as.
pub(super) const SEEN: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: true,
};

/// The survey's target.
pub(super) struct Survey {
    pub(super) seen: wgpu::TextureView,
}

impl Survey {
    pub(super) fn new(kit: &Kit<'_>, size: [u32; 2]) -> Self {
        let texture = kit.target("survey", size, FORMAT, SAMPLES, TextureUsages::TEXTURE_BINDING);
        Self { seen: texture.create_view(&wgpu::TextureViewDescriptor::default()) }
    }

    /// Records the survey of so many corners; `depth` is its depth buffer.
    pub(super) fn record(
        &self,
        kit: &Kit<'_>,
        encoder: &mut wgpu::CommandEncoder,
        (layout, geometry): (&BindGroupLayout, &BindGroup),
        corners: u32,
        depth: &wgpu::TextureView,
    ) {
        let pipeline = kit.pipeline(&Pass {
            name: "survey",
            vertex: "survey",
            source: include_str!("survey.wgsl"),
            groups: &[layout],
            topology: wgpu::PrimitiveTopology::TriangleList,
            format: FORMAT,
            blend: None,
            samples: SAMPLES,
            write: wgpu::ColorWrites::ALL,
            depth: Some(depth_test(true)),
            constants: &[],
        });
        let nothing = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let mut pass = color_pass(encoder, "survey", &self.seen, None, nothing, Some(depth));
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &kit.frame_group, &[]);
        pass.set_bind_group(1, geometry, &[]);
        pass.draw(0..corners, 0..1);
    }

    /// The survey, positions and drawn faces for `lines.wgsl`. Vertex shaders do not see them: what lists are read by
    /// there leaves no room for more storage buffers.
    pub(super) fn group(
        &self,
        kit: &Kit<'_>,
        positions: &wgpu::Buffer,
        faces: &wgpu::Buffer,
    ) -> (BindGroupLayout, BindGroup) {
        let storage = BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let layout = kit.layout_for(ShaderStages::FRAGMENT, &[SEEN, storage, storage]);
        let resources =
            [BindingResource::TextureView(&self.seen), positions.as_entire_binding(), faces.as_entire_binding()];
        let group = kit.group(&layout, &resources);
        (layout, group)
    }
}
