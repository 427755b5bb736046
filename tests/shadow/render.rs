//! A frame on the GPU: the depth of everything, then each light's count in the stencil buffer, read back.

use rimline::gpu::depth_map::{DepthMap, DepthMapOptions, DepthMapPipelines, DepthMapVolumes};
use rimline::gpu::{
    Pipelines, PositionBuffer, Receivers, SceneOptions, SceneStatistics, ShadowFormat, ShadowPipelines, read_back_vec,
};
use rimline::internals::layout::{ShadowDraws, ShadowLight, ShadowStatistics};
use rimline::mesh::Weld;
use rimline::{Counting, DepthDirection, Light, Mesh};
use rimline_testkit::{OneCaster, OneCasterOptions, OneFrame};

use crate::in_scene::InScene;
use crate::scene::{Body, Frame, Placed};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::uniform;
use rimline_testkit::on_gpu::{chosen, draws, shadow_statistics, text};
use rimline_testkit::pipelines::{self, Drawing};

/// How the scene's own depth pass computes positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DepthPass {
    /// Equal to the volumes' positions, bit for bit.
    Alike,
    /// In another order.
    Reordered,
}

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
    /// Words of what the shadows of a scene may fall on.
    pub(crate) receivers: Vec<u32>,
    /// Draws for each caster and light.
    pub(crate) draws: Vec<Vec<ShadowDraws>>,
    pub(crate) statistics: Vec<ShadowStatistics>,
    /// Statistics of a scene.
    pub(crate) scene: Option<SceneStatistics>,
}

const DEPTH: &str = "
struct Camera { columns: array<vec4<f32>, 4>, origin: vec3<f32>, reordered: u32 }
@group(0) @binding(0) var<uniform> camera: Camera;
struct Out { @invariant @builtin(position) clip: vec4<f32> }
@vertex fn scene(@location(0) position: vec3<f32>) -> Out {
  let q = position - camera.origin;
  var clip = camera.columns[0] * q.x + camera.columns[1] * q.y + camera.columns[2] * q.z + camera.columns[3];
  if (camera.reordered != 0u) {
    clip = camera.columns[3] + (camera.columns[2] * q.z + (camera.columns[1] * q.y + camera.columns[0] * q.x));
  }
  return Out(clip);
}
@fragment fn nothing() {}
";

const SAMPLES: &str = "
@group(0) @binding(0) var stencil: texture_multisampled_2d<u32>;
@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.0, 1.0);
}
@fragment fn samples(@builtin(position) at: vec4<f32>) -> @location(0) vec4<u32> {
  let pixel = vec2<i32>(at.xy);
  return vec4<u32>(
    textureLoad(stencil, pixel, 0).x,
    textureLoad(stencil, pixel, 1).x,
    textureLoad(stencil, pixel, 2).x,
    textureLoad(stencil, pixel, 3).x,
  );
}
";

