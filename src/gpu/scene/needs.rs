//! The needs of a frame: which figures must be deformed, found on the GPU before they are.

use std::ops::Range;

use bytemuck::Zeroable;
use slotmap::DefaultKey;

use super::caster::Placement;
use super::handles::{CasterHandle, SceneId};
use super::options::Measuring;
use super::scene::Scene;
use super::view::View;
use crate::ShadowCamera;
use crate::gpu::common::bindings::{uniform, whole};
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, guarded};
use crate::gpu::common::pass::{Workgroups, record};
use crate::gpu::common::requirements::{check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::common::wanted::Wanted;
use crate::gpu::shadow::errors::ShadowError;
use crate::layout::{LightCone, NeedsDispatch, SeenLight, ShadowLight, ShadowView};
use crate::stages::NEEDS;
use crate::turns::NEEDS_BOXES;

/// Invocations of a workgroup, which take a figure each.
const WORKGROUP: u64 = 64;

/// Which casters a frame needs, once the encoder was submitted: the result of [`Scene::encode_needs`].
///
/// A clone is cheap.
#[derive(Clone, Debug)]
pub struct SceneNeeds {
    pub(crate) words: wgpu::Buffer,
    entries: Range<usize>,
    pub(crate) device: wgpu::Device,
    scene: SceneId,
    /// How many the scene had made.
    serial: u64,
    keys: Vec<DefaultKey>,
    views: Vec<ShadowView>,
}

impl SceneNeeds {
    /// The number of casters.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// A part of the casters, for example those of the second of two deformers. `None` if there are fewer.
    #[must_use]
    pub fn part(&self, casters: Range<usize>) -> Option<Self> {
        let is_within = casters.start <= casters.end && casters.end <= self.len();
        let first = self.entries.start;
        is_within.then(|| Self { entries: first + casters.start..first + casters.end, ..self.clone() })
    }

    /// A `u32` for each caster, from byte [`Self::offset`] on: 1 if the frame does not need it, else 0. Usages `STORAGE` and
    /// `COPY_SRC`.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.words
    }

    /// The byte of the buffer where the first caster's entry is.
    pub fn offset(&self) -> u64 {
        4 * self.entries.start as u64
    }
}

