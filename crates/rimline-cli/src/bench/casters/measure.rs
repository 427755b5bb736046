//! CPU time of recording a frame, GPU time of its stages and draws, and memory.

use std::time::Instant;

use rimline::gpu::{DeviceError, ShadowFormat, StageTimer};
use rimline::wgpu;
use wgpu::{LoadOp, Operations, StoreOp, TextureFormat, TextureUsages};

use super::field::LIGHTS;
use super::recorder::{DrawPipelines, Recorder, Until};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// A format that every device has.
pub(in super::super) const DEPTH: TextureFormat = TextureFormat::Depth24PlusStencil8;
/// The passes that draw, as the timer has them.
pub(in super::super) const STENCIL: &str = "stencil";
/// The stages that extract, of a scene and of a single mesh.
const EXTRACTION: [&str; 6] = ["reach", "chunks", "facing", "exact_facing", "edges", "arguments"];

/// Milliseconds of the GPU for the compute stages of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StageTimes {
    /// The stages that find silhouettes.
    pub(crate) extraction_ms: f64,
    /// The stages that find silhouettes, and those that prepare volumes.
    pub(crate) all_ms: f64,
}

/// Milliseconds of the GPU for a frame with draws.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DrawTimes {
    /// The stencil passes of all lights.
    pub(crate) stencil_ms: f64,
    /// From the first stage's beginning to the last pass's end.
    pub(crate) frame_ms: f64,
}

