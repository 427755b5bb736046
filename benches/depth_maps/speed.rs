//! Detection and compaction against a kernel that loads the same texels and writes one word a cell, in turn.

use glam::DVec3;
use rimline::gpu::{DepthMap, DepthMapVolumes, StageTimer};
use rimline_measure::on_gpu::text;
use rimline_measure::pipelines::TexelKernel;

use crate::growth::eye;
use crate::scenes::{RADIUS, scene};
use crate::stage::{Bench, DETECTORS, MAP, axes, camera, map_of, medians};

/// The four texels of each cell, and a word for it.
const FLOOR: &str = "
@group(0) @binding(0) var depth_texture: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;
fn at(place: vec2<i32>) -> u32 {
  return bitcast<u32>(textureLoad(depth_texture, place, 0).x);
}
@compute @workgroup_size(256) fn floor(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let size = textureDimensions(depth_texture);
  let cell = (group.x + groups.x * group.y) * 256u + local;
  if (cell < (size.x + 1u) * (size.y + 1u)) {
    let place = vec2<i32>(vec2<u32>(cell % (size.x + 1u), cell / (size.x + 1u)));
    let last = vec2<i32>(size) - 1;
    let before = max(place - 1, vec2<i32>(0));
    let after = min(place, last);
    words[cell] = at(before) ^ at(vec2<i32>(after.x, before.y)) ^ at(vec2<i32>(before.x, after.y)) ^ at(after);
  }
}
";

const SIDE: u32 = 2048;

pub(crate) fn measure(bench: &Bench, rounds: usize, seed: u64) -> Result<(), String> {
    let map = bench.target(SIDE, MAP);
    let light = camera(axes(DVec3::new(0.4, -1.0, 0.3).normalize(), DVec3::Z), 8.0, f64::from(RADIUS), true);
    let cells = (SIDE + 1) * (SIDE + 1);
    let words = bench.gpu.storage(&vec![0_u32; cells as usize]);
    let floor = TexelKernel::new(&bench.gpu.device, ("floor", FLOOR), &map.depths, &words);
    let mut volumes = Vec::new();
    for (_, edges) in DETECTORS {
        volumes.push(bench.volumes(SIDE, edges)?);
    }
    println!("\nDetection and compaction of {SIDE}² texels, medians of {rounds} rounds in turn; seed {seed}");
    println!(
        "| scene | loads and a word a cell, ms | {} |",
        DETECTORS.map(|(name, _)| format!("{name}, ms | times")).join(" | ")
    );
    println!("|---|---:|{}", "---:|---:|".repeat(DETECTORS.len()));
    for number in [0, 1] {
        let drawn = bench.drawn(&scene(number, seed))?;
        bench.gpu.submit(|encoder| Bench::draw_map(encoder, &drawn, &map, &light))?;
        let mut times = Vec::new();
        // One more, in which shaders are compiled.
        for round in 0..=rounds {
            let mut own = [0.0; DETECTORS.len() + 1];
            own[0] = bench.clock(|encoder| {
                floor.run(encoder, [cells.div_ceil(256), 1]);
                Ok(())
            })?;
            for (time, volumes) in own[1..].iter_mut().zip(&mut volumes) {
                *time = bench.clock(|encoder| {
                    volumes.encode(encoder, &map_of(&map, light), &eye(), None).map(drop).map_err(text)
                })?;
            }
            times.extend((round > 0).then_some(own));
        }
        let medians = medians(&times);
        let own: Vec<_> = medians[1..].iter().map(|time| format!("{time:.1} | {:.2}", time / medians[0])).collect();
        println!("| {} | {:.1} | {} |", ["A", "B"][number], medians[0], own.join(" | "));
        if std::env::args().any(|argument| argument == "--stages") {
            for ((name, _), volumes) in DETECTORS.iter().zip(&mut volumes) {
                println!("{name}: {}", stages(bench, volumes, &map_of(&map, light))?);
            }
        }
    }
    Ok(())
}

/// What each stage takes, once.
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
