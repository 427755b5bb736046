//! The contact shadow's map: the model seen from below, darker the nearer it is to the ground, blurred twice.

use rimline::wgpu;
use wgpu::{BindGroup, BindGroupLayout, BlendComponent, BlendFactor, BlendOperation, BlendState, TextureFormat};

use super::frame::Region;
use crate::render::pipeline_factory::{Pass, PipelineFactory, UNIFORM, color_pass, read_texture, view};

/// Pixels along a side of the map.
pub(super) const SIZE: u32 = 512;
/// How far all blurs together spread, in pixels: twelve samples on each side, and the neighbours that each is mixed with.
pub(super) const SPREAD: f64 = 12.0 * (1.6 + 0.7) + 2.0;
const FORMAT: TextureFormat = TextureFormat::R8Unorm;

pub(super) struct ContactShadow {
    /// The layout with which `shadow.wgsl` reads the map, and each blur the map before.
    pub(super) layout: BindGroupLayout,
    below: wgpu::RenderPipeline,
    blur: wgpu::RenderPipeline,
}

impl ContactShadow {
    /// `geometry` is the layout of the model's group.
    pub(super) fn new(factory: &PipelineFactory<'_>, geometry: &BindGroupLayout) -> Self {
        let map = read_texture(wgpu::TextureViewDimension::D2, true);
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let layout = factory.layout(&[map, sampler, UNIFORM]);
        // Whatever is nearest to the ground counts, in any order.
        let nearest = BlendComponent {
            src_factor: BlendFactor::One,
            dst_factor: BlendFactor::One,
            operation: BlendOperation::Max,
        };
        let pipeline =
            |name, source, group, blend| factory.pipeline(&Pass { blend, ..Pass::new(name, source, &[group], FORMAT) });
        let nearest = Some(BlendState { color: nearest, alpha: nearest });
        Self {
            below: pipeline("below", include_str!("ground.wgsl"), geometry, nearest),
            blur: pipeline("blur", include_str!("blur.wgsl"), &layout, None),
            layout,
        }
    }

    /// Records the map of so many corners, which is black but for a region, and returns the group that `shadow.wgsl` reads it with.
    pub(super) fn record(
        &self,
        factory: &PipelineFactory<'_>,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        (geometry, region): (&BindGroup, Region),
        corners: u32,
    ) -> BindGroup {
        let [first, second] = ["contact map", "blurred contact map"]
            .map(|label| view(&factory.target(label, [SIZE; 2], FORMAT, 1, wgpu::TextureUsages::TEXTURE_BINDING)));
        {
            let mut pass = color_pass(encoder, "below", &first, None, wgpu::LoadOp::Clear(wgpu::Color::BLACK), None);
            pass.set_pipeline(&self.below);
            pass.set_bind_group(0, &factory.frame_group, &[]);
            pass.set_bind_group(1, geometry, &[]);
            pass.draw(0..corners, 0..1);
        }
        let sampler = factory.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let group = |view, pitch: [f32; 2]| {
            let pitch = factory.uniform(queue, "pitch", bytemuck::bytes_of(&pitch));
            let resources = [
                wgpu::BindingResource::TextureView(view),
                wgpu::BindingResource::Sampler(&sampler),
                pitch.as_entire_binding(),
            ];
            factory.group(&self.layout, &resources)
        };
        for (pitch, across) in [(1.6, true), (1.6, false), (0.7, true), (0.7, false)] {
            let (source, target) = if across { (&first, &second) } else { (&second, &first) };
            let pitch = if across { [pitch, 0.0] } else { [0.0, pitch] };
            let mut pass = color_pass(encoder, "blur", target, None, wgpu::LoadOp::Clear(wgpu::Color::BLACK), None);
            if region.keep(&mut pass) {
                pass.set_pipeline(&self.blur);
                pass.set_bind_group(0, &factory.frame_group, &[]);
                pass.set_bind_group(1, &group(source, pitch), &[]);
                pass.draw(0..3, 0..1);
            }
        }
        group(&first, [0.0; 2])
    }
}
