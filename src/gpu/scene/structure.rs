//! The layout, the buffers and the uniforms of a scene. Only adding or removing casters or lights makes new ones.

use bytemuck::Zeroable;
use slotmap::{DefaultKey, SlotMap};

use super::buffers::{Buffers, CLUSTER_WORDS, GroupSizes, Sizes, WorkOffsets, work_offsets};
use super::caster::CasterEntry;
use super::content::Content;
use super::layout::{Group, Layout};
use super::lights::Lights;
use super::options::{Measuring, SceneOptions};
use super::sources::GroupTopology;
use super::table::{Part, Table};
use crate::Light;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, filled, guarded, mapped, write_mapped};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::extract::of_scene::PolygonMesh;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::sizes::choice_bytes;
use crate::layout::{CHUNK, DrawShape, LightBatch, SceneDispatch};

/// One group of casters and one batch of lights: what a dispatch of a stage covers.
#[derive(Clone, Debug)]
pub(crate) struct GroupBatch {
    pub(crate) group: usize,
    pub(crate) batch: usize,
    pub(crate) sizes: GroupSizes,
    /// Bits of the batch up to the last light.
    pub(crate) lights: u32,
    /// The uniform of its dispatches, and its offset.
    pub(crate) dispatch: SceneDispatch,
    pub(crate) offset: u32,
    /// The offset of its [`DrawShape`].
    pub(crate) shape: u32,
}

/// Vertices that draw one silhouette edge, as a strip.
const VERTICES_PER_EDGE: u32 = 4;

/// A layout of a scene, with its buffers. Frames hold it, so a frame that is submitted late still has its own buffers.
#[derive(Debug)]
pub(crate) struct Structure {
    pub(crate) layout: Layout,
    /// The scene table. The casters of chunks are written once, here. Each encode uploads what lies before them.
    pub(crate) table: wgpu::Buffer,
    /// The offset of the choices of shadow volumes in the table, in units of 16 bytes.
    pub(crate) choices_offset: usize,
    /// The first word of the work lists with the states of deforming casters, one each.
    pub(crate) needed_states_offset: u32,
    pub(crate) buffers: Buffers,
    pub(crate) batches: usize,
    pub(crate) parts: Vec<GroupBatch>,
    pub(crate) uniforms: wgpu::Buffer,
    pub(crate) shapes: wgpu::Buffer,
    /// For each group and batch the masks of faces that callers exclude, if there are any.
    pub(crate) exclusions: Vec<Option<wgpu::Buffer>>,
    /// For each group.
    pub(crate) topology: Vec<GroupTopology>,
}

/// The only caster of a group of polygons.
pub(crate) struct PolygonCaster<'a> {
    pub(crate) caster: &'a CasterEntry,
    pub(crate) mesh: &'a PolygonMesh,
    /// The word of its first vertex in the bound positions, and words from vertex to vertex.
    pub(crate) offset_words: u32,
    pub(crate) stride_words: u32,
}

/// The number of a structure, which no other one of the scene has, and that of its first encode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Versions {
    pub(crate) structure: u32,
    pub(crate) encode: u32,
}

/// The parts of a scene that a structure is made from.
pub(crate) struct Inputs<'a> {
    pub(crate) pipelines: &'a Pipelines,
    pub(crate) content: &'a Content,
    /// The bytes of pages and deformers.
    pub(crate) others: u64,
    pub(crate) options: &'a SceneOptions,
    /// Views that the table has room for.
    pub(crate) views: usize,
    /// Whether views may have receivers.
    pub(crate) has_receivers: bool,
}

