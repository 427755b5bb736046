//! The contact shadow's map: the model seen from below, darker the nearer it is to the ground, blurred twice.

use rimline::wgpu;
use wgpu::{BindGroup, BindGroupLayout, BindingResource, TextureFormat};

use super::frame::Region;
use rimline_picture::{LARGEST, Pass, PipelineFactory, UNIFORM, color_pass, read_texture, view};

/// Pixels along a side of the map.
pub(super) const SIZE: u32 = 512;
/// How far all blurs together spread, in pixels: twelve samples on each side, and the neighbours that each is mixed with.
pub(super) const SPREAD: f64 = 12.0 * (1.6 + 0.7) + 2.0;
const FORMAT: TextureFormat = TextureFormat::R8Unorm;

pub(super) struct ContactShadow {
    /// The layout with which the ground reads the map, and each blur the map before.
    pub(super) layout: BindGroupLayout,
    below: wgpu::RenderPipeline,
    blur: wgpu::RenderPipeline,
}

impl ContactShadow {
    /// `geometry` is the layout of the model's group.
    pub(super) fn new(factory: &PipelineFactory, geometry: &BindGroupLayout) -> Self {
        let map = read_texture(wgpu::TextureViewDimension::D2, true);
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let layout = factory.layout(&[map, sampler, UNIFORM]);
        let (model, screen) = (include_str!("model.wgsl"), include_str!("screen.wgsl"));
        Self {
            // Whatever is nearest to the ground counts, in any order.
            below: factory.pipeline(&Pass { blend: Some(LARGEST), ..Pass::new("below", model, &[geometry], FORMAT) }),
            blur: factory.pipeline(&Pass::over("blur", screen, &[&layout], FORMAT)),
            layout,
        }
    }

    /// Records the map of so many corners, which is black but for a region, and returns the group that the ground reads
    /// it with.
    pub(super) fn record(
        &self,
        factory: &PipelineFactory,
        encoder: &mut wgpu::CommandEncoder,
        (geometry, region): (&BindGroup, Region),
        corners: u32,
    ) -> BindGroup {
        let [first, second] = ["contact map", "blurred contact map"]
            .map(|label| view(&factory.target(label, [SIZE; 2], FORMAT, 1, wgpu::TextureUsages::TEXTURE_BINDING)));
        let black = Some(wgpu::Color::BLACK);
        let mut pass = color_pass(encoder, "below", (&first, None), black, None);
        factory.draw(&mut pass, &self.below, &[geometry], corners);
        drop(pass);
        let sampler = factory.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let group = |view, pitch: [f32; 2]| {
            let pitch = factory.uniform("pitch", bytemuck::bytes_of(&pitch));
            let map = BindingResource::TextureView(view);
            factory.group(&self.layout, &[map, BindingResource::Sampler(&sampler), pitch.as_entire_binding()])
        };
        for (pitch, across) in [(1.6, true), (1.6, false), (0.7, true), (0.7, false)] {
            let (source, target) = if across { (&first, &second) } else { (&second, &first) };
            let pitch = if across { [pitch, 0.0] } else { [0.0, pitch] };
            let mut pass = color_pass(encoder, "blur", (target, None), black, None);
            if region.keep(&mut pass) {
                factory.draw(&mut pass, &self.blur, &[&group(source, pitch)], 3);
            }
        }
        group(&first, [0.0; 2])
    }
}
