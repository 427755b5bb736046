//! Masks are equal to the stencil that a caller would draw.

use rimline::Counting;
use rimline::gpu::{SceneOptions, ShadowMasks};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::scenes::PROJECTIONS;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat::{self, Depth16Unorm, Depth24Plus, Depth24PlusStencil8, Depth32Float, Depth32FloatStencil8};
use wgpu::TextureFormat::{R8Uint, R8Unorm, R32Uint};

use crate::drawn::Picture;
use crate::world::{SIZE, World, counted_by};

pub(crate) const TESTS: &[Test] = &[
    ("masks_are_equal_to_stencils", alike),
    ("masks_without_float_depth", without),
    ("masks_of_many_lights", many),
    ("masks_of_casters_in_batches", batches),
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
            let [more, is, to] = [1 + wrong.count(), mask[at].into(), at];
            return Err(format!(
                "light {light} of {picture:?}: {more} wrong, pixel {to} is {is} and not {}",
                shares[at]
            ));
        }
    }
    if masks.len() == stencils.len() { Ok(counts) } else { Err(format!("{} masks", masks.len())) }
}

/// The share of shadow that a mask has for a pixel with these counts.
fn share(picture: &Picture, counts: &[u8]) -> f64 {
    let samples = if picture.target == R8Unorm { counts } else { &counts[..1] };
    samples.iter().filter(|&&count| count != 0).count() as f64 / samples.len() as f64
}

/// Random worlds with every depth format, direction, number of samples, target and counting method.
fn alike() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let mut all = [0, 0];
    for number in 0..if is_long() { 600 } else { 60 } {
        let picture = Picture {
            size: SIZE,
            depth: DEPTHS[number % 5],
            samples: [1, 1, 4][number % 3],
            target: [R32Uint, R8Unorm, R8Uint, R8Unorm][number % 4],
        };
        let world = World::new(number as u64, number / 2 % PROJECTIONS, 3);
        masks.trim = number % 7 == 3;
        let [found, stencils] = picture.both(gpu, &world, &counted_by(METHODS[number / 5 % 4]), masks)?;
        let counts = compare(&picture, &found, &stencils).map_err(|error| format!("world {number}: {error}"))?;
        all = [all[0] + counts[0], all[1] + counts[1]];
        let mut changed = found;
        changed[1][777] ^= 0x80;
        must_fail("a bit that is changed", &compare(&picture, &changed, &stencils))?;
    }
    println!("{} samples in shadow, {} not", all[0], all[1]);
    if all.iter().all(|&count| count > 100_000) { Ok(()) } else { Err("too little of a kind".to_owned()) }
}

/// On a device without the feature, depth of 24 bits is that of a texture with stencil, to the bit below 3/4 (`copied.rs`).
fn without() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    for number in 0..8 {
        let picture = Picture { size: SIZE, depth: Depth24Plus, samples: [1, 4][number % 2], target: R8Unorm };
        // Reversed depth: nothing is as near as 4/3 of the near plane.
        let world = World::new(300 + number as u64, 0, 3);
        let [found, stencils] = picture.both(gpu, &world, &SceneOptions::default(), masks)?;
        compare(&picture, &found, &stencils)?;
    }
    Ok(())
}

/// More lights than a layer, a channel or a pass of bits holds.
fn many() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    for (number, (lights, target)) in [
        (1, R8Uint),
        (1, R8Unorm),
        (1, R8Unorm),
        (1, R32Uint),
        (8, R8Uint),
        (9, R8Uint),
        (32, R32Uint),
        (33, R32Uint),
        (41, R8Uint),
        (35, R8Unorm),
        (70, R32Uint),
    ]
    .into_iter()
    .enumerate()
    {
        let picture = Picture { size: [64, 40], depth: Depth32Float, samples: [1, 4][number % 2], target };
        let world = World::new(100 + number as u64, number % 2, lights);
        let [found, stencils] = picture.both(gpu, &world, &SceneOptions::default(), masks)?;
        compare(&picture, &found, &stencils)?;
    }
    Ok(())
}

/// Casters in batches, and counts of few bits.
fn batches() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    for (number, [count_batches, count_bits]) in [[2, 8], [2, 4], [1, 3]].into_iter().enumerate() {
        let options = SceneOptions {
            stencil: rimline::gpu::StencilCounts { count_batches, count_bits, ..Default::default() },
            ..SceneOptions::default()
        };
        let picture = Picture { size: SIZE, depth: Depth24Plus, samples: 1, target: R8Uint };
        let world = World::new(200 + number as u64, 0, 3);
        let [found, stencils] = picture.both(gpu, &world, &options, masks)?;
        compare(&picture, &found, &stencils)?;
    }
    Ok(())
}
