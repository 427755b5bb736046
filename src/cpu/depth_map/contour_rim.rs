//! Contour rim: where a smooth surface ends, from the depths of its last samples.

use super::contour::{FAR, Map, RANGE, TEXEL, parts, smaller, sum};
use super::contour_marks::is_marked_before;

/// Parts of a texel up to which a rim may lie beyond the other sample: rounding brings it there.
const BEYOND: i32 = 24;
/// Parts of the square of the last difference that a fifth sample may be off its conic.
const ON_CONIC: i32 = 5;

/// The place of the rim of a smooth surface beyond its last sample, in the direction of a step, in parts of a texel.
pub(crate) fn rim_beyond(map: &Map<'_>, marks: &[u32], last: [i32; 2], step: [i32; 2]) -> Option<i32> {
    let before = |number: i32| sum(last, step.map(|step| -number * step));
    if (0..4).any(|number| is_marked_before(map, marks, before(number), step)) {
        return None;
    }
    let conic = map.conic(last, step, ON_CONIC)?;
    // The rise is at most three times the last difference, if the rim is within a texel.
    if conic.y > 3 * conic.u {
        return None;
    }
    // y² = slope · place + curve · place²
    let square = (conic.y * conic.y) >> 12;
    let curve = (conic.first - conic.second) >> 13;
    let slope = (conic.first + (conic.first - conic.second) / 2) >> 12;
    if curve * 4 < -slope {
        return None;
    }
    let mut place = 0;
    for part in (0..=8).rev().map(|bit| 1 << bit) {
        let next = place + part;
        if slope * next + curve * next * next / TEXEL <= square * TEXEL {
            place = next;
        }
    }
    (place <= TEXEL + BEYOND).then_some(place.min(TEXEL))
}

/// The distance of the surface of a sample at a place beside it, in parts of a texel in the direction of a step. It goes on as
/// between the last samples. Where it bends away from the light, as towards a rim, it goes on bending: the slope grows twice as
/// it did last, to four times at most. With `texels`: away from the light by the slope of so many
/// texels at least.
pub(crate) fn surface(map: &Map<'_>, marks: &[u32], (at, step): ([i32; 2], [i32; 2]), place: i32, texels: i32) -> i32 {
    let own = map.distance(at);
    if own == FAR {
        return FAR;
    }
    let back = step.map(|step| -step);
    let first = sum(at, back);
    let second = sum(first, back);
    let is_joined = |to: [i32; 2]| !is_marked_before(map, marks, to, step);
    let way = if is_joined(at) {
        let last = own - map.distance(first);
        let before = if is_joined(first) { Some(map.distance(first) - map.distance(second)) } else { None };
        match before {
            // Jumps are not marked without a threshold.
            Some(before) if map.shape.threshold >= RANGE => parts(smaller(last, before), place),
            Some(before) if last > before.max(0) => {
                let growth = (last / (before.max(last / 2) >> 8).max(1)).clamp(TEXEL, 2 * TEXEL);
                parts(parts(parts(last.min(RANGE / 8), place), growth), growth)
            }
            _ => parts(last, place),
        }
    } else {
        0
    };
    // Without a threshold it may be a jump.
    let is_slope = is_joined(at) && map.shape.threshold < RANGE;
    let slope = if is_slope { (own - map.distance(first)).clamp(0, RANGE / 8) } else { 0 };
    let way = if texels > 0 { way.max(texels * slope) } else { way };
    (map.moved(at) + way).clamp(0, own + (RANGE - own) / 2)
}
