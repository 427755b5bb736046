//! Brute force in big integers: does a face hide a place from a light? It shares no code with the library.

use num_bigint::{BigInt, Sign};
use rimline::Light;

/// A homogeneous place in integers.
pub(crate) type Place = [BigInt; 4];

/// `value · 2^298` as an integer, if all of its digits are there: so for each finite f32.
fn integer(value: f32) -> BigInt {
    let bits = value.to_bits();
    let (exponent, fraction) = (bits >> 23 & 0xff, bits & 0x7f_ffff);
    let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 23 };
    let size = BigInt::from(mantissa) << (exponent.max(1) - 1 + 149);
    if bits >> 31 == 0 { size } else { -size }
}

pub(crate) fn corner([x, y, z]: [f32; 3]) -> Place {
    [integer(x), integer(y), integer(z), integer(1.0)]
}

pub(crate) fn light(light: Light) -> Place {
    light.to_array().map(integer)
}

/// The place with these weights, of which not all are 0.
pub(crate) fn between(corners: &[Place; 3], weights: [u32; 3]) -> Place {
    std::array::from_fn(|axis| corners.iter().zip(weights).map(|(corner, weight)| &corner[axis] * weight).sum())
}

/// The sign of the determinant of four homogeneous places, along the first row.
pub(crate) fn sign(rows: [&Place; 4]) -> i32 {
    let minor = |column: usize| {
        let [x, y, z] = match column {
            0 => [1, 2, 3],
            1 => [0, 2, 3],
            2 => [0, 1, 3],
            _ => [0, 1, 2],
        };
        let [_, a, b, c] = rows;
        &a[x] * (&b[y] * &c[z] - &b[z] * &c[y]) - &a[y] * (&b[x] * &c[z] - &b[z] * &c[x])
            + &a[z] * (&b[x] * &c[y] - &b[y] * &c[x])
    };
    let sum: BigInt = (0..4)
        .map(|column| {
            let term = &rows[0][column] * minor(column);
            if column % 2 == 0 { term } else { -term }
        })
        .sum();
    match sum.sign() {
        Sign::Minus => -1,
        Sign::NoSign => 0,
        Sign::Plus => 1,
    }
}

/// Whether the segment from the light to the place, or the ray from infinity, meets the face at the place or before.
pub(crate) fn hides([a, b, c]: &[Place; 3], light: &Place, place: &Place) -> bool {
    let side = sign([a, b, c, light]);
    side != 0
        && sign([a, b, c, place]) != side
        && [[place, b, c, light], [a, place, c, light], [a, b, place, light]]
            .into_iter()
            .all(|rows| sign(rows) != -side)
}
