//! Why a depth map of the user's is refused.

use rimline::CameraError;
use rimline::gpu::depth_map::DepthMapError;

#[derive(Debug, thiserror::Error)]
pub(crate) enum GivenMapError {
    #[error(
        "`view_projection` of map {map}: {error}; its rows make clip space of positions less `origin`, and depth is as \
         `reversed` says"
    )]
    Camera { map: usize, error: CameraError },
    #[error(
        "`view_projection` of map {map} makes a mirror image; change the sign of its row of x or of y, whichever runs the wrong \
         way (clip space has x to the right and y up), and turn the rows of `depth` to match"
    )]
    Mirrored { map: usize },
    #[error("six maps are square, and these have {}×{} texels", .0[0], .0[1])]
    NotSquare([u32; 2]),
    #[error("`objects` go with one map, not with six; take another detector")]
    ObjectsOfCube,
    #[error(
        "`depth` is uint16, and `metric` says that it has distances; give distances as float32, in the units of the models"
    )]
    DistanceType,
    #[error(
        "`depth_bits` is that of a depth buffer, and `metric` says that `depth` has distances; leave one of them out"
    )]
    DistanceBits,
    #[error(
        "map {map} does not meet the others: {what}; take the views that docs/formats.md states for six maps, or turn all six \
         together"
    )]
    Apart { map: usize, what: &'static str },
    #[error("it has six maps, and --detector contours takes one; take another detector, or give one map")]
    ContoursOfCube,
    #[error(transparent)]
    Map(DepthMapError),
}

/// In words of the command: users have a file, and no cameras of the library.
impl From<DepthMapError> for GivenMapError {
    fn from(error: DepthMapError) -> Self {
        match error {
            DepthMapError::Apart { face, what } => Self::Apart { map: face, what },
            DepthMapError::CubeContours => Self::ContoursOfCube,
            other => Self::Map(other),
        }
    }
}
