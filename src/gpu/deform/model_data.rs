//! The geometry of a model as the deform stage reads it, in chunks, and the dispatches that take them. A dispatch takes as
//! many chunks as its bindings hold, of all instances.

use std::ops::Range;

use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::{DispatchLimits, WORKGROUP};
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::{DeformChunk, DeformDispatch};
use crate::model::{Geometry, Influences, Model};

/// The words of a 3×4 matrix.
const MATRIX_WORDS: u64 = 12;

/// Words of a chunk in the pose.
const CHUNK_WORDS: u64 = (size_of::<DeformChunk>() / 4) as u64;

/// The arrays of a model.
pub(super) const ARRAYS: [&str; 4] = ["rest positions", "morph targets", "influences", "source vertices"];

/// A chunk of a geometry's vertices, with its bytes in each array.
#[derive(Debug)]
struct GeometryChunk {
    vertices: Range<usize>,
    arrays: [Range<u64>; 4],
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
    /// Where its positions begin, in bytes.
    pub(super) positions: u64,
}

/// The bytes that a dispatch binds of each array, and of the positions.
type Bound = [Range<u64>; 5];

/// A chunk of an instance, with its bytes.
struct InstanceChunk {
    instance: usize,
    record: DeformChunk,
    bound: Bound,
}

/// The chunks of a dispatch, while more may be added.
struct Gathered {
    workgroups: u64,
    /// The bytes around those of all chunks.
    bound: Bound,
    chunks: Vec<InstanceChunk>,
}

/// A dispatch of the deform stage.
#[derive(Debug)]
pub(super) struct PlannedDispatch {
    /// The word in the pose where the chunks of its workgroups begin.
    pub(super) first_word: u32,
    pub(super) workgroups: u32,
    pub(super) bound: Bound,
}

/// Everything that the deform stage reads, and its dispatches.
#[derive(Debug)]
pub(super) struct ModelData {
    pub(super) arrays: [Vec<u32>; 4],
    pub(super) vertices: u64,
    pub(super) layouts: Vec<PoseLayout>,
    /// The words of the pose without those of `workgroups`.
    pub(super) pose_words: u64,
    /// The word of the pose where for each instance it is 1 if its positions are a point, and then 1 if it is not needed.
    pub(super) before: u64,
    /// The chunks that the pose begins with, and their instances.
    pub(super) chunks: Vec<(usize, DeformChunk)>,
    /// The word of the chunk of each workgroup, with which the pose ends.
    pub(super) workgroups: Vec<u32>,
    pub(super) dispatches: Vec<PlannedDispatch>,
}

impl ModelData {
    pub(super) fn new(model: &Model, split: &DispatchLimits) -> Result<Self, DeviceError> {
        let mut arrays = <[Vec<u32>; 4]>::default();
        let chunks = model.geometries().iter().map(|geometry| chunk_geometry(geometry, split, &mut arrays));
        let geometries = chunks.collect::<Result<Vec<_>, _>>()?;
        let chunks = || model.instances().iter().flat_map(|instance| &geometries[instance.geometry()]);
        let before = CHUNK_WORDS * chunks().count() as u64;
        let workgroups = chunks().map(|chunk| chunk.vertices.len().div_ceil(WORKGROUP as usize) as u64).sum::<u64>();
        let mut pose_words = before + 2 * model.instances().len() as u64;
        let (mut layouts, mut positions) = (Vec::with_capacity(model.instances().len()), 0);
        for geometry in model.placed_geometries() {
            let joints = geometry.joints_needed() as u64;
            let target_count = geometry.morph_targets().len() as u64;
            let (palette, targets) = (pose_words, pose_words + MATRIX_WORDS * joints);
            pose_words = targets + 2 * target_count;
            let bytes = 4 * (pose_words + workgroups);
            if bytes > split.binding {
                return Err(DeviceError::BindingTooLarge { what: "pose", bytes, limit: split.binding });
            }
            layouts.push(PoseLayout {
                palette: palette as u32,
                joints: joints as u32,
                targets: targets as u32,
                target_count: target_count as u32,
                influences: geometry.influences().map_or(0, Influences::most_per_vertex) as u32,
                positions,
            });
            positions += 12 * geometry.positions().len() as u64;
        }
        let mut data = Self {
            arrays,
            vertices: model.vertex_count() as u64,
            layouts,
            pose_words,
            before,
            chunks: Vec::new(),
            workgroups: Vec::new(),
            dispatches: Vec::new(),
        };
        data.plan(model, &geometries, split);
        Ok(data)
    }

    /// The words of the pose before the first encode. Each encode writes what comes before the chunks of the workgroups.
    pub(super) fn first_pose(&self) -> Vec<u32> {
        let mut words = vec![0; self.pose_words as usize];
        words.extend(&self.workgroups);
        words
    }

