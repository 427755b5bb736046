//! Walls over contours are closed, and cross each marked edge once and no other. Which edges are marked, by independent
//! code.

use std::collections::{HashMap, HashSet};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::{is_long, must_fail};

use crate::contours::{Fit, Quad, UNIT, smooth, walls_of};
use crate::maps::{Map, maps};

pub(crate) const TESTS: &[Test] = &[("walls_are_closed_and_cross_marked_edges_once", closed)];

/// The distance of a sample from the near plane, `None` where it casts nothing. Independent code.
pub(crate) fn distance(map: &Map, [x, y]: [i32; 2]) -> Option<i64> {
    let inside = x > 0 && y > 0 && x as u32 <= map.size[0] && y as u32 <= map.size[1];
    let depth = inside.then(|| f64::from(map.depths[((y - 1) as u32 * map.size[0] + (x - 1) as u32) as usize]))?;
    let is_far = depth.is_nan() || if map.is_reversed { depth < f64::from(f32::MIN_POSITIVE) } else { depth >= 1.0 };
    let units = (depth.clamp(0.0, 1.0) * UNIT).floor() as i64;
    let units = if map.is_reversed { UNIT as i64 - units } else { units };
    (!is_far).then(|| units.min(UNIT as i64 - 1))
}

/// Whether the distances of five samples, from a rim inwards, are those of a conic that ends along a ray of the light:
/// the squares of their differences from the rim's own are a quadratic polynomial. For maps of floats.
fn is_round(map: &Map, z: &[i64]) -> bool {
    let rises: Vec<_> = z.iter().map(|distance| z[0] - distance).collect();
    let off = if map.is_reversed { (UNIT as i64 - z[0]) >> 21 } else { 128 };
    if rises.windows(2).any(|pair| pair[0] >= pair[1]) || rises[1] < 1024.max(16 * off) {
        return false;
    }
    // With eleven bits of the first difference.
    let shift = (rises[1].ilog2() + 1).saturating_sub(11);
    let rises: Vec<_> = rises.iter().map(|rise| rise >> shift).collect();
    let differences: Vec<_> = rises.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let bend = differences[0] - 2 * differences[1] + differences[2];
    if differences.iter().any(|&difference| difference > differences[0]) || bend <= 0 {
        return false;
    }
    // The third difference of (rim + rise)² is 0, which is linear in the rim.
    let cube = |of: [i64; 4]| of[3] - 3 * of[2] + 3 * of[1] - of[0];
    let four = [rises[0], rises[1], rises[2], rises[3]];
    let (squares, linear) = (cube(four.map(|rise| rise * rise)), 2 * cube(four));
    if -squares * linear.signum() < 0 || squares.abs() / bend > 16 * differences[0] {
        return false;
    }
    let rim = -squares / linear;
    let further = [rises[1], rises[2], rises[3], rises[4]].map(|rise| (rim + rise) * (rim + rise));
    cube(further).abs() <= differences[0] * differences[0] / 8
}

