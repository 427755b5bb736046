//! The WGSL include, with which a caller's shaders read the results.

use super::errors::ExtractorError;
use super::extraction::Shared;
use crate::gpu::common::bindings::{READ, UNIFORM, entries, whole};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::pipelines::group;
use crate::gpu::common::positions::{self, BoundPositions, PositionBuffer};
use crate::gpu::common::requirements::check_alive;
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::RimlineInfo;
use crate::stages::source;

/// WGSL that reads the results: structs and functions whose names begin with `rimline_`, on bind group `group`. Put it
/// before or after your own source. The file `wgsl/extract/results.wgsl` documents its functions.
pub fn include_wgsl(group: u32) -> String {
    source("extract/results").unwrap_or_default().replace("GROUP", &group.to_string())
}

/// The layout of the include's bind group. `visibility` names the shader stages that read it: vertex, fragment or
/// compute.
pub fn results_bind_group_layout(device: &wgpu::Device, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("rimline results"),
        entries: &results_entries(visibility),
    })
}

/// The entries of the include's layout.
pub(crate) fn results_entries(visibility: wgpu::ShaderStages) -> Vec<wgpu::BindGroupLayoutEntry> {
    entries(visibility, [(0, UNIFORM)].into_iter().chain((1..7).map(|binding| (binding, READ))))
}

impl Shared {
    /// The bind group of the include for a batch of lights.
    pub(crate) fn include_group(
        &self,
        layout: &wgpu::BindGroupLayout,
        batch: usize,
        positions: PositionBuffer<'_>,
    ) -> Result<wgpu::BindGroup, ExtractorError> {
        let (device, limits, shape) = (self.device(), &self.limits, &self.shape);
        let results = self.results();
        self.check_include()?;
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
            lights: shape.batch_lights(batch) as u32,
            position_offset: bound.offset_words,
            position_stride: bound.stride_words,
            twisted_at: if shape.polygons.is_some() { shape.faces as u32 } else { 0 },
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

    /// Checks that each array that the include and shadow volumes read fits one binding.
    pub(crate) fn check_single_bindings(&self, bound: &BoundPositions) -> Result<(), DeviceError> {
        let limit = self.limits.binding;
        let too_large = |what, bytes| Err(DeviceError::BindingTooLarge { what, bytes, limit });
        if bound.windows.words != 0 {
            return too_large("positions", bound.windows.ranges.iter().map(|range| range.end).max().unwrap_or(0));
        }
        let facing = self.buffers.facing.iter().map(|masks| ("facing masks", masks));
        let arrays = std::iter::once(("edge records", &self.buffers.edge_vertices)).chain(facing);
        for (what, buffer) in arrays {
            if buffer.size() > limit {
                return too_large(what, buffer.size());
            }
        }
        Ok(())
    }

    /// Checks that the extractor has what the include reads.
    pub(crate) fn check_include(&self) -> Result<(), ExtractorError> {
        let is_there = !self.buffers.lists.is_empty() && !self.buffers.facing.is_empty();
        if is_there { Ok(()) } else { Err(ExtractorError::NoInclude) }
    }
}
