//! Volumes of meshes and of a depth map in one stencil: counts own the low bits, parity the high ones.

use glam::DVec3;
use rimline::gpu::depth_map::{DepthMap, DepthMapOptions};
use rimline::gpu::{SceneOptions, ShadowFormat, StencilCounts};
use rimline::{Counting, Light};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::map_pipelines;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{made_anew, must_fail, same};
use wgpu::TextureFormat;

use crate::rays::{self, Truth};
use crate::render::{Beside, Counted, Placing, Renderer};
use crate::trials::Test;
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::frames::{Body, CENTRE, Eye, Frame};
use rimline_testkit::textures;

pub(crate) const TESTS: &[Test] =
    &[("counts_and_parities_share_a_stencil", share), ("counts_of_few_bits_in_batches_lose_no_shadow", batches)];

/// Texels of the map, each way.
const MAP: u32 = 24;

/// Where the light is, which the map sees from, too.
const LIGHT: [f32; 3] = [0.3, 2.9, 0.4];

/// Cubes around each other in a room. Shadows on its floor count from 0 to as many cubes. `is_one`: they are one caster,
/// since the reference by rays knows few.
fn shells(count: u32, is_one: bool) -> Frame {
    let mut frame = (CLASSES[0].frame)(&mut Random::new(7));
    let shell = |number: u32| Body::caster(shapes::cube()).scaled(0.3 + 0.9 * number as f32 / count as f32);
    frame.bodies = (0..count).map(shell).collect();
    if is_one {
        frame.bodies = vec![Body::caster(Shape::joined(frame.bodies.iter().map(|body| &body.shape)))];
    }
    frame.bodies.push(Body::room([0.0; 3], 3.0));
    frame.lights = vec![Light::point(LIGHT)];
    let position = DVec3::new(2.2, -1.3, 2.5);
    frame.eye = Eye::new(position, DVec3::new(-2.2, -1.6, -2.5), 0.1);
    frame.size = 64;
    frame
}

/// The same picture without casters.
fn without_casters(frame: &Frame) -> Frame {
    let mut without = frame.clone();
    without.bodies.iter_mut().for_each(|body| body.casts = false);
    without
}

/// A map of random steps and holes, and the camera at the light that it is seen by.
fn map(gpu: &Gpu, seed: u64) -> Result<(wgpu::Texture, rimline::ShadowCamera), String> {
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let position = DVec3::from(LIGHT.map(f64::from));
    let eye = Eye::new(position, -position, 0.5);
    let depths: Vec<f32> =
        (0..MAP * MAP).map(|_| if random.below(3) == 0 { 0.0 } else { 0.5 / random.between(1.5, 5.5) }).collect();
    Ok((textures::texture(gpu, [MAP; 2], TextureFormat::R32Float, &depths)?, eye.camera()))
}

/// Whether the bits above `count_bits` are those of `parities`, and those below are `counts` (of a run with 8 bits) modulo
/// 2^`count_bits`.
fn bits(count_bits: u32, found: &Counted, parities: &[u8], counts: &[u8]) -> Result<(), String> {
    let low = u8::try_from((1_u32 << count_bits) - 1).map_err(text)?;
    let found = &found.stencils[0];
    let part = |of: &[u8], mask: u8| of.iter().map(|value| value & mask).collect::<Vec<_>>();
    same("parities", &part(found, !low), parities)?;
    same("counts", &part(found, low), &part(counts, low))?;
    let dark = |is_dark: &dyn Fn(usize) -> bool| (0..found.len()).map(is_dark).collect::<Vec<_>>();
    same("dark", &dark(&|at| found[at] != 0), &dark(&|at| parities[at] != 0 || counts[at] & low != 0))
}

