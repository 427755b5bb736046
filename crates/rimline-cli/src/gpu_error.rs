//! Errors of the library's GPU part, and what they mean for the command.

use std::path::{Path, PathBuf};

use rimline::LightError;
use rimline::gpu::{
    DeformError, DepthMapError, ExtractionDrawError, ExtractionEncodeError, ExtractionIncludeError, ExtractorError,
    MAX_OUTLINE_EDGES, MemoryError, PositionError, ReadError, SceneError, ShadowDrawError, ShadowEncodeError,
    ShadowFormatError, ShadowQueryEncodeError, ShadowQueryError, ShadowVolumesError, StaleExtraction, TimerError,
};

use crate::device::{Gpu, describe};
use crate::failure::{Failure, NoDevice, UsageError};
use crate::load_args::size;
use crate::shadow::given_map::GivenMapError;

#[derive(Debug, thiserror::Error)]
pub(crate) enum GpuError {
    #[error(transparent)]
    Deform(#[from] DeformError),
    #[error(transparent)]
    Extractor(#[from] ExtractorError),
    #[error(transparent)]
    Encode(#[from] ExtractionEncodeError),
    #[error(transparent)]
    Include(#[from] ExtractionIncludeError),
    #[error(transparent)]
    Memory(#[from] MemoryError),
    #[error(transparent)]
    Query(#[from] ShadowQueryEncodeError),
    #[error(transparent)]
    ShadowQuery(#[from] ShadowQueryError),
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Timer(#[from] TimerError),
    #[error(transparent)]
    Draw(#[from] ExtractionDrawError),
    #[error(transparent)]
    Shadow(#[from] ShadowEncodeError),
    #[error(transparent)]
    ShadowVolumes(#[from] ShadowVolumesError),
    #[error(transparent)]
    ShadowDraw(#[from] ShadowDrawError),
    #[error(transparent)]
    ShadowFormat(#[from] ShadowFormatError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Stale(#[from] StaleExtraction),
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
        use DepthMapError::{Camera, Device, Format, Memory, Positions, Refused, StaleFrame};
        let error: GivenMapError = match self {
            Self::DepthMap(
                error @ (Camera(_) | Device(_) | Format(_) | Memory(_) | Positions(_) | Refused { .. } | StaleFrame),
            ) => return Self::DepthMap(error),
            Self::DepthMap(error) => error.into(),
            other => return other,
        };
        Self::GivenMap { file: file.to_owned(), error: Box::new(error) }
    }

    fn of_device(self, gpu: &Gpu) -> Failure {
        match &self {
            Self::Shadow(ShadowEncodeError::Camera(camera)) | Self::DepthMap(DepthMapError::Camera(camera)) => {
                return UsageError::Camera(*camera).into();
            }
            Self::Scene(SceneError::Camera { error, .. }) => return UsageError::Camera(*error).into(),
            Self::Shadow(ShadowEncodeError::Light(lights)) => return UsageError::Lights(*lights).into(),
            // The CPU would do.
            Self::Deform(DeformError::TooManyTerms { .. })
            | Self::Extractor(ExtractorError::Polygons | ExtractorError::OutlineTooLarge { .. })
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
            if let Self::Scene(_) = self { "; it may fit with fewer instances, joined to fewer meshes" } else { "" };
        // Its advice is to give the options of the command.
        if let Self::Extractor(ExtractorError::OutlineTooLarge { polygon, edges }) = self {
            return format!(
                "polygon {polygon} has an outline of {edges} edges, and one has at most {MAX_OUTLINE_EDGES} there; cut it, or \
                 leave out --polygons"
            );
        }
        match self.memory() {
            Some(MemoryError::Binding { what, bytes, limit } | MemoryError::Gathered { what, bytes, limit }) => {
                format!("{what}: {} at once, and the device reads at most {}{of_scene}", size(*bytes), size(*limit))
            }
            Some(MemoryError::Buffer { label, bytes, limit }) => {
                format!("{label}: {} in one buffer, and the device allows {}{of_scene}", size(*bytes), size(*limit))
            }
            _ => self.to_string(),
        }
    }

    fn memory(&self) -> Option<&MemoryError> {
        match self {
            Self::Memory(memory)
            | Self::Deform(DeformError::Memory(memory))
            | Self::Extractor(ExtractorError::Memory(memory))
            | Self::Encode(ExtractionEncodeError::Positions(PositionError::Memory(memory)))
            | Self::ShadowQuery(ShadowQueryError::Memory(memory))
            | Self::Query(
                ShadowQueryEncodeError::Positions(PositionError::Memory(memory))
                | ShadowQueryEncodeError::Points(PositionError::Memory(memory)),
            )
            | Self::Include(
                ExtractionIncludeError::Memory(memory)
                | ExtractionIncludeError::Positions(PositionError::Memory(memory)),
            )
            | Self::ShadowVolumes(ShadowVolumesError::Memory(memory))
            | Self::DepthMap(DepthMapError::Memory(memory) | DepthMapError::Positions(PositionError::Memory(memory)))
            | Self::Scene(SceneError::Memory(memory) | SceneError::Positions(PositionError::Memory(memory)))
            | Self::Shadow(
                ShadowEncodeError::Positions(PositionError::Memory(memory))
                | ShadowEncodeError::Include(
                    ExtractionIncludeError::Memory(memory)
                    | ExtractionIncludeError::Positions(PositionError::Memory(memory)),
                ),
            ) => Some(memory),
            _ => None,
        }
    }

    fn lights(&self) -> Option<&LightError> {
        match self {
            Self::Scene(SceneError::Light(lights))
            | Self::Extractor(ExtractorError::Light(lights))
            | Self::Encode(ExtractionEncodeError::Light(lights))
            | Self::ShadowQuery(ShadowQueryError::Light(lights))
            | Self::Query(ShadowQueryEncodeError::Light(lights)) => Some(lights),
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
