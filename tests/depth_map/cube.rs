//! Cubes of six maps: the samples that `depth_cube` merges, and their cells, against rays of the cameras.

use std::collections::HashMap;

use glam::{DMat3, DVec3, Mat4};
use rimline::ShadowCamera;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapCube, DepthMapMethod};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::same;
use wgpu::TextureFormat;

use crate::boundary::{names, positions};
use crate::maps::Map;
use crate::metric::bits;
use crate::parity::{device_depth, either};
use crate::picture::{EVERY_CELL, Encoded, FACES, Maps, REVERSED, Volumes, by, differences, pipelines};
use crate::rules::{Rule, cast, listed_of_cube};
use crate::stages::camera;
use rimline_testkit::frames::vector;
use rimline_testkit::textures::{objects, read};

pub(crate) const TESTS: &[Test] = &[("cube_samples_and_cells_are_those_of_their_rays", lists)];

/// Six maps with their cameras.
pub(crate) struct Cube {
    pub(crate) light: DVec3,
    pub(crate) cameras: [ShadowCamera; 6],
    pub(crate) maps: [Option<Map>; 6],
    /// Each map has depths that its neighbours do not share.
    pub(crate) side: u32,
}

/// Discs across borders and corners and elsewhere, on a background or not, with noise or not, and missing maps, of `side`
/// texels.
pub(crate) fn cube_of(random: &mut Random, side: u32) -> Cube {
    let light = 2.0 * vector(random);
    let depth = either(random);
    let far = [None, Some(40.0)][random.below(2)];
    let cameras = DepthMapCube::cameras(light.as_vec3().to_array(), 0.3, far, depth, side).expect("a cube");
    let light = light.as_vec3().as_dvec3();
    // The world is turned, or mirrored.
    let turn = DMat3::from_axis_angle(vector(random), f64::from(random.between(0.0, 6.0)));
    let mirror = if random.below(3) == 0 { -1.0 } else { 1.0 };
    let turn = mirror * [DMat3::IDENTITY, turn][random.below(2)];
    let cameras = cameras.map(|camera| {
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let matrix = matrix * glam::DMat4::from_mat3(turn.inverse());
        ShadowCamera { view_projection: matrix.as_mat4().to_cols_array_2d(), ..camera }
    });
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
    let is_reversed = depth == REVERSED;
    let maps = cameras.map(|camera| {
        let position = positions(&camera, [side; 2], [0.0; 2]);
        let is_there = random.below(8) != 0;
        let map = Map::new([side; 2], is_reversed, |texel| {
            let ray = (position([texel % side, texel / side].map(i64::from), 0.5) - light).normalize();
            let hits = discs.iter().filter(|(axis, cosine, _)| axis.dot(ray) > *cosine).map(|disc| disc.2);
            let distance = hits.fold(background, f64::min);
            match random.below(6) {
                0 if noise => f32::NAN,
                1 | 2 if noise => device_depth(&camera, light + f64::from(random.between(1.0, 7.0)) * ray),
                _ if distance.is_infinite() => f32::from(!is_reversed),
                _ => device_depth(&camera, light + distance * ray),
            }
        });
        is_there.then_some(map)
    });
    Cube { light, cameras, maps, side }
}

/// Slopes that would go on in the map that follows in the texture, if it followed.
fn slopes(side: u32, is_reversed: bool) -> [Option<Map>; 6] {
    [0, 1, 2, 3, 4, 5].map(|face: u32| {
        let near = 0.1 + 0.02 * (face % 3) as f32 + 0.2 * (face / 3) as f32;
        let depth = |texel: u32| near + 0.002 * (texel % side) as f32 + 0.02 * (texel / side) as f32;
        Some(Map::new([side; 2], is_reversed, |texel| if is_reversed { 1.0 - depth(texel) } else { depth(texel) }))
    })
}

/// A sample: the number of its map, and its position in it.
type Sample = (u32, [u32; 2]);

/// For each sample those on its ray, in the order of the maps. Rays come from the cameras, in `f64`.
pub(crate) fn on_rays(cameras: &[ShadowCamera; 6], side: u32) -> HashMap<Sample, Vec<Sample>> {
    let name = names(cameras, side);
    let name = |(face, at): Sample| name(face as usize, at.map(i64::from));
    let all = || (0..6).flat_map(move |face| (0..side * side).map(move |at| (face, [at % side, at / side])));
    let mut rays: HashMap<_, Vec<Sample>> = HashMap::new();
    for sample in all() {
        rays.entry(name(sample)).or_default().push(sample);
    }
    all().map(|sample| (sample, rays[&name(sample)].clone())).collect()
}

