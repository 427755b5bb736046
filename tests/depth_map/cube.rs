//! Cubes of six maps: the stencil against the crossings of rays with a boundary that an oracle of its own builds, the samples
//! that `depth_cube` merges and their cells against rays, and cameras that do not meet.

use std::collections::HashMap;

use glam::{DMat3, DVec2, DVec3, Mat4};
use rimline::gpu::depth_map::{
    DanglingEdges, DepthCubeMaps, DepthMapCube, DepthMapError, DepthMapMethod, DepthMapOptions, DepthMapPipelines,
};
use rimline::gpu::{DeviceError, ShadowFormat};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same};
use wgpu::TextureFormat;

use crate::boundary::Boundary;
use crate::cells::{self, cast, listed_of_cube};
use crate::maps::Map;
use crate::parity::{SIDE, device_depth, middle, mirrored, seen, seen_depths, trials_of, vector};
use crate::picture::{pipelines, stencil_of};
use crate::rules;
use crate::scene::{Eye, Rays};
use crate::stages::rule_of;
use crate::textures::{depth_view, objects, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("cube_parity_is_that_of_rays", every_cell),
    ("cube_parity_of_marked_cells_is_that_of_rays", differences),
    ("cube_parity_with_a_cut_near_rectangle_is_that_of_rays", cut),
    ("cube_parity_of_lists_that_overflow_is_that_of_rays", overflow),
    ("cubes_have_no_gaps_and_no_specks_where_maps_meet", plane),
    ("cube_maps_that_are_exchanged_are_noticed", exchanged),
    ("cube_samples_and_cells_are_those_of_their_rays", lists),
    ("cubes_that_do_not_meet_are_refused", refused),
];

/// Six maps with their cameras.
pub(crate) struct Cube {
    pub(crate) light: DVec3,
    pub(crate) cameras: [ShadowCamera; 6],
    pub(crate) maps: [Option<Map>; 6],
    /// Each map has depths that its neighbours do not share.
    side: u32,
}

/// Discs across borders and corners and elsewhere, on a background or not, with noise or not, and maps that are not there.
fn cube(random: &mut Random) -> Cube {
    let side = 3 + random.below(8) as u32;
    cube_of(random, side)
}

/// The same, with maps of `side` texels.
pub(crate) fn cube_of(random: &mut Random, side: u32) -> Cube {
    let light = 2.0 * vector(random);
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
    let far = [None, Some(40.0)][random.below(2)];
    let cameras = DepthMapCube::cameras(light.as_vec3().to_array(), 0.3, far, depth, side).expect("a cube");
    let light = light.as_vec3().as_dvec3();
    let turn = DMat3::from_axis_angle(vector(random), f64::from(random.between(0.0, 6.0)));
    let mirror = if random.below(3) == 0 { -1.0 } else { 1.0 };
    let turn = mirror * [DMat3::IDENTITY, turn][random.below(2)];
    let cameras = turned(&cameras, turn);
    let discs: Vec<_> = (0..=random.below(5))
        .map(|_| {
            let mut axis = vector(random).to_array();
            // On a border: two components are as large; at a corner: three.
            let kind = random.below(3);
            for other in 1..=kind {
                axis[other] = axis[other].signum() * axis[0].abs();
            }
            let axis = turn * DVec3::from_array(axis);
            (axis.normalize(), f64::from(random.between(0.5, 0.98)), f64::from(random.between(1.0, 6.0)))
        })
        .collect();
    let background = [f64::INFINITY, f64::from(random.between(4.0, 9.0))][random.below(2)];
    let noise = random.below(3) == 0;
    let is_reversed = depth == DepthDirection::Reversed;
    let nothing = if is_reversed { 0.0 } else { 1.0 };
    let maps = cameras.map(|camera| {
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
        let is_there = random.below(8) != 0;
        let map = Map::new([side; 2], is_reversed, |texel| {
            let [x, y] = [texel % side, texel / side].map(|at| (f64::from(at) + 0.5) / f64::from(side) * 2.0 - 1.0);
            let point = matrix * glam::DVec4::new(x, -y, 0.5, 1.0);
            let ray = (point.truncate() / point.w).normalize();
            let hits = discs.iter().filter(|(axis, reach, _)| axis.dot(ray) > *reach).map(|disc| disc.2);
            let distance = hits.fold(background, f64::min);
            match random.below(6) {
                0 if noise => f32::NAN,
                1 | 2 if noise => device_depth(&camera, light + f64::from(random.between(1.0, 7.0)) * ray),
                _ if distance.is_infinite() => nothing,
                _ => device_depth(&camera, light + distance * ray),
            }
        });
        is_there.then_some(map)
    });
    Cube { light, cameras, maps, side }
}

