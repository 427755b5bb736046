//! Volumes of a depth map against a lookup in the same map, without filter, as shaders of receivers do it: wrong pixels
//! of the same views. And volumes in other units.

use std::collections::HashSet;

use glam::DVec2;
use rimline::ShadowCamera;
use rimline::gpu::depth_map::DepthMapMethod;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::parity::{device_depth, middle};
use crate::picture::{AUTOMATIC, EVERY_CELL, Maps, REVERSED, Target, by, contours, differences};
use crate::rules::CELL;
use crate::views::{MapOf, Near, Seen, Tally, View, worlds};
use rimline_testkit::textures::{read, texture};

pub(crate) const TESTS: &[Test] =
    &[("volumes_have_no_acne_and_lookups_have", compare), ("detectors_list_the_same_in_every_unit", units)];

/// Else upright edges of boxes lie along the columns of a map, where a contour has the same crossing in each row.
const TURN: f64 = 0.5;

/// How a pixel's shadow is found.
#[derive(Clone, Copy, Debug)]
enum Way {
    Volumes(DepthMapMethod),
    /// With a bias of a map that is drawn: steps of its format, and multiples of its slope, as `wgpu::DepthBiasState`
    /// has them.
    Lookup([f64; 2]),
}

/// The step between depths of a format at a depth, as polygon offsets count it.
fn step(format: TextureFormat, depth: f64) -> f64 {
    match format {
        TextureFormat::Depth16Unorm => 1.0 / 65_536.0,
        TextureFormat::Depth24Plus => 1.0 / 16_777_216.0,
        _ => (depth.max(1e-30).log2().floor() - 23.0).exp2(),
    }
}

/// The depths that a map has if its triangles are drawn with a bias.
fn biased(view: &View<'_>, format: TextureFormat, [constant, slope_scale]: [f64; 2]) -> Vec<f32> {
    let is_reversed = view.sun.cameras[0].depth == REVERSED;
    let (far, away) = if is_reversed { (0.0, -1.0) } else { (1.0, 1.0) };
    let biased_depth = |(texel, seen): (u32, &Seen)| {
        let Some((point, normal)) = *seen else { return far };
        let middle = middle(texel, view.sun.side);
        // The depth of the surface's tangent plane.
        let on_plane = |position: DVec2| {
            let (from, direction) = view.sun.rays[0].at(position);
            let t = (point - from).dot(normal) / direction.dot(normal);
            view.sun.in_map(from + t * direction).z
        };
        let slope = |axis: DVec2| (on_plane(middle + 0.1 * axis) - on_plane(middle - 0.1 * axis)).abs() / 0.2;
        let depth = view.sun.in_map(point).z;
        let bias = slope_scale * slope(DVec2::X).max(slope(DVec2::Y)) + constant * step(format, depth);
        (depth + away * bias).clamp(0.0, 1.0) as f32
    };
    (0..).zip(&view.light_seen()[0]).map(biased_depth).collect()
}

/// The stencil, or 1 for each pixel that is in shadow by a lookup.
fn dark(gpu: &Gpu, view: &View<'_>, format: TextureFormat, way: Way) -> Result<Vec<u8>, String> {
    let bias = match way {
        Way::Volumes(method) => {
            return Target::new(view.eye, &view.eye_depths()).stencil(gpu, &view.maps(gpu, format)?, by(method));
        }
        Way::Lookup(bias) => bias,
    };
    let size = view.sun.side;
    let stored = read(gpu, &texture(gpu, [size; 2], format, &biased(view, format, bias))?)?;
    let dark = |seen: &Seen| {
        let Some((point, _)) = *seen else { return 0 };
        let position = view.sun.in_map(point);
        let [x, y] = [position.x, position.y].map(|at| (at * f64::from(size)).floor());
        if x.min(y) < 0.0 || x.max(y) >= f64::from(size) {
            return 0;
        }
        let (depth, stored) = (position.z as f32, stored[(y * f64::from(size) + x) as usize]);
        u8::from(if view.sun.cameras[0].depth == REVERSED { depth < stored } else { depth > stored })
    };
    Ok(view.eye_seen.iter().map(dark).collect())
}

