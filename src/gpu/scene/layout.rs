//! The layout of a scene: groups, slots, and offsets in the scene table.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use slotmap::{DefaultKey, SecondaryMap, SlotMap};

use super::caster::{CasterEntry, MeshEntry, Placement};
use super::content::Content;
use super::mask::LightMask;
use super::occluders::OccluderLayout;
use super::table::{LIGHT_PARTS, Part, Slots, Table};
use super::topology::SlotOrder;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::extract::buffers::smooth_edges;
use crate::gpu::extract::polygon_buffers::PolygonCounts;
use crate::layout::CHUNK;
use crate::mesh::EdgeCounts;

/// Casters of one page that read positions from one source: one dispatch of each stage for each batch of lights. A source
/// with more slots than a binding holds has several groups. A caster of polygons is a group of its own, because the stages
/// of `Extractor` extract it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Group {
    pub(crate) source: DefaultKey,
    /// Its first caster in the table. The casters of a group lie one after the other.
    pub(crate) first: u32,
    pub(crate) face_chunks: u32,
    pub(crate) edge_chunks: u32,
    /// Face chunks of casters that are not in the depth buffer.
    pub(crate) proxy_chunks: u32,
    /// Edge records of all casters.
    pub(crate) counts: EdgeCounts,
    /// Consistent edges that may be silhouette edges for a light, see [`smooth_edges`].
    pub(crate) smooth: usize,
    /// Offsets in the table of the casters of its chunks.
    pub(crate) face_chunks_offset: usize,
    pub(crate) edge_chunks_offset: usize,
    /// Whether the caller excludes faces of a caster.
    pub(crate) excludes: bool,
    /// The polygons of its only caster.
    pub(crate) polygons: Option<PolygonCounts>,
}

/// The part of a scene that changes only if casters or lights are added or removed.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    pub(crate) groups: Vec<Group>,
    /// The casters, in the order of the table.
    pub(crate) order: Vec<DefaultKey>,
    /// Their face slots in their groups.
    pub(crate) face_slots: Vec<Range<u32>>,
    /// The faces of their slots. `None`: the order of the mesh.
    pub(crate) slot_orders: Vec<Option<Arc<SlotOrder>>>,
    /// The occluders in the table: none if occluders cull nothing.
    pub(crate) occluders: OccluderLayout,
    /// Parts of the table that each encode uploads. The casters of chunks follow, and are written once.
    pub(crate) uploaded: usize,
}

impl Group {
    fn new(source: DefaultKey, first: u32) -> Self {
        Self { source, first, ..Self::default() }
    }

    /// Adds a caster and returns its slots.
    fn add(&mut self, mesh: &MeshEntry, in_depth: bool) -> Slots {
        let (first_face, first_edge) = (CHUNK * self.face_chunks, CHUNK * self.edge_chunks);
        let slots = Slots { first_face, first_edge, ..Slots::default() };
        self.polygons = mesh.polygons.as_ref().map(|polygons| polygons.counts);
        self.face_chunks += mesh.face_chunks();
        self.proxy_chunks += if in_depth { 0 } else { mesh.face_chunks() };
        self.edge_chunks += mesh.edge_chunks();
        self.counts.consistent += mesh.counts.consistent;
        self.counts.inconsistent += mesh.counts.inconsistent;
        self.counts.boundary += mesh.counts.boundary;
        self.smooth += smooth_edges(mesh.counts.consistent);
        slots
    }

    /// Whether the slots of a further mesh fit.
    fn has_room(&self, mesh: &MeshEntry, limits: &DispatchLimits) -> bool {
        let face_slots = u64::from(CHUNK) * (u64::from(self.face_chunks) + u64::from(mesh.face_chunks()));
        let edge_slots = u64::from(CHUNK) * (u64::from(self.edge_chunks) + u64::from(mesh.edge_chunks()));
        // A list entry has 31 bits for a slot.
        4 * face_slots <= limits.binding && edge_slots < 1 << 31
    }

    pub(crate) fn face_slots(&self) -> u32 {
        CHUNK * self.face_chunks
    }

    pub(crate) fn edge_slots(&self) -> u32 {
        CHUNK * self.edge_chunks
    }
}

impl Layout {
    /// Lays out casters and lights. Writes the table, and the offsets of each caster to its entry.
    pub(crate) fn new(
        table: &mut Table,
        content: &mut Content,
        encode: u32,
        limits: &DispatchLimits,
    ) -> Result<Self, DeviceError> {
        let Content { meshes, casters, lights, .. } = content;
        // Excluded faces of removed lights end.
        for caster in casters.values_mut() {
            caster.excluded.retain(|(light, _)| lights.check(*light).is_ok());
            caster.occluded.retain(|(light, _)| lights.check(*light).is_ok());
        }
        let mut by_source: SecondaryMap<DefaultKey, Vec<DefaultKey>> = SecondaryMap::new();
        let mut sources = Vec::new();
        for (key, caster) in &*casters {
            let Some(entry) = by_source.entry(caster.source) else { continue };
            let keys = entry.or_insert_with(|| {
                sources.push(caster.source);
                Vec::new()
            });
            keys.push(key);
        }
        let mut layout = Self::default();
        let mut slots = Vec::with_capacity(casters.len());
        for source in sources {
            let mut group = Group::new(source, layout.order.len() as u32);
            for &key in by_source.get(source).into_iter().flatten() {
                let Some(caster) = casters.get(key) else { continue };
                let Some(mesh) = meshes.get(caster.mesh) else { continue };
                let is_begun = layout.order.len() as u32 > group.first;
                let is_alone = group.polygons.is_some() || mesh.polygons.is_some();
                if (is_begun && is_alone) || (group.face_chunks > 0 && !group.has_room(mesh, limits)) {
                    let next = Group::new(source, layout.order.len() as u32);
                    layout.groups.push(std::mem::replace(&mut group, next));
                }
                let caster_slots = group.add(mesh, caster.in_depth);
                layout.face_slots.push(caster_slots.first_face..caster_slots.first_face + mesh.faces);
                slots.push(Slots { group: layout.groups.len() as u32, first_caster: group.first, ..caster_slots });
                layout.order.push(key);
                layout.slot_orders.push(mesh.order.clone());
            }
            layout.groups.push(group);
        }
        layout.mark_excluding_groups(casters, &mut slots);
        layout.assign_offsets(table, content, limits)?;
        layout.write(table, content, &slots, encode);
        Ok(layout)
    }