/// The maps as textures that shaders read.
pub(crate) fn views(gpu: &Gpu, maps: &[Option<Map>; 6]) -> Result<Vec<Option<wgpu::TextureView>>, String> {
    let view = |map: &Option<Map>| {
        let texture = |map: &Map| texture(gpu, map.size, TextureFormat::R32Float, &map.depths);
        Ok(map.as_ref().map(texture).transpose()?.map(|texture| depth_view(&texture)))
    };
    maps.iter().map(view).collect()
}

/// Cameras whose world is turned, or mirrored.
fn turned(cameras: &[ShadowCamera; 6], turn: DMat3) -> [ShadowCamera; 6] {
    cameras.map(|camera| {
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let matrix = matrix * glam::DMat4::from_mat3(turn.inverse());
        ShadowCamera { view_projection: matrix.as_mat4().to_cols_array_2d(), ..camera }
    })
}

#[derive(Debug, Default)]
struct Tally {
    dark: usize,
    lit: usize,
    near_borders: usize,
    cut: usize,
    wrong: usize,
}

#[derive(Clone, Copy)]
struct Kind {
    near: [f32; 2],
    threshold: f32,
    overflows: bool,
    /// Two maps change places before they are given: a negative control.
    is_exchanged: bool,
}

fn trial(gpu: &Gpu, random: &mut Random, kind: Kind, tally: &mut Tally) -> Result<(), String> {
    let Cube { light, cameras, maps, side } = cube(random);
    let place = light * f64::from(random.below(2) as u32) + f64::from(random.between(0.1, 6.0)) * vector(random);
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
    let near = f64::from(random.between(kind.near[0], kind.near[1]));
    let (far, half_width) = [(None, None), (Some(60.0), None), (Some(60.0), Some(6.0))][random.below(3)];
    let is_relative = random.below(2) == 0;
    let eye = Eye { place, forward: vector(random), near, is_relative, depth, far, half_width }.camera();
    let eye = mirrored(random, eye);
    let rays = Rays::new(&eye, SIDE);
    let seen = seen(random, &rays);
    let centres: Vec<_> = (0..SIDE * SIDE).map(|pixel| middle(pixel, SIDE)).collect();
    let depths = seen_depths(&eye, SIDE, &seen);
    let threshold = kind.threshold;
    let edges = if threshold < 0.0 {
        DepthMapMethod::EveryCell
    } else {
        DepthMapMethod::Differences { threshold, dangling: None }
    };
    let capacity = kind.overflows.then(|| random.below(3) as u32);
    let options = DepthMapOptions { method: edges, capacity, slope_bias: 0.0, ..Default::default() };
    let pipelines = pipelines(gpu, depth, 2..3)?;
    let mut volumes = DepthMapCube::new(&pipelines, side, options).map_err(text)?;
    let mut views = views(gpu, &maps)?;
    if kind.is_exchanged {
        views.swap(0, 3);
    }
    let textures = [0, 1, 2, 3, 4, 5].map(|face: usize| views[face].as_ref());
    let given = DepthCubeMaps { textures, lights: cameras, objects: [None; 6] };
    let stencil =
        stencil_of(gpu, &pipelines, (SIDE, &depths), |encoder| volumes.encode(encoder, &given, &eye).map_err(text))?;
    let boundary = Boundary::cube(&maps, &cameras, light, f64::from(threshold));
    for (&centre, value) in centres.iter().zip(stencil) {
        let around =
            [(0.0, 0.0, 1.003), (0.06, 0.05, 0.997), (-0.06, 0.05, 1.003), (0.05, -0.06, 1.003), (-0.05, -0.06, 0.997)];
        let truths = around.map(|(x, y, share)| {
            let (near, place) = seen(centre + DVec2::new(x, y));
            let place = near + share * (place - near);
            (boundary.parity(near, place), boundary.is_dark(near), boundary.is_dark(place))
        });
        // With every edge marked, parity is darkness.
        let is_unclear = threshold < 0.0 && truths.iter().any(|truth| truth.0 != truth.2);
        if is_unclear || truths != [truths[0]; 5] {
            tally.near_borders += 1;
            continue;
        }
        let (truth, is_cut, _) = truths[0];
        *(if truth { &mut tally.dark } else { &mut tally.lit }) += 1;
        tally.cut += usize::from(is_cut);
        tally.wrong += usize::from((value != 0) != truth);
    }
    Ok(())
}

