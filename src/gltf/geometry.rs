//! Merges the primitives of a glTF mesh into one [`Geometry`].

use std::collections::HashMap;

use super::budget::grown;
use super::colors::{self, Colors, WHITE};
use super::document::{InfluenceSet, Mesh, Primitive, checked};
use super::error::GltfError;
use super::extensions;
use super::reader::Reader;
use super::triangles;
use super::vertices::{self, HighestJoint, Vertices};
use super::warning::GltfWarning;
use crate::model::{Geometry, GeometryOptions, Influences, ModelError};

/// A merged mesh, before welding.
#[derive(Debug)]
pub(super) struct Merged {
    pub(super) geometry: Geometry,
    pub(super) colors: Colors,
    /// The highest joint of each primitive that has joints.
    pub(super) highest_joints: Vec<HighestJoint>,
}

/// Merges all triangle primitives of mesh `index`. Vertices of the other primitives are read too, so that their faults
/// are warned of, and then dropped. `skinned_by` is a node that gives the mesh a skin. Without such a node the joints are
/// dropped.
pub(super) fn merge(reader: &Reader<'_>, index: usize, skinned_by: Option<usize>) -> Result<Merged, GltfError> {
    let named = &reader.document.meshes[index];
    let mesh = checked(&named.part)?;
    let draft = Draft::new(mesh, skinned_by.is_some());
    let mut merging = Merging { reader, skinned_by, draft, blocks: HashMap::new(), highest_joints: Vec::new() };
    let mark = reader.budget.mark();
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        // Reading the last primitive took memory that is free again.
        reader.budget.settle(mark, merging.draft.bytes());
        if let Some(position) = primitive.position {
            merging.add(primitive, position, &format!("meshes[{index}].primitives[{p}]"))?;
        }
    }
    let Merging { mut draft, highest_joints, .. } = merging;
    reader.budget.settle(mark, draft.bytes());
    let json_path = format!("meshes[{index}]");
    let vertices = draft.positions.len();
    if !draft.vertex_colors.is_empty() {
        reserve(reader, &mut draft.vertex_colors, vertices, &json_path)?;
        draft.vertex_colors.resize(vertices, WHITE);
    }
    let of = |list: &mut Vec<[f32; 3]>| Some(std::mem::take(list)).filter(|colors| !colors.is_empty());
    let colors = Colors { faces: of(&mut draft.face_colors), vertices: of(&mut draft.vertex_colors) };
    let geometry = draft.finish(named.name.clone()).map_err(GltfError::model(json_path))?;
    Ok(Merged { geometry, colors, highest_joints })
}

/// The accessors that decide the vertices of a primitive.
#[derive(PartialEq, Eq, Hash)]
struct VertexSource<'a> {
    position: usize,
    targets: &'a [Option<usize>],
    influences: Option<&'a [InfluenceSet]>,
}

/// The vertices of a source in the merged mesh.
struct Block {
    /// The first of them.
    first: u32,
    /// The accessor of their colours.
    color: Option<usize>,
}

/// A mesh while its primitives are merged.
struct Merging<'a, 'r> {
    reader: &'a Reader<'r>,
    skinned_by: Option<usize>,
    draft: Draft,
    blocks: HashMap<VertexSource<'a>, Block>,
    highest_joints: Vec<HighestJoint>,
}

