//! Lights that are hard on a polygon.

use rimline::Light;
use rimline_testkit::random::Random;

/// A light with its name: anywhere, in the hull, in planes and on lines through corners, at corners, at infinity.
pub(crate) fn light_for(random: &mut Random, corners: &[[f32; 3]]) -> (&'static str, Light) {
    let any = |random: &mut Random| corners[random.below(corners.len())];
    let weighted = |random: &mut Random, count: usize, low: f32| {
        let mut point = [0.0; 3];
        let weights: Vec<f32> = (0..count).map(|_| random.between(low, 1.0)).collect();
        let sum: f32 = weights.iter().sum();
        for weight in weights {
            let corner = any(random);
            (0..3).for_each(|axis| point[axis] += corner[axis] * weight / sum);
        }
        point
    };
    let direction = random.direction();
    let from = |p: [f32; 3], q: [f32; 3]| [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
    let far = direction.map(|c| c * random.between(0.5, 9.0));
    match random.below(12) {
        0 => ("near or far", Light::point(far)),
        1 => ("at infinity", Light::directional(direction)),
        2 => ("in the hull", Light::point(weighted(random, 5, 0.1))),
        3 => {
            // Doubled twice, which is exact for whole numbers.
            let (p, q, r) = (any(random), any(random), any(random));
            let point = [0, 1, 2].map(|axis| p[axis] + 2.0 * (q[axis] - p[axis]) - 2.0 * (r[axis] - p[axis]));
            ("in a plane of corners", Light::point(point))
        }
        4 => {
            let (p, q) = (any(random), any(random));
            ("on a line of corners", Light::point([0, 1, 2].map(|axis| 2.0 * q[axis] - p[axis])))
        }
        5 => ("at a corner", Light::point(any(random))),
        6 => {
            let (p, q) = (any(random), any(random));
            ("between two corners", Light::homogeneous([p[0] + q[0], p[1] + q[1], p[2] + q[2], 2.0]))
        }
        7 => {
            let (p, q) = (any(random), any(random));
            let towards = from(p, q);
            let towards = if towards == [0.0; 3] { [0.0, 0.0, 1.0] } else { towards };
            ("along an edge", Light::directional(towards))
        }
        8 => {
            let point = [0, 1, 2].map(|_| random.below(9) as f32 - 4.0);
            ("at whole numbers", Light::point(point))
        }
        9 => {
            let mut point = [0, 1, 2].map(|_| random.below(5) as f32 - 2.0);
            if point == [0.0; 3] {
                point[2] = 1.0;
            }
            ("at infinity, of whole numbers", Light::directional(point))
        }
        10 => {
            let [x, y, z] = far;
            ("with a weight", Light::homogeneous([x, y, z, random.between(0.2, 3.0)]))
        }
        _ => {
            let [x, y, z] = far;
            ("with a negative weight", Light::homogeneous([x, y, z, random.between(-3.0, -0.2)]))
        }
    }
}
