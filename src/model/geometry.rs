//! Triangle meshes in mesh space, with morph targets and influences.

use super::ModelError;
use crate::mesh::weld::{self, Keys, NearGroups, bits, groups, near_groups, same_bits};
use crate::mesh::{Mesh, MeshError, Weld, WeldCounts, WeldDistance, out_of_range};

/// The joints that move each vertex, with their weights. A vertex may have any number of joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Influences {
    offsets: Vec<u32>,
    joints: Vec<u32>,
    weights: Vec<f32>,
    joints_needed: usize,
}

impl Influences {
    /// Makes influences from three lists.
    ///
    /// * `offsets`: where the entries of each vertex begin in `joints` and `weights`. It has one element more than
    ///   there are vertices, begins with 0 and ends with the number of entries.
    /// * `joints` are indices into the instance's palette ([`InstancePose::palette`](super::InstancePose::palette)).
    /// * `weights` are used as given. The weights of a vertex should sum to 1.
    ///
    /// # Errors
    /// [`ModelError`] when offsets, joints and weights do not fit together, or a weight is not finite.
    pub fn new(offsets: Vec<u32>, joints: Vec<u32>, weights: Vec<f32>) -> Result<Self, ModelError> {
        if joints.len() != weights.len() {
            return Err(ModelError::InfluenceWeights { joints: joints.len(), weights: weights.len() });
        }
        let (Some(&0), Some(&last)) = (offsets.first(), offsets.last()) else {
            return Err(ModelError::FirstOffset { found: offsets.first().copied() });
        };
        if let Some(vertex) = offsets.windows(2).position(|pair| pair[0] > pair[1]) {
            return Err(ModelError::FallingOffset { vertex, begin: offsets[vertex], end: offsets[vertex + 1] });
        }
        if last as usize != joints.len() {
            return Err(ModelError::LastOffset { found: last, joints: joints.len() });
        }
        if let Some(entry) = weights.iter().position(|weight| !weight.is_finite()) {
            let vertex = offsets.partition_point(|&offset| offset as usize <= entry) - 1;
            return Err(ModelError::InfluenceWeight { vertex, joint: joints[entry], weight: weights[entry] });
        }
        Ok(Self { joints_needed: joints_needed(&joints), offsets, joints, weights })
    }

    /// Where the entries of each vertex begin in [`Influences::joints`] and [`Influences::weights`]. There is one more
    /// offset than there are vertices.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// Indices into the instance's palette.
    pub fn joints(&self) -> &[u32] {
        &self.joints
    }

    /// The weight of each joint. All are finite.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// The range of vertex `v`'s entries in [`Influences::joints`] and [`Influences::weights`]. It is empty past the
    /// last vertex.
    pub fn range(&self, v: usize) -> std::ops::Range<usize> {
        match self.offsets.get(v..).unwrap_or_default() {
            &[begin, end, ..] => begin as usize..end as usize,
            _ => 0..0,
        }
    }

    /// The largest number of entries of a vertex.
    pub fn most_per_vertex(&self) -> usize {
        self.offsets.windows(2).map(|pair| (pair[1] - pair[0]) as usize).max().unwrap_or(0)
    }

    #[cfg(feature = "gltf")]
    fn bytes(&self) -> u64 {
        4 * (self.offsets.capacity() + self.joints.capacity() + self.weights.capacity()) as u64
    }

    fn select(&self, vertices: &[usize]) -> Self {
        let mut selected = Self { offsets: vec![0], joints: Vec::new(), weights: Vec::new(), joints_needed: 0 };
        for &v in vertices {
            selected.joints.extend_from_slice(&self.joints[self.range(v)]);
            selected.weights.extend_from_slice(&self.weights[self.range(v)]);
            selected.offsets.push(selected.joints.len() as u32);
        }
        selected.joints_needed = joints_needed(&selected.joints);
        selected
    }
}

/// One more than the highest joint.
fn joints_needed(joints: &[u32]) -> usize {
    joints.iter().max().map_or(0, |&joint| (joint as usize).saturating_add(1))
}

