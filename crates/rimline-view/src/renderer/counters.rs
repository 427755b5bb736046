//! Numbers of a frame, read back without waiting for the device.

use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll, Waker};

use rimline::gpu::{
    DeviceError, SceneFrame, SceneStatistics, ShadowStatistics, StageTimer, StageTimes, read_back_vec_async,
};

use super::gpu::Gpu;

type Pending<T> = Pin<Box<dyn Future<Output = Result<T, DeviceError>>>>;

/// Numbers of the last frame that was read back.
#[derive(Clone, Debug, Default)]
pub struct Counters {
    /// Counters of work that was done and work that was left out.
    pub scene: Option<SceneStatistics>,
    /// The same of shadow volumes.
    pub shadow: Option<ShadowStatistics>,
    /// Names and times of the stages in milliseconds, or why there are none. `None`: they are not measured, or
    /// have yet to arrive.
    pub stages: Option<Result<StageTimes, String>>,
    /// Bytes of textures and models that the viewer made.
    pub bytes: u64,
    /// Bytes of everything on the device, the scene's tables, lists and volumes included. `None`: only Vulkan and Direct3D 12
    /// say it.
    pub device_bytes: Option<u64>,
}

/// Copies that are on their way.
#[derive(Default)]
pub(super) struct Readings {
    scene: Option<Pending<Vec<u32>>>,
    shadow: Option<Pending<Vec<u32>>>,
    stages: Option<Pending<StageTimes>>,
    /// Whether the last frame was timed.
    is_timed: bool,
}

impl Readings {
    /// Whether something is on its way.
    pub(super) fn are_pending(&self) -> bool {
        self.scene.is_some() || self.shadow.is_some() || self.stages.is_some()
    }

    /// Begins to read the numbers of a frame that was submitted, unless earlier ones are still on their way.
    pub(super) fn begin(&mut self, gpu: &Gpu, frame: &SceneFrame, timer: Option<&StageTimer>) {
        let read = |buffer| Box::pin(read_back_vec_async::<u32>(&gpu.device, &gpu.queue, buffer)) as Pending<_>;
        if self.scene.is_none() && self.shadow.is_none() {
            self.scene = Some(read(frame.statistics()));
            self.shadow = frame.shadow_statistics().map(read);
        }
        self.is_timed = timer.is_some();
        if let Some(timer) = timer.filter(|_| self.stages.is_none()) {
            self.stages = Some(Box::pin(timer.read_async(&gpu.device, &gpu.queue)));
        }
    }

    /// Takes what has arrived. Returns whether something did.
    pub(super) fn poll(&mut self, gpu: &Gpu, counters: &mut Counters) -> bool {
        // A lost device gives none, and is noticed elsewhere.
        if !self.are_pending() || gpu.is_lost() {
            return false;
        }
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        let (scene, shadow, stages) = (taken(&mut self.scene), taken(&mut self.shadow), taken(&mut self.stages));
        let has_arrived = scene.is_some() || shadow.is_some() || stages.is_some();
        if let Some(Ok(words)) = scene {
            counters.scene = first(&words);
        }
        if let Some(Ok(words)) = shadow {
            counters.shadow = first(&words);
        }
        // Times may arrive after they were switched off.
        if let Some(times) = stages.filter(|_| self.is_timed) {
            counters.stages = Some(times.map_err(|error| error.to_string()));
        }
        has_arrived
    }
}

/// The result of a copy that has arrived.
fn taken<T>(pending: &mut Option<Pending<T>>) -> Option<Result<T, DeviceError>> {
    let mut context = Context::from_waker(Waker::noop());
    match pending.as_mut()?.as_mut().poll(&mut context) {
        Poll::Ready(result) => {
            *pending = None;
            Some(result)
        }
        Poll::Pending => None,
    }
}

/// The value that words begin with.
fn first<T: bytemuck::Pod>(words: &[u32]) -> Option<T> {
    let bytes: &[u8] = bytemuck::cast_slice(words);
    bytes.get(..size_of::<T>()).map(bytemuck::pod_read_unaligned)
}