fn trials(seed: u64, count: u32, kind: Kind) -> Result<Tally, String> {
    println!("seed {seed}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let mut tally = Tally::default();
    for number in 0..count {
        let before = tally.wrong;
        trial(&gpu, &mut random, kind, &mut tally)?;
        if tally.wrong > before {
            println!("trial {number}: {} wrong", tally.wrong - before);
        }
    }
    println!("{tally:?}");
    Ok(tally)
}

const EVERY_CELL: Kind = Kind { near: [0.05, 0.2], threshold: -1.0, overflows: false, is_exchanged: false };

fn right(seed: u64, count: u32, kind: Kind) -> Result<Tally, String> {
    let tally = trials(seed, count, kind)?;
    let pixels = tally.dark + tally.lit + tally.near_borders;
    if tally.wrong > 0 || tally.dark < pixels / 10 || tally.lit < pixels / 10 || tally.near_borders > pixels / 4 {
        return Err(format!("{tally:?}"));
    }
    Ok(tally)
}

fn every_cell() -> Result<(), String> {
    right(1651, trials_of(24), EVERY_CELL).map(drop)
}

fn differences() -> Result<(), String> {
    right(1652, trials_of(24), Kind { threshold: 0.01, ..EVERY_CELL }).map(drop)
}

/// Near rectangles that are large: they cut the boundary, and lie across several maps.
fn cut() -> Result<(), String> {
    let tally = right(1653, trials_of(24), Kind { near: [0.5, 6.0], ..EVERY_CELL })?;
    if tally.cut < 1000 { Err(format!("the near rectangle is cut too rarely: {tally:?}")) } else { Ok(()) }
}

fn overflow() -> Result<(), String> {
    right(1654, trials_of(12), Kind { near: [0.05, 2.0], threshold: 0.01, overflows: true, is_exchanged: false })
        .map(drop)
}

/// Negative control.
fn exchanged() -> Result<(), String> {
    let tally = trials(1655, 10, Kind { is_exchanged: true, ..EVERY_CELL })?;
    if tally.wrong > 500 { Ok(()) } else { Err(format!("{tally:?}")) }
}

/// A plane that several maps see: what lies on it is lit, and what lies behind it is dark, also where the moved surface passes
/// from map to map.
fn plane() -> Result<(), String> {
    const SEED: u64 = 1657;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut seen, mut wrong) = ([0; 2], [0; 2]);
    for _ in 0..80 {
        let side = 9 + random.below(20) as u32;
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
        let light = vector(&mut random).as_vec3();
        let cameras = DepthMapCube::cameras(light.to_array(), 0.2, None, depth, side).map_err(text)?;
        let (light, normal) = (light.as_dvec3(), vector(&mut random));
        let height = f64::from(random.between(1.0, 3.0));
        let is_reversed = depth == DepthDirection::Reversed;
        let mut views = Vec::new();
        for camera in &cameras {
            let rays = Rays::new(camera, side);
            let map = Map::new([side; 2], is_reversed, |texel| {
                let ray = rays.at(middle(texel, side)).1.normalize();
                let t = height / -ray.dot(normal);
                let nothing = if is_reversed { 0.0 } else { 1.0 };
                if t > 0.0 && t < 1e4 { device_depth(camera, light + t * ray) } else { nothing }
            });
            views.push(depth_view(&texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?));
        }
        // An eye on the light's side of the plane, which looks at a place that is not far from the light's foot.
        let foot = light - height * normal;
        let aside = vector(&mut random);
        let target = foot + f64::from(random.between(0.0, 1.5)) * height * (aside - aside.dot(normal) * normal);
        let away = vector(&mut random);
        let away = if away.dot(normal) < 0.0 { -away } else { away };
        let place = target + f64::from(random.between(0.5, 4.0)) * away + 0.3 * normal;
        let (near, is_relative) = (0.05, true);
        let eye = Eye { place, forward: target - place, near, is_relative, depth, far: None, half_width: None };
        let eye = eye.camera();
        let rays = Rays::new(&eye, SIDE);
        // The move takes at most half of what is left to infinity, which is twice the distance.
        for (behind, expected) in [(0.0, false), (1.2 * height, true)] {
            let points = (0..SIDE * SIDE).map(|pixel| {
                let (near, ray) = rays.at(middle(pixel, SIDE));
                let t = -((near - foot).dot(normal) + behind) / ray.dot(normal);
                let point = near + t * ray;
                let way = point - light;
                let is_taken = t > 0.0 && t < 100.0 && -way.dot(normal) > 0.4 * way.length();
                is_taken.then_some(point)
            });
            let points: Vec<_> = points.collect();
            let nothing = if is_reversed { 0.0 } else { 1.0 };
            let depths: Vec<_> =
                points.iter().map(|point| point.map_or(nothing, |point| device_depth(&eye, point))).collect();
            let pipelines = pipelines(&gpu, depth, 2..3)?;
            // Behind the plane nothing of it is in the eye's depth.
            let options = DepthMapOptions { method: DepthMapMethod::EveryCell, ..Default::default() };
            let mut volumes = DepthMapCube::new(&pipelines, side, options).map_err(text)?;
            let textures = [0, 1, 2, 3, 4, 5].map(|face: usize| Some(&views[face]));
            let given = DepthCubeMaps { textures, lights: cameras, objects: [None; 6] };
            let stencil = stencil_of(&gpu, &pipelines, (SIDE, &depths), |encoder| {
                volumes.encode(encoder, &given, &eye).map_err(text)
            })?;
            let kind = usize::from(expected);
            seen[kind] += points.iter().flatten().count();
            let is_wrong = |(point, value): &(&Option<DVec3>, u8)| point.is_some() && (*value != 0) != expected;
            wrong[kind] += points.iter().zip(stencil).filter(is_wrong).count();
        }
    }
    println!("{seen:?} on the plane and behind it, {wrong:?} wrong");
    if wrong == [0; 2] && seen.iter().all(|&seen| seen > 20_000) {
        Ok(())
    } else {
        Err(format!("{wrong:?} of {seen:?}"))
    }
}

