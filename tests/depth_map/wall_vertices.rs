//! Vertices of walls against `f64`, and surfaces beside contours against goldens and integers.

use glam::DVec2;
use rimline::DepthDirection;
use rimline::reference::depth_map::{Placing, map_view};
use rimline::reference::stages::DEPTH_WALLS;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::uniform;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::contours::{Fit, Traced, UNIT, distance, is_jump};
use crate::exact::{Exact, ROUNDING};
use crate::maps::Map;
use crate::parity::light;
use crate::probe::{Bound, Probe};
use crate::vertices::{Given, Tally, eye};
use rimline_testkit::goldens::golden;

pub(crate) const TESTS: &[Test] = &[
    ("vertices_of_walls_are_those_of_f64", vertices),
    ("surfaces_beside_contours_are_the_goldens", surfaces),
    ("surfaces_beside_contours_join_those_between_samples", joined),
];

/// The distance of what is far.
const FAR: i32 = i32::MAX;

/// How contours are found. The tolerance is 20 units of 2⁻¹⁰ of the range of depths.
pub(crate) fn fit(slope_bias: f32) -> Fit {
    Fit { threshold: 0.005, sideways: 0.25, depth: 20.0 / 1024.0, slope_bias }
}

/// Slopes, steps between them, and holes.
pub(crate) fn map(random: &mut Random, is_reversed: bool) -> Map {
    let size = [3 + random.below(30) as u32, 3 + random.below(30) as u32];
    let far = if is_reversed { 0.0 } else { 1.0 };
    let discs: Vec<_> = (0..4)
        .map(|_| {
            let middle = [0, 1].map(|axis| random.between(0.0, size[axis] as f32));
            (middle, random.between(1.0, 9.0), random.between(0.1, 0.8), random.between(-0.004, 0.004))
        })
        .collect();
    let has_ground = random.below(2) == 0;
    Map::new(size, is_reversed, |texel| {
        let [x, y] = [texel % size[0], texel / size[0]].map(|at| at as f32);
        let of = |(middle, radius, depth, slope): &([f32; 2], f32, f32, f32)| {
            let [x, y] = [x - middle[0], y - middle[1]];
            // Products alone are the same on every machine, as goldens need.
            (x * x + y * y < radius * radius).then(|| depth + slope * (x + 0.5 * y) + 0.0005 * x * x)
        };
        let depth = discs.iter().filter_map(of).fold(f32::INFINITY, f32::min);
        match depth {
            depth if depth < 0.9 => {
                if is_reversed {
                    1.0 - depth
                } else {
                    depth
                }
            }
            _ if has_ground => 0.5 + 0.4 * if is_reversed { -1.0 } else { 1.0 },
            _ => far,
        }
    })
}

fn vertices() -> Result<(), String> {
    const SEED: u64 = 16_105;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut tally, mut probe) = (Tally::default(), None);
    for round in 0..if is_long() { 1000 } else { 60 } {
        let (camera, _) = light(&mut random);
        let (eye, format) = eye(&mut random);
        let map = map(&mut random, camera.depth == DepthDirection::Reversed);
        let shape = map.shape(0.005, u32::MAX);
        let Traced { quads: walls, list, .. } = Traced::new(&gpu, &map, fit(1.0), None)?;
        if walls.is_empty() {
            continue;
        }
        let placing = Placing { border: 1.0, jitter: [0.0; 2], slope_bias: 0.5 };
        let view = map_view((&camera, map.size, TextureFormat::R32Float), (&eye, format), &placing).map_err(text)?;
        let given = Given::new(&gpu, (&shape, map.size, &map.depths), &list, &[view])?;
        let bound = given.bound();
        let make =
            || Probe::new(&gpu, &DEPTH_WALLS.wgsl(), ("vec4<f32>", "depth_walls(u32(input.x)).position"), &bound[..4]);
        let inputs: Vec<_> = (0..6 * walls.len()).map(|index| [index as f32, 0.0, 0.0, 0.0]).collect();
        let drawn = probe.get_or_insert_with(make).run(&gpu, &bound[..4], &inputs)?;
        let exact = Exact::new((&camera, map.size), (&eye, format), [0.0; 2]);
        for (index, drawn) in drawn.into_iter().enumerate() {
            let wall = &walls[index / 6];
            let [x, y, distance] = wall[[0, 1, 2, 0, 2, 3][index % 6]];
            // Texel 0 is a texel after the border's.
            let texel = DVec2::new(f64::from(x), f64::from(y)) / 256.0 - 1.0;
            let depth = (distance != FAR).then(|| {
                let depth = f64::from(distance) / UNIT;
                let depth = if map.is_reversed { 1.0 - depth } else { depth };
                // A conversion, and a quotient, 2.5 units.
                (depth, 3.5 * ROUNDING * depth)
            });
            // The quotient, 2.5 units, of twice the place.
            let places = 2.5 * ROUNDING * (texel.max_element() + 1.0);
            let held = exact.vertex(texel, depth, places);
            tally.add(&format!("round {round}, vertex {index}"), &held, drawn.map(f32::from_bits))?;
            tally.far += usize::from(depth.is_none());
        }
    }
    tally.check(5000)?;
    if tally.far > 1000 { Ok(()) } else { Err(format!("few are far: {tally:?}")) }
}

