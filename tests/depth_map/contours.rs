//! Walls over contours by `contour_marks`, `contour_tiles`, `contour_crossings` and `contour_walls`: lists against goldens,
//! and those that overflow. They are closed, cross each jump once, and lie on rims that are known exactly.

use std::collections::{HashMap, HashSet};

use rimline::gpu::depth_map::DepthMapOptions;
use rimline::internals::stages::CONTOUR_TILES;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::{Dispatch, uniform};
use rimline_testkit::goldens::golden;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::limited;
use rimline_testkit::random::Random;
use rimline_testkit::turns::limits;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::maps::{Map, further, maps};
use crate::picture::{EVERY_CELL, Encoded, Maps, REVERSED, Target, by, contours, pipelines};
use crate::stages::{camera, is_short};
use crate::views::{View, worlds};
use rimline_testkit::textures::{objects, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("lists_of_walls_are_the_goldens", lists),
    ("contours_through_every_cell_are_the_goldens", long),
    ("lists_of_walls_of_few_workgroups_are_those_of_many", few_workgroups),
    ("workgroups_for_contours_on_a_device_without_a_limit", workgroups),
    ("tiles_have_at_most_as_many_walls_as_turns_count", most_walls),
    ("steep_surfaces_end_before_those_behind", before_those_behind),
    ("walls_that_overflow_are_those_of_every_cell", overflow),
    ("walls_are_closed_and_cross_jumps_once", closed),
    ("walls_are_closed_where_a_contour_ends_beside_a_tile", ends_beside_a_tile),
    ("contours_lie_on_rims", on_rims),
];

/// The unit of distances.
pub(crate) const UNIT: f64 = 536_870_912.0;

/// How contours are found, as the options say it.
#[derive(Clone, Copy, Debug)]
struct Fit {
    threshold: f32,
    sideways: f32,
    depth: f32,
    slope_bias: f32,
}

impl Fit {
    fn options(self) -> DepthMapOptions {
        let method = contours([self.threshold, self.sideways, self.depth]);
        DepthMapOptions { slope_bias: self.slope_bias, capacity: Some(100_000), ..by(method) }
    }
}

/// The samples of a tile, of which some are near. A contour winds through nearly all cells.
const SPIRAL: [&str; 16] = [
    "................",
    ".###############",
    "...............#",
    ".#############.#",
    ".#...........#.#",
    ".#.#########.#.#",
    ".#.#.......#.#.#",
    ".#.#.#####.#.#.#",
    ".#.#.#...#.#.#.#",
    ".#.#.#.###.#.#.#",
    ".#.#.#.....#.#.#",
    ".#.#.#######.#.#",
    ".#.#.........#.#",
    ".#.###########.#",
    ".#.............#",
    ".###############",
];

/// Maps with a spiral in each tile: a loop, or joined to its neighbours.
fn spirals(random: &mut Random, is_loop: bool) -> Map {
    // The sample 0 of the lattice lies before texel 0.
    Map::new([142, 110], false, |texel| {
        let [x, y] = [texel % 142 + 1, texel / 142 + 1].map(|at| (at % 16) as usize);
        let is_near = SPIRAL[y].as_bytes()[x] == b'#' || (!is_loop && [x, y] == [0, 1]);
        if is_near { random.between(0.2, 0.4) } else { random.between(0.7, 0.9) }
    })
}

/// The sine of `lobes` times the angle of a position: by products alone, which are the same on every machine, as
/// goldens need.
fn wave(lobes: u32, [x, y]: [f64; 2]) -> f64 {
    let length = (x * x + y * y).sqrt().max(f64::MIN_POSITIVE);
    let unit = [x / length, y / length];
    let turned = |[a, b]: [f64; 2], _| [a * unit[0] - b * unit[1], a * unit[1] + b * unit[0]];
    (0..lobes).fold([1.0, 0.0], turned)[1]
}

