//! The instances of models that a frame needs. The GPU finds them before it deforms them.

use std::sync::atomic::Ordering;

use bytemuck::Zeroable;

use super::mask::LightMask;
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
use crate::layout::{LightCone, NeedsDispatch, ShadowView, ViewLight};
use crate::stages::NEEDS;
use crate::turns::NEEDS_BOXES;

/// Invocations of a workgroup, one a deforming caster.
const WORKGROUP: u32 = 64;

/// The stage `needs`, ready to be recorded.
pub(super) struct Needs {
    /// The states that it writes, a word a deforming caster.
    states: wgpu::Buffer,
    step: Step,
    /// The uniforms of each model.
    uniforms: Vec<UniformTable>,
}

impl Scene {
    /// Computes the positions of all models before [`Self::encode`]. Only programs that draw a depth for [`View::depth`]
    /// need it. The encode does not compute the positions again if it has the same views, for these lights or fewer, and
    /// nothing in the scene changed. Record both into one encoder, or submit this one before. Else the encode reads the
    /// positions of an earlier frame, and the next encode computes all again. Depths of `inputs` are ignored. Frames of
    /// earlier encodes become stale.
    ///
    /// # Errors
    /// The errors of [`Self::encode`].
    pub fn deform(&mut self, encoder: &mut wgpu::CommandEncoder, inputs: FrameInputs<'_>) -> Result<(), ShadowError> {
        check_timer(inputs.timer.as_deref(), self.pipelines.device())?;
        let views = Self::check_views(inputs.views)?;
        // The encode must find this layout: another one would discard the positions.
        self.prepare(views.len(), 0)?;
        let Some(needs) = self.find_needs(inputs.views, &views)? else { return Ok(()) };
        let uploads: Vec<_> = self.deform_uploads(&needs).collect();
        upload(self.pipelines.device(), encoder, &uploads)?;
        let states = self.record_needs(encoder, &needs, inputs.timer);
        let lights = inputs.views.iter().map(|view| view.lights).collect();
        self.deformed = Some(Deformed { states, views, lights });
        // Earlier frames draw with positions that are overwritten here.
        self.encodes.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    /// The uploads before models are deformed.
    pub(super) fn deform_uploads<'a>(&'a self, needs: &'a Needs) -> impl Iterator<Item = (&'a wgpu::Buffer, &'a [u8])> {
        let models = self.models.values().zip(&needs.uniforms);
        models.flat_map(|(model, uniforms)| model.deformer.uploads(&model.words, uniforms))
    }

    /// Records the stage, and deforms the needed instances. Returns the states.
    pub(super) fn record_needs(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        needs: &Needs,
        mut timer: Option<&mut StageTimer>,
    ) -> wgpu::Buffer {
        record([&needs.step], encoder, timer.as_deref_mut());
        let mut from = 0;
        for model in self.models.values() {
            let states = Some((&needs.states, from));
            model.deformer.record(encoder, states, model.resources.as_ref(), timer.as_deref_mut());
            from += 4 * model.casters.len() as u64;
        }
        needs.states.clone()
    }

