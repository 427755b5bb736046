//! The lists that `depth_edges` and `depth_cells` make against exact arithmetic, for each format of a map, and what
//! statistics and arguments of draws agree with them.

use std::ops::Range;

use glam::DVec3;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod, DepthMapOptions, DepthMapStatistics};
use rimline::internals::depth_map::DepthMapNearCap;
use rimline::internals::stages::DEPTH_CELLS;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::probe::Probe;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::maps::{Map, further, maps};
use crate::picture::{AUTOMATIC, EVERY_CELL, Encoded, Maps, REVERSED, Volumes, by, differences, look, pipelines};
use crate::rules::{Rule, exact, exceeds, listed};
use rimline_testkit::frames::Eye;
use rimline_testkit::textures::{objects, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("lists_of_cells_are_those_of_exact_arithmetic", lists),
    ("lists_of_large_maps_are_those_of_exact_arithmetic", large),
    ("slopes_are_left_out_and_steps_are_not", slopes),
    ("encodes_in_one_encoder_do_not_disturb_each_other", two_encodes),
    ("differences_are_compared_exactly", compared),
];

const FORMATS: [TextureFormat; 6] = [
    TextureFormat::R32Float,
    TextureFormat::Depth32Float,
    TextureFormat::Depth24Plus,
    TextureFormat::Depth24PlusStencil8,
    TextureFormat::Depth16Unorm,
    TextureFormat::Depth32FloatStencil8,
];

/// Whether the short run takes a map with this format: those of all sizes with floats, and with other formats those
/// whose sides are no powers of two. A software device compiles each shader again for each format, and for each side
/// that is a power of two.
pub(crate) fn is_short(map: &Map, format: TextureFormat) -> bool {
    format == TextureFormat::R32Float || !map.size.iter().any(|side| side.is_power_of_two())
}

pub(crate) fn camera(depth: DepthDirection) -> ShadowCamera {
    let (position, forward) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.3, -1.0, 0.2));
    Eye { depth, far: Some(50.0), ..look(position, forward, 0.1) }.camera()
}

/// A map that is listed.
struct Case<'a> {
    map: &'a Map,
    format: TextureFormat,
    options: DepthMapOptions,
    bits: Range<u32>,
    objects: &'a [u32],
}

/// A list that is right, of the depths that a shader reads.
struct Listed {
    read: Map,
    rule: Rule,
    list: Vec<u32>,
    continued: usize,
    encoded: Encoded,
}

impl Case<'_> {
    /// Compares the list with that of exact arithmetic, and its statistics.
    fn check(&self, gpu: &Gpu, eye: &ShadowCamera) -> Result<Listed, String> {
        let Self { map, format, options, ref bits, objects: numbers } = *self;
        let texture = texture(gpu, map.size, format, &map.for_format(format).depths)?;
        let read = Map { depths: read(gpu, &texture)?, ..*map };
        let mut maps = Maps::one(&texture, camera(map.direction()));
        if !numbers.is_empty() {
            maps.objects = vec![Some(objects(gpu, map.size, numbers))];
        }
        let encoded = Encoded::new(gpu, &*pipelines(gpu, eye.depth, bits.clone())?, &maps, eye, options)?;
        let found = encoded.statistics;
        let rule = Rule::new(options.method, bits.len(), map.is_reversed, format);
        let (expected, continued) = listed(&read, numbers, &rule, Some(found.capacity));
        let list = encoded.list(gpu)?;
        let what = format!("{format:?} {:?}, reversed {}, {options:?}, {bits:?}", map.size, map.is_reversed);
        same(&what, &list, &expected)?;
        let cells = (map.size[0] + 1) * (map.size[1] + 1);
        let capacity = options.capacity.map_or(found.capacity, |capacity| capacity.min(cells));
        let near_cap_vertices = match encoded.frame.near_cap() {
            DepthMapNearCap::Skipped => 0,
            DepthMapNearCap::Indirect(draw) => gpu.read::<u32>(draw, 1)?[0],
            DepthMapNearCap::Drawn => 3,
        };
        let statistics = DepthMapStatistics { found: expected[0], capacity, near_cap_vertices, unused: 0 };
        same(&format!("{what}: statistics"), &[found], &[statistics])?;
        let arguments: Vec<u32> = gpu.read(encoded.frame.draw_arguments(), usize::MAX)?;
        let drawn = if found.is_overflowed() { cells } else { expected[0] };
        same(&format!("{what}: arguments"), &arguments, &[6 * drawn, 1, 0, 0])?;
        Ok(Listed { read, rule, list, continued, encoded })
    }
}

