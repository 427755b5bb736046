//! The stencil against the crossings of each pixel's ray with the boundary, which an oracle of its own builds.

use glam::{DVec2, DVec3, DVec4, Mat4};
use rimline::gpu::depth_map::{DepthMapMethod, DepthMapOptions};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat;

use crate::boundary::Boundary;
use crate::maps::Map;
use crate::picture::Picture;
use crate::scene::{Eye, Rays};
use crate::textures::texture;

pub(crate) const TESTS: &[Test] = &[
    ("parity_is_that_of_rays", every_cell),
    ("parity_of_marked_cells_is_that_of_rays", differences),
    ("parity_with_a_cut_near_rectangle_is_that_of_rays", cut),
    ("parity_of_lists_that_overflow_is_that_of_rays", overflow),
    ("parity_of_each_bit_is_that_of_its_rays", of_bits),
];

pub(crate) const SIDE: u32 = 48;

pub(crate) fn vector(random: &mut Random) -> DVec3 {
    DVec3::from_array(random.direction().map(f64::from))
}

/// The device depth of a place.
pub(crate) fn device_depth(camera: &ShadowCamera, place: DVec3) -> f32 {
    let origin = DVec3::from_array(camera.origin.map(f64::from));
    let clip = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4() * (place - origin).extend(1.0);
    (clip.z / clip.w) as f32
}

/// The camera of a light near the middle of the scene, of any kind, and the light.
pub(crate) fn light(random: &mut Random) -> (ShadowCamera, DVec4) {
    let away = vector(random);
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
    let (far, half_width) = [(None, None), (Some(40.0), None), (Some(40.0), Some(4.0))][random.below(3)];
    let place = 8.0 * away;
    let eye = Eye { place, forward: -away, near: 0.5, is_relative: random.below(2) == 0, depth, far, half_width };
    (eye.camera(), if half_width.is_some() { away.extend(0.0) } else { place.extend(1.0) })
}

/// The camera, or in every third case its mirror image.
pub(crate) fn mirrored(random: &mut Random, camera: ShadowCamera) -> ShadowCamera {
    let sign = if random.below(3) == 0 { -1.0 } else { 1.0 };
    ShadowCamera { view_projection: camera.view_projection.map(|[x, y, z, w]| [sign * x, y, z, w]), ..camera }
}

/// Steps, slopes, holes and lone texels.
pub(crate) fn map(random: &mut Random, camera: &ShadowCamera) -> Map {
    let size = [1 + random.below(12) as u32, 1 + random.below(12) as u32];
    let is_reversed = camera.depth == DepthDirection::Reversed;
    let far = if is_reversed { 0.0 } else { 1.0 };
    let share = random.below(4);
    let slope = [random.between(-0.3, 0.3), random.between(-0.3, 0.3)];
    let axis = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
    let origin = DVec3::from_array(camera.origin.map(f64::from));
    let place = |depth: f64| {
        let place = axis * DVec4::new(0.0, 0.0, depth, 1.0);
        place.truncate() / place.w + origin
    };
    let (near, ahead) = (place(f64::from(u8::from(is_reversed))), place(0.5));
    let forward = (ahead - near).normalize();
    Map::new(size, is_reversed, |texel| {
        if random.below(4) < share {
            return if random.below(7) == 0 { f32::NAN } else { far };
        }
        let [x, y] = [texel % size[0], texel / size[0]].map(|place| place as f32);
        let step = random.below(3) as f32 * 1.5;
        let distance = (5.0 + step + slope[0] * x + slope[1] * y).max(0.1);
        device_depth(camera, near + f64::from(distance) * forward)
    })
}

