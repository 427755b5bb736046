//! The stages that choose and list for shadow volumes, each against an oracle or goldens.

use std::sync::Arc;

use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::{
    SceneCaster, ShadowDraw, ShadowDraws, ShadowLight, ShadowShape, ShadowStatistics, ShadowView, ViewLight,
};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::internals::shadow::{
    self, CAST_BACK_FACING, CAST_EVERY, CAST_NOTHING, COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS,
    COUNT_ZP_PLUS_2005,
};
use rimline::internals::stages::{BOUNDS, CAPS, COUNTING_METHODS, LIST_SIDES, SHADOW_ARGUMENTS, Stage};
use rimline::{Light, Mesh, Predicate};

use crate::sides::{self, box_words};
use rimline_testkit::cases::topologies;
use rimline_testkit::choices::chosen;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::{Dispatch, uniform};
use rimline_testkit::goldens::golden;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{interleaved, text};
use rimline_testkit::oracle::listed;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Scene, scene};
use rimline_testkit::stage_probe::seen_light;
use rimline_testkit::{is_long, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("bounds_are_those_of_the_finite_faces", bounds),
    ("choices_and_lists_of_caps", choose_and_caps),
    ("sides_are_those_of_their_faces", list_sides),
    ("shadow_arguments_are_those_of_their_counts", shadow_arguments),
];

/// Layouts of positions in their buffer: words before the first, and from one to the next.
pub(crate) const LAYOUTS: [(u32, u32); 3] = [(0, 3), (5, 3), (7, 8)];

pub(crate) fn position_buffer(gpu: &Gpu, positions: &[[f32; 3]], (offset, stride): (u32, u32)) -> wgpu::Buffer {
    gpu.storage(&interleaved(positions, 4 * u64::from(offset), 4 * u64::from(stride)))
}

/// Where the casters of a table's chunks begin.
const CHUNKS_AT: u32 = size_of::<SceneCaster>() as u32 / 16;

/// The vectors of a table for the casters of a mesh's chunks, of faces or of edges.
fn chunk_vectors(mesh: &Mesh) -> u32 {
    (mesh.faces().len().max(mesh.edges().len()) as u32).div_ceil(4 * 64)
}

