//! Receivers: the farthest of each tile, and depths as keys. The WGSL is `wgsl/shadow/receivers.wgsl`.

use crate::layout::ReceiverView;

/// Words before the levels.
pub const RECEIVERS_HEAD: usize = 16;
/// Pixels along a side of a tile.
pub(super) const TILE: u32 = 8;

/// Orders depths by distance. 0 is no receiver.
pub(super) fn far_key(depth: f32, near_z: f32) -> u32 {
    let bits = depth.clamp(0.0, 1.0).to_bits();
    if near_z == 0.0 { bits + 1 } else { 0x4000_0000 - bits }
}

/// A depth that is not nearer than that of a key, however it was stored.
pub(super) fn depth_of_key(key: u32, near_z: f32) -> f32 {
    let [relative, absolute] = [22, 23].map(|bits| f32::from_bits((127 - bits) << 23));
    if near_z == 0.0 {
        let depth = f32::from_bits(key - 1);
        return depth + (relative * depth + absolute);
    }
    let depth = f32::from_bits(0x4000_0000 - key);
    depth - (relative * depth + absolute)
}

/// Tiles across and down.
pub(super) fn tiles(view: &ReceiverView) -> [u32; 2] {
    view.pixels.map(|pixels| pixels.div_ceil(TILE))
}

/// The key of the farthest receiver of each tile, row by row. `depths` has the samples of each pixel one after the other, row
/// by row.
pub(super) fn farthest(view: &ReceiverView, depths: &[f32], samples: usize) -> Vec<u32> {
    let [across, down] = tiles(view);
    let sky = 1.0 - view.near_z;
    let mut keys = vec![0; (across * down) as usize];
    for (number, depths) in (0..).zip(depths.chunks(samples.max(1))) {
        let [x, y] = [number % view.pixels[0].max(1), number / view.pixels[0].max(1)];
        let tile = y / TILE * across + x / TILE;
        let seen = depths.iter().filter(|&&depth| depth != sky || view.sky_receives != 0);
        let key = seen.map(|&depth| far_key(depth, view.near_z)).max().unwrap_or(0);
        if let Some(farthest) = keys.get_mut(tile as usize) {
            *farthest = key.max(*farthest);
        }
    }
    keys
}
