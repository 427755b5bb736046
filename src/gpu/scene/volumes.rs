//! The shadow volumes of a scene.

use super::buffers::LISTS_HEAD;
use super::layout::Group;
use super::structure::{GroupBatch, Making, Structure};
use crate::gpu::common::dispatch_limits::{DispatchLimits, binding};
use crate::gpu::common::memory::Allocation;
use crate::gpu::common::positions::bound;
use crate::gpu::common::timer::StageTimer;
use crate::gpu::shadow::buffers::VolumeBuffers;
use crate::gpu::shadow::draws::LightDraws;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::sizes::{GroupSize, Room, VolumeSettings, VolumeSizes};
use crate::gpu::shadow::source::{BatchSource, GroupSource, VolumeSource};
use crate::gpu::shadow::stages::{StagePipelines, VolumeStages};
use crate::layout::{CHUNK, ExtractionStatistics, SceneDispatch};

/// Near caps of each group that there is room for besides sixteen times the root of the faces.
const FEW_CAPS: u32 = 4096;

/// The volumes of a structure, for a number of views.
#[derive(Debug)]
pub(crate) struct Volumes {
    pub(crate) buffers: VolumeBuffers,
    stages: VolumeStages,
}

impl Volumes {
    /// Makes the volumes of a structure whose table has room for the choices of `views` views, and so many words for the
    /// receivers of each. `others` are the bytes of the
    /// rest of the scene.
    pub(crate) fn new(
        making: &Making<'_>,
        structure: &Structure,
        views: usize,
        receivers: u64,
        others: u64,
    ) -> Result<Self, ShadowError> {
        let device = making.pipelines.device();
        let limits = DispatchLimits::new(&device.limits());
        let settings = making.options.volumes(making.has_receivers);
        let mut sizes = VolumeSizes { receivers, ..sizes(structure, settings, views, &limits) };
        sizes.fit_memory(others);
        let others = Allocation { label: "the scene without volumes", bytes: others };
        let buffers = VolumeBuffers::new(device, sizes, &[others], &limits)?;
        let pipelines = StagePipelines::new(making.pipelines, true, &settings);
        let source = source(making, structure);
        let stages = bound(device, || VolumeStages::new(&pipelines, &buffers, &source))?;
        Ok(Self { buffers, stages })
    }

    /// The number of entries for views and lights that each encode uploads.
    pub(crate) fn seen(&self) -> usize {
        self.buffers.sizes.seen()
    }

    /// The number of lights of a view, with those that are not there.
    pub(crate) fn lights(&self) -> usize {
        self.buffers.sizes.lights
    }

    /// Records what chooses and lists, after the extraction.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, timer: Option<&mut StageTimer>) {
        self.stages.record(encoder, &self.buffers, self.buffers.sizes.batches(), timer);
    }

    /// The draws of a light in a view for a batch of casters, for each group.
    pub(crate) fn draws(&self, count_batch: usize, view: usize, light: usize) -> impl Iterator<Item = LightDraws<'_>> {
        self.stages.draws(&self.buffers, count_batch, view, light)
    }
}

fn sizes(structure: &Structure, settings: VolumeSettings, views: usize, limits: &DispatchLimits) -> VolumeSizes {
    let group_of = |part: &GroupBatch| structure.layout.groups.get(part.group);
    let group_size = |part: &GroupBatch| {
        let sizes = |group: &Group| (group.face_slots(), group.edge_slots(), CHUNK * group.proxy_chunks);
        let (faces, edges, proxies) = group_of(part).map_or((0, 0, 0), sizes);
        let SceneDispatch { lights_at, face_chunks_at, edge_chunks_at, .. } = part.dispatch;
        let first_caster = group_of(part).map_or(0, |group| group.first);
        GroupSize { faces, edges, first_caster, proxies, lights_at, face_chunks_at, edge_chunks_at }
    };
    let room = |part: &GroupBatch| {
        let room = Room::new(&settings, &group_size(part), FEW_CAPS, part.sizes.capacity, part.lights, limits);
        Room { lists_at: part.dispatch.lists_at, ..room }
    };
    VolumeSizes {
        settings,
        casters: structure.layout.order.len(),
        lights: 32 * structure.batches,
        views,
        choices_at: structure.choices_at,
        groups: structure.parts.iter().filter(|part| part.batch == 0).map(group_size).collect(),
        rooms: structure.parts.iter().map(room).collect(),
        receivers: 0,
    }
}

fn source<'a>(making: &Making<'a>, structure: &'a Structure) -> VolumeSource<'a> {
    let batch = |part: &'a GroupBatch| {
        let extracted = structure.buffers.groups.get(part.group)?.get(part.batch)?;
        Some(BatchSource {
            facing: binding(&extracted.facing, 0..part.sizes.masks),
            excluded: binding(&extracted.excluded, 0..part.sizes.masks),
            silhouette_counts: binding(&extracted.lists, 0..LISTS_HEAD),
            silhouettes: binding(&extracted.lists, LISTS_HEAD..part.sizes.lists),
            statistics: binding(&extracted.record, 0..size_of::<ExtractionStatistics>() as u64),
            pieces: None,
        })
    };
    let group = |parts: &'a [GroupBatch]| {
        let (page, source) = structure.source(making, parts.first()?.group)?;
        Some(GroupSource {
            faces: &page.faces,
            edge_vertices: &page.edge_vertices,
            edge_faces: &page.edge_faces,
            positions: match &source.buffer {
                Some(bound) => binding(&bound.buffer, bound.range.clone()),
                None => page.positions.as_entire_binding(),
            },
            has_boxes: source.buffer.is_none(),
            batches: parts.iter().filter_map(batch).collect(),
        })
    };
    let groups = structure.parts.chunks(structure.batches.max(1)).filter_map(group).collect();
    VolumeSource {
        table: &structure.table,
        lit: Some(&structure.buffers.lit),
        kept: Some(&structure.buffers.kept),
        statistics: None,
        groups,
    }
}
