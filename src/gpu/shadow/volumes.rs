//! Shadow volumes of one caster.

use wgpu::BufferUsages;

use super::choice::{Choice, Groups};
use super::draws::DrawGroups;
use super::pipelines::{Convention, Layouts, ShadowPipelines};
use crate::gpu::buffers::Shape;
use crate::gpu::extractor::Extractor;
use crate::gpu::frame::{UniformTable, upload};
use crate::gpu::include::IncludeError;
use crate::gpu::memory::{Allocation, MemoryError, buffer, check, guarded, padded};
use crate::gpu::pipelines::group;
use crate::gpu::positions::{PositionBuffer, PositionError};
use crate::gpu::split::{Split, WORKGROUP, binding};
use crate::gpu::timer::StageTimer;
use crate::layout::{ShadowDraw, ShadowDraws, ShadowLight, ShadowShape, ShadowStatistics, ShadowView};
use crate::light;
use crate::shadow::{CameraError, RangedLight, ShadowCamera, ShadowLightError, check_ranged_lights};
use crate::{Counting, DepthDirection, Light, Mesh};

/// How a caster casts.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct ShadowOptions {
    /// Every face casts, also of a closed mesh, whose faces averted from the light suffice. Right, too, and slower.
    pub every_face: bool,
    /// Entries that each of a light's two lists of cap faces has room for. `None`: with z-fail, ZP+ as published and
    /// [`Self::end_at_range`] every face, else 1,024 and sixteen times the square root of the faces; but never more than
    /// fit one binding (8 bytes an entry for each of up to 32 lights) and [`Self::memory_limit`]. A list that overflows
    /// loses nothing: its draw goes over all faces.
    pub cap_capacity: Option<u32>,
    /// Skip the caster for lights whose shadow of it the camera cannot see.
    pub skip_unseen: bool,
    /// Volumes end beyond their light's range, at a sphere around the light (Bergeron 1986), instead of at infinity, but
    /// where ZP+ counts them or the light may be within the caster's box. Receivers out of range hold any count then: they
    /// must not be lit by that light. Less to fill; z-pass then draws dark caps, too.
    pub end_at_range: bool,
    /// Find what no stencil count of the caster exceeds, for [`ShadowStatistics::count_bound`] and
    /// [`ShadowStatistics::may_wrap`]: a pass over the silhouettes. Counts wrap exactly at 256, so a point in a multiple of
    /// 256 volumes at once appears lit. The casters' bounds add up.
    pub bound_counts: bool,
    /// As of [`crate::gpu::ExtractorOptions`].
    pub memory_limit: Option<u64>,
}

impl Default for ShadowOptions {
    /// Averted faces where they suffice, lists by the mesh, unseen shadows skipped, infinite volumes, no bound on counts, no memory
    /// limit.
    fn default() -> Self {
        Self {
            every_face: false,
            cap_capacity: None,
            skip_unseen: true,
            end_at_range: false,
            bound_counts: false,
            memory_limit: None,
        }
    }
}

/// Why shadow volumes cannot be made or recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowError {
    /// The extractor makes no lists or no facing masks, or its arrays do not fit one binding.
    #[error(transparent)]
    Include(#[from] IncludeError),
    /// The volumes' own buffers do not fit the device.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The position buffer is refused.
    #[error(transparent)]
    Positions(#[from] PositionError),
    /// The camera is refused.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The lights are refused.
    #[error(transparent)]
    Light(#[from] ShadowLightError),
    /// The volumes read the lists of the extractor that they were made for.
    #[error("these volumes were made for another extractor; encode them with the one given to `ShadowVolumes::new`")]
    OtherExtractor,
    /// The lists of some lights are not there.
    #[error(
        "{given} lights given, and the extractor's last encode was for {encoded}; encode the extractor for all of them \
         before the volumes"
    )]
    NotExtracted {
        /// Lights given.
        given: usize,
        /// Lights of the extractor's last encode.
        encoded: usize,
    },
    /// The lists at a light's place are another light's.
    #[error(
        "light {index} is not, bit for bit, light {index} of the extractor's last encode; encode the extractor for the same \
         lights in the same order before the volumes"
    )]
    OtherLight {
        /// Position in the list.
        index: usize,
    },
    /// Near and far would be taken for each other.
    #[error(
        "the camera's depth is {camera:?}, and the pipelines that the volumes were made with have {pipelines:?}; set \
         `ShadowFormat::depth` to the camera's"
    )]
    Depth {
        /// Of the camera.
        camera: DepthDirection,
        /// Of the pipelines.
        pipelines: DepthDirection,
    },
    /// Dark caps would be cut off at the camera's far plane.
    #[error(
        "{counting:?} with a camera that has a far plane needs `ShadowFormat::has_far_plane` (and \
         `Features::DEPTH_CLIP_CONTROL`); set it, use an infinite far plane, or `Counting::Auto`"
    )]
    FarPlane {
        /// The counting method.
        counting: Counting,
    },
}

