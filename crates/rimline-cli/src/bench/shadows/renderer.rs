//! One caster in its room on the GPU, drawn with one counting method, timed part by part.

use std::time::Instant;

use rimline::ShadowCamera;
use rimline::gpu::{
    Extractor, ExtractorOptions, PositionBuffer, ShadowFormat, ShadowFrame, ShadowOptions, ShadowPipelines,
    ShadowVolumes, StageTimer, read_back_vec,
};
use rimline::{Light, Mesh, wgpu};
use rimline_bench::shapes::Shape;
use wgpu::{ColorWrites, LoadOp, PrimitiveTopology, TextureAspect, TextureFormat, TextureUsages};

use super::method::ShadowMethod;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;
use crate::render::camera::Camera;
use crate::render::pipeline_factory::{Pass, PipelineFactory};
use crate::shadow::frame::shadow_camera;
use crate::shadow::receiver_pipelines::{ADD, Onto};

/// The drawn scene: a caster, and a room that receives.
pub(super) struct Stage<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) caster: &'a Shape,
    pub(super) room: &'a Shape,
    /// Pixels across and down.
    pub(super) size: u32,
}

/// Milliseconds of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrameTime {
    /// The pass that counts.
    pub(crate) stencil_ms: f64,
    /// The whole frame: extraction, choice, depth, stencil, light.
    pub(crate) frame_ms: f64,
}

/// Layout of `Frame` in `frame.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Frame {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 3],
    reserved_0: u32,
    light: [f32; 3],
    reserved_1: u32,
}

const COLOR: TextureFormat = TextureFormat::Rgba8Unorm;
/// A format that every device has.
const DEPTH: TextureFormat = TextureFormat::Depth24PlusStencil8;
/// The passes that draw, as the timer has them.
const PASSES: [&str; 3] = ["depth", "stencil", "light"];

pub(super) struct ShadowBenchRenderer<'a> {
    gpu: &'a Gpu,
    stage: &'a Stage<'a>,
    factory: PipelineFactory<'a>,
    depth: wgpu::RenderPipeline,
    light: wgpu::RenderPipeline,
    /// Each with its number of corners.
    bodies: [(wgpu::BindGroup, u32); 2],
    positions: wgpu::Buffer,
    extractor: Extractor,
    pipelines: ShadowPipelines,
    volumes: ShadowVolumes,
    shadows: Option<ShadowFrame>,
    color_view: wgpu::TextureView,
    depth_texture: wgpu::Texture,
    depth_view: wgpu::TextureView,
    timer: Option<StageTimer>,
}

impl<'a> ShadowBenchRenderer<'a> {
    pub(super) fn new(gpu: &'a Gpu, stage: &'a Stage<'a>, method: &ShadowMethod) -> Result<Self, GpuError> {
        let nothing = vec![0; size_of::<Frame>()];
        let factory = PipelineFactory::new(&gpu.device, &gpu.queue, include_str!("frame.wgsl"), &nothing);
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let layout = factory.layout(&[storage, storage]);
        let pipeline = |name, onto: Onto, blend| {
            factory.pipeline(&Pass {
                name,
                vertex: "surface",
                source: "",
                groups: &[&layout],
                topology: PrimitiveTopology::TriangleList,
                format: COLOR,
                blend,
                samples: 1,
                write: ColorWrites::ALL,
                depth: Some(onto.state(DEPTH)),
                constants: &[],
            })
        };
        let [depth, light] = [pipeline("ambient", Onto::Nearest, None), pipeline("lit", Onto::Lit, ADD)];
        let positions = factory.buffer(&gpu.queue, "positions", bytemuck::cast_slice(&stage.caster.positions));
        let body = |shape: &Shape, positions: &wgpu::Buffer| {
            let faces = factory.buffer(&gpu.queue, "faces", bytemuck::cast_slice(&shape.faces));
            let buffers = [positions, &faces].map(wgpu::Buffer::as_entire_binding);
            (factory.group(&layout, &buffers), 3 * shape.faces.len() as u32)
        };
        let walls = factory.buffer(&gpu.queue, "walls", bytemuck::cast_slice(&stage.room.positions));
        let bodies = [body(stage.caster, &positions), body(stage.room, &walls)];
        let extractor = Extractor::new(&gpu.pipelines, stage.mesh, ExtractorOptions::default())?;
        let format = ShadowFormat { depth_stencil: DEPTH, ..ShadowFormat::default() };
        let pipelines = ShadowPipelines::new(&gpu.pipelines, &format, method.counting)?;
        let volumes = ShadowVolumes::new(&pipelines, &extractor, ShadowOptions::default())?;
        let size = [stage.size; 2];
        let texture = |label, format, usage| factory.target(label, size, format, 1, usage);
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let depth_texture = texture("depth", DEPTH, TextureUsages::COPY_SRC);
        Ok(Self {
            gpu,
            stage,
            depth,
            light,
            bodies,
            positions,
            extractor,
            pipelines,
            volumes,
            shadows: None,
            color_view: view(&texture("color", COLOR, TextureUsages::empty())),
            depth_view: view(&depth_texture),
            depth_texture,
            timer: StageTimer::new(&gpu.device, &gpu.queue),
            factory,
        })
    }

