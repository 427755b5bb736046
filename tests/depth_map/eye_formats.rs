//! Eyes whose depth buffers have floats or several samples a pixel, and maps with a stencil beside their floats: the stencil of
//! each sample against the crossings of its own ray.

use glam::DVec2;
use rimline::DepthDirection;
use rimline::gpu::ShadowFormat;
use rimline::gpu::depth_map::{DepthMap, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::boundary::Boundary;
use crate::maps::Map;
use crate::parity::{SIDE, device_depth, light, map, seen, seen_depths, vector};
use crate::scene::{CENTRE, Eye, Rays, SAMPLES};
use crate::textures::{depth_view, read, sampled, texture};

pub(crate) const TESTS: &[Test] = &[
    ("parity_of_each_sample_is_that_of_its_ray", samples),
    ("maps_with_floats_and_a_stencil_equal_those_without", maps),
];

/// Stencils of a picture as words: texels row by row, samples in turn.
const STENCILS: &str = "
@group(0) @binding(0) var stencil: texture_2d<u32>;
@group(0) @binding(1) var<storage, read_write> found: array<u32>;
@compute @workgroup_size(64) fn stencils(@builtin(global_invocation_id) id: vec3<u32>) {
  let size = textureDimensions(stencil);
  let samples = 1u;
  if (id.x < size.x * size.y * samples) {
    let texel = id.x / samples;
    found[id.x] = textureLoad(stencil, vec2<u32>(texel % size.x, texel / size.x), id.x % samples).x;
  }
}
";

fn stencils(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<u32>, String> {
    let samples = texture.sample_count();
    let source = if samples == 1 {
        STENCILS.to_owned()
    } else {
        STENCILS
            .replace("texture_2d", "texture_multisampled_2d")
            .replace("samples = 1u", &format!("samples = {samples}u"))
    };
    let device = &gpu.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("stencils"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("stencils"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let view = texture
        .create_view(&wgpu::TextureViewDescriptor { aspect: wgpu::TextureAspect::StencilOnly, ..Default::default() });
    let count = texture.width() * texture.height() * samples;
    let found = gpu.storage(&vec![0_u32; count as usize]);
    let entries = [
        wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
        wgpu::BindGroupEntry { binding: 1, resource: found.as_entire_binding() },
    ];
    let layout = &pipeline.get_bind_group_layout(0);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(count.div_ceil(64), 1, 1);
        Ok(())
    })?;
    gpu.read(&found, count as usize)
}

/// Pipelines that were made for targets and directions of depth.
#[derive(Default)]
pub(crate) struct Made(Vec<DepthMapPipelines>);

impl Made {
    fn get(
        &mut self,
        gpu: &Gpu,
        (depth_stencil, samples): (TextureFormat, u32),
        depth: DepthDirection,
    ) -> Result<&DepthMapPipelines, String> {
        let format = ShadowFormat { depth_stencil, depth, samples, ..Default::default() };
        if !self.0.iter().any(|own| *own.format() == format) {
            self.0.push(DepthMapPipelines::new(&gpu.pipelines, &format, 0).map_err(text)?);
        }
        self.0.iter().find(|own| *own.format() == format).ok_or_else(|| "no pipelines".to_owned())
    }
}

/// The stencils of a target with the depths of its samples, after the volumes of a map.
pub(crate) fn drawn(
    gpu: &Gpu,
    pipelines: &mut Made,
    (format, samples): (TextureFormat, u32),
    depths: &[f32],
    (map, eye): (&DepthMap<'_>, &rimline::ShadowCamera),
    options: DepthMapOptions,
) -> Result<Vec<u32>, String> {
    let pipelines = pipelines.get(gpu, (format, samples), eye.depth)?;
    let size = [map.texture.texture().width(), map.texture.texture().height()];
    let mut volumes = DepthMapVolumes::new(pipelines, size, options).map_err(text)?;
    let target = sampled(gpu, [SIDE; 2], (format, samples), depths)?;
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    gpu.submit(|encoder| {
        let frame = volumes.encode(encoder, map, eye).map_err(text)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("volumes"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: None,
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
            }),
            ..Default::default()
        });
        frame.draw(&mut pass, pipelines).map_err(text)
    })?;
    stencils(gpu, &target)
}

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    dark: usize,
    lit: usize,
    near_borders: usize,
    wrong: usize,
    /// Samples that the stencil of the next sample is wrong for.
    others: usize,
}

/// Places within a twentieth of a pixel of a ray's, and depths that are nearer and farther by little.
pub(crate) const AROUND: [(f64, f64, f64); 6] = [
    (0.0, 0.0, 1.0),
    (0.0, 0.0, 1.003),
    (0.06, 0.05, 0.997),
    (-0.06, 0.05, 1.003),
    (0.05, -0.06, 1.003),
    (-0.05, -0.06, 0.997),
];

pub(crate) fn device() -> Result<Gpu, String> {
    Gpu::with(wgpu::Features::DEPTH32FLOAT_STENCIL8, wgpu::Limits::default())
}

