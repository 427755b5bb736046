//! Triangle meshes in their own space, with morph targets and influences.

use super::ModelError;
use crate::mesh::weld::{self, Keys, bits, groups, same_bits};
use crate::mesh::{Weld, WeldCounts};

/// The joints that move each vertex, any number a vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Influences {
    offsets: Vec<u32>,
    joints: Vec<u32>,
    weights: Vec<f32>,
    joints_needed: usize,
}

impl Influences {
    /// `offsets` says where each vertex's entries begin in `joints` and `weights`; it is one longer than there are
    /// vertices, begins with 0 and ends with the number of entries. `joints` are indices into the instance's palette
    /// ([`InstancePose::palette`](super::InstancePose::palette)). The weights of a vertex should sum to 1; they are used
    /// as given.
    ///
    /// # Errors
    /// [`ModelError`] for offsets, joints and weights that do not go together, or a weight that is not finite.
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

    /// Where each vertex's entries begin in [`Influences::joints`] and [`Influences::weights`]; one more than vertices.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// Indices into the instance's palette.
    pub fn joints(&self) -> &[u32] {
        &self.joints
    }

    /// The joints' weights; finite.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Where vertex `v`'s entries lie in [`Influences::joints`] and [`Influences::weights`]; empty past the last vertex.
    pub fn range(&self, v: usize) -> std::ops::Range<usize> {
        match self.offsets.get(v..).unwrap_or_default() {
            &[begin, end, ..] => begin as usize..end as usize,
            _ => 0..0,
        }
    }

    /// The most entries that any vertex has.
    pub fn most_per_vertex(&self) -> usize {
        self.offsets.windows(2).map(|pair| (pair[1] - pair[0]) as usize).max().unwrap_or(0)
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

/// What a [`Geometry`] has besides positions and faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeometryOptions {
    /// Its name.
    pub name: Option<String>,
    /// Offsets from the positions, one list a target, one offset a vertex.
    pub morph_targets: Vec<Vec<[f32; 3]>>,
    /// `None`: rigid, moved by the palette's only matrix.
    pub influences: Option<Influences>,
    /// The number that a displacement knows each vertex by; `None`: they are numbered in order.
    pub source_vertices: Option<Vec<u32>>,
}

/// A triangle mesh in its own space, with what deforms it.
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
    /// Counter-clockwise triangles, as indices into `positions`, which lie in mesh space. Positions and morph offsets may
    /// be non-finite: their faces never face a light.
    ///
    /// # Errors
    /// [`ModelError`] for an index out of range, or a list in `options` that has not one entry a vertex.
    pub fn new(positions: Vec<[f32; 3]>, faces: Vec<[u32; 3]>, options: GeometryOptions) -> Result<Self, ModelError> {
        let GeometryOptions { name, morph_targets, influences, source_vertices } = options;
        let vertices = positions.len();
        if vertices >= u32::MAX as usize {
            return Err(ModelError::TooManyVertices { vertices });
        }
        let is_outside = |v: &u32| *v as usize >= vertices;
        if let Some((face, corners)) = faces.iter().enumerate().find(|(_, corners)| corners.iter().any(is_outside)) {
            let corner = corners.iter().position(is_outside).unwrap_or(0);
            return Err(ModelError::FaceIndex { face, corner, index: corners[corner], vertices });
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

    /// Its name.
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

    /// Offsets from [`Geometry::positions`], one list a target, one offset a vertex.
    pub fn morph_targets(&self) -> &[Vec<[f32; 3]>] {
        &self.morph_targets
    }

    /// `None`: rigid, moved by the palette's only matrix.
    pub fn influences(&self) -> Option<&Influences> {
        self.influences.as_ref()
    }

    /// The index each vertex had before welding: the lowest of its group. A displacement knows vertices by it.
    pub fn source_vertices(&self) -> &[u32] {
        &self.source_vertices
    }

    /// Matrices that a pose's palette must have: one more than the highest joint named, or 1 where nothing is skinned.
    pub fn joints_needed(&self) -> usize {
        self.influences.as_ref().map_or(1, |influences| influences.joints_needed)
    }

    /// This geometry with equal vertices made one and the vertices renumbered, in order of their lowest source index.
    #[must_use]
    pub fn welded(&self, weld: Weld) -> (Self, WeldCounts) {
        let count = self.positions.len();
        if weld == Weld::Keep {
            return (self.clone(), WeldCounts::kept(count));
        }
        let keys = Keys::new(self.most_words());
        let by_position = groups(count, |v| keys.hash(self.positions[v].map(bits)), |a, b| self.same_position(a, b));
        let groups = match weld {
            Weld::Position => by_position.clone(),
            // The hash covers all that is compared: vertices that share a position alone would else be searched one by
            // one, in quadratic time.
            _ => groups(
                count,
                |v| keys.hash(self.words(v)),
                |a, b| self.same_position(a, b) && self.same_morph(a, b) && self.same_influences(a, b),
            ),
        };
        let kept: Vec<usize> = (0..count).filter(|&v| groups[v] as usize == v).collect();
        let mut renumbered = vec![0_u32; count];
        for (new, &old) in kept.iter().enumerate() {
            renumbered[old] = new as u32;
        }
        let welded = Self {
            name: self.name.clone(),
            positions: kept.iter().map(|&v| self.positions[v]).collect(),
            faces: self.faces.iter().map(|f| f.map(|v| renumbered[groups[v as usize] as usize])).collect(),
            morph_targets: self.morph_targets.iter().map(|t| kept.iter().map(|&v| t[v]).collect()).collect(),
            influences: self.influences.as_ref().map(|influences| influences.select(&kept)),
            source_vertices: kept.iter().map(|&v| self.source_vertices[v]).collect(),
        };
        let counts = WeldCounts { before: count, after: kept.len(), apart: kept.len() - weld::count(&by_position) };
        (welded, counts)
    }

    /// At least as many words as any vertex has.
    fn most_words(&self) -> usize {
        let ranges = self.influences.iter().flat_map(|influences| influences.offsets.windows(2));
        let most = ranges.map(|pair| (pair[1] - pair[0]) as usize).max().unwrap_or(0);
        3 * (1 + self.morph_targets.len()) + 1 + 2 * most
    }

    /// A vertex's position, morph and skin data as words. The number of joints comes before them, so vertices whose data
    /// differ have a word that differs.
    fn words(&self, v: usize) -> impl Iterator<Item = u32> + '_ {
        let morph = self.morph_targets.iter().flat_map(move |target| target[v].map(bits));
        let skin = self.influences.iter().flat_map(move |influences| {
            let range = influences.range(v);
            let entries = range.len() as u32;
            let weights = influences.weights[range.clone()].iter().map(|w| w.to_bits());
            std::iter::once(entries).chain(influences.joints[range].iter().copied()).chain(weights)
        });
        self.positions[v].map(bits).into_iter().chain(morph).chain(skin)
    }

    fn same_position(&self, a: usize, b: usize) -> bool {
        same_bits(self.positions[a], self.positions[b])
    }

    fn same_morph(&self, a: usize, b: usize) -> bool {
        self.morph_targets.iter().all(|target| same_bits(target[a], target[b]))
    }

    fn same_influences(&self, a: usize, b: usize) -> bool {
        self.influences.as_ref().is_none_or(|influences| {
            let (a, b) = (influences.range(a), influences.range(b));
            influences.joints[a.clone()] == influences.joints[b.clone()]
                && influences.weights[a]
                    .iter()
                    .map(|w| w.to_bits())
                    .eq(influences.weights[b].iter().map(|w| w.to_bits()))
        })
    }
}