/// Slopes that would go on in the map that follows in the texture, if it followed.
fn slopes(side: u32, depth: DepthDirection) -> [Option<Map>; 6] {
    let is_reversed = depth == DepthDirection::Reversed;
    [0, 1, 2, 3, 4, 5].map(|face: u32| {
        let near = 0.1 + 0.02 * (face % 3) as f32 + 0.2 * (face / 3) as f32;
        let depth = |texel: u32| near + 0.002 * (texel % side) as f32 + 0.02 * (texel / side) as f32;
        Some(Map::new([side; 2], is_reversed, |texel| if is_reversed { 1.0 - depth(texel) } else { depth(texel) }))
    })
}

/// The place of a sample in the texture that has all maps, three in a row.
pub(crate) fn at_face(side: u32, face: u32, [x, y]: [u32; 2]) -> [u32; 2] {
    [face % 3 * side + x, face / 3 * side + y]
}

/// A sample: the number of its map, and its place in it.
type Sample = (u32, [u32; 2]);

/// For each sample those on its ray, in the order of the maps. Rays come from the cameras, in `f64`.
pub(crate) fn on_rays(cameras: &[ShadowCamera; 6], side: u32) -> HashMap<Sample, Vec<Sample>> {
    let inverse = cameras.map(|camera| Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse());
    let ray = |face: u32, [x, y]: [u32; 2]| {
        let [x, y] = [x, y].map(|at| (f64::from(at) + 0.5) / f64::from(side) * 2.0 - 1.0);
        let point = |depth: f64| {
            let point = inverse[face as usize] * glam::DVec4::new(x, -y, depth, 1.0);
            point.truncate() / point.w
        };
        let near = if cameras[0].depth == DepthDirection::Reversed { 1.0 } else { 0.0 };
        let (from, to) = (point(near), point(0.5));
        (to - from).normalize()
    };
    // The same ray of two cameras differs by less than a cell of this grid, and rays of neighbours by more than two.
    let name = |ray: DVec3| (ray * (200.0 * f64::from(side))).round().to_array().map(|part| part as i64);
    let all = (0..6).flat_map(|face| (0..side * side).map(move |at| (face, [at % side, at / side])));
    let all: Vec<Sample> = all.collect();
    let is_same = |a: DVec3, b: DVec3| a.distance(b) < 0.1 / f64::from(side);
    let mut found = HashMap::new();
    let rays: Vec<_> = all.iter().map(|&(face, at)| ray(face, at)).collect();
    let mut by_name: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (number, &ray) in rays.iter().enumerate() {
        by_name.entry(name(ray)).or_default().push(number);
    }
    for (number, &sample) in all.iter().enumerate() {
        let around = (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| [x, y, z])));
        let [x, y, z] = name(rays[number]);
        let near = around.filter_map(|[i, j, k]| by_name.get(&[x + i, y + j, z + k])).flatten();
        let mut same: Vec<_> = near.copied().filter(|&other| is_same(rays[number], rays[other])).collect();
        same.sort_unstable();
        found.insert(sample, same.into_iter().map(|number| all[number]).collect());
    }
    found
}

