//! The dispatches of a scene's stages, with the buffers that they bind.

use wgpu::BindingResource;

use super::buffers::{Buffers, GroupBuffers, LISTS_HEAD, WORK_WORDS};
use super::structure::{GroupBatch, Making, Structure};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::{DispatchLimits, binding, loops_of};
use crate::gpu::common::pass::{Dispatch, Pass};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, Program};
use crate::gpu::common::positions::bound;
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::entry;
use crate::gpu::shadow;
use crate::layout::{DrawShape, ExtractionStatistics, LANES, SceneDispatch};
use crate::method::Predicate;
use crate::stages::{ARGUMENTS, CHUNKS, CLUSTERS, REACH, SCENE_EDGES, SCENE_EXACT_FACING, SCENE_FACING, Stage};
use crate::turns::{SCENE_ITEMS, scene_exact_items};

/// The number of invocations in a workgroup of `reach` and of exact facing.
const SMALL_WORKGROUP: u64 = 64;

/// The number of faces that an invocation of exact facing takes in turn if every face is undecided. See
/// ARCHITECTURE.md, "Exact facing is a direct dispatch".
fn exact_turns(device: &wgpu::Device, lights: u32) -> u64 {
    if device.adapter_info().device_type == wgpu::DeviceType::Cpu { scene_exact_items(lights).into() } else { 4 }
}

/// The programs of these passes, in their order.
pub(crate) fn programs(predicate: Predicate) -> Vec<Program> {
    let mut programs: Vec<_> = [&REACH, &CLUSTERS, &CHUNKS].map(|stage| Program::of(stage, &[])).into();
    programs.push(facing(predicate));
    programs.extend((predicate == Predicate::Exact).then(|| Program::of(&SCENE_EXACT_FACING, &[])));
    programs.extend([&SCENE_EDGES, &ARGUMENTS].map(|stage| Program::of(stage, &[])));
    programs
}

fn facing(predicate: Predicate) -> Program {
    let plane = ("PLANE", f64::from(u8::from(predicate.is_plane())));
    let exact = ("EXACT", f64::from(u8::from(predicate == Predicate::Exact)));
    Program::of(&SCENE_FACING, &[plane, exact])
}

/// The passes of a scene, in order. There are none without casters or lights.
#[derive(Debug, Default)]
pub(crate) struct Passes(Vec<Pass>);

impl Passes {
    /// The passes of a structure.
    ///
    /// # Errors
    /// [`DeviceError::BufferRefused`] if a caller destroyed the buffer of a caster.
    pub(crate) fn new(making: &Making<'_>, structure: &Structure) -> Result<Self, DeviceError> {
        let device = making.pipelines.device();
        let limits = &DispatchLimits::new(&device.limits());
        bound(device, || Binder { pipelines: making.pipelines, structure, making, limits }.passes())
    }

    /// Records the extraction. The encoder has uploaded the table.
    pub(crate) fn record(
        &self,
        structure: &Structure,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut StageTimer>,
    ) {
        let Structure { parts, buffers, given, .. } = structure;
        if parts.is_empty() {
            return;
        }
        encoder.clear_buffer(&buffers.work, 0, Some(4 * WORK_WORDS * parts.len() as u64));
        encoder.clear_buffer(&buffers.statistics, 0, None);
        for ((part, given), buffers) in parts.iter().zip(given).zip(buffers.groups.iter().flatten()) {
            // Elsewhere `facing` begins with none.
            let is_given = structure.layout.groups.get(part.group).is_some_and(|group| group.is_given);
            match given {
                Some(given) => encoder.copy_buffer_to_buffer(given, 0, &buffers.excluded, 0, part.sizes.masks),
                None if is_given => encoder.clear_buffer(&buffers.excluded, 0, Some(part.sizes.masks)),
                None => {}
            }
        }
        Pass::record_all(&self.0, encoder, 0..structure.batches, timer);
    }
}

/// Makes the passes of a structure.
struct Binder<'a> {
    pipelines: &'a Pipelines,
    structure: &'a Structure,
    making: &'a Making<'a>,
    limits: &'a DispatchLimits,
}

/// The size of what a stage walks along, for a group and batch.
#[derive(Clone, Copy)]
enum Items {
    FaceChunks,
    EdgeChunks,
    Faces,
    Edges,
}

