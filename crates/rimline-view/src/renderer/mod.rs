//! Draws the viewer's state into a texture: models and ground in ambient light, then for each light the count of its shadow
//! volumes in the stencil and the surfaces that it lights.

mod canvas;
mod counters;
mod drawing;
mod drawn;
mod error;
mod gpu;
mod models;
mod overlays;
mod picture;
mod pipelines;
mod scene;
mod skipping;
mod tiles;

use std::future::Future;

use rimline::gpu::{Receivers, SceneFrame, StageTimer, View, read_back_vec_async};
use rimline_picture::{Mode, NormalPipeline, Resources};

pub use counters::Counters;
pub use error::RenderError;
pub use gpu::Gpu;
pub use picture::Picture;

use crate::state::viewer::{MAX_SOURCES, Tone, Viewer};
use canvas::{Canvas, Quality};
use counters::Readings;
use drawing::Drawing;
use drawn::Drawn;
use models::{Made, Models};
use overlays::Overlays;
use picture::Copy;
use pipelines::Pipelines;
use scene::SeenScene;

/// Draws the state of a viewer into a texture that it owns. No method waits for the device.
pub struct Renderer {
    gpu: Gpu,
    resources: Resources,
    normals: NormalPipeline,
    /// One for each number of samples a pixel that was drawn with.
    pipelines: Vec<Pipelines>,
    models: Option<Models>,
    overlays: Option<Overlays>,
    canvas: Option<Canvas>,
    timer: Option<StageTimer>,
    readings: Readings,
    counters: Counters,
    drawn: Option<Drawn>,
    pictures: u64,
}

