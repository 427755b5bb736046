//! The extraction of a mesh of polygons in a scene: the stages of [`Extractor`](super::extractor::Extractor), in
//! buffers of the scene. A caster of such a mesh is the only one of its group, so its slots are the triangles of the
//! mesh.

use super::buffers::{Buffers, RECORD_HEAD, Shape};
use super::errors::ExtractorError;
use super::options::ExtractorOptions;
use super::polygon_buffers::{HEAD, PolygonBuffers, PolygonCounts, PolygonShape, boundaries};
use super::stages::{Binder, DispatchRanges, from_facing, from_positions, made, programs};
use crate::Mesh;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, guarded};
use crate::gpu::common::pass::Step;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::BoundPositions;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::common::wanted::Wanted;

/// The polygons of a mesh as a scene keeps them, beside its topology.
#[derive(Debug)]
pub(crate) struct PolygonMesh {
    pub(crate) counts: PolygonCounts,
    boundaries: wgpu::Buffer,
    head: wgpu::Buffer,
}

impl PolygonMesh {
    /// The polygons of a mesh, if it has any. `used` are the bytes of the scene so far.
    pub(crate) fn new(
        device: &wgpu::Device,
        mesh: &Mesh,
        used: u64,
        memory_limit: Option<u64>,
    ) -> Result<Option<Self>, ExtractorError> {
        let Some(polygons) = mesh.polygons() else { return Ok(None) };
        let counts = PolygonCounts::new(polygons)?;
        let table = boundaries(polygons);
        let wanted = Wanted::filled("boundaries", bytemuck::cast_slice(&table));
        let limit = DispatchLimits::new(&device.limits()).binding;
        if wanted.bytes > limit {
            return Err(DeviceError::BindingTooLarge { what: wanted.label, bytes: wanted.bytes, limit }.into());
        }
        let others = Allocation { label: "the rest of the scene", bytes: used };
        check(&[Allocation { label: wanted.label, bytes: wanted.bytes }, others], u64::MAX, memory_limit)?;
        let head = Wanted::filled("boundary head", bytemuck::cast_slice(&HEAD));
        let made = guarded(device, wanted.bytes, || (wanted.make(device), head.make(device)))?;
        Ok(Some(Self { counts, boundaries: made.0, head: made.1 }))
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.boundaries.size()
    }
}

/// The buffers of a scene that a caster of polygons has for a batch of lights.
pub(crate) struct PolygonPart<'a> {
    pub(crate) mesh: &'a PolygonMesh,
    /// Sizes: the slots of its triangles and edge records, the lights of the batch, the room of its lists.
    pub(crate) faces: u32,
    pub(crate) edges: u32,
    pub(crate) lights: u32,
    pub(crate) capacity: u32,
    pub(crate) polygons: PolygonShape,
    /// The topology, and where vertices are.
    pub(crate) topology: [&'a wgpu::Buffer; 3],
    pub(crate) positions: (&'a wgpu::Buffer, BoundPositions),
    /// The faces that count nowhere, in any extraction.
    pub(crate) given: Option<&'a wgpu::Buffer>,
    pub(crate) light_batch: &'a wgpu::Buffer,
    /// The results: facing masks and behind them twisted masks, excluded masks, statistics, and the lists with bytes before
    /// them.
    pub(crate) facing: &'a wgpu::Buffer,
    pub(crate) excluded: &'a wgpu::Buffer,
    pub(crate) record: &'a wgpu::Buffer,
    pub(crate) lists: (&'a wgpu::Buffer, u64),
    pub(crate) undecided: &'a wgpu::Buffer,
    pub(crate) arguments: &'a wgpu::Buffer,
    pub(crate) pieces: &'a wgpu::Buffer,
}

impl PolygonPart<'_> {
    /// The steps of the extraction, after light batch and positions were written.
    pub(crate) fn steps(&self, pipelines: &Pipelines) -> Result<Vec<Step>, DeviceError> {
        let device = pipelines.device();
        let limits = DispatchLimits::new(&device.limits());
        let options = ExtractorOptions { max_lights: self.lights as usize, ..ExtractorOptions::default() };
        let (faces, edges) = (self.faces as usize, self.edges as usize);
        let shape = Shape {
            vertices: 0,
            faces,
            edges,
            max_lights: options.max_lights,
            capacity: self.capacity,
            lists_head: self.lists.1,
            blocks: 0,
            undecided: 0,
            face_words: 2 * faces,
            polygons: Some(self.polygons),
        };
        let facing = limits.windows("facing masks", 4 * shape.face_words as u64)?;
        let mut chunks = UniformTable::default();
        let ranges = DispatchRanges::new(&shape, [&[], &limits.chunks("edge records", edges, 8)?], &mut chunks);
        let buffers = self.buffers(chunks.into_buffer(device, "chunks"));
        let (reading, others) =
            (from_positions(device, &options, Some(true), 0), from_facing(&options, faces, facing.words));
        let mut all = programs(reading.iter().chain(&others), &options);
        // The scene makes draw arguments.
        all.pop();
        pipelines.make_together(&all);
        let (reading, others) = (made(pipelines, reading), made(pipelines, others));
        let positions = Some((self.positions.0, &self.positions.1));
        let (shape, buffers, ranges, facing) = (&shape, &buffers, &ranges, &facing);
        let binder = Binder { device, shape, buffers, ranges, facing, positions, given: self.given };
        let mut steps =
            vec![Step::Clear(self.record.clone(), 0..RECORD_HEAD), Step::Clear(self.lists.0.clone(), 0..self.lists.1)];
        steps.extend(binder.read_positions(&reading, 0));
        steps.extend(binder.read_facing(&others, 0));
        Ok(steps)
    }

    /// The same buffers as an extractor for one batch of lights has.
    fn buffers(&self, chunks: wgpu::Buffer) -> Buffers {
        let [faces, edge_vertices, edge_faces] = self.topology.map(wgpu::Buffer::clone);
        let unused = self.arguments.clone();
        Buffers {
            faces,
            edge_vertices,
            edge_faces,
            edge_corners: None,
            facing: vec![self.facing.clone()],
            masks: Vec::new(),
            lists: vec![self.lists.0.clone()],
            excluded: vec![self.excluded.clone()],
            record: self.record.clone(),
            block_offsets: unused.clone(),
            counts: self.lists.0.clone(),
            draw_arguments: unused.clone(),
            polygons: Some(PolygonBuffers {
                boundaries: self.mesh.boundaries.clone(),
                undecided: self.undecided.clone(),
                head: self.mesh.head.clone(),
                arguments: self.arguments.clone(),
                pieces: vec![self.pieces.clone()],
            }),
            light_batches: self.light_batch.clone(),
            chunks,
            draw_shape: unused.clone(),
            statistics: unused.clone(),
            unused,
        }
    }
}
