//! The WGSL include, with which a caller's shaders read the results.

use super::buffers::Buffers;
use super::errors::ExtractorError;
use super::extraction::Shared;
use crate::gpu::common::bindings::{READ, UNIFORM, entries, whole};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::memory::{Allocation, check_bindings};
use crate::gpu::common::pipelines::group;
use crate::gpu::common::positions::{self, BoundPositions, PositionBuffer};
use crate::gpu::common::requirements::check_alive;
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::RimlineInfo;
use crate::stages::source;

/// WGSL that reads the results: structs and functions whose names begin with `rimline_`, on bind group `group`. Put it
/// before or after your own source.
///
/// A light has its number among all lights of the extraction, as in [`Extraction::draw`](crate::gpu::Extraction::draw). One
/// that the bound batch does not have has no edge. An instance is one of that draw, and a vertex is one of its vertices.
///
/// | function | result |
/// |---|---|
/// | `rimline_edge_vertex(light: u32, instance: u32, vertex: u32) -> vec4<f32>` | The position of the edge's end at this vertex, with `w` = 1, for your matrix. Seen from the light, the edge's faces lie to the left from the first end to the second. All zeros if the instance is no silhouette: nothing is drawn then, by any matrix. Both sides of a quad have these ends: it shows nothing until you move its corners apart, by `rimline_corner` |
/// | `rimline_corner(vertex: u32) -> u32` | The corner of the edge's quad, in the order of a strip: bit 0 is the end, bit 1 the side |
/// | `rimline_silhouette(light: u32, instance: u32) -> RimlineSilhouette` | The edge itself. Check its `valid` |
/// | `rimline_silhouettes(light: u32) -> u32` | The number of silhouette edges, including those that a list has no room for |
/// | `rimline_edge(light: u32, edge: u32) -> RimlineSilhouette` | Any edge record, `valid` if it is a silhouette |
/// | `rimline_position(vertex: u32) -> vec3<f32>` | The position of a vertex of the mesh |
/// | `rimline_clip(view_projection: mat4x4<f32>, origin: vec3<f32>, position: vec3<f32>) -> vec4<f32>` | A position of world space in clip space, in the same bits as light caps. z-fail needs a depth pass that computes positions so, with an `@invariant` output. Volumes of moved rigid casters round otherwise: see [`CasterPositions::Rigid`](crate::gpu::CasterPositions::Rigid) |
/// | `rimline_faces_light(face: u32, light: u32) -> bool` | Whether a triangle faces the light |
/// | `rimline_is_twisted(face: u32, light: u32) -> bool` | Whether the polygon of a triangle is twisted as seen from the light, so that it counts nowhere |
/// | `rimline_has_light(light: u32) -> bool` | Whether the encode has the light, in the bound batch |
/// | `rimline_light_bit(light: u32) -> u32` | The light's bit in the masks of its batch |
///
/// | member of `RimlineSilhouette` | |
/// |---|---|
/// | `valid: bool` | False: draw nothing; the other members mean nothing. The list overflowed, so the draw goes over all edge records, and this one is no silhouette |
/// | `edge: u32`, `a: u32`, `b: u32` | The index of the edge record, and its vertices. Face 0 traverses it from `a` to `b` |
/// | `winding: bool` | Whether face 0 faces the light, as in [`EdgeMasks`](crate::gpu::EdgeMasks). If so, (b, a, far a, far b) is counter-clockwise from outside the shadow volume |
/// | `kind: u32` | 0 consistent, 1 inconsistent, 2 boundary |
///
/// The bindings, 0 to 6: `rimline_info`, `rimline_positions`, `rimline_edge_vertices`, `rimline_edge_faces`,
/// `rimline_facing`, `rimline_list`, `rimline_counts`. The last six are storage buffers.
/// [`ExtractionResults`](crate::gpu::ExtractionResults) says what they hold. `rimline_info` is a uniform buffer with a
/// `RimlineInfo`:
///
/// | member of `RimlineInfo` | |
/// |---|---|
/// | `edges: u32`, `capacity: u32` | Edge records, and entries that the list of each light has room for |
/// | `first_light: u32`, `lights: u32` | The first light of the batch, and how many of the encode's lights it has |
/// | `position_offset: u32`, `position_stride: u32` | The word of vertex 0 in `rimline_positions`, and the words from one vertex to the next |
/// | `twisted_offset: u32` | Where twisted masks lie behind the facing masks, or 0 |
/// | `vertices_per_edge: u32` | Vertices that the draw has for each edge, by [`EdgeTopology`](crate::gpu::EdgeTopology) |
///
/// This shader draws lines, by a list with [`EdgeTopology::LineList`](crate::gpu::EdgeTopology::LineList):
///
/// ```
/// let shader = rimline::gpu::include_wgsl(0) + "
///     @group(1) @binding(0) var<uniform> view_projection: mat4x4<f32>;
///     @vertex fn line(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32)
///       -> @builtin(position) vec4<f32> {
///       return view_projection * rimline_edge_vertex(0u, instance, vertex);
///     }";
/// # assert!(shader.contains("fn rimline_edge_vertex"));
/// ```
pub fn include_wgsl(group: u32) -> String {
    source("extract/results").unwrap_or_default().replace("GROUP", &group.to_string())
}

