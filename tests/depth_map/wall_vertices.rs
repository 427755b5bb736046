//! Vertices of walls, and surfaces beside contours, on the GPU and by their twins, against `f64`.

use glam::{DVec2, Vec2};
use rimline::DepthDirection;
use rimline::reference::cpu::{
    ContourMap, FAR, Samples, Wall, contour_distance, contour_marks, contour_places, contour_walls, depth_walls,
};
use rimline::reference::depth_map::{Placing, map_view};
use rimline::reference::layout::ContourShape;
use rimline::reference::stages::DEPTH_WALLS;
use rimline_measure::device::Gpu;
use rimline_measure::dispatch::uniform;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::random::Random;
use rimline_measure::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::exact::{Exact, ROUNDING};
use crate::maps::Map;
use crate::parity::light;
use crate::probe::{Bound, Probe};
use crate::vertices::{Given, Tally, eye};

pub(crate) const TESTS: &[Test] = &[
    ("vertices_of_walls_are_those_of_f64", vertices),
    ("surfaces_beside_contours_equal_their_twin", surfaces),
    ("surfaces_beside_contours_join_those_between_samples", joined),
];

/// The unit of distances.
const UNIT: f64 = 536_870_912.0;

/// How contours are found in a map of `R32Float`.
pub(crate) fn shape_of(map: &Map, slope_bias: f32, capacity: u32) -> ContourShape {
    let tiles = map.size.map(|texels| (texels + 16) / 16);
    ContourShape {
        tiles: [tiles[0], tiles[0] * tiles[1]],
        words: (map.size[0] + 17) / 16,
        capacity,
        threshold: (0.005 * UNIT) as i32,
        sure: (0.08 * UNIT) as i32,
        sideways: 64,
        tolerance: 20,
        shift: 19,
        slope_bias: (128.0 * slope_bias) as i32,
        share: if map.is_reversed { 256 } else { 0 },
        constant: if map.is_reversed { 0 } else { 128 },
    }
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
            (x.hypot(y) < *radius).then(|| depth + slope * (x + 0.5 * y) + 0.0005 * x * x)
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

/// Results of the contour stages for a map.
struct Found {
    marks: Vec<u32>,
    places: Vec<u32>,
    walls: Vec<Wall>,
}

fn found(samples: &Samples<'_>, shape: &ContourShape) -> Found {
    let map = ContourMap { samples, shape };
    let marks = contour_marks(&map);
    let list = contour_walls(&map, &marks, &contour_places(&map, &marks));
    Found { marks, places: list.places, walls: list.walls }
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
        let contour = shape_of(&map, 1.0, 100_000);
        let shape = map.shape(0.005, u32::MAX);
        let samples = Samples { shape: &shape, depths: &map.depths, objects: &[] };
        let Found { walls, .. } = found(&samples, &contour);
        if walls.is_empty() {
            continue;
        }
        let placing = Placing { border: 1.0, jitter: [0.0; 2], slope_bias: 0.5 };
        let view = map_view((&camera, map.size, TextureFormat::R32Float), (&eye, format), &placing).map_err(text)?;
        let words = [walls.len() as u32, 0, 0, 0].into_iter();
        let words: Vec<_> = words.chain(walls.iter().flatten().flatten().map(|&word| word as u32)).collect();
        let given = Given::new(&gpu, (&shape, map.size, &map.depths), &words, &[view])?;
        let bound = given.bound();
        let make =
            || Probe::new(&gpu, &DEPTH_WALLS.wgsl(), ("vec4<f32>", "depth_walls(u32(input.x)).position"), &bound[..4]);
        let inputs: Vec<_> = (0..6 * walls.len()).map(|index| [index as f32, 0.0, 0.0, 0.0]).collect();
        let drawn = probe.get_or_insert_with(make).run(&gpu, &bound[..4], &inputs)?;
        let exact = Exact::new((&camera, map.size), (&eye, format), [0.0; 2]);
        let own = ContourMap { samples: &samples, shape: &contour };
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
            let twin = depth_walls(&own, &view, wall, index).to_array();
            tally.add(&format!("round {round}, vertex {index}"), &held, [twin, drawn.map(f32::from_bits)])?;
            tally.far += usize::from(depth.is_none());
        }
    }
    tally.check(5000)?;
    if tally.far > 1000 { Ok(()) } else { Err(format!("few are far: {tally:?}")) }
}

