//! Choosing a device, and noticing when it fails.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, Once, OnceLock, PoisonError};

use rimline::gpu::depth_map::DepthMapError;
use rimline::gpu::{
    DeformError, DeviceError, ExtractorError, MAX_BOUNDARY_EDGES, Pipelines, QueryError, ShadowError, read_back_vec,
};
use rimline::wgpu;
use rimline_bench::slivers;
use rimline_files::size::size;
use wgpu::{AdapterInfo, Backend, Backends, DeviceType, Features, Limits};

use crate::failure::{Failure, NoDevice};
use crate::output::note;

/// Features that Rimline uses where a device has them; it needs none of them.
pub(crate) const OPTIONAL_FEATURES: [(Features, &str); 2] = [
    (Features::TIMESTAMP_QUERY, "times of the stages as the device measures them"),
    (Features::DEPTH32FLOAT_STENCIL8, "shadows far away from a near plane that is next to the eye"),
];

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    Auto,
    Gpu,
    Cpu,
    Named(String),
}

impl From<&str> for Wanted {
    fn from(text: &str) -> Self {
        // Letters may be of either case, as in names.
        match &*text.to_lowercase() {
            "auto" => Self::Auto,
            "gpu" => Self::Gpu,
            "cpu" => Self::Cpu,
            _ => Self::Named(text.to_owned()),
        }
    }
}

impl Wanted {
    fn fits(&self, adapter: &wgpu::Adapter) -> bool {
        let Self::Named(part) = self else { return true };
        describe(&adapter.get_info()).to_lowercase().contains(&part.to_lowercase())
    }
}

pub(crate) enum Device {
    Cpu,
    Gpu(Box<Gpu>),
}

impl Device {
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Cpu => "cpu".into(),
            Self::Gpu(gpu) => describe(&gpu.info),
        }
    }

    pub(crate) fn clips_wrongly(&self) -> bool {
        matches!(self, Self::Gpu(gpu) if gpu.clips_wrongly())
    }
}

#[derive(Clone)]
pub(crate) struct Gpu {
    pub(crate) info: AdapterInfo,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// Shared by all meshes and methods on this device.
    pub(crate) pipelines: Pipelines,
    /// Whether the CPU can do the work that the device is opened for.
    pub(crate) cpu_would_do: bool,
    /// The first failure is the cause; what follows are its consequences.
    failure: Arc<OnceLock<String>>,
    /// Pixels that the trial of slivers has wrong, once it ran.
    wrong_slivers: Arc<OnceLock<Result<usize, String>>>,
}

/// All adapters of all backends, the ones to prefer first.
pub(crate) fn adapters() -> Vec<wgpu::Adapter> {
    adapters_of(Backends::all())
}

fn adapters_of(backends: Backends) -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(
        wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() }.with_env(),
    );
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.retain(|adapter| adapter.get_info().backend != Backend::Noop);
    adapters.sort_by_key(|adapter| KINDS.iter().position(|(kind, _)| *kind == adapter.get_info().device_type));
    adapters
}

/// The kinds of devices in words, the ones to prefer first.
const KINDS: [(DeviceType, &str); 5] = [
    (DeviceType::DiscreteGpu, "discrete GPU"),
    (DeviceType::IntegratedGpu, "integrated GPU"),
    (DeviceType::VirtualGpu, "virtual GPU"),
    (DeviceType::Other, "other"),
    (DeviceType::Cpu, "software"),
];

/// The kind of a device, in words.
pub(crate) fn kind_name(kind: DeviceType) -> &'static str {
    KINDS.iter().find(|(of, _)| *of == kind).map_or("other", |(_, name)| *name)
}

/// A capability that every stage needs and the adapter lacks, if any.
pub(crate) fn lacks(adapter: &wgpu::Adapter) -> Option<String> {
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Some("compute shaders".into());
    }
    let (needed, has) = (Limits::default(), adapter.limits());
    let of = |l: &Limits| [l.max_storage_buffers_per_shader_stage, l.max_compute_invocations_per_workgroup];
    let names = ["storage buffers a stage", "invocations a workgroup"];
    let mut limits = names.into_iter().zip(of(&needed).into_iter().zip(of(&has)));
    let short = limits.find(|(_, (needed, has))| has < needed);
    short.map(|(name, (needed, has))| format!("{needed} {name} (it has {has})"))
}

pub(crate) fn open(wanted: &Wanted) -> Result<Device, Failure> {
    if *wanted == Wanted::Cpu {
        return Ok(Device::Cpu);
    }
    match open_gpu(wanted) {
        Ok(gpu) => Ok(Device::Gpu(Box::new(Gpu { cpu_would_do: true, ..gpu }))),
        Err(reason) if *wanted == Wanted::Auto => {
            // Once for all jobs.
            static NOTE: Once = Once::new();
            NOTE.call_once(|| note(&format!("working on the CPU, because {reason}")));
            Ok(Device::Cpu)
        }
        Err(reason) => Err(reason.into()),
    }
}