/// Bodies with smooth rims over ground or nothing, some behind others.
pub(crate) fn smooth(random: &mut Random, size: [u32; 2], is_reversed: bool) -> Map {
    let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
    let [width, height] = size.map(f64::from);
    let bodies: Vec<_> = (0..5)
        .map(|_| {
            let middle = [between(0.0, 1.0) * width, between(0.0, 1.0) * height];
            let lobes = [between(2.0, 6.0).floor(), between(0.0, 0.5)];
            (middle, between(0.05, 0.35) * width.min(height), lobes, between(0.2, 0.5), between(-0.001, 0.001))
        })
        .collect();
    let ground = (between(0.0, 1.0) < 0.5).then(|| [between(0.7, 0.9), between(-0.0004, 0.0004)]);
    Map::new(size, is_reversed, |texel| {
        let [x, y] = [texel % size[0], texel / size[0]].map(f64::from);
        let mut depth = ground.map_or(f64::INFINITY, |[depth, slope]| depth + slope * x);
        for (middle, radius, [lobes, share], near, slope) in &bodies {
            let [x, y] = [x - middle[0], y - middle[1]];
            let limit = radius * (1.0 + share * wave(*lobes as u32, [x, y]));
            let inside = 1.0 - (x * x + y * y) / (limit * limit);
            if inside > 0.0 {
                depth = depth.min(near - 0.05 * inside.sqrt() + slope * x);
            }
        }
        if depth.is_infinite() {
            f32::from(!is_reversed)
        } else if is_reversed {
            1.0 - depth as f32
        } else {
            depth as f32
        }
    })
}

/// A wall: four vertices of a position and a distance.
pub(crate) type Quad = [[i32; 3]; 4];

/// The walls that the GPU lists, and their number.
pub(crate) fn listed(gpu: &Gpu, cells: &wgpu::Buffer) -> Result<(u32, Vec<Quad>), String> {
    let head: Vec<u32> = gpu.read(cells, 4)?;
    same("words before the list", &head[1..], &[0; 3])?;
    let room = (cells.size() / 4 - 4) / 12;
    let words: Vec<i32> = gpu.read(cells, 4 + 12 * u64::from(head[0]).min(room) as usize)?;
    let quad = |words: &[i32]| [0, 3, 6, 9].map(|at| [words[at], words[at + 1], words[at + 2]]);
    Ok((head[0], words[4..].chunks_exact(12).map(quad).collect()))
}

/// A list of walls as words: the number, and the words of the quadrilaterals.
fn words((count, quads): &(u32, Vec<Quad>)) -> Vec<u32> {
    std::iter::once(*count).chain(quads.iter().flatten().flatten().map(|&word| word as u32)).collect()
}

/// Walls of a map in a texture on the GPU.
fn walls(
    gpu: &Gpu,
    (map, texture): (&Map, &wgpu::Texture),
    numbers: Option<&[u32]>,
    options: DepthMapOptions,
) -> Result<(u32, Vec<Quad>), String> {
    let mut maps = Maps::one(texture, camera(map.direction()));
    maps.objects = vec![numbers.map(|numbers| objects(gpu, map.size, numbers))];
    let encoded = Encoded::new(gpu, &*pipelines(gpu, REVERSED, 7..8)?, &maps, &camera(REVERSED), options)?;
    listed(gpu, encoded.volumes.cells())
}

/// Walls of a map of floats.
pub(crate) fn walls_of(
    gpu: &Gpu,
    map: &Map,
    numbers: Option<&[u32]>,
    options: DepthMapOptions,
) -> Result<Vec<Quad>, String> {
    Ok(walls(gpu, (map, &texture(gpu, map.size, TextureFormat::R32Float, &map.depths)?), numbers, options)?.1)
}

/// The depths in steps of a format, as a test rounds them.
fn rounded(map: &Map, format: TextureFormat) -> Map {
    let steps = match format {
        TextureFormat::Depth16Unorm => 65_535.0,
        TextureFormat::Depth24Plus => 16_777_215.0,
        _ => return map.clone(),
    };
    let map = map.for_format(format);
    let round = |&depth: &f32| ((f64::from(depth) * steps).round() / steps) as f32;
    Map { depths: map.depths.iter().map(round).collect(), ..map }
}

