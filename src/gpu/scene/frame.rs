//! The result of one encode of a scene.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::handles::{CasterHandle, LightHandle, SceneId};
use super::layout::{CasterSlots, Layout};
use super::mask::LightMask;
use super::occluded_faces::OccludedCounts;
use super::structure::Structure;
use super::volumes::Volumes;
use crate::gpu::common::requirements::check_same;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::pipelines::Convention;
use crate::gpu::shadow::shadow_pipelines::ShadowPipelines;
use crate::layout::{SceneDispatch, ShadowShape};
use crate::{Light, ShadowCamera};

/// The result of one [`Scene::encode`](crate::gpu::Scene::encode): the casters and lights of that moment. A later
/// encode of the same scene overwrites the results, or a [`deform`](crate::gpu::Scene::deform) of its models. Draws and masks
/// of this value are then refused with [`ShadowError::StaleFrame`]; its buffers of statistics are not.
///
/// A clone is cheap. It keeps the scene's buffers alive.
#[derive(Clone, Debug)]
pub struct SceneFrame {
    pub(crate) structure: Arc<Structure>,
    /// `None`: no view was asked for.
    pub(crate) volumes: Option<Arc<Volumes>>,
    pub(crate) views: Arc<[EncodedView]>,
    /// Whether there are instances of models.
    pub(crate) has_models: bool,
    pub(crate) count_batches: u32,
    pub(crate) device: wgpu::Device,
    pub(crate) scene: SceneId,
    pub(crate) lights: Arc<[(LightHandle, Light)]>,
    pub(crate) occluded: OccludedCounts,
    pub(crate) encodes: Arc<AtomicU64>,
    pub(crate) encode: u64,
}

/// A view of an encode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EncodedView {
    /// The settings that pipelines must have.
    pub(crate) convention: Convention,
    pub(crate) camera: ShadowCamera,
    /// The lights that volumes were prepared for.
    pub(crate) lights: LightMask,
}

/// The results of a group of casters for a batch of lights. A group has one page of topology and one source of
/// positions.
#[derive(Clone, Debug)]
pub struct SceneGroupResults<'a> {
    /// The group and the batch.
    pub group: usize,
    /// Bit `bit` of a mask is light `32 · batch + bit`.
    pub batch: usize,
    /// Facing masks, one `u32` a face slot ([`SceneFrame::slot_order`]). Bits of lights that are not relevant to the caster
    /// have no meaning. For polygons, twisted masks follow.
    pub facing: &'a wgpu::Buffer,
    /// One `u32` a face slot: the lights in the plane of the face, and those for which it is excluded.
    pub excluded: &'a wgpu::Buffer,
    /// The number of silhouette edges of each of 32 lights, then, from byte 256 on, [`Self::capacity`] entries for each
    /// light. An entry is an edge slot, with the winding bit as bit 31.
    pub lists: &'a wgpu::Buffer,
    /// Entries that the list of each light has room for.
    pub capacity: u32,
    /// For each view the drawn sides: for each of 32 lights two counts, then [`Self::side_capacity`] entries for each light,
    /// plain sides from the front and clipped ones from the back. An entry is as in [`Self::lists`].
    pub sides: Vec<&'a wgpu::Buffer>,
    /// Entries that the sides of each light have room for.
    pub side_capacity: u32,
    /// A [`DrawArguments`](crate::gpu::DrawArguments) for each of 32 lights.
    pub draws: &'a wgpu::Buffer,
    /// Begins with [`ExtractionStatistics`](crate::gpu::ExtractionStatistics).
    pub record: &'a wgpu::Buffer,
    /// The uniform of the stages.
    pub dispatch: SceneDispatch,
}

