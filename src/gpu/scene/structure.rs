//! The layout, the buffers and the uniforms of a scene. They are made anew only when casters or lights come and go.

use slotmap::{DefaultKey, SlotMap};

use super::buffers::{Buffers, CLUSTER_WORDS, GroupSizes, Sizes, WorkPlace, work_places};
use super::caster::{CasterEntry, MeshEntry, Placement};
use super::layout::{Group, Layout};
use super::lights::Lights;
use super::options::{Measuring, SceneOptions};
use super::pages::{Page, Pages};
use super::sources::{GroupTopology, Source, Sources};
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
use crate::layout::{DrawShape, LightBatch, SceneDispatch};

/// One group of casters and one batch of lights, as the stages are dispatched for them.
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

/// A scene as it was laid out. Frames keep it, so that a frame that is submitted later finds its own buffers.
#[derive(Debug)]
pub(crate) struct Structure {
    pub(crate) layout: Layout,
    /// The scene table. Its part about chunks is written here, once. Each encode uploads all that comes before it.
    pub(crate) table: wgpu::Buffer,
    /// Where the choices of shadow volumes begin in the table, in units of 16 bytes.
    pub(crate) choices_offset: usize,
    /// The word of the work lists from which on there is one for each caster: whether figures are not needed.
    pub(crate) needed_states_offset: u32,
    pub(crate) buffers: Buffers,
    pub(crate) batches: usize,
    pub(crate) parts: Vec<GroupBatch>,
    pub(crate) uniforms: wgpu::Buffer,
    pub(crate) shapes: wgpu::Buffer,
    /// For each group and batch the masks of faces that callers exclude, if there are any.
    pub(crate) given: Vec<Option<wgpu::Buffer>>,
    /// For each group.
    pub(crate) topology: Vec<GroupTopology>,
}

/// Numbers of a structure and of the encode that lays it out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number {
    /// No other structure of the scene has the same.
    pub(crate) structure: u32,
    pub(crate) encode: u32,
}

/// All that a structure is made from.
pub(crate) struct Making<'a> {
    pub(crate) pipelines: &'a Pipelines,
    pub(crate) meshes: &'a SlotMap<DefaultKey, MeshEntry>,
    pub(crate) sources: &'a Sources,
    pub(crate) pages: &'a Pages,
    /// The bytes of pages and deformers.
    pub(crate) others: u64,
    pub(crate) lights: &'a Lights,
    pub(crate) options: &'a SceneOptions,
    /// Views that there is room for in the table.
    pub(crate) views: usize,
    /// Whether views may have receivers.
    pub(crate) has_receivers: bool,
}

