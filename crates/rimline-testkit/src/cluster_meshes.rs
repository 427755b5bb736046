//! Meshes and lights that clusters may get wrong.

use crate::any_finite;
use crate::clusters::whole;
use crate::random::Random;
use crate::shapes::{self, Shape};
use rimline::Light;
use rimline::internals::clusters::{ClusterBound, Clusters};
use rimline::internals::cpu::Threads;

/// A mesh, and lights for it.
pub struct Case {
    pub name: &'static str,
    pub shape: Shape,
    pub lights: Vec<Light>,
}

/// A family of meshes.
type Family = (&'static str, fn(&mut Random) -> Shape);

const FAMILIES: [Family; 10] = [
    ("smooth", smooth),
    ("smooth, far from the origin", |random| moved(random, smooth)),
    ("smooth, of any size", |random| scaled(random, smooth)),
    ("flat", flat),
    ("nearly flat", |random| nudged(random, flat)),
    ("nearly flat, far from the origin", |random| moved(random, flat)),
    ("flat, of any size", |random| scaled(random, flat)),
    ("random faces", soup),
    ("with vertices that are not finite", |random| spoilt(random, true)),
    ("with degenerate faces", |random| spoilt(random, false)),
];

/// Case `index`: all families come in turn.
pub fn case(random: &mut Random, index: usize) -> Case {
    let (name, make) = FAMILIES[index % FAMILIES.len()];
    let mut shape = make(random);
    if random.below(2) == 0 {
        shape = shape.shuffled(random.next_u64());
    }
    let lights = lights(random, &shape);
    Case { name, shape, lights }
}

/// Lights that clusters of the case are only just decided for: moved from decided to mixed by bisection.
pub fn marginal_lights(random: &mut Random, case: &Case) -> Result<Vec<Light>, String> {
    let mesh = case.shape.mesh().map_err(|error| error.to_string())?;
    let found = Clusters::new(&mesh, &case.shape.positions, Threads::ONE);
    let pick = |random: &mut Random| case.lights[random.below(case.lights.len())].to_array();
    let is_mixed = |bound: &ClusterBound, light: [f32; 4]| whole(bound, Light::homogeneous(light)).is_none();
    let mut marginal = Vec::new();
    for _ in 0..6 {
        let bound = &found.bounds()[random.below(found.bounds().len())];
        let (mut near, mut far) = (pick(random), pick(random));
        if is_mixed(bound, near) || !is_mixed(bound, far) {
            continue;
        }
        for _ in 0..40 {
            let middle: [f32; 4] = std::array::from_fn(|i| 0.5 * near[i] + 0.5 * far[i]);
            if middle == [0.0; 4] {
                break;
            }
            *if is_mixed(bound, middle) { &mut far } else { &mut near } = middle;
        }
        marginal.push(Light::homogeneous(near));
    }
    Ok(marginal)
}

fn smooth(random: &mut Random) -> Shape {
    let size = 4 + random.below(5) as u32;
    match random.below(4) {
        0 => shapes::sphere(size),
        1 => shapes::torus(2 * size, 2 * size, 1.0, 0.4),
        2 => shapes::blob(size, random.between(0.0, 0.5), random.next_u64() as u32),
        // Thin in one direction.
        _ => {
            let thin = random.between(-20.0, 0.0).exp2();
            shapes::sphere(size).placed(|[x, y, z]| [x, y * thin, z])
        }
    }
}

/// A tilted plane of whole numbers. A part of it may be wound the other way.
fn flat(random: &mut Random) -> Shape {
    let mut slope = || random.below(7) as f32 - 3.0;
    let [p, q, r] = [slope(), slope(), slope()];
    let lattice = |position: [f32; 3]| {
        let [x, y, z] = position.map(|c| (c * 12.0).round());
        [x, y + p * x + q * z + r, z]
    };
    let mut shape = shapes::plane_grid(6 + random.below(10) as u32, 12).placed(lattice);
    let axis = random.below(3);
    shape.positions.iter_mut().for_each(|position| position.rotate_left(axis));
    if random.below(2) == 0 {
        shape.faces.iter_mut().step_by(2).for_each(|face| face.swap(0, 1));
    }
    shape
}

fn nudged(random: &mut Random, make: fn(&mut Random) -> Shape) -> Shape {
    let mut shape = make(random);
    for position in &mut shape.positions {
        let coordinate = &mut position[random.below(3)];
        *coordinate = [*coordinate, coordinate.next_up(), coordinate.next_down()][random.below(3)];
    }
    shape
}

fn moved(random: &mut Random, make: fn(&mut Random) -> Shape) -> Shape {
    let shape = make(random);
    let by = random.direction().map(|c| c * [1e2, 1e4, 1e6, 1e30][random.below(4)]);
    shape.placed(|position| std::array::from_fn(|axis| position[axis] + by[axis]))
}

fn scaled(random: &mut Random, make: fn(&mut Random) -> Shape) -> Shape {
    let shape = make(random);
    // To numbers that are subnormal, and to the largest.
    let by = random.between(-148.0, 123.0).floor().exp2();
    shape.placed(|position| position.map(|c| c * by))
}

fn soup(random: &mut Random) -> Shape {
    let count = 40 + random.below(200);
    let positions: Vec<_> = (0..count).map(|_| random.direction()).collect();
    let faces = (0..2 * count).map(|_| [(); 3].map(|()| random.below(count) as u32)).collect();
    Shape { positions, faces }
}

/// A mesh with a few bad faces: so few that most clusters have none, or so many that all of some clusters are bad.
fn spoilt(random: &mut Random, with_infinities: bool) -> Shape {
    let mut shape = if random.below(2) == 0 { smooth(random) } else { flat(random) };
    let (vertices, faces) = (shape.positions.len(), shape.faces.len());
    for _ in 0..[2, 60, 400][random.below(3)] {
        let face = shape.faces[random.below(faces)];
        match random.below(4) {
            0 if with_infinities => {
                let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX][random.below(4)];
                shape.positions[random.below(vertices)][random.below(3)] = bad;
            }
            1 => shape.positions[face[0] as usize] = shape.positions[face[1] as usize],
            2 => shape.faces.push([face[0], face[0], face[1]]),
            _ => shape.faces.push([face[2]; 3]),
        }
    }
    shape
}