fn lists() -> Result<(), String> {
    const SEED: u64 = 1641;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let formats =
        [TextureFormat::R32Float, TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];
    let mut all = 0;
    for (of_format, format) in (0..).zip(formats) {
        let mut random = Random::new(SEED + of_format);
        let mut given = maps(&mut random);
        given.extend(further(&mut random));
        for size in [[70, 45], [33, 90], [120, 120]] {
            given.extend([false, true].map(|is_reversed| smooth(&mut random, size, is_reversed)));
        }
        for (number, map) in (0..).zip(given).filter(|(_, map)| is_short(map, format)) {
            let mut random = Random::new(1000 * (SEED + of_format) + number);
            let fit = Fit {
                threshold: [0.0, 0.0005, 0.01, 0.125, 1.0][random.below(5)],
                sideways: [0.0, 0.25, 0.5][random.below(3)],
                depth: [0.0, 0.001, 0.02, 1.0][random.below(4)],
                slope_bias: [0.0, 1.0, 5.5][random.below(3)],
            };
            let numbers: Vec<_> = map.depths.iter().map(|_| u32::from(random.below(19) == 0)).collect();
            let numbers = (random.below(4) == 0).then_some(&numbers[..]);
            let capacity = if random.below(5) == 0 { random.below(40) as u32 } else { 100_000 };
            let options = DepthMapOptions { capacity: Some(capacity), ..fit.options() };
            let stored = texture(&gpu, map.size, format, &map.for_format(format).depths)?;
            let found = walls(&gpu, (&map, &stored), numbers, options)?;
            all += found.0;
            let of_floats = |depths: &[f32]| {
                let texture = texture(&gpu, map.size, TextureFormat::R32Float, depths)?;
                walls(&gpu, (&map, &texture), numbers, DepthMapOptions { rounded_to: Some(format), ..options })
            };
            let is_float = matches!(format, TextureFormat::R32Float | TextureFormat::Depth32Float);
            // Floats have the same list if they are stated to be rounded to the format. With reversed depth the error
            // of floats is added.
            if is_float || !map.is_reversed {
                let what = format!("{format:?} {:?}, reversed {}, {fit:?}", map.size, map.is_reversed);
                same(&what, &of_floats(&read(&gpu, &stored)?)?.1, &found.1)?;
            }
            // Which of two steps a depth is rounded to is the driver's choice, so goldens are of floats.
            let result = if is_float { found } else { of_floats(&rounded(&map, format).depths)? };
            golden("depth_map", &format!("walls {number:03} of {format:?}"), &words(&result))?;
        }
    }
    println!("{all} walls");
    if all > 50_000 { Ok(()) } else { Err("too few".to_owned()) }
}

/// A slope that ends three and a half of its steps before a plane. It goes on more steeply, but not behind the plane.
fn before_those_behind() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let unit = |depth: f64| (depth * UNIT) as i32;
    let map = Map::new([18, 40], false, |texel| match texel % 18 {
        x @ ..9 => 0.25 + 0.01 * x as f32,
        _ => 0.365,
    });
    let fit = Fit { threshold: 0.005, sideways: 0.25, depth: 0.01, slope_bias: 0.0 };
    // Between the slope and the plane, away from the border of the map.
    let inner =
        |vertex: &[i32; 3]| (9 * 256..=10 * 256).contains(&vertex[0]) && (10 * 256..30 * 256).contains(&vertex[1]);
    let walls = walls_of(&gpu, &map, None, fit.options())?.concat();
    let depths: Vec<_> = walls.iter().filter(|vertex| inner(vertex)).map(|vertex| vertex[2]).collect();
    // Four slopes are more than the jump, which would end at 0.37.
    let is_right = |depth: Option<&i32>| depth.is_some_and(|&depth| (unit(0.364)..unit(0.366)).contains(&depth));
    let is_slope = |depth: Option<&i32>| depth.is_some_and(|&depth| depth >= unit(0.329));
    if is_right(depths.iter().max()) && is_slope(depths.iter().min()) { Ok(()) } else { Err(format!("{depths:?}")) }
}

/// Software Vulkan ends the loops of an invocation after 65,535 iterations, so invocations must not have more.
fn long() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1646)?;
    for is_loop in [false, true] {
        for (sideways, depth) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.01), (0.5, 1.0)] {
            let fit = Fit { threshold: 0.25, sideways, depth, slope_bias: 1.0 };
            let quads = walls_of(&gpu, &spirals(&mut random, is_loop), None, fit.options())?;
            let name = format!("walls of spirals, loops {is_loop}, sideways {sideways}, depth {depth}");
            println!("{} {name}", quads.len());
            golden("depth_map", &name, &words(&(quads.len() as u32, quads)))?;
        }
    }
    Ok(())
}

