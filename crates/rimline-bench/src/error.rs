//! Why a measurement ends.

use rimline::gpu::depth_map::DepthMapError;
use rimline::gpu::{DeformError, DeviceError, ExtractorError, QueryError, ShadowError};
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
    Query(#[from] QueryError),
    #[error(transparent)]
    Read(#[from] DeviceError),
    #[error(transparent)]
    Shadow(#[from] ShadowError),
    /// The chart could not be drawn.
    #[error("a chart cannot be drawn: {0}")]
    Chart(#[from] std::io::Error),
}

impl Error {
    /// A failure of the device, or of what a bench works with.
    pub fn device(error: impl std::fmt::Display) -> Self {
        Self::Device(error.to_string())
    }

    /// The device has too little memory for the scene, so another one may serve.
    pub fn is_too_large(&self) -> bool {
        match self {
            Self::Deform(DeformError::TooManyTerms { .. })
            | Self::Extractor(ExtractorError::Polygons | ExtractorError::BoundaryTooLarge { .. }) => true,
            Self::Deform(DeformError::Device(error))
            | Self::Extractor(ExtractorError::Device(error))
            | Self::Shadow(ShadowError::Device(error) | ShadowError::Extraction(ExtractorError::Device(error))) => {
                error.is_memory()
            }
            _ => false,
        }
    }
}