pub(crate) fn shape(mesh: &Mesh, lights: usize) -> ShadowShape {
    let counts = mesh.edges().counts();
    let choices_offset = CHUNKS_AT + chunk_vectors(mesh);
    let batches = lights.div_ceil(32) as u32;
    ShadowShape {
        casters: 1,
        lights: lights as u32,
        batches,
        // Whole chunks.
        faces: mesh.faces().len().next_multiple_of(64) as u32,
        edges: mesh.edges().len() as u32,
        capacity: 1000,
        side_capacity: 1000,
        near_capacity: mesh.faces().len() as u32,
        far_capacity: mesh.faces().len() as u32,
        allow_back_facing: u32::from(counts.boundary == 0 && counts.inconsistent == 0),
        counting: COUNT_AUTO,
        cull_by_view: 1,
        cull_by_range: 1,
        choices_offset,
        measures_offset: choices_offset + 2 * batches,
        face_chunks_offset: CHUNKS_AT,
        edge_chunks_offset: CHUNKS_AT,
        views: 1,
        count_batches: 1,
        used_lights: lights as u32,
        largest_count: 255,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// The words of a table with one caster, whose positions have this layout, and of what was chosen for the lights.
pub(crate) fn table(
    mesh: &Mesh,
    (position_offset, position_stride): (u32, u32),
    lights: &[ShadowLight],
    capped: &[bool],
) -> Vec<u32> {
    let counts = mesh.edges().counts();
    let caster = SceneCaster {
        row_0: [1.0, 0.0, 0.0, 0.0],
        row_1: [0.0, 1.0, 0.0, 0.0],
        row_2: [0.0, 0.0, 1.0, 0.0],
        scale: 1.0,
        flags: u32::from(counts.boundary == 0 && counts.inconsistent == 0),
        faces: mesh.faces().len() as u32,
        edges: mesh.edges().len() as u32,
        position_offset,
        position_stride,
        ..bytemuck::Zeroable::zeroed()
    };
    let mut words = bytemuck::cast_slice(&[caster]).to_vec();
    words.resize(words.len() + 4 * chunk_vectors(mesh) as usize, 0);
    words.extend(choices(lights, capped));
    words
}

/// The words of a table whose first caster is in the depth buffer, or not.
pub(crate) fn with_depth(mut words: Vec<u32>, in_depth: bool) -> Vec<u32> {
    let flags = std::mem::offset_of!(SceneCaster, flags) / 4;
    words[flags] = words[flags] & !128 | if in_depth { 0 } else { 128 };
    words
}

/// Words of choices for so many lights that are made anew.
fn dirty_choices(lights: usize) -> Vec<u32> {
    [0, 0, 0, 0, 0, 0, 0, u32::MAX].repeat(lights.div_ceil(32))
}

/// Choices and measures of one caster, as the stages leave them.
pub(crate) fn choices(lights: &[ShadowLight], capped: &[bool]) -> Vec<u32> {
    let mut words = dirty_choices(lights.len());
    for (number, (light, &capped)) in lights.iter().zip(capped).enumerate() {
        let has_near_cap = matches!(light.counting, COUNT_ZP_PLUS | COUNT_ZP_PLUS_2005);
        let every = light.casting == CAST_EVERY;
        let excludes = light.casting != CAST_NOTHING && light.excludes != 0;
        let kinds = [light.casting != CAST_NOTHING, every, has_near_cap, capped, excludes, excludes];
        for (kind, is_set) in kinds.into_iter().enumerate() {
            words[CHOICE_WORDS * (number / 32) + kind] |= u32::from(is_set) << (number % 32);
        }
    }
    words.extend(lights.iter().flat_map(|light| [light.end, light.frustum_near].map(f32::to_bits)));
    words
}

/// Lights without what was chosen for them.
pub(crate) fn seen(view: ShadowView, lights: &[ShadowLight]) -> Vec<ViewLight> {
    lights.iter().map(|&light| seen_light(view, light)).collect()
}

/// A stage by itself, compiled once.
pub(crate) fn stage(gpu: &Gpu, stage: &Stage) -> Result<Arc<Dispatch>, String> {
    gpu.kept(stage.name, || Ok(Dispatch::stage(gpu, stage)))
}

/// Makes some coordinates infinite or NaN.
pub(crate) fn spoil(random: &mut Random, positions: &mut [[f32; 3]], count: usize) {
    for _ in 0..count {
        let vertex = random.below(positions.len());
        positions[vertex][random.below(3)] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][random.below(3)];
    }
}

const EMPTY: [u32; 7] = [0; 7];

fn bounds() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(101)?;
    let stage = Dispatch::stage(&gpu, &BOUNDS);
    for (name, mut positions, mesh) in topologies() {
        let faces = gpu.storage(mesh.faces());
        for round in 0..6 {
            let (offset, scale) = ([0.0, -7.0, 1e30][round % 3], [1.0, 1e-40, 1e8][random.below(3)]);
            positions.iter_mut().flatten().for_each(|c| *c = *c * scale + offset);
            // In the end none is finite.
            spoil(&mut random, &mut positions, if round == 5 { 100_000 } else { 2 * round });
            let layout = LAYOUTS[round % 3];
            let found = gpu.storage(&EMPTY);
            let shape = uniform(&gpu, &shape(&mesh, 1));
            let table = gpu.storage(&table(&mesh, layout, &[], &[]));
            let choices = gpu.storage(&dirty_choices(1));
            let lit = gpu.storage(&[1_u32]);
            let buffers = [&shape, &table, &position_buffer(&gpu, &positions, layout), &faces, &found, &choices, &lit];
            stage.run(&gpu, &buffers, [1, 3, 50][random.below(3)])?;
            let mut found: Vec<u32> = gpu.read(&found, 7)?;
            let expected = box_words(&positions, mesh.faces());
            same(&format!("{name}, round {round}"), &found, &expected)?;
            found[random.below(7)] ^= 1;
            must_fail("a moved bound", &same(&name, &found, &expected))?;
        }
        let with_holes = [0, 0, 0, 0, 0, 0, 1];
        same(&format!("{name}, nothing finite"), &box_words(&positions, mesh.faces()), &with_holes)?;
    }
    Ok(())
}

