//! The extraction stages: facing, edges, compaction, draw arguments.

use std::ops::Range;
use std::sync::Arc;

use super::bind_groups::BindGroupBuilder;
use super::buffers::{Buffers, RECORD_HEAD, Shape};
use super::errors::{ExtractionEncodeError, ExtractorError};
use super::extraction::{Extraction, Place, Shared};
use super::options::ExtractorOptions;
use super::polygon_passes::PolygonPasses;
use super::programs;
#[cfg(feature = "reference")]
use super::results::ExtractionResults;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::pass::{Dispatch, Pass};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::{self, BoundPositions, PositionBuffer, PositionError};
use crate::gpu::common::requirements::{Subject, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, upload};
use crate::layout::{Chunk, LightBatch};
use crate::light::{self, check_lights};
use crate::method::Predicate;
use crate::stages::ARGUMENTS;
use crate::turns::EXACT_ITEMS;
use crate::{Light, Mesh};

/// Extracts the silhouettes of one mesh every frame, for up to `max_lights` lights. It records compute passes into the
/// caller's encoder. The results stay in GPU buffers, see [`Extraction::results`].
#[derive(Debug)]
pub struct Extractor {
    shared: Arc<Shared>,
    light_batches: wgpu::Buffer,
    chunks: wgpu::Buffer,
    /// Facing, or the per-edge method. It is bound when the positions are known.
    from_positions: Option<Pass>,
    /// Exact facing, if the options ask for it. It has the dispatches of facing, with fewer workgroups.
    exact: Option<Pass>,
    /// The passes that replace facing and exact facing for a mesh of polygons.
    polygons: Option<PolygonPasses>,
    polygon_dispatches: Vec<Dispatch>,
    /// Edges, compaction and arguments, as the options ask for them, in order.
    from_facing: Vec<Pass>,
    options: ExtractorOptions,
    bound_to: Option<Place>,
}

/// The number of invocations in a workgroup of exact facing.
const EXACT_WORKGROUP: u32 = 64;

/// The number of faces that an invocation of exact facing takes in turn if every face is undecided. See
/// ARCHITECTURE.md, "Exact facing is a direct dispatch". From 4 on, a dispatch has no more workgroups than one of
/// facing.
fn exact_turns(device: &wgpu::Device) -> u32 {
    if device.adapter_info().device_type == wgpu::DeviceType::Cpu { EXACT_ITEMS } else { 4 }
}

