//! Walls over contours by `contour_marks`, `contour_tiles` and `contour_walls`: lists against goldens, what closes them, and what
//! they cross.

use std::collections::{HashMap, HashSet};

use rimline::DepthDirection;
use rimline::gpu::depth_map::{
    DepthMap, DepthMapCube, DepthMapError, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes,
};
use rimline::gpu::{DeviceError, ShadowFormat};
use rimline::reference::layout::ContourShape;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::maps::{Map, further, maps};
use crate::picture::{Picture, pipelines};
use crate::stages::{camera, direction, is_short};
use crate::textures::{depth_view, objects, read, texture};
use crate::views::{SIDE, View, worlds};
use rimline_testkit::goldens::golden;

pub(crate) const TESTS: &[Test] = &[
    ("lists_of_walls_are_the_goldens", lists),
    ("contours_through_every_cell_are_the_goldens", long),
    ("lists_of_walls_of_few_workgroups_are_the_goldens", few_workgroups),
    ("steep_surfaces_end_before_those_behind", before_those_behind),
    ("walls_are_closed_and_cross_marked_edges_once", closed),
    ("walls_that_overflow_are_those_of_every_cell", overflow),
    ("walls_of_smooth_bodies_are_few", few),
    ("contours_that_cannot_be_traced_are_refused", refused),
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
        let Self { threshold, sideways, depth, .. } = self;
        DepthMapOptions {
            method: DepthMapMethod::Contours { threshold, sideways, depth },
            slope_bias: self.slope_bias,
            ..Default::default()
        }
    }

    /// Uniform of the stages, for a map in a format.
    pub(crate) fn shape(self, map: &Map, format: TextureFormat, capacity: u32) -> ContourShape {
        let units = |depth: f32| (f64::from(depth) * UNIT).round().min(UNIT) as i32;
        let tolerance = units(self.depth);
        // Four bits are left of a tolerance.
        let shift = if tolerance < 16 { 0 } else { 28 - tolerance.leading_zeros() };
        let tiles = map.size.map(|texels| (texels + 16) / 16);
        let is_float = matches!(format, TextureFormat::R32Float | TextureFormat::Depth32Float);
        let [share, constant] = match format {
            TextureFormat::Depth16Unorm => [0, 1 << 15],
            _ if is_float && map.is_reversed => [256, 0],
            _ => [0, 128],
        };
        ContourShape {
            tiles: [tiles[0], tiles[0] * tiles[1]],
            words: (map.size[0] + 17) / 16,
            capacity,
            threshold: units(self.threshold),
            sure: (f64::from(self.threshold) * 16.0 * UNIT).round().min(UNIT) as i32,
            sideways: (f64::from(self.sideways) * 256.0).round() as i32,
            tolerance: tolerance >> shift,
            shift,
            slope_bias: (f64::from(self.slope_bias) * 128.0).round() as i32,
            share,
            constant,
        }
    }
}

fn far(is_reversed: bool) -> f32 {
    if is_reversed { 0.0 } else { 1.0 }
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

/// The sine of `lobes` times the angle of a place: by products alone, which are the same on every machine, as goldens need.
fn wave(lobes: u32, [x, y]: [f64; 2]) -> f64 {
    let length = (x * x + y * y).sqrt().max(f64::MIN_POSITIVE);
    let unit = [x / length, y / length];
    let turned = |[a, b]: [f64; 2], _| [a * unit[0] - b * unit[1], a * unit[1] + b * unit[0]];
    (0..lobes).fold([1.0, 0.0], turned)[1]
}

/// Bodies with smooth rims over ground or nothing, some behind others.
fn smooth(random: &mut Random, size: [u32; 2], is_reversed: bool) -> Map {
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
            let reach = radius * (1.0 + share * wave(*lobes as u32, [x, y]));
            let inside = 1.0 - (x * x + y * y) / (reach * reach);
            if inside > 0.0 {
                depth = depth.min(near - 0.05 * inside.sqrt() + slope * x);
            }
        }
        if depth.is_infinite() {
            far(is_reversed)
        } else if is_reversed {
            1.0 - depth as f32
        } else {
            depth as f32
        }
    })
}

