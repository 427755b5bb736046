//! The shadow volumes of a scene.

use super::buffers::{LISTS_HEAD, PolygonBuffers};
use super::layout::Group;
use super::structure::{GroupBatch, Inputs, Structure};
use crate::gpu::common::bindings::{part, whole};
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::Allocation;
use crate::gpu::common::positions::bound;
use crate::gpu::shadow::buffers::SizedBuffers;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::sizes::{GroupSize, Room, VolumeSizes};
use crate::gpu::shadow::source::{GroupSource, VolumeSource};
use crate::gpu::shadow::stages::{StagePipelines, VolumeStages};
use crate::layout::{CHUNK, ExtractionStatistics, SceneDispatch};

/// Room for near caps in each group, in addition to sixteen times the root of the faces.
const FEW_CAPS: u32 = 4096;

/// The volumes of a structure.
#[derive(Debug)]
pub(crate) struct Volumes {
    pub(crate) buffers: SizedBuffers,
    pub(crate) stages: VolumeStages,
}

impl Volumes {
    /// Makes the volumes of a structure, with `receivers` words for the receivers of each view.
    pub(crate) fn new(inputs: &Inputs<'_>, structure: &Structure, receivers: u64) -> Result<Self, ShadowError> {
        let device = inputs.pipelines.device();
        let limits = DispatchLimits::new(&device.limits());
        let sizes = VolumeSizes { receivers, ..sizes(inputs, structure, &limits) };
        let bytes = inputs.others + structure.bytes();
        let others = Allocation { label: "the scene without volumes", bytes };
        let buffers = SizedBuffers::new(device, sizes, others, &limits)?;
        let pipelines = StagePipelines::new(inputs.pipelines, buffers.sizes.has_pieces(), inputs.options);
        let source = source(inputs, structure);
        let stages = bound(device, || VolumeStages::new(&pipelines, &buffers, &source))?;
        Ok(Self { buffers, stages })
    }
}

fn sizes(inputs: &Inputs<'_>, structure: &Structure, limits: &DispatchLimits) -> VolumeSizes {
    let group_of = |part: &GroupBatch| structure.layout.groups.get(part.group);
    let group_size = |part: &GroupBatch| {
        let sizes = |group: &Group| (group.face_slots(), group.edge_slots(), CHUNK * group.proxy_chunks);
        let (faces, edges, proxies) = group_of(part).map_or((0, 0, 0), sizes);
        let SceneDispatch { lights_offset, face_chunks_offset, edge_chunks_offset, .. } = part.dispatch;
        let (first_caster, boundaries) =
            group_of(part).map_or((0, 0), |group| (group.first, group.counts.boundary as u32));
        GroupSize {
            faces,
            edges,
            boundaries,
            first_caster,
            proxies,
            lights_offset,
            face_chunks_offset,
            edge_chunks_offset,
        }
    };
    let room = |part: &GroupBatch| {
        let room = Room::new(inputs.options, &group_size(part), FEW_CAPS, part.sizes.capacity, part.lights, limits);
        let pieces = part.sizes.polygons.map_or(0, |polygons| polygons.pieces);
        Room { lists_offset: part.dispatch.lists_offset, pieces, ..room }
    };
    VolumeSizes {
        options: *inputs.options,
        casters: structure.layout.order.len(),
        lights: 32 * structure.batches,
        views: inputs.views,
        choices_offset: structure.choices_offset,
        groups: structure.parts.iter().filter(|part| part.batch == 0).map(group_size).collect(),
        rooms: structure.parts.iter().map(room).collect(),
        receivers: 0,
    }
}

fn source<'a>(inputs: &Inputs<'a>, structure: &'a Structure) -> VolumeSource<'a> {
    let batch = |group_batch: &'a GroupBatch| {
        let GroupBatch { group, batch, sizes, .. } = group_batch;
        let extracted = structure.buffers.groups.get(*group)?.get(*batch)?;
        let mut named = vec![
            ("facing_masks", part(&extracted.facing, 0..sizes.masks)),
            ("excluded_masks", part(&extracted.excluded, 0..sizes.masks)),
            ("silhouette_counts", part(&extracted.lists, 0..LISTS_HEAD)),
            ("silhouettes", part(&extracted.lists, LISTS_HEAD..sizes.lists)),
            ("extraction_statistics", part(&extracted.record, 0..size_of::<ExtractionStatistics>() as u64)),
        ];
        let pieces = |polygons: &'a PolygonBuffers| ("pieces", part(&polygons.pieces, 0..sizes.pieces()));
        named.extend(extracted.polygons.as_ref().map(pieces));
        Some(named)
    };
    let group = |parts: &'a [GroupBatch]| {
        let (page, source) = structure.source(inputs.content, parts.first()?.group)?;
        Some(GroupSource {
            named: vec![
                ("faces", whole(&page.faces)),
                ("edge_vertices", whole(&page.edge_vertices)),
                ("edge_faces", whole(&page.edge_faces)),
                ("positions", source.positions(page)),
            ],
            has_boxes: source.buffer.is_none(),
            batches: parts.iter().filter_map(batch).collect(),
        })
    };
    let groups = structure.parts.chunks(structure.batches.max(1)).filter_map(group).collect();
    let named = vec![
        ("relevant_lights", whole(&structure.buffers.relevant_lights)),
        ("cache", whole(&structure.buffers.cache)),
    ];
    VolumeSource { table: &structure.table, named, groups }
}
