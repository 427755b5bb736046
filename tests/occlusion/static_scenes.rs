//! Random static scenes: bodies and open sheets that overlap, lie in each other, touch, coincide, or occlude each other in a
//! circle.

use rimline::mesh::Weld;
use rimline::{Light, Mesh};
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};

#[derive(Clone)]
pub(crate) struct Caster {
    pub(crate) mesh: Mesh,
    pub(crate) positions: Vec<[f32; 3]>,
}

impl Caster {
    pub(crate) fn new(Shape { positions, faces }: Shape) -> Self {
        Self { mesh: Mesh::new(&positions, &faces, Weld::Position).expect("a mesh"), positions }
    }
}

pub(crate) struct StaticScene {
    pub(crate) casters: Vec<Caster>,
    pub(crate) light: Light,
}

/// Three blades, each before the next and behind the one before.
fn circle() -> Shape {
    let blade = |turn: usize| {
        let position = |x: f32, y: f32, z: f32| {
            let (sin, cos) = (turn as f32 * std::f32::consts::TAU / 3.0).sin_cos();
            [x * cos - y * sin, x * sin + y * cos, z]
        };
        [position(-2.0, -1.0, 0.5), position(2.0, -1.0, -0.5), position(0.0, 0.25, 0.0)]
    };
    let positions = (0..3).flat_map(blade).collect();
    Shape { positions, faces: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]] }
}

/// Loose faces with corners on whole numbers, so that many are coplanar.
fn soup(random: &mut Random) -> Shape {
    let count = 4 + random.below(16) as u32;
    let mut number = || random.below(7) as f32 - 3.0;
    let positions = (0..3 * count).map(|_| [(); 3].map(|()| number())).collect();
    Shape { positions, faces: (0..count).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect() }
}

fn shape(random: &mut Random) -> Shape {
    match random.below(8) {
        0 | 1 => shapes::cube(),
        2 => shapes::sphere(1),
        3 => shapes::torus(5, 4, 1.0, 0.5),
        4 => shapes::moebius(6, 1),
        5 => circle(),
        6 => soup(random),
        _ => shapes::square(),
    }
}

impl StaticScene {
    pub(crate) fn random(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let scale = [1.0, 1e-20, 1e20, 1e-3, 1e6][random.below(5)];
        let is_mixed = random.below(4) == 0;
        let mut casters: Vec<Caster> = Vec::new();
        for _ in 0..2 + random.below(4) {
            // Some lie where others are, with other bits or the same.
            if random.below(5) == 0 && !casters.is_empty() {
                casters.push(casters[random.below(casters.len())].clone());
                continue;
            }
            let shape = shape(&mut random);
            let size = scale * [0.5, 1.0, 2.0, 4.0][random.below(4)];
            let size = if is_mixed { size * 10.0_f32.powi(random.below(13) as i32 - 6) } else { size };
            let is_whole = random.below(2) == 0;
            let middle =
                [(); 3].map(|()| if is_whole { random.below(5) as f32 - 2.0 } else { random.between(-2.0, 2.0) });
            let is_turned = random.below(2) == 0;
            let position = |[x, y, z]: [f32; 3]| {
                let [x, y, z] = if is_turned { [z, x, y] } else { [x, y, z] };
                [x * size + middle[0] * scale, y * size + middle[1] * scale, z * size + middle[2] * scale]
            };
            let positions: Vec<[f32; 3]> = shape.positions.iter().map(|&at| position(at)).collect();
            let mut faces = shape.faces;
            if random.below(3) == 0 {
                for face in &mut faces {
                    face.swap(1, 2);
                }
            }
            casters.push(Caster::new(Shape { positions, faces }));
        }
        let mut number = |far: f32| {
            [(); 3].map(|()| if random.below(2) == 0 { random.between(-far, far) } else { (far / 2.0).round() })
        };
        let [near, far, huge] = [number(3.0), number(10.0), number(1000.0)];
        let light = match random.below(5) {
            0 => Light::point(near.map(|c| c * scale)),
            1 => Light::directional(if near == [0.0; 3] { [1.0, 0.0, 0.0] } else { near }),
            2 => Light::homogeneous([far[0] * scale * 0.25, far[1] * scale * 0.25, far[2] * scale * 0.25, 0.25]),
            3 => Light::point(huge.map(|c| c * scale)),
            _ => Light::point([far[0] * scale, 0.0, far[2] * scale]),
        };
        Self { casters, light }
    }
}