/// Maps of all formats by all methods, with and without objects, room, several bits and continued edges.
fn lists() -> Result<(), String> {
    const SEED: u64 = 1611;
    println!("seed {SEED}");
    let gpu = Gpu::shared_with_depth_features()?;
    let mut random = Random::new(SEED);
    let (mut cells, mut continued, mut overflowed, mut caps, mut noticed) = (0, 0, [0; 2], [0; 3], [0; 6]);
    for (of_format, format) in FORMATS.into_iter().enumerate() {
        for (number, map) in further(&mut random).into_iter().chain(maps(&mut random)).enumerate() {
            if !is_long() && !is_short(&map, format) {
                continue;
            }
            let (met, share) = (met(&mut random, &map), [0.5, 0.0, 0.25][random.below(3)]);
            let always = Some(DanglingEdges { share, cells: [1, 2, 5, 32][random.below(4)] });
            let dangling = always.filter(|_| random.below(2) == 0);
            let low = [0.001, met][random.below(2)];
            let methods = [
                EVERY_CELL,
                differences([0.0, 0.125, 0.1, 1.0][random.below(4)]),
                differences(met),
                DepthMapMethod::Differences { threshold: [0.02, met, 1.0][random.below(3)], dangling: always },
                DepthMapMethod::Automatic { dangling },
                DepthMapMethod::SecondDifferences { low, high: 0.1_f32.max(low), dangling },
                DepthMapMethod::SecondDifferences { low: 0.0, high: [1.0, met][random.below(2)], dangling },
            ];
            for (kind, method) in methods.into_iter().enumerate() {
                // Each pipeline with few formats: `is_short`.
                if !is_long() && kind > 2 && of_format > 0 && (kind + of_format) % 3 != 0 {
                    continue;
                }
                let numbers: Vec<_> = map
                    .depths
                    .iter()
                    .map(|_| [0, 0, 0, 0, 1, u32::MAX, 1 << 24, (1 << 24) + 1][random.below(8)])
                    .collect();
                let objects = if of_format == 0 && random.below(2) == 0 { &numbers[..] } else { &[] };
                let capacity = (random.below(4) == 0).then(|| random.below(60) as u32);
                let options = DepthMapOptions { capacity, skip_near_caps: random.below(3) > 0, ..by(method) };
                let bits = [7..8, 3..5][random.below(2)].clone();
                // An eye beside the light, and one where it looks at.
                let mut eye = camera(REVERSED);
                eye.origin[1] += [8.0, -1.0][random.below(2)];
                let found = Case { map: &map, format, options, bits, objects }.check(&gpu, &eye)?;
                cells += found.list[0];
                continued += found.continued;
                overflowed[usize::from(found.encoded.statistics.is_overflowed())] += 1;
                caps[found.encoded.cap_kind()] += 1;
                // Negative controls: other rules, the other direction, and each texel has the object of the next one.
                let (rule, mut rotated) = (found.rule, objects.to_vec());
                rotated.rotate_left(usize::from(!objects.is_empty()));
                let reversed = Map { is_reversed: !map.is_reversed, ..found.read.clone() };
                let others = [
                    (Rule { cells: rule.cells / 2, ..rule }, &found.read, objects),
                    (Rule { rings: rule.rings + 1, ..rule }, &found.read, objects),
                    (Rule { low: rule.low.map(|low| low + 0.01), ..rule }, &found.read, objects),
                    (Rule { slopes: rule.slopes.map(|slopes| slopes + 1.0), ..rule }, &found.read, objects),
                    (rule, &reversed, objects),
                    (rule, &found.read, &rotated[..]),
                ];
                for (noticed, (rule, map, objects)) in noticed.iter_mut().zip(&others).filter(|_| number == 2) {
                    let other = listed(map, objects, rule, Some(found.encoded.statistics.capacity));
                    *noticed += u32::from(found.list != other.0);
                }
            }
        }
    }
    println!(
        "{cells} cells, {continued} edges are continued, {noticed:?} of other rules, direction and objects noticed"
    );
    println!("{overflowed:?} lists with room and without, near caps skipped, skipped by the GPU and drawn: {caps:?}");
    let is_tried = overflowed.iter().chain(&caps).all(|&count| count > 4) && !noticed.contains(&0);
    if is_tried && cells > 50_000 && continued > 300 { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// The difference of two depths of a map, if it is a threshold.
fn met(random: &mut Random, map: &Map) -> f32 {
    let [a, b] = [0, 1].map(|_| map.depths[random.below(map.depths.len())]);
    let met = (a - b).abs();
    if (0.0..=1.0).contains(&met) && met >= f32::MIN_POSITIVE { met } else { 0.125 }
}

/// More blocks than a scan has invocations: each takes several. With `RIMLINE_LONG=1` a map of 4,096² texels, too.
fn large() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1612)?;
    let ways = [
        ([1100, 601], TextureFormat::Depth32Float, 7..8, 9, 4096.0),
        ([640, 820], TextureFormat::R32Float, 5..8, 99, 8192.0),
        ([4096; 2], TextureFormat::R32Float, 5..8, 99, 8192.0),
    ];
    for (size, format, bits, rare, steps) in ways.into_iter().take(if is_long() { 3 } else { 2 }) {
        let map = &Map::new(size, true, |texel| {
            let is_other = random.below(rare) == 0;
            if is_other { random.between(0.0, 1.0) } else { 0.25 + (texel % size[0] % 700) as f32 / steps }
        });
        for method in [EVERY_CELL, differences(0.01)] {
            let found = Case { map, format, options: by(method), bits: bits.clone(), objects: &[] };
            let cells = found.check(&gpu, &camera(REVERSED))?.list[0];
            println!("{cells} cells of {size:?} texels, {method:?}");
            if cells < 20_000 {
                return Err(format!("only {cells} cells"));
            }
        }
    }
    Ok(())
}