type Resources<'a> = Vec<(&'static str, BindingResource<'a>)>;

impl<'a> Binder<'a> {
    fn passes(&self) -> Passes {
        if self.structure.parts.is_empty() {
            return Passes::default();
        }
        let Making { options, views, has_receivers, .. } = *self.making;
        let predicate = options.predicate();
        let mut programs = programs(predicate);
        if views > 0 {
            programs.extend(shadow::stages::programs(true, &options.volumes(has_receivers)));
        }
        self.pipelines.make_together(&programs);
        let facing = self.pipelines.get(&facing(predicate));
        let mut passes = vec![
            self.reach(),
            self.walk(self.stage(&CLUSTERS), Items::FaceChunks, |part| self.clusters(part)),
            self.walk(self.stage(&CHUNKS), Items::EdgeChunks, |part| self.chunks(part)),
            self.walk(facing, Items::Faces, |part| self.facing(part)),
        ];
        if predicate == Predicate::Exact {
            passes.push(self.exact_facing());
        }
        passes.push(self.walk(self.stage(&SCENE_EDGES), Items::Edges, |part| self.edges(part)));
        passes.push(self.arguments());
        Passes(passes)
    }

    fn stage(&self, stage: &'static Stage) -> Pipeline {
        self.pipelines.get(&Program::of(stage, &[]))
    }

    fn dispatch(&self, pipeline: &Pipeline, resources: &Resources<'_>, offset: u32, workgroups: u64) -> Dispatch {
        let group = Some(pipeline.bind(self.pipelines.device(), resources));
        let workgroups = workgroups.min(self.limits.workgroups) as u32;
        Dispatch { group, offsets: vec![offset], workgroups, ..Dispatch::over(0, 0..0, 0) }
    }

    /// A thread for each caster and batch, of all groups at once.
    fn reach(&self) -> Pass {
        let pipeline = self.stage(&REACH);
        let pairs = self.structure.layout.order.len() * self.structure.batches;
        let Buffers { lit, taken, .. } = &self.structure.buffers;
        let resources = self.versions(&[("lit", lit), ("taken", taken)]);
        let workgroups = (pairs as u64).div_ceil(SMALL_WORKGROUP);
        let rows = workgroups.div_ceil(self.limits.workgroups).clamp(1, self.limits.workgroups) as u32;
        let dispatch = self.dispatch(&pipeline, &resources, 0, workgroups);
        Pass { pipeline, dispatches: vec![Dispatch { rows, ..dispatch }] }
    }

    /// A dispatch of a stage for each group and batch.
    fn walk(&self, pipeline: Pipeline, items: Items, resources: impl Fn(&GroupBatch) -> Option<Resources<'a>>) -> Pass {
        let mut dispatches = Vec::new();
        for part in &self.structure.parts {
            let Some(group) = self.structure.layout.groups.get(part.group) else { continue };
            let count = match items {
                Items::FaceChunks => group.face_chunks,
                Items::EdgeChunks => group.edge_chunks,
                Items::Faces => LANES * group.face_chunks,
                Items::Edges => LANES * group.edge_chunks,
            };
            let Some(resources) = resources(part) else { continue };
            let workgroups = loops_of(self.pipelines.device(), count, SCENE_ITEMS);
            dispatches.push(self.dispatch(&pipeline, &resources, part.offset, workgroups.into()));
        }
        Pass { pipeline, dispatches }
    }

    fn exact_facing(&self) -> Pass {
        let pipeline = self.stage(&SCENE_EXACT_FACING);
        let dispatch = |part: &GroupBatch| {
            let slots = u64::from(self.structure.layout.groups.get(part.group)?.face_slots());
            let resources = self.faces(part)?;
            let turns = exact_turns(self.pipelines.device(), part.lights);
            Some(self.dispatch(&pipeline, &resources, part.offset, slots.div_ceil(SMALL_WORKGROUP * turns)))
        };
        let dispatches = self.structure.parts.iter().filter_map(dispatch).collect();
        Pass { pipeline, dispatches }
    }