/// Lights, maps and eyes of all kinds. Half of the near rectangles cut the boundary.
fn samples() -> Result<(), String> {
    const SEED: u64 = 16_601;
    println!("seed {SEED}");
    let gpu = device()?;
    let mut random = Random::new(SEED);
    let targets = [
        (TextureFormat::Depth32FloatStencil8, 1),
        (TextureFormat::Depth32FloatStencil8, 4),
        (TextureFormat::Depth24PlusStencil8, 4),
    ];
    let mut tallies = [Tally::default(); 3];
    let mut pipelines = Made::default();
    for round in 0..if is_long() { 120 } else { 12 } {
        let (camera, at) = light(&mut random);
        let map = map(&mut random, &camera);
        let place = f64::from(random.between(0.5, 9.0)) * vector(&mut random);
        let forward = vector(&mut random) * 3.0 - place;
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
        let (far, half_width) = [(None, None), (Some(60.0), None), (Some(60.0), Some(6.0))][random.below(3)];
        let near = f64::from(if round % 2 == 0 { random.between(0.05, 0.2) } else { random.between(0.5, 6.0) });
        let eye = Eye { place, forward, near, is_relative: random.below(2) == 0, depth, far, half_width }.camera();
        let rays = Rays::new(&eye, SIDE);
        let seen = seen(&mut random, &rays);
        let boundary = Boundary::new(&map, &camera, at, -1.0);
        let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
        let given = DepthMap { texture: &depth_view(&texture), light: camera, objects: None };
        let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
        for (tally, target) in tallies.iter_mut().zip(targets) {
            let within = if target.1 == 1 { &[CENTRE][..] } else { &SAMPLES };
            let places = (0..SIDE * SIDE).flat_map(|pixel| {
                let corner = DVec2::new(f64::from(pixel % SIDE), f64::from(pixel / SIDE));
                within.iter().map(move |&place| corner + place)
            });
            let places: Vec<_> = places.collect();
            let depths: Vec<_> = places.iter().map(|&place| device_depth(&eye, seen(place).1)).collect();
            let found = drawn(&gpu, &mut pipelines, target, &depths, (&given, &eye), options)?;
            for (number, &place) in places.iter().enumerate() {
                // In the short run, a seventh of the pixels.
                if !is_long() && target.1 > 1 && (number / 4) % 7 != round % 7 {
                    continue;
                }
                let truth = |(x, y, share): (f64, f64, f64)| {
                    let (near, place) = seen(place + DVec2::new(x, y));
                    let place = near + share * (place - near);
                    (boundary.parity(near, place), boundary.is_dark(place), boundary.is_dark(near))
                };
                // At the border of the near cap, rounding moves it against the clipped triangle.
                let truths = AROUND.map(truth);
                if truths.iter().any(|truth| truth.0 != truth.1 || truth != &truths[0]) {
                    tally.near_borders += 1;
                    continue;
                }
                *(if truths[0].0 { &mut tally.dark } else { &mut tally.lit }) += 1;
                tally.wrong += usize::from((found[number] != 0) != truths[0].0);
                let next = number - number % within.len() + (number + 2) % within.len();
                tally.others += usize::from((found[next] != 0) != truths[0].0);
            }
        }
    }
    for (tally, target) in tallies.iter().zip(targets) {
        println!("{target:?}: {tally:?}");
        let is_told_apart = target.1 == 1 || tally.others > 50;
        if tally.wrong > 0 || tally.dark < 1000 || tally.lit < 2000 || !is_told_apart {
            return Err(format!("{target:?}: {tally:?}"));
        }
    }
    Ok(())
}

/// Pictures of a map of `Depth32FloatStencil8` and of one of `Depth32Float` with the same depths, by triangles and by walls.
fn maps() -> Result<(), String> {
    const SEED: u64 = 16_602;
    println!("seed {SEED}");
    let gpu = device()?;
    let mut random = Random::new(SEED);
    let (mut dark, mut other, mut pipelines) = (0, 0, Made::default());
    for round in 0..6 {
        let (camera, _) = light(&mut random);
        let map = map(&mut random, &camera);
        let clamped = |depth: &f32| if depth.is_nan() { 0.5 } else { depth.clamp(0.0, 1.0) };
        let map = Map { depths: map.depths.iter().map(clamped).collect(), ..map };
        let place = f64::from(random.between(3.0, 9.0)) * vector(&mut random);
        let eye = Eye {
            place,
            forward: vector(&mut random) * 3.0 - place,
            near: 0.1,
            is_relative: true,
            depth: DepthDirection::Reversed,
            far: None,
            half_width: None,
        };
        let eye = eye.camera();
        let rays = Rays::new(&eye, SIDE);
        let seen = seen(&mut random, &rays);
        let depths = seen_depths(&eye, SIDE, &seen);
        let method = [
            DepthMapMethod::EveryCell,
            DepthMapMethod::Automatic { dangling: None },
            DepthMapMethod::Contours { threshold: 0.005, sideways: 0.25, depth: 0.02 },
        ][round % 3];
        let options = DepthMapOptions { method, ..Default::default() };
        let mut picture = |format: TextureFormat, map: &Map| {
            let texture = texture(&gpu, map.size, format, &map.depths)?;
            let given = DepthMap { texture: &depth_view(&texture), light: camera, objects: None };
            let target = (TextureFormat::Depth32FloatStencil8, 1);
            Ok::<_, String>((
                read(&gpu, &texture)?,
                drawn(&gpu, &mut pipelines, target, &depths, (&given, &eye), options)?,
            ))
        };
        let plain = picture(TextureFormat::Depth32Float, &map)?;
        let beside = picture(TextureFormat::Depth32FloatStencil8, &map)?;
        rimline_testkit::same("depths", &beside.0, &plain.0)?;
        rimline_testkit::same(&format!("round {round}, {method:?}"), &beside.1, &plain.1)?;
        dark += plain.1.iter().filter(|&&value| value != 0).count();
        // Negative control: the map upside down.
        let turned = Map { depths: map.depths.iter().rev().copied().collect(), ..map.clone() };
        other += usize::from(picture(TextureFormat::Depth32FloatStencil8, &turned)?.1 != plain.1);
    }
    println!("{dark} dark pixels; {other} maps upside down are noticed");
    if dark > 500 && other > 2 { Ok(()) } else { Err(format!("{dark}, {other}")) }
}
