//! Depth near: whether a near rectangle may be in shadow, as told by the samples around it.

use super::samples::{Key, Samples};
use crate::layout::DepthNearBox;

pub(super) fn samples_of_box(near: &DepthNearBox) -> impl Iterator<Item = [u32; 2]> {
    let ([x, y], [across, down]) = (near.first, near.size);
    (y..y + down).flat_map(move |y| (x..x + across).map(move |x| [x, y]))
}

/// Whether triangles between the samples may have it behind them.
pub fn depth_near(samples: &Samples<'_>, near: &DepthNearBox) -> bool {
    samples_of_box(near).any(|at| matches!(samples.at(at), Key::Steps(steps) if steps <= near.key))
}