/// The milliseconds of each stage, and from the first stage's beginning to the last one's end.
pub(in super::super) type Timestamps = (Vec<(&'static str, f64)>, f64);

/// Times of a frame that was recorded and run.
pub(in super::super) struct Timed {
    /// Milliseconds of the CPU for recording.
    pub(in super::super) recording_ms: f64,
    /// By the clock, from the submission on.
    pub(in super::super) clock_ms: f64,
    /// Times of the passes. `None` without a timer.
    pub(in super::super) times: Option<Timestamps>,
}

/// Records frames and runs them on one device.
///
/// On Mesa's software device the timestamps of compute passes mean nothing once the device has drawn anything: each is
/// taken when the next one is asked for. So stages are timed on a device of their own, on which nothing is drawn.
pub(in super::super) struct Stopwatch<'a> {
    pub(in super::super) gpu: &'a Gpu,
    pub(in super::super) pipelines: DrawPipelines,
    /// `None`: times are by the clock.
    timer: Option<StageTimer>,
}

impl<'a> Stopwatch<'a> {
    pub(in super::super) fn new(gpu: &'a Gpu) -> Result<Self, Failure> {
        let format = ShadowFormat { depth_stencil: DEPTH, ..ShadowFormat::default() };
        let pipelines = DrawPipelines::new(gpu, &format).map_err(|error| error.on(gpu))?;
        Ok(Self { gpu, pipelines, timer: StageTimer::new(&gpu.device, &gpu.queue) })
    }

    /// A depth buffer, so many pixels across and down.
    pub(in super::super) fn depth(&self, size: u32) -> wgpu::TextureView {
        let depth = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("depth"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        depth.create_view(&wgpu::TextureViewDescriptor::default())
    }

    pub(in super::super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Milliseconds of the CPU for `change` and for recording a frame. The frame is then run and waited for.
    pub(super) fn recording<R: Recorder>(
        &self,
        recorder: &mut R,
        change: impl FnOnce(&mut R) -> Result<(), GpuError>,
    ) -> Result<f64, Failure> {
        let mut encoder = self.encoder();
        let begin = Instant::now();
        let recorded = change(recorder).and_then(|()| recorder.encode(&mut encoder, Until::Volumes, None));
        recorded.map_err(|error| error.on(self.gpu))?;
        let commands = encoder.finish();
        let ms = begin.elapsed().as_secs_f64() * 1e3;
        self.run(commands)?;
        Ok(ms)
    }

    /// Runs the stages. Returns the milliseconds by the clock from the submission on.
    pub(super) fn stages_by_clock(&self, recorder: &mut dyn Recorder, until: Until) -> Result<f64, Failure> {
        let mut encoder = self.encoder();
        recorder.encode(&mut encoder, until, None).map_err(|error| error.on(self.gpu))?;
        self.run(encoder.finish())
    }

    /// Submits and waits. Returns the milliseconds that this took.
    pub(in super::super) fn run(&self, commands: wgpu::CommandBuffer) -> Result<f64, Failure> {
        let begin = Instant::now();
        self.gpu.queue.submit([commands]);
        self.gpu.wait()?;
        Ok(begin.elapsed().as_secs_f64() * 1e3)
    }

    /// Whether passes have times of their own.
    pub(in super::super) fn has_timer(&self) -> bool {
        self.timer.is_some()
    }

    /// Runs what `record` records, and waits for it.
    pub(in super::super) fn timed(
        &mut self,
        record: impl FnOnce(&mut wgpu::CommandEncoder, Option<&mut StageTimer>, &DrawPipelines) -> Result<(), GpuError>,
    ) -> Result<Timed, Failure> {
        let begin = Instant::now();
        let mut encoder = self.encoder();
        if let Some(timer) = &mut self.timer {
            timer.clear();
        }
        record(&mut encoder, self.timer.as_mut(), &self.pipelines).map_err(|error| error.on(self.gpu))?;
        if let Some(timer) = &self.timer {
            timer.resolve(&mut encoder);
        }
        let commands = encoder.finish();
        let recording_ms = begin.elapsed().as_secs_f64() * 1e3;
        let clock_ms = self.run(commands)?;
        Ok(Timed { recording_ms, clock_ms, times: self.read()? })
    }

    /// Times of the stages.
    pub(super) fn stages(&mut self, recorder: &mut dyn Recorder, until: Until) -> Result<StageTimes, Failure> {
        if self.timer.is_some() {
            let Timed { times, .. } = self.timed(|encoder, timer, _| recorder.encode(encoder, until, timer))?;
            if let Some((stages, _)) = times {
                return Ok(StageTimes::of(&stages));
            }
        }
        let extraction_ms = self.stages_by_clock(recorder, Until::Extraction)?;
        let all_ms = if until == Until::Volumes { self.stages_by_clock(recorder, until)? } else { extraction_ms };
        Ok(StageTimes { extraction_ms, all_ms })
    }

    /// Times of a frame with draws.
    pub(super) fn draws(
        &mut self,
        recorder: &mut dyn Recorder,
        depth: &wgpu::TextureView,
    ) -> Result<DrawTimes, Failure> {
        let stages_ms = if self.timer.is_some() { 0.0 } else { self.stages_by_clock(recorder, Until::Volumes)? };
        let Timed { clock_ms, times, .. } = self.timed(|encoder, mut timer, pipelines| {
            recorder.encode(encoder, Until::Volumes, timer.as_deref_mut())?;
            for light in 0..LIGHTS {
                // Depth is reversed: 0 is farthest.
                let mut pass = stencil_pass(encoder, depth, LoadOp::Clear(0.0), timer.as_deref_mut(), None);
                recorder.draw(&mut pass, pipelines, light)?;
            }
            Ok(())
        })?;
        let by_clock = DrawTimes { stencil_ms: (clock_ms - stages_ms).max(0.0), frame_ms: clock_ms };
        let Some((stages, span_ms)) = times else { return Ok(by_clock) };
        let stencil_ms = stages.iter().filter(|(name, _)| *name == STENCIL).map(|(_, ms)| ms).sum();
        let is_software = self.timer.as_ref().is_some_and(StageTimer::is_software);
        Ok(DrawTimes { stencil_ms, frame_ms: if is_software { clock_ms } else { span_ms } })
    }

    /// Times of the stages and their span. `None` without a timer, and from the first timestamps on that mean nothing.
    fn read(&mut self) -> Result<Option<Timestamps>, Failure> {
        let Some(timer) = &self.timer else { return Ok(None) };
        let Gpu { device, queue, .. } = self.gpu;
        match timer.read(device, queue).and_then(|stages| Ok((stages, timer.read_span(device, queue)?))) {
            Ok(times) => Ok(Some(times)),
            Err(
                DeviceError::TimestampPeriod { .. }
                | DeviceError::ClockStill { .. }
                | DeviceError::ClockBackwards { .. },
            ) => {
                self.timer = None;
                Ok(None)
            }
            Err(error) => Err(GpuError::from(error).on(self.gpu)),
        }
    }
}

/// A pass that counts the volumes of a light, from 0 on. `queries` are for the caller's own.
pub(in super::super) fn stencil_pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    depth: &wgpu::TextureView,
    load: LoadOp<f32>,
    timer: Option<&mut StageTimer>,
    queries: Option<&wgpu::QuerySet>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(STENCIL),
        color_attachments: &[],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(Operations { load, store: StoreOp::Store }),
            stencil_ops: Some(Operations { load: LoadOp::Clear(0), store: StoreOp::Store }),
        }),
        timestamp_writes: timer.and_then(|timer| timer.render_pass(STENCIL)),
        occlusion_query_set: queries,
        multiview_mask: None,
    })
}

impl StageTimes {
    fn of(stages: &[(&'static str, f64)]) -> Self {
        let extraction = stages.iter().filter(|(name, _)| EXTRACTION.contains(name));
        Self { extraction_ms: extraction.map(|(_, ms)| ms).sum(), all_ms: stages.iter().map(|(_, ms)| ms).sum() }
    }
}

/// Bytes that the device has allocated in buffers and textures, where its backend tells.
pub(super) fn allocated_bytes(gpu: &Gpu) -> Result<Option<u64>, Failure> {
    // Waiting frees the resources that were dropped.
    gpu.wait()?;
    Ok(gpu.device.generate_allocator_report().map(|report| report.total_allocated_bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extraction_is_a_part_of_all_stages() {
        let stages = [("reach", 1.0), ("facing", 2.0), ("choose", 4.0), ("caps", 8.0)];
        assert_eq!(StageTimes::of(&stages), StageTimes { extraction_ms: 3.0, all_ms: 15.0 });
    }

    #[test]
    fn the_stages_of_extraction_are_stages() {
        let all = rimline::reference::stages::STAGES;
        for name in EXTRACTION {
            assert!(all.iter().any(|stage| stage.name == name), "{name}");
        }
    }
}
