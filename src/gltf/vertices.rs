//! A primitive's vertices: positions, morph offsets, joints.

use super::document::Primitive;
use super::error::GltfError;
use super::formats;
use super::reader::Reader;
use super::warning::GltfWarning;

/// Vertices that primitives with the same accessors share.
#[derive(Debug)]
pub(super) struct Vertices {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) targets: Vec<Vec<[f32; 3]>>,
    pub(super) bindings: Bindings,
}

/// Joints and weights of all vertices, without those of weight zero. Empty for a primitive without joints.
#[derive(Debug, Default)]
pub(super) struct Bindings {
    /// The number of entries of each vertex.
    pub(super) counts: Vec<u32>,
    pub(super) joints: Vec<u32>,
    pub(super) weights: Vec<f32>,
    pub(super) highest: Option<HighestJoint>,
}

/// The highest joint that some vertices of a primitive name.
#[derive(Clone, Debug)]
pub(super) struct HighestJoint {
    pub(super) joint: u32,
    pub(super) vertex: usize,
    /// JSON path of the attribute.
    pub(super) place: String,
}

/// Reads a primitive's vertices; `place` is its JSON path. `skinned`: a skin moves them.
pub(super) fn read(
    reader: &Reader<'_>,
    primitive: &Primitive,
    position: usize,
    skinned: bool,
    place: &str,
) -> Result<Vertices, GltfError> {
    let (positions, bad) = offsets(reader, position, &format!("{place}.attributes.POSITION"))?;
    if let Some(NonFinite { count: vertices, first }) = bad {
        let place = format!("{place}.attributes.POSITION");
        reader.warnings.push(GltfWarning::NonFinitePositions { place, vertices, first })?;
    }
    let mut targets = Vec::new();
    for (t, &target) in primitive.targets.iter().enumerate() {
        let place = format!("{place}.targets[{t}].POSITION");
        targets.push(if let Some(target) = target {
            same_count(reader.count(target)?, positions.len(), &place)?;
            let (offsets, bad) = offsets(reader, target, &place)?;
            if let Some(NonFinite { count: vertices, first }) = bad {
                reader.warnings.push(GltfWarning::NonFiniteOffsets { place, vertices, first })?;
            }
            offsets
        } else {
            reader.charge(positions.len() as u64, 12, &|| place.clone())?;
            vec![[0.0; 3]; positions.len()]
        });
    }
    let bindings = match &primitive.influences_fault {
        Some(fault) => Err(GltfError::clone(fault)),
        None => bindings(reader, primitive, positions.len(), place),
    };
    // Without a skin nobody asks for joints.
    let bindings = if skinned { bindings? } else { reader.warnings.leave_out(bindings)?.unwrap_or_default() };
    Ok(Vertices { positions, targets, bindings })
}

/// Vectors that are not finite.
struct NonFinite {
    count: usize,
    first: usize,
}

/// Vectors, and those of them that are not finite.
fn offsets(reader: &Reader<'_>, accessor: usize, place: &str) -> Result<(Vec<[f32; 3]>, Option<NonFinite>), GltfError> {
    let format = if reader.document.quantized { formats::POSITION_QUANTIZED } else { formats::POSITION };
    let vectors = reader.vectors(accessor, format, place)?;
    let mut bad = (0..vectors.len()).filter(|&v| !vectors[v].iter().all(|c: &f32| c.is_finite()));
    let first = bad.next();
    let count = 1 + bad.count();
    Ok((vectors, first.map(|first| NonFinite { count, first })))
}

fn same_count(count: usize, expected: usize, place: &str) -> Result<(), GltfError> {
    if count == expected {
        return Ok(());
    }
    Err(GltfError::Count { place: place.to_owned(), count, expected })
}

struct Set {
    joints: Vec<[u32; 4]>,
    weights: Vec<[f32; 4]>,
    joints_place: String,
}

fn bindings(reader: &Reader<'_>, primitive: &Primitive, vertices: usize, place: &str) -> Result<Bindings, GltfError> {
    let mark = reader.budget.mark();
    let mut sets = Vec::new();
    for set in &primitive.influences {
        let joints_place = format!("{place}.attributes.JOINTS_{}", set.set);
        let weights_place = format!("{place}.attributes.WEIGHTS_{}", set.set);
        same_count(reader.count(set.joints)?, vertices, &joints_place)?;
        same_count(reader.count(set.weights)?, vertices, &weights_place)?;
        let joints = reader.integers(set.joints, formats::JOINTS, &joints_place)?;
        let weights: Vec<[f32; 4]> = reader.vectors(set.weights, formats::WEIGHTS, &weights_place)?;
        let bad = |w: &f32| !(w.is_finite() && *w >= 0.0);
        if let Some((vertex, weights)) = weights.iter().enumerate().find(|(_, w)| w.iter().any(bad)) {
            return Err(GltfError::Weight {
                place: weights_place,
                vertex,
                weight: weights.iter().copied().find(bad).unwrap_or(f32::NAN),
            });
        }
        sets.push(Set { joints: joints.as_chunks().0.to_vec(), weights, joints_place });
    }
    let mut bindings = Bindings::default();
    if sets.is_empty() {
        return Ok(bindings);
    }
    // Four joints and weights of 4 bytes for each set, and a count, in lists that double.
    reader.charge(vertices as u64, 3 * (32 * sets.len() as u64 + 4), &|| format!("{place}.attributes"))?;
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
                    self.entry(joint, weight, vertex, &set.joints_place);
                }
            }
        }
        if start == self.joints.len() {
            self.entry(sets[0].joints[vertex][0], 1.0, vertex, &sets[0].joints_place);
        }
        self.counts.push((self.joints.len() - start) as u32);
    }

    fn entry(&mut self, joint: u32, weight: f32, vertex: usize, place: &str) {
        self.joints.push(joint);
        self.weights.push(weight);
        if self.highest.as_ref().is_none_or(|highest| joint > highest.joint) {
            self.highest = Some(HighestJoint { joint, vertex, place: place.to_owned() });
        }
    }
}
