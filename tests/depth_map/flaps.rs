//! Flaps change the shadow at points near contours, against `f64`.

use glam::DVec4;
use rimline::reference::depth_map::{Placing, map_view};
use rimline::reference::stages::DEPTH_WALLS;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::uniform;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::contours::{Traced, UNIT};
use crate::near_contours::among;
use crate::probe::{Bound, Probe};
use crate::vertices::Given;
use crate::wall_vertices::{fit, map};

pub(crate) const TESTS: &[Test] = &[("flaps_change_what_f64_says_they_do", changes)];

fn changes() -> Result<(), String> {
    const SEED: u64 = 16_107;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut told, mut changed, mut several, mut unsure, mut probe) = (0, 0, 0, 0, None);
    for round in 0..if is_long() { 1000 } else { 60 } {
        let is_reversed = random.below(2) == 0;
        let map = map(&mut random, is_reversed);
        let shape = map.shape(0.005, u32::MAX);
        let Traced { shape: contour, quads: walls, list, counts, .. } = Traced::new(&gpu, &map, fit(1.0), None)?;
        if walls.is_empty() {
            continue;
        }
        let camera = crate::stages::camera(crate::stages::direction(&map));
        let placing = Placing { border: 1.0, jitter: [0.0; 2], slope_bias: 0.5 };
        let formats = [TextureFormat::R32Float, TextureFormat::Depth24PlusStencil8];
        let view = map_view((&camera, map.size, formats[0]), (&camera, formats[1]), &placing).map_err(text)?;
        let given = Given::new(&gpu, (&shape, map.size, &map.depths), &list, &[view])?;
        let contour_given = uniform(&gpu, &contour);
        let mut bound = given.bound().to_vec();
        bound.retain(|&(binding, _)| binding == 0 || binding == 2);
        bound.extend([(6, Bound::Uniform(&contour_given)), (7, Bound::Storage(&counts))]);
        let source = format!(
            "{}
fn probe_flaps(place: vec2<f32>, depth: f32, is_behind: bool) -> vec4<u32> {{
  let cell = vec2<i32>(floor(place));
  return vec4<u32>(u32(flaps_change(cell, place - floor(place), depth, is_behind)), 0u, 0u, 0u);
}}",
            DEPTH_WALLS.wgsl()
        );
        // Places beside vertices of flaps, at about their depths.
        let flaps: Vec<_> = walls.iter().filter(|wall| wall[0][..2] != wall[1][..2]).collect();
        if flaps.is_empty() {
            continue;
        }
        let inputs: Vec<_> = (0..400)
            .map(|_| {
                let flap = flaps[random.below(flaps.len())];
                let shares = [0; 3].map(|_| random.between(0.0, 1.0));
                let whole = shares.iter().sum::<f32>().max(0.01);
                let mean = |axis: usize| {
                    let mean = (0..3).map(|at| flap[at][axis] as f32 * shares[at] / whole).sum::<f32>();
                    (mean + flap[3][axis] as f32 * 1e-3) / 1.001
                };
                let [x, y] = [0, 1].map(|axis| {
                    let most = map.size[axis] as f32;
                    (mean(axis) / 256.0 + random.between(-0.2, 0.2)).clamp(0.0, most + 0.99)
                });
                let depth = mean(2) / UNIT as f32 + random.between(-0.004, 0.004);
                let depth = if is_reversed { 1.0 - depth } else { depth };
                [x, y, depth, random.below(2) as f32]
            })
            .collect();
        let expression = "probe_flaps(input.xy, input.z, input.w != 0.0)";
        let make = || Probe::new(&gpu, &source, ("vec4<u32>", expression), &bound);
        let found = probe.get_or_insert_with(make).run(&gpu, &bound, &inputs)?;
        for (&[x, y, depth, is_behind], found) in inputs.iter().zip(found) {
            let is_behind = is_behind != 0.0;
            // Texel 0 is a texel after the border's, and distances begin at the near plane.
            let at = |off: [f64; 3]| {
                let [x, y, depth] = [x, y, depth].map(f64::from);
                let distance = if is_reversed { 1.0 - depth } else { depth };
                let place = DVec4::new(x - 1.0 + off[0], y - 1.0 + off[1], distance + off[2], 1.0);
                among(&walls, place).1
            };
            let own = at([0.0; 3]);
            // Rounding in `f32` may move the point and its depth by this much.
            let around = [-1.0, 1.0].map(|sign| {
                [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 4e-6]].map(|off| at(off.map(|off| sign * off)))
            });
            if around.iter().flatten().any(|there| *there != own) {
                unsure += 1;
                continue;
            }
            let expected = own.iter().filter(|&&(_, behind)| behind != is_behind).count() % 2 == 1;
            if (found[0] == 1) != expected {
                return Err(format!("round {round}, {x} {y} {depth}: {found:?}, expected {expected}: {own:?}"));
            }
            told += 1;
            changed += usize::from(expected);
            several += usize::from(own.len() > 1);
        }
    }
    println!("{told} places, {changed} changed, {several} in several flaps, {unsure} too near to a border");
    if changed * 10 > told && several > 100 && unsure * 5 < told { Ok(()) } else { Err("too few".to_owned()) }
}
