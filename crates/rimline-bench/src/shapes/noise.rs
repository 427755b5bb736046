//! Deterministic noise by integer hashing, + − × and floor: the same bits on every platform.

/// The next number of a splitmix64 sequence (Steele, Lea and Flood 2014).
pub fn splitmix64(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Smooth noise between −1 and 1: two octaves of value noise, the coarse one with two lattice cells to the unit.
pub fn smooth(point: [f32; 3], seed: u32) -> f32 {
    let coarse = value(point.map(|axis| 2.0 * axis), seed);
    let fine = value(point.map(|axis| 4.0 * axis), seed.wrapping_add(1));
    (2.0 * coarse + fine) / 3.0
}

/// Random values at integer points, blended between them with first derivatives 0 there.
fn value(point: [f32; 3], seed: u32) -> f32 {
    let cell = point.map(f32::floor);
    let blend: [f32; 3] = std::array::from_fn(|axis| {
        let t = point[axis] - cell[axis];
        t * t * (3.0 - 2.0 * t)
    });
    let corner = |offset: [i32; 3]| at_lattice(std::array::from_fn(|axis| cell[axis] as i32 + offset[axis]), seed);
    let along_x = |y, z| mix(corner([0, y, z]), corner([1, y, z]), blend[0]);
    let along_y = |z| mix(along_x(0, z), along_x(1, z), blend[1]);
    mix(along_y(0), along_y(1), blend[2])
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// A value from −1 to 1 for an integer point.
fn at_lattice([x, y, z]: [i32; 3], seed: u32) -> f32 {
    let mut state = u64::from(seed);
    for axis in [x, y, z] {
        state = splitmix64(&mut state) ^ u64::from(axis as u32);
    }
    // 24 bits, so that the conversion is exact.
    (splitmix64(&mut state) >> 40) as f32 / (1 << 23) as f32 - 1.0
}