impl Structure {
    /// Lays the scene out anew. `old` gives its buffers where they are large enough.
    pub(crate) fn new(
        making: &Making<'_>,
        casters: &mut SlotMap<DefaultKey, CasterEntry>,
        table: &mut Table,
        old: Option<&Self>,
        number: Number,
    ) -> Result<Self, ShadowError> {
        let Making { pipelines, meshes, lights, options, views, .. } = *making;
        let device = pipelines.device();
        let limits = DispatchLimits::new(&device.limits());
        let layout = Layout::new(table, casters, meshes, lights, number.encode, &limits)?;
        let batches = table.batches;
        let sizes: Vec<Vec<GroupSizes>> = layout
            .groups
            .iter()
            .map(|group| {
                (0..batches).map(|batch| GroupSizes::new(group, room(lights, batch), options, &limits)).collect()
            })
            .collect();
        let (places, words) = work_places(&layout.groups, batches);
        let pairs = (table.casters * batches) as u64;
        let [_, choices] = choice_bytes(options, making.has_receivers, [table.casters, 32 * batches, views]);
        let table_bytes = (table.parts.len() * size_of::<Part>()) as u64 + choices;
        if table_bytes > limits.binding {
            let limit = limits.binding;
            return Err(DeviceError::BindingTooLarge { what: "the scene table", bytes: table_bytes, limit }.into());
        }
        let given = given_masks(&layout, table, casters);
        let given_bytes: u64 = given.iter().flatten().map(|masks| 4 * masks.len() as u64).sum();
        let others = making.others + table_bytes + given_bytes;
        let old = old.map(|old| &old.buffers);
        let memory_limit = options.memory_limit;
        let face_chunks = layout.groups.iter().map(|group| u64::from(group.face_chunks)).sum();
        let work = words + table.casters as u64;
        let wanted = Sizes { groups: &sizes, pairs, batches, face_chunks, work, others, memory_limit };
        let buffers = Buffers::new(device, old, &wanted, &limits)?;
        let table_buffer = table_buffer(device, table, table_bytes)?;
        let room = |batch| room(lights, batch);
        let ids = [number.structure, u32::from(!options.measuring.has(Measuring::BITS))];
        let (parts, uniforms, shapes) = parts(&layout, table, &sizes, &places, room, ids);
        let uniforms = uniforms.into_buffer(device, "scene dispatches");
        let shapes = shapes.into_buffer(device, "draw shapes");
        let choices_offset = table.parts.len();
        let usage = wgpu::BufferUsages::COPY_SRC;
        let filled = |masks: Vec<u32>| filled(device, "excluded by callers", bytemuck::cast_slice(&masks), usage);
        let given =
            guarded(device, given_bytes, || given.into_iter().map(|masks| masks.map(filled)).collect::<Vec<_>>())?;
        let topology = |group: &Group| {
            let source = making.sources.get(group.source)?;
            Some(source.topology(making.pages.get(source.page)?))
        };
        let topology = layout.groups.iter().filter_map(topology).collect();
        let needed_states_offset = words as u32;
        Ok(Self {
            layout,
            table: table_buffer,
            choices_offset,
            needed_states_offset,
            buffers,
            batches,
            parts,
            uniforms,
            shapes,
            given,
            topology,
        })
    }

    /// The size of all buffers in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let given = self.given.iter().flatten().map(wgpu::Buffer::size).sum::<u64>();
        self.buffers.bytes + self.table.size() + given
    }

    /// The mesh of the only caster of a group of polygons, and where its vertices are: in the page or a buffer, the word of the
    /// first and the words from one to the next.
    pub(crate) fn polygons<'a>(
        &self,
        meshes: &'a SlotMap<DefaultKey, MeshEntry>,
        casters: &SlotMap<DefaultKey, CasterEntry>,
        group: usize,
    ) -> Option<(&'a PolygonMesh, [u32; 2])> {
        let first = self.layout.groups.get(group)?.first;
        let caster = casters.get(*self.layout.order.get(first as usize)?)?;
        let mesh = meshes.get(caster.mesh)?;
        let [_, _, vertices, _] = &mesh.run.ranges;
        let place = match caster.placement {
            Placement::Rigid(_) => [3 * vertices.start, 3],
            Placement::World { offset, stride } => [offset, stride],
        };
        Some((mesh.polygons.as_ref()?, place))
    }

    /// The lights of casters of polygons, as the extraction of each takes them, for each batch.
    pub(crate) fn light_batches(
        &self,
        meshes: &SlotMap<DefaultKey, MeshEntry>,
        casters: &SlotMap<DefaultKey, CasterEntry>,
        lights: &Lights,
    ) -> Vec<(wgpu::Buffer, LightBatch)> {
        let of_part = |part: &GroupBatch| {
            let buffers = self.buffers.groups.get(part.group)?.get(part.batch)?.polygons.as_ref()?;
            let caster = casters.get(*self.layout.order.get(self.layout.groups.get(part.group)?.first as usize)?)?;
            let (_, [offset, stride]) = self.polygons(meshes, casters, part.group)?;
            let light = |bit: usize| caster.light(lights, (32 * part.batch + bit) as u32).map(Light::to_array);
            Some((buffers.lights.clone(), LightBatch::of_bits(light, part.lights, offset, stride)))
        };
        self.parts.iter().filter_map(of_part).collect()
    }

    /// The page of a group, and the part of a caller's buffer that its positions are read from, unless they are the
    /// page's.
    pub(crate) fn source<'a>(&self, making: &Making<'a>, group: usize) -> Option<(&'a Page, &'a Source)> {
        let source = making.sources.get(self.layout.groups.get(group)?.source)?;
        Some((making.pages.get(source.page)?, source))
    }
}

