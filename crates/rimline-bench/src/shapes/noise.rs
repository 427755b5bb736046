//! Deterministic noise by integer hashing, + − × and floor: the same bits on every platform.

use crate::random::Random;

/// Smooth noise between −1 and 1: two octaves of value noise, the coarse one with two lattice cells to the unit.
pub(super) fn smooth(point: [f32; 3], seed: u32) -> f32 {
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
fn at_lattice(point: [i32; 3], seed: u32) -> f32 {
    let mix = |state: u64, axis: i32| Random::new(state).next_u64() ^ u64::from(axis as u32);
    Random::new(point.into_iter().fold(u64::from(seed), mix)).between(-1.0, 1.0)
}