/// A device whose workgroups are fewer than the tiles need.
fn few_workgroups() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1647)?;
    let map = smooth(&mut random, [250, 130], false);
    let options = Fit { threshold: 0.01, sideways: 0.25, depth: 0.01, slope_bias: 1.0 }.options();
    let expected = walls_of(&gpu, &map, None, options)?;
    for most in [1, 2] {
        let found = walls_of(&limited(128 << 20, 256 << 20, most)?, &map, None, options)?;
        same(&format!("walls with {most} workgroups across"), &found, &expected)?;
    }
    if expected.len() > 500 { Ok(()) } else { Err(format!("{} walls", expected.len())) }
}

/// Workgroups for 48 tiles that a contour crosses, where a dispatch has few, and where the limit is the largest number.
fn workgroups() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let tiles = 48;
    let shape = uniform(gpu, &[tiles, tiles, 3_u32, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    for (most, right) in [(5, [3, 1, 1, 5, 5, 1]), (u32::MAX, [3, 1, 1, 24, 1, 1])] {
        // The tiles, and room for counts and list.
        let counts = gpu.storage(&[1_u32; 48 * 66 + 1]);
        let found = gpu.storage(&[0_u32; 6]);
        let source = CONTOUR_TILES.wgsl().replace(" = 65535u;", &format!(" = {most}u;"));
        let stage = Dispatch::new(gpu, &source, "contour_tiles_list");
        stage.run_bound(gpu, &[&[(5, &counts), (6, &shape), (10, &found)]], 1)?;
        same(&format!("{most} workgroups"), &gpu.read::<u32>(&found, 6)?, &right)?;
    }
    Ok(())
}

/// Loops over the walls of a tile have as many turns. Here every edge is marked, and no two segments are joined.
fn most_walls() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1648)?;
    // One tile: with the border of far samples it has 16 cells a side.
    let map = Map::new([15, 15], false, |_| random.between(0.2, 0.8));
    let numbers: Vec<u32> = (0..225).collect();
    let fit = Fit { threshold: 1.0, sideways: 0.0, depth: 0.0, slope_bias: 0.0 };
    let count = walls_of(&gpu, &map, Some(&numbers[..]), fit.options())?.len() as u64;
    let most = limits(1, 1)["TILE_WALLS"];
    println!("{count} walls and flaps, of at most {most}");
    // Not vacuous: more than eight a cell.
    if count > 8 * 256 && count <= most { Ok(()) } else { Err(format!("{count} walls and flaps, of at most {most}")) }
}

/// A list that overflows is not drawn: every cell is, by its triangles. Arguments and statistics agree.
fn overflow() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1643)?;
    let mut differ = 0;
    let walled = by(contours([0.0005, 0.25, 0.002]));
    for world in worlds(&mut random) {
        let Some(view) = View::random(&mut random, &world) else { continue };
        let maps = view.maps(&gpu, TextureFormat::Depth32Float)?;
        let depths = view.eye_depths();
        let target = Target::new(view.eye, &depths);
        let every = target.stencil(&gpu, &maps, by(EVERY_CELL))?;
        let cells = (maps.size[0] + 1) * (maps.size[1] + 1);
        let (stencil, encoded) = target.draw(&gpu, &maps, walled)?;
        let all = encoded.statistics.found;
        differ += usize::from(stencil != every);
        for capacity in [1 << 16, all, all - 1, 3] {
            let options = DepthMapOptions { capacity: Some(capacity), ..walled };
            let (found, encoded) = target.draw(&gpu, &maps, options)?;
            let statistics = [encoded.statistics.found, encoded.statistics.capacity];
            same("statistics", &statistics, &[all, capacity])?;
            let [walls, triangles] = if all > capacity { [0, 6 * cells] } else { [6 * all, 0] };
            let arguments: Vec<u32> = gpu.read(encoded.frame.draw_arguments(), usize::MAX)?;
            same("arguments", &arguments, &[walls, 1, 0, 0, triangles, 1, 0, 0])?;
            same("a picture", &found, if all > capacity { &every } else { &stencil })?;
        }
    }
    // Negative control: contours are not the same.
    if differ > 3 { Ok(()) } else { Err(format!("{differ} pictures differ")) }
}

