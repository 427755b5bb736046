//! Stages of shadow volumes with the maximum of items for an invocation, in one workgroup.
//! llvmpipe ends an invocation's loops after 65,535 turns without an error. docs/numerics/loops.md.

use bytemuck::Zeroable;
use rimline::internals::cpu::WINDING;
use rimline::internals::layout::{
    SceneCaster, ShadowDraw, ShadowLight, ShadowShape, ShadowStatistics, StencilPencil, ViewLight,
};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::internals::shadow::COUNT_AUTO;
use rimline::internals::stages::{BOUNDS, CAPS, COMPACT, LIST_SIDES, STENCIL_BOUND, STENCIL_CROSSINGS, STENCIL_PENCIL};
use rimline::internals::turns::EXACT_ITEMS;
use rimline::mesh::NO_FACE;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::{Dispatch, uniform};
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::interleaved;
use rimline_testkit::turns::limits;
use rimline_testkit::{must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("most_turns_of_compact_scan", compact_scan),
    ("most_turns_of_bounds", bounds),
    ("most_turns_of_caps", caps),
    ("most_turns_of_list_sides", list_sides),
    ("most_turns_of_stencil_pencil", stencil_pencil),
    ("most_turns_of_stencil_crossings", stencil_crossings),
    ("most_turns_of_stencil_bound", stencil_bound),
];

/// Slots of a chunk.
const CHUNK: u32 = 64;
/// Bytes of one binding: the default limit of devices, and llvmpipe's.
const BINDING: usize = 128 << 20;
/// Choices of a caster: every face casts for all lights, and may have near caps. All lists are dirty.
const CHOSEN: [u32; CHOICE_WORDS] = [u32::MAX, u32::MAX, u32::MAX, 0, 0, 0, 0, u32::MAX];
/// Flags of casters: their boxes and matrices are in the table; they are not in the depth buffer.
const RIGID: u32 = 4;
const PROXY: u32 = 128;
/// A matrix for rigid casters.
const ROWS: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

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

/// Small faces, some that are not finite, and behind them one that is larger than all others; or none that is finite, or
/// tiny numbers, which no device may flush to zero. Only the last choices say that the box is needed, and only the last
/// batch has a light.
fn bounds() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let chunks = 64 * stated("BOUND_CHUNKS");
    let large = [[-2.0, -3.0, -4.0], [5.0, 6.0, 7.0], [9.0, f32::MIN_POSITIVE, -8.0]];
    let hole = [[f32::NAN, 50.0, 0.0], [f32::INFINITY, 0.0, 60.0]];
    let tiny = [[1e-40, -2e-40, 0.0], [3e-40, -1e-40, -0.0], [2e-40, 2e-40, 1e-40]];
    let positions = [&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]][..], &large, &hole, &tiny].concat();
    let face = |left: u32| match left {
        0 => [3, 4, 5],
        // One names a vertex twice.
        1 => [0, 1, 7],
        2 => [0, 6, 6],
        _ => [0, 1, 2],
    };
    let faces: Vec<[u32; 3]> = (0..chunks * CHUNK).rev().map(face).collect();
    let [none, tiny] = [[0_u32, 1, 7], [8, 9, 10]].map(|face| gpu.storage(&vec![face; faces.len()]));
    // Words that grow with the coordinates: the lowest corner, inverted, and the highest; then whether there is a hole.
    let key = |c: f32| if c.is_sign_negative() { !c.to_bits() } else { c.to_bits() | 0x8000_0000 };
    let words =
        |low: [f32; 3], high: [f32; 3], hole: u32| [&low.map(|c| !key(c))[..], &high.map(key), &[hole]].concat();
    let [expected, without_last] = [words([-2.0, -3.0, -8.0], [9.0, 6.0, 7.0], 1), words([0.0; 3], [1.0; 3], 1)];
    let of_tiny = words([1e-40, -2e-40, -0.0], [3e-40, 2e-40, 1e-40], 0);
    let choice_count = stated("BOUND_CHOICES");
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
    let mut run = |faces: &wgpu::Buffer, is_dirty: u32, is_lit: u32| {
        choices[CHOICE_WORDS * choice_count as usize - 1] = is_dirty;
        lit[batches as usize - 1] = is_lit;
        let (choices, lit, found) = (gpu.storage(&choices), gpu.storage(&lit), gpu.storage(&[0_u32; 7]));
        stage.run(gpu, &[&shape, &table, &positions, faces, &found, &choices, &lit], 1)?;
        gpu.read::<u32>(&found, 7)
    };
    same("box", &run(&faces, 1, 1)?, &expected)?;
    must_fail("without the last face", &same("box", &without_last, &expected))?;
    same("no finite face", &run(&none, 1, 1)?, &[0, 0, 0, 0, 0, 0, 1])?;
    same("tiny numbers", &run(&tiny, 1, 1)?, &of_tiny)?;
    same("a box that is not read", &run(&faces, 0, 1)?, &[0; 7])?;
    same("a caster without a light", &run(&faces, 1, 0)?, &[0; 7])
}