/// Why volumes cannot be drawn with these pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowDrawError {
    /// What was listed is not what the pipelines draw.
    #[error(
        "volumes made for {volumes:?} drawn with pipelines of {pipelines:?}; draw them with pipelines of the counting \
         method given to `ShadowVolumes::new`"
    )]
    Counting {
        /// Of the volumes.
        volumes: Counting,
        /// Of the pipelines given.
        pipelines: Counting,
    },
    /// The pipelines take far for near.
    #[error(
        "volumes made for {volumes:?} depth drawn with pipelines of {pipelines:?} depth; take a `ShadowFormat` of that"
    )]
    Depth {
        /// Of the volumes.
        volumes: DepthDirection,
        /// Of the pipelines given.
        pipelines: DepthDirection,
    },
    /// The pipelines clip at the far plane, unlike those that the volumes were made with.
    #[error(
        "volumes made for z-fail with a far plane drawn with pipelines for none; set `ShadowFormat::has_far_plane`"
    )]
    FarPlane,
}

/// What the stages and draws share.
#[derive(Debug)]
pub(super) struct Buffers {
    pub(super) shape: wgpu::Buffer,
    pub(super) view: wgpu::Buffer,
    pub(super) draw_lights: wgpu::Buffer,
    pub(super) faces: wgpu::Buffer,
    pub(super) bounds: wgpu::Buffer,
    pub(super) lights: wgpu::Buffer,
    pub(super) cap_dispatches: wgpu::Buffer,
    pub(super) cap_counts: wgpu::Buffer,
    /// One a word of lights.
    pub(super) cap_lists: Vec<wgpu::Buffer>,
    pub(super) draws: wgpu::Buffer,
    pub(super) statistics: wgpu::Buffer,
}

/// The shadow volumes of one caster, for the lights of its [`Extractor`]. Records compute passes into the caller's encoder
/// after the extraction's, and draws into the caller's render pass; nothing is read back.
///
/// A light's stencil pass clears the stencil to 0, draws the volumes of all casters, and then the light is added where
/// the stencil is still 0. What casts must be in the depth buffer before.
#[derive(Debug)]
pub struct ShadowVolumes {
    buffers: Buffers,
    choice: Choice,
    layouts: Layouts,
    groups: Option<DrawGroups>,
    shape: ShadowShape,
    max_lights: usize,
    convention: Convention,
    bound_to: Option<(wgpu::Buffer, u64, u64)>,
}

