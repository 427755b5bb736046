//! Polygons as large as the GPU takes them. llvmpipe ends an invocation's loops after 65,535 turns without a word, so
//! these are compared with the twin. docs/numerics/loops.md.

use rimline::gpu::{DeviceError, Extractor, ExtractorError, ExtractorOptions, MAX_BOUNDARY_EDGES};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::stages::POLYGON_TURNS;
use rimline::mesh::Weld;
use rimline::{Light, Mesh};

use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::Dispatch;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{extract, extract_with, limited, text};
use rimline_testkit::polygons::{PolygonSet, quad_box};
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{is, refusal, refused};
use rimline_testkit::{is_long, must_fail, same};

use crate::stages::check_facing;

pub(crate) const TESTS: &[Test] = &[
    ("boundaries_of_most_edges_and_triangles", largest),
    ("polygons_of_more_triangles_are_refused", too_many_triangles),
    ("more_polygons_than_a_row_of_workgroups_takes", several_rows),
    ("rows_of_entries_on_a_device_without_a_limit", rows),
];

/// The most triangles of a polygon, as `ExtractorError::PolygonTooLarge` says it.
pub(crate) const MOST_TRIANGLES: usize = 2048;
/// Edges of the largest boundary that is tried for being strictly convex.
const MOST_CONVEX: usize = 256;

/// A loop through the corners, and over a bridge to a hole of 3 edges and back: so many `triangles` in all. The edges
/// of the bridge are walked both ways, so they are not in the boundary, but there are triangles on both sides of it.
fn bridged(corners: &[[f32; 3]], triangles: usize) -> Vec<[f32; 3]> {
    let length = (triangles + 2 - corners.len() - 3) / 2;
    let hole = [[0.0; 3], [-1.0, 0.0, -1.0], [1.0, 0.0, -1.0]];
    let first = corners[0];
    let along = |at: usize| [[-0.01, 0.01][at % 2], 0.0, first[2] * (length - at) as f32 / length as f32];
    let bridge: Vec<_> = (1..length).map(along).collect();
    let mut points = corners.to_vec();
    points.push(first);
    points.extend(&bridge);
    points.extend(hole);
    points.push(hole[0]);
    points.extend(bridge.iter().rev());
    points
}

/// Around the y axis, strictly convex as seen along it.
fn circle(corners: usize) -> Vec<[f32; 3]> {
    let angle = |at: usize| at as f32 / corners as f32 * std::f32::consts::TAU;
    (0..corners).map(|at| [40.0 * angle(at).sin(), 0.0, 40.0 * angle(at).cos()]).collect()
}

/// Between two circles by turns, in one plane: simple, not convex, and seen edge-on from within the plane but for one
/// corner.
fn star(corners: usize) -> Vec<[f32; 3]> {
    let mut points = circle(corners);
    points.iter_mut().step_by(2).for_each(|p| *p = p.map(|c| 0.5 * c));
    points[0][1] = 0.001;
    points
}

/// A mesh whose polygons have these many edges and triangles.
fn mesh_of(set: &PolygonSet, sizes: &[[usize; 2]]) -> Result<Mesh, String> {
    let mesh = set.mesh(Weld::Position).map_err(text)?;
    let polygons = mesh.polygons().ok_or("no polygons")?;
    let found = (0..polygons.len()).map(|at| [polygons.boundary(at).len(), polygons.triangles(at).len()]);
    same("edges and triangles", &found.collect::<Vec<_>>(), sizes)?;
    Ok(mesh)
}

