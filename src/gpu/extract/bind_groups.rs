//! The buffers that the dispatches of each stage bind.

use wgpu::BindingResource;

use super::buffers::{Buffers, RECORD_HEAD, Shape};
use super::options::ExtractorOptions;
use super::programs;
use crate::gpu::common::dispatch_limits::{Windows, binding};
use crate::gpu::common::pass::{Dispatch, Pass};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::BoundPositions;
use crate::gpu::common::uniforms::{UniformTable, entry};
use crate::layout::{Chunk, DrawShape, EdgeMasks, ExtractionStatistics, LightBatch};

/// Makes pipelines and bind groups over the buffers of an extraction.
pub(crate) struct BindGroupBuilder<'a> {
    pub(crate) pipelines: &'a Pipelines,
    pub(crate) device: &'a wgpu::Device,
    pub(crate) shape: &'a Shape,
    pub(crate) buffers: &'a Buffers,
    pub(crate) chunks: &'a wgpu::Buffer,
    pub(crate) light_batches: &'a wgpu::Buffer,
}

impl<'a> BindGroupBuilder<'a> {
    /// Statistics and the list of undecided faces; its length tells the shaders its capacity.
    pub(super) fn record(&self) -> BindingResource<'a> {
        binding(&self.buffers.record, 0..RECORD_HEAD + 4 * self.shape.undecided.max(1) as u64)
    }

    /// Binds positions to the dispatches of a pipeline.
    pub(crate) fn bind_positions(&self, pass: &mut Pass, positions: &wgpu::Buffer, bound: &BoundPositions) {
        for dispatch in &mut pass.dispatches {
            let mut resources =
                vec![("batch", entry::<LightBatch>(self.light_batches)), ("chunk", entry::<Chunk>(self.chunks))];
            resources.extend(bound.bindings(positions));
            if let Some(corners) = &self.buffers.edge_corners {
                resources.push(("edge_corners", binding(corners, dispatch.bytes(16))));
                resources.extend(self.emit_targets(dispatch));
            } else {
                resources.extend([
                    ("faces", binding(&self.buffers.faces, dispatch.bytes(12))),
                    ("facing_masks", binding(&self.buffers.facing[dispatch.batch], dispatch.bytes(4))),
                    ("record", self.record()),
                ]);
                let excluded = self
                    .buffers
                    .excluded
                    .get(dispatch.batch)
                    .map_or_else(|| self.buffers.unused.as_entire_binding(), |masks| binding(masks, dispatch.bytes(4)));
                resources.push(("excluded_masks", excluded));
            }
            dispatch.offsets = Self::batch_and_chunk(dispatch);
            dispatch.group = Some(pass.pipeline.bind(self.device, &resources));
        }
    }

    /// The edges stage, which reads facing masks.
    pub(crate) fn edges(&self, options: &ExtractorOptions, mut dispatches: Vec<Dispatch>, windows: &Windows) -> Pass {
        let twisted_at = if self.shape.polygons.is_some() { self.shape.faces } else { 0 };
        let pipeline = self.pipelines.get(&programs::edges(options, twisted_at, windows.words));
        for dispatch in &mut dispatches {
            let facing = &self.buffers.facing[dispatch.batch];
            let mut resources =
                vec![("batch", entry::<LightBatch>(self.light_batches)), ("chunk", entry::<Chunk>(self.chunks))];
            let names = ["facing_0", "facing_1", "facing_2", "facing_3"];
            resources
                .extend(names.into_iter().zip(windows.ranges.iter().map(|window| binding(facing, window.clone()))));
            resources.push(("edge_faces", binding(&self.buffers.edge_faces, dispatch.bytes(8))));
            resources.extend(self.emit_targets(dispatch));
            dispatch.offsets = Self::batch_and_chunk(dispatch);
            dispatch.group = Some(pipeline.bind(self.device, &resources));
        }
        Pass { pipeline, dispatches }
    }

    /// Compaction in edge order: count, scan, scatter.
    pub(crate) fn compact(&self, edge_dispatches: &[Dispatch]) -> [Pass; 3] {
        programs::compact().map(|program| {
            let pipeline = self.pipelines.get(&program);
            let scans = program.entry_point == "compact_scan";
            // The scan goes over all blocks of a batch at once, with one workgroup for each light.
            let of_batch = |dispatch: &&Dispatch| !scans || dispatch.items.start == 0;
            let mut dispatches: Vec<_> = edge_dispatches.iter().filter(of_batch).cloned().collect();
            for dispatch in &mut dispatches {
                let resources = [
                    ("chunk", entry::<Chunk>(self.chunks)),
                    ("masks", self.masks_of(dispatch)),
                    ("places", self.buffers.places.as_entire_binding()),
                    ("counts", self.buffers.counts.as_entire_binding()),
                    ("list", self.buffers.lists[dispatch.batch].as_entire_binding()),
                ];
                dispatch.offsets = vec![dispatch.chunk_offset];
                dispatch.group = Some(pipeline.bind(self.device, &resources));
                if scans {
                    dispatch.workgroups = self.at_most_workgroups(self.shape.batch_lights(dispatch.batch));
                }
            }
            Pass { pipeline, dispatches }
        })
    }

    /// The draw arguments of all lights, in one dispatch.
    pub(crate) fn arguments(&self, vertices_per_edge: u32) -> Pass {
        let Shape { edges, max_lights, capacity, .. } = *self.shape;
        let mut table = UniformTable::default();
        table.push(&DrawShape { lights: max_lights as u32, capacity, edges: edges as u32, vertices_per_edge });
        let shape = table.into_buffer(self.device, "draw shape");
        let pipeline = self.pipelines.get(&programs::arguments());
        let resources = [
            ("shape", entry::<DrawShape>(&shape)),
            ("counts", self.buffers.counts.as_entire_binding()),
            ("draw_arguments", self.buffers.draw_arguments.as_entire_binding()),
            ("statistics", binding(&self.buffers.record, 0..size_of::<ExtractionStatistics>() as u64)),
        ];
        let group = Some(pipeline.bind(self.device, &resources));
        let workgroups = self.at_most_workgroups(max_lights.div_ceil(64));
        let dispatch = Dispatch { group, offsets: vec![0], workgroups, ..Dispatch::over(0, 0..max_lights, 0) };
        Pass { pipeline, dispatches: vec![dispatch] }
    }

    /// `wanted` workgroups, but at most as many as the device allows in one dispatch. It is for stages whose workgroups
    /// take turns.
    fn at_most_workgroups(&self, wanted: usize) -> u32 {
        let limit = self.device.limits().max_compute_workgroups_per_dimension;
        (wanted as u32).min(limit)
    }

    /// Masks, counts and list, as `extract/edge_lists.wgsl` binds them.
    fn emit_targets(&self, dispatch: &Dispatch) -> [(&'static str, BindingResource<'_>); 3] {
        let unused = self.buffers.unused.as_entire_binding();
        let list = self.buffers.lists.get(dispatch.batch).map_or(unused, wgpu::Buffer::as_entire_binding);
        [("masks", self.masks_of(dispatch)), ("counts", self.buffers.counts.as_entire_binding()), ("list", list)]
    }

    /// The masks of the chunk: those of its batch, those that all batches share, or none.
    fn masks_of(&self, dispatch: &Dispatch) -> BindingResource<'_> {
        match self.buffers.masks.get(dispatch.batch).or(self.buffers.masks.first()) {
            Some(masks) => binding(masks, dispatch.bytes(size_of::<EdgeMasks>() as u64)),
            None => self.buffers.unused.as_entire_binding(),
        }
    }

    /// The dynamic offsets of a light batch and a chunk.
    fn batch_and_chunk(dispatch: &Dispatch) -> Vec<u32> {
        vec![dispatch.batch as u32 * UniformTable::stride::<LightBatch>() as u32, dispatch.chunk_offset]
    }
}
