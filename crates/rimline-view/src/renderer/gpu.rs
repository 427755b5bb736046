//! The device.

use std::pin::pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Waker};

use rimline::gpu::Pipelines;
use wgpu::{Features, Limits};

use super::error::RenderError;

/// A device that pictures are drawn on.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The name of the adapter.
    pub name: String,
    /// Whether the device is software, which runs on the CPU.
    pub is_software: bool,
    pub(crate) pipelines: Pipelines,
    is_lost: Arc<AtomicBool>,
    /// The first error of the device that no error scope took.
    refusal: Arc<OnceLock<String>>,
}

/// Features that are used where a device has them.
const OPTIONAL: Features = Features::TIMESTAMP_QUERY.union(Features::DEPTH32FLOAT_STENCIL8);

impl Gpu {
    /// Opens an adapter's device: with default limits, and more where big models and pictures need it.
    ///
    /// # Errors
    /// [`RenderError::Adapter`] if the adapter lacks what extraction needs, or gives no device.
    pub async fn open(adapter: &wgpu::Adapter) -> Result<Self, RenderError> {
        let info = adapter.get_info();
        let name = format!("{} ({:?})", info.name, info.backend);
        let refused = |why: String| RenderError::Adapter { name: name.clone(), why };
        if !adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
            return Err(refused("it has no compute shaders".into()));
        }
        let offered = adapter.limits();
        let limits = Limits {
            max_buffer_size: offered.max_buffer_size,
            max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
            max_texture_dimension_2d: offered.max_texture_dimension_2d,
            ..Limits::default().or_worse_values_from(&offered)
        };
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("rimline view"),
                required_features: adapter.features() & OPTIONAL,
                required_limits: limits,
                ..Default::default()
            })
            .await
            .map_err(|error| refused(error.to_string()))?;
        let is_software = info.device_type == wgpu::DeviceType::Cpu;
        let gpu = Self::of(device, queue, name, is_software);
        let (is_lost, refusal) = (Arc::clone(&gpu.is_lost), Arc::clone(&gpu.refusal));
        gpu.device.set_device_lost_callback(move |_, _| is_lost.store(true, Ordering::Relaxed));
        // Without this, wgpu panics. Later errors follow from the first.
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| _ = refusal.set(one_line(&error))));
        Ok(gpu)
    }

    /// Takes a device that is there. Its owner hears of its errors and of its loss: [`Self::check`] and
    /// [`Self::is_lost`] do not tell them.
    pub fn of(device: wgpu::Device, queue: wgpu::Queue, name: String, is_software: bool) -> Self {
        let pipelines = Pipelines::new(&device);
        Self { device, queue, name, is_software, pipelines, is_lost: Arc::default(), refusal: Arc::default() }
    }

    /// Whether the device is lost: everything is to be made anew, on another one.
    pub fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Relaxed)
    }

    /// Whether the device did all that was asked of it. A lost device is another matter.
    ///
    /// # Errors
    /// [`RenderError::Unexpected`] if it refused something, so that what is shown may be wrong.
    pub fn check(&self) -> Result<(), RenderError> {
        let why = self.refusal.get().filter(|_| !self.is_lost());
        why.map_or(Ok(()), |why| Err(RenderError::Unexpected { name: self.name.clone(), why: why.clone() }))
    }

    /// Device and queue.
    pub(super) fn on(&self) -> (&wgpu::Device, &wgpu::Queue) {
        (&self.device, &self.queue)
    }

    pub(super) fn encoder(&self, label: &str) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) })
    }
}

/// wgpu breaks its messages into lines.
fn one_line(error: &wgpu::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Makes textures and buffers, or says why the device refuses them: most often it lacks memory. A browser answers later than
/// this returns, so that [`Gpu::check`] says it.
pub(super) fn granted<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, String> {
    if cfg!(target_arch = "wasm32") {
        return Ok(make());
    }
    // A view of a texture that was refused is invalid.
    let scopes =
        [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation].map(|filter| device.push_error_scope(filter));
    let made = make();
    let answer = |scope: wgpu::ErrorScopeGuard| match pin!(scope.pop()).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(error) => error,
        Poll::Pending => None,
    };
    let Some(error) = scopes.into_iter().rev().filter_map(answer).reduce(|_, outer| outer) else { return Ok(made) };
    // The first lines name functions.
    let said = error.to_string();
    Err(said.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or_default().to_owned())
}