/// Six maps in one: each sample has the nearest depth on its ray, and the object of the first map that has it.
pub(crate) fn merged(cube: &Cube, objects: &[&[u32]]) -> (Vec<f32>, Vec<u32>) {
    let side = cube.side;
    let is_reversed = cube.cameras[0].depth == REVERSED;
    let rays = on_rays(&cube.cameras, side);
    let positions =
        (0..2 * side).flat_map(|y| (0..3 * side).map(move |x| (x / side + 3 * (y / side), [x % side, y % side])));
    let of_ray = |sample: Sample| {
        let mut nearest: Option<(f32, Sample)> = None;
        for &(face, [x, y]) in &rays[&sample] {
            let map = cube.maps[face as usize].as_ref();
            let Some(depth) = map.and_then(|map| cast(map, i64::from(x), i64::from(y))) else { continue };
            if nearest.is_none_or(|(than, _)| if is_reversed { depth > than } else { depth < than }) {
                nearest = Some((depth, (face, [x, y])));
            }
        }
        let Some((depth, (face, [x, y]))) = nearest else { return (f32::from(!is_reversed), 0) };
        let of_map = objects.get(face as usize).and_then(|objects| objects.get((y * side + x) as usize));
        (depth, of_map.copied().unwrap_or(0))
    };
    positions.map(of_ray).unzip()
}

/// The maps of a cube, each with a value for each texel, from those of the texture that has all.
pub(crate) fn parted<T: Copy>(side: u32, all: &[T]) -> Vec<Vec<T>> {
    // Three in a row.
    let row = |face: u32, y: u32| ((face / 3 * side + y) * 3 + face % 3) * side;
    let of_face = |face| (0..side).flat_map(move |y| (0..side).map(move |x| row(face, y) + x));
    (0..6).map(|face| of_face(face).map(|at| all[at as usize]).collect()).collect()
}

/// Samples and cells, with and without objects, thresholds, and marks that are continued.
fn lists() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1656)?;
    let pipelines = pipelines(&gpu, REVERSED, 7..8)?;
    let (mut shared, mut listed, mut continued, mut without) = (0, 0, 0, 0);
    for round in 0..96 {
        let side = 3 + random.below(8) as u32;
        let mut cube = cube_of(&mut random, side);
        let is_reversed = cube.cameras[0].depth == REVERSED;
        if round % 8 == 7 {
            cube.maps = slopes(side, is_reversed);
        } else if round == 46 {
            cube.maps = [const { None }; 6];
        }
        let threshold = [-1.0, 0.0, 0.02][round % 3];
        // Marks, in some: two thresholds, and edges that are continued.
        let dangling = Some(DanglingEdges { share: 0.125, cells: 1 + round as u32 % 5 });
        let method = match round % 4 {
            _ if round % 16 == 7 => DepthMapMethod::Automatic { dangling },
            3 => DepthMapMethod::SecondDifferences { low: 0.01, high: 0.1, dangling },
            2 => DepthMapMethod::Differences { threshold: 0.2, dangling },
            _ if threshold < 0.0 => EVERY_CELL,
            _ => differences(threshold),
        };
        let numbers: Vec<_> = (0..6 * side * side).map(|_| u32::from(random.below(5) == 0) * 7).collect();
        let numbers: Vec<_> = numbers.chunks((side * side) as usize).collect();
        let mut given = Maps::all(&gpu, (&cube.maps, side), TextureFormat::R32Float, &cube.cameras)?;
        let has_objects = round % 3 == 1;
        if has_objects {
            let of_map = |face: usize| cube.maps[face].as_ref().map(|_| objects(&gpu, [side; 2], numbers[face]));
            given.objects = FACES.map(of_map).to_vec();
        }
        let encoded = Encoded::new(&gpu, &pipelines, &given, &camera(REVERSED), by(method))?;
        let Volumes::Cube(volumes) = &encoded.volumes else { return Err("no cube".to_owned()) };
        let (depths, numbers) = merged(&cube, &numbers);
        let samples = read(&gpu, volumes.texture().texture())?;
        same(&format!("samples of round {round}"), &bits(&samples), &bits(&depths))?;
        let of_face = |depths| Map { size: [side; 2], is_reversed, depths };
        let faces: Vec<_> = parted(side, &depths).into_iter().map(of_face).collect();
        let numbers = if has_objects { parted(side, &numbers) } else { Vec::new() };
        let rule = Rule::new(method, 1, is_reversed, TextureFormat::R32Float);
        let (expected, further) = listed_of_cube(&faces, &numbers, &rule);
        same(&format!("cells of round {round}"), &encoded.list(&gpu)?, &expected)?;
        listed += expected[0];
        continued += further;
        let is_shared = |(face, merged): (usize, &Map)| {
            let map = cube.maps[face].as_ref();
            map.map_or(0, |map| bits(&map.depths).iter().zip(bits(&merged.depths)).filter(|(a, b)| *a != b).count())
        };
        shared += faces.iter().enumerate().map(is_shared).sum::<usize>();
        // A negative control.
        let (other, _) = merged(&Cube { maps: [const { None }; 6], ..cube }, &[]);
        without += usize::from(other != depths);
        if round == 46 {
            same("without maps", &expected, &[0])?;
        }
    }
    println!("{listed} cells, {continued} edges are continued, {shared} samples are another map's");
    if listed > 3000 && shared > 300 && continued > 20 && without > 40 { Ok(()) } else { Err("too few".to_owned()) }
}
