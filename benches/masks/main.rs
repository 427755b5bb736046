//! `cargo bench --bench masks`: shadow masks from depth without a stencil, against the stencil of a caller who has one.
//! Milliseconds of the GPU for what comes after the depth pass: there a pass a light, with its volumes and a draw that
//! adds light where the stencil is 0; here the masks and one draw that adds all lights. Both must give the same
//! picture. Then the same without the light. `--quick` takes fewer rounds.

use std::cell::RefCell;
use std::time::Duration;

use glam::{Affine3A, Mat4, Vec3};
use rimline::cpu::{self, Threads};
use rimline::gltf::Asset;
use rimline::gpu::{
    Caster, FrameInputs, LightHandle, MaskInputs, Pipelines, Scene, SceneFrame, SceneOptions, ShadowFormat,
    ShadowMasks, ShadowPipelines,
};
use rimline::mesh::Weld;
use rimline::{Counting, Light, Matrix3x4, ShadowCamera};
use rimline_bench::Error;
use rimline_bench::engine::{Contender, Metric, Rounds, interleave};
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::pipelines::{Drawing, SURFACE, depth};
use rimline_bench::record::{Camera, IDENTITY};
use rimline_bench::row::{Entry, Variant};
use rimline_bench::shapes::{self, Shape};
use wgpu::TextureFormat;

const SIZE: [u32; 2] = [1280, 720];
const COLOR: TextureFormat = TextureFormat::Rgba16Float;
const DRAWING: Metric = Metric::Time("drawing");
const RECORDING: Metric = Metric::Time("recording");

const LIGHT: &str = "
@vertex fn whole(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
// White, as the colours of surfaces are read.
@group(0) @binding(0) var colors: texture_2d<f32>;
@group(0) @binding(1) var masks: texture_2d<u32>;
// The first word says how many lights there are.
@group(0) @binding(2) var<storage, read> lights: array<u32>;
@fragment fn one(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return textureLoad(colors, vec2<i32>(at.xy), 0);
}
// All lights whose bit is 0.
@fragment fn all(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let mask = textureLoad(masks, vec2<i32>(at.xy), 0).x;
  return f32(lights[0] - countOneBits(mask)) * textureLoad(colors, vec2<i32>(at.xy), 0);
}
";

fn main() -> Result<(), Error> {
    let is_quick = std::env::args().any(|argument| argument == "--quick");
    let (gpu, name) = device()?;
    let time = Duration::from_secs(if is_quick { 1 } else { 5 });
    println!("{name}; {} x {} pixels, Depth32Float; medians, milliseconds", SIZE[0], SIZE[1]);
    println!(
        "| scene | lights | own stencil | masks | ratio | without light, own | masks | ratio | recording, own | masks | ratio |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let (shape, title) = walker()?;
    let scenes = [(title, vec![(shape, vec![IDENTITY])]), ("100 casters".to_owned(), field())];
    for (title, casters) in &scenes {
        for lights in [1, 8, 32] {
            measure(&gpu, title, casters, lights, Rounds { least: 3, most: 200, time })?;
        }
    }
    Ok(())
}

/// The first device, with depth of 32 bits beside a stencil.
fn device() -> Result<(Gpu, String), Error> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
    let text = |error: &dyn std::fmt::Display| Error::Device(error.to_string());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let adapter = adapter.map_err(|error| text(&error))?;
    let opened = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: wgpu::Features::DEPTH32FLOAT_STENCIL8,
        ..wgpu::DeviceDescriptor::default()
    }));
    let (device, queue) = opened.map_err(|error| text(&error))?;
    let pipelines = Pipelines::new(&device);
    Ok((Gpu { device, queue, pipelines, reported: Box::new(|| None) }, adapter.get_info().name))
}

/// `CesiumMan` as it stands, one unit high and more; without the file a torus of as many faces.
fn walker() -> Result<(Shape, String), Error> {
    let text = |error: &dyn std::fmt::Display| Error::Device(error.to_string());
    let Some(folder) = rimline_testkit::assets() else {
        return Ok((shapes::torus(68, 34, 0.6, 0.25), "torus".to_owned()));
    };
    let asset = Asset::open(folder.join("CesiumMan.glb"), Weld::Position).map_err(|error| text(&error))?;
    let model = asset.model();
    let pose = asset.pose(None, 0.0).map_err(|error| text(&error))?;
    let positions = cpu::deform(model, &pose, 0.0, None, Threads::all()).map_err(|error| text(&error))?;
    Ok((Shape { positions, faces: model.geometries()[0].faces().to_vec() }, "CesiumMan".to_owned()))
}

