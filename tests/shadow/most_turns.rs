//! Stages of shadow volumes with the maximum of items for an invocation, in one workgroup.
//! llvmpipe ends an invocation's loops after 65,535 turns without an error. docs/numerics/loops.md.

use bytemuck::Zeroable;
use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::{SceneCaster, ShadowDraw, ShadowLight, ShadowShape, ShadowStatistics, StencilPencil};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::internals::shadow::{self, CAST_EVERY, COUNT_Z_PASS, COUNT_ZP_PLUS};
use rimline::internals::stages::{BOUNDS, CAPS, COMPACT, LIST_SIDES, STENCIL_BOUND, STENCIL_CROSSINGS, STENCIL_PENCIL};
use rimline::internals::turns::EXACT_ITEMS;
use rimline::{DepthDirection, Light, Mesh, Predicate, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::{Dispatch, uniform};
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::turns::limits;
use rimline_testkit::{must_fail, same, shapes};

use crate::sides::{self, box_words};
use crate::stages::{LAYOUTS, choices, position_buffer, seen, shape, table, with_depth};
use rimline_testkit::goldens::golden;

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

/// Small faces, and behind them one that is larger than all others.
fn one_large(faces: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let positions = vec![
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 1.0],
        [-2.0, -3.0, -4.0],
        [5.0, 6.0, 7.0],
        [9.0, f32::MIN_POSITIVE, -8.0],
    ];
    let faces = (1..=faces).map(|face| if face == faces { [3, 4, 5] } else { [0, 1, 2] }).collect();
    (positions, faces)
}

/// Only the last choices say that the box is needed, and only the last batch has a light.
fn bounds() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let chunks = 64 * stated("BOUND_CHUNKS");
    let (positions, faces) = one_large(chunks * CHUNK);
    let [expected, without_last] = [box_words(&positions, &faces), box_words(&positions, &faces[..64])];
    let choice_count = stated("BOUND_PLACES");
    let (batches, views) = (32, choice_count / 32);
    let caster = SceneCaster { faces: faces.len() as u32, position_stride: 3, ..Zeroable::zeroed() };
    let mut words: Vec<u32> = bytemuck::cast_slice(&[caster]).to_vec();
    let face_chunks_offset = words.len() as u32 / 4;
    words.extend((0..chunks).map(|_| 0));
    let mesh = Mesh::from_faces(positions.len(), vec![[0, 1, 2]]).map_err(text)?;
    let shadow_shape = ShadowShape { faces: faces.len() as u32, batches, views, face_chunks_offset, ..shape(&mesh, 1) };
    let mut choices = vec![0_u32; CHOICE_WORDS * choice_count as usize];
    let mut lit = vec![0_u32; batches as usize];
    let stage = Dispatch::stage(gpu, &BOUNDS);
    let (shape, table) = (uniform(gpu, &shadow_shape), gpu.storage(&words));
    let (positions, faces) = (position_buffer(gpu, &positions, LAYOUTS[0]), gpu.storage(&faces));
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

fn camera() -> ShadowCamera {
    let view_projection = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.1, 0.0]];
    ShadowCamera { view_projection, origin: [0.1, 0.2, 3.0], depth: DepthDirection::Reversed }
}

