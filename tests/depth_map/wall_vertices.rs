//! Vertices of walls against `f64`, surfaces beside contours against goldens, and flaps at points near contours.

use glam::{DVec2, DVec4};
use rimline::DepthDirection;
use rimline::internals::depth_map::{Placing, map_view};
use rimline::internals::stages::DEPTH_WALLS;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::uniform;
use rimline_testkit::goldens::golden;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::probe::{Bound, Probe};
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::contours::{Fit, Traced, UNIT};
use crate::exact::{Exact, ROUNDING};
use crate::maps::Map;
use crate::near_contours::among;
use crate::parity::light;
use crate::vertices::{Given, Tally, eye};

pub(crate) const TESTS: &[Test] = &[
    ("vertices_of_walls_are_those_of_f64", vertices),
    ("surfaces_beside_contours_are_the_goldens", surfaces),
    ("flaps_change_what_f64_says_they_do", changes),
];

/// The distance of what is far.
const FAR: i32 = i32::MAX;

/// How contours are found. The tolerance is 20 units of 2⁻¹⁰ of the range of depths.
fn fit(slope_bias: f32) -> Fit {
    Fit { threshold: 0.005, sideways: 0.25, depth: 20.0 / 1024.0, slope_bias }
}

/// Slopes, steps between them, and holes.
fn map(random: &mut Random, is_reversed: bool) -> Map {
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
    let (gpu, mut random) = Gpu::seeded(16_105)?;
    let mut tally = Tally::default();
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
        let call = "depth_walls(u32(input.x)).position";
        let drawn = Probe::vertices(&gpu, &DEPTH_WALLS, call, &bound[..4], 6 * walls.len())?;
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
            // The quotient, 2.5 units, of twice the position.
            let positions = 2.5 * ROUNDING * (texel.max_element() + 1.0);
            let held = exact.vertex(texel, depth, positions);
            tally.add(&format!("round {round}, vertex {index}"), &held, drawn)?;
            tally.far += usize::from(depth.is_none());
        }
    }
    tally.check(5000)?;
    if tally.far > 1000 { Ok(()) } else { Err(format!("few are far: {tally:?}")) }
}

/// Four words of a function of `depth_walls` for each input, from a probe, which is made once: `source` and
/// `expression` are added to the stage. A stage has eight storage buffers, so only those of `wanted` are bound.
fn probed(
    gpu: &Gpu,
    (map, traced): (&Map, &Traced),
    (source, expression, wanted): (&str, &str, &[u32]),
    inputs: &[[f32; 4]],
) -> Result<Vec<[u32; 4]>, String> {
    let shape = map.shape(0.005, u32::MAX);
    let camera = crate::stages::camera(map.direction());
    let placing = Placing { border: 1.0, jitter: [0.0; 2], slope_bias: 0.5 };
    let formats = [TextureFormat::R32Float, TextureFormat::Depth24PlusStencil8];
    let view = map_view((&camera, map.size, formats[0]), (&camera, formats[1]), &placing).map_err(text)?;
    let given = Given::new(gpu, (&shape, map.size, &map.depths), &traced.list, &[view])?;
    let contour = uniform(gpu, &traced.shape);
    let mut bound = given.bound().to_vec();
    bound.extend([
        (5, Bound::Storage(&traced.crossings)),
        (6, Bound::Uniform(&contour)),
        (7, Bound::Storage(&traced.counts)),
        (8, Bound::Storage(&traced.marks)),
    ]);
    bound.retain(|(binding, _)| wanted.contains(binding));
    let source = format!("{}{source}", DEPTH_WALLS.wgsl());
    gpu.kept(expression, || Ok(Probe::new(gpu, &source, ("vec4<u32>", expression), &bound)))?.run(gpu, &bound, inputs)
}

/// The surfaces of a map at positions of cells: the code of the cell, and the distance.
const SURFACE: (&str, &str, &[u32]) = (
    "
fn probe_surface(cell: vec2<i32>, position: vec2<f32>) -> vec4<u32> {
  let code = load_edge_code(cell);
  if (code == 0u) { return vec4<u32>(0u); }
  return vec4<u32>(code, bitcast<u32>(contour_distance(cell, code, position)), 0u, 0u);
}",
    "probe_surface(vec2<i32>(input.xy), input.zw)",
    &[0, 1, 5, 6, 8],
);

/// Whether flaps change whether a position is behind.
const FLAPS: (&str, &str, &[u32]) = (
    "
fn probe_flaps(position: vec2<f32>, depth: f32, is_behind: bool) -> vec4<u32> {
  let cell = vec2<i32>(floor(position));
  return vec4<u32>(u32(flaps_change(cell, position - floor(position), depth, is_behind)), 0u, 0u, 0u);
}",
    "probe_flaps(input.xy, input.z, input.w != 0.0)",
    &[0, 2, 6, 7],
);