/// Whether there is a jump between neighbours: the rule as the documentation has it.
fn is_jump(map: &Map, numbers: Option<&[u32]>, threshold: i64, at: [i32; 2], step: [i32; 2]) -> bool {
    let there = |count: i32| [at[0] + count * step[0], at[1] + count * step[1]];
    let values: Vec<_> = (-3..=4).map(|count| distance(map, there(count))).collect();
    let difference = |first: usize| Some(values[first + 1]? - values[first]?);
    let (Some(a), Some(b)) = (values[3], values[4]) else { return values[3].is_some() != values[4].is_some() };
    let number =
        |[x, y]: [i32; 2]| numbers.map(|numbers| numbers[((y - 1) as u32 * map.size[0] + (x - 1) as u32) as usize]);
    if number(at) != number(there(1)) {
        return true;
    }
    let jump = (b - a).abs();
    if jump <= threshold {
        return false;
    }
    // The sign makes the second sample the farther one.
    let sign = if b > a { 1 } else { -1 };
    let (nearer, farther) = if b > a { ([2, 1], [4, 5]) } else { ([4, 5], [2, 1]) };
    let beside = |first: usize| difference(first).map(|difference| sign * difference);
    if [nearer[0], farther[0]].into_iter().filter_map(beside).any(|beside| (jump - beside).abs() <= threshold) {
        return false;
    }
    let slope = |[first, second]: [usize; 2]| match (beside(first), beside(second)) {
        (Some(a), Some(b)) if a.signum() * b.signum() >= 0 && (a >= 0) == (b >= 0) => {
            if a.abs() < b.abs() {
                a
            } else {
                b
            }
        }
        _ => 0,
    };
    let before = beside(nearer[0]).unwrap_or(0);
    // The next edge rises more, or leads to nothing, and the surface is round up to here.
    let towards = if b > a { [4, 3, 2, 1, 0] } else { [3, 4, 5, 6, 7] };
    let round: Option<Vec<_>> = towards.into_iter().map(|at| values[at]).collect();
    if beside(farther[0]).is_none_or(|after| after > jump) && round.is_some_and(|z| is_round(map, &z)) {
        return false;
    }
    let is_alone = beside(farther[0]).is_some_and(|after| before.max(after) / 2 < jump / 4);
    (jump > 16 * threshold || is_alone) && jump - slope(nearer).max(slope(farther)) > threshold
}

/// Whether the way from one sample to the next crosses a segment, neither through its end.
fn crosses([a, b]: [[i64; 2]; 2], [p, q]: [[i64; 2]; 2]) -> bool {
    let side = |from: [i64; 2], to: [i64; 2], at: [i64; 2]| {
        ((to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])).signum()
    };
    // A segment's first end counts, its second does not.
    let is_between = (side(a, b, p) >= 0) != (side(a, b, q) >= 0);
    is_between && side(p, q, a) * side(p, q, b) < 0
}

/// Checks that ends of walls cancel, and that the walls cross each marked edge once and no other.
fn check_closed(map: &Map, numbers: Option<&[u32]>, threshold: i64, quads: &[Quad]) -> Result<usize, String> {
    // The vertical ends at each position: every distance between two ends lies in as many as go down as go up.
    let mut ends: HashMap<[i32; 2], Vec<(i32, i32)>> = HashMap::new();
    let mut seams: HashMap<[[i32; 3]; 2], i32> = HashMap::new();
    let mut segments = HashSet::new();
    for quad in quads {
        for number in 0..4 {
            let [a, b] = [quad[number], quad[(number + 1) % 4]];
            if a[..2] == b[..2] {
                ends.entry([a[0], a[1]]).or_default().push((a[2], b[2]));
            }
        }
        for side in [[quad[0], quad[1]], [quad[3], quad[2]]] {
            if side[0][..2] != side[1][..2] {
                *seams.entry(side).or_default() += 1;
            }
        }
        let [a, b, c, d] = *quad;
        if a[..2] == b[..2] && c[..2] == d[..2] && a[..2] != c[..2] {
            let [p, q] = [a, c].map(|[x, y, _]| [i64::from(x), i64::from(y)]);
            segments.insert(if p < q { [p, q] } else { [q, p] });
        }
    }
    for (position, ends) in &ends {
        let mut steps: Vec<_> = ends.iter().flat_map(|&(from, to)| [(from, 1), (to, -1)]).collect();
        steps.sort_unstable();
        let mut sum = 0;
        for (at, step) in
            steps.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same.iter().map(|step| step.1).sum::<i32>()))
        {
            sum += step;
            if step != 0 {
                return Err(format!("at {position:?} ends at {at} do not cancel: {ends:?}"));
            }
        }
        if sum != 0 {
            return Err(format!("at {position:?} ends do not cancel: {ends:?}"));
        }
    }
    // Sides of flaps, from a sample to a position on an edge, belong to two flaps.
    if let Some((seam, count)) = seams.iter().find(|(_, count)| *count % 2 != 0) {
        return Err(format!("{count} flaps at {seam:?}"));
    }
    let mut by_cell: HashMap<[i64; 2], Vec<[[i64; 2]; 2]>> = HashMap::new();
    for &[a, b] in &segments {
        let cells = |axis: usize| a[axis].min(b[axis]).div_euclid(256)..=a[axis].max(b[axis]).div_euclid(256);
        for x in cells(0) {
            for y in cells(1) {
                by_cell.entry([x, y]).or_default().push([a, b]);
            }
        }
    }
    let mut marked = 0;
    let size = map.size.map(|texels| texels as i32);
    for (x, y) in (0..=size[1] + 1).flat_map(|y| (0..=size[0] + 1).map(move |x| (x, y))) {
        for step in [[1, 0], [0, 1]] {
            let other = [x + step[0], y + step[1]];
            if other[0] > size[0] + 1 || other[1] > size[1] + 1 {
                continue;
            }
            let way = [[x, y], other].map(|at| at.map(|position| i64::from(position) * 256));
            let mut near: HashSet<[[i64; 2]; 2]> = HashSet::new();
            for cell in [[x, y], [x - step[1], y - step[0]]] {
                near.extend(by_cell.get(&cell.map(i64::from)).into_iter().flatten());
            }
            let crossed = near.iter().filter(|&&segment| crosses(way, segment)).count();
            let is_marked = is_jump(map, numbers, threshold, [x, y], step);
            marked += usize::from(is_marked);
            if crossed != usize::from(is_marked) {
                let ends: Vec<_> = near.iter().filter(|&&segment| crosses(way, segment)).collect();
                return Err(format!(
                    "{crossed} walls cross from {:?} to {other:?}, marked {is_marked}: {ends:?}",
                    [x, y]
                ));
            }
        }
    }
    Ok(marked)
}

