//! The layout, the buffers and the uniforms of a scene. New ones are made if casters or lights are added or removed, if
//! light masks, excluded faces, occluders, meshes or position buffers of casters change, or if capacities or the most views do.

use std::collections::HashSet;

use bytemuck::Zeroable;
use slotmap::{DefaultKey, SlotMap};

use super::buffers::{Buffers, CLUSTER_WORDS, GroupBuffers, GroupSizes, Sizes, WORK_WORDS};
use super::caster::{CasterEntry, Content};
use super::layout::{Group, Layout};
use super::options::{Measuring, SceneOptions};
use super::pages::Pages;
use super::sources::GroupTopology;
use super::table::{Part, Table};
use crate::Light;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, filled, guarded, mapped, write_mapped};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::sizes::choice_bytes;
use crate::layout::{CHUNK, DrawShape, FACE_ENTRY, LightBatch, SceneDispatch};

/// One group of casters and one batch of lights: what a dispatch of a stage covers.
#[derive(Clone, Debug)]
pub(crate) struct GroupBatch {
    pub(crate) group: usize,
    pub(crate) batch: usize,
    pub(crate) sizes: GroupSizes,
    pub(crate) buffers: GroupBuffers,
    /// The masks of faces that callers exclude, if there are any.
    pub(crate) exclusions: Option<wgpu::Buffer>,
    /// The uniform of its dispatches, and its offset.
    pub(crate) dispatch: SceneDispatch,
    pub(crate) offset: u32,
    /// The offset of its [`DrawShape`].
    pub(crate) shape: u32,
}

/// Vertices that draw one silhouette edge, as a strip.
const VERTICES_PER_EDGE: u32 = 4;

/// A layout of a scene, with its buffers. Frames hold it, so a frame that is submitted late still has its buffers. A newer
/// structure may share them.
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
    pub(crate) parts: Vec<GroupBatch>,
    pub(crate) uniforms: wgpu::Buffer,
    pub(crate) shapes: wgpu::Buffer,
    /// For each group.
    pub(crate) topology: Vec<GroupTopology>,
    /// The buffers that casters with positions of their own read, each once, sorted.
    position_buffers: Vec<wgpu::Buffer>,
}

/// The parts of a scene that a structure is made from.
pub(crate) struct Inputs<'a> {
    pub(crate) pipelines: &'a Pipelines,
    pub(crate) content: &'a Content,
    /// The bytes of pages and deformers.
    pub(crate) others: u64,
    pub(crate) options: &'a SceneOptions,
    pub(crate) room: Room,
}

/// The most views of an encode so far, and the most words for the receivers of each.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Room {
    pub(crate) views: usize,
    pub(crate) receiver_words: u64,
}

impl Room {
    /// Whether views may have receivers.
    pub(crate) fn has_receivers(self) -> bool {
        self.receiver_words > 0
    }
}

impl Structure {
    /// Makes the buffers of a layout. It reuses those of `old` that are large enough. No other structure of the scene has the
    /// same `number`.
    pub(crate) fn new(
        inputs: &Inputs<'_>,
        layout: Layout,
        table: &Table,
        old: Option<&Self>,
        number: u32,
    ) -> Result<Self, ShadowError> {
        let Inputs { pipelines, content: Content { casters, lights, pages, .. }, options, .. } = *inputs;
        let device = pipelines.device();
        let limits = DispatchLimits::new(&device.limits());
        let table_bytes = table_bytes(inputs, table, &limits)?;
        let exclusions = caller_exclusions(&layout, table, casters);
        let exclusion_bytes: u64 = exclusions.iter().flatten().map(|masks| 4 * masks.len() as u64).sum();
        let shared = shared_dispatch(&layout, table, options, number);
        let sizes_of = |group: &Group, batch| {
            let bits = 32 - lights.used.word(batch).leading_zeros(); // up to the last light
            GroupSizes::new(group, bits, options, &limits)
        };
        let (sizes, dispatches) = plan(&shared, &layout.groups, sizes_of);
        sizes.groups.iter().filter_map(|part| part.polygons).try_for_each(|part| part.check_workgroups(&limits))?;
        check_uniforms(dispatches.len(), &limits)?;
        let needed_states_offset = sizes.work as u32;
        let sizes = Sizes {
            work: sizes.work + table.casters as u64,
            others: inputs.others + table_bytes + exclusion_bytes,
            memory_limit: options.memory_limit,
            ..sizes
        };
        let buffers = Buffers::new(device, old.map(|old| &old.buffers), &sizes, &limits)?;
        let table_buffer = table_buffer(device, table, table_bytes)?;
        let usage = wgpu::BufferUsages::COPY_SRC;
        let filled = |masks: Vec<u32>| filled(device, "excluded by callers", bytemuck::cast_slice(&masks), usage);
        let upload = || exclusions.into_iter().map(|masks| masks.map(filled)).collect::<Vec<_>>();
        let exclusions = guarded(device, exclusion_bytes, upload)?;
        let Bound { parts, uniforms, shapes } = Bound::new(dispatches, &sizes, &buffers.groups, exclusions);
        let topology = |group: &Group| Some(group.source.topology(pages.get(group.source.page)?));
        let topology: Vec<_> = layout.groups.iter().filter_map(topology).collect();
        Ok(Self {
            position_buffers: position_buffers(&topology),
            topology,
            layout,
            table: table_buffer,
            choices_offset: table.parts.len(),
            needed_states_offset,
            buffers,
            parts,
            uniforms: uniforms.into_buffer(device, "scene dispatches"),
            shapes: shapes.into_buffer(device, "draw shapes"),
        })
    }

