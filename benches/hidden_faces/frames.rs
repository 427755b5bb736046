//! Frames of a scene on the GPU: the stages, the depth of what is seen, and the volumes in the stencil.

use std::collections::HashMap;
use std::rc::Rc;
use std::time::Instant;

use glam::{Mat4, Vec3, Vec4};
use rimline::cpu::HiddenFaces;
use rimline::gpu::{
    Caster, CasterHandle, LightHandle, Measuring, PositionBuffer, Scene, SceneFrame, SceneOptions, ScenePipelines,
    ShadowFormat, read_back_vec,
};
use rimline::reference::layout::ShadowDraws;
use rimline::{Counting, DepthDirection, Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::pipelines::{self, Drawing};

use crate::capping::CapDrawer;
use crate::scenes::{Body, Setting};

pub(crate) const SIZE: [u32; 2] = [640, 480];
pub(crate) const NEAR: f32 = 0.5;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth24PlusStencil8;
/// Runs; the least time of each part counts. Runs of scenes that are compared take turns.
const ROUNDS: usize = 7;

// Positions equal those of the volumes bit for bit, because z-fail needs equal depths.
const SHADER: &str = "
@group(0) @binding(0) var<uniform> columns: mat4x4<f32>;
struct Out { @invariant @builtin(position) clip: vec4<f32> }
@vertex fn scene(@location(0) p: vec3<f32>) -> Out {
  return Out(columns[0] * p.x + columns[1] * p.y + columns[2] * p.z + columns[3]);
}
@fragment fn nothing() {}
";

/// Milliseconds and fragments of a frame with a light.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Measured {
    pub(crate) stages: f64,
    pub(crate) depth: f64,
    pub(crate) stencil: f64,
    pub(crate) fragments: u64,
}

impl Measured {
    pub(crate) fn frame(&self) -> f64 {
        self.stages + self.depth + self.stencil
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.stages += other.stages;
        self.depth += other.depth;
        self.stencil += other.stencil;
        self.fragments += other.fragments;
    }
}