/// A scene in buffers.
pub(crate) struct Staged<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) shape: ShadowShape,
    layout: (u32, u32),
    pub(crate) view: ShadowView,
    given: Vec<ShadowLight>,
    pub(crate) facing: Vec<u32>,
    pub(crate) excluded: Vec<u32>,
    positions: wgpu::Buffer,
    faces: wgpu::Buffer,
    bounds: [u32; 7],
}

impl<'a> Staged<'a> {
    /// `shape` has the options. Any masks of excluded faces will do: what they say has nothing to do with where lights are.
    pub(crate) fn new(
        gpu: &Gpu,
        scene: &'a Scene,
        layout: (u32, u32),
        shape: ShadowShape,
        excluded: Vec<u32>,
    ) -> Result<Self, String> {
        let (_, positions, mesh) = &scene.caster;
        let view = shadow::view(&scene.camera).map_err(text)?;
        Ok(Self {
            scene,
            shape,
            layout,
            view,
            given: scene.lights.iter().map(|&light| shadow::light(&scene.camera, &view, light)).collect(),
            facing: cpu::facing(positions, mesh.faces(), &scene.lights, Predicate::Exact, Threads::ONE),
            excluded,
            positions: position_buffer(gpu, positions, layout),
            faces: gpu.storage(mesh.faces()),
            bounds: box_words(positions, mesh.faces()),
        })
    }

    /// The caster, in the depth buffer or not.
    fn table(&self) -> Vec<u32> {
        with_depth(table(&self.scene.caster.2, self.layout, &[], &[]), self.shape.proxies == 0)
    }

    /// The lights with what is chosen for them, where polygons are twisted for the lights of `twisted` in each batch.
    pub(crate) fn choose(&self, gpu: &Gpu, twisted: u32) -> Result<(Vec<ShadowLight>, ShadowStatistics), String> {
        let stage = stage(gpu, &COUNTING_METHODS)?;
        let seen = seen(self.view, &self.given);
        let mut words = dirty_choices(seen.len());
        words.resize(words.len() + 2 * seen.len(), 0);
        let (choices, statistics) = (gpu.storage(&words), gpu.storage(&[0_u32; size_of::<ShadowStatistics>() / 4]));
        let table = gpu.storage(&self.table());
        let batches = seen.len().div_ceil(32);
        let (bounds, twisted) = (gpu.storage(&self.bounds), gpu.storage(&vec![twisted; batches]));
        let (shape, lights) = (uniform(gpu, &self.shape), gpu.storage(&seen));
        let (lit, receivers) = (gpu.storage(&vec![u32::MAX; batches]), gpu.storage(&[0_u32]));
        stage.run(gpu, &[&shape, &lights, &table, &bounds, &twisted, &choices, &statistics, &lit, &receivers], 1)?;
        let words: Vec<u32> = gpu.read(&choices, usize::MAX)?;
        Ok((chosen(&self.shape, &seen, &words), gpu.read(&statistics, 1)?[0]))
    }

    /// The counts, the lists in the order of the faces, and which lights have near caps.
    pub(crate) fn caps(&self, gpu: &Gpu, lights: &[ShadowLight], capacity: u32) -> Result<Listed, String> {
        let stage = stage(gpu, &CAPS)?;
        let faces = self.scene.caster.2.faces().len();
        let shape = ShadowShape { near_capacity: capacity, far_capacity: capacity, ..self.shape };
        let (shape, seen) = (uniform(gpu, &shape), gpu.storage(&seen(self.view, &self.given)));
        let choices = gpu.storage(&choices(lights, &vec![false; lights.len()]));
        let table = gpu.storage(&self.table());
        let mut listed = Listed::default();
        for (word, planes) in self.facing.chunks(faces).zip(self.excluded.chunks(faces)).enumerate() {
            let (light, first_light) = (32 * word as u32, 32 * word as u32);
            let draw = uniform(gpu, &ShadowDraw { light, first_light, view: 0, count_batch: 0 });
            let count = (lights.len() - 32 * word).min(32);
            let mut words = vec![0_u32; 128];
            words.resize(128 + 2 * count * capacity as usize, u32::MAX);
            let list = gpu.storage(&words);
            let (facing, excluded) = (gpu.storage(planes.0), gpu.storage(planes.1));
            let given = [&shape, &draw, &seen, &table, &self.positions, &self.faces, &facing, &excluded];
            stage.run(gpu, &[&given[..], &[&choices, &list]].concat(), 3)?;
            let list: Vec<u32> = gpu.read(&list, usize::MAX)?;
            let (counts, lists) = list.split_at(128);
            for (counts, run) in counts.chunks(2).zip(lists.chunks(capacity as usize)) {
                listed.counts.extend(counts);
                listed.lists.push(run.iter().copied().take(counts[0] as usize).collect());
                listed.lists.push(run.iter().rev().copied().take(counts[1] as usize).collect());
            }
        }
        listed.lists.iter_mut().for_each(|list| list.sort_unstable());
        let words: Vec<u32> = gpu.read(&choices, usize::MAX)?;
        let capped = |light: usize| words[CHOICE_WORDS * (light / 32) + 3] >> (light % 32) & 1 != 0;
        listed.capped = (0..lights.len()).map(capped).collect();
        Ok(listed)
    }
}

