//! The dispatches of a scene's stages, with the buffers that they bind.

use super::buffers::{Buffers, LISTS_HEAD, WORK_WORDS};
use super::structure::{GroupBatch, Inputs, PolygonCaster, Structure};
use crate::gpu::common::bindings::{Resource, part, uniform, whole};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::{DispatchLimits, exact_workgroups, loops_of};
use crate::gpu::common::pass::{Step, Workgroups};
use crate::gpu::common::pipelines::Program;
use crate::gpu::common::positions::{BoundPositions, bound};
use crate::gpu::extract::of_scene::PolygonPart;
use crate::gpu::shadow;
use crate::layout::{CHUNK, DrawShape, ExtractionStatistics, LANES, SceneDispatch};
use crate::mesh::EdgeCounts;
use crate::method::Predicate;
use crate::stages::{ARGUMENTS, CHUNKS, CLUSTERS, CULL_LIGHTS, SCENE_EDGES, SCENE_EXACT_FACING, SCENE_FACING};
use crate::turns::{SCENE_ITEMS, scene_exact_items};

/// The number of invocations in a workgroup of `cull_lights`.
const SMALL_WORKGROUP: u64 = 64;

/// The items of a stage, for a group and batch.
#[derive(Clone, Copy)]
enum Items {
    /// An invocation for each caster and batch, of all groups at once.
    Pairs,
    FaceChunks,
    EdgeChunks,
    Faces,
    Edges,
    /// The undecided faces.
    Undecided,
    /// One workgroup.
    One,
}

impl Items {
    /// Whether polygons have other stages for it.
    fn is_of_triangles(self) -> bool {
        matches!(self, Self::Faces | Self::Undecided | Self::Edges)
    }
}

/// The stages in their order, with their items.
fn stages(predicate: Predicate) -> Vec<(Program, Items)> {
    let switch = |is_on: bool| f64::from(u8::from(is_on));
    let is_exact = predicate == Predicate::Exact;
    let plain = |stage| Program::of(stage, &[]);
    let facing = [("PLANE", switch(predicate.is_plane())), ("EXACT", switch(is_exact))];
    let mut stages = vec![
        (plain(&CULL_LIGHTS), Items::Pairs),
        (plain(&CLUSTERS), Items::FaceChunks),
        (plain(&CHUNKS), Items::EdgeChunks),
        (Program::of(&SCENE_FACING, &facing), Items::Faces),
    ];
    stages.extend(is_exact.then(|| (plain(&SCENE_EXACT_FACING), Items::Undecided)));
    stages.extend([(plain(&SCENE_EDGES), Items::Edges), (plain(&ARGUMENTS), Items::One)]);
    stages
}

/// The programs of these stages, in their order.
pub(crate) fn programs(predicate: Predicate) -> Vec<Program> {
    stages(predicate).into_iter().map(|(program, _)| program).collect()
}

/// The steps of a structure, for after the upload of its table. There are none without casters or lights.
///
/// # Errors
/// [`DeviceError::Refused`] if a caller destroyed the buffer of a caster.
pub(crate) fn steps(inputs: &Inputs<'_>, structure: &Structure) -> Result<Vec<Step>, DeviceError> {
    let Inputs { pipelines, options, views, .. } = *inputs;
    let (device, predicate) = (pipelines.device(), options.predicate());
    let Some(first) = structure.parts.first() else { return Ok(Vec::new()) };
    let mut programs = programs(predicate);
    if views > 0 {
        let has_pieces = structure.layout.groups.iter().any(|group| group.polygons.is_some());
        programs.extend(shadow::stages::programs(has_pieces, options));
    }
    pipelines.make_together(&programs);
    let limits = &DispatchLimits::new(&device.limits());
    let binder = Binder { device, structure, inputs, limits };
    let mut steps = clears(structure);
    bound(device, || {
        for (program, items) in stages(predicate) {
            let pipeline = pipelines.get(&program);
            let parts = if let Items::Pairs = items { std::slice::from_ref(first) } else { &structure.parts };
            if pipeline.label == ARGUMENTS.name {
                for part in parts.iter().filter(|part| part.sizes.polygons.is_some()) {
                    steps.extend(binder.polygons(part).transpose()?.unwrap_or_default());
                }
            }
            let dispatch = |part: &GroupBatch| {
                pipeline.dispatch(device, binder.workgroups(items, part), |name| binder.get(pipeline.label, name, part))
            };
            let parts = parts.iter().filter(|part| !items.is_of_triangles() || part.sizes.polygons.is_none());
            steps.push(pipeline.pass(parts.map(dispatch)));
        }
        Ok(steps)
    })?
}

/// Clears counts and statistics, and writes the masks of faces that callers exclude.
fn clears(structure: &Structure) -> Vec<Step> {
    let Structure { parts, buffers, exclusions, .. } = structure;
    let counts = Step::Clear(buffers.work.clone(), 0..4 * WORK_WORDS * parts.len() as u64);
    let mut steps = vec![counts, Step::clear(&buffers.statistics)];
    for ((part, masks), buffers) in parts.iter().zip(exclusions).zip(buffers.groups.iter().flatten()) {
        // In groups without exclusions `facing` clears the masks.
        let excludes = structure.layout.groups.get(part.group).is_some_and(|group| group.excludes);
        let (excluded, bytes) = (buffers.excluded.clone(), part.sizes.masks);
        match masks {
            Some(masks) => steps.push(Step::Copy([(masks.clone(), 0), (excluded, 0)], bytes)),
            None if excludes => steps.push(Step::Clear(excluded, 0..bytes)),
            None => {}
        }
    }
    steps
}