    /// The uniforms of the dispatches.
    pub(super) fn uniforms(&self, displaced: bool, time: f32) -> UniformTable {
        let mut table = UniformTable::default();
        for dispatch in &self.dispatches {
            table.push(&DeformDispatch {
                workgroups: dispatch.first_word,
                displaced: u32::from(displaced),
                time,
                instances: self.layouts.len() as u32,
            });
        }
        table
    }

    /// Adds the dispatches over all instances, in order.
    fn plan(&mut self, model: &Model, geometries: &[Vec<GeometryChunk>], split: &DispatchLimits) {
        let mut dispatches: Vec<Gathered> = Vec::new();
        for (index, (instance, pose)) in model.instances().iter().zip(&self.layouts).enumerate() {
            for chunk in &geometries[instance.geometry()] {
                let begin = pose.positions + 12 * chunk.vertices.start as u64;
                let positions = split.align_down(begin)..begin + 12 * chunk.vertices.len() as u64;
                let record = DeformChunk {
                    count: chunk.vertices.len() as u32,
                    positions: ((begin - positions.start) / 4) as u32,
                    palette: pose.palette,
                    targets: pose.targets,
                    skinned: u32::from(model.geometries()[instance.geometry()].influences().is_some()),
                    before: self.before as u32 + index as u32,
                    ..bytemuck::Zeroable::zeroed()
                };
                let [rest, morph, skin, sources] = chunk.arrays.clone();
                let bound = [rest, morph, skin, sources, positions];
                let added = u64::from(record.count.div_ceil(WORKGROUP));
                if let Some(last) = dispatches.last_mut() {
                    let union = |array: usize| {
                        let (a, b): (&Range<u64>, &Range<u64>) = (&last.bound[array], &bound[array]);
                        a.start.min(b.start)..a.end.max(b.end)
                    };
                    let whole: Bound = std::array::from_fn(union);
                    let fits = whole.iter().all(|range| range.end - range.start <= split.binding);
                    if fits && last.workgroups + added <= split.workgroups {
                        (last.workgroups, last.bound) = (last.workgroups + added, whole);
                        last.chunks.push(InstanceChunk { instance: index, record, bound });
                        continue;
                    }
                }
                let of_all = bound.clone();
                let chunks = vec![InstanceChunk { instance: index, record, bound }];
                dispatches.push(Gathered { workgroups: added, bound: of_all, chunks });
            }
        }
        for Gathered { workgroups, bound, chunks } in dispatches {
            let first = self.workgroups.len();
            for InstanceChunk { instance, record, bound: of_chunk } in chunks {
                let word = (CHUNK_WORDS * self.chunks.len() as u64) as u32;
                let [rest, morph, skin, sources, positions] =
                    [0, 1, 2, 3, 4].map(|array: usize| ((of_chunk[array].start - bound[array].start) / 4) as u32);
                let first_workgroup = (self.workgroups.len() - first) as u32;
                let positions = record.positions + positions;
                self.chunks
                    .push((instance, DeformChunk { first_workgroup, rest, morph, skin, sources, positions, ..record }));
                self.workgroups.extend(std::iter::repeat_n(word, record.count.div_ceil(WORKGROUP) as usize));
            }
            let first_word = (self.pose_words + first as u64) as u32;
            self.dispatches.push(PlannedDispatch { first_word, workgroups: workgroups as u32, bound });
        }
    }
}

/// Cuts a geometry so that the arrays of each chunk fit a binding, and appends them.
fn chunk_geometry(
    geometry: &Geometry,
    split: &DispatchLimits,
    arrays: &mut [Vec<u32>; 4],
) -> Result<Vec<GeometryChunk>, DeviceError> {
    let targets = geometry.morph_targets();
    let most_influences = geometry.influences().map_or(0, |influences| influences.most_per_vertex() as u64);
    // A dispatch also binds positions before its first, up to one alignment.
    let bytes_per_vertex = 13.max(12 * targets.len() as u64).max(8 + 8 * most_influences);
    let ranges = split.chunks("vertices of a deforming mesh", geometry.positions().len(), bytes_per_vertex)?;
    let mut append = |array: usize, words: &[u32]| {
        let array = &mut arrays[array];
        let begin = split.align_up(4 * array.len() as u64);
        array.resize(begin as usize / 4, 0);
        // The range is never empty, because an array without elements is still bound.
        array.extend_from_slice(if words.is_empty() { &[0] } else { words });
        begin..4 * array.len() as u64
    };
    let chunks = ranges.into_iter().map(|vertices| {
        let morph: Vec<[f32; 3]> = targets.iter().flat_map(|target| &target[vertices.clone()]).copied().collect();
        let arrays = [
            append(0, bytemuck::cast_slice(&geometry.positions()[vertices.clone()])),
            append(1, bytemuck::cast_slice(&morph)),
            append(2, &skin_words(geometry, &vertices)),
            append(3, &geometry.source_vertices()[vertices.clone()]),
        ];
        GeometryChunk { vertices, arrays }
    });
    Ok(chunks.collect())
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
