//! The scenes: those of the paper by code, and larger ones.

use rimline::{Light, Mesh};
use rimline_bench::random::Random;
use rimline_bench::record::{Camera, IDENTITY, Setting as Recorded};
use rimline_bench::shapes::{self, Shape};

pub(crate) struct Setting {
    pub(crate) name: &'static str,
    /// In world space, Z up, each with its mesh.
    pub(crate) bodies: Vec<(Shape, Mesh)>,
    pub(crate) lights: Vec<Light>,
    eye: [f32; 3],
    target: [f32; 3],
    /// The height of the ground, which receives shadows.
    ground: f32,
}

impl Setting {
    /// Casters of the setting as they are recorded, with Y up.
    pub(crate) fn recorded(&self, shapes: Vec<Shape>, light: Light) -> Recorded {
        let upright = |[x, y, z]: [f32; 3]| [x, z, -y];
        let placed = (0..shapes.len()).map(|shape| (shape, IDENTITY)).collect();
        let shapes = shapes.into_iter().map(|shape| shape.placed(upright)).collect();
        let [eye, target] = [self.eye, self.target].map(|point| glam::Vec3::from(upright(point)));
        let camera = Camera::level(eye, target - eye, 2.0, 0.5);
        let light = Light { xyz: upright(light.xyz), ..light };
        Recorded { ground: Some(self.ground), ..Recorded::rigid(shapes, placed, vec![light], &camera) }
    }
}

fn placed(shape: &Shape, scale: [f32; 3], at: [f32; 3]) -> Shape {
    shape.clone().placed(|p| std::array::from_fn(|axis| p[axis] * scale[axis] + at[axis]))
}

fn with_meshes(bodies: Vec<Shape>) -> Vec<(Shape, Mesh)> {
    let with_mesh = |shape: Shape| {
        let mesh = shape.mesh().expect("a mesh");
        (shape, mesh)
    };
    bodies.into_iter().map(with_mesh).collect()
}

fn tetrahedron() -> Shape {
    let positions = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]] }
}

fn icosahedron() -> Shape {
    let g = 0.5 * (1.0 + 5.0_f32.sqrt());
    let corners = [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)].map(|(a, b)| [[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    let mut shape = Shape { positions: corners.concat(), faces: Vec::new() };
    for (a, b, c) in (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| (a, b, c)))) {
        let [u, v, w] = [a, b, c].map(|vertex| glam::Vec3::from(shape.positions[vertex as usize]));
        if [(u, v), (v, w), (w, u)].iter().all(|(from, to)| from.distance_squared(*to) < 4.5) {
            let is_outward = (v - u).cross(w - u).dot(u) > 0.0;
            shape.faces.push(if is_outward { [a, b, c] } else { [a, c, b] });
        }
    }
    shape
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
fn strewn(seed: u64, count: usize, far: f32, shape: &Shape, scale: impl Fn(&mut Random) -> [f32; 3]) -> Vec<Shape> {
    let mut random = Random::new(seed);
    let body = |_| {
        let scale = scale(&mut random);
        placed(shape, scale, [random.between(-far, far), random.between(-far, far), scale[2]])
    };
    (0..count).map(body).collect()
}

/// The paper's scenes have 256, 96, 752, 752 and 1,502 polygons, and ten lights each.
pub(crate) fn of_the_paper() -> Vec<Setting> {
    let mut random = Random::new(1);
    let lights: Vec<Light> =
        (0..10).map(|_| Light::point([random.between(-9.0, 9.0), random.between(-9.0, 9.0), 20.0])).collect();
    let tetrahedra = |height: f32| {
        let mut bodies = strewn(7, 187, 10.0, &tetrahedron(), |_| [0.5; 3]);
        bodies.push(placed(&base(), [14.0, 14.0, 1.0], [0.0, 0.0, height]));
        bodies
    };
    let kinds = [(shapes::cube(), 2), (tetrahedron(), 2), (shapes::sphere(1), 3), (icosahedron(), 2)];
    let solids = kinds.iter().flat_map(|(shape, count)| std::iter::repeat_n(shape, *count)).enumerate();
    let solids = solids.map(|(number, shape)| {
        placed(shape, [1.0; 3], [6.0 * (number % 3) as f32 - 6.0, 6.0 * (number / 3) as f32 - 6.0, 2.0])
    });
    let cube = shapes::cube();
    let cubes = (0..125).map(|number| {
        let at = [number % 5, number / 5 % 5, number / 25].map(|step| 2.0 * step as f32);
        placed(&cube, [0.5; 3], [at[0] - 4.0, at[1] - 4.0, at[2] + 1.0])
    });
    let all = [
        ("sphere", vec![placed(&shapes::globe(16, 9), [3.0; 3], [0.0, 0.0, 3.0])]),
        ("solids", solids.collect()),
        ("tetrahedra 1", tetrahedra(-3.0)),
        ("tetrahedra 2", tetrahedra(4.0)),
        ("cubes", cubes.chain([placed(&wall(), [14.0, 14.0, 1.0], [0.0, 0.0, -3.0])]).collect()),
    ];
    let (eye, target, ground) = ([6.0, -26.0, 11.0], [0.0, 0.0, -1.0], -5.0);
    let setting =
        |(name, bodies)| Setting { name, bodies: with_meshes(bodies), lights: lights.clone(), eye, target, ground };
    all.into_iter().map(setting).collect()
}

/// A large scene on the ground, that reaches so far, in the light of a direction, from a height.
fn large(name: &'static str, bodies: Vec<Shape>, light: [f32; 3], [far, height, aim]: [f32; 3]) -> Setting {
    let (eye, target) = ([-far, -1.2 * far, height], [0.0, 0.0, aim]);
    let lights = vec![Light::directional(light)];
    Setting { name, bodies: with_meshes(bodies), lights, eye, target, ground: 0.0 }
}

/// Boxes of 12 faces, so many faces in all.
pub(crate) fn city(faces: usize) -> Setting {
    let count = faces / 12;
    let far = 5.0 * (count as f32).sqrt();
    let boxes = strewn(3, count, far, &shapes::cube(), |random| [3.0, 3.0, random.between(2.0, 30.0)]);
    large("city", boxes, [1.0, 0.4, 0.5], [far, 90.0, 0.0])
}

pub(crate) fn forest(faces: usize) -> Setting {
    let tree = shapes::sphere(6);
    let count = faces / tree.faces.len();
    let far = 60.0 * (faces as f32 / 1e5).sqrt();
    let trees = strewn(4, count, far, &tree, |random| [1.0, 1.0, random.between(1.0, 6.0)]);
    large("forest", trees, [1.0, 0.4, 0.5], [far, 20.0, 0.0])
}

/// Boxes under a roof that all of the light comes from.
pub(crate) fn building(faces: usize) -> Setting {
    let far = 40.0 * (faces as f32 / 1e5).sqrt();
    let mut bodies = strewn(6, faces.saturating_sub(2) / 12, far, &shapes::cube(), |_| [0.4, 0.4, 1.0]);
    bodies.push(placed(&wall(), [far + 10.0, far + 10.0, 1.0], [0.0, 0.0, 4.0]));
    large("building", bodies, [0.1, 0.2, 1.0], [far, 2.5, 1.0])
}