/// Integers all, but for the side of the contour. Places are parts of 64 of a texel, so that is exact as well.
fn surfaces() -> Result<(), String> {
    const SEED: u64 = 16_106;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut compared, mut far, mut sides, mut probe, mut others) = (0, 0, 0, None, 0);
    for round in 0..if is_long() { 1000 } else { 60 } {
        let is_reversed = random.below(2) == 0;
        let map = map(&mut random, is_reversed);
        let contour = shape_of(&map, 1.0, 100_000);
        let shape = map.shape(0.005, u32::MAX);
        let samples = Samples { shape: &shape, depths: &map.depths, objects: &[] };
        let own = ContourMap { samples: &samples, shape: &contour };
        let Found { marks, places, .. } = found(&samples, &contour);
        let camera = crate::stages::camera(crate::stages::direction(&map));
        let placing = Placing { border: 1.0, jitter: [0.0; 2], slope_bias: 0.5 };
        let formats = [TextureFormat::R32Float, TextureFormat::Depth24PlusStencil8];
        let view = map_view((&camera, map.size, formats[0]), (&camera, formats[1]), &placing).map_err(text)?;
        let given = Given::new(&gpu, (&shape, map.size, &map.depths), &[0], &[view])?;
        let [marks_given, places_given] = [&marks, &places].map(|words| gpu.storage(words));
        let contour_given = uniform(&gpu, &contour);
        let mut bound = given.bound().to_vec();
        bound.extend([
            (5, Bound::Storage(&places_given)),
            (6, Bound::Uniform(&contour_given)),
            (9, Bound::Storage(&marks_given)),
        ]);
        // A stage has eight storage buffers: cells are not read here.
        bound.retain(|&(binding, _)| binding != 2 && binding != 3 && binding != 4);
        let expression = "probe_surface(vec2<i32>(input.xy), input.zw)";
        let source = format!(
            "{}
fn probe_surface(cell: vec2<i32>, place: vec2<f32>) -> vec4<u32> {{
  let code = code_of_cell(cell);
  if (code == 0u) {{ return vec4<u32>(0u); }}
  return vec4<u32>(code, bitcast<u32>(contour_distance(cell, code, place)), 0u, 0u);
}}",
            DEPTH_WALLS.wgsl()
        );
        let cells = (0..=map.size[1]).flat_map(|y| (0..=map.size[0]).map(move |x| [x as f32, y as f32]));
        let cells: Vec<_> = cells.collect();
        let part = |random: &mut Random| random.below(64) as f32 / 64.0;
        let inputs: Vec<_> = cells
            .iter()
            .flat_map(|&[x, y]| [0; 3].map(|_: u32| [x, y, part(&mut random), part(&mut random)]))
            .collect();
        let make = || Probe::new(&gpu, &source, ("vec4<u32>", expression), &bound);
        let told = probe.get_or_insert_with(make).run(&gpu, &bound, &inputs)?;
        let marked = inputs.iter().zip(&told).filter(|(_, told)| told[0] != 0);
        let distance = |[x, y, across, down]: [f32; 4]| {
            contour_distance(&own, &marks, &places, [x as i32, y as i32], Vec2::new(across, down))
        };
        let (expected, found): (Vec<_>, Vec<_>) =
            marked.clone().map(|(&input, told)| (distance(input), told[1] as i32)).unzip();
        same(&format!("round {round}, {:?}", map.size), &found, &expected)?;
        compared += found.len();
        far += found.iter().filter(|&&distance| distance == FAR).count();
        // Nearer than, or as far as, the surface of a corner of the cell, by no more than slopes tell; and on both sides of it.
        let of_cell = |&[x, y]: &[f32; 2]| [0.0, 63.0 / 64.0].map(|at| distance([x, y, at, at]));
        let told_cells = cells.iter().zip(told.iter().step_by(3)).filter(|(_, told)| told[0] != 0);
        sides += told_cells
            .filter(|(cell, _)| {
                let [a, b] = of_cell(cell);
                (a - b).abs() > contour.threshold || a == FAR || b == FAR
            })
            .count();
        // Negative control.
        let mirrored = marked.map(|(&[x, y, across, down], _)| distance([x, y, 1.0 - across, 1.0 - down]));
        let mirrored: Vec<_> = mirrored.collect();
        if found.len() > 20 {
            must_fail("mirrored places", &same("places", &found, &mirrored))?;
            others += 1;
        }
    }
    println!("{compared} places, {far} far, {sides} cells with two surfaces");
    if compared > 5000 && far > 500 && sides > 500 && others > 20 { Ok(()) } else { Err("too few".to_owned()) }
}

