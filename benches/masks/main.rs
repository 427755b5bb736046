//! `cargo bench --bench masks`: shadow masks from depth without a stencil, against the stencil of a caller who has one.
//! Milliseconds of the GPU for what comes after the depth pass: there a pass a light, with its volumes and a draw that
//! adds light where the stencil is 0; here the masks and one draw that adds all lights. Both must give the same
//! picture. Then the same without the light. `--quick` takes fewer rounds.

use std::cell::RefCell;
use std::time::Duration;

use glam::{Affine3A, Mat4, Vec3};
use rimline::cpu::{self, Threads};
use rimline::gltf::Asset;
use rimline::gpu::{MaskInputs, SceneOptions, ShadowFormat, ShadowMasks, ShadowPipelines};
use rimline::mesh::Weld;
use rimline::{Counting, Light, Matrix3x4, ShadowCamera};
use rimline_bench::Error;
use rimline_bench::engine::{Contender, Rounds, times};
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::pipelines::{ADDED, Drawing, group};
use rimline_bench::record::{Camera, Casters, IDENTITY, Pass, SceneRecorder, Setting, Surfaces, Target, Until};
use rimline_bench::row::compare;
use rimline_bench::shapes::{self, Shape};
use wgpu::{CommandEncoder, LoadOp, TextureFormat, TextureView};

const SIZE: [u32; 2] = [1280, 720];
const COLOR: TextureFormat = TextureFormat::Rgba16Float;

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
    let (gpu, name) = Gpu::first(wgpu::Features::DEPTH32FLOAT_STENCIL8)?;
    let time = Duration::from_secs(if is_quick { 1 } else { 5 });
    println!("{name}; {} x {} pixels, Depth32Float; medians, milliseconds", SIZE[0], SIZE[1]);
    println!(
        "| scene | lights | own stencil | masks | ratio | without light, own | masks | ratio | recording, own | masks | ratio |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let (shape, title) = walker()?;
    let man = Casters::Rigid { shapes: vec![shape], placed: vec![(0, IDENTITY)] };
    for (title, casters, far) in [(&*title, man, 2.2), ("100 casters", field(), 7.0)] {
        let mut setting = setting(casters, far);
        let all = std::mem::take(&mut setting.lights);
        for lights in [1, 8, 32] {
            setting.lights = all[..lights].to_vec();
            measure(&gpu, title, &setting, Rounds { least: 3, most: 200, time })?;
        }
    }
    Ok(())
}

/// `CesiumMan` as it stands, one unit high and more; without the file a torus of as many faces.
fn walker() -> Result<(Shape, String), Error> {
    let Some(folder) = rimline_testkit::assets() else {
        return Ok((shapes::torus(68, 34, 0.6, 0.25), "torus".to_owned()));
    };
    let asset = Asset::open(folder.join("CesiumMan.glb"), Weld::Position).map_err(Error::device)?;
    let model = asset.model();
    let pose = asset.pose(None, 0.0).map_err(Error::device)?;
    let positions = cpu::deform(model, &pose, 0.0, None, Threads::all()).map_err(Error::device)?;
    Ok((Shape { positions, faces: model.geometries()[0].faces().to_vec() }, "CesiumMan".to_owned()))
}

/// Ten by ten casters of three shapes.
fn field() -> Casters {
    let matrix_of = |at: usize| -> Matrix3x4 {
        let turn = Mat4::from_rotation_y(at as f32) * Mat4::from_rotation_x(0.7 * at as f32);
        let to = Vec3::new((at % 10) as f32 - 4.5, 0.6, (at / 10) as f32 - 4.5);
        let matrix = Mat4::from(Affine3A::from_translation(to)) * turn * Mat4::from_scale(Vec3::splat(0.4));
        [0, 1, 2].map(|row| matrix.row(row).to_array())
    };
    Casters::Rigid {
        shapes: vec![shapes::torus(32, 24, 0.35, 0.15), shapes::blob(4, 0.2, 3), shapes::cube()],
        placed: (0..100).map(|at| (at % 3, matrix_of(at))).collect(),
    }
}

