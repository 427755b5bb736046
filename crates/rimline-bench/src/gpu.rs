//! A device, and a stopwatch for the frames that run on it.

use std::time::Instant;

use bytemuck::Pod;
use rimline::gpu::{DeviceError, Pipelines, StageTimer, read_back_vec};
use wgpu::BufferUsages;

use crate::Error;
use crate::engine::{Metric, Sample, Summary};
use crate::pipelines::{pixels, texture};

/// An opened device. Its device, queue and pipelines are handles, which are cheap to clone.
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Shared by all that is made on the device.
    pub pipelines: Pipelines,
    /// The first error that the device reported outside error scopes, `None` for a device of [`Self::first`].
    pub reported: Box<dyn Fn() -> Option<String>>,
}

impl Gpu {
    /// Opens the default adapter of wgpu, for benches, with those of timestamp queries and `wanted` that it has. Returns
    /// the adapter's name, too.
    pub fn first(wanted: wgpu::Features) -> Result<(Self, String), Error> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let adapter = adapter.map_err(Error::device)?;
        let offered = adapter.limits();
        let descriptor = wgpu::DeviceDescriptor {
            required_features: adapter.features() & (wanted | wgpu::Features::TIMESTAMP_QUERY),
            required_limits: wgpu::Limits {
                max_buffer_size: offered.max_buffer_size,
                max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
                ..wgpu::Limits::default()
            },
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened.map_err(Error::device)?;
        let pipelines = Pipelines::new(&device);
        Ok((Self { device, queue, pipelines, reported: Box::new(|| None) }, adapter.get_info().name))
    }

    pub fn wait(&self) -> Result<(), Error> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        polled.map(drop).map_err(Error::device)
    }

    pub fn check(&self) -> Result<(), Error> {
        (self.reported)().map_or(Ok(()), |error| Err(Error::Device(error)))
    }

    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    pub fn buffer<T: Pod>(&self, usage: BufferUsages, contents: &[T]) -> wgpu::Buffer {
        let bytes = bytemuck::cast_slice(contents);
        let buffer = self.empty(usage | BufferUsages::COPY_DST, bytes.len() as u64);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    pub fn empty(&self, usage: BufferUsages, bytes: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("bench"),
            size: bytes.next_multiple_of(4).max(16),
            usage,
            mapped_at_creation: false,
        })
    }

    pub fn read<T: Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, DeviceError> {
        read_back_vec(&self.device, &self.queue, buffer)
    }

    pub fn read_planes<T: Pod>(&self, buffers: &[wgpu::Buffer], items: usize) -> Result<Vec<T>, DeviceError> {
        let mut all = Vec::new();
        for buffer in buffers {
            // A buffer may be longer than what it holds.
            all.extend(self.read::<T>(buffer)?.into_iter().take(items));
        }
        Ok(all)
    }

    pub fn texture(&self, size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::TextureView {
        texture(&self.device, size, format)
    }

    /// The pixels of a texture, row by row, after what `record` records has run.
    pub fn pixels(
        &self,
        view: &wgpu::TextureView,
        aspect: wgpu::TextureAspect,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<(), Error>,
    ) -> Result<Vec<u8>, Error> {
        let mut encoder = self.encoder();
        record(&mut encoder)?;
        let pixels = pixels((&self.device, &self.queue), encoder, view, aspect);
        self.check()?;
        Ok(pixels?)
    }

    /// Bytes that the device has allocated in buffers and textures, where its backend tells.
    pub fn allocated_bytes(&self) -> Result<Option<u64>, Error> {
        // Waiting frees the resources that were dropped.
        self.wait()?;
        Ok(self.device.generate_allocator_report().map(|report| report.total_allocated_bytes))
    }

    /// GB/s of a copy from buffer to buffer, bytes read and written both counted.
    pub fn copy_bandwidth(&self) -> Result<f64, Error> {
        // Small devices allow smaller buffers only. Copies are of whole words.
        let bytes = (64 << 20).min(self.device.limits().max_buffer_size) & !3;
        let [from, to] = [BufferUsages::COPY_SRC, BufferUsages::COPY_DST].map(|usage| self.empty(usage, bytes));
        let mut times = Vec::new();
        for _ in 0..=5 {
            let begin = Instant::now();
            let mut encoder = self.encoder();
            // Several, so that the submission itself takes little of the time.
            for _ in 0..8 {
                encoder.copy_buffer_to_buffer(&from, 0, &to, 0, bytes);
            }
            self.queue.submit([encoder.finish()]);
            self.wait()?;
            times.push(begin.elapsed().as_secs_f64());
        }
        // The first round is a warm-up.
        let median = Summary::of(times.drain(1..)).map_or(f64::NAN, |summary| summary.median);
        Ok(8.0 * 2.0 * bytes as f64 / median / 1e9)
    }
}