/// Alone and in a scene, by several ways to count, with one, two and four bits of parity, drawn before the counts and after.
fn share() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (texture, light) = map(gpu, 1681)?;
    let view = textures::depth_view(&texture);
    let map = DepthMap { texture: &view, light, objects: None };
    let options = DepthMapOptions::default();
    let mut wrapped = 0;
    for (placing, counting, parity_bits, is_first) in [
        (Placing::Alone, Counting::Auto, 1, true),
        (Placing::Alone, Counting::ZpPlus, 2, false),
        (Placing::Alone, Counting::ZFail, 2, true),
        (Placing::Scene, Counting::Auto, 4, false),
        (Placing::Scene, Counting::ZFail, 1, true),
    ] {
        let count_bits = 8 - parity_bits;
        let frame = shells((9 << count_bits) / 8, placing == Placing::Alone);
        let plain = Renderer { placing, ..Renderer::new(gpu) };
        let counts = plain.count(&frame, counting)?.stencils.remove(0);
        wrapped += counts.iter().filter(|&&count| u32::from(count) >= 1 << count_bits).count();
        let of_bits = |bits| {
            let format = ShadowFormat { depth: frame.eye.depth, count_bits: bits, ..Default::default() };
            map_pipelines(gpu, &format, count_bits..8)
        };
        let (shared, all) = (of_bits(count_bits)?, of_bits(8)?);
        let what = format!("{placing:?} {counting:?} {parity_bits} {is_first}");
        let beside = Some(Beside { map, pipelines: &shared, options, is_first });
        let mut mixed = Renderer { beside, ..plain };
        mixed.options.stencil.count_bits = count_bits;
        let parities = mixed.count(&without_casters(&frame), counting)?.stencils.remove(0);
        let darkened = parities.iter().filter(|&&value| value != 0).count();
        if darkened.min(parities.len() - darkened) < 300 {
            return Err(format!("{what}: the map darkens {darkened} pixels of {}", parities.len()));
        }
        let found = mixed.count(&frame, counting)?;
        bits(count_bits, &found, &parities, &counts).map_err(|error| format!("{what}: {error}"))?;
        // Must fail: counts that use all 8 bits.
        let beside = Some(Beside { map, pipelines: &all, options, is_first: true });
        let whole = Renderer { beside, ..plain }.count(&frame, counting)?;
        must_fail(&what, &bits(count_bits, &whole, &parities, &counts))?;
    }
    println!("{wrapped} counts that do not fit their bits");
    if wrapped < 1000 { Err(format!("{wrapped} counts that do not fit")) } else { Ok(()) }
}

/// The number of shells is a multiple of 2^`count_bits`, so full counts wrap to 0. The bound warns of it. In batches
/// every shadow is there.
fn batches() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (texture, light) = map(gpu, 1682)?;
    let view = textures::depth_view(&texture);
    let map = DepthMap { texture: &view, light, objects: None };
    for (count_bits, count, count_batches) in [(4, 32, 6), (6, 64, 3), (8, 256, 3)] {
        let frame = shells(count, false);
        let truths = rays::trace(&shells(count, true), CENTRE);
        // With 8 bits of counts no bit is left for a map.
        let first_bit = count_bits.min(7);
        let format = ShadowFormat { depth: frame.eye.depth, count_bits: first_bit, ..Default::default() };
        let pipelines = map_pipelines(gpu, &format, first_bit..8)?;
        let options = DepthMapOptions::default();
        let beside = (count_bits < 8).then_some(Beside { map, pipelines: &pipelines, options, is_first: true });
        let stencil = StencilCounts { bound_counts: true, count_bits, ..StencilCounts::default() };
        let bounded = SceneOptions { stencil, ..made_anew(32, Counting::Auto) };
        let renderer = |count_batches| Renderer {
            placing: Placing::Scene,
            count_batches,
            beside,
            options: bounded,
            ..Renderer::new(gpu)
        };
        let alone = |counted: &Counted| {
            counted.stencils[0].iter().map(|value| value & (0xff >> (8 - count_bits))).collect::<Vec<u8>>()
        };
        // Pixels that at least three shells shadow by rays, and that a stencil has light for.
        let lost = |stencil: &[u8]| {
            let is_lost = |(truths, value): &(&Vec<Truth>, &u8)| match truths[0] {
                Truth::Surface(between) => between.count(&[false]) > 2 && **value == 0,
                _ => false,
            };
            truths.iter().zip(stencil).filter(is_lost).count()
        };
        for counting in [Counting::Auto, Counting::ZFail] {
            let at_once = renderer(1).count(&frame, counting)?;
            let in_batches = renderer(count_batches).count(&frame, counting)?;
            let [whole, batch] = [&at_once, &in_batches].map(|counted| counted.statistics[0]);
            let lost = [&at_once, &in_batches].map(|counted| lost(&alone(counted)));
            println!(
                "{count_bits} bits, {count} shells, {counting:?}: bounds {} and {}, lost {lost:?}",
                whole.count_bound, batch.count_bound
            );
            // A bound is that of a batch.
            let is_smaller = batch.count_bound < whole.count_bound;
            if [whole.may_wrap, batch.may_wrap] != [1, 0] || !is_smaller || lost[0] < 100 || lost[1] > 0 {
                return Err(format!("{whole:?}, in batches {batch:?}, lost {lost:?}"));
            }
            // The map's own bits are there, too.
            let parities = renderer(1).count(&without_casters(&frame), counting)?.stencils.remove(0);
            let high = |of: &[u8]| of.iter().map(|&value| u32::from(value) >> count_bits).collect::<Vec<_>>();
            for found in [&at_once, &in_batches] {
                same("parities", &high(&found.stencils[0]), &high(&parities))?;
            }
        }
    }
    Ok(())
}
