//! The stencil against the crossings of each sample's ray with the boundary, which an independent oracle builds: of one
//! map and of six, of every cell and of marked ones, of bits that are moved by parts of a texel, of eyes of several formats,
//! and of scenes in several units.

use glam::{DVec2, DVec3, DVec4, Mat4};
use rimline::gpu::depth_map::DepthMapOptions;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{CENTRE, Eye, Rays, SAMPLES, vector};
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat;

use crate::boundary::Boundary;
use crate::cube::cube_of;
use crate::maps::Map;
use crate::picture::{EVERY_CELL, Maps, REVERSED, STANDARD, Target, by, differences};

pub(crate) const TESTS: &[Test] = &[
    ("parity_is_that_of_rays", of_maps),
    ("parity_of_each_bit_is_that_of_its_rays", of_bits),
    ("parity_of_each_sample_is_that_of_its_ray", of_samples),
    ("cube_parity_is_that_of_rays", of_cubes),
];

pub(crate) const SIDE: u32 = 48;

pub(crate) fn either(random: &mut Random) -> DepthDirection {
    [REVERSED, STANDARD][random.below(2)]
}

/// The clip position of a position.
pub(crate) fn clip(camera: &ShadowCamera, position: DVec3) -> DVec4 {
    let origin = DVec3::from_array(camera.origin.map(f64::from));
    Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4() * (position - origin).extend(1.0)
}

/// The device depth of a position.
pub(crate) fn device_depth(camera: &ShadowCamera, position: DVec3) -> f32 {
    let clip = clip(camera, position);
    (clip.z / clip.w) as f32
}

/// The position of device coordinates.
pub(crate) fn unprojected(camera: &ShadowCamera, device: DVec3) -> DVec3 {
    let point = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse() * device.extend(1.0);
    point.truncate() / point.w + DVec3::from_array(camera.origin.map(f64::from))
}

/// The camera of a light near the middle of the scene, of any kind, and the light.
pub(crate) fn light(random: &mut Random) -> (ShadowCamera, DVec4) {
    any_light(random, false)
}

/// `is_within`: its near and far plane are within the scene.
fn any_light(random: &mut Random, is_within: bool) -> (ShadowCamera, DVec4) {
    let away = vector(random);
    let depth = either(random);
    let (near, far, half_width) = if is_within {
        let (near, far) = (random.between(2.0, 4.5).into(), random.between(9.0, 11.0).into());
        (near, Some(far), [None, Some(4.0)][random.below(2)])
    } else {
        [(0.5, None, None), (0.5, Some(40.0), None), (0.5, Some(40.0), Some(4.0))][random.below(3)]
    };
    let position = 8.0 * away;
    let eye = Eye { position, forward: -away, near, is_relative: random.below(2) == 0, depth, far, half_width };
    (eye.camera(), if half_width.is_some() { away.extend(0.0) } else { position.extend(1.0) })
}

/// An eye of any kind that looks about the middle of the scene, with its near plane between these distances.
pub(crate) fn any_eye(random: &mut Random, position: DVec3, near: [f32; 2]) -> ShadowCamera {
    let forward = vector(random) * 3.0 - position;
    let depth = either(random);
    let (far, half_width) = [(None, None), (Some(60.0), None), (Some(60.0), Some(6.0))][random.below(3)];
    let near = f64::from(random.between(near[0], near[1]));
    Eye { position, forward, near, is_relative: random.below(2) == 0, depth, far, half_width }.camera()
}

/// The camera, or in every third case its mirror image.
fn mirrored(random: &mut Random, camera: ShadowCamera) -> ShadowCamera {
    let sign = if random.below(3) == 0 { -1.0 } else { 1.0 };
    ShadowCamera { view_projection: camera.view_projection.map(|[x, y, z, w]| [sign * x, y, z, w]), ..camera }
}

