//! The topology that the scene uploads for a mesh: its faces and edge records in the order of their slots.

use std::borrow::Cow;
use std::sync::Arc;

use crate::Mesh;
use crate::cpu::Threads;
use crate::gpu::extract::polygon_buffers::faces_of_records;
use crate::mesh::clusters::{Arranged, Clusters};

/// The faces and edge records of a mesh in slots.
#[derive(Debug)]
pub(crate) struct Topology<'a> {
    pub(crate) faces: Cow<'a, [[u32; 3]]>,
    pub(crate) edge_vertices: Cow<'a, [[u32; 2]]>,
    pub(crate) edge_faces: Cow<'a, [[u32; 2]]>,
    /// The clusters, as the GPU has them. Empty: slots have the order of the mesh.
    pub(crate) clusters: Vec<u32>,
    /// The face of each face slot, for a mesh in clusters.
    pub(crate) order: Option<Arc<[u32]>>,
}

impl<'a> Topology<'a> {
    /// A mesh in its own order. Edge records of polygons refer to the first triangles of their faces.
    pub(crate) fn plain(mesh: &'a Mesh) -> Self {
        Self {
            faces: mesh.faces().into(),
            edge_vertices: mesh.edges().vertices().into(),
            edge_faces: faces_of_records(mesh).map_or_else(|| mesh.edges().packed_faces().into(), Cow::from),
            clusters: Vec::new(),
            order: None,
        }
    }

    /// A mesh of triangles in clusters, by its positions.
    pub(crate) fn in_clusters(mesh: &Mesh, positions: &[[f32; 3]]) -> Self {
        let clusters = Clusters::new(mesh, positions, Threads::all());
        let Arranged { faces, edge_vertices, edge_faces, words } = Arranged::new(mesh, &clusters, Threads::all());
        Self {
            faces: faces.into(),
            edge_vertices: edge_vertices.into(),
            edge_faces: edge_faces.into(),
            clusters: words,
            order: Some(clusters.faces.into()),
        }
    }
}
