//! Units: a scene in metres and in millimetres, and in units that are powers of two apart. Detectors without a threshold list the
//! same cells, and pictures are the same.

use std::collections::HashSet;

use rimline::ShadowCamera;
use rimline::gpu::depth_map::{DepthMap, DepthMapMethod, DepthMapOptions, DepthMapVolumes};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::parity::device_depth;
use crate::picture::{pipelines, stencil_of};
use crate::textures::{depth_view, texture};
use crate::views::{Near, SIDE, Seen, View, worlds};

pub(crate) const TESTS: &[Test] = &[("detectors_list_the_same_in_every_unit", units)];

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

fn depths(camera: &ShadowCamera, seen: &[Seen], by: f64) -> Vec<f32> {
    let far = if camera.depth == rimline::DepthDirection::Reversed { 0.0 } else { 1.0 };
    seen.iter().map(|seen| seen.map_or(far, |(place, _)| device_depth(camera, by * place))).collect()
}

/// Depths, a list of cells, and stencils.
type Drawn = (Vec<f32>, Vec<u32>, Vec<u8>);

/// The depths of a map, the list of cells and the stencil, in another unit.
fn drawn(gpu: &Gpu, view: &View<'_>, edges: DepthMapMethod, by: f64) -> Result<Drawn, String> {
    let [light, eye] = [&view.sun.camera, &view.eye].map(|camera| scaled(camera, by));
    let of_light = depths(&light, &view.light_seen, by);
    let map = texture(gpu, [SIDE; 2], TextureFormat::Depth32Float, &of_light)?;
    let pipelines = pipelines(gpu, eye.depth, 0..1)?;
    let options = DepthMapOptions { method: edges, ..Default::default() };
    let mut volumes = DepthMapVolumes::new(&pipelines, [SIDE; 2], options).map_err(text)?;
    let stencil = stencil_of(gpu, &pipelines, (SIDE, &depths(&eye, &view.eye_seen, by)), |encoder| {
        volumes.encode(encoder, &DepthMap { texture: &depth_view(&map), light, objects: None }, &eye).map_err(text)
    })?;
    let list: Vec<u32> = gpu.read(volumes.cells(), usize::MAX)?;
    let count = list[0] as usize;
    Ok((of_light, list.into_iter().take(1 + count).collect(), stencil))
}

/// Cells that one list has and the other has not.
fn apart(a: &[u32], b: &[u32]) -> usize {
    let cells = |list: &[u32]| list[1..].iter().map(|entry| entry & ((1 << 29) - 1)).collect::<HashSet<_>>();
    cells(a).symmetric_difference(&cells(b)).count()
}

fn units() -> Result<(), String> {
    const SEED: u64 = 16_501;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    // Cells listed, cells listed in one unit alone, pixels, pixels that differ.
    let mut tally = [0; 4];
    let mut other = 0;
    for _ in 0..if is_long() { 6 } else { 1 } {
        for (number, world) in worlds(&mut random).iter().enumerate() {
            if !is_long() && ![1, 3, 5].contains(&number) {
                continue;
            }
            let Some(view) = View::random(&mut random, world) else { continue };
            for edges in [DepthMapMethod::Automatic { dangling: None }, DepthMapMethod::EveryCell] {
                let own = drawn(&gpu, &view, edges, 1.0)?;
                for by in [1.0 / 4096.0, 1024.0] {
                    let found = drawn(&gpu, &view, edges, by)?;
                    let what = format!("world {number}, {edges:?}, {by} times as large");
                    same(&format!("{what}: depths"), &found.0, &own.0)?;
                    same(&format!("{what}: cells"), &found.1, &own.1)?;
                    same(&format!("{what}: stencil"), &found.2, &own.2)?;
                }
                for by in [1000.0, 0.001] {
                    let found = drawn(&gpu, &view, edges, by)?;
                    tally[0] += own.1.len() - 1;
                    tally[1] += apart(&found.1, &own.1);
                    if edges == DepthMapMethod::EveryCell && apart(&found.1, &own.1) > 0 {
                        return Err(format!("world {number}: every cell is not, {by} times as large"));
                    }
                    for (pixel, seen) in view.receivers() {
                        tally[2] += 1;
                        if found.2[pixel] != own.2[pixel] {
                            tally[3] += 1;
                            if view.near(seen, 1.0) == Near::Nothing {
                                return Err(format!("world {number}, {edges:?}, {by} times: pixel {pixel}"));
                            }
                        }
                    }
                }
            }
            // Negative control: another detector.
            let lists =
                [DepthMapMethod::EveryCell, DepthMapMethod::default()].map(|method| drawn(&gpu, &view, method, 1.0));
            let [every, automatic] = lists;
            must_fail("another detector", &same("cells", &automatic?.1, &every?.1))?;
            other += 1;
        }
    }
    println!(
        "{} cells, {} in one unit alone; {} pixels, {} differ; {other} views",
        tally[0], tally[1], tally[2], tally[3]
    );
    if tally[1] * 500 < tally[0] && tally[3] * 500 < tally[2] && other > 1 { Ok(()) } else { Err(format!("{tally:?}")) }
}
