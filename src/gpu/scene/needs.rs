//! The needs of a frame: which instances of models must be deformed, found on the GPU before they are.

use std::sync::atomic::Ordering;

use bytemuck::Zeroable;

use super::model::Deformed;
use super::options::Measuring;
use super::scene::Scene;
use super::view::{FrameInputs, View};
use crate::gpu::common::bindings::{uniform, whole};
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, guarded};
use crate::gpu::common::pass::{Step, Workgroups, record};
use crate::gpu::common::requirements::{check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, upload};
use crate::gpu::common::wanted::Wanted;
use crate::gpu::shadow::errors::ShadowError;
use crate::layout::{LightCone, NeedsDispatch, ShadowLight, ShadowView, ViewLight};
use crate::stages::NEEDS;
use crate::turns::NEEDS_BOXES;

/// Invocations of a workgroup, which take a figure each.
const WORKGROUP: u64 = 64;

/// The stage, ready to be recorded.
pub(super) struct Needs {
    words: wgpu::Buffer,
    step: Step,
    /// The uniforms of each model.
    uniforms: Vec<UniformTable>,
}

impl Scene {
    /// Computes the positions of all models before [`Self::encode`], if you draw the depth that its views take
    /// ([`View::depth`]). The encode then does not compute them again, provided that its views are the same and nothing in the
    /// scene was changed. Record both into one encoder, or submit this one before: without it the encode finds the positions of
    /// an earlier frame, and the next one computes all anew. Depths of `inputs` do not matter here. Frames of earlier encodes are
    /// out of date then. Other programs do not need this call.
    ///
    /// # Errors
    /// The errors of [`Self::encode`].
    pub fn deform(&mut self, encoder: &mut wgpu::CommandEncoder, inputs: FrameInputs<'_>) -> Result<(), ShadowError> {
        check_timer(inputs.timer.as_deref(), self.pipelines.device())?;
        let views = Self::check_views(inputs.views)?;
        // Lay out the scene now, so that the encode of the frame does not.
        self.prepare_views(views.len())?;
        let Some(needs) = self.find_needs(inputs.views, &views)? else { return Ok(()) };
        let uploads: Vec<_> = self.deform_uploads(&needs).collect();
        if !uploads.is_empty() {
            upload(self.pipelines.device(), encoder, &uploads)?;
        }
        let words = self.record_needs(encoder, &needs, inputs.timer);
        self.deformed = Some(Deformed { words, views });
        // Frames before draw with positions that are overwritten here.
        self.encodes.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    /// The uploads before models are deformed.
    pub(super) fn deform_uploads<'a>(&'a self, needs: &'a Needs) -> impl Iterator<Item = (&'a wgpu::Buffer, &'a [u8])> {
        let models = self.models.values().zip(&needs.uniforms);
        models.flat_map(|(model, uniforms)| model.deformer.uploads(&model.words, uniforms))
    }

    /// Finds what the views need of the models, and deforms that. Returns the words that say it.
    pub(super) fn record_needs(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        needs: &Needs,
        mut timer: Option<&mut StageTimer>,
    ) -> wgpu::Buffer {
        record([&needs.step], encoder, 0..1, timer.as_deref_mut());
        let mut from = 0;
        for model in self.models.values() {
            let unneeded = Some((&needs.words, from));
            model.deformer.record(encoder, unneeded, model.resources.as_ref(), timer.as_deref_mut());
            from += 4 * model.casters.len() as u64;
        }
        needs.words.clone()
    }

    /// The words of the models that were deformed for an encode of these views, if the scene is as it was then.
    pub(super) fn take_deformed(&mut self, views: &[ShadowView]) -> Option<wgpu::Buffer> {
        let bytes = bytemuck::cast_slice::<ShadowView, u8>;
        // Rigid casters may have moved: models need nothing of them.
        let is_same = self.structure.is_some() && self.lights.moved.is_empty();
        self.deformed.take().filter(|of| is_same && bytes(&of.views) == bytes(views)).map(|of| of.words)
    }

