//! Contour rim: where a smooth surface ends, from the depths of its last samples.

use super::contour::{FAR, LEAST, Map, RANGE, TEXEL, parts, smaller, sum};
use super::contour_marks::is_marked_before;

/// Parts of a texel up to which a rim may lie beyond the other sample: rounding brings it there.
const BEYOND: i32 = 24;
/// Units that the last difference before a rim has at least, and how many times what depths may be off by it is.
const LEAST_RISE: i32 = 1024;
const PRECISE: i32 = 16;

/// Where a surface ends beyond a sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rim {
    /// In parts of a texel from the sample on.
    pub(crate) place: i32,
    /// How much farther away it is than the sample.
    pub(crate) rise: i32,
}

/// The rim of a smooth surface beyond its last sample, in the direction of a step.
///
/// The surface along a row is taken for a conic whose tangent at the rim is a ray of the light: the square of the distance from
/// the rim's depth is a quadratic polynomial. Four samples tell it, and a fifth has to lie on it.
pub(crate) fn rim_beyond(map: &Map<'_>, marks: &[u32], last: [i32; 2], step: [i32; 2]) -> Option<Rim> {
    let z = map.distance(last);
    let mut gone = [0; 5];
    let mut at = last;
    for number in 1..5 {
        let next = sum(at, step.map(|step| -step));
        let own = map.distance(next);
        if own == FAR || is_marked_before(map, marks, at, step) || z - own <= gone[number - 1] {
            return None;
        }
        gone[number] = z - own;
        at = next;
    }
    if gone[1] < LEAST_RISE.max(PRECISE * map.precision(z).min(RANGE / PRECISE)) {
        return None;
    }
    // Eleven bits of the largest difference are enough.
    let shift = 21_u32.saturating_sub(gone[1].leading_zeros());
    let [_, u, of_two, of_three, of_four] = gone.map(|gone| gone >> shift);
    let [v, w, x] = [of_two - u, of_three - of_two, of_four - of_three];
    let bend = u - 2 * v + w;
    if v.max(w).max(x) > u || bend <= 0 {
        return None;
    }
    // The rim's depth less that of the last sample.
    let rise = 4 * u * v + 2 * v * v - u * u - w * (2 * (u + v) + w);
    if rise < 0 || rise / bend > 6 * u {
        return None;
    }
    let y = rise / (2 * bend);
    // Differences of the squares.
    let first = u * (2 * y + u);
    let second = v * (2 * (y + u) + v);
    let third = w * (2 * (y + u + v) + w);
    let fourth = x * (2 * (y + u + v + w) + x);
    if (fourth - 2 * third + second).abs() > u * u / 5 {
        return None;
    }
    // y² = slope · place + curve · place²
    let square = (y * y) >> 12;
    let curve = (first - second) >> 13;
    let slope = (first + (first - second) / 2) >> 12;
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
    let rise = y.min((RANGE / 2) >> shift) << shift;
    (place <= TEXEL + BEYOND).then_some(Rim { place: place.min(TEXEL), rise })
}

/// The distance of the surface of a sample at a place beside it, in parts of a texel in the direction of a step. It goes on
/// to the rim, if depths tell of one. Else it goes on as
/// between the last samples. Where it bends away from the light, as towards a rim, it goes on bending: the slope grows twice as
/// it did last, to four times at most.
pub(crate) fn surface(map: &Map<'_>, marks: &[u32], at: [i32; 2], step: [i32; 2], place: i32) -> i32 {
    let own = map.distance(at);
    if own == FAR {
        return FAR;
    }
    let back = step.map(|step| -step);
    let first = sum(at, back);
    let second = sum(first, back);
    let is_joined = |to: [i32; 2]| !is_marked_before(map, marks, to, step);
    let way = if let Some(rim) = rim_beyond(map, marks, at, step) {
        parts(rim.rise, (place * TEXEL / rim.place.max(LEAST)).min(2 * TEXEL))
    } else if is_joined(at) {
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
    (map.moved(at) + way).clamp(0, own + (RANGE - own) / 2)
}
