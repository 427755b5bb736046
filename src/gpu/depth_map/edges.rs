//! Detectors that read more than the two samples of an edge, or continue edges. They mark edges first, and cells are
//! decided from the marks.

use super::bound::ObjectStage;
use super::options::{DanglingEdges, DepthMapMethod};
use crate::gpu::common::bindings::{Resource, uniform, whole};
use crate::gpu::common::dispatch_limits::WORKGROUP;
use crate::gpu::common::memory::filled;
use crate::gpu::common::pass::{Dispatch, Step, Workgroups};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, switch};
use crate::gpu::common::wanted::Wanted;
use crate::layout::DepthEdgeRule;
use crate::stages::DEPTH_EDGES;

/// Samples of the lattice across, and down.
pub(super) fn lattice([width, height]: [u32; 2], faces: u32) -> [u32; 2] {
    if faces > 1 { [3 * width, 2 * height] } else { [width + 2, height + 2] }
}

/// Samples of a row whose marks one word has.
const WORD_SAMPLES: u32 = 16;

/// Words below each other that one invocation marks.
const STRIP: u32 = 4;

/// Invocations of a workgroup that marks.
const MARKERS: u64 = 64;

/// The error of a float, four steps of up to 2⁻²³ of it, has an exponent that is smaller by this than that of the float.
const FLOAT_EXPONENTS: u32 = 21;

/// `DepthMapMethod::Automatic` marks differences above so many times the smaller of the two beside them.
const SLOPES: f32 = 2.0;

/// A detector that needs marks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detector {
    rule: DepthEdgeRule,
    /// The use of second differences: `SECOND` in `edge_rule.wgsl`.
    second: u32,
    dangling: Option<DanglingEdges>,
    /// Which triangles without a marked edge are drawn near one: `RINGS` in `depth_edges.wgsl`.
    rings: u32,
}

/// Bits of a threshold. Subnormal thresholds, which a device may flush, count as 0.
pub(super) fn threshold_bits(threshold: f32) -> u32 {
    if threshold < f32::MIN_POSITIVE { 0 } else { threshold.to_bits() }
}

impl Detector {
    /// `None`: the method needs no marks. It decides an edge by its two samples alone, draws every cell, or has contours.
    /// `bits`: how many bits of the stencil the boundary is drawn into. `faces`: the number of maps, 1 or 6. The options
    /// have been checked.
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
            high_threshold: threshold_bits(high),
            low_thresholds: [low, low * share].map(threshold_bits),
            slopes: [slopes, slopes * share].map(threshold_bits),
            noise: 0,
            noise_exponents: 0,
        };
        // Triangles on slopes are omitted, and the boundary is off by half a texel there. Jitter of several bits adds as
        // much.
        let rings = u32::from(second > 0) + u32::from(bits > 1);
        Some(Self { rule, second, dangling, rings })
    }

    /// The count of strips of words.
    fn strips(&self) -> u64 {
        let [across, down] = self.rule.words;
        u64::from(across) * u64::from(down.div_ceil(STRIP))
    }

    /// The fields of [`EdgeStages::buffers`].
    pub(super) fn buffers<B>(&self, make: &mut impl FnMut(Wanted<'static>) -> B) -> [B; 4] {
        let words = u64::from(self.rule.words[0]) * u64::from(self.rule.words[1]);
        let continued_words = if self.dangling.is_some() { words } else { 1 };
        [
            make(Wanted::new("edges of a depth map", 4 * words)),
            make(Wanted::new("continued edges of a depth map", 4 * continued_words)),
            make(Wanted::new("faint edges of a depth map", 4 * continued_words)),
            make(Wanted::new("samples of a depth map", 4 * words)),
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
    /// Marks, and marks after a pass that continues them, which are swapped each pass; faint edges; bits of samples.
    buffers: [wgpu::Buffer; 4],
}

impl EdgeStages {
    pub(super) fn new(shared: &Pipelines, detector: Detector, buffers: [wgpu::Buffer; 4]) -> Self {
        // Each pass has only its constants, so that more pipelines are shared.
        let mark = [("SECOND", f64::from(detector.second)), ("CONTINUES", switch(detector.dangling.is_some()))];
        let count = [("RINGS", f64::from(detector.rings))];
        let passes = [("depth_edges_continue", &[][..]), ("depth_edges_count", &count)];
        let stages = passes.map(|(entry_point, constants)| shared.compute(&DEPTH_EDGES, entry_point, constants));
        Self { detector, mark: ObjectStage::new(shared, &DEPTH_EDGES, "depth_edges_mark", &mark), stages, buffers }
    }

    /// Marks, continues, counts. `share` and `constant`: the error of depths, from their formats. `get`: what all stages
    /// of cells read. `has_objects`: whether edges between objects are marked. `few`: workgroups that loop over blocks.
    pub(super) fn steps<'a>(
        &'a self,
        shared: &Pipelines,
        [share, constant]: [f64; 2],
        get: impl Fn(&str) -> Option<Resource<'a>>,
        (has_objects, few): (bool, u32),
    ) -> Vec<Step> {
        let device = shared.device();
        let rule = DepthEdgeRule {
            noise: threshold_bits(constant as f32),
            noise_exponents: if share > 0.0 { FLOAT_EXPONENTS } else { 0 },
            ..self.detector.rule
        };
        let rules = filled(device, "edges of a depth map", bytemuck::bytes_of(&rule), wgpu::BufferUsages::UNIFORM);
        let continued = self.detector.dangling.map_or(0, |dangling| dangling.cells as usize);
        let bind = |stage: &Pipeline, count: u32, out: usize| -> Dispatch {
            let resource = |name: &str| {
                Some(match name {
                    "edge_rule" => uniform::<DepthEdgeRule>(&rules, 0),
                    "edges_before" => whole(&self.buffers[1 - out]),
                    "edges" => whole(&self.buffers[out]),
                    "faint_edges" => whole(&self.buffers[2]),
                    "sample_bits" => whole(&self.buffers[3]),
                    _ => return get(name),
                })
            };
            stage.dispatch(device, Workgroups::over(device, count), resource)
        };
        let (mark, [forward, count]) = (self.mark.get(shared, has_objects), &self.stages);
        let marking = self.detector.strips().div_ceil(MARKERS) as u32;
        let mut steps = vec![mark.pass([bind(&mark, marking, 0)])];
        if continued > 0 {
            let passes = [0, 1].map(|out| bind(forward, rule.blocks, out));
            steps.push(forward.pass((1..=continued).map(|pass| passes[pass % 2].clone())));
        }
        steps.push(count.pass([bind(count, few, 1 - continued % 2)]));
        steps
    }
}