/// Names and milliseconds.
type Passes = Vec<(&'static str, f64)>;

/// Times of a frame that was recorded and run.
pub struct Timed {
    pub recording_ms: f64,
    /// By the clock, from the submission to the end of the work.
    pub clock_ms: f64,
    /// From the first pass's beginning to the last one's end by timestamps, or `clock_ms`: without timestamps, and for
    /// [`Stopwatch::frame`] on software.
    pub whole_ms: f64,
    pub has_stamps: bool,
    /// Passes by timestamps. Without them, parts of [`Stopwatch::frame`] by the clock.
    passes: Passes,
}

impl Timed {
    /// The sum over passes or parts whose names are chosen.
    pub fn of(&self, chosen: impl Fn(&str) -> bool) -> f64 {
        self.passes.iter().filter(|(name, _)| chosen(name)).map(|(_, ms)| ms).sum()
    }

    pub fn stages(&self) -> Sample {
        self.passes.iter().map(|&(name, ms)| (Metric::Stage(name), ms)).collect()
    }
}

/// The timer of compute stages on a device that draws. On software there is none, see [`Stopwatch`].
pub fn beside_draws(timer: Option<&mut StageTimer>) -> Option<&mut StageTimer> {
    timer.filter(|timer| !timer.is_software())
}

/// Records frames and runs them on one device.
///
/// On Mesa's software device the timestamps of compute passes are taken too late once the device has drawn anything, and
/// the timer refuses them. So stages are timed on a device on which nothing is drawn, and [`beside_draws`] leaves them
/// out elsewhere.
pub struct Stopwatch<'a> {
    pub gpu: &'a Gpu,
    /// `None`: times are by the clock.
    timer: Option<StageTimer>,
}

impl<'a> Stopwatch<'a> {
    pub fn new(gpu: &'a Gpu) -> Self {
        Self { gpu, timer: StageTimer::new(&gpu.device, &gpu.queue) }
    }

    /// Runs what `record` records, and waits for it.
    pub fn timed(
        &mut self,
        record: impl FnOnce(&mut wgpu::CommandEncoder, Option<&mut StageTimer>) -> Result<(), Error>,
    ) -> Result<Timed, Error> {
        let begin = Instant::now();
        let mut encoder = self.gpu.encoder();
        if let Some(timer) = &mut self.timer {
            timer.clear();
        }
        record(&mut encoder, self.timer.as_mut())?;
        if let Some(timer) = &self.timer {
            timer.resolve(&mut encoder);
        }
        let commands = encoder.finish();
        let recorded = Instant::now();
        self.gpu.queue.submit([commands]);
        self.gpu.wait()?;
        let clock_ms = recorded.elapsed().as_secs_f64() * 1e3;
        let recording_ms = (recorded - begin).as_secs_f64() * 1e3;
        let stamps = self.read()?;
        let has_stamps = stamps.is_some();
        let (passes, whole_ms) = stamps.unwrap_or_else(|| (Vec::new(), clock_ms));
        Ok(Timed { recording_ms, clock_ms, whole_ms, has_stamps, passes })
    }

    /// Runs a frame of parts. `record` records the part of a name, and times passes that draw under that name. Without
    /// timestamps the parts are run and timed one by one. On software [`Timed::whole_ms`] is by the clock.
    pub fn frame(
        &mut self,
        parts: &[&'static str],
        mut record: impl FnMut(&mut wgpu::CommandEncoder, &'static str, Option<&mut StageTimer>) -> Result<(), Error>,
    ) -> Result<Timed, Error> {
        if let Some(is_software) = self.timer.as_ref().map(StageTimer::is_software) {
            let mut all = self.timed(|encoder, mut timer| {
                parts.iter().try_for_each(|part| record(encoder, part, timer.as_deref_mut()))
            })?;
            if all.has_stamps {
                all.whole_ms = if is_software { all.clock_ms } else { all.whole_ms };
                return Ok(all);
            }
        }
        let mut sums = [0.0; 2];
        let mut passes = Vec::new();
        for &part in parts {
            let times = self.by_clock(|encoder| record(encoder, part, None))?;
            passes.push((part, times[1]));
            sums.iter_mut().zip(times).for_each(|(sum, ms)| *sum += ms);
        }
        let [recording_ms, clock_ms] = sums;
        Ok(Timed { recording_ms, clock_ms, whole_ms: clock_ms, has_stamps: false, passes })
    }

    /// The same as [`Self::timed`] without timestamps. Returns [`Timed::recording_ms`] and [`Timed::clock_ms`].
    pub fn by_clock(
        &self,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<(), Error>,
    ) -> Result<[f64; 2], Error> {
        let timed = Stopwatch { gpu: self.gpu, timer: None }.timed(|encoder, _| record(encoder))?;
        Ok([timed.recording_ms, timed.clock_ms])
    }

    /// Passes and the time from the first to the last. `None` without a timer. Timestamps without meaning remove the timer.
    fn read(&mut self) -> Result<Option<(Passes, f64)>, Error> {
        let Some(timer) = &self.timer else { return Ok(None) };
        let Gpu { device, queue, .. } = self.gpu;
        match timer.read(device, queue) {
            Ok(times) => Ok(Some((times.stages, times.span_ms))),
            Err(error) if error.is_clock() => {
                self.timer = None;
                Ok(None)
            }
            Err(error) => Err(error.into()),
        }
    }
}