impl Scene {
    /// Records the stage that finds which of some `casters` the next encode needs, before their positions are computed. They are
    /// casters with buffers, as a rule those of a [`Deformer`](crate::gpu::Deformer). A caster is needed if a camera may see it,
    /// or its shadow from a light that may reach it, by the box that [`Self::set_bounds`] states. It is needed, too, if it has no
    /// box, if there is no camera, or if there are many views and lights.
    ///
    /// `cameras` are all that see the casters or their shadows in the frame. A caller who deforms by shaders of its own reads
    /// [`SceneNeeds::buffer`]. Positions of a caster that isn't needed must show nothing: a `Deformer` makes them a point.
    ///
    /// In each frame, in one encoder:
    ///
    /// ```no_run
    /// use rimline::gpu::{CasterHandle, Deformer, FrameInputs, Scene, SceneFrame};
    /// use rimline::{ModelBounds, Pose, ShadowCamera, wgpu};
    ///
    /// /// `figures` are the casters of the deformer's instances, in order. `bounds` are those of its model.
    /// fn frame(
    ///     (scene, figures): (&mut Scene, &[CasterHandle]),
    ///     (deformer, bounds, pose): (&Deformer, &ModelBounds, &Pose),
    ///     encoder: &mut wgpu::CommandEncoder,
    ///     camera: ShadowCamera,
    /// ) -> Result<SceneFrame, Box<dyn std::error::Error>> {
    ///     for (&figure, own) in figures.iter().zip(bounds.boxes(pose, 0.0)?) {
    ///         scene.set_bounds(figure, own)?;
    ///     }
    ///     let needs = scene.encode_needs(encoder, figures, &[camera], None)?;
    ///     deformer.encode_needed(encoder, pose, 0.0, None, &needs, None)?;
    ///     // Draw the figures, and all else that is seen; then:
    ///     Ok(scene.encode_needed(encoder, FrameInputs::new(&[camera.into()]), &needs)?)
    /// }
    /// ```
    ///
    /// # Errors
    /// [`ShadowError::NoBuffer`] for a rigid caster, [`ShadowError::ListedTwice`], or as [`Self::encode`].
    pub fn encode_needs(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        casters: &[CasterHandle],
        cameras: &[ShadowCamera],
        timer: Option<&mut StageTimer>,
    ) -> Result<SceneNeeds, ShadowError> {
        check_timer(timer.as_deref(), self.pipelines.device())?;
        let given: Vec<View<'_>> = cameras.iter().map(|&camera| camera.into()).collect();
        let views = self.check_views(&given)?;
        let keys = self.number_figures(casters)?;
        // Lay out the scene now, so that the encode of the frame does not.
        self.prepare_views(cameras.len())?;
        self.needs += 1;
        let (mut seen, mut figures) = (self.seen_for_needs(cameras, &views), self.figures(&keys));
        let lights = if views.is_empty() { 1 } else { seen.len() / views.len() };
        let is_short = views.len() * (lights + 1) <= NEEDS_BOXES;
        let frame = NeedsDispatch {
            figures: keys.len() as u32,
            views: views.len() as u32,
            lights: lights as u32,
            parts: figures.len().checked_div(keys.len()).unwrap_or(0) as u32,
            all: u32::from(self.options.measuring.has(Measuring::UNNEEDED) || views.is_empty() || !is_short),
            skip_unreached: (!self.options.measuring.has(Measuring::UNREACHED)).into(),
            skip_unseen: (!self.options.measuring.has(Measuring::UNSEEN)).into(),
            reserved: 0,
        };
        // Bindings are never empty.
        seen.extend(seen.is_empty().then(SeenLight::zeroed));
        figures.extend(figures.is_empty().then_some([0; 4]));
        let words =
            self.record_needs(encoder, &frame, [bytemuck::cast_slice(&seen), bytemuck::cast_slice(&figures)], timer)?;
        let device = self.pipelines.device().clone();
        let (entries, scene, serial) = (0..keys.len(), self.id, self.needs);
        Ok(SceneNeeds { words, entries, device, scene, serial, keys, views })
    }