/// The distance of a sample from the near plane, `None` where it casts nothing. Independent code.
pub(crate) fn distance(map: &Map, [x, y]: [i32; 2]) -> Option<i64> {
    let inside = x > 0 && y > 0 && x as u32 <= map.size[0] && y as u32 <= map.size[1];
    let depth = inside.then(|| f64::from(map.depths[((y - 1) as u32 * map.size[0] + (x - 1) as u32) as usize]))?;
    let is_far = depth.is_nan() || if map.is_reversed { depth < f64::from(f32::MIN_POSITIVE) } else { depth >= 1.0 };
    let units = (depth.clamp(0.0, 1.0) * UNIT).floor() as i64;
    let units = if map.is_reversed { UNIT as i64 - units } else { units };
    (!is_far).then(|| units.min(UNIT as i64 - 1))
}

/// Whether the distances of five samples, from a rim inwards, are those of a conic that ends along a ray of the light:
/// the squares of their differences from the rim's own are a quadratic polynomial. For maps of floats.
fn is_round(map: &Map, z: &[i64]) -> bool {
    let rises: Vec<_> = z.iter().map(|distance| z[0] - distance).collect();
    let off = if map.is_reversed { (UNIT as i64 - z[0]) >> 21 } else { 128 };
    if rises.windows(2).any(|pair| pair[0] >= pair[1]) || rises[1] < 1024.max(16 * off) {
        return false;
    }
    // With eleven bits of the first difference.
    let shift = (rises[1].ilog2() + 1).saturating_sub(11);
    let rises: Vec<_> = rises.iter().map(|rise| rise >> shift).collect();
    let differences: Vec<_> = rises.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let bend = differences[0] - 2 * differences[1] + differences[2];
    if differences.iter().any(|&difference| difference > differences[0]) || bend <= 0 {
        return false;
    }
    // The third difference of (rim + rise)² is 0, which is linear in the rim.
    let cube = |of: [i64; 4]| of[3] - 3 * of[2] + 3 * of[1] - of[0];
    let four = [rises[0], rises[1], rises[2], rises[3]];
    let (squares, linear) = (cube(four.map(|rise| rise * rise)), 2 * cube(four));
    if -squares * linear.signum() < 0 || squares.abs() / bend > 16 * differences[0] {
        return false;
    }
    let rim = -squares / linear;
    let further = [rises[1], rises[2], rises[3], rises[4]].map(|rise| (rim + rise) * (rim + rise));
    cube(further).abs() <= differences[0] * differences[0] / 8
}

/// Whether there is a jump between neighbours: the whole rule, by independent code, which shares no constant with the stage.
fn is_jump(map: &Map, numbers: Option<&[u32]>, threshold: i64, at: [i32; 2], step: [i32; 2]) -> bool {
    let there = |count: i32| [at[0] + count * step[0], at[1] + count * step[1]];
    let values: Vec<_> = (-3..=4).map(|count| distance(map, there(count))).collect();
    let difference = |first: usize| Some(values[first + 1]? - values[first]?);
    let (Some(a), Some(b)) = (values[3], values[4]) else { return values[3].is_some() != values[4].is_some() };
    let number =
        |[x, y]: [i32; 2]| numbers.map(|numbers| numbers[((y - 1) as u32 * map.size[0] + (x - 1) as u32) as usize]);
    if number(at) != number(there(1)) {
        return true;
    }
    let jump = (b - a).abs();
    if jump <= threshold {
        return false;
    }
    // The sign makes the second sample the farther one.
    let sign = if b > a { 1 } else { -1 };
    let (nearer, farther) = if b > a { ([2, 1], [4, 5]) } else { ([4, 5], [2, 1]) };
    let beside = |first: usize| difference(first).map(|difference| sign * difference);
    if [nearer[0], farther[0]].into_iter().filter_map(beside).any(|beside| (jump - beside).abs() <= threshold) {
        return false;
    }
    let slope = |[first, second]: [usize; 2]| match (beside(first), beside(second)) {
        (Some(a), Some(b)) if a.signum() * b.signum() >= 0 && (a >= 0) == (b >= 0) => {
            if a.abs() < b.abs() {
                a
            } else {
                b
            }
        }
        _ => 0,
    };
    let before = beside(nearer[0]).unwrap_or(0);
    // The next edge rises more, or leads to nothing, and the surface is round up to here.
    let towards = if b > a { [4, 3, 2, 1, 0] } else { [3, 4, 5, 6, 7] };
    let round: Option<Vec<_>> = towards.into_iter().map(|at| values[at]).collect();
    if beside(farther[0]).is_none_or(|after| after > jump) && round.is_some_and(|z| is_round(map, &z)) {
        return false;
    }
    let is_alone = beside(farther[0]).is_some_and(|after| before.max(after) / 2 < jump / 4);
    (jump > 16 * threshold || is_alone) && jump - slope(nearer).max(slope(farther)) > threshold
}

