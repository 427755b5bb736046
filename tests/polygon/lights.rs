//! Lights that are hard on a polygon.

use rimline::Light;
use rimline_testkit::random::Random;

/// A light with its name, now and then without an extent: anywhere, in the hull, in planes and on lines through corners, at corners, at infinity.
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
    let [x, y, z] = direction.map(|c| c * random.between(0.5, 9.0));
    let far = |w: f32| Light::homogeneous([x, y, z, w]);
    match random.below(12) {
        0 => ("near or far", far(1.0)),
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
            ("along an edge", Light::directional([0, 1, 2].map(|axis| q[axis] - p[axis])))
        }
        8 => ("at whole numbers", Light::point([0; 3].map(|_| random.below(9) as f32 - 4.0))),
        9 => {
            let towards = [0; 3].map(|_| random.below(5) as f32 - 2.0);
            ("at infinity, of whole numbers", Light::directional(towards))
        }
        10 => ("with a weight", far(random.between(0.2, 3.0))),
        _ => ("with a negative weight", far(random.between(-3.0, -0.2))),
    }
}

/// So many of these lights.
pub(crate) fn lights_for(random: &mut Random, corners: &[[f32; 3]], count: usize) -> Vec<Light> {
    let any = std::iter::repeat_with(|| light_for(random, corners).1);
    any.filter(|light| light.to_array() != [0.0; 4]).take(count).collect()
}
