//! Volumes of meshes and of a depth map in one stencil: counts own the low bits, parity the high ones.

use glam::DVec3;
use rimline::gpu::depth_map::{DepthMap, DepthMapError, DepthMapOptions, DepthMapPipelines};
use rimline::gpu::{FrameInputs, Scene, SceneOptions, ShadowError, ShadowFormat, ShadowPipelines, StencilCounts};
use rimline::{Counting, Light};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::draw_small;
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{is, refusal, refused};
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::classes::CLASSES;
use crate::rays::{self, Truth};
use crate::render::{Beside, Counted, Placing, Renderer};
use crate::scene::{Body, CENTRE, Eye, Frame};
use crate::trials::Test;
use rimline_testkit::textures;

pub(crate) const TESTS: &[Test] = &[
    ("counts_and_parities_share_a_stencil", share),
    ("counts_of_few_bits_in_batches_lose_no_shadow", batches),
    ("counts_own_one_to_eight_bits", refusals),
];

/// Texels of the map, each way.
const MAP: u32 = 24;

/// Cubes around each other above a floor, which is seen from the side. So shadows on it count from 0 to as many cubes.
fn shells(count: u32, is_one: bool) -> Frame {
    let mut frame = (CLASSES[0].frame)(&mut Random::new(7));
    let shell = |number: u32| Body::caster(shapes::cube()).scaled(0.3 + 0.9 * number as f32 / count as f32);
    frame.bodies = (0..count).map(shell).collect();
    if is_one {
        frame.bodies = vec![Body::caster(Shape::joined(frame.bodies.iter().map(|body| &body.shape)))];
    }
    frame.bodies.push(Body::room([0.0; 3], 3.0));
    frame.lights = vec![Light::point([0.3, 2.9, 0.4])];
    let position = DVec3::new(2.2, -1.3, 2.5);
    frame.eye = Eye::new(position, DVec3::new(-2.2, -1.6, -2.5), 0.1);
    frame.size = 64;
    frame
}

/// The same is seen, and nothing casts.
fn without_casters(frame: &Frame) -> Frame {
    let mut without = frame.clone();
    without.bodies.iter_mut().for_each(|body| body.casts = false);
    without
}

/// The light's own camera, and a map of steps and holes at random.
fn map(gpu: &Gpu, seed: u64) -> Result<(wgpu::Texture, rimline::ShadowCamera), String> {
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let position = DVec3::new(0.3, 2.9, 0.4);
    let eye = Eye::new(position, -position, 0.5);
    let depths: Vec<f32> =
        (0..MAP * MAP).map(|_| if random.below(3) == 0 { 0.0 } else { 0.5 / random.between(1.5, 5.5) }).collect();
    Ok((textures::texture(gpu, [MAP; 2], TextureFormat::R32Float, &depths)?, eye.camera()))
}

/// Whether the bits above `count_bits` are those of `parities`, and those below are `counts`, which did not wrap.
fn bits(count_bits: u32, found: &Counted, parities: &[u8], counts: &[u8]) -> Result<(), String> {
    let low = u8::try_from((1_u32 << count_bits) - 1).map_err(text)?;
    let found = &found.stencils[0];
    let part = |of: &[u8], mask: u8| of.iter().map(|value| value & mask).collect::<Vec<_>>();
    same("parities", &part(found, !low), parities)?;
    same("counts", &part(found, low), &part(counts, low))?;
    let dark = |is_dark: &dyn Fn(usize) -> bool| (0..found.len()).map(is_dark).collect::<Vec<_>>();
    same("dark", &dark(&|at| found[at] != 0), &dark(&|at| parities[at] != 0 || counts[at] & low != 0))
}

/// In each way to draw meshes, with one, two and four bits of parity, drawn before the counts and after them.
fn share() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (texture, light) = map(gpu, 1681)?;
    let view = textures::depth_view(&texture);
    let map = DepthMap { texture: &view, light, objects: None };
    let mut wrapped = 0;
    for (placing, counting) in [
        (Placing::Alone, Counting::Auto),
        (Placing::Alone, Counting::ZpPlus),
        (Placing::Alone, Counting::ZFail),
        (Placing::Scene, Counting::Auto),
        (Placing::Scene, Counting::ZFail),
    ] {
        // Each number of bits has pipelines of its own.
        let few: &[u32] = match (placing, counting) {
            _ if is_long() => &[1, 2, 4],
            (Placing::Alone, Counting::Auto) => &[1, 2, 4],
            (Placing::Scene, Counting::Auto) => &[2, 4],
            (Placing::Scene, Counting::ZFail) => &[1],
            _ => &[2],
        };
        for &parity_bits in few {
            let count_bits = 8 - parity_bits;
            let frame = shells((9 << count_bits) / 8, placing == Placing::Alone);
            let without = without_casters(&frame);
            let plain = Renderer { placing, ..Renderer::new(gpu) };
            let counts = plain.count(&frame, counting)?.stencils.remove(0);
            wrapped += counts.iter().filter(|&&count| u32::from(count) >= 1 << count_bits).count();
            let format = |count_bits| ShadowFormat { depth: frame.eye.depth, count_bits, ..Default::default() };
            let of_bits = |format| DepthMapPipelines::antialiased(&gpu.pipelines, &format, count_bits..8);
            let pipelines = of_bits(format(count_bits)).map_err(text)?;
            let options = DepthMapOptions::default();
            let orders: &[bool] = if parity_bits == 2 { &[true, false] } else { &[true] };
            for &is_first in orders {
                let what = format!("{placing:?} {counting:?} {parity_bits} {is_first}");
                let beside = Some(Beside { map, pipelines: &pipelines, options, is_first });
                let mixed = Renderer { placing, count_bits, beside, ..Renderer::new(gpu) };
                let parities = mixed.count(&without, counting)?.stencils.remove(0);
                let dark = [0, 1].map(|which| parities.iter().filter(|&&value| (value != 0) == (which == 1)).count());
                if dark.iter().any(|&count| count < 300) {
                    return Err(format!("{what}: {dark:?} pixels that the map leaves and darkens"));
                }
                let found = mixed.count(&frame, counting)?;
                bits(count_bits, &found, &parities, &counts).map_err(|error| format!("{what}: {error}"))?;
                // Counts that own the whole byte.
                let all = of_bits(format(8)).map_err(text)?;
                let beside = Some(Beside { map, pipelines: &all, options, is_first: true });
                let whole = Renderer { placing, beside, ..Renderer::new(gpu) }.count(&frame, counting)?;
                must_fail(&what, &bits(count_bits, &whole, &parities, &counts))?;
            }
        }
    }
    println!("{wrapped} counts that do not fit their bits");
    if wrapped < 2000 { Err(format!("{wrapped} counts that do not fit")) } else { Ok(()) }
}