    /// Refuses buffers of casters that were destroyed since the steps were made. The steps would spoil the caller's
    /// submission.
    pub(crate) fn check_positions(&self, pipelines: &Pipelines) -> Result<(), DeviceError> {
        pipelines.check_all_bindable(&self.position_buffers)
    }

    /// The size of all buffers in bytes, but for uniforms.
    pub(crate) fn bytes(&self) -> u64 {
        let exclusions: u64 =
            self.parts.iter().filter_map(|part| part.exclusions.as_ref()).map(wgpu::Buffer::size).sum();
        self.buffers.bytes + self.table.size() + exclusions
    }

    /// The bytes of meshes that were removed since, with their pages. The steps of the structure hold them.
    pub(crate) fn removed_bytes(&self, pages: &Pages) -> u64 {
        let mut counted = HashSet::new();
        let groups = self.layout.groups.iter().zip(&self.topology);
        let removed = groups.filter(|(group, _)| pages.get(group.source.page).is_none());
        removed
            .filter(|(group, _)| counted.insert(group.source.page))
            .map(|(group, topology)| topology.page.bytes() + group.polygons.map_or(0, |of| of.boundary_bytes()))
            .sum()
    }

    /// Whether casters read positions from this buffer.
    pub(crate) fn binds(&self, positions: &wgpu::Buffer) -> bool {
        self.position_buffers.binary_search(positions).is_ok()
    }

    /// The first caster of a group. A group of polygons has no other.
    pub(crate) fn first_caster<'a>(&self, content: &'a Content, group: usize) -> Option<&'a CasterEntry> {
        let first = self.layout.groups.get(group)?.first;
        content.casters.get(*self.layout.order.get(first as usize)?)
    }

    /// For each caster of polygons and batch its lights, and the uniform that they are uploaded to.
    pub(crate) fn light_batches(&self, content: &Content) -> Vec<(wgpu::Buffer, LightBatch)> {
        let light_batch = |part: &GroupBatch| {
            let buffers = part.buffers.polygons.as_ref()?;
            let caster = self.first_caster(content, part.group)?;
            let [offset_words, stride_words] = caster.position_words();
            let light = |bit: usize| caster.light(&content.lights, (32 * part.batch + bit) as u32).map(Light::to_array);
            Some((buffers.lights.clone(), LightBatch::of_bits(light, part.sizes.lights, offset_words, stride_words)))
        };
        self.parts.iter().filter_map(light_batch).collect()
    }
}

/// The buffers of positions that are not at rest, each once.
fn position_buffers(topology: &[GroupTopology]) -> Vec<wgpu::Buffer> {
    let of_casters = topology.iter().filter(|topology| !topology.are_at_rest);
    let mut buffers: Vec<_> = of_casters.map(|topology| topology.positions.0.clone()).collect();
    buffers.sort_unstable();
    buffers.dedup();
    buffers
}

/// All groups and batches, with their uniforms.
#[derive(Default)]
struct Bound {
    parts: Vec<GroupBatch>,
    uniforms: UniformTable,
    shapes: UniformTable,
}

impl Bound {
    /// All lists have an element for each group and batch, batch after batch in each group.
    fn new(
        dispatches: Vec<SceneDispatch>,
        sizes: &Sizes,
        buffers: &[GroupBuffers],
        exclusions: Vec<Option<wgpu::Buffer>>,
    ) -> Self {
        let mut all = Self::default();
        for (((dispatch, &sizes), buffers), exclusions) in
            dispatches.into_iter().zip(&sizes.groups).zip(buffers).zip(exclusions)
        {
            let batches = dispatch.batches as usize;
            let (group, batch) = (all.parts.len() / batches, all.parts.len() % batches);
            let offset = all.uniforms.push(&dispatch);
            let shape = all.shapes.push(&DrawShape {
                lights: 32,
                capacity: sizes.capacity,
                edges: CHUNK * dispatch.edge_chunks,
                vertices_per_edge: VERTICES_PER_EDGE,
            });
            let buffers = buffers.clone();
            all.parts.push(GroupBatch { group, batch, sizes, buffers, exclusions, dispatch, offset, shape });
        }
        all
    }
}