/// The surfaces of a map at places of cells, from a probe: the code of the cell, and the distance.
fn surfaces_at(
    gpu: &Gpu,
    probe: &mut Option<Probe>,
    (map, traced): (&Map, &Traced),
    inputs: &[[f32; 4]],
) -> Result<Vec<[u32; 4]>, String> {
    let shape = map.shape(0.005, u32::MAX);
    let camera = crate::stages::camera(crate::stages::direction(map));
    let placing = Placing { border: 1.0, jitter: [0.0; 2], slope_bias: 0.5 };
    let formats = [TextureFormat::R32Float, TextureFormat::Depth24PlusStencil8];
    let view = map_view((&camera, map.size, formats[0]), (&camera, formats[1]), &placing).map_err(text)?;
    let given = Given::new(gpu, (&shape, map.size, &map.depths), &[0], &[view])?;
    let contour = uniform(gpu, &traced.shape);
    let mut bound = given.bound().to_vec();
    bound.extend([
        (5, Bound::Storage(&traced.places)),
        (6, Bound::Uniform(&contour)),
        (9, Bound::Storage(&traced.marks)),
    ]);
    // A stage has eight storage buffers: cells are not read here.
    bound.retain(|&(binding, _)| binding != 2 && binding != 3 && binding != 4);
    let source = format!(
        "{}
fn probe_surface(cell: vec2<i32>, place: vec2<f32>) -> vec4<u32> {{
  let code = code_of_cell(cell);
  if (code == 0u) {{ return vec4<u32>(0u); }}
  return vec4<u32>(code, bitcast<u32>(contour_distance(cell, code, place)), 0u, 0u);
}}",
        DEPTH_WALLS.wgsl()
    );
    let expression = "probe_surface(vec2<i32>(input.xy), input.zw)";
    let make = || Probe::new(gpu, &source, ("vec4<u32>", expression), &bound);
    probe.get_or_insert_with(make).run(gpu, &bound, inputs)
}

