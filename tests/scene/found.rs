//! Results of a frame, read back from its buffers, and a comparison of each caster with its results alone.

use glam::{DMat3, DVec3};
use rimline::gpu::{CasterHandle, ExtractionStatistics, SceneFrame, SceneResults, SceneStatistics};
use rimline::internals::clusters::edge_order;
use rimline::internals::cpu;
use rimline::internals::layout::{CHUNK, DrawArguments, SceneCaster};
use rimline::internals::scene::SceneTable;
use rimline::{Cone, Light, Matrix3x4, Mesh};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::same;

use crate::cones::inside;
use crate::random_scene::{Content, Expected, Placed, RandomScene, TestCaster};

/// Results of a frame, read back from its buffers.
pub(crate) struct Found {
    pub(crate) table: Vec<[u32; 4]>,
    /// The relevant lights of each batch and caster, and the active ones.
    pub(crate) relevant: Vec<u32>,
    pub(crate) active: Vec<u32>,
    pub(crate) statistics: SceneStatistics,
    pub(crate) groups: Vec<GroupFound>,
}

/// The first face of a caster, and a relevant light.
pub(crate) struct LitFace {
    /// The index of the caster in the frame.
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
    /// Lights with a dirty list.
    pub(crate) dirty: u32,
}

impl Found {
    pub(crate) fn read(gpu: &Gpu, frame: &SceneFrame) -> Result<Self, String> {
        Self::of(gpu, &frame.results().map_err(text)?)
    }

    pub(crate) fn of(gpu: &Gpu, results: &SceneResults<'_>) -> Result<Self, String> {
        let mut found = Self {
            table: gpu.read(results.table, usize::MAX)?,
            relevant: gpu.read(results.relevant_lights, usize::MAX)?,
            active: gpu.read(results.active_lights, usize::MAX)?,
            statistics: gpu.read(results.statistics, 1)?.remove(0),
            groups: Vec::new(),
        };
        let work: Vec<u32> = gpu.read(results.work, usize::MAX)?;
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
                dirty: work[group.dispatch.work_count as usize + 2],
            });
        }
        Ok(found)
    }

    /// A caster with a relevant light in the first batch.
    pub(crate) fn lit_face(&self, content: &Content, frame: &SceneFrame) -> Option<LitFace> {
        let mut located = content.casters.iter().filter_map(|caster| frame.locate(caster.handle));
        let (index, group) = located.find(|(index, _)| self.relevant[*index as usize] != 0)?;
        Some(LitFace {
            caster: index as usize,
            group: self.groups.iter().position(|found| (found.group, found.batch) == (group, 0))?,
            slot: SceneTable(&self.table).caster(index).first_face_slot as usize,
            bit: 1 << self.relevant[index as usize].trailing_zeros(),
        })
    }

    pub(crate) fn group(&self, group: usize, batch: usize) -> Result<&GroupFound, String> {
        let found = self.groups.iter().find(|found| (found.group, found.batch) == (group, batch));
        found.ok_or_else(|| format!("no results of group {group}, batch {batch}"))
    }
}

/// A position in world space, in `f64`.
fn in_world(caster: &TestCaster, rest: &[[f32; 3]], vertex: u32) -> DVec3 {
    match &caster.placed {
        Placed::World(world) => DVec3::from(world[vertex as usize].map(f64::from)),
        Placed::Rigid(rows) => {
            let position = DVec3::from(rest[vertex as usize].map(f64::from));
            DVec3::from(rows.map(|row| {
                let [a, b, c, d] = row.map(f64::from);
                DVec3::new(a, b, c).dot(position) + d
            }))
        }
    }
}

