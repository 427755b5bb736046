//! The lists that `depth_edges` and `depth_cells` make against exact arithmetic, for each format of a map.

use rimline::gpu::ShadowFormat;
use rimline::gpu::depth_map::{
    DanglingEdges, DepthMap, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes,
};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::cells::{listed, with_count};
use crate::maps::{Map, further, maps};
use crate::picture::pipelines;
use crate::rules::{Rule, Second, expected};
use crate::scene::Eye;
use crate::textures::{depth_view, objects, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("lists_of_cells_are_those_of_exact_arithmetic", lists),
    ("lists_of_large_maps_are_those_of_exact_arithmetic", large),
    ("lists_of_objects_are_those_of_exact_arithmetic", of_objects),
    ("lists_of_detectors_are_those_of_exact_arithmetic", detectors),
    ("slopes_are_left_out_and_steps_are_not", slopes),
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
fn is_taken(map: &Map, format: TextureFormat) -> bool {
    is_long() || is_short(map, format)
}

/// Whether the short run takes it.
pub(crate) fn is_short(map: &Map, format: TextureFormat) -> bool {
    format == TextureFormat::R32Float || !map.size.iter().any(|side| side.is_power_of_two())
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

/// Compares the list of a map with that of exact arithmetic, of what a shader reads. Tells how many cells there are.
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
        volumes.encode(encoder, &map, &camera(DepthDirection::Reversed)).map(drop).map_err(text)
    })?;
    let read = Map { depths, ..map.clone() };
    let expected = listed(&read, &[], threshold, bits > 1, capacity);
    let found: Vec<u32> = gpu.read(volumes.cells(), expected.len())?;
    let what = format!("{format:?} {:?}, reversed {}, threshold {threshold}, {bits} bits", map.size, map.is_reversed);
    same(&what, &found, &expected)?;
    // Negative control: a triangle is drawn that is not, or the other way round.
    let mut other = found;
    if let Some(entry) = other[1..].last_mut() {
        *entry ^= 1 << 31;
        must_fail("another triangle", &same(&what, &other, &expected))?;
    }
    Ok(expected[0])
}

fn lists() -> Result<(), String> {
    const SEED: u64 = 1611;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let of_bits = [pipelines(&gpu, DepthDirection::Reversed, 7..8)?, pipelines(&gpu, DepthDirection::Reversed, 3..5)?];
    let pipelines = &of_bits[0];
    let mut random = Random::new(SEED);
    let mut cells = 0;
    for format in FORMATS {
        let maps = maps(&mut random);
        for map in maps.iter().filter(|map| is_taken(map, format)) {
            // Every cell, none, two thresholds, and one that the difference of two depths meets exactly.
            let met = met(&mut random, map);
            for threshold in [-1.0, 0.0, 0.125, random.between(0.0, 0.3), met] {
                let capacity = (random.below(3) == 0).then(|| random.below(300) as u32);
                cells += check((&gpu, &of_bits[random.below(2)]), map, format, threshold, capacity)?;
            }
        }
    }
    println!("{cells} cells");
    // Negative control: the list of another map.
    let map = Map::new([9, 9], false, |texel| (texel % 5) as f32 / 8.0);
    let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let mut volumes = DepthMapVolumes::new(pipelines, map.size, options(0.125, None)).map_err(text)?;
    let given = DepthMap { texture: &depth_view(&texture), light: camera(DepthDirection::Reversed), objects: None };
    gpu.submit(|encoder| volumes.encode(encoder, &given, &camera(DepthDirection::Reversed)).map(drop).map_err(text))?;
    let expected = listed(&map, &[], 0.125, false, None);
    let found: Vec<u32> = gpu.read(volumes.cells(), expected.len())?;
    must_fail("the other direction", &same("cells", &found, &expected))
}

/// The difference of two depths of a map, if it is a threshold.
fn met(random: &mut Random, map: &Map) -> f32 {
    let [a, b] = [0, 1].map(|_| map.depths[random.below(map.depths.len())]);
    let met = (a - b).abs();
    if (0.0..=1.0).contains(&met) && met >= f32::MIN_POSITIVE { met } else { 0.125 }
}

