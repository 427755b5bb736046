//! Results of a frame, read back from its buffers, and a comparison of each caster with its results alone.

use glam::{DMat3, DVec3};
use rimline::Mesh;
use rimline::gpu::{CasterHandle, ExtractionStatistics, SceneFrame, SceneResults, SceneStatistics};
use rimline::internals::clusters::EdgeOrder;
use rimline::internals::cpu;
use rimline::internals::layout::{CHUNK, DrawArguments};
use rimline::internals::scene::SceneTable;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::same;

use crate::random_scene::{Content, Expected, Own, Placed};

/// Results of a frame, read back from its buffers.
pub(crate) struct Found {
    pub(crate) table: Vec<[u32; 4]>,
    pub(crate) lit: Vec<u32>,
    pub(crate) taken: Vec<u32>,
    pub(crate) statistics: SceneStatistics,
    pub(crate) groups: Vec<GroupFound>,
}

/// Where a bit of a caster's first face is, for a light that reaches it.
pub(crate) struct LitFace {
    /// The number of the caster in the frame.
    pub(crate) caster: usize,
    /// Position in [`Found::groups`].
    pub(crate) group: usize,
    pub(crate) slot: usize,
    pub(crate) bit: u32,
}

pub(crate) struct GroupFound {
    pub(crate) group: usize,
    pub(crate) batch: usize,
    pub(crate) facing: Vec<u32>,
    pub(crate) excluded: Vec<u32>,
    /// For each light of the batch.
    pub(crate) counts: Vec<u32>,
    pub(crate) lists: Vec<Vec<u32>>,
    pub(crate) capacity: u32,
    pub(crate) edge_slots: u32,
    pub(crate) draws: Vec<DrawArguments>,
    pub(crate) statistics: ExtractionStatistics,
    /// Faces that facing left to exact facing.
    pub(crate) undecided: u32,
}

impl Found {
    pub(crate) fn read(gpu: &Gpu, frame: &SceneFrame) -> Result<Self, String> {
        Self::of(gpu, &frame.results().map_err(text)?)
    }

    pub(crate) fn of(gpu: &Gpu, results: &SceneResults<'_>) -> Result<Self, String> {
        let mut found = Self {
            table: gpu.read(results.table, usize::MAX)?,
            lit: gpu.read(results.relevant_lights, usize::MAX)?,
            taken: gpu.read(results.active_lights, usize::MAX)?,
            statistics: gpu.read(results.statistics, 1)?.remove(0),
            groups: Vec::new(),
        };
        for group in &results.groups {
            let words: Vec<u32> = gpu.read(group.lists, usize::MAX)?;
            let (counts, lists) = sorted_lists(&words, group.capacity);
            let record: Vec<u32> = gpu.read(group.record, 6)?;
            found.groups.push(GroupFound {
                group: group.group,
                batch: group.batch,
                facing: gpu.read(group.facing, (CHUNK * group.dispatch.face_chunks) as usize)?,
                excluded: gpu.read(group.excluded, (CHUNK * group.dispatch.face_chunks) as usize)?,
                counts,
                lists,
                capacity: group.capacity,
                edge_slots: CHUNK * group.dispatch.edge_chunks,
                draws: gpu.read(group.draws, 32)?,
                statistics: *bytemuck::from_bytes(bytemuck::cast_slice(&record[..5])),
                undecided: record[5],
            });
        }
        Ok(found)
    }

    /// The first face of a caster that a light of the first batch reaches.
    pub(crate) fn lit_face(&self, content: &Content, frame: &SceneFrame) -> Option<LitFace> {
        let places = content.casters.iter().filter_map(|own| frame.locate(own.handle));
        let (index, group) = places.into_iter().find(|(index, _)| self.lit[*index as usize] != 0)?;
        Some(LitFace {
            caster: index as usize,
            group: self.groups.iter().position(|found| (found.group, found.batch) == (group, 0))?,
            slot: SceneTable(&self.table).caster(index).first_face_slot as usize,
            bit: 1 << self.lit[index as usize].trailing_zeros(),
        })
    }

