//! Clusters: ranges of faces that lie together, each with a bound that decides for many lights that all of them face the
//! light, or that none does (docs/numerics/clusters.md).
//!
//! The order in space is internal. A face or edge **slot** is an index in it. The mesh keeps its own order, and each slot
//! names the face or edge record of the mesh that it holds.

mod arranged;
mod bound;
mod edges;
mod order;
mod plane;

pub use arranged::Arranged;
pub use bound::{ClusterBound, WIDENING};
pub use edges::edge_order;

use crate::cpu::Threads;
use crate::layout::CHUNK;
use crate::mesh::Mesh;
use order::Order;

/// Faces of a cluster: two chunks. The last cluster of a mesh may have fewer.
pub const CLUSTER_FACES: usize = 2 * CHUNK as usize;

/// The clusters of a rigid mesh.
///
/// Memory: 4 bytes a face and 4 bytes an edge record for the orders, and 48 bytes a cluster for bounds. Together these are
/// 10.4 bytes a face on closed meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Clusters {
    pub(crate) faces: Vec<u32>,
    bounds: Vec<ClusterBound>,
    edges: Vec<u32>,
}

impl Clusters {
    /// Orders the faces of `mesh` in space, bounds each cluster, and groups the edge records. `mesh` must have no
    /// [`Mesh::polygons`]: edge records would name these, and clusters are of triangles. `positions` are those of the
    /// mesh's vertices; the bounds hold for no others. A vertex that `positions` lacks counts as non-finite. The result
    /// does not depend on the number of threads.
    pub fn new(mesh: &Mesh, positions: &[[f32; 3]], threads: Threads) -> Self {
        let order = Order::new(positions, mesh.faces(), threads);
        let bounds = bound::bounds(&order, threads);
        let Order { faces, .. } = order;
        let edges = edge_order(mesh.edges(), &faces);
        Self { faces, bounds, edges }
    }

    /// For each face slot the mesh's face. Cluster `i` has the slots from `i·CLUSTER_FACES` on.
    pub fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// The bound of each cluster.
    pub fn bounds(&self) -> &[ClusterBound] {
        &self.bounds
    }

    /// For each edge slot the mesh's record: see [`edge_order`].
    pub fn edges(&self) -> &[u32] {
        &self.edges
    }

    /// The size in memory, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.faces) + size_of_val(&*self.bounds) + size_of_val(&*self.edges)
    }
}
