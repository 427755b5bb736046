//! Wrong pixels of a detector, each traced to what it left out: the way from the near rectangle to what is seen crosses an odd
//! number of triangles that every cell has and the detector has not.

use std::collections::HashSet;

use glam::{DVec2, DVec3, DVec4};
use rimline::gpu::depth_map::{DepthMap, DepthMapMethod, DepthMapOptions, DepthMapVolumes};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::boundary::{Boundary, Name};
use crate::exact::{Moves, steps};
use crate::maps::Map;
use crate::parity::{device_depth, middle};
use crate::picture::{pipelines, stencil_of};
use crate::scene::{Eye, Rays};
use crate::textures::{depth_view, read, texture};
use crate::views::{SIDE, View, worlds};

pub(crate) const TESTS: &[Test] = &[
    ("wrong_pixels_are_traced_to_missed_edges", of_worlds),
    ("stairs_without_an_edge_are_traced_to_missed_edges", of_stairs),
];

/// The stencil of a square picture, and the triangles that were drawn.
pub(crate) fn drawn(
    gpu: &Gpu,
    (map, light): (&wgpu::Texture, ShadowCamera),
    (eye, depths): (&ShadowCamera, &[f32]),
    edges: DepthMapMethod,
    side: u32,
) -> Result<(Vec<u8>, HashSet<Name>), String> {
    let pipelines = pipelines(gpu, eye.depth, 0..1)?;
    let options = DepthMapOptions { method: edges, ..Default::default() };
    let mut volumes = DepthMapVolumes::new(&pipelines, [map.width(), map.height()], options).map_err(text)?;
    let stencil = stencil_of(gpu, &pipelines, (side, depths), |encoder| {
        volumes.encode(encoder, &DepthMap { texture: &depth_view(map), light, objects: None }, eye).map_err(text)
    })?;
    let list: Vec<u32> = gpu.read(volumes.cells(), usize::MAX)?;
    let across = map.width() + 1;
    let entries = list.iter().skip(1).take(list[0] as usize);
    let names = entries.flat_map(|&entry| {
        let cell = entry & ((1 << 29) - 1);
        let at = [cell % across, cell / across].map(|at| i64::from(at) - 1);
        (0..2).filter(move |half| entry >> (30 + half) & 1 == 1).map(move |half| (at, half))
    });
    Ok((stencil, names.collect()))
}

/// A light, its map, an eye, and what it sees through the middle of each pixel: from where to where, and whether light reaches
/// it.
struct Given<'a> {
    light: ShadowCamera,
    at: DVec4,
    map: &'a wgpu::Texture,
    eye: ShadowCamera,
    depths: &'a [f32],
    pixels: &'a [(usize, DVec3, bool)],
}

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    /// Wrong ones that every cell has right.
    wrong: usize,
    traced: usize,
    /// Right ones, and those of them whose way crosses an odd number of missed triangles.
    right: usize,
    right_traced: usize,
    /// Wrong ones that would be traced to triangles beside those that were missed.
    beside: usize,
}

impl Tally {
    fn add(&mut self, gpu: &Gpu, given: &Given<'_>, edges: DepthMapMethod, share: usize) -> Result<(), String> {
        let Given { light, at, map: texture, eye, depths, pixels } = *given;
        let every = drawn(gpu, (texture, light), (&eye, depths), DepthMapMethod::EveryCell, SIDE)?;
        let found = drawn(gpu, (texture, light), (&eye, depths), edges, SIDE)?;
        let missed: HashSet<Name> = every.1.difference(&found.1).copied().collect();
        let size = [texture.width(), texture.height()];
        let is_reversed = light.depth == DepthDirection::Reversed;
        let map = Map { size, is_reversed, depths: read(gpu, texture)? };
        let format = texture.format();
        let moves = Moves { slope_bias: 0.5, steps: steps(format, light.depth), spread: false };
        let moved = |texel| moves.depth(&map, texel).map(|depth| depth.0);
        let boundary = Boundary::moved(&map, &light, at, -1.0, None, &moved);
        let rays = Rays::new(&eye, SIDE);
        for &(pixel, place, is_lit) in pixels {
            let is_right = |stencil: &[u8]| (stencil[pixel] == 0) == is_lit;
            if !is_right(&every.0) {
                continue;
            }
            let is_wrong = !is_right(&found.0);
            if !is_wrong && pixel % share != 0 {
                continue;
            }
            let middle = middle(pixel as u32, SIDE);
            // Within what a rasterizer rounds places to.
            let around = [(0.0, 0.0), (0.01, 0.01), (-0.01, 0.01), (0.01, -0.01), (-0.01, -0.01)];
            let crossed = around.map(|(x, y)| boundary.crossings(rays.at(middle + DVec2::new(x, y)).0, place));
            let is_odd = |names: &[Name], by: i64| {
                let there = |&&([x, y], half): &&Name| missed.contains(&([x + by, y + 2 * by], half));
                names.iter().filter(there).count() % 2 == 1
            };
            let is_traced = crossed.iter().any(|names| is_odd(names, 0));
            if is_wrong {
                self.wrong += 1;
                self.traced += usize::from(is_traced);
                self.beside += usize::from(crossed.iter().any(|names| is_odd(names, 3)));
                if !is_traced {
                    println!("{edges:?}: pixel {pixel}, {place}, lit {is_lit}: {:?}", crossed[0]);
                }
            } else {
                self.right += 1;
                self.right_traced += usize::from(crossed.iter().all(|names| is_odd(names, 0)));
            }
        }
        Ok(())
    }

