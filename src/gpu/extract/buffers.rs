//! The buffers of an extraction and their sizes.

use super::errors::ExtractorError;
use super::options::ExtractorOptions;
use super::polygon_buffers::{PolygonBuffers, PolygonCounts, PolygonShape, boundaries, faces_of_records};
use crate::cpu::extract::per_edge::edge_corners;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::{DispatchLimits, WORKGROUP};
use crate::gpu::common::memory::{check, guarded};
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::common::wanted::{Account, Wanted};
use crate::layout::{DrawArguments, DrawShape, EdgeMasks, ExtractionStatistics, LightBatch};
use crate::mesh::EdgeCounts;
use crate::method::Predicate;
use crate::{Mesh, light};

/// The numbers that all sizes follow from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) vertices: u32,
    /// Triangles, in a mesh of polygons too.
    pub(crate) faces: usize,
    pub(crate) edges: usize,
    pub(crate) max_lights: usize,
    /// Entries that the list of each light has room for. It is 0 without lists.
    pub(crate) capacity: u32,
    /// Bytes before the list of the first light.
    pub(crate) lists_head: u64,
    /// Blocks of edges that compaction counts.
    pub(crate) blocks: u32,
    /// Faces that the list of undecided faces has room for. It is 0 without exact facing, and for polygons.
    pub(crate) undecided: usize,
    /// Facing masks, and twisted masks if there are polygons.
    pub(crate) face_words: usize,
    pub(crate) polygons: Option<PolygonShape>,
}

impl Shape {
    pub(crate) fn new(mesh: &Mesh, options: &ExtractorOptions, split: &DispatchLimits) -> Result<Self, ExtractorError> {
        let (edges, counts) = (mesh.edges().len(), mesh.edges().counts());
        let batch = options.max_lights.min(32) as u64;
        let fitting = u32::try_from(split.binding / (4 * batch)).unwrap_or(u32::MAX);
        let default = default_capacity(counts, smooth_edges(counts.consistent), options.max_lights) as u32;
        let asked = options.lists.map(|lists| lists.capacity.unwrap_or(default.min(fitting)));
        let capacity = asked.map_or(0, |capacity| capacity.clamp(1, edges.max(1) as u32));
        if capacity > fitting {
            let bytes = u64::from(capacity) * 4 * batch;
            return Err(DeviceError::BindingTooLarge { what: "edge lists", bytes, limit: split.binding }.into());
        }
        let polygons = mesh.polygons().map(PolygonCounts::new).transpose()?;
        let pieces = if options.is_for_volumes() { None } else { Some(0) };
        let polygons = polygons.map(|counts| PolygonShape::new(&counts, options.max_lights, pieces, split.binding));
        polygons.iter().try_for_each(|polygons| polygons.check_workgroups(split))?;
        Ok(Self {
            vertices: mesh.vertex_count(),
            faces: mesh.faces().len(),
            edges,
            max_lights: options.max_lights,
            capacity,
            lists_head: 0,
            blocks: edges.div_ceil(WORKGROUP as usize) as u32,
            undecided: undecided_capacity(mesh, options, split),
            face_words: mesh.faces().len() * if polygons.is_some() { 2 } else { 1 },
            polygons,
        })
    }

    /// The number of batches of 32 lights.
    pub(crate) fn batches(&self) -> usize {
        light::batches(self.max_lights)
    }

    /// The offset of the twisted masks behind the facing masks. 0: no face is twisted.
    pub(super) fn twisted_offset(&self) -> u32 {
        if self.polygons.is_some() { self.faces as u32 } else { 0 }
    }

    /// Bytes of a `FacingRecord`.
    pub(super) fn record_bytes(&self) -> u64 {
        RECORD_HEAD + 4 * self.undecided.max(1) as u64
    }

    /// The largest number of lights in a batch.
    pub(crate) fn batch_lights(&self, batch: usize) -> usize {
        (self.max_lights - 32 * batch).min(32)
    }
}

