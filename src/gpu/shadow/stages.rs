//! The compute passes before the draws: `bounds`, `counting_methods`, `caps`, `list_sides`, `shadow_arguments`, and
//! four optional ones. And the bind groups of the draws.

use wgpu::BindingResource;

use super::buffers::{SizedBuffers, VolumeBuffers};
use super::draws::LightDraws;
use super::pipelines::{Layouts, layouts};
use super::sizes::{GroupSize, Room, VolumeSizes};
use super::source::{Named, VolumeSource, named};
use crate::gpu::common::bindings::{Resource, part, uniform, whole};
use crate::gpu::common::dispatch_limits::{DispatchLimits, loops};
use crate::gpu::common::pass::{Dispatch, Step, Workgroups, record};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, Program, group};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::scene::options::SceneOptions;
use crate::layout::{CHUNK, ExtractionStatistics, LANES, PieceDraws, ShadowDraw, ShadowDraws, ShadowShape, ViewLight};
use crate::stages::{
    BOUNDS, CAPS, COUNTING_METHODS, LIST_SIDES, PIECE_ARGUMENTS, PIECE_CROSSINGS, RELIST, SHADOW_ARGUMENTS,
    STENCIL_BOUND, STENCIL_CROSSINGS, STENCIL_PENCIL, ZP_PLUS_2005_CASES,
};
use crate::turns::{BOUND_CHUNKS, LISTED_ITEMS};

/// The items that a stage walks along.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Over {
    /// The faces of each group whose boxes are not known.
    Boxes,
    /// All casters, lights and views in one dispatch.
    Pairs,
    /// For each group, batch and view: one workgroup, also only where there are pieces, or faces, edges, sides, pieces.
    One,
    OneOfPieces,
    Faces,
    Edges,
    Sides,
    Pieces,
    /// For each batch and view a workgroup for each light, for all groups together.
    Lights,
}

/// The stages in their order, and what they walk along. Those from `list_sides` on read the choices in the table.
fn stages(has_pieces: bool, options: &SceneOptions) -> Vec<(Program, Over)> {
    let of = |stage, over| (Program::of(stage, &[]), over);
    let (pieces, bound) = (has_pieces, options.stencil.bound_counts);
    let stages = [
        (true, of(&RELIST, Over::One)),
        (true, of(&BOUNDS, Over::Boxes)),
        (true, of(&COUNTING_METHODS, Over::Pairs)),
        (options.counting.is_zp_plus_2005(), of(&ZP_PLUS_2005_CASES, Over::Edges)),
        (true, of(&CAPS, Over::Faces)),
        (true, of(&LIST_SIDES, Over::Sides)),
        (true, of(&SHADOW_ARGUMENTS, Over::One)),
        (pieces, of(&PIECE_ARGUMENTS, Over::OneOfPieces)),
        (bound, of(&STENCIL_PENCIL, Over::Lights)),
        (bound, of(&STENCIL_CROSSINGS, Over::Sides)),
        (bound && pieces, of(&PIECE_CROSSINGS, Over::Pieces)),
        (bound, of(&STENCIL_BOUND, Over::Lights)),
    ];
    stages.into_iter().filter(|(is_there, _)| *is_there).map(|(_, stage)| stage).collect()
}

/// The programs of these stages, in their order.
pub(crate) fn programs(has_pieces: bool, options: &SceneOptions) -> Vec<Program> {
    stages(has_pieces, options).into_iter().map(|(program, _)| program).collect()
}

/// The pipelines of these stages.
#[derive(Clone, Debug)]
pub(crate) struct StagePipelines {
    device: wgpu::Device,
    layouts: Layouts,
    stages: Vec<(Pipeline, Over)>,
}

impl StagePipelines {
    pub(crate) fn new(pipelines: &Pipelines, has_pieces: bool, options: &SceneOptions) -> Self {
        let stages = stages(has_pieces, options);
        pipelines.make_together(&programs(has_pieces, options));
        Self {
            device: pipelines.device().clone(),
            layouts: layouts(pipelines),
            stages: stages.into_iter().map(|(program, over)| (pipelines.get(&program), over)).collect(),
        }
    }
}

