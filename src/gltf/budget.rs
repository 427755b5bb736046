//! The memory of loading a file. It is charged before it is allocated.

use std::cell::Cell;

use super::document::Node;
use super::error::GltfError;
use super::placement::Placement;
use crate::mesh::Weld;
use crate::model::{Geometry, Influences, Instance, InstancePose};

/// The memory that loading one input may take, in bytes. A charge is never given back, so the charges bound the peak,
/// and also the time.
#[derive(Debug)]
pub(super) struct Budget {
    limit: u64,
    used: Cell<u64>,
}

/// The largest size of a list that grows one by one, for each byte of its elements: the old and the new array while it
/// doubles.
const GROWTH: u64 = 3;
/// Bytes for a JSON object: the tree of its members, the struct that it becomes, the list and the path that name it.
const JSON_OBJECT: u64 = 1536;
/// Bytes for a member, an array, or an element of an array.
const JSON_VALUE: u64 = 160;
/// Bytes for each byte of text. Names are copied to the descriptions of meshes, skins and animations.
const JSON_TEXT: u64 = 4;
/// Bytes for a face, and for a vertex, of all instances: `Mesh` with its edge records during construction.
const PLACED_FACE: u64 = 132;
const PLACED_VERTEX: u64 = 12;
/// Bytes for an instance, for a matrix of its pose, and for a morph weight.
const INSTANCE: u64 =
    GROWTH * (size_of::<Instance>() + size_of::<Placement>() + size_of::<InstancePose>()) as u64 + 128;
const MATRIX: u64 = 160;
const MORPH_WEIGHT: u64 = 32;
/// Bytes for a node besides its JSON: the struct, its place in the forest, its matrices in a pose.
const NODE: u64 = GROWTH * size_of::<Node>() as u64 + 512;

/// More bytes for a vertex that is welded by distance: its cell, boxes of its cell, and its group without and with its data.
const WELD_BY_DISTANCE: u64 = 256;

impl Budget {
    pub(super) fn new(limit: u64) -> Self {
        Self { limit, used: Cell::new(0) }
    }

    /// Charges `count` elements of `size` bytes that are about to be allocated.
    pub(super) fn charge(&self, count: u64, size: u64, what: &dyn Fn() -> String) -> Result<(), GltfError> {
        let needed = count.saturating_mul(size).saturating_add(self.used.get());
        if needed > self.limit {
            return Err(GltfError::TooLarge { what: what(), needed, limit: self.limit });
        }
        self.used.set(needed);
        Ok(())
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

    pub(super) fn charge_nodes(&self, nodes: usize) -> Result<(), GltfError> {
        self.charge(nodes as u64, NODE, &|| "nodes".to_owned())
    }

    /// Charges the merging of a primitive's `vertices`, with `entries` joints and weights, into a mesh.
    pub(super) fn charge_merging(
        &self,
        vertices: usize,
        entries: usize,
        targets: usize,
        is_skinned: bool,
        what: &dyn Fn() -> String,
    ) -> Result<(), GltfError> {
        let lists = 12 * (1 + targets as u64) + 4;
        let offset = if is_skinned { 4 } else { 0 };
        self.charge(vertices as u64, GROWTH * (lists + offset), what)?;
        self.charge(entries as u64, GROWTH * 8, what)
    }

    /// Charges the welding of a mesh, and the list of its joints in use.
    pub(super) fn charge_welding(
        &self,
        geometry: &Geometry,
        weld: Weld,
        what: &dyn Fn() -> String,
    ) -> Result<(), GltfError> {
        let vertices = geometry.positions().len() as u64;
        let entries = geometry.influences().map_or(0, |i: &Influences| i.joints().len()) as u64;
        // Two tables with chains and their groups, and the vertices that are kept, renumbered, with their data.
        let tables = 2 * (16 + 4 + 4);
        let kept = GROWTH * 8 + 4 + 12 * (1 + geometry.morph_targets().len() as u64) + GROWTH * 4 + 4;
        let by_distance = if matches!(weld, Weld::Distance(_)) { WELD_BY_DISTANCE } else { 0 };
        self.charge(vertices, tables + kept + by_distance, what)?;
        self.charge(entries, GROWTH * 8 + 24, what)?;
        self.charge(geometry.faces().len() as u64, 12, what)
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
        self.charge(geometry.faces().len() as u64, PLACED_FACE, what)?;
        self.charge(geometry.positions().len() as u64, PLACED_VERTEX, what)
    }
}
