//! Measures the GPU time of each stage, on devices with timestamp queries.

use super::clock_check::{ClockCheck, LEAST_MS, load_ticks};
use super::device_error::DeviceError;
use super::dispatch_limits::is_software;
use super::memory::buffer;
use super::readback::{read_back_vec, read_back_vec_async};

/// The number of passes that a timer can hold. A query set has at most 4,096 queries, and a pass takes two.
const MOST: u32 = 2048;

/// Results of a [`StageTimer`].
#[derive(Clone, Debug, PartialEq)]
pub struct StageTimes {
    /// Name and time of each stage in milliseconds, summed over its passes, in the order first recorded.
    pub stages: Vec<(&'static str, f64)>,
    /// The time from the beginning of the first stage to the end of the last, in milliseconds. It includes gaps between
    /// stages.
    pub span_ms: f64,
}

/// Takes timestamps around the pass of each stage. The device needs `Features::TIMESTAMP_QUERY`.
///
/// On a software device ([`Self::is_software`]) the timestamps are the machine's clock, read by any of its threads. Mesa's
/// llvmpipe takes those of compute passes too late once the device has drawn anything. So reading runs a load of a few
/// milliseconds there, and checks its times.
///
/// Reading returns a [`DeviceError`] where the times have no meaning; [`DeviceError::is_clock`] is true for these. Measure
/// by a clock then.
#[derive(Debug)]
pub struct StageTimer {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pub(crate) device: wgpu::Device,
    period_ns: f32,
    names: Vec<&'static str>,
    /// On software devices.
    check: Option<ClockCheck>,
    /// Whether a compute pass was timed: the check concerns these.
    has_compute: bool,
}

impl StageTimer {
    /// Makes a timer. `None` if the device has no timestamp queries, or if a software device refuses the load that checks
    /// them.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let check = if is_software(device) { Some(ClockCheck::new(device)?) } else { None };
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        Some(Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stages"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * MOST,
            }),
            resolved: buffer(device, "stage timestamps", u64::from(2 * MOST) * 8, usage),
            device: device.clone(),
            period_ns: queue.get_timestamp_period(),
            names: Vec::new(),
            check,
            has_compute: false,
        })
    }

    /// Removes all recorded passes, so that the timer can be used for the next encoder.
    pub fn clear(&mut self) {
        self.names.clear();
        self.has_compute = false;
    }

    /// The timestamps for the next compute pass. It may be a stage's pass or one of the caller's own. `None` if the
    /// timer is full.
    pub fn compute_pass(&mut self, name: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let [begin, end] = self.next(name)?;
        self.has_compute = true;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }

    /// The timestamps for the next render pass, for example one that draws volumes. `None` if the timer is full.
    pub fn render_pass(&mut self, name: &'static str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let [begin, end] = self.next(name)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }

    /// The indices of the next pass's queries.
    fn next(&mut self, name: &'static str) -> Option<[Option<u32>; 2]> {
        let index = 2 * self.names.len() as u32;
        if index >= 2 * MOST {
            return None;
        }
        self.names.push(name);
        Some([Some(index), Some(index + 1)])
    }

    /// Records the copy that makes the timestamps readable. Call it after the stages, on the same encoder.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.set, 0..2 * self.names.len() as u32, &self.resolved, 0);
    }

    /// Whether the device is software. The times are then CPU times: other programs share the CPU, and stages may
    /// overlap. Use them for ratios at most.
    pub fn is_software(&self) -> bool {
        is_software(&self.device)
    }

    /// The name of each stage, in the order first recorded: those that [`Self::read`] gives times of.
    pub fn stages(&self) -> Vec<&'static str> {
        let mut stages = Vec::new();
        for &name in &self.names {
            if !stages.contains(&name) {
                stages.push(name);
            }
        }
        stages
    }

    /// The times of the stages. Call it after the encoder was submitted. It waits for the device. The timer has times of the
    /// first 2,048 passes only. An extraction has at most two passes for each chunk of the mesh and batch of 32 lights, or
    /// four for each batch if the mesh is of polygons by loop. Beside these it has at most four for each batch, and one more.
    ///
    /// # Errors
    /// [`DeviceError`] when the device is lost or the timestamps have no meaning.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<StageTimes, DeviceError> {
        let ticks: Vec<u64> = read_back_vec(device, queue, &self.resolved)?;
        let times = times(&self.names, &ticks, self.period_ns)?;
        if let Some(load) = self.submit_check(queue) {
            check_load(&read_back_vec(device, queue, load)?, self.period_ns)?;
        }
        Ok(times)
    }

    /// Submits the load that decides whether times of compute passes are valid, if there are such times.
    fn submit_check(&self, queue: &wgpu::Queue) -> Option<&wgpu::Buffer> {
        self.check.as_ref().filter(|_| self.has_compute).map(|check| check.submit(&self.device, queue))
    }

    /// The result of [`Self::read`], without waiting. [`read_back_async`](crate::gpu::read_back_async) says who polls the
    /// device. The timer may be cleared and used again at once.
    ///
    /// # Errors
    /// The errors of [`Self::read`].
    pub fn read_async(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> impl Future<Output = Result<StageTimes, DeviceError>> + use<> {
        let ticks = read_back_vec_async::<u64>(device, queue, &self.resolved);
        let load = self.submit_check(queue).map(|load| read_back_vec_async::<u64>(device, queue, load));
        let (names, period_ns) = (self.names.clone(), self.period_ns);
        async move {
            let times = times(&names, &ticks.await?, period_ns)?;
            if let Some(load) = load {
                check_load(&load.await?, period_ns)?;
            }
            Ok(times)
        }
    }
}