/// All boundary and inconsistent edges have room. Consistent edges share lists of 16 bytes for each edge in total, so
/// every edge has room for up to four lights. Each light has room for at least `smooth` of them, the sum of [`smooth_edges`]
/// of all meshes.
pub(crate) fn default_capacity(counts: EdgeCounts, smooth: usize, lights: usize) -> usize {
    let shared = 4 * counts.consistent / lights.max(1);
    counts.boundary + counts.inconsistent + smooth.max(shared).max(1024).min(counts.consistent)
}

/// How many consistent edges of a smooth surface may be silhouette edges for a light: a few times the root of their number.
pub(crate) fn smooth_edges(consistent: usize) -> usize {
    (16 * consistent.isqrt()).min(consistent)
}

/// Bytes before the undecided faces of a `FacingRecord`: the statistics, and how many faces are undecided.
pub(crate) const RECORD_HEAD: u64 = size_of::<ExtractionStatistics>() as u64 + 4;

/// Room for all faces of one dispatch, unless the options ask for less.
fn undecided_capacity(mesh: &Mesh, options: &ExtractorOptions, split: &DispatchLimits) -> usize {
    if mesh.polygons().is_some() || options.method.predicate(options.predicate) != Predicate::Exact {
        return 0;
    }
    let fitting = ((split.binding - RECORD_HEAD) / 4) as usize;
    let asked = options.undecided_capacity.map_or(usize::MAX, |capacity| capacity.max(1) as usize);
    asked.min(mesh.faces().len()).min(fitting)
}

/// The buffers of an extraction. A `Vec` has one buffer for each batch of lights.
#[derive(Debug)]
pub(crate) struct Buffers<B = wgpu::Buffer> {
    pub(crate) faces: B,
    pub(crate) edge_vertices: B,
    pub(crate) edge_faces: B,
    /// For the per-edge method.
    pub(crate) edge_corners: Option<B>,
    pub(crate) facing: Vec<B>,
    /// Empty, one buffer that all batches share for compaction, or one for each batch if the masks are requested.
    pub(crate) masks: Vec<B>,
    pub(crate) lists: Vec<B>,
    /// For which lights a face is excluded, for shadow volumes.
    pub(crate) excluded: Vec<B>,
    /// A `FacingRecord`: the statistics while they are counted, and the undecided faces of exact facing.
    pub(crate) record: B,
    pub(crate) block_offsets: B,
    pub(crate) counts: B,
    pub(crate) draw_arguments: B,
    pub(crate) polygons: Option<PolygonBuffers<B>>,
    pub(crate) light_batches: B,
    pub(crate) chunks: B,
    pub(crate) draw_shape: B,
    pub(crate) statistics: B,
    /// A buffer for bindings that a stage does not use.
    pub(crate) unused: B,
}

/// The contents of buffers beside those that the mesh has as they are.
struct Contents {
    edge_faces: Option<Vec<[u32; 2]>>,
    edge_corners: Option<Vec<[u32; 4]>>,
    boundaries: Option<Vec<[u32; 2]>>,
    light_batches: UniformTable,
    draw_shape: UniformTable,
}

impl Buffers {
    /// `chunks` has those of the dispatches.
    pub(crate) fn new(
        device: &wgpu::Device,
        mesh: &Mesh,
        shape: &Shape,
        options: &ExtractorOptions,
        split: &DispatchLimits,
        chunks: &UniformTable,
    ) -> Result<Self, DeviceError> {
        let per_edge = options.method.is_per_edge();
        let mut light_batches = UniformTable::default();
        (0..shape.batches()).for_each(|_| _ = light_batches.push(&LightBatch::new(&[], 0, 3)));
        let (lights, edges) = (shape.max_lights as u32, shape.edges as u32);
        let vertices_per_edge = options.lists.map_or(0, |lists| lists.topology.vertices());
        let mut draw_shape = UniformTable::default();
        draw_shape.push(&DrawShape { lights, capacity: shape.capacity, edges, vertices_per_edge });
        let contents = Contents {
            edge_faces: faces_of_records(mesh),
            edge_corners: per_edge.then(|| edge_corners(mesh)),
            boundaries: mesh.polygons().map(boundaries),
            light_batches,
            draw_shape,
        };
        let mut account = Account::default();
        Buffers::<()>::plan(mesh, shape, options, (&contents, chunks), &mut |wanted| account.note(&wanted));
        account.check_whole(split.binding)?;
        let bytes = check(&account.all, split.buffer, options.memory_limit)?;
        guarded(device, bytes, || {
            Self::plan(mesh, shape, options, (&contents, chunks), &mut |wanted| wanted.make(device))
        })
    }
}