    /// Every wrong pixel is traced, and no right one is: that is the negative control.
    fn check(&self, what: &str, least: usize) -> Result<(), String> {
        println!("{what}: {self:?}");
        let is_told = self.traced == self.wrong && self.right_traced == 0;
        if is_told && self.wrong >= least && self.right > 500 { Ok(()) } else { Err(format!("{what}: {self:?}")) }
    }
}

/// Bodies on a ground. A threshold that is too large has wrong pixels there, and `Automatic` hardly any.
fn of_worlds() -> Result<(), String> {
    const SEED: u64 = 16_201;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let detectors =
        [DepthMapMethod::Automatic { dangling: None }, DepthMapMethod::Differences { threshold: 0.05, dangling: None }];
    let mut tallies = [Tally::default(); 2];
    for round in 0..if is_long() { 12 } else { 1 } {
        for (number, world) in worlds(&mut random).iter().enumerate() {
            // A ball that touches the ground, a box, a plate, and a mesh.
            if !is_long() && ![1, 3, 4, 5].contains(&number) {
                continue;
            }
            let Some(view) = View::random(&mut random, world) else { continue };
            let [light_depths, depths] = view.depths();
            let format = [TextureFormat::Depth32Float, TextureFormat::Depth24Plus][round % 2];
            let map = texture(&gpu, [SIDE; 2], format, &light_depths)?;
            let pixels = view.receivers().map(|(pixel, seen)| (pixel, seen.0, view.is_lit(seen)));
            let pixels: Vec<_> = pixels.collect();
            let given = Given {
                light: view.sun.camera,
                at: view.sun.homogeneous(),
                map: &map,
                eye: view.eye,
                depths: &depths,
                pixels: &pixels,
            };
            for (tally, edges) in tallies.iter_mut().zip(detectors) {
                tally.add(&gpu, &given, edges, 13)?;
            }
        }
    }
    for ((tally, edges), least) in tallies.iter().zip(detectors).zip([0, 20]) {
        tally.check(&format!("{edges:?}"), least)?;
    }
    Ok(())
}

/// Plates over a floor, each a texel of the map wide and higher than the one before by as much: a step between steps that are
/// as large is no edge of `Automatic`, and none of differences above a step. An eye at their low side looks in under them.
fn of_stairs() -> Result<(), String> {
    const STEPS: i64 = 12;
    let gpu = Gpu::shared()?;
    let eye_of = |place: DVec3, forward: DVec3, half_width| Eye {
        place,
        forward,
        near: 0.1,
        is_relative: false,
        depth: DepthDirection::Reversed,
        far: Some(40.0),
        half_width,
    };
    let light = eye_of(DVec3::new(0.0, 8.0, 0.0), DVec3::NEG_Y, Some(4.0)).camera();
    // A texel is a quarter wide.
    let rays = Rays::new(&light, 32);
    let plate = |place: DVec3| {
        let column = ((place.x + 1.0) * 4.0).floor() as i64;
        ((0..STEPS).contains(&column) && place.z.abs() < 2.0).then_some(0.3 + 0.15 * column as f64)
    };
    let map = Map::new([32, 32], true, |texel| {
        let (from, _) = rays.at(middle(texel, 32));
        device_depth(&light, DVec3::new(from.x, plate(from).unwrap_or(0.0), from.z))
    });
    let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let step = device_depth(&light, DVec3::ZERO) - device_depth(&light, DVec3::new(0.0, -0.15, 0.0));
    let detectors = [
        DepthMapMethod::Automatic { dangling: None },
        DepthMapMethod::Differences { threshold: 1.5 * step, dangling: None },
    ];
    let mut tallies = [Tally::default(); 2];
    for (height, aside) in [(0.9, 0.0), (1.2, 0.6), (0.6, -1.1)] {
        let place = DVec3::new(-5.0, height, aside);
        let eye = eye_of(place, DVec3::new(1.0, 0.6, 0.0) - place, None).camera();
        let rays = Rays::new(&eye, SIDE);
        let seen = |pixel: u32| {
            let (from, ray) = rays.at(middle(pixel, SIDE));
            let mut found =
                [0.0].into_iter().chain((0..STEPS).map(|column| 0.3 + 0.15 * column as f64)).filter_map(|height| {
                    let t = (height - from.y) / ray.y;
                    let place = from + t * ray;
                    let is_there =
                        if height == 0.0 { true } else { plate(place).is_some_and(|own| (own - height).abs() < 1e-9) };
                    (t > 0.0 && t < 30.0 && is_there).then_some((t, place, height))
                });
            let first = found.next()?;
            Some(found.fold(first, |a, b| if b.0 < a.0 { b } else { a }))
        };
        let seen: Vec<_> = (0..SIDE * SIDE).map(seen).collect();
        let depths: Vec<_> =
            seen.iter().map(|seen| seen.map_or(0.0, |(_, place, _)| device_depth(&eye, place))).collect();
        let pixels = seen.iter().enumerate().filter_map(|(pixel, seen)| {
            let (_, place, height) = (*seen)?;
            Some((pixel, place, height > 0.0 || plate(place).is_none()))
        });
        let pixels: Vec<_> = pixels.collect();
        let at = DVec3::Y.extend(0.0);
        let given = Given { light, at, map: &texture, eye, depths: &depths, pixels: &pixels };
        for (tally, edges) in tallies.iter_mut().zip(detectors) {
            tally.add(&gpu, &given, edges, 13)?;
        }
    }
    for (tally, edges) in tallies.iter().zip(detectors) {
        tally.check(&format!("{edges:?}"), 300)?;
        // Negative control: each stair's triangles are missed, so others are too far aside.
        if tally.beside * 3 > tally.wrong {
            return Err(format!("{} of {} are traced to others", tally.beside, tally.wrong));
        }
    }
    Ok(())
}
