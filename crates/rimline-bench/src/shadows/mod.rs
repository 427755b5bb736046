//! Counting methods against each other over paths of cameras: time of the stencil pass and of the whole frame, and wrong
//! pixels.

pub(crate) mod scene;
mod truth;

use rimline::gpu::{ShadowFormat, ShadowPipelines, StageTimer};
use rimline::{Counting, Light};
use serde_json::json;
use wgpu::{LoadOp, TextureAspect};

use crate::engine::{Contender, Metric, Rounds, Sample, interleave};
use crate::gpu::{Gpu, Stopwatch};
use crate::record::{
    Camera, DEPTH, IDENTITY, Meshes, Pass, Recorder as _, STENCIL, Surface, Surfaces, Until, stencil_pass,
};
use crate::row::{Entry, Row, Section, Variant};
use crate::shapes::Shape;
use crate::{Error, Host};
use scene::Path;
use truth::Truth;

pub(crate) const Z_PASS: &str = "z-pass";
pub(crate) const AUTO: &str = "auto";

/// The counting methods that are compared.
const METHODS: [(&str, &str, Counting, usize, usize); 5] = [
    (Z_PASS, "z-pass", Counting::ZPass, 6, 2),
    ("z-fail", "z-fail", Counting::ZFail, 0, 1),
    ("zp+paper", "ZP+ as published", Counting::ZpPlus2005, 1, 4),
    ("zp+", "ZP+ clipped", Counting::ZpPlus, 2, 3),
    (AUTO, "auto", Counting::Auto, 4, 0),
];

/// A caster, and a room that receives.
pub(crate) struct Stage {
    pub(crate) caster: Shape,
    pub(crate) room: Shape,
    /// Pixels across and down.
    pub(crate) size: u32,
}

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frames {
    /// The length of each path; 0 leaves all out.
    pub(crate) count: usize,
    pub(crate) size: u32,
    pub(crate) rounds: Rounds,
}

impl Frames {
    fn camera(self, path: Path, frame: usize) -> Camera {
        path.camera(frame as f32 / self.count.saturating_sub(1).max(1) as f32)
    }
}

/// Times and wrong pixels of every method for a caster on a path.
pub(crate) fn measure(
    plan: Frames,
    gpu: &Gpu,
    (name, caster): (&str, Shape),
    path: Path,
    host: &dyn Host,
) -> Result<Row, Error> {
    let stage = Stage { caster, room: scene::room(), size: plan.size };
    let (light, faces) = (path.light(), stage.caster.faces.len());
    let format = ShadowFormat { depth_stencil: DEPTH, ..ShadowFormat::default() };
    let pipelines = METHODS.map(|(_, _, counting, ..)| ShadowPipelines::new(&gpu.pipelines, &format, counting));
    let pipelines = pipelines.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut drawn =
        pipelines.iter().map(|pipelines| Drawn::new(gpu, &stage, pipelines, light)).collect::<Result<Vec<_>, _>>()?;
    let mut wrong = vec![Vec::new(); METHODS.len()];
    let truth = Truth::new(&stage, light);
    // About four of each path are held against rays.
    for frame in (0..plan.count).step_by(plan.count.div_ceil(4).max(1)) {
        if host.is_stopped() {
            return Err(Error::Stopped);
        }
        let camera = plan.camera(path, frame);
        let seen = truth.seen(&camera);
        for (drawn, wrong) in drawn.iter_mut().zip(&mut wrong) {
            wrong.push(seen.wrong(&drawn.counts(&camera)?) as f64);
        }
    }
    let contenders = drawn.iter_mut().map(|drawn| -> Contender<'_> {
        Box::new(move || {
            let mut sums = [0.0; 2];
            for frame in 0..plan.count {
                let times = drawn.frame(&plan.camera(path, frame))?;
                sums.iter_mut().zip(times).for_each(|(sum, ms)| *sum += ms / plan.count as f64);
            }
            Ok(Sample::from([(Metric::Time("stencil"), sums[0]), (Metric::Time("frame"), sums[1])]))
        })
    });
    let samples = interleave(plan.rounds, contenders.collect(), host)?;
    let entries = METHODS.iter().zip(samples).zip(wrong).map(|((&(id, name, _, colour, shape), samples), wrong)| {
        Entry::new(Variant::new(id, name, colour, shape), &samples).with(Metric::Count("wrong_pixels"), wrong)
    });
    Ok(Row {
        section: Section::Shadows,
        scene: path.id().to_owned(),
        title: path.name().to_owned(),
        group: name.to_owned(),
        facts: vec![
            ("faces", json!(faces)),
            ("lights", json!(1)),
            ("size", json!(plan.size)),
            ("frames", json!(plan.count)),
        ],
        entries: entries.collect(),
    })
}

