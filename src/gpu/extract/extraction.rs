//! The result of one encode, and the buffers that hold it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use super::buffers::{Buffers, Shape};
use super::errors::ExtractorError;
use crate::gpu::common::cache::lock;
use crate::gpu::common::dispatch_limits::{DispatchLimits, Windows};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::PositionBuffer;
use crate::mesh::MeshId;
use crate::{Light, light};

/// State that an extractor and its extractions share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) pipelines: Pipelines,
    pub(crate) limits: DispatchLimits,
    pub(crate) shape: Shape,
    pub(crate) buffers: Buffers,
    /// The windows of facing masks.
    pub(super) facing: Windows,
    pub(crate) mesh: MeshId,
    /// Whether the masks were requested.
    pub(crate) has_masks: bool,
    /// Vertices of the draw of each edge; 0 without lists.
    pub(crate) vertices_per_edge: u32,
    pub(super) encodes: AtomicU64,
    pub(super) include_groups: Mutex<Vec<IncludeGroup>>,
}

/// A cached bind group of the include.
#[derive(Debug)]
pub(super) struct IncludeGroup {
    layout: wgpu::BindGroupLayout,
    batch: usize,
    /// The number of the batch's lights.
    lights: usize,
    positions: PositionSlice,
    group: wgpu::BindGroup,
}

/// The most cached bind groups of the include. A program has one layout, or a few.
const CACHED_GROUPS: usize = 64;

/// The part of a position buffer that an encode read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PositionSlice {
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) offset: u64,
    pub(crate) stride: u64,
}

impl PositionSlice {
    pub(crate) fn of(positions: PositionBuffer<'_>) -> Self {
        let PositionBuffer { buffer, offset, stride } = positions;
        Self { buffer: buffer.clone(), offset, stride }
    }

    pub(crate) fn as_buffer(&self) -> PositionBuffer<'_> {
        PositionBuffer { buffer: &self.buffer, offset: self.offset, stride: self.stride }
    }
}

impl Shared {
    pub(crate) fn device(&self) -> &wgpu::Device {
        self.pipelines.device()
    }

    pub(crate) fn results(&self) -> ExtractionResults<'_> {
        let Buffers { edge_vertices, edge_faces, facing, masks, lists, counts, draw_arguments, statistics, .. } =
            &self.buffers;
        ExtractionResults {
            edge_vertices,
            edge_faces,
            facing,
            masks: if self.has_masks { masks } else { &[] },
            lists,
            capacity: self.shape.capacity,
            counts,
            draw_arguments,
            statistics,
        }
    }
}

/// The buffers that hold the results of an extraction. All have usages `STORAGE`, `COPY_SRC` and `COPY_DST`. Light `l`
/// is bit `l mod 32`, least significant bit first, of batch `l div 32`. Each batch of lights has its own buffers.
#[derive(Clone, Copy, Debug)]
pub struct ExtractionResults<'a> {
    /// The vertices `(a, b)` of each edge record: two `u32`.
    pub edge_vertices: &'a wgpu::Buffer,
    /// The faces of each edge record: two `u32`. See [`crate::mesh::EdgeRecords::packed_faces`]. In a mesh of polygons, the
    /// first triangle of a polygon stands for it.
    pub edge_faces: &'a wgpu::Buffer,
    /// One buffer for each batch, with a facing mask for each face, or for each triangle of a mesh of polygons: one
    /// `u32`. Empty for the per-edge method. Triangles of a polygon have the same mask, and after all masks come as
    /// many masks of the lights for which the polygon is twisted.
    /// [`Polygons::masks_of`](crate::mesh::Polygons::masks_of) makes one a polygon of them.
    pub facing: &'a [wgpu::Buffer],
    /// One buffer for each batch, with an [`EdgeMasks`](crate::gpu::EdgeMasks) for each edge record. Empty unless
    /// requested.
    pub masks: &'a [wgpu::Buffer],
    /// One buffer for each batch, with [`Self::capacity`] entries for each of its lights. An entry is one `u32`: the
    /// index of an edge record, with the winding bit as bit 31. Entries past the light's count have no meaning. Empty
    /// without lists.
    pub lists: &'a [wgpu::Buffer],
    /// Entries that the list of each light has room for. 0 without lists.
    pub capacity: u32,
    /// One `u32` for each light of all batches: the number of its silhouette edges, or 0 without lists. The list overflowed
    /// if it is more than the capacity.
    pub counts: &'a wgpu::Buffer,
    /// A [`DrawArguments`](crate::gpu::DrawArguments) for each light of all batches. Usage `INDIRECT`, too. The draw of
    /// a list that overflowed goes over all edge records, see [`crate::gpu::include_wgsl`]. All are 0 without lists.
    pub draw_arguments: &'a wgpu::Buffer,
    /// One [`ExtractionStatistics`](crate::gpu::ExtractionStatistics).
    pub statistics: &'a wgpu::Buffer,
}