/// On an edge without a contour a surface is the line between the two samples, as it is in the triangles on the other side.
fn joined() -> Result<(), String> {
    const SEED: u64 = 16_108;
    println!("seed {SEED}");
    let mut random = Random::new(SEED);
    let (mut compared, mut others) = (0, 0);
    for round in 0..60 {
        let is_reversed = random.below(2) == 0;
        let map = map(&mut random, is_reversed);
        let contour = shape_of(&map, 0.0, 100_000);
        let shape = map.shape(0.005, u32::MAX);
        let samples = Samples { shape: &shape, depths: &map.depths, objects: &[] };
        let own = ContourMap { samples: &samples, shape: &contour };
        let Found { marks, places, .. } = found(&samples, &contour);
        let is_marked = |[x, y]: [i32; 2], axis: usize| {
            let word = marks[y as usize * contour.words as usize + x as usize / 16];
            word >> (2 * (x as usize % 16) + axis) & 1 == 1
        };
        let [width, height] = map.size.map(|texels| texels as i32);
        for [x, y] in (0..=height).flat_map(|y| (0..=width).map(move |x| [x, y])) {
            let edges =
                [is_marked([x, y], 0), is_marked([x + 1, y], 1), is_marked([x, y + 1], 0), is_marked([x, y], 1)];
            // The edge at the top, and that on the left.
            for (axis, other) in [(0, [x + 1, y]), (1, [x, y + 1])] {
                let ends = [[x, y], other].map(|at| crate::contours::distance(&map, at));
                let (true, false, [Some(first), Some(last)]) = (edges.contains(&true), is_marked([x, y], axis), ends)
                else {
                    continue;
                };
                let at = |part: f32| {
                    let place = if axis == 0 { Vec2::new(part, 0.0) } else { Vec2::new(0.0, part) };
                    i64::from(contour_distance(&own, &marks, &places, [x, y], place))
                };
                for part in [0.25, 0.75] {
                    let expected = first as f64 + f64::from(part) * (last - first) as f64;
                    // Both distances include the allowance for errors of depths. A 256th of a difference is rounded.
                    let off = (at(part) - at(0.0)) as f64 - (expected - first as f64);
                    if off.abs() > 1000.0 {
                        return Err(format!("round {round}, {:?}, edge {axis} of {x}, {y}: {off}", map.size));
                    }
                    compared += 1;
                    others += usize::from((last - first).abs() > 10_000);
                }
            }
        }
    }
    println!("{compared} places, {others} of them on slopes");
    if compared > 5000 && others > 2000 { Ok(()) } else { Err("too few".to_owned()) }
}
