//! The lists that the GPU makes against those of the twin, for each format of a map.

use rimline::gpu::{
    DanglingEdges, DepthEdges, DepthMap, DepthMapOptions, DepthMapPipelines, DepthMapReconstruction, DepthMapVolumes,
    ShadowFormat,
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
use crate::scene::Eye;
use crate::textures::{depth_view, objects, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("lists_of_cells_equal_their_twin", lists),
    ("lists_of_a_large_map_equal_their_twin", large),
    ("lists_of_the_largest_map_equal_their_twin", largest),
    ("lists_of_objects_equal_their_twin", of_objects),
    ("lists_of_steps_in_world_units_equal_their_twin", world),
    ("world_steps_of_a_large_map_are_all_left_to_integers", undecided),
    ("lists_of_detectors_equal_their_twin", detectors),
    ("steps_in_world_units_are_those_of_distances", distances),
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
    (bits, is_fixed): (u32, bool),
) -> Result<u32, String> {
    // A depth attachment takes finite depths from 0 to 1 alone.
    let clamped: Vec<_> =
        map.depths.iter().map(|depth| if depth.is_nan() { 0.5 } else { depth.clamp(0.0, 1.0) }).collect();
    let depths = if format == TextureFormat::R32Float { &map.depths } else { &clamped };
    let texture = texture(gpu, map.size, format, depths)?;
    let depths = read(gpu, &texture)?;
    let reconstruction = if is_fixed { DepthMapReconstruction::FixedMesh } else { DepthMapReconstruction::Triangles };
    let options = DepthMapOptions { bits, reconstruction, ..options(threshold, capacity) };
    let mut volumes = DepthMapVolumes::new(pipelines, map.size, options).map_err(text)?;
    let (view, light) = (depth_view(&texture), camera(direction(map)));
    gpu.submit(|encoder| {
        let map = DepthMap { texture: &view, light };
        volumes.encode(encoder, &map, &camera(DepthDirection::Reversed), None).map(drop).map_err(text)
    })?;
    let shape = DepthMapShape {
        spread: u32::from(bits > 1),
        whole_cells: u32::from(is_fixed),
        ..map.shape(threshold, capacity.unwrap_or(u32::MAX))
    };
    let expected = depth_cells(&shape, &depths);
    let found: Vec<u32> = gpu.read(volumes.cells(), 1 + expected.entries.len())?;
    let what = format!(
        "{format:?} {:?}, reversed {}, threshold {threshold}, {bits} bits, fixed {is_fixed}",
        map.size, map.is_reversed
    );
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
        let maps = maps(&mut random);
        for map in maps.iter().filter(|map| is_taken(map, format)) {
            for threshold in [-1.0, 0.0, 0.125, random.between(0.0, 0.3)] {
                let capacity = (random.below(3) == 0).then(|| random.below(300) as u32);
                let way = (1 + random.below(2) as u32, random.below(2) == 0);
                listed += check((&gpu, &pipelines), map, format, threshold, capacity, way)?;
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
    let map = Map::new([1100, 601], true, |texel| {
        if random.below(9) == 0 { random.between(0.0, 1.0) } else { 0.25 + (texel % 700) as f32 / 4096.0 }
    });
    for threshold in [-1.0, 0.01] {
        let listed = check((&gpu, &pipelines), &map, TextureFormat::Depth32Float, threshold, None, (1, false))?;
        if listed < 100_000 {
            return Err(format!("only {listed} cells"));
        }
    }
    Ok(())
}

/// A map of 4,096² texels, with `RIMLINE_LONG=1`; else one of 1,024².
fn largest() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let side = if is_long() { 4096 } else { 1024 };
    let mut random = Random::new(1616);
    let map = Map::new([side; 2], true, |texel| {
        if random.below(99) == 0 { random.between(0.0, 1.0) } else { 0.25 + (texel % side) as f32 / 8192.0 }
    });
    for threshold in [-1.0, 0.01] {
        let listed = check((&gpu, &pipelines), &map, TextureFormat::R32Float, threshold, None, (3, false))?;
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

/// Edges of objects, alone and with differences, also where the list overflows.
fn of_objects() -> Result<(), String> {
    const SEED: u64 = 1613;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let mut random = Random::new(SEED);
    let mut added = 0;
    for edges in [DepthEdges::Outlines, DepthEdges::Differences { threshold: 0.1 }] {
        for map in maps(&mut random) {
            let capacity = (random.below(3) == 0).then(|| random.below(20) as u32);
            let numbers: Vec<_> =
                map.depths.iter().map(|_| [0, 1, u32::MAX, 1 << 24, (1 << 24) + 1][random.below(5)]).collect();
            let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
            let objects = objects(&gpu, map.size, &numbers).create_view(&wgpu::TextureViewDescriptor::default());
            let options = DepthMapOptions { edges, objects: true, capacity, ..Default::default() };
            let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
            let (view, light) = (depth_view(&texture), camera(direction(&map)));
            gpu.submit(|encoder| {
                let map = DepthMap { texture: &view, light };
                let eye = camera(DepthDirection::Reversed);
                volumes.encode_objects(encoder, &map, &objects, &eye, None).map(drop).map_err(text)
            })?;
            let threshold = match edges {
                DepthEdges::Differences { threshold } => threshold,
                _ => 1.0,
            };
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

/// What decides about a threshold in world units, from the rows of the camera's matrix: depth differences are multiplied with the
/// first, and the second is the depth at infinity.
pub(crate) fn world_rule(light: &ShadowCamera, threshold: f64) -> [f32; 2] {
    let matrix = glam::Mat4::from_cols_array_2d(&light.view_projection).as_dmat4();
    let [depth, w] = [2, 3].map(|row| matrix.row(row).truncate());
    let infinity = depth.dot(w) / w.length_squared();
    let share = (matrix.row(2).w - infinity * matrix.row(3).w).abs() / w.length();
    [(share / threshold) as f32, infinity as f32]
}

fn world() -> Result<(), String> {
    const SEED: u64 = 1614;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let mut random = Random::new(SEED);
    let (mut listed, mut fewer) = (0, 0);
    for round in 0..8 {
        let mut all = maps(&mut random);
        // Powers of two and their neighbours meet thresholds that are powers of two exactly, where the near distance is one.
        for is_reversed in [false, true] {
            all.push(Map::new([40, 40], is_reversed, |_| {
                let power = 0.5_f32.powi(random.below(12) as i32);
                f32::from_bits(power.to_bits() + [0, 0, 0, 1, u32::MAX][random.below(5)].min(1))
            }));
        }
        // Each edge nearly meets the threshold of odd rounds: as many as one invocation can have to decide exactly.
        for is_reversed in [false, true] {
            let places = |texel: u32| texel % 67 + texel / 67;
            all.push(Map::new([67, 41], is_reversed, |texel| [0.25, 0.625][places(texel) as usize % 2]));
        }
        for map in all {
            let far = [None, Some(50.0)][random.below(2)];
            let forward = if round % 2 == 0 { glam::DVec3::X } else { glam::DVec3::new(0.3, -1.0, 0.2) };
            let place = glam::DVec3::new(1.0, 2.0, 3.0);
            let depth = direction(&map);
            let light = Eye { place, forward, near: 0.125, is_relative: true, depth, far, half_width: None }.camera();
            let mut threshold = [0.0625, 0.125, 0.5, 2.0, 64.0, random.between(0.01, 3.0)][random.below(6)];
            // One that a step of the map nearly meets, so that floats do not tell.
            let [share, infinity] = world_rule(&light, 1.0).map(f64::from);
            let steps = map.depths.windows(2).map(|pair| {
                let [a, b] = [pair[0], pair[1]].map(f64::from);
                (share * (a - b).abs() / ((a - infinity) * (b - infinity)).abs()) as f32
            });
            let steps: Vec<_> = steps.filter(|step| (0.001..100.0).contains(step)).collect();
            if round % 2 == 1 && !steps.is_empty() {
                threshold = steps[random.below(steps.len())];
            }
            // Edges that meet the same threshold are continued nowhere.
            let dangling = (round % 4 == 3).then_some(DanglingEdges { share: 1.0, cells: 1 });
            let edges = DepthEdges::WorldDifferences { threshold };
            let options = DepthMapOptions { edges, dangling, ..Default::default() };
            let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
            let texture = depth_view(&texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?);
            gpu.submit(|encoder| {
                let given = DepthMap { texture: &texture, light };
                volumes.encode(encoder, &given, &camera(DepthDirection::Reversed), None).map(drop).map_err(text)
            })?;
            let shape = map.shape(-1.0, u32::MAX);
            let samples = Samples { shape: &shape, depths: &map.depths, objects: &[] };
            let expected = depth_edges(&samples, &detector_of(&options, &map, &light, TextureFormat::R32Float));
            let found: Vec<u32> = gpu.read(volumes.cells(), 1 + expected.entries.len())?;
            let what = format!("{:?}, reversed {}, {threshold}, {far:?}", map.size, map.is_reversed);
            same(&what, &found, &[&[expected.count], &expected.entries[..]].concat())?;
            listed += expected.count;
            fewer += u32::from(expected.count < depth_cells(&map.shape(0.0, u32::MAX), &map.depths).count);
        }
    }
    println!("{listed} cells; {fewer} maps have fewer than without a threshold");
    if listed > 10_000 && fewer > 20 { Ok(()) } else { Err("too few".to_owned()) }
}

/// Floats leave every edge open. Software Vulkan ends the loops of an invocation after 65,535 turns, so invocations must not have
/// more to decide.
fn undecided() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let (size, depths) = ([1100_u32, 1000], [0.25_f32, 0.625]);
    let (place, forward) = (glam::DVec3::new(1.0, 2.0, 3.0), glam::DVec3::X);
    let light = Eye {
        place,
        forward,
        near: 0.125,
        is_relative: true,
        depth: DepthDirection::Reversed,
        far: None,
        half_width: None,
    };
    let light = light.camera();
    let map = Map::new(size, true, |texel| depths[((texel % size[0] + texel / size[0]) % 2) as usize]);
    let texture = depth_view(&texture(&gpu, size, TextureFormat::R32Float, &map.depths)?);
    let [share, infinity] = world_rule(&light, 1.0).map(f64::from);
    let [a, b] = depths.map(f64::from);
    let step = share * (a - b).abs() / ((a - infinity) * (b - infinity)).abs();
    let all = (size[0] + 1) * (size[1] + 1);
    // Cells at the border have far samples.
    let inner = (size[0] - 1) * (size[1] - 1);
    for (threshold, expected) in [(step * (1.0 - 1e-5), all), (step * (1.0 + 1e-5), all - inner)] {
        let edges = DepthEdges::WorldDifferences { threshold: threshold as f32 };
        let options = DepthMapOptions { edges, ..Default::default() };
        let mut volumes = DepthMapVolumes::new(&pipelines, size, options).map_err(text)?;
        gpu.submit(|encoder| {
            let given = DepthMap { texture: &texture, light };
            volumes.encode(encoder, &given, &camera(DepthDirection::Reversed), None).map(drop).map_err(text)
        })?;
        same(&format!("{threshold}"), &gpu.read::<u32>(volumes.cells(), 1)?, &[expected])?;
    }
    Ok(())
}

/// The detector of options and a map, for a light with this camera.
fn detector_of(options: &DepthMapOptions, map: &Map, light: &ShadowCamera, format: TextureFormat) -> EdgeDetector {
    let share = options.dangling.map_or(1.0, |dangling| dangling.share);
    let (second, thresholds, slopes) = match options.edges {
        DepthEdges::SecondDifferences { low, high } => (Second::Both, [low, high], 1.0),
        DepthEdges::Automatic => (Second::One, [0.0, 1.0], 2.0),
        DepthEdges::Differences { threshold } => (Second::Nothing, [threshold, 1.0], 1.0),
        _ => (Second::Nothing, [1.0, 1.0], 1.0),
    };
    let mut detector = detector(second, thresholds, slopes, share);
    detector.cells = options.dangling.map_or(0, |dangling| dangling.cells);
    detector.rings = u32::from(second != Second::Nothing) + u32::from(options.bits > 1);
    if let DepthEdges::WorldDifferences { threshold } = options.edges {
        let rule = |threshold: f32| world_rule(light, f64::from(threshold)).map(f32::to_bits);
        detector.rule.ratio = [threshold, threshold * share].map(|threshold| rule(threshold)[0]);
        detector.rule.at_infinity = rule(threshold)[1];
    }
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
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let mut random = Random::new(SEED);
    let (mut listed, mut continued) = (0, 0);
    for round in (0..24).map(|round| round % 12) {
        let edges = [
            DepthEdges::Automatic,
            DepthEdges::SecondDifferences { low: 0.001, high: 0.1 },
            DepthEdges::SecondDifferences { low: 0.0, high: 1.0 },
            DepthEdges::Differences { threshold: 0.02 },
            DepthEdges::WorldDifferences { threshold: 0.125 },
            DepthEdges::Outlines,
        ][round % 6];
        let is_second = matches!(edges, DepthEdges::Automatic | DepthEdges::SecondDifferences { .. });
        // Each pipeline with few formats: `is_taken`.
        let format = if round < 3 { TextureFormat::R32Float } else { FORMATS[round % FORMATS.len()] };
        let (has_objects, continues) = (round < 6, (round + round / 6) % 2 == 0);
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
            let dangling = DanglingEdges { share, cells: [1, 2, 5, 32][random.below(4)] };
            let numbers: Vec<_> = depths.iter().map(|_| u32::from(random.below(9) == 0)).collect();
            let options = DepthMapOptions {
                edges,
                objects: has_objects,
                dangling: (!is_second || continues).then_some(dangling),
                capacity: (random.below(4) == 0).then(|| random.below(30) as u32),
                bits: 1 + random.below(2) as u32,
                reconstruction: [DepthMapReconstruction::Triangles, DepthMapReconstruction::FixedMesh]
                    [(round + number) % 2],
                ..Default::default()
            };
            let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
            let eye = camera(DepthDirection::Reversed);
            let (place, forward) = (glam::DVec3::new(1.0, 2.0, 3.0), glam::DVec3::new(0.3, -1.0, 0.2));
            let (near, depth, far) = (0.125, direction(&map), [None, Some(50.0)][random.below(2)]);
            let light = Eye { place, forward, near, is_relative: true, depth, far, half_width: None }.camera();
            let objects = objects(&gpu, map.size, &numbers).create_view(&wgpu::TextureViewDescriptor::default());
            gpu.submit(|encoder| {
                let map = DepthMap { texture: &depth_view(&texture), light };
                if options.objects {
                    volumes.encode_objects(encoder, &map, &objects, &eye, None).map(drop).map_err(text)
                } else {
                    volumes.encode(encoder, &map, &eye, None).map(drop).map_err(text)
                }
            })?;
            let shape = DepthMapShape {
                objects: u32::from(options.objects),
                whole_cells: u32::from(options.reconstruction == DepthMapReconstruction::FixedMesh),
                ..map.shape(-1.0, options.capacity.unwrap_or(u32::MAX))
            };
            let twin = detector_of(&options, &map, &light, format);
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

/// Cells against the distances of unprojected samples, where rounding cannot matter; of parallel lights too.
fn distances() -> Result<(), String> {
    const SEED: u64 = 1615;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let mut random = Random::new(SEED);
    let mut seen = [0; 2];
    for _ in 0..60 {
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
        let (far, half_width) = [(None, None), (Some(40.0), None), (Some(40.0), Some(4.0))][random.below(3)];
        let forward = glam::DVec3::new(0.3, -1.0, 0.2);
        let place = glam::DVec3::new(1.0, 2.0, 3.0);
        let light =
            Eye { place, forward, near: 0.5, is_relative: random.below(2) == 0, depth, far, half_width }.camera();
        let forward = forward.normalize();
        let threshold = random.between(0.1, 2.0);
        // Two texels: a cell between them is listed with a triangle at their edge or not.
        let away = [0; 2].map(|_| f64::from(random.between(1.0, 5.0)));
        let depths = away.map(|away| crate::parity::device_depth(&light, place + away * forward));
        let map = Map::new([3, 3], depth == DepthDirection::Reversed, |texel| depths[usize::from(texel % 3 == 2)]);
        let step = (away[0] - away[1]).abs() - f64::from(threshold);
        if step.abs() < 1e-4 {
            continue;
        }
        let options =
            DepthMapOptions { edges: DepthEdges::WorldDifferences { threshold }, ..DepthMapOptions::default() };
        let mut volumes = DepthMapVolumes::new(&pipelines, [3, 3], options).map_err(text)?;
        let texture = depth_view(&texture(&gpu, [3, 3], TextureFormat::R32Float, &map.depths)?);
        gpu.submit(|encoder| {
            let given = DepthMap { texture: &texture, light };
            volumes.encode(encoder, &given, &camera(DepthDirection::Reversed), None).map(drop).map_err(text)
        })?;
        // 12 cells at the border; 2 within the first two columns, and 2 at the step.
        let found: Vec<u32> = gpu.read(volumes.cells(), 1)?;
        let expected = if step > 0.0 { 14 } else { 12 };
        same(&format!("{away:?} with {threshold}, {far:?}, {half_width:?}"), &found, &[expected])?;
        seen[usize::from(step > 0.0)] += 1;
    }
    if seen.iter().all(|&seen| seen > 10) { Ok(()) } else { Err(format!("{seen:?}")) }
}
