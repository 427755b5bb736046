//! Deformable models: geometries, their instances, and poses. They do not depend on a file format.
//!
//! Every part is checked when it is made, so the code that takes a part can rely on it.

mod bounds;
mod error;
mod geometry;
mod pose;

pub use bounds::{Box3, ModelBounds};
pub use error::ModelError;
pub use geometry::{Geometry, GeometryOptions, Influences};
pub use pose::{InstancePose, Matrix3x4, Pose};

use crate::mesh::{MAX_FACES, Mesh, MeshError, is_degenerate};

/// One placement of a geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    geometry: usize,
    name: Option<String>,
}

impl Instance {
    /// An instance of the geometry with index `geometry` in [`Model::geometries`], with a name if it has one.
    pub fn new(geometry: usize, name: Option<String>) -> Self {
        Self { geometry, name }
    }

    /// Index into [`Model::geometries`].
    pub fn geometry(&self) -> usize {
        self.geometry
    }

    /// The name, if it has one.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }
}

/// Geometries and their instances. All instances together make one [`Mesh`]: vertices and faces are
/// concatenated in the order of the instances. Vertices are welded within an instance, never across instances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    geometries: Vec<Geometry>,
    instances: Vec<Instance>,
    vertex_count: usize,
}

impl Model {
    /// Makes a model of `geometries` and their placements. A geometry may have any number of instances, also none.
    ///
    /// # Errors
    /// [`ModelError`] for an instance of a geometry that does not exist, or for more vertices than `u32` indices can
    /// name.
    pub fn new(geometries: Vec<Geometry>, instances: Vec<Instance>) -> Result<Self, ModelError> {
        let mut vertex_count = 0_usize;
        for (index, instance) in instances.iter().enumerate() {
            let Some(geometry) = geometries.get(instance.geometry) else {
                return Err(ModelError::InstanceGeometry {
                    instance: index,
                    geometry: instance.geometry,
                    geometries: geometries.len(),
                });
            };
            vertex_count = vertex_count.saturating_add(geometry.positions().len());
        }
        if vertex_count >= u32::MAX as usize {
            return Err(ModelError::TooManyVertices { vertices: vertex_count });
        }
        Ok(Self { geometries, instances, vertex_count })
    }

    /// The geometries.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// The placements of the geometries.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The geometry of each instance, in the order of [`Model::instances`].
    pub fn placed_geometries(&self) -> impl ExactSizeIterator<Item = &Geometry> {
        self.instances.iter().map(|instance| &self.geometries[instance.geometry])
    }

    /// The number of vertices of all instances together.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Checks that `pose` has one pose for each instance of this model, with the matrices and weights that its geometry
    /// needs.
    ///
    /// # Errors
    /// [`ModelError`] for the first instance that does not fit.
    pub fn check(&self, pose: &Pose) -> Result<(), ModelError> {
        pose.check_instances(self.instances.len())?;
        let mut instances = pose.instances().iter().zip(self.placed_geometries()).enumerate();
        instances.try_for_each(|(instance, (pose, geometry))| {
            pose.check_counts(instance, geometry.joints_needed(), geometry.morph_targets().len())
        })
    }

    /// The mesh that all instances make in this pose. Vertices and faces are concatenated in the order of the
    /// instances, and the faces of mirrored instances are turned. The mesh depends only on
    /// [`InstancePose::faces_turned`] of the pose, so it stays valid for other poses until this changes.
    /// [`Self::check_mesh`] tells when it does.
    ///
    /// # Errors
    /// [`ModelError`] when the pose does not fit the model, or for the reasons of [`Mesh::from_faces`].
    pub fn mesh(&self, pose: &Pose) -> Result<Mesh, ModelError> {
        self.check(pose)?;
        // Faces are counted first, so that many instances of a large geometry are refused before they fill the memory.
        let count = self.placed_geometries().fold(0, |sum: usize, geometry| sum.saturating_add(geometry.faces().len()));
        if count > MAX_FACES {
            return Err(MeshError::TooManyFaces { faces: count }.into());
        }
        let mut faces = Vec::with_capacity(count);
        let mut first_vertex = 0;
        for (geometry, pose) in self.placed_geometries().zip(pose.instances()) {
            faces.extend(geometry.faces().iter().map(|&face| {
                // No sum overflows: all instances together have fewer than `u32::MAX` vertices.
                let [a, b, c] = face.map(|v| v + first_vertex);
                if pose.faces_turned() { [a, c, b] } else { [a, b, c] }
            }));
            first_vertex += geometry.positions().len() as u32;
        }
        Ok(Mesh::from_faces(self.vertex_count, faces)?)
    }

    /// Checks that a mesh that [`Self::mesh`] made is that of this pose, too. It is not where an instance mirrors that
    /// did not, as one may whose scale an animation moves through 0. Its faces would seem reversed. It looks at one
    /// face of each instance, so it may be called each frame.
    ///
    /// # Errors
    /// [`ModelError::Turned`] for the first instance whose faces are turned the other way in the mesh.
    /// [`ModelError::OtherMesh`] if a count or one of these faces shows that the mesh is not one of this model. The errors of
    /// [`Self::check`].
    pub fn check_mesh(&self, mesh: &Mesh, pose: &Pose) -> Result<(), ModelError> {
        self.check(pose)?;
        let needed = self.placed_geometries().map(|geometry| geometry.faces().len()).sum();
        let counts = (mesh.vertex_count() as usize, mesh.faces().len());
        if mesh.polygons().is_some() || counts != (self.vertex_count, needed) {
            return Err(ModelError::OtherMesh);
        }
        let (mut first_vertex, mut first_face) = (0, 0);
        for (instance, (geometry, pose)) in self.placed_geometries().zip(pose.instances()).enumerate() {
            let faces = geometry.faces();
            if let Some(number) = faces.iter().position(|&face| !is_degenerate(face)) {
                let [a, b, c] = faces[number].map(|vertex| vertex + first_vertex);
                let found = mesh.faces()[first_face + number];
                match (found == [a, b, c], found == [a, c, b]) {
                    (false, false) => return Err(ModelError::OtherMesh),
                    (_, is_turned) if is_turned != pose.faces_turned() => return Err(ModelError::Turned { instance }),
                    _ => {}
                }
            }
            first_vertex += geometry.positions().len() as u32;
            first_face += faces.len();
        }
        Ok(())
    }
}