/// Whether the caster must be relevant: a corner of a face is within the light's range, and one is in its cone.
fn certainly_affects(content: &Content, caster: &TestCaster, light: Light) -> bool {
    let is_boxed = matches!(caster.placed, Placed::Rigid(_)) || caster.bounds.is_some();
    if !is_boxed || light.w == 0.0 {
        return true;
    }
    let (_, rest, mesh) = &*content.meshes[caster.mesh].0;
    let corners = || mesh.faces().iter().flatten().map(|&vertex| in_world(caster, rest, vertex));
    let apex = DVec3::from(light.xyz.map(f64::from)) / f64::from(light.w);
    let least = || corners().map(|corner| corner.distance(apex)).fold(f64::MAX, f64::min);
    let is_in_range = !light.range.is_finite() || least() <= f64::from(light.range) * (1.0 - 1e-5);
    // Faces that are not finite are in no box.
    let is_finite = |face: &&[u32; 3]| face.iter().all(|&vertex| cpu::is_finite(rest[vertex as usize]));
    let finite = || mesh.faces().iter().filter(is_finite).flatten().map(|&vertex| in_world(caster, rest, vertex));
    is_in_range && light.cone.is_none_or(|cone| finite().any(|corner| inside(cone, apex, corner) > 0.0))
}

/// Why a rigid caster must be culled, by more than rounding: it is out of range, or beside the cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Culled {
    ByRange,
    ByCone,
}

/// By the box for ranges, and for cones by a ball around the box that the caster's matrix moves.
pub(crate) fn certainly_culled(content: &Content, caster: &TestCaster, light: Light) -> Option<Culled> {
    let Placed::Rigid(rows) = &caster.placed else { return None };
    let (mesh, positions) = content.mesh_and_positions(caster);
    let is_finite = |face: &&[u32; 3]| face.iter().all(|&vertex| cpu::is_finite(positions[vertex as usize]));
    let corners = mesh.faces().iter().filter(is_finite).flatten();
    let corners = corners.map(|&vertex| DVec3::from(positions[vertex as usize].map(f64::from)));
    let [low, high] = corners.map(|p| [p, p]).reduce(|[low, high], [p, _]| [low.min(p), high.max(p)])?;
    let apex = DVec3::from(light.xyz.map(f64::from)) / f64::from(light.w);
    // The box around the moved box, and the largest term of its coordinates.
    let [x, y, z] = rows.map(|row| DVec3::from([0, 1, 2].map(|column| f64::from(row[column]))));
    let moved = |p: DVec3| DVec3::new(x.dot(p), y.dot(p), z.dot(p));
    let shift = DVec3::from(rows.map(|row| f64::from(row[3])));
    let away = moved(0.5 * (low + high)) + shift - apex;
    let radius = DVec3::from([x, y, z].map(|row| row.abs().dot(0.5 * (high - low)))).length();
    let terms = [x, y, z].map(|row| row.abs().dot(low.abs().max(high.abs())));
    let size = (DVec3::from(terms) + shift.abs()).max(apex.abs()).max_element();
    let beyond = |distance: f64| distance > 1.001 * radius + 1e-3 * size;
    let angle = |cone: Cone| {
        let axis = DVec3::from(cone.axis.map(f64::from)).normalize();
        away.normalize().dot(axis).clamp(-1.0, 1.0).acos() - f64::from(cone.cosine).acos()
    };
    let is_beside = |cone| beyond(away.length() * angle(cone).clamp(0.0, std::f64::consts::FRAC_PI_2).sin());
    if light.w.abs() < 1e-6 {
        None
    } else if light.range.is_finite() && is_out_of_range(rows, [low, high], apex, light.range) {
        Some(Culled::ByRange)
    } else {
        light.cone.filter(|&cone| (1e-6..1e15).contains(&size) && is_beside(cone)).map(|_| Culled::ByCone)
    }
}

/// Whether a box that the matrix moves is clearly out of range. The matrix must be a rotation times a scale.
fn is_out_of_range(rows: &Matrix3x4, [low, high]: [DVec3; 2], apex: DVec3, range: f32) -> bool {
    let column = |index: usize| DVec3::from(rows.map(|row| f64::from(row[index])));
    let matrix = DMat3::from_cols(column(0), column(1), column(2));
    let scale = column(0).length();
    let gram = matrix.transpose() * matrix - DMat3::from_diagonal(DVec3::splat(scale * scale));
    let is_turned = gram.to_cols_array().iter().all(|off| off.abs() < 1e-5 * scale * scale);
    let position = matrix.inverse() * (apex - column(3));
    let size = position.abs().max(low.abs()).max(high.abs()).max_element();
    let distance = scale * (position - position.clamp(low, high)).length();
    is_turned && size < 1e8 && distance > 1.003 * f64::from(range) + 1e-3 * scale * size
}