/// Six maps in one: each sample has the nearest depth on its ray, and the object of the first map that has it.
pub(crate) fn merged(cube: &Cube, objects: &[&[u32]]) -> (Vec<f32>, Vec<u32>) {
    let side = cube.side;
    let is_reversed = cube.cameras[0].depth == DepthDirection::Reversed;
    let far = if is_reversed { 0.0 } else { 1.0 };
    let rays = on_rays(&cube.cameras, side);
    let own = |(face, [x, y]): Sample| {
        let map = cube.maps[face as usize].as_ref()?;
        cast(map, i64::from(x), i64::from(y))
    };
    let places =
        (0..2 * side).flat_map(|y| (0..3 * side).map(move |x| (x / side + 3 * (y / side), [x % side, y % side])));
    let of_ray = |sample: Sample| {
        let mut nearest: Option<(f32, Sample)> = None;
        for &other in &rays[&sample] {
            let Some(depth) = own(other) else { continue };
            let is_nearer = |than: f32| if is_reversed { depth > than } else { depth < than };
            if nearest.is_none_or(|(than, _)| is_nearer(than)) {
                nearest = Some((depth, other));
            }
        }
        let Some((depth, (face, [x, y]))) = nearest else { return (far, 0) };
        let of_map = objects.get(face as usize).and_then(|objects| objects.get((y * side + x) as usize));
        (depth, of_map.copied().unwrap_or(0))
    };
    places.map(of_ray).unzip()
}