    /// The keys of casters with buffers.
    fn number_figures(&mut self, casters: &[CasterHandle]) -> Result<Vec<DefaultKey>, ShadowError> {
        let mut keys = Vec::with_capacity(casters.len());
        for caster in casters {
            let key = caster.key_in(self.id)?;
            let entry = self.casters.get(key).ok_or(ShadowError::Removed { what: "caster" })?;
            if matches!(entry.placement, Placement::Rigid(_)) {
                return Err(ShadowError::NoBuffer);
            }
            keys.push(key);
        }
        let mut sorted = keys.clone();
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            let caster = keys.iter().rposition(|key| *key == pair[0]).unwrap_or(0);
            return Err(ShadowError::ListedTwice { caster });
        }
        Ok(keys)
    }

    /// The records of the figures that the stage reads.
    fn figures(&self, keys: &[DefaultKey]) -> Vec<[u32; 4]> {
        let batches = self.lights.batches();
        let mut figures = Vec::with_capacity(keys.len() * (2 + batches.div_ceil(4)));
        for entry in keys.iter().filter_map(|&key| self.casters.get(key)) {
            let [low, high] = entry.bounds.unwrap_or_default().map(|corner| corner.map(f32::to_bits));
            figures.push([low[0], low[1], low[2], entry.bounds.is_some().into()]);
            figures.push([high[0], high[1], high[2], 0]);
            let word = |batch| if batch < batches { entry.lights.and(&self.lights.used).word(batch) } else { 0 };
            figures.extend((0..batches.div_ceil(4)).map(|part| [0, 1, 2, 3].map(|batch| word(4 * part + batch))));
        }
        figures
    }

    /// The lights of each view, up to the last one. There is at least one entry for each view.
    fn seen_for_needs(&self, cameras: &[ShadowCamera], views: &[ShadowView]) -> Vec<SeenLight> {
        let last = (0..32 * self.lights.batches() as u32).rfind(|&bit| self.lights.get(bit).is_some());
        let lights = last.unwrap_or(0) + 1;
        let mut seen = Vec::with_capacity(views.len() * lights as usize);
        for (camera, &view) in cameras.iter().zip(views) {
            for bit in 0..lights {
                let given = self.lights.get(bit);
                let light = given.map_or_else(ShadowLight::zeroed, |light| camera.light(&view, light));
                let cone = given.map_or_else(LightCone::zeroed, |light| LightCone::of(&light));
                seen.push(SeenLight { view, light, cone, ..SeenLight::zeroed() });
            }
        }
        seen
    }

    fn record_needs(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &NeedsDispatch,
        inputs: [&[u8]; 2],
        timer: Option<&mut StageTimer>,
    ) -> Result<wgpu::Buffer, ShadowError> {
        let device = self.pipelines.device();
        check_alive(device)?;
        let limits = DispatchLimits::new(&device.limits());
        let wanted = [
            Wanted::filled("seen by needs", inputs[0]),
            Wanted::filled("figures", inputs[1]),
            Wanted::new("unneeded figures", 4 * u64::from(frame.figures.max(1))),
        ];
        let allocations = wanted.map(|Wanted { label, bytes, .. }| Allocation { label, bytes });
        let bytes = check(&allocations, limits.binding, self.options.memory_limit)?;
        let [seen, figures, words] = guarded(device, bytes, || wanted.map(|wanted| wanted.make(device)))?;
        let mut table = UniformTable::default();
        let offset = table.push(frame);
        let frames = table.into_buffer(device, "needs");
        let pipeline = self.pipelines.compute(&NEEDS, NEEDS.name, &[]);
        let count = u64::from(frame.figures).div_ceil(WORKGROUP).min(limits.workgroups) as u32;
        let dispatch = pipeline.dispatch(device, Workgroups::Known([count, 1]), |name| {
            Some(match name {
                "frame" => uniform::<NeedsDispatch>(&frames, offset),
                "seen" => whole(&seen),
                "figures" => whole(&figures),
                "unneeded" => whole(&words),
                _ => return None,
            })
        });
        record([&pipeline.pass([dispatch])], encoder, 0..1, timer);
        Ok(words)
    }

    /// Whether the scene is as it was when it found these needs, and is asked for the same views.
    pub(super) fn check_needs(&self, needs: &SceneNeeds, views: &[ShadowView]) -> Result<(), ShadowError> {
        if needs.scene != self.id {
            return Err(ShadowError::OtherScene { what: "needs" });
        }
        let bytes = bytemuck::cast_slice::<ShadowView, u8>;
        let is_same = needs.serial == self.needs
            && self.structure.is_some()
            && self.moved.is_empty()
            && self.lights.moved.is_empty()
            && bytes(&needs.views) == bytes(views)
            && needs.entries.start == 0
            && needs.len() == needs.keys.len();
        if is_same { Ok(()) } else { Err(ShadowError::StaleNeeds) }
    }

    /// Numbers the figures of an encode. Results of casters that become figures, or cease to be, are not cached.
    pub(super) fn heed_needs(&mut self, needs: Option<&SceneNeeds>) {
        let keys = needs.map_or(&[][..], |needs| &needs.keys);
        if self.figures == keys {
            return;
        }
        let before = std::mem::replace(&mut self.figures, keys.to_vec());
        for &key in &before {
            self.number_figure(key, 0);
        }
        for (&key, number) in keys.iter().zip(1..) {
            self.number_figure(key, number);
        }
    }

    fn number_figure(&mut self, key: DefaultKey, number: u32) {
        if let Some(entry) = self.casters.get_mut(key) {
            entry.figure = number;
            self.note_change(key);
        }
    }
}
