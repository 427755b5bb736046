//! What the stages of a scene found and chose, file by file. A file's positions are a buffer of its own, so no group of
//! casters has those of two files.

use rimline::gpu::{CasterHandle, ReadError, SceneError, SceneFrame, SceneGroupResults, read_back_vec};
use rimline::reference::cpu::{self, CHOICE_WORDS, SceneTable};
use rimline::reference::layout::{ExtractionStatistics, SeenLight, ShadowLight, ShadowShape, ShadowStatistics};
use rimline::reference::shadow::{CAST_EVERY, CAST_NOTHING, COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS};

use rimline::{Counting, wgpu};

use super::counts;
use super::posed_model::PosedModel;
use super::scene_shadows::{File, SceneShadows};
use super::shadows::{FacingMasks, FacingRun, Found};
use crate::device::Gpu;
use crate::gpu_error::GpuError;

/// The word of a caster's choices with the lights for which it has near caps.
const CAPPED: usize = 3;

/// The place of a caster in the table, and its group.
fn place(frame: &SceneFrame, caster: CasterHandle) -> Result<(u32, usize), SceneError> {
    frame.place(caster).ok_or(SceneError::NotEncoded)
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
            for &(_, caster) in casters {
                let (index, group) = place(frame, caster)?;
                let caster = SceneTable(&table).caster(index);
                masks.slots.extend(caster.first_face_slot..caster.first_face_slot + caster.faces);
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

    /// What was found and chosen for each file.
    pub(super) fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, GpuError> {
        let frame = self.frame()?;
        let results = frame.results()?;
        let choices = results.choices.map(|choices| read_back_vec(&gpu.device, &gpu.queue, choices)).transpose()?;
        let choices = Choices {
            words: choices.unwrap_or_default(),
            casters: self.files.iter().map(|file| file.casters.len()).sum(),
            batches: frame.batches(),
            shape: ShadowShape { counting: code(self.counting), ..bytemuck::Zeroable::zeroed() },
            seen: vec![bytemuck::Zeroable::zeroed(); self.lights.len()],
        };
        let all = self.statistics(gpu)?;
        let mut files = Vec::with_capacity(self.files.len());
        for File { casters, .. } in &self.files {
            let mut groups = Vec::new();
            let mut most = Most::new(self.lights.len());
            for &(_, caster) in casters {
                let (index, group) = place(frame, caster)?;
                groups.push(group);
                choices.add(index, &mut most);
            }
            let mut silhouettes = vec![0; self.lights.len()];
            let mut extraction: ExtractionStatistics = bytemuck::Zeroable::zeroed();
            for group in results.groups.iter().filter(|of| groups.contains(&of.group)) {
                let (counts, statistics) = of_group(gpu, group)?;
                let counted = silhouettes.iter_mut().skip(32 * group.batch).zip(counts);
                counted.for_each(|(sum, count)| *sum += count);
                extraction = counts::sum(extraction, statistics);
            }
            let shadow = most.statistics(all);
            let is_whole = self.files.len() == 1;
            files.push(Found { lights: most.lights, silhouettes, extraction, shadow, is_whole });
        }
        Ok(files)
    }

    /// The statistics of all files.
    pub(super) fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, ReadError> {
        let buffer = self.frame().ok().and_then(SceneFrame::shadow_statistics);
        buffer.map_or(Ok(bytemuck::Zeroable::zeroed()), |buffer| counts::read(gpu, buffer))
    }
}

/// What was chosen for all casters.
struct Choices {
    words: Vec<u32>,
    casters: usize,
    batches: usize,
    shape: ShadowShape,
    /// Of each light only what is chosen matters.
    seen: Vec<SeenLight>,
}

/// The most that any of some casters needs for each light.
struct Most {
    lights: Vec<ShadowLight>,
    /// The lights for which there are near caps, a word for each batch.
    capped: Vec<u32>,
}

impl Choices {
    /// Adds what was chosen for a caster.
    fn add(&self, index: u32, most: &mut Most) {
        let of_batch = |batch: usize| {
            let first = CHOICE_WORDS * (batch * self.casters + index as usize);
            self.words.get(first..first + CHOICE_WORDS).unwrap_or(&[0; CHOICE_WORDS])
        };
        let words: Vec<u32> = (0..self.batches).flat_map(of_batch).copied().collect();
        for (most, light) in most.lights.iter_mut().zip(cpu::chosen(&self.shape, &self.seen, &words)) {
            // Every face is more than those averted. What casts nothing is not counted.
            most.casting = most.casting.max(light.casting);
            if light.casting != CAST_NOTHING {
                most.counting = most.counting.max(light.counting);
            }
        }
        for (most, words) in most.capped.iter_mut().zip(words.chunks_exact(CHOICE_WORDS)) {
            *most |= words[CAPPED];
        }
    }
}

impl Most {
    fn new(lights: usize) -> Self {
        Self { lights: vec![bytemuck::Zeroable::zeroed(); lights], capped: vec![0; lights.div_ceil(32)] }
    }

    /// The lights for which nothing or every face casts, or that have near caps; the rest as for all files.
    fn statistics(&self, all: ShadowStatistics) -> ShadowStatistics {
        let count = |casting: u32| self.lights.iter().filter(|light| light.casting == casting).count() as u32;
        ShadowStatistics {
            skipped: count(CAST_NOTHING),
            every_face: count(CAST_EVERY),
            capped: self.capped.iter().map(|word| word.count_ones()).sum(),
            ..all
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
fn of_group(gpu: &Gpu, group: &SceneGroupResults<'_>) -> Result<(Vec<u32>, ExtractionStatistics), ReadError> {
    let counts = first_words(gpu, group.lists, 32)?;
    let record = first_words(gpu, group.record, 4)?;
    Ok((counts, bytemuck::pod_read_unaligned(bytemuck::cast_slice(&record))))
}

/// The first words of a buffer whose rest is not needed.
fn first_words(gpu: &Gpu, buffer: &wgpu::Buffer, words: u64) -> Result<Vec<u32>, ReadError> {
    let label = Some("first words");
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    let copy =
        gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size: 4 * words, usage, mapped_at_creation: false });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, 4 * words);
    gpu.queue.submit([encoder.finish()]);
    read_back_vec(&gpu.device, &gpu.queue, &copy)
}
