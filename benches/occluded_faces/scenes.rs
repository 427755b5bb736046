//! The scenes: those of the paper by code, and larger ones.

use std::rc::Rc;

use rimline::mesh::Weld;
use rimline::{Light, Mesh};
use rimline_bench::random::Random;
use rimline_bench::record::{Camera, IDENTITY, Setting as Recorded};
use rimline_bench::shapes::{self, Shape};

/// A body in world space. Bodies of one shape share their mesh.
#[derive(Clone)]
pub(crate) struct Body {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) mesh: Rc<Mesh>,
}

pub(crate) struct Setting {
    pub(crate) name: &'static str,
    pub(crate) bodies: Vec<Body>,
    pub(crate) lights: Vec<Light>,
    pub(crate) eye: [f32; 3],
    pub(crate) target: [f32; 3],
    /// The height of the ground, which receives shadows. Z is up.
    pub(crate) ground: f32,
}

impl Setting {
    /// Casters of the setting as they are recorded, with Y up.
    pub(crate) fn recorded(&self, mut shapes: Vec<Shape>, light: Light) -> Recorded {
        let upright = |[x, y, z]: [f32; 3]| [x, z, -y];
        for position in shapes.iter_mut().flat_map(|shape| &mut shape.positions) {
            *position = upright(*position);
        }
        let placed = (0..shapes.len()).map(|shape| (shape, IDENTITY)).collect();
        let [eye, target] = [self.eye, self.target].map(|point| glam::Vec3::from(upright(point)));
        let camera = Camera::level(eye, target - eye, 2.0, 0.5);
        let light = Light { xyz: upright(light.xyz), ..light };
        Recorded { ground: Some(self.ground), ..Recorded::rigid(shapes, placed, vec![light], &camera) }
    }
}

/// A shape with its mesh.
struct Kind {
    shape: Shape,
    mesh: Rc<Mesh>,
}

impl Kind {
    fn new(shape: Shape) -> Self {
        let mesh = Rc::new(Mesh::new(&shape.positions, &shape.faces, Weld::Position).expect("a mesh"));
        Self { shape, mesh }
    }

    fn placed(&self, scale: [f32; 3], at: [f32; 3]) -> Body {
        let transform = |p: &[f32; 3]| std::array::from_fn(|axis| p[axis] * scale[axis] + at[axis]);
        Body { positions: self.shape.positions.iter().map(transform).collect(), mesh: Rc::clone(&self.mesh) }
    }
}

fn tetrahedron() -> Shape {
    let positions = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]] }
}

fn icosahedron() -> Shape {
    let g = 0.5 * (1.0 + 5.0_f32.sqrt());
    let mut positions = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        positions.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    }
    let distance = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f32>();
    let is_edge = |a: usize, b: usize| distance(&positions[a], &positions[b]) < 4.5;
    let mut faces = Vec::new();
    for (a, b, c) in (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| (a, b, c)))) {
        if is_edge(a, b) && is_edge(b, c) && is_edge(a, c) {
            let [u, v, w] = [a, b, c].map(|vertex| glam::Vec3::from(positions[vertex]));
            let is_outward = (v - u).cross(w - u).dot(u) > 0.0;
            faces.push(if is_outward { [a, b, c] } else { [a, c, b] }.map(|vertex| vertex as u32));
        }
    }
    Shape { positions, faces }
}

/// A sphere of 16 slices in 9 stacks: 256 faces.
fn sphere_256() -> Shape {
    let (slices, stacks) = (16_u32, 9_u32);
    let mut positions = vec![[0.0, 0.0, 1.0]];
    for stack in 1..stacks {
        let (sine, cosine) = shapes::turn(stack, 2 * stacks);
        for slice in 0..slices {
            let (y, x) = shapes::turn(slice, slices);
            positions.push([sine * x, sine * y, cosine]);
        }
    }
    positions.push([0.0, 0.0, -1.0]);
    let last = positions.len() as u32 - 1;
    let at = |stack: u32, slice: u32| match stack {
        0 => 0,
        stack if stack == stacks => last,
        stack => 1 + (stack - 1) * slices + slice % slices,
    };
    let mut faces = Vec::new();
    for (stack, slice) in (0..stacks).flat_map(|stack| (0..slices).map(move |slice| (stack, slice))) {
        let [a, b, c, d] = [at(stack, slice), at(stack + 1, slice), at(stack + 1, slice + 1), at(stack, slice + 1)];
        faces.extend([[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
    }
    Shape { positions, faces }
}

/// A square of four faces around its middle.
fn base() -> Shape {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
    Shape { positions, faces: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]] }
}

fn wall() -> Shape {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3]] }
}