    /// The states of instances that were deformed for an encode of these views and their lights, if the scene did not change
    /// since.
    pub(super) fn take_deformed(&mut self, given: &[View<'_>], views: &[ShadowView]) -> Option<wgpu::Buffer> {
        let bytes = bytemuck::cast_slice::<ShadowView, u8>;
        // Moved rigid casters do not matter to models.
        let is_same = self.structure.is_some() && self.content.lights.moved.is_empty();
        let deformed = self.deformed.take().filter(|of| is_same && bytes(&of.views) == bytes(views))?;
        let has_lights = |(view, lights): (&View<'_>, &LightMask)| view.lights.and(lights) == view.lights;
        given.iter().zip(&deformed.lights).all(has_lights).then_some(deformed.states)
    }

    /// The stage `needs` for these views. `None` without instances.
    pub(super) fn find_needs(&self, given: &[View<'_>], views: &[ShadowView]) -> Result<Option<Needs>, ShadowError> {
        if self.deforming.is_empty() {
            return Ok(None);
        }
        let (mut view_lights, records) = (self.view_lights_for_needs(given, views), self.deforming_records());
        let lights = if views.is_empty() { 1 } else { view_lights.len() / views.len() };
        let is_short = views.len() * (lights + 1) <= NEEDS_BOXES;
        let culls = |culled: Measuring| u32::from(!self.options.measuring.has(culled));
        let frame = NeedsDispatch {
            casters: self.deforming.len() as u32,
            views: views.len() as u32,
            lights: lights as u32,
            parts: (records.len() / self.deforming.len()) as u32,
            all: u32::from(culls(Measuring::CULLED_CASTERS) == 0 || views.is_empty() || !is_short),
            cull_by_range: culls(Measuring::CULLED_BY_RANGE),
            cull_by_view: culls(Measuring::CULLED_BY_VIEW),
            reserved: 0,
        };
        // Bindings are never empty.
        view_lights.extend(view_lights.is_empty().then(ViewLight::zeroed));
        let (states, step) =
            self.needs_step(&frame, [bytemuck::cast_slice(&view_lights), bytemuck::cast_slice(&records)])?;
        let uniforms = self.models.values().map(|model| model.deformer.uniforms(model.time_s)).collect();
        Ok(Some(Needs { states, step, uniforms }))
    }

    /// The deforming casters for the stage: boxes and bits of lights. The stage reads a batch also where there is no light.
    fn deforming_records(&self) -> Vec<[u32; 4]> {
        let batches = self.content.lights.used.batches().max(1);
        let mut records = Vec::with_capacity(self.deforming.len() * (2 + batches.div_ceil(4)));
        for entry in self.deforming.iter().filter_map(|&key| self.content.casters.get(key)) {
            let [low, high] = entry.bounds.unwrap_or_default().map(|corner| corner.map(f32::to_bits));
            records.push([low[0], low[1], low[2], entry.bounds.is_some().into()]);
            records.push([high[0], high[1], high[2], 0]);
            let mask = entry.lights.and(&self.content.lights.used);
            records.extend((0..batches.div_ceil(4)).map(|part| [0, 1, 2, 3].map(|batch| mask.word(4 * part + batch))));
        }
        records
    }

    /// The lights of each view, up to the last light and at least one.
    fn view_lights_for_needs(&self, given: &[View<'_>], views: &[ShadowView]) -> Vec<ViewLight> {
        let lights = self.content.lights.used.bits().max(1);
        let mut all = Vec::with_capacity(views.len() * lights as usize);
        for (given, &view) in given.iter().zip(views) {
            for bit in 0..lights {
                let light = self.content.lights.get(bit);
                let cone = light.map_or_else(LightCone::zeroed, |light| LightCone::of(&light));
                let version = [u32::from(given.lights.has(bit)), 0, 0, 0];
                all.push(ViewLight { version, cone, ..self.light_in_view(&given.camera, view, bit) });
            }
        }
        all
    }

    fn needs_step(&self, frame: &NeedsDispatch, inputs: [&[u8]; 2]) -> Result<(wgpu::Buffer, Step), ShadowError> {
        let device = self.pipelines.device();
        check_alive(device)?;
        let limits = DispatchLimits::new(&device.limits());
        let wanted = [
            Wanted::filled("lights of views", inputs[0]),
            Wanted::filled("deforming casters", inputs[1]),
            Wanted::new("needed states", 4 * u64::from(frame.casters.max(1))),
        ];
        let allocations = wanted.map(|Wanted { label, bytes, .. }| Allocation { label, bytes });
        let bytes = check(&allocations, limits.binding, None)?;
        let others = Allocation { label: "the rest of the scene", bytes: self.used() };
        check(&[Allocation { label: "needs", bytes }, others], u64::MAX, self.options.memory_limit)?;
        let [view_lights, records, states] = guarded(device, bytes, || wanted.map(|wanted| wanted.make(device)))?;
        let mut table = UniformTable::default();
        let offset = table.push(frame);
        let frames = table.into_buffer(device, "needs");
        let pipeline = self.pipelines.compute(&NEEDS, NEEDS.name, &[]);
        let workgroups = Workgroups::over(device, frame.casters.div_ceil(WORKGROUP));
        let dispatch = pipeline.dispatch(device, workgroups, |name| {
            Some(match name {
                "frame" => uniform::<NeedsDispatch>(&frames, offset),
                "view_lights" => whole(&view_lights),
                "deforming_casters" => whole(&records),
                "needed_states" => whole(&states),
                _ => return None,
            })
        });
        Ok((states, pipeline.pass([dispatch])))
    }
}