fn compare() -> Result<(), String> {
    compare_with(MapOf::default(), if is_long() { 8 } else { 1 })?;
    if !is_long() {
        return Ok(());
    }
    compare_with(MapOf { turn: TURN, ..MapOf::default() }, 8)?;
    compare_with(MapOf { side: 384, ..MapOf::default() }, 4)?;
    compare_with(MapOf { side: 384, turn: TURN, ..MapOf::default() }, 4)
}

/// Wrong pixels with such maps.
fn compare_with(map: MapOf, rounds: usize) -> Result<(), String> {
    let ways = [
        ("volumes, every cell", Way::Volumes(EVERY_CELL)),
        ("volumes, differences above 0.0005", Way::Volumes(differences(0.0005))),
        ("contours, differences above 0.0005", Way::Volumes(contours([0.0005, 0.1, 0.002]))),
        ("lookup, no bias", Way::Lookup([0.0, 0.0])),
        // The bias of wgpu's example of shadows.
        ("lookup, bias of 2 steps and 2 slopes", Way::Lookup([2.0, 2.0])),
        ("volumes, automatic", Way::Volumes(AUTOMATIC)),
    ];
    let seed = 1635;
    println!("seed {seed}, maps of {}², turned by {}", map.side, map.turn);
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let mut tallies = ways.map(|_| Tally::default());
    // Wrong pixels on the ground.
    let mut on_ground = [0; 6];
    for format in [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm] {
        for _ in 0..rounds {
            for world in worlds(&mut random) {
                let Some(view) = View::lit(&mut random, &world, map) else { continue };
                for ((tally, on_ground), (_, way)) in tallies.iter_mut().zip(&mut on_ground).zip(ways) {
                    let dark = dark(&gpu, &view, format, way)?;
                    tally.add(&view, &dark, 1);
                    let ground = view.receivers.iter().filter(|receiver| receiver.seen.0.y < 1e-7);
                    *on_ground += ground.filter(|receiver| (dark[receiver.pixel] == 0) != receiver.is_lit).count();
                }
            }
        }
    }
    let pixels = tallies[0].pixels();
    println!("{pixels} pixels, {} of them lit", tallies[0].lit);
    println!("| way | acne, leaks | at folds | at borders | on the ground |\n|---|---:|---:|---:|---:|");
    for (((name, _), tally), on_ground) in ways.iter().zip(&tallies).zip(on_ground) {
        println!("| {name} | {} | {} | {} | {on_ground} |", tally.wrong, tally.at_folds, tally.at_borders);
    }
    let far = tallies.map(|tally| tally.wrong);
    let all = tallies.map(|tally| tally.wrong + tally.at_folds + tally.at_borders);
    println!("contours: {:.2} of the lookup with bias", all[2] as f64 / all[4] as f64);
    // On the ground contours have half of what the lookup has, and in all, with steep sides of bodies, 0.65.
    let is_better = on_ground[2] * 2 <= on_ground[4] && all[2] * 20 <= all[4] * 13;
    // The lookup without bias has acne, so the counts show it.
    let has_acne = far[3] * 50 > tallies[0].lit;
    let is_right = far[0] == 0 && far[1].max(far[5]) * 100_000 <= pixels && far[2] * 5000 <= pixels;
    if is_better && is_right && has_acne { Ok(()) } else { Err(format!("{tallies:?}, {on_ground:?} on the ground")) }
}

/// The camera of a scene whose lengths are `by` times as large, near and far plane among them.
fn scaled(camera: &ShadowCamera, by: f64) -> ShadowCamera {
    let [x, y, z, w] = camera.view_projection.map(|column| column.map(f64::from));
    let is_parallel = [x, y, z].iter().all(|column| column[3] == 0.0);
    // Clip space in the scene's unit for perspective, and without one for parallel rays.
    let [of_axes, of_origin] = if is_parallel { [1.0 / by, 1.0] } else { [1.0, by] };
    let axis = |column: [f64; 4]| column.map(|value| (value * of_axes) as f32);
    ShadowCamera {
        view_projection: [axis(x), axis(y), axis(z), w.map(|value| (value * of_origin) as f32)],
        origin: camera.origin.map(|value| (f64::from(value) * by) as f32),
        depth: camera.depth,
    }
}

