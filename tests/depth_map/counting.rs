//! The surface counted as a volume, beside its parity: equal where no edge is missed, and what a missed edge does to each.

use glam::{DVec2, DVec3};
use rimline::gpu::{DepthEdges, DepthMap, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, ShadowFormat};
use rimline::{DepthDirection, ShadowCamera};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::random::Random;
use rimline_measure::{must_fail, same};
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::parity::{SIDE, device_depth, light, map, seen, vector};
use crate::picture::stencil_of;
use crate::scene::{Eye, Rays};
use crate::textures::{depth_view, texture};

pub(crate) const TESTS: &[Test] =
    &[("the_surface_counts_as_its_parity", counts), ("a_missed_edge_in_parity_and_in_counts", missed)];

/// The stencil by parity, and by counts.
fn both(
    gpu: &Gpu,
    (map, light): (&Map, ShadowCamera),
    (eye, depths): (&ShadowCamera, &[f32]),
    edges: DepthEdges,
) -> Result<[Vec<u8>; 2], String> {
    let format = ShadowFormat { depth: eye.depth, count_bits: 7, ..Default::default() };
    let options = DepthMapOptions { edges, slope_bias: 0.0, ..Default::default() };
    let texture = texture(gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let draw = |pipelines: &DepthMapPipelines| {
        let mut volumes = DepthMapVolumes::new(pipelines, map.size, options).map_err(text)?;
        stencil_of(gpu, pipelines, (SIDE, depths), |encoder| {
            let map = DepthMap { texture: &depth_view(&texture), light };
            volumes.encode(encoder, &map, eye, None).map_err(text)
        })
    };
    let parity = draw(&DepthMapPipelines::new(&gpu.pipelines, &format, 7).map_err(text)?)?;
    let counting = DepthMapPipelines::counting(&gpu.pipelines, &format).map_err(text)?;
    if [0, 1, 127].map(|stencil| counting.lit_share(stencil)) != [1.0, 0.0, 0.0] {
        return Err("shares of a count".to_owned());
    }
    Ok([parity.iter().map(|value| value >> 7).collect(), draw(&counting)?])
}

fn pixels() -> impl Iterator<Item = DVec2> {
    (0..SIDE * SIDE).map(|pixel| DVec2::new(f64::from(pixel % SIDE) + 0.5, f64::from(pixel / SIDE) + 0.5))
}

/// Random lights, maps and eyes, mirrored ones among both: the count is 1 in the dark and 0 in the light.
fn counts() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    println!("seed 1671");
    let mut random = Random::new(1671);
    let (mut dark, mut at_borders) = (0, 0);
    for _ in 0..24 {
        let (mut camera, _) = light(&mut random);
        let map = map(&mut random, &camera);
        let place = f64::from(random.between(0.5, 9.0)) * vector(&mut random);
        let forward = vector(&mut random) * 3.0 - place;
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
        let near = f64::from(random.between(0.05, 3.0));
        let (far, half_width) = [(None, None), (Some(60.0), None), (Some(60.0), Some(6.0))][random.below(3)];
        let mut eye = Eye { place, forward, near, is_relative: random.below(2) == 0, depth, far, half_width }.camera();
        for camera in [&mut camera, &mut eye] {
            let is_mirrored = random.below(3) == 0;
            let columns = camera.view_projection.iter_mut();
            columns.filter(|_| is_mirrored).for_each(|column| column[0] = -column[0]);
        }
        let rays = Rays::new(&eye, SIDE);
        let seen = seen(&mut random, &rays);
        let depths: Vec<_> = pixels().map(|pixel| device_depth(&eye, seen(pixel).1)).collect();
        let every = DepthEdges::EveryCell;
        let [parity, mut counted] = both(&gpu, (&map, camera), (&eye, &depths), every)?;
        let low: Vec<u8> = counted.iter().map(|value| value & 1).collect();
        same("the lowest bits", &low, &parity)?;
        // Where rounding moves the border of the near cap against that of the surface, both are wrong.
        let near = if depth == DepthDirection::Reversed { 1.0 } else { 0.0 };
        let [cap, _] = both(&gpu, (&map, camera), (&eye, &vec![near; depths.len()]), every)?;
        for at in (0..counted.len()).filter(|&at| counted[at] > 1) {
            let (x, y) = (at as i64 % i64::from(SIDE), at as i64 / i64::from(SIDE));
            let around = pixels()
                .zip(&cap)
                .filter(|(pixel, _)| (pixel.x - 0.5 - x as f64).abs() < 1.5 && (pixel.y - 0.5 - y as f64).abs() < 1.5);
            if around.map(|(_, value)| value).all(|value| *value == cap[at]) {
                return Err(format!("pixel {x}, {y}: {}", counted[at]));
            }
            at_borders += 1;
        }
        dark += parity.iter().map(|&value| usize::from(value)).sum::<usize>();
        for value in &mut counted {
            *value = (128 - *value) % 128;
        }
        if parity.contains(&1) {
            must_fail("counts that go the other way", &same("counts", &counted, &parity))?;
        }
    }
    println!("{dark} dark pixels, {at_borders} wrong at borders of near caps");
    if dark < 5_000 || at_borders > 5 { Err(format!("only {dark} dark pixels")) } else { Ok(()) }
}