/// The parts of a [`Geometry`] beside positions and faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeometryOptions {
    /// The name.
    pub name: Option<String>,
    /// One list for each morph target, with one offset for each vertex: its displacement from the position, in mesh
    /// space.
    pub morph_targets: Vec<Vec<[f32; 3]>>,
    /// The joints that move each vertex. `None`: the mesh is rigid, and the palette's only matrix moves it.
    pub influences: Option<Influences>,
    /// The index by which a displacement knows each vertex. `None`: vertices are numbered in order.
    pub source_vertices: Option<Vec<u32>>,
}

/// A triangle mesh in mesh space, with what deforms it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    name: Option<String>,
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    morph_targets: Vec<Vec<[f32; 3]>>,
    influences: Option<Influences>,
    source_vertices: Vec<u32>,
}

impl Geometry {
    /// Makes a geometry. `positions` are in mesh space. `faces` are counter-clockwise triangles, as indices into
    /// `positions`. Positions and morph offsets may be non-finite; their faces never face a light. An offset has no effect
    /// where its target's weight is 0.
    ///
    /// # Errors
    /// [`ModelError`] for an index out of range, too many vertices, or a list in `options` whose length does not fit
    /// the vertices.
    pub fn new(positions: Vec<[f32; 3]>, faces: Vec<[u32; 3]>, options: GeometryOptions) -> Result<Self, ModelError> {
        let GeometryOptions { name, morph_targets, influences, source_vertices } = options;
        let vertices = positions.len();
        if vertices >= u32::MAX as usize {
            return Err(ModelError::TooManyVertices { vertices });
        }
        if let Some([face, corner]) = out_of_range(&faces, vertices) {
            return Err(ModelError::FaceIndex { face, corner, index: faces[face][corner], vertices });
        }
        if let Some(target) = morph_targets.iter().position(|offsets| offsets.len() != vertices) {
            return Err(ModelError::MorphTarget { target, given: morph_targets[target].len(), vertices });
        }
        if let Some(influences) = &influences {
            let given = influences.offsets.len() - 1;
            if given != vertices {
                return Err(ModelError::InfluencedVertices { given, vertices });
            }
        }
        let source_vertices = source_vertices.unwrap_or_else(|| (0..vertices as u32).collect());
        if source_vertices.len() != vertices {
            return Err(ModelError::SourceVertices { given: source_vertices.len(), vertices });
        }
        Ok(Self { name, positions, faces, morph_targets, influences, source_vertices })
    }

    /// The name, if it has one.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Vertex positions in mesh space.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Counter-clockwise triangles, as indices into [`Geometry::positions`].
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The mesh of this geometry alone, for example of a rigid caster at [`Geometry::positions`]. Vertices stay as they
    /// are: a geometry of a file is welded already, and [`Geometry::welded`] welds others.
    ///
    /// # Errors
    /// [`MeshError`] for a geometry without faces, or with too many.
    pub fn mesh(&self) -> Result<Mesh, MeshError> {
        Mesh::from_faces(self.positions.len(), self.faces.clone())
    }

    /// One list for each morph target, with one offset for each vertex: its displacement from [`Geometry::positions`].
    pub fn morph_targets(&self) -> &[Vec<[f32; 3]>] {
        &self.morph_targets
    }

    /// The joints that move each vertex. `None`: the mesh is rigid, and the palette's only matrix moves it.
    pub fn influences(&self) -> Option<&Influences> {
        self.influences.as_ref()
    }

    /// The index of each vertex before welding: the lowest of its group, or that of the vertex whose position the group
    /// takes. A displacement knows vertices by it.
    pub fn source_vertices(&self) -> &[u32] {
        &self.source_vertices
    }

    /// The number of matrices that a pose's palette must have at least: one more than the highest joint, or 1 for a rigid
    /// mesh.
    pub fn joints_needed(&self) -> usize {
        self.influences.as_ref().map_or(1, |influences| influences.joints_needed)
    }

    /// The size in memory, in bytes.
    #[cfg(feature = "gltf")]
    pub(crate) fn bytes(&self) -> u64 {
        let vectors = self.positions.capacity()
            + self.faces.capacity()
            + self.morph_targets.iter().map(Vec::capacity).sum::<usize>();
        (12 * vectors + 4 * self.source_vertices.capacity()) as u64
            + self.influences.as_ref().map_or(0, Influences::bytes)
    }