/// For each group and batch the masks of faces that callers exclude, by slots. `None`: there are none.
fn given_masks(layout: &Layout, table: &Table, casters: &SlotMap<DefaultKey, CasterEntry>) -> Vec<Option<Vec<u32>>> {
    let batches = table.batches;
    let mut given = vec![None; layout.groups.len() * batches];
    for (&key, index) in layout.order.iter().zip(0_u32..) {
        let Some(caster) = casters.get(key).filter(|caster| caster.is_excluding()) else { continue };
        let Some(number) = layout.groups.iter().rposition(|group| group.first <= index) else { continue };
        let room = layout.groups.get(number).map_or(0, Group::face_slots);
        for (light, faces) in caster.all_excluded() {
            let bit = light.bit as usize;
            let Some(masks) = given.get_mut(number * batches + bit / 32) else { continue };
            let masks = masks.get_or_insert_with(|| vec![0; room as usize]);
            let first = table.first_face_slot(index);
            for &slot in &**faces {
                if let Some(mask) = masks.get_mut((first + slot) as usize) {
                    *mask |= 1 << (bit % 32);
                }
            }
        }
    }
    given
}

/// The bits of a batch up to the last light.
fn room(lights: &Lights, batch: usize) -> u32 {
    32 - lights.used.word(batch).leading_zeros()
}

/// The table as it is, with `bytes` in all.
fn table_buffer(device: &wgpu::Device, table: &Table, bytes: u64) -> Result<wgpu::Buffer, ShadowError> {
    let label = "scene table";
    check(&[Allocation { label, bytes }], device.limits().max_buffer_size, None)?;
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    let buffer = guarded(device, bytes, || mapped(device, label, bytes, usage))?;
    let is_written = write_mapped(&buffer, bytemuck::cast_slice(&table.parts));
    if is_written { Ok(buffer) } else { Err(DeviceError::Lost.into()) }
}

/// The uniforms of all groups and batches.
fn parts(
    layout: &Layout,
    table: &Table,
    sizes: &[Vec<GroupSizes>],
    places: &[Vec<WorkPlace>],
    room: impl Fn(usize) -> u32,
    [structure, uses_cache]: [u32; 2],
) -> (Vec<GroupBatch>, UniformTable, UniformTable) {
    // Behind the versions of casters, and behind those of lists.
    let kept = 4 + 32 * table.batches + 2 * table.batches * table.casters;
    let mut clusters_offset = kept + 32 * table.batches * layout.groups.len();
    let (mut parts, mut uniforms, mut shapes) = (Vec::new(), UniformTable::default(), UniformTable::default());
    let batches = layout.groups.iter().zip(sizes).zip(places).enumerate();
    for (number, ((group, sizes), places)) in batches {
        for (batch, (&sizes, place)) in sizes.iter().zip(places).enumerate() {
            let dispatch = SceneDispatch {
                casters: table.casters as u32,
                batches: table.batches as u32,
                batch: batch as u32,
                lists_offset: (kept + 32 * parts.len()) as u32,
                lights_offset: table.lights_offset() as u32,
                ranges_offset: table.ranges_offset() as u32,
                face_chunks_offset: group.face_chunks_offset as u32,
                edge_chunks_offset: group.edge_chunks_offset as u32,
                face_chunks: group.face_chunks,
                edge_chunks: group.edge_chunks,
                work_count: place.count as u32,
                face_work: place.faces as u32,
                edge_work: place.edges as u32,
                capacity: sizes.capacity,
                structure,
                uses_cache,
                clusters_offset: clusters_offset as u32,
                occluders_offset: layout.occluders.at as u32,
                occluders: layout.occluders.count as u32,
                world_lights_offset: layout.occluders.lights_offset as u32,
            };
            clusters_offset += CLUSTER_WORDS * group.face_chunks as usize;
            let offset = uniforms.push(&dispatch);
            let shape = shapes.push(&DrawShape {
                lights: 32,
                capacity: sizes.capacity,
                edges: group.edge_slots(),
                vertices_per_edge: VERTICES_PER_EDGE,
            });
            parts.push(GroupBatch { group: number, batch, sizes, lights: room(batch), dispatch, offset, shape });
        }
    }
    (parts, uniforms, shapes)
}
