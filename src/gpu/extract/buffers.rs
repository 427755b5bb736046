//! The buffers of an extraction and their sizes.

use wgpu::BufferUsages;

use super::errors::ExtractorError;
use super::options::ExtractorOptions;
use super::polygon_buffers::{PolygonBuffers, PolygonShape, faces_of_records};
use crate::cpu::extract::per_edge::edge_corners;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, buffer, check, filled, guarded, padded};
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::{Chunk, DrawArguments, EdgeMasks, ExtractionStatistics, LightBatch};
use crate::method::Predicate;
use crate::{Mesh, light};

/// The numbers that all sizes follow from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) vertices: u32,
    pub(crate) faces: usize,
    pub(crate) edges: usize,
    pub(crate) max_lights: usize,
    /// Entries that the list of each light has room for. It is 0 without lists.
    pub(crate) capacity: u32,
    /// Blocks of edges that compaction counts.
    pub(crate) blocks: u32,
    /// Faces that the list of undecided faces has room for. It is 0 without exact facing.
    pub(crate) undecided: usize,
    /// Facing masks, and twisted masks if there are polygons.
    pub(crate) face_words: usize,
    pub(crate) polygons: Option<PolygonShape>,
}

impl Shape {
    pub(crate) fn new(mesh: &Mesh, options: &ExtractorOptions, split: &DispatchLimits) -> Result<Self, ExtractorError> {
        let edges = mesh.edges().len();
        let batch = options.max_lights.min(32) as u64;
        let fitting = u32::try_from(split.binding / (4 * batch)).unwrap_or(u32::MAX);
        let capacity = match options.lists {
            None => 0,
            Some(lists) => match lists.capacity {
                Some(capacity) => capacity,
                None => default_capacity(mesh, options.max_lights).min(fitting),
            }
            .clamp(1, edges.max(1) as u32),
        };
        if capacity > fitting {
            let bytes = u64::from(capacity) * 4 * batch;
            return Err(DeviceError::BindingTooLarge { what: "edge lists", bytes, limit: split.binding }.into());
        }
        let polygons = mesh
            .polygons()
            .map(|polygons| PolygonShape::new(polygons, options.max_lights, options.lists.is_some(), split.binding));
        let polygons = polygons.transpose()?;
        Ok(Self {
            vertices: mesh.vertex_count(),
            faces: mesh.faces().len(),
            edges,
            max_lights: options.max_lights,
            capacity,
            blocks: edges.div_ceil(crate::gpu::common::dispatch_limits::WORKGROUP as usize) as u32,
            undecided: undecided_capacity(mesh, options, split),
            face_words: mesh.faces().len() * if polygons.is_some() { 2 } else { 1 },
            polygons,
        })
    }

    /// The number of batches of 32 lights.
    pub(crate) fn batches(&self) -> usize {
        light::batches(self.max_lights)
    }

    /// The largest number of lights in a batch.
    pub(crate) fn batch_lights(&self, batch: usize) -> usize {
        (self.max_lights - 32 * batch).min(32)
    }
}

/// All boundary and inconsistent edges have room. Consistent edges share lists of 16 bytes for each edge in total, so
/// every edge has room for up to four lights. Each light has room for at least sixteen times the square root of their
/// number, which is a few times the silhouette of a smooth surface.
fn default_capacity(mesh: &Mesh, lights: usize) -> u32 {
    let counts = mesh.edges().counts();
    let smooth = 16 * counts.consistent.isqrt();
    let shared = 4 * counts.consistent / lights.max(1);
    (counts.boundary + counts.inconsistent + smooth.max(shared).max(1024).min(counts.consistent)) as u32
}

/// Bytes before the undecided faces of a `FacingRecord`: the statistics, and how many faces are undecided.
pub(crate) const RECORD_HEAD: u64 = size_of::<ExtractionStatistics>() as u64 + 4;

/// Room for all faces of one dispatch, unless the options ask for less.
fn undecided_capacity(mesh: &Mesh, options: &ExtractorOptions, split: &DispatchLimits) -> usize {
    if mesh.polygons().is_some() || options.method().predicate(options.predicate) != Predicate::Exact {
        return 0;
    }
    let fitting = ((split.binding - RECORD_HEAD) / 4) as usize;
    let asked = options.undecided_capacity.map_or(usize::MAX, |capacity| capacity.max(1) as usize);
    asked.min(mesh.faces().len()).min(fitting)
}

/// The buffers of an extraction. A `Vec` has one buffer for each batch of lights.
#[derive(Debug)]
pub(crate) struct Buffers {
    pub(crate) faces: wgpu::Buffer,
    pub(crate) edge_vertices: wgpu::Buffer,
    pub(crate) edge_faces: wgpu::Buffer,
    /// For the per-edge method.
    pub(crate) edge_corners: Option<wgpu::Buffer>,
    pub(crate) facing: Vec<wgpu::Buffer>,
    /// For which lights a face is excluded; with lists, for shadow volumes.
    pub(crate) excluded: Vec<wgpu::Buffer>,
    /// Empty, one buffer that all batches share for compaction, or one for each batch if the masks are asked for.
    pub(crate) masks: Vec<wgpu::Buffer>,
    pub(crate) lists: Vec<wgpu::Buffer>,
    pub(crate) places: wgpu::Buffer,
    pub(crate) counts: wgpu::Buffer,
    pub(crate) draw_arguments: wgpu::Buffer,
    pub(crate) statistics: wgpu::Buffer,
    /// A `FacingRecord`: the statistics while they are counted, and the undecided faces of exact facing.
    pub(crate) record: wgpu::Buffer,
    pub(crate) polygons: Option<PolygonBuffers>,
    /// A buffer for bindings that a stage does not use.
    pub(crate) unused: wgpu::Buffer,
}

