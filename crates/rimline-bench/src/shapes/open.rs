//! Shapes with boundaries, and worse.

use super::{MAX_COUNT, Shape, turn};

/// An open grid of `n` by `m` squares, at least 1 each, from −1 to 1 in X and Z at y = 0, facing +Y: `2·n·m` faces and
/// `2·(n + m)` boundary edges.
#[must_use]
pub fn plane_grid(n: u32, m: u32) -> Shape {
    let (n, m) = (n.clamp(1, MAX_COUNT), m.clamp(1, MAX_COUNT));
    let coordinate = |step: u32, steps: u32| 2.0 * step as f32 / steps as f32 - 1.0;
    let mut shape = Shape::default();
    for i in 0..=n {
        shape.positions.extend((0..=m).map(|j| [coordinate(i, n), 0.0, coordinate(j, m)]));
    }
    for i in 0..n {
        let (here, there) = (i * (m + 1), (i + 1) * (m + 1));
        for j in 0..m {
            shape.quad([here + j, here + j + 1, there + j + 1, there + j]);
        }
    }
    shape
}

/// A Möbius strip of `segments` quads around (at least 3) and `strips` across (at least 1), centre line of radius 1
/// around the Y axis. It has one side and no consistent orientation: the `strips` edges across the seam are
/// inconsistent records, and `2·segments` edges are boundaries.
#[must_use]
pub fn moebius(segments: u32, strips: u32) -> Shape {
    let (segments, strips) = (segments.clamp(3, MAX_COUNT), strips.clamp(1, MAX_COUNT));
    let row = strips + 1;
    let mut shape = Shape::default();
    for i in 0..segments {
        let (sin_u, cos_u) = turn(i, segments);
        // Half a turn of the cross-section on one way round.
        let (sin_half, cos_half) = turn(i, 2 * segments);
        for j in 0..row {
            let across = 0.8 * (j as f32 / strips as f32 - 0.5);
            let radius = 1.0 + across * cos_half;
            shape.positions.push([radius * cos_u, across * sin_half, radius * sin_u]);
        }
    }
    for i in 0..segments {
        // Past the seam a row meets the first one end for end.
        let next = |j: u32| {
            if i + 1 < segments { (i + 1) * row + j } else { strips - j }
        };
        for j in 0..strips {
            shape.quad([i * row + j, i * row + j + 1, next(j + 1), next(j)]);
        }
    }
    shape
}

/// Three sheets that meet on one line, the Y axis, of `segments` edges (at least 1): non-manifold. Two sheets run up
/// the line and one down, so each of its edges has one consistent and one boundary record. `6·segments` faces.
#[must_use]
pub fn three_sheets(segments: u32) -> Shape {
    let segments = segments.clamp(1, MAX_COUNT);
    let row = segments + 1;
    let height = |step: u32| 2.0 * step as f32 / segments as f32 - 1.0;
    let mut shape = Shape { positions: (0..row).map(|step| [0.0, height(step), 0.0]).collect(), faces: Vec::new() };
    for sheet in 1..=3 {
        let (sin, cos) = turn(sheet, 3);
        shape.positions.extend((0..row).map(|step| [cos, height(step), sin]));
        for low in 0..segments {
            let far = sheet * row + low;
            if sheet == 3 {
                shape.quad([low, far, far + 1, low + 1]);
            } else {
                shape.quad([low, low + 1, far + 1, far]);
            }
        }
    }
    shape
}