/// Counts of pairs of caster and light, for tests that must not be vacuous.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) relevant: u32,
    /// Relevant pairs whose bits are those of an earlier frame.
    pub(crate) cached: u32,
    /// Pairs that are culled by range or cone.
    pub(crate) culled: u32,
    /// Pairs that must be culled by range, and by cone.
    pub(crate) certain: [u32; 2],
    pub(crate) silhouettes: usize,
    pub(crate) in_planes: u32,
}

impl Tally {
    pub(crate) fn add(&mut self, other: &Self) {
        self.relevant += other.relevant;
        self.cached += other.cached;
        self.culled += other.culled;
        self.certain = [0, 1].map(|rule| self.certain[rule] + other.certain[rule]);
        self.silhouettes += other.silhouettes;
        self.in_planes += other.in_planes;
    }
}

/// The relevant lights of a caster, a word for each batch. No light that certainly affects it may be culled, and none may be
/// relevant that must be culled.
fn relevant_lights(
    content: &Content,
    caster: &TestCaster,
    found: &Found,
    index: u32,
    batches: usize,
    tally: &mut Tally,
) -> Result<Vec<u32>, String> {
    let casters = content.casters.len();
    let relevant: Vec<u32> = (0..batches).map(|batch| found.relevant[batch * casters + index as usize]).collect();
    for bit in 0..32 * batches as u32 {
        let is_relevant = relevant[bit as usize / 32] >> (bit % 32) & 1 != 0;
        let light = content.lights.iter().find(|(handle, _)| handle.bit() == bit).map(|(_, light)| *light);
        let Some(light) = light.filter(|_| content.moved_light(caster, bit).is_some()) else {
            if is_relevant {
                return Err(format!("light {bit} is relevant to caster {index}, which does not allow it"));
            }
            continue;
        };
        if !is_relevant && certainly_affects(content, caster, light) {
            return Err(format!("light {bit} affects caster {index}, and is culled: {light:?}"));
        }
        let culled = certainly_culled(content, caster, light);
        if is_relevant && let Some(rule) = culled {
            return Err(format!("light {bit} is not culled for caster {index} {rule:?}: {light:?}"));
        }
        if let Some(rule) = culled {
            tally.certain[rule as usize] += 1;
        }
        tally.relevant += u32::from(is_relevant);
        tally.culled += u32::from(!is_relevant);
    }
    Ok(relevant)
}

/// The face of each face slot of a caster, and the record of each edge slot.
pub(crate) type SlotOrder = [Vec<u32>; 2];

