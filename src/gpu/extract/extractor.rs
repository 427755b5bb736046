//! The extraction: facing, edges, compaction, draw arguments.

use std::ops::Range;
use std::sync::Arc;

use super::bind_groups::Binder;
use super::buffers::{Buffers, Shape, UNDECIDED_HEAD};
use super::extraction::{Extraction, Place, Shared};
use super::results::Results;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::pass::{Dispatch, Pass};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::{BoundPositions, PositionBuffer, PositionError};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, upload};
use crate::layout::{Chunk, LightWord};
use crate::light::{self, LightError, check_lights};
use crate::method::{Method, Predicate};
use crate::stages::ARGUMENTS;
use crate::{Light, Mesh};

/// What an [`Extractor`] finds and keeps.
#[derive(Clone, Copy, Debug)]
pub struct ExtractorOptions {
    /// The most lights of one encode, 1 to [`MAX_LIGHTS`].
    pub max_lights: usize,
    /// How silhouettes are found; with the feature `reference` alone.
    #[cfg(feature = "reference")]
    pub method: Method,
    /// How a face's side is decided. The per-edge method of the feature `reference` is never exact.
    pub predicate: Predicate,
    /// Faces that the list of those the filter leaves undecided has room for. `None`: all of them, 4 bytes a face. A
    /// list that overflows loses nothing: every face then goes through the exact stage, which is slow.
    pub undecided_capacity: Option<u32>,
    /// Keep silhouette and winding masks of every edge record: 8 bytes an edge and word of 32 lights.
    pub masks: bool,
    /// Make lists of silhouette edges; `None` for none.
    pub lists: Option<ListOptions>,
    /// Refuse, before anything is allocated, to take more bytes of device memory than this. wgpu tells no device's
    /// memory, so without it a mesh too large is found out by the device, and what was allocated is given back.
    pub memory_limit: Option<u64>,
}

impl Default for ExtractorOptions {
    /// One light, face masks, exact, lists, no edge masks, no memory limit.
    fn default() -> Self {
        Self {
            max_lights: 1,
            #[cfg(feature = "reference")]
            method: Method::FaceMask,
            predicate: Predicate::Exact,
            undecided_capacity: None,
            masks: false,
            lists: Some(ListOptions::default()),
            memory_limit: None,
        }
    }
}

impl ExtractorOptions {
    /// Face masks, unless the feature `reference` asks for something else.
    pub(crate) const fn method(&self) -> Method {
        #[cfg(feature = "reference")]
        return self.method;
        #[cfg(not(feature = "reference"))]
        Method::FaceMask
    }
}

/// How lists of silhouette edges are made.
#[derive(Clone, Copy, Debug)]
pub struct ListOptions {
    /// Entries that each light's list has room for, clamped to 1 … edge records. `None`: boundary and inconsistent
    /// edges, and of the others a share of four lists of all edges, at least sixteen times their square root. A list
    /// that overflows loses nothing: its draw goes over all edges, of which the include rejects what is no silhouette
    /// (by the facing masks; of the per-edge method, which has none, only the edge masks know), and
    /// [`crate::layout::Statistics`] counts it.
    pub capacity: Option<u32>,
    /// Lists in the order of the edges, the same in every run; costs the masks' memory traffic.
    pub ordered: bool,
    /// `vertex_count` of the draw arguments: 4 for a quad as a strip, 6 as two triangles, 2 for a line.
    pub vertices_per_edge: u32,
}

impl Default for ListOptions {
    /// Capacity by the mesh, unordered, 4 vertices an edge.
    fn default() -> Self {
        Self { capacity: None, ordered: false, vertices_per_edge: 4 }
    }
}

/// Why an extraction cannot be recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// The lights are refused.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The position buffer is refused.
    #[error(transparent)]
    Positions(#[from] PositionError),
}