impl ShadowVolumes {
    /// Buffers for the mesh that `extractor` was made for, on the same device as `pipelines`; what the volumes compute with
    /// is kept there, too.
    ///
    /// # Errors
    /// [`ShadowError`] when the extractor lacks lists or facing masks, or the mesh does not fit the device.
    pub fn new(
        pipelines: &ShadowPipelines,
        extractor: &Extractor,
        mesh: &Mesh,
        options: ShadowOptions,
    ) -> Result<Self, ShadowError> {
        let (device, split, extraction) = extractor.parts();
        let results = extractor.results();
        if results.lists.is_empty() || results.facing.is_empty() {
            return Err(IncludeError::NoLists.into());
        }
        let face_count = extraction.faces;
        let lists_all = options.end_at_range || matches!(pipelines.counting(), Counting::ZFail | Counting::ZpPlusPaper);
        let cap_capacity = options.cap_capacity.map_or_else(
            || {
                let wanted = if lists_all { face_count } else { 1024 + 16 * face_count.isqrt() };
                wanted.min(fitting_capacity(extraction, split, options.memory_limit))
            },
            |capacity| capacity as usize,
        );
        let cap_capacity = cap_capacity.clamp(1, face_count.max(1));
        let workgroups = device.limits().max_compute_workgroups_per_dimension;
        let most = |wanted: usize| (wanted as u32).clamp(1, workgroups);
        let shape = ShadowShape {
            lights: 0,
            faces: face_count as u32,
            edges: extraction.edges as u32,
            capacity: extraction.capacity,
            cap_capacity: cap_capacity as u32,
            averted: u32::from(mesh.is_closed() && !options.every_face),
            counting: pipelines.counting().code(),
            skip_unseen: u32::from(options.skip_unseen),
            position_offset: 0,
            position_stride: 0,
            cap_groups: most(face_count.div_ceil(WORKGROUP as usize)),
            end_at_range: u32::from(options.end_at_range),
        };
        if extractor.faces().size() > split.binding {
            let (bytes, limit) = (extractor.faces().size(), split.binding);
            return Err(MemoryError::Binding { what: "faces", bytes, limit }.into());
        }
        let buffers = Buffers::new(extractor, cap_capacity, options.memory_limit)?;
        let choice = Choice::new(pipelines.shared(), &buffers, &results, pipelines.counting(), options);
        Ok(Self {
            buffers,
            choice,
            layouts: pipelines.layouts.clone(),
            groups: None,
            shape,
            max_lights: extraction.max_lights,
            convention: pipelines.convention,
            bound_to: None,
        })
    }