/// Opens what `--device` asks for, for what the CPU can do, too. `auto` takes no GPU that is software: it runs on the same
/// cores, and compiles shaders first. A device that was made small stands for one that is none.
pub(crate) fn open_fastest(wanted: &Wanted) -> Result<Device, Failure> {
    if *wanted == Wanted::Auto && buffer_limit().is_none() && is_software() { Ok(Device::Cpu) } else { open(wanted) }
}

/// Whether the GPU that `auto` would take is software. Looks once.
fn is_software() -> bool {
    static IS_SOFTWARE: OnceLock<bool> = OnceLock::new();
    *IS_SOFTWARE.get_or_init(|| {
        let first = by_preference().find(|adapter| lacks(adapter).is_none());
        first.is_some_and(|adapter| adapter.get_info().device_type == DeviceType::Cpu)
    })
}

/// Does the work on the device. Where `auto` chose a GPU that the work does not fit, the CPU does it, and a remark says
/// so. Returns the device that did it.
pub(crate) fn work<T>(
    wanted: &Wanted,
    device: Device,
    mut run: impl FnMut(&Device) -> Result<T, Failure>,
) -> Result<(Device, T), Failure> {
    match run(&device) {
        Err(Failure::NoDevice(NoDevice::TooSmall { adapter, reason, cpu_would_do: true }))
            if *wanted == Wanted::Auto =>
        {
            // Its memory is given back first.
            drop(device);
            note(&format!("working on the CPU, because the model does not fit the device {adapter}: {reason}"));
            run(&Device::Cpu).map(|done| (Device::Cpu, done))
        }
        done => Ok((device, done?)),
    }
}

/// Devices that many jobs share, by what was asked for. `None`: they are not shared.
static SHARED: Mutex<Option<Vec<(Wanted, Gpu)>>> = Mutex::new(None);

fn shared() -> MutexGuard<'static, Option<Vec<(Wanted, Gpu)>>> {
    SHARED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Opens each device once from now on, or closes what is open.
pub(crate) fn keep_open(is_kept: bool) {
    *shared() = is_kept.then(Vec::new);
}

/// Opens the device that is asked for, unless it is open and works.
pub(crate) fn open_gpu(wanted: &Wanted) -> Result<Gpu, NoDevice> {
    let mut shared = shared();
    let Some(shared) = &mut *shared else { return open_first(wanted) };
    shared.retain(|(_, gpu)| gpu.check().is_ok());
    if let Some((_, gpu)) = shared.iter().find(|(name, _)| name == wanted) {
        return Ok(gpu.clone());
    }
    let gpu = open_first(wanted)?;
    shared.push((wanted.clone(), gpu.clone()));
    Ok(gpu)
}

/// The adapters that are tried, as they are needed. OpenGL, the poorer way to a GPU, is looked at only where nothing else
/// fits: its drivers talk, and the same GPU mostly shows elsewhere too.
fn by_preference() -> impl Iterator<Item = wgpu::Adapter> {
    [Backends::all().difference(Backends::GL), Backends::GL].into_iter().flat_map(adapters_of)
}

/// Opens the first adapter that fits. All but [`Wanted::Named`] mean any here, the CPU too: callers refuse that before.
fn open_first(wanted: &Wanted) -> Result<Gpu, NoDevice> {
    let (mut names, mut refused) = (Vec::new(), None);
    for adapter in by_preference() {
        names.push(describe(&adapter.get_info()));
        if !wanted.fits(&adapter) {
            continue;
        }
        match request(&adapter) {
            Ok(gpu) => {
                log::debug!("opened {}", describe(&gpu.info));
                return Ok(gpu);
            }
            Err(reason) => {
                refused.get_or_insert(reason);
            }
        }
    }
    match (refused, wanted) {
        (Some(reason), _) => Err(reason),
        (None, Wanted::Named(name)) if !names.is_empty() => {
            Err(NoDevice::NotNamed { name: name.clone(), adapters: names })
        }
        _ => Err(NoDevice::none()),
    }
}

/// Opens every adapter that fits, and says of those that cannot be used why not.
pub(crate) fn open_every(wanted: &Wanted) -> (Vec<Gpu>, Vec<NoDevice>) {
    let (mut opened, mut unusable) = (Vec::new(), Vec::new());
    for adapter in adapters().iter().filter(|adapter| wanted.fits(adapter)) {
        match request(adapter) {
            Ok(gpu) => opened.push(gpu),
            Err(reason) => unusable.push(reason),
        }
    }
    (opened, unusable)
}