pub(crate) struct Renderer<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) pipelines: Pipelines,
    pub(crate) format: wgpu::TextureFormat,
    pub(crate) depth_pass: DepthPass,
    /// 1 or 4.
    pub(crate) samples: u32,
    pub(crate) options: OneCasterOptions,
    /// Capacity of the lists of silhouette edges.
    pub(crate) list_capacity: Option<u32>,
    /// Range of every light.
    pub(crate) range: f32,
    pub(crate) placing: Placing,
    /// Number of batches of a scene's casters.
    pub(crate) count_batches: u32,
    /// Whether a scene is told what its shadows fall on, and whether they fall on the sky.
    pub(crate) receivers: Option<bool>,
    /// Switches levels of skipping of a scene.
    pub(crate) levels: fn(&mut SceneOptions),
    /// The last bodies, which are drawn after the scene is encoded.
    pub(crate) late_bodies: usize,
    /// Low bits of the stencil that counts own.
    pub(crate) count_bits: u32,
    /// Whether volumes are cut at the frustum in the vertex shader.
    pub(crate) trim: bool,
    /// The map of a light, drawn into the same stencil in each pass: by these pipelines, of so many bits, before the
    /// meshes or after them.
    pub(crate) beside: Option<Beside<'a>>,
}

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
            pipelines: gpu.pipelines.clone(),
            format: wgpu::TextureFormat::Depth24PlusStencil8,
            depth_pass: DepthPass::Alike,
            samples: 1,
            options: OneCasterOptions::default(),
            list_capacity: None,
            range: f32::INFINITY,
            placing: Placing::Alone,
            count_batches: 1,
            receivers: None,
            levels: |_| {},
            late_bodies: 0,
            count_bits: 8,
            trim: false,
            beside: None,
        }
    }

    /// Copies the stencil values, rows of so many bytes, which split into samples.
    pub(crate) fn copy_stencil(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::Texture,
        row: u32,
    ) -> wgpu::Buffer {
        let copy = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stencil"),
            size: u64::from(row) * u64::from(target.height()),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let split = (self.samples > 1).then(|| self.split(encoder, target));
        let aspect = if split.is_some() { wgpu::TextureAspect::All } else { wgpu::TextureAspect::StencilOnly };
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { aspect, ..split.as_ref().unwrap_or(target).as_image_copy() },
            wgpu::TexelCopyBufferInfo {
                buffer: &copy,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
            },
            target.size(),
        );
        copy
    }

    pub(crate) fn count(&self, frame: &Frame, counting: Counting) -> Result<Counted, String> {
        let gpu = self.gpu;
        let shadow_format = |front_face| ShadowFormat {
            front_face,
            depth_stencil: self.format,
            depth: frame.eye.depth,
            samples: self.samples,
            has_far_plane: frame.eye.far.is_some(),
            count_bits: self.count_bits,
            trim: self.trim,
            ..ShadowFormat::default()
        };
        let pipelines =
            |front_face| ShadowPipelines::new(&self.pipelines, &shadow_format(front_face), counting).map_err(text);
        let plain = pipelines(wgpu::FrontFace::Ccw)?;
        let is_mirrored = frame.bodies.iter().any(|body| body.mirror.is_some());
        let mirroring = if is_mirrored { Some(pipelines(wgpu::FrontFace::Cw)?) } else { None };
        let target = self.target(frame.size, self.samples, self.format);
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let depth = self.early_depth(&mut encoder, frame, &target);
        let receivers = self.receivers.map(|sky_receives| Receivers { depth: &depth, sky_receives, version: None });
        let format = shadow_format(wgpu::FrontFace::Ccw);
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
            self.depth(&mut encoder, frame, &view);
        }
        let row = (frame.size * self.samples).next_multiple_of(256);
        let mut copies = Vec::new();
        for light in 0..frame.lights.len() {
            let mut pass = encoder.begin_render_pass(&attachment(&view, wgpu::LoadOp::Load));
            draw_mapped(&mut pass, true)?;
            for (shadows, is_mirrored) in &casters {
                let pipelines = mirroring.as_ref().filter(|_| *is_mirrored).unwrap_or(&plain);
                shadows.draw(&mut pass, pipelines, light).map_err(text)?;
            }
            if let Some(together) = &together {
                together.draw(&mut pass, light)?;
            }
            draw_mapped(&mut pass, false)?;
            drop(pass);
            copies.push(self.copy_stencil(&mut encoder, &target, row));
        }
        gpu.queue.submit([encoder.finish()]);
        let mut counted = Counted {
            stencils: self.stencils(&copies, [row, frame.size])?,
            chosen: Vec::new(),
            receivers: Vec::new(),
            draws: Vec::new(),
            statistics: Vec::new(),
            scene: None,
        };
        for (shadows, _) in &casters {
            counted.chosen.push(chosen(gpu, shadows, frame.lights.len())?);
            counted.draws.push(draws(gpu, shadows, frame.lights.len())?);
            counted.statistics.push(shadow_statistics(gpu, shadows)?);
        }
        if let Some(together) = &together {
            together.read(gpu, &mut counted)?;
        }
        Ok(counted)
    }

    /// The casters of a frame, each in a scene of its own, and whether each is mirrored.
    fn alone(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        counting: Counting,
    ) -> Result<Vec<(OneFrame, bool)>, String> {
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
            let options = OneCasterOptions {
                counting,
                max_lights: lights.len(),
                in_depth: body.in_depth,
                list_capacity: self.list_capacity,
                count_bits: self.count_bits,
                ..self.options
            };
            let caster = OneCaster::new(&self.pipelines, &self.gpu.queue, &mesh.map_err(text)?, &options);
            let encoded = caster.and_then(|mut one| one.encode(encoder, positions, &lights, Some(&camera), None));
            casters.push((encoded.map_err(text)?, body.mirror.is_some()));
        }
        Ok(casters)
    }

    /// The stencil values of copies with rows of so many bytes, for pictures with so many pixels a side.
    fn stencils(&self, copies: &[wgpu::Buffer], [row, size]: [u32; 2]) -> Result<Vec<Vec<u8>>, String> {
        let samples = self.samples as usize;
        let mut stencils = Vec::new();
        for copy in copies {
            let all: Vec<u8> = read_back_vec(&self.gpu.device, &self.gpu.queue, copy).map_err(|e| e.to_string())?;
            let lines = all.chunks(row as usize).map(|line| &line[..size as usize * samples]);
            let values: Vec<u8> = lines.flatten().copied().collect();
            stencils.extend((0..samples).map(|sample| values.iter().skip(sample).step_by(samples).copied().collect()));
        }
        Ok(stencils)
    }

    pub(crate) fn target(&self, size: u32, sample_count: u32, format: wgpu::TextureFormat) -> wgpu::Texture {
        let read = if sample_count == 1 { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() };
        let read = read | wgpu::TextureUsages::TEXTURE_BINDING;
        self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("target"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | read,
            view_formats: &[],
        })
    }

    /// A texture with a channel for each sample's stencil value.
    fn split(&self, encoder: &mut wgpu::CommandEncoder, target: &wgpu::Texture) -> wgpu::Texture {
        let device = &self.gpu.device;
        let format = wgpu::TextureFormat::Rgba8Uint;
        let split = self.target(target.width(), 1, format);
        let drawing =
            Drawing { label: "samples", source: SAMPLES, targets: &[Some(format.into())], ..Drawing::default() };
        let pipeline = drawing.pipeline(device);
        let stencil = target.create_view(&wgpu::TextureViewDescriptor {
            aspect: wgpu::TextureAspect::StencilOnly,
            ..wgpu::TextureViewDescriptor::default()
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&stencil) }],
        });
        let color = Some(wgpu::RenderPassColorAttachment {
            view: &split.create_view(&wgpu::TextureViewDescriptor::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("samples"),
            color_attachments: &[color],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        split
    }

    /// Depth of all bodies but those that are drawn late, and a view of it.
    fn early_depth(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        target: &wgpu::Texture,
    ) -> wgpu::TextureView {
        let mut early = frame.clone();
        early.bodies.truncate(frame.bodies.len() - self.late_bodies);
        self.depth(encoder, &early, &target.create_view(&wgpu::TextureViewDescriptor::default()));
        target.create_view(&wgpu::TextureViewDescriptor {
            aspect: wgpu::TextureAspect::DepthOnly,
            ..wgpu::TextureViewDescriptor::default()
        })
    }

    /// Depth of every body; the stencil cleared.
    pub(crate) fn depth(&self, encoder: &mut wgpu::CommandEncoder, frame: &Frame, view: &wgpu::TextureView) {
        let device = &self.gpu.device;
        let camera = frame.eye.camera();
        let is_reversed = frame.eye.depth == DepthDirection::Reversed;
        let mut words = [0.0; 20];
        words[..16].copy_from_slice(camera.view_projection.as_flattened());
        words[16..19].copy_from_slice(&camera.origin);
        words[19] = f32::from_bits(u32::from(self.depth_pass == DepthPass::Reordered));
        let buffer = uniform::<[f32; 20]>(self.gpu, &words);
        let compare = if is_reversed { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Less };
        let drawing = Drawing {
            label: "scene",
            source: DEPTH,
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
            depth_stencil: Some(pipelines::depth(self.format, compare, true)),
            samples: self.samples,
            ..Drawing::default()
        };
        let pipeline = drawing.pipeline(device);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        let corners: Vec<[f32; 3]> = frame
            .bodies
            .iter()
            .filter(|body| body.is_drawn)
            .flat_map(|body| {
                // In the order that caps are drawn in, which the last bits of depth depend on.
                let faces = Body::caster(frame.placed(body).shape).finite_faces();
                faces.into_iter().flatten().map(|v| body.shape.positions[v as usize])
            })
            .collect();
        let vertices = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("corners"),
            size: (corners.len() * 12) as u64,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.gpu.queue.write_buffer(&vertices, 0, bytemuck::cast_slice(&corners));
        let mut pass =
            encoder.begin_render_pass(&attachment(view, wgpu::LoadOp::Clear(if is_reversed { 0.0 } else { 1.0 })));
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.draw(0..corners.len() as u32, 0..1);
    }
}

/// The depth as `load` says, the stencil cleared.
pub(crate) fn attachment(view: &wgpu::TextureView, load: wgpu::LoadOp<f32>) -> wgpu::RenderPassDescriptor<'_> {
    wgpu::RenderPassDescriptor {
        label: Some("count"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
            stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store }),
        }),
        ..Default::default()
    }
}
