//! Faces hidden by faces: how many, what that leaves of the sides of shadow volumes, and how long the search takes.
//!
//! The first scenes are like those of Batagelo and Costa Júnior (1999), each with ten lights.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::time::Instant;

use rimline::cpu::{self, HiddenCaster, HiddenFaces, HiddenOptions, Threads};
use rimline::mesh::Weld;
use rimline::{Light, Mesh, Predicate};
use rimline_measure::random::Random;
use rimline_measure::shapes::{self, Shape};

type Caster = (Vec<[f32; 3]>, Mesh);

fn placed(shape: &Shape, scale: [f32; 3], at: [f32; 3]) -> Caster {
    let place = |p: &[f32; 3]| std::array::from_fn(|axis| p[axis] * scale[axis] + at[axis]);
    let positions: Vec<[f32; 3]> = shape.positions.iter().map(place).collect();
    let mesh = Mesh::new(&positions, &shape.faces, Weld::Position).expect("a mesh");
    (positions, mesh)
}

fn tetrahedron() -> Shape {
    let positions = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]] }
}

fn wall() -> Shape {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3]] }
}

/// `count` bodies at random places on the ground, z up.
fn strewn(seed: u64, count: usize, far: f32, shape: &Shape, scale: impl Fn(&mut Random) -> [f32; 3]) -> Vec<Caster> {
    let mut random = Random::new(seed);
    let body = |_| {
        let scale = scale(&mut random);
        placed(shape, scale, [random.between(-far, far), random.between(-far, far), scale[2]])
    };
    (0..count).map(body).collect()
}

/// The tetrahedra, and a wall over or under them.
fn tetrahedra(height: f32) -> Vec<Caster> {
    let mut casters = strewn(7, 187, 10.0, &tetrahedron(), |_| [0.5; 3]);
    casters.push(placed(&wall(), [14.0, 14.0, 1.0], [0.0, 0.0, height]));
    casters
}

/// The sum of the multiplicities of edges, over all casters, and three times the faces.
fn sides(casters: &[Caster], light: Light, hidden: Option<&HiddenFaces>) -> [usize; 2] {
    let (mut sides, mut plain) = (0, 0);
    for (number, (positions, mesh)) in casters.iter().enumerate() {
        let facing = cpu::extract(positions, mesh, &[light], Predicate::Exact, Threads::ONE).expect("a light").facing;
        let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
        for (face, (&[a, b, c], mask)) in (0_u32..).zip(mesh.faces().iter().zip(facing)) {
            let is_hidden = hidden.is_some_and(|hidden| hidden.faces(number).binary_search(&face).is_ok());
            if is_hidden || (mesh.is_closed() && mask & 1 != 0) {
                continue;
            }
            plain += 3;
            let sign = if mask & 1 != 0 { 1 } else { -1 };
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let (edge, sign) = if from < to { ([from, to], sign) } else { ([to, from], -sign) };
                *edges.entry(edge).or_default() += sign;
            }
        }
        sides += edges.values().map(|times| times.unsigned_abs() as usize).sum::<usize>();
    }
    [plain, sides]
}

fn show(name: &str, casters: &[Caster], lights: &[Light]) {
    let all: Vec<HiddenCaster<'_>> =
        casters.iter().map(|(positions, mesh)| HiddenCaster { mesh, positions, version: None }).collect();
    let faces: usize = casters.iter().map(|(_, mesh)| mesh.faces().len()).sum();
    let (mut plain, mut outline, mut left, mut hidden, mut undecided, mut nodes, mut time) = (0, 0, 0, 0, 0, 0, 0.0);
    for &light in lights {
        let start = Instant::now();
        let found = HiddenFaces::find(light, &all, HiddenOptions::default(), |_, _| ControlFlow::Continue(()));
        let found = found.expect("found");
        time += start.elapsed().as_secs_f64();
        let [polygons, edges] = sides(casters, light, None);
        let statistics = found.statistics();
        (plain, outline, left) = (plain + polygons, outline + edges, left + sides(casters, light, Some(&found))[1]);
        (hidden, undecided) = (hidden + statistics.hidden, undecided + statistics.undecided);
        nodes += statistics.nodes;
    }
    let mean = |sum: usize| sum / lights.len();
    let [plain, outline, left, hidden, undecided, nodes] = [plain, outline, left, hidden, undecided, nodes].map(mean);
    let time = 1e3 * time / lights.len() as f64;
    println!("| {name} | {faces} | {hidden} | {undecided} | {plain} | {outline} | {left} | {nodes} | {time:.1} |");
}

fn main() {
    println!(
        "| scene | faces | hidden | undecided | sides, plain | silhouettes | and hidden faces | nodes | search, ms |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut random = Random::new(1);
    let ten: Vec<Light> =
        (0..10).map(|_| Light::point([random.between(-9.0, 9.0), random.between(-9.0, 9.0), 20.0])).collect();
    show("sphere", &[placed(&shapes::sphere(6), [2.0; 3], [0.0; 3])], &ten);
    show("tetrahedra, wall below", &tetrahedra(-3.0), &ten);
    show("tetrahedra, wall above", &tetrahedra(3.0), &ten);
    show("cubes", &strewn(5, 125, 10.0, &shapes::cube(), |_| [0.5; 3]), &ten);
    let low = [Light::directional([1.0, 0.4, 0.5])];
    for count in [520, 2083, 8333] {
        let far = 5.0 * (count as f32).sqrt();
        let city = strewn(3, count, far, &shapes::cube(), |random| [3.0, 3.0, random.between(2.0, 30.0)]);
        show("city", &city, &low);
    }
    let tree = shapes::sphere(6);
    show(
        "forest",
        &strewn(4, 100_000 / tree.faces.len(), 60.0, &tree, |random| [1.0, 1.0, random.between(1.0, 6.0)]),
        &low,
    );
    let mut building = strewn(6, 8330, 40.0, &shapes::cube(), |_| [0.4, 0.4, 1.0]);
    building.push(placed(&wall(), [50.0, 50.0, 1.0], [0.0, 0.0, 4.0]));
    show("building", &building, &[Light::directional([0.1, 0.2, 1.0])]);
}
