//! Encodes of a scene: brings table, buffers and volumes up to date, and records the stages.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use bytemuck::Zeroable;

use super::frame::{EncodedView, SceneFrame};
use super::layout::Layout;
use super::needs::Needs;
use super::options::Measuring;
use super::receivers::{self, ReceiverState, ViewVersion};
use super::scene::Scene;
use super::stages::steps;
use super::structure::{Inputs, Room, Structure};
use super::table::Part;
use super::view::{FrameInputs, View};
use super::volumes::Volumes;
use crate::ShadowCamera;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::pass::record;
use crate::gpu::common::requirements::check_timer;
use crate::gpu::common::uniforms::upload;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::pipelines::Convention;
use crate::layout::{ShadowLight, ShadowView, ViewLight};

impl Scene {
    /// Records the extraction of all casters for all lights, and the shadow volumes of all views. One encoder may hold several
    /// encodes. Each sees the scene of its moment, and overwrites the results of the one before. An encoder may be dropped, or
    /// submitted after a later one. Memory is kept for the most views, and the largest [`View::depth`], of an encode so far.
    ///
    /// # Errors
    /// [`ShadowError`] if a camera or its [`View::depth`] is refused, a buffer of a caster was destroyed,
    /// the scene does not fit the device or the memory limit, or the device is lost or not the timer's. Nothing is recorded
    /// then, and the next encode is not affected.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: FrameInputs<'_>,
    ) -> Result<SceneFrame, ShadowError> {
        let mut timer = inputs.timer;
        check_timer(timer.as_deref(), self.pipelines.device())?;
        let shadow_views = Self::check_views(inputs.views)?;
        let views = &*self.check_depths(inputs.views)?;
        let words = views.iter().filter_map(|view| view.depth).map(|depth| depth.words()).max().unwrap_or(0);
        let deformed = self.take_deformed(views, &shadow_views);
        let (structure, volumes) = self.prepare(views.len(), words)?;
        let needs = if deformed.is_some() { None } else { self.find_needs(views, &shadow_views)? };
        let needed_states_offset = if self.deforming.is_empty() { 0 } else { structure.needed_states_offset };
        let origin = views.iter().flat_map(|view| view.camera.origin).fold(0.0_f32, |size, c| size.max(c.abs()));
        self.table.put_encode(self.encode_number(), needed_states_offset, origin);
        let receiver_steps = match volumes.as_ref().filter(|_| !structure.parts.is_empty()) {
            Some(volumes) => receivers::steps(&self.pipelines, views, &shadow_views, &volumes.buffers)?,
            None => Vec::new(),
        };
        self.update_view_versions(&shadow_views, views);
        self.record_uploads(encoder, &structure, volumes.as_deref(), views, needs.as_ref())?;
        let needed_states = needs.map(|needs| self.record_needs(encoder, &needs, timer.as_deref_mut())).or(deformed);
        if let Some(words) = needed_states.filter(|_| !structure.parts.is_empty()) {
            let (to, bytes) = (4 * u64::from(needed_states_offset), 4 * self.deforming.len() as u64);
            encoder.copy_buffer_to_buffer(&words, 0, &structure.buffers.work, to, bytes);
        }
        // All clears come first, because each one between stages ends a compute pass.
        let stages = volumes.as_ref().filter(|_| structure.buffers.batches > 0).map(|volumes| &volumes.stages);
        let clears = stages.into_iter().flat_map(|stages| &stages.clears);
        let volume_steps = stages.into_iter().flat_map(|stages| &stages.steps);
        let steps = clears.chain(&self.steps).chain(&receiver_steps).chain(volume_steps);
        record(steps, encoder, timer);
        Ok(self.finish(structure, volumes, views))
    }

    /// Records the uploads of an encode: the inputs of models, the table, the lights of views and of polygons.
    fn record_uploads(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        structure: &Structure,
        volumes: Option<&Volumes>,
        views: &[View<'_>],
        needs: Option<&Needs>,
    ) -> Result<(), ShadowError> {
        let view_lights = volumes.map_or_else(Vec::new, |volumes| self.view_lights(volumes, views));
        let light_batches = structure.light_batches(&self.content);
        let uploaded: &[Part] = self.table.parts.get(..structure.layout.uploaded).unwrap_or_default();
        let mut uploads: Vec<(&wgpu::Buffer, &[u8])> = Vec::new();
        uploads.extend(needs.into_iter().flat_map(|needs| self.deform_uploads(needs)));
        if !structure.parts.is_empty() {
            uploads.push((&structure.table, bytemuck::cast_slice(uploaded)));
            uploads.extend(
                volumes.map(|volumes| (&volumes.buffers.of.view_lights, bytemuck::cast_slice(&view_lights[..]))),
            );
            uploads.extend(light_batches.iter().map(|(buffer, batch)| (buffer, bytemuck::bytes_of(batch))));
        }
        upload(self.pipelines.device(), encoder, &uploads)?;
        Ok(())
    }

    /// Counts the encode that was recorded, and makes its result.
    fn finish(&mut self, structure: Arc<Structure>, volumes: Option<Arc<Volumes>>, views: &[View<'_>]) -> SceneFrame {
        let encode = self.encodes.fetch_add(1, Ordering::Relaxed) + 1;
        self.content.pages.reclaim();
        let encoded_view = |&View { camera, lights, .. }: &View<'_>| EncodedView {
            convention: self.convention(&camera),
            camera,
            lights,
        };
        SceneFrame {
            structure,
            volumes,
            views: views.iter().map(encoded_view).collect(),
            has_models: !self.deforming.is_empty(),
            count_batches: self.options.stencil.count_batches,
            device: self.pipelines.device().clone(),
            scene: self.id,
            lights: self.content.lights.listed(),
            occluded: self.count_occluded(),
            encodes: Arc::clone(&self.encodes),
            encode,
        }
    }

    /// The cameras in the layout of the stages.
    pub(super) fn check_views(views: &[View<'_>]) -> Result<Vec<ShadowView>, ShadowError> {
        let check = |(number, view): (usize, &View<'_>)| {
            view.camera.view().map_err(|error| ShadowError::ViewCamera { view: number, error })
        };
        views.iter().enumerate().map(check).collect()
    }

    /// The views, without depths if receivers cull nothing.
    fn check_depths<'a>(&self, views: &[View<'a>]) -> Result<Vec<View<'a>>, ShadowError> {
        let cull = !self.options.measuring.has(Measuring::CULLED_BY_RECEIVERS);
        let check = |(number, view): (usize, &View<'a>)| {
            let checked = view.depth.map_or(Ok(()), |depth| depth.check(number));
            checked.map(|()| View { depth: view.depth.filter(|_| cull), ..*view })
        };
        views.iter().enumerate().map(check).collect()
    }

    /// The settings that pipelines must have to draw a camera's volumes.
    fn convention(&self, camera: &ShadowCamera) -> Convention {
        let counting = self.options.counting;
        let is_unclipped = counting.may_fail() && camera.has_far_plane();
        let (count_bits, mirrors) = (self.options.stencil.count_bits, camera.mirrors());
        Convention { counting, depth: camera.depth, is_unclipped, count_bits, mirrors }
    }

    /// The inputs of structures and volumes.
    fn inputs(&self) -> Inputs<'_> {
        Inputs {
            pipelines: &self.pipelines,
            content: &self.content,
            others: self.content.pages.bytes + self.deformed_bytes(),
            options: &self.options,
            room: self.room,
        }
    }

    /// Gives this encode's version to views that changed.
    fn update_view_versions(&mut self, shadow_views: &[ShadowView], views: &[View<'_>]) {
        let encode = self.encode_number();
        let before = std::mem::take(&mut self.view_versions);
        let version = |(number, (&view, given)): (usize, (&ShadowView, &View<'_>))| {
            let receivers = ReceiverState::of(given.depth.as_ref());
            let is_same = |before: &&ViewVersion| {
                let is_same_view = bytemuck::bytes_of(&before.view) == bytemuck::bytes_of(&view);
                is_same_view && before.receivers == receivers && receivers != ReceiverState::Changing
            };
            let version = before.get(number).filter(is_same).map_or(encode, |before| before.version);
            ViewVersion { view, version, receivers }
        };
        self.view_versions = shadow_views.iter().zip(views).enumerate().map(version).collect();
    }

    /// Each light in each view. Unused views are zero, and so are the lights that a view leaves out.
    fn view_lights(&self, volumes: &Volumes, views: &[View<'_>]) -> Vec<ViewLight> {
        let sizes = &volumes.buffers.sizes;
        let mut all = Vec::with_capacity(sizes.view_lights());
        for (number, (given, &ViewVersion { view, version, .. })) in views.iter().zip(&self.view_versions).enumerate() {
            let receivers = if given.depth.is_some() { receivers::offset(number, sizes.receivers) } else { 0 };
            for bit in 0..sizes.lights as u32 {
                let version = [version, receivers, 0, 0];
                let in_view = || ViewLight { version, ..self.light_in_view(&given.camera, view, bit) };
                all.push(if given.lights.has(bit) { in_view() } else { ViewLight::zeroed() });
            }
        }
        all.resize(sizes.view_lights(), ViewLight::zeroed());
        all
    }

    /// A view, with the light of a bit as its camera sees it, or zeros for the light.
    pub(super) fn light_in_view(&self, camera: &ShadowCamera, view: ShadowView, bit: u32) -> ViewLight {
        let light = self.content.lights.get(bit).map_or_else(ShadowLight::zeroed, |light| camera.light(&view, light));
        ViewLight { view, light, ..ViewLight::zeroed() }
    }

    /// Updates the structure and the volumes, with room for `views` views and `words` words for the receivers of each.
    pub(super) fn prepare(
        &mut self,
        views: usize,
        words: u64,
    ) -> Result<(Arc<Structure>, Option<Arc<Volumes>>), ShadowError> {
        let before = self.room;
        self.set_room(Room { views: before.views.max(views), receiver_words: before.receiver_words.max(words) });
        let made = match self.prepare_in_room(views) {
            Err(ShadowError::Device(DeviceError::MemoryLimit { .. } | DeviceError::OutOfMemory { .. })) => {
                // Reused buffers may be larger than needed, and the steps hold those of what was removed.
                (self.structure, self.last, self.volumes) = (None, None, None);
                self.steps.clear();
                self.removed.clear();
                self.prepare_in_room(views)
            }
            made => made,
        };
        if made.is_err() {
            self.set_room(before);
        }
        made
    }

    fn set_room(&mut self, room: Room) {
        let before = std::mem::replace(&mut self.room, room);
        // With receivers the table also has room for the ends of volumes.
        if room.views != before.views || room.has_receivers() != before.has_receivers() {
            self.structure = None;
        }
        if room.receiver_words != before.receiver_words {
            self.volumes = None;
        }
    }

    /// Updates the table, or makes a new layout if the structure is `None`, and the volumes if there are views.
    fn prepare_in_room(&mut self, views: usize) -> Result<(Arc<Structure>, Option<Arc<Volumes>>), ShadowError> {
        self.update_occluded_faces();
        let structure = match self.structure.clone() {
            Some(structure) => {
                structure.check_positions(&self.pipelines)?;
                self.update(&structure);
                structure
            }
            None => self.lay_out()?,
        };
        self.moved.clear();
        if views == 0 {
            return Ok((structure, None));
        }
        let volumes = match self.volumes.clone() {
            Some(volumes) => volumes,
            None => Arc::new(Volumes::new(&self.inputs(), &structure)?),
        };
        self.volumes = Some(Arc::clone(&volumes));
        Ok((structure, Some(volumes)))
    }

    /// The number of the encode that is being recorded.
    fn encode_number(&self) -> u32 {
        (self.encodes.load(Ordering::Relaxed) + 1) as u32
    }

    fn lay_out(&mut self) -> Result<Arc<Structure>, ShadowError> {
        self.structures = self.structures.wrapping_add(1).max(1);
        let encode = self.encode_number();
        self.content.lights.update_versions(encode);
        self.index_deforming();
        let limits = DispatchLimits::new(&self.pipelines.device().limits());
        let layout = Layout::new(&mut self.table, &mut self.content, encode, &limits)?;
        let inputs = self.inputs();
        let made = Arc::new(Structure::new(&inputs, layout, &self.table, self.last.as_deref(), self.structures)?);
        self.steps = steps(&inputs, &made)?;
        self.volumes = None;
        self.last = Some(Arc::clone(&made));
        self.removed.clear();
        self.structure = Some(Arc::clone(&made));
        Ok(made)
    }

    /// Writes changed casters and lights to the table.
    fn update(&mut self, structure: &Structure) {
        let encode = self.encode_number();
        let Self { content, table, moved, .. } = self;
        let moved_lights = content.lights.moved;
        if moved.is_empty() && moved_lights.is_empty() {
            return;
        }
        let order = &structure.layout.order;
        let mut changed = &*moved;
        if !moved_lights.is_empty() {
            content.lights.update_versions(encode);
            table.put_ranges(&content.lights);
            changed = order;
        }
        for &key in changed {
            let Some(caster) = content.casters.get_mut(key) else { continue };
            if caster.is_moved || !caster.lights.and(&moved_lights).is_empty() {
                if std::mem::take(&mut caster.is_moved) {
                    caster.version = encode;
                    table.put_change(caster);
                }
                table.put_lights(caster, &content.lights);
            }
        }
        structure.layout.occluders.write(table, order, content);
    }
}
