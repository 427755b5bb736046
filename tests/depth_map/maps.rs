//! Depth maps of tests: random ones, and ones that are hard to take.

use rimline::DepthDirection;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

/// A map: texels across and down, whether near is 1, and depths.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub(crate) size: [u32; 2],
    pub(crate) is_reversed: bool,
    pub(crate) depths: Vec<f32>,
}

impl Map {
    pub(crate) fn new(size: [u32; 2], is_reversed: bool, depth: impl FnMut(u32) -> f32) -> Self {
        Self { size, is_reversed, depths: (0..size[0] * size[1]).map(depth).collect() }
    }

    /// The depth where nothing casts.
    pub(crate) fn far(&self) -> f32 {
        if self.is_reversed { 0.0 } else { 1.0 }
    }

    pub(crate) fn direction(&self) -> DepthDirection {
        if self.is_reversed { DepthDirection::Reversed } else { DepthDirection::Standard }
    }

    /// The map that a format may hold: a depth attachment takes finite depths from 0 to 1 alone.
    pub(crate) fn for_format(&self, format: TextureFormat) -> Self {
        let clamped = |depth: &f32| if depth.is_nan() { 0.5 } else { depth.clamp(0.0, 1.0) };
        let is_plain = format == TextureFormat::R32Float;
        Self { depths: self.depths.iter().map(|d| if is_plain { *d } else { clamped(d) }).collect(), ..*self }
    }
}

/// A depth of any size, with those that are equal, far, not finite or out of range among them.
fn hostile(random: &mut Random) -> f32 {
    let exponent = 127 - random.below(30) as u32;
    let near_exponent = random.below(256) as u32;
    let mantissa = random.next_u64() as u32 & 0x007f_ffff;
    match random.below(12) {
        0 => 0.0,
        1 => 1.0,
        2 => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, -1.5, 7.0, f32::MIN_POSITIVE / 2.0][random.below(7)],
        3 => f32::from_bits((near_exponent << 23) | mantissa),
        4 => 0.5,
        5 => 1.0 - f32::EPSILON / 2.0,
        6 => f32::from_bits((exponent << 23) | mantissa),
        7 => f32::from_bits(0x3f00_0000 | (mantissa & 3)),
        _ => random.between(0.0, 1.0),
    }
}

/// Maps of odd sizes, of both directions: hostile everywhere, flat with few steps, all far, of one texel.
pub(crate) fn maps(random: &mut Random) -> Vec<Map> {
    let mut maps = Vec::new();
    for is_reversed in [false, true] {
        let far = if is_reversed { 0.0 } else { 1.0 };
        for size in [[1, 1], [1, 9], [40, 1], [7, 5], [16, 16], [31, 50]] {
            maps.push(Map::new(size, is_reversed, |_| hostile(random)));
            maps.push(Map::new(size, is_reversed, |_| far));
            maps.push(Map::new(size, is_reversed, |_| 0.5 + random.below(3) as f32 * 0.125));
            let lone = random.below((size[0] * size[1]) as usize) as u32;
            maps.push(Map::new(size, is_reversed, |texel| if texel == lone { 0.25 } else { far }));
            maps.push(Map::new(size, is_reversed, |texel| 0.3 + (texel % size[0]) as f32 * 0.01));
        }
    }
    maps
}

/// Rows of four samples whose middle difference is `slopes` times those beside it and what the format may be off by, to
/// within one step of a float.
fn nearly(random: &mut Random, is_reversed: bool, slopes: u32) -> Map {
    // The step of floats from a quarter to a half.
    let step = 0.5_f32.powi(25);
    let mut depths = Vec::new();
    for _ in 0..9 * 12 {
        let first = (1 << 23) + random.below(1_000_000) as u32;
        let beside = 1_500_000 + random.below(100_000) as u32;
        let second = first + beside;
        let third = second + slopes * beside;
        // Four steps of 24 bits, or of a float there.
        let noise = if is_reversed { third >> 21 } else { 8 };
        let third = third + noise + random.below(4) as u32 - 1;
        depths.extend([first, second, third, third + beside].map(|steps| steps as f32 * step));
    }
    Map { size: [36, 12], is_reversed, depths }
}

/// Steep planes, a ridge that fades, and depths with steps of a precision, so that rules are met exactly.
pub(crate) fn further(random: &mut Random) -> Vec<Map> {
    let unit = 0.5_f32.powi(22);
    let mut maps = Vec::new();
    for is_reversed in [false, true] {
        maps.push(Map::new([23, 19], is_reversed, |_| 0.5 + random.below(6) as f32 * unit));
        maps.push(Map::new([23, 19], is_reversed, |_| 0.5 - [1, 2, 20, 21, 38, 39, 40][random.below(7)] as f32 * unit));
        maps.push(Map::new([23, 19], is_reversed, |texel| {
            let (x, y) = ((texel % 23) as f32, (texel / 23) as f32);
            0.4 + 0.001 * x + if x > 11.0 { 0.001 * y } else { 0.0 }
        }));
        maps.extend([1, 2].map(|slopes| nearly(random, is_reversed, slopes)));
        // Each other step is twice those beside it and what depths that are not reversed may be off by, in both directions.
        let steps = |position: u32| (position.div_ceil(2) * 64 + position / 2 * 129) as f32 * unit;
        maps.push(Map::new([70, 37], is_reversed, |texel| 0.5 + steps(texel % 70) + steps(texel / 70)));
        maps.push(Map::new([17, 21], is_reversed, |texel| {
            0.5 + (texel / 17) as f32 / 64.0 + if texel % 17 > 8 { random.between(0.0, 0.05) } else { 0.0 }
        }));
    }
    maps
}