/// A wall: four vertices of a place and a distance.
pub(crate) type Quad = [[i32; 3]; 4];

/// The walls that the GPU lists, and their number.
pub(crate) fn listed(volumes: &DepthMapVolumes, gpu: &Gpu) -> Result<(u32, Vec<Quad>), String> {
    let head: Vec<u32> = gpu.read(volumes.cells(), 4)?;
    same("words before the list", &head[1..], &[0; 3])?;
    let room = (volumes.cells().size() / 4 - 4) / 12;
    let words: Vec<i32> = gpu.read(volumes.cells(), 4 + 12 * u64::from(head[0]).min(room) as usize)?;
    let vertex = |words: &[i32]| [words[0], words[1], words[2]];
    let quad = |words: &[i32]| [0, 3, 6, 9].map(|at| vertex(&words[at..]));
    Ok((head[0], words[4..].chunks_exact(12).map(quad).collect()))
}

/// A list of walls as it is in its buffer: the number, and the words of the quadrilaterals.
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
    pub(crate) places: wgpu::Buffer,
    pub(crate) counts: wgpu::Buffer,
}

impl Traced {
    /// `rounded_to`: the format whose steps the depths have, if it is another.
    pub(crate) fn new(gpu: &Gpu, map: &Map, fit: Fit, rounded_to: Option<TextureFormat>) -> Result<Self, String> {
        let capacity = 100_000;
        let options = DepthMapOptions { capacity: Some(capacity), rounded_to, ..fit.options() };
        let pipelines = pipelines(gpu, DepthDirection::Reversed, 7..8)?;
        let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
        Given::new(gpu, map, TextureFormat::R32Float)?.encode(gpu, &mut volumes, None)?;
        let (count, quads) = listed(&volumes, gpu)?;
        let [marks, places, counts] = volumes.contour_buffers().ok_or("no contours")?.map(Clone::clone);
        let list = [count, 0, 0, 0].into_iter().chain(quads.iter().flatten().flatten().map(|&word| word as u32));
        let shape = fit.shape(map, rounded_to.unwrap_or(TextureFormat::R32Float), capacity);
        Ok(Self { shape, list: list.collect(), quads, marks, places, counts })
    }
}

/// A map on the GPU, and what its shaders read.
struct Given {
    texture: wgpu::Texture,
    map: Map,
}

impl Given {
    fn new(gpu: &Gpu, map: &Map, format: TextureFormat) -> Result<Self, String> {
        let clamped = |depth: &f32| if depth.is_nan() { 0.5 } else { depth.clamp(0.0, 1.0) };
        let is_plain = format == TextureFormat::R32Float;
        let depths = if is_plain { map.depths.clone() } else { map.depths.iter().map(clamped).collect() };
        let texture = texture(gpu, map.size, format, &depths)?;
        let depths = read(gpu, &texture)?;
        Ok(Self { texture, map: Map { depths, ..map.clone() } })
    }

    fn encode(&self, gpu: &Gpu, volumes: &mut DepthMapVolumes, objects: Option<&wgpu::Texture>) -> Result<(), String> {
        let eye = camera(DepthDirection::Reversed);
        let objects = objects.map(|objects| objects.create_view(&wgpu::TextureViewDescriptor::default()));
        let (texture, light) = (depth_view(&self.texture), camera(direction(&self.map)));
        gpu.submit(|encoder| {
            let given = DepthMap { texture: &texture, light, objects: objects.as_ref() };
            volumes.encode(encoder, &given, &eye).map(drop).map_err(text)
        })
    }
}