    pub(crate) fn group(&self, group: usize, batch: usize) -> Result<&GroupFound, String> {
        let found = self.groups.iter().find(|found| (found.group, found.batch) == (group, batch));
        found.ok_or_else(|| format!("no results of group {group}, batch {batch}"))
    }
}

/// Whether the light certainly reaches the caster: a corner of a face is within its range.
fn certainly_reaches(content: &Content, own: &Own, bit: u32) -> bool {
    let Some((_, light)) = content.lights.iter().find(|(handle, _)| handle.bit() == bit) else { return false };
    let is_boxed = matches!(own.placed, Placed::Rigid(_)) || own.bounds.is_some();
    if !is_boxed || !light.range.is_finite() || light.w == 0.0 {
        return true;
    }
    let (case, _) = &content.meshes[own.mesh];
    let (_, rest, mesh) = &**case;
    let placed = |vertex: u32| match &own.placed {
        Placed::World(world) => world[vertex as usize].map(f64::from),
        Placed::Rigid(rows) => {
            let position = rest[vertex as usize].map(f64::from);
            rows.map(|row| {
                let [a, b, c, d] = row.map(f64::from);
                a * position[0] + b * position[1] + c * position[2] + d
            })
        }
    };
    let squares = mesh.faces().iter().flatten().map(|&vertex| {
        let placed = placed(vertex);
        (0..3).map(|axis| (placed[axis] - f64::from(light.xyz[axis]) / f64::from(light.w)).powi(2)).sum::<f64>()
    });
    squares.fold(f64::MAX, f64::min).sqrt() <= f64::from(light.range) * (1.0 - 1e-5)
}

/// Whether the light is clearly out of range of a rigid caster whose matrix is a rotation times a scale.
fn certainly_beyond(content: &Content, own: &Own, bit: u32) -> bool {
    let Some((_, light)) = content.lights.iter().find(|(handle, _)| handle.bit() == bit) else { return false };
    let Placed::Rigid(rows) = &own.placed else { return false };
    let column = |at: usize| DVec3::from(rows.map(|row| f64::from(row[at])));
    let matrix = DMat3::from_cols(column(0), column(1), column(2));
    let scale = column(0).length();
    let is_turned = (matrix.transpose() * matrix - DMat3::from_diagonal(DVec3::splat(scale * scale)))
        .to_cols_array()
        .iter()
        .all(|off| off.abs() < 1e-5 * scale * scale);
    let w = f64::from(light.w);
    let place = matrix.inverse() * (DVec3::from(light.xyz.map(f64::from)) / w - column(3));
    let (mesh, positions) = content.mesh_and_positions(own);
    let is_finite = |face: &&[u32; 3]| face.iter().all(|&vertex| cpu::is_finite(positions[vertex as usize]));
    let corners = mesh.faces().iter().filter(is_finite).flatten();
    let corners = corners.map(|&vertex| DVec3::from(positions[vertex as usize].map(f64::from)));
    let ends = corners.map(|p| [p, p]).reduce(|[low, high], [p, _]| [low.min(p), high.max(p)]);
    let Some([low, high]) = ends.filter(|_| is_turned && light.range.is_finite() && w.abs() > 1e-6) else {
        return false;
    };
    let size = place.abs().max(low.abs()).max(high.abs()).max_element();
    let distance = scale * (place - place.clamp(low, high)).length();
    size < 1e8 && distance > 1.003 * f64::from(light.range) + 1e-3 * scale * size
}

/// Counts of pairs of a scene, for tests that must not be vacuous.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) lit: u32,
    /// Lit pairs whose bits are those of an earlier frame.
    pub(crate) kept: u32,
    pub(crate) out_of_range: u32,
    /// Pairs that are clearly out of range.
    pub(crate) beyond: u32,
    pub(crate) silhouettes: usize,
    pub(crate) in_planes: u32,
}

