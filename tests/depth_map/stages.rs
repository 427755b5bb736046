//! The lists that the GPU makes against those of the twin, for each format of a map.

use rimline::gpu::{
    DanglingEdges, DepthMap, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, ShadowFormat,
};
use rimline::reference::cpu::{EdgeDetector, Samples, Second, depth_cells, depth_cells_of_objects, depth_edges};
use rimline::reference::layout::DepthMapShape;
use rimline::{DepthDirection, ShadowCamera};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::random::Random;
use rimline_measure::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::maps::{Map, detector, further, maps};
use crate::picture::pipelines;
use crate::scene::Eye;
use crate::textures::{depth_view, objects, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("lists_of_cells_equal_their_twin", lists),
    ("lists_of_a_large_map_equal_their_twin", large),
    ("lists_of_the_largest_map_equal_their_twin", largest),
    ("lists_of_objects_equal_their_twin", of_objects),
    ("lists_of_detectors_equal_their_twin", detectors),
    ("encodes_in_one_encoder_do_not_disturb_each_other", two_encodes),
];

const FORMATS: [TextureFormat; 5] = [
    TextureFormat::R32Float,
    TextureFormat::Depth32Float,
    TextureFormat::Depth24Plus,
    TextureFormat::Depth24PlusStencil8,
    TextureFormat::Depth16Unorm,
];

/// Whether a map is taken with this format: those of all sizes with floats, and with other formats those whose sides are no powers
/// of two, but for the long run. A software device compiles each shader again for each format, and for each side that is a power of two.
pub(crate) fn is_taken(map: &Map, format: TextureFormat) -> bool {
    is_long() || format == TextureFormat::R32Float || !map.size.iter().any(|side| side.is_power_of_two())
}

pub(crate) fn camera(depth: DepthDirection) -> ShadowCamera {
    let (place, forward) = (glam::DVec3::new(1.0, 2.0, 3.0), glam::DVec3::new(0.3, -1.0, 0.2));
    Eye { place, forward, near: 0.1, is_relative: true, depth, far: Some(50.0), half_width: None }.camera()
}

pub(crate) fn direction(map: &Map) -> DepthDirection {
    if map.is_reversed { DepthDirection::Reversed } else { DepthDirection::Standard }
}

fn options(threshold: f32, capacity: Option<u32>) -> DepthMapOptions {
    let edges = if threshold < 0.0 {
        DepthMapMethod::EveryCell
    } else {
        DepthMapMethod::Differences { threshold, dangling: None }
    };
    DepthMapOptions { method: edges, capacity, ..Default::default() }
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
    let bits = pipelines.bits().len();
    let mut volumes = DepthMapVolumes::new(pipelines, map.size, options(threshold, capacity)).map_err(text)?;
    let (view, light) = (depth_view(&texture), camera(direction(map)));
    gpu.submit(|encoder| {
        let map = DepthMap { texture: &view, light, objects: None };
        volumes.encode(encoder, &map, &camera(DepthDirection::Reversed), None).map(drop).map_err(text)
    })?;
    let shape = DepthMapShape { spread: u32::from(bits > 1), ..map.shape(threshold, capacity.unwrap_or(u32::MAX)) };
    let expected = depth_cells(&shape, &depths);
    let found: Vec<u32> = gpu.read(volumes.cells(), 1 + expected.entries.len())?;
    let what = format!("{format:?} {:?}, reversed {}, threshold {threshold}, {bits} bits", map.size, map.is_reversed);
    same(&what, &found, &[&[expected.count], &expected.entries[..]].concat())?;
    Ok(expected.count)
}