    /// Marks the casters of groups in which the caller excludes faces.
    fn mark_excluding_groups(&mut self, casters: &SlotMap<DefaultKey, CasterEntry>, slots: &mut [Slots]) {
        let excluding = |key: DefaultKey| casters.get(key).is_some_and(CasterEntry::is_excluding);
        for (slots, _) in slots.iter().zip(&self.order).filter(|(_, key)| excluding(**key)) {
            if let Some(group) = self.groups.get_mut(slots.group as usize) {
                group.excludes = true;
            }
        }
        for slots in slots {
            slots.group_excludes = self.groups.get(slots.group as usize).is_some_and(|group| group.excludes);
        }
    }

    /// Assigns offsets in the table.
    fn assign_offsets(
        &mut self,
        table: &mut Table,
        content: &mut Content,
        limits: &DispatchLimits,
    ) -> Result<(), DeviceError> {
        let Content { casters, lights, .. } = content;
        let parts = std::mem::take(&mut table.parts);
        *table = Table { parts, casters: self.order.len(), batches: lights.batches(), ..*table };
        let mut next = table.caster_lights_offset();
        // Casters in world space share lights if their masks are equal.
        let mut in_world: HashMap<LightMask, u32> = HashMap::new();
        for (index, &key) in (0..).zip(&self.order) {
            let Some(caster) = casters.get_mut(key) else { continue };
            let mask = caster.lights.and(&lights.used);
            let mut allocate = || {
                let first = next;
                next += (LIGHT_PARTS * mask.count(table.batches)) as usize;
                first as u32
            };
            caster.index = index;
            caster.first_light = match caster.placement {
                Placement::Rigid(_) => allocate(),
                Placement::World { .. } => *in_world.entry(mask).or_insert_with(allocate),
            };
        }
        if table.culls_by_occluders {
            (self.occluders, next) = OccluderLayout::new(&self.order, casters, table.batches, next);
        }
        self.uploaded = next;
        for group in &mut self.groups {
            group.face_chunks_offset = next;
            group.edge_chunks_offset = next + group.face_chunks.div_ceil(4) as usize;
            next = group.edge_chunks_offset + group.edge_chunks.div_ceil(4) as usize;
        }
        // Offsets of one binding fit 32 bits.
        let bytes = (next * size_of::<Part>()) as u64;
        if bytes > limits.binding {
            return Err(DeviceError::BindingTooLarge { what: "the scene table", bytes, limit: limits.binding });
        }
        table.parts.clear();
        table.parts.resize(next, [0; 4]);
        Ok(())
    }

    fn write(&self, table: &mut Table, content: &mut Content, slots: &[Slots], encode: u32) {
        let Content { meshes, casters, lights, .. } = content;
        for (&key, &slots) in self.order.iter().zip(slots) {
            let Some(caster) = casters.get_mut(key) else { continue };
            caster.is_moved = false;
            caster.version = encode;
            if let Some(mesh) = meshes.get(caster.mesh) {
                table.put_caster(caster, mesh, slots);
            }
            table.put_lights(caster, lights);
        }
        table.put_ranges(lights);
        self.occluders.write(table, &self.order, content);
        self.write_chunks(table, content);
    }

    /// Writes the caster of each chunk.
    fn write_chunks(&self, table: &mut Table, Content { meshes, casters, .. }: &Content) {
        let ends = self.groups.iter().skip(1).map(|group| group.first).chain([self.order.len() as u32]);
        for (group, end) in self.groups.iter().zip(ends) {
            let casters_with_meshes = || {
                let keys = self.order.get(group.first as usize..end as usize).unwrap_or_default();
                let meshes = keys.iter().map(|&key| casters.get(key).and_then(|caster| meshes.get(caster.mesh)));
                (group.first..).zip(meshes).filter_map(|(index, mesh)| mesh.map(|mesh| (index, mesh)))
            };
            for (offset, chunks_of) in [
                (group.face_chunks_offset, MeshEntry::face_chunks as fn(&MeshEntry) -> u32),
                (group.edge_chunks_offset, MeshEntry::edge_chunks),
            ] {
                let words = table.parts.get_mut(offset..).unwrap_or_default().as_flattened_mut();
                let chunks = casters_with_meshes()
                    .flat_map(|(index, mesh)| std::iter::repeat_n(index, chunks_of(mesh) as usize));
                words.iter_mut().zip(chunks).for_each(|(word, index)| *word = index);
            }
        }
    }
}

impl MeshEntry {
    fn face_chunks(&self) -> u32 {
        self.faces.div_ceil(CHUNK)
    }

    fn edge_chunks(&self) -> u32 {
        self.edges().div_ceil(CHUNK)
    }
}