/// The buffers of a frame.
#[derive(Clone, Debug)]
pub struct SceneResults<'a> {
    /// The scene table, in units of 16 bytes.
    pub table: &'a wgpu::Buffer,
    /// The relevant lights of each batch and caster.
    pub relevant_lights: &'a wgpu::Buffer,
    /// The active lights of each batch and caster.
    pub active_lights: &'a wgpu::Buffer,
    /// The [`SceneStatistics`](crate::gpu::SceneStatistics).
    pub statistics: &'a wgpu::Buffer,
    /// The counts of listed chunks, then the lists.
    pub work: &'a wgpu::Buffer,
    /// The lights in each view, [`ViewLight`](crate::layout::ViewLight)s of all bits, and the sizes of the first group and
    /// batch. `None`: no view.
    pub view_lights: Option<(&'a wgpu::Buffer, ShadowShape)>,
    /// The choices: for each view, batch and caster eight words, as `rimline_testkit::choices` reads them. `None`: no view.
    pub choices: Option<&'a wgpu::Buffer>,
    /// After one word the receivers of each view, and how many words each has: a head and the levels of
    /// `wgsl/shadow/receivers.wgsl`. `None`: no view.
    pub receivers: Option<(&'a wgpu::Buffer, u64)>,
    /// For each view and light bit a [`StencilPencil`](crate::layout::StencilPencil), and for each batch of casters a row of
    /// the stage `stencil_crossings`. `None`: bounds are off.
    pub bound: Option<[&'a wgpu::Buffer; 2]>,
    /// For each group the [`ShadowDraws`](crate::layout::ShadowDraws) of each view and light bit.
    pub shadow_draws: &'a [wgpu::Buffer],
    /// All groups and batches, batch after batch in each group.
    pub groups: Vec<SceneGroupResults<'a>>,
    /// The size of all buffers but pages, in bytes.
    pub bytes: u64,
}

impl SceneFrame {
    /// The lights, in the order of their bits.
    pub fn lights(&self) -> &[(LightHandle, Light)] {
        &self.lights
    }

    /// Counts of the occluded faces of [`Scene::set_occluded_faces`](crate::gpu::Scene::set_occluded_faces) that this encode
    /// culled or ignored.
    pub fn occluded_faces(&self) -> OccludedCounts {
        self.occluded
    }

    /// The number of batches of 32 lights, up to the highest bit.
    pub fn batches(&self) -> usize {
        self.structure.buffers.batches
    }

    /// The number of groups of casters. A group has one page of topology and one source of positions. Casters of more
    /// slots than a binding holds are several groups, and each caster of polygons is one.
    pub fn groups(&self) -> usize {
        self.structure.layout.groups.len()
    }

    /// Draws the shadow volumes of all casters for a light and a view, into a pass with the attachments of `pipelines`.
    /// `view` is the index of a camera of the encode. The draw adds to the bits of the stencil that hold counts, which must
    /// be 0 if casters are counted in batches. Other bits do not change. The viewport must be that of the depth pass. Other
    /// state of the pass does not matter. The call changes the pipeline and bind groups 0 and 1, and sets the stencil
    /// reference to 0, for pipelines that add light.
    ///
    /// Use one pass a light. The pass loads the depths of the depth pass and clears the stencil to 0. After this draw, the
    /// same pass adds the light where the stencil is still 0, with a pipeline of
    /// [`ShadowFormat::light_pass_depth_stencil`](crate::gpu::ShadowFormat::light_pass_depth_stencil).
    /// [`ShadowFormat::begin_pass`](crate::gpu::ShadowFormat::begin_pass) begins such a pass. Add nothing outside of
    /// the light's range and cone, and nothing to the sides of surfaces that are turned away from it.
    ///
    /// # Errors
    /// [`ShadowError`] if the pipelines do not match the scene, the frame has no such view or light, or a later encode
    /// overwrites what is drawn. Nothing is drawn then.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        view: usize,
        light: LightHandle,
    ) -> Result<(), ShadowError> {
        let in_view = self.check_view(view)?;
        self.check_drawn(view, light)?;
        check_same(["`ShadowPipelines`", "the scene"], [pipelines.volumes.shared.device(), &self.device])?;
        in_view.convention.check_drawn_by(pipelines.volumes.convention)?;
        if (self.count_batches > 1) != pipelines.resolve.is_some() {
            return Err(ShadowError::CountBatches { count_batches: self.count_batches });
        }
        self.record(pass, pipelines, view, light);
        pass.set_stencil_reference(0);
        Ok(())
    }

    /// A view of the encode. Refuses a stale frame.
    pub(crate) fn check_view(&self, view: usize) -> Result<&EncodedView, ShadowError> {
        self.check_current()?;
        self.views.get(view).ok_or(ShadowError::NoSuchView { view, views: self.views.len() })
    }

    /// The light of a handle as it was encoded, if a view draws its shadows.
    pub(crate) fn check_drawn(&self, view: usize, light: LightHandle) -> Result<Light, ShadowError> {
        let encoded = self.check_light(light)?;
        let has_light = self.check_view(view)?.lights.contains(light);
        if has_light { Ok(encoded) } else { Err(ShadowError::NotInView { view }) }
    }

    /// The light of a handle as it was encoded.
    pub(crate) fn check_light(&self, light: LightHandle) -> Result<Light, ShadowError> {
        if light.scene != self.scene {
            return Err(ShadowError::OtherScene { what: "light" });
        }
        let encoded = self.lights.iter().find(|(handle, _)| *handle == light);
        encoded.map(|(_, light)| *light).ok_or(ShadowError::NotEncoded)
    }

    /// Draws after all checks.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        view: usize,
        light: LightHandle,
    ) {
        let Some(volumes) = &self.volumes else { return };
        for count_batch in 0..self.count_batches {
            if count_batch > 0 {
                pipelines.resolve(pass);
            }
            let of = [count_batch as usize, view, light.bit as usize];
            volumes.stages.draw(pass, &pipelines.volumes, &volumes.buffers, of);
        }
    }

    /// The [`ShadowStatistics`](crate::gpu::ShadowStatistics) of the encode, once its encoder was submitted. Usage `COPY_SRC`.
    /// `None` if no view was asked for.
    pub fn shadow_statistics(&self) -> Option<&wgpu::Buffer> {
        self.volumes.as_ref().map(|volumes| &volumes.buffers.of.statistics)
    }

    /// The [`SceneStatistics`](crate::gpu::SceneStatistics) of the encode, once its encoder was submitted. Usage `COPY_SRC`.
    /// Without casters or lights nothing is written.
    pub fn statistics(&self) -> &wgpu::Buffer {
        &self.structure.buffers.statistics
    }

    /// Refuses a frame whose results a later encode overwrites.
    ///
    /// # Errors
    /// [`ShadowError::StaleFrame`].
    pub fn check_current(&self) -> Result<(), ShadowError> {
        if self.encodes.load(Ordering::Relaxed) == self.encode { Ok(()) } else { Err(ShadowError::StaleFrame) }
    }

    /// The buffers that hold the results once the encoder is submitted.
    ///
    /// # Errors
    /// [`ShadowError::StaleFrame`] if a later encode overwrites them.
    #[doc(hidden)]
    pub fn results(&self) -> Result<SceneResults<'_>, ShadowError> {
        self.check_current()?;
        let Structure { table, buffers, parts, .. } = &*self.structure;
        let volumes = self.volumes.as_ref().map(|volumes| &volumes.buffers);
        let of = volumes.map(|volumes| &volumes.of);
        let groups = parts.iter().enumerate().map(|(number, part)| {
            let views = of.and_then(|of| of.lists.get(number));
            let sizes = volumes.and_then(|volumes| volumes.sizes.parts.get(number));
            SceneGroupResults {
                sides: views.into_iter().flatten().map(|lists| &lists.sides).collect(),
                side_capacity: sizes.map_or(0, |sizes| sizes.shape.side_capacity),
                group: part.group,
                batch: part.batch,
                facing: &part.buffers.facing,
                excluded: &part.buffers.excluded,
                lists: &part.buffers.lists,
                capacity: part.sizes.capacity,
                draws: &part.buffers.draws,
                record: &part.buffers.record,
                dispatch: part.dispatch,
            }
        });
        Ok(SceneResults {
            view_lights: volumes.map(|volumes| (&volumes.of.view_lights, volumes.sizes.shape(0))),
            choices: of.map(|of| &of.choices),
            receivers: volumes.map(|volumes| (&volumes.of.receivers, volumes.sizes.receivers)),
            bound: of.and_then(|of| of.bound.as_ref()).map(|bound| [&bound.pencils, &bound.bin_rows]),
            shadow_draws: of.map_or(&[][..], |of| &of.draws),
            table,
            relevant_lights: &buffers.relevant_lights,
            active_lights: &buffers.active_lights,
            statistics: &buffers.statistics,
            work: &buffers.work,
            groups: groups.collect(),
            bytes: self.structure.bytes() + volumes.map_or(0, |volumes| volumes.bytes),
        })
    }

    /// Whether it has the slots and buffers of another frame: casters and lights are the same, though they may have moved.
    #[doc(hidden)]
    pub fn has_layout_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.structure, &other.structure)
    }

    /// The group of a caster, and the slots of its faces in the facing masks of that group.
    #[doc(hidden)]
    pub fn face_slots(&self, caster: CasterHandle) -> Option<(usize, Range<u32>)> {
        let (_, slots) = self.slots(caster)?;
        Some((slots.group, slots.faces.clone()))
    }

    /// The face of each face slot of a caster. `None`: the order of the mesh.
    #[doc(hidden)]
    pub fn slot_order(&self, caster: CasterHandle) -> Option<&[u32]> {
        self.slots(caster)?.1.order.as_deref()
    }

    /// The index of a caster in the scene table, and that of its group.
    #[doc(hidden)]
    pub fn locate(&self, caster: CasterHandle) -> Option<(u32, usize)> {
        self.slots(caster).map(|(index, slots)| (index as u32, slots.group))
    }

    /// The index of a caster in the scene table, and its slots.
    fn slots(&self, caster: CasterHandle) -> Option<(usize, &CasterSlots)> {
        let Layout { order, slots, .. } = &self.structure.layout;
        let key = caster.key_in(self.scene).ok()?;
        order.iter().zip(slots).enumerate().find_map(|(index, (&of, slots))| (of == key).then_some((index, slots)))
    }
}