/// Whether the way from one sample to the next crosses a segment, neither through its end.
fn crosses([a, b]: [[i64; 2]; 2], [p, q]: [[i64; 2]; 2]) -> bool {
    let side = |from: [i64; 2], to: [i64; 2], at: [i64; 2]| {
        ((to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])).signum()
    };
    // A segment's first end counts, its second does not.
    let is_between = (side(a, b, p) >= 0) != (side(a, b, q) >= 0);
    is_between && side(p, q, a) * side(p, q, b) < 0
}

/// Checks that ends of walls cancel, and that the walls cross each jump once and no other edge.
fn check_closed(map: &Map, numbers: Option<&[u32]>, threshold: i64, quads: &[Quad]) -> Result<usize, String> {
    // The vertical ends: at each position and distance as many go down as go up.
    let mut ends: HashMap<[i32; 3], i32> = HashMap::new();
    let mut seams: HashMap<[[i32; 3]; 2], i32> = HashMap::new();
    let mut segments = HashSet::new();
    for quad in quads {
        for number in 0..4 {
            let [a, b] = [quad[number], quad[(number + 1) % 4]];
            if a[..2] == b[..2] {
                *ends.entry(a).or_default() += 1;
                *ends.entry(b).or_default() -= 1;
            }
        }
        for side in [[quad[0], quad[1]], [quad[3], quad[2]]] {
            if side[0][..2] != side[1][..2] {
                *seams.entry(side).or_default() += 1;
            }
        }
        let [a, b, c, d] = *quad;
        if a[..2] == b[..2] && c[..2] == d[..2] && a[..2] != c[..2] {
            let [p, q] = [a, c].map(|[x, y, _]| [i64::from(x), i64::from(y)]);
            segments.insert(if p < q { [p, q] } else { [q, p] });
        }
    }
    if let Some((at, _)) = ends.iter().find(|(_, sum)| **sum != 0) {
        return Err(format!("ends at {at:?} do not cancel"));
    }
    // Sides of flaps, from a sample to a position on an edge, belong to two flaps.
    if let Some((seam, count)) = seams.iter().find(|(_, count)| *count % 2 != 0) {
        return Err(format!("{count} flaps at {seam:?}"));
    }
    let edge = |[x, y]: [i64; 2], axis: usize| {
        let step = [[256, 0], [0, 256]][axis];
        [[256 * x, 256 * y], [256 * x + step[0], 256 * y + step[1]]]
    };
    let mut crossings: HashMap<([i64; 2], usize), usize> = HashMap::new();
    for &[a, b] in &segments {
        let cells = |axis: usize| a[axis].min(b[axis]).div_euclid(256)..=a[axis].max(b[axis]).div_euclid(256) + 1;
        for at in cells(1).flat_map(|y| cells(0).map(move |x| [x, y])) {
            for axis in [0, 1] {
                *crossings.entry((at, axis)).or_default() += usize::from(crosses(edge(at, axis), [a, b]));
            }
        }
    }
    let (mut crossed, size) = (0, map.size.map(|texels| texels as i32 + 1));
    for (x, y, axis) in (0..=size[1]).flat_map(|y| (0..=size[0]).flat_map(move |x| [(x, y, 0), (x, y, 1)])) {
        let step = [[1, 0], [0, 1]][axis];
        if x + step[0] > size[0] || y + step[1] > size[1] {
            continue;
        }
        let found = crossings.get(&([x, y].map(i64::from), axis)).copied().unwrap_or(0);
        let is_marked = is_jump(map, numbers, threshold, [x, y], step);
        if found != usize::from(is_marked) {
            return Err(format!("{found} walls cross from {:?} along {axis}, a jump: {is_marked}", [x, y]));
        }
        crossed += found;
    }
    Ok(crossed)
}

