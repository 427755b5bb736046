//! Methods that look at more than the ends of an edge, or continue edges: marks of all edges, which the cells are decided from.

use super::error::DepthMapError;
use super::options::{DanglingEdges, DepthMapMethod};
use super::stage::{BoundStage, ObjectStage, Workgroups};
use super::view::steps;
use crate::gpu::common::dispatch_limits::WORKGROUP;
use crate::gpu::common::memory::{Allocation, buffer, filled, guarded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::uniforms::entry;
use crate::layout::DepthEdgeRule;
use crate::shadow::DepthDirection;
use crate::stages::DEPTH_EDGES;

/// Samples of the lattice across, and down.
pub(super) fn lattice([width, height]: [u32; 2], faces: u32) -> [u32; 2] {
    if faces > 1 { [3 * width, 2 * height] } else { [width + 2, height + 2] }
}

/// Samples of a row that one word tells about.
const WORD_SAMPLES: u32 = 16;

/// Words below each other that one invocation marks.
const STRIP: u32 = 4;

/// Invocations of a workgroup that marks.
const MARKERS: u64 = 64;

/// A share of the depth whose exponent is so much less is what floats are off by: four steps of up to 2⁻²³ of it.
const FLOAT_EXPONENTS: u32 = 21;

/// How many times the differences beside it a difference is, where `DepthMapMethod::Automatic` takes it for an edge.
const SLOPES: f32 = 2.0;

/// How a detector that needs marks decides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detector {
    rule: DepthEdgeRule,
    /// The use of second differences, as a constant of the stage.
    second: u32,
    dangling: Option<DanglingEdges>,
    rings: u32,
}

/// Bits of a threshold. One that a device may flush is none.
pub(super) fn threshold_bits(threshold: f32) -> u32 {
    if threshold < f32::MIN_POSITIVE { 0 } else { threshold.to_bits() }
}

impl Detector {
    /// `None`: edges are decided by their ends alone. The thresholds have been checked.
    pub(super) fn new(method: DepthMapMethod, bits: u32, faces: u32, size: [u32; 2]) -> Option<Self> {
        let dangling = method.dangling();
        let (second, low, high) = match method {
            DepthMapMethod::EveryCell | DepthMapMethod::Contours { .. } => return None,
            DepthMapMethod::Differences { threshold, .. } => (0, threshold, 1.0),
            DepthMapMethod::SecondDifferences { low, high, .. } => (1, low, high),
            DepthMapMethod::Automatic { .. } => (2, 0.0, 1.0),
        };
        if second == 0 && dangling.is_none() {
            return None;
        }
        let share = dangling.map_or(1.0, |dangling| dangling.share);
        let slopes = if second == 2 { SLOPES } else { 1.0 };
        let [across, down] = lattice(size, faces);
        let words = [across.div_ceil(WORD_SAMPLES), down];
        let rule = DepthEdgeRule {
            words,
            blocks: (u64::from(words[0]) * u64::from(words[1])).div_ceil(u64::from(WORKGROUP)) as u32,
            high: threshold_bits(high),
            low: [low, low * share].map(threshold_bits),
            slopes: [slopes, slopes * share].map(threshold_bits),
            noise: 0,
            noise_exponents: 0,
        };
        // Left out steep surfaces are moved by half a texel across and down, and by as much again for the parts of a texel of
        // several bits.
        let rings = u32::from(second > 0) + u32::from(bits > 1);
        Some(Self { rule, second, dangling, rings })
    }

    /// Words side by side, and the strips of them.
    fn strips(&self) -> u64 {
        let [across, down] = self.rule.words;
        u64::from(across) * u64::from(down.div_ceil(STRIP))
    }

    /// Bytes of the marks, of those that may be continued, and of what is known about samples.
    pub(super) fn allocations(&self) -> [Allocation; 4] {
        let words = u64::from(self.rule.words[0]) * u64::from(self.rule.words[1]);
        let further = if self.dangling.is_some() { words } else { 1 };
        let allocation = |label, words| Allocation { label, bytes: 4 * words };
        [
            allocation("edges of a depth map", words),
            allocation("continued edges of a depth map", further),
            allocation("faint edges of a depth map", further),
            allocation("samples of a depth map", words),
        ]
    }
}

