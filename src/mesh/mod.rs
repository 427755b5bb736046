//! Meshes as the extraction needs them: triangles or polygons, welded vertices, edge records.

#[cfg(feature = "gpu")]
pub(crate) mod clusters;
mod diagnostics;
mod error;
mod faces;
mod polygons;
mod silhouette;
mod topology;
pub(crate) mod weld;

pub use diagnostics::MeshDiagnostics;
pub use error::{MAX_FACES, MeshError};
pub use faces::Mesh;
#[cfg(feature = "gpu")]
pub(crate) use faces::MeshId;
pub(crate) use faces::out_of_range;
pub(crate) use polygons::is_loop;
pub use polygons::{MAX_POLYGON_CORNERS, PolygonLoops, PolygonTriangles, Polygons};
pub use silhouette::{Chain, Silhouette, SilhouetteEdge};
pub(crate) use topology::is_degenerate;
pub use topology::{Edge, EdgeCounts, EdgeKind, EdgeRecords, INCONSISTENT_BIT, NO_FACE};
pub use weld::{Weld, WeldCounts, WeldDistance};