/// The height of a ramp over a floor.
fn ramp(x: f64) -> f64 {
    0.8 + 0.45 * (x + 2.0)
}

/// A ramp over a floor, seen by a parallel light from above, with a threshold above the step at its low end. Rays from there
/// leave the shadow and never entered it, and rays the other way enter it and never leave.
fn missed() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let eye_of = |place: DVec3, half_width| Eye {
        place,
        forward: -place,
        near: 0.1,
        is_relative: false,
        depth: DepthDirection::Reversed,
        far: Some(40.0),
        half_width,
    };
    let light = eye_of(DVec3::new(0.0, 8.0, 0.0), Some(4.0)).camera();
    // The map, by the light's rays down to ramp or floor.
    let rays = Rays::new(&light, 32);
    let map = Map::new([32, 32], true, |texel| {
        let (from, _) = rays.at(DVec2::new(f64::from(texel % 32) + 0.5, f64::from(texel / 32) + 0.5));
        let is_ramp = from.x.abs() < 2.0 && from.z.abs() < 2.0;
        device_depth(&light, DVec3::new(from.x, if is_ramp { ramp(from.x) } else { 0.0 }, from.z))
    });
    // Above the threshold: all steps at the ramp but those at its low end.
    let edges = DepthEdges::WorldDifferences { threshold: 1.0 };
    // Pixels that are wrong: lit and dark ones by parity, lit and dark ones by counts, and by counts beside a mesh that darkens
    // all.
    let mut wrong = [[0; 5]; 2];
    for (side, x) in [(0, -6.0), (1, 6.0)] {
        let eye = eye_of(DVec3::new(x, 0.9, 0.3), None).camera();
        let rays = Rays::new(&eye, SIDE);
        let seen = |pixel: DVec2| {
            let (from, direction) = rays.at(pixel);
            // Where the ray goes below the ramp's plane or the floor.
            let to_floor = -from.y / direction.y;
            let slope = direction.y - 0.45 * direction.x;
            let to_ramp = (ramp(from.x) - from.y) / slope;
            let on_ramp = from + to_ramp * direction;
            let is_ramp = to_ramp > 0.0 && on_ramp.x.abs() < 2.0 && on_ramp.z.abs() < 2.0;
            let floor = (to_floor > 0.0).then_some(to_floor);
            match (is_ramp.then_some(to_ramp), floor) {
                (Some(ramp), Some(floor)) => from + ramp.min(floor) * direction,
                (Some(at), None) | (None, Some(at)) => from + at * direction,
                (None, None) => from + 30.0 * direction,
            }
        };
        let places: Vec<_> = pixels().map(seen).collect();
        let depths: Vec<_> = places.iter().map(|&place| device_depth(&eye, place)).collect();
        let [truth, counted] = both(&gpu, (&map, light), (&eye, &depths), DepthEdges::EveryCell)?;
        same("counts", &counted, &truth)?;
        let [parity, counted] = both(&gpu, (&map, light), (&eye, &depths), edges)?;
        for (at, &is_dark) in truth.iter().enumerate() {
            let is_dark = is_dark == 1;
            for (first, found) in [(0, parity[at] == 1), (2, counted[at] != 0)] {
                wrong[side][first + usize::from(found)] += usize::from(found != is_dark);
            }
            // The mesh counts 1 more. Parity has a bit of its own, so the mesh's shadow stays.
            wrong[side][4] += usize::from((counted[at] + 1).is_multiple_of(128));
        }
    }
    println!("{wrong:?} wrong of {} each", SIDE * SIDE);
    // Towards the low end of the ramp, rays leave the shadow that they entered: the count stays above what it should be.
    let [leaving, entering] = wrong;
    for found in [leaving, entering] {
        same("parity and counts without a mesh", &found[..2], &found[2..4])?;
    }
    if leaving[..2].iter().any(|&count| count < 50) || entering[0] > 0 || entering[1] < 50 {
        return Err("the missed edge does nothing".to_owned());
    }
    same("beside a mesh", &[leaving[4], entering[4]], &[leaving[3], 0])
}