/// More blocks than a scan has invocations: each takes several. With `RIMLINE_LONG=1` a map of 4,096² texels, too.
fn large() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let [one, three] = [7..8, 5..8].map(|bits| pipelines(&gpu, DepthDirection::Reversed, bits));
    let (one, three) = (one?, three?);
    let mut random = Random::new(1612);
    let mut ways = vec![
        ([1100, 601], TextureFormat::Depth32Float, &one, 9, 4096.0),
        ([640, 820], TextureFormat::R32Float, &three, 99, 8192.0),
    ];
    if is_long() {
        ways.push(([4096; 2], TextureFormat::R32Float, &three, 99, 8192.0));
    }
    for (size, format, pipelines, rare, steps) in ways {
        let map = Map::new(size, true, |texel| {
            let is_other = random.below(rare) == 0;
            if is_other { random.between(0.0, 1.0) } else { 0.25 + (texel % size[0] % 700) as f32 / steps }
        });
        for threshold in [-1.0, 0.01] {
            let listed = check((&gpu, pipelines), &map, format, threshold, None)?;
            println!("{listed} cells of {size:?} texels, threshold {threshold}");
            if listed < 20_000 {
                return Err(format!("only {listed} cells"));
            }
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
            let given = DepthMap { texture: &depth_view(map), light: camera(depth), objects: None };
            volumes.encode(encoder, &given, &camera(DepthDirection::Reversed)).map_err(text)?;
            encoder.copy_buffer_to_buffer(&cells, 0, copy, 0, 420);
        }
        Ok(())
    })?;
    let [first, second] = maps;
    let second = Map { is_reversed: true, ..second };
    let expected = [first, second].map(|map| listed(&map, &[], 0.0, false, None));
    for (number, copy) in copies.iter().enumerate() {
        let found: Vec<u32> = gpu.read(copy, expected[number].len())?;
        same(&format!("encode {number}"), &found, &expected[number])?;
        must_fail("the other encode", &same("cells", &found, &expected[1 - number]))?;
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
    let (mut added, mut noticed) = (0, 0);
    for threshold in [1.0, 0.1] {
        for map in maps(&mut random) {
            let capacity = (random.below(3) == 0).then(|| random.below(20) as u32);
            let mut numbers: Vec<_> =
                map.depths.iter().map(|_| [0, 1, u32::MAX, 1 << 24, (1 << 24) + 1][random.below(5)]).collect();
            let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
            let objects = objects(&gpu, map.size, &numbers).create_view(&wgpu::TextureViewDescriptor::default());
            let options = options(threshold, capacity);
            let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
            let (view, light) = (depth_view(&texture), camera(direction(&map)));
            gpu.submit(|encoder| {
                let map = DepthMap { texture: &view, light, objects: Some(&objects) };
                let eye = camera(DepthDirection::Reversed);
                volumes.encode(encoder, &map, &eye).map(drop).map_err(text)
            })?;
            let without = listed(&map, &[], threshold, false, None);
            let expected = listed(&map, &numbers, threshold, false, capacity);
            let found: Vec<u32> = gpu.read(volumes.cells(), expected.len())?;
            same(&format!("{:?}", map.size), &found, &expected)?;
            added += expected[0] - without[0];
            // Negative control: a texel has the object of the next one.
            let at = random.below(numbers.len());
            numbers[at] = numbers[(at + 1) % numbers.len()];
            noticed += u32::from(found != listed(&map, &numbers, threshold, false, capacity));
        }
    }
    println!("{added} cells of edges of objects alone, {noticed} other objects noticed");
    if added > 1000 && noticed > 5 { Ok(()) } else { Err("too few".to_owned()) }
}

/// The rule of a method and a map, with some bits.
pub(crate) fn rule_of(method: DepthMapMethod, bits: usize, is_reversed: bool, format: TextureFormat) -> Rule {
    let (second, [low, high], slopes, dangling) = match method {
        DepthMapMethod::SecondDifferences { low, high, dangling } => (Second::Both, [low, high], 1.0, dangling),
        DepthMapMethod::Automatic { dangling } => (Second::One, [0.0, 1.0], 2.0, dangling),
        DepthMapMethod::Differences { threshold, dangling } => (Second::Nothing, [threshold, 1.0], 1.0, dangling),
        _ => (Second::Nothing, [1.0, 1.0], 1.0, None),
    };
    let share = dangling.map_or(1.0, |dangling| dangling.share);
    // Subnormal numbers are none to the shaders.
    let normal = |value: f32| if value < f32::MIN_POSITIVE { 0.0 } else { value };
    // Four steps of the format.
    let (noise, noise_exponents) = match format {
        TextureFormat::Depth16Unorm => (4.0 / 65_536.0, 0),
        TextureFormat::Depth32Float | TextureFormat::R32Float if is_reversed => (0.0, 21),
        _ => (4.0 / 16_777_216.0, 0),
    };
    Rule {
        second,
        low: [low, low * share].map(normal),
        high: normal(high),
        slopes: [slopes, slopes * share].map(normal),
        noise,
        noise_exponents,
        cells: dangling.map_or(0, |dangling| dangling.cells),
        rings: u32::from(second != Second::Nothing) + u32::from(bits > 1),
    }
}

