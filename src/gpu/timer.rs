//! GPU time a stage, where the device has timestamp queries.

use super::readback::{ReadError, read_back_vec};

/// Stages that one timer can hold.
const MOST: u32 = 64;

/// Takes timestamps around each stage's pass. Needs `Features::TIMESTAMP_QUERY`.
#[derive(Debug)]
pub struct StageTimer {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    period_ns: f64,
    names: Vec<&'static str>,
}

impl StageTimer {
    /// A timer, or `None` where the device has no timestamp queries.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stages"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * MOST,
            }),
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stage timestamps"),
                size: u64::from(2 * MOST) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            period_ns: f64::from(queue.get_timestamp_period()),
            names: Vec::new(),
        })
    }

    /// Forgets what was timed, for the next encoder.
    pub fn clear(&mut self) {
        self.names.clear();
    }

    /// The timestamps of the next pass; `None` once the timer is full.
    pub(super) fn writes(&mut self, name: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let index = 2 * self.names.len() as u32;
        if index >= 2 * MOST {
            return None;
        }
        self.names.push(name);
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(index),
            end_of_pass_write_index: Some(index + 1),
        })
    }

    /// Records that the timestamps be made readable; call it after the stages, on the same encoder.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.set, 0..2 * self.names.len() as u32, &self.resolved, 0);
    }

    /// Name and milliseconds of each stage, in the order recorded; after the encoder was submitted. Waits for the device.
    ///
    /// # Errors
    /// [`ReadError`] when the device is lost.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<(&'static str, f64)>, ReadError> {
        let ticks: Vec<u64> = read_back_vec(device, queue, &self.resolved)?;
        let spans = ticks.chunks_exact(2).map(|pair| pair[1].saturating_sub(pair[0]) as f64 * self.period_ns / 1e6);
        Ok(self.names.iter().copied().zip(spans).collect())
    }
}