/// Ten by ten casters of three shapes.
fn field() -> Vec<(Shape, Vec<Matrix3x4>)> {
    let kinds = [shapes::torus(32, 24, 0.35, 0.15), shapes::blob(4, 0.2, 3), shapes::cube()];
    let matrix_of = |at: usize| {
        let turn = Mat4::from_rotation_y(at as f32) * Mat4::from_rotation_x(0.7 * at as f32);
        let to = Vec3::new((at % 10) as f32 - 4.5, 0.6, (at / 10) as f32 - 4.5);
        let matrix = Mat4::from(Affine3A::from_translation(to)) * turn * Mat4::from_scale(Vec3::splat(0.4));
        [0, 1, 2].map(|row| matrix.row(row).to_array())
    };
    let of = |kind: usize| (0..100).filter(move |at| at % 3 == kind).map(matrix_of).collect();
    kinds.into_iter().enumerate().map(|(kind, shape)| (shape, of(kind))).collect()
}

/// The parts of both ways.
struct World<'a> {
    gpu: &'a Gpu,
    frame: SceneFrame,
    lights: Vec<LightHandle>,
    camera: wgpu::Buffer,
    corners: wgpu::Buffer,
    count: u32,
    color: wgpu::Texture,
    white: wgpu::TextureView,
    /// The scene, whose frame is drawn again and again.
    _scene: Scene,
}

fn measure(
    gpu: &Gpu,
    title: &str,
    casters: &[(Shape, Vec<Matrix3x4>)],
    lights: usize,
    rounds: Rounds,
) -> Result<(), Error> {
    let world = World::new(gpu, casters, lights)?;
    let (stencil, mut masked) = (Stencil::new(&world)?, Masked::new(&world)?);
    let stopwatch = Stopwatch::new(gpu);
    let mut pictures = Vec::new();
    let mut last = 0.0;
    for way in [&mut |encoder: &mut _| stencil.record(&world, encoder, true), &mut |encoder: &mut _| {
        masked.record(&world, encoder, true)
    }] as [&mut dyn FnMut(&mut wgpu::CommandEncoder) -> Result<(), Error>; 2]
    {
        let pixels =
            gpu.empty(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC, u64::from(8 * SIZE[0] * SIZE[1]));
        for _ in 0..2 {
            last = stopwatch.by_clock(|encoder| {
                way(encoder)?;
                let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(8 * SIZE[0]), ..Default::default() };
                let copy = wgpu::TexelCopyBufferInfo { buffer: &pixels, layout };
                encoder.copy_texture_to_buffer(world.color.as_image_copy(), copy, world.color.size());
                Ok(())
            })?[1];
        }
        pictures.push(gpu.read::<u8>(&pixels)?);
    }
    if pictures[0] != pictures[1] {
        return Err(Error::Device(format!("{title}, {lights} lights: the pictures differ")));
    }
    // More on a fast device, so that handing over the commands weighs little.
    let repeats = (20.0 / last).clamp(1.0, 30.0) as usize;
    let masked = &RefCell::new(masked);
    let by = |by_stencil: bool, is_lit: bool| {
        let (stencil, world, stopwatch) = (&stencil, &world, &stopwatch);
        let run: Contender<'_> = Box::new(move || {
            let times = stopwatch.by_clock(|encoder| {
                (0..repeats).try_for_each(|_| {
                    if by_stencil {
                        stencil.record(world, encoder, is_lit)
                    } else {
                        masked.borrow_mut().record(world, encoder, is_lit)
                    }
                })
            })?;
            let [recording, drawing] = times.map(|time| time / repeats as f64);
            Ok(vec![(RECORDING, recording), (DRAWING, drawing)])
        });
        run
    };
    let samples = interleave(rounds, vec![by(true, true), by(false, true), by(true, false), by(false, false)], &())?;
    let median = |at: usize, metric| {
        Entry::new(Variant::new("masks", "masks", 0, 0), &samples[at]).median(metric).unwrap_or(f64::NAN)
    };
    let cells = [(DRAWING, 0), (DRAWING, 2), (RECORDING, 0)].map(|(metric, first)| {
        let [stencil, masks] = [first, first + 1].map(|at| median(at, metric));
        format!("{stencil:.3} | {masks:.3} | {:.2}", masks / stencil)
    });
    println!("| {title} | {lights} | {} |", cells.join(" | "));
    Ok(())
}