/// Casters in 32 lights, seen from so far.
fn setting(casters: Casters, far: f32) -> Setting {
    // Above, all around, and one in four at infinity.
    let light = |number: usize| {
        let angle = 2.4 * number as f32;
        let xyz = [4.0 * angle.cos(), 4.0, 4.0 * angle.sin()];
        if number % 4 == 3 { Light::directional(xyz) } else { Light::point(xyz) }
    };
    let eye = Vec3::new(0.3, 0.7, 1.0) * far;
    let level = Camera::level(eye, Vec3::Y * 0.5 - eye, 1.8, 0.05).shadow();
    let wide = Mat4::from_scale(Vec3::new(SIZE[1] as f32 / SIZE[0] as f32, 1.0, 1.0));
    let matrix = wide * Mat4::from_cols_array_2d(&level.view_projection);
    let camera = ShadowCamera { view_projection: matrix.to_cols_array_2d(), ..level };
    Setting { ground: Some(0.0), ..Setting::new(casters, (0..32).map(light).collect(), camera) }
}

fn measure(gpu: &Gpu, title: &str, setting: &Setting, rounds: Rounds) -> Result<(), Error> {
    let world = World::new(gpu, setting)?;
    let ways = [RefCell::new(Way::by_stencil(&world)?), RefCell::new(Way::by_masks(&world)?)];
    let (stopwatch, lights) = (Stopwatch::new(gpu), setting.lights.len());
    let record =
        |way: usize, encoder: &mut CommandEncoder, is_lit: bool| ways[way].borrow_mut().record(&world, encoder, is_lit);
    let picture = |way| gpu.pixels(&world.color, wgpu::TextureAspect::All, |encoder| record(way, encoder, true));
    if picture(0)? != picture(1)? {
        return Err(Error::device(format!("{title}, {lights} lights: the pictures differ")));
    }
    // More on a fast device, so that handing over the commands weighs little.
    let once = stopwatch.by_clock(|encoder| record(1, encoder, true))?[1];
    let repeats = (20.0 / once).clamp(1.0, 30.0) as usize;
    let by = |way: usize, is_lit: bool| -> (&str, Contender<'_>) {
        let (record, stopwatch) = (&record, &stopwatch);
        let run = move || {
            let found = stopwatch
                .by_clock(|encoder| (0..repeats).try_for_each(|_| record(way, encoder, is_lit)))?
                .map(|time| time / repeats as f64);
            Ok(times([("recording", found[0]), ("drawing", found[1])]))
        };
        ("", Box::new(run))
    };
    let entries = compare(rounds, vec![by(0, true), by(1, true), by(0, false), by(1, false)], &())?;
    let cells = [("drawing", 0), ("drawing", 2), ("recording", 0)].map(|(whole, first)| {
        let [stencil, masks] = [first, first + 1].map(|at: usize| entries[at].ms(whole));
        format!("{stencil:.3} | {masks:.3} | {:.2}", masks / stencil)
    });
    println!("| {title} | {lights} | {} |", cells.join(" | "));
    Ok(())
}

/// The parts of both ways.
struct World<'a> {
    gpu: &'a Gpu,
    /// A frame of it is drawn again and again.
    scene: SceneRecorder<'a>,
    color: TextureView,
    white: TextureView,
}

impl<'a> World<'a> {
    fn new(gpu: &'a Gpu, setting: &'a Setting) -> Result<Self, Error> {
        let mut scene = SceneRecorder::new(gpu, setting, None, SceneOptions::default())?;
        let white = gpu.texture(SIZE, TextureFormat::Rgba8Unorm);
        let mut encoder = gpu.encoder();
        scene.encode(&mut encoder, Until::Volumes(None), None)?;
        let color = Some((&white, LoadOp::Clear(wgpu::Color::WHITE)));
        drop(Target { color, ..Target::default() }.begin(&mut encoder));
        gpu.queue.submit([encoder.finish()]);
        Ok(Self { gpu, scene, color: gpu.texture(SIZE, COLOR), white })
    }

    /// The surfaces' depth.
    fn depth(&self, format: TextureFormat) -> TextureView {
        let view = self.gpu.texture(SIZE, format);
        let mut encoder = self.gpu.encoder();
        Surfaces::of(self.gpu, format, self.scene.setting, None).pass(&mut encoder, &view, Pass::Depth, None);
        self.gpu.queue.submit([encoder.finish()]);
        view
    }
}