/// Binds the stages of a structure.
struct Binder<'a> {
    device: &'a wgpu::Device,
    structure: &'a Structure,
    inputs: &'a Inputs<'a>,
    limits: &'a DispatchLimits,
}

impl<'a> Binder<'a> {
    fn workgroups(&self, items: Items, part: &GroupBatch) -> Workgroups {
        let most = self.limits.workgroups;
        let chunks = self.structure.layout.groups.get(part.group).map(|group| (group.face_chunks, group.edge_chunks));
        let (faces, edges) = chunks.unwrap_or_default();
        let in_turn = |items: u32| u64::from(loops_of(self.device, items, SCENE_ITEMS));
        let (count, rows) = match items {
            Items::Pairs => {
                let pairs = self.structure.layout.order.len() * self.structure.batches;
                let workgroups = (pairs as u64).div_ceil(SMALL_WORKGROUP);
                (workgroups, workgroups.div_ceil(most).clamp(1, most) as u32)
            }
            Items::FaceChunks => (in_turn(faces), 1),
            Items::EdgeChunks => (in_turn(edges), 1),
            Items::Faces => (in_turn(LANES * faces), 1),
            Items::Edges => (in_turn(LANES * edges), 1),
            Items::Undecided => {
                (exact_workgroups(self.device, CHUNK * faces, scene_exact_items(part.lights)).into(), 1)
            }
            Items::One => (1, 1),
        };
        Workgroups::Known([count.min(most) as u32, rows])
    }

    /// The extraction of the polygons of a group.
    fn polygons(&self, group_batch: &GroupBatch) -> Option<Result<Vec<Step>, DeviceError>> {
        let Self { structure, inputs, limits, .. } = self;
        let &GroupBatch { group, batch, ref sizes, lights, .. } = group_batch;
        let buffers = structure.buffers.groups.get(group)?.get(batch)?;
        let of_polygons = buffers.polygons.as_ref()?;
        let (page, source) = structure.source(inputs.content, group)?;
        let PolygonCaster { mesh, offset_words, stride_words, .. } = structure.polygons(inputs.content, group)?;
        let (positions, range) = source.bound_positions(page);
        // One binding holds them, so this is no error.
        let windows = limits.windows("positions", range.end - range.start).ok()?;
        let layout = structure.layout.groups.get(group)?;
        let EdgeCounts { consistent, inconsistent, boundary } = layout.counts;
        let part = PolygonPart {
            mesh,
            faces: layout.face_slots(),
            edges: (consistent + inconsistent + boundary) as u32,
            lights,
            capacity: sizes.capacity,
            polygons: sizes.polygons?,
            topology: [&page.faces, &page.edge_vertices, &page.edge_faces],
            positions: (positions, BoundPositions { base: range.start, windows, offset_words, stride_words }),
            given: structure.exclusions.get(group * structure.batches + batch)?.as_ref(),
            light_batch: &of_polygons.lights,
            facing: &buffers.facing,
            excluded: &buffers.excluded,
            record: &buffers.record,
            lists: (&buffers.lists, LISTS_HEAD),
            undecided: &of_polygons.undecided,
            arguments: &of_polygons.arguments,
            pieces: &of_polygons.pieces,
        };
        Some(part.steps(inputs.pipelines))
    }

    fn get(&self, stage: &str, name: &str, group_batch: &GroupBatch) -> Option<Resource<'a>> {
        let Structure { table, uniforms, shapes, buffers, .. } = self.structure;
        let Buffers { relevant_lights, active_lights, cache, work, statistics, .. } = buffers;
        let &GroupBatch { group, batch, ref sizes, offset, shape, .. } = group_batch;
        let of_group = buffers.groups.get(group)?.get(batch)?;
        let (page, source) = self.structure.source(self.inputs.content, group)?;
        Some(match name {
            "group" => uniform::<SceneDispatch>(uniforms, offset),
            "shape" => uniform::<DrawShape>(shapes, shape),
            "table" => whole(table),
            "work" => whole(work),
            "relevant_lights" => whole(relevant_lights),
            // A dirty list has the edges of all casters.
            "active_lights" if stage == SCENE_EDGES.name => whole(relevant_lights),
            "active_lights" => whole(active_lights),
            "cache" => whole(cache),
            "statistics" if stage == ARGUMENTS.name => {
                part(&of_group.record, 0..size_of::<ExtractionStatistics>() as u64)
            }
            "statistics" => whole(statistics),
            "cluster_words" => whole(&page.clusters),
            "positions" => source.positions(page),
            "faces" => whole(&page.faces),
            "edge_faces" => whole(&page.edge_faces),
            "facing_masks" => part(&of_group.facing, 0..sizes.masks),
            "excluded_masks" => part(&of_group.excluded, 0..sizes.masks),
            "record" => part(&of_group.record, 0..sizes.record),
            "lists" => part(&of_group.lists, 0..sizes.lists),
            "list_counts" | "counts" => part(&of_group.lists, 0..LISTS_HEAD),
            "draw_arguments" => whole(&of_group.draws),
            _ => return None,
        })
    }
}
