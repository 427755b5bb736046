//! GPU time a stage, where the device has timestamp queries.

use super::readback::{ReadError, read_back_vec};

/// Passes that one timer can hold: a query set has at most 4,096 queries, two a pass.
const MOST: u32 = 2048;

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

    /// The timestamps of a compute pass to come, a stage's or one of the caller's own; `None` once the timer is full.
    pub fn compute_pass(&mut self, name: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let [begin, end] = self.next(name)?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }

    /// The timestamps of a render pass to come, such as the one that draws the volumes; `None` once the timer is full.
    pub fn render_pass(&mut self, name: &'static str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let [begin, end] = self.next(name)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }

    /// Indices of the next pass's queries.
    fn next(&mut self, name: &'static str) -> Option<[Option<u32>; 2]> {
        let index = 2 * self.names.len() as u32;
        if index >= 2 * MOST {
            return None;
        }
        self.names.push(name);
        Some([Some(index), Some(index + 1)])
    }

    /// Records that the timestamps be made readable; call it after the stages, on the same encoder.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.set, 0..2 * self.names.len() as u32, &self.resolved, 0);
    }

    /// Name and milliseconds of each stage, summed over its passes, in the order first recorded; after the encoder was
    /// submitted. Waits for the device. More than 2,048 passes are not timed: an extraction has at most two a chunk of
    /// the mesh and word of 32 lights, four a word and one more.
    ///
    /// # Errors
    /// [`ReadError`] when the device is lost.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<(&'static str, f64)>, ReadError> {
        let ticks = self.read_ticks(device, queue)?;
        let spans = ticks.chunks_exact(2).map(|pair| pair[1].saturating_sub(pair[0]) as f64 * self.period_ns / 1e6);
        let mut stages: Vec<(&'static str, f64)> = Vec::new();
        for (&name, ms) in self.names.iter().zip(spans) {
            match stages.iter_mut().find(|(stage, _)| *stage == name) {
                Some((_, sum)) => *sum += ms,
                None => stages.push((name, ms)),
            }
        }
        Ok(stages)
    }

    /// Milliseconds from the beginning of the first stage to the end of the last, what lies between stages included; as
    /// [`Self::read`] otherwise.
    ///
    /// # Errors
    /// [`ReadError`] when the device is lost.
    pub fn read_span(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<f64, ReadError> {
        let ticks = self.read_ticks(device, queue)?;
        let pairs = ticks.chunks_exact(2).take(self.names.len());
        let first = pairs.clone().map(|pair| pair[0]).min().unwrap_or(0);
        let last = pairs.map(|pair| pair[1]).max().unwrap_or(0);
        Ok(last.saturating_sub(first) as f64 * self.period_ns / 1e6)
    }

    /// A beginning and an end for each pass.
    fn read_ticks(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<u64>, ReadError> {
        read_back_vec(device, queue, &self.resolved)
    }
}
