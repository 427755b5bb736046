//! Which cells are listed, and what of them is drawn: the twin against big integers.

use num_bigint::BigInt;
use rimline::reference::cpu::{
    CELL_MASK, FIRST_TRIANGLE, SECOND_TRIANGLE, SPLIT, depth_cells, depth_cells_of_objects, exceeds,
};
use rimline::reference::layout::DepthMapShape;
use rimline_measure::random::Random;

use crate::maps::{Map, maps};

/// A finite number that is not negative, in units of 2⁻¹⁴⁹.
pub(crate) fn exact(value: f32) -> BigInt {
    let (exponent, fraction) = (value.to_bits() >> 23, value.to_bits() & 0x007f_ffff);
    if exponent == 0 { BigInt::from(fraction) } else { BigInt::from(fraction + 0x0080_0000) << (exponent - 1) }
}

/// The depth of a texel as the documents tell: clamped, and nothing where it is far.
pub(crate) fn cast(map: &Map, x: i64, y: i64) -> Option<f32> {
    let inside = (0..i64::from(map.size[0])).contains(&x) && (0..i64::from(map.size[1])).contains(&y);
    let depth = *inside.then(|| &map.depths[(y * i64::from(map.size[0]) + x) as usize])?;
    let depth = if depth < f32::MIN_POSITIVE { 0.0 } else { depth.min(1.0) };
    let far = if map.is_reversed { 0.0 } else { 1.0 };
    (!map.depths[(y * i64::from(map.size[0]) + x) as usize].is_nan() && depth != far).then_some(depth)
}

/// The rank of a sample among all floats from near to far, with nothing behind all.
pub(crate) fn rank(map: &Map, sample: Option<f32>) -> i64 {
    let Some(depth) = sample else { return 0x7fff_ffff };
    let bits = i64::from(depth.to_bits());
    if map.is_reversed { i64::from(1.0_f32.to_bits()) - bits } else { bits }
}

/// The entry of a cell, 0 if it is not listed. `objects`: none, or one for each texel. `spreads`: triangles at the ends of edges
/// are drawn.
fn expected(map: &Map, objects: &[u32], threshold: f32, spreads: bool, number: u32) -> u32 {
    let across = i64::from(map.size[0]) + 1;
    let (x, y) = (i64::from(number) % across - 1, i64::from(number) / across - 1);
    // The depth that casts, and the object.
    let corner = |dx: i64, dy: i64| {
        let texel = (y + dy) * i64::from(map.size[0]) + x + dx;
        cast(map, x + dx, y + dy).map(|depth| (depth, objects.get(texel as usize).copied()))
    };
    let is_marked = |a: Option<(f32, Option<u32>)>, b: Option<(f32, Option<u32>)>| match (a, b) {
        (None, None) => false,
        (Some((a, first)), Some((b, second))) => {
            let difference = exact(a) - exact(b);
            threshold < 0.0 || first != second || difference.magnitude() > exact(threshold).magnitude()
        }
        _ => true,
    };
    let depth = |sample: Option<(f32, Option<u32>)>| sample.map(|sample| sample.0);
    let diagonal = |a, b| (rank(map, depth(a)) - rank(map, depth(b))).abs();
    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
    let is_split = diagonal(a, d) > diagonal(b, c);
    // Whether a corner is a depth next to which, in the four directions, an edge is marked.
    let touches = |dx: i64, dy: i64| {
        let beside = [[-1, 0], [1, 0], [0, -1], [0, 1]];
        let own = corner(dx, dy);
        spreads && own.is_some() && beside.iter().any(|[x, y]| is_marked(own, corner(dx + x, dy + y)))
    };
    let diagonal_touches = if is_split { touches(1, 0) || touches(0, 1) } else { touches(0, 0) || touches(1, 1) };
    // The triangle at a corner that the diagonal leaves out has the two edges of that corner.
    let (first, second) = if is_split {
        (
            is_marked(a, b) || is_marked(a, c) || touches(0, 0) || diagonal_touches,
            is_marked(d, b) || is_marked(d, c) || touches(1, 1) || diagonal_touches,
        )
    } else {
        (
            is_marked(b, a) || is_marked(b, d) || touches(1, 0) || diagonal_touches,
            is_marked(c, a) || is_marked(c, d) || touches(0, 1) || diagonal_touches,
        )
    };
    if !first && !second {
        return 0;
    }
    let bit = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
    number | bit(is_split, SPLIT) | bit(first, FIRST_TRIANGLE) | bit(second, SECOND_TRIANGLE)
}

/// Entries of a map by the strips of their cells, eight across and four down, and by the rows of each strip.
pub(crate) fn by_strips(size: [u32; 2], mut entries: Vec<u32>) -> Vec<u32> {
    entries.sort_by_key(|entry| {
        let number = entry & 0x1fff_ffff;
        let [x, y] = [number % (size[0] + 1), number / (size[0] + 1)];
        [y / 4, x / 8, y % 4, x % 8]
    });
    entries
}

