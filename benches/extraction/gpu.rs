//! GPU contenders.

use rimline::gpu::{Extractor, ExtractorOptions, ListOptions, PositionBuffer, StageTimer};
use rimline::{Light, Mesh, Method, Predicate};

use crate::measure::{Contender, Times, interleave, wall_ms};

/// A device with every feature and limit that helps measuring.
pub(crate) struct Gpu {
    pub(crate) name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// One method's times for one mesh and number of lights.
pub(crate) struct Row {
    pub(crate) name: String,
    /// By the wall clock, from recording to the device's being done.
    pub(crate) wall: Times,
    /// Median GPU milliseconds a stage, where the device has timestamps.
    pub(crate) stages: Vec<(&'static str, f64)>,
    /// Bytes that the method must move an edge, at least.
    pub(crate) bytes_per_edge: f64,
}

impl Gpu {
    pub(crate) fn new() -> Option<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        }));
        let adapter = adapter.ok()?;
        let info = adapter.get_info();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("bench"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .ok()?;
        let name = format!("{} ({}, {:?})", info.name, info.driver_info, info.backend);
        Some(Self { name, device, queue })
    }

    fn run(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> f64 {
        wall_ms(|| {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record(&mut encoder);
            self.queue.submit([encoder.finish()]);
            self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device works");
        })
    }

    fn storage(&self, bytes: &[u8]) -> wgpu::Buffer {
        let buffer = self.scratch(bytes.len() as u64);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    fn scratch(&self, size: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("bench"),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// GB/s of a copy from buffer to buffer, read and written bytes counted.
    pub(crate) fn copy_bandwidth(&self, rounds: usize) -> f64 {
        const BYTES: u64 = 64 << 20;
        let (from, to) = (self.scratch(BYTES), self.scratch(BYTES));
        let copy = || self.run(|encoder| encoder.copy_buffer_to_buffer(&from, 0, &to, 0, BYTES));
        let times = interleave(rounds, vec![("copy".to_owned(), Box::new(copy))]);
        2.0 * BYTES as f64 / times[0].1.median() / 1e6
    }

    /// Face masks and the 2003 method, with lists and with masks only.
    pub(crate) fn methods(&self, positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light], rounds: usize) -> Vec<Row> {
        let buffer = self.storage(bytemuck::cast_slice(positions));
        let lists = |ordered| Some(ListOptions { ordered, ..ListOptions::default() });
        let exact = ExtractorOptions { max_lights: lights.len(), ..Default::default() };
        let per_edge = ExtractorOptions { method: Method::PerEdge, ..exact };
        let fast = ExtractorOptions { predicate: Predicate::Fast, ..exact };
        // What each must move an edge, if every vertex and mask is fetched once: half a vertex and two thirds of a face.
        let face = (12.0 + 4.0) * 2.0 / 3.0 + 4.0;
        let with = |base: ExtractorOptions, lists, masks| ExtractorOptions { lists, masks, ..base };
        let read = face + 8.0 + 4.0 * 2.0 / 3.0;
        let setups = [
            ("per-edge, list", with(per_edge, lists(false), false), 16.0 + 4.0),
            ("face-mask fast, list", with(fast, lists(false), false), read),
            ("face-mask exact, list", with(exact, lists(false), false), read),
            ("face-mask exact, ordered", with(exact, lists(true), false), read + 24.0),
            ("per-edge, masks", with(per_edge, None, true), 16.0 + 4.0 + 8.0),
            ("face-mask exact, masks", with(exact, None, true), read + 8.0),
        ];
        let mut extractors: Vec<_> = setups
            .iter()
            .map(|(_, options, _)| Extractor::new(&self.device, mesh, *options).expect("the mesh fits the device"))
            .collect();
        let mut timers: Vec<_> = setups.iter().map(|_| StageTimer::new(&self.device, &self.queue)).collect();
        let contenders: Vec<Contender<'_>> = setups
            .iter()
            .zip(extractors.iter_mut().zip(&mut timers))
            .map(|((name, ..), (extractor, timer))| {
                let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
                let run = move || {
                    self.run(|encoder| {
                        if let Some(timer) = timer.as_mut() {
                            timer.clear();
                        }
                        extractor.encode(encoder, positions, lights, timer.as_mut()).expect("good lights");
                        if let Some(timer) = timer.as_ref() {
                            timer.resolve(encoder);
                        }
                    })
                };
                ((*name).to_owned(), Box::new(run) as Box<dyn FnMut() -> f64>)
            })
            .collect();
        let times = interleave(rounds, contenders);
        let rows = times.into_iter().zip(setups).zip(&timers);
        rows.map(|(((name, wall), (.., bytes_per_edge)), timer)| {
            let stages = timer.as_ref().and_then(|timer| timer.read(&self.device, &self.queue).ok());
            Row { name, wall, stages: stages.unwrap_or_default(), bytes_per_edge }
        })
        .collect()
    }
}
