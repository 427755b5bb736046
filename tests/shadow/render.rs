//! A frame on the GPU: the depth of everything, then each light's count in the stencil buffer, read back.

use rimline::gpu::depth_map::{DepthMap, DepthMapOptions, DepthMapPipelines, DepthMapVolumes};
use rimline::gpu::{
    Measuring, PositionBuffer, Receivers, SceneOptions, SceneStatistics, ShadowFormat, ShadowPipelines,
};
use rimline::internals::layout::{ShadowLight, ShadowStatistics};
use rimline::mesh::Weld;
use rimline::{Counting, DepthDirection, Light, Mesh};
use rimline_testkit::{OneCaster, OneFrame, made_anew};

use crate::in_scene::InScene;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::uniform;
use rimline_testkit::frames::{Body, Frame, Placed};
use rimline_testkit::on_gpu::{chosen, shadow_statistics, text};
use rimline_testkit::passes::{self, CLEARED, depth_pass};
use rimline_testkit::pipelines::{self, Drawing};
use rimline_testkit::textures::{Stencils, depth_view};

/// How casters are given to the library.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Placing {
    /// Each is alone in a scene.
    Alone,
    /// All are in one scene, at positions in world space. Mirrored casters have a matrix.
    Scene,
    /// The same in a scene with a past: of casters and lights that came and went, of encoders that were dropped, and with
    /// further views. At random from this seed.
    Busy(u64),
    /// All are rigid casters of one scene, with matrices at random from this seed, and the whole world is moved far away.
    Moved(u64),
}

/// Results that the GPU counted.
pub(crate) struct Counted {
    /// The stencil value of each pixel, row by row, a light each; of four samples four of them a light.
    pub(crate) stencils: Vec<Vec<u8>>,
    /// Choices for each caster and light.
    pub(crate) chosen: Vec<Vec<ShadowLight>>,
    pub(crate) statistics: Vec<ShadowStatistics>,
    /// Statistics of a scene.
    pub(crate) scene: Option<SceneStatistics>,
}

const DEPTH: &str = "
struct Camera { columns: array<vec4<f32>, 4>, origin: vec3<f32>, reordered: u32 }
@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> corners: array<f32>;
struct Out { @invariant @builtin(position) clip: vec4<f32> }
@vertex fn scene(@builtin(vertex_index) at: u32) -> Out {
  let q = vec3<f32>(corners[3u * at], corners[3u * at + 1u], corners[3u * at + 2u]) - camera.origin;
  var clip = camera.columns[0] * q.x + camera.columns[1] * q.y + camera.columns[2] * q.z + camera.columns[3];
  if (camera.reordered != 0u) {
    clip = camera.columns[3] + (camera.columns[2] * q.z + (camera.columns[1] * q.y + camera.columns[0] * q.x));
  }
  return Out(clip);
}
@fragment fn nothing() {}
";

#[derive(Clone, Copy)]
pub(crate) struct Renderer<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) format: wgpu::TextureFormat,
    /// Whether the depth pass computes positions in another order than volumes, whose bits it else has.
    pub(crate) is_reordered: bool,
    /// 1 or 4.
    pub(crate) samples: u32,
    pub(crate) options: SceneOptions,
    /// Range of every light.
    pub(crate) range: f32,
    pub(crate) placing: Placing,
    /// Number of batches of a scene's casters.
    pub(crate) count_batches: u32,
    /// Whether a scene gets the depth that its shadows fall on, and whether they fall on the sky.
    pub(crate) receivers: Option<bool>,
    /// Levels of skipping of a scene that are on, if not those by default.
    pub(crate) levels: Option<Levels>,
    /// The last bodies, which are drawn after the scene is encoded.
    pub(crate) late_bodies: usize,
    /// Whether volumes are cut at the frustum in the vertex shader.
    pub(crate) trim: bool,
    /// The map of a light, drawn into the same stencil in each pass: by these pipelines, of so many bits, before the
    /// meshes or after them.
    pub(crate) beside: Option<Beside<'a>>,
}

