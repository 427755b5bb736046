//! Deform on the GPU: a model's poses to world-space positions in a storage buffer.

use wgpu::BufferUsages;

use super::model_data::{ModelData, PoseLayout};
use crate::displace::{DISPLACE_GROUP, Displacement};
use crate::gpu::common::dispatch_limits::{DispatchLimits, binding};
use crate::gpu::common::memory::{MemoryError, buffer, guarded, scoped};
use crate::gpu::common::pass::{Dispatch, Pass};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::positions::PositionBuffer;
use crate::gpu::common::requirements::{DeviceError, Subject, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, entry, upload};
use crate::layout::DeformChunk;
use crate::model::{Model, Pose, PoseMismatch};

/// What a [`Deformer`] does besides morph and skin.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeformerOptions<'a> {
    /// The caller's displacement. Its own loops may take 5,000 turns a vertex; software devices end longer ones without a
    /// word.
    pub displacement: Option<&'a Displacement>,
    /// The layout of the bind group that the displacement's resources are in, if it has any. Models that share
    /// [`Pipelines`] share those of one layout, not those of equal ones.
    pub displacement_layout: Option<&'a wgpu::BindGroupLayout>,
    /// Refuse, before anything is allocated, to take more bytes of device memory than this.
    pub memory_limit: Option<u64>,
}

/// Why a deformer cannot be made, or a pose cannot be recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DeformError {
    /// The device lacks what deformation needs, is lost, or is another than the timer's.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The model does not fit the device.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The pose is not one of this model.
    #[error(transparent)]
    Pose(#[from] PoseMismatch),
    /// A vertex is the sum of more terms than one invocation may add.
    #[error(
        "a vertex of instance {instance} has {influences} influences, and {targets} morph targets have a weight other than \
         0; together they may be {limit}, because software devices end longer loops without a word. Give fewer, or deform \
         on the CPU (`cpu::deform`)"
    )]
    TooManyTerms {
        /// The instance's index.
        instance: usize,
        /// Morph targets whose weight is not 0; 0 where the influences alone are too many.
        targets: u32,
        /// The most influences that any of its vertices has.
        influences: u32,
        /// The most of both together.
        limit: u32,
    },
    /// The displacement declares resources, and no layout or bind group for them was given; or the other way round.
    #[error("the displacement's resources and the bind group given do not go together: give both or neither")]
    Resources,
    /// The device makes no pipeline of the displacement and the layout given: resources that are not as the layout
    /// says, or more of something than the device has.
    #[error("the device refuses the displacement with the layout given: {message}")]
    Pipeline {
        /// What the device said.
        message: String,
    },
}

/// The most turns that the stage's loops take in one invocation, morph targets and influences together. llvmpipe (Mesa
/// 22.3) ends an invocation's loops after 65,535 turns, all of them together and without a word; what is left is for a
/// displacement's own.
const MOST_TERMS: u32 = 60_000;

/// Deforms a model, frame after frame, into a position buffer of its own: all instances, in the vertex order of
/// [`Model::mesh`], three tightly packed `f32` a vertex, in world space.
#[derive(Debug)]
pub struct Deformer {
    device: wgpu::Device,
    positions: wgpu::Buffer,
    pose: wgpu::Buffer,
    chunks: wgpu::Buffer,
    layouts: Vec<PoseLayout>,
    /// The constant part of each dispatch's uniform, and its instance.
    plan: Vec<(usize, DeformChunk)>,
    pass: Pass,
    displaced: bool,
    has_resources: bool,
}

