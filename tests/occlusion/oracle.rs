//! Brute force in big integers: does a face occlude a point from a light? It shares no code with the library.

use num_bigint::{BigInt, Sign};
use rimline::Light;
use rimline_testkit::shadow_oracle::scaled;

/// A homogeneous point in integers.
pub(crate) type Point = [BigInt; 4];

/// `value · 2^298` as an integer, if all of its digits are there: so for each finite f32.
fn integer(value: f32) -> BigInt {
    scaled(value, 298)
}

pub(crate) fn corner([x, y, z]: [f32; 3]) -> Point {
    [integer(x), integer(y), integer(z), integer(1.0)]
}

pub(crate) fn light(light: Light) -> Point {
    light.to_array().map(integer)
}

/// The point with these weights, of which not all are 0.
pub(crate) fn between(corners: &[Point; 3], weights: [u32; 3]) -> Point {
    std::array::from_fn(|axis| corners.iter().zip(weights).map(|(corner, weight)| &corner[axis] * weight).sum())
}

/// The sign of the determinant of four homogeneous points, along the first row.
pub(crate) fn sign(rows: [&Point; 4]) -> i32 {
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

/// Whether the segment from the light to the point, or the ray from infinity, meets the face at the point or before.
pub(crate) fn occludes([a, b, c]: &[Point; 3], light: &Point, point: &Point) -> bool {
    let side = sign([a, b, c, light]);
    side != 0
        && sign([a, b, c, point]) != side
        && [[point, b, c, light], [a, point, c, light], [a, b, point, light]]
            .into_iter()
            .all(|rows| sign(rows) != -side)
}
