//! The stages of extraction, and their dispatches with the buffers that they bind.

use std::ops::Range;

use super::buffers::{Buffers, RECORD_HEAD, Shape};
use super::options::ExtractorOptions;
use super::polygon_buffers::{
    CUT_GROUP_WORKGROUPS, CUT_WORKGROUPS, HEAD_WORDS, INDIRECT_BYTES, PIECE_COUNTS, PolygonBuffers, RECORD_WORKGROUPS,
    WORKGROUPS,
};
use crate::gpu::common::bindings::{Resource, part, uniform, whole};
use crate::gpu::common::dispatch_limits::{WORKGROUP, Windows, exact_workgroups};
use crate::gpu::common::pass::{Dispatch, Step, Workgroups};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, Program, switch};
use crate::gpu::common::positions::BoundPositions;
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::{Chunk, DrawShape, EdgeMasks, ExtractionStatistics, LightBatch};
use crate::method::Predicate;
use crate::stages::{
    ARGUMENTS, COMPACT, CUT_EDGES, CUT_QUADS, EDGES, EXACT_FACING, FACING, PER_EDGE, POLYGON_FACING, POLYGON_MASKS,
    POLYGON_PAIRS, POLYGON_TURNS, Stage,
};
use crate::turns::EXACT_ITEMS;

/// The items that a stage walks along.
#[derive(Clone, Copy, Debug)]
enum Over {
    Faces,
    Edges,
    Polygons,
}

/// How many workgroups a dispatch has.
#[derive(Clone, Copy, Debug)]
enum Size {
    /// An invocation for each item.
    Items,
    /// Few invocations, which take the undecided faces in turn.
    Few,
    /// A workgroup for each light of the batch, for all chunks at once.
    Lights,
    /// The GPU writes it at this byte of the head of undecided polygons.
    Written(u64),
}

/// A stage that is dispatched for each batch of lights.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    pub(crate) program: Program,
    over: Over,
    size: Size,
}

