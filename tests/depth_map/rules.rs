//! Detectors that look at more than the ends of an edge: lists by big integers, without code of the library.

use std::collections::HashSet;

use num_bigint::BigInt;

use crate::cells::{by_strips, cast, entry as cell_entry, exact, rank};
use crate::maps::Map;

/// How second differences decide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Second {
    Nothing,
    Both,
    One,
}

/// How edges are found: thresholds of both levels, which are above all and next to marked edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    pub(crate) second: Second,
    pub(crate) low: [f32; 2],
    pub(crate) high: f32,
    pub(crate) slopes: [f32; 2],
    pub(crate) noise: f32,
    /// Depths may be off by a share of 2 to the power of minus as much, or by none.
    pub(crate) noise_exponents: u32,
    /// Cells by which an edge that dangles is continued at most.
    pub(crate) cells: u32,
    /// A triangle is drawn if one of its samples is so many edges, less one, from the end of a marked edge.
    pub(crate) rings: u32,
}

/// An edge: from a texel to the right (0) or down (1).
type Edge = (i64, i64, usize);

/// The texel at the other end of an edge, or as many steps along it.
fn along((x, y, axis): Edge, steps: i64) -> (i64, i64) {
    if axis == 0 { (x + steps, y) } else { (x, y + steps) }
}

/// Bound on the error of two depths, times 2²⁹⁸.
fn noise(rule: &Rule, large: f32) -> BigInt {
    let share = exact(large) << (149 - rule.noise_exponents);
    // No share is less than the least normal number.
    let is_counted = rule.noise_exponents > 0 && share >= exact(f32::MIN_POSITIVE) << 149;
    let constant = exact(rule.noise) << 149;
    if is_counted { share.max(constant) } else { constant }
}

fn is_marked(map: &Map, objects: &[u32], rule: &Rule, level: usize, edge: Edge) -> bool {
    let texel = |(x, y): (i64, i64)| cast(map, x, y);
    let [before, a, b, after] = [-1, 0, 1, 2].map(|steps| texel(along(edge, steps)));
    let (Some(p), Some(q)) = (a, b) else { return a.is_some() != b.is_some() };
    let object = |(x, y): (i64, i64)| objects.get((y * i64::from(map.size[0]) + x) as usize);
    if object(along(edge, 0)) != object(along(edge, 1)) {
        return true;
    }
    let step = exact(q) - exact(p);
    let sign = if step < BigInt::ZERO { -1 } else { 1 };
    let size = BigInt::from(sign) * &step;
    if size == BigInt::ZERO || size <= exact(rule.low[level]) {
        return false;
    }
    // The steps beside it, in the same direction.
    let beside = [(before, a), (b, after)].map(|ends| match ends {
        (Some(p), Some(q)) => (BigInt::from(sign) * (exact(q) - exact(p))).max(BigInt::ZERO),
        _ => BigInt::ZERO,
    });
    let slopes = exact(rule.slopes[level]);
    let larger = beside.map(|beside| (&size << 149) > slopes.clone() * beside + noise(rule, p.max(q)));
    let is_sure = size > exact(rule.high);
    match rule.second {
        Second::Nothing => true,
        Second::Both => is_sure || larger == [true; 2],
        Second::One => is_sure || larger != [false; 2],
    }
}

/// The entries of all cells that are listed, and how many edges were continued.
pub(crate) fn expected(map: &Map, objects: &[u32], rule: &Rule) -> (Vec<u32>, usize) {
    let (all, continued) = entries(map, objects, rule, true);
    (by_strips(map.size, all), continued)
}

/// The entries row by row. Without `has_border` the map is one of a cube: there are no edges to samples around it. Cells have the
/// numbers of those with a border.
pub(crate) fn entries(map: &Map, objects: &[u32], rule: &Rule, has_border: bool) -> (Vec<u32>, usize) {
    let [width, height] = map.size.map(i64::from);
    let places = || (-1..=height).flat_map(move |y| (-1..=width).map(move |x| (x, y)));
    let is_there = |&edge: &Edge| {
        let ends = [along(edge, 0), along(edge, 1)];
        has_border || ends.iter().all(|(x, y)| (0..width).contains(x) && (0..height).contains(y))
    };
    let all = || places().flat_map(|(x, y)| [(x, y, 0), (x, y, 1)]).filter(is_there);
    let of_level = |level| all().filter(|&edge| is_marked(map, objects, rule, level, edge)).collect::<HashSet<_>>();
    let (mut marks, faint) = (of_level(0), of_level(1));
    let first = marks.len();
    for _ in 0..rule.cells {
        let around = |x: i64, y: i64| [(x, y, 0), (x, y + 1, 0), (x, y, 1), (x + 1, y, 1)];
        let single = |&(x, y): &(i64, i64)| around(x, y).iter().filter(|edge| marks.contains(edge)).count() == 1;
        let dangling: Vec<_> = places().filter(single).collect();
        let further = dangling.iter().flat_map(|&(x, y)| around(x, y)).filter(|edge| faint.contains(edge));
        let before = marks.len();
        marks.extend(further.collect::<Vec<_>>());
        if marks.len() == before {
            break;
        }
    }
    // Other maps of a cube may have a mark at a sample on the border.
    let is_shared = |x: i64, y: i64| !has_border && (x == 0 || y == 0 || x == width - 1 || y == height - 1);
    let ends = |(x, y): (i64, i64)| {
        let beside = [(x, y, 0), (x, y, 1), (x - 1, y, 0), (x, y - 1, 1)];
        is_shared(x, y) || beside.iter().any(|edge| marks.contains(edge))
    };
    let is_near = |(x, y): (i64, i64)| {
        let reach = i64::from(rule.rings) - 1;
        let near = (-reach..=reach).flat_map(|dx| (-reach..=reach).map(move |dy| (dx, dy)));
        cast(map, x, y).is_some()
            && near.filter(|(dx, dy)| dx.abs() + dy.abs() <= reach).any(|(dx, dy)| ends((x + dx, y + dy)))
    };
    let across = width + 1;
    let entry = |number: u32| {
        let (x, y) = (i64::from(number) % across - 1, i64::from(number) / across - 1);
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let ranks = corners.map(|(x, y)| rank(map, cast(map, x, y)));
        let is_split = (ranks[0] - ranks[3]).abs() > (ranks[1] - ranks[2]).abs();
        let [top, bottom, left, right] =
            [(x, y, 0), (x, y + 1, 0), (x, y, 1), (x + 1, y, 1)].map(|edge| marks.contains(&edge));
        let [a, b, c, d] = corners.map(is_near);
        let [first, second] = if is_split {
            [top || left || a || b || c, right || bottom || b || c || d]
        } else {
            [top || right || a || b || d, left || bottom || a || c || d]
        };
        cell_entry(number, is_split, [first, second])
    };
    let entries = (0..((width + 1) * (height + 1)) as u32).filter_map(entry).collect();
    (entries, marks.len() - first)
}
