//! Deforms a model on the GPU: computes world-space positions of a pose in a storage buffer.

use std::sync::Mutex;

use super::model_data::{ARRAYS, ModelData, PlannedDispatch, PoseLayout};
use crate::displace::{DISPLACE_GROUP, Displacement};
use crate::gpu::common::bindings::{part, uniform, whole};
use crate::gpu::common::cache::lock;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, any_error, check, guarded, scoped};
use crate::gpu::common::pass::{Step, Workgroups, record_with};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, Program};
use crate::gpu::common::positions::PositionBuffer;
use crate::gpu::common::requirements::{Subject, check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, upload};
use crate::gpu::common::wanted::{Account, Wanted};
use crate::layout::{DeformChunk, DeformDispatch};
use crate::model::{Model, ModelError, Pose};
use crate::turns::DEFORM_TERMS;

/// The displacement of a [`Deformer`], beside morph targets and skins, and its memory limit.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeformerOptions<'a> {
    /// The caller's displacement. Its loops may take 5,000 turns for a vertex; software devices silently end longer
    /// loops.
    pub displacement: Option<&'a Displacement>,
    /// The layout of the bind group with the displacement's resources, if it has any. Models with the same
    /// [`Pipelines`] share pipelines if they give the same layout object, not if they give equal ones.
    pub displacement_layout: Option<&'a wgpu::BindGroupLayout>,
    /// The largest device memory for the deformer, in bytes. `None`: no limit. It is checked before anything is
    /// allocated.
    pub memory_limit: Option<u64>,
}

/// A pose, and what a displacement takes beside it. A `&Pose` is one, too.
#[derive(Clone, Copy, Debug)]
pub struct PoseInputs<'a> {
    /// The pose.
    pub pose: &'a Pose,
    /// The time in seconds, for the displacement.
    pub time_s: f32,
    /// The displacement's bind group, of the layout that [`DeformerOptions::displacement_layout`] had. What it binds
    /// may change before each encode, so a scene keeps nothing that was computed from the positions. The deformer holds the
    /// last one.
    pub resources: Option<&'a wgpu::BindGroup>,
    /// The most by which the displacement moves any coordinate of a vertex, for scenes. Infinity, as in [`Self::new`]:
    /// nothing is known, so every frame needs all instances. Without a displacement it has no effect.
    pub displaced_by: f32,
}

impl<'a> PoseInputs<'a> {
    /// A pose at time 0, without resources of a displacement.
    pub fn new(pose: &'a Pose) -> Self {
        Self { pose, time_s: 0.0, resources: None, displaced_by: f32::INFINITY }
    }
}

impl<'a> From<&'a Pose> for PoseInputs<'a> {
    fn from(pose: &'a Pose) -> Self {
        Self::new(pose)
    }
}

/// Why a deformer cannot be made, or a pose cannot be recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum DeformError {
    /// The device lacks what deformation needs, is lost, or is not the timer's. Or the model does not fit it.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The pose does not fit this model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A vertex is the sum of more terms than one invocation may add. `targets` is 0 if the influences alone are too many.
    #[error(
        "a vertex of instance {instance} has {influences} influences, and {targets} morph targets have a weight other than \
         0; together they may be {limit}, because software devices end longer loops without a word. Give fewer, or deform \
         on the CPU (`cpu::deform`)"
    )]
    TooManyTerms { instance: usize, targets: u32, influences: u32, limit: u32 },
    /// The displacement declares resources but the layout or the bind group is missing, or the displacement declares
    /// none and one was given.
    #[error("the displacement's resources and the bind group given do not go together: give both or neither")]
    Resources,
    /// The device cannot make a pipeline of the displacement and the layout. For example the resources do not match the
    /// layout, or there are more of them than the device allows.
    #[error("the device refuses the displacement with the layout given: {message}")]
    Pipeline { message: String },
    /// The device cannot use the bind group of the displacement. For example it has another layout than the deformer was
    /// made with, or is of another device. A buffer of it that is destroyed later is wgpu's error when
    /// an encoder is finished or submitted.
    #[error(
        "the device refuses the displacement's bind group; make it with `DeformerOptions::displacement_layout`: {message}"
    )]
    BindGroup { message: String },
}