/// The depths of a map, a list of cells, and stencils.
type Drawn = (Vec<f32>, Vec<u32>, Vec<u8>);

/// A view in another unit.
fn in_unit(gpu: &Gpu, view: &View<'_>, method: DepthMapMethod, unit: f64) -> Result<Drawn, String> {
    let depths = |camera: &ShadowCamera, seen: &[Seen]| {
        let far = if camera.depth == REVERSED { 0.0 } else { 1.0 };
        seen.iter()
            .map(|seen| seen.map_or(far, |(position, _)| device_depth(camera, unit * position)))
            .collect::<Vec<_>>()
    };
    let [light, eye] = [&view.sun.cameras[0], &view.eye].map(|camera| scaled(camera, unit));
    let of_light = depths(&light, &view.light_seen()[0]);
    let map = Map { size: [view.sun.side; 2], is_reversed: light.depth == REVERSED, depths: of_light };
    let maps = Maps::of(gpu, &map, TextureFormat::Depth32Float, light)?;
    let (stencil, encoded) = Target::new(eye, &depths(&eye, &view.eye_seen)).draw(gpu, &maps, by(method))?;
    Ok((map.depths, encoded.list(gpu)?, stencil))
}

/// A scene in metres and in millimetres, and in units that are powers of two apart. Detectors without a threshold list
/// the same cells, and pictures are the same.
fn units() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_501)?;
    // Cells listed, cells listed in one unit alone, pixels, pixels that differ, views.
    let mut tally = [0; 5];
    for _ in 0..if is_long() { 6 } else { 1 } {
        for (number, world) in worlds(&mut random).iter().enumerate() {
            if !is_long() && ![1, 3, 5].contains(&number) {
                continue;
            }
            let Some(view) = View::random(&mut random, world) else { continue };
            let mut lists = Vec::new();
            for method in [AUTOMATIC, EVERY_CELL] {
                let unscaled = in_unit(&gpu, &view, method, 1.0)?;
                for unit in [1.0 / 4096.0, 1024.0, 1000.0, 0.001] {
                    let found = in_unit(&gpu, &view, method, unit)?;
                    let what = format!("world {number}, {method:?}, {unit} times as large");
                    if unit != 1000.0 && unit != 0.001 {
                        same(&format!("{what}: depths"), &found.0, &unscaled.0)?;
                        same(&format!("{what}: cells"), &found.1, &unscaled.1)?;
                        same(&format!("{what}: stencil"), &found.2, &unscaled.2)?;
                        continue;
                    }
                    let cells = |list: &[u32]| list[1..].iter().map(|entry| entry & CELL).collect::<HashSet<_>>();
                    let apart = cells(&found.1).symmetric_difference(&cells(&unscaled.1)).count();
                    tally[0] += unscaled.1.len() - 1;
                    tally[1] += apart;
                    let is_every = method == EVERY_CELL;
                    for receiver in &view.receivers {
                        tally[2] += 1;
                        let differs = found.2[receiver.pixel] != unscaled.2[receiver.pixel];
                        tally[3] += usize::from(differs);
                        if (is_every && apart > 0) || (differs && view.near(receiver, 1) == Near::Nothing) {
                            return Err(format!("{what}: pixel {}, {apart} cells", receiver.pixel));
                        }
                    }
                }
                lists.push(unscaled.1);
            }
            must_fail("another detector", &same("cells", &lists[0], &lists[1]))?;
            tally[4] += 1;
        }
    }
    println!("cells, in one unit alone, pixels, that differ, views: {tally:?}");
    if tally[1] * 500 < tally[0] && tally[3] * 500 < tally[2] && tally[4] > 1 {
        Ok(())
    } else {
        Err(format!("{tally:?}"))
    }
}