/// Bytes of the scene table with the choices. Refuses more than one binding.
fn table_bytes(inputs: &Inputs<'_>, table: &Table, limits: &DispatchLimits) -> Result<u64, ShadowError> {
    let counts = [table.casters, 32 * table.batches, inputs.room.views];
    let [_, choices] = choice_bytes(inputs.options, inputs.room.has_receivers(), counts);
    let bytes = (table.parts.len() * size_of::<Part>()) as u64 + choices;
    if bytes > limits.binding {
        let limit = limits.binding;
        return Err(DeviceError::BindingTooLarge { what: "the scene table", bytes, limit }.into());
    }
    Ok(bytes)
}

/// Refuses uniforms of more groups and batches than one buffer holds, or offsets of 32 bits select.
fn check_uniforms(parts: usize, limits: &DispatchLimits) -> Result<(), DeviceError> {
    let bytes = (parts * UniformTable::stride::<SceneDispatch>()) as u64;
    check(&[Allocation { label: "scene dispatches", bytes }], limits.buffer.min(u32::MAX.into()), None).map(drop)
}

/// The fields that the uniforms of all groups and batches share.
fn shared_dispatch(layout: &Layout, table: &Table, options: &SceneOptions, number: u32) -> SceneDispatch {
    SceneDispatch {
        casters: table.casters as u32,
        batches: table.batches as u32,
        lights_offset: table.lights_offset() as u32,
        ranges_offset: table.ranges_offset() as u32,
        structure: number,
        uses_cache: u32::from(!options.measuring.has(Measuring::CACHED_BITS)),
        occluders_offset: layout.occluders.offset as u32,
        occluders: layout.occluders.count as u32,
        world_lights_offset: layout.occluders.lights_offset as u32,
        ..SceneDispatch::zeroed()
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

/// A buffer of `bytes` that begins with the table.
fn table_buffer(device: &wgpu::Device, table: &Table, bytes: u64) -> Result<wgpu::Buffer, ShadowError> {
    let label = "scene table";
    check(&[Allocation { label, bytes }], device.limits().max_buffer_size, None)?;
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    let buffer = guarded(device, bytes, || mapped(device, label, bytes, usage))?;
    let is_written = write_mapped(&buffer, &[bytemuck::cast_slice(&table.parts)]);
    if is_written { Ok(buffer) } else { Err(DeviceError::Lost.into()) }
}

/// The sizes and the uniforms of all groups and batches. Uniforms have the fields of `shared`.
fn plan(
    shared: &SceneDispatch,
    groups: &[Group],
    sizes_of: impl Fn(&Group, usize) -> GroupSizes,
) -> (Sizes, Vec<SceneDispatch>) {
    let (casters, batches) = (u64::from(shared.casters), u64::from(shared.batches));
    let parts = batches * groups.len() as u64;
    // The cache has the versions of lights and casters, those of lists, then the words of clusters.
    let lists_offset = 4 + batches * (32 + 2 * casters);
    // Counts come first, so that one command clears them.
    let (mut work, mut cache) = (WORK_WORDS * parts, lists_offset + 32 * parts);
    let (mut sizes, mut dispatches) = (Vec::new(), Vec::new());
    for (group, batch) in groups.iter().flat_map(|group| (0..shared.batches).map(move |batch| (group, batch))) {
        let number = dispatches.len() as u64;
        let of_part = sizes_of(group, batch as usize);
        let edge_work = work + u64::from(FACE_ENTRY * group.face_chunks);
        dispatches.push(SceneDispatch {
            batch,
            lists_offset: (lists_offset + 32 * number) as u32,
            face_chunks_offset: group.face_chunks_offset as u32,
            edge_chunks_offset: group.edge_chunks_offset as u32,
            face_chunks: group.face_chunks,
            edge_chunks: group.edge_chunks,
            work_count: (WORK_WORDS * number) as u32,
            face_work: work as u32,
            edge_work: edge_work as u32,
            capacity: of_part.capacity,
            clusters_offset: cache as u32,
            ..*shared
        });
        sizes.push(of_part);
        work = edge_work + u64::from(group.edge_chunks);
        cache += u64::from(CLUSTER_WORDS * group.face_chunks);
    }
    let sizes = Sizes {
        groups: sizes,
        batches: shared.batches as usize,
        pairs: batches * casters,
        cache,
        work,
        ..Sizes::default()
    };
    (sizes, dispatches)
}