impl<'a> World<'a> {
    fn new(gpu: &'a Gpu, casters: &[(Shape, Vec<Matrix3x4>)], lights: usize) -> Result<Self, Error> {
        let mut scene =
            Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions { max_lights: 32, ..SceneOptions::default() })?;
        // A ground that does not cast.
        let mut corners: Vec<[f32; 3]> = [[-1, 1], [1, 1], [1, -1], [-1, 1], [1, -1], [-1, -1]]
            .map(|[x, z]| [50.0 * x as f32, 0.0, 50.0 * z as f32])
            .into();
        for (shape, matrices) in casters {
            let mesh = scene.add_mesh(&shape.mesh()?, &shape.positions)?;
            for matrix in matrices {
                scene.insert(Caster::rigid(mesh, *matrix))?;
                let transform = |p: [f32; 3]| matrix.map(|[x, y, z, shift]| Vec3::new(x, y, z).dot(p.into()) + shift);
                corners.extend(shape.faces.iter().flatten().map(|&v| transform(shape.positions[v as usize])));
            }
        }
        // Above, all around, and one in four at infinity.
        let light = |number: usize| {
            let angle = 2.4 * number as f32;
            let xyz = [4.0 * angle.cos(), 4.0, 4.0 * angle.sin()];
            if number % 4 == 3 { Light::directional(xyz) } else { Light::point(xyz) }
        };
        let lights = (0..lights).map(|number| scene.add_light(light(number))).collect::<Result<Vec<_>, _>>()?;
        let far: f32 = if casters.len() > 1 { 7.0 } else { 2.2 };
        let eye = Vec3::new(0.3, 0.7, 1.0) * far;
        let level = Camera::level(eye, Vec3::Y * 0.5 - eye, 1.8, 0.05).shadow();
        let wide = Mat4::from_scale(Vec3::new(SIZE[1] as f32 / SIZE[0] as f32, 1.0, 1.0));
        let matrix = wide * Mat4::from_cols_array_2d(&level.view_projection);
        let camera = ShadowCamera { view_projection: matrix.to_cols_array_2d(), ..level };
        let mut encoder = gpu.encoder();
        let frame = scene.encode(&mut encoder, FrameInputs::new(&[camera.into()]))?;
        let white = texture(gpu, TextureFormat::Rgba8Unorm).create_view(&wgpu::TextureViewDescriptor::default());
        let clear = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
        drop(pass(&mut encoder, Some((&white, clear)), None, wgpu::LoadOp::Load));
        gpu.queue.submit([encoder.finish()]);
        let words = [camera.view_projection.concat(), [eye.to_array().to_vec(), vec![0.0]].concat()].concat();
        let storage = wgpu::BufferUsages::STORAGE;
        Ok(Self {
            gpu,
            frame,
            lights,
            camera: gpu.buffer(storage, &words),
            count: corners.len() as u32,
            corners: gpu.buffer(storage, &corners),
            color: texture(gpu, COLOR),
            white,
            _scene: scene,
        })
    }

    /// Draws the surfaces' depth.
    fn depth(&self, texture: &wgpu::Texture) {
        let (gpu, device) = (self.gpu, &self.gpu.device);
        let depth_stencil = Some(depth(texture.format(), wgpu::CompareFunction::Greater, true));
        let pipeline = Drawing { source: SURFACE, depth_stencil, samples: 1, ..Drawing::default() }.pipeline(device);
        let group = group(gpu, &pipeline, &[self.camera.as_entire_binding(), self.corners.as_entire_binding()]);
        let mut encoder = gpu.encoder();
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = pass(&mut encoder, None, Some(&view), wgpu::LoadOp::Clear(0.0));
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..self.count, 0..1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }

    fn color(&self) -> wgpu::TextureView {
        self.color.create_view(&wgpu::TextureViewDescriptor::default())
    }
}

/// A caller with a stencil.
struct Stencil {
    volumes: ShadowPipelines,
    light: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    depth: wgpu::TextureView,
    color: wgpu::TextureView,
}