/// The layout of the include's bind group. `visibility` names the shader stages that read it: vertex, fragment or
/// compute.
pub fn results_bind_group_layout(device: &wgpu::Device, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("rimline results"),
        entries: &entries(visibility, (0..).zip([UNIFORM].into_iter().chain([READ; 6]))),
    })
}

impl Shared {
    /// The bind group of the include for a batch of lights, of which the encode has `lights`.
    pub(crate) fn include_group(
        &self,
        layout: &wgpu::BindGroupLayout,
        batch: usize,
        lights: usize,
        positions: PositionBuffer<'_>,
    ) -> Result<wgpu::BindGroup, ExtractorError> {
        let (device, limits, shape) = (self.device(), &self.limits, &self.shape);
        let results = self.results();
        if results.lists.is_empty() || results.facing.is_empty() {
            return Err(ExtractorError::NoInclude);
        }
        let (Some(list), Some(facing)) = (results.lists.get(batch), results.facing.get(batch)) else {
            return Err(ExtractorError::NoSuchBatch { batch, batches: results.lists.len() });
        };
        check_alive(device)?;
        let bound = positions.bind(shape.vertices, limits)?;
        self.check_single_bindings(&bound)?;
        let mut table = UniformTable::default();
        table.push(&RimlineInfo {
            edges: shape.edges as u32,
            capacity: shape.capacity,
            first_light: 32 * batch as u32,
            lights: lights as u32,
            position_offset: bound.offset_words,
            position_stride: bound.stride_words,
            twisted_offset: shape.twisted_offset(),
            vertices_per_edge: self.vertices_per_edge,
        });
        let info = table.into_buffer(device, "rimline info");
        let resources = [
            whole(&info),
            bound.first_binding(positions.buffer),
            whole(results.edge_vertices),
            whole(results.edge_faces),
            whole(facing),
            whole(list),
            whole(results.counts),
        ];
        Ok(positions::bound(device, || group(device, "rimline results", layout, &resources))?)
    }

    /// Checks that each array that the include reads fits one binding.
    fn check_single_bindings(&self, bound: &BoundPositions) -> Result<(), DeviceError> {
        let Buffers { edge_vertices, facing, .. } = &self.buffers;
        let positions = bound.windows.ranges.iter().map(|range| range.end).max().unwrap_or(0);
        let facing = facing.iter().map(|masks| ("facing masks", masks.size()));
        let arrays = [("positions", positions), ("edge records", edge_vertices.size())].into_iter().chain(facing);
        let arrays: Vec<_> = arrays.map(|(label, bytes)| Allocation { label, bytes }).collect();
        check_bindings(&arrays, self.limits.binding)
    }
}
