//! The geometry of a model as the deform stage reads it, in chunks, and the dispatches that take them. A dispatch takes as
//! many chunks as its bindings hold, of all instances.

use std::ops::Range;

use wgpu::BufferUsages;

use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::{DispatchLimits, WORKGROUP};
use crate::gpu::common::memory::{Allocation, check, filled, padded};
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::{DeformChunk, DeformDispatch};
use crate::model::{Geometry, Influences, InstancePose, Model, ModelError};

/// The words of a 3×4 matrix.
const MATRIX_WORDS: u64 = 12;

/// A chunk of a geometry's vertices, with its bytes in each array.
#[derive(Clone, Debug)]
struct GeometryChunk {
    vertices: Range<usize>,
    rest: Range<u64>,
    morph: Range<u64>,
    skin: Range<u64>,
    sources: Range<u64>,
}

/// Where the pose of an instance lies, in words, and how many matrices and weights it needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseLayout {
    pub(super) palette: u32,
    pub(super) joints: u32,
    pub(super) targets: u32,
    pub(super) target_count: u32,
    /// The largest number of influences of a vertex.
    pub(super) influences: u32,
}

/// A chunk of an instance's vertices, with its bytes in each array.
#[derive(Clone, Debug)]
struct InstanceChunk {
    instance: usize,
    record: DeformChunk,
    arrays: [Range<u64>; ARRAYS],
}

/// Arrays that a dispatch binds in part: rest positions, morph targets, influences, source vertices, positions.
const ARRAYS: usize = 5;

/// A dispatch of the deform stage.
#[derive(Clone, Debug, Default)]
pub(super) struct PlannedDispatch {
    /// The word in the pose where the chunks of its workgroups begin.
    pub(super) first_word: u32,
    pub(super) workgroups: u32,
    /// The bytes that it binds: rest positions, morph targets, influences, source vertices, positions.
    pub(super) arrays: [Range<u64>; ARRAYS],
}

/// The dispatches, and what the pose holds beside matrices and weights.
#[derive(Debug, Default)]
pub(super) struct Plan {
    pub(super) dispatches: Vec<PlannedDispatch>,
    /// The chunks that the pose begins with, and their instances.
    pub(super) chunks: Vec<(usize, DeformChunk)>,
    /// The word of the chunk of each workgroup, with which the pose ends.
    pub(super) workgroups: Vec<u32>,
}

/// Sizes and offsets of everything that the deform stage reads.
#[derive(Debug)]
pub(super) struct ModelData {
    geometries: Vec<Vec<GeometryChunk>>,
    pub(super) pose_layouts: Vec<PoseLayout>,
    pub(super) pose_words: u64,
    /// The word of the pose where for each instance it is 1 if its positions are a point, and then 1 if it is not needed.
    pub(super) before: u64,
    pub(super) vertices: u64,
    bytes: [u64; 4],
    /// Chunks of all instances.
    chunks: u64,
    workgroups: u64,
}

/// Words of a chunk in the pose.
const CHUNK_WORDS: u64 = (size_of::<DeformChunk>() / 4) as u64;

const LABELS: [&str; 4] = ["rest positions", "morph targets", "influences", "source vertices"];

impl ModelData {
    pub(super) fn new(model: &Model, split: &DispatchLimits) -> Result<Self, DeviceError> {
        let mut bytes = [0; 4];
        let mut geometries = Vec::with_capacity(model.geometries().len());
        for geometry in model.geometries() {
            geometries.push(chunk_geometry(geometry, split, &mut bytes)?);
        }
        let of_geometry = |instance: &crate::model::Instance| &geometries[instance.geometry()];
        let chunks = model.instances().iter().map(|instance| of_geometry(instance).len() as u64).sum::<u64>();
        let workgroups = |chunk: &GeometryChunk| chunk.vertices.len().div_ceil(WORKGROUP as usize) as u64;
        let workgroups = model.instances().iter().flat_map(|instance| of_geometry(instance).iter().map(workgroups));
        let workgroups = workgroups.sum::<u64>();
        let before = CHUNK_WORDS * chunks;
        let mut pose_words = before + 2 * model.instances().len() as u64;
        let mut pose_layouts = Vec::with_capacity(model.instances().len());
        for geometry in model.placed_geometries() {
            let joints = geometry.joints_needed() as u64;
            let target_count = geometry.morph_targets().len() as u64;
            let (palette, targets) = (pose_words, pose_words + MATRIX_WORDS * joints);
            pose_words = targets + 2 * target_count;
            let bytes = 4 * (pose_words + workgroups);
            if bytes > split.binding {
                return Err(DeviceError::BindingTooLarge { what: "pose", bytes, limit: split.binding });
            }
            pose_layouts.push(PoseLayout {
                palette: palette as u32,
                joints: joints as u32,
                targets: targets as u32,
                target_count: target_count as u32,
                influences: geometry.influences().map_or(0, Influences::most_per_vertex) as u32,
            });
        }
        Ok(Self {
            chunks,
            workgroups,
            geometries,
            pose_layouts,
            pose_words,
            before,
            vertices: model.vertex_count() as u64,
            bytes,
        })
    }