/// The bind groups of the draws of a group of casters.
#[derive(Debug)]
struct GroupDraws {
    /// For each batch of lights: the shape of the group differs.
    frames: Vec<wgpu::BindGroup>,
    /// For each batch one for each view.
    sides: Vec<Vec<wgpu::BindGroup>>,
    caps: Vec<Vec<wgpu::BindGroup>>,
    /// For each batch, of a caster with polygons.
    pieces: Vec<wgpu::BindGroup>,
}

/// The stages and draws of the volumes of some casters, with everything bound.
#[derive(Debug)]
pub(crate) struct VolumeStages {
    steps: Vec<Step>,
    groups: Vec<GroupDraws>,
}

impl VolumeStages {
    /// Binds everything.
    pub(crate) fn new(pipelines: &StagePipelines, buffers: &SizedBuffers, source: &VolumeSource<'_>) -> Self {
        let most = DispatchLimits::new(&pipelines.device.limits()).workgroups;
        let most = u32::try_from(most).unwrap_or(u32::MAX);
        let SizedBuffers { sizes, of, .. } = buffers;
        let binder = Binder { pipelines, sizes, buffers: of, source, most };
        let mut steps = buffers.clears();
        if !sizes.groups.is_empty() {
            steps.extend(binder.steps());
        }
        Self { steps, groups: binder.draws() }
    }

    /// Records the stages for the first `batches` batches of lights, after their extraction.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, batches: usize, timer: Option<&mut StageTimer>) {
        let steps = self.steps.iter().filter(|_| batches > 0);
        record(steps, encoder, 0..batches, timer);
    }

    /// The draws of a light in a view for a batch of casters, for each group.
    pub(crate) fn draws<'a>(
        &'a self,
        buffers: &'a SizedBuffers,
        count_batch: usize,
        view: usize,
        light: usize,
    ) -> impl Iterator<Item = LightDraws<'a>> {
        let SizedBuffers { sizes, of: buffers, .. } = buffers;
        let (batch, view_light) = (light / 32, view * sizes.lights + light);
        let uniform = count_batch * sizes.view_lights() + view_light;
        let groups = self.groups.iter().zip(&buffers.draws).zip(&sizes.groups).zip(&buffers.piece_draws);
        groups.filter_map(move |(((group, draws), size), piece_draws)| {
            Some(LightDraws {
                frame: group.frames.get(batch)?,
                uniform: (uniform * UniformTable::stride::<ShadowDraw>()) as u32,
                view_light: (view_light * size_of::<ViewLight>()) as u32,
                sides: group.sides.get(batch)?.get(view)?,
                caps: group.caps.get(batch)?.get(view)?,
                draws,
                first: (view_light * size_of::<ShadowDraws>()) as u64,
                may_end: sizes.options.end_at_range,
                has_proxies: size.proxies > 0,
                pieces: group.pieces.get(batch).zip(piece_draws.as_ref()),
                first_piece: (view_light * size_of::<PieceDraws>()) as u64,
            })
        })
    }
}

/// The inputs for binding stages and draws.
struct Binder<'a> {
    pipelines: &'a StagePipelines,
    sizes: &'a VolumeSizes,
    buffers: &'a VolumeBuffers,
    source: &'a VolumeSource<'a>,
    /// The most workgroups along an axis.
    most: u32,
}

/// The group of casters, batch of lights and view of a dispatch or draw.
#[derive(Clone, Copy, Default)]
struct Scope {
    group: usize,
    batch: usize,
    view: usize,
}

impl<'a> Binder<'a> {
    /// The index of the group and batch among all.
    fn group_and_batch(&self, scope: Scope) -> usize {
        scope.group * self.sizes.batches() + scope.batch
    }