/// Integers all, but for the side of the contour. Places are parts of 64 of a texel, so that is exact as well.
fn surfaces() -> Result<(), String> {
    const SEED: u64 = 16_106;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut compared, mut far, mut sides, mut probe) = (0, 0, 0, None);
    let mut words = Vec::new();
    for round in 0..60 {
        let is_reversed = random.below(2) == 0;
        let map = map(&mut random, is_reversed);
        let traced = Traced::new(&gpu, &map, fit(1.0), None)?;
        let cells = (0..=map.size[1]).flat_map(|y| (0..=map.size[0]).map(move |x| [x as f32, y as f32]));
        let part = |random: &mut Random| random.below(64) as f32 / 64.0;
        let inputs: Vec<_> = cells
            .flat_map(|[x, y]| {
                let random = [0; 3].map(|_: u32| [x, y, part(&mut random), part(&mut random)]);
                [random[0], random[1], random[2], [x, y, 0.0, 0.0], [x, y, 63.0 / 64.0, 63.0 / 64.0]]
            })
            .collect();
        let told = surfaces_at(&gpu, &mut probe, (&map, &traced), &inputs)?;
        let marked: Vec<_> = told.chunks(5).filter(|cell| cell[0][0] != 0).collect();
        let found: Vec<_> = marked.iter().flat_map(|cell| cell.iter().map(|told| told[1])).collect();
        words.push(found.len() as u32);
        words.extend(&found);
        compared += found.len();
        far += found.iter().filter(|&&distance| distance as i32 == FAR).count();
        // Two surfaces: nearer than the threshold to each other only if they are one.
        let is_two = |cell: &&&[[u32; 4]]| {
            let [a, b] = [3, 4].map(|place: usize| cell[place][1] as i32);
            a == FAR || b == FAR || (a - b).abs() > traced.shape.threshold
        };
        sides += marked.iter().filter(is_two).count();
        if round % 10 == 9 {
            golden("depth_map", &format!("surfaces {:02}", round / 10), &words)?;
            words.clear();
        }
    }
    println!("{compared} places, {far} far, {sides} cells with two surfaces");
    if compared > 5000 && far > 500 && sides > 500 { Ok(()) } else { Err("too few".to_owned()) }
}

/// On an edge without a contour a surface is the line between the two samples, as it is in the triangles on the other side.
fn joined() -> Result<(), String> {
    const SEED: u64 = 16_108;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut compared, mut others, mut probe) = (0, 0, None);
    for round in 0..60 {
        let is_reversed = random.below(2) == 0;
        let map = map(&mut random, is_reversed);
        let traced = Traced::new(&gpu, &map, fit(0.0), None)?;
        let threshold = i64::from(traced.shape.threshold);
        let [width, height] = map.size.map(|texels| texels as i32);
        let is_marked = |at: [i32; 2], step: [i32; 2]| is_jump(&map, None, threshold, at, step);
        let (mut inputs, mut ends) = (Vec::new(), Vec::new());
        for [x, y] in (0..=height).flat_map(|y| (0..=width).map(move |x| [x, y])) {
            let [across, down] = [[1, 0], [0, 1]];
            let edges = [
                is_marked([x, y], across),
                is_marked([x + 1, y], down),
                is_marked([x, y + 1], across),
                is_marked([x, y], down),
            ];
            // The edge at the top, and that on the left.
            for (axis, other) in [(0, [x + 1, y]), (1, [x, y + 1])] {
                let distances = [[x, y], other].map(|at| distance(&map, at));
                let (true, false, [Some(first), Some(last)]) = (edges.contains(&true), edges[3 * axis], distances)
                else {
                    continue;
                };
                let at = |part: f32| {
                    let [along, beside] = if axis == 0 { [part, 0.0] } else { [0.0, part] };
                    [x as f32, y as f32, along, beside]
                };
                inputs.extend([at(0.0), at(0.25), at(0.75)]);
                ends.push((first, last));
            }
        }
        if inputs.is_empty() {
            continue;
        }
        let told = surfaces_at(&gpu, &mut probe, (&map, &traced), &inputs)?;
        for (told, (first, last)) in told.chunks(3).zip(ends) {
            let at = |number: usize| i64::from(told[number][1] as i32);
            for (number, part) in [(1, 0.25), (2, 0.75)] {
                // Both distances include the allowance for errors of depths. A 256th of a difference is rounded.
                let off = (at(number) - at(0)) as f64 - part * (last - first) as f64;
                if told[number][0] == 0 || off.abs() > 1000.0 {
                    return Err(format!("round {round}, {:?}, from {first} to {last}: {told:?}, {off}", map.size));
                }
                compared += 1;
                others += usize::from((last - first).abs() > 10_000);
            }
        }
    }
    println!("{compared} places, {others} of them on slopes");
    if compared > 5000 && others > 2000 { Ok(()) } else { Err("too few".to_owned()) }
}