fn closed() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1642)?;
    let mut crossed = 0;
    for round in 0..if is_long() { 15 } else { 3 } {
        let mut given = maps(&mut random);
        for size in [[70, 45], [130, 120]] {
            given.extend([false, true].map(|is_reversed| smooth(&mut random, size, is_reversed)));
        }
        for map in given {
            let fit = Fit {
                threshold: [0.0005, 0.007_812_5, 0.125][random.below(3)],
                sideways: [0.0, 0.25, 0.5][round % 3],
                depth: [0.0, 0.002, 1.0][random.below(3)],
                slope_bias: [0.0, 1.0][random.below(2)],
            };
            // Objects of several texels, whose edges may be without a jump.
            let numbers: Vec<_> = (0..map.depths.len() as u32)
                .map(|texel| (texel % map.size[0] / 5 + texel / map.size[0] / 7) % 3)
                .collect();
            let numbers = (random.below(3) == 0).then_some(&numbers[..]);
            let quads = walls_of(&gpu, &map, numbers, fit.options())?;
            let threshold = (f64::from(fit.threshold) * UNIT).round() as i64;
            let check = |quads: &[Quad]| check_closed(&map, numbers, threshold, quads);
            let what = |error| format!("{:?}, reversed {}, {fit:?}: {error}", map.size, map.is_reversed);
            crossed += check(&quads).map_err(what)?;
            // Negative control: a wall is missing, or a vertex is elsewhere.
            if quads.len() > 4 {
                let at = random.below(quads.len());
                if quads[at][0][..2] == quads[at][1][..2] && quads[at][0] != quads[at][1] {
                    must_fail("a missing wall", &check(&[&quads[..at], &quads[at + 1..]].concat()))?;
                }
                let mut moved = quads;
                moved[at][0][2] ^= 1;
                must_fail("a moved vertex", &check(&moved))?;
            }
        }
    }
    println!("{crossed} edges are crossed");
    if crossed > 20_000 { Ok(()) } else { Err("too few".to_owned()) }
}

/// A jump that fades along rows or columns, so that a contour ends in the last cell of a tile that no other crosses.
fn ends_beside_a_tile() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let fit = Fit { threshold: 0.1, sideways: 0.25, depth: 0.01, slope_bias: 0.0 };
    for is_column in [false, true] {
        // The sample 0 of the lattice lies before texel 0. The jump is above the threshold from sample 32 on.
        let map = Map::new([48; 2], false, |texel| {
            let [x, y] = [texel % 48 + 1, texel / 48 + 1];
            let [along, across] = if is_column { [y, x] } else { [x, y] };
            0.3 + if across > 20 { 0.009 * along.saturating_sub(20) as f32 } else { 0.0 }
        });
        let quads = walls_of(&gpu, &map, None, fit.options())?;
        let check = |quads: &[Quad]| check_closed(&map, None, (f64::from(fit.threshold) * UNIT).round() as i64, quads);
        check(&quads).map_err(|error| format!("column {is_column}: {error}"))?;
        // Negative control: the wall up to the middle of the last cell is missing.
        let [across, along] = [20, 31].map(|at| 256 * at + 128);
        let end: [i32; 2] = if is_column { [across, along] } else { [along, across] };
        let others: Vec<Quad> =
            quads.iter().filter(|quad| quad.iter().all(|vertex| vertex[..2] != end)).copied().collect();
        must_fail("no wall at the end", &check(&others))?;
    }
    Ok(())
}

const SIDE: u32 = 96;

/// Body that a map shows before a ground.
#[derive(Clone, Copy, Debug)]
enum Body {
    /// Round towards the light: its depths determine its rim.
    Ellipsoid,
    /// Flat, with a round border: only its border determines it.
    Disc,
    /// Flat, with a straight border.
    HalfPlane,
}

/// A body in a map, in texels.
#[derive(Clone, Copy, Debug)]
struct Placed {
    body: Body,
    middle: [f64; 2],
    /// The axis of the ellipse, or what is at right angles to the border.
    axis: [f64; 2],
    radii: [f64; 2],
    /// The slope of the body along x and y.
    slopes: [f64; 2],
}