/// Samples and cells, with and without objects, thresholds, and marks that are continued.
fn lists() -> Result<(), String> {
    const SEED: u64 = 1656;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let mut random = Random::new(SEED);
    let eye = crate::stages::camera(DepthDirection::Reversed);
    let (mut shared, mut listed, mut continued) = (0, 0, 0);
    for round in 0..48 {
        let mut cube = cube(&mut random);
        let side = cube.side;
        if round % 8 == 7 {
            cube.maps = slopes(side, cube.cameras[0].depth);
        }
        let threshold = [-1.0, 0.0, 0.02][round % 3];
        // Marks, in some: two thresholds, and edges that are continued.
        let second = [None, None, Some([0.2, 1.0]), Some([0.01, 0.1])][round % 4];
        let dangling = second.map(|_| DanglingEdges { share: 0.125, cells: 1 + round as u32 % 5 });
        let method = |dangling| match second {
            _ if round % 8 == 7 => DepthMapMethod::Automatic { dangling },
            Some([low, high]) if round % 4 == 3 => DepthMapMethod::SecondDifferences { low, high, dangling },
            Some([threshold, _]) => DepthMapMethod::Differences { threshold, dangling },
            None if threshold < 0.0 => DepthMapMethod::EveryCell,
            None => DepthMapMethod::Differences { threshold, dangling },
        };
        let has_objects = round % 3 == 1;
        let numbers: Vec<_> = (0..6 * side * side).map(|_| u32::from(random.below(5) == 0) * 7).collect();
        let numbers: Vec<_> = numbers.chunks((side * side) as usize).collect();
        let (views, mut of_objects) = (views(&gpu, &cube.maps)?, Vec::new());
        for (map, numbers) in cube.maps.iter().zip(&numbers) {
            let objects = objects(&gpu, [side; 2], numbers);
            of_objects.push(map.is_some().then(|| objects.create_view(&wgpu::TextureViewDescriptor::default())));
        }
        let [textures, of_objects] =
            [&views, &of_objects].map(|views| [0, 1, 2, 3, 4, 5].map(|face: usize| views[face].as_ref()));
        let given_objects = if has_objects { of_objects } else { [None; 6] };
        let given = DepthCubeMaps { textures, lights: cube.cameras, objects: given_objects };
        let options = DepthMapOptions { method: method(dangling), ..Default::default() };
        let mut volumes = DepthMapCube::new(&pipelines, side, options).map_err(text)?;
        gpu.submit(|encoder| volumes.encode(encoder, &given, &eye).map(drop).map_err(text))?;
        let head: Vec<u32> = gpu.read(volumes.cells(), 1)?;
        let found: Vec<u32> = gpu.read(volumes.cells(), 1 + head[0] as usize)?;
        listed += found[0];
        let bits = |depths: &[f32]| depths.iter().map(|depth| depth.to_bits()).collect::<Vec<_>>();
        let (depths, numbers) = merged(&cube, &numbers);
        let samples = read(&gpu, volumes.texture().texture())?;
        same(&format!("samples of round {round}"), &bits(&samples), &bits(&depths))?;
        let is_reversed = cube.cameras[0].depth == DepthDirection::Reversed;
        let of_face = |face: u32| {
            let texels = (0..side * side).map(move |texel| at_face(side, face, [texel % side, texel / side]));
            let places: Vec<_> = texels.map(|[x, y]| (y * 3 * side + x) as usize).collect();
            let map = Map { size: [side; 2], is_reversed, depths: places.iter().map(|&at| depths[at]).collect() };
            (map, places.iter().map(|&at| numbers[at]).collect::<Vec<_>>())
        };
        let (faces, numbers): (Vec<_>, Vec<_>) = (0..6).map(of_face).unzip();
        let objects_of = |face: usize| if has_objects { &numbers[face][..] } else { &[] };
        let expected = if second.is_some() {
            let rule = rule_of(method(dangling), 1, is_reversed, TextureFormat::R32Float);
            listed_of_cube(&faces, |face, map| {
                let (entries, further) = rules::entries(map, objects_of(face), &rule, false);
                continued += further;
                entries
            })
        } else {
            listed_of_cube(&faces, |face, map| cells::entries(map, objects_of(face), threshold, false))
        };
        same(&format!("cells of round {round}"), &found, &expected)?;
        let is_shared = |(face, own): (usize, &Map)| {
            let map = cube.maps[face].as_ref();
            map.map_or(0, |map| bits(&map.depths).iter().zip(bits(&own.depths)).filter(|(a, b)| *a != b).count())
        };
        shared += faces.iter().enumerate().map(is_shared).sum::<usize>();
        if !cube.maps.iter().all(Option::is_none) && round == 0 {
            let (other, _) = merged(&Cube { maps: [const { None }; 6], ..cube }, &[]);
            must_fail("no maps", &same("samples", &bits(&other), &bits(&depths)))?;
        }
    }
    println!("{listed} cells, {continued} edges are continued, {shared} samples are another map's");
    if listed > 3000 && shared > 300 && continued > 20 { Ok(()) } else { Err("too few".to_owned()) }
}