pub(crate) struct Frames {
    pub(crate) gpu: Gpu,
    pipelines: ScenePipelines,
    texture: wgpu::Texture,
    target: wgpu::TextureView,
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

/// Geometry of a setting that is drawn before shadows, and the camera.
pub(crate) struct View {
    pub(crate) camera: ShadowCamera,
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    count: u32,
}

/// A scene with some casters and one light.
pub(crate) struct Casting {
    scene: Scene,
    light: LightHandle,
    casters: Vec<CasterHandle>,
}

/// Reversed depth without a far plane, Z up.
pub(crate) fn camera(setting: &Setting) -> Mat4 {
    let (eye, up) = (Vec3::from(setting.eye), Vec3::Z);
    let forward = (Vec3::from(setting.target) - eye).normalize();
    let right = forward.cross(up).normalize();
    let scale = 2.0;
    let row = |axis: Vec3, scale: f32| (scale * axis).extend(-scale * axis.dot(eye));
    let [x, y] = [row(right, scale * SIZE[1] as f32 / SIZE[0] as f32), row(right.cross(forward), scale)];
    Mat4::from_cols(x, y, Vec4::new(0.0, 0.0, 0.0, NEAR), row(forward, 1.0)).transpose()
}

impl Frames {
    pub(crate) fn new(counting: Counting) -> Result<Self, String> {
        let gpu = Gpu::with_limits(wgpu::Limits::default())?;
        let pipelines = ScenePipelines::new(&gpu.pipelines, &ShadowFormat::default(), counting).map_err(text)?;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("depth"),
            size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("fragments"),
            ty: wgpu::QueryType::Occlusion,
            count: 1,
        });
        let resolved = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("fragments"),
            size: 8,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self { gpu, pipelines, texture, target, queries, resolved })
    }

    pub(crate) fn view(&self, setting: &Setting) -> View {
        let device = &self.gpu.device;
        let matrix = camera(setting);
        let camera = ShadowCamera {
            view_projection: matrix.to_cols_array_2d(),
            origin: [0.0; 3],
            depth: DepthDirection::Reversed,
        };
        let far = 1e3 * Vec3::from(setting.eye).length();
        let corner = |x: f32, y: f32| [far * x, far * y, setting.ground];
        let mut vertices = vec![corner(-1.0, -1.0), corner(3.0, -1.0), corner(-1.0, 3.0)];
        for body in &setting.bodies {
            vertices.extend(body.mesh.faces().iter().flatten().map(|&vertex| body.positions[vertex as usize]));
        }
        let drawing = Drawing {
            label: "depth",
            source: SHADER,
            entry_points: [Some("scene"), Some("nothing")],
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
            depth_stencil: Some(pipelines::depth(DEPTH, wgpu::CompareFunction::Greater, true)),
            ..Drawing::default()
        };
        let pipeline = drawing.pipeline(device);
        let buffer = |contents: &[u8], usage| {
            let size = contents.len() as u64;
            let usage = usage | wgpu::BufferUsages::COPY_DST;
            let label = Some("view");
            let buffer =
                device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false });
            self.gpu.queue.write_buffer(&buffer, 0, contents);
            buffer
        };
        let uniform = buffer(bytemuck::bytes_of(&matrix.to_cols_array()), wgpu::BufferUsages::UNIFORM);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("view"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let count = vertices.len() as u32;
        let vertices = buffer(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX);
        View { camera, pipeline, group, vertices, count }
    }

    /// A scene of bodies, whose stages compute everything in each frame.
    pub(crate) fn casting(&self, bodies: &[Body], light: Light) -> Result<Casting, String> {
        let mut options =
            SceneOptions { max_lights: 1, counting: self.pipelines.counting(), ..SceneOptions::default() };
        options.measuring.set(Measuring::BITS, true);
        let mut scene = Scene::new(&self.gpu.pipelines, &self.gpu.queue, options).map_err(text)?;
        let positions: Vec<[f32; 3]> = bodies.iter().flat_map(|body| body.positions.iter().copied()).collect();
        let buffer = self.gpu.storage(&positions);
        let (mut meshes, mut casters, mut offset) = (HashMap::new(), Vec::new(), 0);
        for body in bodies {
            let key = Rc::as_ptr(&body.mesh);
            let mesh = match meshes.get(&key) {
                Some(mesh) => *mesh,
                None => scene.add_mesh(&body.mesh, &body.positions).map_err(text)?,
            };
            meshes.insert(key, mesh);
            let own = PositionBuffer { buffer: &buffer, offset, stride: 12 };
            let caster = scene.insert(Caster::in_buffer(mesh, own)).map_err(text)?;
            scene.set_position_version(caster, Some(0)).map_err(text)?;
            casters.push(caster);
            offset += 12 * body.positions.len() as u64;
        }
        let light = scene.add_light(light).map_err(text)?;
        Ok(Casting { scene, light, casters })
    }

    /// Milliseconds that commands take.
    fn clock(&self, record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<(), String>) -> Result<f64, String> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        record(&mut encoder)?;
        let commands = encoder.finish();
        let begin = Instant::now();
        self.gpu.queue.submit([commands]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(text)?;
        Ok(begin.elapsed().as_secs_f64() * 1e3)
    }

    pub(crate) fn measure<const N: usize>(
        &self,
        view: &View,
        mut all: [&mut Casting; N],
    ) -> Result<[Measured; N], String> {
        let mut least = [[f64::INFINITY; 3]; N];
        // The first run makes room and compiles.
        for run in 0..=ROUNDS {
            for (casting, least) in all.iter_mut().zip(&mut least) {
                let times = self.times(view, casting)?;
                if run > 0 {
                    least.iter_mut().zip(times).for_each(|(least, time)| *least = least.min(time));
                }
            }
        }
        let mut measured = [Measured::default(); N];
        for ((measured, casting), [stages, depth, stencil]) in measured.iter_mut().zip(all).zip(least) {
            *measured = Measured { stages, depth, stencil, fragments: self.fragments(view, casting)? };
        }
        Ok(measured)
    }

    /// Milliseconds of the stages, the depth and the volumes.
    fn times(&self, view: &View, casting: &mut Casting) -> Result<[f64; 3], String> {
        let mut frame = None;
        Ok([
            self.clock(|encoder| {
                frame = Some(casting.scene.encode(encoder, &[view.camera], None).map_err(text)?);
                Ok(())
            })?,
            self.clock(|encoder| {
                self.depth(encoder, view);
                Ok(())
            })?,
            self.clock(|encoder| {
                let mut pass = self.pass(encoder, wgpu::LoadOp::Load, false);
                self.draw(&mut pass, frame.as_ref(), casting.light)
            })?,
        ])
    }

    fn fragments(&self, view: &View, casting: &mut Casting) -> Result<u64, String> {
        self.clock(|encoder| {
            let frame = Some(casting.scene.encode(encoder, &[view.camera], None).map_err(text)?);
            // Depth is reversed: 0 is farthest, so all fragments pass.
            let mut pass = self.pass(encoder, wgpu::LoadOp::Clear(0.0), true);
            pass.begin_occlusion_query(0);
            self.draw(&mut pass, frame.as_ref(), casting.light)?;
            pass.end_occlusion_query();
            drop(pass);
            encoder.resolve_query_set(&self.queries, 0..1, &self.resolved, 0);
            Ok(())
        })?;
        let fragments: Vec<u64> = read_back_vec(&self.gpu.device, &self.gpu.queue, &self.resolved).map_err(text)?;
        Ok(fragments.iter().sum())
    }

    fn depth(&self, encoder: &mut wgpu::CommandEncoder, view: &View) {
        let mut pass = self.pass(encoder, wgpu::LoadOp::Clear(0.0), false);
        pass.set_pipeline(&view.pipeline);
        pass.set_bind_group(0, &view.group, &[]);
        pass.set_vertex_buffer(0, view.vertices.slice(..));
        pass.draw(0..view.count, 0..1);
    }

    /// The stencil of a frame, with caps of one's own or none, and what the scene drew.
    pub(crate) fn stencil(
        &self,
        view: &View,
        casting: &mut Casting,
        caps: Option<&CapDrawer>,
    ) -> Result<(Vec<u8>, Vec<ShadowDraws>), String> {
        let gpu = &self.gpu;
        let row = SIZE[0].next_multiple_of(256);
        let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stencil"),
            size: u64::from(row * SIZE[1]),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let frame = gpu.submit(|encoder| {
            let frame = casting.scene.encode(encoder, &[view.camera], None).map_err(text)?;
            self.depth(encoder, view);
            let mut pass = self.pass(encoder, wgpu::LoadOp::Load, false);
            self.draw(&mut pass, Some(&frame), casting.light)?;
            if let Some(caps) = caps {
                caps.draw(&mut pass);
            }
            drop(pass);
            let aspect = wgpu::TextureAspect::StencilOnly;
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo { aspect, ..self.texture.as_image_copy() },
                wgpu::TexelCopyBufferInfo { buffer: &copy, layout },
                self.texture.size(),
            );
            Ok(frame)
        })?;
        let all: Vec<u8> = gpu.read(&copy, usize::MAX)?;
        let mut draws = Vec::new();
        for buffer in frame.results().map_err(text)?.shadow_draws {
            draws.extend(gpu.read::<ShadowDraws>(buffer, 1)?);
        }
        Ok((all.chunks(row as usize).flat_map(|line| &line[..SIZE[0] as usize]).copied().collect(), draws))
    }

    /// A buffer of vertices.
    pub(crate) fn vertices(&self, floats: &[f32]) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST;
        let size = 4 * floats.len().max(4) as u64;
        let label = Some("vertices");
        let buffer =
            self.gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false });
        self.gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(floats));
        buffer
    }

    fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        frame: Option<&SceneFrame>,
        light: LightHandle,
    ) -> Result<(), String> {
        frame.map_or(Ok(()), |frame| frame.draw(pass, &self.pipelines, 0, light).map_err(text))
    }

    fn pass<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        load: wgpu::LoadOp<f32>,
        counts: bool,
    ) -> wgpu::RenderPass<'a> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("pass"),
            color_attachments: &[],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.target,
                depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store }),
            }),
            timestamp_writes: None,
            occlusion_query_set: counts.then_some(&self.queries),
            multiview_mask: None,
        })
    }
}

impl Casting {
    pub(crate) fn set_light(&mut self, light: Light) -> Result<(), String> {
        self.scene.set_light(self.light, light).map_err(text)
    }

    pub(crate) fn set_hidden(&mut self, hidden: Option<&HiddenFaces>) -> Result<(), String> {
        self.scene.set_hidden_faces(self.light, &self.casters, hidden).map_err(text)
    }
}
