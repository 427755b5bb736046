//! Receivers over the picture, as scenes cull by them: a shadow volume is not drawn if it lies behind the farthest receivers
//! of all tiles that it covers.

use rimline_picture::{PictureFormat, PipelineDescriptor, Resources};
use wgpu::BlendState;

use super::canvas::Canvas;

/// Bands of half an octave of distance, and nothing where no surface receives.
const SOURCE: &str = "
@group(1) @binding(0) var depths: TEXTURE;

@fragment fn receivers_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let first = vec2<i32>(at.xy) & vec2<i32>(-8);
  let end = min(first + vec2<i32>(8), vec2<i32>(textureDimensions(depths)));
  var farthest = 2.0;
  // Turns: 8.
  for (var y = first.y; y < end.y; y++) {
    // Turns: 8.
    for (var x = first.x; x < end.x; x++) {
      // Turns: SAMPLES.
      for (var number = 0; number < SAMPLES; number++) {
        let depth = textureLoad(depths, vec2<i32>(x, y), number).x;
        farthest = select(farthest, min(farthest, depth), depth > 0.0);
      }
    }
  }
  if (farthest > 1.0) {
    discard;
  }
  // Reversed depth is near / distance.
  let distance = frame.view_projection[3].z / farthest;
  return vec4<f32>(mix(vec3<f32>(0.1, 0.3, 0.75), vec3<f32>(0.95, 0.75, 0.25), fract(2.0 * log2(distance))), 0.45);
}
";

/// Textures of one sample and of several. Depth is read as floats, because naga writes no loads of depth textures for
/// OpenGL.
const TEXTURES: [&str; 2] = ["texture_2d<f32>", "texture_multisampled_2d<f32>"];

/// Draws the farthest receiver of each tile of 8 × 8 pixels.
pub(super) struct Tiles {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl Tiles {
    /// On pictures of a format.
    pub(super) fn new(resources: &Resources, format: PictureFormat) -> Self {
        let multisampled = format.samples > 1;
        let texture = TEXTURES[usize::from(multisampled)];
        let source = SOURCE.replace("TEXTURE", texture).replace("SAMPLES", &format.samples.to_string());
        let sample_type = wgpu::TextureSampleType::Float { filterable: false };
        let view_dimension = wgpu::TextureViewDimension::D2;
        let layout =
            resources.factory.layout(&[wgpu::BindingType::Texture { sample_type, view_dimension, multisampled }]);
        let groups = [&layout];
        let descriptor = PipelineDescriptor::over("receivers", &source, &groups, format.picture());
        let pipeline =
            resources.factory.pipeline(&PipelineDescriptor { blend: Some(BlendState::ALPHA_BLENDING), ..descriptor });
        Self { layout, pipeline }
    }

    pub(super) fn draw(&self, encoder: &mut wgpu::CommandEncoder, resources: &Resources, canvas: &Canvas) {
        let group = resources.factory.group(&self.layout, &[wgpu::BindingResource::TextureView(&canvas.depth)]);
        resources.factory.draw(&mut canvas.pass(encoder), &self.pipeline, &[&group], 3);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opengl_can_load_the_depth() {
        assert!([SOURCE].iter().chain(&TEXTURES).all(|text| !text.contains("texture_depth")));
    }
}
