//! Draws the viewer's state into a texture: models, ground and shadows by the stencil, a pass for each light.

mod counters;
mod error;
mod frame;
mod gpu;
mod models;
mod overlays;
mod picture;
mod pipelines;
mod skipping;
mod targets;

use std::future::Future;

use rimline::gpu::{SceneFrame, StageTimer, read_back_vec_async};

pub use counters::Counters;
pub use error::RenderError;
pub use gpu::Gpu;
pub use picture::Picture;

use crate::state::camera::{Camera, Orbit};
use crate::state::lamp::Lamp;
use crate::state::options::{Options, Overlays as ShownOverlays};
use crate::state::viewer::{MAX_SOURCES, Tone, Viewer};
use counters::Readings;
use frame::{Frame, LampData};
use models::{Made, Models};
use overlays::Overlays;
use picture::Copy;
use pipelines::{Pipelines, Shared};
use targets::Targets;

/// Draws the state of a viewer into a texture of its own. Nothing waits for the device.
pub struct Renderer {
    gpu: Gpu,
    shared: Shared,
    /// By the number of samples.
    pipelines: Vec<Pipelines>,
    models: Option<Models>,
    overlays: Option<Overlays>,
    targets: Option<Targets>,
    timer: Option<StageTimer>,
    readings: Readings,
    counters: Counters,
    drawn: Option<Drawn>,
    pictures: u64,
}

/// All that a picture depends on.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    generation: u64,
    size: [u32; 2],
    orbit: Orbit,
    lamps: Vec<Lamp>,
    options: Options,
    seconds: f32,
}

impl Drawn {
    fn of(viewer: &Viewer) -> Self {
        Self {
            generation: viewer.generation(),
            size: viewer.size(),
            orbit: viewer.orbit,
            lamps: viewer.lamps.clone(),
            // Boxes are drawn by the panel.
            options: Options { overlays: ShownOverlays { boxes: false, ..viewer.options.overlays }, ..viewer.options },
            seconds: viewer.clock.seconds,
        }
    }
}

