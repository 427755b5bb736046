//! Everything that can go wrong, and the exit code it ends with.

use std::path::{Path, PathBuf};

use rimline::{CameraError, LightError, MeshError};
use rimline_files::npz::NpzError;
use rimline_files::size::size;
use rimline_files::{FileError, FormatError};
#[cfg(feature = "view")]
use rimline_view::desktop::DesktopError;

use crate::shadow::given_map_error::GivenMapError;
use crate::spec::SpecError;

pub(crate) const ADVICE: &str = if cfg!(target_os = "linux") {
    "`rimline extract --device cpu` needs none. To use a GPU, install its Vulkan driver, or Mesa's software one: on Debian \
     and Ubuntu `sudo apt-get install mesa-vulkan-drivers`, on Fedora `sudo dnf install mesa-vulkan-drivers`, on Arch \
     `sudo pacman -S vulkan-swrast`"
} else {
    "`rimline extract --device cpu` needs none. To use a GPU, install its current driver"
};

/// Why the command stops. The exit codes are part of the interface: `rimline --help` lists them.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The model file, or what is in it.
    #[error("{}: {source}", .file.display())]
    Input {
        file: PathBuf,
        #[source]
        source: InputError,
    },
    /// A pose of another model.
    #[error(transparent)]
    Pose(#[from] rimline::ModelError),
    /// The command line asks for what cannot be.
    #[error(transparent)]
    Usage(#[from] UsageError),
    /// There is no device that could do it.
    #[error(transparent)]
    NoDevice(#[from] NoDevice),
    /// There is no window.
    #[cfg(feature = "view")]
    #[error(transparent)]
    Window(DesktopError),
    /// The device stopped in the middle.
    #[error("the device {adapter} failed: {message}; nothing was written")]
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
    Output {
        file: PathBuf,
        #[source]
        source: std::io::Error,
    },
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum InputError {
    #[error("cannot be read: {0}")]
    Read(#[from] std::io::Error),
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Foreign(#[from] FormatError),
    #[error(transparent)]
    Gltf(#[from] rimline::gltf::GltfError),
    #[error(
        "{what}: reading it takes at least {} of memory, more than the limit of {}; if it is meant to be that large, give \
         a larger --memory-limit", size(*.needed), size(*.limit)
    )]
    TooLarge { what: String, needed: u64, limit: u64 },
    #[error(transparent)]
    Model(#[from] rimline::ModelError),
    #[error(transparent)]
    Npz(#[from] NpzError),
    #[error(transparent)]
    DepthMap(#[from] GivenMapError),
    #[cfg(feature = "bench")]
    #[error("it is not what `cargo bench --bench depth_maps -- casters --json FILE` writes: {what}")]
    DepthMapTimes { what: String },
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Lines(rimline_lines::LinesError),
    #[error("nothing of it can be drawn; the warnings say why")]
    NothingToDraw,
    #[error("{problem}")]
    Style { problem: String },
    #[error("its lights cannot be used: {0}")]
    Lights(LightError),
    #[error(
        "it has polygons, whose vertices cannot be displaced so far; cut its faces into triangles, as those of an .obj are without --polygons"
    )]
    PolygonsDisplaced,
    #[error(transparent)]
    Displacement(#[from] rimline::DisplaceError),
    #[error(
        "the displacement declares bindings, but the command has no resources for them; use functions and constants only"
    )]
    DisplacementResources,
    #[error("the depths of {points} points for {lights} lights do not fit into memory; give fewer points or lights")]
    Depths { points: usize, lights: usize },
    #[error("no face has finite positions at all of its corners, so there is nothing to draw")]
    NoFiniteFace,
    #[error("its polygons have no area, so there is nothing to draw")]
    NoArea,
    #[error(
        "its scene has no triangles; nothing is placed in it, or all of that is hidden or lines and points (`rimline info` \
         lists it)"
    )]
    EmptyScene,
    #[error("the model is larger than 32-bit numbers can say, so no camera can see it; scale it down")]
    Boundless,
    #[error("the folder contains no .npz file, so there is nothing to check; `rimline verify --make` writes some")]
    NoArchives,
    #[error("it has the same name as {}, so both would be written to the same file; rename one of them", .other.display())]
    SameName { other: PathBuf },
}

/// Errors in the command line that the parser of options does not see.
#[derive(Debug, thiserror::Error)]
pub(crate) enum UsageError {
    #[error("--displace needs a GPU, because WGSL runs on GPUs only; leave out `--device cpu` or `--displace`")]
    DisplaceOnCpu,
    #[error("the per-edge method has no exact form; leave out `--predicate exact`, or `--method per-edge`")]
    ExactPerEdge,
    #[error("drawing needs a GPU; leave out `--device cpu` (Mesa's software Vulkan counts as a GPU)")]
    DrawOnCpu,
    #[error("there is no animation `{wanted}`; {there}")]
    Animation { wanted: String, there: String },
    #[error("the file has no lights; give some with `--light point:x,y,z` or `--light dir:x,y,z`")]
    NoFileLights,
    #[error("{}: {error}", .file.display())]
    Together { file: PathBuf, error: rimline::gltf::GltfError },
    #[error("the scene of the file has no light `{wanted}`; it has {there}")]
    FileLight { wanted: String, there: String },
    #[error("{}: its scene has no cameras; leave --camera out, or say with --eye and --target where to look from", .file.display())]
    NoFileCameras { file: PathBuf },
    #[error("{}: its scene has no camera `{wanted}`; it has {there}", .file.display())]
    FileCamera { file: PathBuf, wanted: String, there: String },
    #[error(
        "{what} takes a perspective view, and this one is orthographic; leave it out, or leave out --ortho or the --camera"
    )]
    Orthographic { what: &'static str },
    #[error(transparent)]
    Lights(LightError),
    #[error(transparent)]
    Arguments(#[from] rimline::cpu::CpuError),
    #[error("{0}; change --eye, --target, --fov or --near")]
    Camera(CameraError),
    #[error(
        "--near {near:e} is too near: depths of what lies {farthest} away leave the normal range of 32-bit floats; give \
         {least:.1e} or more"
    )]
    Near { near: f32, farthest: f32, least: f32 },
    #[error("{lights} lights have {samples} samples, and at most {limit} fit; give fewer --samples")]
    Samples { lights: usize, samples: usize, limit: usize },
    #[error("--mode {0} cannot draw soft shadows; leave out --mode {0}, or --area and radius=")]
    AreaMode(String),
    #[error("{option} is for lights with an area; give --area, or a --light with radius=R, or leave {option} out")]
    NoArea { option: &'static str },
    #[error("{option} takes lights without an area; leave out {option}, or radius=")]
    Radius { option: &'static str },
    #[error(
        "--size {width}x{height} needs {needed} MiB in one array, more than {adapter} has; try --size {}x{}",
        .fits[0], .fits[1]
    )]
    PictureMemory { width: u32, height: u32, needed: u64, adapter: String, fits: [u32; 2] },
    #[error(
        "no file has an animation, so nothing moves; give --orbit 360 to lead the camera around, or --displace, or the number of \
         pictures with --frames"
    )]
    NoAnimation,
    #[error(
        "{} needs ffmpeg, and no program of this name can be started: {source}; install it (on Debian `sudo apt-get install ffmpeg`), \
         or give a folder, .gif or .apng", .out.display()
    )]
    NoFfmpeg { out: PathBuf, source: std::io::Error },
    #[error("--resume keeps the pictures of a folder; give --out the name of a folder, or leave it out")]
    ResumeClip,
    #[error(
        "{} is of a film with other options or another size, so --resume would mix two; give the options of that film, or leave \
         --resume out, which draws all pictures anew, or choose another folder", .file.display()
    )]
    ResumeOther { file: PathBuf },
    #[error("a GIF has at most 65535 pixels in each direction; give a smaller --size, or .apng")]
    GifSize,
    #[error("a film with --displace needs a length; give --frames or --seconds, or name an --animation")]
    EndlessDisplacement,
    #[error("--out and --mask would both write {}; change one of them", .file.display())]
    SameOutput { file: PathBuf },
    #[error("{} is an input, {}, and the result would replace it; choose another name", .out.display(), .input.display())]
    OutputIsInput { out: PathBuf, input: PathBuf },
    #[error("{} is written as {what}; give a name that ends in .{expected}", .out.display())]
    Ending { out: PathBuf, what: &'static str, expected: &'static str },
    #[error(
        "{} looks like a file, but --out is the folder for numbered PNG files; give the name of a folder, or one that ends in .gif, \
         .apng or .mp4", .out.display()
    )]
    FolderEnding { out: PathBuf },
    #[cfg(feature = "bench")]
    #[error("{} looks like a file, but --report names a folder; give the name of a folder", .folder.display())]
    ReportEnding { folder: PathBuf },
    #[error(
        "{} has {count} of another film, which is longer or has other numbers, first {}; remove these pictures or choose \
         another folder", .folder.display(), .first.display()
    )]
    OtherFilm { folder: PathBuf, first: PathBuf, count: String },
    #[error(
        "another film is being written into {}; wait until it is done, or choose another folder (if there is no other film, \
         remove {})", .folder.display(), .claim.display()
    )]
    FilmInProgress { folder: PathBuf, claim: PathBuf },
    #[cfg(feature = "bench")]
    #[error(
        "{} has {}, which is not of a report of `rimline bench` and would be replaced; move it away, or choose another folder",
        .folder.display(), .file.display()
    )]
    NotAReport { folder: PathBuf, file: PathBuf },
    #[error("--light: {0}")]
    Lamp(SpecError),
    #[error("the file's light `{name}`: {problem}")]
    LampOptions { name: String, problem: SpecError },
    #[error("a film of {frames} pictures is too long; at most {limit} are written")]
    TooManyFrames { frames: u64, limit: u64 },
    #[cfg(feature = "bench")]
    #[error(transparent)]
    Bench(rimline_bench::PlanError),
    #[cfg(not(feature = "bench"))]
    #[error(
        "this build of rimline leaves `bench` out; `cargo install rimline-cli` builds one that has it, and so does \
         `--features bench`"
    )]
    WithoutBench,
    #[cfg(not(feature = "view"))]
    #[error(
        "this build of rimline leaves `view` out; `cargo install rimline-cli` builds one that has it, and so does \
         `--features view`; `rimline shadow` draws to a file"
    )]
    WithoutView,
    #[error("{0}; give another light, or leave out --hide-covered")]
    Covered(rimline::cpu::CpuError),
    #[error(
        "--hide-covered takes triangles, and {} has polygons; cut its faces into triangles, as those of an .obj are without \
         --polygons, or leave out --hide-covered",
        .file.display()
    )]
    CoveredPolygons { file: PathBuf },
    #[error(
        "light {light} is among the models or close to them, so it has six depth maps, whose device depths are nearly all \
         alike; take --detector every or automatic"
    )]
    DetectorInCube { light: usize },
    #[error(
        "--dangling continues edges that a detector finds; add --detector automatic, second=LOW,HIGH or differences=T"
    )]
    Dangling,
    #[error(
        "--depth is the map of one light, and --light gives {count}; give one, or none: the light is then where the map was \
         seen from"
    )]
    DepthLights { count: usize },
    #[error("--light is {given}, but the map of --depth was seen from {map}; give this light, or leave --light out")]
    DepthLightApart { given: String, map: String },
    #[error("{position}{problem}")]
    Job { position: String, problem: String },
    #[error(
        "{} and {} would both write {}; give other names, or a pattern such as --out out/{{stem}}.png", .jobs[0], .jobs[1],
        .file.display()
    )]
    SameResult { file: PathBuf, jobs: [String; 2] },
    #[error("standard output takes the result of one job, and these are {jobs}; give --out such as out/{{stem}}.png")]
    JobsToStdout { jobs: usize },
    #[error("{}: no format is known by this name; end it in .svg, .pdf, .dxf, .json or .png, or give --format", .out.display())]
    LinesFormat { out: PathBuf },
    #[error("{option} needs an orthographic view; leave out --fov or --camera, or give --ortho with --eye")]
    ScaleOfPerspective { option: &'static str },
    #[error(
        "{} looks like a file, but with --frames --out is the folder for numbered drawings; give the name of a folder, and the \
         format by --format", .out.display()
    )]
    DrawingsFolderEnding { out: PathBuf },
    #[error(
        "at this scale the drawing takes {width}x{height} mm, and at most 100 m each way are drawn; give a smaller --scale"
    )]
    DrawingTooLarge { width: String, height: String },
    #[error("--eye is in the middle of the models, where it looks by default; give --target")]
    EyeInMiddle,
    #[error("--eye and --target are the same point; move one")]
    EyeAtTarget,
    #[error("--size {width}x{height} is too large: {adapter} can draw at most {limit} pixels in each direction")]
    Size { width: u32, height: u32, limit: u32, adapter: String },
}

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
    pub(crate) fn input(file: &Path) -> impl Fn(InputError) -> Self + '_ {
        move |source| Self::Input { file: file.to_owned(), source }
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
            // 128 and the number of the signal, as shells have it.
            Self::Jobs { .. } => 6,
            Self::Interrupted => crate::signals::interrupted_code(),
        }
    }
}