fn refused() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let options = DepthMapOptions::default();
    let made = |side| DepthMapCube::new(&pipelines, side, options).err();
    // Nothing is there.
    let given = |side, lights: [ShadowCamera; 6]| {
        let mut cube = DepthMapCube::new(&pipelines, side, options).map_err(text)?;
        let maps = DepthCubeMaps { textures: [None; 6], lights, objects: [None; 6] };
        let eye = crate::stages::camera(DepthDirection::Reversed);
        gpu.submit(|encoder| Ok(cube.encode(encoder, &maps, &eye).err()))
    };
    let reversed = DepthDirection::Reversed;
    let right = |place, near, side| DepthMapCube::cameras(place, near, None, reversed, side).map_err(text);
    let place = [1.0, 2.0, 3.0];
    let cameras = right(place, 0.1, 16)?;
    let ended = DepthMapCube::cameras(place, 0.1, Some(50.0), reversed, 16).map_err(text)?;
    let standard = DepthMapCube::cameras(place, 0.1, None, DepthDirection::Standard, 16).map_err(text)?;
    let with = |face: usize, camera: ShadowCamera| {
        let mut cameras = cameras;
        cameras[face] = camera;
        given(16, cameras)
    };
    let apart = |face, what| Some(DepthMapError::Apart { face, what });
    let lost = ShadowCamera { view_projection: [[0.0; 4]; 4], ..cameras[2] };
    let parallel = Eye {
        place: DVec3::ZERO,
        forward: DVec3::X,
        near: 0.1,
        is_relative: true,
        depth: reversed,
        far: Some(9.0),
        half_width: Some(2.0),
    };
    let most = gpu.device.limits().max_texture_dimension_2d;
    let too_large = DepthMapError::Texture { size: [3 * most, 2 * most], most };
    let two = DepthMapPipelines::antialiased(&gpu.pipelines, &ShadowFormat::default(), 6..8).map_err(text)?;
    let found = [made(16), made(2), made(most), made(20_000), made(u32::MAX)];
    let cells = |side| Some(DepthMapError::Cells(side));
    let expected = [None, Some(DepthMapError::Side(2)), Some(too_large), cells(20_000), cells(u32::MAX)];
    same("sizes", &found, &expected)?;
    same("bits", &[DepthMapCube::new(&two, 16, options).err()], &[Some(DepthMapError::OneBit(2))])?;
    let found = [
        given(16, cameras)?,
        // Cameras for 90°: the width of a map with very many texels.
        given(16, right(place, 0.1, 1 << 20)?)?,
        given(16, right(place, 0.1, 15)?)?,
        with(1, right([1.0, 2.0, 3.001], 0.1, 16)?[1])?,
        with(5, right(place, 0.2, 16)?[5])?,
        with(3, cameras[2])?,
        with(4, ended[4])?,
        with(3, standard[3])?,
        with(0, parallel.camera())?,
        with(1, lost)?,
    ];
    let [width, place, depths] = [
        "the middles of its outermost texels are not 45° from its middle",
        "it is at another place",
        "its near or far distance, or the scale of its matrix, differs",
    ];
    let expected = [
        None,
        apart(0, width),
        apart(0, width),
        apart(1, place),
        apart(5, depths),
        apart(3, "it does not look along its axis of the cube, or is turned"),
        apart(4, depths),
        apart(3, "its depth direction differs"),
        Some(DepthMapError::Parallel { face: 0 }),
        Some(DepthMapError::CubeLight { face: 1, error: rimline::CameraError::Singular }),
    ];
    same("cubes", &found, &expected)?;
    cameras_refused()?;
    memory(&gpu, &pipelines, &cameras)
}

