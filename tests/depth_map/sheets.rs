//! Where detectors miss edges and every cell does not: equal stairs, and open sheets of folds over a ground that is not
//! in the map (docs/numerics/depth-maps.md, "Open sheets").

use glam::DVec3;
use rimline::gpu::depth_map::DepthMapMethod;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::random::Random;
use rimline_testkit::rays::Tracer;
use wgpu::TextureFormat;

use crate::boundary::sample;
use crate::maps::Map;
use crate::parity::{clip, device_depth, middle};
use crate::picture::{AUTOMATIC, EVERY_CELL, Maps, REVERSED, STANDARD, Target, by, differences, look};
use crate::scene::{Eye, Rays};

pub(crate) const TESTS: &[Test] = &[
    ("equal_stairs_have_no_edges_but_for_every_cell", of_stairs),
    ("open_sheets_swap_few_pixels_and_none_with_every_cell", of_sheets),
];

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    pixels: usize,
    /// Wrong ones of every cell, and others that the detector has wrong.
    every: usize,
    wrong: usize,
}

impl Tally {
    /// Adds pixels, and whether light reaches what the eye sees there.
    fn add(
        &mut self,
        gpu: &Gpu,
        (maps, method): (&Maps, DepthMapMethod),
        (eye, depths): (ShadowCamera, &[f32]),
        pixels: &[(usize, bool)],
    ) -> Result<(), String> {
        let target = Target::new(eye, depths);
        let (every, found) = (target.stencil(gpu, maps, by(EVERY_CELL))?, target.stencil(gpu, maps, by(method))?);
        self.pixels += pixels.len();
        for &(pixel, is_lit) in pixels {
            let [every, found] = [&every, &found].map(|stencil| (stencil[pixel] == 0) == is_lit);
            self.every += usize::from(!every);
            self.wrong += usize::from(every && !found);
        }
        Ok(())
    }
}

/// Plates over a floor, each a texel of the map wide and higher than the one before by as much: a step between steps
/// that are as large is no edge of `Automatic`, and none of differences above a step. An eye at their low side looks in
/// under them.
fn of_stairs() -> Result<(), String> {
    const STEPS: i64 = 12;
    const SIDE: u32 = 96;
    let gpu = Gpu::shared()?;
    let eye_of = |position: DVec3, forward: DVec3, half_width| {
        Eye { is_relative: false, far: Some(40.0), half_width, ..look(position, forward, 0.1) }.camera()
    };
    let light = eye_of(DVec3::new(0.0, 8.0, 0.0), DVec3::NEG_Y, Some(4.0));
    // A texel is a quarter wide.
    let rays = Rays::new(&light, 32);
    let heights = || (0..STEPS).map(|column| 0.3 + 0.15 * column as f64);
    let plate = |position: DVec3| {
        let column = ((position.x + 1.0) * 4.0).floor() as i64;
        ((0..STEPS).contains(&column) && position.z.abs() < 2.0).then_some(0.3 + 0.15 * column as f64)
    };
    let map = Map::new([32, 32], true, |texel| {
        let (from, _) = rays.at(middle(texel, 32));
        device_depth(&light, DVec3::new(from.x, plate(from).unwrap_or(0.0), from.z))
    });
    let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, light)?;
    let step = device_depth(&light, DVec3::ZERO) - device_depth(&light, DVec3::new(0.0, -0.15, 0.0));
    for method in [AUTOMATIC, differences(1.5 * step)] {
        let mut tally = Tally::default();
        for (height, aside) in [(0.9, 0.0), (1.2, 0.6), (0.6, -1.1)] {
            let position = DVec3::new(-5.0, height, aside);
            let eye = eye_of(position, DVec3::new(1.0, 0.6, 0.0) - position, None);
            let rays = Rays::new(&eye, SIDE);
            let seen = |pixel: u32| {
                let (from, ray) = rays.at(middle(pixel, SIDE));
                let found = [0.0].into_iter().chain(heights()).filter_map(|height| {
                    let t = (height - from.y) / ray.y;
                    let position = from + t * ray;
                    let is_there = height == 0.0 || plate(position).is_some_and(|top| (top - height).abs() < 1e-9);
                    (t > 0.0 && t < 30.0 && is_there).then_some((t, position, height))
                });
                found.min_by(|a, b| a.0.total_cmp(&b.0))
            };
            let seen: Vec<_> = (0..SIDE * SIDE).map(seen).collect();
            let depth = |seen: &Option<(f64, DVec3, f64)>| seen.map_or(0.0, |seen| device_depth(&eye, seen.1));
            let depths: Vec<_> = seen.iter().map(depth).collect();
            let pixels = seen.iter().enumerate().filter_map(|(pixel, seen)| {
                let (_, position, height) = (*seen)?;
                Some((pixel, height > 0.0 || plate(position).is_none()))
            });
            tally.add(&gpu, (&maps, method), (eye, &depths), &pixels.collect::<Vec<_>>())?;
        }
        println!("{method:?}: {tally:?}");
        // Without wrong pixels the limit is gone, and the documents have to say so.
        if tally.wrong < 300 || tally.pixels - tally.every - tally.wrong < 6500 {
            return Err(format!("{method:?}: {tally:?}"));
        }
    }
    Ok(())
}