impl Buffers {
    /// `chunks` are the chunks of the dispatches of a batch of lights.
    pub(crate) fn new(
        device: &wgpu::Device,
        mesh: &Mesh,
        shape: &Shape,
        options: &ExtractorOptions,
        split: &DispatchLimits,
        chunks: usize,
    ) -> Result<Self, DeviceError> {
        let batches = shape.batches();
        let per_edge = options.method().is_per_edge();
        let ordered = options.lists.is_some_and(|lists| lists.ordered);
        let mask_planes = if options.masks { batches } else { usize::from(ordered) };
        let list_bytes = |batch: usize| u64::from(shape.capacity) * 4 * shape.batch_lights(batch) as u64;
        let lists = if options.lists.is_some() { batches } else { 0 };
        let [edges, faces, face_words] = [shape.edges, shape.faces, shape.face_words].map(|count| count as u64);
        let lights = shape.max_lights as u64;
        let places_bytes = if ordered { u64::from(shape.blocks) * 32 * 4 } else { 0 };
        let record_bytes = RECORD_HEAD + 4 * shape.undecided.max(1) as u64;
        let excluded = if lists > 0 && !per_edge { batches } else { 0 };
        // These buffers are bound whole. All others are bound in chunks or windows.
        let mut bound_whole = vec![
            ("places", places_bytes),
            ("counts", lights * 4),
            ("draw arguments", lights * size_of::<DrawArguments>() as u64),
        ];
        if let Some(polygons) = &shape.polygons {
            bound_whole.extend(polygons.bound_whole());
            bound_whole.extend((0..batches).filter_map(|batch| polygons.pieces(shape.batch_lights(batch))));
        }
        // `wanted` has these, too.
        let of_polygons = [("facing masks", face_words * 4), ("faces", faces * 12)];
        let of_polygons = of_polygons.iter().filter(|_| shape.polygons.is_some());
        if let Some(&(what, bytes)) =
            bound_whole.iter().chain(of_polygons).find(|&&(_, bytes)| padded(bytes) > split.binding)
        {
            let limit = split.binding;
            return Err(DeviceError::BindingTooLarge { what, bytes, limit });
        }

        let mut wanted = vec![("faces", faces * 12), ("edge vertices", edges * 8), ("edge faces", edges * 8)];
        wanted.extend(per_edge.then_some(("edge corners", edges * 16)));
        wanted.extend((0..if per_edge { 0 } else { batches }).map(|_| ("facing masks", face_words * 4)));
        wanted.extend((0..mask_planes).map(|_| ("edge masks", edges * size_of::<EdgeMasks>() as u64)));
        wanted.extend((0..lists).map(|batch| ("edge lists", list_bytes(batch))));
        wanted.extend((0..excluded).map(|_| ("excluded masks", faces * 4)));
        wanted.push(("undecided faces", record_bytes));
        wanted.extend(bound_whole);
        wanted.push(("light batches", (batches * UniformTable::stride::<LightBatch>()) as u64));
        wanted.push(("chunks", (batches * chunks * UniformTable::stride::<Chunk>()) as u64));
        let allocations: Vec<_> =
            wanted.iter().map(|&(label, bytes)| Allocation { label, bytes: padded(bytes) }).collect();
        let bytes = check(&allocations, split.buffer, options.memory_limit)?;

        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let result = storage | BufferUsages::COPY_DST;
        guarded(device, bytes, || Self {
            faces: filled(device, "faces", bytemuck::cast_slice(mesh.faces()), storage),
            edge_vertices: filled(device, "edge vertices", bytemuck::cast_slice(mesh.edges().vertices()), storage),
            edge_faces: filled(
                device,
                "edge faces",
                bytemuck::cast_slice(faces_of_records(mesh).as_deref().unwrap_or(mesh.edges().packed_faces())),
                storage,
            ),
            edge_corners: per_edge
                .then(|| filled(device, "edge corners", bytemuck::cast_slice(&edge_corners(mesh)), storage)),
            facing: (0..if per_edge { 0 } else { batches })
                .map(|_| buffer(device, "facing masks", face_words * 4, result))
                .collect(),
            excluded: (0..excluded).map(|_| buffer(device, "excluded masks", faces * 4, result)).collect(),
            masks: (0..mask_planes)
                .map(|_| buffer(device, "edge masks", edges * size_of::<EdgeMasks>() as u64, result))
                .collect(),
            lists: (0..lists).map(|batch| buffer(device, "edge lists", list_bytes(batch), result)).collect(),
            places: buffer(device, "places", places_bytes, storage),
            counts: buffer(device, "counts", lights * 4, result),
            draw_arguments: buffer(
                device,
                "draw arguments",
                lights * size_of::<DrawArguments>() as u64,
                result | BufferUsages::INDIRECT,
            ),
            statistics: buffer(device, "statistics", size_of::<ExtractionStatistics>() as u64, result),
            record: buffer(device, "undecided faces", record_bytes, result),
            polygons: mesh.polygons().zip(shape.polygons).map(|(polygons, polygon_shape)| {
                PolygonBuffers::new(
                    device,
                    polygons,
                    polygon_shape,
                    (0..batches).map(|batch| shape.batch_lights(batch)),
                )
            }),
            unused: buffer(device, "unused", 64, result),
        })
    }
}