/// The depths in steps of a format, as a test rounds them.
fn rounded(map: &Map, format: TextureFormat) -> Map {
    let steps = if format == TextureFormat::Depth16Unorm { 65_535.0 } else { 16_777_215.0 };
    let round = |&depth: &f32| {
        let depth = if depth.is_nan() { 0.5 } else { f64::from(depth).clamp(0.0, 1.0) };
        ((depth * steps).round() / steps) as f32
    };
    Map { depths: map.depths.iter().map(round).collect(), ..map.clone() }
}

fn lists() -> Result<(), String> {
    const SEED: u64 = 1641;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
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
            let has_objects = random.below(4) == 0;
            let options = DepthMapOptions {
                capacity: Some(if random.below(5) == 0 { random.below(40) as u32 } else { 100_000 }),
                ..fit.options()
            };
            let given = Given::new(&gpu, &map, format)?;
            let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
            let numbers_given = has_objects.then(|| objects(&gpu, map.size, &numbers));
            given.encode(&gpu, &mut volumes, numbers_given.as_ref())?;
            let found = listed(&volumes, &gpu)?;
            let what = format!("{format:?} {:?}, reversed {}, {fit:?}", map.size, map.is_reversed);
            all += found.0;
            let of_floats = |map: &Map| {
                let options = DepthMapOptions { rounded_to: Some(format), ..options };
                let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
                Given::new(&gpu, map, TextureFormat::R32Float)?.encode(&gpu, &mut volumes, numbers_given.as_ref())?;
                listed(&volumes, &gpu)
            };
            let is_float = matches!(format, TextureFormat::R32Float | TextureFormat::Depth32Float);
            // Floats have the same list if they are taken as rounded to the format. Where depths are reversed, what floats may be
            // off is added.
            if is_float || !map.is_reversed {
                same(&what, &of_floats(&given.map)?.1, &found.1)?;
            }
            // Which of two steps a depth is rounded to is the driver's choice, so goldens are of floats.
            if is_short {
                let own = if is_float { found } else { of_floats(&rounded(&map, format))? };
                golden("depth_map", &format!("walls {number:03} of {format:?}"), &words(&own))?;
            }
        }
    }
    println!("{all} walls");
    if all > 50_000 { Ok(()) } else { Err("too few".to_owned()) }
}

/// A slope that ends three and a half of its steps before a plane. It goes on more steeply, but not behind the plane.
fn before_those_behind() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let unit = |depth: f64| (depth * 536_870_912.0) as i32;
    let map = Map::new([18, 40], false, |texel| match texel % 18 {
        x @ ..9 => 0.25 + 0.01 * x as f32,
        _ => 0.365,
    });
    let fit = Fit { threshold: 0.005, sideways: 0.25, depth: 0.01, slope_bias: 0.0 };
    let mut volumes = DepthMapVolumes::new(&pipelines, map.size, fit.options()).map_err(text)?;
    Given::new(&gpu, &map, TextureFormat::R32Float)?.encode(&gpu, &mut volumes, None)?;
    let (_, walls) = listed(&volumes, &gpu)?;
    // Between the slope and the plane, away from the border of the map.
    let inner =
        |vertex: &[i32; 3]| (9 * 256..=10 * 256).contains(&vertex[0]) && (10 * 256..30 * 256).contains(&vertex[1]);
    let depths: Vec<_> = walls.concat().iter().filter(|vertex| inner(vertex)).map(|vertex| vertex[2]).collect();
    let (least, most) = (depths.iter().min(), depths.iter().max());
    // Four slopes are more than the jump, which would end at 0.37.
    let is_right = |depth: Option<&i32>| depth.is_some_and(|&depth| (unit(0.364)..unit(0.366)).contains(&depth));
    let is_slope = |depth: Option<&i32>| depth.is_some_and(|&depth| depth >= unit(0.329));
    if is_right(most) && is_slope(least) { Ok(()) } else { Err(format!("{depths:?}")) }
}

