//! Near caps that are left out: pictures do not change, and `depth_near` and `depth_near_walls` tell what the samples around the
//! near rectangle say.

use glam::DVec3;
use rimline::gpu::ShadowFormat;
use rimline::gpu::depth_map::{
    DepthCubeMaps, DepthMap, DepthMapCube, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes,
};
use rimline::reference::depth_map::DepthMapNearCap;
use rimline::reference::depth_map::near_box;
use rimline::reference::layout::DepthNearBox;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, same};
use wgpu::TextureFormat;

use crate::cells::{cast, rank};
use crate::contours::distance;
use crate::cube::{Cube, cube_of, views};
use crate::maps::Map;
use crate::parity::{light, map, seen, seen_depths, vector};
use crate::picture::stencil_of;
use crate::scene::{Eye, Rays};
use crate::textures::{depth_view, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("near_caps_that_are_left_out_change_no_picture", of_maps),
    ("near_caps_beyond_the_far_plane_are_drawn", beyond),
    ("near_caps_of_cubes_that_are_left_out_change_no_picture", of_cubes),
];

const SIDE: u32 = 40;
const CUBE_SIDE: u32 = 24;

/// Pictures by what is known of their near caps: lit, told so, told not so, drawn. And dark pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    known: [usize; 4],
    dark: usize,
    /// Pictures whose result changes if surfaces are never nearer: the negative control.
    others: usize,
}

impl Tally {
    fn count(&mut self, gpu: &Gpu, cap: &DepthMapNearCap, told: impl FnOnce() -> bool) -> Result<(), String> {
        let at = match cap {
            DepthMapNearCap::Lit => 0,
            DepthMapNearCap::Told(draw) => {
                let (draw, told): (Vec<u32>, _) = (gpu.read(draw, 4)?, told());
                same("the draw", &draw, &[if told { 3 } else { 0 }, 1, 0, 0])?;
                1 + usize::from(told)
            }
            DepthMapNearCap::Drawn => 3,
        };
        self.known[at] += 1;
        Ok(())
    }
}

/// Pipelines for both directions of depth and some bits.
#[derive(Default)]
struct Made(Vec<DepthMapPipelines>);

impl Made {
    fn get(&mut self, gpu: &Gpu, depth: DepthDirection, bits: u32) -> Result<&DepthMapPipelines, String> {
        let is_it = |own: &DepthMapPipelines| own.format().depth == depth && own.bits() == (0..bits);
        if !self.0.iter().any(is_it) {
            let format = ShadowFormat { depth, ..Default::default() };
            self.0.push(DepthMapPipelines::antialiased(&gpu.pipelines, &format, 0..bits).map_err(text)?);
        }
        self.0.iter().find(|own| is_it(own)).ok_or_else(|| "no pipelines".to_owned())
    }
}

/// The samples of a box.
fn samples(near: &DepthNearBox) -> impl Iterator<Item = [u32; 2]> {
    let ([x, y], [across, down]) = (near.first, near.size);
    (y..y + down).flat_map(move |y| (x..x + across).map(move |x| [x, y]))
}

/// Whether triangles between the samples may be nearer than the near rectangle. Texel 0 comes after a border.
fn may_reach(map: &Map, border: i64, near: &DepthNearBox) -> bool {
    let own = |[x, y]: [u32; 2]| cast(map, i64::from(x) - border, i64::from(y) - border);
    samples(near).any(|at| own(at).is_some_and(|depth| rank(map, Some(depth)) <= i64::from(near.key)))
}

/// Whether surfaces that go on up to contours may be. A sample moves nearer by the largest step to a neighbour that is farther away,
/// in each direction.
fn may_reach_walls(map: &Map, near: &DepthNearBox) -> bool {
    let nearest = |at: [i32; 2]| {
        let own = distance(map, at)?;
        let nearing = |[x, y]: [i32; 2]| {
            let beside = [[at[0] - x, at[1] - y], [at[0] + x, at[1] + y]];
            beside.into_iter().filter_map(|there| distance(map, there)).map(|other| (other - own).max(0)).max()
        };
        Some(own - nearing([1, 0]).unwrap_or(0) - nearing([0, 1]).unwrap_or(0))
    };
    let mut nearest = samples(near).filter_map(|at| nearest(at.map(|at| at as i32)));
    nearest.any(|distance| distance <= i64::from(near.distance))
}

