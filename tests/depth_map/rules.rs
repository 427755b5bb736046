//! Which cells are listed, and what of them is drawn: by big integers, without code of the library.

use num_bigint::BigInt;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod};
use wgpu::TextureFormat;

use crate::maps::Map;

/// A finite number that is not negative, in units of 2⁻¹⁴⁹.
pub(crate) fn exact(value: f32) -> BigInt {
    let (exponent, fraction) = (value.to_bits() >> 23, value.to_bits() & 0x007f_ffff);
    if exponent == 0 { BigInt::from(fraction) } else { BigInt::from(fraction + 0x0080_0000) << (exponent - 1) }
}

/// Whether `large` is more than `small` + `threshold`: by the rounded difference and, where that is the threshold, by
/// what rounding left of it.
pub(crate) fn exceeds(large: f32, small: f32, threshold: f32) -> bool {
    let [large, small, threshold] = [large, small, threshold].map(f64::from);
    let difference = large - small;
    let rounding = (large - difference) - small;
    difference > threshold || (difference == threshold && rounding > 0.0)
}

/// The depth of a texel as the documents define it: clamped, and nothing where it is far.
pub(crate) fn cast(map: &Map, x: i64, y: i64) -> Option<f32> {
    let inside = (0..i64::from(map.size[0])).contains(&x) && (0..i64::from(map.size[1])).contains(&y);
    let given = *inside.then(|| &map.depths[(y * i64::from(map.size[0]) + x) as usize])?;
    let depth = if given < f32::MIN_POSITIVE { 0.0 } else { given.min(1.0) };
    (!given.is_nan() && depth != map.far()).then_some(depth)
}

/// The rank of a sample among all floats from near to far, with nothing behind all.
pub(crate) fn rank(map: &Map, sample: Option<f32>) -> i64 {
    let Some(depth) = sample else { return 0x7fff_ffff };
    let bits = i64::from(depth.to_bits());
    if map.is_reversed { i64::from(1.0_f32.to_bits()) - bits } else { bits }
}

/// Whether a cell is split from its sample (1, 0) to (0, 1), by the ranks of its samples.
pub(crate) fn is_split([a, b, c, d]: [i64; 4]) -> bool {
    (a - d).abs() > (b - c).abs()
}

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
    /// Every edge is marked.
    pub(crate) every: bool,
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

impl Rule {
    /// The rule of a method and a map, with some bits.
    pub(crate) fn new(method: DepthMapMethod, bits: usize, is_reversed: bool, format: TextureFormat) -> Self {
        let (second, [low, high], slopes, dangling) = match method {
            DepthMapMethod::SecondDifferences { low, high, dangling } => (Second::Both, [low, high], 1.0, dangling),
            DepthMapMethod::Automatic { dangling } => (Second::One, [0.0, 1.0], 2.0, dangling),
            DepthMapMethod::Differences { threshold, dangling } => (Second::Nothing, [threshold, 1.0], 1.0, dangling),
            _ => (Second::Nothing, [1.0, 1.0], 1.0, None),
        };
        let DanglingEdges { share, cells } = dangling.unwrap_or(DanglingEdges { share: 1.0, cells: 0 });
        // Subnormal numbers are none to the shaders.
        let normal = |value: f32| if value < f32::MIN_POSITIVE { 0.0 } else { value };
        // Four steps of the format.
        let (noise, noise_exponents) = match format {
            TextureFormat::Depth16Unorm => (4.0 / 65_536.0, 0),
            TextureFormat::Depth32Float | TextureFormat::Depth32FloatStencil8 | TextureFormat::R32Float
                if is_reversed =>
            {
                (0.0, 21)
            }
            _ => (4.0 / 16_777_216.0, 0),
        };
        Self {
            every: method == DepthMapMethod::EveryCell,
            second,
            low: [low, low * share].map(normal),
            high: normal(high),
            slopes: [slopes, slopes * share].map(normal),
            noise,
            noise_exponents,
            cells,
            rings: u32::from(second != Second::Nothing) + u32::from(bits > 1),
        }
    }

    /// Bound on the error of two depths, times 2²⁹⁸.
    fn noise(&self, large: f32) -> BigInt {
        let share = exact(large) << (149 - self.noise_exponents);
        // No share is less than the least normal number.
        let is_counted = self.noise_exponents > 0 && share >= exact(f32::MIN_POSITIVE) << 149;
        let constant = exact(self.noise) << 149;
        if is_counted { share.max(constant) } else { constant }
    }