/// The distance of a sample from the near plane, `None` where it casts nothing. A text of its own.
pub(crate) fn distance(map: &Map, [x, y]: [i32; 2]) -> Option<i64> {
    let inside = x > 0 && y > 0 && x as u32 <= map.size[0] && y as u32 <= map.size[1];
    let depth = inside.then(|| f64::from(map.depths[((y - 1) as u32 * map.size[0] + (x - 1) as u32) as usize]))?;
    let is_far = depth.is_nan() || if map.is_reversed { depth < f64::from(f32::MIN_POSITIVE) } else { depth >= 1.0 };
    let units = (depth.clamp(0.0, 1.0) * UNIT).floor() as i64;
    let units = if map.is_reversed { UNIT as i64 - units } else { units };
    (!is_far).then(|| units.min(UNIT as i64 - 1))
}

/// Whether the distances of five samples, from a rim inwards, are those of a conic that ends along a ray of the light: the squares
/// of their differences from the rim's own are a quadratic polynomial. For maps of floats.
fn is_round(map: &Map, z: &[i64]) -> bool {
    let gone: Vec<_> = z.iter().map(|own| z[0] - own).collect();
    let off = if map.is_reversed { (UNIT as i64 - z[0]) >> 21 } else { 128 };
    if gone.windows(2).any(|pair| pair[0] >= pair[1]) || gone[1] < 1024.max(16 * off) {
        return false;
    }
    // With eleven bits of the first difference.
    let shift = (gone[1].ilog2() + 1).saturating_sub(11);
    let gone: Vec<_> = gone.iter().map(|gone| gone >> shift).collect();
    let differences: Vec<_> = gone.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let bend = differences[0] - 2 * differences[1] + differences[2];
    if differences.iter().any(|&difference| difference > differences[0]) || bend <= 0 {
        return false;
    }
    // The third difference of (rim + gone)² is 0, which is linear in the rim.
    let cube = |of: [i64; 4]| of[3] - 3 * of[2] + 3 * of[1] - of[0];
    let four = [gone[0], gone[1], gone[2], gone[3]];
    let (squares, linear) = (cube(four.map(|gone| gone * gone)), 2 * cube(four));
    if -squares * linear.signum() < 0 || squares.abs() / bend > 16 * differences[0] {
        return false;
    }
    let rim = -squares / linear;
    let further = [gone[1], gone[2], gone[3], gone[4]].map(|gone| (rim + gone) * (rim + gone));
    cube(further).abs() <= differences[0] * differences[0] / 8
}