/// Steps, slopes, holes and lone texels.
pub(crate) fn map(random: &mut Random, camera: &ShadowCamera) -> Map {
    let size = [1 + random.below(12) as u32, 1 + random.below(12) as u32];
    let is_reversed = camera.depth == REVERSED;
    let share = random.below(4);
    let slope = [random.between(-0.3, 0.3), random.between(-0.3, 0.3)];
    let near = unprojected(camera, DVec3::new(0.0, 0.0, f64::from(u8::from(is_reversed))));
    let forward = (unprojected(camera, DVec3::new(0.0, 0.0, 0.5)) - near).normalize();
    Map::new(size, is_reversed, |texel| {
        if random.below(4) < share {
            return if random.below(7) == 0 { f32::NAN } else { f32::from(!is_reversed) };
        }
        let [x, y] = [texel % size[0], texel / size[0]].map(|position| position as f32);
        let step = random.below(3) as f32 * 1.5;
        let distance = (5.0 + step + slope[0] * x + slope[1] * y).max(0.1);
        device_depth(camera, near + f64::from(distance) * forward)
    })
}

/// Where a ray begins, and the point that it sees, for a position of a picture.
pub(crate) type Seen<'a> = dyn Fn(DVec2) -> (DVec3, DVec3) + 'a;

/// Points on a wavy surface, near or far.
pub(crate) fn seen<'a>(random: &mut Random, rays: &'a Rays) -> impl Fn(DVec2) -> (DVec3, DVec3) + use<'a> {
    let middle = f64::from(random.between(3.0, 14.0));
    let waves = [0; 4].map(|_| f64::from(random.between(-0.2, 0.2)));
    move |position: DVec2| {
        let (near, direction) = rays.at(position);
        let wave = (waves[0] * position.x + waves[1] * position.y).sin() * 0.4
            + (waves[2] * position.x + waves[3]).cos() * 0.3;
        (near, near + direction * middle * (1.0 + wave))
    }
}

/// The middle of a pixel of a square picture.
pub(crate) fn middle(pixel: u32, side: u32) -> DVec2 {
    DVec2::new(f64::from(pixel % side) + 0.5, f64::from(pixel / side) + 0.5)
}

/// Depths that the pixels of a square picture see at their middles, as device depths.
pub(crate) fn seen_depths(eye: &ShadowCamera, side: u32, seen: &Seen<'_>) -> Vec<f32> {
    (0..side * side).map(|pixel| device_depth(eye, seen(middle(pixel, side)).1)).collect()
}

/// The truth by the ray at a position of a picture, with those within a twentieth of a pixel, times `wider`, and of
/// points that are nearer and farther by little: whether the stencil is set, and whether the ray begins in shadow.
/// `None` near borders. `is_every`: every edge is marked, so parity is darkness, and where the two differ is a border,
/// too.
pub(crate) fn truth(
    boundary: &Boundary,
    seen: &Seen<'_>,
    at: DVec2,
    (wider, is_every): (f64, bool),
) -> Option<(bool, bool)> {
    let around = [
        (0.0, 0.0, 1.0),
        (0.0, 0.0, 1.003),
        (0.06, 0.05, 0.997),
        (-0.06, 0.05, 1.003),
        (0.05, -0.06, 1.003),
        (-0.05, -0.06, 0.997),
    ];
    let truths = around.map(|(x, y, share)| {
        let (near, position) = seen(at + wider * DVec2::new(x, y));
        let position = near + share * (position - near);
        (boundary.parity(near, position), boundary.is_dark(near), boundary.is_dark(position))
    });
    let (parity, is_cut, is_dark) = truths[0];
    (truths == [truths[0]; 6] && (!is_every || parity == is_dark)).then_some((parity, is_cut))
}

/// Samples with a dark and a lit truth, those too near to a border to decide, those whose rays begin in shadow, and
/// wrong ones.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) dark: usize,
    pub(crate) lit: usize,
    pub(crate) near_borders: usize,
    pub(crate) behind: usize,
    pub(crate) wrong: usize,
    /// Lit and dark ones before the light's near plane, between its planes, and beyond its far plane.
    zones: [[usize; 2]; 3],
}

