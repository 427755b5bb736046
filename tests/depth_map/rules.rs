//! Detectors that look at more than the ends of an edge: the twin's lists against big integers.

use std::collections::HashSet;

use num_bigint::BigInt;
use rimline::reference::cpu::{
    EdgeDetector, FIRST_TRIANGLE, SECOND_TRIANGLE, SPLIT, Samples, Second, depth_cells, depth_edges,
};
use rimline::reference::layout::DepthMapShape;
use rimline_measure::random::Random;

use crate::cells::{by_strips, cast, exact, rank};
use crate::maps::{Map, detector, further, maps};

/// An edge: from a texel to the right (0) or down (1).
type Edge = (i64, i64, usize);

/// The texel at the other end of an edge, or as many steps along it.
fn along((x, y, axis): Edge, steps: i64) -> (i64, i64) {
    if axis == 0 { (x + steps, y) } else { (x, y + steps) }
}

/// Bound on the error of two depths, times 2²⁹⁸.
fn noise(detector: &EdgeDetector, large: f32) -> BigInt {
    let rule = &detector.rule;
    let share = exact(large) << (149 - rule.noise_exponents);
    // No share is less than the least normal number.
    let is_counted = rule.noise_exponents > 0 && share >= exact(f32::MIN_POSITIVE) << 149;
    let constant = exact(f32::from_bits(rule.noise)) << 149;
    if is_counted { share.max(constant) } else { constant }
}

fn is_marked(map: &Map, objects: &[u32], detector: &EdgeDetector, level: usize, edge: Edge) -> bool {
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
    let rule = &detector.rule;
    if size == BigInt::ZERO || size <= exact(f32::from_bits(rule.low[level])) {
        return false;
    }
    // The steps beside it, in the same direction.
    let beside = [(before, a), (b, after)].map(|ends| match ends {
        (Some(p), Some(q)) => (BigInt::from(sign) * (exact(q) - exact(p))).max(BigInt::ZERO),
        _ => BigInt::ZERO,
    });
    let slopes = exact(f32::from_bits(rule.slopes[level]));
    let larger = beside.map(|beside| (&size << 149) > slopes.clone() * beside + noise(detector, p.max(q)));
    let is_sure = size > exact(f32::from_bits(rule.high));
    match detector.second {
        Second::Nothing => true,
        Second::Both => is_sure || larger == [true; 2],
        Second::One => is_sure || larger != [false; 2],
    }
}

