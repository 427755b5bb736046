//! The lists that the GPU makes against those of the twin, for each format of a map.

use rimline::gpu::{DepthEdges, DepthMap, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, ShadowFormat};
use rimline::reference::cpu::depth_cells;
use rimline::{DepthDirection, ShadowCamera};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::random::Random;
use rimline_measure::{must_fail, same};
use wgpu::TextureFormat;

use crate::maps::{Map, maps};
use crate::scene::Eye;
use crate::textures::{depth_view, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("lists_of_cells_equal_their_twin", lists),
    ("lists_of_a_large_map_equal_their_twin", large),
    ("encodes_in_one_encoder_do_not_disturb_each_other", two_encodes),
];

const FORMATS: [TextureFormat; 5] = [
    TextureFormat::R32Float,
    TextureFormat::Depth32Float,
    TextureFormat::Depth24Plus,
    TextureFormat::Depth24PlusStencil8,
    TextureFormat::Depth16Unorm,
];

pub(crate) fn camera(depth: DepthDirection) -> ShadowCamera {
    let (place, forward) = (glam::DVec3::new(1.0, 2.0, 3.0), glam::DVec3::new(0.3, -1.0, 0.2));
    Eye { place, forward, near: 0.1, is_relative: true, depth, far: Some(50.0), half_width: None }.camera()
}

fn direction(map: &Map) -> DepthDirection {
    if map.is_reversed { DepthDirection::Reversed } else { DepthDirection::Standard }
}

fn options(threshold: f32, capacity: Option<u32>) -> DepthMapOptions {
    let edges = if threshold < 0.0 { DepthEdges::EveryCell } else { DepthEdges::Differences { threshold } };
    DepthMapOptions { edges, capacity, ..Default::default() }
}

/// Compares the list of a map with the twin's, of what a shader reads.
fn check(
    (gpu, pipelines): (&Gpu, &DepthMapPipelines),
    map: &Map,
    format: TextureFormat,
    threshold: f32,
    capacity: Option<u32>,
) -> Result<u32, String> {
    // A depth attachment takes finite depths from 0 to 1 alone.
    let clamped: Vec<_> =
        map.depths.iter().map(|depth| if depth.is_nan() { 0.5 } else { depth.clamp(0.0, 1.0) }).collect();
    let depths = if format == TextureFormat::R32Float { &map.depths } else { &clamped };
    let texture = texture(gpu, map.size, format, depths)?;
    let depths = read(gpu, &texture)?;
    let mut volumes = DepthMapVolumes::new(pipelines, map.size, options(threshold, capacity)).map_err(text)?;
    let (view, light) = (depth_view(&texture), camera(direction(map)));
    gpu.submit(|encoder| {
        let map = DepthMap { texture: &view, light };
        volumes.encode(encoder, &map, &camera(DepthDirection::Reversed), None).map(drop).map_err(text)
    })?;
    let expected = depth_cells(&map.shape(threshold, capacity.unwrap_or(u32::MAX)), &depths);
    let found: Vec<u32> = gpu.read(volumes.cells(), 1 + expected.entries.len())?;
    let what = format!("{format:?} {:?}, reversed {}, threshold {threshold}", map.size, map.is_reversed);
    same(&what, &found, &[&[expected.count], &expected.entries[..]].concat())?;
    Ok(expected.count)
}

fn lists() -> Result<(), String> {
    const SEED: u64 = 1611;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let mut random = Random::new(SEED);
    let mut listed = 0;
    for format in FORMATS {
        for map in maps(&mut random) {
            for threshold in [-1.0, 0.0, 0.125, random.between(0.0, 0.3)] {
                let capacity = (random.below(3) == 0).then(|| random.below(300) as u32);
                listed += check((&gpu, &pipelines), &map, format, threshold, capacity)?;
            }
        }
    }
    println!("{listed} cells");
    // Negative control: the list of another map.
    let map = Map::new([9, 9], false, |texel| (texel % 5) as f32 / 8.0);
    let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options(0.125, None)).map_err(text)?;
    let given = DepthMap { texture: &depth_view(&texture), light: camera(DepthDirection::Reversed) };
    gpu.submit(|encoder| {
        volumes.encode(encoder, &given, &camera(DepthDirection::Reversed), None).map(drop).map_err(text)
    })?;
    let expected = depth_cells(&map.shape(0.125, u32::MAX), &map.depths);
    let found: Vec<u32> = gpu.read(volumes.cells(), 1 + expected.entries.len())?;
    must_fail("the other direction", &same("cells", &found, &[&[expected.count], &expected.entries[..]].concat()))
}

/// More blocks than a scan has invocations: each takes several.
fn large() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let mut random = Random::new(1612);
    let map = Map::new([700, 401], true, |texel| {
        if random.below(9) == 0 { random.between(0.0, 1.0) } else { 0.25 + (texel % 700) as f32 / 4096.0 }
    });
    for threshold in [-1.0, 0.01] {
        let listed = check((&gpu, &pipelines), &map, TextureFormat::Depth32Float, threshold, None)?;
        if listed < 100_000 {
            return Err(format!("only {listed} cells"));
        }
    }
    Ok(())
}

/// The second encode writes after the first has been copied out.
fn two_encodes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let maps = [0.25, 0.75].map(|depth| Map::new([12, 7], false, |texel| if texel % 7 < 3 { depth } else { 1.0 }));
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 0).map_err(text)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, [12, 7], options(0.0, None)).map_err(text)?;
    let textures = [
        texture(&gpu, maps[0].size, TextureFormat::Depth32Float, &maps[0].depths)?,
        texture(&gpu, maps[1].size, TextureFormat::R32Float, &maps[1].depths)?,
    ];
    let copies = [0; 2].map(|_: u32| gpu.storage(&[0_u32; 105]));
    gpu.submit(|encoder| {
        let cells = volumes.cells().clone();
        for (number, (map, copy)) in textures.iter().zip(&copies).enumerate() {
            let depth = [DepthDirection::Standard, DepthDirection::Reversed][number];
            let given = DepthMap { texture: &depth_view(map), light: camera(depth) };
            volumes.encode(encoder, &given, &camera(DepthDirection::Reversed), None).map_err(text)?;
            encoder.copy_buffer_to_buffer(&cells, 0, copy, 0, 420);
        }
        Ok(())
    })?;
    for (number, (map, copy)) in maps.into_iter().zip(&copies).enumerate() {
        let map = Map { is_reversed: number == 1, ..map };
        let expected = depth_cells(&map.shape(0.0, u32::MAX), &map.depths);
        let found: Vec<u32> = gpu.read(copy, 1 + expected.entries.len())?;
        same(&format!("encode {number}"), &found, &[&[expected.count], &expected.entries[..]].concat())?;
    }
    Ok(())
}