/// Lists of the caps stage: four a light.
#[derive(Default)]
pub(crate) struct Listed {
    counts: Vec<u32>,
    pub(crate) lists: Vec<Vec<u32>>,
    /// Which lights have near caps.
    pub(crate) capped: Vec<bool>,
}

/// A scene with positions that are not finite and lights in the caster's box, in buffers; and what is excluded at random.
fn random_stage(random: &mut Random, number: usize, lights: usize) -> (Scene, (u32, u32), ShadowShape, Vec<u32>) {
    let mut scene = scene(random, number, lights);
    let (_, positions, mesh) = &mut scene.caster;
    let spoiled = [0, 0, 6, 1][random.below(4)];
    spoil(random, positions, spoiled);
    for light in scene.lights.iter_mut().step_by(8) {
        let [a, b] = [0, 1].map(|_| positions[random.below(positions.len())]);
        let middle: [f32; 3] = std::array::from_fn(|axis| f32::midpoint(a[axis], b[axis]));
        if middle.iter().all(|coordinate| coordinate.is_finite()) {
            *light = Light::point(middle);
        }
    }
    let layout = LAYOUTS[random.below(3)];
    let shape = ShadowShape {
        counting: [COUNT_AUTO, COUNT_AUTO, COUNT_ZP_PLUS, COUNT_Z_FAIL, COUNT_Z_PASS][random.below(5)],
        cull_by_view: random.below(2) as u32,
        proxies: u32::from(random.below(3) == 0),
        ..shape(mesh, lights)
    };
    let excluded = (0..mesh.faces().len() * lights.div_ceil(32)).map(|_| 1 << random.below(64).min(31)).collect();
    (scene, layout, shape, excluded)
}