/// The entries of all cells that are listed, and how many edges were continued.
fn expected(map: &Map, objects: &[u32], detector: &EdgeDetector) -> (Vec<u32>, usize) {
    let [width, height] = map.size.map(i64::from);
    let places = || (-1..=height).flat_map(move |y| (-1..=width).map(move |x| (x, y)));
    let all = || places().flat_map(|(x, y)| [(x, y, 0), (x, y, 1)]);
    let of_level = |level| all().filter(|&edge| is_marked(map, objects, detector, level, edge)).collect::<HashSet<_>>();
    let (mut marks, faint) = (of_level(0), of_level(1));
    let first = marks.len();
    for _ in 0..detector.cells {
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
    let ends = |(x, y): (i64, i64)| {
        [(x, y, 0), (x, y, 1), (x - 1, y, 0), (x, y - 1, 1)].iter().any(|edge| marks.contains(edge))
    };
    let is_near = |(x, y): (i64, i64)| {
        let reach = i64::from(detector.rings) - 1;
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
        let bit = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
        let drawn = bit(first, FIRST_TRIANGLE) | bit(second, SECOND_TRIANGLE);
        (drawn != 0).then_some(number | bit(is_split, SPLIT) | drawn)
    };
    let entries = (0..((width + 1) * (height + 1)) as u32).filter_map(entry).collect();
    (by_strips(map.size, entries), marks.len() - first)
}

/// How many edges were continued.
fn check(map: &Map, objects: &[u32], shape: &DepthMapShape, detector: &EdgeDetector) -> Result<usize, String> {
    let found = depth_edges(&Samples { shape, depths: &map.depths, objects }, detector);
    let (all, continued) = expected(map, objects, detector);
    if found.count as usize != all.len() || found.entries != all[..all.len().min(shape.capacity as usize)] {
        return Err(format!("{:?} with {detector:?}: {} cells, {} expected", map.size, found.count, all.len()));
    }
    Ok(continued)
}

#[test]
fn detectors_list_the_cells_of_exact_arithmetic() {
    const SEED: u64 = 1604;
    println!("seed {SEED}");
    let mut random = Random::new(SEED);
    let (mut continued, mut fewer) = (0, 0);
    for round in 0..12 {
        for map in further(&mut random).into_iter().chain(maps(&mut random)) {
            let depths = &map.depths;
            let [a, b] = [0, 1].map(|_| depths[random.below(depths.len())]);
            let met = (a - b).abs();
            let met = if (0.0..=1.0).contains(&met) && met >= f32::MIN_POSITIVE { met } else { 0.125 };
            let low = [0.0, met, 0.001, random.between(0.0, 0.3)][random.below(4)];
            let high = low.max([1.0, met, 0.02][random.below(3)]);
            let mut detector = detector(
                [Second::Nothing, Second::Both, Second::One][random.below(3)],
                [low, high],
                [1.0, 2.0, 0.5, 1.5][random.below(4)],
                [1.0, 0.5, random.between(0.0, 1.0), 0.0][random.below(4)],
            );
            (detector.rule.noise, detector.rule.noise_exponents) =
                [(0, 0), (0.5_f32.powi(22).to_bits(), 0), (0, 21), (met.to_bits(), 3)][random.below(4)];
            (detector.cells, detector.rings) = ([0, 1, 2, 9][random.below(4)], random.below(3) as u32);
            let objects: Vec<_> = (0..depths.len()).map(|_| u32::from(random.below(9) == 0)).collect();
            let objects = if round % 3 == 0 { &objects[..] } else { &[] };
            let shape = DepthMapShape { objects: u32::from(!objects.is_empty()), ..map.shape(-1.0, u32::MAX) };
            continued += check(&map, objects, &shape, &detector).expect("as expected");
            let samples = Samples { shape: &shape, depths, objects };
            fewer += usize::from(depth_edges(&samples, &detector).count < depth_cells(&shape, depths).count);
        }
    }
    println!("{continued} edges continued, {fewer} maps have fewer cells than all");
    assert!(continued > 1000 && fewer > 100, "{continued}, {fewer}");
}

/// The rules find no edges within a slope, and find a step on it.
#[test]
fn slopes_are_left_out_and_steps_are_not() {
    let flat = Map::new([20, 20], false, |texel| 0.25 + (texel % 20) as f32 / 64.0);
    // From the middle on, farther away by as much as the slope has in two texels.
    let step =
        Map::new([20, 20], false, |texel| flat.depths[texel as usize] + if texel % 20 > 9 { 0.03125 } else { 0.0 });
    let count = |map: &Map, second| {
        let shape = map.shape(-1.0, u32::MAX);
        let detector = detector(second, [0.001, 1.0], if second == Second::One { 2.0 } else { 1.0 }, 1.0);
        depth_edges(&Samples { shape: &shape, depths: &map.depths, objects: &[] }, &detector).count
    };
    for second in [Second::Both, Second::One] {
        // Cells at the border, where one difference beside an edge is not known for `One`.
        let border = 4 * 20;
        let found = [count(&flat, second), count(&step, second)];
        assert!(found[0] >= border && found[0] <= 2 * border && found[1] == found[0] + 19, "{second:?}: {found:?}");
    }
    assert!(count(&flat, Second::Nothing) > 300);
}

/// Negative controls: another rule for map or oracle.
#[test]
fn another_rule_is_noticed() {
    let map = further(&mut Random::new(3)).swap_remove(2);
    let shape = map.shape(-1.0, u32::MAX);
    let right = detector(Second::Both, [0.004, 1.0], 1.0, 0.5);
    let right = EdgeDetector { cells: 3, ..right };
    assert!(check(&map, &[], &shape, &right).is_ok_and(|continued| continued > 0));
    let list =
        |detector: &EdgeDetector| depth_edges(&Samples { shape: &shape, depths: &map.depths, objects: &[] }, detector);
    for other in [
        EdgeDetector { cells: 1, ..right },
        EdgeDetector { rings: 1, ..right },
        detector(Second::Both, [0.006, 1.0], 1.0, 0.5),
    ] {
        assert_ne!(list(&right), list(&other), "{other:?}");
    }
}
