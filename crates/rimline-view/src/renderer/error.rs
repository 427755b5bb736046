//! Failures of drawing.

use rimline::gpu::{DeviceError, ExtractorError, OutlineError, ShadowError};

/// Why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The adapter cannot be used.
    #[error("the adapter {name} cannot be used: {why}")]
    Adapter {
        /// Its name.
        name: String,
        /// Why.
        why: String,
    },
    /// The device refused something that it should do. Later pictures may be wrong.
    #[error("the device {name} refused what the viewer needs: {why}; a newer driver or another device may not")]
    Unexpected {
        /// Its name.
        name: String,
        /// Why, in the device's words.
        why: String,
    },
    /// A model cannot be shown. The others can.
    #[error("{name}: {why}")]
    Body {
        /// Its index among the models.
        index: usize,
        /// Its name.
        name: String,
        /// Why.
        why: String,
    },
    /// Overlays of a model's edges cannot be drawn. The picture without them can.
    #[error("overlays of {name}: {why}")]
    Overlays {
        /// Its name.
        name: String,
        /// Why.
        why: String,
    },
    /// The device fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// Shadows cannot be computed.
    #[error(transparent)]
    Shadow(#[from] ShadowError),
    /// Silhouettes cannot be computed.
    #[error(transparent)]
    Extractor(#[from] ExtractorError),
    /// Outlines cannot be drawn.
    #[error(transparent)]
    Outline(#[from] OutlineError),
    /// The picture has more pixels than the device takes.
    #[error("a picture of {width} x {height} pixels is too large for this device, which takes up to {limit} each way")]
    Size {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// The limit.
        limit: u32,
    },
    /// The device makes no textures of this size, or has no memory for them.
    #[error("a picture of {width} x {height} pixels is too large for this device: {why}")]
    Refused {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// The reason, in the device's words.
        why: String,
    },
    /// The picture cannot be encoded.
    #[error("the picture cannot be written: {0}")]
    Png(#[from] png::EncodingError),
}

impl RenderError {
    pub(super) fn body(index: usize, name: &str, why: &dyn ToString) -> Self {
        Self::Body { index, name: name.to_owned(), why: why.to_string() }
    }

    pub(super) fn overlays(name: &str, why: &dyn ToString) -> Self {
        Self::Overlays { name: name.to_owned(), why: why.to_string() }
    }

    pub(super) fn refused([width, height]: [u32; 2], why: String) -> Self {
        Self::Refused { width, height, why }
    }
}
