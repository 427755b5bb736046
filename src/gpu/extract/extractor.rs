//! The extraction stages: facing, edges, compaction, draw arguments.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use super::buffers::{Buffers, RECORD_HEAD, Shape};
use super::errors::ExtractorError;
use super::extraction::{Extraction, ExtractionResults, PositionSlice, Shared};
use super::options::ExtractorOptions;
use super::stages::{Binder, DispatchRanges, Planned, arguments, from_facing, from_positions, programs};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::pass::{Step, record};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::{self, BoundPositions, PositionBuffer};
use crate::gpu::common::requirements::{Subject, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, upload};
use crate::layout::LightBatch;
use crate::light::{self, check_lights};
use crate::method::Predicate;
use crate::{Light, Mesh};

/// Extracts the silhouettes of one mesh every frame, for up to `max_lights` lights. It records compute passes into the
/// caller's encoder. The results stay in GPU buffers, see [`Extraction::results`].
#[derive(Debug)]
pub struct Extractor {
    shared: Arc<Shared>,
    options: ExtractorOptions,
    ranges: DispatchRanges,
    /// For each batch of lights the steps that read positions, and the positions that they are bound to.
    from_positions: Option<(PositionSlice, Vec<Vec<Step>>)>,
    /// The steps before all stages, for each batch those after facing, and the last.
    before: [Step; 2],
    from_facing: Vec<Vec<Step>>,
    at_last: Vec<Step>,
}

impl Extractor {
    /// Uploads the topology of the mesh and makes the result buffers on the caller's device. `pipelines` is that
    /// device, or the [`Pipelines`] that many meshes share.
    ///
    /// # Errors
    /// [`ExtractorError`] if the device lacks what extraction needs, the number of lights is impossible, or the mesh
    /// does not fit the device's limits, the `memory_limit` or the device's memory. Polygons of
    /// [`Mesh::from_polygons_by_loop`](crate::Mesh::from_polygons_by_loop) need exact facing masks, and boundaries of
    /// at most [`MAX_BOUNDARY_EDGES`](crate::gpu::MAX_BOUNDARY_EDGES) edges.
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
        let per_edge = options.method.is_per_edge();
        if mesh.polygons().is_some() && (per_edge || options.predicate != Predicate::Exact) {
            return Err(ExtractorError::Polygons);
        }
        let split = DispatchLimits::new(&device.limits());
        let shape = Shape::new(mesh, &options, &split)?;
        let faces = split.chunks("faces", shape.faces, 12)?;
        let edges = split.chunks("edge records", shape.edges, if per_edge { 16 } else { 8 })?;
        let facing = split.windows("facing masks", 4 * shape.face_words as u64)?;
        let mut chunks = UniformTable::default();
        let ranges = DispatchRanges::new(&shape, [&faces, &edges], &mut chunks);
        let buffers = Buffers::new(device, mesh, &shape, &options, &split, &chunks)?;