impl Stencil {
    fn new(world: &World<'_>) -> Result<Self, Error> {
        let format = ShadowFormat {
            depth_stencil: TextureFormat::Depth32FloatStencil8,
            colors: vec![Some(COLOR)],
            ..ShadowFormat::default()
        };
        let volumes = ShadowPipelines::new(&world.gpu.pipelines, &format, Counting::Auto)?;
        let one = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        };
        let added = wgpu::BlendState { color: one, alpha: one };
        let state = format.light_pass_depth_stencil();
        let light = Drawing {
            source: LIGHT,
            entry_points: [Some("whole"), Some("one")],
            depth_stencil: Some(wgpu::DepthStencilState {
                depth_compare: Some(wgpu::CompareFunction::Always),
                ..state
            }),
            targets: &[Some(wgpu::ColorTargetState { blend: Some(added), ..COLOR.into() })],
            ..Drawing::default()
        };
        let texture = texture(world.gpu, TextureFormat::Depth32FloatStencil8);
        world.depth(&texture);
        let depth = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let light = light.pipeline(&world.gpu.device);
        let group = group(world.gpu, &light, &[wgpu::BindingResource::TextureView(&world.white)]);
        Ok(Self { volumes, light, group, depth, color: world.color() })
    }

    fn record(&self, world: &World<'_>, encoder: &mut wgpu::CommandEncoder, is_lit: bool) -> Result<(), Error> {
        for (number, &light) in world.lights.iter().enumerate() {
            let load = if number == 0 { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
            let mut pass = pass(encoder, Some((&self.color, load)), Some(&self.depth), wgpu::LoadOp::Load);
            world.frame.draw(&mut pass, &self.volumes, 0, light)?;
            if is_lit {
                pass.set_pipeline(&self.light);
                pass.set_bind_group(0, &self.group, &[]);
                pass.draw(0..3, 0..1);
            }
        }
        Ok(())
    }
}

/// A caller without one.
struct Masked {
    masks: ShadowMasks,
    light: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    target: wgpu::Texture,
    depth: wgpu::TextureView,
    color: wgpu::TextureView,
}

impl Masked {
    fn new(world: &World<'_>) -> Result<Self, Error> {
        let gpu = world.gpu;
        let masks = ShadowMasks::new(&gpu.pipelines).map_err(|error| Error::Device(error.to_string()))?;
        let target = texture(gpu, if world.lights.len() > 8 { TextureFormat::R32Uint } else { TextureFormat::R8Uint });
        let light = Drawing {
            source: LIGHT,
            entry_points: [Some("whole"), Some("all")],
            targets: &[Some(COLOR.into())],
            ..Drawing::default()
        };
        let light = light.pipeline(&gpu.device);
        let lights = gpu.buffer(wgpu::BufferUsages::STORAGE, &[world.lights.len() as u32]);
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let [white, masks_view] = [&world.white, &view].map(wgpu::BindingResource::TextureView);
        let group = group(gpu, &light, &[white, masks_view, lights.as_entire_binding()]);
        let texture = texture(gpu, TextureFormat::Depth32Float);
        world.depth(&texture);
        let depth = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self { masks, light, group, target, depth, color: world.color() })
    }

    fn record(&mut self, world: &World<'_>, encoder: &mut wgpu::CommandEncoder, is_lit: bool) -> Result<(), Error> {
        let inputs = MaskInputs { depth: &self.depth, view: 0, lights: &world.lights, target: &self.target };
        let written = world.frame.write_masks(encoder, &mut self.masks, &inputs);
        written.map_err(|error| Error::Device(error.to_string()))?;
        if !is_lit {
            return Ok(());
        }
        let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let mut pass = pass(encoder, Some((&self.color, clear)), None, wgpu::LoadOp::Load);
        pass.set_pipeline(&self.light);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }
}

fn texture(gpu: &Gpu, format: TextureFormat) -> wgpu::Texture {
    let [width, height] = SIZE;
    let copied = if format == COLOR { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::TEXTURE_BINDING };
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("bench"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | copied,
        view_formats: &[],
    })
}

fn group(gpu: &Gpu, pipeline: &wgpu::RenderPipeline, resources: &[wgpu::BindingResource<'_>]) -> wgpu::BindGroup {
    let numbered = (0..).zip(resources.iter().cloned());
    let entries: Vec<_> = numbered.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    let layout = &pipeline.get_bind_group_layout(0);
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// A pass with colour and depth, as far as they are given, and the stencil at 0.
fn pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    color: Option<(&wgpu::TextureView, wgpu::LoadOp<wgpu::Color>)>,
    depth: Option<&wgpu::TextureView>,
    load: wgpu::LoadOp<f32>,
) -> wgpu::RenderPass<'e> {
    let store = wgpu::StoreOp::Store;
    let color = color.map(|(view, load)| wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store },
    });
    let stencil = wgpu::Operations { load: wgpu::LoadOp::Clear(0), store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("bench"),
        color_attachments: if color.is_some() { std::slice::from_ref(&color) } else { &[] },
        depth_stencil_attachment: depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load, store }),
            stencil_ops: view.texture().format().has_stencil_aspect().then_some(stencil),
        }),
        ..wgpu::RenderPassDescriptor::default()
    })
}