impl Tally {
    pub(crate) fn add(&mut self, truth: Option<(bool, bool)>, is_set: bool) {
        let Some((is_dark, is_behind)) = truth else {
            self.near_borders += 1;
            return;
        };
        *(if is_dark { &mut self.dark } else { &mut self.lit }) += 1;
        self.behind += usize::from(is_behind);
        self.wrong += usize::from(is_set != is_dark);
    }

    fn check(&self, what: &str, least_dark: usize) -> Result<(), String> {
        println!("{what}: {self:?}");
        let all = self.dark + self.lit + self.near_borders;
        let is_tried = self.dark * least_dark > all && self.lit * 10 > all && self.near_borders * 4 < all;
        if self.wrong == 0 && is_tried { Ok(()) } else { Err(format!("{what}: {self:?}")) }
    }
}

/// A scene of one map.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Any,
    /// Nothing casts but one texel, or nothing at all.
    Little,
    /// The light's near and far plane are within the scene, so receivers are before and beyond them.
    Within,
}

/// Parameters of trials.
#[derive(Clone, Copy, Debug)]
struct Way<'a> {
    /// Six maps of a cube.
    is_cube: bool,
    content: Content,
    /// From the least to the largest distance of the near plane.
    near: [f32; 2],
    threshold: f32,
    overflows: bool,
    /// Parts of a texel that each bit is moved by, if there is more than one.
    moves: &'a [[f64; 2]],
    /// The format of the eye's depth, and samples.
    target: (TextureFormat, u32),
}

const PLAIN: Way<'_> = Way {
    is_cube: false,
    content: Content::Any,
    near: [0.05, 0.2],
    threshold: -1.0,
    overflows: false,
    moves: &[],
    target: (TextureFormat::Depth24PlusStencil8, 1),
};

/// A light with its maps, and boundaries of them for each bit.
struct Scene {
    maps: Vec<Option<Map>>,
    side: u32,
    lights: Vec<ShadowCamera>,
    /// About the position of the light.
    middle: DVec3,
    boundaries: Vec<Boundary>,
}

impl Scene {
    fn new(random: &mut Random, way: Way<'_>) -> Self {
        if way.is_cube {
            let side = 3 + random.below(8) as u32;
            let cube = cube_of(random, side);
            let (boundaries, lights) = (vec![Boundary::cube(&cube, way.threshold)], cube.cameras.to_vec());
            return Self { maps: cube.maps.to_vec(), side, lights, middle: cube.light, boundaries };
        }
        let (camera, at) = any_light(random, way.content == Content::Within);
        let camera = mirrored(random, camera);
        let mut map = map(random, &camera);
        if way.content == Content::Little {
            if random.below(2) == 0 {
                map = Map { size: [1, 1], depths: vec![map.depths[0]], ..map };
            }
            let (lone, far) = (random.below(map.depths.len() + 1), [f32::NAN, map.far()][random.below(2)]);
            map.depths.iter_mut().enumerate().filter(|(at, _)| *at != lone).for_each(|(_, depth)| *depth = far);
        }
        let moves: Vec<_> = way.moves.iter().map(|&by| Some(by)).collect();
        let moves = if moves.is_empty() { vec![None] } else { moves };
        let boundaries = moves.into_iter().map(|by| Boundary::edited(&map, &camera, at, way.threshold, by)).collect();
        Self { maps: vec![Some(map)], side: 0, lights: vec![camera], middle: DVec3::ZERO, boundaries }
    }

    fn maps(&self, gpu: &Gpu) -> Result<Maps, String> {
        let size = self.maps[0].as_ref().filter(|_| self.side == 0).map_or([self.side; 2], |map| map.size);
        Ok(Maps { size, ..Maps::all(gpu, (&self.maps, self.side), TextureFormat::R32Float, &self.lights)? })
    }
}

