//! The extraction of a mesh of polygons in a scene: the stages of [`Extractor`](super::extractor::Extractor), in
//! buffers of the scene. A caster of such a mesh is the only one of its group, so its slots are the triangles of the
//! mesh.

use super::buffers::{Buffers, RECORD_HEAD, Shape};
use super::errors::ExtractorError;
use super::options::ExtractorOptions;
use super::polygon_buffers::{HEAD, PolygonBuffers, PolygonCounts, boundaries};
use super::stages::{Binder, DispatchRanges, from_facing, from_positions, programs};
use crate::Mesh;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, check_bindings, guarded};
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
        let boundaries = Allocation { label: wanted.label, bytes: wanted.bytes };
        check_bindings(&[boundaries], DispatchLimits::new(&device.limits()).binding)?;
        check(&[boundaries, Allocation { label: "the rest of the scene", bytes: used }], u64::MAX, memory_limit)?;
        let head = Wanted::filled("boundary head", bytemuck::cast_slice(&HEAD));
        let made = guarded(device, wanted.bytes, || (wanted.make(device), head.make(device)))?;
        Ok(Some(Self { counts, boundaries: made.0, head: made.1 }))
    }

    /// The buffers of an extraction: undecided polygons, arguments of dispatches over them, and pieces.
    pub(crate) fn buffers(&self, of_scene: [&wgpu::Buffer; 3]) -> PolygonBuffers {
        let [undecided, arguments, pieces] = of_scene.map(wgpu::Buffer::clone);
        let (boundaries, head) = (self.boundaries.clone(), self.head.clone());
        PolygonBuffers { boundaries, undecided, head, arguments, pieces: vec![pieces] }
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.boundaries.size()
    }
}

/// The steps of the extraction of a caster of polygons for a batch of lights, after light batch and positions were written.
/// `buffers` are those of an extractor, but for the chunks.
pub(crate) fn polygon_steps(
    pipelines: &Pipelines,
    shape: &Shape,
    mut buffers: Buffers,
    positions: (&wgpu::Buffer, &BoundPositions),
) -> Result<Vec<Step>, DeviceError> {
    let device = pipelines.device();
    let limits = DispatchLimits::new(&device.limits());
    let options = ExtractorOptions { max_lights: shape.max_lights, ..ExtractorOptions::default() };
    let facing = &limits.windows("facing masks", 4 * shape.face_words as u64)?;
    let mut chunks = UniformTable::default();
    let ranges = &DispatchRanges::new(shape, [&[], &limits.chunks("edge records", shape.edges, 8)?], &mut chunks);
    buffers.chunks = chunks.into_buffer(device, "chunks");
    let (reading, others) = (from_positions(device, &options, Some(true), 0), from_facing(&options, facing.words));
    // The scene makes draw arguments.
    pipelines.make_together(&programs([&reading, &others], None));
    let Buffers { record, counts, .. } = &buffers;
    let mut steps = vec![Step::Clear(record.clone(), 0..RECORD_HEAD), Step::Clear(counts.clone(), 0..shape.lists_head)];
    let binder = Binder { pipelines, shape, buffers: &buffers, ranges, facing, positions: Some(positions) };
    steps.extend(binder.read_positions(&reading, 0));
    steps.extend(binder.read_facing(&others, 0));
    Ok(steps)
}
