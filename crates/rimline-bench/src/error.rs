//! The program that measures, and why a measurement ends.

use rimline::gpu::depth_map::DepthMapError;
use rimline::gpu::{DeformError, DeviceError, ExtractorError, QueryError, ShadowError};
use rimline::{MeshError, ModelError};

#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// [`crate::Host::is_stopped`] said so.
    #[error("stopped")]
    Stopped,
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
    #[error("{option} needs a value; give one behind it")]
    NoValue { option: &'static str },
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

/// Hears what is going on, and may stop it. All methods are optional.
pub trait Host {
    fn is_stopped(&self) -> bool {
        false
    }

    /// Hears the name of the work that begins.
    fn step(&self, _what: &str) {}

    fn done(&self, _what: &str) {}

    fn note(&self, _text: &str) {}
}

/// Nobody.
impl Host for () {}