/// Levels of skipping, and whether clusters are one of them.
pub(crate) type Levels = (&'static [Measuring], bool);

/// A depth map that casts beside meshes.
#[derive(Clone, Copy)]
pub(crate) struct Beside<'a> {
    pub(crate) map: DepthMap<'a>,
    pub(crate) pipelines: &'a DepthMapPipelines,
    pub(crate) options: DepthMapOptions,
    pub(crate) is_first: bool,
}

impl<'a> Renderer<'a> {
    pub(crate) fn new(gpu: &'a Gpu) -> Self {
        Self {
            gpu,
            format: wgpu::TextureFormat::Depth24PlusStencil8,
            is_reordered: false,
            samples: 1,
            options: made_anew(32, Counting::Auto),
            range: f32::INFINITY,
            placing: Placing::Alone,
            count_batches: 1,
            receivers: None,
            levels: None,
            late_bodies: 0,
            trim: false,
            beside: None,
        }
    }

    fn shadow_format(&self, frame: &Frame, front_face: wgpu::FrontFace) -> ShadowFormat {
        ShadowFormat {
            front_face,
            depth_stencil: self.format,
            depth: frame.eye.depth,
            samples: self.samples,
            has_far_plane: frame.eye.far.is_some(),
            count_bits: self.options.stencil.count_bits,
            trim: self.trim,
            ..ShadowFormat::default()
        }
    }