/// Wrong pixels in the trial of slivers that leave the picture. `None` if the adapter cannot run the trial.
pub(crate) fn wrong_slivers(adapter: &wgpu::Adapter) -> Option<usize> {
    request(adapter).ok().and_then(|gpu| gpu.wrong_slivers().as_ref().ok().copied())
}

pub(crate) fn describe(info: &AdapterInfo) -> String {
    format!("{} ({})", info.name, backend_name(info.backend))
}

pub(crate) fn backend_name(backend: Backend) -> &'static str {
    match backend {
        Backend::Vulkan => "Vulkan",
        Backend::Metal => "Metal",
        Backend::Dx12 => "DirectX 12",
        Backend::Gl => "OpenGL",
        Backend::BrowserWebGpu => "WebGPU",
        Backend::Noop => "no-op",
    }
}

/// `RIMLINE_BUFFER_LIMIT`, the most bytes that a GPU's buffer and binding may have: makes a small device of a large one, to
/// try what happens there.
fn buffer_limit() -> Option<u64> {
    std::env::var("RIMLINE_BUFFER_LIMIT").ok()?.parse().ok()
}

fn request(adapter: &wgpu::Adapter) -> Result<Gpu, NoDevice> {
    let name = || describe(&adapter.get_info());
    if let Some(lacking) = lacks(adapter) {
        let adapter = name();
        return Err(NoDevice::Lacks { adapter, lacking });
    }
    let offered = adapter.limits();
    let most = buffer_limit().unwrap_or(u64::MAX);
    // The portable limits, as far as they go, and more only where big meshes and pictures need it.
    let limits = Limits {
        max_buffer_size: offered.max_buffer_size.min(most),
        max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size.min(most),
        max_texture_dimension_2d: offered.max_texture_dimension_2d,
        ..Limits::default().or_worse_values_from(&offered)
    };
    let features = OPTIONAL_FEATURES.iter().fold(Features::empty(), |all, &(feature, _)| all | feature);
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("rimline"),
        required_features: adapter.features() & features,
        required_limits: limits,
        ..Default::default()
    }))
    .map_err(|source| NoDevice::Refused { adapter: name(), source })?;
    let failure = Arc::new(OnceLock::new());
    let [reported, lost] = [Arc::clone(&failure), Arc::clone(&failure)];
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        let _ = reported.set(match error {
            wgpu::Error::OutOfMemory { .. } => {
                "it is out of memory; try a smaller model, a smaller picture or fewer lights".to_owned()
            }
            error => error.to_string(),
        });
    }));
    device.set_device_lost_callback(move |reason, message| {
        if reason != wgpu::DeviceLostReason::Destroyed {
            let _ = lost.set(format!("it was lost: {message}"));
        }
    });
    let pipelines = Pipelines::new(&device);
    Ok(Gpu {
        info: adapter.get_info(),
        device,
        queue,
        pipelines,
        cpu_would_do: false,
        failure,
        wrong_slivers: Arc::default(),
    })
}

impl Gpu {
    /// The first error that the device reported, as exit code 4; asked before results are trusted.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        self.failure.get().map_or(Ok(()), |message| Err(self.failed(message)))
    }

    /// Tells the first error that the device reported, also when the device has been cloned.
    #[cfg(feature = "bench")]
    pub(crate) fn reported(&self) -> impl Fn() -> Option<String> + use<> {
        let failure = Arc::clone(&self.failure);
        move || failure.get().cloned()
    }

    /// How many pixels of slivers that leave the picture the driver counts wrongly: 0 of one that clips them rightly. Or why
    /// that cannot be tried. The first call draws them.
    pub(crate) fn wrong_slivers(&self) -> &Result<usize, String> {
        self.wrong_slivers.get_or_init(|| slivers::wrong_pixels(&self.device, &self.queue))
    }

    /// Whether the driver clips slivers wrongly. A device that fails says so when its results are read.
    pub(crate) fn clips_wrongly(&self) -> bool {
        self.wrong_slivers().as_ref().is_ok_and(|&wrong| wrong > 0)
    }

    pub(crate) fn failed(&self, message: &str) -> Failure {
        // wgpu's messages are paragraphs; the command's are lines.
        let lines: Vec<&str> = message.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        Failure::DeviceLost { adapter: describe(&self.info), message: lines.join(" ") }
    }

    pub(crate) fn encoder(&self, label: &str) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) })
    }

    pub(crate) fn submit(&self, encoder: wgpu::CommandEncoder) {
        self.queue.submit([encoder.finish()]);
    }

    /// A buffer that is written by copies and has at least 16 bytes.
    pub(crate) fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let (label, size, usage) = (Some(label), size.max(16), usage | wgpu::BufferUsages::COPY_DST);
        self.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
    }

    pub(crate) fn read<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, DeviceError> {
        read_back_vec(&self.device, &self.queue, buffer)
    }

    pub(crate) fn read_first<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer) -> Result<T, DeviceError> {
        Ok(self.read(buffer)?.first().copied().unwrap_or(T::zeroed()))
    }

    pub(crate) fn wait(&self) -> Result<(), Failure> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        polled.map(|_| ()).map_err(|error| self.failed(&error.to_string()))
    }
}

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
    #[error("{}: {problem}", .file.display())]
    GivenMap { file: PathBuf, problem: String },
}