/// A map with five texels each way for each of another.
fn enlarged(map: &Map) -> Map {
    let [across, down] = map.size.map(|texels| 5 * texels);
    let texel = |at: u32| map.depths[(at / across / 5 * map.size[0] + at % across / 5) as usize];
    Map::new([across, down], map.is_reversed, texel)
}

/// An eye near the scene, and the depths that it sees. Its near plane is near or far away from it.
fn look(random: &mut Random, place: f64) -> (ShadowCamera, Vec<f32>) {
    let place = place * f64::from(random.between(0.1, 1.0)) * vector(random);
    let forward = vector(random) * 3.0 - place;
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
    let (low, high) = [(0.01, 0.3), (0.3, 3.0)][random.below(2)];
    let near = f64::from(random.between(low, high));
    let (far, half_width) = [(None, None), (Some(60.0), None), (Some(60.0), Some(2.0))][random.below(3)];
    let eye = Eye { place, forward, near, is_relative: random.below(2) == 0, depth, far, half_width }.camera();
    let rays = Rays::new(&eye, SIDE);
    let seen = seen(random, &rays);
    (eye, seen_depths(&eye, SIDE, &seen))
}

/// Eyes farther away than any depth of the map. Far is no surface, but a map may clamp to it what is behind: all is drawn.
fn beyond() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut made = Made::default();
    let map = Map::new([9, 9], false, |_| 0.5);
    let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let place = DVec3::new(0.5, 1.0, -2.0);
    let forward = DVec3::new(0.0, 0.0, 1.0);
    for (depth, is_parallel) in
        [DepthDirection::Standard, DepthDirection::Reversed].map(|way| [(way, true), (way, false)]).concat()
    {
        let half_width = is_parallel.then_some(2.0);
        let light = Eye { place, forward, near: 0.5, is_relative: true, depth, far: Some(2.5), half_width }.camera();
        let pipelines = made.get(&gpu, depth, 1)?;
        for along in [0.6, 2.0, 2.6, 4.5, 8.0, 8.9, 1e5] {
            let eye = Eye {
                place: place + along * forward,
                forward,
                near: 1e-3,
                is_relative: true,
                depth,
                far: None,
                half_width: None,
            };
            let mut volumes = DepthMapVolumes::new(pipelines, map.size, DepthMapOptions::default()).map_err(text)?;
            let mut cap = DepthMapNearCap::Lit;
            let given = DepthMap { texture: &depth_view(&texture), light, objects: None };
            gpu.submit(|encoder| {
                cap = volumes.encode(encoder, &given, &eye.camera()).map_err(text)?.near_cap().clone();
                Ok(())
            })?;
            let is_drawn = match &cap {
                DepthMapNearCap::Lit => false,
                DepthMapNearCap::Told(draw) => gpu.read::<u32>(draw, 1)? == [3],
                DepthMapNearCap::Drawn => true,
            };
            same(&format!("{depth:?}, parallel {is_parallel}, {along} away"), &[is_drawn], &[along > 1.0])?;
        }
    }
    Ok(())
}