/// `count` bodies at random places on the ground.
fn strewn(seed: u64, count: usize, far: f32, shape: Shape, scale: impl Fn(&mut Random) -> [f32; 3]) -> Vec<Body> {
    let (mut random, kind) = (Random::new(seed), Kind::new(shape));
    let body = |_| {
        let scale = scale(&mut random);
        kind.placed(scale, [random.between(-far, far), random.between(-far, far), scale[2]])
    };
    (0..count).map(body).collect()
}

/// The paper's scenes have 256, 96, 752, 752 and 1,502 polygons, and ten lights each.
pub(crate) fn of_the_paper() -> Vec<Setting> {
    let mut random = Random::new(1);
    let lights: Vec<Light> =
        (0..10).map(|_| Light::point([random.between(-9.0, 9.0), random.between(-9.0, 9.0), 20.0])).collect();
    let tetrahedra = |height: f32| {
        let mut bodies = strewn(7, 187, 10.0, tetrahedron(), |_| [0.5; 3]);
        bodies.push(Kind::new(base()).placed([14.0, 14.0, 1.0], [0.0, 0.0, height]));
        bodies
    };
    let mut solids = Vec::new();
    let kinds = [(shapes::cube(), 2), (tetrahedron(), 2), (shapes::sphere(1), 3), (icosahedron(), 2)];
    for (shape, count) in kinds {
        let kind = Kind::new(shape);
        for _ in 0..count {
            let number = solids.len();
            solids.push(kind.placed([1.0; 3], [6.0 * (number % 3) as f32 - 6.0, 6.0 * (number / 3) as f32 - 6.0, 2.0]));
        }
    }
    let cube = Kind::new(shapes::cube());
    let mut cubes: Vec<Body> = (0..125)
        .map(|number| {
            let at = [number % 5, number / 5 % 5, number / 25].map(|step| 2.0 * step as f32);
            cube.placed([0.5; 3], [at[0] - 4.0, at[1] - 4.0, at[2] + 1.0])
        })
        .collect();
    cubes.push(Kind::new(wall()).placed([14.0, 14.0, 1.0], [0.0, 0.0, -3.0]));
    let all = [
        ("sphere", vec![Kind::new(sphere_256()).placed([3.0; 3], [0.0, 0.0, 3.0])]),
        ("solids", solids),
        ("tetrahedra 1", tetrahedra(-3.0)),
        ("tetrahedra 2", tetrahedra(4.0)),
        ("cubes", cubes),
    ];
    let setting = |(name, bodies)| Setting {
        name,
        bodies,
        lights: lights.clone(),
        eye: [6.0, -26.0, 11.0],
        target: [0.0, 0.0, -1.0],
        ground: -5.0,
    };
    all.into_iter().map(setting).collect()
}

/// Boxes of 12 faces, so many faces in all.
pub(crate) fn city(faces: usize) -> Setting {
    let count = faces / 12;
    let far = 5.0 * (count as f32).sqrt();
    Setting {
        name: "city",
        bodies: strewn(3, count, far, shapes::cube(), |random| [3.0, 3.0, random.between(2.0, 30.0)]),
        lights: vec![Light::directional([1.0, 0.4, 0.5])],
        eye: [-far, -1.2 * far, 90.0],
        target: [0.0, 0.0, 0.0],
        ground: 0.0,
    }
}

pub(crate) fn forest(faces: usize) -> Setting {
    let tree = shapes::sphere(6);
    let count = faces / tree.faces.len();
    let far = 60.0 * (faces as f32 / 1e5).sqrt();
    Setting {
        name: "forest",
        bodies: strewn(4, count, far, tree, |random| [1.0, 1.0, random.between(1.0, 6.0)]),
        lights: vec![Light::directional([1.0, 0.4, 0.5])],
        eye: [-far, -1.2 * far, 20.0],
        target: [0.0, 0.0, 0.0],
        ground: 0.0,
    }
}

/// Boxes under a roof that all of the light comes from.
pub(crate) fn building(faces: usize) -> Setting {
    let far = 40.0 * (faces as f32 / 1e5).sqrt();
    let mut bodies = strewn(6, faces.saturating_sub(2) / 12, far, shapes::cube(), |_| [0.4, 0.4, 1.0]);
    bodies.push(Kind::new(wall()).placed([far + 10.0, far + 10.0, 1.0], [0.0, 0.0, 4.0]));
    Setting {
        name: "building",
        bodies,
        lights: vec![Light::directional([0.1, 0.2, 1.0])],
        eye: [-far, -1.2 * far, 2.5],
        target: [0.0, 0.0, 1.0],
        ground: 0.0,
    }
}