    /// Draws a frame and waits for it.
    pub(super) fn draw(&mut self, camera: &Camera, light: Light) -> Result<FrameTime, Failure> {
        let (gpu, view) = (self.gpu, shadow_camera(camera));
        let [x, y, z] = light.xyz;
        let frame = Frame {
            view_projection: view.view_projection,
            eye: camera.eye.into(),
            reserved_0: 0,
            light: [x - camera.eye.x, y - camera.eye.y, z - camera.eye.z],
            reserved_1: 0,
        };
        self.factory.set_frame(&gpu.queue, bytemuck::bytes_of(&frame));
        let mut timer = self.timer.take();
        let time = match &mut timer {
            Some(timer) => self.timed(&view, light, timer).map_err(|error| error.on(gpu)),
            None => self.clocked(&view, light),
        };
        self.timer = timer;
        time
    }

    /// By the GPU's timestamps.
    fn timed(&mut self, camera: &ShadowCamera, light: Light, timer: &mut StageTimer) -> Result<FrameTime, GpuError> {
        let gpu = self.gpu;
        timer.clear();
        let mut encoder = self.encoder();
        self.prepare(&mut encoder, camera, light, Some(timer))?;
        for pass in PASSES {
            self.pass(&mut encoder, pass, Some(timer))?;
        }
        timer.resolve(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        let stages = timer.read(&gpu.device, &gpu.queue)?;
        let frame_ms = timer.read_span(&gpu.device, &gpu.queue)?;
        let stencil = stages.iter().find(|(name, _)| *name == PASSES[1]);
        Ok(FrameTime { stencil_ms: stencil.map_or(0.0, |(_, ms)| *ms), frame_ms })
    }

    /// By the clock, each part waited for.
    fn clocked(&mut self, camera: &ShadowCamera, light: Light) -> Result<FrameTime, Failure> {
        let gpu = self.gpu;
        let mut time = FrameTime::default();
        for pass in [None, Some(PASSES[0]), Some(PASSES[1]), Some(PASSES[2])] {
            let begin = Instant::now();
            let mut encoder = self.encoder();
            match pass {
                None => self.prepare(&mut encoder, camera, light, None),
                Some(pass) => self.pass(&mut encoder, pass, None),
            }
            .map_err(|error| error.on(gpu))?;
            gpu.queue.submit([encoder.finish()]);
            gpu.wait()?;
            let ms = begin.elapsed().as_secs_f64() * 1e3;
            time.frame_ms += ms;
            if pass == Some(PASSES[1]) {
                time.stencil_ms = ms;
            }
        }
        Ok(time)
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Extraction and choice.
    fn prepare(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &ShadowCamera,
        light: Light,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        let positions = PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 };
        let extraction = self.extractor.encode(encoder, positions, &[light], timer.as_deref_mut())?;
        self.shadows = Some(self.volumes.encode(encoder, &extraction, camera, timer)?);
        Ok(())
    }

    /// One of the passes that draw.
    fn pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        name: &'static str,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        let [is_first, is_stencil] = [PASSES[0], PASSES[1]].map(|pass| pass == name);
        let store = wgpu::StoreOp::Store;
        let color = Some(wgpu::RenderPassColorAttachment {
            view: &self.color_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: if is_first { LoadOp::Clear(wgpu::Color::BLACK) } else { LoadOp::Load },
                store,
            },
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(name),
            color_attachments: if is_stencil { &[] } else { std::slice::from_ref(&color) },
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations {
                    load: if is_first { LoadOp::Clear(0.0) } else { LoadOp::Load },
                    store,
                }),
                stencil_ops: Some(wgpu::Operations {
                    load: if is_first { LoadOp::Clear(0) } else { LoadOp::Load },
                    store,
                }),
            }),
            timestamp_writes: timer.and_then(|timer| timer.render_pass(name)),
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if is_stencil {
            if let Some(shadows) = &self.shadows {
                shadows.draw(&mut pass, &self.pipelines, 0)?;
            }
            return Ok(());
        }
        pass.set_pipeline(if is_first { &self.depth } else { &self.light });
        pass.set_bind_group(0, &self.factory.frame_group, &[]);
        for (group, corners) in &self.bodies {
            pass.set_bind_group(1, group, &[]);
            pass.draw(0..*corners, 0..1);
        }
        Ok(())
    }

    /// The counts of a frame, row by row, the light pass left out.
    pub(super) fn counts(&mut self, camera: &Camera, light: Light) -> Result<Vec<u8>, Failure> {
        self.draw(camera, light)?;
        let (gpu, size) = (self.gpu, self.stage.size);
        let mut encoder = self.encoder();
        for pass in [PASSES[0], PASSES[1]] {
            self.pass(&mut encoder, pass, None).map_err(|error| error.on(gpu))?;
        }
        let row = size.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stencil"),
            size: u64::from(row) * u64::from(size),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { aspect: TextureAspect::StencilOnly, ..self.depth_texture.as_image_copy() },
            wgpu::TexelCopyBufferInfo {
                buffer: &copy,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
            },
            self.depth_texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let read = read_back_vec(&gpu.device, &gpu.queue, &copy);
        let all: Vec<u8> = read.map_err(|error| GpuError::from(error).on(gpu))?;
        Ok(all.chunks(row as usize).flat_map(|line| &line[..size as usize]).copied().collect())
    }
}
