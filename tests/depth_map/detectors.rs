//! Cost of the edges that detectors leave out: wrong pixels and triangles of the same views.

use std::cell::OnceCell;

use rimline::gpu::{DanglingEdges, DepthMap, DepthMapMethod, DepthMapOptions, DepthMapVolumes};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::picture::{pipelines, stencil_of};
use crate::textures::{depth_view, texture};
use crate::views::{Near, SIDE, View, worlds};

pub(crate) const TESTS: &[Test] = &[("detectors_leave_out_what_the_light_sees", compare)];

/// Wrong pixels, and triangles drawn.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    /// Farther than a texel from a border and a fold.
    wrong: usize,
    at_folds: usize,
    at_borders: usize,
    triangles: usize,
}

/// The stencil of a view, and how many triangles its volumes have.
fn drawn(
    gpu: &Gpu,
    view: &View<'_>,
    map: &wgpu::Texture,
    eye_depths: &[f32],
    (options, bits): (DepthMapOptions, u32),
) -> Result<(Vec<u8>, usize), String> {
    let pipelines = pipelines(gpu, view.eye.depth, 0..bits)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, [SIDE; 2], options).map_err(text)?;
    let stencil = stencil_of(gpu, &pipelines, (SIDE, eye_depths), |encoder| {
        let map = DepthMap { texture: &depth_view(map), light: view.sun.camera, objects: None };
        volumes.encode(encoder, &map, &view.eye, None).map_err(text)
    })?;
    let list: Vec<u32> = gpu.read(volumes.cells(), usize::MAX)?;
    let entries = list.iter().skip(1).take(list[0] as usize);
    Ok((stencil, entries.map(|entry| (entry >> 30).count_ones() as usize).sum()))
}

fn compare() -> Result<(), String> {
    let seed = 1661;
    println!("seed {seed}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let second = |low, high, dangling| DepthMapMethod::SecondDifferences { low, high, dangling };
    let differences = |threshold, dangling| DepthMapMethod::Differences { threshold, dangling };
    let automatic = |dangling| DepthMapMethod::Automatic { dangling };
    let continued = Some(DanglingEdges::default());
    let of = |method| (DepthMapOptions { method, ..Default::default() }, 1);
    let unmoved = |method| (DepthMapOptions { method, slope_bias: 0.0, ..Default::default() }, 1);
    let ways = [
        ("every cell", of(DepthMapMethod::EveryCell)),
        ("differences above 0.02", of(differences(0.02, None))),
        ("automatic, continued", of(automatic(continued))),
        ("second 0.0005, 0.05, continued", of(second(0.0005, 0.05, continued))),
        ("differences above 0.0005", of(differences(0.0005, None))),
        ("differences above 0.005, continued", of(differences(0.005, continued))),
        ("automatic", of(automatic(None))),
        ("automatic, no slope bias", unmoved(automatic(None))),
        ("automatic, four bits", (DepthMapOptions::default(), 4)),
        ("second 0.0005, 0.05", of(second(0.0005, 0.05, None))),
        ("second 0.0005, 0.05, no slope bias", unmoved(second(0.0005, 0.05, None))),
        ("second 0.0001, 0.02", of(second(0.0001, 0.02, None))),
    ];
    let ways = &ways[..if is_long() { ways.len() } else { 4 }];
    let mut tallies = vec![Tally::default(); ways.len()];
    let mut pixels = 0;
    let formats = [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];
    for (of_format, format) in formats.into_iter().enumerate() {
        for round in 0..if is_long() { 8 } else { 1 } {
            for (number, world) in worlds(&mut random).iter().enumerate() {
                // Each world with one format, in the short run.
                if !is_long() && number % 3 != of_format {
                    continue;
                }
                let Some(view) = View::random(&mut random, world) else { continue };
                let [light_depths, eye_depths] = view.depths();
                let map = texture(&gpu, [SIDE; 2], format, &light_depths)?;
                let receivers: Vec<_> =
                    view.receivers().map(|(pixel, seen)| (pixel, seen, view.is_lit(seen), OnceCell::new())).collect();
                pixels += receivers.len();
                for (tally, (name, (options, bits))) in tallies.iter_mut().zip(ways.iter().copied()) {
                    let (stencil, triangles) = drawn(&gpu, &view, &map, &eye_depths, (options, bits))?;
                    tally.triangles += triangles;
                    // A texel, and as much as bits move the boundary.
                    let within = 1.5 - 0.5 / f64::from(bits);
                    let before = tally.wrong;
                    for &(pixel, seen, is_lit, ref near) in &receivers {
                        if stencil[pixel] == if is_lit { 0 } else { (1 << bits) - 1 } {
                            continue;
                        }
                        let near = if bits == 1 {
                            *near.get_or_init(|| view.near(seen, within))
                        } else {
                            view.near(seen, within)
                        };
                        let count = match near {
                            Near::Nothing => &mut tally.wrong,
                            Near::Fold => &mut tally.at_folds,
                            Near::Border => &mut tally.at_borders,
                        };
                        *count += 1;
                    }
                    if tally.wrong > before {
                        println!("{name}: {} wrong in world {number}, {format:?}, round {round}", tally.wrong - before);
                    }
                }
            }
        }
    }
    println!("{pixels} pixels");
    println!("| detector | wrong | at folds | at borders | triangles |\n|---|---:|---:|---:|---:|");
    for ((name, _), Tally { wrong, at_folds, at_borders, triangles }) in ways.iter().zip(&tallies) {
        println!("| {name} | {wrong} | {at_folds} | {at_borders} | {triangles} |");
    }
    // Every cell, and without a threshold and continued. A threshold that is too large is the negative control.
    let [every, large, automatic, second] = [0, 1, 2, 3].map(|way| tallies[way]);
    let allowed = pixels / 100_000;
    let is_right = every.wrong == 0 && automatic.wrong <= allowed && second.wrong <= 1 + allowed && large.wrong > 0;
    let is_spared = automatic.triangles * 3 < every.triangles && second.triangles < automatic.triangles;
    if is_right && is_spared && automatic.at_folds <= every.at_folds {
        Ok(())
    } else {
        Err(format!("{tallies:?} of {pixels} pixels"))
    }
}
