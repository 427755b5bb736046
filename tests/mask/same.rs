//! Masks are equal to the stencil that a caller would draw.

use rimline::Counting;
use rimline::gpu::{MaskInputs, SceneOptions, ShadowMasks, StencilCounts};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::scenes::PROJECTIONS;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat::{self, Depth16Unorm, Depth24Plus, Depth24PlusStencil8, Depth32Float, Depth32FloatStencil8};
use wgpu::TextureFormat::{R8Uint, R8Unorm, R32Uint};

use crate::drawn::Picture;
use crate::world::{SIZE, World};

pub(crate) const TESTS: &[Test] = &[
    ("masks_are_equal_to_stencils", alike),
    ("masks_without_float_depth", without),
    ("masks_of_many_lights_and_of_batches", many),
];

const DEPTHS: [TextureFormat; 5] = [Depth32Float, Depth24Plus, Depth16Unorm, Depth32FloatStencil8, Depth24PlusStencil8];
const METHODS: [Counting; 4] = [Counting::Auto, Counting::ZFail, Counting::ZpPlus, Counting::ZPass];

/// Fails if a mask differs from the stencils. Returns the numbers of samples in shadow and of others.
fn compare(picture: &Picture, masks: &[Vec<u8>], stencils: &[Vec<u8>]) -> Result<[usize; 2], String> {
    let samples = picture.samples as usize;
    let mut counts = [0, 0];
    for (light, (mask, stencil)) in masks.iter().zip(stencils).enumerate() {
        for &count in stencil {
            counts[usize::from(count == 0)] += 1;
        }
        let shares: Vec<f64> = stencil.chunks(samples).map(|pixel| share(picture, pixel)).collect();
        // Half of 255 may be rounded either way.
        let is_wrong = |at: &usize| (f64::from(mask[*at]) - 255.0 * shares[*at]).abs() > 0.5;
        let mut wrong = (0..mask.len()).filter(is_wrong);
        if let Some(at) = wrong.next() {
            let more = 1 + wrong.count();
            let [found, share] = [f64::from(mask[at]), shares[at]];
            return Err(format!("light {light} of {picture:?}: {more} wrong, pixel {at} is {found} and not {share}"));
        }
    }
    if masks.len() == stencils.len() { Ok(counts) } else { Err(format!("{} masks", masks.len())) }
}

/// The share of shadow that a mask has for a pixel with these counts.
fn share(picture: &Picture, counts: &[u8]) -> f64 {
    let samples = if picture.target == R8Unorm { counts } else { &counts[..1] };
    samples.iter().filter(|&&count| count != 0).count() as f64 / samples.len() as f64
}

/// A picture of a world by masks that drew others before, against its stencils.
fn check(
    gpu: &Gpu,
    masks: &mut ShadowMasks,
    picture: &Picture,
    world: &World,
    options: &SceneOptions,
) -> Result<[usize; 2], String> {
    let [mut found, stencils] = picture.both(gpu, world, options, masks)?;
    let counts = compare(picture, &found, &stencils)?;
    let last = found[0].len() - 1;
    found[0][last.min(777)] ^= 0x80;
    must_fail("a bit that is changed", &compare(picture, &found, &stencils))?;
    Ok(counts)
}

/// Random worlds with every depth format, direction, number of samples, target, size and counting method. Before some,
/// masks of another world are recorded and never submitted.
fn alike() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let mut all = [0, 0];
    for number in 0..if is_long() { 600 } else { 60 } {
        let size = match number % 15 {
            7 => [65, 41],
            11 => [1, 1],
            _ => SIZE,
        };
        let picture = Picture {
            size,
            depth: DEPTHS[number % 5],
            samples: [1, 1, 4][number % 3],
            target: [R32Uint, R8Unorm, R8Uint, R8Unorm][number % 4],
        };
        masks.trim = number % 7 == 3;
        if number % 6 == 5 {
            let other = World::new(number as u64 + 50, 0, 3);
            let mut dropped = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let depth = &picture.depth(gpu, &mut dropped, &other)?;
            let encoded = other.encode(gpu, &mut dropped, SceneOptions::default())?;
            let target = &picture.target(gpu, 3);
            let inputs = MaskInputs { depth, view: 0, lights: &encoded.lights, target };
            encoded.frame.write_masks(&mut dropped, masks, &inputs).map_err(text)?;
        }
        let world = World::new(number as u64, number / 2 % PROJECTIONS, 3);
        let options = SceneOptions { counting: METHODS[number / 5 % 4], ..SceneOptions::default() };
        let counts = check(gpu, masks, &picture, &world, &options);
        let counts = counts.map_err(|error| format!("world {number}: {error}"))?;
        all = [all[0] + counts[0], all[1] + counts[1]];
    }
    println!("{} samples in shadow, {} not", all[0], all[1]);
    if all.iter().all(|&count| count > 100_000) { Ok(()) } else { Err("too little of a kind".to_owned()) }
}

/// On a device without the feature, depth of 24 bits is that of a texture with stencil, to the bit below 3/4 (`copied.rs`).
fn without() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    for number in 0..4 {
        let picture = Picture { size: SIZE, depth: Depth24Plus, samples: [1, 4][number % 2], target: R8Unorm };
        // Reversed depth: nothing is as near as 4/3 of the near plane.
        let world = World::new(300 + number as u64, 0, 3);
        check(gpu, masks, &picture, &world, &SceneOptions::default())?;
    }
    Ok(())
}

/// More lights than a layer, a channel or a pass of bits holds; then casters in batches, and counts of few bits.
fn many() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    for (target, counts) in [(R8Uint, &[1, 9, 8, 41][..]), (R8Unorm, &[1, 35, 3, 1]), (R32Uint, &[1, 33, 32, 1, 70])] {
        for (number, &lights) in counts.iter().enumerate() {
            let picture = Picture { size: [64, 40], depth: Depth32Float, samples: [1, 4][number % 2], target };
            let world = World::new(100 + number as u64, number % 2, lights);
            check(gpu, masks, &picture, &world, &SceneOptions::default())?;
        }
    }
    for (seed, [count_batches, count_bits]) in (200..).zip([[2, 8], [2, 4], [1, 3]]) {
        let stencil = StencilCounts { count_batches, count_bits, ..StencilCounts::default() };
        let options = SceneOptions { stencil, ..SceneOptions::default() };
        let picture = Picture { size: SIZE, depth: Depth24Plus, samples: 1, target: R8Uint };
        check(gpu, masks, &picture, &World::new(seed, 0, 3), &options)?;
    }
    Ok(())
}