/// Masks are written if they are requested or if ordered lists are made from them. Appending makes unordered lists.
fn emit_constants(options: &ExtractorOptions) -> [(&'static str, f64); 2] {
    let ordered = options.is_ordered();
    [("WRITE_MASKS", switch(options.masks || ordered)), ("APPEND", switch(options.lists.is_some() && !ordered))]
}

/// The stages that read positions, in their order. `words` are those of a window of positions, or 0 if there is one.
/// `pieces`: whether polygons have pieces. `None`: there are triangles only.
pub(super) fn from_positions(
    device: &wgpu::Device,
    options: &ExtractorOptions,
    pieces: Option<bool>,
    words: u32,
) -> Vec<Planned> {
    let windows = ("WINDOW_WORDS", f64::from(words));
    if let Some(pieces) = pieces {
        let row = ("ENTRY_ROW", f64::from(device.limits().max_compute_workgroups_per_dimension));
        let stage = |(stage, entry_point, size): (&'static Stage, usize, Size)| {
            let program = Program::at(stage, stage.entry_points[entry_point], &[row, windows]);
            Planned { program, over: Over::Polygons, size }
        };
        let stages = [
            (&POLYGON_FACING, 0, Size::Items),
            (&POLYGON_TURNS, 0, Size::Written(RECORD_WORKGROUPS)),
            (&POLYGON_PAIRS, 0, Size::Written(WORKGROUPS)),
            (&POLYGON_MASKS, 0, Size::Written(RECORD_WORKGROUPS)),
        ];
        let cut = [
            (&CUT_EDGES, 0, Size::Written(CUT_WORKGROUPS)),
            (&CUT_EDGES, 1, Size::Written(CUT_GROUP_WORKGROUPS)),
            (&CUT_EDGES, 2, Size::Written(CUT_GROUP_WORKGROUPS)),
            (&CUT_EDGES, 3, Size::Written(CUT_GROUP_WORKGROUPS)),
            // Last, because the passes of `CUT_EDGES` read all listed pieces as their cuts.
            (&CUT_QUADS, 0, Size::Written(RECORD_WORKGROUPS)),
        ];
        return stages.into_iter().chain(cut.into_iter().filter(|_| pieces)).map(stage).collect();
    }
    let predicate = options.method.predicate(options.predicate);
    let plane = ("PLANE", switch(predicate == Predicate::Plane));
    if options.method.is_per_edge() {
        let [masks, append] = emit_constants(options);
        let program = Program::of(&PER_EDGE, &[windows, plane, masks, append]);
        return vec![Planned { program, over: Over::Edges, size: Size::Items }];
    }
    let is_exact = predicate == Predicate::Exact;
    let facing = Program::of(&FACING, &[windows, plane, ("EXACT", switch(is_exact))]);
    let mut stages = vec![Planned { program: facing, over: Over::Faces, size: Size::Items }];
    let exact = Program::of(&EXACT_FACING, &[windows]);
    stages.extend(is_exact.then_some(Planned { program: exact, over: Over::Faces, size: Size::Few }));
    stages
}

/// The stages after facing, in their order. Facing masks are read in windows of `words` words, or in one window if 0.
pub(super) fn from_facing(options: &ExtractorOptions, words: u32) -> Vec<Planned> {
    let [masks, append] = emit_constants(options);
    let windows = ("FACING_WINDOW_WORDS", f64::from(words));
    let edges = Program::of(&EDGES, &[windows, masks, append]);
    let has_edges = !options.method.is_per_edge() && (options.masks || options.lists.is_some());
    let compact = COMPACT.entry_points.iter().zip([Size::Items, Size::Lights, Size::Items]);
    let compact = compact
        .filter(|_| options.is_ordered())
        .map(|(&entry_point, size)| (Program::at(&COMPACT, entry_point, &[]), size));
    let stages = has_edges.then_some((edges, Size::Items)).into_iter().chain(compact);
    stages.map(|(program, size)| Planned { program, over: Over::Edges, size }).collect()
}

/// The program of draw arguments, if there are lists.
pub(super) fn arguments(options: &ExtractorOptions) -> Option<Program> {
    options.lists.map(|_| Program::of(&ARGUMENTS, &[]))
}

/// The programs of stages, and another.
pub(super) fn programs([reading, others]: [&[Planned]; 2], further: Option<Program>) -> Vec<Program> {
    reading.iter().chain(others).map(|planned| planned.program.clone()).chain(further).collect()
}

/// The programs of all stages for triangles whose arrays each fit one window.
pub(crate) fn of_triangles(device: &wgpu::Device, options: &ExtractorOptions) -> Vec<Program> {
    programs([&from_positions(device, options, None, 0), &from_facing(options, 0)], arguments(options))
}

/// Items of a dispatch, for a batch of lights.
#[derive(Clone, Debug, Default)]
struct BatchItems {
    batch: usize,
    items: Range<usize>,
    /// The offset of its `Chunk` in the table of chunks.
    chunk: u32,
}

impl BatchItems {
    /// Its bytes in an array of `bytes_per_item`.
    fn bytes(&self, bytes_per_item: u64) -> Range<u64> {
        self.items.start as u64 * bytes_per_item..self.items.end as u64 * bytes_per_item
    }
}

/// The dispatches over the items of each [`Over`], in order: for each batch of lights those of its chunks.
#[derive(Debug)]
pub(super) struct DispatchRanges([Vec<Vec<BatchItems>>; 3]);

impl DispatchRanges {
    /// Writes the chunks to the table.
    pub(super) fn new(shape: &Shape, [faces, edges]: [&[Range<usize>]; 2], table: &mut UniformTable) -> Self {
        let twisted_offset = shape.twisted_offset();
        let mut plan = |chunks: &[Range<usize>], capacity: u32, blocks: u32| {
            let mut range = |batch: usize, items: &Range<usize>| {
                let (first, count, first_light) = (items.start as u32, items.len() as u32, 32 * batch as u32);
                let chunk = table.push(&Chunk { first, count, first_light, capacity, blocks, twisted_offset });
                BatchItems { batch, items: items.clone(), chunk }
            };
            let mut of_batch = |batch| chunks.iter().map(|items| range(batch, items)).collect();
            (0..shape.batches()).map(&mut of_batch).collect()
        };
        let Shape { capacity, blocks, polygons, .. } = *shape;
        let (polygons, pieces) = polygons.map_or((0, 0), |polygons| (polygons.polygons, polygons.pieces));
        Self([
            plan(faces, capacity, blocks),
            plan(edges, capacity, blocks),
            plan(std::slice::from_ref(&(0..polygons)), pieces, 0),
        ])
    }

    fn of(&self, over: Over, batch: usize) -> &[BatchItems] {
        self.0[over as usize].get(batch).map_or(&[], Vec::as_slice)
    }
}

/// Binds the stages of an extraction.
pub(super) struct Binder<'a> {
    pub(super) pipelines: &'a Pipelines,
    pub(super) shape: &'a Shape,
    pub(super) buffers: &'a Buffers,
    pub(super) ranges: &'a DispatchRanges,
    /// The windows of facing masks.
    pub(super) facing: &'a Windows,
    /// Positions, for stages that read them.
    pub(super) positions: Option<(&'a wgpu::Buffer, &'a BoundPositions)>,
}