/// Adds the samples of a picture. Counts those that the stencil of another sample of the pixel is wrong for.
fn trial(gpu: &Gpu, random: &mut Random, tally: &mut Tally, way: Way<'_>) -> Result<usize, String> {
    let scene = Scene::new(random, way);
    let position =
        scene.middle * f64::from(random.below(2) as u32) + f64::from(random.between(0.3, 9.0)) * vector(random);
    let eye = any_eye(random, position, way.near);
    let eye = mirrored(random, eye);
    let rays = Rays::new(&eye, SIDE);
    let seen = seen(random, &rays);
    let within = if way.target.1 == 1 { &[CENTRE][..] } else { &SAMPLES };
    let positions: Vec<_> =
        (0..SIDE * SIDE).flat_map(|pixel| within.iter().map(move |&at| middle(pixel, SIDE) - CENTRE + at)).collect();
    let depths: Vec<_> = positions.iter().map(|&position| device_depth(&eye, seen(position).1)).collect();
    let method = if way.threshold < 0.0 { EVERY_CELL } else { differences(way.threshold) };
    let capacity = way.overflows.then(|| random.below(3) as u32);
    let options = DepthMapOptions { capacity, slope_bias: 0.0, ..by(method) };
    let count = scene.boundaries.len() as u32;
    let bit = random.below(9 - count as usize) as u32;
    let (format, samples) = way.target;
    let mut maps = scene.maps(gpu)?;
    // Some scenes are in other units, which are powers of two apart, so nothing is rounded otherwise.
    let unit = [1.0, 1.0 / 4096.0, 1.0, 1024.0][bit as usize % 4];
    maps.lights = maps.lights.iter().map(|light| scaled(light, unit)).collect();
    let eye = scaled(&eye, unit);
    let target = Target { format, samples, bits: bit..bit + count, ..Target::new(eye, &depths) };
    let stencil = target.stencil(gpu, &maps, options)?;
    let mask = ((1_u32 << count) - 1) << bit;
    if let Some(value) = stencil.iter().find(|&value| u32::from(*value) & !mask != 0) {
        return Err(format!("{value:08b} where {mask:08b} are drawn"));
    }
    // In the short run, a seventh of the pixels of several samples.
    let (share, turn) = if samples > 1 && !is_long() { (7, random.below(7)) } else { (1, 0) };
    let mut others = 0;
    for (bit, boundary) in (bit..).zip(&scene.boundaries) {
        for (number, &position) in positions.iter().enumerate().filter(|(at, _)| at / within.len() % share == turn) {
            let is_set = |number: usize| stencil[number] >> bit & 1 == 1;
            let truth = truth(boundary, &seen, position, (1.0, way.threshold < 0.0));
            tally.add(truth, is_set(number));
            if let Some((is_dark, _)) = truth {
                let clip = clip(&scene.lights[0], seen(position).1);
                let from_near = if scene.lights[0].depth == REVERSED { clip.w - clip.z } else { clip.z };
                let zone = usize::from(from_near > 0.0) + usize::from(from_near > clip.w);
                tally.zones[zone][usize::from(is_dark)] += 1;
            }
            let next = number - number % within.len() + (number + 2) % within.len();
            others += usize::from(truth.is_some_and(|truth| truth.0 != is_set(next)));
        }
    }
    Ok(others)
}

/// So many trials, and ten times as many with `RIMLINE_LONG=1`.
fn trials(gpu: &Gpu, seed: u64, count: u32, way: Way<'_>) -> Result<(Tally, usize), String> {
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut tally, mut others) = (Tally::default(), 0);
    for number in 0..if is_long() { 10 * count } else { count } {
        let before = tally.wrong;
        others += trial(gpu, &mut random, &mut tally, way)?;
        if tally.wrong > before {
            println!("trial {number}: {} wrong", tally.wrong - before);
        }
    }
    // One texel casts little, and nothing casts before the near plane.
    tally.check(&format!("{way:?}"), if way.content == Content::Any { 50 } else { 2000 })?;
    let [before, between, beyond] = tally.zones;
    let has_all = before[0].min(beyond[0]) > 300 && before[1] == 0 && between[1].min(beyond[1]) > 50;
    if way.content == Content::Within && !has_all {
        return Err(format!("{way:?}: {tally:?}"));
    }
    Ok((tally, others))
}

