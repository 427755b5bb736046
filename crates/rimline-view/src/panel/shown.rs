//! The picture in the window, below what egui draws.

use rimline_picture::{COMMON, PipelineDescriptor, group, layout, read_texture};

use crate::renderer::{Gpu, Renderer};

/// The panel and the time line are at the right and below, so the picture is in the upper left corner of the window. Where it
/// ends, they begin.
const SOURCE: &str = "
@group(0) @binding(0) var picture: texture_2d<f32>;
@fragment fn shown_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return textureLoad(picture, vec2<i32>(at.xy), 0);
}
// Where a pixel of the picture is two pixels of the window wide and high.
@fragment fn shown_doubled_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return textureLoad(picture, vec2<i32>(0.5 * at.xy), 0);
}
";

/// Draws the picture pixel by pixel. As one of egui's images it would be sampled and blended, which takes software devices
/// long.
pub(super) struct Shown {
    layout: wgpu::BindGroupLayout,
    /// For each pixel of the picture, and for doubled ones.
    pipelines: [wgpu::RenderPipeline; 2],
    is_doubled: bool,
    /// The last picture, and its number.
    picture: Option<(u64, wgpu::BindGroup)>,
}

impl Shown {
    /// On targets of a format.
    pub(super) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let layout =
            layout(&gpu.device, wgpu::ShaderStages::FRAGMENT, &[read_texture(wgpu::TextureViewDimension::D2, false)]);
        let pipelines = ["shown", "shown_doubled"]
            .map(|name| PipelineDescriptor::over(name, SOURCE, &[&layout], format).pipeline(&gpu.device, COMMON, None));
        Self { layout, pipelines, is_doubled: false, picture: None }
    }

    /// Takes the last picture.
    pub(super) fn take(&mut self, renderer: &Renderer) {
        let (number, device) = (renderer.pictures(), &renderer.gpu().device);
        let Some(view) = renderer.texture().filter(|_| self.picture.as_ref().is_none_or(|(of, _)| *of != number))
        else {
            return;
        };
        let view = group(device, &self.layout, &[wgpu::BindingResource::TextureView(view)]);
        self.picture = Some((number, view));
        self.is_doubled = renderer.step() > 1;
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Some((_, picture)) = &self.picture else { return };
        pass.set_pipeline(&self.pipelines[usize::from(self.is_doubled)]);
        pass.set_bind_group(0, picture, &[]);
        pass.draw(0..3, 0..1);
    }
}
