//! The compute passes before the draws: `bounds`, `choose`, `caps`, `list_sides`, `shadow_arguments`, and four optional
//! ones.

use super::buffers::Buffers;
use crate::Counting;
use crate::gpu::common::dispatch_limits::binding;
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::positions::BoundPositions;
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::extract::extraction;
use crate::layout::{SceneCaster, ShadowDraw};
use crate::stages::{
    BOUNDS, CAPS, CHOOSE, LIST_SIDES, SHADOW_ARGUMENTS, STENCIL_BOUND, STENCIL_CROSSINGS, STENCIL_PENCIL, Stage,
    ZP_PLUS_2005_CASES,
};

/// Pipelines and bind groups of these stages.
#[derive(Debug)]
pub(super) struct Choice {
    bounds: Pipeline,
    choose: Pipeline,
    /// Only for ZP+ as published.
    zp_plus_2005_cases: Option<Pipeline>,
    caps: Pipeline,
    list_sides: Pipeline,
    arguments: Pipeline,
    /// Only if the caller asks for it.
    bound: Option<BoundStages>,
    choose_group: wgpu::BindGroup,
    /// One for each batch of lights.
    side_groups: Vec<wgpu::BindGroup>,
    /// One for each batch of lights.
    arguments_groups: Vec<wgpu::BindGroup>,
    /// Made for the current positions.
    position_groups: Option<PositionGroups>,
}

/// The stages that bound stencil counts.
#[derive(Debug)]
struct BoundStages {
    pencil: Pipeline,
    pencil_group: wgpu::BindGroup,
    crossings: Pipeline,
    bound: Pipeline,
    bound_group: wgpu::BindGroup,
}

/// The bind groups of the stages that read positions. A `Vec` has one for each batch of lights.
#[derive(Debug)]
struct PositionGroups {
    bounds: wgpu::BindGroup,
    /// Empty except for ZP+ as published.
    zp_plus_2005_cases: Vec<wgpu::BindGroup>,
    caps: Vec<wgpu::BindGroup>,
    /// Empty unless the caller asks for the bound.
    stencil_crossings: Vec<wgpu::BindGroup>,
}

/// The number of workgroups of the stages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Groups {
    pub(super) bounds: u32,
    /// For all lights.
    pub(super) lights: u32,
    pub(super) caps: u32,
    /// For each light.
    pub(super) sides: u32,
}

/// What stages may bind, by the names that the WGSL gives it.
struct Resources<'a> {
    buffers: &'a Buffers,
    source: &'a extraction::Shared,
}

impl<'a> Resources<'a> {
    fn of<'n>(&self, names: &'n [String], batch: usize) -> Vec<(&'n str, wgpu::BindingResource<'a>)> {
        names.iter().filter_map(|name| Some((name.as_str(), self.get(name, batch)?))).collect()
    }

    fn get(&self, name: &str, batch: usize) -> Option<wgpu::BindingResource<'a>> {
        let Self { buffers, source } = *self;
        let extracted = &source.buffers;
        let buffer = match name {
            "shape" => &buffers.shape,
            "draw" => return Some(binding(&buffers.draw_lights, 0..size_of::<ShadowDraw>() as u64)),
            "seen" => &buffers.seen,
            "table" => &buffers.table,
            // A single caster has no list of the lights that matter, and it is not read.
            "boxes" | "lit" => &buffers.boxes,
            "choices" => &buffers.choices,
            "shadow_statistics" => &buffers.statistics,
            "shadow_draws" => &buffers.draws,
            "sides" => buffers.sides.get(batch)?,
            "caps_listed" => buffers.caps.get(batch)?,
            "faces" => &buffers.faces,
            "edge_vertices" => &extracted.edge_vertices,
            "edge_faces" => &extracted.edge_faces,
            "facing_masks" => extracted.facing.get(batch)?,
            "excluded_masks" => extracted.excluded.get(batch)?,
            "silhouettes" => extracted.lists.get(batch)?,
            "silhouette_counts" => &extracted.counts,
            "extraction_statistics" => &extracted.statistics,
            "pencils" => &buffers.bound.as_ref()?.pencils,
            "crossings" => &buffers.bound.as_ref()?.crossings,
            _ => return None,
        };
        Some(buffer.as_entire_binding())
    }
}

impl Choice {
    pub(super) fn new(
        pipelines: &Pipelines,
        buffers: &Buffers,
        source: &extraction::Shared,
        counting: Counting,
    ) -> Self {
        let device = pipelines.device();
        let pipeline = |stage: &Stage| pipelines.compute(stage, stage.name, &[]);
        let [choose, list_sides, arguments] = [&CHOOSE, &LIST_SIDES, &SHADOW_ARGUMENTS].map(pipeline);
        let bind = |pipeline: &Pipeline, batch: usize| {
            pipeline.bind(device, &Resources { buffers, source }.of(pipeline.names(), batch))
        };
        let batches = 0..source.shape.batches();
        Self {
            bounds: pipeline(&BOUNDS),
            zp_plus_2005_cases: counting.is_zp_plus_2005().then(|| pipeline(&ZP_PLUS_2005_CASES)),
            caps: pipeline(&CAPS),
            bound: buffers.bound.is_some().then(|| {
                let [pencil, crossings, bound] = [&STENCIL_PENCIL, &STENCIL_CROSSINGS, &STENCIL_BOUND].map(pipeline);
                let (pencil_group, bound_group) = (bind(&pencil, 0), bind(&bound, 0));
                BoundStages { pencil, pencil_group, crossings, bound, bound_group }
            }),
            choose_group: bind(&choose, 0),
            side_groups: batches.clone().map(|batch| bind(&list_sides, batch)).collect(),
            arguments_groups: batches.map(|batch| bind(&arguments, batch)).collect(),
            choose,
            list_sides,
            arguments,
            position_groups: None,
        }
    }