/// A caster in its room on the GPU, counted with one method.
struct Drawn<'a> {
    stopwatch: Stopwatch<'a>,
    parts: Parts<'a>,
}

struct Parts<'a> {
    meshes: Meshes<'a>,
    surfaces: Surfaces,
    depth: wgpu::Texture,
    view: wgpu::TextureView,
    light: Light,
}

impl<'a> Drawn<'a> {
    fn new(gpu: &'a Gpu, stage: &Stage, pipelines: &'a ShadowPipelines, light: Light) -> Result<Self, Error> {
        let mut meshes = Meshes::new(Some(pipelines), &[light], None);
        meshes.push_all(gpu, [stage.caster.clone()])?;
        let surfaces = [&stage.caster, &stage.room].map(|shape| Surface::new(gpu, shape, &[IDENTITY]));
        let surfaces = Surfaces::new(gpu, Some(stage.size), surfaces.into());
        let depth = gpu.texture(stage.size, DEPTH);
        let view = depth.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self { stopwatch: Stopwatch::new(gpu), parts: Parts { meshes, surfaces, depth, view, light } })
    }

    fn look(&mut self, camera: &Camera) {
        let Parts { meshes, surfaces, light, .. } = &mut self.parts;
        meshes.camera = Some(camera.shadow());
        surfaces.set(self.stopwatch.gpu, &camera.shadow(), Some(*light));
    }

    /// Draws a frame and waits for it. Returns milliseconds of the stencil pass, and of the whole: stages, depth,
    /// stencil, light.
    fn frame(&mut self, camera: &Camera) -> Result<[f64; 2], Error> {
        self.look(camera);
        let Self { stopwatch, parts } = self;
        if stopwatch.has_timer() {
            let timed = stopwatch.timed(|encoder, mut timer| {
                (0..4).try_for_each(|part| parts.record(encoder, part, timer.as_deref_mut()))
            })?;
            if let Some((_, span)) = timed.passes {
                return Ok([timed.of(|name| name == STENCIL), span]);
            }
        }
        // By the clock, each part waited for.
        let mut times = [0.0; 2];
        for part in 0..4 {
            let [recording, running] = stopwatch.by_clock(|encoder| parts.record(encoder, part, None))?;
            times[1] += recording + running;
            if part == 2 {
                times[0] = recording + running;
            }
        }
        Ok(times)
    }

    /// The counts of a frame, row by row, the light pass left out.
    fn counts(&mut self, camera: &Camera) -> Result<Vec<u8>, Error> {
        self.look(camera);
        let gpu = self.stopwatch.gpu;
        let depth = self.parts.depth.clone();
        let size = depth.width();
        let mut encoder = gpu.encoder();
        for part in 0..3 {
            self.parts.record(&mut encoder, part, None)?;
        }
        let row = size.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let copy = gpu.empty(usage, u64::from(row) * u64::from(size));
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { aspect: TextureAspect::StencilOnly, ..depth.as_image_copy() },
            wgpu::TexelCopyBufferInfo {
                buffer: &copy,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
            },
            depth.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let all: Vec<u8> = gpu.read(&copy)?;
        Ok(all.chunks(row as usize).flat_map(|line| &line[..size as usize]).copied().collect())
    }
}

impl Parts<'_> {
    /// Records a part of a frame: its stages, then its passes.
    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        part: usize,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        match part {
            0 => self.meshes.encode(encoder, Until::Volumes, timer)?,
            2 => {
                let mut pass = stencil_pass(encoder, &self.view, LoadOp::Load, timer, None);
                self.meshes.draw(&mut pass, 0)?;
            }
            part => {
                let (which, name) = if part == 1 { (Pass::Depth, "depth") } else { (Pass::Light, "light") };
                let writes = timer.as_mut().and_then(|timer| timer.render_pass(name));
                self.surfaces.pass(encoder, &self.view, which, writes);
            }
        }
        Ok(())
    }
}