/// The second encode writes after the first has been copied out.
fn two_encodes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let maps = [(0.25, false), (0.75, true)]
        .map(|(depth, is_reversed)| Map::new([12, 7], is_reversed, |at| if at % 7 < 3 { depth } else { 1.0 }));
    let mut volumes = Volumes::new(&*pipelines(&gpu, REVERSED, 0..1)?, 1, [12, 7], by(differences(0.0)))?;
    let formats = [TextureFormat::Depth32Float, TextureFormat::R32Float];
    let given = [0, 1].map(|at| Maps::of(&gpu, &maps[at], formats[at], camera(maps[at].direction())));
    let copies = [0; 2].map(|_: u32| gpu.storage(&[0_u32; 105]));
    gpu.submit(|encoder| {
        for (given, copy) in given.iter().zip(&copies) {
            volumes.encode(encoder, given.as_ref()?, &camera(REVERSED))?;
            encoder.copy_buffer_to_buffer(volumes.cells(), 0, copy, 0, 420);
        }
        Ok(())
    })?;
    let rule = Rule::new(differences(0.0), 1, false, TextureFormat::R32Float);
    let expected = maps.map(|map| listed(&map, &[], &rule, None).0);
    for (number, copy) in copies.iter().enumerate() {
        let found: Vec<u32> = gpu.read(copy, expected[number].len())?;
        same(&format!("encode {number}"), &found, &expected[number])?;
        must_fail("the other encode", &same("cells", &found, &expected[1 - number]))?;
    }
    Ok(())
}