/// Folds beside each other, some of them steep, of quadrilaterals in two triangles each.
fn sheet(random: &mut Random) -> Vec<[DVec3; 3]> {
    const ACROSS: usize = 9;
    let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
    let (turn, lift, tilt) = (between(0.0, 6.3), between(1.5, 2.5), between(-0.5, 0.5));
    let mut x = -1.5;
    let mut columns = Vec::new();
    for number in 0..ACROSS {
        let height = if number % 2 == 0 { 1.0 } else { -1.0 } * between(0.1, 0.7);
        columns.push((x, height));
        x += between(0.15, 0.6);
    }
    let rows: Vec<_> = (0..4).map(|row| (f64::from(row) - 1.5) * between(0.7, 1.1)).collect();
    let wobbles: Vec<_> = (0..ACROSS * rows.len()).map(|_| between(-1.0, 1.0)).collect();
    let (sin, cos) = turn.sin_cos();
    let position = |column: usize, row: usize| {
        let ((x, height), wobble) = (columns[column], wobbles[row * ACROSS + column]);
        let z = rows[row] * (1.0 + 0.15 * wobble);
        DVec3::new(cos * x - sin * z, lift + height * (1.0 + 0.3 * wobble) + tilt * z, sin * x + cos * z)
    };
    let cells = (1..rows.len()).flat_map(|row| (1..ACROSS).map(move |column| [column, row]));
    let triangles = cells.flat_map(|[x, y]| {
        let [a, b, c, d] = [position(x - 1, y - 1), position(x, y - 1), position(x, y), position(x - 1, y)];
        [[a, b, c], [a, c, d]]
    });
    triangles.collect()
}

/// Ground whose texel has nothing around it is lit. Every cell has it so.
fn of_sheets() -> Result<(), String> {
    /// Texels of a map a side, and pixels of a picture.
    const SIDE: u32 = 256;
    const GROUND: f64 = 12.0;
    let (gpu, mut random) = Gpu::seeded(28_001)?;
    let mut tally = Tally::default();
    for round in 0..if is_long() { 60 } else { 4 } {
        let tracer = Tracer::build(sheet(&mut random).into_iter().map(|corners| (corners, ())));
        let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
        let towards = DVec3::new(between(-0.8, 0.8), 1.0, between(-0.8, 0.8)).normalize();
        let depth = [REVERSED, STANDARD][round % 2];
        let light = look(towards * 9.0, -towards, 1.0);
        let light = Eye { depth, far: Some(20.0), half_width: Some(4.0), ..light }.camera();
        let rays = Rays::new(&light, SIDE);
        let map = Map::new([SIDE; 2], depth == DepthDirection::Reversed, |texel| {
            let far = f32::from(depth == DepthDirection::Standard);
            tracer.first(rays.at(middle(texel, SIDE))).map_or(far, |(position, _)| device_depth(&light, position))
        });
        let maps = Maps::of(&gpu, &map, TextureFormat::Depth32Float, light)?;
        // Whether there is nothing in the map two rows and columns around a position.
        let is_open = |position: DVec3| {
            let clip = clip(&light, position);
            let [x, y] = [clip.x, -clip.y].map(|at| (f64::midpoint(at / clip.w, 1.0) * f64::from(SIDE)).floor() as i64);
            (-2..=2).all(|down| (-2..=2).all(|across| sample(&map, x + across, y + down).is_none()))
        };
        for _ in 0..6 {
            let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
            let angle = between(0.0, 6.3);
            let position = DVec3::new(3.5 * angle.cos(), between(0.3, 4.0), 3.5 * angle.sin());
            let forward = DVec3::new(between(-0.7, 0.7), between(0.6, 2.2), between(-0.7, 0.7)) - position;
            let eye = Eye { is_relative: false, ..look(position, forward, 0.05) }.camera();
            let rays = Rays::new(&eye, SIDE);
            // The position, and whether it is of the ground.
            let seen = |pixel| {
                let (from, way) = rays.at(middle(pixel, SIDE));
                let of_sheet =
                    tracer.first((from, way)).map(|(position, _)| (position.distance(from), position, false));
                let t = -from.y / way.y;
                let position = from + t * way;
                let is_ground = t > 0.0 && position.x.abs() < GROUND && position.z.abs() < GROUND;
                let of_ground = is_ground.then_some((t, position, true));
                of_sheet.into_iter().chain(of_ground).min_by(|a, b| a.0.total_cmp(&b.0))
            };
            let seen: Vec<_> = (0..SIDE * SIDE).map(seen).collect();
            let depth = |seen: &Option<(f64, DVec3, bool)>| seen.map_or(0.0, |seen| device_depth(&eye, seen.1));
            let depths: Vec<_> = seen.iter().map(depth).collect();
            let pixels = seen.iter().enumerate().filter_map(|(pixel, seen)| match *seen {
                Some((_, position, true)) if is_open(position) => Some((pixel, true)),
                _ => None,
            });
            tally.add(&gpu, (&maps, AUTOMATIC), (eye, &depths), &pixels.collect::<Vec<_>>())?;
        }
    }
    println!("{tally:?}");
    let Tally { pixels, every, wrong } = tally;
    let is_meant = pixels > 300_000 && wrong > 0 && wrong * 10_000 < pixels;
    if every == 0 && is_meant { Ok(()) } else { Err(format!("{tally:?}")) }
}
