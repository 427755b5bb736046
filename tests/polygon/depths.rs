//! Occluder counts of polygons: the sets, points and lights of both tests.

use rimline::mesh::Weld;
use rimline::{Light, Mesh};
use rimline_testkit::polygons::{PolygonSet, random_polygon, random_set};
use rimline_testkit::random::Random;

use crate::lights::light_for;

/// A set of polygons with points and lights.
pub(crate) struct DepthCase {
    pub(crate) set: PolygonSet,
    pub(crate) mesh: Mesh,
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) lights: Vec<Light>,
}

impl DepthCase {
    pub(crate) fn new(random: &mut Random, set: PolygonSet, points: usize, lights: usize) -> Self {
        let mesh = set.mesh(Weld::Position).expect("a mesh");
        let any = std::iter::repeat_with(|| light_for(random, &set.positions).1);
        let is_allowed = |light: &Light| light.to_array() != [0.0; 4] && light.w >= 0.0;
        let lights: Vec<_> = any.filter(is_allowed).take(lights).collect();
        let points = (0..points).map(|at| point(random, &set, lights[at % lights.len()])).collect();
        Self { set, mesh, points, lights }
    }

    pub(crate) fn random(random: &mut Random) -> Self {
        let most = [6, 12, 40, 100][random.below(4)];
        let set = if random.below(3) == 0 { random_polygon(random, most).1 } else { random_set(random, most) };
        Self::new(random, set, 40, 6)
    }
}

/// At a corner, between corners, around them, and in line with a light and a point on an edge or diagonal.
fn point(random: &mut Random, set: &PolygonSet, light: Light) -> [f32; 3] {
    let any = |random: &mut Random| set.positions[random.below(set.positions.len())];
    let (p, q) = (any(random), any(random));
    let middle = [0, 1, 2].map(|axis| 0.5 * (p[axis] + q[axis]));
    match random.below(8) {
        0 => p,
        1 => middle,
        2 => [0, 1, 2].map(|axis| p[axis] + 3.0 * (q[axis] - p[axis])),
        3 => [0, 1, 2].map(|_| random.below(7) as f32 - 3.0),
        4 => random.direction().map(|c| c * random.between(0.0, 40.0)),
        5 | 6 => [0, 1, 2].map(|axis| middle[axis] + light.w * middle[axis] - light.xyz[axis]),
        _ => [0, 1, 2].map(|axis| p[axis] + random.between(-0.3, 0.3)),
    }
}
