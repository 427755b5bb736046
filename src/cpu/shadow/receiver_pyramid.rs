//! Receiver pyramid: the levels above the tiles, and the box of all places that receivers may be seen at.

use glam::{Vec3, Vec4, Vec4Swizzles};

use super::receivers::{RECEIVERS_HEAD, TILE, depth_of_key, tiles};
use crate::layout::ReceiverView;

/// The box is taken from the first level that has at most so many cells.
const MOST_BOXED: u32 = 1024;
/// Above the rounding error of a product of matrix and vector, relative to its terms.
const UNPROJECTION: f32 = 1e-5;

/// All words of a view's receivers: the head, then the levels. `level` is that of the tiles.
pub fn receiver_pyramid(view: &ReceiverView, level: &[u32]) -> Vec<u32> {
    let [across, down] = tiles(view);
    let mut words = vec![0; RECEIVERS_HEAD];
    let (mut level, mut cells, mut size) = (level.to_vec(), [across, down], TILE);
    let mut ends: Option<Option<[Vec3; 2]>> = None;
    loop {
        words.extend(&level);
        if ends.is_none() && cells[0] * cells[1] <= MOST_BOXED {
            ends = Some(receiver_box(view, &level, cells, size));
        }
        if level.len() <= 1 {
            break;
        }
        let next = cells.map(|cells| cells.div_ceil(2));
        let key = |x: u32, y: u32| {
            let [x, y] = [x.min(cells[0] - 1), y.min(cells[1] - 1)];
            level.get((y * cells[0] + x) as usize).copied().unwrap_or(0)
        };
        let cell = |x: u32, y: u32| key(x, y).max(key(x + 1, y)).max(key(x, y + 1)).max(key(x + 1, y + 1));
        let above = (0..next[0] * next[1]).map(|number| cell(2 * (number % next[0]), 2 * (number / next[0])));
        (level, cells, size) = (above.collect(), next, 2 * size);
    }
    let farthest = level.first().copied().unwrap_or(0);
    let limited = ends.flatten();
    let head = [across, down, view.pixels[0], view.pixels[1], farthest, u32::from(limited.is_some())];
    let ends = limited.map_or([0; 6], |[low, high]| {
        let [low, high] = [low.to_array(), high.to_array()].map(|ends| ends.map(f32::to_bits));
        [low[0], low[1], low[2], high[0], high[1], high[2]]
    });
    for (word, value) in words.iter_mut().zip(head.into_iter().chain(ends)) {
        *word = value;
    }
    words
}

/// The box of the near rectangle and all receivers. `None`: one may be at infinity.
fn receiver_box(view: &ReceiverView, level: &[u32], cells: [u32; 2], size: u32) -> Option<[Vec3; 2]> {
    let mut ends = [Vec3::from(view.near_min), Vec3::from(view.near_max)];
    for (number, &key) in (0..).zip(level).filter(|&(_, &key)| key != 0) {
        let cell = [number % cells[0], number / cells[0]];
        let end = |axis: usize, cell: u32, margin: f32| {
            ((cell * size) as f32 + margin) / view.pixels[axis] as f32 * 2.0 - 1.0
        };
        let depth = depth_of_key(key, view.near_z);
        for corner in 0..4 {
            let [x, y] = [0, 1].map(|axis| {
                if corner >> axis & 1 == 0 { end(axis, cell[axis], -1.0) } else { end(axis, cell[axis] + 1, 1.0) }
            });
            let [low, high] = place(view, x, -y, depth)?;
            ends = [ends[0].min(low), ends[1].max(high)];
        }
    }
    Some(ends)
}

/// Bounds of a place in the camera's frame, from normalised device coordinates.
fn place(view: &ReceiverView, x: f32, y: f32, depth: f32) -> Option<[Vec3; 2]> {
    let [a, b, c, d] = view.inverse.map(Vec4::from_array);
    let place = a * x + b * y + c * depth + d;
    let error = UNPROJECTION * ((a * x).abs() + (b * y).abs() + (c * depth).abs() + d.abs());
    let (least, most) = (place.w - error.w, place.w + error.w);
    if least > 0.0 {
        let (low, high) = (place.xyz() - error.xyz(), place.xyz() + error.xyz());
        let (low, high) = ((low / least).min(low / most), (high / least).max(high / most));
        return Some([low - UNPROJECTION * low.abs(), high + UNPROJECTION * high.abs()]);
    }
    None
}
