//! Why queries of occluder counts cannot be made or recorded.

use crate::gpu::common::device_error::DeviceError;
use crate::gpu::extract::errors::ExtractorError;
use crate::light::LightError;

/// Why a query cannot be made or recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum QueryError {
    /// The device lacks what the query needs, is lost, or is not that of the timer. Or the mesh or the counts do not
    /// fit it, or the position buffer is refused.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The lights are refused, for example one with a negative `w`, or `max_lights` is 0 or more than
    /// [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    #[error(transparent)]
    Light(#[from] LightError),
    /// The extraction belongs to another mesh.
    #[error("the extraction is of another mesh than this query was made for; make both with the same `Mesh`")]
    OtherMesh,
    /// A later encode of the extractor may have moved the positions that the extraction names.
    #[error(transparent)]
    Extraction(#[from] ExtractorError),
    /// The buffer of points is refused.
    #[error("points: {0}")]
    Points(DeviceError),
    /// The faces that points are on lie in the points or behind them.
    #[error(
        "faces of points at offset {offset}, stride {stride}: the offset must be a multiple of 4 from 12 to the stride less 4"
    )]
    FaceOffset { offset: u64, stride: u64 },
    /// There are more points than the query has room for.
    #[error("{count} points given, at most {limit} fit (`max_points`); query them in several encodes")]
    TooManyPoints { count: u32, limit: u32 },
}