impl Structure {
    /// Makes the buffers of a layout. It reuses those of `old` that are large enough.
    pub(crate) fn new(
        inputs: &Inputs<'_>,
        layout: Layout,
        table: &Table,
        old: Option<&Self>,
        versions: Versions,
    ) -> Result<Self, ShadowError> {
        let Inputs { pipelines, content: Content { casters, lights, pages, .. }, options, views, .. } = *inputs;
        let device = pipelines.device();
        let limits = DispatchLimits::new(&device.limits());
        let batches = table.batches;
        let sizes: Vec<Vec<GroupSizes>> = layout
            .groups
            .iter()
            .map(|group| {
                (0..batches).map(|batch| GroupSizes::new(group, room(lights, batch), options, &limits)).collect()
            })
            .collect();
        let (work_offsets, words) = work_offsets(&layout.groups, batches);
        let pairs = (table.casters * batches) as u64;
        let [_, choices] = choice_bytes(options, inputs.has_receivers, [table.casters, 32 * batches, views]);
        let table_bytes = (table.parts.len() * size_of::<Part>()) as u64 + choices;
        if table_bytes > limits.binding {
            let limit = limits.binding;
            return Err(DeviceError::BindingTooLarge { what: "the scene table", bytes: table_bytes, limit }.into());
        }
        let exclusions = caller_exclusions(&layout, table, casters);
        let exclusion_bytes: u64 = exclusions.iter().flatten().map(|masks| 4 * masks.len() as u64).sum();
        let wanted = Sizes {
            groups: &sizes,
            pairs,
            batches,
            face_chunks: layout.groups.iter().map(|group| u64::from(group.face_chunks)).sum(),
            work: words + table.casters as u64,
            others: inputs.others + table_bytes + exclusion_bytes,
            memory_limit: options.memory_limit,
        };
        let buffers = Buffers::new(device, old.map(|old| &old.buffers), &wanted, &limits)?;
        let table_buffer = table_buffer(device, table, table_bytes)?;
        let shared = SceneDispatch {
            casters: table.casters as u32,
            batches: batches as u32,
            lights_offset: table.lights_offset() as u32,
            ranges_offset: table.ranges_offset() as u32,
            structure: versions.structure,
            uses_cache: u32::from(!options.measuring.has(Measuring::CACHED_BITS)),
            occluders_offset: layout.occluders.offset as u32,
            occluders: layout.occluders.count as u32,
            world_lights_offset: layout.occluders.lights_offset as u32,
            ..SceneDispatch::zeroed()
        };
        let (mut uniforms, mut shapes) = (UniformTable::default(), UniformTable::default());
        let mut parts = parts(&shared, &layout.groups, &sizes, &work_offsets);
        for part in &mut parts {
            part.lights = room(lights, part.batch);
            part.offset = uniforms.push(&part.dispatch);
            part.shape = shapes.push(&DrawShape {
                lights: 32,
                capacity: part.sizes.capacity,
                edges: CHUNK * part.dispatch.edge_chunks,
                vertices_per_edge: VERTICES_PER_EDGE,
            });
        }
        let usage = wgpu::BufferUsages::COPY_SRC;
        let filled = |masks: Vec<u32>| filled(device, "excluded by callers", bytemuck::cast_slice(&masks), usage);
        let upload = || exclusions.into_iter().map(|masks| masks.map(filled)).collect::<Vec<_>>();
        let exclusions = guarded(device, exclusion_bytes, upload)?;
        let topology = |group: &Group| Some(group.source.topology(pages.get(group.source.page)?));
        Ok(Self {
            topology: layout.groups.iter().filter_map(topology).collect(),
            layout,
            table: table_buffer,
            choices_offset: table.parts.len(),
            needed_states_offset: words as u32,
            buffers,
            batches,
            parts,
            uniforms: uniforms.into_buffer(device, "scene dispatches"),
            shapes: shapes.into_buffer(device, "draw shapes"),
            exclusions,
        })
    }

