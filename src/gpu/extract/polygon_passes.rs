//! The stages of polygons: facing of those whose corners turn alike, the turns of the others, the outlines that are left, their
//! masks, and the pieces of those that are L-twisted.

use super::bind_groups::BindGroupBuilder;
use super::polygon_buffers::{
    ARGUMENTS, CUT_WORKGROUPS, HEAD_WORDS, PIECE_COUNTS, PolygonBuffers, RECORD_WORKGROUPS, ROW_WORKGROUPS, WORKGROUPS,
};
use super::programs;
use crate::gpu::common::dispatch_limits::WORKGROUP;
use crate::gpu::common::pass::{Dispatch, Pass};
use crate::gpu::common::pipelines::Pipeline;
use crate::gpu::common::positions::BoundPositions;
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, entry};
use crate::layout::{Chunk, LightBatch};
use crate::stages::{CUT_EDGES, CUT_QUADS, OUTLINE, POLYGON_FACING, POLYGON_MASKS, POLYGON_TURNS};

/// The stages, in order.
#[derive(Debug)]
pub(super) struct PolygonPasses {
    facing: Pass,
    turns: Pass,
    outline: Pass,
    masks: Pass,
    cut: Option<CutPasses>,
}

/// The stages that list pieces, if there are lists.
#[derive(Debug)]
struct CutPasses {
    edges: Pass,
    /// The passes over the cuts that this finds.
    rows: Vec<Pass>,
    /// Quadrilaterals of which no sign is in doubt. Their pieces are behind the others, in places that have no cuts.
    quads: Pass,
}

impl PolygonPasses {
    /// `dispatches` has one for each batch, over all polygons.
    pub(super) fn new(binder: &BindGroupBuilder<'_>, dispatches: &[Dispatch], window_words: u32) -> Option<Self> {
        let buffers = binder.buffers.polygons.as_ref()?;
        let polygons = buffers.shape.polygons as u32;
        let workgroups = polygons.div_ceil(WORKGROUP);
        // `at`: where the GPU writes how many workgroups there are.
        let pass = |pipeline: Pipeline, at: Option<u64>| {
            let indirect = at.map(|at| (buffers.arguments.clone(), at));
            let one = |dispatch: &Dispatch| Dispatch { workgroups, indirect: indirect.clone(), ..dispatch.clone() };
            Pass { pipeline, dispatches: dispatches.iter().map(one).collect() }
        };
        let compute = |stage| binder.pipelines.get(&programs::of_polygons(binder.device, stage, window_words));
        let mut masks = pass(compute(&POLYGON_MASKS), Some(RECORD_WORKGROUPS));
        for dispatch in &mut masks.dispatches {
            let resources = resources(binder, &masks.pipeline, dispatch);
            dispatch.group = Some(masks.pipeline.bind(binder.device, &resources));
        }
        let has_pieces = !buffers.pieces.is_empty();
        Some(Self {
            facing: pass(compute(&POLYGON_FACING), None),
            turns: pass(compute(&POLYGON_TURNS), Some(RECORD_WORKGROUPS)),
            outline: pass(compute(&OUTLINE), Some(WORKGROUPS)),
            masks,
            cut: has_pieces.then(|| CutPasses {
                edges: pass(compute(&CUT_EDGES), Some(CUT_WORKGROUPS)),
                rows: programs::cut_rows(binder.device, window_words)
                    .map(|program| pass(binder.pipelines.get(&program), Some(ROW_WORKGROUPS)))
                    .collect(),
                quads: pass(compute(&CUT_QUADS), Some(RECORD_WORKGROUPS)),
            }),
        })
    }

    /// The number of words in a window of positions that the pipelines are for.
    pub(super) fn window_words(&self) -> u32 {
        self.facing.pipeline.window_words
    }

    pub(super) fn bind_positions(
        &mut self,
        binder: &BindGroupBuilder<'_>,
        positions: &wgpu::Buffer,
        bound: &BoundPositions,
    ) {
        let cut = self.cut.iter_mut().flat_map(|cut| [&mut cut.edges, &mut cut.quads].into_iter().chain(&mut cut.rows));
        for pass in [&mut self.facing, &mut self.turns, &mut self.outline].into_iter().chain(cut) {
            for dispatch in &mut pass.dispatches {
                let mut resources = resources(binder, &pass.pipeline, dispatch);
                resources.extend(bound.bindings(positions));
                dispatch.group = Some(pass.pipeline.bind(binder.device, &resources));
            }
        }
    }

    /// Records the stages of a batch of lights: up to the masks.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &PolygonBuffers,
        batch: usize,
        mut timer: Option<&mut StageTimer>,
    ) {
        let PolygonBuffers { undecided, head, arguments, .. } = buffers;
        let arguments = |encoder: &mut wgpu::CommandEncoder, at| {
            encoder.copy_buffer_to_buffer(undecided, at, arguments, at, ARGUMENTS);
        };
        let batches = batch..batch + 1;
        encoder.copy_buffer_to_buffer(head, 0, undecided, 0, 4 * HEAD_WORDS);
        self.facing.record(encoder, batches.clone(), timer.as_deref_mut());
        arguments(encoder, RECORD_WORKGROUPS);
        self.turns.record(encoder, batches.clone(), timer.as_deref_mut());
        arguments(encoder, WORKGROUPS);
        self.outline.record(encoder, batches.clone(), timer.as_deref_mut());
        self.masks.record(encoder, batches.clone(), timer.as_deref_mut());
        if let (Some(cut), Some(pieces)) = (&self.cut, buffers.pieces.get(batch)) {
            encoder.clear_buffer(pieces, 0, Some(4 * PIECE_COUNTS));
            arguments(encoder, CUT_WORKGROUPS);
            cut.edges.record(encoder, batches.clone(), timer.as_deref_mut());
            arguments(encoder, ROW_WORKGROUPS);
            Pass::record_all(cut.rows.iter().chain([&cut.quads]), encoder, batches, timer);
        }
    }
}

/// The bindings of a stage besides positions.
fn resources<'a>(
    binder: &BindGroupBuilder<'a>,
    pipeline: &Pipeline,
    dispatch: &mut Dispatch,
) -> Vec<(&'static str, wgpu::BindingResource<'a>)> {
    let batch = dispatch.batch as u32 * UniformTable::stride::<LightBatch>() as u32;
    let uses = |name: &str| pipeline.names().iter().any(|own| own == name);
    let offsets = [("batch", batch), ("chunk", dispatch.chunk_offset)];
    dispatch.offsets = offsets.into_iter().filter(|(name, _)| uses(name)).map(|(_, offset)| offset).collect();
    let Some(polygons) = &binder.buffers.polygons else { return Vec::new() };
    let unused = &binder.buffers.unused;
    let of_batch = |buffers: &'a [wgpu::Buffer]| buffers.get(dispatch.batch).unwrap_or(unused).as_entire_binding();
    vec![
        ("batch", entry::<LightBatch>(binder.light_batches)),
        ("chunk", entry::<Chunk>(binder.chunks)),
        ("outlines", polygons.outlines.as_entire_binding()),
        ("undecided", polygons.undecided.as_entire_binding()),
        ("facing_masks", of_batch(&binder.buffers.facing)),
        ("excluded_masks", of_batch(&binder.buffers.excluded)),
        ("record", binder.record()),
        ("faces", binder.buffers.faces.as_entire_binding()),
        ("pieces", of_batch(&polygons.pieces)),
    ]
}
