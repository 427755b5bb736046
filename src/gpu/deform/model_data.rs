//! The geometry of a model as the deform stage reads it, in chunks. Each array is bound from the first item of the
//! chunk on.

use std::ops::Range;

use wgpu::BufferUsages;

use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, MemoryError, check, filled, padded};
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::DeformChunk;
use crate::model::{Geometry, Influences, InstancePose, Model, PoseMismatch};

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

/// A dispatch of the deform stage.
#[derive(Clone, Debug)]
pub(super) struct PlannedDispatch {
    pub(super) instance: usize,
    pub(super) chunk: DeformChunk,
    pub(super) rest: Range<u64>,
    pub(super) morph: Range<u64>,
    pub(super) skin: Range<u64>,
    pub(super) sources: Range<u64>,
    pub(super) positions: Range<u64>,
}

/// Sizes and offsets of everything that the deform stage reads.
#[derive(Debug)]
pub(super) struct ModelData {
    geometries: Vec<Vec<GeometryChunk>>,
    pub(super) pose_layouts: Vec<PoseLayout>,
    pub(super) pose_words: u64,
    pub(super) vertices: u64,
    bytes: [u64; 4],
    dispatches: u64,
}

const LABELS: [&str; 4] = ["rest positions", "morph targets", "influences", "source vertices"];

impl ModelData {
    pub(super) fn new(model: &Model, split: &DispatchLimits) -> Result<Self, MemoryError> {
        let mut bytes = [0; 4];
        let mut geometries = Vec::with_capacity(model.geometries().len());
        for geometry in model.geometries() {
            geometries.push(chunk_geometry(geometry, split, &mut bytes)?);
        }
        let mut pose_words = 0_u64;
        let mut pose_layouts = Vec::with_capacity(model.instances().len());
        for geometry in model.placed_geometries() {
            let joints = geometry.joints_needed() as u64;
            let target_count = geometry.morph_targets().len() as u64;
            let (palette, targets) = (pose_words, pose_words + MATRIX_WORDS * joints);
            pose_words = targets + 2 * target_count;
            if pose_words * 4 > split.binding {
                return Err(MemoryError::Binding { what: "pose", bytes: pose_words * 4, limit: split.binding });
            }
            pose_layouts.push(PoseLayout {
                palette: palette as u32,
                joints: joints as u32,
                targets: targets as u32,
                target_count: target_count as u32,
                influences: geometry.influences().map_or(0, Influences::most_per_vertex) as u32,
            });
        }
        let dispatches = model.instances().iter().map(|instance| geometries[instance.geometry()].len() as u64);
        Ok(Self {
            dispatches: dispatches.sum(),
            geometries,
            pose_layouts,
            pose_words,
            vertices: model.vertex_count() as u64,
            bytes,
        })
    }

    /// Checks all sizes before any buffer is made.
    pub(super) fn check(&self, split: &DispatchLimits, memory_limit: Option<u64>) -> Result<u64, MemoryError> {
        let arrays = LABELS.into_iter().zip(self.bytes);
        let uniforms = self.dispatches * UniformTable::stride::<DeformChunk>() as u64;
        let own = [("positions", self.vertices * 12), ("pose", self.pose_words * 4), ("deform chunks", uniforms)];
        let allocations: Vec<_> =
            arrays.chain(own).map(|(label, bytes)| Allocation { label, bytes: padded(bytes) }).collect();
        check(&allocations, split.buffer, memory_limit)
    }

    /// Rest positions, morph targets, influences and source vertices as buffers.
    pub(super) fn upload(&self, device: &wgpu::Device, model: &Model) -> [wgpu::Buffer; 4] {
        let chunks = || {
            model.geometries().iter().zip(&self.geometries).flat_map(|(g, chunks)| chunks.iter().map(move |c| (g, c)))
        };
        let make = |array: usize,
                    place: fn(&GeometryChunk) -> &Range<u64>,
                    words: fn(&Geometry, &Range<usize>) -> Vec<u32>| {
            let mut contents: Vec<u32> = Vec::with_capacity(self.bytes[array] as usize / 4);
            for (geometry, chunk) in chunks() {
                contents.resize(place(chunk).start as usize / 4, 0);
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

    /// The dispatches of all instances in order, with the constant part of their uniforms.
    pub(super) fn plan(&self, model: &Model, split: &DispatchLimits) -> Vec<PlannedDispatch> {
        let mut dispatches = Vec::new();
        let mut first_vertex = 0_u64;
        for (index, (instance, pose)) in model.instances().iter().zip(&self.pose_layouts).enumerate() {
            let geometry = &model.geometries()[instance.geometry()];
            for chunk in &self.geometries[instance.geometry()] {
                let begin = 12 * (first_vertex + chunk.vertices.start as u64);
                let bound = split.align_down(begin);
                dispatches.push(PlannedDispatch {
                    instance: index,
                    chunk: DeformChunk {
                        count: chunk.vertices.len() as u32,
                        first_word: ((begin - bound) / 4) as u32,
                        palette: pose.palette,
                        targets: pose.targets,
                        target_count: 0,
                        skinned: u32::from(geometry.influences().is_some()),
                        displaced: 0,
                        time: 0.0,
                    },
                    rest: chunk.rest.clone(),
                    morph: chunk.morph.clone(),
                    skin: chunk.skin.clone(),
                    sources: chunk.sources.clone(),
                    positions: bound..begin + 12 * chunk.vertices.len() as u64,
                });
            }
            first_vertex += geometry.positions().len() as u64;
        }
        dispatches
    }
}

/// Cuts a geometry so that the arrays of each chunk fit a binding, and places them behind `ends`.
fn chunk_geometry(
    geometry: &Geometry,
    split: &DispatchLimits,
    ends: &mut [u64; 4],
) -> Result<Vec<GeometryChunk>, MemoryError> {
    // A dispatch also binds positions before its own, up to one alignment.
    let morph_bytes = 12 * geometry.morph_targets().len() as u64;
    let most_influences = geometry.influences().map_or(0, |influences| influences.most_per_vertex() as u64);
    let bytes_per_vertex = 13.max(morph_bytes).max(8 + 8 * most_influences);
    let runs = split.chunks("vertices of a deforming mesh", geometry.positions().len(), bytes_per_vertex)?;
    let mut place = |array: usize, bytes: u64| {
        let begin = split.align_up(ends[array]);
        // The range is never empty, because an array without elements is still bound.
        ends[array] = begin + bytes.max(4);
        begin..ends[array]
    };
    let chunks = runs.into_iter().map(|vertices| GeometryChunk {
        rest: place(0, 12 * vertices.len() as u64),
        morph: place(1, morph_bytes * vertices.len() as u64),
        skin: place(2, 4 * skin_word_count(geometry, &vertices)),
        sources: place(3, 4 * vertices.len() as u64),
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
    pub(super) fn check(&self, instance: usize, pose: &InstancePose) -> Result<(), PoseMismatch> {
        pose.check_counts(instance, self.joints as usize, self.target_count as usize)
    }
}