/// Every cell, marked ones, near rectangles that are large, most of which cut the boundary, lists that overflow, and maps
/// of little.
fn all(seed: u64, is_cube: bool) -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let ways = [
        (24, PLAIN),
        (24, Way { threshold: 0.01, ..PLAIN }),
        (24, Way { near: [0.5, 6.0], ..PLAIN }),
        (12, Way { near: [0.05, 2.0], threshold: 0.01, overflows: true, ..PLAIN }),
        (24, Way { content: Content::Little, ..PLAIN }),
        (24, Way { content: Content::Within, near: [0.1, 1.0], ..PLAIN }),
    ];
    for (seed, (count, way)) in (seed..).zip(ways).take(if is_cube { 4 } else { 6 }) {
        let (tally, _) = trials(&gpu, seed, count, Way { is_cube, ..way })?;
        if way.near == [0.5, 6.0] && tally.behind < 1000 {
            return Err(format!("the near rectangle is cut too rarely: {tally:?}"));
        }
    }
    Ok(())
}

fn of_maps() -> Result<(), String> {
    all(1621, false)
}

fn of_cubes() -> Result<(), String> {
    all(1651, true)
}

/// Boundaries that are moved by parts of a texel, each into another bit.
fn of_bits() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let of_two = [[-0.25, 0.25], [0.25, -0.25]];
    let of_four = [[-0.375, -0.125], [-0.125, 0.375], [0.125, -0.375], [0.375, 0.125]];
    let near = [0.05, 0.5];
    for (seed, threshold, overflows) in [(1625, -1.0, false), (1626, 0.01, false), (1627, 0.01, true)] {
        for moves in [&of_two[..], &of_four] {
            trials(&gpu, seed, 3, Way { near, threshold, overflows, moves, ..PLAIN })?;
        }
    }
    let exchanged = Way { near, moves: &[of_two[1], of_two[0]], ..PLAIN };
    must_fail("bits that are exchanged", &trials(&gpu, 1625, 3, exchanged))
}

/// Eyes whose depth buffers have floats or several samples a pixel. Half of the near rectangles cut the boundary.
fn of_samples() -> Result<(), String> {
    let gpu = Gpu::shared_with_depth_features()?;
    let [floats, fixed] = [TextureFormat::Depth32FloatStencil8, TextureFormat::Depth24PlusStencil8];
    for target in [(floats, 1), (floats, 4), (fixed, 4)] {
        let mut others = 0;
        for near in [[0.05, 0.2], [0.5, 6.0]] {
            others += trials(&gpu, 16_601, 6, Way { near, target, ..PLAIN })?.1;
        }
        if target.1 > 1 && others < 50 {
            return Err(format!("{target:?}: {others} samples differ from others of their pixels"));
        }
    }
    Ok(())
}

/// The camera of a scene whose lengths are `by` times as large, near and far plane among them.
fn scaled(camera: &ShadowCamera, by: f32) -> ShadowCamera {
    let [x, y, z, w] = camera.view_projection;
    let is_parallel = [x, y, z].iter().all(|column| column[3] == 0.0);
    // Clip space in the scene's unit for perspective, and without one for parallel rays.
    let [of_axes, of_origin] = if is_parallel { [1.0 / by, 1.0] } else { [1.0, by] };
    let [x, y, z] = [x, y, z].map(|column| column.map(|value| of_axes * value));
    let view_projection = [x, y, z, w.map(|value| of_origin * value)];
    ShadowCamera { view_projection, origin: camera.origin.map(|value| by * value), ..*camera }
}
