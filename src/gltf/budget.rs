//! The memory of loading a file. It is charged before it is allocated, and given back when it is freed.

use std::cell::Cell;

use super::document::{Node, Placement};
use super::error::GltfError;
use crate::mesh::Weld;
use crate::model::{Geometry, Influences, Instance, InstancePose};

/// The memory that loading one input may take, in bytes.
#[derive(Debug)]
pub(super) struct Budget {
    limit: u64,
    /// Bytes in use.
    used: Cell<u64>,
    /// The part of `used` that is never given back: see [`Budget::charge_lasting`].
    lasting: Cell<u64>,
    /// The part of `used` that is freed when the asset is complete: the content of files.
    files: Cell<u64>,
    /// Bytes that the mesh of all instances takes while it is made, beside the asset.
    placed: Cell<u64>,
    /// All charges, also those given back. They bound the time: see [`MOST_WORK`].
    charged: Cell<u64>,
}

/// State of a budget at some time, to give back all that was charged later.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    used: u64,
    lasting: u64,
}

/// How many times the limit all charges together may be. Ordinary files charge each byte a few times.
const MOST_WORK: u64 = 8;

/// The largest size of a list that grows one by one, for each byte of its elements: the old and the new array while it
/// doubles.
const GROWTH: u64 = 3;
/// Bytes for a JSON object: the tree of its members, the struct that it becomes, the list and the path that name it.
const JSON_OBJECT: u64 = 1536;
/// Bytes for a member, an array, or an element of an array.
const JSON_VALUE: u64 = 160;
/// Bytes for each byte of text. Names are copied to the descriptions of meshes, skins and animations.
const JSON_TEXT: u64 = 4;
/// Bytes for a vertex, and for a face, of a mesh that is read: position and source vertex; corners.
const VERTEX: u64 = 12 + 4;
const FACE: u64 = 12;
/// Bytes for a position of a morph target.
const OFFSET: u64 = 12;
/// Bytes for a vertex during welding, beside those before and after: two lists of groups, the remaining vertices, and
/// their new indices. The table of groups is not larger than the last two and the new positions, and is freed before.
const WELDING: u64 = 4 + 4 + 8 + 4;
/// Bytes for a face, and for a vertex, of all instances: `Mesh` with its edge records during construction. The most of a
/// face are the mesh's copy, the mates of its half-edges and three boundary records.
const PLACED_FACE: u64 = 12 + 12 + 3 * 16;
const PLACED_VERTEX: u64 = 8;
/// Bytes for an instance, for a matrix of its pose, and for a morph weight.
const INSTANCE: u64 =
    GROWTH * (size_of::<Instance>() + size_of::<Placement>() + size_of::<InstancePose>()) as u64 + 128;
const MATRIX: u64 = 160;
const MORPH_WEIGHT: u64 = 32;
/// Bytes for an instance with one matrix, and neither name nor weights.
pub(super) const RIGID_INSTANCE: u64 = INSTANCE + MATRIX;
/// Bytes for a joint in the set of those in use.
const USED_JOINT: u64 = 24;
/// Bytes for a node beside its JSON: the struct, its entry in the forest, its matrices in a pose.
pub(super) const NODE: u64 = GROWTH * size_of::<Node>() as u64 + 512;

/// More bytes for a vertex that is welded by distance: its cell, boxes of its cell, and its group without and with its data.
const WELD_BY_DISTANCE: u64 = 256;

impl Budget {
    pub(super) fn new(limit: u64) -> Self {
        let zero = || Cell::new(0);
        // Above this, sums of what is in use could overflow, and no machine has as much.
        let limit = limit.min(i64::MAX as u64);
        Self { limit, used: zero(), lasting: zero(), files: zero(), placed: zero(), charged: zero() }
    }

    /// Charges `count` elements of `size` bytes that are about to be allocated.
    pub(super) fn charge(&self, count: u64, size: u64, what: &dyn Fn() -> String) -> Result<(), GltfError> {
        let bytes = count.saturating_mul(size);
        let charged = self.charged.get().saturating_add(bytes);
        self.refuse(self.needed(bytes, 0), what)?;
        self.refuse(charged.div_ceil(MOST_WORK), what)?;
        self.charged.set(charged);
        self.used.set(self.used.get() + bytes);
        Ok(())
    }

    /// The same for data that stays.
    pub(super) fn charge_lasting(&self, bytes: u64, what: &dyn Fn() -> String) -> Result<(), GltfError> {
        self.charge(bytes, 1, what)?;
        self.lasting.set(self.lasting.get() + bytes);
        Ok(())
    }

    /// The same for a file's content, which is freed when the asset is made. [`Self::settle`] would give it
    /// back, so it must not lie between a mark and its use.
    pub(super) fn charge_file(&self, bytes: u64, what: &dyn Fn() -> String) -> Result<(), GltfError> {
        self.charge(bytes, 1, what)?;
        self.files.set(self.files.get() + bytes);
        Ok(())
    }