/// Casters of one group: their shape, and the words of a table with them, with their choices, and with the first of them for
/// so many chunks.
fn group(
    casters: &[SceneCaster],
    choices: impl Fn(u32) -> [u32; CHOICE_WORDS],
    chunks: u32,
) -> (ShadowShape, Vec<u32>) {
    let count = casters.len() as u32;
    let mut words: Vec<u32> = bytemuck::cast_slice(casters).to_vec();
    words.extend((0..count).flat_map(choices));
    words.resize(words.len() + chunks.next_multiple_of(4) as usize, 0);
    let shape = ShadowShape {
        casters: count,
        lights: 32,
        batches: 1,
        views: 1,
        count_batches: 1,
        counting: COUNT_AUTO,
        choices_offset: 8 * count,
        face_chunks_offset: 10 * count,
        edge_chunks_offset: 10 * count,
        ..Zeroable::zeroed()
    };
    (shape, words)
}

/// Every face has two caps for each of 32 lights: nothing is outside a pyramid of zeros, and a light that is on the near plane
/// counts as beyond it.
fn caps() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(4712)?;
    // An invocation takes 8 slots of a chunk.
    let faces = 256 * 8 * stated("ITEMS");
    let caster = SceneCaster { flags: PROXY, faces, position_stride: 3, ..Zeroable::zeroed() };
    let (shape, table) = group(&[caster], |_| CHOSEN, faces / CHUNK);
    let shape = ShadowShape { faces, near_capacity: faces, far_capacity: faces, ..shape };
    let masks: Vec<u32> = (0..faces).map(|_| random.next_u64() as u32).collect();
    let (shape, draw) = (uniform(&gpu, &shape), uniform(&gpu, &ShadowDraw::zeroed()));
    let (seen, table) = (gpu.storage(&vec![ViewLight::zeroed(); 32]), gpu.storage(&table));
    let (positions, corners) = (gpu.storage(&[0_u32; 9]), gpu.storage(&vec![[0_u32, 1, 2]; faces as usize]));
    let (facing, excluded) = (gpu.storage(&masks), gpu.storage(&vec![0_u32; faces as usize]));
    let (choices, listed) = (gpu.storage(&CHOSEN), gpu.storage(&vec![0_u32; 128 + 64 * faces as usize]));
    let buffers = [&shape, &draw, &seen, &table, &positions, &corners, &facing, &excluded, &choices, &listed];
    Dispatch::stage(&gpu, &CAPS).run(&gpu, &buffers, 1)?;
    same("lights with near caps", &gpu.read::<u32>(&choices, 4)?[3..], &[u32::MAX])?;
    let listed: Vec<u32> = gpu.read(&listed, usize::MAX)?;
    let (counts, lists) = listed.split_at(128);
    for (light, (counts, lists)) in counts.chunks(4).zip(lists.chunks(2 * faces as usize)).enumerate() {
        let (front, back): (Vec<u32>, Vec<u32>) = (0..faces).partition(|&face| masks[face as usize] >> light & 1 != 0);
        let (front, back) = (&front[..], &back[..]);
        let lengths = [back, front, front, back].map(|list| list.len() as u32);
        same(&format!("light {light}, counts"), counts, &lengths)?;
        // Two lists fill a run.
        for (run, [first, second]) in lists.chunks(faces as usize).zip([[back, front], [front, back]]) {
            let mut found = run.to_vec();
            let (from_begin, from_end) = found.split_at_mut(first.len());
            from_begin.sort_unstable();
            from_end.sort_unstable();
            same(&format!("light {light}"), &found, &[first, second].concat())?;
            must_fail("the other list", &same("caps", &found, &[second, first].concat()))?;
        }
    }
    Ok(())
}