/// Choices are goldens; `tests/shadow/choice.rs` and `tests/shadow/margins` say whether they are right. Lists of caps
/// have the faces that cast; which of the near caps there are is a golden, too.
fn choose_and_caps() -> Result<(), String> {
    const GOLDENS: usize = 24;
    let (gpu, mut random) = Gpu::seeded(102)?;
    let (mut listed, mut skipped, mut z_pass, mut excluded, mut seen_through) = (0, 0, 0, 0, 0);
    for number in 0..if is_long() { 1000 } else { GOLDENS } {
        let (scene, layout, shape, masks) = random_stage(&mut random, number, [70, 33, 1][number % 3]);
        let staged = Staged::new(&gpu, &scene, layout, shape, masks)?;
        let (name, (_, positions, mesh)) = (&scene.name, &scene.caster);
        let twisted = [0, 0, random.next_u64() as u32][random.below(3)];
        let (lights, statistics) = staged.choose(&gpu, twisted)?;
        let counted = |is: fn(&ShadowLight) -> bool| lights.iter().filter(|light| is(light)).count() as u32;
        let expected = ShadowStatistics {
            skipped: counted(|light| light.casting == CAST_NOTHING),
            every_face: counted(|light| light.casting == CAST_EVERY),
            ended: counted(|light| light.end > 0.0),
            ..statistics
        };
        same(&format!("{name}, statistics"), &[statistics], &[expected])?;
        let mut all = staged.caps(&gpu, &lights, shape.faces)?;
        if number < GOLDENS {
            let chosen = lights.iter().flat_map(|light| [light.casting, light.counting, light.excludes]);
            let words: Vec<u32> = chosen.chain(bytemuck::cast_slice(&[statistics]).iter().copied()).collect();
            golden("shadow", &format!("counting_methods {number}"), &words)?;
            golden("shadow", &format!("caps {number}"), &[all.counts.clone(), all.lists.concat()].concat())?;
        }
        let in_depth = shape.proxies == 0;
        seen_through += usize::from(!in_depth);
        let candidates = |masks: &[u32]| -> Vec<Vec<u32>> {
            let of = |light| sides::caps(mesh, positions, light, [&staged.facing, masks], in_depth);
            lights.iter().enumerate().flat_map(of).collect()
        };
        let most = candidates(&staged.excluded);
        let every = candidates(&vec![0; staged.excluded.len()]);
        excluded += most.chunks(4).zip(every.chunks(4)).filter(|(most, every)| most != every).count();
        let check = |lists: &[Vec<u32>]| {
            let is_right = |(number, (list, most)): (usize, (&Vec<u32>, &Vec<u32>))| {
                if number % 4 < 2 { list.iter().all(|face| most.contains(face)) } else { list == most }
            };
            let wrong = lists.iter().zip(&most).enumerate().find(|&list| !is_right(list));
            wrong.map_or(Ok(()), |wrong| Err(format!("{name}: list and what casts: {wrong:?}")))
        };
        check(&all.lists)?;
        let counts: Vec<_> = all.lists.iter().map(|list| list.len() as u32).collect();
        same(&format!("{name}, counts"), &all.counts, &counts)?;
        let capped: Vec<bool> = counts.chunks(4).map(|counts| counts[0] + counts[1] > 0).collect();
        same(&format!("{name}, near caps"), &all.capped, &capped)?;
        let short = staged.caps(&gpu, &lights, 7)?;
        same(&format!("{name}, counts of short lists"), &short.counts, &counts)?;
        // Two lists that overflow their run write over each other.
        for (lists, all) in short.lists.chunks(2).zip(all.lists.chunks(2)) {
            let whole = all.concat();
            let fits = whole.len() <= 7;
            let is_listed = lists.iter().flatten().all(|face| whole.contains(face));
            if !is_listed || (fits && lists != all) {
                return Err(format!("{name}: short lists are {lists:?}, all are {all:?}"));
            }
        }
        listed += all.lists.iter().filter(|list| !list.is_empty()).count();
        skipped += counted(|light| light.casting == CAST_NOTHING);
        z_pass += counted(|light| light.casting != CAST_NOTHING && light.counting == COUNT_Z_PASS);
        if let Some(list) = all.lists.iter_mut().skip(2).step_by(4).find(|list| !list.is_empty()) {
            list.pop();
            must_fail("a missing cap face", &check(&all.lists))?;
        }
    }
    println!("{listed} lists with faces, {skipped} lights skipped, {z_pass} by z-pass, {excluded} with excluded faces");
    println!("{seen_through} casters that are not in the depth buffer");
    if seen_through < 4 {
        return Err("too few of a kind".to_owned());
    }
    if listed.min(excluded).min(skipped.min(z_pass) as usize) < 20 {
        Err("too few of a kind".to_owned())
    } else {
        Ok(())
    }
}

fn by_edge(list: &[u32]) -> Vec<u32> {
    let mut list = list.to_vec();
    list.sort_by_key(|entry| entry & !cpu::WINDING);
    list
}

