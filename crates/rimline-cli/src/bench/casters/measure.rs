//! CPU time of recording a frame, GPU time of a recorded one, and memory.

use std::time::Instant;

use rimline::gpu::{ShadowFormat, StageTimer, TimerError};
use rimline::wgpu;
use wgpu::{LoadOp, Operations, StoreOp, TextureFormat, TextureUsages};

use super::field::LIGHTS;
use super::recorder::{DrawPipelines, Recorder, Until};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// What every device has.
const DEPTH: TextureFormat = TextureFormat::Depth24PlusStencil8;
/// The passes that draw, as the timer has them.
const STENCIL: &str = "stencil";
/// The stages that extract, of a scene and of a single mesh.
const EXTRACTION: [&str; 6] = ["reach", "chunks", "facing", "exact_facing", "edges", "arguments"];

/// Milliseconds of the GPU for a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FrameTimes {
    /// The stages that find silhouettes.
    pub(crate) extraction_ms: f64,
    /// Those and the stages that prepare volumes.
    pub(crate) stages_ms: f64,
    /// The stencil passes of all lights.
    pub(crate) draws_ms: f64,
    /// From the first stage's beginning to the last pass's end.
    pub(crate) frame_ms: f64,
}

/// Records frames and runs them.
pub(super) struct Stopwatch<'a> {
    gpu: &'a Gpu,
    pub(super) pipelines: DrawPipelines,
    /// Depths without any surface.
    depth_view: wgpu::TextureView,
    /// `None`: times are by the clock.
    timer: Option<StageTimer>,
}

impl<'a> Stopwatch<'a> {
    /// `size` is the number of pixels across and down.
    pub(super) fn new(gpu: &'a Gpu, size: u32) -> Result<Self, Failure> {
        let format = ShadowFormat { depth_stencil: DEPTH, ..ShadowFormat::default() };
        let pipelines = DrawPipelines::new(gpu, &format).map_err(|error| error.on(gpu))?;
        let depth = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("depth"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let depth_view = depth.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self { gpu, pipelines, depth_view, timer: StageTimer::new(&gpu.device, &gpu.queue) })
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
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

    /// Runs a frame without draws.
    pub(super) fn warm_up(&self, recorder: &mut impl Recorder, until: Until) -> Result<(), Failure> {
        let mut encoder = self.encoder();
        recorder.encode(&mut encoder, until, None).map_err(|error| error.on(self.gpu))?;
        self.run(encoder.finish())
    }

    fn run(&self, commands: wgpu::CommandBuffer) -> Result<(), Failure> {
        self.gpu.queue.submit([commands]);
        self.gpu.wait()
    }

    /// Times of a frame; without a view only those of extraction.
    pub(super) fn frame(&mut self, recorder: &mut dyn Recorder, until: Until) -> Result<FrameTimes, Failure> {
        if let Some(mut timer) = self.timer.take() {
            match self.timed(recorder, until, &mut timer) {
                Err(GpuError::Timer(TimerError::Read(error))) => return Err(GpuError::from(error).on(self.gpu)),
                // Timestamps that mean nothing, now or ever: the clock's time is left.
                Err(GpuError::Timer(_)) => {}
                Ok(times) => {
                    self.timer = Some(timer);
                    return Ok(times);
                }
                Err(error) => return Err(error.on(self.gpu)),
            }
        }
        self.clocked(recorder, until)
    }

    fn timed(&self, recorder: &mut dyn Recorder, until: Until, timer: &mut StageTimer) -> Result<FrameTimes, GpuError> {
        let Self { gpu, .. } = self;
        timer.clear();
        let mut encoder = self.encoder();
        recorder.encode(&mut encoder, until, Some(timer))?;
        if until == Until::Volumes {
            self.draw(&mut encoder, recorder, Some(timer))?;
        }
        timer.resolve(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        let stages = timer.read(&gpu.device, &gpu.queue)?;
        Ok(FrameTimes { frame_ms: timer.read_span(&gpu.device, &gpu.queue)?, ..FrameTimes::of(&stages) })
    }

    /// By the clock. Each time is of a submission of its own, from the first stage on.
    fn clocked(&self, recorder: &mut dyn Recorder, until: Until) -> Result<FrameTimes, Failure> {
        let submitted = |recorder: &mut dyn Recorder, until: Until, is_drawn: bool| -> Result<f64, Failure> {
            let mut encoder = self.encoder();
            let encoded = recorder.encode(&mut encoder, until, None);
            let drawn = encoded.and_then(|()| if is_drawn { self.draw(&mut encoder, recorder, None) } else { Ok(()) });
            drawn.map_err(|error| error.on(self.gpu))?;
            let commands = encoder.finish();
            let begin = Instant::now();
            self.run(commands)?;
            Ok(begin.elapsed().as_secs_f64() * 1e3)
        };
        let extraction_ms = submitted(recorder, Until::Extraction, false)?;
        if until == Until::Extraction {
            return Ok(FrameTimes { extraction_ms, ..FrameTimes::default() });
        }
        let stages_ms = submitted(recorder, Until::Volumes, false)?;
        let frame_ms = submitted(recorder, Until::Volumes, true)?;
        Ok(FrameTimes { extraction_ms, stages_ms, draws_ms: (frame_ms - stages_ms).max(0.0), frame_ms })
    }

    /// The stencil passes of all lights.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        recorder: &dyn Recorder,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for light in 0..LIGHTS {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(STENCIL),
                color_attachments: &[],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth_view,
                    // Depth is reversed: 0 is farthest.
                    depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Store }),
                    stencil_ops: Some(Operations { load: LoadOp::Clear(0), store: StoreOp::Store }),
                }),
                timestamp_writes: timer.as_deref_mut().and_then(|timer| timer.render_pass(STENCIL)),
                occlusion_query_set: None,
                multiview_mask: None,
            });
            recorder.draw(&mut pass, &self.pipelines, light)?;
        }
        Ok(())
    }
}

impl FrameTimes {
    /// Sums of stages, without the span.
    fn of(stages: &[(&'static str, f64)]) -> Self {
        let sum = |chosen: &dyn Fn(&str) -> bool| {
            stages.iter().filter(|(name, _)| chosen(name)).map(|(_, ms)| ms).sum::<f64>()
        };
        Self {
            extraction_ms: sum(&|name| EXTRACTION.contains(&name)),
            stages_ms: sum(&|name| name != STENCIL),
            draws_ms: sum(&|name| name == STENCIL),
            frame_ms: 0.0,
        }
    }
}

/// Bytes that the device has allocated in buffers and textures, where its backend tells.
pub(super) fn allocated_bytes(gpu: &Gpu) -> Result<Option<u64>, Failure> {
    // What was dropped is freed here.
    gpu.wait()?;
    Ok(gpu.device.generate_allocator_report().map(|report| report.total_allocated_bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_those_of_extraction_of_volumes_and_draws() {
        let stages = [("reach", 1.0), ("facing", 2.0), ("choose", 4.0), ("caps", 8.0), (STENCIL, 16.0)];
        let expected = FrameTimes { extraction_ms: 3.0, stages_ms: 15.0, draws_ms: 16.0, frame_ms: 0.0 };
        assert_eq!(FrameTimes::of(&stages), expected);
    }

    #[test]
    fn the_stages_of_extraction_are_stages() {
        let all = rimline::reference::stages::STAGES;
        for name in EXTRACTION {
            assert!(all.iter().any(|stage| stage.name == name), "{name}");
        }
    }
}