    /// The size of all buffers in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let exclusions = self.exclusions.iter().flatten().map(wgpu::Buffer::size).sum::<u64>();
        self.buffers.bytes + self.table.size() + exclusions
    }

    /// The caster of a group of polygons.
    pub(crate) fn polygons<'a>(&self, content: &'a Content, group: usize) -> Option<PolygonCaster<'a>> {
        let first = self.layout.groups.get(group)?.first;
        let caster = content.casters.get(*self.layout.order.get(first as usize)?)?;
        let [offset_words, stride_words] = caster.position_words();
        Some(PolygonCaster { caster, mesh: caster.mesh.polygons.as_ref()?, offset_words, stride_words })
    }

    /// For each caster of polygons and batch its lights, and the uniform that they are uploaded to.
    pub(crate) fn light_batches(&self, content: &Content) -> Vec<(wgpu::Buffer, LightBatch)> {
        let light_batch = |part: &GroupBatch| {
            let buffers = self.buffers.groups.get(part.group)?.get(part.batch)?.polygons.as_ref()?;
            let PolygonCaster { caster, offset_words, stride_words, .. } = self.polygons(content, part.group)?;
            let light = |bit: usize| caster.light(&content.lights, (32 * part.batch + bit) as u32).map(Light::to_array);
            Some((buffers.lights.clone(), LightBatch::of_bits(light, part.lights, offset_words, stride_words)))
        };
        self.parts.iter().filter_map(light_batch).collect()
    }
}

/// For each group and batch the masks of faces that callers exclude, by slots. `None`: there are none.
fn caller_exclusions(
    layout: &Layout,
    table: &Table,
    casters: &SlotMap<DefaultKey, CasterEntry>,
) -> Vec<Option<Vec<u32>>> {
    let batches = table.batches;
    let mut exclusions = vec![None; layout.groups.len() * batches];
    for (&key, slots) in layout.order.iter().zip(&layout.slots) {
        let Some((caster, group)) = casters.get(key).zip(layout.groups.get(slots.group)) else { continue };
        for (light, faces) in caster.all_excluded() {
            let bit = light.bit as usize;
            let Some(masks) = exclusions.get_mut(slots.group * batches + bit / 32) else { continue };
            let masks = masks.get_or_insert_with(|| vec![0; group.face_slots() as usize]);
            for &slot in &**faces {
                if let Some(mask) = masks.get_mut((slots.faces.start + slot) as usize) {
                    *mask |= 1 << (bit % 32);
                }
            }
        }
    }
    exclusions
}

/// The bits of a batch up to the last light.
fn room(lights: &Lights, batch: usize) -> u32 {
    32 - lights.used.word(batch).leading_zeros()
}

/// A buffer of `bytes` that begins with the table.
fn table_buffer(device: &wgpu::Device, table: &Table, bytes: u64) -> Result<wgpu::Buffer, ShadowError> {
    let label = "scene table";
    check(&[Allocation { label, bytes }], device.limits().max_buffer_size, None)?;
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    let buffer = guarded(device, bytes, || mapped(device, label, bytes, usage))?;
    let is_written = write_mapped(&buffer, bytemuck::cast_slice(&table.parts));
    if is_written { Ok(buffer) } else { Err(DeviceError::Lost.into()) }
}

/// The groups and batches, with uniforms that have the fields of `shared`. Their lights and offsets of uniforms are 0.
fn parts(
    shared: &SceneDispatch,
    groups: &[Group],
    sizes: &[Vec<GroupSizes>],
    work_offsets: &[Vec<WorkOffsets>],
) -> Vec<GroupBatch> {
    // The cache has the versions of lights and casters, those of lists, then the words of clusters.
    let versions = 4 + shared.batches * (32 + 2 * shared.casters);
    let mut clusters_offset = versions + 32 * shared.batches * groups.len() as u32;
    let mut parts = Vec::new();
    for (number, ((group, sizes), work_offsets)) in groups.iter().zip(sizes).zip(work_offsets).enumerate() {
        for (batch, (&sizes, work)) in sizes.iter().zip(work_offsets).enumerate() {
            let dispatch = SceneDispatch {
                batch: batch as u32,
                lists_offset: versions + 32 * parts.len() as u32,
                face_chunks_offset: group.face_chunks_offset as u32,
                edge_chunks_offset: group.edge_chunks_offset as u32,
                face_chunks: group.face_chunks,
                edge_chunks: group.edge_chunks,
                work_count: work.count as u32,
                face_work: work.faces as u32,
                edge_work: work.edges as u32,
                capacity: sizes.capacity,
                clusters_offset,
                ..*shared
            };
            clusters_offset += CLUSTER_WORDS * group.face_chunks;
            parts.push(GroupBatch { group: number, batch, sizes, lights: 0, dispatch, offset: 0, shape: 0 });
        }
    }
    parts
}
