//! Walls over contours by `contour_marks`, `contour_tiles` and `contour_walls`: lists against goldens, and those that
//! overflow.

use rimline::gpu::depth_map::{DepthMapOptions, DepthMapPipelines};
use rimline::internals::layout::ContourShape;
use rimline_testkit::device::Gpu;
use rimline_testkit::goldens::golden;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::limited;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, same};
use wgpu::TextureFormat;

use crate::maps::{Map, further, maps};
use crate::picture::{EVERY_CELL, Encoded, Maps, REVERSED, Target, Volumes, by, contours, pipelines};
use crate::stages::{camera, is_short};
use crate::views::{View, worlds};
use rimline_testkit::textures::{objects, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("lists_of_walls_are_the_goldens", lists),
    ("contours_through_every_cell_are_the_goldens", long),
    ("lists_of_walls_of_few_workgroups_are_the_goldens", few_workgroups),
    ("steep_surfaces_end_before_those_behind", before_those_behind),
    ("walls_that_overflow_are_those_of_every_cell", overflow),
];

/// The unit of distances.
pub(crate) const UNIT: f64 = 536_870_912.0;

/// How contours are found, as the options say it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fit {
    pub(crate) threshold: f32,
    pub(crate) sideways: f32,
    pub(crate) depth: f32,
    pub(crate) slope_bias: f32,
}

impl Fit {
    pub(crate) fn options(self) -> DepthMapOptions {
        let method = contours([self.threshold, self.sideways, self.depth]);
        DepthMapOptions { slope_bias: self.slope_bias, capacity: Some(100_000), ..by(method) }
    }