impl Deformer {
    /// Uploads the model's rest positions, morph targets and influences to the caller's device. `pipelines` is that device,
    /// or the [`Pipelines`] that many models share.
    ///
    /// # Errors
    /// [`DeformError`] when the model does not fit the device, a vertex has more than 60,000 influences, or the
    /// displacement's layout is missing.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        model: &Model,
        options: DeformerOptions<'_>,
    ) -> Result<Self, DeformError> {
        let pipelines = pipelines.into();
        pipelines.construct(Subject::Deform, || Self::with(&pipelines, model, options))
    }

    fn with(pipelines: &Pipelines, model: &Model, options: DeformerOptions<'_>) -> Result<Self, DeformError> {
        let device = pipelines.device();
        let has_resources = options.displacement.is_some_and(Displacement::uses_resources);
        if has_resources != options.displacement_layout.is_some() {
            return Err(DeformError::Resources);
        }
        let split = DispatchLimits::new(&device.limits());
        let data = ModelData::new(model, &split)?;
        for (instance, layout) in data.pose_layouts.iter().enumerate() {
            check_terms(instance, 0, layout)?;
        }
        let bytes = data.check(&split, options.memory_limit)?;
        // Only a caller's displacement or layout can make this fail.
        let pipeline = scoped(device, wgpu::ErrorFilter::Validation, || {
            pipelines.deform(options.displacement, options.displacement_layout)
        })
        .map_err(|message| DeformError::Pipeline { message })?;
        guarded(device, bytes, || {
            Self::build(device, model, &data, &split, pipeline, options.displacement.is_some(), has_resources)
        })
        .map_err(DeformError::from)
    }

    fn build(
        device: &wgpu::Device,
        model: &Model,
        data: &ModelData,
        split: &DispatchLimits,
        pipeline: Pipeline,
        displaced: bool,
        has_resources: bool,
    ) -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let positions = buffer(device, "positions", data.vertices * 12, storage | BufferUsages::VERTEX);
        let pose = buffer(device, "pose", data.pose_words * 4, storage);
        let [rest, morph, skin, source_vertices] = data.upload(device, model);
        let dispatches_planned = data.plan(model, split);
        let mut table = UniformTable::default();
        for planned in &dispatches_planned {
            table.push(&planned.chunk);
        }
        let chunks = table.into_buffer(device, "deform chunks");
        let stride = UniformTable::stride::<DeformChunk>() as u32;
        let dispatches = (0..)
            .zip(&dispatches_planned)
            .map(|(index, planned)| {
                let resources = [
                    ("chunk", entry::<DeformChunk>(&chunks)),
                    ("rest", binding(&rest, planned.rest.clone())),
                    ("morph", binding(&morph, planned.morph.clone())),
                    ("skin", binding(&skin, planned.skin.clone())),
                    ("pose", pose.as_entire_binding()),
                    ("source_vertices", binding(&source_vertices, planned.sources.clone())),
                    ("positions", binding(&positions, planned.positions.clone())),
                ];
                let group = Some(pipeline.bind(device, &resources));
                Dispatch {
                    group,
                    offsets: vec![index * stride],
                    ..Dispatch::over(0, 0..planned.chunk.count as usize, 0)
                }
            })
            .collect();
        Self {
            device: device.clone(),
            positions,
            pose,
            chunks,
            layouts: data.pose_layouts.clone(),
            plan: dispatches_planned.into_iter().map(|planned| (planned.instance, planned.chunk)).collect(),
            pass: Pass { pipeline, dispatches },
            displaced,
            has_resources,
        }
    }

    /// Where the positions lie once the encoder is submitted.
    pub fn positions(&self) -> PositionBuffer<'_> {
        PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 }
    }

    /// Records the deformation into `pose`; `time_s` is for the displacement, and so is `resources`, the bind group of
    /// the layout that the deformer was made with.
    ///
    /// # Errors
    /// [`DeformError`] when the pose is of another model, has more active morph targets than a vertex may be the sum of
    /// ([`DeformError::TooManyTerms`]), or `resources` is missing; nothing is recorded then.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pose: &Pose,
        time_s: f32,
        resources: Option<&wgpu::BindGroup>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), DeformError> {
        if self.has_resources != resources.is_some() {
            return Err(DeformError::Resources);
        }
        check_timer(timer.as_deref(), &self.device)?;
        let (words, target_counts) = self.pose_words(pose)?;
        let mut table = UniformTable::default();
        for &(instance, chunk) in &self.plan {
            table.push(&DeformChunk {
                target_count: target_counts[instance],
                displaced: u32::from(self.displaced),
                time: time_s,
                ..chunk
            });
        }
        upload(&self.device, encoder, &self.chunks, table.bytes())?;
        upload(&self.device, encoder, &self.pose, bytemuck::cast_slice(&words))?;
        self.pass.record_with(encoder, |_| true, timer, resources.map(|group| (DISPLACE_GROUP, group)));
        Ok(())
    }

    /// The pose as the shader reads it, and each instance's active morph targets.
    fn pose_words(&self, pose: &Pose) -> Result<(Vec<u32>, Vec<u32>), DeformError> {
        let mut words = Vec::new();
        let mut target_counts = Vec::with_capacity(self.layouts.len());
        if pose.instances().len() != self.layouts.len() {
            let (given, needed) = (pose.instances().len(), self.layouts.len());
            return Err(PoseMismatch::Instances { given, needed }.into());
        }
        for (instance, (layout, pose)) in self.layouts.iter().zip(pose.instances()).enumerate() {
            layout.check(instance, pose)?;
            words.resize(layout.palette as usize, 0);
            for row in pose.palette().iter().take(layout.joints as usize).flatten() {
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
        Ok((words, target_counts))
    }
}

/// Whether one invocation may take all terms of a vertex of instance `instance`, of whose morph targets `targets` are
/// active.
fn check_terms(instance: usize, targets: u32, layout: &PoseLayout) -> Result<(), DeformError> {
    let influences = layout.influences;
    if targets.saturating_add(influences) > MOST_TERMS {
        return Err(DeformError::TooManyTerms { instance, targets, influences, limit: MOST_TERMS });
    }
    Ok(())
}