/// Whether there is a jump between neighbours: the rule as the documentation has it.
pub(crate) fn is_jump(map: &Map, numbers: Option<&[u32]>, threshold: i64, at: [i32; 2], step: [i32; 2]) -> bool {
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

/// Checks that ends of walls cancel, and that the walls cross each marked edge once and no other.
fn check_closed(map: &Map, numbers: Option<&[u32]>, threshold: i64, quads: &[Quad]) -> Result<usize, String> {
    // The vertical ends at each place: every distance between two ends lies in as many as go down as go up.
    let mut ends: HashMap<[i32; 2], Vec<(i32, i32)>> = HashMap::new();
    let mut seams: HashMap<[[i32; 3]; 2], i32> = HashMap::new();
    let mut segments = HashSet::new();
    for quad in quads {
        for number in 0..4 {
            let [a, b] = [quad[number], quad[(number + 1) % 4]];
            if a[..2] == b[..2] {
                ends.entry([a[0], a[1]]).or_default().push((a[2], b[2]));
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
    for (place, ends) in &ends {
        let mut turns: Vec<_> = ends.iter().flat_map(|&(from, to)| [(from, 1), (to, -1)]).collect();
        turns.sort_unstable();
        let mut sum = 0;
        for (at, turn) in
            turns.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same.iter().map(|turn| turn.1).sum::<i32>()))
        {
            sum += turn;
            if turn != 0 {
                return Err(format!("at {place:?} ends at {at} do not cancel: {ends:?}"));
            }
        }
        if sum != 0 {
            return Err(format!("at {place:?} ends do not cancel: {ends:?}"));
        }
    }
    // Sides of flaps, from a sample to a place on an edge, belong to two flaps.
    if let Some((seam, count)) = seams.iter().find(|(_, count)| *count % 2 != 0) {
        return Err(format!("{count} flaps at {seam:?}"));
    }
    let mut by_cell: HashMap<[i64; 2], Vec<[[i64; 2]; 2]>> = HashMap::new();
    for &[a, b] in &segments {
        let cells = |axis: usize| a[axis].min(b[axis]).div_euclid(256)..=a[axis].max(b[axis]).div_euclid(256);
        for x in cells(0) {
            for y in cells(1) {
                by_cell.entry([x, y]).or_default().push([a, b]);
            }
        }
    }
    let mut marked = 0;
    let size = map.size.map(|texels| texels as i32);
    for (x, y) in (0..=size[1] + 1).flat_map(|y| (0..=size[0] + 1).map(move |x| (x, y))) {
        for step in [[1, 0], [0, 1]] {
            let other = [x + step[0], y + step[1]];
            if other[0] > size[0] + 1 || other[1] > size[1] + 1 {
                continue;
            }
            let way = [[x, y], other].map(|at| at.map(|place| i64::from(place) * 256));
            let mut near: HashSet<[[i64; 2]; 2]> = HashSet::new();
            for cell in [[x, y], [x - step[1], y - step[0]]] {
                near.extend(by_cell.get(&cell.map(i64::from)).into_iter().flatten());
            }
            let crossed = near.iter().filter(|&&segment| crosses(way, segment)).count();
            let is_marked = is_jump(map, numbers, threshold, [x, y], step);
            marked += usize::from(is_marked);
            if crossed != usize::from(is_marked) {
                let ends: Vec<_> = near.iter().filter(|&&segment| crosses(way, segment)).collect();
                return Err(format!(
                    "{crossed} walls cross from {:?} to {other:?}, marked {is_marked}: {ends:?}",
                    [x, y]
                ));
            }
        }
    }
    Ok(marked)
}

fn closed() -> Result<(), String> {
    const SEED: u64 = 1642;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let mut random = Random::new(SEED);
    let (mut marked, mut walls) = (0, 0);
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
            let given = Given::new(&gpu, &map, TextureFormat::R32Float)?;
            // Objects of several texels, whose edges may be without a jump.
            let has_objects = random.below(3) == 0;
            let numbers: Vec<_> = (0..given.map.depths.len() as u32)
                .map(|texel| (texel % map.size[0] / 5 + texel / map.size[0] / 7) % 3)
                .collect();
            let texture = has_objects.then(|| objects(&gpu, map.size, &numbers));
            let numbers = has_objects.then_some(&numbers[..]);
            let options = DepthMapOptions { capacity: Some(100_000), ..fit.options() };
            let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
            given.encode(&gpu, &mut volumes, texture.as_ref())?;
            let (_, quads) = listed(&volumes, &gpu)?;
            let threshold = (f64::from(fit.threshold) * UNIT).round() as i64;
            let what = |error| format!("{:?}, reversed {}, {fit:?}: {error}", map.size, map.is_reversed);
            marked += check_closed(&given.map, numbers, threshold, &quads).map_err(what)?;
            walls += quads.len();
            // Negative control: a wall is missing, or a vertex is elsewhere.
            if quads.len() > 4 {
                let at = random.below(quads.len());
                let less = [&quads[..at], &quads[at + 1..]].concat();
                let is_wall = quads[at][0][..2] == quads[at][1][..2] && quads[at][0] != quads[at][1];
                if is_wall {
                    must_fail("a missing wall", &check_closed(&given.map, numbers, threshold, &less))?;
                }
                let mut moved = quads.clone();
                moved[at][0][2] ^= 1;
                must_fail("a moved vertex", &check_closed(&given.map, numbers, threshold, &moved))?;
            }
        }
    }
    println!("{marked} marked edges, {walls} walls");
    if marked > 20_000 { Ok(()) } else { Err("too few".to_owned()) }
}

