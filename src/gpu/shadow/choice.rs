//! The compute passes before the draws: `bounds`, `choose`, `caps`, `list_sides`, `shadow_arguments`, and two optional
//! ones.

use super::buffers::Buffers;
use super::options::ShadowOptions;
use crate::Counting;
use crate::gpu::common::dispatch_limits::binding;
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::positions::BoundPositions;
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::extract::results::ExtractionResults;
use crate::layout::ShadowDraw;
use crate::stages::{BOUNDS, CAPS, CHOOSE, LIST_SIDES, SHADOW_ARGUMENTS, STENCIL_BOUND, Stage, ZP_PLUS_2005_CASES};

/// Pipelines and bind groups of these stages.
#[derive(Debug)]
pub(super) struct Choice {
    bounds: Pipeline,
    choose: Pipeline,
    /// Only for ZP+ as published.
    zp_plus_2005_cases: Option<Pipeline>,
    /// Only if the caller asks for it.
    stencil_bound: Option<Pipeline>,
    caps: Pipeline,
    list_sides: Pipeline,
    arguments: Pipeline,
    choose_group: wgpu::BindGroup,
    /// One for each batch of lights.
    side_groups: Vec<wgpu::BindGroup>,
    /// One for each batch of lights.
    arguments_groups: Vec<wgpu::BindGroup>,
    /// Made for the current positions.
    position_groups: Option<PositionGroups>,
}

/// The bind groups of the stages that read positions.
#[derive(Debug)]
struct PositionGroups {
    bounds: wgpu::BindGroup,
    /// One for each batch of lights. Empty except for ZP+ as published.
    zp_plus_2005_cases: Vec<wgpu::BindGroup>,
    /// One for each batch of lights. Empty unless the caller asks for the bound.
    stencil_bound: Vec<wgpu::BindGroup>,
    caps: Vec<wgpu::BindGroup>,
}

/// The number of workgroups of the stages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Groups {
    pub(super) bounds: u32,
    pub(super) lights: u32,
    /// For each light.
    pub(super) sides: u32,
}

impl Choice {
    pub(super) fn new(
        pipelines: &Pipelines,
        buffers: &Buffers,
        results: &ExtractionResults<'_>,
        excluded: &[wgpu::Buffer],
        counting: Counting,
        options: ShadowOptions,
    ) -> Self {
        let device = pipelines.device();
        let pipeline = |stage: &Stage| pipelines.compute(stage, stage.name, &[]);
        let choose = pipeline(&CHOOSE);
        let arguments = pipeline(&SHADOW_ARGUMENTS);
        let whole = wgpu::Buffer::as_entire_binding;
        let choose_group = choose.bind(
            device,
            &[
                ("shape", whole(&buffers.shape)),
                ("view", whole(&buffers.view)),
                ("box", whole(&buffers.bounds)),
                ("shadow_lights", whole(&buffers.lights)),
                ("cap_dispatches", whole(&buffers.cap_dispatches)),
                ("extraction_statistics", whole(results.statistics)),
            ],
        );
        let draw = || binding(&buffers.draw_lights, 0..size_of::<ShadowDraw>() as u64);
        let list_sides = pipeline(&LIST_SIDES);
        let per_batch = results.facing.iter().zip(excluded).zip(results.lists).zip(&buffers.sides);
        let side_groups = per_batch.map(|(((facing, excluded), silhouettes), sides)| {
            list_sides.bind(
                device,
                &[
                    ("shape", whole(&buffers.shape)),
                    ("draw", draw()),
                    ("silhouette_counts", whole(results.counts)),
                    ("silhouettes", whole(silhouettes)),
                    ("edge_faces", whole(results.edge_faces)),
                    ("facing_masks", whole(facing)),
                    ("excluded_masks", whole(excluded)),
                    ("shadow_lights", whole(&buffers.lights)),
                    ("sides", whole(sides)),
                ],
            )
        });
        let side_groups = side_groups.collect();
        let arguments_groups = buffers.sides.iter().map(|sides| {
            arguments.bind(
                device,
                &[
                    ("shape", whole(&buffers.shape)),
                    ("draw", draw()),
                    ("sides", whole(sides)),
                    ("cap_counts", whole(&buffers.cap_counts)),
                    ("shadow_lights", whole(&buffers.lights)),
                    ("shadow_draws", whole(&buffers.draws)),
                    ("shadow_statistics", whole(&buffers.statistics)),
                ],
            )
        });
        let arguments_groups = arguments_groups.collect();
        Self {
            bounds: pipeline(&BOUNDS),
            zp_plus_2005_cases: counting.is_zp_plus_2005().then(|| pipeline(&ZP_PLUS_2005_CASES)),
            stencil_bound: options.bound_counts.then(|| pipeline(&STENCIL_BOUND)),
            caps: pipeline(&CAPS),
            choose,
            list_sides,
            arguments,
            choose_group,
            side_groups,
            arguments_groups,
            position_groups: None,
        }
    }