/// Deforms a model every frame into a position buffer of its own. The buffer holds all instances in the vertex order of
/// [`Model::mesh`]: three tightly packed `f32` for each vertex, in world space.
///
/// A [`Scene`](crate::gpu::Scene) deforms its models itself, those that a frame needs.
#[derive(Debug)]
pub struct Deformer {
    device: wgpu::Device,
    buffers: Buffers,
    /// Without its arrays, which are in buffers.
    data: ModelData,
    pass: Step,
    displaced: bool,
    pub(crate) has_resources: bool,
    /// The last bind group of the displacement that the device accepted. It accepts it in each later encode, too.
    accepted: Mutex<Option<wgpu::BindGroup>>,
    /// The size of all buffers.
    pub(crate) bytes: u64,
}

/// The buffers of a deformer.
#[derive(Debug)]
struct Buffers<B = wgpu::Buffer> {
    /// The words of [`ModelData::arrays`].
    arrays: [B; 4],
    positions: B,
    pose: B,
    dispatches: B,
    /// For each instance 1 if its positions are a point, since it was not needed. It is copied to the pose, where for each
    /// instance 1 follows if it is not needed now, which an upload makes 0.
    held: B,
}

impl<B> Buffers<B> {
    /// `pose` and `dispatches` are the contents before the first encode.
    fn plan(data: &ModelData, pose: &[u32], dispatches: &UniformTable, make: &mut impl FnMut(Wanted<'_>) -> B) -> Self {
        let instances = data.layouts.len() as u64;
        Self {
            arrays: [0, 1, 2, 3]
                .map(|array: usize| make(Wanted::filled(ARRAYS[array], bytemuck::cast_slice(&data.arrays[array])))),
            positions: make(Wanted::new("positions", 12 * data.vertices).vertices()),
            pose: make(Wanted::filled("pose", bytemuck::cast_slice(pose))),
            dispatches: make(Wanted::uniforms("deform dispatches", dispatches)),
            held: make(Wanted::new("deformed", 4 * instances)),
        }
    }
}

impl Deformer {
    /// Uploads rest positions, morph targets and influences of the model to the caller's device. `pipelines` is that
    /// device, or the [`Pipelines`] that many models share.
    ///
    /// # Errors
    /// [`DeformError`] if the device lacks what deformation needs, the model does not fit it, a vertex has more than
    /// 60,000 influences, or the displacement's layout is missing.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        model: &Model,
        options: DeformerOptions<'_>,
    ) -> Result<Self, DeformError> {
        Self::beside(&pipelines.into(), model, options, (0, None))
    }

    /// The same for a scene: the bytes of its other buffers, and its limit for all bytes.
    pub(crate) fn beside(
        pipelines: &Pipelines,
        model: &Model,
        options: DeformerOptions<'_>,
        scene: (u64, Option<u64>),
    ) -> Result<Self, DeformError> {
        pipelines.construct(Subject::Deform, || Self::with(pipelines, model, options, scene))
    }

    fn with(
        pipelines: &Pipelines,
        model: &Model,
        options: DeformerOptions<'_>,
        (used, most): (u64, Option<u64>),
    ) -> Result<Self, DeformError> {
        let device = pipelines.device();
        let has_resources = options.displacement.is_some_and(Displacement::uses_resources);
        if has_resources != options.displacement_layout.is_some() {
            return Err(DeformError::Resources);
        }
        let split = DispatchLimits::new(&device.limits());
        let data = ModelData::new(model, &split)?;
        for (instance, layout) in data.layouts.iter().enumerate() {
            check_terms(instance, 0, layout)?;
        }
        let displaced = options.displacement.is_some();
        let (pose, dispatches) = (data.first_pose(), data.uniforms(displaced, 0.0));
        let mut account = Account::default();
        Buffers::<()>::plan(&data, &pose, &dispatches, &mut |wanted| account.note(&wanted));
        let bytes = check(&account.all, split.buffer, options.memory_limit)?;
        let whole = [("the model", bytes), ("the rest of the scene", used)];
        check(&whole.map(|(label, bytes)| Allocation { label, bytes }), u64::MAX, most)?;
        // Only a caller's displacement or layout can make this fail.
        let pipeline = scoped(device, wgpu::ErrorFilter::Validation, || {
            pipelines.get(&Program::deform(options.displacement, options.displacement_layout))
        })
        .map_err(|message| DeformError::Pipeline { message })?;
        let made = guarded(device, bytes, || {
            let buffers = Buffers::plan(&data, &pose, &dispatches, &mut |wanted| wanted.make(device));
            Self::build(device, data, buffers, &pipeline, displaced)
        })?;
        Ok(Self { has_resources, bytes, ..made })
    }