/// With lists that fit and overflow, silhouettes that are listed and not, and faces excluded at random: the sides of each edge
/// record are those that its faces sum to.
fn list_sides() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(108)?;
    let stage = Dispatch::stage(&gpu, &LIST_SIDES);
    let (mut entries, mut by_exclusion, mut short) = (0, 0, 0);
    for (name, _, mesh) in topologies() {
        let (faces, packed) = (mesh.faces().len(), mesh.edges().packed_faces());
        for round in 0..if is_long() { 40 } else { 4 } {
            let count: usize = [70, 33, 32, 1][round % 4];
            let masks = |random: &mut Random, rare: bool| -> Vec<u32> {
                let mask =
                    |_| random.below(1 << 32) as u32 & if rare { random.below(1 << 32) as u32 } else { u32::MAX };
                (0..faces * count.div_ceil(32)).map(mask).collect()
            };
            let (facing, excluded) = (masks(&mut random, false), masks(&mut random, round % 2 == 0));
            let counts = mesh.edges().counts();
            let casting = if counts.boundary + counts.inconsistent == 0 { 3 } else { 2 };
            let lights: Vec<_> = (0..count)
                .map(|_| ShadowLight {
                    casting: [CAST_NOTHING, CAST_EVERY, CAST_BACK_FACING][random.below(casting)],
                    excludes: random.below(2) as u32,
                    counting: [COUNT_Z_PASS, COUNT_ZP_PLUS][random.below(2)],
                    ..bytemuck::Zeroable::zeroed()
                })
                .collect();
            let silhouettes = cpu::edges(mesh.edges(), &facing, faces, count, Threads::ONE);
            let silhouettes: Vec<Vec<u32>> = (0..count)
                .map(|light| listed(&silhouettes[light / 32 * packed.len()..][..packed.len()], light as u32 % 32))
                .collect();
            let capped: Vec<bool> = (0..count).map(|_| random.below(3) > 0).collect();
            let masks = [&facing[..], &excluded[..]];
            let expected: Vec<[Vec<u32>; 2]> = (0..)
                .zip(&lights)
                .zip(&capped)
                .map(|(light, &capped)| sides::lists(&mesh, light, masks, capped))
                .collect();
            let most = |lists: &[Vec<u32>; 2]| lists[0].len() + lists[1].len();
            let longest = expected.iter().map(most).max().unwrap_or(0).max(1);
            let capacity = [longest, longest.div_ceil(2)][random.below(2)];
            let room = [packed.len(), 5][random.below(2)];
            let shape = ShadowShape { capacity: room as u32, side_capacity: capacity as u32, ..shape(&mesh, count) };
            let shape = uniform(&gpu, &shape);
            let chosen = gpu.storage(&table(&mesh, LAYOUTS[0], &lights, &capped));
            let (edge_faces, zeros) = (gpu.storage(packed), gpu.storage(&[0_u32, 0, 0, 1, 0]));
            for (batch, expected) in expected.chunks(32).enumerate() {
                let light = 32 * batch as u32;
                let draw = uniform(&gpu, &ShadowDraw { light, first_light: light, view: 0, count_batch: 0 });
                let mut raw = vec![u32::MAX; 32 * room];
                for (list, raw) in silhouettes[32 * batch..].iter().zip(raw.chunks_mut(room)) {
                    // The stage must not depend on the entries of a list that overflowed.
                    let listed = list.len().min(room);
                    raw[..listed].copy_from_slice(&list[..listed]);
                }
                let plane = |masks: &[u32]| gpu.storage(&masks[batch * faces..][..faces]);
                let mut counts = vec![0; 33];
                for (count, list) in counts.iter_mut().zip(&silhouettes[32 * batch..]).take(32) {
                    *count = list.len() as u32;
                }
                let counts = gpu.storage(&counts);
                let (raw, facing, excluded) = (gpu.storage(&raw), plane(&facing), plane(&excluded));
                let sides = gpu.storage(&vec![0_u32; 64 + 32 * capacity]);
                let buffers = [&shape, &draw, &chosen, &counts, &raw, &edge_faces, &facing, &excluded, &sides, &zeros];
                stage.run_over(&gpu, &buffers, [1 + round as u32 % 3, expected.len() as u32])?;
                let sides: Vec<u32> = gpu.read(&sides, usize::MAX)?;
                for (at, (lists, expected)) in sides[64..].chunks(capacity).zip(expected).enumerate() {
                    let what = format!("{name}, round {round}, batch {batch}, light {at}");
                    let counts = &sides[2 * at..][..2];
                    let lengths = [expected[0].len(), expected[1].len()];
                    same(&format!("{what}, counts"), counts, &lengths.map(|length| length as u32))?;
                    if most(expected) > capacity {
                        short += 1;
                        continue;
                    }
                    let number = 32 * batch + at;
                    let mut found = [by_edge(&lists[..lengths[0]]), by_edge(&lists[capacity - lengths[1]..])];
                    same(&what, &found, expected)?;
                    entries += most(expected);
                    if let Some(entry) = found.iter_mut().flatten().next() {
                        *entry ^= cpu::WINDING;
                        let light = &lights[number];
                        by_exclusion += usize::from(light.excludes == 1 && light.casting == CAST_EVERY);
                        must_fail("a turned side", &same(&what, &found, expected))?;
                    }
                }
            }
        }
    }
    println!("{entries} sides, {by_exclusion} lists of every face with some excluded, {short} lists too short");
    if entries.min(by_exclusion).min(short) < 100 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// Instances of the draws of a light: of plain and clipped sides, near caps, and far ones.
