//! Polygons hide and are occluded as a whole, if they are exactly planar and convex.

use std::ops::ControlFlow;

use rimline::cpu::{OccludedFaces, OcclusionCaster, OcclusionOptions};
use rimline::mesh::Weld;
use rimline::{Light, Mesh};
use rimline_testkit::oracle::ExactFace;
use rimline_testkit::polygons::{PolygonSet, quad_box, quad_torus, random_polygon};
use rimline_testkit::random::Random;

use crate::oracle::{Point, between, corner, hides, light, sign};

struct Caster {
    mesh: Mesh,
    positions: Vec<[f32; 3]>,
}

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

fn find(casters: &[Caster], light: Light) -> OccludedFaces {
    let searched: Vec<OcclusionCaster<'_>> = casters
        .iter()
        .map(|caster| OcclusionCaster { mesh: &caster.mesh, positions: &caster.positions, version: None })
        .collect();
    let options = OcclusionOptions { leave_out_all: true, ..OcclusionOptions::default() };
    OccludedFaces::find(light, &searched, options, |_, _| ControlFlow::Continue(())).expect("found")
}

/// The triangles of a face. A mesh of nothing but triangles has no polygons.
fn triangles(caster: &Caster, face: usize) -> &[[u32; 3]] {
    let range = caster.mesh.polygons().map_or(face..face + 1, |polygons| polygons.triangles(face));
    &caster.mesh.faces()[range]
}

/// Whether all corners lie in one plane, by the oracle's integers.
fn is_planar(caster: &Caster, polygon: usize) -> bool {
    let all: Vec<[Point; 3]> =
        triangles(caster, polygon).iter().map(|face| face.map(|v| corner(caster.positions[v as usize]))).collect();
    let Some([a, b, c]) = all.first() else { return true };
    all.iter().flatten().all(|point| sign([a, b, c, point]) == 0)
}

/// Asks for each occluded polygon whether points in its triangles are occluded by planar polygons that stay.
fn check(casters: &[Caster], from: Light, occluded: &[Vec<u32>], random: &mut Random) -> Result<usize, String> {
    let at = light(from);
    let (mut hiders, mut occluded_ones) = (Vec::new(), Vec::new());
    for (number, caster) in casters.iter().enumerate() {
        for polygon in 0..caster.mesh.face_count() {
            let is_occluded = occluded[number].contains(&(polygon as u32));
            if is_occluded && !is_planar(caster, polygon) {
                return Err(format!("caster {number}, polygon {polygon} is occluded and not planar"));
            }
            for &face in triangles(caster, polygon) {
                let corners = face.map(|vertex| corner(caster.positions[vertex as usize]));
                let faces_light = ExactFace::new(&caster.positions, face).is_some_and(|face| face.sign(from) > 0);
                if is_occluded {
                    occluded_ones.push((number, polygon, corners));
                } else if is_planar(caster, polygon) && !(caster.mesh.is_closed() && faces_light) {
                    hiders.push(corners);
                }
            }
        }
    }
    for (number, polygon, corners) in &occluded_ones {
        let mut weights = vec![[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1]];
        weights.extend((0..3).map(|_| [(); 3].map(|()| 1 + random.below(1 << 20) as u32)));
        for weights in weights {
            let point = between(corners, weights);
            if !hiders.iter().any(|hider| hides(hider, &at, &point)) {
                return Err(format!("caster {number}, polygon {polygon}: the point {weights:?} is not occluded"));
            }
        }
    }
    Ok(occluded.iter().map(Vec::len).sum())
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
        let light = Light::point([random.between(-1.0, 1.0), 0.5, 9.0]);
        let found = find(&casters, light);
        let mut occluded: Vec<Vec<u32>> = (0..casters.len()).map(|number| found.faces(number).to_vec()).collect();
        let count =
            check(&casters, light, &occluded, &mut random).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert_eq!(count, found.statistics().occluded, "seed {seed}");
        all += count;
        bumped += casters
            .iter()
            .map(|casters| (0..casters.mesh.face_count()).filter(|&face| !is_planar(casters, face)).count())
            .sum::<usize>();
        let number = random.below(casters.len());
        let face = random.below(casters[number].mesh.face_count()) as u32;
        if !occluded[number].contains(&face) {
            occluded[number].push(face);
            refuted += usize::from(check(&casters, light, &occluded, &mut random).is_err());
        }
    }
    println!("{all} occluded polygons, {bumped} that are not planar; {refuted} wrong ones refuted");
    assert!(all > 200 && bumped > 100 && refuted > 30);
}

#[test]
fn a_polygon_that_is_occluded_in_part_stays() {
    let small = |sides| wall(sides, 1.0, 0.0);
    let light = Light::point([0.0, 0.0, 10.0]);
    for sides in [3, 4, 6, 11] {
        let found = find(&[wall(4, 4.0, 5.0), small(sides)], light);
        assert_eq!([found.faces(0), found.faces(1)], [&[][..], &[0]], "{sides}");
        let statistics = found.statistics();
        assert_eq!([statistics.tried, statistics.occluded, statistics.left_out], [2, 1, 1], "{sides}");
        // A hider that covers one half leaves triangles of the fan occluded, and the polygon whole.
        let mut half = PolygonSet::default();
        half.push_points(&[vec![[0.0, -4.0, 5.0], [4.0, -4.0, 5.0], [4.0, 4.0, 5.0], [0.0, 4.0, 5.0]]]);
        let found = find(&[placed(half, 1.0, [0.0; 3]), small(sides)], light);
        assert!(found.faces(1).is_empty(), "{sides}");
    }
}