/// The purpose of the rules: a slope has no edges within it, and a step on it has.
fn slopes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let flat = |texel: u32| 0.25 + (texel % 20) as f32 / 64.0;
    // From the middle on, farther away by as much as the slope has in two texels.
    let step = |texel: u32| flat(texel) + if texel % 20 > 9 { 0.03125 } else { 0.0 };
    let count = |depth: &dyn Fn(u32) -> f32, method| {
        let (map, format) = (&Map::new([20, 20], false, depth), TextureFormat::R32Float);
        let found =
            Case { map, format, options: by(method), bits: 7..8, objects: &[] }.check(&gpu, &camera(REVERSED))?;
        Ok::<_, String>(found.list[0])
    };
    // `Automatic` marks two columns more, where one difference beside an edge is not known.
    let second = DepthMapMethod::SecondDifferences { low: 0.001, high: 1.0, dangling: None };
    for (method, further) in [(second, 0), (AUTOMATIC, 2 * 17)] {
        // The cells at the border, and those next to them, since triangles are drawn at the ends of marked edges. So
        // are the cells on both sides of the step, in the 17 rows between.
        let border = 4 * 20 + 4 * 18;
        let found = [count(&flat, method)?, count(&step, method)?];
        same(&format!("{method:?}"), &found, &[border + further, border + further + 3 * 17])?;
    }
    let all = count(&flat, differences(0.001))?;
    if all > 300 { Ok(()) } else { Err(format!("differences list {all} cells of the slope")) }
}

/// The comparison of the shaders, and that of the lists that tests expect, against big integers.
fn compared() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1602)?;
    let (mut met, mut inputs, mut expected) = ([0; 3], Vec::new(), Vec::new());
    for case in 0..300_000 {
        // Near each other or not, with bits at both ends of the mantissa.
        let number = |random: &mut Random, most: u32| {
            let exponent = most.saturating_sub(random.below(60) as u32).max(1);
            let mantissa = [random.next_u64() as u32, 1 << random.below(23), u32::MAX, 0][random.below(4)];
            f32::from_bits((exponent << 23) | (mantissa & 0x007f_ffff)).min(1.0)
        };
        let large = number(&mut random, 127);
        let small = if random.below(8) == 0 { 0.0 } else { number(&mut random, large.to_bits() >> 23).min(large) };
        let threshold = match case % 3 {
            0 => number(&mut random, 127),
            1 => (large - small).max(0.0),
            _ => f32::from_bits(((large - small).to_bits() + random.below(3) as u32).saturating_sub(1)),
        };
        let threshold = if threshold < f32::MIN_POSITIVE { 0.0 } else { threshold };
        let order = (exact(large) - exact(small)).cmp(&exact(threshold));
        met[(order as i8 + 1) as usize] += 1;
        same("lists that tests expect", &[exceeds(large, small, threshold)], &[order.is_gt()])?;
        inputs.push([large, small, threshold, 0.0]);
        expected.push(u32::from(order.is_gt()));
    }
    let expression = "vec4<u32>(u32(exceeds(bitcast<u32>(input.x), bitcast<u32>(input.y), bitcast<u32>(input.z))))";
    let probe = Probe::new(&gpu, &DEPTH_CELLS.wgsl(), ("vec4<u32>", expression), &[]);
    let found: Vec<_> = probe.run(&gpu, &[], &inputs)?.into_iter().map(|words| words[0]).collect();
    same("comparisons", &found, &expected)?;
    if met.iter().all(|&count| count > 10_000) { Ok(()) } else { Err(format!("less, equal, more: {met:?}")) }
}