    /// Checks all sizes before any buffer is made.
    pub(super) fn check(&self, split: &DispatchLimits, memory_limit: Option<u64>) -> Result<u64, DeviceError> {
        // There is never more than one dispatch for each chunk.
        let uniforms = self.chunks * UniformTable::stride::<DeformDispatch>() as u64;
        let of_model = [
            ("positions", self.vertices * 12),
            ("pose", 4 * (self.pose_words + self.workgroups)),
            ("deform dispatches", uniforms),
            ("deformed", 4 * self.pose_layouts.len() as u64),
        ];
        let arrays = LABELS.into_iter().zip(self.bytes);
        let allocation = |(label, bytes)| Allocation { label, bytes: padded(bytes) };
        check(&arrays.chain(of_model).map(allocation).collect::<Vec<_>>(), split.buffer, memory_limit)
    }

    /// Rest positions, morph targets, influences and source vertices as buffers.
    pub(super) fn upload(&self, device: &wgpu::Device, model: &Model) -> [wgpu::Buffer; 4] {
        let chunks = || {
            model.geometries().iter().zip(&self.geometries).flat_map(|(g, chunks)| chunks.iter().map(move |c| (g, c)))
        };
        let make = |array: usize,
                    range: fn(&GeometryChunk) -> &Range<u64>,
                    words: fn(&Geometry, &Range<usize>) -> Vec<u32>| {
            let mut contents: Vec<u32> = Vec::with_capacity(self.bytes[array] as usize / 4);
            for (geometry, chunk) in chunks() {
                contents.resize(range(chunk).start as usize / 4, 0);
                contents.append(&mut words(geometry, &chunk.vertices));
            }
            contents.resize(self.bytes[array] as usize / 4, 0);
            filled(device, LABELS[array], bytemuck::cast_slice(&contents), BufferUsages::STORAGE)
        };
        [
            make(0, |chunk| &chunk.rest, |g, v| bytemuck::cast_slice(&g.positions()[v.clone()]).to_vec()),
            make(
                1,
                |chunk| &chunk.morph,
                |g, v| {
                    g.morph_targets().iter().flat_map(|t| bytemuck::cast_slice(&t[v.clone()]).iter().copied()).collect()
                },
            ),
            make(2, |chunk| &chunk.skin, skin_words),
            make(3, |chunk| &chunk.sources, |g, v| g.source_vertices()[v.clone()].to_vec()),
        ]
    }

    /// The dispatches over all instances, in order.
    pub(super) fn plan(&self, model: &Model, split: &DispatchLimits) -> Plan {
        let mut plan = Plan::default();
        let mut chunks_of_dispatch: Vec<InstanceChunk> = Vec::new();
        let mut arrays: [Range<u64>; ARRAYS] = Default::default();
        let mut workgroups = 0;
        for chunk in self.instance_chunks(model, split) {
            let added = u64::from(chunk.record.count.div_ceil(WORKGROUP));
            let whole: [Range<u64>; ARRAYS] = std::array::from_fn(|array| union(&arrays[array], &chunk.arrays[array]));
            let fits = whole.iter().all(|range| range.end - range.start <= split.binding);
            if !chunks_of_dispatch.is_empty() && (!fits || workgroups + added > split.workgroups) {
                plan.dispatch(std::mem::take(&mut chunks_of_dispatch), &arrays, self.pose_words);
                (arrays, workgroups) = (chunk.arrays.clone(), added);
            } else {
                (arrays, workgroups) = (whole, workgroups + added);
            }
            chunks_of_dispatch.push(chunk);
        }
        if !chunks_of_dispatch.is_empty() {
            plan.dispatch(chunks_of_dispatch, &arrays, self.pose_words);
        }
        plan
    }

    /// The chunks of all instances in order. Their words are not known yet.
    fn instance_chunks(&self, model: &Model, split: &DispatchLimits) -> Vec<InstanceChunk> {
        let mut chunks = Vec::with_capacity(self.chunks as usize);
        let mut first_vertex = 0_u64;
        for (index, (instance, pose)) in model.instances().iter().zip(&self.pose_layouts).enumerate() {
            let geometry = &model.geometries()[instance.geometry()];
            for chunk in &self.geometries[instance.geometry()] {
                let begin = 12 * (first_vertex + chunk.vertices.start as u64);
                let bound = split.align_down(begin);
                let record = DeformChunk {
                    count: chunk.vertices.len() as u32,
                    positions: ((begin - bound) / 4) as u32,
                    palette: pose.palette,
                    targets: pose.targets,
                    skinned: u32::from(geometry.influences().is_some()),
                    before: self.before as u32 + index as u32,
                    ..bytemuck::Zeroable::zeroed()
                };
                let positions = bound..begin + 12 * chunk.vertices.len() as u64;
                let GeometryChunk { rest, morph, skin, sources, .. } = chunk.clone();
                chunks.push(InstanceChunk { instance: index, record, arrays: [rest, morph, skin, sources, positions] });
            }
            first_vertex += geometry.positions().len() as u64;
        }
        chunks
    }
}