/// For each pixel, the start of its ray and the point that it sees on a wavy surface, near or far.
pub(crate) fn seen<'a>(random: &mut Random, rays: &'a Rays) -> impl Fn(DVec2) -> (DVec3, DVec3) + use<'a> {
    let middle = f64::from(random.between(3.0, 14.0));
    let waves = [0; 4].map(|_| f64::from(random.between(-0.2, 0.2)));
    move |place: DVec2| {
        let (near, direction) = rays.at(place);
        let wave = (waves[0] * place.x + waves[1] * place.y).sin() * 0.4 + (waves[2] * place.x + waves[3]).cos() * 0.3;
        (near, near + direction * middle * (1.0 + wave))
    }
}

/// The middle of a pixel of a square picture.
pub(crate) fn middle(pixel: u32, side: u32) -> DVec2 {
    DVec2::new(f64::from(pixel % side) + 0.5, f64::from(pixel / side) + 0.5)
}

/// Depths that the pixels of a square picture see at their middles, as device depths.
pub(crate) fn seen_depths(eye: &ShadowCamera, side: u32, seen: &dyn Fn(DVec2) -> (DVec3, DVec3)) -> Vec<f32> {
    (0..side * side).map(|pixel| device_depth(eye, seen(middle(pixel, side)).1)).collect()
}

/// Results of trials: pixels with a dark and a lit truth, pixels too near to a border to decide, and wrong ones.
#[derive(Debug, Default)]
struct Tally {
    dark: usize,
    lit: usize,
    near_borders: usize,
    cut: usize,
    wrong: usize,
}

/// Parameters of trials.
#[derive(Clone, Copy, Debug)]
struct Way<'a> {
    /// From the least to the largest distance of the near plane.
    near: [f32; 2],
    threshold: f32,
    overflows: bool,
    /// Parts of a texel that each bit is moved by, if there is more than one.
    moves: &'a [[f64; 2]],
}

const EVERY_CELL: Way<'_> = Way { near: [0.05, 0.2], threshold: -1.0, overflows: false, moves: &[] };