    fn build(
        device: &wgpu::Device,
        mut data: ModelData,
        buffers: Buffers,
        pipeline: &Pipeline,
        displaced: bool,
    ) -> Self {
        data.arrays = <[Vec<u32>; 4]>::default();
        let Buffers { arrays, positions, pose, dispatches, .. } = &buffers;
        let bind = |(offset, planned): (usize, &PlannedDispatch)| {
            let of_array = |array: usize| part(&arrays[array], planned.bound[array].clone());
            pipeline.dispatch(device, Workgroups::Known([planned.workgroups, 1]), |name| {
                Some(match name {
                    "dispatch" => uniform::<DeformDispatch>(dispatches, offset as u32),
                    "rest" => of_array(0),
                    "morph" => of_array(1),
                    "skin" => of_array(2),
                    "source_vertices" => of_array(3),
                    "pose" => whole(pose),
                    "positions" => part(positions, planned.bound[4].clone()),
                    _ => return None,
                })
            })
        };
        let offsets = (0..).step_by(UniformTable::stride::<DeformDispatch>());
        let pass = pipeline.pass(offsets.zip(&data.dispatches).map(bind));
        let (device, accepted) = (device.clone(), Mutex::default());
        Self { device, buffers, data, pass, displaced, has_resources: false, accepted, bytes: 0 }
    }

