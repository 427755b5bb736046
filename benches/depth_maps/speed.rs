//! Detection and compaction against kernels that load the same texels and write one word a cell, in turn.

use glam::DVec3;
use rimline::gpu::{DepthMap, DepthMapVolumes, StageTimer};
use rimline_testkit::on_gpu::text;
use rimline_testkit::pipelines::TexelKernel;

use crate::growth::eye;
use crate::scenes::{RADIUS, scene};
use crate::stage::{Bench, DETECTORS, MAP, axes, camera, map_of, medians};

/// Texels of each cell, and a word for it: its own four, or the twelve that lie on its edges and beyond their ends.
const KERNEL: &str = "
@group(0) @binding(0) var depth_texture: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;
fn at(x: i32, y: i32) -> u32 {
  return bitcast<u32>(textureLoad(depth_texture, vec2<i32>(x, y), 0).x);
}
@compute @workgroup_size(256) fn kernel(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let size = textureDimensions(depth_texture);
  let cell = (group.x + groups.x * group.y) * 256u + local;
  if (cell < (size.x + 1u) * (size.y + 1u)) {
    let place = vec2<i32>(vec2<u32>(cell % (size.x + 1u), cell / (size.x + 1u)));
    let x = clamp(vec4<i32>(-2, -1, 0, 1) + place.x, vec4<i32>(0), vec4<i32>(size.xxxx) - 1);
    let y = clamp(vec4<i32>(-2, -1, 0, 1) + place.y, vec4<i32>(0), vec4<i32>(size.yyyy) - 1);
    words[cell] = at(x.y, y.y) ^ at(x.z, y.y) ^ at(x.y, y.z) ^ at(x.z, y.z)BESIDE;
  }
}
";

const BESIDE: &str = "
      ^ at(x.y, y.x) ^ at(x.z, y.x) ^ at(x.y, y.w) ^ at(x.z, y.w) ^ at(x.x, y.y) ^ at(x.x, y.z) ^ at(x.w, y.y) ^ at(x.w, y.z)";

const SIDE: u32 = 2048;

const KERNELS: usize = 2;

pub(crate) fn measure(bench: &Bench, rounds: usize, seed: u64) -> Result<(), String> {
    let map = bench.target(SIDE, MAP);
    let light = camera(axes(DVec3::new(0.4, -1.0, 0.3).normalize(), DVec3::Z), 8.0, f64::from(RADIUS), true);
    let cells = (SIDE + 1) * (SIDE + 1);
    let words = bench.gpu.storage(&vec![0_u32; cells as usize]);
    let kernels: [_; KERNELS] = ["", BESIDE].map(|beside| {
        let code = KERNEL.replace("BESIDE", beside);
        let kernel = TexelKernel::new(&bench.gpu.device, ("kernel", &code));
        let group = kernel.group(&bench.gpu.device, &map.depths, &words);
        (kernel, group)
    });
    let mut volumes = Vec::new();
    for (_, edges) in DETECTORS {
        volumes.push(bench.volumes(SIDE, edges)?);
    }
    println!("\nDetection and compaction of {SIDE}² texels, medians of {rounds} rounds in turn; seed {seed}");
    println!(
        "| scene | 4 loads and a word a cell, ms | 12 loads, ms | {} |",
        DETECTORS.map(|(name, _)| format!("{name}, ms | times 4 loads | times 12 loads")).join(" | ")
    );
    println!("|---|---:|---:|{}", "---:|---:|---:|".repeat(DETECTORS.len()));
    for number in [0, 1] {
        let drawn = bench.drawn(&scene(number, seed))?;
        bench.gpu.submit(|encoder| Bench::draw_map(encoder, &drawn, &map, &light))?;
        let mut times = Vec::new();
        // One more, in which shaders are compiled.
        for round in 0..=rounds {
            let mut own = [0.0; DETECTORS.len() + KERNELS];
            for (time, (kernel, group)) in own.iter_mut().zip(&kernels) {
                *time = bench.clock(|encoder| {
                    kernel.run(encoder, group, [cells.div_ceil(256), 1]);
                    Ok(())
                })?;
            }
            for (time, volumes) in own[KERNELS..].iter_mut().zip(&mut volumes) {
                *time = bench.clock(|encoder| {
                    volumes.encode(encoder, &map_of(&map, light), &eye(), None).map(drop).map_err(text)
                })?;
            }
            times.extend((round > 0).then_some(own));
        }
        let medians = medians(&times);
        let times = |time| format!("{time:.1} | {:.2} | {:.2}", time / medians[0], time / medians[1]);
        let own: Vec<_> = medians[KERNELS..].iter().map(times).collect();
        println!("| {} | {:.1} | {:.1} | {} |", ["A", "B"][number], medians[0], medians[1], own.join(" | "));
        if std::env::args().any(|argument| argument == "--stages") {
            for ((name, _), volumes) in DETECTORS.iter().zip(&mut volumes) {
                println!("{name}: {}", stages(bench, volumes, &map_of(&map, light))?);
            }
        }
    }
    Ok(())
}

/// Time of each stage, measured once.
fn stages(bench: &Bench, volumes: &mut DepthMapVolumes, map: &DepthMap<'_>) -> Result<String, String> {
    let (device, queue) = (&bench.gpu.device, &bench.gpu.queue);
    let mut timer = StageTimer::new(device, queue).ok_or("no timestamps")?;
    bench.gpu.submit(|encoder| {
        volumes.encode(encoder, map, &eye(), Some(&mut timer)).map_err(text)?;
        timer.resolve(encoder);
        Ok(())
    })?;
    let times = timer.read(device, queue).map_err(text)?;
    Ok(times.iter().map(|(name, time)| format!("{name} {time:.1}")).collect::<Vec<_>>().join(", "))
}
