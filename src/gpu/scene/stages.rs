//! The dispatches of a scene's stages, with the buffers that they bind.

use super::buffers::{Buffers, GroupBuffers, LISTS_HEAD, PolygonBuffers, WORK_WORDS};
use super::sources::GroupTopology;
use super::structure::{GroupBatch, Inputs, Structure};
use crate::gpu::common::bindings::{Resource, part, uniform, whole};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::{DispatchLimits, exact_workgroups, loops_of};
use crate::gpu::common::pass::{Step, Workgroups};
use crate::gpu::common::pipelines::Program;
use crate::gpu::common::positions::{BoundPositions, bound};
use crate::gpu::extract::buffers::Shape;
use crate::gpu::extract::of_scene::polygon_steps;
use crate::gpu::{extract, shadow};
use crate::layout::{CHUNK, DrawShape, ExtractionStatistics, LANES, SceneDispatch};
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

/// The stages in their order, with their items.
fn stages() -> [(Program, Items); 7] {
    [
        (&CULL_LIGHTS, Items::Pairs),
        (&CLUSTERS, Items::FaceChunks),
        (&CHUNKS, Items::EdgeChunks),
        (&SCENE_FACING, Items::Faces),
        (&SCENE_EXACT_FACING, Items::Undecided),
        (&SCENE_EDGES, Items::Edges),
        (&ARGUMENTS, Items::One),
    ]
    .map(|(stage, items)| (Program::of(stage, &[]), items))
}

/// The programs of these stages, in their order.
pub(crate) fn programs() -> Vec<Program> {
    stages().into_iter().map(|(program, _)| program).collect()
}

/// The steps of a structure, for after the upload of its table. There are none without casters or lights.
///
/// # Errors
/// [`DeviceError::BufferRefused`] if a caller destroyed the buffer of a caster.
pub(crate) fn steps(inputs: &Inputs<'_>, structure: &Structure) -> Result<Vec<Step>, DeviceError> {
    let Inputs { pipelines, options, room, .. } = *inputs;
    let device = pipelines.device();
    let Some(first) = structure.parts.first() else { return Ok(Vec::new()) };
    let mut programs = programs();
    if room.views > 0 {
        let has_pieces = structure.layout.groups.iter().any(|group| group.polygons.is_some());
        programs.extend(shadow::stages::programs(has_pieces, options));
    }
    pipelines.make_together(&programs);
    let binder = Binder::new(inputs, structure);
    let mut steps = clears(structure);
    bound(device, || {
        for (program, items) in stages() {
            let pipeline = pipelines.get(&program);
            let parts = if let Items::Pairs = items { std::slice::from_ref(first) } else { &structure.parts };
            if pipeline.label == ARGUMENTS.name {
                for part in parts.iter().filter(|part| part.sizes.polygons.is_some()) {
                    steps.extend(binder.polygons(part).transpose()?.unwrap_or_default());
                }
            }
            let dispatch = |part| {
                pipeline.dispatch(device, binder.workgroups(items, part), |name| binder.get(pipeline.label, name, part))
            };
            // Groups of polygons have other stages for these items.
            let is_of_triangles = matches!(items, Items::Faces | Items::Undecided | Items::Edges);
            let parts = parts.iter().filter(|part| !is_of_triangles || part.sizes.polygons.is_none());
            steps.push(pipeline.pass(parts.map(dispatch)));
        }
        Ok(steps)
    })?
}

/// Clears counts and statistics, and writes the masks of faces that callers exclude.
fn clears(structure: &Structure) -> Vec<Step> {
    let Structure { parts, buffers, .. } = structure;
    let counts = Step::Clear(buffers.work.clone(), 0..4 * WORK_WORDS * parts.len() as u64);
    let mut steps = vec![counts, Step::clear(&buffers.statistics)];
    // The extraction of polygons clears their masks. Nobody excludes polygons.
    for part in parts.iter().filter(|part| part.sizes.polygons.is_none()) {
        // In groups without exclusions `facing` clears the masks.
        let excludes = structure.layout.groups.get(part.group).is_some_and(|group| group.excludes);
        let (excluded, bytes) = (part.buffers.excluded.clone(), part.sizes.masks);
        match &part.exclusions {
            Some(masks) => steps.push(Step::Copy([(masks.clone(), 0), (excluded, 0)], bytes)),
            None if excludes => steps.push(Step::Clear(excluded, 0..bytes)),
            None => {}
        }
    }
    steps
}

/// Binds the stages of a structure.
pub(crate) struct Binder<'a> {
    device: &'a wgpu::Device,
    structure: &'a Structure,
    inputs: &'a Inputs<'a>,
    limits: DispatchLimits,
}

impl<'a> Binder<'a> {
    pub(crate) fn new(inputs: &'a Inputs<'a>, structure: &'a Structure) -> Self {
        let device = inputs.pipelines.device();
        Self { device, structure, inputs, limits: DispatchLimits::new(&device.limits()) }
    }