    /// The positions, once the encoder was submitted. The buffer stays the same, and has the usages `VERTEX` and `STORAGE`.
    pub fn positions(&self) -> PositionBuffer<'_> {
        PositionBuffer { buffer: &self.buffers.positions, offset: 0, stride: 12 }
    }

    /// The positions of instance number `instance`, once the encoder was submitted. `None` if the model has fewer instances.
    pub fn instance_positions(&self, instance: usize) -> Option<PositionBuffer<'_>> {
        let offset = self.data.layouts.get(instance)?.positions;
        Some(PositionBuffer { buffer: &self.buffers.positions, offset, stride: 12 })
    }

    /// Records the deformation into a pose: a `&Pose`, or [`PoseInputs`].
    ///
    /// # Errors
    /// [`DeformError`] if the pose does not fit the model, has too many active morph targets
    /// ([`DeformError::TooManyTerms`]), or resources of the displacement are missing or refused. Nothing is recorded then.
    pub fn encode<'a>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pose: impl Into<PoseInputs<'a>>,
    ) -> Result<(), DeformError> {
        self.encode_timed(encoder, pose, None)
    }

    /// The same with a timestamp around the stage.
    ///
    /// # Errors
    /// The errors of [`Self::encode`], and [`DeformError::Device`] for a timer of another device.
    pub fn encode_timed<'a>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pose: impl Into<PoseInputs<'a>>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), DeformError> {
        let PoseInputs { pose, time_s, resources, .. } = pose.into();
        self.check_resources(resources)?;
        check_timer(timer.as_deref(), &self.device)?;
        let (words, uniforms) = (self.pose_words(pose)?, self.uniforms(time_s));
        let uploads: Vec<_> = self.uploads(&words, &uniforms).collect();
        upload(&self.device, encoder, &uploads)?;
        self.record(encoder, None, resources, timer);
        Ok(())
    }

    /// Refuses a bind group without a displacement that has resources, and the other way round. A bind group that would
    /// spoil the caller's encoder is tried in another one, once.
    pub(crate) fn check_resources(&self, resources: Option<&wgpu::BindGroup>) -> Result<(), DeformError> {
        if self.has_resources != resources.is_some() {
            return Err(DeformError::Resources);
        }
        let Some(group) = resources else { return Ok(()) };
        // A browser's answer comes too late, so the error is left to the caller's encoder.
        if cfg!(target_family = "wasm") || lock(&self.accepted).as_ref() == Some(group) {
            return Ok(());
        }
        let tried = any_error(&self.device, || {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record_with([&self.pass], &mut encoder, None, Some((DISPLACE_GROUP, group)));
            drop(encoder.finish());
        });
        tried.map_err(|message| {
            check_alive(&self.device).map_or_else(DeformError::Device, |()| DeformError::BindGroup { message })
        })?;
        *lock(&self.accepted) = Some(group.clone());
        Ok(())
    }

    /// The uniforms of the dispatches.
    pub(crate) fn uniforms(&self, time_s: f32) -> UniformTable {
        self.data.uniforms(self.displaced, time_s)
    }

    /// The buffers that [`Self::record`] reads, and what is to be uploaded to them.
    pub(crate) fn uploads<'a>(
        &'a self,
        words: &'a [u32],
        uniforms: &'a UniformTable,
    ) -> impl Iterator<Item = (&'a wgpu::Buffer, &'a [u8])> {
        let Buffers { pose, dispatches, .. } = &self.buffers;
        let uploads = [(dispatches, uniforms.bytes()), (pose, bytemuck::cast_slice(words))];
        uploads.into_iter().filter(|_| !self.data.dispatches.is_empty())
    }

    /// Records the deformation of what was uploaded. `states` has a word for each instance, from a byte offset on: 1 if
    /// it is culled, so that all its positions become (0, 0, 0), else 2.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        states: Option<(&wgpu::Buffer, u64)>,
        resources: Option<&wgpu::BindGroup>,
        timer: Option<&mut StageTimer>,
    ) {
        if !self.data.dispatches.is_empty() {
            let Buffers { pose, held, .. } = &self.buffers;
            let bytes = 4 * self.data.layouts.len() as u64;
            encoder.copy_buffer_to_buffer(held, 0, pose, 4 * self.data.before, bytes);
            if let Some((words, from)) = states {
                encoder.copy_buffer_to_buffer(words, from, pose, 4 * self.data.before + bytes, bytes);
            }
            // The same commands write what the positions are, so an encoder that is dropped changes both or neither.
            encoder.copy_buffer_to_buffer(pose, 4 * self.data.before + bytes, held, 0, bytes);
        }
        record_with([&self.pass], encoder, timer, resources.map(|group| (DISPLACE_GROUP, group)));
    }

    /// The words of an instance's pose among those of all.
    pub(crate) fn words_of<'a>(&self, instance: usize, words: &'a [u32]) -> &'a [u32] {
        let at =
            |instance: usize| self.data.layouts.get(instance).map_or(words.len(), |layout| layout.palette as usize);
        words.get(at(instance)..at(instance + 1).min(words.len())).unwrap_or_default()
    }

    /// The chunks and the pose in the words that the shader reads.
    pub(crate) fn pose_words(&self, pose: &Pose) -> Result<Vec<u32>, DeformError> {
        let mut words = vec![0; self.data.chunks.len() * size_of::<DeformChunk>() / 4];
        let mut target_counts = Vec::with_capacity(self.data.layouts.len());
        pose.check_instances(self.data.layouts.len())?;
        for (instance, (layout, pose)) in self.data.layouts.iter().zip(pose.instances()).enumerate() {
            pose.check_counts(instance, layout.joints as usize, layout.target_count as usize)?;
            words.resize(layout.palette as usize, 0);
            for row in pose.palette().iter().take(layout.joints as usize).flat_map(|matrix| matrix.rows()) {
                words.extend(row.map(f32::to_bits));
            }
            words.resize(layout.targets as usize, 0);
            let active = (0..).zip(pose.morph_weights()).filter(|(_, weight)| **weight != 0.0);
            let before = words.len();
            words.extend(active.flat_map(|(target, weight)| [target, weight.to_bits()]));
            let targets = ((words.len() - before) / 2) as u32;
            check_terms(instance, targets, layout)?;
            target_counts.push(targets);
        }
        let chunk = |&(instance, chunk): &(usize, DeformChunk)| {
            let target_count = target_counts.get(instance).copied().unwrap_or_default();
            DeformChunk { target_count, ..chunk }
        };
        let chunks: Vec<DeformChunk> = self.data.chunks.iter().map(chunk).collect();
        let chunks: &[u32] = bytemuck::cast_slice(&chunks);
        words.splice(..chunks.len(), chunks.iter().copied());
        Ok(words)
    }
}

/// Checks that one invocation may add all terms of a vertex of instance number `instance`, with `targets` active morph
/// targets.
fn check_terms(instance: usize, targets: u32, layout: &PoseLayout) -> Result<(), DeformError> {
    let influences = layout.influences;
    if targets.saturating_add(influences) > DEFORM_TERMS {
        return Err(DeformError::TooManyTerms { instance, targets, influences, limit: DEFORM_TERMS });
    }
    Ok(())
}