    /// Records, after the extraction's encode for the same positions and lights, what chooses and lists for `camera`.
    /// Fewer lights than were extracted are fine: the first ones.
    ///
    /// # Errors
    /// [`ShadowError`] when positions, camera or lights are refused, or do not go with the extractor's last encode or with
    /// the pipelines of [`Self::new`]; nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        extractor: &Extractor,
        positions: PositionBuffer<'_>,
        camera: &ShadowCamera,
        lights: &[RangedLight],
        timer: Option<&mut StageTimer>,
    ) -> Result<(), ShadowError> {
        check_ranged_lights(lights, self.max_lights)?;
        self.check(extractor, camera, lights)?;
        let view = camera.view()?;
        let (device, split, extraction) = extractor.parts();
        let bound = positions.bind(extraction.vertices, split)?;
        self.bind(extractor, positions)?;
        let shape = ShadowShape {
            lights: lights.len() as u32,
            position_offset: bound.offset_words,
            position_stride: bound.stride_words,
            ..self.shape
        };
        let seen: Vec<ShadowLight> = lights.iter().map(|&light| camera.light(&view, light)).collect();
        let words = light::words(lights.len());
        let buffers = &self.buffers;
        upload(device, encoder, &buffers.shape, bytemuck::bytes_of(&shape));
        upload(device, encoder, &buffers.view, bytemuck::bytes_of(&view));
        upload(device, encoder, &buffers.lights, bytemuck::cast_slice(&seen));
        upload(device, encoder, &buffers.bounds, bytemuck::cast_slice(&[u32::MAX, u32::MAX, u32::MAX, 0, 0, 0]));
        upload(device, encoder, &buffers.cap_dispatches, bytemuck::cast_slice(&[0_u32, 1, 1].repeat(words)));
        encoder.clear_buffer(&buffers.cap_counts, 0, None);
        encoder.clear_buffer(&buffers.draws, 0, None);
        encoder.clear_buffer(&buffers.statistics, 0, None);
        // A thread takes some 64 faces: few atomics, and still all cores.
        let groups = Groups {
            bounds: (extraction.faces as u32).div_ceil(64 * 64).clamp(1, 1024),
            lights: (lights.len() as u32).div_ceil(64),
        };
        self.choice.record(encoder, buffers, groups, lights.len(), timer);
        Ok(())
    }

    /// Draws the volume of light `light`, as it was encoded, into a pass whose attachments are those of `pipelines`.
    /// Counts up from whatever the stencil holds; no other state of the pass matters, and bind groups 0 and 1 and the
    /// pipeline are left changed. A light that was not encoded draws nothing.
    ///
    /// `pipelines` may be others than those of [`Self::new`], for other attachments, as long as they count alike.
    ///
    /// # Errors
    /// [`ShadowDrawError`] when they do not; nothing is drawn then.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        light: usize,
    ) -> Result<(), ShadowDrawError> {
        let (ours, theirs) = (self.convention, pipelines.convention);
        if ours.counting != theirs.counting {
            return Err(ShadowDrawError::Counting { volumes: ours.counting, pipelines: theirs.counting });
        }
        if ours.depth != theirs.depth {
            return Err(ShadowDrawError::Depth { volumes: ours.depth, pipelines: theirs.depth });
        }
        if ours.is_unclipped && !theirs.is_unclipped {
            return Err(ShadowDrawError::FarPlane);
        }
        if let Some(groups) = &self.groups {
            groups.draw(pass, pipelines, &self.buffers, light, self.shape.end_at_range != 0);
        }
        Ok(())
    }

    /// A [`ShadowStatistics`] of the last encode, once submitted; usage `COPY_SRC`.
    pub fn statistics(&self) -> &wgpu::Buffer {
        &self.buffers.statistics
    }

    /// What was chosen for each light: [`ShadowLight`]s, once submitted; usage `COPY_SRC`.
    pub fn lights(&self) -> &wgpu::Buffer {
        &self.buffers.lights
    }

    /// The draws of each light: [`ShadowDraws`], once submitted; usages `INDIRECT` and `COPY_SRC`.
    pub fn draw_arguments(&self) -> &wgpu::Buffer {
        &self.buffers.draws
    }

    /// Refuses what would draw wrong shadows: another extractor or other lights than the lists are of, another camera than
    /// the pipelines are for.
    fn check(&self, extractor: &Extractor, camera: &ShadowCamera, lights: &[RangedLight]) -> Result<(), ShadowError> {
        // Each extractor has a buffer of its own.
        if extractor.faces() != &self.buffers.faces {
            return Err(ShadowError::OtherExtractor);
        }
        let Convention { counting, depth, .. } = self.convention;
        if camera.depth != depth {
            return Err(ShadowError::Depth { camera: camera.depth, pipelines: depth });
        }
        if self.convention.needs_far_end() && camera.has_far_plane() {
            return Err(ShadowError::FarPlane { counting });
        }
        let encoded = extractor.encoded();
        if lights.len() > encoded.len() {
            return Err(ShadowError::NotExtracted { given: lights.len(), encoded: encoded.len() });
        }
        let bits = |light: Light| light.to_array().map(f32::to_bits);
        match lights.iter().zip(encoded).position(|(given, encoded)| bits(given.light) != bits(*encoded)) {
            Some(index) => Err(ShadowError::OtherLight { index }),
            None => Ok(()),
        }
    }

    /// Makes the bind groups that read positions, unless they are made for this very place already.
    fn bind(&mut self, extractor: &Extractor, positions: PositionBuffer<'_>) -> Result<(), ShadowError> {
        let target = (positions.buffer.clone(), positions.offset, positions.stride);
        if self.bound_to.as_ref() == Some(&target) {
            return Ok(());
        }
        let (device, split, extraction) = extractor.parts();
        let results = extractor.results();
        let groups = (0..results.facing.len())
            .map(|word| extractor.results_bind_group(&self.layouts.results, word, positions))
            .collect::<Result<Vec<_>, _>>()?;
        let bound = positions.bind(extraction.vertices, split)?;
        let buffers = &self.buffers;
        self.choice.bind_positions(device, buffers, &results, positions.buffer, &bound);
        let whole = wgpu::Buffer::as_entire_binding;
        let group = |layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource<'_>]| {
            group(device, "shadow volumes", layout, resources)
        };
        let frame = group(
            &self.layouts.frame,
            &[
                whole(&buffers.shape),
                whole(&buffers.view),
                binding(&buffers.draw_lights, 0..size_of::<ShadowDraw>() as u64),
                whole(&buffers.lights),
            ],
        );
        let placed = bound.first_binding(positions.buffer);
        let caps = results.facing.iter().zip(&buffers.cap_lists).map(|(facing, list)| {
            group(
                &self.layouts.cap_data,
                &[placed.clone(), whole(&buffers.faces), whole(facing), whole(&buffers.cap_counts), whole(list)],
            )
        });
        let caps = caps.collect();
        self.groups = Some(DrawGroups { frame, results: groups, caps });
        self.bound_to = Some(target);
        Ok(())
    }
}

