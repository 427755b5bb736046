//! Polygons occlude and are occluded as a whole, if they are exactly planar and convex.

use rimline::Light;
use rimline::mesh::Weld;
use rimline_testkit::polygons::{PolygonSet, quad_box, quad_torus, random_polygon};
use rimline_testkit::random::Random;

use crate::occluded_faces::{all_left_out, check_found, find, triangles};
use crate::static_scenes::{Caster, StaticScene};

fn placed(mut set: PolygonSet, size: f32, at: [f32; 3]) -> Caster {
    for point in &mut set.positions {
        *point = std::array::from_fn(|axis| size * point[axis] + at[axis]);
    }
    Caster { mesh: set.mesh(Weld::Position).expect("a mesh"), positions: set.positions }
}

fn wall(sides: usize, size: f32, height: f32) -> Caster {
    let corner = |turn: usize| {
        // Whole numbers, so that all are in one plane.
        let (sine, cosine) = (turn as f32 * std::f32::consts::TAU / sides as f32).sin_cos();
        [(64.0 * cosine).round(), (64.0 * sine).round(), 0.0]
    };
    let mut set = PolygonSet::default();
    set.push_points(&[(0..sides).map(corner).collect()]);
    placed(set, size / 64.0, [0.0, 0.0, height])
}

#[test]
fn polygons_under_a_wall_are_occluded_as_a_whole() {
    let (mut all, mut refuted, mut bumped) = (0, 0, 0);
    for seed in 7000..7100 {
        let mut random = Random::new(seed);
        let (sides, size) = (3 + random.below(9), random.between(1.0, 4.0));
        let mut casters = vec![wall(sides, size, 3.0)];
        for _ in 0..4 {
            let at = [random.between(-3.0, 3.0), random.between(-3.0, 3.0), random.between(-3.0, 2.0)].map(f32::round);
            casters.push(match random.below(4) {
                0 => placed(quad_box(1 + random.below(2) as u32), 1.0, at),
                1 => wall(3 + random.below(5), 1.0, at[2]),
                2 => placed(quad_torus(&mut random, 4, 4, 0.1), 1.0, at),
                _ => placed(random_polygon(&mut random, 7).1, 1.0, at),
            });
        }
        let scene = StaticScene { casters, light: Light::point([random.between(-1.0, 1.0), 0.5, 9.0]) };
        let [count, is_refuted] = check_found(&scene, &find(&scene, all_left_out()), &mut random)
            .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        (all, refuted) = (all + count, refuted + is_refuted);
        let bumps = |caster: &Caster| (0..caster.mesh.face_count()).filter(|&face| !triangles(caster, face).1).count();
        bumped += scene.casters.iter().map(bumps).sum::<usize>();
    }
    println!("{all} occluded polygons, {bumped} that are not planar; {refuted} wrong ones refuted");
    assert!(all > 200 && bumped > 100 && refuted > 30);
}

#[test]
fn a_polygon_that_is_occluded_in_part_stays() {
    for sides in [3, 4, 6, 11] {
        let under = |occluder| {
            let casters = vec![occluder, wall(sides, 1.0, 0.0)];
            find(&StaticScene { casters, light: Light::point([0.0, 0.0, 10.0]) }, all_left_out())
        };
        let found = under(wall(4, 4.0, 5.0));
        assert_eq!([found.faces(0), found.faces(1)], [&[][..], &[0]], "{sides}");
        let statistics = found.statistics();
        assert_eq!([statistics.tried, statistics.occluded, statistics.left_out], [2, 1, 1], "{sides}");
        // An occluder of one half leaves triangles of the fan occluded, and the polygon whole.
        let mut half = PolygonSet::default();
        half.push_points(&[vec![[0.0, -4.0, 5.0], [4.0, -4.0, 5.0], [4.0, 4.0, 5.0], [0.0, 4.0, 5.0]]]);
        assert!(under(placed(half, 1.0, [0.0; 3])).faces(1).is_empty(), "{sides}");
    }
}