impl<B> Buffers<B> {
    fn plan(
        mesh: &Mesh,
        shape: &Shape,
        options: &ExtractorOptions,
        (contents, chunks): (&Contents, &UniformTable),
        make: &mut impl FnMut(Wanted<'_>) -> B,
    ) -> Self {
        let batches = shape.batches();
        let planes = if options.method.is_per_edge() { 0 } else { batches };
        let mask_planes = if options.masks { batches } else { usize::from(options.is_ordered()) };
        let lists = if options.lists.is_some() { batches } else { 0 };
        let excluded = if options.is_for_volumes() { planes } else { 0 };
        let block_offsets = if options.is_ordered() { u64::from(shape.blocks) * 32 * 4 } else { 0 };
        let [edges, faces, face_words, lights] =
            [shape.edges, shape.faces, shape.face_words, shape.max_lights].map(|count| count as u64);
        let has_polygons = shape.polygons.is_some();
        let list =
            |batch: usize| Wanted::new("edge lists", u64::from(shape.capacity) * 4 * shape.batch_lights(batch) as u64);
        let edge_masks = Wanted::new("edge masks", edges * size_of::<EdgeMasks>() as u64);
        let facing = Wanted::new("facing masks", face_words * 4).whole_if(has_polygons);
        let draws = Wanted::new("draw arguments", lights * size_of::<DrawArguments>() as u64).indirect();
        let records = mesh.edges();
        let edge_faces = contents.edge_faces.as_deref().unwrap_or(records.packed_faces());
        let corners = contents.edge_corners.as_ref();
        let polygons = contents.boundaries.as_ref().zip(shape.polygons);
        Self {
            faces: make(Wanted::filled("faces", bytemuck::cast_slice(mesh.faces())).whole_if(has_polygons)),
            edge_vertices: make(Wanted::filled("edge vertices", bytemuck::cast_slice(records.vertices()))),
            edge_faces: make(Wanted::filled("edge faces", bytemuck::cast_slice(edge_faces))),
            edge_corners: corners.map(|corners| make(Wanted::filled("edge corners", bytemuck::cast_slice(corners)))),
            facing: (0..planes).map(|_| make(facing)).collect(),
            masks: (0..mask_planes).map(|_| make(edge_masks)).collect(),
            lists: (0..lists).map(|batch| make(list(batch))).collect(),
            excluded: (0..excluded).map(|_| make(Wanted::new("excluded masks", faces * 4))).collect(),
            record: make(Wanted::new("undecided faces", shape.record_bytes())),
            block_offsets: make(Wanted::new("block offsets", block_offsets).whole_if(true)),
            counts: make(Wanted::new("counts", lights * 4).whole_if(true)),
            draw_arguments: make(draws.whole_if(true)),
            polygons: polygons.map(|(boundaries, polygons)| {
                let lights = (0..batches).map(|batch| shape.batch_lights(batch));
                PolygonBuffers::plan(boundaries, polygons, lights, make)
            }),
            light_batches: make(Wanted::uniforms("light batches", &contents.light_batches)),
            chunks: make(Wanted::uniforms("chunks", chunks)),
            draw_shape: make(Wanted::uniforms("draw shape", &contents.draw_shape).free()),
            statistics: make(Wanted::new("statistics", size_of::<ExtractionStatistics>() as u64).free()),
            unused: make(Wanted::new("unused", 64).free()),
        }
    }
}
