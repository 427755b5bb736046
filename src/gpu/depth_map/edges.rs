//! Detectors that look at more than the ends of an edge, or continue edges, or compare steps in world units for several bits: marks
//! of all edges, which the cells are decided from.

use super::frame_errors::DepthMapEncodeError;
use super::options::{DanglingEdges, DepthEdges, DepthMapOptions};
use super::view::{steps, world_step};
use super::volumes_errors::DepthMapVolumesError;
use crate::ShadowCamera;
use crate::gpu::common::dispatch_limits::{WORKGROUP, loops};
use crate::gpu::common::memory::{Allocation, buffer, filled, guarded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::entry;
use crate::layout::{DepthEdgeRule, DepthMapShape};
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

/// How many times the differences beside it a difference is, where `DepthEdges::Automatic` takes it for an edge.
const SLOPES: f32 = 2.0;

/// How a detector that needs marks decides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detector {
    rule: DepthEdgeRule,
    /// What second differences tell, as the stage's constant has it.
    second: u32,
    /// A threshold in world units.
    world: Option<f32>,
    dangling: Option<DanglingEdges>,
    rings: u32,
}

/// Bits of a threshold. One that a device may flush is none.
pub(super) fn threshold_bits(threshold: f32) -> u32 {
    if threshold < f32::MIN_POSITIVE { 0 } else { threshold.to_bits() }
}

impl Detector {
    /// `None`: edges are decided by their ends alone. The thresholds have been checked.
    pub(super) fn new(options: &DepthMapOptions, faces: u32, size: [u32; 2]) -> Option<Self> {
        let DepthMapOptions { edges, dangling, bits, .. } = *options;
        let (second, low, high, world) = match edges {
            DepthEdges::EveryCell => return None,
            DepthEdges::Differences { threshold } => (0, threshold, 1.0, None),
            DepthEdges::WorldDifferences { threshold } => (0, 0.0, 1.0, Some(threshold)),
            DepthEdges::Outlines => (0, 1.0, 1.0, None),
            DepthEdges::SecondDifferences { low, high } => (1, low, high, None),
            DepthEdges::Automatic => (2, 0.0, 1.0, None),
        };
        // Steps in world units need no marks, but where triangles at the ends of edges are drawn, too.
        if second == 0 && dangling.is_none() && (world.is_none() || bits == 1) {
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
            ratio: [0; 2],
            slopes: [slopes, slopes * share].map(threshold_bits),
            noise: 0,
            noise_exponents: 0,
            at_infinity: 0,
            unused: 0,
        };
        // Left out steep surfaces are moved by half a texel across and down, and by as much again for the parts of a texel of
        // several bits.
        let rings = u32::from(second > 0) + u32::from(bits > 1);
        Some(Self { rule, second, world, dangling, rings })
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
    /// Mark, continue, count.
    stages: [Pipeline; 3],
    /// Two of marks, that take turns, the faint ones, and what is known about samples.
    buffers: [wgpu::Buffer; 4],
}

/// The stages by their places in [`EdgeStages::stages`].
const MARK: usize = 0;
const CONTINUE: usize = 1;
const COUNT: usize = 2;

/// What an encode binds.
pub(super) struct BoundEdges {
    /// Mark, then continue in turn, then count: which stage, and its group.
    passes: Vec<(usize, wgpu::BindGroup)>,
    /// Workgroups of each stage.
    workgroups: [u32; 3],
}

impl EdgeStages {
    pub(super) fn new(shared: &Pipelines, detector: Detector, objects: bool) -> Result<Self, DepthMapVolumesError> {
        // Each pass has its own constants, so that more of them are shared.
        let mark = [
            ("WORLD", u32::from(detector.world.is_some())),
            ("OBJECTS", u32::from(objects)),
            ("SECOND", detector.second),
            ("CONTINUES", u32::from(detector.dangling.is_some())),
        ]
        .map(|(name, value)| (name, f64::from(value)));
        let count = [("RINGS", f64::from(detector.rings))];
        let allocations = detector.allocations();
        let bytes = allocations.iter().map(|allocation| allocation.bytes).sum();
        let device = shared.device();
        let usage = wgpu::BufferUsages::STORAGE;
        let buffers = guarded(device, bytes, || {
            [0, 1, 2, 3].map(|at| buffer(device, allocations[at].label, allocations[at].bytes, usage))
        })?;
        let passes = [("depth_edges_mark", &mark[..]), ("depth_edges_continue", &[]), ("depth_edges_count", &count)];
        let stages = passes.map(|(entry_point, constants)| shared.compute(&DEPTH_EDGES, entry_point, constants));
        Ok(Self { detector, stages, buffers })
    }

