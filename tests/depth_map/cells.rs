//! Which cells are listed, and what of them is drawn: by a text of its own, without code of the library. Depths are compared on the
//! GPU as in big integers.

use num_bigint::BigInt;
use rimline::reference::stages::DEPTH_CELLS;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::same;

use crate::maps::Map;
use crate::probe::Probe;

pub(crate) const TESTS: &[Test] = &[("differences_are_compared_exactly", differences)];

/// A finite number that is not negative, in units of 2⁻¹⁴⁹.
pub(crate) fn exact(value: f32) -> BigInt {
    let (exponent, fraction) = (value.to_bits() >> 23, value.to_bits() & 0x007f_ffff);
    if exponent == 0 { BigInt::from(fraction) } else { BigInt::from(fraction + 0x0080_0000) << (exponent - 1) }
}

/// Whether `large` is more than `small` + `threshold`: by the rounded difference and, where that is the threshold, by what rounding
/// left of it.
fn exceeds(large: f32, small: f32, threshold: f32) -> bool {
    let [large, small, threshold] = [large, small, threshold].map(f64::from);
    let difference = large - small;
    let rest = (large - difference) - small;
    difference > threshold || (difference == threshold && rest > 0.0)
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

/// The entry of a cell, if it is listed. `objects`: none, or one for each texel. `spreads`: triangles at the ends of edges
/// are drawn.
fn expected(map: &Map, objects: &[u32], threshold: f32, spreads: bool, number: u32) -> Option<u32> {
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
            threshold < 0.0 || first != second || exceeds(a.max(b), a.min(b), threshold)
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
    entry(number, is_split, [first, second])
}

/// Bits of an entry: its cell, the cell is split from its sample (1, 0), and its two triangles are drawn.
pub(crate) const CELL: u32 = (1 << 29) - 1;
const SPLIT: u32 = 1 << 29;
const FIRST_TRIANGLE: u32 = 1 << 30;
const SECOND_TRIANGLE: u32 = 1 << 31;

/// The corners of the six vertices of a cell, from its first sample: `None` where a triangle is left out.
pub(crate) fn corners(entry: u32) -> [Option<[u32; 2]>; 6] {
    let [a, b, c, d] = [[0, 0], [1, 0], [0, 1], [1, 1]];
    let triangles = if entry & SPLIT == 0 { [a, b, d, a, d, c] } else { [a, b, c, b, d, c] };
    std::array::from_fn(|vertex| (entry & (FIRST_TRIANGLE << (vertex / 3)) != 0).then_some(triangles[vertex]))
}

/// The entry of a cell whose triangles are drawn so, if one is.
pub(crate) fn entry(number: u32, is_split: bool, [first, second]: [bool; 2]) -> Option<u32> {
    let bit = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
    let drawn = bit(first, FIRST_TRIANGLE) | bit(second, SECOND_TRIANGLE);
    (drawn != 0).then_some(number | bit(is_split, SPLIT) | drawn)
}

/// The list of a map's cells as buffers have it, as far as there is room.
pub(crate) fn listed(map: &Map, objects: &[u32], threshold: f32, spreads: bool, capacity: Option<u32>) -> Vec<u32> {
    with_count(by_strips(map.size, entries(map, objects, threshold, spreads)), capacity)
}

/// The number of entries, and those that there is room for.
pub(crate) fn with_count(entries: Vec<u32>, capacity: Option<u32>) -> Vec<u32> {
    let count = entries.len();
    std::iter::once(count as u32)
        .chain(entries.into_iter().take(capacity.map_or(count, |room| room as usize)))
        .collect()
}

/// The list of the cells of six maps of a cube. `entries` are those of a map with a border, of which cells within the map count.
pub(crate) fn listed_of_cube(maps: &[Map], mut entries: impl FnMut(usize, &Map) -> Vec<u32>) -> Vec<u32> {
    let side = maps[0].size[0];
    let place = |entry: u32| [(entry & CELL) % (side + 1), (entry & CELL) / (side + 1)];
    let mut all = Vec::new();
    for (face, map) in maps.iter().enumerate() {
        let mut own = entries(face, map);
        own.retain(|&entry| place(entry).iter().all(|at| (1..side).contains(at)));
        // Strips begin at the first cell within the map.
        let strip = |entry: &u32| {
            let [x, y] = place(*entry).map(|at| at - 1);
            [y / 4, x / 8, y % 4, x % 8]
        };
        own.sort_by_key(strip);
        let renumbered = |entry: u32| {
            let [x, y] = place(entry).map(|at| at - 1);
            entry & !CELL | ((face as u32 * (side - 1) + y) * (side - 1) + x)
        };
        all.extend(own.into_iter().map(renumbered));
    }
    with_count(all, None)
}

/// The entries of a map, row by row.
pub(crate) fn entries(map: &Map, objects: &[u32], threshold: f32, spreads: bool) -> Vec<u32> {
    let cells = (map.size[0] + 1) * (map.size[1] + 1);
    (0..cells).filter_map(|number| expected(map, objects, threshold, spreads, number)).collect()
}

/// Entries of a map by the strips of their cells, eight across and four down, and by the rows of each strip.
pub(crate) fn by_strips(size: [u32; 2], mut entries: Vec<u32>) -> Vec<u32> {
    entries.sort_by_key(|entry| {
        let number = entry & CELL;
        let [x, y] = [number % (size[0] + 1), number / (size[0] + 1)];
        [y / 4, x / 8, y % 4, x % 8]
    });
    entries
}

/// The comparison of the shaders, and that of the lists that tests expect.
fn differences() -> Result<(), String> {
    const SEED: u64 = 1602;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut met, mut inputs, mut expected) = ([0; 3], Vec::new(), Vec::new());
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
        if exceeds(large, small, threshold) != order.is_gt() {
            return Err(format!("lists that tests expect: {large:e} − {small:e} > {threshold:e}"));
        }
        inputs.push([large, small, threshold, 0.0]);
        expected.push(u32::from(order.is_gt()));
    }
    let expression = "vec4<u32>(u32(exceeds(bitcast<u32>(input.x), bitcast<u32>(input.y), bitcast<u32>(input.z))))";
    let probe = Probe::new(&gpu, &DEPTH_CELLS.wgsl(), ("vec4<u32>", expression), &[]);
    let found: Vec<_> = probe.run(&gpu, &[], &inputs)?.into_iter().map(|words| words[0]).collect();
    same("comparisons", &found, &expected)?;
    if met.iter().all(|&count| count > 10_000) { Ok(()) } else { Err(format!("less, equal, more: {met:?}")) }
}