pub(crate) fn instances(draws: &ShadowDraws) -> [u32; 6] {
    let ShadowDraws { plain, clipped, near_front, near_back, far_front, far_back, .. } = draws;
    [plain, clipped, near_front, near_back, far_front, far_back].map(|draw| draw.instance_count)
}

/// The same from the lengths of the lists. A list that does not fit is drawn from all edges, or all faces. The published ZP+
/// draws three quadrilaterals instead of a side.
pub(crate) fn drawn(shape: &ShadowShape, sides: [u32; 2], caps: [u32; 4]) -> [u32; 6] {
    let of = |lists: [u32; 2], capacity: u32, all: u32| {
        lists.map(|length| if lists[0] + lists[1] > capacity { all * length.min(1) } else { length })
    };
    let [plain, clipped] = of(sides, shape.side_capacity, 2 * shape.edges);
    let [near_front, near_back] = of([caps[0], caps[1]], shape.near_capacity, shape.faces);
    let [far_front, far_back] = of([caps[2], caps[3]], shape.far_capacity, shape.faces);
    let quads = if shape.counting == COUNT_ZP_PLUS_2005 { 3 } else { 1 };
    [plain, quads * clipped, near_front, near_back, far_front, far_back]
}

fn shadow_arguments() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(103)?;
    let stage = Dispatch::stage(&gpu, &SHADOW_ARGUMENTS);
    let (_, _, mesh) = topologies().swap_remove(0);
    for round in 0..20 {
        let count = [1, 32, 70, 200][round % 4];
        let counting = [COUNT_AUTO, COUNT_ZP_PLUS_2005][round / 4 % 2];
        let (near_capacity, far_capacity) = (50, [50, 1][round % 2]);
        let proxies = u32::from(round % 3 == 1);
        let shape = ShadowShape { near_capacity, far_capacity, counting, proxies, ..shape(&mesh, count) };
        let mut number = || [0, 0, 1, 49, 50, 51, 999, 1000, 1001, 5000][random.below(10)];
        let sides: Vec<[u32; 2]> = (0..count).map(|_| [number(), number()]).collect();
        let caps: Vec<[u32; 4]> = (0..count).map(|_| [number(), number(), number(), number()]).collect();
        let draws = gpu.storage(&vec![u32::MAX; size_of::<ShadowDraws>() / 4 * count]);
        let statistics = gpu.storage(&[0_u32; size_of::<ShadowStatistics>() / 4]);
        let shape_buffer = uniform(&gpu, &shape);
        for (batch, (sides, caps)) in (0..).zip(sides.chunks(32).zip(caps.chunks(32))) {
            let draw = ShadowDraw { light: 32 * batch, first_light: 32 * batch, view: 0, count_batch: 0 };
            let (mut side_counts, mut cap_counts) = ([[7_u32; 2]; 32], [[7_u32; 4]; 32]);
            side_counts[..sides.len()].copy_from_slice(sides);
            cap_counts[..caps.len()].copy_from_slice(caps);
            let (draw, sides, caps) = (uniform(&gpu, &draw), gpu.storage(&side_counts), gpu.storage(&cap_counts));
            stage.run(&gpu, &[&shape_buffer, &draw, &sides, &caps, &draws, &statistics], 1)?;
        }
        let found: Vec<ShadowDraws> = gpu.read(&draws, count)?;
        let statistics: Vec<u32> = gpu.read(&statistics, usize::MAX)?;
        golden("shadow", &format!("shadow_arguments {round}"), &[bytemuck::cast_slice(&found), &statistics].concat())?;
        for ((draws, sides), caps) in found.iter().zip(&sides).zip(&caps) {
            same(&format!("round {round}, instances"), &instances(draws), &drawn(&shape, *sides, *caps))?;
        }
    }
    Ok(())
}