/// Bytes that an entry of both lists of cap faces takes for a light.
const CAP_ENTRY: u64 = 8;

/// What takes room besides the lists of cap faces.
fn per_light(lights: usize) -> [(&'static str, u64); 3] {
    let lights = lights as u64;
    [
        ("shadow lights", lights * size_of::<ShadowLight>() as u64),
        ("shadow draws", lights * size_of::<ShadowDraws>() as u64),
        ("shadow draw lights", lights * UniformTable::stride::<ShadowDraw>() as u64),
    ]
}

/// The most entries of a list of cap faces that one binding, and the memory limit, have room for.
fn fitting_capacity(extraction: &Shape, split: &Split, memory_limit: Option<u64>) -> usize {
    let bound = split.binding / (CAP_ENTRY * extraction.word_lights(0) as u64);
    let others: u64 = per_light(extraction.max_lights).iter().map(|&(_, bytes)| padded(bytes)).sum();
    let left = memory_limit.map_or(u64::MAX, |limit| limit.saturating_sub(others));
    let fitting = bound.min(left / (CAP_ENTRY * extraction.max_lights as u64));
    usize::try_from(fitting).unwrap_or(usize::MAX)
}

impl Buffers {
    fn new(extractor: &Extractor, cap_capacity: usize, memory_limit: Option<u64>) -> Result<Self, MemoryError> {
        let (device, split, extraction) = extractor.parts();
        let lights = extraction.max_lights as u64;
        let words = extraction.words();
        let list_bytes = |word: usize| CAP_ENTRY * cap_capacity as u64 * extraction.word_lights(word) as u64;
        let widest = list_bytes(0);
        if padded(widest) > split.binding {
            let what = "lists of cap faces";
            return Err(MemoryError::Binding { what, bytes: widest, limit: split.binding });
        }
        let wanted: Vec<Allocation> = (0..words)
            .map(|word| ("lists of cap faces", list_bytes(word)))
            .chain(per_light(extraction.max_lights))
            .map(|(label, bytes)| Allocation { label, bytes: padded(bytes) })
            .collect();
        let bytes = check(&wanted, split.buffer, memory_limit)?;
        let mut draw_lights = UniformTable::default();
        for light in 0..extraction.max_lights as u32 {
            draw_lights.push(&ShadowDraw { light, first_light: light / 32 * 32, reserved_0: 0, reserved_1: 0 });
        }
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        guarded(device, bytes, || Self {
            shape: buffer(device, "shadow shape", size_of::<ShadowShape>() as u64, uniform),
            view: buffer(device, "shadow view", size_of::<ShadowView>() as u64, uniform | BufferUsages::STORAGE),
            draw_lights: draw_lights.into_buffer(device, "shadow draw lights"),
            faces: extractor.faces().clone(),
            bounds: buffer(device, "caster bounds", 24, storage),
            lights: buffer(device, "shadow lights", lights * size_of::<ShadowLight>() as u64, storage),
            cap_dispatches: buffer(device, "cap dispatches", 12 * words as u64, storage | BufferUsages::INDIRECT),
            cap_counts: buffer(device, "cap counts", 8 * lights, storage),
            cap_lists: (0..words).map(|word| buffer(device, "cap faces", list_bytes(word), storage)).collect(),
            draws: buffer(
                device,
                "shadow draws",
                lights * size_of::<ShadowDraws>() as u64,
                storage | BufferUsages::INDIRECT,
            ),
            statistics: buffer(device, "shadow statistics", size_of::<ShadowStatistics>() as u64, storage),
        })
    }
}