impl Placed {
    fn random(body: Body, random: &mut Random) -> Self {
        let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
        let angle = between(0.0, std::f32::consts::TAU);
        Self {
            body,
            middle: [between(40.0, 56.0), between(40.0, 56.0)],
            axis: [angle.cos(), angle.sin()],
            radii: [between(12.0, 36.0), between(12.0, 36.0)],
            slopes: [between(-0.001, 0.001), between(-0.001, 0.001)],
        }
    }

    /// More than 0 within the body. The square of the height, of an ellipsoid.
    fn inside(&self, [x, y]: [f64; 2]) -> f64 {
        let [x, y] = [x - self.middle[0], y - self.middle[1]];
        let along = x * self.axis[0] + y * self.axis[1];
        let across = y * self.axis[0] - x * self.axis[1];
        match self.body {
            Body::HalfPlane => along,
            Body::Ellipsoid | Body::Disc => 1.0 - (along / self.radii[0]).powi(2) - (across / self.radii[1]).powi(2),
        }
    }

    fn depth(&self, position: [f64; 2]) -> f64 {
        let inside = self.inside(position);
        if inside <= 0.0 {
            return 0.9;
        }
        let height = if matches!(self.body, Body::Ellipsoid) { 0.2 * inside.sqrt() } else { 0.0 };
        0.5 + self.slopes[0] * (position[0] - 48.0) + self.slopes[1] * (position[1] - 48.0) - height
    }

    fn map(&self, is_reversed: bool) -> Map {
        Map::new([SIDE; 2], is_reversed, |texel| {
            let depth = self.depth([texel % SIDE, texel / SIDE].map(|at| f64::from(at) + 0.5));
            if is_reversed { 1.0 - depth as f32 } else { depth as f32 }
        })
    }

    /// Where the border is on an edge, in parts of a texel from its first sample on.
    fn crossing(&self, at: [u32; 2], axis: usize) -> f64 {
        let on = |along: f64| {
            let mut position = at.map(|at| f64::from(at) - 0.5);
            position[axis] += along;
            self.inside(position) > 0.0
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = f64::midpoint(low, high);
            if on(middle) == on(0.0) { low = middle } else { high = middle }
        }
        low
    }
}

/// Errors of crossings in the mean, in texels.
fn on_rims() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1691)?;
    // Segments go through the crossings that they join, so these move by rounding to 1/256 texel alone.
    let fit = Fit { threshold: 1.0 / 2048.0, sideways: 0.0, depth: 0.0, slope_bias: 1.0 };
    // The middle of an edge is a fourth of a texel off in the mean.
    for (body, most) in [(Body::Ellipsoid, 0.03), (Body::Disc, 0.13), (Body::HalfPlane, 0.095)] {
        // Sums of errors, those of the middles of edges, and those of the other side of edges.
        let (mut edges, mut off) = (0, [0.0; 3]);
        for round in 0..if is_long() { 400 } else { 30 } {
            let placed = Placed::random(body, &mut random);
            let formats = [TextureFormat::R32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];
            let map = rounded(&placed.map(round % 2 == 1), formats[round % 3]);
            let options = DepthMapOptions { rounded_to: Some(formats[round % 3]), ..fit.options() };
            let vertices = walls_of(&gpu, &map, None, options)?.concat();
            // Vertices on edges, but for the outermost, which lead out of the map.
            for [x, y] in vertices.iter().map(|vertex| [vertex[0], vertex[1]]).collect::<HashSet<_>>() {
                let at = [x, y].map(|along| along as u32 / 256);
                let axis = usize::from(x % 256 == 0);
                let crossing = [x, y][axis] % 256;
                if crossing == 0 || [x, y][1 - axis] % 256 != 0 || at.iter().any(|at| !(2..SIDE - 1).contains(at)) {
                    continue;
                }
                let (crossing, truth) = (f64::from(crossing) / 256.0, placed.crossing(at, axis));
                edges += 1;
                [crossing, 0.5, 1.0 - crossing]
                    .into_iter()
                    .zip(&mut off)
                    .for_each(|(at, off)| *off += (at - truth).abs());
            }
        }
        let off = off.map(|off| off / f64::from(edges));
        println!("{body:?}: {edges} edges, off in the mean, their middles, and other sides: {off:?}");
        if edges < 1000 || off[0] > most || off[1].min(off[2]) < most {
            return Err(format!("{body:?}: {edges} edges, {off:?} texels off, most is {most}"));
        }
    }
    Ok(())
}