/// Compares the walls of a map of floats with a golden. How many there are.
fn check_lists(
    (gpu, pipelines): (&Gpu, &DepthMapPipelines),
    name: &str,
    given: &Given,
    fit: Fit,
) -> Result<u32, String> {
    let options = DepthMapOptions { capacity: Some(100_000), ..fit.options() };
    let mut volumes = DepthMapVolumes::new(pipelines, given.map.size, options).map_err(text)?;
    given.encode(gpu, &mut volumes, None)?;
    let found = listed(&volumes, gpu)?;
    golden("depth_map", name, &words(&found))?;
    Ok(found.0)
}

/// Software Vulkan ends the loops of an invocation after 65,535 turns, so invocations must not have more.
fn long() -> Result<(), String> {
    const SEED: u64 = 1646;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let mut random = Random::new(SEED);
    for is_loop in [false, true] {
        for (sideways, depth) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.01), (0.5, 1.0)] {
            let fit = Fit { threshold: 0.25, sideways, depth, slope_bias: 1.0 };
            let given = Given::new(&gpu, &spirals(&mut random, is_loop), TextureFormat::R32Float)?;
            let name = format!("walls of spirals, loops {is_loop}, sideways {sideways}, depth {depth}");
            let walls = check_lists((&gpu, &pipelines), &name, &given, fit)?;
            println!("{walls} walls of spirals, loops {is_loop}, {fit:?}");
            if walls < 6_000 {
                return Err(format!("{walls} walls"));
            }
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
        let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
        // Reading the map back would take more workgroups.
        let map = smooth(&mut random, [250, 130], false);
        let given = Given { texture: texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?, map };
        let fit = Fit { threshold: 0.01, sideways: 0.25, depth: 0.01, slope_bias: 1.0 };
        let walls = check_lists((&gpu, &pipelines), &format!("walls of {most} workgroups across"), &given, fit)?;
        println!("{walls} walls with {most} workgroups across");
        if walls < 300 {
            return Err(format!("{walls} walls"));
        }
    }
    Ok(())
}

/// A list that overflows is not drawn: every cell is, by its triangles.
fn overflow() -> Result<(), String> {
    const SEED: u64 = 1643;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let mut differ = 0;
    for world in worlds(&mut random) {
        let Some(view) = View::random(&mut random, &world) else { continue };
        let [light_depths, eye_depths] = view.depths();
        let map = texture(&gpu, [SIDE; 2], TextureFormat::Depth32Float, &light_depths)?;
        let fit = Fit { threshold: 0.0005, sideways: 0.25, depth: 0.002, slope_bias: 1.0 };
        let picture = |options| {
            let (light, eye, depths) = (view.sun.camera, view.eye, &eye_depths[..]);
            Picture { map: &map, objects: None, light, eye, depths, side: SIDE, options, bits: 7..8 }.stencil(&gpu)
        };
        let every = picture(DepthMapOptions::default())?;
        let overflown = picture(DepthMapOptions { capacity: Some(3), ..fit.options() })?;
        same("an overflow", &overflown, &every)?;
        differ += usize::from(picture(fit.options())? != every);
    }
    // Negative control: contours are not the same.
    if differ > 3 { Ok(()) } else { Err(format!("{differ} pictures differ")) }
}