/// Detectors that mark edges first, with and without objects and continued edges, also where the list overflows.
fn detectors() -> Result<(), String> {
    const SEED: u64 = 1617;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let of_bits = [pipelines(&gpu, DepthDirection::Reversed, 7..8)?, pipelines(&gpu, DepthDirection::Reversed, 6..8)?];
    let mut random = Random::new(SEED);
    let (mut cells, mut continued, mut noticed) = (0, 0, [0; 4]);
    for round in (0..if is_long() { 20 } else { 10 }).map(|round| round % 10) {
        // Each pipeline with few formats: `is_taken`.
        let format = if round < 3 { TextureFormat::R32Float } else { FORMATS[round % FORMATS.len()] };
        let (has_objects, continues) = (round < 5, (round + round / 5) % 2 == 0);
        for (number, map) in further(&mut random).into_iter().chain(maps(&mut random)).enumerate() {
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
            let met = met(&mut random, &map);
            let low = [0.001, met][random.below(2)];
            let method = [
                DepthMapMethod::Automatic { dangling },
                DepthMapMethod::SecondDifferences { low, high: 0.1_f32.max(low), dangling },
                DepthMapMethod::SecondDifferences { low: 0.0, high: [1.0, met][random.below(2)], dangling },
                DepthMapMethod::Differences { threshold: [0.02, met][random.below(2)], dangling: always },
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
                volumes.encode(encoder, &map, &eye).map(drop).map_err(text)
            })?;
            let read = Map { depths, ..map };
            let given = if has_objects { &numbers[..] } else { &[] };
            let rule = rule_of(method, pipelines.bits().len(), read.is_reversed, format);
            let (entries, further) = expected(&read, given, &rule);
            let expected = with_count(entries, capacity);
            let found: Vec<u32> = gpu.read(volumes.cells(), expected.len())?;
            let what = format!("{format:?} {:?}, reversed {}, {options:?}", read.size, read.is_reversed);
            same(&what, &found, &expected)?;
            cells += expected[0];
            continued += further;
            // Negative control: another rule.
            let others = [
                Rule { cells: rule.cells / 2, ..rule },
                Rule { rings: rule.rings + 1, ..rule },
                Rule { low: rule.low.map(|low| low + 0.01), ..rule },
                Rule { slopes: rule.slopes.map(|slopes| slopes + 1.0), ..rule },
            ];
            for (noticed, other) in noticed.iter_mut().zip(&others).filter(|_| number == 2) {
                *noticed += u32::from(found != with_count(self::expected(&read, given, other).0, capacity));
            }
        }
    }
    println!("{cells} cells, {continued} edges are continued, {noticed:?} other rules noticed");
    if cells > 50_000 && continued > 300 && !noticed.contains(&0) { Ok(()) } else { Err("too few".to_owned()) }
}

/// The purpose of the rules: a slope has no edges within it, and a step on it has.
fn slopes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let flat = |texel: u32| 0.25 + (texel % 20) as f32 / 64.0;
    // From the middle on, farther away by as much as the slope has in two texels.
    let step = |texel: u32| flat(texel) + if texel % 20 > 9 { 0.03125 } else { 0.0 };
    let count = |depth: &dyn Fn(u32) -> f32, method| {
        let map = Map::new([20, 20], false, depth);
        let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
        let options = DepthMapOptions { method, ..Default::default() };
        let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
        let (view, light) = (depth_view(&texture), camera(direction(&map)));
        gpu.submit(|encoder| {
            let map = DepthMap { texture: &view, light, objects: None };
            volumes.encode(encoder, &map, &camera(DepthDirection::Reversed)).map(drop).map_err(text)
        })?;
        Ok::<_, String>(gpu.read::<u32>(volumes.cells(), 1)?[0])
    };
    // `Automatic` marks two columns more, where one difference beside an edge is not known.
    for (method, further) in [
        (DepthMapMethod::SecondDifferences { low: 0.001, high: 1.0, dangling: None }, 0),
        (DepthMapMethod::Automatic { dangling: None }, 2 * 17),
    ] {
        // The cells at the border, and those next to them, since triangles are drawn at the ends of marked edges. So are the cells on
        // both sides of the step, in the 17 rows between.
        let border = 4 * 20 + 4 * 18;
        let found = [count(&flat, method)?, count(&step, method)?];
        println!("{found:?} cells of the slope and the step, {method:?}");
        if found != [border + further, border + further + 3 * 17] {
            return Err(format!("{method:?}: {found:?}"));
        }
    }
    let all = count(&flat, DepthMapMethod::Differences { threshold: 0.001, dangling: None })?;
    if all > 300 { Ok(()) } else { Err(format!("differences list {all} cells of the slope")) }
}