/// All faces have far caps for 32 lights, and some have near caps.
fn caps() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    // An invocation takes 8 slots of a chunk.
    let plane = shapes::plane_grid(512, 2 * stated("ITEMS"));
    let mesh = plane.mesh().map_err(text)?;
    let faces = mesh.faces().len();
    same("faces", &[faces as u32], &[256 * stated("ITEMS") * 8])?;
    let camera = camera();
    let view = shadow::view(&camera).map_err(text)?;
    let plain: Vec<Light> = (0..32).map(|number| Light::point([number as f32 / 8.0 - 2.0, -0.1, -0.9])).collect();
    let given: Vec<ShadowLight> = plain.iter().map(|&light| shadow::light(&camera, &view, light)).collect();
    let chosen = |light: &ShadowLight| ShadowLight { casting: CAST_EVERY, counting: COUNT_ZP_PLUS, ..*light };
    let lights: Vec<ShadowLight> = given.iter().map(chosen).collect();
    let masks = cpu::facing(&plane.positions, mesh.faces(), &plain, Predicate::Exact, Threads::all());
    let none = vec![0; faces];
    let shadow_shape = ShadowShape { proxies: 1, ..shape(&mesh, 32) };
    let mut list = vec![0_u32; 128];
    list.resize(128 + 64 * faces, u32::MAX);
    let capped = vec![false; 32];
    let table = with_depth(table(&mesh, LAYOUTS[0], &lights, &capped), false);
    let draw = ShadowDraw::zeroed();
    let (shape, draw, seen) = (uniform(gpu, &shadow_shape), uniform(gpu, &draw), gpu.storage(&seen(view, &given)));
    let (positions, table) = (position_buffer(gpu, &plane.positions, LAYOUTS[0]), gpu.storage(&table));
    let (faces_buffer, facing, excluded) = (gpu.storage(mesh.faces()), gpu.storage(&masks), gpu.storage(&none));
    let (choices, list) = (gpu.storage(&choices(&lights, &capped)), gpu.storage(&list));
    let buffers = [&shape, &draw, &seen, &table, &positions, &faces_buffer, &facing, &excluded, &choices, &list];
    Dispatch::stage(gpu, &CAPS).run(gpu, &buffers, 1)?;
    let list: Vec<u32> = gpu.read(&list, usize::MAX)?;
    let (counts, lists) = list.split_at(128);
    let mut near = 0;
    let mut all = counts.to_vec();
    for (number, runs) in lists.chunks(2 * faces).enumerate() {
        let lengths = [0, 1, 2, 3].map(|kind| counts[4 * number + kind] as usize);
        let most = sides::caps(&mesh, &plane.positions, (number, &lights[number]), [&masks, &none], false);
        for (kind, most) in most.iter().enumerate() {
            let run = &runs[kind / 2 * faces..][..faces];
            let mut entries =
                if kind % 2 == 0 { &run[..lengths[kind]] } else { &run[faces - lengths[kind]..] }.to_vec();
            entries.sort_unstable();
            if kind > 1 {
                same(&format!("light {number}, list {kind}"), &entries, most)?;
            }
            all.extend(entries);
        }
        same(&format!("light {number}, faces with caps"), &[lengths[2] + lengths[3]], &[faces])?;
        near += lengths[0] + lengths[1];
    }
    // Which faces have near caps: those between light and near rectangle.
    golden("shadow", "most_turns_of_caps", &all)?;
    println!("{near} near caps");
    if near > 100 { Ok(()) } else { Err("too few near caps".to_owned()) }
}