/// All edges are gone over, since silhouettes do not fit their list. Most have a side of weight 2.
fn list_sides() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let edges = 64 * stated("LISTED_ITEMS");
    // Only the first of two faces faces the light.
    let record = |edge: u32| match edge % 7 {
        0 => [0, NO_FACE],
        1 => [1, 1],
        _ => [edge % 2, 1 - edge % 2],
    };
    let sides_of = |edge: u32| match record(edge) {
        [0, NO_FACE] => vec![edge | WINDING],
        [0, _] => vec![edge | WINDING; 2],
        [_, 0] => vec![edge; 2],
        _ => Vec::new(),
    };
    let expected: Vec<u32> = (0..edges).flat_map(sides_of).collect();
    let records: Vec<[u32; 2]> = (0..edges).map(record).collect();
    let caster = SceneCaster { faces: 2, edges, ..Zeroable::zeroed() };
    let (shape, table) = group(&[caster], |_| CHOSEN, edges / CHUNK);
    let shape = ShadowShape { edges, capacity: 1, side_capacity: 2 * edges, ..shape };
    let mut counts = [0; 33];
    counts[0] = edges;
    let (shape, draw, table) = (uniform(gpu, &shape), uniform(gpu, &ShadowDraw::zeroed()), gpu.storage(&table));
    let (counts, silhouettes, records) = (gpu.storage(&counts), gpu.storage(&[0_u32]), gpu.storage(&records));
    let (facing, excluded, statistics) = (gpu.storage(&[1_u32, 0]), gpu.storage(&[0_u32; 2]), gpu.storage(&[0_u32; 5]));
    let sides = gpu.storage(&vec![0_u32; 64 + 2 * edges as usize]);
    let buffers = [&shape, &draw, &table, &counts, &silhouettes, &records, &facing, &excluded, &sides, &statistics];
    Dispatch::stage(gpu, &LIST_SIDES).run(gpu, &buffers, 1)?;
    let sides: Vec<u32> = gpu.read(&sides, usize::MAX)?;
    same("counts", &sides[..2], &[expected.len() as u32, 0])?;
    let mut found = sides[64..][..expected.len()].to_vec();
    found.sort_unstable_by_key(|side| side & !WINDING);
    same("sides", &found, &expected)?;
    for side in &mut found {
        *side ^= WINDING;
    }
    must_fail("turned sides", &same("sides", &found, &expected))
}

/// The maximum of casters that fit into a table with their choices. The light is among them.
fn stencil_pencil() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let count = (BINDING / (size_of::<SceneCaster>() + 4 * CHOICE_WORDS)) as u32;
    // Each of 256 invocations has nearly as many as the bound of its loops counts.
    if count.div_ceil(256) > stated("PENCIL_CASTERS") || count.div_ceil(256) < stated("PENCIL_CASTERS") * 3 / 4 {
        return Err(format!("{count} casters"));
    }
    // Whole numbers, so that boxes are exact. The last casters are on the axes, fewest on the third.
    let end = |caster: u32| [-900.0, 900.0][(caster % 2) as usize];
    let middle = |caster: u32| match count - caster {
        1..=256 => [0.0, end(caster), 0.0],
        257..=512 => [end(caster), 0.0, 0.0],
        513..=600 => [0.0, 0.0, end(caster)],
        _ => [(caster % 400) as f32 + 8.0, (caster / 400 % 400) as f32 + 8.0, (caster % 3) as f32],
    };
    let caster = |caster: u32| {
        let [x, y, z] = middle(caster);
        let (low, high) = ([x - 1.0, y - 1.0, z - 1.0], [x + 1.0, y + 1.0, z + 1.0]);
        let [row_0, row_1, row_2] = ROWS;
        SceneCaster { row_0, row_1, row_2, low, high, flags: RIGID, faces: 1 + caster % 3, ..Zeroable::zeroed() }
    };
    let does_cast = |caster: &u32| caster % 5 != 3;
    // Faces of casters whose box has a part of the third axis, and of all.
    let row_of = |count: u32| {
        let mut row = vec![0_u32; 1028];
        for caster in (0..count).filter(does_cast) {
            let [x, y, _] = middle(caster);
            row[1025] += if x == 0.0 && y == 0.0 { 1 + caster % 3 } else { 0 };
            row[1026] += 1 + caster % 3;
        }
        row
    };
    let casters: Vec<SceneCaster> = (0..count).map(caster).collect();
    let choices = |caster| if does_cast(&caster) { CHOSEN } else { [0; CHOICE_WORDS] };
    let (shape, table) = group(&casters, choices, 0);
    let light = ShadowLight { light: [0.0, 0.0, 0.0, 1.0], ..Zeroable::zeroed() };
    let seen = gpu.storage(&[ViewLight { light, ..Zeroable::zeroed() }]);
    let (shape, draw, table) = (uniform(gpu, &shape), uniform(gpu, &ShadowDraw::zeroed()), gpu.storage(&table));
    let (boxes, pencils) = (gpu.storage(&[0_u32; 8]), gpu.storage(&[StencilPencil::zeroed()]));
    let bin_rows = gpu.storage(&[0_u32; 1028]);
    let buffers = [&shape, &draw, &seen, &table, &boxes, &pencils, &bin_rows];
    Dispatch::stage(gpu, &STENCIL_PENCIL).run(gpu, &buffers, 1)?;
    let (forward, aside) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let axis = StencilPencil { kind: 2, forward, aside, bins_per_key: 256.0, ..Zeroable::zeroed() };
    same("pencil", &gpu.read::<StencilPencil>(&pencils, 1)?, &[axis])?;
    let found = gpu.read::<u32>(&bin_rows, 1028)?;
    same("row", &found, &row_of(count))?;
    must_fail("without the last casters", &same("row", &found, &row_of(count - 512)))
}