    /// The resource that stages bind by this name.
    fn get(&self, name: &str, scope: Scope) -> Option<Resource<'a>> {
        let Self { buffers, source, .. } = *self;
        let group = source.groups.get(scope.group)?;
        let batch = group.batches.get(scope.batch)?;
        let lists = || buffers.lists.get(self.group_and_batch(scope))?.get(scope.view);
        // The shape, and the first light of the batch in the view.
        let shape = (self.group_and_batch(scope) * UniformTable::stride::<ShadowShape>()) as u32;
        let light = scope.view * self.sizes.lights + 32 * scope.batch;
        let draw = (light * UniformTable::stride::<ShadowDraw>()) as u32;
        Some(match name {
            "shape" => uniform::<ShadowShape>(&buffers.shapes, shape),
            "draw" => uniform::<ShadowDraw>(&buffers.draw_lights, draw),
            "view_lights" => whole(&buffers.view_lights),
            "table" => whole(source.table),
            "boxes" => whole(&buffers.boxes),
            "twisted_lights" => whole(&buffers.twisted_lights),
            "choices" => whole(&buffers.choices),
            "receivers" => whole(&buffers.receivers),
            "list_versions" => whole(&buffers.list_versions),
            "shadow_statistics" => whole(&buffers.statistics),
            "shadow_draws" => whole(buffers.draws.get(scope.group)?),
            "sides" => whole(&lists()?.sides),
            "caps_listed" => whole(&lists()?.caps),
            "piece_draws" => whole(buffers.piece_draws.get(scope.group)?.as_ref()?),
            "pencils" => whole(&buffers.bound.as_ref()?.pencils),
            "bin_rows" => whole(&buffers.bound.as_ref()?.bin_rows),
            _ => [batch, &group.named, &source.named].into_iter().find_map(|of| named(of, name))?,
        })
    }

    fn dispatch(&self, pipeline: &Pipeline, scope: Scope, [x, y]: [u32; 2]) -> Dispatch {
        let workgroups = Workgroups::Known([x.min(self.most), y]);
        Dispatch {
            batch: scope.batch,
            ..pipeline.dispatch(&self.pipelines.device, workgroups, |name| self.get(name, scope))
        }
    }

    /// The dispatches of a stage, with their workgroups.
    fn dispatches(&self, over: Over) -> Vec<(Scope, [u32; 2])> {
        let VolumeSizes { groups, rooms, casters, views, .. } = self.sizes;
        let device = &self.pipelines.device;
        let batches = self.sizes.batches();
        let numbered = || groups.iter().enumerate();
        match over {
            Over::Boxes => {
                let unknown =
                    numbered().filter(|(group, _)| !self.source.groups.get(*group).is_some_and(|of| of.has_boxes));
                // An invocation takes some 64 faces. So there are few atomics, and all cores have work.
                let workgroups = |size: &GroupSize| {
                    let chunks = size.faces.div_ceil(CHUNK);
                    [chunks.div_ceil(64).clamp(1, 1024).max(chunks.div_ceil(64 * BOUND_CHUNKS)), 1]
                };
                unknown.map(|(group, size)| (Scope { group, ..Scope::default() }, workgroups(size))).collect()
            }
            Over::Pairs => {
                let pairs = u32::try_from(*casters as u64 * self.sizes.used_lights() as u64).unwrap_or(u32::MAX);
                let workgroups = (4 * loops(device, pairs)).min(pairs.div_ceil(64)).min(self.most).max(1);
                groups.iter().take(1).map(|_| (Scope::default(), [workgroups, *views as u32])).collect()
            }
            Over::Lights => {
                let lights = |batch: usize| (self.sizes.lights - 32 * batch).min(32) as u32;
                let batches = (0..batches).filter(|_| !groups.is_empty());
                let scopes = batches.flat_map(|batch| (0..*views).map(move |view| Scope { group: 0, batch, view }));
                scopes.map(|scope| (scope, [lights(scope.batch), 1])).collect()
            }
            _ => {
                let is_of_pieces = matches!(over, Over::Pieces | Over::OneOfPieces);
                let parts = numbered().zip(rooms.chunks(batches.max(1)));
                let parts = parts.filter(|((group, _), _)| !is_of_pieces || self.sizes.group_has_pieces(*group));
                let parts = parts.flat_map(|(group, rooms)| rooms.iter().enumerate().map(move |room| (group, room)));
                let scopes = parts.flat_map(|((group, size), (batch, room))| {
                    let workgroups = self.workgroups_of(over, size, room);
                    (0..*views).map(move |view| (Scope { group, batch, view }, workgroups))
                });
                scopes.collect()
            }
        }
    }

    /// The workgroups of a stage for a group, batch and view.
    fn workgroups_of(&self, over: Over, size: &GroupSize, room: &Room) -> [u32; 2] {
        let StagePipelines { device, .. } = self.pipelines;
        let is_cpu = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        // All edges take few turns.
        let fewest = size.edges.div_ceil(64 * LISTED_ITEMS);
        match over {
            Over::Faces => [loops(device, size.faces.div_ceil(CHUNK) * LANES), 1],
            Over::Edges => [fewest.max(1), room.lights],
            Over::Sides => {
                // An invocation takes some sixteen sides of a list that is full.
                let most = if is_cpu { 64_u32.div_ceil(room.lights).max(4) } else { 256 };
                [room.silhouettes.div_ceil(16 * 64).clamp(1, most).max(fewest), room.lights]
            }
            Over::Pieces => {
                // An invocation takes few pieces of many.
                let fewest = room.pieces.div_ceil(64 * LISTED_ITEMS);
                [if is_cpu { 4 } else { 64 }.max(fewest), room.lights]
            }
            _ => [1, 1],
        }
    }

    /// For each group and batch with polygons, a copy of the lights for which they are twisted to where
    /// `counting_methods` reads them.
    fn twisted(&self) -> Vec<Step> {
        let parts = self.source.groups.iter().flat_map(|group| &group.batches).enumerate();
        let copy = |(part, batch): (usize, &Named<'_>)| {
            named(batch, "pieces")?;
            let BindingResource::Buffer(statistics) = named(batch, "extraction_statistics")?.bound else { return None };
            let from = statistics.offset + std::mem::offset_of!(ExtractionStatistics, twisted_lights) as u64;
            let to = 4 * part as u64;
            Some(Step::Copy([(statistics.buffer.clone(), from), (self.buffers.twisted_lights.clone(), to)], 4))
        };
        parts.filter_map(copy).collect()
    }

    /// The stages, with a copy of the choices to the table before the lists are made.
    fn steps(&self) -> Vec<Step> {
        let mut steps = Vec::new();
        for (pipeline, over) in &self.pipelines.stages {
            if pipeline.label == COUNTING_METHODS.name {
                steps.extend(self.twisted());
            }
            if pipeline.label == LIST_SIDES.name {
                let [_, bytes] = self.sizes.choice_bytes();
                let table = (self.source.table.clone(), 16 * self.sizes.choices_offset as u64);
                steps.push(Step::Copy([(self.buffers.choices.clone(), 0), table], bytes));
            }
            let dispatches = self.dispatches(*over);
            if !dispatches.is_empty() {
                let bind = |(scope, workgroups)| self.dispatch(pipeline, scope, workgroups);
                steps.push(pipeline.pass(dispatches.into_iter().map(bind)));
            }
        }
        steps
    }

    /// The bind groups of the draws, for each group.
    fn draws(&self) -> Vec<GroupDraws> {
        let Layouts { frame, side_data, cap_data, piece_data } = &self.pipelines.layouts;
        let bind = |layout: &wgpu::BindGroupLayout, resources: &[Resource<'_>]| {
            group(&self.pipelines.device, "shadow volumes", layout, resources)
        };
        let frame = |scope: Scope| {
            let first = (self.group_and_batch(scope) * UniformTable::stride::<ShadowShape>()) as u64;
            let VolumeBuffers { shapes, draw_lights, view_lights, .. } = self.buffers;
            let resources = [
                part(shapes, first..first + size_of::<ShadowShape>() as u64),
                uniform::<ShadowDraw>(draw_lights, 0),
                part(view_lights, 0..size_of::<ViewLight>() as u64),
                whole(self.source.table),
            ];
            bind(frame, &resources)
        };
        let data = |layout: &wgpu::BindGroupLayout, names: &[&str], group: usize, batch: usize| {
            let of_view = |view| {
                let scope = Scope { group, batch, view };
                let resources: Vec<_> = names.iter().filter_map(|name| self.get(name, scope)).collect();
                bind(layout, &resources)
            };
            (0..self.sizes.views).map(of_view).collect::<Vec<_>>()
        };
        let side_names = ["positions", "edge_vertices", "edge_faces", "facing_masks", "excluded_masks", "sides"];
        let cap_names = ["positions", "faces", "facing_masks", "excluded_masks", "caps_listed"];
        let batches = || 0..self.sizes.batches();
        let of_group = |group| GroupDraws {
            frames: batches().map(|batch| frame(Scope { group, batch, view: 0 })).collect(),
            sides: batches().map(|batch| data(side_data, &side_names, group, batch)).collect(),
            caps: batches().map(|batch| data(cap_data, &cap_names, group, batch)).collect(),
            pieces: batches()
                .filter_map(|batch| Some(bind(piece_data, &[self.get("pieces", Scope { group, batch, view: 0 })?])))
                .collect(),
        };
        (0..self.sizes.groups.len()).map(of_group).collect()
    }
}