fn of_maps() -> Result<(), String> {
    const SEED: u64 = 1695;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut tallies, mut pipelines) = ([Tally::default(); 3], Made::default());
    for round in 0..if is_long() { 3000 } else { 300 } {
        let (camera, _) = light(&mut random);
        let map = enlarged(&map(&mut random, &camera));
        let (eye, depths) = look(&mut random, [8.0, 24.0][round % 2]);
        let way = round % 3;
        let plain = DepthMapOptions::default();
        let options = match way {
            0 | 1 => plain,
            _ => {
                let method = DepthMapMethod::Contours { threshold: 0.005, sideways: 0.25, depth: 0.02 };
                DepthMapOptions { method, ..plain }
            }
        };
        let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
        let pipelines = pipelines.get(&gpu, eye.depth, [1, 2, 1][way])?;
        let tally = &mut tallies[way];
        let mut pictures = Vec::new();
        for skip_near_caps in [true, false] {
            let options = DepthMapOptions { skip_near_caps, ..options };
            let mut volumes = DepthMapVolumes::new(pipelines, map.size, options).map_err(text)?;
            let mut cap = DepthMapNearCap::Drawn;
            pictures.push(stencil_of(&gpu, pipelines, (SIDE, &depths), |encoder| {
                let map = DepthMap { texture: &depth_view(&texture), light: camera, objects: None };
                let frame = volumes.encode(encoder, &map, &eye).map_err(text)?;
                cap = frame.near_cap().clone();
                Ok(frame)
            })?);
            if !skip_near_caps {
                same("without the switch", &[cap], &[DepthMapNearCap::Drawn])?;
                continue;
            }
            let near = near_box(&[camera], map.size, (&eye, pipelines.format().depth_stencil), way == 2);
            let told = |near| if way == 2 { may_reach_walls(&map, near) } else { may_reach(&map, 1, near) };
            tally.count(&gpu, &cap, || near.as_ref().is_some_and(told))?;
            // Negative control: surfaces that are never nearer.
            let other = near.map(|near| DepthNearBox { key: 0, distance: i32::MIN, ..near });
            tally.others += usize::from(near.as_ref().is_some_and(told) != other.as_ref().is_some_and(told));
        }
        same(&format!("round {round}, {options:?}"), &pictures[0], &pictures[1])?;
        tally.dark += pictures[0].iter().filter(|&&value| value != 0).count();
    }
    if tallies.iter().any(|tally| tally.others < 10) {
        return Err(format!("another limit goes unnoticed: {tallies:?}"));
    }
    report("maps, bits, walls", &tallies, [10, 4, 10, 0])
}

fn of_cubes() -> Result<(), String> {
    const SEED: u64 = 1696;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut tally, mut pipelines) = (Tally::default(), Made::default());
    for round in 0..if is_long() { 1000 } else { 60 } {
        let Cube { light, cameras, maps, .. } = cube_of(&mut random, CUBE_SIDE);
        let (eye, depths) = look(&mut random, 5.0 + light.length());
        let pipelines = pipelines.get(&gpu, eye.depth, 1)?;
        let views = views(&gpu, &maps)?;
        let mut pictures = Vec::new();
        for skip_near_caps in [true, false] {
            let options = DepthMapOptions { skip_near_caps, ..Default::default() };
            let mut volumes = DepthMapCube::new(pipelines, CUBE_SIDE, options).map_err(text)?;
            let mut cap = DepthMapNearCap::Drawn;
            pictures.push(stencil_of(&gpu, pipelines, (SIDE, &depths), |encoder| {
                let textures = [0, 1, 2, 3, 4, 5].map(|face: usize| views[face].as_ref());
                let maps = DepthCubeMaps { textures, lights: cameras, objects: [None; 6] };
                let frame = volumes.encode(encoder, &maps, &eye).map_err(text)?;
                cap = frame.near_cap().clone();
                Ok(frame)
            })?);
            if skip_near_caps {
                let near = near_box(&cameras, [CUBE_SIDE; 2], (&eye, pipelines.format().depth_stencil), false);
                let is_reversed = cameras[0].depth == DepthDirection::Reversed;
                let depths = read(&gpu, volumes.texture().texture())?;
                // Six maps in one, without a border.
                let all = Map { size: [3 * CUBE_SIDE, 2 * CUBE_SIDE], is_reversed, depths };
                tally.count(&gpu, &cap, || near.is_some_and(|near| may_reach(&all, 0, &near)))?;
            }
        }
        same(&format!("round {round}"), &pictures[0], &pictures[1])?;
        tally.dark += pictures[0].iter().filter(|&&value| value != 0).count();
    }
    report("cubes", &[tally], [0, 5, 5, 5])
}

fn report(what: &str, tallies: &[Tally], least: [usize; 4]) -> Result<(), String> {
    println!("{what}: {tallies:?}");
    let few = |tally: &Tally| tally.dark < 1000 || tally.known.iter().zip(least).any(|(&known, least)| known < least);
    if tallies.iter().any(few) { Err(format!("too few of a kind: {tallies:?}")) } else { Ok(()) }
}