impl Renderer {
    /// Makes what all pictures share.
    ///
    /// # Errors
    /// [`RenderError`] if the device lacks what shadows need.
    pub fn new(gpu: Gpu) -> Result<Self, RenderError> {
        let shared = Shared::new(&gpu, MAX_SOURCES);
        let timer = StageTimer::new(&gpu.device, &gpu.queue);
        Ok(Self {
            gpu,
            shared,
            pipelines: Vec::new(),
            models: None,
            overlays: None,
            targets: None,
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

    /// The last picture, of format `Rgba8Unorm` and encoded as sRGB. `None`: none was drawn.
    pub fn texture(&self) -> Option<&wgpu::TextureView> {
        self.targets.as_ref().map(|targets| &targets.picture_view)
    }

    /// The number of pictures that were drawn.
    pub fn pictures(&self) -> u64 {
        self.pictures
    }

    /// Whether the picture is not of this state: something changed since it was drawn.
    pub fn is_stale(&self, viewer: &Viewer) -> bool {
        self.drawn.as_ref() != Some(&Drawn::of(viewer))
    }

    /// Whether [`Self::refine`] makes a smoother picture: the last one was drawn in a hurry.
    pub fn is_coarse(&self, viewer: &Viewer) -> bool {
        self.targets.as_ref().is_some_and(|targets| targets.samples < viewer.options.samples)
    }

    /// Draws the state, if the picture is not of it already: with one sample a pixel on software devices, else with as many as
    /// the options say. Returns whether it did.
    ///
    /// # Errors
    /// [`RenderError`]. The picture before stays.
    pub fn draw(&mut self, viewer: &Viewer) -> Result<bool, RenderError> {
        if !self.is_stale(viewer) {
            return Ok(false);
        }
        let samples = if self.gpu.is_software { 1 } else { viewer.options.samples };
        self.draw_with(viewer, samples).map(|()| true)
    }

    /// Draws the state once more with all samples, for what stays as it is.
    ///
    /// # Errors
    /// [`RenderError`]. The picture before stays.
    pub fn refine(&mut self, viewer: &Viewer) -> Result<(), RenderError> {
        self.draw_with(viewer, viewer.options.samples)
    }

    /// Draws like [`Self::draw`]. A model that fails is taken out, and every failure becomes the viewer's message. Returns
    /// whether there is a new picture.
    pub fn show(&mut self, viewer: &mut Viewer) -> bool {
        loop {
            match self.draw(viewer) {
                Ok(is_drawn) => return is_drawn,
                Err(error) => {
                    viewer.message = Some((Tone::Error, error.to_string()));
                    let RenderError::Body { index, .. } = error else {
                        // The same state would fail again.
                        self.drawn = Some(Drawn::of(viewer));
                        return false;
                    };
                    viewer.remove_body(index);
                }
            }
        }
    }

    /// Takes numbers of earlier frames that have arrived. Returns whether some did.
    pub fn poll(&mut self) -> bool {
        self.readings.poll(&self.gpu, &mut self.counters)
    }

    /// Whether numbers are on their way, for which [`Self::poll`] is to be called.
    pub fn is_waiting(&self) -> bool {
        self.readings.are_pending()
    }

    /// Numbers of an earlier frame.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Whether the device measures times.
    pub fn has_timer(&self) -> bool {
        self.timer.is_some()
    }

    fn draw_with(&mut self, viewer: &Viewer, samples: u32) -> Result<(), RenderError> {
        let size = viewer.size();
        if self.targets.as_ref().is_none_or(|targets| targets.size != size || targets.samples != samples) {
            self.targets = Some(Targets::new(&self.gpu, &self.shared, size, samples)?);
        }
        let Some(targets) = self.targets.take() else { return Ok(()) };
        let mut encoder = self.gpu.encoder("view");
        let recorded = self.record(&mut encoder, viewer, &targets);
        self.counters.bytes = targets.bytes() + self.models.as_ref().map_or(0, |models| models.bytes);
        self.targets = Some(targets);
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

    /// Draws the state into a picture of its own with four samples a pixel, so many times as large each way. The future waits
    /// for the device, which somebody must poll.
    ///
    /// # Errors
    /// [`RenderError`], also if the device has no textures of that size.
    pub fn screenshot(
        &mut self,
        viewer: &Viewer,
        scale: u32,
    ) -> Result<impl Future<Output = Result<Picture, RenderError>> + use<>, RenderError> {
        let size = viewer.size().map(|side| side * scale);
        let targets = Targets::new(&self.gpu, &self.shared, size, 4)?;
        let mut encoder = self.gpu.encoder("screenshot");
        self.record(&mut encoder, viewer, &targets)?;
        let copy = Copy::record(&self.gpu.device, &mut encoder, &targets.picture);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(read(&self.gpu, copy))
    }

    /// Reads the last picture. The future waits for the device, which somebody must poll. `None`: none was drawn.
    pub fn read(&self) -> Option<impl Future<Output = Result<Picture, RenderError>> + use<>> {
        let targets = self.targets.as_ref()?;
        let mut encoder = self.gpu.encoder("read");
        let copy = Copy::record(&self.gpu.device, &mut encoder, &targets.picture);
        self.gpu.queue.submit([encoder.finish()]);
        Some(read(&self.gpu, copy))
    }

    /// Records everything of a picture.
    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        viewer: &Viewer,
        targets: &Targets,
    ) -> Result<SceneFrame, RenderError> {
        let gpu = &self.gpu;
        if self.models.as_ref().is_none_or(|models| models.made != Made::of(viewer)) {
            self.models = None;
            self.models = Some(Models::new(gpu, &self.shared.models, viewer)?);
        }
        let options = &viewer.options;
        let needs_edges = options.overlays.needs_edges();
        if !needs_edges {
            self.overlays = None;
        } else if self.overlays.as_ref().is_none_or(|overlays| !overlays.is_of(viewer)) {
            self.overlays = Some(Overlays::new(gpu, viewer)?);
        }
        if !self.pipelines.iter().any(|pipelines| pipelines.samples == targets.samples) {
            self.pipelines.push(Pipelines::new(gpu, &self.shared, targets.samples)?);
        }
        let Self { models: Some(models), pipelines, shared, timer, overlays, .. } = self else {
            unreachable!("the models were made above");
        };
        let pipelines = pipelines.iter_mut().find(|pipelines| pipelines.samples == targets.samples);
        let Some(pipelines) = pipelines else { unreachable!("they were made above") };
        pipelines.prepare(gpu, shared, options.counting, options.mode)?;

        let camera = viewer.orbit.camera(targets.size, &viewer.bounds(), viewer.ground());
        let frame_data = Frame::new(viewer, &camera);
        write_uniforms(gpu, shared, viewer, &frame_data, &camera);
        let shadow_camera = camera.shadow_camera();
        let mut timer = timer.as_mut().filter(|_| options.timing);
        if let Some(timer) = &mut timer {
            timer.clear();
        }
        let frame = models.encode(gpu, &shared.models, encoder, viewer, shadow_camera, timer.as_deref_mut())?;
        if let Some(timer) = timer {
            timer.resolve(encoder);
        }
        if let Some(overlays) = overlays.as_mut() {
            overlays.encode(gpu, encoder, models, viewer, &shadow_camera)?;
        }
        let scene = Drawing {
            shared,
            pipelines,
            models,
            overlays: overlays.as_ref(),
            has_ground: options.ground && frame_data.sees_ground(),
        };
        scene.light(encoder, viewer, targets, &frame)?;
        let outlines = overlays.as_ref().map(|overlays| overlays.outlines(pipelines, targets, viewer, &shadow_camera));
        let mut pass = targets.finish(encoder, "tone", true);
        pass.set_pipeline(&pipelines.tone);
        pass.set_bind_group(0, &shared.frame_group, &[]);
        pass.set_bind_group(1, &targets.light, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        for outline in outlines.transpose()?.into_iter().flatten() {
            outline.draw(&mut targets.finish(encoder, "outline", false))?;
        }
        Ok(frame)
    }
}

fn write_uniforms(gpu: &Gpu, shared: &Shared, viewer: &Viewer, frame: &Frame, camera: &Camera) {
    gpu.queue.write_buffer(&shared.frame_buffer, 0, bytemuck::bytes_of(frame));
    let sources = viewer.sources();
    let sources = sources.iter().take(MAX_SOURCES);
    let data: Vec<LampData> = sources.map(|(number, source)| LampData::new(source, *number, camera.eye)).collect();
    gpu.queue.write_buffer(&shared.lamp_buffer, 0, bytemuck::cast_slice(&data));
}

fn read(gpu: &Gpu, copy: Copy) -> impl Future<Output = Result<Picture, RenderError>> + use<> {
    let words = read_back_vec_async::<u32>(&gpu.device, &gpu.queue, copy.buffer());
    async move { Ok(copy.picture(&words.await?)) }
}

/// Bindings of the passes of a light.
struct Drawing<'a> {
    shared: &'a Shared,
    pipelines: &'a Pipelines,
    models: &'a Models,
    overlays: Option<&'a Overlays>,
    has_ground: bool,
}

impl Drawing<'_> {
    /// Records the light of all lights, and what is drawn into it.
    fn light(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        viewer: &Viewer,
        targets: &Targets,
        frame: &SceneFrame,
    ) -> Result<(), RenderError> {
        let (options, pipelines) = (&viewer.options, self.pipelines);
        let shadows = pipelines.shadows(options.counting).filter(|_| options.shadows);
        let mut pass = targets.pass(encoder, "ambient", true, false);
        self.paint(&mut pass, &pipelines.ambient, 0);
        pass.set_pipeline(&pipelines.backdrop);
        pass.draw(0..3, 0..1);
        drop(pass);
        let shade = pipelines.shade.as_ref().filter(|_| options.shadows);
        for (number, &light) in self.models.lights.iter().enumerate() {
            let mut pass = targets.pass(encoder, "light", false, false);
            if let Some(shadows) = shadows.filter(|_| shade.is_none()) {
                frame.draw(&mut pass, shadows, 0, light)?;
            }
            self.paint(&mut pass, &pipelines.lit, number);
        }
        for (number, &light) in self.models.lights.iter().enumerate() {
            let Some(((_, shade), shadows)) = shade.zip(shadows) else { break };
            let mut pass = targets.pass(encoder, "shade", false, false);
            frame.draw(&mut pass, shadows, 0, light)?;
            for receivers in shade {
                self.paint(&mut pass, receivers, number);
            }
        }
        let has_overlays = options.overlays.caps || options.overlays.volumes;
        if !has_overlays && targets.resolved.is_none() {
            return Ok(());
        }
        let mut pass = targets.pass(encoder, "overlays", false, true);
        let mut sources: Vec<_> = viewer.sources().iter().map(|(number, _)| *number).enumerate().collect();
        sources.dedup_by_key(|(_, number)| *number);
        for (source, number) in sources {
            if options.overlays.caps {
                self.select(&mut pass, source);
                pass.set_pipeline(&pipelines.caps);
                self.draw_models(&mut pass);
            }
            if let Some(overlays) = self.overlays.filter(|_| options.overlays.volumes) {
                self.select(&mut pass, source);
                overlays.draw_volumes(&mut pass, (self.shared, pipelines), number)?;
            }
        }
        Ok(())
    }

    /// Binds the frame and a light.
    fn select(&self, pass: &mut wgpu::RenderPass<'_>, lamp: usize) {
        pass.set_bind_group(0, &self.shared.frame_group, &[]);
        pass.set_bind_group(1, &self.shared.lamp_group, &[lamp as u32 * LampData::STRIDE as u32]);
    }

    fn draw_models(&self, pass: &mut wgpu::RenderPass<'_>) {
        for placed in &self.models.placed {
            pass.set_bind_group(2, &placed.draw, &[]);
            pass.draw(0..placed.corners, 0..1);
        }
    }

    /// Draws models and ground for a light.
    fn paint(&self, pass: &mut wgpu::RenderPass<'_>, receivers: &pipelines::Receivers, lamp: usize) {
        self.select(pass, lamp);
        pass.set_pipeline(&receivers.surface);
        self.draw_models(pass);
        if self.has_ground {
            pass.set_pipeline(&receivers.ground);
            pass.draw(0..12, 0..1);
        }
    }
}
