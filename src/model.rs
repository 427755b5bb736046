//! Deformable models: geometries, their instances, and a pose, whatever file they came from.

use crate::mesh::weld::{self, Keys, bits, groups, same_bits};
use crate::mesh::{MAX_FACES, Mesh, MeshError, Weld, WeldCounts};

/// The joints that move each vertex, any number a vertex; weights of a vertex sum to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Influences {
    /// Where each vertex's entries begin in `joints` and `weights`; one more than vertices.
    pub offsets: Vec<u32>,
    /// Indices into the instance's palette ([`InstancePose::palette`]).
    pub joints: Vec<u32>,
    /// The joints' weights.
    pub weights: Vec<f32>,
}

/// A triangle mesh in its own space, with what deforms it.
///
/// Invariants, which the glTF loader keeps and who fills the fields by hand must keep: faces name vertices that are
/// there; every morph target and `source_vertices` have one entry a vertex; the influences' offsets begin at 0, never
/// fall, are one more than vertices and end at the length of `joints` and `weights`. Whatever reads a geometry that
/// breaks them may panic.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// The name in the file.
    pub name: Option<String>,
    /// Vertex positions in mesh space.
    pub positions: Vec<[f32; 3]>,
    /// Counter-clockwise triangles, as indices into `positions`.
    pub faces: Vec<[u32; 3]>,
    /// Offsets from `positions`, one list a target, one offset a vertex.
    pub morph_targets: Vec<Vec<[f32; 3]>>,
    /// `None`: rigid, moved by the palette's only matrix.
    pub influences: Option<Influences>,
    /// The index each vertex had before welding: the lowest of its group.
    pub source_vertices: Vec<u32>,
}

/// One geometry at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Index into [`Model::geometries`].
    pub geometry: usize,
    /// The node's name in the file.
    pub name: Option<String>,
}

/// Geometries and the instances that place them. All instances together make one [`Mesh`], in their order, vertices
/// and faces concatenated; vertices are welded within an instance, never across.
///
/// Invariant: every instance names a geometry that is there. Whatever reads a model that breaks it may panic.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The distinct meshes.
    pub geometries: Vec<Geometry>,
    /// Where they stand.
    pub instances: Vec<Instance>,
}

/// A row-major 3×4 matrix that maps `(x, y, z, 1)`.
pub type Matrix3x4 = [[f32; 4]; 3];

/// The state of one instance at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstancePose {
    /// Mesh space to world space: a matrix a joint where the geometry has influences, else exactly one.
    pub palette: Vec<Matrix3x4>,
    /// A weight a morph target.
    pub morph_weights: Vec<f32>,
    /// The transform mirrors (negative determinant), so the faces are turned to stay counter-clockwise outside.
    pub turned: bool,
}

/// The state of a whole model at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// One for each of [`Model::instances`].
    pub instances: Vec<InstancePose>,
    /// Skinned instances of which some joint matrices mirror and some do not; they are turned by the majority.
    pub mixed_determinants: usize,
}

impl Geometry {
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

    /// Matrices that a pose's palette must have: one more than the highest joint named, or 1 where nothing is skinned.
    pub fn joints_needed(&self) -> usize {
        let highest = self.influences.as_ref().map(|influences| influences.joints.iter().max());
        highest.map_or(1, |joint| joint.map_or(0, |&joint| joint as usize + 1))
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

impl Influences {
    /// Where vertex `v`'s entries lie in `joints` and `weights`.
    pub fn range(&self, v: usize) -> std::ops::Range<usize> {
        self.offsets[v] as usize..self.offsets[v + 1] as usize
    }

    fn select(&self, vertices: &[usize]) -> Self {
        let mut selected = Self { offsets: vec![0], ..Self::default() };
        for &v in vertices {
            selected.joints.extend_from_slice(&self.joints[self.range(v)]);
            selected.weights.extend_from_slice(&self.weights[self.range(v)]);
            selected.offsets.push(selected.joints.len() as u32);
        }
        selected
    }
}

impl Model {
    /// Vertices of all instances together.
    pub fn vertex_count(&self) -> usize {
        self.instances.iter().map(|instance| self.geometries[instance.geometry].positions.len()).sum()
    }

    /// The mesh that all instances make in this pose: instances in order, vertices and faces concatenated, the faces
    /// of mirrored instances turned. Only [`InstancePose::turned`] of the pose matters, so the mesh stays valid for
    /// other poses until that changes.
    ///
    /// # Errors
    /// [`MeshError`] as for [`Mesh::from_faces`].
    pub fn mesh(&self, pose: &Pose) -> Result<Mesh, MeshError> {
        // Counted first, so that instances of a large geometry are refused before they fill the memory.
        let geometries = self.instances.iter().map(|instance| &self.geometries[instance.geometry]);
        let count = geometries.map(|geometry| geometry.faces.len()).sum();
        if count > MAX_FACES {
            return Err(MeshError::TooManyFaces { faces: count });
        }
        let mut faces = Vec::with_capacity(count);
        let mut first_vertex = 0;
        for (instance, pose) in self.instances.iter().zip(&pose.instances) {
            let geometry = &self.geometries[instance.geometry];
            faces.extend(geometry.faces.iter().map(|&face| {
                let [a, b, c] = face.map(|v| v.wrapping_add(first_vertex));
                if pose.turned { [a, c, b] } else { [a, b, c] }
            }));
            first_vertex = first_vertex.wrapping_add(geometry.positions.len() as u32);
        }
        Mesh::from_faces(self.vertex_count(), faces)
    }
}

/// Why a pose is not one of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseMismatch {
    /// Another number of instances.
    #[error("the pose has {given} instances, and the model has {needed}")]
    Instances {
        /// Instances of the pose.
        given: usize,
        /// Instances of the model.
        needed: usize,
    },
    /// Too few matrices.
    #[error("the pose of instance {instance} has {given} matrices, and its geometry needs {needed}")]
    Palette {
        /// The instance's index.
        instance: usize,
        /// Matrices of the pose.
        given: usize,
        /// Matrices needed.
        needed: usize,
    },
    /// Another number of morph weights than targets.
    #[error("the pose of instance {instance} has {given} morph weights, and its geometry has {needed} targets")]
    MorphWeights {
        /// The instance's index.
        instance: usize,
        /// Weights of the pose.
        given: usize,
        /// Targets of the geometry.
        needed: usize,
    },
}
