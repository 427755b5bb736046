//! The shadow volumes of a scene.

use bytemuck::Zeroable;

use super::stages::Binder;
use super::structure::{GroupBatch, Inputs, Structure};
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::Allocation;
use crate::gpu::common::positions::bound;
use crate::gpu::common::requirements::Subject;
use crate::gpu::shadow::buffers::SizedBuffers;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::sizes::{PartSizes, VolumeSizes};
use crate::gpu::shadow::stages::{VolumeSource, VolumeStages};
use crate::layout::{CHUNK, SceneDispatch, ShadowShape};

/// The volumes of a structure.
#[derive(Debug)]
pub(crate) struct Volumes {
    pub(crate) buffers: SizedBuffers,
    pub(crate) stages: VolumeStages,
}

impl Volumes {
    /// Makes the volumes of a structure. A device that extracts need not have what they need.
    pub(crate) fn new(inputs: &Inputs<'_>, structure: &Structure) -> Result<Self, ShadowError> {
        inputs.pipelines.construct(Subject::Shadow, || Self::with(inputs, structure))
    }

    fn with(inputs: &Inputs<'_>, structure: &Structure) -> Result<Self, ShadowError> {
        let device = inputs.pipelines.device();
        let limits = DispatchLimits::new(&device.limits());
        let sizes = sizes(inputs, structure, &limits);
        let bytes = inputs.others + structure.bytes();
        let others = Allocation { label: "the scene without volumes", bytes };
        let buffers = SizedBuffers::new(device, sizes, others, &limits)?;
        let binder = Binder::new(inputs, structure);
        let part = |group: usize, batch: usize| structure.parts.get(group * structure.buffers.batches + batch);
        let source = VolumeSource {
            table: &structure.table,
            has_boxes: structure.topology.iter().map(|topology| topology.are_at_rest).collect(),
            get: &|name, group, batch| binder.get("", name, part(group, batch)?),
        };
        let stages = bound(device, || VolumeStages::new(inputs.pipelines, &buffers, &source))?;
        Ok(Self { buffers, stages })
    }
}

fn sizes(inputs: &Inputs<'_>, structure: &Structure, limits: &DispatchLimits) -> VolumeSizes {
    let sizes_of = |part: &GroupBatch| {
        let group = structure.layout.groups.get(part.group)?;
        let SceneDispatch { lights_offset, face_chunks_offset, edge_chunks_offset, lists_offset, .. } = part.dispatch;
        let shape = ShadowShape {
            faces: group.face_slots(),
            edges: group.edge_slots(),
            capacity: part.sizes.capacity,
            lights_offset,
            face_chunks_offset,
            edge_chunks_offset,
            first_caster: group.first,
            lists_offset,
            piece_capacity: part.sizes.polygons.map_or(0, |polygons| polygons.pieces),
            ..ShadowShape::zeroed()
        };
        let boundaries_and_proxies = [group.counts.boundary as u32, CHUNK * group.proxy_chunks];
        Some(PartSizes::new(inputs.options, shape, part.sizes.lights, boundaries_and_proxies, limits))
    };
    VolumeSizes {
        options: *inputs.options,
        casters: structure.layout.order.len(),
        lights: 32 * structure.buffers.batches,
        views: inputs.room.views,
        choices_offset: structure.choices_offset,
        parts: structure.parts.iter().filter_map(sizes_of).collect(),
        receivers: inputs.room.receiver_words,
    }
}
