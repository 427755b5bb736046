//! The device that GPU tests run on.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

use rimline::gpu::Pipelines;

use crate::random::Random;

/// A device with its queue, its adapter's name, and pipelines that all tests on it share.
pub struct Gpu {
    instance: wgpu::Instance,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub pipelines: Pipelines,
    pub name: String,
    kept: Mutex<HashMap<(TypeId, String), Arc<dyn Any + Send + Sync>>>,
}

/// A device that tests share, or why there is none, once it was asked for.
type Shared = Option<Result<Arc<Gpu>, String>>;

/// The shared device, and the one with features.
static SHARED: Mutex<[Shared; 2]> = Mutex::new([None, None]);

impl Gpu {
    /// A device with no optional feature and these limits.
    pub fn with_limits(limits: wgpu::Limits) -> Result<Self, String> {
        Self::with(wgpu::Features::empty(), limits)
    }

    /// A device with these features and limits.
    pub fn with(features: wgpu::Features, limits: wgpu::Limits) -> Result<Self, String> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
        Self::of(instance, features, limits)
    }

    /// Another device of the same instance.
    pub fn another(&self, features: wgpu::Features, limits: wgpu::Limits) -> Result<Self, String> {
        Self::of(self.instance.clone(), features, limits)
    }

    fn of(instance: wgpu::Instance, features: wgpu::Features, limits: wgpu::Limits) -> Result<Self, String> {
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
            .map_err(|error| format!("no GPU adapter: {error}; `cargo xtask test` installs a software one"))?;
        let info = adapter.get_info();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("test"),
            required_features: features,
            required_limits: limits,
            ..Default::default()
        }))
        .map_err(|error| error.to_string())?;
        let pipelines = Pipelines::new(&device);
        let name = format!("{} ({:?})", info.name, info.backend);
        Ok(Self { instance, device, queue, pipelines, name, kept: Mutex::default() })
    }

    /// One device of `Limits::default()` that tests share.
    pub fn shared() -> Result<Arc<Self>, String> {
        Self::shared_with(0, wgpu::Features::empty())
    }

    /// The device that tests share, and random numbers from a seed, which is printed.
    pub fn seeded(seed: u64) -> Result<(Arc<Self>, Random), String> {
        println!("seed {seed}");
        Ok((Self::shared()?, Random::new(seed)))
    }

    /// Another device that tests share: unclipped depth, and 32 bits of depth beside a stencil. Pipelines are made once.
    pub fn shared_with_depth_features() -> Result<Arc<Self>, String> {
        Self::shared_with(1, wgpu::Features::DEPTH_CLIP_CONTROL | wgpu::Features::DEPTH32FLOAT_STENCIL8)
    }

    fn shared_with(number: usize, features: wgpu::Features) -> Result<Arc<Self>, String> {
        let mut shared = SHARED.lock().map_err(|error| error.to_string())?;
        let make = || Self::with(features, wgpu::Limits::default()).map(Arc::new);
        shared[number].get_or_insert_with(make).clone()
    }

    /// Lets go of the shared devices. A software driver that still has threads when the process exits may crash there.
    pub fn close() {
        if let Ok(mut shared) = SHARED.lock() {
            *shared = [None, None];
        }
    }

    /// The value that `make` made for this device when it was first asked for by its type and this name. Pipelines of
    /// tests are made once so: a software driver compiles for longer than it draws a picture.
    pub fn kept<T: Any + Send + Sync>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T, String>,
    ) -> Result<Arc<T>, String> {
        let key = (TypeId::of::<T>(), name.to_owned());
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let found = lock().get(&key).cloned();
        let kept = if let Some(kept) = found {
            kept
        } else {
            let made: Arc<dyn Any + Send + Sync> = Arc::new(make()?);
            // Another thread may have been faster.
            Arc::clone(lock().entry(key).or_insert(made))
        };
        kept.downcast().map_err(|_| format!("{name} is of another type"))
    }

    /// Buffers that live on this device's instance.
    pub fn live_buffers(&self) -> Result<usize, String> {
        let report = self.instance.generate_report().ok_or("no report of live objects")?;
        Ok(report.hub_report().buffers.num_allocated)
    }

    /// Pipelines, compute and render, that live on this device's instance.
    pub fn live_pipelines(&self) -> Result<usize, String> {
        let report = self.instance.generate_report().ok_or("no report of live objects")?;
        let report = report.hub_report();
        Ok(report.compute_pipelines.num_allocated + report.render_pipelines.num_allocated)
    }

    /// A storage buffer with these contents.
    pub fn storage<T: bytemuck::Pod>(&self, contents: &[T]) -> wgpu::Buffer {
        let bytes = bytemuck::cast_slice(contents);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("test"),
            size: (bytes.len() as u64).next_multiple_of(4).max(16),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// A buffer's first `count` items.
    pub fn read<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<T>, String> {
        let mut items =
            rimline::gpu::read_back_vec(&self.device, &self.queue, buffer).map_err(|error| error.to_string())?;
        items.truncate(count);
        Ok(items)
    }

    /// Polls the device and a future by turns, as an event loop does, on this one thread.
    pub fn finish<T>(&self, future: impl Future<Output = T>) -> Result<T, String> {
        let mut future = std::pin::pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        loop {
            if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
                return Ok(value);
            }
            self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
        }
    }

    /// Records with `record` and submits.
    pub fn submit<T>(&self, record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<T, String>) -> Result<T, String> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let recorded = record(&mut encoder)?;
        self.queue.submit([encoder.finish()]);
        Ok(recorded)
    }
}
