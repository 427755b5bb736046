//! Which joints move each vertex.

use glam::Vec3;

use super::body::Part;
use super::skeleton::{JOINTS, Side, side_of};

/// The greater, the narrower the bend at a joint.
const SHARPNESS: i32 = 6;
/// Rounds of smoothing over the surface.
const ROUNDS: usize = 3;
/// Half the width of the strip in the middle where left and right share, in metres.
const MIDDLE: f32 = 0.03;

type Row = [f32; JOINTS.len()];

/// Four joints and weights a vertex, by distance to the joints' parts of the body as a fraction of their radius.
pub(super) fn bind(parts: &[Part], positions: &[Vec3], faces: &[[u32; 3]]) -> (Vec<[u8; 4]>, Vec<[f32; 4]>) {
    let mut rows: Vec<Row> = positions.iter().map(|&point| row(parts, point)).collect();
    for _ in 0..ROUNDS {
        rows = smoothed(&rows, faces);
    }
    rows.iter().map(strongest).unzip()
}

fn row(parts: &[Part], point: Vec3) -> Row {
    let mut row = [0.0_f32; JOINTS.len()];
    for part in parts {
        let weight = part.relative_distance(point).max(0.1).powi(-SHARPNESS) * reach(part.joint, point);
        row[part.joint] = row[part.joint].max(weight);
    }
    normalised(row)
}

/// From 1 on a joint's own side to 0 on the other, so that one leg does not pull at the other.
fn reach(joint: usize, point: Vec3) -> f32 {
    side_of(joint).map_or(1.0, |side: Side| {
        let t = ((point.x * side.sign() + MIDDLE) / (2.0 * MIDDLE)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    })
}

fn smoothed(rows: &[Row], faces: &[[u32; 3]]) -> Vec<Row> {
    let mut sums = rows.to_vec();
    for face in faces {
        for corner in 0..3 {
            let other = rows[face[(corner + 1) % 3] as usize];
            for (sum, weight) in sums[face[corner] as usize].iter_mut().zip(other) {
                *sum += weight;
            }
        }
    }
    sums.into_iter().map(normalised).collect()
}

fn normalised(row: Row) -> Row {
    let sum: f32 = row.iter().sum();
    row.map(|weight| weight / sum)
}

fn strongest(row: &Row) -> ([u8; 4], [f32; 4]) {
    let mut order: [u8; JOINTS.len()] = std::array::from_fn(|joint| joint as u8);
    order.sort_by(|&a, &b| row[b as usize].total_cmp(&row[a as usize]));
    let joints = [order[0], order[1], order[2], order[3]];
    let weights = joints.map(|joint| row[joint as usize]);
    let sum: f32 = weights.iter().sum();
    (joints, weights.map(|weight| weight / sum))
}
