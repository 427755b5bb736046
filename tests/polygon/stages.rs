//! The stages of polygons against their twins.

use rimline::gpu::{ExtractorOptions, ListOptions};
use rimline::mesh::Weld;
use rimline::reference::cpu::{self, PolygonMasks, Threads};
use rimline::{Light, Mesh, Predicate};

use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::{Found, extract};
use rimline_measure::polygons::{PolygonSet, quad_box, quad_torus, random_polygon};
use rimline_measure::random::Random;
use rimline_measure::{is_long, must_fail, same};

use crate::lights::light_for;

pub(crate) const TESTS: &[Test] = &[("masks_equal_their_twin", masks)];

/// Many random polygons together, and bodies of quadrilaterals.
fn random_set(random: &mut Random) -> PolygonSet {
    let mut set = match random.below(4) {
        0 => {
            let bump = [0.0, 0.01, 0.1, 0.3][random.below(4)];
            quad_torus(random, 12, 8, bump)
        }
        1 => quad_box(1 + random.below(3) as u32),
        _ => PolygonSet::default(),
    };
    let most = [6, 12, 33, 64, 100][random.below(5)];
    for _ in 0..5 + random.below(30) {
        let (_, one) = random_polygon(random, most);
        let first = set.positions.len() as u32;
        set.positions.extend(&one.positions);
        for loops in one.polygons() {
            let moved = |corners: Vec<u32>| corners.into_iter().map(|corner| first + corner).collect();
            set.push(&loops.into_iter().map(moved).collect::<Vec<_>>());
        }
    }
    set
}

fn random_lights(random: &mut Random, set: &PolygonSet, count: usize) -> Vec<Light> {
    let any = std::iter::repeat_with(|| light_for(random, &set.positions).1);
    any.filter(|light| light.to_array() != [0.0; 4]).take(count).collect()
}

/// What is found for triangles, against the masks of their polygons.
fn check_masks(mesh: &Mesh, found: &Found, masks: &[PolygonMasks]) -> Result<(), String> {
    let polygons = mesh.polygons().ok_or("no polygons")?;
    let of = |triangles: &[u32], of_polygon: fn(&PolygonMasks) -> u32, what: &str| {
        let expected = masks.chunks(polygons.len()).flat_map(|plane| {
            polygons.triangle_polygons().into_iter().map(move |polygon| of_polygon(&plane[polygon as usize]))
        });
        same(what, triangles, &expected.collect::<Vec<_>>())
    };
    of(&found.facing, |masks| masks.facing, "facing")?;
    of(&found.twisted, |masks| masks.twisted, "twisted")?;
    of(&found.excluded, |masks| masks.excluded, "excluded")
}

fn masks() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 31_000;
    println!("seeds from {first}");
    let (mut twisted, mut large, mut not_finite) = (0, 0, 0);
    for seed in first..first + if is_long() { 600 } else { 40 } {
        let mut random = Random::new(seed);
        let mut set = random_set(&mut random);
        let count = [1, 2, 16, 17, 32, 35][random.below(6)];
        let lights = random_lights(&mut random, &set, count);
        if seed % 5 == 0 {
            let vertex = random.below(set.positions.len());
            set.positions[vertex][random.below(3)] = [f32::NAN, f32::INFINITY][random.below(2)];
        }
        if seed % 7 == 0 {
            let scale = [1e-30, 1e18, 1e30][random.below(3)];
            set.positions.iter_mut().for_each(|p| *p = p.map(|c| c * scale));
        }
        let mesh = set.mesh(Weld::Position).map_err(|error| error.to_string())?;
        let Some(polygons) = mesh.polygons() else { continue };
        let (masks, statistics) = cpu::polygon_facing(&set.positions, polygons, &lights, Threads::ONE);
        let lists = ListOptions { capacity: Some(u32::MAX), ordered: random.below(2) == 0, vertices_per_edge: 4 };
        let options =
            ExtractorOptions { max_lights: count, masks: true, lists: Some(lists), ..ExtractorOptions::default() };
        let found = extract(gpu, &set.positions, &mesh, &lights, options)?;
        check_masks(&mesh, &found, &masks).map_err(|error| format!("seed {seed}: {error}"))?;
        let expected = cpu::extract(&set.positions, &mesh, &lights, Predicate::Exact, Threads::ONE)
            .map_err(|error| error.to_string())?;
        same(&format!("seed {seed}, masks"), &found.masks, &expected.masks)?;
        same(&format!("seed {seed}, not finite"), &[found.statistics.non_finite_faces], &[statistics.non_finite_faces])?;
        for light in 0..count {
            let plane = &expected.masks[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
            let silhouettes = plane.iter().filter(|masks| masks.silhouette >> (light % 32) & 1 != 0).count();
            same(&format!("seed {seed}, light {light}, count"), &[found.counts[light]], &[silhouettes as u32])?;
        }
        twisted += masks.iter().map(|masks| masks.twisted.count_ones()).sum::<u32>();
        large += (0..polygons.len()).filter(|&polygon| polygons.outline(polygon).len() > 32).count();
        not_finite += statistics.non_finite_faces;
        let mut wrong = masks.clone();
        let at = random.below(wrong.len());
        if !polygons.triangles(at % polygons.len()).is_empty() {
            wrong[at].twisted ^= 1;
            must_fail("a twisted bit", &check_masks(&mesh, &found, &wrong))?;
        }
    }
    println!("{twisted} twisted pairs, {large} large outlines, {not_finite} not finite");
    if twisted > 1000 && large > 50 && not_finite > 0 { Ok(()) } else { Err("too few of a kind".to_owned()) }
}