/// Every edge has a side of weight 1 or 2, but where one face of two faces the light.
fn list_sides() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let most = 64 * stated("LISTED_ITEMS");
    let mesh = shapes::plane_grid(295, 295).mesh().map_err(text)?;
    let (faces, packed) = (mesh.faces().len(), mesh.edges().packed_faces());
    if !(most - 600..=most).contains(&(packed.len() as u32)) {
        return Err(format!("{} edges for {most} items", packed.len()));
    }
    let mut random = Random::new(4711);
    let facing: Vec<u32> = (0..faces).map(|_| random.next_u64() as u32).collect();
    let none = vec![0; faces];
    let light = ShadowLight { casting: CAST_EVERY, counting: COUNT_Z_PASS, ..Zeroable::zeroed() };
    let twin = sides::lists(&mesh, (0, &light), [&facing, &none], false).concat();
    let room = 2 * packed.len();
    let shadow_shape = ShadowShape { capacity: 1, side_capacity: room as u32, ..shape(&mesh, 1) };
    let draw = ShadowDraw::zeroed();
    // Silhouettes that do not fit their list, so that all edges are gone over.
    let mut counts = [0; 33];
    counts[0] = packed.len() as u32;
    let (counts, raw) = (gpu.storage(&counts), gpu.storage(&[u32::MAX]));
    let (shape, draw) = (uniform(gpu, &shadow_shape), uniform(gpu, &draw));
    let (table, edge_faces) = (gpu.storage(&table(&mesh, LAYOUTS[0], &[light], &[false])), gpu.storage(packed));
    let (facing, excluded, zeros) = (gpu.storage(&facing), gpu.storage(&none), gpu.storage(&[0_u32; 5]));
    let sides = gpu.storage(&vec![u32::MAX; 64 + room]);
    gpu.queue.write_buffer(&sides, 0, &[0; 256]);
    let buffers = [&shape, &draw, &table, &counts, &raw, &edge_faces, &facing, &excluded, &sides, &zeros];
    Dispatch::stage(gpu, &LIST_SIDES).run(gpu, &buffers, 1)?;
    let sides: Vec<u32> = gpu.read(&sides, usize::MAX)?;
    same("counts", &sides[..2], &[twin.len() as u32, 0])?;
    let mut found = sides[64..][..twin.len()].to_vec();
    found.sort_by_key(|entry| entry & !cpu::WINDING);
    same("sides", &found, &twin)?;
    let doubled = twin.windows(2).filter(|pair| pair[0] == pair[1]).count();
    println!("{} sides, {doubled} of them twice", twin.len());
    if doubled > 50_000 { Ok(()) } else { Err("too few sides of weight 2".to_owned()) }
}

/// The maximum of casters that fit into a table with their choices. The light is among them, and they are rotated.
fn stencil_pencil() -> Result<(), String> {
    const RIGID: u32 = 4;
    let gpu = &*Gpu::shared()?;
    let casters = (BINDING / (size_of::<SceneCaster>() + 4 * CHOICE_WORDS)) as u32;
    // Each of 256 invocations has nearly as many as the bound of its loops counts.
    if casters.div_ceil(256) > stated("PENCIL_CASTERS") || casters.div_ceil(256) < stated("PENCIL_CASTERS") * 3 / 4 {
        return Err(format!("{casters} casters"));
    }
    // Whole numbers, so that boxes are exact. The last casters are on the axes, fewest on the third.
    let end = |caster: u32| [-900.0, 900.0][(caster % 2) as usize];
    let centre = |caster: u32| match casters - caster {
        1..=256 => [0.0, end(caster), 0.0],
        257..=512 => [end(caster), 0.0, 0.0],
        513..=600 => [0.0, 0.0, end(caster)],
        _ => [(caster % 400) as f32 + 8.0, (caster / 400 % 400) as f32 + 8.0, (caster % 3) as f32],
    };
    let of = |caster: u32| {
        let [x, y, z] = centre(caster);
        SceneCaster {
            row_0: [0.0, 2.0, 0.0, x],
            row_1: [-2.0, 0.0, 0.0, y],
            row_2: [0.0, 0.0, 1.0, z],
            low: [-1.0; 3],
            scale: 1.0,
            high: [1.0; 3],
            flags: RIGID,
            faces: 1 + caster % 3,
            ..Zeroable::zeroed()
        }
    };
    let does_cast = |caster: &u32| caster % 5 != 3;
    let camera = camera();
    let view = shadow::view(&camera).map_err(text)?;
    let light = shadow::light(&camera, &view, Light::point([0.0; 3]));
    let axis = StencilPencil {
        kind: 2,
        forward: [1.0, 0.0, 0.0],
        aside: [0.0, 1.0, 0.0],
        bins_per_key: 256.0,
        ..Zeroable::zeroed()
    };
    // Faces of casters whose box has a part of the third axis, and of all.
    let row_of = |casters: std::ops::Range<u32>| {
        let mut row = vec![0; 1028];
        for caster in casters.filter(does_cast) {
            let [x, y, _] = centre(caster);
            row[1025] += if x.abs() <= 2.0 && y.abs() <= 2.0 { 1 + caster % 3 } else { 0 };
            row[1026] += 1 + caster % 3;
        }
        row
    };
    let row = row_of(0..casters);
    let all: Vec<SceneCaster> = (0..casters).map(of).collect();
    let mut words: Vec<u32> = bytemuck::cast_slice(&all).to_vec();
    let choices_offset = words.len() as u32 / 4;
    words.extend((0..casters).flat_map(|caster| [u32::from(does_cast(&caster)), 0, 0, 0, 0, 0, 0, 0]));
    let mesh = Mesh::from_faces(3, vec![[0, 1, 2]]).map_err(text)?;
    let shadow_shape = ShadowShape { casters, choices_offset, ..shape(&mesh, 1) };
    let draw = ShadowDraw::zeroed();
    let (shape, draw, seen) = (uniform(gpu, &shadow_shape), uniform(gpu, &draw), gpu.storage(&seen(view, &[light])));
    let (table, boxes_buffer) = (gpu.storage(&words), gpu.storage(&[0_u32; 8]));
    let (pencils, bin_rows) = (gpu.storage(&[[0_u32; size_of::<StencilPencil>() / 4]]), gpu.storage(&[0_u32; 1028]));
    let buffers = [&shape, &draw, &seen, &table, &boxes_buffer, &pencils, &bin_rows];
    Dispatch::stage(gpu, &STENCIL_PENCIL).run(gpu, &buffers, 1)?;
    same("pencil", &gpu.read::<StencilPencil>(&pencils, 1)?, &[axis])?;
    same("row", &gpu.read::<u32>(&bin_rows, row.len())?, &row)?;
    must_fail("without the last casters", &same("row", &row, &row_of(0..casters - 512)))
}