/// Why an extractor cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExtractorError {
    /// `max_lights` is 0 or more than [`MAX_LIGHTS`].
    #[error(transparent)]
    Light(#[from] LightError),
    /// The mesh does not fit the device.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}

/// Extracts the silhouettes of one mesh, frame after frame, for up to `max_lights` lights. Records compute passes into
/// the caller's encoder; the results stay in GPU buffers, see [`Extractor::results`].
#[derive(Debug)]
pub struct Extractor {
    shared: Arc<Shared>,
    light_words: wgpu::Buffer,
    chunks: wgpu::Buffer,
    /// Facing, or the per-edge method; bound to positions when they are known.
    from_positions: Pass,
    /// Exact facing, where it is wanted; dispatches as those of facing, but of fewer workgroups.
    exact: Option<Pass>,
    /// Edges, compaction, arguments: what the options ask for, in order.
    from_facing: Vec<Pass>,
    options: ExtractorOptions,
    bound_to: Option<Place>,
}

/// Invocations of a workgroup of exact facing.
const EXACT_WORKGROUP: u32 = 64;

/// How many faces an invocation of exact facing takes by turns where every face is undecided; ARCHITECTURE.md, "Where it
/// differs from the design". From 4 on a dispatch has no more workgroups than one of facing.
fn exact_turns(device: &wgpu::Device) -> u32 {
    if device.adapter_info().device_type == wgpu::DeviceType::Cpu { 48 } else { 4 }
}

impl Extractor {
    /// Uploads the mesh's topology and makes result buffers on the caller's device. `pipelines` is that device, or the
    /// [`Pipelines`] that many meshes share.
    ///
    /// # Errors
    /// [`ExtractorError`] for an impossible number of lights, or a mesh that does not fit the device's limits, the
    /// `memory_limit` or its memory.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        mesh: &Mesh,
        options: ExtractorOptions,
    ) -> Result<Self, ExtractorError> {
        Self::with(pipelines.into(), mesh, options)
    }

    fn with(pipelines: Pipelines, mesh: &Mesh, options: ExtractorOptions) -> Result<Self, ExtractorError> {
        let device = pipelines.device();
        light::check_room(options.max_lights)?;
        let split = DispatchLimits::new(&device.limits());
        let shape = Shape::new(mesh, &options, &split)?;
        let per_edge = options.method().is_per_edge();
        let face_chunks = split.chunks("faces", shape.faces, 12)?;
        let edge_chunks = split.chunks("edge records", shape.edges, if per_edge { 16 } else { 8 })?;
        let facing_windows = split.windows("facing masks", 4 * shape.faces as u64)?;
        let buffers = Buffers::new(device, mesh, &shape, &options, &split, face_chunks.len() + edge_chunks.len())?;

        let mut chunk_table = UniformTable::default();
        let face_dispatches = plan(&shape, &face_chunks, &mut chunk_table);
        let edge_dispatches = plan(&shape, &edge_chunks, &mut chunk_table);
        let chunks = chunk_table.into_buffer(device, "chunks");
        let mut light_table = UniformTable::default();
        (0..shape.words()).for_each(|_| _ = light_table.push(&LightWord::new(&[], 0, 3)));
        let light_words = light_table.into_buffer(device, "light words");

        let binder = Binder {
            pipelines: &pipelines,
            device,
            shape: &shape,
            buffers: &buffers,
            chunks: &chunks,
            light_words: &light_words,
        };
        let from_positions = Pass {
            pipeline: binder.positions_pipeline(&options, 0),
            dispatches: if per_edge { edge_dispatches.clone() } else { face_dispatches.clone() },
        };
        let is_exact = options.method().predicate(options.predicate) == Predicate::Exact;
        let exact = is_exact.then(|| {
            let turns = exact_turns(device);
            let fewer = |dispatch: Dispatch| Dispatch {
                workgroups: (dispatch.items.len() as u32).div_ceil(EXACT_WORKGROUP * turns),
                ..dispatch
            };
            let dispatches = face_dispatches.into_iter().map(fewer).collect();
            Pass { pipeline: binder.exact_pipeline(0), dispatches }
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
        let shared = Arc::new(Shared::new(pipelines, split, shape, buffers, mesh, options.masks));
        Ok(Self { shared, light_words, chunks, from_positions, exact, from_facing, options, bound_to: None })
    }

    /// Records the extraction for `lights`, which are in the space of the positions, and returns what was extracted. No
    /// lights are fine: then nothing is a silhouette. Lights past those given keep the masks of an earlier encode, and
    /// their draws are empty. Several encodes in one encoder are fine, too: each sees its own lights, and overwrites the
    /// results of the one before.
    ///
    /// `timer` takes a timestamp around each stage.
    ///
    /// # Errors
    /// [`EncodeError`] when lights or positions are refused; nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        lights: &[Light],
        mut timer: Option<&mut StageTimer>,
    ) -> Result<Extraction, EncodeError> {
        check_lights(lights, self.options.max_lights)?;
        let bound = positions.bind(self.shared.shape.vertices, &self.shared.limits)?;
        let place = Place::of(positions);
        self.bind_positions(&place, &bound);
        let buffers = &self.shared.buffers;

        let mut words = UniformTable::default();
        for lights in lights.chunks(32) {
            words.push(&LightWord::new(lights, bound.offset_words, bound.stride_words));
        }
        upload(self.shared.device(), encoder, &self.light_words, words.bytes());
        encoder.clear_buffer(&buffers.statistics, 0, None);
        encoder.clear_buffer(&buffers.counts, 0, None);
        let used = light::words(lights.len());
        // Compaction counts in one buffer (and masks that nobody asked for are shared, too), so each word of lights goes
        // through all stages by itself there.
        let by_word = self.options.lists.is_some_and(|lists| lists.ordered);
        let runs: Vec<Range<usize>> = if by_word {
            (0..used).map(|word| word..word + 1).collect()
        } else {
            std::iter::once(0..used).filter(|run| !run.is_empty()).collect()
        };
        let (per_light, at_last): (Vec<_>, Vec<_>) =
            self.from_facing.iter().partition(|pass| pass.pipeline.label != ARGUMENTS.name);
        for run in runs {
            match &self.exact {
                None => self.from_positions.record(encoder, run.clone(), timer.as_deref_mut()),
                Some(exact) => self.record_exactly(encoder, exact, run.clone(), timer.as_deref_mut()),
            }
            for pass in &per_light {
                pass.record(encoder, run.clone(), timer.as_deref_mut());
            }
        }
        for pass in at_last {
            // Of all lights there is room for, so that those not used draw nothing.
            pass.record(encoder, 0..used.max(1), timer.as_deref_mut());
        }
        let encode = self.shared.begin_encode();
        Ok(Extraction::new(Arc::clone(&self.shared), place, lights, encode))
    }

    /// Facing and exact facing by turns: all chunks and words share the list of undecided faces.
    fn record_exactly(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        exact: &Pass,
        words: Range<usize>,
        mut timer: Option<&mut StageTimer>,
    ) {
        for (index, dispatch) in self.from_positions.dispatches.iter().enumerate() {
            if words.contains(&dispatch.word) {
                encoder.clear_buffer(&self.shared.buffers.undecided, 0, Some(UNDECIDED_HEAD));
                for pass in [&self.from_positions, exact] {
                    pass.record_one(encoder, index, timer.as_deref_mut());
                }
            }
        }
    }

    /// Makes the bind groups that read positions, unless they are made for this very place already.
    fn bind_positions(&mut self, place: &Place, bound: &BoundPositions) {
        if self.bound_to.as_ref() == Some(place) {
            return;
        }
        let Self { shared, chunks, light_words, .. } = self;
        let Shared { pipelines, shape, buffers, .. } = &**shared;
        let binder = Binder { pipelines, device: pipelines.device(), shape, buffers, chunks, light_words };
        if self.from_positions.pipeline.window_words != bound.windows.words {
            self.from_positions.pipeline = binder.positions_pipeline(&self.options, bound.windows.words);
        }
        binder.bind_positions(&mut self.from_positions, &place.buffer, bound);
        if let Some(exact) = &mut self.exact {
            if exact.pipeline.window_words != bound.windows.words {
                exact.pipeline = binder.exact_pipeline(bound.windows.words);
            }
            binder.bind_positions(exact, &place.buffer, bound);
        }
        self.bound_to = Some(place.clone());
    }

    /// The buffers that hold the results of the last encode once its encoder is submitted. They stay the same for as long as
    /// the extractor lives.
    pub fn results(&self) -> Results<'_> {
        self.shared.results()
    }

    /// What extractions share.
    pub(crate) fn shared(&self) -> &Arc<Shared> {
        &self.shared
    }
}

/// A dispatch for each word of lights and chunk of items.
fn plan(shape: &Shape, chunks: &[Range<usize>], table: &mut UniformTable) -> Vec<Dispatch> {
    let mut dispatches = Vec::with_capacity(shape.words() * chunks.len());
    for word in 0..shape.words() {
        for items in chunks {
            let chunk_offset = table.push(&Chunk {
                first: items.start as u32,
                count: items.len() as u32,
                first_light: 32 * word as u32,
                capacity: shape.capacity,
                blocks: shape.blocks,
            });
            dispatches.push(Dispatch::over(word, items.clone(), chunk_offset));
        }
    }
    dispatches
}