/// Quadrilaterals of walls and flaps against the triangles of marked cells.
fn few() -> Result<(), String> {
    const SEED: u64 = 1644;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let mut random = Random::new(SEED);
    let mut ratios = Vec::new();
    let sides: &[u32] = if is_long() { &[128, 256, 512, 1024, 2048] } else { &[128, 256, 512] };
    for &side in sides {
        let (mut triangles, mut walls) = (0, 0);
        let mut own = Random::new(random.next_u64());
        for is_reversed in [false, true, false, true] {
            let given = Given::new(&gpu, &smooth(&mut own, [side; 2], is_reversed), TextureFormat::Depth32Float)?;
            let fit = Fit { threshold: 0.01, sideways: 0.25, depth: 0.01, slope_bias: 1.0 };
            let count = |options| {
                let mut volumes = DepthMapVolumes::new(&pipelines, [side; 2], options).map_err(text)?;
                given.encode(&gpu, &mut volumes, None)?;
                let head: Vec<u32> = gpu.read(volumes.cells(), 1)?;
                let cells: Vec<u32> = gpu.read(volumes.cells(), 1 + head[0] as usize)?;
                Ok::<_, String>((head[0], cells))
            };
            walls += 2 * count(fit.options())?.0;
            let method = DepthMapMethod::Differences { threshold: fit.threshold, dangling: None };
            let listed = count(DepthMapOptions { method, ..fit.options() })?;
            triangles += listed.1[1..].iter().map(|cell| (cell >> 30).count_ones()).sum::<u32>();
        }
        println!("{side}²: {triangles} triangles of cells, {walls} of walls");
        ratios.push(f64::from(triangles) / f64::from(walls));
    }
    println!("{ratios:.2?} times fewer");
    let grows = ratios.last() > ratios.first();
    if ratios.iter().all(|&ratio| ratio > 1.5) && grows { Ok(()) } else { Err(format!("{ratios:?}")) }
}

fn refused() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let options = Fit { threshold: 0.01, sideways: 0.25, depth: 0.01, slope_bias: 1.0 }.options();
    let refused = |options| DepthMapVolumes::new(&pipelines, [8, 8], options).err();
    let with = |threshold, sideways, depth| {
        let method = DepthMapMethod::Contours { threshold, sideways, depth };
        match refused(DepthMapOptions { method, ..options }) {
            Some(DepthMapError::Option { name, .. }) => Some(name),
            _ => None,
        }
    };
    for wrong in [-0.1, f32::INFINITY, f32::NAN] {
        let found = [with(wrong, 0.25, 0.01), with(0.01, wrong, 0.01), with(0.01, 0.25, wrong)];
        same("contours", &found, &["threshold", "sideways", "depth"].map(Some))?;
    }
    let found = [with(1.5, 0.25, 0.01), with(0.01, 0.6, 0.01), with(0.01, 0.25, 1.5), with(1.0, 0.5, 1.0)];
    same("limits", &found, &[Some("threshold"), Some("sideways"), Some("depth"), None])?;
    let two = DepthMapPipelines::antialiased(&gpu.pipelines, &ShadowFormat::default(), 6..8).map_err(text)?;
    let bits = DepthMapVolumes::new(&two, [8, 8], options).err();
    same("bits", &[bits], &[Some(DepthMapError::OneBit(2))])?;
    // Eight bytes for a sample, which one binding holds.
    let side = gpu.device.limits().max_texture_dimension_2d;
    let limit = gpu.device.limits().max_storage_buffer_binding_size / 256 * 256;
    match DepthMapVolumes::new(&pipelines, [side; 2], options).err() {
        Some(DepthMapError::Device(DeviceError::BindingTooLarge { bytes, limit: told, .. }))
            if told == limit && bytes > limit => {}
        None if 4 * (u64::from(side) + 2).pow(2) <= limit => {}
        other => return Err(format!("{side}²: {other:?}")),
    }
    let cube = DepthMapCube::new(&pipelines, 8, options).err();
    same("cube", &[cube], &[Some(DepthMapError::CubeContours)])
}