fn trial(gpu: &Gpu, random: &mut Random, tally: &mut Tally, way: Way<'_>) -> Result<(), String> {
    let Way { near, threshold, overflows, moves } = way;
    let near = f64::from(random.between(near[0], near[1]));
    let capacity = overflows.then(|| random.below(3) as u32);
    let (camera, light) = light(random);
    let camera = mirrored(random, camera);
    let map = map(random, &camera);
    let place = f64::from(random.between(0.5, 9.0)) * vector(random);
    let forward = vector(random) * 3.0 - place;
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
    let (far, half_width) = [(None, None), (Some(60.0), None), (Some(60.0), Some(6.0))][random.below(3)];
    let eye = Eye { place, forward, near, is_relative: random.below(2) == 0, depth, far, half_width }.camera();
    let eye = mirrored(random, eye);
    let rays = Rays::new(&eye, SIDE);
    let seen = seen(random, &rays);
    let centres: Vec<_> = (0..SIDE * SIDE).map(|pixel| middle(pixel, SIDE)).collect();
    let depths = seen_depths(&eye, SIDE, &seen);
    let edges = if threshold < 0.0 {
        DepthMapMethod::EveryCell
    } else {
        DepthMapMethod::Differences { threshold, dangling: None }
    };
    let bits = moves.len().max(1) as u32;
    let options = DepthMapOptions { method: edges, capacity, slope_bias: 0.0, ..Default::default() };
    let texture = texture(gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let bit = random.below(9 - bits as usize) as u32;
    let mask = u8::try_from(((1 << bits) - 1) << bit).map_err(text)?;
    let bits = bit..bit + bits;
    let picture =
        Picture { map: &texture, objects: None, light: camera, eye, depths: &depths, side: SIDE, options, bits };
    let stencil = picture.stencil(gpu)?;
    if let Some(value) = stencil.iter().find(|&value| value & !mask != 0) {
        return Err(format!("{value:08b} where {mask:08b} are drawn"));
    }
    let edited = |by| Boundary::edited(&map, &camera, light, f64::from(threshold), by);
    let boundaries = match moves {
        [] => vec![edited(None)],
        moves => moves.iter().map(|&by| edited(Some(by))).collect(),
    };
    let of_bits = (bit..).zip(&boundaries).flat_map(|(bit, boundary)| {
        centres.iter().zip(&stencil).map(move |(&centre, value)| (boundary, centre, value >> bit & 1 == 1))
    });
    for (boundary, centre, is_set) in of_bits {
        let around = [
            (0.0, 0.0, 1.0),
            (0.0, 0.0, 1.003),
            (0.06, 0.05, 0.997),
            (-0.06, 0.05, 1.003),
            (0.05, -0.06, 1.003),
            (-0.05, -0.06, 0.997),
        ];
        let truths = around.map(|(x, y, share)| {
            let (near, place) = seen(centre + DVec2::new(x, y));
            let place = near + share * (place - near);
            (boundary.parity(near, place), boundary.is_dark(near), boundary.is_dark(place))
        });
        // With every edge marked, parity is darkness.
        if threshold < 0.0 && truths.iter().any(|truth| truth.0 != truth.2) {
            tally.near_borders += 1;
            continue;
        }
        if truths != [truths[0]; 6] {
            tally.near_borders += 1;
            continue;
        }
        let (truth, is_cut, _) = truths[0];
        *(if truth { &mut tally.dark } else { &mut tally.lit }) += 1;
        tally.cut += usize::from(is_cut);
        tally.wrong += usize::from(is_set != truth);
    }
    Ok(())
}

fn trials(seed: u64, count: u32, way: Way<'_>) -> Result<Tally, String> {
    println!("seed {seed}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let mut tally = Tally::default();
    for number in 0..count {
        let before = tally.wrong;
        trial(&gpu, &mut random, &mut tally, way)?;
        if tally.wrong > before {
            println!("trial {number}: {} wrong", tally.wrong - before);
        }
    }
    println!("{tally:?}");
    let pixels = tally.dark + tally.lit + tally.near_borders;
    if tally.wrong > 0 || tally.dark < pixels / 50 || tally.lit < pixels / 10 || tally.near_borders > pixels / 4 {
        return Err(format!("{tally:?}"));
    }
    Ok(tally)
}

/// So many trials, and ten times as many with `RIMLINE_LONG=1`.
pub(crate) fn trials_of(count: u32) -> u32 {
    if is_long() { 10 * count } else { count }
}

fn every_cell() -> Result<(), String> {
    trials(1621, trials_of(24), EVERY_CELL).map(drop)
}

fn differences() -> Result<(), String> {
    trials(1622, trials_of(24), Way { threshold: 0.01, ..EVERY_CELL }).map(drop)
}

/// Near rectangles that are large: most cut the boundary.
fn cut() -> Result<(), String> {
    let tally = trials(1623, trials_of(24), Way { near: [0.5, 6.0], ..EVERY_CELL })?;
    if tally.cut < 1000 {
        return Err(format!("the near rectangle is cut too rarely: {tally:?}"));
    }
    Ok(())
}

/// Boundaries that are moved by parts of a texel, each into a bit of its own.
fn of_bits() -> Result<(), String> {
    let of_two = [[-0.25, 0.25], [0.25, -0.25]];
    let of_four = [[-0.375, -0.125], [-0.125, 0.375], [0.125, -0.375], [0.375, 0.125]];
    let near = [0.05, 0.5];
    for (seed, threshold, overflows) in [(1625, -1.0, false), (1626, 0.01, false), (1627, 0.01, true)] {
        for moves in [&of_two[..], &of_four] {
            trials(seed, trials_of(3), Way { near, threshold, overflows, moves })?;
        }
    }
    let exchanged = [of_two[1], of_two[0]];
    let exchanged = trials(1625, 3, Way { near, moves: &exchanged, ..EVERY_CELL });
    must_fail("bits that are exchanged", &exchanged)
}

fn overflow() -> Result<(), String> {
    trials(1624, trials_of(12), Way { near: [0.05, 2.0], threshold: 0.01, overflows: true, ..EVERY_CELL }).map(drop)
}
