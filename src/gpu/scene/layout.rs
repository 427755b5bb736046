//! The layout of a scene: groups, slots, and offsets in the scene table.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use bytemuck::Zeroable;
use slotmap::{DefaultKey, SlotMap};

use super::caster::{CasterEntry, Content, MeshEntry, Placement};
use super::mask::LightMask;
use super::occluders::OccluderLayout;
use super::sources::Source;
use super::table::{LIGHT_PARTS, Part, Table, flag};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::extract::buffers::smooth_edges;
use crate::gpu::extract::polygon_buffers::PolygonCounts;
use crate::layout::caster_flags::GROUP_EXCLUDES;
use crate::layout::{CHUNK, SceneCaster};
use crate::mesh::EdgeCounts;

/// Casters of one page that read positions from one source: one dispatch of each stage for each batch of lights. A source
/// with more slots than a binding holds has several groups. A caster of polygons is a group of its own, because the stages
/// of `Extractor` extract it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Group {
    pub(crate) source: Source,
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
    /// Whether faces of a caster are excluded, by the caller or as occluded ones.
    pub(crate) excludes: bool,
    /// The polygons of its only caster.
    pub(crate) polygons: Option<PolygonCounts>,
}

/// The slots of a caster in its group.
#[derive(Debug)]
pub(crate) struct CasterSlots {
    pub(crate) group: usize,
    pub(crate) faces: Range<u32>,
    first_edge: u32,
    /// The faces of the slots. `None`: the order of the mesh.
    pub(crate) order: Option<Arc<[u32]>>,
}

/// The part of a scene that casters which only move, and lights which only change, leave as it is.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    pub(crate) groups: Vec<Group>,
    /// The casters, in the order of the table.
    pub(crate) order: Vec<DefaultKey>,
    /// Their slots.
    pub(crate) slots: Vec<CasterSlots>,
    /// The occluders in the table: none if occluders cull nothing.
    pub(crate) occluders: OccluderLayout,
    /// Parts of the table that each encode uploads. The casters of chunks follow, and are written once.
    pub(crate) uploaded: usize,
}

impl Group {
    fn new(source: &Source, first: u32) -> Self {
        Self { source: source.clone(), first, ..Self::default() }
    }

    /// Adds a caster.
    fn add(&mut self, caster: &CasterEntry) {
        let mesh = &caster.mesh;
        self.excludes |= caster.is_excluding();
        self.polygons = mesh.polygons.as_ref().map(|polygons| polygons.counts);
        self.face_chunks += mesh.face_chunks();
        self.proxy_chunks += if caster.in_depth { 0 } else { mesh.face_chunks() };
        self.edge_chunks += mesh.edge_chunks();
        self.counts.consistent += mesh.counts.consistent;
        self.counts.inconsistent += mesh.counts.inconsistent;
        self.counts.boundary += mesh.counts.boundary;
        self.smooth += smooth_edges(mesh.counts.consistent);
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
        let Content { casters, lights, .. } = content;
        // Excluded faces of removed lights end.
        for caster in casters.values_mut() {
            caster.excluded.retain(|(light, _)| lights.check(*light).is_ok());
            caster.occluded.retain(|(light, _)| lights.check(*light).is_ok());
        }
        let mut layout = Self::default();
        layout.add_casters(casters, limits);
        layout.assign_offsets(table, content, limits)?;
        layout.write(table, content, encode);
        Ok(layout)
    }

    /// Adds the groups of all casters, source by source.
    #[allow(clippy::mutable_key_type, reason = "buffers are compared by identity")]
    fn add_casters(&mut self, casters: &SlotMap<DefaultKey, CasterEntry>, limits: &DispatchLimits) {
        let mut by_source: HashMap<Source, Vec<(DefaultKey, &CasterEntry)>> = HashMap::new();
        let mut sources = Vec::new();
        for (key, caster) in casters {
            let new = |source: &Source| {
                sources.push(source.clone());
                Vec::new()
            };
            by_source.entry(Source::of(caster)).or_insert_with_key(new).push((key, caster));
        }
        for source in sources {
            self.add_groups(&source, by_source.get(&source).into_iter().flatten(), limits);
        }
    }

    /// Adds the groups of a source.
    fn add_groups<'a>(
        &mut self,
        source: &Source,
        casters: impl Iterator<Item = &'a (DefaultKey, &'a CasterEntry)>,
        limits: &DispatchLimits,
    ) {
        let mut group = Group::new(source, self.order.len() as u32);
        for &(key, caster) in casters {
            let mesh = &caster.mesh;
            let is_begun = self.order.len() as u32 > group.first;
            let is_alone = group.polygons.is_some() || mesh.polygons.is_some();
            if (is_begun && is_alone) || (group.face_chunks > 0 && !group.has_room(mesh, limits)) {
                let next = Group::new(source, self.order.len() as u32);
                self.groups.push(std::mem::replace(&mut group, next));
            }
            let first_face = group.face_slots();
            self.slots.push(CasterSlots {
                group: self.groups.len(),
                faces: first_face..first_face + mesh.faces,
                first_edge: group.edge_slots(),
                order: mesh.order.clone(),
            });
            self.order.push(key);
            group.add(caster);
        }
        self.groups.push(group);
    }

    /// Assigns offsets in the table.
    fn assign_offsets(
        &mut self,
        table: &mut Table,
        content: &mut Content,
        limits: &DispatchLimits,
    ) -> Result<(), DeviceError> {
        let Content { casters, lights, .. } = content;
        (table.casters, table.batches) = (self.order.len(), lights.used.batches());
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

    /// Writes the table: casters with their lights, the caster of each chunk, and what all casters share.
    fn write(&self, table: &mut Table, content: &mut Content, encode: u32) {
        let Content { casters, lights, .. } = content;
        for (&key, slots) in self.order.iter().zip(&self.slots) {
            let Some((caster, group)) = casters.get_mut(key).zip(self.groups.get(slots.group)) else { continue };
            caster.is_moved = false;
            caster.version = encode;
            let slots = SceneCaster {
                flags: flag(group.excludes, GROUP_EXCLUDES),
                first_face_slot: slots.faces.start,
                first_edge_slot: slots.first_edge,
                group: slots.group as u32,
                first_caster: group.first,
                ..SceneCaster::zeroed()
            };
            table.put_caster(caster, slots);
            table.put_lights(caster, lights);
            for (offset, first_slot, chunks) in [
                (group.face_chunks_offset, slots.first_face_slot, caster.mesh.face_chunks()),
                (group.edge_chunks_offset, slots.first_edge_slot, caster.mesh.edge_chunks()),
            ] {
                let first = 4 * offset + (first_slot / CHUNK) as usize;
                let words = table.parts.as_flattened_mut().get_mut(first..first + chunks as usize);
                words.unwrap_or_default().fill(caster.index);
            }
        }
        table.put_ranges(lights);
        self.occluders.write(table, &self.order, content);
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
