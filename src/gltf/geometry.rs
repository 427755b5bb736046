//! Merges the primitives of a glTF mesh into one [`Geometry`].

use std::collections::HashMap;

use super::budget::grown;
use super::document::{InfluenceSet, Mesh, Primitive};
use super::error::GltfError;
use super::extensions;
use super::reader::Reader;
use super::triangles::{self, Place};
use super::vertices::{self, HighestJoint, Vertices};
use crate::model::{Geometry, GeometryOptions, Influences, ModelError};

/// A merged mesh, before welding.
#[derive(Debug)]
pub(super) struct Merged {
    pub(super) geometry: Geometry,
    /// The highest joint of each primitive that has joints.
    pub(super) highest_joints: Vec<HighestJoint>,
}

/// Primitives of a mesh with equal keys share vertices.
#[derive(PartialEq, Eq, Hash)]
struct Key<'a> {
    position: usize,
    targets: &'a [Option<usize>],
    influences: Vec<(u32, usize, usize)>,
}

/// Merges all triangle primitives of mesh `index`. Vertices of the other primitives are read too, so that their errors
/// are told, and then dropped. `skinned_by` is a node that gives the mesh a skin. Without such a node the joints are
/// dropped.
pub(super) fn merge(reader: &Reader<'_>, index: usize, skinned_by: Option<usize>) -> Result<Merged, GltfError> {
    let mesh = &reader.document.meshes[index];
    if let Some(fault) = &mesh.fault {
        return Err(GltfError::clone(fault));
    }
    let mut draft = Draft::new(mesh, skinned_by.is_some());
    let mut highest_joints = Vec::new();
    let mut blocks = HashMap::new();
    let mark = reader.budget.mark();
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        // Reading the last primitive took memory that is free again.
        reader.budget.settle(mark, draft.bytes());
        let Some(position) = primitive.position else {
            continue;
        };
        let place = format!("meshes[{index}].primitives[{p}]");
        let read = || vertices::read(reader, primitive, position, skinned_by.is_some(), &place);
        let checked = check_compression(reader, primitive, &place);
        if !triangles::has_triangles(primitive.mode) {
            reader.warnings.leave_out(checked.and_then(|()| read()))?;
            continue;
        }
        checked?;
        if let Some(node) = skinned_by
            && primitive.influences.is_empty()
            && primitive.influences_fault.is_none()
        {
            return Err(GltfError::NotSkinned { node, mesh: index, primitive: p });
        }
        let first = if let Some(&first) = blocks.get(&key(primitive, position)) {
            first
        } else {
            let vertices = read()?;
            highest_joints.extend(vertices.bindings.highest.clone());
            let first = draft.append(&vertices, reader, &place)?;
            blocks.insert(key(primitive, position), first);
            first
        };
        let at = Place { mesh: index, primitive: p };
        let faces = triangles::read(reader, primitive, reader.count(position)?, at)?;
        reader.charge(grown(&draft.faces, faces.len()), 1, &|| place.clone())?;
        let faces = faces.into_iter().map(|face| face.map(|v| v + first));
        draft.faces.extend(faces);
    }
    reader.budget.settle(mark, draft.bytes());
    let geometry =
        draft.finish(mesh).map_err(|source| GltfError::Model { place: format!("meshes[{index}]"), source })?;
    Ok(Merged { geometry, highest_joints })
}

fn key(primitive: &Primitive, position: usize) -> Key<'_> {
    let set = |s: &InfluenceSet| (s.set, s.joints, s.weights);
    Key { position, targets: &primitive.targets, influences: primitive.influences.iter().map(set).collect() }
}

/// Refuses a primitive whose plain data was left out in compression. It would read as zeros.
fn check_compression(reader: &Reader<'_>, primitive: &Primitive, place: &str) -> Result<(), GltfError> {
    let empty = |accessor: usize| {
        reader.accessor(accessor).is_ok_and(|accessor| accessor.view.is_none() && accessor.sparse.is_none())
    };
    if primitive.draco && primitive.position.into_iter().chain(primitive.indices).any(empty) {
        return Err(GltfError::Extension {
            name: extensions::DRACO.to_owned(),
            place: place.to_owned(),
            advice: extensions::DRACO_ADVICE,
        });
    }
    Ok(())
}

/// A geometry while primitives are added to it.
struct Draft {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    morph_targets: Vec<Vec<[f32; 3]>>,
    /// Offsets, joints and weights.
    influences: Option<(Vec<u32>, Vec<u32>, Vec<f32>)>,
}

impl Draft {
    fn new(mesh: &Mesh, skinned: bool) -> Self {
        Self {
            positions: Vec::new(),
            faces: Vec::new(),
            morph_targets: vec![Vec::new(); mesh.targets],
            influences: skinned.then(|| (vec![0], Vec::new(), Vec::new())),
        }
    }

    /// The memory of what is merged, and of the numbers of its vertices.
    fn bytes(&self) -> u64 {
        let vectors = self.positions.capacity()
            + self.faces.capacity()
            + self.morph_targets.iter().map(Vec::capacity).sum::<usize>();
        let influences = self
            .influences
            .as_ref()
            .map_or(0, |(offsets, joints, weights)| offsets.capacity() + joints.capacity() + weights.capacity());
        (12 * vectors + 4 * (influences + self.positions.len())) as u64
    }

    fn finish(self, mesh: &Mesh) -> Result<Geometry, ModelError> {
        let influences = self.influences.map(|(offsets, joints, weights)| Influences::new(offsets, joints, weights));
        let options = GeometryOptions {
            name: mesh.name.clone(),
            morph_targets: self.morph_targets,
            influences: influences.transpose()?,
            source_vertices: None,
        };
        Geometry::new(self.positions, self.faces, options)
    }

    /// Adds vertices and returns the index of the first.
    fn append(&mut self, vertices: &Vertices, reader: &Reader<'_>, place: &str) -> Result<u32, GltfError> {
        let first = self.positions.len();
        let entries = self.influences.as_ref().map_or(0, |(_, joints, _)| joints.len());
        // Indices and offsets are u32.
        let over = (first + vertices.positions.len()).max(entries + vertices.bindings.joints.len()) as u64;
        if over > u64::from(u32::MAX) {
            return Err(GltfError::TooManyVertices { place: place.to_owned() });
        }
        let (count, joints) = (vertices.positions.len(), vertices.bindings.joints.len());
        let targets: u64 = self.morph_targets.iter().map(|target| grown(target, count)).sum();
        let influences = self
            .influences
            .as_ref()
            .map_or(0, |(offsets, all, weights)| grown(offsets, count) + grown(all, joints) + grown(weights, joints));
        reader.charge(grown(&self.positions, count) + targets + influences, 1, &|| place.to_owned())?;
        // The number of each vertex in the file, once the mesh is complete.
        reader.charge(count as u64, 4, &|| place.to_owned())?;
        self.positions.extend_from_slice(&vertices.positions);
        for (target, offsets) in self.morph_targets.iter_mut().zip(&vertices.targets) {
            target.extend_from_slice(offsets);
        }
        if let Some((offsets, joints, weights)) = &mut self.influences {
            let mut end = entries as u32;
            offsets.reserve(vertices.bindings.counts.len());
            for count in &vertices.bindings.counts {
                end += count;
                offsets.push(end);
            }
            joints.extend_from_slice(&vertices.bindings.joints);
            weights.extend_from_slice(&vertices.bindings.weights);
        }
        Ok(first as u32)
    }
}