    fn is_marked(&self, map: &Map, objects: &[u32], level: usize, edge: Edge) -> bool {
        let texel = |(x, y): (i64, i64)| cast(map, x, y);
        let [a, b] = [0, 1].map(|steps| texel(along(edge, steps)));
        let (Some(p), Some(q)) = (a, b) else { return a.is_some() != b.is_some() };
        let object = |(x, y): (i64, i64)| objects.get((y * i64::from(map.size[0]) + x) as usize);
        if self.every || object(along(edge, 0)) != object(along(edge, 1)) {
            return true;
        }
        if !exceeds(p.max(q), p.min(q), self.low[level]) || self.second == Second::Nothing {
            return exceeds(p.max(q), p.min(q), self.low[level]);
        }
        let step = exact(q) - exact(p);
        let sign = BigInt::from(if step < BigInt::ZERO { -1 } else { 1 });
        let size = &sign * &step;
        // The steps beside it, in the same direction.
        let beside = [(texel(along(edge, -1)), a), (b, texel(along(edge, 2)))].map(|ends| match ends {
            (Some(p), Some(q)) => (&sign * (exact(q) - exact(p))).max(BigInt::ZERO),
            _ => BigInt::ZERO,
        });
        let slopes = exact(self.slopes[level]);
        let larger = beside.map(|beside| (&size << 149) > &slopes * beside + self.noise(p.max(q)));
        size > exact(self.high) || if self.second == Second::Both { larger == [true; 2] } else { larger != [false; 2] }
    }
}

/// An edge: from a texel to the right (0) or down (1).
type Edge = (i64, i64, usize);

/// The texel at the other end of an edge, or as many steps along it.
fn along((x, y, axis): Edge, steps: i64) -> (i64, i64) {
    if axis == 0 { (x + steps, y) } else { (x, y + steps) }
}

/// Edges of a map with a border of a texel.
#[derive(Clone, PartialEq)]
struct Marks(i64, Vec<bool>);

impl Marks {
    fn at(&self, (x, y, axis): Edge) -> Option<usize> {
        let across = self.0 + 2;
        (-1..=self.0).contains(&x).then_some(())?;
        usize::try_from(((y + 1) * across + x + 1) * 2 + axis as i64).ok()
    }

    fn contains(&self, edge: Edge) -> bool {
        self.at(edge).and_then(|at| self.1.get(at)).copied().unwrap_or(false)
    }
}

/// Bits of an entry: its cell, the cell is split from its sample (1, 0), and its two triangles are drawn.
pub(crate) const CELL: u32 = (1 << 29) - 1;
pub(crate) const SPLIT: u32 = 1 << 29;
pub(crate) const TRIANGLES: [u32; 2] = [1 << 30, 1 << 31];