fn largest() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(61);
    let most = MAX_BOUNDARY_EDGES;
    // One that is simple, decided edge by edge, and one that is tangled; with the convex one in one workgroup.
    let (edge_on, above) = (Light::point([100.0, 0.0, 0.0]), Light::directional([0.0, 1.0, 0.0]));
    let mut lights = vec![edge_on, above];
    if is_long() {
        lights.extend((0..30).map(|_| Light::directional(random.direction())));
    }
    // Corners of whole numbers, so that many turns are 0.
    let tangled = (3..most).map(|_| [0; 3].map(|_| random.below(9) as f32 - 4.0)).collect();
    let shapes = [("a star", star(most - 3), lights), ("tangled", tangled, vec![above])];
    let (mut facing, mut twisted) = (0, 0);
    for (name, corners, lights) in shapes {
        let mut set = PolygonSet::default();
        set.push_points(&[bridged(&corners, MOST_TRIANGLES)]);
        set.push_points(&[circle(MOST_CONVEX)]);
        let mesh = match name {
            "tangled" => set.mesh(Weld::Position).map_err(text)?,
            _ => mesh_of(&set, &[[most, MOST_TRIANGLES], [MOST_CONVEX, MOST_CONVEX - 2]])?,
        };
        let polygons = mesh.polygons().ok_or("no polygons")?;
        let (mut masks, _) = cpu::polygon_facing(&set.positions, polygons, &lights, Threads::all());
        let options = ExtractorOptions { max_lights: lights.len(), lists: None, ..ExtractorOptions::default() };
        let found = extract(gpu, &set.positions, &mesh, &lights, options)?;
        check_facing(&mesh, &found, &masks).map_err(|error| format!("{name}: {error}"))?;
        facing += masks[0].facing.count_ones();
        twisted += masks[0].twisted.count_ones();
        masks[0].facing ^= 1 << (lights.len() - 1);
        must_fail("a bit of the last light", &check_facing(&mesh, &found, &masks))?;
    }
    println!("{facing} facing, {twisted} twisted");
    if facing > 0 && twisted > 0 { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

fn too_many_triangles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut set = PolygonSet::default();
    let triangles = MOST_TRIANGLES + 2;
    set.push_points(&[bridged(&circle(MAX_BOUNDARY_EDGES - 3), triangles)]);
    let mesh = mesh_of(&set, &[[MAX_BOUNDARY_EDGES, triangles]])?;
    match Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions::default()) {
        Err(ExtractorError::PolygonTooLarge { polygon: 0, triangles: found }) if found == triangles => Ok(()),
        other => Err(format!("{:?}", other.err())),
    }
}

/// A workgroup of `polygon_facing` takes 256 polygons, and each polygon may be an entry, a workgroup by itself.
fn several_rows() -> Result<(), String> {
    let (set, lights) = (quad_box(105), [Light::point([300.0, 200.0, 40.0])]);
    let mesh = set.mesh(Weld::Position).map_err(text)?;
    let polygons = mesh.polygons().ok_or("no polygons")?;
    same("polygons", &[polygons.len()], &[258 * 256 + 102])?;
    let options = ExtractorOptions { max_lights: 1, lists: None, ..ExtractorOptions::default() };
    let found = extract_with(&limited(1 << 27, 1 << 28, 258)?, &set.positions, &mesh, &lights, options)?;
    let (mut masks, _) = cpu::polygon_facing(&set.positions, polygons, &lights, Threads::all());
    check_facing(&mesh, &found, &masks)?;
    masks[polygons.len() - 1].facing ^= 1;
    must_fail("a bit of the last polygon", &check_facing(&mesh, &found, &masks))?;
    let (subject, limit) = ("a mesh of so many polygons", "max_compute_workgroups_per_dimension");
    let error = DeviceError::Limit { subject, limit, needed: 258, there: 257 };
    let made = Extractor::new(&limited(1 << 27, 1 << 28, 257)?.pipelines, &mesh, options);
    refused([refusal("fewer workgroups", made, is(ExtractorError::Device(error)))])
}

/// The rows of workgroups for seven entries, where a row takes four, and on a device whose limit is the largest number.
fn rows() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let probe = "@compute @workgroup_size(1) fn probe() { _ = reserve_entries(WORKGROUPS, 7u); }";
    let source = POLYGON_TURNS.composed_for(probe)?.wgsl + probe;
    for (most, right) in [(4, [4, 2, 0, 7]), (u32::MAX, [7, 1, 0, 7])] {
        let undecided = gpu.storage(&[0_u32; 16]);
        let stage = Dispatch::new(gpu, &source.replace(" = 65535u;", &format!(" = {most}u;")), "probe");
        stage.run_bound(gpu, &[&[(7, &undecided)]], 1)?;
        same(&format!("{most} a row"), &gpu.read::<u32>(&undecided, 8)?[4..], &right)?;
    }
    Ok(())
}