/// The result of one [`Extractor::encode`](crate::gpu::Extractor::encode): a mesh, at these positions, for these
/// lights. Everything that reads the results takes this value, so it cannot be given other positions or lights by
/// mistake. A later encode of the same extractor overwrites the results. This value is then refused with
/// [`ExtractorError`].
///
/// A clone is cheap. It keeps the extractor's buffers alive.
#[derive(Clone, Debug)]
pub struct Extraction {
    pub(crate) shared: Arc<Shared>,
    pub(crate) positions: PositionSlice,
    lights: Arc<[Light]>,
    encode: u64,
}

impl Extraction {
    pub(crate) fn new(shared: Arc<Shared>, positions: PositionSlice, lights: &[Light], encode: u64) -> Self {
        Self { shared, positions, lights: lights.into(), encode }
    }

    /// The lights, in the order of their bits in the masks.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// The positions that the extraction was made from.
    pub fn positions(&self) -> PositionBuffer<'_> {
        self.positions.as_buffer()
    }

    /// The number of batches of 32 lights: ⌈lights / 32⌉.
    pub fn batches(&self) -> usize {
        light::batches(self.lights.len())
    }

    /// The buffers that hold the results once the encoder is submitted.
    ///
    /// # Errors
    /// [`ExtractorError`] if a later encode overwrites them.
    pub fn results(&self) -> Result<ExtractionResults<'_>, ExtractorError> {
        self.check_current()?;
        Ok(self.shared.results())
    }

    /// Draws the silhouette of light number `light` by an indirect draw. Each edge is an instance.
    /// [`ListOptions::topology`](crate::gpu::ListOptions::topology) says which vertices it has.
    /// The caller sets pipeline and bind groups; [`Self::bind_group`] makes the one that the include reads.
    ///
    /// # Errors
    /// [`ExtractorError`] if the light was not extracted, there are no lists, or a later encode overwrites the
    /// results. Nothing is drawn then.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), ExtractorError> {
        let (arguments, offset) = self.draw_arguments(light)?;
        pass.draw_indirect(arguments, offset);
        Ok(())
    }

    /// The buffer with the [`DrawArguments`](crate::gpu::DrawArguments) of light number `light`, and their offset in
    /// bytes. It is for callers that record their own draws.
    ///
    /// # Errors
    /// The errors of [`Self::draw`].
    pub fn draw_arguments(&self, light: usize) -> Result<(&wgpu::Buffer, u64), ExtractorError> {
        self.check_current()?;
        let lights = self.lights.len();
        if self.shared.buffers.lists.is_empty() {
            return Err(ExtractorError::NoLists);
        }
        if light >= lights {
            return Err(ExtractorError::NoSuchLight { light, lights });
        }
        Ok((&self.shared.buffers.draw_arguments, (light * size_of::<crate::layout::DrawArguments>()) as u64))
    }

    /// The bind group with which a shader reads the results of lights `32 · batch` to `32 · batch + 31`, through
    /// [`include_wgsl`](crate::gpu::include_wgsl). It includes the positions of the extraction. `layout` is that of
    /// [`results_bind_group_layout`](crate::gpu::results_bind_group_layout). Bind groups are cached, so the same call
    /// gives the same group.
    ///
    /// # Errors
    /// [`ExtractorError`] if the extractor lacks what the include reads, an array does not fit one binding, there is no
    /// such batch, a later encode overwrites the results, or the buffer of the positions was destroyed.
    pub fn bind_group(&self, layout: &wgpu::BindGroupLayout, batch: usize) -> Result<wgpu::BindGroup, ExtractorError> {
        self.check_current()?;
        let batches = self.batches();
        if batch >= batches {
            return Err(ExtractorError::NoSuchBatch { batch, batches });
        }
        // The extractor may have room for more.
        let lights = (self.lights.len() - 32 * batch).min(32);
        let mut cached = lock(&self.shared.include_groups);
        let is_it = |made: &&IncludeGroup| {
            (made.batch, made.lights) == (batch, lights) && made.positions == self.positions && made.layout == *layout
        };
        if let Some(made) = cached.iter().find(is_it) {
            // The buffer may have been destroyed since. A group that binds it would spoil the caller's submission.
            self.shared.pipelines.check_bindable(&self.positions.buffer)?;
            return Ok(made.group.clone());
        }
        let group = self.shared.include_group(layout, batch, lights, self.positions.as_buffer())?;
        // Positions that an encode read before are unlikely to come again.
        cached.retain(|made| made.positions == self.positions);
        if cached.len() >= CACHED_GROUPS {
            cached.remove(0);
        }
        cached.push(IncludeGroup {
            layout: layout.clone(),
            batch,
            lights,
            positions: self.positions.clone(),
            group: group.clone(),
        });
        Ok(group)
    }

    pub(crate) fn check_current(&self) -> Result<(), ExtractorError> {
        if self.shared.encodes.load(Ordering::Relaxed) == self.encode { Ok(()) } else { Err(ExtractorError::Stale) }
    }
}