    pub(crate) fn count(&self, frame: &Frame, counting: Counting) -> Result<Counted, String> {
        let gpu = self.gpu;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let copied = if self.samples == 1 { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() };
        let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
            sample_count: self.samples,
            usage: usage | copied,
            ..passes::texture([frame.size; 2], self.format)
        });
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let depth = self.early_depth(&mut encoder, frame, &target)?;
        let receivers = self.receivers.map(|sky_receives| Receivers { depth: &depth, sky_receives, version: None });
        let format = self.shadow_format(frame, wgpu::FrontFace::Ccw);
        let together = match self.placing {
            Placing::Alone => None,
            _ => Some(InScene::new(self, &mut encoder, frame, counting, &format, receivers)?),
        };
        let casters = if together.is_none() { self.alone(&mut encoder, frame, counting)? } else { Vec::new() };
        let mut mapped = None;
        if let Some(Beside { map, pipelines, options, is_first }) = &self.beside {
            let size = [map.texture.texture().width(), map.texture.texture().height()];
            let mut volumes = DepthMapVolumes::new(pipelines, size, *options).map_err(text)?;
            let camera = frame.eye.camera();
            let shadows = volumes.encode(&mut encoder, map, &camera).map_err(text)?;
            mapped = Some((shadows, *pipelines, *is_first));
        }
        let draw_mapped = |pass: &mut wgpu::RenderPass<'_>, is_first: bool| match &mapped {
            Some((shadows, pipelines, first)) if *first == is_first => shadows.draw(pass, pipelines).map_err(text),
            _ => Ok(()),
        };
        if self.late_bodies > 0 {
            self.depth(&mut encoder, frame, &view)?;
        }
        let mut copies = Vec::new();
        for light in 0..frame.lights.len() {
            let mut pass = encoder.begin_render_pass(&depth_pass(&view, (Some(wgpu::LoadOp::Load), CLEARED.1)));
            draw_mapped(&mut pass, true)?;
            for (shadows, pipelines) in &casters {
                shadows.draw(&mut pass, pipelines, light).map_err(text)?;
            }
            if let Some(together) = &together {
                together.draw(&mut pass, light)?;
            }
            draw_mapped(&mut pass, false)?;
            drop(pass);
            copies.push(Stencils::of(gpu, &mut encoder, &target)?);
        }
        gpu.queue.submit([encoder.finish()]);
        // A picture for each sample.
        let samples = self.samples as usize;
        let mut stencils = Vec::new();
        for copy in copies {
            let values = copy.read(gpu)?;
            stencils.extend((0..samples).map(|sample| values.iter().skip(sample).step_by(samples).copied().collect()));
        }
        let mut counted = Counted { stencils, chosen: Vec::new(), statistics: Vec::new(), scene: None };
        for (shadows, _) in &casters {
            counted.chosen.push(chosen(gpu, shadows, frame.lights.len())?);
            counted.statistics.push(shadow_statistics(gpu, shadows)?);
        }
        if let Some(together) = &together {
            together.read(gpu, &mut counted)?;
        }
        Ok(counted)
    }

    /// The casters of a frame, each in a scene of its own, and the pipelines that draw each.
    fn alone(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        counting: Counting,
    ) -> Result<Vec<(OneFrame, ShadowPipelines)>, String> {
        let mut casters = Vec::new();
        for body in frame.bodies.iter().filter(|body| body.casts) {
            let Placed { shape, camera, lights } = frame.placed(body);
            let mesh = match &body.polygons {
                Some(polygons) => polygons.mesh(Weld::Position),
                None => Mesh::from_faces(shape.positions.len(), shape.faces.clone()),
            };
            let buffer = self.gpu.storage(&shape.positions);
            let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
            let lights: Vec<Light> = lights.iter().map(|light| light.with_range(self.range)).collect();
            let options = SceneOptions { counting, max_lights: lights.len(), ..self.options };
            let caster = OneCaster::new(&self.gpu.pipelines, &self.gpu.queue, &mesh.map_err(text)?, options);
            let encoded = caster.and_then(|mut one| {
                one.in_depth = body.in_depth;
                one.encode(encoder, positions, &lights, Some(&camera), None)
            });
            let front_face = if body.mirror.is_some() { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw };
            let format = self.shadow_format(frame, front_face);
            let pipelines = ShadowPipelines::new(&self.gpu.pipelines, &format, counting).map_err(text)?;
            casters.push((encoded.map_err(text)?, pipelines));
        }
        Ok(casters)
    }

    /// Depth of all bodies but those that are drawn late, and a view of it.
    fn early_depth(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        target: &wgpu::Texture,
    ) -> Result<wgpu::TextureView, String> {
        let mut early = frame.clone();
        early.bodies.truncate(frame.bodies.len() - self.late_bodies);
        self.depth(encoder, &early, &target.create_view(&wgpu::TextureViewDescriptor::default()))?;
        Ok(depth_view(target))
    }

    /// Depth of every body; the stencil cleared.
    fn depth(&self, encoder: &mut wgpu::CommandEncoder, frame: &Frame, view: &wgpu::TextureView) -> Result<(), String> {
        let Self { gpu, format, samples, .. } = *self;
        let eye = frame.eye.camera();
        let is_reversed = frame.eye.depth == DepthDirection::Reversed;
        let mut words = [0.0; 20];
        words[..16].copy_from_slice(eye.view_projection.as_flattened());
        words[16..19].copy_from_slice(&eye.origin);
        words[19] = f32::from_bits(u32::from(self.is_reordered));
        let compare = if is_reversed { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Less };
        let pipeline = gpu.kept(&format!("bodies {format:?} {samples} {is_reversed}"), || {
            let depth_stencil = Some(pipelines::depth(format, compare, true));
            Ok(Drawing { source: DEPTH, depth_stencil, samples, ..Drawing::default() }.pipeline(&gpu.device))
        })?;
        let bodies = frame.bodies.iter().filter(|body| body.is_drawn);
        let corners: Vec<[f32; 3]> = bodies
            .flat_map(|body| {
                // In the order that caps are drawn in, which the last bits of depth depend on.
                let faces = Body::caster(frame.placed(body).shape).finite_faces();
                faces.into_iter().flatten().map(|v| body.shape.positions[v as usize])
            })
            .collect();
        let camera = uniform::<[f32; 20]>(gpu, &words);
        let far = wgpu::LoadOp::Clear(if is_reversed { 0.0 } else { 1.0 });
        let mut pass = encoder.begin_render_pass(&depth_pass(view, (Some(far), CLEARED.1)));
        pass.set_pipeline(&pipeline);
        // Small devices bind 64 KiB.
        for part in corners.chunks(3 * 1024) {
            let part_buffer = gpu.storage(part);
            let bound = [&camera, &part_buffer].map(wgpu::Buffer::as_entire_binding);
            pass.set_bind_group(0, &pipelines::group(&gpu.device, &pipeline.get_bind_group_layout(0), bound), &[]);
            pass.draw(0..part.len() as u32, 0..1);
        }
        Ok(())
    }
}