impl<'a> Merging<'a, '_> {
    /// Adds a primitive with positions if it has triangles.
    fn add(&mut self, primitive: &'a Primitive, position: usize, json_path: &str) -> Result<(), GltfError> {
        let reader = self.reader;
        let compression = check_compression(reader, primitive, json_path);
        if !primitive.mode.has_triangles() {
            let read = |()| vertices::read(reader, primitive, position, self.skinned_by.is_some(), json_path);
            reader.warnings.leave_out(compression.and_then(read))?;
            return Ok(());
        }
        compression?;
        if let Some(node) = self.skinned_by
            && primitive.influences.as_ref().is_ok_and(Vec::is_empty)
        {
            let problem = format!(" has a skin, but {json_path} has no JOINTS_0 and WEIGHTS_0");
            return Err(GltfError::invalid(format!("nodes[{node}]"), problem));
        }
        let first = self.first_vertex(primitive, position, json_path)?;
        let faces = triangles::read(reader, primitive, reader.count(position)?, json_path)?;
        self.draft.add_faces(reader, primitive, faces, first, json_path)
    }

    /// The first vertex of a primitive. Primitives with the same accessors share vertices; those of others are added.
    fn first_vertex(&mut self, primitive: &'a Primitive, position: usize, json_path: &str) -> Result<u32, GltfError> {
        let reader = self.reader;
        let influences = primitive.influences.as_ref().ok().map(Vec::as_slice);
        let source = VertexSource { position, targets: &primitive.targets, influences };
        let color = primitive.color.as_ref().ok().copied().flatten();
        if let Some(block) = self.blocks.get(&source) {
            if color != block.color {
                let problem =
                    ": COLOR_0 differs from that of a primitive with the same positions, which is taken instead";
                let json_path = json_path.to_owned();
                reader.warnings.push(GltfWarning::Changed { json_path, problem: problem.to_owned() })?;
            }
            return Ok(block.first);
        }
        let vertices = vertices::read(reader, primitive, position, self.skinned_by.is_some(), json_path)?;
        self.highest_joints.extend(vertices.bindings.highest.clone());
        let first = self.draft.append(&vertices, reader, json_path)?;
        self.draft.color_vertices(reader, primitive, first as usize, json_path)?;
        self.blocks.insert(source, Block { first, color });
        Ok(first)
    }
}

/// Makes room for so many elements in a list.
fn reserve<T>(reader: &Reader<'_>, list: &mut Vec<T>, length: usize, json_path: &str) -> Result<(), GltfError> {
    let more = length - list.len();
    reader.budget.charge(grown(list, more), 1, &|| json_path.to_owned())?;
    list.reserve(more);
    Ok(())
}

/// Refuses a primitive whose plain data was left out in compression. It would read as zeros.
fn check_compression(reader: &Reader<'_>, primitive: &Primitive, json_path: &str) -> Result<(), GltfError> {
    let empty = |accessor: usize| {
        reader.accessor(accessor).is_ok_and(|accessor| accessor.view.is_none() && accessor.sparse.is_none())
    };
    if primitive.draco && primitive.position.into_iter().chain(primitive.indices).any(empty) {
        let (name, json_path) = (extensions::DRACO.to_owned(), json_path.to_owned());
        return Err(GltfError::Extension { name, json_path, advice: extensions::DRACO_ADVICE });
    }
    Ok(())
}

/// A geometry while primitives are added to it.
struct Draft {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    /// Colours of the first faces and vertices; the others are white.
    face_colors: Vec<[f32; 3]>,
    vertex_colors: Vec<[f32; 3]>,
    morph_targets: Vec<Vec<[f32; 3]>>,
    is_skinned: bool,
    /// Where the joints of each vertex end. Empty without a skin, as the lists below.
    ends: Vec<u32>,
    joints: Vec<u32>,
    weights: Vec<f32>,
}

impl Draft {
    fn new(mesh: &Mesh, is_skinned: bool) -> Self {
        Self {
            positions: Vec::new(),
            faces: Vec::new(),
            face_colors: Vec::new(),
            vertex_colors: Vec::new(),
            morph_targets: vec![Vec::new(); mesh.targets],
            is_skinned,
            ends: if is_skinned { vec![0] } else { Vec::new() },
            joints: Vec::new(),
            weights: Vec::new(),
        }
    }

