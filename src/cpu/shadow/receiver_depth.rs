//! Receiver depth: the farthest receiver of each tile of a picture.

use super::receivers::farthest;
use crate::layout::ReceiverView;

/// The key of the farthest receiver of each tile of 8 × 8 pixels, row by row. A larger key is farther, and 0 says that there is
/// none. `depths` are those of the pixels, row by row.
pub fn receiver_depth(view: &ReceiverView, depths: &[f32]) -> Vec<u32> {
    farthest(view, depths, 1)
}
