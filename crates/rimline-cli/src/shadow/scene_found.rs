//! Results and choices of a scene's stages, file by file. Each file has its own buffer of positions, so no group of
//! casters has those of two files.

use std::collections::BTreeSet;

use rimline::gpu::{CasterHandle, DeviceError, SceneFrame, SceneGroupResults, ShadowError, read_back_vec};
use rimline::reference::cpu::{self, CHOICE_WORDS, SceneTable};
use rimline::reference::layout::{ExtractionStatistics, SeenLight, ShadowShape, ShadowStatistics};
use rimline::reference::shadow::{CAST_EVERY, CAST_NOTHING, COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS};
use rimline::{Counting, wgpu};

use super::counts;
use super::found::{FacingMasks, FacingRun, Found};
use super::layers::Layers;
use super::posed_model::PosedModel;
use super::scene_shadows::{File, SceneShadows};
use crate::device::Gpu;
use crate::gpu_error::GpuError;

/// The word of a caster's choices with the lights for which it has near caps.
const CAPPED: usize = 3;

/// The place of a caster in the table, and its group.
fn place(frame: &SceneFrame, caster: CasterHandle) -> Result<(u32, usize), ShadowError> {
    frame.place(caster).ok_or(ShadowError::Removed { what: "caster" })
}

impl SceneShadows {
    /// Where the facing masks of each file lie.
    pub(super) fn facing(&self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        let frame = self.frame()?;
        let results = frame.results()?;
        let table: Vec<[u32; 4]> = read_back_vec(&gpu.device, &gpu.queue, results.table)?;
        let buffers = |group: usize| -> Vec<wgpu::Buffer> {
            results.groups.iter().filter(|of| of.group == group).map(|of| of.facing.clone()).collect()
        };
        let mut files = Vec::with_capacity(bodies.len());
        for File { casters, .. } in &self.files {
            let mut masks = FacingMasks::default();
            let mut last = None;
            for &(_, handle) in casters {
                let (index, group) = place(frame, handle)?;
                let caster = SceneTable(&table).caster(index);
                let first = masks.slots.len();
                masks.slots.extend(caster.first_face_slot..caster.first_face_slot + caster.faces);
                if let Some([faces, _]) = frame.slot_order(handle) {
                    for (slot, &face) in (caster.first_face_slot..).zip(faces) {
                        masks.slots[first + face as usize] = slot;
                    }
                }
                let end = masks.slots.len() as u32;
                match masks.runs.last_mut().filter(|_| last == Some(group)) {
                    Some(run) => run.faces.end = end,
                    None => {
                        masks.runs.push(FacingRun { faces: end - caster.faces..end, facing: buffers(group) });
                    }
                }
                last = Some(group);
            }
            files.push(masks);
        }
        Ok(files)
    }

    /// Results and choices for each file.
    pub(super) fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, GpuError> {
        let frame = self.frame()?;
        let results = frame.results()?;
        let choices = results.choices.map(|choices| read_back_vec(&gpu.device, &gpu.queue, choices)).transpose()?;
        let choices = Choices {
            words: choices.unwrap_or_default(),
            casters: self.files.iter().map(|file| file.casters.len()).sum(),
            batches: frame.batches(),
        };
        let shape = ShadowShape { counting: code(self.counting), ..bytemuck::Zeroable::zeroed() };
        // Only the choice for each light is read from the result, so the other values are zero.
        let seen: Vec<SeenLight> = vec![bytemuck::Zeroable::zeroed(); self.lights.len()];
        let all = self.statistics(gpu)?;
        let mut files = Vec::with_capacity(self.files.len());
        for File { casters, .. } in &self.files {
            let mut groups = BTreeSet::new();
            let mut words = vec![0; CHOICE_WORDS * choices.batches];
            for &(_, caster) in casters {
                let (index, group) = place(frame, caster)?;
                groups.insert(group);
                choices.add(index, &mut words);
            }
            let mut silhouettes = vec![0; self.lights.len()];
            let mut extraction: ExtractionStatistics = bytemuck::Zeroable::zeroed();
            for group in results.groups.iter().filter(|of| groups.contains(&of.group)) {
                let (counts, statistics) = of_group(gpu, group)?;
                let counted = silhouettes.iter_mut().skip(32 * group.batch).zip(counts);
                counted.for_each(|(sum, count)| *sum += count);
                extraction = counts::sum(extraction, statistics);
            }
            let lights = cpu::chosen(&shape, &seen, &words);
            let count = |casting: u32| lights.iter().filter(|light| light.casting == casting).count() as u32;
            let capped = words.chunks_exact(CHOICE_WORDS).map(|words| words[CAPPED].count_ones()).sum();
            let (skipped, every_face) = (count(CAST_NOTHING), count(CAST_EVERY));
            let shadow = ShadowStatistics { skipped, every_face, capped, ..all };
            let is_whole = self.files.len() == 1;
            files.push(Found { lights, silhouettes, extraction, shadow, is_whole });
        }
        Ok(files)
    }

    /// The statistics of all files.
    pub(super) fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, DeviceError> {
        let buffer = self.frame().ok().and_then(SceneFrame::shadow_statistics);
        let found = buffer.map_or(Ok(bytemuck::Zeroable::zeroed()), |buffer| counts::read(gpu, buffer))?;
        Ok(match self.layers {
            Some(Layers::Few(most)) => {
                ShadowStatistics { count_bound: found.count_bound.min(most), may_wrap: 0, ..found }
            }
            Some(Layers::Batched(_)) => ShadowStatistics { may_wrap: 0, ..found },
            Some(Layers::Many) | None => found,
        })
    }
}

/// Choices for all casters, in words for each batch of lights.
struct Choices {
    words: Vec<u32>,
    casters: usize,
    batches: usize,
}

impl Choices {
    /// Adds what was chosen for a caster. A bit stands for something that costs more, or for faces that cast: so casters
    /// together have the bits of any.
    fn add(&self, index: u32, sum: &mut [u32]) {
        for (batch, sum) in sum.chunks_exact_mut(CHOICE_WORDS).enumerate() {
            let first = CHOICE_WORDS * (batch * self.casters + index as usize);
            let words = self.words.get(first..first + CHOICE_WORDS).unwrap_or_default();
            sum.iter_mut().zip(words).for_each(|(sum, word)| *sum |= word);
        }
    }
}

fn code(counting: Counting) -> u32 {
    match counting {
        Counting::ZFail => COUNT_Z_FAIL,
        Counting::ZPass => COUNT_Z_PASS,
        Counting::ZpPlus => COUNT_ZP_PLUS,
        _ => COUNT_AUTO,
    }
}

/// The number of silhouette edges of each light of a group and batch, and its statistics.
fn of_group(gpu: &Gpu, group: &SceneGroupResults<'_>) -> Result<(Vec<u32>, ExtractionStatistics), DeviceError> {
    let counts = first_words(gpu, group.lists, 32)?;
    let record = first_words(gpu, group.record, size_of::<ExtractionStatistics>() as u64 / 4)?;
    Ok((counts, bytemuck::pod_read_unaligned(bytemuck::cast_slice(&record))))
}

/// The first words of a buffer whose rest is not needed.
fn first_words(gpu: &Gpu, buffer: &wgpu::Buffer, words: u64) -> Result<Vec<u32>, DeviceError> {
    let label = Some("first words");
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    let copy =
        gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size: 4 * words, usage, mapped_at_creation: false });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, 4 * words);
    gpu.queue.submit([encoder.finish()]);
    read_back_vec(&gpu.device, &gpu.queue, &copy)
}