    /// The stage that finds which instances of models the views need. `None` without instances.
    pub(super) fn find_needs(&self, given: &[View<'_>], views: &[ShadowView]) -> Result<Option<Needs>, ShadowError> {
        if self.figures.is_empty() {
            return Ok(None);
        }
        let (mut seen, figures) = (self.seen_for_needs(given, views), self.figure_records());
        let lights = if views.is_empty() { 1 } else { seen.len() / views.len() };
        let is_short = views.len() * (lights + 1) <= NEEDS_BOXES;
        let does = |skipped: Measuring| u32::from(!self.options.measuring.has(skipped));
        let frame = NeedsDispatch {
            casters: self.figures.len() as u32,
            views: views.len() as u32,
            lights: lights as u32,
            parts: (figures.len() / self.figures.len()) as u32,
            all: u32::from(does(Measuring::UNNEEDED) == 0 || views.is_empty() || !is_short),
            cull_by_range: does(Measuring::UNREACHED),
            cull_by_view: does(Measuring::UNSEEN),
            reserved: 0,
        };
        // Bindings are never empty.
        seen.extend(seen.is_empty().then(ViewLight::zeroed));
        let (words, step) = self.needs_step(&frame, [bytemuck::cast_slice(&seen), bytemuck::cast_slice(&figures)])?;
        let uniforms = self.models.values().map(|model| model.deformer.uniforms(model.time_s)).collect();
        Ok(Some(Needs { words, step, uniforms }))
    }

    /// The records of the figures that the stage reads.
    fn figure_records(&self) -> Vec<[u32; 4]> {
        let batches = self.lights.batches();
        let mut figures = Vec::with_capacity(self.figures.len() * (2 + batches.div_ceil(4)));
        for entry in self.figures.iter().filter_map(|&key| self.casters.get(key)) {
            let [low, high] = entry.bounds.unwrap_or_default().map(|corner| corner.map(f32::to_bits));
            figures.push([low[0], low[1], low[2], entry.bounds.is_some().into()]);
            figures.push([high[0], high[1], high[2], 0]);
            let word = |batch| if batch < batches { entry.lights.and(&self.lights.used).word(batch) } else { 0 };
            figures.extend((0..batches.div_ceil(4)).map(|part| [0, 1, 2, 3].map(|batch| word(4 * part + batch))));
        }
        figures
    }

    /// The lights of each view, up to the last one. There is at least one entry for each view.
    fn seen_for_needs(&self, given: &[View<'_>], views: &[ShadowView]) -> Vec<ViewLight> {
        let last = (0..32 * self.lights.batches() as u32).rfind(|&bit| self.lights.get(bit).is_some());
        let lights = last.unwrap_or(0) + 1;
        let mut seen = Vec::with_capacity(views.len() * lights as usize);
        for (given, &view) in given.iter().zip(views) {
            for bit in 0..lights {
                let own = self.lights.get(bit);
                let light = own.map_or_else(ShadowLight::zeroed, |light| given.camera.light(&view, light));
                let cone = own.map_or_else(LightCone::zeroed, |light| LightCone::of(&light));
                seen.push(ViewLight { view, light, cone, ..ViewLight::zeroed() });
            }
        }
        seen
    }

    fn needs_step(&self, frame: &NeedsDispatch, inputs: [&[u8]; 2]) -> Result<(wgpu::Buffer, Step), ShadowError> {
        let device = self.pipelines.device();
        check_alive(device)?;
        let limits = DispatchLimits::new(&device.limits());
        let wanted = [
            Wanted::filled("seen by needs", inputs[0]),
            Wanted::filled("figures", inputs[1]),
            Wanted::new("unneeded figures", 4 * u64::from(frame.casters.max(1))),
        ];
        let allocations = wanted.map(|Wanted { label, bytes, .. }| Allocation { label, bytes });
        let bytes = check(&allocations, limits.binding, None)?;
        let others = Allocation { label: "the rest of the scene", bytes: self.used() + self.pages.bytes };
        check(&[Allocation { label: "needs", bytes }, others], u64::MAX, self.options.memory_limit)?;
        let [seen, figures, words] = guarded(device, bytes, || wanted.map(|wanted| wanted.make(device)))?;
        let mut table = UniformTable::default();
        let offset = table.push(frame);
        let frames = table.into_buffer(device, "needs");
        let pipeline = self.pipelines.compute(&NEEDS, NEEDS.name, &[]);
        let count = u64::from(frame.casters).div_ceil(WORKGROUP).min(limits.workgroups) as u32;
        let dispatch = pipeline.dispatch(device, Workgroups::Known([count, 1]), |name| {
            Some(match name {
                "frame" => uniform::<NeedsDispatch>(&frames, offset),
                "view_lights" => whole(&seen),
                "deforming_casters" => whole(&figures),
                "needed_states" => whole(&words),
                _ => return None,
            })
        });
        Ok((words, pipeline.pass([dispatch])))
    }
}