/// Cameras that are none, and what the errors say.
fn cameras_refused() -> Result<(), String> {
    let (inf, nan) = (f32::INFINITY, f32::NAN);
    let refused = |place, near, far, side| {
        let of = |depth| DepthMapCube::cameras(place, near, far, depth, side).err().map(text);
        let [reversed, standard] = [DepthDirection::Reversed, DepthDirection::Standard].map(of);
        if reversed == standard { reversed } else { Some(format!("{reversed:?} and {standard:?}")) }
    };
    let place = [1.0, 2.0, 3.0];
    let far_away = [1e30, 0.0, 0.0];
    let sides = [0, 1, 2, 3].map(|side| refused(place, 0.1, Some(50.0), side));
    let nears = [0.0, -0.1, inf, nan, 1e-33].map(|near| refused(place, near, None, 16));
    let tiny = [f32::MIN_POSITIVE, 1e-33].map(|near| refused(place, near, None, 16));
    let fars = [0.1, 0.05, -1.0, inf, nan, 0.2].map(|far| refused(place, 0.1, Some(far), 16));
    let places = [[nan, 0.0, 0.0], [0.0, inf, 0.0], far_away].map(|place| refused(place, 0.1, None, 16));
    let is_told = |errors: &[Option<String>], part: &str| {
        let (last, wrong) = errors.split_last().ok_or("none")?;
        let told = wrong.iter().all(|error| error.as_ref().is_some_and(|error| error.contains(part)));
        if told && last.is_none() { Ok(()) } else { Err(format!("{part}: {errors:?}")) }
    };
    is_told(&sides, "at least 3 texels a side")?;
    is_told(&nears, "`near` is ")?;
    is_told(&tiny, "leave the normal range")?;
    is_told(&fars, "`near` 0.1; take a finite distance above `near`")?;
    is_told(&places, "take finite coordinates")
}

/// The limit of memory holds for textures and buffers together, and for those of the first objects.
fn memory(gpu: &Gpu, pipelines: &DepthMapPipelines, cameras: &[ShadowCamera; 6]) -> Result<(), String> {
    let made = |memory_limit| {
        DepthMapCube::new(pipelines, 16, DepthMapOptions { memory_limit: Some(memory_limit), ..Default::default() })
    };
    let needed = |error: Option<DepthMapError>| match error {
        Some(DepthMapError::Device(DeviceError::MemoryLimit { bytes, .. })) => Ok(bytes),
        other => Err(format!("{other:?}")),
    };
    let texels = 6 * 16 * 16;
    let plain = needed(made(1).err())?;
    let [map, objects] = [TextureFormat::R32Float, TextureFormat::R32Uint].map(|format| {
        let made = if format == TextureFormat::R32Uint {
            objects(gpu, [16; 2], &[0; 256])
        } else {
            texture(gpu, [16; 2], format, &[0.5; 256]).expect("a texture")
        };
        made.create_view(&wgpu::TextureViewDescriptor::default())
    });
    let with = |memory_limit, objects| {
        let mut cube = made(memory_limit).map_err(text)?;
        let textures = [Some(&map), None, None, None, None, None];
        let maps = DepthCubeMaps { textures, lights: *cameras, objects };
        let eye = crate::stages::camera(DepthDirection::Reversed);
        let found = gpu.submit(|encoder| Ok(cube.encode(encoder, &maps, &eye).err()))?;
        Ok::<_, String>((found, cube.cells().size()))
    };
    let (none, some) = ([None; 6], [Some(&objects), None, None, None, None, None]);
    let (found, cells) = with(plain, none)?;
    same("without objects", &[found], &[None])?;
    let all = needed(with(plain, some)?.0)?;
    if all - plain != 4 * texels || plain < 4 * texels + cells {
        return Err(format!("{plain} bytes, {all} with objects"));
    }
    same(
        "enough",
        &[with(all, some)?.0, with(all, [None, Some(&objects), None, None, None, None])?.0],
        &[None, Some(DepthMapError::NoObjects { face: 0 })],
    )?;
    needed(with(all - 1, some)?.0).map(drop)
}