impl Renderer {
    /// A renderer without models: the first picture makes them.
    ///
    /// # Errors
    /// [`RenderError`] if the device lacks what shadows need.
    pub fn new(gpu: Gpu) -> Result<Self, RenderError> {
        let (resources, normals) = (Resources::new(gpu.on(), MAX_SOURCES), NormalPipeline::new(&gpu.device));
        let timer = StageTimer::new(&gpu.device, &gpu.queue);
        Ok(Self {
            gpu,
            resources,
            normals,
            pipelines: Vec::new(),
            models: None,
            overlays: None,
            canvas: None,
            timer,
            readings: Readings::default(),
            counters: Counters::default(),
            drawn: None,
            pictures: 0,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The last picture, of format `Rgba8Unorm` and encoded as sRGB. Its pixels are [`Self::step`] pixels of the window wide
    /// and high. `None`: none was drawn.
    pub fn texture(&self) -> Option<&wgpu::TextureView> {
        self.canvas.as_ref().map(|canvas| &canvas.picture)
    }

    /// How many pictures [`Self::texture`] has had. Screenshots are not among them.
    pub fn pictures(&self) -> u64 {
        self.pictures
    }

    /// Whether the picture is not of this state: something changed since it was drawn, or since [`Self::show`] failed to
    /// draw it. With a NaN in the state it always is.
    pub fn is_stale(&self, viewer: &Viewer) -> bool {
        self.drawn.as_ref() != Some(&Drawn::of(viewer))
    }

    /// Whether the last picture has fewer pixels or samples than [`Self::refine`] draws with these options.
    pub fn is_coarse(&self, viewer: &Viewer) -> bool {
        self.canvas.as_ref().is_some_and(|canvas| canvas.quality != self.full(viewer.options.samples))
    }

    /// How many pixels of the window a pixel of [`Self::texture`] is wide and high: 2 in large pictures that [`Self::draw`]
    /// made on software devices, else 1.
    pub fn step(&self) -> u32 {
        self.canvas.as_ref().map_or(1, |canvas| canvas.quality.step)
    }

    /// Draws the state, unless the picture is of it already: on software devices with one sample a pixel, and large pictures
    /// with fewer pixels; else with as many samples as the options ask for. Returns whether it drew.
    ///
    /// # Errors
    /// [`RenderError`]. The picture before stays.
    pub fn draw(&mut self, viewer: &Viewer) -> Result<bool, RenderError> {
        if !self.is_stale(viewer) {
            return Ok(false);
        }
        let quality =
            if self.gpu.is_software { Quality::hurried(viewer.size()) } else { self.full(viewer.options.samples) };
        self.draw_with(viewer, quality).map(|()| true)
    }

    /// Draws the state with all pixels and as many samples as the options ask for, on every device. It is slow on software
    /// devices: call it when the state has stayed the same for a while.
    ///
    /// # Errors
    /// [`RenderError`]. The picture before stays.
    pub fn refine(&mut self, viewer: &Viewer) -> Result<(), RenderError> {
        self.draw_with(viewer, self.full(viewer.options.samples))
    }

    /// All pixels, with so many samples each. OpenGL has one, since with wgpu 30 shaders there cannot read a depth of several
    /// samples.
    fn full(&self, samples: u32) -> Quality {
        let is_opengl = self.gpu.device.adapter_info().backend == wgpu::Backend::Gl;
        Quality { samples: if is_opengl { 1 } else { samples }, step: 1 }
    }

    /// Draws like [`Self::draw`]. A model that fails is removed from the viewer, overlays that fail are switched off, and the
    /// viewer's message tells these failures; those of models stand beside errors that it told before. A lost device changes
    /// nothing of the viewer. Returns whether there is a new picture.
    pub fn show(&mut self, viewer: &mut Viewer) -> bool {
        let mut has_failed = false;
        loop {
            let error = match self.draw(viewer) {
                Ok(is_drawn) => return is_drawn,
                // Another device may have no such error.
                Err(_) if self.gpu.is_lost() => return false,
                Err(error) => error,
            };
            // Files that failed to open, and models that are gone, stay named.
            let stays = has_failed || matches!(error, RenderError::Body { .. });
            let earlier = viewer.message.take().filter(|message| stays && message.tone == Tone::Error);
            has_failed = true;
            let can_go_on = match &error {
                RenderError::Body { index, .. } => {
                    viewer.remove_body(*index);
                    true
                }
                RenderError::Overlays { .. } => {
                    viewer.options.overlays = viewer.options.overlays.without_edges();
                    true
                }
                // The same state would fail again, so it does not count as stale. With a NaN it is never like itself.
                _ => {
                    self.drawn = Some(Drawn::of(viewer));
                    false
                }
            };
            viewer.message = earlier;
            viewer.add_error(&error.to_string());
            if !can_go_on {
                return false;
            }
        }
    }

    /// Puts numbers of earlier frames that the device has given by now into [`Self::counters`]. Returns whether there were
    /// any.
    pub fn poll(&mut self) -> bool {
        self.readings.poll(&self.gpu, &mut self.counters)
    }

    /// Whether the device has yet to give numbers of a frame: call [`Self::poll`] until it has.
    pub fn is_waiting(&self) -> bool {
        self.readings.are_pending()
    }

    /// Numbers of the last frame that was read back.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Whether the device measures times.
    pub fn has_timer(&self) -> bool {
        self.timer.is_some()
    }

    fn draw_with(&mut self, viewer: &Viewer, quality: Quality) -> Result<(), RenderError> {
        let size = viewer.size();
        let last = self.canvas.take_if(|canvas| canvas.is_for(size, quality));
        let is_last = last.is_some();
        let canvas = if let Some(last) = last { last } else { Canvas::new(&self.resources, size, quality)? };
        let mut encoder = self.gpu.encoder("view");
        let recorded = self.record(&mut encoder, viewer, &canvas);
        self.counters.bytes = canvas.bytes() + self.models.as_ref().map_or(0, Models::bytes);
        let report = self.gpu.device.generate_allocator_report();
        self.counters.device_bytes = report.map(|report| report.total_allocated_bytes);
        // After a failure the canvas of the last picture stays. A new one would have no picture.
        if is_last || recorded.is_ok() {
            self.canvas = Some(canvas);
        }
        let frame = recorded?;
        self.gpu.queue.submit([encoder.finish()]);
        let timer = self.timer.as_ref().filter(|_| viewer.options.timing);
        self.readings.begin(&self.gpu, &frame, timer);
        if !viewer.options.timing {
            self.counters.stages = None;
        }
        self.drawn = Some(Drawn::of(viewer));
        self.pictures += 1;
        Ok(())
    }

    /// Draws the state into another picture, `scale` times as wide and as high, with four samples a pixel, or one
    /// on OpenGL. The caller must poll the device until the future is ready.
    ///
    /// # Errors
    /// [`RenderError`], also if the device has no textures of that size.
    pub fn screenshot(
        &mut self,
        viewer: &Viewer,
        scale: u32,
    ) -> Result<impl Future<Output = Result<Picture, RenderError>> + use<>, RenderError> {
        let size = viewer.size().map(|side| side.saturating_mul(scale));
        let canvas = Canvas::new(&self.resources, size, self.full(4))?;
        let copy = gpu::granted(&self.gpu.device, || Copy::new(&self.gpu.device, size));
        let copy = copy.map_err(|why| RenderError::refused(size, why))?;
        let mut encoder = self.gpu.encoder("screenshot");
        self.record(&mut encoder, viewer, &canvas)?;
        copy.record(&mut encoder, &canvas.targets.picture);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(read(&self.gpu, copy))
    }

    /// Reads the last picture. The caller must poll the device until the future is ready. `None`: none was drawn.
    pub fn read(&self) -> Option<impl Future<Output = Result<Picture, RenderError>> + use<>> {
        let canvas = self.canvas.as_ref()?;
        let mut encoder = self.gpu.encoder("read");
        let copy = Copy::new(&self.gpu.device, canvas.size);
        copy.record(&mut encoder, &canvas.targets.picture);
        self.gpu.queue.submit([encoder.finish()]);
        Some(read(&self.gpu, copy))
    }

    /// Makes models, overlays and pipelines, unless there are those of this state.
    fn make(&mut self, viewer: &Viewer, samples: u32) -> Result<(), RenderError> {
        let (gpu, options) = (&self.gpu, &viewer.options);
        if self.models.as_ref().is_none_or(|models| models.made != Made::of(viewer)) {
            self.models = None;
            self.models = Some(Models::new(gpu, &self.resources, &self.normals, viewer)?);
        }
        if !options.overlays.needs_edges() {
            self.overlays = None;
        } else if self.overlays.as_ref().is_none_or(|overlays| !overlays.is_of(viewer)) {
            self.overlays = Some(Overlays::new(gpu, viewer)?);
        }
        if !self.pipelines.iter().any(|pipelines| pipelines.samples() == samples) {
            self.pipelines.push(Pipelines::new(gpu, &self.resources, samples)?);
        }
        let mode = if options.shadows { options.mode } else { Mode::Additive };
        let pipelines = self.pipelines.iter_mut().find(|pipelines| pipelines.samples() == samples);
        pipelines.map_or(Ok(()), |pipelines| pipelines.prepare(gpu, &self.resources, options.counting, mode))
    }

    /// Records the picture of a state onto a canvas. The frame has the counts of what was encoded.
    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        viewer: &Viewer,
        canvas: &Canvas,
    ) -> Result<SceneFrame, RenderError> {
        self.make(viewer, canvas.format.samples)?;
        let (gpu, options) = (&self.gpu, &viewer.options);
        let Self { models: Some(models), pipelines, resources, normals, timer, overlays, .. } = self else {
            unreachable!("the models were made above");
        };
        let pipelines = pipelines.iter().find(|pipelines| pipelines.samples() == canvas.format.samples);
        let Some(pipelines) = pipelines else { unreachable!("they were made above") };

        let seen = SeenScene::of(viewer, canvas.of, canvas.part);
        let view = seen.view();
        resources.set(&view);
        let camera = view.shadow_camera();
        let mut timer = timer.as_mut().filter(|_| options.timing);
        if let Some(timer) = &mut timer {
            timer.clear();
        }
        models.set((resources, normals), viewer)?;
        models.deform(normals, encoder, camera.into(), timer.as_deref_mut())?;
        let (attachments, has_ground) = (&canvas.targets.attachments[0], options.ground && view.sees_ground());
        let ambient = |encoder: &mut wgpu::CommandEncoder, models: &Models| {
            let seen = Drawing::of_receivers(resources, pipelines, models, has_ground);
            pipelines.passes.record_receivers(encoder, resources, attachments, &seen);
        };
        // If the buffers of the last encode's surfaces are still right, the surfaces are drawn first: their depth lets the
        // encode leave out shadows that fall on nothing.
        let depth = (options.shadows && options.skipping.receivers && models.has_surfaces()).then(|| {
            ambient(encoder, models);
            Receivers { depth: &canvas.depth, sky_receives: false, version: None }
        });
        let view_with_depth = View { depth, ..camera.into() };
        let frame = models.encode(resources, encoder, view_with_depth, timer.as_deref_mut(), viewer)?;
        if depth.is_none() {
            ambient(encoder, models);
        }
        if let Some(timer) = timer {
            timer.resolve(encoder);
        }
        if let Some(overlays) = overlays.as_mut() {
            overlays.encode(gpu, encoder, models, viewer, &camera)?;
        }
        let drawing = Drawing {
            resources,
            pipelines,
            models,
            frame: Some(&frame),
            shadows: pipelines.shadows(options.counting).filter(|_| options.shadows),
            overlays: overlays.as_ref(),
            shown: options.overlays,
            has_ground,
            firsts: seen.firsts(),
        };
        pipelines.passes.record_lights(encoder, resources, attachments, &drawing)?;
        pipelines.passes.develop(encoder, resources, &canvas.targets);
        if options.overlays.receivers {
            pipelines.tiles(resources).draw(encoder, resources, canvas);
        }
        if let Some(overlays) = overlays.as_ref() {
            for outline in overlays.outlines(pipelines, canvas, viewer, &camera)? {
                outline.draw(&mut canvas.pass(encoder))?;
            }
        }
        Ok(frame)
    }
}

fn read(gpu: &Gpu, copy: Copy) -> impl Future<Output = Result<Picture, RenderError>> + use<> {
    let words = read_back_vec_async::<u32>(&gpu.device, &gpu.queue, copy.buffer());
    async move { Ok(copy.picture(&words.await?)) }
}