/// Sides in the middle of bins, around an axis that their caster does not meet: each crosses from a half plane to
/// another, some across the half plane with the key 0.
fn stencil_crossings() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let most = 64 * stated("LISTED_ITEMS");
    let pencil = StencilPencil {
        kind: 2,
        forward: [0.0, 0.0, 1.0],
        aside: [1.0, 0.0, 0.0],
        bins_per_key: 256.0,
        ..Zeroable::zeroed()
    };
    // |u| + |v| is 512 and u is odd, so that keys are whole numbers of bins and a half.
    let corner = |number: u32| {
        let u = 2 * (number % 512) as i32 - 511;
        [u, (512 - u.abs()) * if number % 1024 < 512 { 1 } else { -1 }]
    };
    let end = |number: u32| {
        let [u, v] = corner(number).map(|c| c as f32);
        [v, 0.0, u]
    };
    let positions: Vec<[f32; 3]> = (0..1024).map(end).collect();
    let edges = (0..4096_u32).map(|edge| [edge % 1024, (7 * edge + edge / 5) % 1024]);
    // Half a turn is the shorter way on either side.
    let is_half = |[a, b]: &[u32; 2]| positions[*a as usize].map(|c| -c) == positions[*b as usize];
    let edges: Vec<[u32; 2]> = edges.filter(|edge| !is_half(edge)).collect();
    let mesh = Mesh::from_faces(3, vec![[0, 1, 2]]).map_err(text)?;
    let plain = most / 3;
    let shadow_shape = ShadowShape { edges: edges.len() as u32, side_capacity: most, ..shape(&mesh, 1) };
    let named = |entry: u32| (entry / 64 + 31 * (entry % 64)) % edges.len() as u32;
    let mut sides = vec![0; 64];
    sides[..2].copy_from_slice(&[plain, most - plain]);
    sides.extend((0..most).map(|entry| named(entry) | if entry % 2 == 0 { cpu::WINDING } else { 0 }));
    // Twice the bins up to the key of an end.
    let halves = |number: u32| {
        let [u, v] = corner(number);
        if v >= 0 { 512 - u } else { 1536 + u }
    };
    let mut bins = vec![0_u32; 1025];
    for entry in 0..most {
        let [p, q] = edges[named(entry) as usize].map(halves);
        let (first, last) = ((p.min(q) / 2) as usize, (p.max(q) / 2) as usize);
        // The shorter way.
        let runs =
            if (p - q).abs() > 1024 { [Some([0, first]), Some([last, 1023])] } else { [Some([first, last]), None] };
        for [first, last] in runs.into_iter().flatten() {
            bins[first] = bins[first].wrapping_add(1);
            bins[last + 1] = bins[last + 1].wrapping_sub(1);
        }
    }
    let light = ShadowLight { casting: CAST_EVERY, counting: COUNT_Z_PASS, ..Zeroable::zeroed() };
    let mut words = table(&mesh, LAYOUTS[0], &[light], &[false]);
    words[std::mem::offset_of!(SceneCaster, edges) / 4] = edges.len() as u32;
    words.resize(words.len().next_multiple_of(4), 0);
    let shadow_shape = ShadowShape { edge_chunks_offset: words.len() as u32 / 4, ..shadow_shape };
    words.resize(words.len() + edges.len().div_ceil(64).next_multiple_of(4), 0);
    // A caster that the axis does not meet.
    let boxes = box_words(&[[8.0, 0.0, 8.0], [12.0, 4.0, 12.0]], &[[0, 1, 1]]);
    let draw = ShadowDraw::zeroed();
    let (shape, draw, table) = (uniform(gpu, &shadow_shape), uniform(gpu, &draw), gpu.storage(&words));
    let (boxes, positions) = (gpu.storage(&boxes), position_buffer(gpu, &positions, LAYOUTS[0]));
    let (edges, sides, pencils) = (gpu.storage(&edges), gpu.storage(&sides), gpu.storage(&[pencil]));
    let bin_rows = gpu.storage(&[0_u32; 1028]);
    let buffers = [&shape, &draw, &table, &boxes, &positions, &edges, &sides, &pencils, &bin_rows];
    Dispatch::stage(gpu, &STENCIL_CROSSINGS).run(gpu, &buffers, 1)?;
    same("bins", &gpu.read::<u32>(&bin_rows, 1025)?, &bins)?;
    let crossed = bins[..1024].iter().filter(|&&change| change != 0).count();
    if crossed > 500 { Ok(()) } else { Err(format!("{crossed} bins")) }
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
    let mesh = Mesh::from_faces(3, vec![[0, 1, 2]]).map_err(text)?;
    let shadow_shape = ShadowShape { count_batches: rows as u32, ..shape(&mesh, 1) };
    let draw = ShadowDraw::zeroed();
    let statistics = gpu.storage(&[0_u32; size_of::<ShadowStatistics>() / 4]);
    let (shape, draw, bin_rows) = (uniform(gpu, &shadow_shape), uniform(gpu, &draw), gpu.storage(&words));
    Dispatch::stage(gpu, &STENCIL_BOUND).run(gpu, &[&shape, &draw, &bin_rows, &statistics], 1)?;
    let bounds: Vec<u32> = (0..rows).map(|row| weight(row).div_ceil(2)).collect();
    let most = |bounds: &[u32]| bounds.iter().copied().max().unwrap_or(0);
    let expected = |count_bound| ShadowStatistics { count_bound, may_wrap: 1, ..Zeroable::zeroed() };
    let found = gpu.read::<ShadowStatistics>(&statistics, 1)?;
    same("statistics", &found, &[expected(most(&bounds))])?;
    must_fail("without the last row", &same("statistics", &found, &[expected(most(&bounds[..rows - 1]))]))
}
