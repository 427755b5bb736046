//! Errors of the library's GPU part, and what they mean for the command.

use std::path::{Path, PathBuf};

use rimline::LightError;
use rimline::gpu::depth_map::DepthMapError;
use rimline::gpu::{DeformError, DeviceError, ExtractorError, MAX_BOUNDARY_EDGES, QueryError, ShadowError};

use crate::device::{Gpu, describe};
use crate::failure::{Failure, NoDevice, UsageError};
use crate::shadow::given_map_error::GivenMapError;
use rimline_files::size::size;

#[derive(Debug, thiserror::Error)]
pub(crate) enum GpuError {
    #[error(transparent)]
    Deform(#[from] DeformError),
    #[error(transparent)]
    Extractor(#[from] ExtractorError),
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error(transparent)]
    Query(#[from] QueryError),
    #[error(transparent)]
    Shadow(#[from] ShadowError),
    #[error(transparent)]
    DepthMap(#[from] DepthMapError),
    /// The user's depth map is the reason.
    #[error("{}: {error}", .file.display())]
    GivenMap { file: PathBuf, error: Box<GivenMapError> },
}

impl GpuError {
    /// The failure that this is, on this device: a model that is too large means that the device will not do.
    pub(crate) fn on(self, gpu: &Gpu) -> Failure {
        // The error that the device reported comes first, because the others follow from it.
        if let Err(failure) = gpu.check() {
            return failure;
        }
        match self {
            Self::GivenMap { file, error } => return Failure::input(&file)((*error).into()),
            error => error.of_device(gpu),
        }
    }

    /// Makes a map of the user's the reason, where it is one.
    pub(crate) fn of_map(self, file: &Path) -> Self {
        use DepthMapError::{Camera, Device, Refused, Shadow, StaleFrame};
        let error: GivenMapError = match self {
            Self::DepthMap(error @ (Camera(_) | Device(_) | Shadow(_) | Refused { .. } | StaleFrame)) => {
                return Self::DepthMap(error);
            }
            Self::DepthMap(error) => error.into(),
            other => return other,
        };
        Self::GivenMap { file: file.to_owned(), error: Box::new(error) }
    }

    fn of_device(self, gpu: &Gpu) -> Failure {
        match &self {
            Self::Shadow(ShadowError::ViewCamera { error: camera, .. })
            | Self::DepthMap(DepthMapError::Camera(camera)) => return UsageError::Camera(*camera).into(),
            // The CPU would do.
            Self::Deform(DeformError::TooManyTerms { .. })
            | Self::Extractor(ExtractorError::Polygons | ExtractorError::BoundaryTooLarge { .. })
            | Self::DepthMap(DepthMapError::Texture { .. }) => {
                return self.too_small(gpu);
            }
            _ => {}
        }
        match (self.memory(), self.lights()) {
            (Some(_), _) => self.too_small(gpu),
            (_, Some(lights)) => UsageError::Lights(*lights).into(),
            _ => gpu.failed(&self.to_string()),
        }
    }

    /// The device will not do.
    fn too_small(&self, gpu: &Gpu) -> Failure {
        let (adapter, reason) = (describe(&gpu.info), self.reason());
        NoDevice::TooSmall { adapter, reason, cpu_would_do: gpu.cpu_would_do }.into()
    }

    /// Reason why something does not fit, in words for users who cannot change the device's limits.
    fn reason(&self) -> String {
        let of_scene =
            if let Self::Shadow(_) = self { "; it may fit with fewer instances, joined to fewer meshes" } else { "" };
        // Its advice is to give the options of the command.
        if let Self::Extractor(ExtractorError::BoundaryTooLarge { polygon, edges }) = self {
            return format!(
                "polygon {polygon} has a boundary of {edges} edges, and one has at most {MAX_BOUNDARY_EDGES} there; cut it, or \
                 leave out --polygons"
            );
        }
        match self.memory() {
            Some(
                DeviceError::BindingTooLarge { what, bytes, limit }
                | DeviceError::GatheredTooLarge { what, bytes, limit },
            ) => {
                format!("{what}: {} at once, and the device reads at most {}{of_scene}", size(*bytes), size(*limit))
            }
            Some(DeviceError::BufferTooLarge { label, bytes, limit }) => {
                format!("{label}: {} in one buffer, and the device allows {}{of_scene}", size(*bytes), size(*limit))
            }
            _ => self.to_string(),
        }
    }

    /// The memory that does not fit.
    fn memory(&self) -> Option<&DeviceError> {
        match self {
            Self::Device(error)
            | Self::Deform(DeformError::Device(error))
            | Self::Extractor(ExtractorError::Device(error))
            | Self::Query(QueryError::Device(error) | QueryError::Points(error))
            | Self::Shadow(ShadowError::Device(error))
            | Self::DepthMap(DepthMapError::Device(error)) => Some(error).filter(|error| error.is_memory()),
            _ => None,
        }
    }

    fn lights(&self) -> Option<&LightError> {
        match self {
            Self::Extractor(ExtractorError::Light(lights))
            | Self::Query(QueryError::Light(lights))
            | Self::Shadow(ShadowError::Light(lights)) => Some(lights),
            _ => None,
        }
    }
}

/// Results of the library's GPU part as results of the command.
pub(crate) trait On<T> {
    fn on(self, gpu: &Gpu) -> Result<T, Failure>;
}

impl<T, E: Into<GpuError>> On<T> for Result<T, E> {
    fn on(self, gpu: &Gpu) -> Result<T, Failure> {
        self.map_err(|error| error.into().on(gpu))
    }
}