    fn workgroups(&self, items: Items, part: &GroupBatch) -> Workgroups {
        let most = self.limits.workgroups;
        let SceneDispatch { face_chunks: faces, edge_chunks: edges, .. } = part.dispatch;
        let in_turn = |items: u32| u64::from(loops_of(self.device, items, SCENE_ITEMS));
        let (count, rows) = match items {
            Items::Pairs => {
                let pairs = self.structure.layout.order.len() * self.structure.buffers.batches;
                let workgroups = (pairs as u64).div_ceil(SMALL_WORKGROUP);
                (workgroups, workgroups.div_ceil(most).clamp(1, most) as u32)
            }
            Items::FaceChunks => (in_turn(faces), 1),
            Items::EdgeChunks => (in_turn(edges), 1),
            Items::Faces => (in_turn(LANES * faces), 1),
            Items::Edges => (in_turn(LANES * edges), 1),
            Items::Undecided => {
                (exact_workgroups(self.device, CHUNK * faces, scene_exact_items(part.sizes.lights)).into(), 1)
            }
            Items::One => (1, 1),
        };
        Workgroups::Known([count.min(most) as u32, rows])
    }

    /// The extraction of the polygons of a group.
    fn polygons(&self, group_batch: &GroupBatch) -> Option<Result<Vec<Step>, DeviceError>> {
        let Self { structure, inputs, limits, .. } = self;
        let &GroupBatch { group, ref sizes, ref buffers, .. } = group_batch;
        let GroupBuffers { facing, excluded, record, lists, polygons, .. } = buffers;
        let PolygonBuffers { lights: light_batch, undecided, arguments, pieces } = polygons.as_ref()?;
        let GroupTopology { page, positions: (positions, range), .. } = structure.topology.get(group)?;
        let caster = structure.first_caster(inputs.content, group)?;
        let [offset_words, stride_words] = caster.position_words();
        // One binding holds them, so this is no error.
        let windows = limits.windows("positions", range.end - range.start).ok()?;
        let bound = BoundPositions { base: range.start, windows, offset_words, stride_words };
        let layout = structure.layout.groups.get(group)?;
        let shape = Shape {
            vertices: 0,
            faces: layout.face_slots() as usize,
            edges: caster.mesh.edges() as usize,
            max_lights: sizes.lights as usize,
            capacity: sizes.capacity,
            lists_head: LISTS_HEAD,
            blocks: 0,
            undecided: 0,
            face_words: 2 * layout.face_slots() as usize,
            polygons: Some(sizes.polygons?),
        };
        let buffers = extract::buffers::Buffers {
            faces: page.faces.clone(),
            edge_vertices: page.edge_vertices.clone(),
            edge_faces: page.edge_faces.clone(),
            edge_corners: None,
            facing: vec![facing.clone()],
            masks: Vec::new(),
            lists: vec![lists.clone()],
            excluded: vec![excluded.clone()],
            record: record.clone(),
            block_offsets: arguments.clone(),
            counts: lists.clone(),
            draw_arguments: arguments.clone(),
            polygons: Some(caster.mesh.polygons.as_ref()?.buffers([undecided, arguments, pieces])),
            light_batches: light_batch.clone(),
            chunks: arguments.clone(),
            draw_shape: arguments.clone(),
            statistics: arguments.clone(),
            unused: arguments.clone(),
        };
        Some(polygon_steps(inputs.pipelines, &shape, buffers, (positions, &bound)))
    }

    /// The resource that a stage binds by this name. Stages and draws of shadow volumes have it here, too.
    pub(crate) fn get(&self, stage: &str, name: &str, group_batch: &'a GroupBatch) -> Option<Resource<'a>> {
        let Structure { table, uniforms, shapes, buffers, .. } = self.structure;
        let Buffers { relevant_lights, active_lights, cache, work, statistics, .. } = buffers;
        let &GroupBatch { group, ref sizes, buffers: ref of_group, offset, shape, .. } = group_batch;
        let GroupTopology { page, positions: (positions, range), .. } = self.structure.topology.get(group)?;
        let extraction_statistics = || part(&of_group.record, 0..size_of::<ExtractionStatistics>() as u64);
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
            "statistics" if stage == ARGUMENTS.name => extraction_statistics(),
            "statistics" => whole(statistics),
            "extraction_statistics" => extraction_statistics(),
            "cluster_words" => whole(&page.clusters),
            "positions" => part(positions, range.clone()),
            "faces" => whole(&page.faces),
            "edge_vertices" => whole(&page.edge_vertices),
            "edge_faces" => whole(&page.edge_faces),
            "facing_masks" => part(&of_group.facing, 0..sizes.masks),
            "excluded_masks" => part(&of_group.excluded, 0..sizes.masks),
            "record" => part(&of_group.record, 0..sizes.record),
            "lists" => part(&of_group.lists, 0..sizes.lists),
            "list_counts" | "counts" | "silhouette_counts" => part(&of_group.lists, 0..LISTS_HEAD),
            "silhouettes" => part(&of_group.lists, LISTS_HEAD..sizes.lists),
            "pieces" => part(&of_group.polygons.as_ref()?.pieces, 0..sizes.pieces()),
            "draw_arguments" => whole(&of_group.draws),
            _ => return None,
        })
    }
}
