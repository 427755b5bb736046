//! Everything that can go wrong, and the exit code it ends with.

use std::path::{Path, PathBuf};

#[cfg(feature = "view")]
use rimline_view::desktop::DesktopError;

pub(crate) const ADVICE: &str = if cfg!(target_os = "linux") {
    "`rimline extract --device cpu` needs none. To use a GPU, install its Vulkan driver, or Mesa's software one: on Debian \
     and Ubuntu `sudo apt-get install mesa-vulkan-drivers`, on Fedora `sudo dnf install mesa-vulkan-drivers`, on Arch \
     `sudo pacman -S vulkan-swrast`"
} else {
    "`rimline extract --device cpu` needs none. To use a GPU, install its current driver"
};

/// The fault of an input.
pub(crate) type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why the command stops. The exit codes are part of the interface: `rimline --help` lists them.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The model file, or what is in it.
    #[error("{}: {source}", .file.display())]
    Input { file: PathBuf, source: Cause },
    /// A model that has no mesh, or cannot be deformed.
    #[error(transparent)]
    Pose(#[from] rimline::ModelError),
    /// The command line asks for what cannot be.
    #[error("{0}")]
    Usage(String),
    /// There is no device that could do it.
    #[error(transparent)]
    NoDevice(#[from] NoDevice),
    /// There is no window.
    #[cfg(feature = "view")]
    #[error(transparent)]
    Window(DesktopError),
    /// The device stopped in the middle.
    #[error("the device {adapter} failed: {message}; no partial file is left")]
    DeviceLost { adapter: String, message: String },
    /// `verify` found what should not be.
    #[error("{}: {different} of {checked} checks found other bits than the files hold", .folder.display())]
    Differs { folder: PathBuf, different: usize, checked: usize },
    /// `verify --built-in` found bits that the CPU does not.
    #[error("{wrong} bits differ from those of the CPU; please report the table and the driver")]
    WrongBits { wrong: u64 },
    /// `verify` could not do all of its checks.
    #[error("{count} of the checks could not be done; the first: {first}")]
    Unchecked { count: usize, first: Box<Failure> },
    /// Ctrl-C, after what there was has been written.
    #[error("stopped; what was finished is kept")]
    Interrupted,
    /// Some of many jobs failed.
    #[error("{failed} of {jobs} jobs failed")]
    Jobs { failed: usize, jobs: usize },
    /// The result could not be written.
    #[error("{}: cannot be written: {source}", .file.display())]
    Output { file: PathBuf, source: std::io::Error },
}

pub(crate) const DISPLACE_ON_CPU: &str =
    "--displace needs a GPU, because WGSL runs on GPUs only; leave out `--device cpu` or `--displace`";
pub(crate) const DRAW_ON_CPU: &str =
    "drawing needs a GPU; leave out `--device cpu` (Mesa's software Vulkan counts as a GPU)";
pub(crate) const EYE_AT_TARGET: &str = "--eye and --target are the same point; move one";
pub(crate) const EYE_TOO_FAR: &str = "the eye would be farther away than 32-bit floats can say; give a larger --fov, \
                                      a nearer --target or smaller models";
pub(crate) const NO_FINITE_FACE: &str =
    "no face has finite positions at all of its corners, so there is nothing to draw";
pub(crate) const NO_AREA: &str = "its polygons have no area, so there is nothing to draw";

#[derive(Debug, thiserror::Error)]
pub(crate) enum NoDevice {
    #[error("no GPU was found. {}", ADVICE)]
    None,
    #[error(
        "no GPU was found, because the environment variable WGPU_BACKEND is `{wanted}` and allows no other backend; unset it, \
         or set it to vulkan, metal, dx12 or gl. `rimline extract --device cpu` needs none"
    )]
    Backend { wanted: String },
    #[error("no device has `{name}` in its name or backend; the devices are {}", .adapters.join(", "))]
    NotNamed { name: String, adapters: Vec<String> },
    #[error(
        "the device {adapter} cannot be used: it lacks {lacking}; choose another one (`rimline devices` lists them)"
    )]
    Lacks { adapter: String, lacking: String },
    #[error("the model does not fit the device {adapter}: {reason}; try {}", remedy(*.cpu_would_do))]
    TooSmall { adapter: String, reason: String, cpu_would_do: bool },
    #[error("the device {adapter} cannot be opened: {source}")]
    Refused { adapter: String, source: rimline::wgpu::RequestDeviceError },
}

impl NoDevice {
    /// Why there is no adapter: wgpu's own variable may hide all.
    pub(crate) fn none() -> Self {
        match std::env::var_os("WGPU_BACKEND") {
            Some(wanted) => Self::Backend { wanted: wanted.to_string_lossy().into_owned() },
            None => Self::None,
        }
    }
}

fn remedy(cpu_would_do: bool) -> &'static str {
    if cpu_would_do {
        "`--device cpu` or another device (`rimline devices` lists them)"
    } else {
        "a smaller model or another device (`rimline devices` lists them)"
    }
}

impl Failure {
    /// Pins what is wrong with an input to its file.
    pub(crate) fn input(file: &Path, error: impl Into<Cause>) -> Self {
        Self::Input { file: file.to_owned(), source: error.into() }
    }

    /// Pins what is wrong with a result to its file, in `map_err`.
    pub(crate) fn output(file: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        move |source| Self::Output { file: file.to_owned(), source }
    }

    pub(crate) fn usage(text: impl Into<String>) -> Self {
        Self::Usage(text.into())
    }

    /// 1 bad input, 2 bad usage, 3 no usable device, 4 device lost or output not writable, 5 other bits, 6 jobs that failed,
    /// 128 and the signal that stopped it.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Input { .. } | Self::Pose(_) => 1,
            Self::Usage(_) => 2,
            Self::NoDevice(_) => 3,
            #[cfg(feature = "view")]
            Self::Window(DesktopError::NoFile) => 1,
            #[cfg(feature = "view")]
            Self::Window(DesktopError::NoFolder(_)) => 2,
            #[cfg(feature = "view")]
            Self::Window(_) => 3,
            Self::DeviceLost { .. } | Self::Output { .. } => 4,
            Self::Differs { .. } | Self::WrongBits { .. } => 5,
            Self::Unchecked { first, .. } => first.code(),
            Self::Jobs { .. } => 6,
            Self::Interrupted => crate::signals::interrupted_code(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A film and a benchmark keep the files that are complete.
    #[test]
    fn a_lost_device_leaves_what_is_complete() {
        let failure = Failure::DeviceLost { adapter: "a".into(), message: "b".into() };
        assert_eq!(failure.to_string(), "the device a failed: b; no partial file is left");
    }
}