    /// The memory of what is merged, and of the numbers of its vertices.
    fn bytes(&self) -> u64 {
        let vectors = self.positions.capacity()
            + self.faces.capacity()
            + self.face_colors.capacity()
            + self.vertex_colors.capacity()
            + self.morph_targets.iter().map(Vec::capacity).sum::<usize>();
        let influences = self.ends.capacity() + self.joints.capacity() + self.weights.capacity();
        (12 * vectors + 4 * (influences + self.positions.len())) as u64
    }

    fn finish(self, name: Option<String>) -> Result<Geometry, ModelError> {
        let influences = self.is_skinned.then(|| Influences::new(self.ends, self.joints, self.weights));
        let options = GeometryOptions {
            name,
            morph_targets: self.morph_targets,
            influences: influences.transpose()?,
            source_vertices: None,
        };
        Geometry::new(self.positions, self.faces, options)
    }

    /// Adds vertices and returns the index of the first.
    fn append(&mut self, vertices: &Vertices, reader: &Reader<'_>, json_path: &str) -> Result<u32, GltfError> {
        let Vertices { positions, targets, bindings } = vertices;
        let first = self.positions.len();
        // Indices and offsets are u32.
        let over = (first + positions.len()).max(self.joints.len() + bindings.joints.len()) as u64;
        if over > u64::from(u32::MAX) {
            let problem = ": its mesh has more vertices or joints than 32-bit indices can name; split it";
            return Err(GltfError::invalid(json_path, problem));
        }
        let (count, joints) = (positions.len(), bindings.joints.len());
        let mut bytes = grown(&self.positions, count);
        bytes += self.morph_targets.iter().map(|target| grown(target, count)).sum::<u64>();
        if self.is_skinned {
            bytes += grown(&self.ends, count) + grown(&self.joints, joints) + grown(&self.weights, joints);
        }
        reader.budget.charge(bytes, 1, &|| json_path.to_owned())?;
        // The number of each vertex in the file, once the mesh is complete.
        reader.budget.charge(count as u64, 4, &|| json_path.to_owned())?;
        self.positions.extend_from_slice(positions);
        for (target, offsets) in self.morph_targets.iter_mut().zip(targets) {
            target.extend_from_slice(offsets);
        }
        if self.is_skinned {
            let mut end = self.joints.len() as u32;
            self.ends.reserve(bindings.counts.len());
            for count in &bindings.counts {
                end += count;
                self.ends.push(end);
            }
            self.joints.extend_from_slice(&bindings.joints);
            self.weights.extend_from_slice(&bindings.weights);
        }
        Ok(first as u32)
    }

    /// Adds the colours of a primitive's vertices, which are those from `first` on.
    fn color_vertices(
        &mut self,
        reader: &Reader<'_>,
        primitive: &Primitive,
        first: usize,
        json_path: &str,
    ) -> Result<(), GltfError> {
        let colors = colors::of_vertices(reader, primitive, self.positions.len() - first, json_path);
        if let Some(colors) = reader.warnings.leave_out(colors)?.flatten() {
            reserve(reader, &mut self.vertex_colors, self.positions.len(), json_path)?;
            self.vertex_colors.resize(first, WHITE);
            self.vertex_colors.extend(colors);
        }
        Ok(())
    }

    /// Adds a primitive's faces, whose vertices begin at `first`, and their colour.
    fn add_faces(
        &mut self,
        reader: &Reader<'_>,
        primitive: &Primitive,
        faces: Vec<[u32; 3]>,
        first: u32,
        json_path: &str,
    ) -> Result<(), GltfError> {
        let (before, after) = (self.faces.len(), self.faces.len() + faces.len());
        reserve(reader, &mut self.faces, after, json_path)?;
        self.faces.extend(faces.into_iter().map(|face| face.map(|v| v + first)));
        let color = reader.warnings.leave_out(colors::of_material(reader, primitive))?.unwrap_or(WHITE);
        if color != WHITE || !self.face_colors.is_empty() {
            reserve(reader, &mut self.face_colors, after, json_path)?;
            self.face_colors.resize(before, WHITE);
            self.face_colors.resize(after, color);
        }
        Ok(())
    }
}