/// The stages of a detector with their buffers.
#[derive(Debug)]
pub(super) struct EdgeStages {
    detector: Detector,
    mark: ObjectStage,
    /// Continue, count.
    stages: [Pipeline; 2],
    /// Two of marks, that take turns, the faint ones, and what is known about samples.
    buffers: [wgpu::Buffer; 4],
}

impl EdgeStages {
    pub(super) fn new(shared: &Pipelines, detector: Detector) -> Result<Self, DepthMapError> {
        // Each pass has its own constants, so that more of them are shared.
        let mark = [("SECOND", detector.second), ("CONTINUES", u32::from(detector.dangling.is_some()))];
        let count = [("RINGS", f64::from(detector.rings))];
        let allocations = detector.allocations();
        let bytes = allocations.iter().map(|allocation| allocation.bytes).sum();
        let device = shared.device();
        let usage = wgpu::BufferUsages::STORAGE;
        let buffers = guarded(device, bytes, || {
            [0, 1, 2, 3].map(|at| buffer(device, allocations[at].label, allocations[at].bytes, usage))
        })?;
        let passes = [("depth_edges_continue", &[][..]), ("depth_edges_count", &count)];
        let stages = passes.map(|(entry_point, constants)| shared.compute(&DEPTH_EDGES, entry_point, constants));
        Ok(Self { detector, mark: ObjectStage::new(shared, &DEPTH_EDGES, "depth_edges_mark", &mark), stages, buffers })
    }

    /// The rule for depths that were rounded to `formats`.
    pub(super) fn rule(
        &self,
        depth: DepthDirection,
        formats: &mut dyn Iterator<Item = wgpu::TextureFormat>,
    ) -> DepthEdgeRule {
        let mut rule = self.detector.rule;
        for format in formats {
            let [share, constant] = steps(format, depth).map(|steps| steps as f32);
            rule.noise = rule.noise.max(threshold_bits(constant));
            if share > 0.0 {
                rule.noise_exponents = FLOAT_EXPONENTS;
            }
        }
        rule
    }

    /// Marks, continues, counts. `map`: what all stages of cells read. `few`: workgroups that take blocks in turn.
    pub(super) fn bind(
        &self,
        shared: &Pipelines,
        rule: &DepthEdgeRule,
        map: &[(&str, wgpu::BindingResource<'_>)],
        (has_objects, few): (bool, u32),
    ) -> Vec<BoundStage> {
        let device = shared.device();
        let uniform = filled(device, "edges of a depth map", bytemuck::bytes_of(rule), wgpu::BufferUsages::UNIFORM);
        let continued = self.detector.dangling.map_or(0, |dangling| dangling.cells as usize);
        let group = |stage: &Pipeline, out: usize| {
            let own = [
                ("edge_rule", entry::<DepthEdgeRule>(&uniform)),
                ("edges_before", self.buffers[1 - out].as_entire_binding()),
                ("edges", self.buffers[out].as_entire_binding()),
                ("faint_edges", self.buffers[2].as_entire_binding()),
                ("sample_bits", self.buffers[3].as_entire_binding()),
            ];
            stage.bind(device, &[map, &own].concat())
        };
        let bound = |stage: &Pipeline, groups, count| BoundStage {
            stage: stage.clone(),
            groups,
            workgroups: Workgroups::over(device, count),
        };
        let (mark, [forward, count]) = (self.mark.get(shared, has_objects), &self.stages);
        let marking = self.detector.strips().div_ceil(MARKERS) as u32;
        let mut stages = vec![bound(&mark, vec![group(&mark, 0)], marking)];
        if continued > 0 {
            let turns = [0, 1].map(|out| group(forward, out));
            let groups = (1..=continued).map(|pass| turns[pass % 2].clone()).collect();
            stages.push(bound(forward, groups, rule.blocks));
        }
        stages.push(bound(count, vec![group(count, 1 - continued % 2)], few));
        stages
    }
}