impl Tally {
    pub(crate) fn add(&mut self, other: &Self) {
        self.lit += other.lit;
        self.kept += other.kept;
        self.out_of_range += other.out_of_range;
        self.beyond += other.beyond;
        self.silhouettes += other.silhouettes;
        self.in_planes += other.in_planes;
    }
}

/// The lights that matter to a caster, a word for each batch. None that certainly reaches it may be missing.
fn lit_of(
    content: &Content,
    own: &Own,
    found: &Found,
    index: u32,
    batches: usize,
    tally: &mut Tally,
) -> Result<Vec<u32>, String> {
    let casters = content.casters.len();
    let lit: Vec<u32> = (0..batches).map(|batch| found.lit[batch * casters + index as usize]).collect();
    for bit in 0..32 * batches as u32 {
        let is_lit = lit[bit as usize / 32] >> (bit % 32) & 1 != 0;
        let is_allowed = content.own_light(own, bit).is_some();
        if is_lit && !is_allowed {
            return Err(format!("light {bit} is not allowed for caster {index}, and it matters"));
        }
        if is_allowed && !is_lit && certainly_reaches(content, own, bit) {
            return Err(format!("light {bit} reaches caster {index}, and it does not matter"));
        }
        let is_beyond = is_allowed && certainly_beyond(content, own, bit);
        if is_lit && is_beyond {
            return Err(format!("light {bit} does not reach caster {index}, and it matters"));
        }
        tally.beyond += u32::from(is_beyond);
        tally.lit += u32::from(is_lit);
        tally.out_of_range += u32::from(is_allowed && !is_lit);
    }
    Ok(lit)
}

/// The face of each face slot of a caster, and the record of each edge slot.
pub(crate) type SlotOrder = [Vec<u32>; 2];

/// `None`: slots have the order of the mesh.
pub(crate) fn slot_order(frame: &SceneFrame, caster: CasterHandle, mesh: &Mesh) -> Option<SlotOrder> {
    let faces = frame.slot_order(caster)?.to_vec();
    let records = EdgeOrder::new(mesh.edges(), &faces).records().to_vec();
    Some([faces, records])
}

/// Masks of face slots in the order of the mesh.
pub(crate) fn in_order(order: Option<&SlotOrder>, masks: &[u32]) -> Vec<u32> {
    let Some([faces, _]) = order else { return masks.to_vec() };
    let mut sorted = vec![u32::MAX; masks.len()];
    for (&face, &mask) in faces.iter().zip(masks) {
        sorted[face as usize] = mask;
    }
    sorted
}

/// Entries of edge slots, counted from the first of their caster, as entries of edge records, in order.
pub(crate) fn records(order: Option<&SlotOrder>, mut list: Vec<u32>) -> Vec<u32> {
    if let Some([_, records]) = order {
        for entry in &mut list {
            *entry = records[(*entry & !cpu::WINDING) as usize] | *entry & cpu::WINDING;
        }
        list.sort_by_key(|entry| entry & !cpu::WINDING);
    }
    list
}

/// Compares one caster's part of the results.
fn check_caster(
    found: &Found,
    (index, group): (u32, usize),
    order: Option<&SlotOrder>,
    lit: &[u32],
    expected: &Expected,
) -> Result<usize, String> {
    let caster = SceneTable(&found.table).caster(index);
    let faces = caster.first_face_slot as usize..(caster.first_face_slot + caster.faces) as usize;
    let edges = caster.first_edge_slot..caster.first_edge_slot + caster.edges;
    let mut silhouettes = 0;
    for (batch, &lit) in lit.iter().enumerate().filter(|(_, lit)| **lit != 0) {
        let results = found.group(group, batch)?;
        let what = format!("caster {index}, batch {batch}");
        // Bits of other lights have no meaning.
        let of_lit = |masks: &[u32]| masks.iter().map(|mask| mask & lit).collect::<Vec<_>>();
        let [facing, excluded] =
            [&results.facing, &results.excluded].map(|masks| in_order(order, &of_lit(&masks[faces.clone()])));
        same(&format!("{what}, facing"), &facing, &of_lit(&expected.facing[batch]))?;
        same(&format!("{what}, lights in planes"), &excluded, &of_lit(&expected.excluded[batch]))?;
        for bit in 0..32 {
            let own = |entry: &&u32| edges.contains(&(**entry & !cpu::WINDING));
            let list: Vec<u32> = results.lists[bit].iter().filter(own).map(|entry| entry - edges.start).collect();
            let list = records(order, list);
            let is_lit = lit >> bit & 1 != 0;
            let expected = &expected.lists[32 * batch + bit];
            same(&format!("{what}, list {bit}"), &list, if is_lit { expected } else { &[] })?;
            silhouettes += list.len();
        }
    }
    Ok(silhouettes)
}