/// The entries row by row, and how many edges were continued. Without `has_border` the map is one of a cube: there are
/// no edges to samples around it. Cells have the numbers of those with a border.
pub(crate) fn entries(map: &Map, objects: &[u32], rule: &Rule, has_border: bool) -> (Vec<u32>, usize) {
    let [width, height] = map.size.map(i64::from);
    let positions = || (-1..=height).flat_map(move |y| (-1..=width).map(move |x| (x, y)));
    let is_there = |edge: Edge| {
        let ends = [along(edge, 0), along(edge, 1)];
        has_border || ends.iter().all(|(x, y)| (0..width).contains(x) && (0..height).contains(y))
    };
    let of_level = |level| {
        let all = positions().flat_map(|(x, y)| [(x, y, 0), (x, y, 1)]);
        Marks(width, all.map(|edge| is_there(edge) && rule.is_marked(map, objects, level, edge)).collect())
    };
    let mut marks = of_level(0);
    let mut continued = 0;
    let faint = (rule.cells > 0).then(|| of_level(1));
    let around = |x: i64, y: i64| [(x, y, 0), (x, y + 1, 0), (x, y, 1), (x + 1, y, 1)];
    for _ in 0..rule.cells {
        let before = marks.clone();
        for (x, y) in positions() {
            if around(x, y).into_iter().filter(|&edge| before.contains(edge)).count() != 1 {
                continue;
            }
            for edge in around(x, y) {
                if let (true, Some(at)) = (faint.as_ref().is_some_and(|faint| faint.contains(edge)), marks.at(edge)) {
                    continued += usize::from(!marks.1[at]);
                    marks.1[at] = true;
                }
            }
        }
        if marks == before {
            break;
        }
    }
    // Other maps of a cube may have a mark at a sample on the border.
    let is_shared = |x: i64, y: i64| !has_border && (x == 0 || y == 0 || x == width - 1 || y == height - 1);
    let ends = |(x, y): (i64, i64)| {
        let beside = [(x, y, 0), (x, y, 1), (x - 1, y, 0), (x, y - 1, 1)];
        is_shared(x, y) || beside.into_iter().any(|edge| marks.contains(edge))
    };
    let is_near = |(x, y): (i64, i64)| {
        let steps = i64::from(rule.rings) - 1;
        let near = (-steps..=steps).flat_map(|dx| (-steps..=steps).map(move |dy| (dx, dy)));
        cast(map, x, y).is_some()
            && near.filter(|(dx, dy)| dx.abs() + dy.abs() <= steps).any(|(dx, dy)| ends((x + dx, y + dy)))
    };
    let entry = |number: u32| {
        let across = width + 1;
        let (x, y) = (i64::from(number) % across - 1, i64::from(number) / across - 1);
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let is_split = is_split(corners.map(|(x, y)| rank(map, cast(map, x, y))));
        let [top, bottom, left, right] = around(x, y).map(|edge| marks.contains(edge));
        let [a, b, c, d] = corners.map(is_near);
        let drawn = if is_split {
            [top || left || a || b || c, right || bottom || b || c || d]
        } else {
            [top || right || a || b || d, left || bottom || a || c || d]
        };
        let bit = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
        let drawn = bit(drawn[0], TRIANGLES[0]) | bit(drawn[1], TRIANGLES[1]);
        (drawn != 0).then_some(number | bit(is_split, SPLIT) | drawn)
    };
    let entries = (0..((width + 1) * (height + 1)) as u32).filter_map(entry).collect();
    (entries, continued)
}

/// Entries by the strips of their cells, eight across and four down, and by the rows of each strip.
fn by_strips(mut entries: Vec<u32>, position: impl Fn(u32) -> [u32; 2]) -> Vec<u32> {
    entries.sort_by_key(|&entry| {
        let [x, y] = position(entry);
        [y / 4, x / 8, y % 4, x % 8]
    });
    entries
}

/// The list of a map as buffers have it, the number and as many entries as there is room for, and how many edges were
/// continued.
pub(crate) fn listed(map: &Map, objects: &[u32], rule: &Rule, capacity: Option<u32>) -> (Vec<u32>, usize) {
    let (entries, continued) = entries(map, objects, rule, true);
    let across = map.size[0] + 1;
    let entries = by_strips(entries, |entry| [(entry & CELL) % across, (entry & CELL) / across]);
    let mut list = vec![entries.len() as u32];
    list.extend(entries.into_iter().take(capacity.map_or(usize::MAX, |room| room as usize)));
    (list, continued)
}

/// The list of the cells of six maps of a cube.
pub(crate) fn listed_of_cube(maps: &[Map], objects: &[Vec<u32>], rule: &Rule) -> (Vec<u32>, usize) {
    let side = maps[0].size[0];
    let position = |entry: u32| [(entry & CELL) % (side + 1), (entry & CELL) / (side + 1)];
    let (mut list, mut all) = (vec![0], 0);
    for (face, map) in maps.iter().enumerate() {
        let (mut cells, continued) = entries(map, objects.get(face).map_or(&[], |objects| objects), rule, false);
        cells.retain(|&entry| position(entry).iter().all(|at| (1..side).contains(at)));
        // Strips begin at the first cell within the map.
        let in_map = |entry: u32| position(entry).map(|at| at - 1);
        list.extend(by_strips(cells, in_map).into_iter().map(|entry| {
            let [x, y] = in_map(entry);
            entry & !CELL | ((face as u32 * (side - 1) + y) * (side - 1) + x)
        }));
        all += continued;
    }
    list[0] = list.len() as u32 - 1;
    (list, all)
}
