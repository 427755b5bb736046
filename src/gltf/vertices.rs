//! A primitive's vertices: positions, morph offsets, joints.

use super::document::{InfluenceSet, Primitive, checked};
use super::error::GltfError;
use super::reader::{self, Reader};
use super::warning::GltfWarning;

/// Vertices that primitives with the same accessors share.
#[derive(Debug)]
pub(super) struct Vertices {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) targets: Vec<Vec<[f32; 3]>>,
    pub(super) bindings: Bindings,
}

/// Joints and weights of all vertices, without those of weight zero; a vertex has at least one. Empty for a primitive
/// without joints.
#[derive(Debug, Default)]
pub(super) struct Bindings {
    /// The number of entries of each vertex.
    pub(super) counts: Vec<u32>,
    pub(super) joints: Vec<u32>,
    pub(super) weights: Vec<f32>,
    pub(super) highest: Option<HighestJoint>,
}

/// The highest joint that some vertices of a primitive follow. One of weight zero may be higher.
#[derive(Clone, Debug)]
pub(super) struct HighestJoint {
    pub(super) joint: u32,
    pub(super) vertex: usize,
    /// JSON path of the attribute.
    pub(super) json_path: String,
}

/// Reads a primitive's vertices; `json_path` is its JSON path. `skinned`: a skin moves them.
pub(super) fn read(
    reader: &Reader<'_>,
    primitive: &Primitive,
    position: usize,
    skinned: bool,
    json_path: &str,
) -> Result<Vertices, GltfError> {
    let positions = vectors(reader, position, format!("{json_path}.attributes.POSITION"), false)?;
    let target = |(t, target): (usize, &Option<usize>)| {
        let json_path = format!("{json_path}.targets[{t}].POSITION");
        let Some(target) = *target else {
            reader.budget.charge(positions.len() as u64, 12, &|| json_path.clone())?;
            return Ok(vec![[0.0; 3]; positions.len()]);
        };
        reader.check_count(target, positions.len(), &json_path)?;
        vectors(reader, target, json_path, true)
    };
    let targets = primitive.targets.iter().enumerate().map(target).collect::<Result<_, GltfError>>()?;
    let bindings = checked(&primitive.influences).and_then(|sets| bindings(reader, sets, positions.len(), json_path));
    // Without a skin nothing uses joints.
    let bindings = if skinned { bindings? } else { reader.warnings.leave_out(bindings)?.unwrap_or_default() };
    Ok(Vertices { positions, targets, bindings })
}

/// Positions, or offsets of a morph target. There is a warning if some are not finite.
fn vectors(
    reader: &Reader<'_>,
    accessor: usize,
    json_path: String,
    is_target: bool,
) -> Result<Vec<[f32; 3]>, GltfError> {
    let format = if reader.document.quantized { reader::POSITION_QUANTIZED } else { reader::VECTORS };
    let vectors = reader.vectors(accessor, format, &json_path)?;
    let mut bad = (0..vectors.len()).filter(|&v| !vectors[v].iter().all(|c: &f32| c.is_finite()));
    if let Some(first) = bad.next() {
        let vertices = 1 + bad.count();
        reader.warnings.push(GltfWarning::NonFinite { json_path, vertices, first, is_target })?;
    }
    Ok(vectors)
}

struct Set {
    joints: Vec<[u32; 4]>,
    weights: Vec<[f32; 4]>,
    joints_path: String,
}

fn bindings(
    reader: &Reader<'_>,
    sets: &[InfluenceSet],
    vertices: usize,
    json_path: &str,
) -> Result<Bindings, GltfError> {
    let mark = reader.budget.mark();
    let set = |&InfluenceSet { set, joints, weights }: &InfluenceSet| {
        let [joints_path, weights_path] =
            ["JOINTS", "WEIGHTS"].map(|name| format!("{json_path}.attributes.{name}_{set}"));
        reader.check_count(joints, vertices, &joints_path)?;
        reader.check_count(weights, vertices, &weights_path)?;
        let joints = reader.integers(joints, reader::JOINTS, &joints_path)?.as_chunks().0.to_vec();
        let weights: Vec<[f32; 4]> = reader.vectors(weights, reader::WEIGHTS, &weights_path)?;
        let is_bad = |weight: f32| !(weight.is_finite() && weight >= 0.0);
        let mut each = weights.as_flattened().iter().copied().enumerate();
        if let Some((at, weight)) = each.find(|&(_, weight)| is_bad(weight)) {
            let json_path = format!("{weights_path}, vertex {}", at / 4);
            return Err(GltfError::invalid(
                json_path,
                format!(": weight {weight} is not a finite number of 0 or more"),
            ));
        }
        Ok(Set { joints, weights, joints_path })
    };
    let sets: Vec<Set> = sets.iter().map(set).collect::<Result<_, _>>()?;
    let mut bindings = Bindings::default();
    if sets.is_empty() {
        return Ok(bindings);
    }
    // Four joints and weights of 4 bytes for each set, and a count, in lists that double.
    reader.budget.charge(vertices as u64, 3 * (32 * sets.len() as u64 + 4), &|| format!("{json_path}.attributes"))?;
    for vertex in 0..vertices {
        bindings.push(&sets, vertex);
    }
    drop(sets);
    let Bindings { counts, joints, weights, .. } = &bindings;
    reader.budget.settle(mark, 4 * (counts.capacity() + joints.capacity() + weights.capacity()) as u64);
    Ok(bindings)
}

impl Bindings {
    /// Weights are scaled to the sum 1 in `f64` and rounded once. If all are zero, the vertex follows the first joint
    /// listed.
    fn push(&mut self, sets: &[Set], vertex: usize) {
        let start = self.joints.len();
        let total: f64 = sets.iter().flat_map(|set| set.weights[vertex]).map(f64::from).sum();
        for set in sets {
            for (joint, weight) in set.joints[vertex].into_iter().zip(set.weights[vertex]) {
                let weight = (f64::from(weight) / total) as f32;
                if weight > 0.0 {
                    self.entry(joint, weight, vertex, &set.joints_path);
                }
            }
        }
        if start == self.joints.len() {
            self.entry(sets[0].joints[vertex][0], 1.0, vertex, &sets[0].joints_path);
        }
        self.counts.push((self.joints.len() - start) as u32);
    }

    fn entry(&mut self, joint: u32, weight: f32, vertex: usize, json_path: &str) {
        self.joints.push(joint);
        self.weights.push(weight);
        if self.highest.as_ref().is_none_or(|highest| joint > highest.joint) {
            self.highest = Some(HighestJoint { joint, vertex, json_path: json_path.to_owned() });
        }
    }
}