/// An error if the load took less time than it can.
fn check_load(ticks: &[u64], period_ns: f32) -> Result<(), DeviceError> {
    let ms = load_ticks(ticks) as f64 * f64::from(period_ns) / 1e6;
    if ms >= LEAST_MS { Ok(()) } else { Err(DeviceError::ClockLate { ms, least_ms: LEAST_MS }) }
}

/// Stages and span of passes, from the beginning and end of each. An error if they have no meaning.
fn times(names: &[&'static str], ticks: &[u64], period_ns: f32) -> Result<StageTimes, DeviceError> {
    let mut times = StageTimes { stages: Vec::new(), span_ms: 0.0 };
    let passes: Vec<[u64; 2]> = ticks.chunks_exact(2).map(|pair| [pair[0], pair[1]]).take(names.len()).collect();
    let Some(first) = passes.iter().map(|pass| pass[0]).min() else { return Ok(times) };
    if !(period_ns > 0.0 && period_ns.is_finite()) {
        return Err(DeviceError::TimestampPeriod { period: period_ns });
    }
    if let Some(pass) = passes.iter().position(|[begin, end]| end < begin) {
        return Err(DeviceError::ClockBackwards { pass, name: names[pass] });
    }
    let last = passes.iter().map(|pass| pass[1]).max().unwrap_or(first);
    if last == first {
        return Err(DeviceError::ClockStill { passes: passes.len() });
    }
    let milliseconds = |ticks: u64| ticks as f64 * f64::from(period_ns) / 1e6;
    times.span_ms = milliseconds(last - first);
    for (&name, [begin, end]) in names.iter().zip(passes) {
        let ms = milliseconds(end - begin);
        match times.stages.iter_mut().find(|(stage, _)| *stage == name) {
            Some((_, sum)) => *sum += ms,
            None => times.stages.push((name, ms)),
        }
    }
    Ok(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_a_stage_are_summed() {
        let found = times(&["a", "b", "a"], &[1000, 3000, 4000, 4500, 5000, 6000, 0, 0], 1000.0);
        let expected = StageTimes { stages: vec![("a", 3.0), ("b", 0.5)], span_ms: 5.0 };
        assert_eq!(found, Ok(expected));
    }

    #[test]
    fn nothing_timed_is_no_error() {
        assert_eq!(times(&[], &[0, 0], 0.0), Ok(StageTimes { stages: Vec::new(), span_ms: 0.0 }));
    }

    #[test]
    fn a_period_that_is_no_time_is_an_error() {
        for period in [0.0, -1.0, f32::INFINITY] {
            assert_eq!(times(&["a"], &[0, 9], period), Err(DeviceError::TimestampPeriod { period }));
        }
        assert!(matches!(times(&["a"], &[0, 9], f32::NAN), Err(DeviceError::TimestampPeriod { .. })));
    }

    #[test]
    fn a_load_that_took_no_time_is_an_error() {
        // Milliseconds of 1,000 ticks.
        assert_eq!(check_load(&[1000, 1100, 1100, 1200], 1000.0), Ok(()));
        for ticks in [[1000, 1099, 1099, 9000], [1000, 9000, 9000, 9000], [9000, 1000, 1000, 9000]] {
            assert!(matches!(check_load(&ticks, 1000.0), Err(DeviceError::ClockLate { .. })), "{ticks:?}");
        }
        assert!(check_load(&[], 1000.0).is_err());
    }

    #[test]
    fn a_clock_that_stands_still_or_runs_backwards_is_an_error() {
        assert_eq!(times(&["a", "b"], &[7, 7, 7, 7], 1.0), Err(DeviceError::ClockStill { passes: 2 }));
        assert_eq!(times(&["a", "b"], &[0; 4], 1.0), Err(DeviceError::ClockStill { passes: 2 }));
        assert_eq!(times(&["a", "b"], &[7, 8, 9, 8], 1.0), Err(DeviceError::ClockBackwards { pass: 1, name: "b" }));
        // A stage may be shorter than the clock's step, as long as some time passed.
        assert!(times(&["a", "b"], &[7, 7, 8, 8], 1.0).is_ok());
    }
}