    fn arguments(&self) -> Pass {
        let pipeline = self.stage(&ARGUMENTS);
        let dispatch = |part: &GroupBatch| {
            let buffers = self.of(part)?;
            let resources = vec![
                ("shape", entry::<DrawShape>(&self.structure.shapes)),
                ("counts", binding(&buffers.lists, 0..LISTS_HEAD)),
                ("draw_arguments", buffers.draws.as_entire_binding()),
                ("statistics", binding(&buffers.record, 0..size_of::<ExtractionStatistics>() as u64)),
            ];
            Some(self.dispatch(&pipeline, &resources, part.shape, 1))
        };
        let dispatches = self.structure.parts.iter().filter_map(dispatch).collect();
        Pass { pipeline, dispatches }
    }

    fn of(&self, part: &GroupBatch) -> Option<&'a GroupBuffers> {
        self.structure.buffers.groups.get(part.group)?.get(part.batch)
    }

    /// The bindings that all stages of the scene but `arguments` have.
    fn common(&self) -> Resources<'a> {
        let Structure { table, uniforms, .. } = self.structure;
        vec![("group", entry::<SceneDispatch>(uniforms)), ("table", table.as_entire_binding())]
    }

    /// The bindings of stages that find what changed, with these lights of casters.
    fn versions(&self, lights: &[(&'static str, &'a wgpu::Buffer)]) -> Resources<'a> {
        let mut resources = self.with_work(self.common());
        let Buffers { kept, statistics, .. } = &self.structure.buffers;
        let named = lights.iter().copied().chain([("kept", kept), ("statistics", statistics)]);
        resources.extend(named.map(|(name, buffer)| (name, buffer.as_entire_binding())));
        resources
    }

    /// The clusters of a group's page.
    fn cluster_words(&self, part: &GroupBatch) -> Option<(&'static str, BindingResource<'a>)> {
        let (page, _) = self.structure.source(self.making, part.group)?;
        Some(("cluster_words", page.clusters.as_entire_binding()))
    }

    fn clusters(&self, part: &GroupBatch) -> Option<Resources<'a>> {
        let mut resources = self.versions(&[("taken", &self.structure.buffers.taken)]);
        resources.push(self.cluster_words(part)?);
        Some(resources)
    }

    fn chunks(&self, part: &GroupBatch) -> Option<Resources<'a>> {
        let buffers = self.of(part)?;
        let mut resources = self.versions(&[("lit", &self.structure.buffers.lit)]);
        resources.extend([
            self.cluster_words(part)?,
            ("list_counts", binding(&buffers.lists, 0..LISTS_HEAD)),
            ("record", binding(&buffers.record, 0..part.sizes.record)),
        ]);
        Some(resources)
    }

    /// Adds the binding of stages that write or read the lists of chunks.
    fn with_work(&self, mut resources: Resources<'a>) -> Resources<'a> {
        resources.push(("work", self.structure.buffers.work.as_entire_binding()));
        resources
    }

    /// The bindings that both facing stages have.
    fn faces(&self, part: &GroupBatch) -> Option<Resources<'a>> {
        let (page, source) = self.structure.source(self.making, part.group)?;
        let buffers = self.of(part)?;
        let mut resources = self.common();
        let positions = match &source.buffer {
            Some(bound) => binding(&bound.buffer, bound.range.clone()),
            None => page.positions.as_entire_binding(),
        };
        resources.extend([
            ("taken", self.structure.buffers.taken.as_entire_binding()),
            ("positions", positions),
            ("faces", page.faces.as_entire_binding()),
            ("facing_masks", binding(&buffers.facing, 0..part.sizes.masks)),
            ("excluded_masks", binding(&buffers.excluded, 0..part.sizes.masks)),
            ("record", binding(&buffers.record, 0..part.sizes.record)),
        ]);
        Some(resources)
    }

    fn facing(&self, part: &GroupBatch) -> Option<Resources<'a>> {
        Some(self.with_work(self.faces(part)?))
    }

    fn edges(&self, part: &GroupBatch) -> Option<Resources<'a>> {
        let (page, _) = self.structure.source(self.making, part.group)?;
        let buffers = self.of(part)?;
        let mut resources = self.with_work(self.common());
        resources.extend([
            // Lists that are made anew have all casters.
            ("taken", self.structure.buffers.lit.as_entire_binding()),
            ("facing_masks", binding(&buffers.facing, 0..part.sizes.masks)),
            ("edge_faces", page.edge_faces.as_entire_binding()),
            ("lists", binding(&buffers.lists, 0..part.sizes.lists)),
        ]);
        Some(resources)
    }
}