    /// Binds positions to the stages that read them.
    pub(super) fn bind_positions(
        &mut self,
        device: &wgpu::Device,
        buffers: &Buffers,
        results: &ExtractionResults<'_>,
        excluded: &[wgpu::Buffer],
        positions: &wgpu::Buffer,
        bound: &BoundPositions,
    ) {
        let whole = wgpu::Buffer::as_entire_binding;
        let positions = bound.first_binding(positions);
        let bounds = self.bounds.bind(
            device,
            &[
                ("shape", whole(&buffers.shape)),
                ("positions", positions.clone()),
                ("faces", whole(&buffers.faces)),
                ("box", whole(&buffers.bounds)),
            ],
        );
        let caps = results.facing.iter().zip(excluded).zip(&buffers.cap_lists).map(|((facing, excluded), list)| {
            self.caps.bind(
                device,
                &[
                    ("shape", whole(&buffers.shape)),
                    ("view", whole(&buffers.view)),
                    ("draw", binding(&buffers.draw_lights, 0..size_of::<ShadowDraw>() as u64)),
                    ("positions", positions.clone()),
                    ("faces", whole(&buffers.faces)),
                    ("facing_masks", whole(facing)),
                    ("shadow_lights", whole(&buffers.lights)),
                    ("cap_counts", whole(&buffers.cap_counts)),
                    ("cap_list", whole(list)),
                    ("excluded_masks", whole(excluded)),
                ],
            )
        });
        let zp_plus_2005_cases = self.zp_plus_2005_cases.iter().flat_map(|stage| {
            results.lists.iter().map(|list| {
                stage.bind(
                    device,
                    &[
                        ("shape", whole(&buffers.shape)),
                        ("view", whole(&buffers.view)),
                        ("draw", binding(&buffers.draw_lights, 0..size_of::<ShadowDraw>() as u64)),
                        ("positions", positions.clone()),
                        ("edge_vertices", whole(results.edge_vertices)),
                        ("list", whole(list)),
                        ("silhouette_counts", whole(results.counts)),
                        ("shadow_lights", whole(&buffers.lights)),
                    ],
                )
            })
        });
        let stencil_bound = self.stencil_bound.iter().flat_map(|stage| {
            results.lists.iter().map(|list| {
                stage.bind(
                    device,
                    &[
                        ("shape", whole(&buffers.shape)),
                        ("draw", binding(&buffers.draw_lights, 0..size_of::<ShadowDraw>() as u64)),
                        ("box", whole(&buffers.bounds)),
                        ("positions", positions.clone()),
                        ("edge_vertices", whole(results.edge_vertices)),
                        ("edge_faces", whole(results.edge_faces)),
                        ("list", whole(list)),
                        ("silhouette_counts", whole(results.counts)),
                        ("shadow_lights", whole(&buffers.lights)),
                        ("shadow_statistics", whole(&buffers.statistics)),
                    ],
                )
            })
        });
        let stencil_bound = stencil_bound.collect();
        self.position_groups = Some(PositionGroups {
            bounds,
            zp_plus_2005_cases: zp_plus_2005_cases.collect(),
            stencil_bound,
            caps: caps.collect(),
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
        let batches = crate::light::batches(lights);
        let Some(PositionGroups { bounds, zp_plus_2005_cases, stencil_bound, caps }) = &self.position_groups else {
            return;
        };
        let mut pass = begin(encoder, &self.bounds, timer.as_deref_mut());
        pass.set_bind_group(0, bounds, &[0]);
        pass.dispatch_workgroups(groups.bounds, 1, 1);
        drop(pass);
        let mut pass = begin(encoder, &self.choose, timer.as_deref_mut());
        pass.set_bind_group(0, &self.choose_group, &[0, 0]);
        pass.dispatch_workgroups(groups.lights, 1, 1);
        drop(pass);
        let first_light = |batch: usize| (32 * batch * UniformTable::stride::<ShadowDraw>()) as u32;
        if let Some(stage) = &self.zp_plus_2005_cases {
            let mut pass = begin(encoder, stage, timer.as_deref_mut());
            for (batch, group) in zp_plus_2005_cases.iter().enumerate().take(batches) {
                pass.set_bind_group(0, group, &[0, 0, first_light(batch)]);
                pass.dispatch_workgroups((lights - 32 * batch).min(32) as u32, 1, 1);
            }
        }
        if let Some(stage) = &self.stencil_bound {
            let mut pass = begin(encoder, stage, timer.as_deref_mut());
            for (batch, group) in stencil_bound.iter().enumerate().take(batches) {
                pass.set_bind_group(0, group, &[0, first_light(batch)]);
                pass.dispatch_workgroups((lights - 32 * batch).min(32) as u32, 1, 1);
            }
        }
        let mut pass = begin(encoder, &self.caps, timer.as_deref_mut());
        for (batch, group) in caps.iter().enumerate().take(batches) {
            pass.set_bind_group(0, group, &[0, 0, first_light(batch)]);
            pass.dispatch_workgroups_indirect(&buffers.cap_dispatches, 12 * batch as u64);
        }
        drop(pass);
        let mut pass = begin(encoder, &self.list_sides, timer.as_deref_mut());
        for (batch, group) in self.side_groups.iter().enumerate().take(batches) {
            pass.set_bind_group(0, group, &[0, first_light(batch)]);
            pass.dispatch_workgroups(groups.sides, (lights - 32 * batch).min(32) as u32, 1);
        }
        drop(pass);
        let mut pass = begin(encoder, &self.arguments, timer);
        for (batch, group) in self.arguments_groups.iter().enumerate().take(batches) {
            pass.set_bind_group(0, group, &[0, first_light(batch)]);
            pass.dispatch_workgroups(1, 1, 1);
        }
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