impl Extractor {
    /// Uploads the topology of the mesh and makes the result buffers on the caller's device. `pipelines` is that
    /// device, or the [`Pipelines`] that many meshes share.
    ///
    /// # Errors
    /// [`ExtractorError`] if the device lacks what extraction needs, the number of lights is impossible, or the mesh does not
    /// fit the device's limits, the `memory_limit` or the device's memory. Polygons of
    /// [`Mesh::from_polygons_by_loop`](crate::Mesh::from_polygons_by_loop) are taken with exact facing masks only, and with
    /// outlines of at most [`MAX_OUTLINE_EDGES`](crate::gpu::MAX_OUTLINE_EDGES) edges.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        mesh: &Mesh,
        options: ExtractorOptions,
    ) -> Result<Self, ExtractorError> {
        let pipelines = pipelines.into();
        pipelines.clone().construct(Subject::Extract, || Self::with(pipelines, mesh, options))
    }

    fn with(pipelines: Pipelines, mesh: &Mesh, options: ExtractorOptions) -> Result<Self, ExtractorError> {
        let device = pipelines.device();
        light::check_room(options.max_lights)?;
        let per_edge = options.method().is_per_edge();
        if mesh.polygons().is_some() && (per_edge || options.predicate != Predicate::Exact) {
            return Err(ExtractorError::Polygons);
        }
        let split = DispatchLimits::new(&device.limits());
        let shape = Shape::new(mesh, &options, &split)?;
        let face_chunks = split.chunks("faces", shape.faces, 12)?;
        let edge_chunks = split.chunks("edge records", shape.edges, if per_edge { 16 } else { 8 })?;
        let facing_windows = split.windows("facing masks", 4 * shape.face_words as u64)?;
        let buffers = Buffers::new(device, mesh, &shape, &options, &split, face_chunks.len() + edge_chunks.len() + 1)?;

        let mut chunk_table = UniformTable::default();
        let face_dispatches = plan(&shape, &face_chunks, &mut chunk_table);
        let edge_dispatches = plan(&shape, &edge_chunks, &mut chunk_table);
        let polygon_dispatches = plan_polygons(&shape, &mut chunk_table);
        let chunks = chunk_table.into_buffer(device, "chunks");
        let mut light_table = UniformTable::default();
        (0..shape.batches()).for_each(|_| _ = light_table.push(&LightBatch::new(&[], 0, 3)));
        let light_batches = light_table.into_buffer(device, "light batches");

        pipelines.make_together(&programs::all(device, &options, &shape, facing_windows.words));
        let binder = BindGroupBuilder {
            pipelines: &pipelines,
            device,
            shape: &shape,
            buffers: &buffers,
            chunks: &chunks,
            light_batches: &light_batches,
        };
        let polygons = PolygonPasses::new(&binder, &polygon_dispatches, 0);
        let from_positions = polygons.is_none().then(|| Pass {
            pipeline: pipelines.get(&programs::from_positions(&options, 0)),
            dispatches: if per_edge { edge_dispatches.clone() } else { face_dispatches.clone() },
        });
        let is_exact = options.method().predicate(options.predicate) == Predicate::Exact && polygons.is_none();
        let exact = is_exact.then(|| {
            let turns = exact_turns(device);
            let fewer = |dispatch: Dispatch| Dispatch {
                workgroups: (dispatch.items.len() as u32).div_ceil(EXACT_WORKGROUP * turns),
                ..dispatch
            };
            let dispatches = face_dispatches.into_iter().map(fewer).collect();
            Pass { pipeline: pipelines.get(&programs::exact_facing(0)), dispatches }
        });
        let mut from_facing = Vec::new();
        if !per_edge && (options.masks || options.lists.is_some()) {
            from_facing.push(binder.edges(&options, edge_dispatches.clone(), &facing_windows));
        }
        if let Some(lists) = options.lists {
            if lists.ordered {
                from_facing.extend(binder.compact(&edge_dispatches));
            }
            from_facing.push(binder.arguments(lists.vertices_per_edge));
        }
        let shared = Arc::new(Shared::new(pipelines, split, shape, buffers, mesh, &options));
        Ok(Self {
            shared,
            light_batches,
            chunks,
            from_positions,
            exact,
            polygons,
            from_facing,
            polygon_dispatches,
            options,
            bound_to: None,
        })
    }

    /// Records the extraction for `lights` and returns what was extracted. Lights are in the space of the positions. No
    /// lights are allowed; then no edge is a silhouette. Lights past those given keep the masks of an earlier encode,
    /// and their draws are empty. One encoder may hold several encodes. Each sees its own lights and overwrites the
    /// results of the one before.
    ///
    /// `timer` takes a timestamp around each stage.
    ///
    /// # Errors
    /// [`ExtractionEncodeError`] if lights or positions are refused, or the device is lost or not the timer's. Nothing
    /// is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        lights: &[Light],
        mut timer: Option<&mut StageTimer>,
    ) -> Result<Extraction, ExtractionEncodeError> {
        check_lights(lights, self.options.max_lights)?;
        check_timer(timer.as_deref(), self.shared.device())?;
        let bound = positions.bind(self.shared.shape.vertices, &self.shared.limits)?;
        let place = Place::of(positions);
        self.bind_positions(&place, &bound)?;
        let buffers = &self.shared.buffers;

        let mut batches = UniformTable::default();
        for lights in lights.chunks(32) {
            batches.push(&LightBatch::new(lights, bound.offset_words, bound.stride_words));
        }
        upload(self.shared.device(), encoder, &[(&self.light_batches, batches.bytes())])?;
        encoder.clear_buffer(&buffers.record, 0, Some(RECORD_HEAD));
        encoder.clear_buffer(&buffers.counts, 0, None);
        let used = light::batches(lights.len());
        for masks in buffers.excluded.iter().take(used) {
            encoder.clear_buffer(masks, 0, None);
        }
        // Compaction counts in one buffer that all batches share, and so do the masks if nobody asked for them. Each
        // batch of lights then goes through all stages alone.
        let by_batch = self.options.lists.is_some_and(|lists| lists.ordered) || self.polygons.is_some();
        let runs: Vec<Range<usize>> = if by_batch {
            (0..used).map(|batch| batch..batch + 1).collect()
        } else {
            std::iter::once(0..used).filter(|run| !run.is_empty()).collect()
        };
        let (per_light, at_last): (Vec<_>, Vec<_>) =
            self.from_facing.iter().partition(|pass| pass.pipeline.label != ARGUMENTS.name);
        for facing in buffers.facing.iter().take(used).filter(|_| self.polygons.is_some()) {
            // Most polygons are not twisted.
            encoder.clear_buffer(facing, 4 * self.shared.shape.faces as u64, None);
        }
        let is_whole = self.polygons.is_none() && runs.len() <= 1 && self.dispatches_of(0..used) <= 1;
        if is_whole && used > 0 {
            // Nothing comes between the stages.
            let passes = self.from_positions.iter().chain(&self.exact).chain(per_light).chain(at_last);
            Pass::record_all(passes, encoder, 0..used, timer);
            return Ok(self.finish(encoder, place, lights));
        }
        for run in runs {
            if let Some((passes, polygons)) = self.polygons.as_ref().zip(buffers.polygons.as_ref()) {
                passes.record(encoder, polygons, run.start, timer.as_deref_mut());
            }
            match (&self.from_positions, &self.exact) {
                (Some(facing), Some(exact)) => {
                    self.record_exactly(encoder, [facing, exact], run.clone(), timer.as_deref_mut());
                }
                (Some(facing), None) => facing.record(encoder, run.clone(), timer.as_deref_mut()),
                (None, _) => {}
            }
            for pass in &per_light {
                pass.record(encoder, run.clone(), timer.as_deref_mut());
            }
        }
        for pass in at_last {
            // For all lights that there is room for, so that unused lights draw nothing.
            pass.record(encoder, 0..used.max(1), timer.as_deref_mut());
        }
        Ok(self.finish(encoder, place, lights))
    }

    /// Dispatches over faces for some batches.
    fn dispatches_of(&self, batches: Range<usize>) -> usize {
        self.from_positions
            .iter()
            .flat_map(|pass| &pass.dispatches)
            .filter(|dispatch| batches.contains(&dispatch.batch))
            .count()
    }

    fn finish(&self, encoder: &mut wgpu::CommandEncoder, place: Place, lights: &[Light]) -> Extraction {
        let Buffers { record, statistics, .. } = &self.shared.buffers;
        encoder.copy_buffer_to_buffer(record, 0, statistics, 0, statistics.size());
        let encode = self.shared.begin_encode();
        Extraction::new(Arc::clone(&self.shared), place, lights, encode)
    }

    /// Facing and exact facing in turn, because all chunks and batches share the list of undecided faces.
    fn record_exactly(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: [&Pass; 2],
        batches: Range<usize>,
        mut timer: Option<&mut StageTimer>,
    ) {
        for (index, dispatch) in passes[0].dispatches.iter().enumerate() {
            if batches.contains(&dispatch.batch) {
                let undecided_count = RECORD_HEAD - 4;
                encoder.clear_buffer(&self.shared.buffers.record, undecided_count, Some(4));
                for pass in passes {
                    pass.record_one(encoder, index, timer.as_deref_mut());
                }
            }
        }
    }

    /// Makes the bind groups that read positions, unless they exist for this place.
    fn bind_positions(&mut self, place: &Place, bound: &BoundPositions) -> Result<(), PositionError> {
        if self.bound_to.as_ref() == Some(place) {
            return Ok(());
        }
        self.bound_to = None;
        let device = self.shared.device().clone();
        positions::bound(&device, || self.make_position_groups(place, bound))?;
        self.bound_to = Some(place.clone());
        Ok(())
    }

    fn make_position_groups(&mut self, place: &Place, bound: &BoundPositions) {
        let Self { shared, chunks, light_batches, .. } = self;
        let Shared { pipelines, shape, buffers, .. } = &**shared;
        let binder = BindGroupBuilder { pipelines, device: pipelines.device(), shape, buffers, chunks, light_batches };
        if let Some(passes) = &mut self.polygons {
            if passes.window_words() != bound.windows.words
                && let Some(made) = PolygonPasses::new(&binder, &self.polygon_dispatches, bound.windows.words)
            {
                *passes = made;
            }
            passes.bind_positions(&binder, &place.buffer, bound);
            return;
        }
        if let Some(facing) = &mut self.from_positions {
            if facing.pipeline.window_words != bound.windows.words {
                facing.pipeline = pipelines.get(&programs::from_positions(&self.options, bound.windows.words));
            }
            binder.bind_positions(facing, &place.buffer, bound);
        }
        if let Some(exact) = &mut self.exact {
            if exact.pipeline.window_words != bound.windows.words {
                exact.pipeline = pipelines.get(&programs::exact_facing(bound.windows.words));
            }
            binder.bind_positions(exact, &place.buffer, bound);
        }
    }

    /// The buffers that hold the results of the last encode, once its encoder was submitted. They stay the same for the
    /// life of the extractor.
    #[cfg(feature = "reference")]
    pub fn results(&self) -> ExtractionResults<'_> {
        self.shared.results()
    }

    /// For each batch of lights one `u32` a face: the lights for which the face is excluded, of the last encode once
    /// submitted. These are the lights in its plane, if facing is exact, and all lights if it has a vertex that is not
    /// finite. Empty without lists, which shadow volumes need.
    #[cfg(feature = "reference")]
    pub fn excluded_masks(&self) -> &[wgpu::Buffer] {
        &self.shared.buffers.excluded
    }

    /// For each batch of lights the pieces of L-twisted polygons, of the last encode once submitted: the number of pieces of
    /// each of 32 lights, then for each light as many pieces as there is room for, of nine words: where it begins, where
    /// it ends, and the middle of its polygon. Empty without polygons or lists.
    #[cfg(feature = "reference")]
    pub fn pieces(&self) -> &[wgpu::Buffer] {
        self.shared.buffers.polygons.as_ref().map_or(&[], |polygons| &polygons.pieces)
    }

    /// The number of pieces of each light that there is room for.
    #[cfg(feature = "reference")]
    pub fn piece_capacity(&self) -> u32 {
        self.shared.buffers.polygons.as_ref().map_or(0, |polygons| polygons.shape.pieces)
    }

    /// The state that extractions share.
    pub(crate) fn shared(&self) -> &Arc<Shared> {
        &self.shared
    }
}

/// A dispatch for each batch of lights over all polygons.
fn plan_polygons(shape: &Shape, table: &mut UniformTable) -> Vec<Dispatch> {
    let Some(polygons) = &shape.polygons else { return Vec::new() };
    let dispatch = |batch: usize| {
        let chunk = Chunk {
            first: 0,
            count: polygons.polygons as u32,
            first_light: 32 * batch as u32,
            capacity: polygons.pieces,
            blocks: 0,
        };
        Dispatch::over(batch, 0..polygons.polygons, table.push(&chunk))
    };
    (0..shape.batches()).map(dispatch).collect()
}

/// A dispatch for each batch of lights and chunk of items.
fn plan(shape: &Shape, chunks: &[Range<usize>], table: &mut UniformTable) -> Vec<Dispatch> {
    let mut dispatches = Vec::with_capacity(shape.batches() * chunks.len());
    for batch in 0..shape.batches() {
        for items in chunks {
            let chunk_offset = table.push(&Chunk {
                first: items.start as u32,
                count: items.len() as u32,
                first_light: 32 * batch as u32,
                capacity: shape.capacity,
                blocks: shape.blocks,
            });
            dispatches.push(Dispatch::over(batch, items.clone(), chunk_offset));
        }
    }
    dispatches
}