    /// Binds positions to the stages that read them.
    pub(super) fn bind_positions(
        &mut self,
        buffers: &Buffers,
        source: &extraction::Shared,
        positions: &wgpu::Buffer,
        bound: &BoundPositions,
    ) {
        let bind = |pipeline: &Pipeline, batch: usize| {
            let mut resources = Resources { buffers, source }.of(pipeline.names(), batch);
            resources.push(("positions", bound.first_binding(positions)));
            pipeline.bind(source.device(), &resources)
        };
        let for_each = |pipeline: &Pipeline| (0..source.shape.batches()).map(|batch| bind(pipeline, batch)).collect();
        self.position_groups = Some(PositionGroups {
            bounds: bind(&self.bounds, 0),
            zp_plus_2005_cases: self.zp_plus_2005_cases.as_ref().map_or_else(Vec::new, for_each),
            caps: for_each(&self.caps),
            stencil_crossings: self.bound.as_ref().map(|stages| &stages.crossings).map_or_else(Vec::new, for_each),
        });
    }

    /// Records the stages for `lights` lights.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &Buffers,
        groups: Groups,
        lights: usize,
        mut timer: Option<&mut StageTimer>,
    ) {
        let Some(PositionGroups { bounds, zp_plus_2005_cases, caps, stencil_crossings }) = &self.position_groups else {
            return;
        };
        let one = std::slice::from_ref::<wgpu::BindGroup>;
        let mut record = |encoder: &mut _, stage, bound, workgroups: &dyn Fn(u32) -> [u32; 2]| {
            dispatch(encoder, stage, bound, lights, workgroups, timer.as_deref_mut());
        };
        record(encoder, &self.bounds, one(bounds), &|_| [groups.bounds, 1]);
        record(encoder, &self.choose, one(&self.choose_group), &|_| [groups.lights, 1]);
        if let Some(stage) = &self.zp_plus_2005_cases {
            record(encoder, stage, zp_plus_2005_cases, &|lights| [lights, 1]);
        }
        record(encoder, &self.caps, caps, &|_| [groups.caps, 1]);
        let behind_caster = size_of::<SceneCaster>() as u64;
        let choices = &buffers.choices;
        encoder.copy_buffer_to_buffer(choices, 0, &buffers.table, behind_caster, choices.size());
        record(encoder, &self.list_sides, &self.side_groups, &|lights| [groups.sides, lights]);
        record(encoder, &self.arguments, &self.arguments_groups, &|_| [1, 1]);
        if let Some(BoundStages { pencil, pencil_group, crossings, bound, bound_group }) = &self.bound {
            let each_light = |_| [lights as u32, 1];
            record(encoder, pencil, one(pencil_group), &each_light);
            record(encoder, crossings, stencil_crossings, &|lights| [groups.sides, lights]);
            record(encoder, bound, one(bound_group), &each_light);
        }
    }
}

/// Records a stage: a dispatch for each batch of lights that is bound, of workgroups that may depend on the lights in it.
fn dispatch(
    encoder: &mut wgpu::CommandEncoder,
    stage: &Pipeline,
    bound: &[wgpu::BindGroup],
    lights: usize,
    workgroups: &dyn Fn(u32) -> [u32; 2],
    timer: Option<&mut StageTimer>,
) {
    let mut pass = begin(encoder, stage, timer);
    for (batch, group) in bound.iter().enumerate().take(crate::light::batches(lights)) {
        let first_light = (32 * batch * UniformTable::stride::<ShadowDraw>()) as u32;
        // The shape, and the light if the stage goes by batches.
        let offsets = [0, first_light];
        pass.set_bind_group(0, group, offsets.get(..stage.uniforms()).unwrap_or(&offsets));
        let [x, y] = workgroups((lights - 32 * batch).min(32) as u32);
        pass.dispatch_workgroups(x, y, 1);
    }
}

fn begin<'encoder>(
    encoder: &'encoder mut wgpu::CommandEncoder,
    pipeline: &Pipeline,
    timer: Option<&mut StageTimer>,
) -> wgpu::ComputePass<'encoder> {
    let timestamp_writes = timer.and_then(|timer| timer.compute_pass(pipeline.label));
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(pipeline.label), timestamp_writes });
    pass.set_pipeline(&pipeline.compute);
    pass
}