/// Compares a whole frame. Returns what it came to.
pub(crate) fn check_frame(content: &Content, frame: &SceneFrame, found: &Found) -> Result<Tally, String> {
    let mut tally = Tally::default();
    let batches = frame.batches();
    let mut non_finite = 0;
    for own in &content.casters {
        let (index, group) = frame.locate(own.handle).ok_or("the frame lacks a caster")?;
        let lit = if batches == 0 { Vec::new() } else { lit_of(content, own, found, index, batches, &mut tally)? };
        let expected = content.alone(own, &lit)?;
        let (mesh, positions) = content.mesh_and_positions(own);
        let order = slot_order(frame, own.handle, mesh);
        tally.silhouettes += check_caster(found, (index, group), order.as_ref(), &lit, &expected)?;
        tally.in_planes += expected.excluded.iter().flatten().map(|mask| mask.count_ones()).sum::<u32>();
        let is_finite = |face: &&[u32; 3]| face.iter().all(|&vertex| cpu::is_finite(positions[vertex as usize]));
        let taken = |batch: usize| found.taken[batch * content.casters.len() + index as usize];
        for (batch, lit) in lit.iter().enumerate() {
            if taken(batch) & !lit != 0 {
                return Err(format!("caster {index}, batch {batch}: lights that do not matter are taken"));
            }
            tally.kept += (lit & !taken(batch)).count_ones();
        }
        if (0..batches).any(|batch| taken(batch) != 0) {
            non_finite += mesh.faces().len() - mesh.faces().iter().filter(is_finite).count();
        }
    }
    let total: usize = found.groups.iter().flat_map(|group| &group.lists).map(Vec::len).sum();
    same("silhouette edges of all casters", &[total], &[tally.silhouettes])?;
    let counted: u32 = found.groups.iter().map(|group| group.statistics.non_finite_faces).sum();
    same("faces that are not finite", &[counted], &[non_finite as u32])?;
    if batches > 0 && !content.casters.is_empty() {
        let SceneStatistics { pairs, cached_pairs, pairs_culled_by_range, .. } = found.statistics;
        let expected = [tally.lit, tally.kept, tally.out_of_range];
        same("pairs, those kept, and those out of range", &[pairs, cached_pairs, pairs_culled_by_range], &expected)?;
    }
    for group in &found.groups {
        let draws: Vec<u32> = group.draws.iter().map(|draw| draw.instance_count).collect();
        same("draws", &draws, &group.counts)?;
    }
    Ok(tally)
}

/// The counts of a batch's lists, and the entries, in the order of the slots.
pub(crate) fn sorted_lists(words: &[u32], capacity: u32) -> (Vec<u32>, Vec<Vec<u32>>) {
    let (counts, entries) = words.split_at(64);
    let (counts, _) = counts.split_at(32);
    let capacity = capacity as usize;
    let list = |(light, &count): (usize, &u32)| {
        let list = entries.iter().skip(light * capacity).take(capacity.min(count as usize));
        let mut list: Vec<u32> = list.copied().collect();
        list.sort_by_key(|entry| entry & !cpu::WINDING);
        list
    };
    (counts.to_vec(), counts.iter().enumerate().map(list).collect())
}