impl<'a> Binder<'a> {
    fn get(&self, name: &str, at: &BatchItems) -> Option<Resource<'a>> {
        let Self { buffers, positions, .. } = *self;
        let polygons = buffers.polygons.as_ref();
        let of_batch = |buffers: &'a [wgpu::Buffer]| buffers.get(at.batch);
        // Stages of polygons find the triangles of a polygon anywhere.
        let of_faces = |buffer: &'a wgpu::Buffer, bytes: u64, all: usize| {
            if polygons.is_some() { part(buffer, 0..bytes * all as u64) } else { part(buffer, at.bytes(bytes)) }
        };
        let Shape { faces, face_words, lists_head, max_lights, .. } = *self.shape;
        let or_unused = |resource: Option<Resource<'a>>| resource.unwrap_or_else(|| whole(&buffers.unused));
        Some(match name {
            "batch" => uniform::<LightBatch>(&buffers.light_batches, (at.batch * BATCH_STRIDE) as u32),
            "chunk" => uniform::<Chunk>(&buffers.chunks, at.chunk),
            // A scene has more slots than faces.
            "faces" if polygons.is_some() => whole(&buffers.faces),
            "faces" => part(&buffers.faces, at.bytes(12)),
            "facing_masks" => of_faces(of_batch(&buffers.facing)?, 4, face_words),
            "excluded_masks" => or_unused(of_batch(&buffers.excluded).map(|masks| of_faces(masks, 4, faces))),
            // Its length is the number of undecided faces that shaders have room for.
            "record" => part(&buffers.record, 0..self.shape.record_bytes()),
            "edge_faces" => part(&buffers.edge_faces, at.bytes(8)),
            "edge_corners" => part(buffers.edge_corners.as_ref()?, at.bytes(16)),
            // Each batch has one, or all share one.
            "masks" => {
                let masks = of_batch(&buffers.masks).or(buffers.masks.first());
                or_unused(masks.map(|masks| part(masks, at.bytes(size_of::<EdgeMasks>() as u64))))
            }
            "counts" => part(&buffers.counts, 0..4 * max_lights as u64),
            "block_offsets" => whole(&buffers.block_offsets),
            "list" => or_unused(of_batch(&buffers.lists).map(|list| part(list, lists_head..list.size()))),
            "shape" => uniform::<DrawShape>(&buffers.draw_shape, 0),
            "draw_arguments" => whole(&buffers.draw_arguments),
            "statistics" => part(&buffers.record, 0..size_of::<ExtractionStatistics>() as u64),
            "boundaries" => whole(&polygons?.boundaries),
            "undecided" => whole(&polygons?.undecided),
            "pieces" => or_unused(of_batch(&polygons?.pieces).map(whole)),
            _ => match self.facing.named("facing_", name) {
                Some(window) => part(of_batch(&buffers.facing)?, window),
                None => positions.and_then(|(buffer, bound)| bound.named(name, buffer))?,
            },
        })
    }

    /// A pass of a stage over ranges of its items.
    fn pass(&self, planned: &Planned, ranges: &[BatchItems]) -> Step {
        let pipeline = self.pipelines.get(&planned.program);
        pipeline.pass(ranges.iter().map(|range| self.dispatch(planned.size, &pipeline, range)))
    }

    fn dispatch(&self, size: Size, pipeline: &Pipeline, at: &BatchItems) -> Dispatch {
        let device = self.pipelines.device();
        let workgroups = match size {
            // Chunks of faces and edges are one row.
            Size::Items => Workgroups::over(device, (at.items.len() as u32).div_ceil(WORKGROUP)),
            Size::Few => Workgroups::Known([exact_workgroups(device, at.items.len() as u32, EXACT_ITEMS), 1]),
            Size::Lights => self.in_turn(self.shape.batch_lights(at.batch)),
            Size::Written(byte) => match &self.buffers.polygons {
                Some(polygons) => Workgroups::Written(polygons.arguments.clone(), byte),
                None => Workgroups::Known([0, 0]),
            },
        };
        pipeline.dispatch(device, workgroups, |name| self.get(name, at))
    }

    /// Workgroups. If the device allows fewer, they take several items in turn.
    fn in_turn(&self, wanted: usize) -> Workgroups {
        let most = self.pipelines.device().limits().max_compute_workgroups_per_dimension;
        Workgroups::Known([(wanted as u32).min(most), 1])
    }

    /// The stages that read positions, for a batch of lights.
    pub(super) fn read_positions(&self, stages: &[Planned], batch: usize) -> Vec<Step> {
        if let Some(polygons) = &self.buffers.polygons {
            return self.read_boundaries(polygons, stages, batch);
        }
        let mut steps: Vec<Step> = self.buffers.excluded.get(batch).map(Step::clear).into_iter().collect();
        let over = stages.first().map_or(Over::Faces, |planned| planned.over);
        // Each chunk goes through all stages in turn, because all share the list of undecided faces.
        for (number, range) in self.ranges.of(over, batch).iter().enumerate() {
            if (batch, number) != (0, 0) {
                steps.push(Step::Clear(self.buffers.record.clone(), RECORD_HEAD - 4..RECORD_HEAD));
            }
            steps.extend(stages.iter().map(|planned| self.pass(planned, std::slice::from_ref(range))));
        }
        steps
    }

    /// The stages of polygons. The workgroups of most are in the head of a buffer that they write, which a dispatch
    /// cannot take them from. So they are copied as soon as they are there.
    fn read_boundaries(&self, polygons: &PolygonBuffers, stages: &[Planned], batch: usize) -> Vec<Step> {
        let PolygonBuffers { undecided, head, arguments, pieces, .. } = polygons;
        let bytes = 4 * self.shape.faces as u64;
        let mut steps: Vec<Step> = self.buffers.excluded.get(batch).map(Step::clear).into_iter().collect();
        if let Some(facing) = self.buffers.facing.get(batch) {
            // The twisted masks. `POLYGON_MASKS` writes only those of undecided polygons.
            steps.push(Step::Clear(facing.clone(), bytes..facing.size()));
        }
        steps.extend(pieces.get(batch).map(|pieces| Step::Clear(pieces.clone(), 0..4 * PIECE_COUNTS)));
        steps.push(Step::Copy([(head.clone(), 0), (undecided.clone(), 0)], 4 * HEAD_WORDS));
        let mut copied = Vec::new();
        for planned in stages {
            if let Size::Written(byte) = planned.size
                && !copied.contains(&byte)
            {
                copied.push(byte);
                steps.push(Step::Copy([undecided, arguments].map(|buffer| (buffer.clone(), byte)), INDIRECT_BYTES));
            }
            steps.push(self.pass(planned, self.ranges.of(Over::Polygons, batch)));
        }
        steps
    }

    /// The stages after facing, for a batch of lights.
    pub(super) fn read_facing(&self, stages: &[Planned], batch: usize) -> Vec<Step> {
        let ranges = |planned: &Planned| {
            let ranges = self.ranges.of(planned.over, batch);
            if let Size::Lights = planned.size { ranges.get(..1).unwrap_or_default() } else { ranges }
        };
        stages.iter().map(|planned| self.pass(planned, ranges(planned))).collect()
    }

    /// The draw arguments of all lights that there is room for, so that unused lights draw nothing. Then the statistics.
    pub(super) fn at_last(&self, options: &ExtractorOptions) -> Vec<Step> {
        let Buffers { record, statistics, .. } = self.buffers;
        let get = |name: &str| self.get(name, &BatchItems::default());
        let pass = arguments(options).map(|program| {
            let pipeline = self.pipelines.get(&program);
            let workgroups = self.in_turn(self.shape.max_lights.div_ceil(64));
            pipeline.pass([pipeline.dispatch(self.pipelines.device(), workgroups, get)])
        });
        let copy = Step::Copy([record, statistics].map(|buffer| (buffer.clone(), 0)), statistics.size());
        pass.into_iter().chain([copy]).collect()
    }
}

const BATCH_STRIDE: usize = UniformTable::stride::<LightBatch>();
