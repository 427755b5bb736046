//! Objects to draw: meshes in world space.

use std::borrow::Cow;

use rimline::cpu::{Threads, deform};
use rimline::mesh::Weld;
use rimline::{Mesh, Model, Pose};

use crate::error::LinesError;

/// A mesh in world space. Faces hide what is behind them from both sides.
#[derive(Clone, Debug)]
pub struct Object<'a> {
    /// A name for messages; it need not be unique.
    pub name: String,
    /// The mesh: triangles, or polygons.
    pub mesh: Cow<'a, Mesh>,
    /// A position in world space for each vertex of the mesh, finite for those that [`Mesh::edges`] names.
    pub positions: Cow<'a, [[f32; 3]]>,
    /// Edges that the caller marks, by vertices as [`Mesh::edges`] names them, in any order.
    pub marked: Vec<[u32; 2]>,
}

impl<'a> Object<'a> {
    /// A mesh at its positions, without a name and marks.
    pub fn new(mesh: &'a Mesh, positions: &'a [[f32; 3]]) -> Self {
        let (mesh, positions) = (Cow::Borrowed(mesh), Cow::Borrowed(positions));
        Self { name: String::new(), mesh, positions, marked: Vec::new() }
    }
}

/// The objects of a posed model: one for each of its instances, in their order. Vertices at one position in this pose are
/// welded; faces keep their numbers. Instances without faces are among them; a drawing names and leaves them out.
///
/// A pose may round vertices whose skin or morph data differ to different positions, which draws their seam as boundaries. Load
/// the model with [`Weld::Position`] to avoid this.
///
/// # Errors
/// [`LinesError::Model`] if the pose does not fit the model.
pub fn objects_of_model(model: &Model, pose: &Pose, threads: Threads) -> Result<Vec<Object<'static>>, LinesError> {
    let positions = deform(model, pose, 0.0, None, threads)?;
    let mut first = 0;
    let placed = model.instances().iter().zip(model.placed_geometries()).zip(pose.instances()).enumerate();
    placed
        .map(|(number, ((instance, geometry), pose))| {
            let count = geometry.positions().len();
            let instance_positions = positions[first..first + count].to_vec();
            first += count;
            let turned = |&[a, b, c]: &[u32; 3]| if pose.faces_turned() { [a, c, b] } else { [a, b, c] };
            let faces: Vec<_> = geometry.faces().iter().map(turned).collect();
            let mesh =
                Mesh::new(&instance_positions, &faces, Weld::Position).or_else(|_| Mesh::from_faces(3, vec![[0; 3]]));
            let name = instance.name().or(geometry.name()).map_or_else(|| format!("instance {number}"), str::to_owned);
            let mesh = Cow::Owned(mesh.map_err(rimline::ModelError::from)?);
            Ok(Object { name, mesh, positions: Cow::Owned(instance_positions), marked: Vec::new() })
        })
        .collect()
}