    /// The most bytes in use with more bytes, now and during the making of the mesh of all instances.
    pub(super) fn needed(&self, bytes: u64, placed: u64) -> u64 {
        let loading = self.used.get().saturating_add(bytes);
        let placing = loading.saturating_sub(self.files.get()).saturating_add(self.placed.get()).saturating_add(placed);
        loading.max(placing)
    }

    pub(super) fn refuse(&self, needed: u64, what: &dyn Fn() -> String) -> Result<(), GltfError> {
        if needed > self.limit {
            return Err(GltfError::TooLarge { what: what(), needed, limit: self.limit });
        }
        Ok(())
    }

    pub(super) fn mark(&self) -> Mark {
        Mark { used: self.used.get(), lasting: self.lasting.get() }
    }

    /// Gives back all that was charged since the mark, but for lasting data and for `in_use` bytes.
    pub(super) fn settle(&self, mark: Mark, in_use: u64) {
        let lasting = self.lasting.get() - mark.lasting;
        self.used.set(self.used.get().min(mark.used.saturating_add(lasting).saturating_add(in_use)));
    }

    /// Charges the values that a JSON text can hold, by its punctuation.
    pub(super) fn charge_json(&self, text: &[u8]) -> Result<(), GltfError> {
        let (mut objects, mut values) = (0, 0);
        for byte in text {
            objects += u64::from(*byte == b'{');
            values += u64::from(matches!(byte, b':' | b'[' | b','));
        }
        let what = || "the JSON".to_owned();
        self.charge(objects, JSON_OBJECT, &what)?;
        self.charge(values, JSON_VALUE, &what)?;
        self.charge(text.len() as u64, JSON_TEXT, &what)
    }

    /// Charges the welding of a mesh, and the list of its joints in use.
    pub(super) fn charge_welding(
        &self,
        geometry: &Geometry,
        weld: Weld,
        what: &dyn Fn() -> String,
    ) -> Result<(), GltfError> {
        let vertices = geometry.positions().len() as u64;
        let influences = geometry.influences();
        let entries = influences.map_or(0, |i: &Influences| i.joints().len()) as u64;
        // The offsets of the remaining vertices are a list that doubles.
        let offset = if influences.is_some() { GROWTH * 4 } else { 0 };
        let by_distance = if matches!(weld, Weld::Distance(_)) { WELD_BY_DISTANCE } else { 0 };
        self.charge(vertices, WELDING + offset + by_distance + vertex(geometry.morph_targets().len()), what)?;
        // Joints and weights, the keys of a hash, the set of joints in use.
        self.charge(entries, GROWTH * 8 + 16 + USED_JOINT, what)?;
        self.charge(geometry.faces().len() as u64, FACE, what)
    }

    /// Charges an instance, its pose, and its part of the mesh that all instances make.
    pub(super) fn charge_instance(
        &self,
        geometry: &Geometry,
        matrices: usize,
        name: Option<&String>,
        what: &dyn Fn() -> String,
    ) -> Result<(), GltfError> {
        self.charge(1, INSTANCE + name.map_or(0, |name| name.len() as u64), what)?;
        self.charge(matrices as u64, MATRIX, what)?;
        self.charge(geometry.morph_targets().len() as u64, MORPH_WEIGHT, what)?;
        let placed = placed(geometry.positions().len() as u64, geometry.faces().len() as u64);
        self.refuse(self.needed(0, placed), what)?;
        self.placed.set(self.placed.get() + placed);
        Ok(())
    }
}

/// Bytes that a mesh keeps once it is welded: the geometry, and the list of its joints in use.
pub(super) fn remaining_bytes(geometry: &Geometry) -> u64 {
    geometry.bytes() + geometry.influences().map_or(0, |i| USED_JOINT * i.joints().len() as u64)
}

/// A vertex of a mesh with so many morph targets.
fn vertex(targets: usize) -> u64 {
    (OFFSET * targets as u64).saturating_add(VERTEX)
}

/// Bytes of a mesh with this number of vertices, morph targets and faces, after reading.
pub(super) fn geometry(vertices: u64, targets: usize, faces: u64) -> u64 {
    vertices.saturating_mul(vertex(targets)).saturating_add(faces.saturating_mul(FACE))
}

/// The same while it is welded.
pub(super) fn welding(vertices: u64, targets: usize, faces: u64) -> u64 {
    geometry(vertices, targets, faces).saturating_mul(2).saturating_add(vertices.saturating_mul(WELDING))
}

/// Bytes that an instance takes while the mesh of all instances is made.
pub(super) fn placed(vertices: u64, faces: u64) -> u64 {
    vertices.saturating_mul(PLACED_VERTEX).saturating_add(faces.saturating_mul(PLACED_FACE))
}

/// The bytes of the list that `more` elements make of this one, if it has no room for them. The list itself is freed then.
pub(super) fn grown<T>(list: &Vec<T>, more: usize) -> u64 {
    let length = list.len().saturating_add(more);
    if length <= list.capacity() {
        return 0;
    }
    (length.max(2 * list.capacity()) as u64).saturating_mul(size_of::<T>() as u64)
}
