//! Why extractions cannot be made, recorded, read or drawn.

use super::options::MAX_BOUNDARY_EDGES;
use crate::gpu::common::device_error::DeviceError;
use crate::light::LightError;
use crate::turns::POLYGON_TRIANGLES;

/// Why an extraction cannot be made, recorded, read, drawn or included.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum ExtractorError {
    /// The device lacks what extraction needs, is lost, or is not that of the timer. Or the mesh does not fit it, the
    /// position buffer is refused, or an array needs more than one binding, and the include reads each array from one.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The lights are refused, or `max_lights` is 0 or more than [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    #[error(transparent)]
    Light(#[from] LightError),
    /// The mesh has polygons, and the options ask for something else than exact facing masks.
    #[error(
        "the mesh has faces of more than three corners, which only `Predicate::Exact` decides, by face masks; ask for \
         that, or make a mesh of its triangles by `Mesh::from_polygons`"
    )]
    Polygons,
    /// A polygon has too many edges.
    #[error(
        "polygon {polygon} has a boundary of {edges} edges, more than {}; cut it, or extract it by `cpu::extract`",
        MAX_BOUNDARY_EDGES
    )]
    BoundaryTooLarge { polygon: usize, edges: usize },
    /// A polygon has too many triangles, though its boundary has few edges: it walks others both ways.
    #[error(
        "polygon {polygon} has {triangles} triangles, more than {POLYGON_TRIANGLES}; cut it, or extract it by `cpu::extract`"
    )]
    PolygonTooLarge { polygon: usize, triangles: usize },
    /// The results were overwritten.
    #[error(
        "this extraction is out of date: its extractor was encoded again, which overwrites the results; use the value that \
         the last encode returned"
    )]
    Stale,
    /// The extraction has no light with this index.
    #[error("light {light} asked for, and {lights} lights were extracted; lights count from 0")]
    NoSuchLight { light: usize, lights: usize },
    /// The extractor makes no lists, so there is nothing to draw.
    #[error("the extractor makes no lists to draw from; set `ExtractorOptions::lists`")]
    NoLists,
    /// The extractor makes no lists, or it uses the per-edge method, which has no facing masks.
    #[error("the include needs lists and facing masks; set `ExtractorOptions::lists`")]
    NoInclude,
    /// The extraction has no batch of lights with this index.
    #[error("batch {batch} of lights asked for, and there are {batches}; a batch is 32 lights, and they count from 0")]
    NoSuchBatch { batch: usize, batches: usize },
    /// The mesh is not the one that the extractor was made for.
    #[error(
        "the mesh is not the one that was extracted; give the mesh that the extractor was made for, or a clone of it"
    )]
    OtherMesh,
    /// The per-edge method has no facing masks, and the light's list has no room for its edges.
    #[error(
        "the list of light {light} does not hold its silhouette edges; set `ExtractorOptions::lists`, and their `capacity`"
    )]
    NoFacing { light: usize },
}