    /// Welds vertices and numbers them anew, in the order of their lowest source index. With [`Weld::Distance`] it is the
    /// order of the vertices whose positions the groups take; of these are the data and the source vertices, too.
    #[must_use]
    pub fn welded(&self, weld: Weld) -> (Self, WeldCounts) {
        let count = self.positions.len();
        if weld == Weld::Keep {
            return (self.clone(), WeldCounts::unchanged(count));
        }
        let keys = Keys::new(self.most_words());
        let (NearGroups { groups, wide }, position_count) = if let Weld::Distance(distance) = weld {
            self.near_groups(distance, &keys)
        } else {
            let same_position = |a: usize, b: usize| same_bits(self.positions[a], self.positions[b]);
            let mut found = groups(count, |v| keys.hash(self.positions[v].map(bits)), same_position);
            let position_count = weld::count(&found);
            if weld == Weld::Data {
                // The hash covers everything that is compared. Otherwise vertices that share only a part of it would be
                // searched one by one, in quadratic time.
                let words = |v: usize| self.positions[v].map(bits).into_iter().chain(self.data(v));
                found = groups(count, |v| keys.hash(words(v)), |a, b| same_position(a, b) && self.same_data(a, b));
            }
            (NearGroups { groups: found, wide: 0 }, position_count)
        };
        let mut remaining: Vec<usize> = Vec::with_capacity(weld::count(&groups));
        remaining.extend((0..count).filter(|&v| groups[v] as usize == v));
        let mut renumbered = vec![0_u32; count];
        for (new, &old) in remaining.iter().enumerate() {
            renumbered[old] = new as u32;
        }
        let welded = Self {
            name: self.name.clone(),
            positions: remaining.iter().map(|&v| self.positions[v]).collect(),
            faces: self.faces.iter().map(|f| f.map(|v| renumbered[groups[v as usize] as usize])).collect(),
            morph_targets: self.morph_targets.iter().map(|t| remaining.iter().map(|&v| t[v]).collect()).collect(),
            influences: self.influences.as_ref().map(|influences| influences.select(&remaining)),
            source_vertices: remaining.iter().map(|&v| self.source_vertices[v]).collect(),
        };
        let collapsed = weld::collapsed(&self.faces, &welded.faces);
        let counts = WeldCounts {
            before: count,
            after: remaining.len(),
            apart: remaining.len() - position_count,
            collapsed,
            wide,
        };
        (welded, counts)
    }

    /// Groups by distance, and how many there are by positions alone.
    fn near_groups(&self, distance: WeldDistance, keys: &Keys) -> (NearGroups, usize) {
        let by_position = || near_groups(&self.positions, distance, |_| 0);
        let has_data = self.influences.is_some() || !self.morph_targets.is_empty();
        if distance.is_across_data() || !has_data {
            let found = by_position();
            let position_count = weld::count(&found.groups);
            return (found, position_count);
        }
        let classes = groups(self.positions.len(), |v| keys.hash(self.data(v)), |a, b| self.same_data(a, b));
        let position_count = weld::count(&by_position().groups);
        (near_groups(&self.positions, distance, |v| classes[v]), position_count)
    }

    /// An upper bound of the number of words of a vertex.
    fn most_words(&self) -> usize {
        let most = self.influences.as_ref().map_or(0, Influences::most_per_vertex);
        3 * (1 + self.morph_targets.len()) + 1 + 2 * most
    }

    /// A vertex's morph and skin data as words. The number of joints comes before them, so vertices with different data have
    /// a word that differs.
    fn data(&self, v: usize) -> impl Iterator<Item = u32> + '_ {
        let morph = self.morph_targets.iter().flat_map(move |target| target[v].map(bits));
        let skin = self.influences.iter().flat_map(move |influences| {
            let range = influences.range(v);
            let entries = range.len() as u32;
            let weights = influences.weights[range.clone()].iter().map(|&w| bits(w));
            std::iter::once(entries).chain(influences.joints[range].iter().copied()).chain(weights)
        });
        morph.chain(skin)
    }

    fn same_data(&self, a: usize, b: usize) -> bool {
        self.data(a).eq(self.data(b))
    }
}