    /// Uniform of the stages, for a map in a format.
    pub(crate) fn shape(self, map: &Map, format: TextureFormat, capacity: u32) -> ContourShape {
        let units = |depth: f32| (f64::from(depth) * UNIT).round().min(UNIT) as i32;
        let tolerance = units(self.depth);
        // Four bits are left of a tolerance.
        let shift = if tolerance < 16 { 0 } else { 28 - tolerance.leading_zeros() };
        let tiles = map.size.map(|texels| (texels + 16) / 16);
        let is_float = matches!(format, TextureFormat::R32Float | TextureFormat::Depth32Float);
        let [noise_share, noise_constant] = match format {
            TextureFormat::Depth16Unorm => [0, 1 << 15],
            _ if is_float && map.is_reversed => [256, 0],
            _ => [0, 128],
        };
        ContourShape {
            tiles: [tiles[0], tiles[0] * tiles[1]],
            words: (map.size[0] + 17) / 16,
            capacity,
            threshold: units(self.threshold),
            certain_threshold: (f64::from(self.threshold) * 16.0 * UNIT).round().min(UNIT) as i32,
            sideways: (f64::from(self.sideways) * 256.0).round() as i32,
            tolerance: tolerance >> shift,
            shift,
            slope_bias: (f64::from(self.slope_bias) * 128.0).round() as i32,
            noise_share,
            noise_constant,
        }
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
    let vertex = |words: &[i32]| [words[0], words[1], words[2]];
    let quad = |words: &[i32]| [0, 3, 6, 9].map(|at| vertex(&words[at..]));
    Ok((head[0], words[4..].chunks_exact(12).map(quad).collect()))
}

/// A list of walls as words: the number, and the words of the quadrilaterals.
fn words((count, quads): &(u32, Vec<Quad>)) -> Vec<u32> {
    std::iter::once(*count).chain(quads.iter().flatten().flatten().map(|&word| word as u32)).collect()
}

/// Results of the contour stages for a map of floats.
pub(crate) struct Traced {
    pub(crate) shape: ContourShape,
    pub(crate) quads: Vec<Quad>,
    /// The list, with the words before it.
    pub(crate) list: Vec<u32>,
    pub(crate) marks: wgpu::Buffer,
    pub(crate) crossings: wgpu::Buffer,
    pub(crate) counts: wgpu::Buffer,
}

impl Traced {
    /// `rounded_to`: the format whose steps the depths have, if it is another.
    pub(crate) fn new(gpu: &Gpu, map: &Map, fit: Fit, rounded_to: Option<TextureFormat>) -> Result<Self, String> {
        let options = DepthMapOptions { rounded_to, ..fit.options() };
        let maps = Maps::of(gpu, map, TextureFormat::R32Float, camera(map.direction()))?;
        let encoded = Encoded::new(gpu, &*pipelines(gpu, REVERSED, 7..8)?, &maps, &camera(REVERSED), options)?;
        let (count, quads) = listed(gpu, encoded.volumes.cells())?;
        let Volumes::Map(volumes) = &encoded.volumes else { return Err("one map".to_owned()) };
        let [marks, crossings, counts] = volumes.contour_buffers().ok_or("no contours")?.map(Clone::clone);
        let mut list = words(&(count, quads.clone()));
        list.splice(1..1, [0; 3]);
        let shape = fit.shape(map, rounded_to.unwrap_or(TextureFormat::R32Float), 100_000);
        Ok(Self { shape, quads, list, marks, crossings, counts })
    }
}

/// Walls of a map on the GPU.
fn walls(
    gpu: &Gpu,
    pipelines: &DepthMapPipelines,
    (map, texture): (&Map, &wgpu::Texture),
    numbers: Option<&[u32]>,
    options: DepthMapOptions,
) -> Result<(u32, Vec<Quad>), String> {
    let mut maps = Maps::one(texture, camera(map.direction()));
    maps.objects = vec![numbers.map(|numbers| objects(gpu, map.size, numbers))];
    listed(gpu, Encoded::new(gpu, pipelines, &maps, &camera(REVERSED), options)?.volumes.cells())
}

/// Walls of a map of floats.
pub(crate) fn walls_of(gpu: &Gpu, map: &Map, numbers: Option<&[u32]>, fit: Fit) -> Result<Vec<Quad>, String> {
    let texture = texture(gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    Ok(walls(gpu, &*pipelines(gpu, REVERSED, 7..8)?, (map, &texture), numbers, fit.options())?.1)
}

/// The depths in steps of a format, as a test rounds them.
pub(crate) fn rounded(map: &Map, format: TextureFormat) -> Map {
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
    let pipelines = pipelines(&gpu, REVERSED, 7..8)?;
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
        for (number, map) in (0..).zip(given) {
            // Maps of the long run change no other.
            let mut random = Random::new(1000 * (SEED + of_format) + number);
            let is_short = is_short(&map, format);
            if !is_short && !is_long() {
                continue;
            }
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
            let of = |map: &Map, format, options| {
                let texture = texture(&gpu, map.size, format, &map.for_format(format).depths)?;
                let walls = walls(&gpu, &pipelines, (map, &texture), numbers, options)?;
                Ok::<_, String>((Map { depths: read(&gpu, &texture)?, ..map.clone() }, walls))
            };
            let (stored, found) = of(&map, format, options)?;
            all += found.0;
            let of_floats = |map: &Map| {
                let options = DepthMapOptions { rounded_to: Some(format), ..options };
                Ok::<_, String>(of(map, TextureFormat::R32Float, options)?.1)
            };
            let is_float = matches!(format, TextureFormat::R32Float | TextureFormat::Depth32Float);
            // Floats have the same list if they are stated to be rounded to the format. With reversed depth the error
            // of floats is added.
            if is_float || !map.is_reversed {
                let what = format!("{format:?} {:?}, reversed {}, {fit:?}", map.size, map.is_reversed);
                same(&what, &of_floats(&stored)?.1, &found.1)?;
            }
            // Which of two steps a depth is rounded to is the driver's choice, so goldens are of floats.
            if is_short {
                let result = if is_float { found } else { of_floats(&rounded(&map, format))? };
                golden("depth_map", &format!("walls {number:03} of {format:?}"), &words(&result))?;
            }
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
    let walls = walls_of(&gpu, &map, None, fit)?.concat();
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
            let quads = walls_of(&gpu, &spirals(&mut random, is_loop), None, fit)?;
            let name = format!("walls of spirals, loops {is_loop}, sideways {sideways}, depth {depth}");
            println!("{} {name}", quads.len());
            golden("depth_map", &name, &words(&(quads.len() as u32, quads)))?;
        }
    }
    Ok(())
}

/// A device whose workgroups are fewer than the tiles need.
fn few_workgroups() -> Result<(), String> {
    const SEED: u64 = 1647;
    println!("seed {SEED}");
    let mut random = Random::new(SEED);
    for most in [1, 2, 65_535] {
        let gpu = limited(128 << 20, 256 << 20, most)?;
        let map = smooth(&mut random, [250, 130], false);
        let fit = Fit { threshold: 0.01, sideways: 0.25, depth: 0.01, slope_bias: 1.0 };
        let quads = walls_of(&gpu, &map, None, fit)?;
        println!("{} walls with {most} workgroups across", quads.len());
        golden("depth_map", &format!("walls of {most} workgroups across"), &words(&(quads.len() as u32, quads)))?;
    }
    Ok(())
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
            let is_overflowed = all > capacity;
            let statistics = [encoded.statistics.found, encoded.statistics.capacity];
            same("statistics", &statistics, &[all, capacity])?;
            same("overflown", &[encoded.statistics.is_overflowed()], &[is_overflowed])?;
            let [walls, triangles] = if is_overflowed { [0, 6 * cells] } else { [6 * all, 0] };
            let arguments: Vec<u32> = gpu.read(encoded.frame.draw_arguments(), usize::MAX)?;
            same("arguments", &arguments, &[walls, 1, 0, 0, triangles, 1, 0, 0])?;
            same("a picture", &found, if is_overflowed { &every } else { &stencil })?;
        }
    }
    // Negative control: contours are not the same.
    if differ > 3 { Ok(()) } else { Err(format!("{differ} pictures differ")) }
}
