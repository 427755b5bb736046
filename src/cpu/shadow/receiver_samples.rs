//! Receiver samples: the farthest receiver of each tile of a picture with several samples for each pixel.

use super::receivers::farthest;
use crate::layout::ReceiverView;

/// Like [`receiver_depth`](super::receiver_depth::receiver_depth). `depths` has `samples` depths for each pixel.
pub fn receiver_samples(view: &ReceiverView, depths: &[f32], samples: usize) -> Vec<u32> {
    farthest(view, depths, samples)
}