/// The smallest range with both. An empty range counts nowhere.
fn union(a: &Range<u64>, b: &Range<u64>) -> Range<u64> {
    if a.is_empty() { b.clone() } else { a.start.min(b.start)..a.end.max(b.end) }
}

impl Plan {
    /// Adds a dispatch for chunks that lie in these parts of the arrays. The workgroups' chunks follow `pose_words` words.
    fn dispatch(&mut self, chunks: Vec<InstanceChunk>, arrays: &[Range<u64>; ARRAYS], pose_words: u64) {
        let first = self.workgroups.len();
        for InstanceChunk { instance, record, arrays: of_chunk } in chunks {
            let word = (CHUNK_WORDS * self.chunks.len() as u64) as u32;
            let [rest, morph, skin, sources, positions] =
                [0, 1, 2, 3, 4].map(|array: usize| ((of_chunk[array].start - arrays[array].start) / 4) as u32);
            let record = DeformChunk {
                first_workgroup: (self.workgroups.len() - first) as u32,
                rest,
                morph,
                skin,
                sources,
                positions: record.positions + positions,
                ..record
            };
            self.chunks.push((instance, record));
            self.workgroups.extend(std::iter::repeat_n(word, record.count.div_ceil(WORKGROUP) as usize));
        }
        self.dispatches.push(PlannedDispatch {
            first_word: (pose_words + first as u64) as u32,
            workgroups: (self.workgroups.len() - first) as u32,
            arrays: arrays.clone(),
        });
    }
}

/// Cuts a geometry so that the arrays of each chunk fit a binding, and appends them at `ends`.
fn chunk_geometry(
    geometry: &Geometry,
    split: &DispatchLimits,
    ends: &mut [u64; 4],
) -> Result<Vec<GeometryChunk>, DeviceError> {
    // A dispatch also binds positions before its first, up to one alignment.
    let morph_bytes = 12 * geometry.morph_targets().len() as u64;
    let most_influences = geometry.influences().map_or(0, |influences| influences.most_per_vertex() as u64);
    let bytes_per_vertex = 13.max(morph_bytes).max(8 + 8 * most_influences);
    let ranges = split.chunks("vertices of a deforming mesh", geometry.positions().len(), bytes_per_vertex)?;
    let mut append = |array: usize, bytes: u64| {
        let begin = split.align_up(ends[array]);
        // The range is never empty, because an array without elements is still bound.
        ends[array] = begin + bytes.max(4);
        begin..ends[array]
    };
    let chunks = ranges.into_iter().map(|vertices| GeometryChunk {
        rest: append(0, 12 * vertices.len() as u64),
        morph: append(1, morph_bytes * vertices.len() as u64),
        skin: append(2, 4 * skin_word_count(geometry, &vertices)),
        sources: append(3, 4 * vertices.len() as u64),
        vertices,
    });
    Ok(chunks.collect())
}

fn skin_word_count(geometry: &Geometry, vertices: &Range<usize>) -> u64 {
    geometry.influences().map_or(0, |influences| {
        let entries = influences.offsets()[vertices.end] - influences.offsets()[vertices.start];
        vertices.len() as u64 + 1 + 2 * u64::from(entries)
    })
}

/// The offset of each vertex's influences, then joint and weight of each influence.
fn skin_words(geometry: &Geometry, vertices: &Range<usize>) -> Vec<u32> {
    let Some(influences) = geometry.influences() else {
        return Vec::new();
    };
    let first = influences.offsets()[vertices.start];
    let offsets = influences.offsets()[vertices.start..=vertices.end].iter().map(|offset| offset - first);
    let entries = first as usize..influences.offsets()[vertices.end] as usize;
    let pairs = influences.joints()[entries.clone()].iter().zip(&influences.weights()[entries]);
    offsets.chain(pairs.flat_map(|(&joint, weight)| [joint, weight.to_bits()])).collect()
}

impl PoseLayout {
    /// Checks that the pose has the matrices and weights that the geometry of instance number `instance` needs.
    pub(super) fn check(&self, instance: usize, pose: &InstancePose) -> Result<(), ModelError> {
        pose.check_counts(instance, self.joints as usize, self.target_count as usize)
    }
}