/// Sides around an axis that their caster does not meet, from the middle of a bin to that of another, the shorter way: some
/// across the half plane with the key 0.
fn stencil_crossings() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(4713)?;
    let most = 64 * stated("LISTED_ITEMS");
    let (forward, aside) = ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let pencil = StencilPencil { kind: 2, forward, aside, bins_per_key: 256.0, ..Zeroable::zeroed() };
    // |u| + |v| is 512 and u is odd, so that keys are whole numbers of bins and a half.
    let in_bin = |bin: u32| {
        let u = if bin < 512 { 511 - 2 * bin as i32 } else { 2 * bin as i32 - 1535 };
        let v = if bin < 512 { 512 - u.abs() } else { u.abs() - 512 };
        [v as f32, 0.0, u as f32]
    };
    let positions: Vec<[f32; 3]> = (0..1024).map(in_bin).collect();
    // Less than half a turn, of which the two ways would be equal.
    let edge = |number: u32| [number % 1024, (number + 1 + random.below(511) as u32) % 1024];
    let edges: Vec<[u32; 2]> = (0..most).map(edge).collect();
    let bins_of = |edges: &[[u32; 2]]| {
        let mut bins = vec![0_u32; 1025];
        for &[p, q] in edges {
            let (low, high) = (p.min(q) as usize, p.max(q) as usize);
            let runs = if high - low < 512 { vec![[low, high]] } else { vec![[0, low], [high, 1023]] };
            for [first, last] in runs {
                bins[first] = bins[first].wrapping_add(1);
                bins[last + 1] = bins[last + 1].wrapping_sub(1);
            }
        }
        bins
    };
    let mut sides = vec![0; 64];
    sides[..2].copy_from_slice(&[most / 3, most - most / 3]);
    sides.extend((0..most).map(|edge| edge | if edge % 2 == 0 { WINDING } else { 0 }));
    let [row_0, row_1, row_2] = ROWS;
    let (low, high, flags, position_stride) = ([8.0, 0.0, 8.0], [12.0, 4.0, 12.0], RIGID, 3);
    let caster =
        SceneCaster { row_0, row_1, row_2, low, high, flags, position_stride, edges: most, ..Zeroable::zeroed() };
    let (shape, table) = group(&[caster], |_| CHOSEN, most / CHUNK);
    let shape = ShadowShape { edges: most, side_capacity: most, ..shape };
    let (shape, draw, table) = (uniform(&gpu, &shape), uniform(&gpu, &ShadowDraw::zeroed()), gpu.storage(&table));
    let (boxes, positions) = (gpu.storage(&[0_u32; 8]), gpu.storage(&positions));
    let (ends, sides, pencils) = (gpu.storage(&edges), gpu.storage(&sides), gpu.storage(&[pencil]));
    let bin_rows = gpu.storage(&[0_u32; 1028]);
    let buffers = [&shape, &draw, &table, &boxes, &positions, &ends, &sides, &pencils, &bin_rows];
    Dispatch::stage(&gpu, &STENCIL_CROSSINGS).run(&gpu, &buffers, 1)?;
    let found = gpu.read::<u32>(&bin_rows, 1025)?;
    same("bins", &found, &bins_of(&edges))?;
    must_fail("without a turn", &same("bins", &found, &bins_of(&edges[64..])))
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