/// `None`: slots have the order of the mesh.
pub(crate) fn slot_order(frame: &SceneFrame, caster: CasterHandle, mesh: &Mesh) -> Option<SlotOrder> {
    let faces = frame.slot_order(caster)?.to_vec();
    let records = edge_order(mesh.edges(), &faces);
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

/// Compares one caster's part of the results. Returns the number of its silhouette edges.
fn check_caster(
    found: &Found,
    (index, group): (u32, usize),
    order: Option<&SlotOrder>,
    relevant: &[u32],
    expected: &Expected,
) -> Result<usize, String> {
    let caster = SceneTable(&found.table).caster(index);
    let faces = caster.first_face_slot as usize..(caster.first_face_slot + caster.faces) as usize;
    let mut silhouettes = 0;
    for (batch, &relevant) in relevant.iter().enumerate().filter(|(_, relevant)| **relevant != 0) {
        let results = found.group(group, batch)?;
        let what = format!("caster {index}, batch {batch}");
        // Bits of other lights have no meaning.
        let meaningful = |masks: &[u32]| masks.iter().map(|mask| mask & relevant).collect::<Vec<_>>();
        let [facing, excluded] =
            [&results.facing, &results.excluded].map(|masks| in_order(order, &meaningful(&masks[faces.clone()])));
        same(&format!("{what}, facing"), &facing, &meaningful(&expected.facing[batch]))?;
        same(&format!("{what}, lights in planes"), &excluded, &meaningful(&expected.excluded[batch]))?;
        for bit in 0..32 {
            let list = records(order, entries_of(&caster, &results.lists[bit]));
            let is_relevant = relevant >> bit & 1 != 0;
            let expected = &expected.lists[32 * batch + bit];
            same(&format!("{what}, list {bit}"), &list, if is_relevant { expected } else { &[] })?;
            silhouettes += list.len();
        }
    }
    Ok(silhouettes)
}

/// The entries of a caster in a list, counted from its first edge slot.
pub(crate) fn entries_of(caster: &SceneCaster, list: &[u32]) -> Vec<u32> {
    let edges = caster.first_edge_slot..caster.first_edge_slot + caster.edges;
    let is_of_caster = |entry: &&u32| edges.contains(&(**entry & !cpu::WINDING));
    list.iter().filter(is_of_caster).map(|entry| entry - edges.start).collect()
}

/// A frame that was compared with its casters alone.
pub(crate) struct Checked {
    pub(crate) frame: SceneFrame,
    pub(crate) found: Found,
}

/// Encodes, submits and reads a frame.
pub(crate) fn read_frame(gpu: &Gpu, scene: &mut RandomScene) -> Result<(SceneFrame, Found), String> {
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    let found = Found::read(gpu, &frame)?;
    Ok((frame, found))
}

/// The same, and compares it.
pub(crate) fn checked(gpu: &Gpu, scene: &mut RandomScene) -> Result<Checked, String> {
    let (frame, found) = read_frame(gpu, scene)?;
    check_frame(&scene.content, &frame, &found)?;
    Ok(Checked { frame, found })
}

/// Compares a whole frame.
pub(crate) fn check_frame(content: &Content, frame: &SceneFrame, found: &Found) -> Result<Tally, String> {
    let mut tally = Tally::default();
    let batches = frame.batches();
    let [mut non_finite, mut faces, mut edges] = [0; 3];
    for caster in &content.casters {
        let (index, group) = frame.locate(caster.handle).ok_or("the frame lacks a caster")?;
        let relevant = relevant_lights(content, caster, found, index, batches, &mut tally)?;
        let expected = content.alone(caster, &relevant)?;
        let (mesh, positions) = content.mesh_and_positions(caster);
        let order = slot_order(frame, caster.handle, mesh);
        tally.silhouettes += check_caster(found, (index, group), order.as_ref(), &relevant, &expected)?;
        tally.in_planes += expected.excluded.iter().flatten().map(|mask| mask.count_ones()).sum::<u32>();
        let active = |batch: usize| found.active[batch * content.casters.len() + index as usize];
        for (batch, relevant) in relevant.iter().enumerate() {
            if active(batch) & !relevant != 0 {
                return Err(format!("caster {index}, batch {batch}: active lights that are not relevant"));
            }
            tally.cached += (relevant & !active(batch)).count_ones();
            faces += if active(batch) != 0 { mesh.faces().len() } else { 0 };
            edges += if relevant & found.group(group, batch)?.dirty != 0 { mesh.edges().len() } else { 0 };
        }
        if (0..batches).any(|batch| active(batch) != 0) {
            let is_finite = |face: &&[u32; 3]| face.iter().all(|&vertex| cpu::is_finite(positions[vertex as usize]));
            non_finite += mesh.faces().len() - mesh.faces().iter().filter(is_finite).count();
        }
    }
    let total: usize = found.groups.iter().flat_map(|group| &group.lists).map(Vec::len).sum();
    same("silhouette edges of all casters", &[total], &[tally.silhouettes])?;
    let counted: u32 = found.groups.iter().map(|group| group.statistics.non_finite_faces).sum();
    same("faces that are not finite", &[counted], &[non_finite as u32])?;
    if batches > 0 && !content.casters.is_empty() {
        let counted = found.statistics;
        let pairs = [counted.pairs, counted.cached_pairs, counted.pairs_culled_by_range];
        same("relevant, cached and culled pairs", &pairs, &[tally.relevant, tally.cached, tally.culled])?;
        let items = [counted.faces + counted.untested_faces, counted.edges + counted.untested_edges];
        same("faces and edges, tested or not", &items, &[faces as u32, edges as u32])?;
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