/// Integers all, but for the side of the contour. Positions are parts of 64 of a texel, so that is exact as well.
fn surfaces() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_106)?;
    let (mut compared, mut far, mut sides) = (0, 0, 0);
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
        let results = probed(&gpu, (&map, &traced), SURFACE, &inputs)?;
        let marked: Vec<_> = results.chunks(5).filter(|cell| cell[0][0] != 0).collect();
        let found: Vec<_> = marked.iter().flat_map(|cell| cell.iter().map(|result| result[1])).collect();
        words.push(found.len() as u32);
        words.extend(&found);
        compared += found.len();
        far += found.iter().filter(|&&distance| distance as i32 == FAR).count();
        // Two surfaces: nearer than the threshold to each other only if they are one.
        let is_two = |cell: &&&[[u32; 4]]| {
            let [a, b] = [3, 4].map(|position: usize| cell[position][1] as i32);
            a == FAR || b == FAR || (a - b).abs() > traced.shape.threshold
        };
        sides += marked.iter().filter(is_two).count();
        if round % 10 == 9 {
            golden("depth_map", &format!("surfaces {:02}", round / 10), &words)?;
            words.clear();
        }
    }
    println!("{compared} positions, {far} far, {sides} cells with two surfaces");
    if compared > 5000 && far > 500 && sides > 500 { Ok(()) } else { Err("too few".to_owned()) }
}

/// Flaps change the shadow at points near contours, against `f64`.
fn changes() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_107)?;
    let (mut compared, mut changed, mut several, mut unsure, mut others) = (0, 0, 0, 0, 0);
    for round in 0..if is_long() { 1000 } else { 60 } {
        let is_reversed = random.below(2) == 0;
        let map = map(&mut random, is_reversed);
        let traced = Traced::new(&gpu, &map, fit(1.0), None)?;
        let walls = &traced.quads;
        // Positions beside vertices of flaps, at about their depths.
        let flaps: Vec<_> = walls.iter().filter(|wall| wall[0][..2] != wall[1][..2]).collect();
        if flaps.is_empty() {
            continue;
        }
        let inputs: Vec<_> = (0..400)
            .map(|_| {
                let flap = flaps[random.below(flaps.len())];
                let shares = [0; 3].map(|_| random.between(0.0, 1.0));
                let whole = shares.iter().sum::<f32>().max(0.01);
                let mean = |axis: usize| {
                    let mean = (0..3).map(|at| flap[at][axis] as f32 * shares[at] / whole).sum::<f32>();
                    (mean + flap[3][axis] as f32 * 1e-3) / 1.001
                };
                let [x, y] = [0, 1].map(|axis| {
                    let most = map.size[axis] as f32;
                    (mean(axis) / 256.0 + random.between(-0.2, 0.2)).clamp(0.0, most + 0.99)
                });
                let depth = mean(2) / UNIT as f32 + random.between(-0.004, 0.004);
                let depth = if is_reversed { 1.0 - depth } else { depth };
                [x, y, depth, random.below(2) as f32]
            })
            .collect();
        let found = probed(&gpu, (&map, &traced), FLAPS, &inputs)?;
        for (number, (&[x, y, depth, is_behind], word)) in inputs.iter().zip(&found).enumerate() {
            let is_behind = is_behind != 0.0;
            // Texel 0 is a texel after the border's, and distances begin at the near plane.
            let at = |off: [f64; 3]| {
                let [x, y, depth] = [x, y, depth].map(f64::from);
                let distance = if is_reversed { 1.0 - depth } else { depth };
                let position = DVec4::new(x - 1.0 + off[0], y - 1.0 + off[1], distance + off[2], 1.0);
                among(walls, position).1
            };
            let flaps_here = at([0.0; 3]);
            // Rounding in `f32` may move the point and its depth by this much.
            let around = [-1.0, 1.0].map(|sign| {
                [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 4e-6]].map(|off| at(off.map(|off| sign * off)))
            });
            if around.iter().flatten().any(|there| *there != flaps_here) {
                unsure += 1;
                continue;
            }
            let expected = flaps_here.iter().filter(|&&(_, behind)| behind != is_behind).count() % 2 == 1;
            if (word[0] == 1) != expected {
                return Err(format!("round {round}, {x} {y} {depth}: {word:?}, expected {expected}: {flaps_here:?}"));
            }
            // The negative control: the answer of another position.
            others += usize::from((found[(number + 1) % found.len()][0] == 1) != expected);
            compared += 1;
            changed += usize::from(expected);
            several += usize::from(flaps_here.len() > 1);
        }
    }
    println!(
        "{compared} positions, {changed} changed, {several} in several flaps, {unsure} too near to a border, {others} others"
    );
    let is_tried = changed * 10 > compared && several > 100 && unsure * 5 < compared && others * 10 > compared;
    if is_tried { Ok(()) } else { Err("too few".to_owned()) }
}