/// A caller's way to shadows.
struct Way {
    counted: Counted,
    /// Adds a light, or all of them.
    light: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    depth: TextureView,
}

enum Counted {
    /// In a stencil.
    Stencil(ShadowPipelines),
    /// In masks, without one.
    Masks(Box<ShadowMasks>, TextureView),
}

impl Way {
    fn by_stencil(world: &World<'_>) -> Result<Self, Error> {
        let depth_stencil = TextureFormat::Depth32FloatStencil8;
        let format = ShadowFormat { depth_stencil, colors: vec![Some(COLOR)], ..ShadowFormat::default() };
        let volumes = ShadowPipelines::new(&world.gpu.pipelines, &format, Counting::Auto)?;
        let depth_compare = Some(wgpu::CompareFunction::Always);
        let light = Drawing {
            source: LIGHT,
            entry_points: [Some("whole"), Some("one")],
            depth_stencil: Some(wgpu::DepthStencilState { depth_compare, ..format.light_pass_depth_stencil() }),
            targets: &[Some(wgpu::ColorTargetState { blend: Some(ADDED), ..COLOR.into() })],
            ..Drawing::default()
        };
        let light = light.pipeline(&world.gpu.device);
        let white = [wgpu::BindingResource::TextureView(&world.white)];
        let group = group(&world.gpu.device, &light.get_bind_group_layout(0), white);
        Ok(Self { counted: Counted::Stencil(volumes), light, group, depth: world.depth(depth_stencil) })
    }

    fn by_masks(world: &World<'_>) -> Result<Self, Error> {
        let (gpu, lights) = (world.gpu, world.scene.lights.len());
        let masks = ShadowMasks::new(&gpu.pipelines).map_err(Error::device)?;
        let target = gpu.texture(SIZE, if lights > 8 { TextureFormat::R32Uint } else { TextureFormat::R8Uint });
        let entry_points = [Some("whole"), Some("all")];
        let light = Drawing { source: LIGHT, entry_points, targets: &[Some(COLOR.into())], ..Drawing::default() };
        let light = light.pipeline(&gpu.device);
        let lights = gpu.buffer(wgpu::BufferUsages::STORAGE, &[lights as u32]);
        let [white, read] = [&world.white, &target].map(wgpu::BindingResource::TextureView);
        let group = group(&gpu.device, &light.get_bind_group_layout(0), [white, read, lights.as_entire_binding()]);
        let depth = world.depth(TextureFormat::Depth32Float);
        Ok(Self { counted: Counted::Masks(Box::new(masks), target), light, group, depth })
    }

    fn record(&mut self, world: &World<'_>, encoder: &mut CommandEncoder, is_lit: bool) -> Result<(), Error> {
        let (lights, light, group) = (&world.scene.lights, &self.light, &self.group);
        let add_light = |pass: &mut wgpu::RenderPass<'_>| {
            pass.set_pipeline(light);
            pass.set_bind_group(0, group, &[]);
            pass.draw(0..3, 0..1);
        };
        let clear = LoadOp::Clear(wgpu::Color::TRANSPARENT);
        match &mut self.counted {
            Counted::Stencil(volumes) => {
                for (number, &light) in lights.iter().enumerate() {
                    let load = if number == 0 { clear } else { LoadOp::Load };
                    let target = Target::counting(&self.depth, LoadOp::Load);
                    let mut pass = Target { color: Some((&world.color, load)), ..target }.begin(encoder);
                    world.scene.frame()?.draw(&mut pass, volumes, 0, light)?;
                    if is_lit {
                        add_light(&mut pass);
                    }
                }
            }
            Counted::Masks(masks, target) => {
                let inputs = MaskInputs { depth: &self.depth, view: 0, lights, target: target.texture() };
                world.scene.frame()?.write_masks(encoder, masks, &inputs).map_err(Error::device)?;
                if is_lit {
                    let target = Target { color: Some((&world.color, clear)), ..Target::default() };
                    add_light(&mut target.begin(encoder));
                }
            }
        }
        Ok(())
    }
}
