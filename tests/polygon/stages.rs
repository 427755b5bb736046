//! The masks of polygons against the CPU's.

use rimline::gpu::{ExtractorOptions, ListOptions};
use rimline::internals::cpu::{self, PolygonMasks, Threads};
use rimline::mesh::Weld;
use rimline::{Mesh, Predicate};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{Found, compare, extract, extract_with, text};
use rimline_testkit::polygons::random_set;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};

use crate::lights::lights_for;

pub(crate) const TESTS: &[Test] = &[("masks_equal_their_twin", masks)];

/// Compares the bits of triangles with the facing and twisted bits of their polygons.
pub(crate) fn check_facing(mesh: &Mesh, found: &Found, masks: &[PolygonMasks]) -> Result<(), String> {
    same("facing", &found.facing, &of_triangles(mesh, masks, |masks| masks.facing)?)?;
    // A row a polygon; one without triangles faces nothing.
    let polygons = mesh.polygons().ok_or("no polygons")?;
    let rows: Vec<u32> =
        found.facing.chunks(mesh.faces().len().max(1)).flat_map(|plane| polygons.masks_of(plane)).collect();
    let expected: Vec<u32> = masks.iter().map(|masks| masks.facing).collect();
    same("facing of polygons", &rows, &expected[..rows.len()])?;
    same("twisted", &found.twisted, &of_triangles(mesh, masks, |masks| masks.twisted)?)
}

fn check_masks(mesh: &Mesh, found: &Found, masks: &[PolygonMasks]) -> Result<(), String> {
    check_facing(mesh, found, masks)?;
    same("excluded", &found.excluded, &of_triangles(mesh, masks, |masks| masks.excluded)?)
}

fn of_triangles(mesh: &Mesh, masks: &[PolygonMasks], of: fn(&PolygonMasks) -> u32) -> Result<Vec<u32>, String> {
    let polygons = mesh.polygons().ok_or("no polygons")?;
    let plane = |plane: &[PolygonMasks]| {
        polygons.triangle_polygons().into_iter().map(|polygon| of(&plane[polygon as usize])).collect::<Vec<_>>()
    };
    Ok(masks.chunks(polygons.len()).flat_map(plane).collect())
}

fn masks() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 31_000;
    println!("seeds from {first}");
    let (mut twisted, mut large, mut not_finite) = (0, 0, 0);
    for seed in first..first + if is_long() { 600 } else { 40 } {
        let mut random = Random::new(seed);
        let most = [6, 12, 33, 64, 100][random.below(5)];
        let mut set = random_set(&mut random, most);
        let count = [1, 2, 16, 17, 32, 35][random.below(6)];
        let lights = lights_for(&mut random, &set.positions, count);
        if seed % 5 == 0 {
            let vertex = random.below(set.positions.len());
            set.positions[vertex][random.below(3)] = [f32::NAN, f32::INFINITY][random.below(2)];
        }
        if seed % 7 == 0 {
            let scale = [1e-30, 1e18, 1e30][random.below(3)];
            set.positions.iter_mut().for_each(|p| *p = p.map(|c| c * scale));
        }
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        let Some(polygons) = mesh.polygons() else { continue };
        let (masks, statistics) = cpu::polygon_facing(&set.positions, polygons, &lights, Threads::ONE);
        let lists = ListOptions { capacity: Some(u32::MAX), ordered: random.below(2) == 0, ..ListOptions::default() };
        let options =
            ExtractorOptions { max_lights: count, masks: true, lists: Some(lists), ..ExtractorOptions::default() };
        let found = extract(gpu, &set.positions, &mesh, &lights, options)?;
        check_masks(&mesh, &found, &masks).map_err(|error| format!("seed {seed}: {error}"))?;
        let expected = cpu::extract(&set.positions, &mesh, &lights, Predicate::Exact, Threads::ONE).map_err(text)?;
        same(&format!("seed {seed}, masks"), &found.masks, &expected.masks)?;
        // The layout is one, too.
        same(&format!("seed {seed}, facing"), &found.facing, &expected.facing)?;
        same(&format!("seed {seed}, twisted"), &found.twisted, &expected.twisted)?;
        same("not finite", &[found.statistics.non_finite_faces], &[statistics.non_finite_faces])?;
        for light in 0..count {
            let silhouettes = expected.silhouette(&mesh, light).edges().len() as u32;
            same(&format!("seed {seed}, light {light}, count"), &[found.counts[light]], &[silhouettes])?;
        }
        twisted += masks.iter().map(|masks| masks.twisted.count_ones()).sum::<u32>();
        large += (0..polygons.len()).filter(|&polygon| polygons.boundary(polygon).len() > 32).count();
        not_finite += statistics.non_finite_faces;
        let mut wrong = masks.clone();
        let at = random.below(wrong.len());
        if !polygons.triangles(at % polygons.len()).is_empty() {
            wrong[at].twisted ^= 1;
            must_fail("a twisted bit", &check_masks(&mesh, &found, &wrong))?;
            wrong[at].twisted ^= 1;
            wrong[at].facing ^= 1;
            must_fail("a facing bit", &check_masks(&mesh, &found, &wrong))?;
        }
        let plain = extract_with(gpu, &set.positions, &mesh, &lights, options)?;
        let public = Found { excluded: Vec::new(), ..found };
        compare(&format!("seed {seed}, not for volumes"), &plain, &public, u32::MAX, lists.ordered)?;
        same("twisted", &plain.twisted, &public.twisted)?;
    }
    println!("{twisted} twisted pairs, {large} large boundaries, {not_finite} not finite");
    if twisted > 1000 && large > 50 && not_finite > 0 { Ok(()) } else { Err("too few of a kind".to_owned()) }
}