    /// The rule for a light whose depths were rounded to `formats`.
    pub(super) fn rule(
        &self,
        light: &ShadowCamera,
        formats: &mut dyn Iterator<Item = wgpu::TextureFormat>,
    ) -> Result<DepthEdgeRule, DepthMapEncodeError> {
        let mut rule = self.detector.rule;
        for format in formats {
            let [share, constant] = steps(format, light.depth).map(|steps| steps as f32);
            rule.noise = rule.noise.max(threshold_bits(constant));
            if share > 0.0 {
                rule.noise_exponents = FLOAT_EXPONENTS;
            }
        }
        if let Some(threshold) = self.detector.world {
            let share = self.detector.dangling.map_or(1.0, |dangling| dangling.share);
            for (level, threshold) in [threshold, threshold * share].into_iter().enumerate() {
                let [low, ratio, infinity] = world_step(light, threshold)?;
                (rule.low[level], rule.ratio[level]) = (low, ratio);
                rule.at_infinity = rule.at_infinity.max(infinity);
            }
        }
        Ok(rule)
    }

    /// `uniform` holds the shape. `textures` are those of depths and objects.
    pub(super) fn bind(
        &self,
        shared: &Pipelines,
        shape: (&DepthMapShape, &wgpu::Buffer),
        rule: &DepthEdgeRule,
        textures: &[wgpu::BindingResource<'_>; 2],
        places: &wgpu::Buffer,
    ) -> BoundEdges {
        let device = shared.device();
        let uniform = filled(device, "edges of a depth map", bytemuck::bytes_of(rule), wgpu::BufferUsages::UNIFORM);
        let continued = self.detector.dangling.map_or(0, |dangling| dangling.cells as usize);
        let group = |stage: usize, out: usize| {
            let resources = [
                ("depth_map", entry::<DepthMapShape>(shape.1)),
                ("depth_texture", textures[0].clone()),
                ("object_texture", textures[1].clone()),
                ("places", places.as_entire_binding()),
                ("edge_rule", entry::<DepthEdgeRule>(&uniform)),
                ("edges_before", self.buffers[1 - out].as_entire_binding()),
                ("edges", self.buffers[out].as_entire_binding()),
                ("faint_edges", self.buffers[2].as_entire_binding()),
                ("sample_bits", self.buffers[3].as_entire_binding()),
            ];
            self.stages[stage].bind(device, &resources)
        };
        let turns = [group(CONTINUE, 0), group(CONTINUE, 1)];
        let mut passes = vec![(MARK, group(MARK, 0))];
        passes.extend((1..=continued).map(|pass| (CONTINUE, turns[pass % 2].clone())));
        passes.push((COUNT, group(COUNT, 1 - continued % 2)));
        let marking = self.detector.strips().div_ceil(MARKERS) as u32;
        BoundEdges {
            passes,
            workgroups: [marking, rule.blocks, loops(device, shape.0.blocks.saturating_mul(WORKGROUP))],
        }
    }

    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bound: &BoundEdges,
        most: u32,
        mut timer: Option<&mut StageTimer>,
    ) {
        for same in bound.passes.chunk_by(|a, b| a.0 == b.0) {
            let Some(&(at, _)) = same.first() else { continue };
            let stage = &self.stages[at];
            let timestamp_writes = timer.as_deref_mut().and_then(|timer| timer.compute_pass(stage.label));
            let label = Some(stage.label);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
            pass.set_pipeline(&stage.compute);
            let workgroups = bound.workgroups[at];
            let rows = workgroups.div_ceil(most).min(most);
            for (_, group) in same {
                pass.set_bind_group(0, group, &[0, 0]);
                pass.dispatch_workgroups(workgroups.div_ceil(rows.max(1)).min(most), rows, 1);
            }
        }
    }
}
