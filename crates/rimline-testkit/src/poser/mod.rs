//! A plain poser in `f64`, written from the glTF 2.0 specification. It shares no code with the library, and decides for
//! tests where the vertices of a posed model are.
//!
//! * [`pose_vertex`]: morph targets and skin of one vertex (sections 3.7.2.2 and 3.7.3);
//! * [`of_model`]: every vertex of a [`Model`] in a [`Pose`];
//! * [`gltf`]: every triangle of a glTF file at one time of an animation, read from the file itself.

mod animation;
mod document;
pub mod gltf;
mod matrix;

use rimline::model::Box3;
use rimline::{Model, Pose};

pub use matrix::Affine;

/// Where a vertex is, and how far an evaluation in `f32` may be from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posed {
    pub position: [f64; 3],
    pub tolerance: [f64; 3],
}

/// One whole ulp of an `f32`, since WGSL names no rounding mode; and the least normal `f32`, which flushing may lose.
const ULP: f64 = 1.192_092_895_507_812_5e-7;
const LEAST: f64 = 1.175_494_350_822_287_5e-38;

/// Poses one vertex: the weighted offsets of all morph targets are added to its rest position, then the weighted joint
/// matrices move it. A rigid vertex has one joint of weight 1.
///
/// The tolerance is one ulp for each operation and for each input that was rounded, times the same sum with absolute
/// values: the weights and the matrices (4 roundings with the quotient of weights), a product and a sum for each target
/// and each joint, and a product and three sums for a row of the matrix.
pub fn pose_vertex(rest: [f64; 3], targets: &[(f64, [f64; 3])], joints: &[(f64, Affine)]) -> Posed {
    let mut morphed = rest;
    let mut magnitude = rest.map(f64::abs);
    for &(weight, offset) in targets {
        for axis in 0..3 {
            morphed[axis] += weight * offset[axis];
            magnitude[axis] += (weight * offset[axis]).abs();
        }
    }
    let mut posed = Posed { position: [0.0; 3], tolerance: [0.0; 3] };
    for (weight, matrix) in joints {
        for (axis, &[x, y, z, w]) in matrix.0.iter().enumerate() {
            posed.position[axis] += weight * (x * morphed[0] + y * morphed[1] + z * morphed[2] + w);
            let [x, y, z, w] = [x, y, z, w].map(f64::abs);
            posed.tolerance[axis] += weight.abs() * (x * magnitude[0] + y * magnitude[1] + z * magnitude[2] + w);
        }
    }
    let roundings = (targets.len() + joints.len() + 10) as f64;
    let relative = (roundings * ULP).exp_m1();
    posed.tolerance = posed.tolerance.map(|magnitude| relative * magnitude + roundings * LEAST);
    posed
}

/// Every vertex of a model in a pose, instance after instance.
pub fn of_model(model: &Model, pose: &Pose) -> Vec<Posed> {
    let mut all = Vec::new();
    for (instance, pose) in model.instances().iter().zip(pose.instances()) {
        let geometry = &model.geometries()[instance.geometry()];
        let palette: Vec<Affine> =
            pose.palette().iter().map(|matrix| Affine(matrix.rows().map(|row| row.map(f64::from)))).collect();
        for (vertex, position) in geometry.positions().iter().enumerate() {
            let weights = pose.morph_weights().iter().map(|&weight| f64::from(weight));
            let offsets = geometry.morph_targets().iter().map(|target| target[vertex].map(f64::from));
            let targets: Vec<_> = weights.zip(offsets).collect();
            let joints = match geometry.influences() {
                None => vec![(1.0, palette[0])],
                Some(influences) => {
                    let [begin, end] = [influences.offsets()[vertex], influences.offsets()[vertex + 1]];
                    let entry = |entry: u32| {
                        let entry = entry as usize;
                        (f64::from(influences.weights()[entry]), palette[influences.joints()[entry] as usize])
                    };
                    (begin..end).map(entry).collect()
                }
            };
            all.push(pose_vertex(position.map(f64::from), &targets, &joints));
        }
    }
    all
}

/// Positions of the corners of all faces.
pub fn corners(model: &Model, positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let (mut corners, mut first) = (Vec::new(), 0);
    for geometry in model.placed_geometries() {
        corners.extend(geometry.faces().as_flattened().iter().map(|&vertex| positions[first + vertex as usize]));
        first += geometry.positions().len();
    }
    corners
}

/// Fails at the first vertex that is further from its expected position than its tolerance. Returns the largest distance by
/// tolerances, which is at most 1.
pub fn compare(what: &str, found: &[[f32; 3]], expected: &[Posed]) -> Result<f64, String> {
    if found.len() != expected.len() {
        return Err(format!("{what}: {} vertices, expected {}", found.len(), expected.len()));
    }
    let mut largest = 0.0_f64;
    for (vertex, (found, expected)) in found.iter().zip(expected).enumerate() {
        for axis in 0..3 {
            let distance = (f64::from(found[axis]) - expected.position[axis]).abs();
            // A NaN is not near.
            let near = distance <= expected.tolerance[axis];
            if !near {
                return Err(format!("{what}: vertex {vertex} is at {found:?}, expected {expected:?}"));
            }
            largest = largest.max(distance / expected.tolerance[axis]);
        }
    }
    Ok(largest)
}

/// Fails where a vertex is outside of its instance's box, or if there are not as many vertices and boxes as the model has.
pub fn within_boxes<T: Copy + Into<f64>>(
    model: &Model,
    boxes: &[Option<Box3>],
    within: &[[T; 3]],
) -> Result<(), String> {
    if within.len() != model.vertex_count() || boxes.len() != model.instances().len() {
        return Err(format!("{} vertices and {} boxes are not all of the model's", within.len(), boxes.len()));
    }
    let mut rest = within.iter();
    for (instance, (geometry, bounds)) in model.placed_geometries().zip(boxes).enumerate() {
        let [low, high] = bounds.ok_or_else(|| format!("instance {instance} has no box"))?;
        for (vertex, position) in rest.by_ref().take(geometry.positions().len()).enumerate() {
            for axis in 0..3 {
                let c: f64 = position[axis].into();
                if !(f64::from(low[axis])..=f64::from(high[axis])).contains(&c) {
                    return Err(format!("vertex {vertex} of instance {instance}, axis {axis}: {c}, {low:?} {high:?}"));
                }
            }
        }
    }
    Ok(())
}
