//! Depth near walls: as depth near, for surfaces that go on beyond their samples, up to contours.

use super::contour::{FAR, Map, sum};
use super::depth_near::samples_of_box;
use crate::layout::DepthNearBox;

/// Whether surfaces that go on up to contours may have it behind them.
pub fn depth_near_walls(map: &Map<'_>, near: &DepthNearBox) -> bool {
    samples_of_box(near).any(|at| {
        let at = at.map(|at| at as i32);
        let own = map.distance(at);
        // The sample moves nearer by the largest step to a neighbour that is farther away.
        let nearing = |step: [i32; 2]| {
            let beside = [step, step.map(|step| -step)].map(|step| map.distance(sum(at, step)));
            beside.into_iter().filter(|&other| other != FAR).map(|other| (other - own).max(0)).max().unwrap_or(0)
        };
        own != FAR && own - nearing([1, 0]) - nearing([0, 1]) <= near.distance
    })
}
