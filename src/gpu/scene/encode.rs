//! Encodes of a scene: brings table, buffers and volumes up to date, and records the stages.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::caster::CasterEntry;
use super::frame::SceneFrame;
use super::options::Measuring;
use super::receivers::{self, SeenReceivers};
use super::scene::Scene;
use super::stages::steps;
use super::structure::{Making, Number, Structure};
use super::table::{Part, Table};
use super::view::{FrameInputs, View};
use super::volumes::Volumes;
use crate::ShadowCamera;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::pass::record;
use crate::gpu::common::requirements::check_timer;
use crate::gpu::common::uniforms::upload;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::pipelines::Convention;
use crate::layout::{ShadowView, ViewLight};

impl Scene {
    /// Records the extraction of all casters for all lights, and the shadow volumes of all views. One encoder may hold several
    /// encodes. Each sees the scene of its moment, and overwrites the results of the one before. An encoder may be dropped, or
    /// submitted after a later one. Memory is kept for the most views of an encode so far.
    ///
    /// ```no_run
    /// use rimline::gpu::{FrameInputs, Scene, SceneFrame, ShadowError, StageTimer};
    /// use rimline::{ShadowCamera, wgpu};
    ///
    /// fn frame(
    ///     scene: &mut Scene,
    ///     encoder: &mut wgpu::CommandEncoder,
    ///     camera: ShadowCamera,
    ///     timer: &mut StageTimer,
    /// ) -> Result<SceneFrame, ShadowError> {
    ///     scene.encode(encoder, FrameInputs { views: &[camera.into()], timer: Some(timer), ..Default::default() })
    /// }
    /// ```
    ///
    /// # Errors
    /// [`ShadowError`] if a camera or its [`View::depth`] is refused, the scene does not fit the device or the memory limit, or
    /// the device is lost or not the timer's. Nothing is recorded then, and the next encode is not affected.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: FrameInputs<'_>,
    ) -> Result<SceneFrame, ShadowError> {
        let mut timer = inputs.timer;
        check_timer(timer.as_deref(), self.pipelines.device())?;
        let views = Self::check_views(inputs.views)?;
        let given = &*self.check_depths(inputs.views)?;
        let words = given.iter().filter_map(|view| view.depth).map(|depth| depth.words()).max().unwrap_or(0);
        let deformed = self.take_deformed(&views);
        let (structure, volumes) = self.prepare_receivers(given.len(), words)?;
        let needs = if deformed.is_some() { None } else { self.find_needs(given, &views)? };
        let needed_states_offset = if self.figures.is_empty() { 0 } else { structure.needed_states_offset };
        self.table.put_encode(self.encode_number(), needed_states_offset);
        self.table.put_origin(given.iter().flat_map(|view| view.camera.origin).fold(0.0, |size, c| size.max(c.abs())));
        let of_receivers = match volumes.as_ref().filter(|_| !structure.parts.is_empty()) {
            Some(volumes) => {
                let target = (&volumes.buffers.of.receivers, volumes.buffers.sizes.receivers);
                let of_views =
                    given.iter().zip(&views).map(|(given, view)| (&given.camera, view, given.depth.as_ref()));
                receivers::steps(&self.pipelines, of_views, target)?
            }
            None => Vec::new(),
        };
        self.renew_views(&views, given);
        let view_lights = volumes.as_ref().map_or_else(Vec::new, |volumes| self.view_lights(volumes, given, &views));
        let light_batches = structure.light_batches(&self.meshes, &self.casters, &self.lights);
        let uploaded: &[Part] = self.table.parts.get(..structure.layout.uploaded).unwrap_or_default();
        let mut uploads: Vec<(&wgpu::Buffer, &[u8])> = Vec::new();
        uploads.extend(needs.iter().flat_map(|needs| self.deform_uploads(needs)));
        if !structure.parts.is_empty() {
            uploads.push((&structure.table, bytemuck::cast_slice(uploaded)));
            uploads.extend(
                volumes.iter().map(|volumes| (&volumes.buffers.of.view_lights, bytemuck::cast_slice(&view_lights[..]))),
            );
            uploads.extend(light_batches.iter().map(|(buffer, batch)| (buffer, bytemuck::bytes_of(batch))));
        }
        if !uploads.is_empty() {
            upload(self.pipelines.device(), encoder, &uploads)?;
        }
        let unneeded = needs.map(|needs| self.record_needs(encoder, &needs, timer.as_deref_mut())).or(deformed);
        if let Some(words) = unneeded.filter(|_| !structure.parts.is_empty()) {
            let (to, bytes) = (4 * u64::from(needed_states_offset), 4 * self.figures.len() as u64);
            encoder.copy_buffer_to_buffer(&words, 0, &structure.buffers.work, to, bytes);
        }
        record(self.steps.iter().chain(&of_receivers), encoder, 0..1, timer.as_deref_mut());
        if let Some(volumes) = &volumes {
            volumes.stages.record(encoder, structure.batches, timer);
        }
        let encode = self.encodes.fetch_add(1, Ordering::Relaxed) + 1;
        self.pages.reclaim(encode);
        let (encodes, lights) = (Arc::clone(&self.encodes), self.lights.listed());
        let views = given.iter().map(|view| (self.convention(&view.camera), view.camera)).collect();
        let count_batches = self.options.stencil.count_batches;
        let hidden = self.count_hidden();
        let device = self.pipelines.device().clone();
        Ok(SceneFrame {
            structure,
            volumes,
            views,
            has_models: !self.figures.is_empty(),
            count_batches,
            device,
            scene: self.id,
            lights,
            hidden,
            encodes,
            encode,
        })
    }

    /// The cameras as stages see them.
    pub(super) fn check_views(given: &[View<'_>]) -> Result<Vec<ShadowView>, ShadowError> {
        let view = |(view, given): (usize, &View<'_>)| {
            given.camera.view().map_err(|error| ShadowError::ViewCamera { view, error })
        };
        given.iter().enumerate().map(view).collect()
    }

    /// The views with the depths that count.
    fn check_depths<'a, 'r>(&self, given: &'a [View<'r>]) -> Result<Cow<'a, [View<'r>]>, ShadowError> {
        for (number, view) in given.iter().enumerate() {
            view.depth.map_or(Ok(()), |depth| depth.check(number))?;
        }
        Ok(if self.options.measuring.has(Measuring::WITHOUT_RECEIVERS) {
            given.iter().map(|view| View::new(view.camera)).collect()
        } else {
            Cow::Borrowed(given)
        })
    }

    /// Brings everything up to date, with room for so many views and so many words for the receivers of each.
    fn prepare_receivers(
        &mut self,
        views: usize,
        words: u64,
    ) -> Result<(Arc<Structure>, Option<Arc<Volumes>>), ShadowError> {
        let before = self.receiver_words;
        // The table has room for where volumes end, once there are receivers.
        let set = |scene: &mut Self, words| {
            (scene.receiver_words, scene.volumes) = (words, None);
            scene.structure = scene.structure.take().filter(|_| before > 0);
        };
        if words > before {
            set(self, words);
        }
        let made = self.prepare_views(views);
        if made.is_err() && words > before {
            set(self, before);
        }
        made
    }

    /// The settings that pipelines must have to draw a camera's volumes.
    fn convention(&self, camera: &ShadowCamera) -> Convention {
        let counting = self.options.counting;
        let is_unclipped = counting.may_fail() && camera.has_far_plane();
        let (count_bits, mirrors) = (self.options.stencil.count_bits, camera.mirrors());
        Convention { counting, depth: camera.depth, is_unclipped, count_bits, mirrors }
    }

    /// The volumes of the structure.
    fn volumes(&mut self, structure: &Structure) -> Result<Arc<Volumes>, ShadowError> {
        if let Some(volumes) = &self.volumes {
            return Ok(Arc::clone(volumes));
        }
        let Self { pipelines, options, meshes, sources, lights, pages, views, receiver_words, deformed_bytes, .. } =
            self;
        let has_receivers = *receiver_words > 0;
        let others = pages.bytes + *deformed_bytes;
        let making =
            Making { pipelines, meshes, sources, pages, others, lights, options, views: *views, has_receivers };
        let others = others + structure.bytes();
        let made = Arc::new(Volumes::new(&making, structure, *views, *receiver_words, others)?);
        self.volumes = Some(Arc::clone(&made));
        Ok(made)
    }

    /// Keeps the versions of cameras that did not change.
    fn renew_views(&mut self, views: &[ShadowView], given: &[View<'_>]) {
        let encode = self.encode_number();
        let last = std::mem::take(&mut self.seen_views);
        let mut last = last.into_iter().map(Some).chain(std::iter::repeat(None));
        let bytes = bytemuck::bytes_of::<ShadowView>;
        let version = |(view, given): (&ShadowView, &View<'_>)| {
            let seen = SeenReceivers::of(given.depth.as_ref());
            let version = match last.next().flatten() {
                Some((before, version, of)) if bytes(&before) == bytes(view) && of == seen => version,
                _ => encode,
            };
            (*view, if seen == SeenReceivers::Changing { encode } else { version }, seen)
        };
        self.seen_views = views.iter().zip(given).map(version).collect();
    }

    /// Each light as each camera sees it. Views that are not used are empty, and their lights reach nothing.
    fn view_lights(&self, volumes: &Volumes, given: &[View<'_>], views: &[ShadowView]) -> Vec<ViewLight> {
        let mut all = Vec::with_capacity(volumes.buffers.sizes.view_lights());
        for (number, ((given, &view), &(_, version, _))) in given.iter().zip(views).zip(&self.seen_views).enumerate() {
            let at = if given.depth.is_some() { receivers::at(number, volumes.buffers.sizes.receivers) } else { 0 };
            for bit in 0..volumes.buffers.sizes.lights as u32 {
                let light = self.lights.get(bit).map(|light| given.camera.light(&view, light));
                let light = light.unwrap_or_else(bytemuck::Zeroable::zeroed);
                all.push(ViewLight { view, light, version: [version, at, 0, 0], ..bytemuck::Zeroable::zeroed() });
            }
        }
        all.resize(volumes.buffers.sizes.view_lights(), bytemuck::Zeroable::zeroed());
        all
    }

    /// Brings everything up to date, with room for so many views.
    pub(super) fn prepare_views(
        &mut self,
        views: usize,
    ) -> Result<(Arc<Structure>, Option<Arc<Volumes>>), ShadowError> {
        let before = self.views;
        if views > before {
            self.views = views;
            self.structure = None;
        }
        let made = match self.prepare_all(views) {
            Err(ShadowError::Device(DeviceError::MemoryLimit { .. } | DeviceError::OutOfMemory { .. })) => {
                // Buffers that are kept may be larger than what is needed.
                (self.structure, self.last, self.volumes) = (None, None, None);
                self.prepare_all(views)
            }
            made => made,
        };
        if made.is_err() && views > before {
            self.views = before;
            self.structure = None;
        }
        made
    }

    fn prepare_all(&mut self, views: usize) -> Result<(Arc<Structure>, Option<Arc<Volumes>>), ShadowError> {
        let structure = self.prepare()?;
        let volumes = if views == 0 { None } else { Some(self.volumes(&structure)?) };
        Ok((structure, volumes))
    }

    /// Brings the table up to date.
    fn prepare(&mut self) -> Result<Arc<Structure>, ShadowError> {
        self.renew_hidden();
        let structure = match &self.structure {
            Some(structure) => {
                let structure = Arc::clone(structure);
                self.update(&structure);
                structure
            }
            None => self.lay_out()?,
        };
        self.moved.clear();
        self.table.put_encode(self.encode_number(), 0);
        Ok(structure)
    }

    /// The number of the encode at hand.
    fn encode_number(&self) -> u32 {
        (self.encodes.load(Ordering::Relaxed) + 1) as u32
    }

    fn lay_out(&mut self) -> Result<Arc<Structure>, ShadowError> {
        self.structures = self.structures.wrapping_add(1).max(1);
        let number = Number { structure: self.structures, encode: self.encode_number() };
        self.lights.renew(number.encode);
        let (views, has_receivers) = (self.views, self.receiver_words > 0);
        self.number_figures();
        let Self { pipelines, options, meshes, casters, sources, lights, pages, table, .. } = self;
        let others = pages.bytes + self.deformed_bytes;
        let making = Making { pipelines, meshes, sources, pages, others, lights, options, views, has_receivers };
        let made = Arc::new(Structure::new(&making, casters, table, self.last.as_deref(), number)?);
        self.steps = steps(&making, casters, &made)?;
        self.volumes = None;
        self.last = Some(Arc::clone(&made));
        self.structure = Some(Arc::clone(&made));
        Ok(made)
    }

    /// Writes what moved to the table.
    fn update(&mut self, structure: &Structure) {
        let encode = self.encode_number();
        let Self { casters, meshes, lights, table, moved, .. } = self;
        let lights_moved = lights.moved;
        if lights_moved.is_empty() {
            for &key in &*moved {
                let Some(caster) = casters.get_mut(key) else { continue };
                put_change(table, caster, encode);
                table.put_lights(caster, lights);
            }
        } else {
            lights.renew(encode);
            table.put_ranges(lights);
            for &key in &structure.layout.order {
                let Some(caster) = casters.get_mut(key) else { continue };
                let is_moved = caster.is_moved;
                if is_moved {
                    put_change(table, caster, encode);
                }
                if is_moved || !caster.lights.and(&lights_moved).is_empty() {
                    table.put_lights(caster, lights);
                }
            }
        }
        if !moved.is_empty() || !lights_moved.is_empty() {
            structure.layout.occluders.write(table, &structure.layout.order, casters, meshes, lights);
        }
    }
}

/// Writes what changed of a caster to the table.
fn put_change(table: &mut Table, caster: &mut CasterEntry, encode: u32) {
    caster.is_moved = false;
    caster.version = encode;
    table.put_change(caster);
}