        let (reading, others) = (shape.reading(device, &options, 0), from_facing(&options, facing.words));
        pipelines.make_together(&programs([&reading, &others], arguments(&options)));
        // If the device refuses one, the error is that of this constructor.
        for planned in &reading {
            pipelines.get(&planned.program);
        }
        let binder = Binder {
            pipelines: &pipelines,
            shape: &shape,
            buffers: &buffers,
            ranges: &ranges,
            facing: &facing,
            positions: None,
        };
        let from_facing = (0..shape.batches()).map(|batch| binder.read_facing(&others, batch)).collect();
        let at_last = binder.at_last(&options);
        let before = [Step::Clear(buffers.record.clone(), 0..RECORD_HEAD), Step::clear(&buffers.counts)];
        let shared = Arc::new(Shared {
            pipelines,
            limits: split,
            shape,
            buffers,
            facing,
            mesh: mesh.id,
            has_masks: options.masks,
            vertices_per_edge: options.lists.map_or(0, |lists| lists.topology.vertices()),
            encodes: AtomicU64::new(0),
            include_groups: Mutex::default(),
        });
        Ok(Self { shared, options, ranges, from_positions: None, before, from_facing, at_last })
    }

    /// Records the extraction for `lights` and returns what was extracted. Lights are in the space of the positions. No
    /// lights are allowed; then no edge is a silhouette. Lights past those given have empty draws. Their bits are 0 in the
    /// batch of the last light given; later batches keep the masks of an earlier encode. One encoder may hold several
    /// encodes. Each sees its own lights and overwrites the results of the one before.
    ///
    /// # Errors
    /// [`ExtractorError`] if lights or positions are refused, or the device is lost. Nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        lights: &[Light],
    ) -> Result<Extraction, ExtractorError> {
        self.encode_timed(encoder, positions, lights, None)
    }

    /// The same with a timestamp around each stage.
    ///
    /// # Errors
    /// The errors of [`Self::encode`], and [`ExtractorError::Device`] for a timer of another device.
    pub fn encode_timed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        lights: &[Light],
        timer: Option<&mut StageTimer>,
    ) -> Result<Extraction, ExtractorError> {
        check_lights(lights, self.options.max_lights)?;
        check_timer(timer.as_deref(), self.shared.device())?;
        let bound = positions.bind(self.shared.shape.vertices, &self.shared.limits)?;
        let slice = PositionSlice::of(positions);
        self.bind_positions(&slice, &bound)?;

        let mut batches = UniformTable::default();
        for lights in lights.chunks(32) {
            batches.push(&LightBatch::new(lights, bound.offset_words, bound.stride_words));
        }
        upload(self.shared.device(), encoder, &[(&self.shared.buffers.light_batches, batches.bytes())])?;
        // Compaction counts in one buffer that all batches share, and so do the masks if they are not requested. Each
        // batch of lights then goes through all stages alone.
        let from_positions = self.from_positions.iter().flat_map(|(_, batches)| batches);
        let of_batches = from_positions.zip(&self.from_facing).take(light::batches(lights.len()));
        let of_batches = of_batches.flat_map(|(first, then)| first.iter().chain(then));
        record(self.before.iter().chain(of_batches).chain(&self.at_last), encoder, timer);
        // The buffers are overwritten from here on, so earlier extractions are out of date.
        let encode = self.shared.encodes.fetch_add(1, Ordering::Relaxed) + 1;
        Ok(Extraction::new(Arc::clone(&self.shared), slice, lights, encode))
    }

    /// Makes the bind groups that read positions, unless they exist for this slice.
    fn bind_positions(&mut self, slice: &PositionSlice, bound: &BoundPositions) -> Result<(), DeviceError> {
        if self.from_positions.as_ref().is_some_and(|(made, _)| made == slice) {
            // The buffer may have been destroyed since. Groups that bind it would spoil the caller's submission.
            return self.shared.pipelines.check_bindable(&slice.buffer);
        }
        self.from_positions = None;
        let Self { shared, options, ranges, .. } = &*self;
        let Shared { pipelines, shape, buffers, facing, .. } = &**shared;
        let positions = Some((&slice.buffer, bound));
        let binder = Binder { pipelines, shape, buffers, ranges, facing, positions };
        let stages = shape.reading(pipelines.device(), options, bound.windows.words);
        let steps = positions::bound(pipelines.device(), || {
            (0..shape.batches()).map(|batch| binder.read_positions(&stages, batch)).collect()
        })?;
        self.from_positions = Some((slice.clone(), steps));
        Ok(())
    }

    /// The buffers that hold the results of the last encode, once its encoder was submitted. They stay the same for the
    /// life of the extractor.
    #[doc(hidden)]
    pub fn results(&self) -> ExtractionResults<'_> {
        self.shared.results()
    }

    /// For each batch of lights one `u32` a face: the lights for which the face is excluded, of the last encode once
    /// submitted. These are the lights in its plane, if facing is exact, and all lights if it has a vertex that is not
    /// finite. Empty unless they are found for volumes.
    #[doc(hidden)]
    pub fn excluded_masks(&self) -> &[wgpu::Buffer] {
        &self.shared.buffers.excluded
    }

    /// For each batch of lights the pieces of twisted polygons, of the last encode once submitted: the number of pieces of
    /// each of 32 lights, then for each light as many pieces as there is room for, of nine words: where it begins, where
    /// it ends, and the middle of its polygon. Empty without polygons, and unless they are found for volumes.
    #[doc(hidden)]
    pub fn pieces(&self) -> &[wgpu::Buffer] {
        self.shared.buffers.polygons.as_ref().map_or(&[], |polygons| &polygons.pieces)
    }

    /// The number of pieces of each light that there is room for.
    #[doc(hidden)]
    pub fn piece_capacity(&self) -> u32 {
        self.shared.shape.polygons.map_or(0, |polygons| polygons.pieces)
    }
}

impl Shape {
    /// The stages that read positions, in windows of this number of words.
    fn reading(&self, device: &wgpu::Device, options: &ExtractorOptions, words: u32) -> Vec<Planned> {
        from_positions(device, options, self.polygons.map(|polygons| polygons.pieces > 0), words)
    }
}