fn lists() -> Result<(), String> {
    const SEED: u64 = 1611;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let of_bits = [pipelines(&gpu, DepthDirection::Reversed, 7..8)?, pipelines(&gpu, DepthDirection::Reversed, 3..5)?];
    let pipelines = &of_bits[0];
    let mut random = Random::new(SEED);
    let mut listed = 0;
    for format in FORMATS {
        let maps = maps(&mut random);
        for map in maps.iter().filter(|map| is_taken(map, format)) {
            for threshold in [-1.0, 0.0, 0.125, random.between(0.0, 0.3)] {
                let capacity = (random.below(3) == 0).then(|| random.below(300) as u32);
                listed += check((&gpu, &of_bits[random.below(2)]), map, format, threshold, capacity)?;
            }
        }
    }
    println!("{listed} cells");
    // Negative control: the list of another map.
    let map = Map::new([9, 9], false, |texel| (texel % 5) as f32 / 8.0);
    let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let mut volumes = DepthMapVolumes::new(pipelines, map.size, options(0.125, None)).map_err(text)?;
    let given = DepthMap { texture: &depth_view(&texture), light: camera(DepthDirection::Reversed), objects: None };
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
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let mut random = Random::new(1612);
    let map = Map::new([1100, 601], true, |texel| {
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

/// A map of 4,096² texels, with `RIMLINE_LONG=1`; else one of 1,024².
fn largest() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::antialiased(&gpu.pipelines, &ShadowFormat::default(), 5..8).map_err(text)?;
    let side = if is_long() { 4096 } else { 1024 };
    let mut random = Random::new(1616);
    let map = Map::new([side; 2], true, |texel| {
        if random.below(99) == 0 { random.between(0.0, 1.0) } else { 0.25 + (texel % side) as f32 / 8192.0 }
    });
    for threshold in [-1.0, 0.01] {
        let listed = check((&gpu, &pipelines), &map, TextureFormat::R32Float, threshold, None)?;
        println!("{listed} cells of {side}² texels, threshold {threshold}");
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
            let given = DepthMap { texture: &depth_view(map), light: camera(depth), objects: None };
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

/// Edges of objects, alone and with differences, also where the list overflows.
fn of_objects() -> Result<(), String> {
    const SEED: u64 = 1613;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let mut random = Random::new(SEED);
    let mut added = 0;
    for threshold in [1.0, 0.1] {
        for map in maps(&mut random) {
            let capacity = (random.below(3) == 0).then(|| random.below(20) as u32);
            let numbers: Vec<_> =
                map.depths.iter().map(|_| [0, 1, u32::MAX, 1 << 24, (1 << 24) + 1][random.below(5)]).collect();
            let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
            let objects = objects(&gpu, map.size, &numbers).create_view(&wgpu::TextureViewDescriptor::default());
            let options = options(threshold, capacity);
            let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
            let (view, light) = (depth_view(&texture), camera(direction(&map)));
            gpu.submit(|encoder| {
                let map = DepthMap { texture: &view, light, objects: Some(&objects) };
                let eye = camera(DepthDirection::Reversed);
                volumes.encode(encoder, &map, &eye, None).map(drop).map_err(text)
            })?;
            let mut shape = map.shape(threshold, capacity.unwrap_or(u32::MAX));
            let without = depth_cells(&shape, &map.depths).count;
            shape.objects = 1;
            let expected = depth_cells_of_objects(&shape, &map.depths, &numbers);
            let found: Vec<u32> = gpu.read(volumes.cells(), 1 + expected.entries.len())?;
            same(&format!("{:?}", map.size), &found, &[&[expected.count], &expected.entries[..]].concat())?;
            added += expected.count - without;
        }
    }
    println!("{added} cells of edges of objects alone");
    if added > 1000 { Ok(()) } else { Err("too few".to_owned()) }
}

/// The detector of a method and a map, with some bits.
fn detector_of(method: DepthMapMethod, bits: usize, map: &Map, format: TextureFormat) -> EdgeDetector {
    let (second, thresholds, slopes, dangling) = match method {
        DepthMapMethod::SecondDifferences { low, high, dangling } => (Second::Both, [low, high], 1.0, dangling),
        DepthMapMethod::Automatic { dangling } => (Second::One, [0.0, 1.0], 2.0, dangling),
        DepthMapMethod::Differences { threshold, dangling } => (Second::Nothing, [threshold, 1.0], 1.0, dangling),
        _ => (Second::Nothing, [1.0, 1.0], 1.0, None),
    };
    let mut detector = detector(second, thresholds, slopes, dangling.map_or(1.0, |dangling| dangling.share));
    detector.cells = dangling.map_or(0, |dangling| dangling.cells);
    detector.rings = u32::from(second != Second::Nothing) + u32::from(bits > 1);
    // Four steps of the format.
    match format {
        TextureFormat::Depth16Unorm => detector.rule.noise = (4.0_f32 / 65_536.0).to_bits(),
        TextureFormat::Depth32Float | TextureFormat::R32Float if map.is_reversed => detector.rule.noise_exponents = 21,
        _ => detector.rule.noise = (4.0_f32 / 16_777_216.0).to_bits(),
    }
    detector
}

/// Detectors that mark edges first, with and without objects and continued edges, also where the list overflows.
fn detectors() -> Result<(), String> {
    const SEED: u64 = 1617;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let of_bits = [pipelines(&gpu, DepthDirection::Reversed, 7..8)?, pipelines(&gpu, DepthDirection::Reversed, 6..8)?];
    let mut random = Random::new(SEED);
    let (mut listed, mut continued) = (0, 0);
    for round in (0..20).map(|round| round % 10) {
        // Each pipeline with few formats: `is_taken`.
        let format = if round < 3 { TextureFormat::R32Float } else { FORMATS[round % FORMATS.len()] };
        let (has_objects, continues) = (round < 5, (round + round / 5) % 2 == 0);
        for map in further(&mut random).into_iter().chain(maps(&mut random)) {
            if !is_taken(&map, format) {
                continue;
            }
            let clamped = |depth: &f32| if depth.is_nan() { 0.5 } else { depth.clamp(0.0, 1.0) };
            let is_plain = format == TextureFormat::R32Float;
            let depths = if is_plain { map.depths.clone() } else { map.depths.iter().map(clamped).collect() };
            let texture = texture(&gpu, map.size, format, &depths)?;
            let depths = read(&gpu, &texture)?;
            let share = [0.5, 0.0, 0.25][random.below(3)];
            let always = Some(DanglingEdges { share, cells: [1, 2, 5, 32][random.below(4)] });
            let dangling = always.filter(|_| continues);
            let numbers: Vec<_> = depths.iter().map(|_| u32::from(random.below(9) == 0)).collect();
            let method = [
                DepthMapMethod::Automatic { dangling },
                DepthMapMethod::SecondDifferences { low: 0.001, high: 0.1, dangling },
                DepthMapMethod::SecondDifferences { low: 0.0, high: 1.0, dangling },
                DepthMapMethod::Differences { threshold: 0.02, dangling: always },
                DepthMapMethod::Differences { threshold: 1.0, dangling: always },
            ][round % 5];
            let capacity = (random.below(4) == 0).then(|| random.below(30) as u32);
            let options = DepthMapOptions { method, capacity, ..Default::default() };
            let pipelines = &of_bits[random.below(2)];
            let mut volumes = DepthMapVolumes::new(pipelines, map.size, options).map_err(text)?;
            let eye = camera(DepthDirection::Reversed);
            let objects = objects(&gpu, map.size, &numbers).create_view(&wgpu::TextureViewDescriptor::default());
            gpu.submit(|encoder| {
                let objects = has_objects.then_some(&objects);
                let map = DepthMap { texture: &depth_view(&texture), light: camera(direction(&map)), objects };
                volumes.encode(encoder, &map, &eye, None).map(drop).map_err(text)
            })?;
            let shape =
                DepthMapShape { objects: u32::from(has_objects), ..map.shape(-1.0, capacity.unwrap_or(u32::MAX)) };
            let twin = detector_of(method, pipelines.bits().len(), &map, format);
            let samples = Samples { shape: &shape, depths: &depths, objects: &numbers };
            let expected = depth_edges(&samples, &twin);
            let found: Vec<u32> = gpu.read(volumes.cells(), 1 + expected.entries.len())?;
            let what = format!("{format:?} {:?}, reversed {}, {options:?}", map.size, map.is_reversed);
            same(&what, &found, &[&[expected.count], &expected.entries[..]].concat())?;
            listed += expected.count;
            continued += expected.count - depth_edges(&samples, &EdgeDetector { cells: 0, ..twin }).count;
        }
    }
    println!("{listed} cells, {continued} of them where edges are continued");
    if listed > 50_000 && continued > 300 { Ok(()) } else { Err("too few".to_owned()) }
}