/// The number of shells is a multiple of 2^`count_bits`, so full counts wrap to 0. The bound warns of it. In batches
/// every shadow is there.
fn batches() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (texture, light) = map(gpu, 1682)?;
    let view = textures::depth_view(&texture);
    let map = DepthMap { texture: &view, light, objects: None };
    for (count_bits, count, count_batches) in [(4, 32, 6), (6, 64, 3)] {
        let frame = shells(count, false);
        let truths = rays::trace(&shells(count, true), CENTRE);
        let format = ShadowFormat { depth: frame.eye.depth, count_bits, ..Default::default() };
        let pipelines = DepthMapPipelines::antialiased(&gpu.pipelines, &format, count_bits..8).map_err(text)?;
        let options = DepthMapOptions::default();
        let beside = Some(Beside { map, pipelines: &pipelines, options, is_first: true });
        let bounded = OneCasterOptions { bound_counts: true, ..OneCasterOptions::default() };
        let renderer = |count_batches| Renderer {
            placing: Placing::Scene,
            count_bits,
            count_batches,
            beside,
            options: bounded,
            ..Renderer::new(gpu)
        };
        let alone = |counted: &Counted| {
            counted.stencils[0].iter().map(|value| value & ((1 << count_bits) - 1)).collect::<Vec<u8>>()
        };
        // Pixels that are in the shadow of any shell by rays, and that a stencil has light for.
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
            if [whole.may_wrap, batch.may_wrap] != [1, 0] || lost[0] < 100 || lost[1] > 0 {
                return Err(format!("{whole:?}, in batches {batch:?}, lost {lost:?}"));
            }
            // The map's own bits are there, too.
            let parities = renderer(1).count(&without_casters(&frame), counting)?.stencils.remove(0);
            let high = |of: &[u8]| of.iter().map(|value| value >> count_bits).collect::<Vec<_>>();
            for found in [&at_once, &in_batches] {
                same("parities", &high(&found.stencils[0]), &high(&parities))?;
            }
        }
    }
    Ok(())
}

fn refusals() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let format = |count_bits| ShadowFormat { count_bits, ..Default::default() };
    let volumes = |given| ShadowPipelines::new(&gpu.pipelines, &format(given), Counting::Auto);
    let scene = |count_bits, count_batches| {
        let stencil = StencilCounts { count_bits, count_batches, ..Default::default() };
        Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions { stencil, ..Default::default() })
    };
    for given in [0, 9, u32::MAX] {
        let error = || ShadowError::CountBits { given, least: 1 };
        let maps = DepthMapPipelines::new(&gpu.pipelines, &format(given), 7);
        refused([
            refusal("volumes", volumes(given), is(error())),
            refusal("maps", maps, is(DepthMapError::Shadow(error()))),
            refusal("scene", scene(given, 1), is(error())),
        ])?;
    }
    let one = || is(ShadowError::CountBits { given: 1, least: 2 });
    let in_batches = ShadowPipelines::in_batches(&gpu.pipelines, &format(1), Counting::Auto);
    let shared = DepthMapPipelines::antialiased(&gpu.pipelines, &format(6), 5..8);
    refused([
        refusal("batches", in_batches, one()),
        refusal("scene in batches", scene(1, 2), one()),
        refusal("a bit of counts", shared, is(DepthMapError::Counted { bit: 5, count_bits: 6 })),
    ])?;
    // Volumes for counts of other bits.
    let (mut scene, pipelines) = (scene(8, 1).map_err(text)?, volumes(7).map_err(text)?);
    let light = scene.add_light(Light::point([0.0; 3])).map_err(text)?;
    let camera = shells(1, true).eye.camera();
    let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::new(&[camera.into()])).map_err(text))?;
    let drawn = draw_small(gpu, |pass| frame.draw(pass, &pipelines, 0, light))?;
    refused([refusal("draw", drawn, is(ShadowError::OtherCountBits { volumes: 8, pipelines: 7 }))])
}