impl GpuError {
    /// The failure that this is, on this device: a model that is too large means that the device will not do.
    pub(crate) fn on(self, gpu: &Gpu) -> Failure {
        // The error that the device reported comes first, because the others follow from it.
        if let Err(failure) = gpu.check() {
            return failure;
        }
        match &self {
            Self::GivenMap { file, problem } => Failure::input(file, problem.clone()),
            Self::Shadow(ShadowError::ViewCamera { error: camera, .. })
            | Self::DepthMap(DepthMapError::Camera(camera)) => {
                Failure::usage(format!("{camera}; change --eye, --target, --fov or --near"))
            }
            Self::Extractor(ExtractorError::Light(lights))
            | Self::Query(QueryError::Light(lights))
            | Self::Shadow(ShadowError::Light(lights)) => Failure::usage(lights.to_string()),
            // The CPU would do.
            Self::Deform(DeformError::TooManyTerms { .. })
            | Self::Extractor(
                ExtractorError::Polygons
                | ExtractorError::BoundaryTooLarge { .. }
                | ExtractorError::PolygonTooLarge { .. },
            )
            | Self::Shadow(ShadowError::Extraction(
                ExtractorError::BoundaryTooLarge { .. } | ExtractorError::PolygonTooLarge { .. },
            ))
            | Self::DepthMap(DepthMapError::Texture { .. }) => self.too_small(gpu),
            _ if self.memory().is_some() => self.too_small(gpu),
            _ => gpu.failed(&self.to_string()),
        }
    }

    /// Makes a map of the user's the reason, where it is one: users have a file, and no cameras of the library.
    pub(crate) fn of_map(self, file: &Path) -> Self {
        use DepthMapError::{Apart, Camera, CubeContours, Device, Refused, Shadow, StaleFrame};
        let problem = match self {
            Self::DepthMap(Apart { face, what }) => format!(
                "map {face} does not meet the others: {what}; take the views that docs/formats.md states for six \
                 maps, or turn all six together"
            ),
            Self::DepthMap(CubeContours) => {
                "it has six maps, and --detector contours takes one; take another detector, or give one map".to_owned()
            }
            Self::DepthMap(Camera(_) | Device(_) | Shadow(_) | Refused { .. } | StaleFrame) => return self,
            Self::DepthMap(error) => error.to_string(),
            other => return other,
        };
        Self::GivenMap { file: file.to_owned(), problem }
    }

    fn too_small(&self, gpu: &Gpu) -> Failure {
        let (adapter, reason) = (describe(&gpu.info), self.reason());
        NoDevice::TooSmall { adapter, reason, cpu_would_do: gpu.cpu_would_do }.into()
    }

    /// Reason why something does not fit, in words for users who cannot change the device's limits.
    fn reason(&self) -> String {
        let of_scene =
            if let Self::Shadow(_) = self { "; it may fit with fewer instances, joined to fewer meshes" } else { "" };
        if let Self::Extractor(error) | Self::Shadow(ShadowError::Extraction(error)) = self
            && let Some(reason) = of_polygons(error)
        {
            return reason;
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
}

/// Why polygons do not fit, with advice that names options of the command and not the library.
fn of_polygons(error: &ExtractorError) -> Option<String> {
    Some(match error {
        ExtractorError::Polygons => {
            "--method per-edge takes no polygons there; leave it out, or leave out --polygons".to_owned()
        }
        ExtractorError::BoundaryTooLarge { polygon, edges } => format!(
            "polygon {polygon} has a boundary of {edges} edges, and one has at most {MAX_BOUNDARY_EDGES} there; cut it, or \
             leave out --polygons"
        ),
        ExtractorError::PolygonTooLarge { polygon, triangles } => {
            format!("polygon {polygon} has {triangles} triangles, too many there; cut it, or leave out --polygons")
        }
        _ => return None,
    })
}

pub(crate) trait On<T> {
    fn on(self, gpu: &Gpu) -> Result<T, Failure>;
}

impl<T, E: Into<GpuError>> On<T> for Result<T, E> {
    fn on(self, gpu: &Gpu) -> Result<T, Failure> {
        self.map_err(|error| error.into().on(gpu))
    }
}