fn lights(random: &mut Random, shape: &Shape) -> Vec<Light> {
    let is_light = |light: &Light| {
        let components = light.to_array();
        components != [0.0; 4] && components.iter().all(|c| c.is_finite())
    };
    let mut tries = (0..140).map(|index| light(random, shape, index)).filter(is_light);
    let mut lights: Vec<Light> = tries.by_ref().take(14).collect();
    lights.push(Light::point([3.0, 4.0, 5.0]));
    lights
}

fn light(random: &mut Random, shape: &Shape, index: usize) -> Light {
    let corners = shape.faces[random.below(shape.faces.len())].map(|vertex| shape.positions[vertex as usize]);
    let corners = if corners.iter().flatten().all(|c| c.is_finite()) { corners } else { shape_corners(shape) };
    let [a, b, c] = corners;
    let [s, t] = [0; 2].map(|_| random.below(9) as f32 - 4.0);
    // In the plane of a face: exactly, where positions are small whole numbers.
    let along: [f32; 3] = std::array::from_fn(|i| s * (b[i] - a[i]) + t * (c[i] - a[i]));
    let point: [f32; 3] = std::array::from_fn(|i| a[i] + along[i]);
    let off = random.direction().map(|c| c * random.between(-20.0, 4.0).exp2());
    let size = (0..3).fold(0.0_f32, |size, i| size.max((b[i] - a[i]).abs()));
    let w = [1.0, 3.0, -1.0, -0.7, 1e-30, 1e30, random.between(0.1, 2.0)][random.below(7)];
    let homogeneous = |[x, y, z]: [f32; 3]| Light::homogeneous([x * w, y * w, z * w, w]);
    match index % 7 {
        0 => homogeneous(a),
        1 => homogeneous(point),
        2 => Light::directional(along),
        3 => homogeneous(std::array::from_fn(|i| point[i] + size * off[i])),
        4 => Light::directional(std::array::from_fn(|i| along[i] + size * off[i])),
        5 => homogeneous(random.direction().map(|c| c * random.between(-3.0, 8.0).exp2())),
        _ => {
            let [x, y, z] = [(); 3].map(|()| any_finite(random));
            Light::homogeneous([x, y, z, [0.0, 1.0, any_finite(random)][random.below(3)]])
        }
    }
}

/// Finite corners.
fn shape_corners(shape: &Shape) -> [[f32; 3]; 3] {
    let mut finite = shape.positions.iter().filter(|position| position.iter().all(|c| c.is_finite()));
    [(); 3].map(|()| finite.next().copied().unwrap_or_default())
}
