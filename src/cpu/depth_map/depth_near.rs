//! Depth near: whether a near rectangle may be in shadow, as told by the samples around it.

use super::contour::{FAR, Map, sum};
use super::samples::{Key, Samples};
use crate::layout::DepthNearBox;

fn samples_of_box(near: &DepthNearBox) -> impl Iterator<Item = [u32; 2]> {
    let ([x, y], [across, down]) = (near.first, near.size);
    (y..y + down).flat_map(move |y| (x..x + across).map(move |x| [x, y]))
}

/// Whether triangles between the samples may have it behind them.
pub fn depth_near(samples: &Samples<'_>, near: &DepthNearBox) -> bool {
    samples_of_box(near).any(|at| matches!(samples.at(at), Key::Steps(steps) if steps <= near.key))
}

/// Whether surfaces that go on up to contours may have it behind them.
pub fn depth_near_walls(map: &Map<'_>, near: &DepthNearBox) -> bool {
    samples_of_box(near).any(|at| {
        let at = at.map(|at| at as i32);
        let own = map.distance(at);
        // As much nearer as a neighbour on the other side is farther away.
        let nearing = |step: [i32; 2]| {
            let beside = [step, step.map(|step| -step)].map(|step| map.distance(sum(at, step)));
            beside.into_iter().filter(|&other| other != FAR).map(|other| (other - own).max(0)).max().unwrap_or(0)
        };
        own != FAR && own - nearing([1, 0]) - nearing([0, 1]) <= near.distance
    })
}
