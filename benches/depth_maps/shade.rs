//! The end of a frame: black where the stencil is not 0, or where a lookup in the map finds shadow.

use glam::Mat4;
use rimline::ShadowCamera;
use rimline_bench::gpu::Gpu;
use rimline_bench::pipelines::{self, Drawing, group};
use rimline_bench::record::Target;

use crate::{Depths, EYE};

const SHADER: &str = "
@group(0) @binding(0) var eye_depth: texture_depth_2d;
@group(0) @binding(1) var map: texture_depth_2d;
// From the eye's device coordinates to the light's.
@group(0) @binding(2) var<uniform> to_light: mat4x4<f32>;
@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.5, 1.0);
}
@fragment fn black() -> @location(0) vec4<f32> {
  return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
@fragment fn lookup(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let depth = textureLoad(eye_depth, vec2<i32>(at.xy), 0);
  let ndc = 2.0 * at.xy / vec2<f32>(textureDimensions(eye_depth)) - 1.0;
  let seen = to_light * vec4<f32>(ndc.x, -ndc.y, depth, 1.0);
  let point = seen.xyz / seen.w;
  let texel = (0.5 + 0.5 * vec2<f32>(point.x, -point.y)) * vec2<f32>(textureDimensions(map));
  if (depth == 0.0 || point.z < textureLoad(map, vec2<i32>(texel), 0) + 0.001) {
    discard;
  }
  return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
";

const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

pub(crate) struct Shade {
    black: wgpu::RenderPipeline,
    lookup: wgpu::RenderPipeline,
    /// Resources that a lookup reads.
    group: wgpu::BindGroup,
    color: wgpu::TextureView,
}

impl Shade {
    pub(crate) fn new(gpu: &Gpu, side: u32, [eye_depth, map]: [&Depths; 2], [eye, light]: [&ShadowCamera; 2]) -> Self {
        let compare = wgpu::CompareFunction::NotEqual;
        let unequal = wgpu::StencilFaceState { compare, ..wgpu::StencilFaceState::IGNORE };
        let stencil = wgpu::DepthStencilState {
            stencil: wgpu::StencilState { front: unequal, back: unequal, read_mask: 0xff, write_mask: 0 },
            ..pipelines::depth(EYE, wgpu::CompareFunction::Always, false)
        };
        let make = |entry_point, depth_stencil| {
            let entry_points = [Some("everywhere"), Some(entry_point)];
            let targets = &[Some(COLOR.into())];
            Drawing { label: entry_point, source: SHADER, entry_points, depth_stencil, targets, ..Drawing::default() }
                .pipeline(&gpu.device)
        };
        let lookup = make("lookup", None);
        let [eye, light] = [eye, light].map(|camera| Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4());
        let matrix = (light * eye.inverse()).as_mat4().to_cols_array();
        let matrix = gpu.buffer(wgpu::BufferUsages::UNIFORM, &matrix);
        let [eye_depth, map] = [eye_depth, map].map(|depths| wgpu::BindingResource::TextureView(&depths.read));
        let group = group(&gpu.device, &lookup.get_bind_group_layout(0), [eye_depth, map, matrix.as_entire_binding()]);
        Self { black: make("black", Some(stencil)), lookup, group, color: gpu.texture([side; 2], COLOR) }
    }

    fn target(&self) -> Target<'_> {
        Target { color: Some((&self.color, wgpu::LoadOp::Clear(wgpu::Color::WHITE))), ..Target::default() }
    }

    /// Black where the stencil is not 0.
    pub(crate) fn stencil(&self, encoder: &mut wgpu::CommandEncoder, depths: &Depths) {
        let mut pass = Target { depth_stencil: Some(&depths.all), ..self.target() }.begin(encoder);
        pass.set_pipeline(&self.black);
        pass.draw(0..3, 0..1);
    }

    /// Black where the map has something nearer to the light.
    pub(crate) fn lookup(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = self.target().begin(encoder);
        pass.set_pipeline(&self.lookup);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}
