//! Stages of shadow volumes with the maximum of items for an invocation, in one workgroup.
//! llvmpipe ends an invocation's loops after 65,535 turns without an error. docs/numerics/loops.md.

use bytemuck::Zeroable;
use rimline::internals::layout::{SceneCaster, ShadowDraw, ShadowShape, ShadowStatistics};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::internals::stages::{BOUNDS, COMPACT, STENCIL_BOUND};
use rimline::internals::turns::EXACT_ITEMS;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::{Dispatch, uniform};
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::interleaved;
use rimline_testkit::turns::limits;
use rimline_testkit::{must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("most_turns_of_compact_scan", compact_scan),
    ("most_turns_of_bounds", bounds),
    ("most_turns_of_stencil_bound", stencil_bound),
];

/// Slots of a chunk.
const CHUNK: u32 = 64;
/// Bytes of one binding: the default limit of devices, and llvmpipe's.
const BINDING: usize = 128 << 20;

/// A number that the bounds of loops are stated by.
fn stated(name: &str) -> u32 {
    limits(32, EXACT_ITEMS)[name] as u32
}

fn compact_scan() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let stage = Dispatch::new(gpu, &COMPACT.wgsl(), "compact_scan");
    // Blocks of one light, the last of four that counts have room for.
    let blocks = 256 * stated("SCAN_BLOCKS");
    let counts: Vec<u32> = (0..blocks).map(|block| block % 7 + block / 1000 % 3).collect();
    let (blocks_before, totals) = (gpu.storage(&counts), gpu.storage(&[9_u32; 4]));
    let chunk = uniform(gpu, &[0, 256 * blocks, 3, 1, blocks, 0, 0, 0]);
    stage.run_bound(gpu, &[&[(0, &chunk), (2, &blocks_before), (3, &totals)]], 1)?;
    let mut sum = 0;
    let before = counts.iter().map(|count| {
        sum += count;
        sum - count
    });
    let before: Vec<u32> = before.collect();
    let found: Vec<u32> = gpu.read(&blocks_before, counts.len())?;
    same("places", &found, &before)?;
    same("totals", &gpu.read::<u32>(&totals, 4)?, &[9, 9, 9, sum])?;
    must_fail("counts", &same("places", &counts, &before))
}

/// Small faces, some that are not finite, and behind them one that is larger than all others. Only the last choices say
/// that the box is needed, and only the last batch has a light.
fn bounds() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let chunks = 64 * stated("BOUND_CHUNKS");
    let large = [[-2.0, -3.0, -4.0], [5.0, 6.0, 7.0], [9.0, f32::MIN_POSITIVE, -8.0]];
    let hole = [[f32::NAN, 50.0, 0.0], [f32::INFINITY, 0.0, 60.0]];
    let positions = [&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]][..], &large, &hole].concat();
    let face = |left: u32| match left {
        0 => [3, 4, 5],
        // One names a vertex twice.
        1 => [0, 1, 7],
        2 => [0, 6, 6],
        _ => [0, 1, 2],
    };
    let faces: Vec<[u32; 3]> = (0..chunks * CHUNK).rev().map(face).collect();
    // Words that grow with the coordinates: the lowest corner, inverted, and the highest; then whether there is a hole.
    let key = |c: f32| if c.is_sign_negative() { !c.to_bits() } else { c.to_bits() | 0x8000_0000 };
    let words = |low: [f32; 3], high: [f32; 3]| [&low.map(|c| !key(c))[..], &high.map(key), &[1]].concat();
    let [expected, without_last] = [words([-2.0, -3.0, -8.0], [9.0, 6.0, 7.0]), words([0.0; 3], [1.0; 3])];
    let choice_count = stated("BOUND_PLACES");
    let (batches, views) = (32, choice_count / 32);
    let caster =
        SceneCaster { faces: faces.len() as u32, position_offset: 7, position_stride: 8, ..Zeroable::zeroed() };
    let mut words: Vec<u32> = bytemuck::cast_slice(&[caster]).to_vec();
    let face_chunks_offset = words.len() as u32 / 4;
    words.extend((0..chunks).map(|_| 0));
    let shape = ShadowShape {
        casters: 1,
        lights: 1,
        used_lights: 1,
        faces: faces.len() as u32,
        batches,
        views,
        face_chunks_offset,
        ..Zeroable::zeroed()
    };
    let mut choices = vec![0_u32; CHOICE_WORDS * choice_count as usize];
    let mut lit = vec![0_u32; batches as usize];
    let stage = Dispatch::stage(gpu, &BOUNDS);
    let (shape, table) = (uniform(gpu, &shape), gpu.storage(&words));
    let (positions, faces) = (gpu.storage(&interleaved(&positions, 28, 32)), gpu.storage(&faces));
    let mut run = |is_dirty: u32, is_lit: u32| {
        choices[CHOICE_WORDS * choice_count as usize - 1] = is_dirty;
        lit[batches as usize - 1] = is_lit;
        let (choices, lit, found) = (gpu.storage(&choices), gpu.storage(&lit), gpu.storage(&[0_u32; 7]));
        stage.run(gpu, &[&shape, &table, &positions, &faces, &found, &choices, &lit], 1)?;
        gpu.read::<u32>(&found, 7)
    };
    same("box", &run(1, 1)?, &expected)?;
    must_fail("without the last face", &same("box", &without_last, &expected))?;
    same("a box that is not read", &run(0, 1)?, &[0; 7])?;
    same("a caster without a light", &run(1, 0)?, &[0; 7])
}

/// The maximum of batches of casters that rows of a light have room for.
fn stencil_bound() -> Result<(), String> {
    const ROW: usize = 1028;
    let gpu = &*Gpu::shared()?;
    let rows = BINDING / (4 * ROW);
    if rows.div_ceil(64) > stated("COUNT_BATCHES") as usize / 64 || rows < stated("COUNT_BATCHES") as usize * 9 / 10 {
        return Err(format!("{rows} rows"));
    }
    let mut words = vec![0_u32; rows * ROW];
    // Some weights that cross the last bins, and more where the row is the last.
    let weight = |number: usize| if number + 1 == rows { 777 } else { (number % 500) as u32 };
    for (number, row) in words.chunks_mut(ROW).enumerate() {
        let weight = weight(number);
        (row[1000 + number % 23], row[1026]) = (weight, 100_000);
        row[1024] = 0_u32.wrapping_sub(weight);
    }
    let shape =
        ShadowShape { lights: 1, views: 1, count_batches: rows as u32, largest_count: 255, ..Zeroable::zeroed() };
    let draw = ShadowDraw::zeroed();
    let statistics = gpu.storage(&[0_u32; size_of::<ShadowStatistics>() / 4]);
    let (shape, draw, bin_rows) = (uniform(gpu, &shape), uniform(gpu, &draw), gpu.storage(&words));
    Dispatch::stage(gpu, &STENCIL_BOUND).run(gpu, &[&shape, &draw, &bin_rows, &statistics], 1)?;
    let bounds: Vec<u32> = (0..rows).map(|row| weight(row).div_ceil(2)).collect();
    let most = |bounds: &[u32]| bounds.iter().copied().max().unwrap_or(0);
    let expected = |count_bound| ShadowStatistics { count_bound, may_wrap: 1, ..Zeroable::zeroed() };
    let found = gpu.read::<ShadowStatistics>(&statistics, 1)?;
    same("statistics", &found, &[expected(most(&bounds))])?;
    must_fail("without the last row", &same("statistics", &found, &[expected(most(&bounds[..rows - 1]))]))
}
