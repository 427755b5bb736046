//! The contact shadow's map: the model seen from below, darker the nearer it is to the ground, blurred twice.

use rimline::wgpu;
use wgpu::{BindGroup, BindGroupLayout, BlendComponent, BlendFactor, BlendOperation, BlendState, TextureFormat};

use super::passes::color_pass;
use crate::render::pipeline_factory::{Pass, PipelineFactory};

const SIZE: u32 = 512;
const FORMAT: TextureFormat = TextureFormat::R8Unorm;

/// Records the map and returns the group that `shadow.wgsl` reads it with.
pub(super) fn record(
    factory: &PipelineFactory<'_>,
    encoder: &mut wgpu::CommandEncoder,
    geometry: (&BindGroupLayout, &BindGroup),
    corners: u32,
) -> (BindGroupLayout, BindGroup) {
    let [first, second] = ["contact map", "blurred contact map"].map(|label| {
        factory
            .target(label, [SIZE; 2], FORMAT, 1, wgpu::TextureUsages::TEXTURE_BINDING)
            .create_view(&wgpu::TextureViewDescriptor::default())
    });
    // Whatever is nearest to the ground counts, in any order.
    let nearest =
        BlendComponent { src_factor: BlendFactor::One, dst_factor: BlendFactor::One, operation: BlendOperation::Max };
    let below = factory.pipeline(&Pass {
        name: "below",
        vertex: "below",
        source: include_str!("ground.wgsl"),
        groups: &[geometry.0],
        topology: wgpu::PrimitiveTopology::TriangleList,
        format: FORMAT,
        blend: Some(BlendState { color: nearest, alpha: nearest }),
        samples: 1,
        write: wgpu::ColorWrites::ALL,
        depth: None,
        constants: &[],
    });
    {
        let mut pass = color_pass(encoder, "below", &first, None, wgpu::LoadOp::Clear(wgpu::Color::BLACK), None);
        pass.set_pipeline(&below);
        pass.set_bind_group(0, &factory.frame_group, &[]);
        pass.set_bind_group(1, geometry.1, &[]);
        pass.draw(0..corners, 0..1);
    }

    let layout = factory.layout(&[
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
    ]);
    let sampler = factory.device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let group = |view| {
        let resources = [wgpu::BindingResource::TextureView(view), wgpu::BindingResource::Sampler(&sampler)];
        factory.group(&layout, &resources)
    };
    let groups = [group(&first), group(&second)];
    for (step, across) in [(1.6, true), (1.6, false), (0.7, true), (0.7, false)] {
        let (source, target) = if across { (0, &second) } else { (1, &first) };
        let step = if across { [step, 0.0] } else { [0.0, step] };
        let pipeline = factory.pipeline(&Pass {
            name: "blur",
            vertex: "blur",
            source: include_str!("blur.wgsl"),
            groups: &[&layout],
            topology: wgpu::PrimitiveTopology::TriangleList,
            format: FORMAT,
            blend: None,
            samples: 1,
            write: wgpu::ColorWrites::ALL,
            depth: None,
            constants: &[("step_x", step[0]), ("step_y", step[1])],
        });
        let mut pass = color_pass(encoder, "blur", target, None, wgpu::LoadOp::Clear(wgpu::Color::BLACK), None);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &factory.frame_group, &[]);
        pass.set_bind_group(1, &groups[source], &[]);
        pass.draw(0..3, 0..1);
    }
    let [blurred, _] = groups;
    (layout, blurred)
}