fn check(map: &Map, objects: &[u32], threshold: f32, shape: &DepthMapShape) -> Result<usize, String> {
    let found = depth_cells_of_objects(shape, &map.depths, objects);
    // An entry of 0 is no entry: an entry has a bit for a triangle.
    let all: Vec<_> = (0..shape.cells)
        .map(|number| expected(map, objects, threshold, shape.spread == 1, number))
        .filter(|&entry| entry != 0)
        .collect();
    let all = by_strips(map.size, all);
    if found.count as usize != all.len() || found.entries != all[..all.len().min(shape.capacity as usize)] {
        return Err(format!("{:?} with {threshold}: {} cells, {} expected", map.size, found.count, all.len()));
    }
    let drawn = if found.count > shape.capacity { shape.cells } else { found.count };
    if found.draw != [6 * drawn, 1, 0, 0] {
        return Err(format!("{:?} with {threshold}: {:?}", map.size, found.draw));
    }
    Ok(all.len())
}

#[test]
fn listed_cells_are_those_of_exact_arithmetic() {
    const SEED: u64 = 1601;
    println!("seed {SEED}");
    let mut random = Random::new(SEED);
    let mut listed = 0;
    for round in 0..20 {
        for map in maps(&mut random) {
            let depths = &map.depths;
            // A threshold that is met exactly, one that is random, none, and every cell.
            let [a, b] = [0, 1].map(|_| depths[random.below(depths.len())]);
            let met = (a - b).abs();
            let met = if (0.0..=1.0).contains(&met) && met >= f32::MIN_POSITIVE { met } else { 0.125 };
            for threshold in [met, random.between(0.0, 0.3), 0.125, 0.0, -1.0] {
                let capacity = if round % 2 == 0 { u32::MAX } else { random.below(9) as u32 };
                let mut shape = map.shape(threshold, capacity);
                listed += check(&map, &[], threshold, &shape).expect("as expected");
                shape.spread = random.below(2) as u32;
                listed += check(&map, &[], threshold, &shape).expect("as expected");
                shape.objects = 1;
                let objects: Vec<_> = (0..depths.len()).map(|_| random.below(3) as u32 * 0x7fff_ffff).collect();
                // The largest threshold leaves edges of objects alone.
                let threshold = if random.below(2) == 0 { threshold } else { 1.0 };
                let shape = DepthMapShape {
                    every_cell: u32::from(threshold < 0.0),
                    threshold: threshold.max(0.0).to_bits(),
                    ..shape
                };
                check(&map, &objects, threshold, &shape).expect("as expected");
            }
        }
    }
    assert!(listed > 100_000, "{listed}");
}

/// Negative controls: a sample, a threshold or the direction of depth that is another.
#[test]
fn another_map_is_noticed() {
    let map = Map::new([7, 5], false, |texel| (texel % 11) as f32 / 16.0);
    let shape = map.shape(0.125, u32::MAX);
    assert!(check(&map, &[], 0.125, &shape).is_ok());
    let mut moved = map.clone();
    moved.depths[17] += 0.5;
    assert!(check(&moved, &[], 0.125, &shape).is_ok());
    assert_ne!(depth_cells(&shape, &map.depths), depth_cells(&shape, &moved.depths));
    assert!(check(&map, &[], 0.5, &shape).is_err());
    assert!(check(&Map { is_reversed: true, ..map.clone() }, &[], 0.125, &shape).is_err());
    let lone = Map::new([7, 5], false, |texel| if texel == 17 { 0.25 } else { 0.5 });
    let spread = DepthMapShape { spread: 1, ..shape };
    assert!(check(&lone, &[], 0.125, &spread).is_ok());
    assert_ne!(depth_cells(&shape, &lone.depths), depth_cells(&spread, &lone.depths));
    let objects: Vec<_> = (0..35).map(|texel| texel / 9).collect();
    let shape = map.shape(0.7, u32::MAX);
    assert!(check(&map, &objects, 0.7, &shape).is_err());
    assert!(check(&map, &objects, 0.7, &DepthMapShape { objects: 1, ..shape }).is_ok());
}

#[test]
fn differences_are_compared_exactly() {
    const SEED: u64 = 1602;
    println!("seed {SEED}");
    let mut random = Random::new(SEED);
    let mut met = [0; 3];
    for case in 0..300_000 {
        // Near each other or not, with bits at both ends of the mantissa.
        let number = |random: &mut Random, most: u32| {
            let exponent = most.saturating_sub(random.below(60) as u32).max(1);
            let mantissa = [random.next_u64() as u32, 1 << random.below(23), u32::MAX, 0][random.below(4)];
            f32::from_bits((exponent << 23) | (mantissa & 0x007f_ffff)).min(1.0)
        };
        let large = number(&mut random, 127);
        let small = if random.below(8) == 0 { 0.0 } else { number(&mut random, large.to_bits() >> 23).min(large) };
        let threshold = match case % 3 {
            0 => number(&mut random, 127),
            1 => (large - small).max(0.0),
            _ => f32::from_bits(((large - small).to_bits() + random.below(3) as u32).saturating_sub(1)),
        };
        let threshold = if threshold < f32::MIN_POSITIVE { 0.0 } else { threshold };
        let order = (exact(large) - exact(small)).cmp(&exact(threshold));
        met[(order as i8 + 1) as usize] += 1;
        let found = exceeds(large.to_bits(), small.to_bits(), threshold.to_bits());
        assert_eq!(found, order.is_gt(), "{large:e} − {small:e} > {threshold:e}");
    }
    assert!(met.iter().all(|&count| count > 10_000), "less, equal, more: {met:?}");
}

#[test]
fn entries_have_room_for_every_cell() {
    assert_eq!(CELL_MASK | SPLIT | FIRST_TRIANGLE | SECOND_TRIANGLE, u32::MAX);
    assert_eq!(CELL_MASK & SPLIT, 0);
}
