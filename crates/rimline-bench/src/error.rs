//! Why a measurement ends.

use rimline::gpu::{
    DeformError, DepthMapError, ExtractionEncodeError, ExtractionIncludeError, ExtractorError, PositionError,
    ReadError, SceneError, ShadowDrawError, ShadowEncodeError, ShadowFormatError, ShadowQueryEncodeError,
    ShadowQueryError, ShadowVolumesError, StaleExtraction,
};
use rimline::{MeshError, ModelError};

/// Why a measurement ends before its time.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// [`crate::Host::is_stopped`] said so.
    #[error("stopped")]
    Stopped,
    /// The device failed.
    #[error("{0}")]
    Device(String),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Deform(#[from] DeformError),
    #[error(transparent)]
    DepthMap(#[from] DepthMapError),
    #[error(transparent)]
    Extractor(#[from] ExtractorError),
    #[error(transparent)]
    Encode(#[from] ExtractionEncodeError),
    #[error(transparent)]
    Query(#[from] ShadowQueryError),
    #[error(transparent)]
    QueryEncode(#[from] ShadowQueryEncodeError),
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Shadow(#[from] ShadowEncodeError),
    #[error(transparent)]
    Volumes(#[from] ShadowVolumesError),
    #[error(transparent)]
    Draw(#[from] ShadowDrawError),
    #[error(transparent)]
    Format(#[from] ShadowFormatError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Stale(#[from] StaleExtraction),
    /// The chart could not be drawn.
    #[error("a chart cannot be drawn: {0}")]
    Chart(#[from] std::io::Error),
}

impl Error {
    /// The device has too little memory for the scene, so another one may serve.
    pub fn is_too_large(&self) -> bool {
        matches!(
            self,
            Self::Deform(DeformError::Memory(_) | DeformError::TooManyTerms { .. })
                | Self::Extractor(
                    ExtractorError::Memory(_) | ExtractorError::Polygons | ExtractorError::OutlineTooLarge { .. }
                )
                | Self::Encode(ExtractionEncodeError::Positions(PositionError::Memory(_)))
                | Self::Volumes(ShadowVolumesError::Memory(_))
                | Self::Scene(SceneError::Memory(_) | SceneError::Positions(PositionError::Memory(_)))
                | Self::Shadow(
                    ShadowEncodeError::Positions(PositionError::Memory(_))
                        | ShadowEncodeError::Include(
                            ExtractionIncludeError::Memory(_)
                                | ExtractionIncludeError::Positions(PositionError::Memory(_))
                        )
                )
        )
    }
}