fn closed() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1642)?;
    let (mut marked, mut walls) = (0, 0);
    for round in 0..if is_long() { 15 } else { 3 } {
        let mut given = maps(&mut random);
        for size in [[70, 45], [130, 120]] {
            given.extend([false, true].map(|is_reversed| smooth(&mut random, size, is_reversed)));
        }
        for map in given {
            let fit = Fit {
                threshold: [0.0005, 0.007_812_5, 0.125][random.below(3)],
                sideways: [0.0, 0.25, 0.5][round % 3],
                depth: [0.0, 0.002, 1.0][random.below(3)],
                slope_bias: [0.0, 1.0][random.below(2)],
            };
            // Objects of several texels, whose edges may be without a jump.
            let numbers: Vec<_> = (0..map.depths.len() as u32)
                .map(|texel| (texel % map.size[0] / 5 + texel / map.size[0] / 7) % 3)
                .collect();
            let numbers = (random.below(3) == 0).then_some(&numbers[..]);
            let quads = walls_of(&gpu, &map, numbers, fit)?;
            let threshold = (f64::from(fit.threshold) * UNIT).round() as i64;
            let check = |quads: &[Quad]| check_closed(&map, numbers, threshold, quads);
            let what = |error| format!("{:?}, reversed {}, {fit:?}: {error}", map.size, map.is_reversed);
            marked += check(&quads).map_err(what)?;
            walls += quads.len();
            // Negative control: a wall is missing, or a vertex is elsewhere.
            if quads.len() > 4 {
                let at = random.below(quads.len());
                if quads[at][0][..2] == quads[at][1][..2] && quads[at][0] != quads[at][1] {
                    must_fail("a missing wall", &check(&[&quads[..at], &quads[at + 1..]].concat()))?;
                }
                let mut moved = quads.clone();
                moved[at][0][2] ^= 1;
                must_fail("a moved vertex", &check(&moved))?;
            }
        }
    }
    println!("{marked} marked edges, {walls} walls");
    if marked > 20_000 { Ok(()) } else { Err("too few".to_owned()) }
}
