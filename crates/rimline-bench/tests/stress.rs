//! Stress scenes are what their names say.

use std::collections::HashSet;

use rimline::internals::cpu::{self, Threads};
use rimline::{Light, MAX_LIGHTS, Mesh, Predicate, check_lights};
use rimline_bench::error_metrics::{Score, light_counts};
use rimline_bench::stress::{self, Scene};

const FACES: usize = 1500;

fn scene(name: &str) -> Scene {
    stress::scene(name, FACES).expect("a scene's name")
}

fn exactly(scene: &Scene, lights: &[Light]) -> cpu::Extraction {
    let mesh = scene.mesh().expect("a mesh");
    cpu::extract(&scene.positions, &mesh, lights, Predicate::Exact, Threads::all()).expect("good lights")
}

/// Undecided pairs of `lights` lights, and exact zeros among them, as shares of all pairs.
fn shares(name: &str, lights: usize) -> (f64, f64) {
    let scene = scene(name);
    let statistics = exactly(&scene, &scene.lights(lights)).statistics;
    let pairs = (scene.faces.len() * lights) as f64;
    (f64::from(statistics.undecided_pairs) / pairs, f64::from(statistics.exact_zeros) / pairs)
}

fn corners(scene: &Scene) -> impl Iterator<Item = [[f64; 3]; 3]> {
    scene.faces.iter().map(|face| face.map(|v| scene.positions[v as usize].map(f64::from)))
}

/// Longest side over the height above it; infinite without a height.
fn aspect(corners: [[f64; 3]; 3]) -> f64 {
    let difference = |i: usize, j: usize| -> [f64; 3] { std::array::from_fn(|k| corners[i][k] - corners[j][k]) };
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let (u, v) = (difference(1, 0), difference(2, 0));
    let area = length([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]);
    let longest = length(u).max(length(v)).max(length(difference(2, 1)));
    longest * longest / area
}

#[test]
fn every_scene_is_a_mesh_of_about_the_size_wished_with_good_lights() {
    let names: HashSet<_> = stress::names().collect();
    assert_eq!(names.len(), stress::names().len(), "names differ");
    for faces in [1, 100, 3000, 20_000] {
        for (scene, name) in stress::scenes(faces).zip(stress::names()) {
            assert_eq!(scene.name, name);
            let again = stress::scene(name, faces).expect("its own name");
            assert_eq!((&scene.positions, &scene.faces), (&again.positions, &again.faces), "{name}");
            assert!(scene.positions.iter().flatten().all(|c| c.is_finite()), "{name}");
            let got = scene.faces.len() as f64;
            assert!(faces < 100 || (0.6..1.5).contains(&(got / faces as f64)), "{name}: {got} for {faces}");
            assert_eq!(scene.mesh().expect("a mesh").faces().len(), scene.faces.len(), "{name}");
            check_lights(&scene.lights(MAX_LIGHTS), MAX_LIGHTS).expect("good lights");
            assert_eq!(scene.lights(32)[..8], scene.lights(8), "{name}: fewer lights are the first of more");
            let distinct: HashSet<_> =
                scene.lights(32).iter().map(|light| light.to_array().map(f32::to_bits)).collect();
            assert!(distinct.len() > if faces < 1000 { 2 } else { 28 }, "{name}: {} of 32 lights", distinct.len());
        }
    }
    assert!(stress::scene("no such scene", 100).is_none());
}

#[test]
fn bodies_are_closed_but_for_plates_and_sheets() {
    for scene in stress::scenes(FACES) {
        let counts = scene.mesh().expect("a mesh").edges().counts();
        let is_open =
            ["plate", "noise"].contains(&scene.class) || ["moebius-strip", "three-sheets"].contains(&scene.name);
        // Doubled faces give some edges an odd number of them.
        let is_open = is_open || scene.name == "degenerate-faces";
        assert_eq!(counts.boundary > 0, is_open, "{}: {counts:?}", scene.name);
        let is_twisted = scene.name == "moebius-strip";
        assert_eq!(counts.inconsistent > 0, is_twisted, "{}: {counts:?}", scene.name);
    }
}

#[test]
fn plates_leave_a_third_of_the_pairs_or_all_undecided() {
    for (name, low, high) in [("plate-third", 0.3, 0.4), ("plate-all", 0.99, 1.0)] {
        for lights in [8, 32] {
            let (undecided, zeros) = shares(name, lights);
            assert!((low..=high).contains(&undecided), "{name}, {lights} lights: {undecided}");
            assert!(zeros < 0.9 * undecided, "{name}: the plane is rounded, {zeros} zeros");
        }
    }
    for (name, low, high) in [("plate-lattice-third", 0.3, 0.4), ("plate-lattice-all", 1.0, 1.0)] {
        let (undecided, zeros) = shares(name, 8);
        assert!((low..=high).contains(&undecided) && zeros == undecided, "{name}: {undecided}, {zeros} zeros");
    }
}

#[test]
fn lights_on_the_surface_are_in_planes_of_faces() {
    for name in ["lights-in-planes", "touching-boxes"] {
        let (undecided, zeros) = shares(name, 32);
        assert!(zeros > 0.05 && zeros <= undecided, "{name}: {undecided}, {zeros} zeros");
    }
    for (name, faces_each) in [("lights-on-vertices", 4), ("lights-on-edges", 1), ("lights-on-faces", 1)] {
        let statistics = exactly(&scene(name), &scene(name).lights(32)).statistics;
        assert!(statistics.undecided_pairs >= 16 * faces_each, "{name}: {statistics:?}");
    }
    let statistics = exactly(&scene("lights-on-vertices"), &scene("lights-on-vertices").lights(32)).statistics;
    assert!(statistics.exact_zeros >= 16 * 4, "{statistics:?}");
    assert!(exactly(&scene("lights-1e-20"), &scene("lights-1e-20").lights(8)).statistics.undecided_pairs > 8);
}

#[test]
fn slivers_and_needles_are_as_thin_as_named() {
    for (power, wished) in [("1e2", 1e2), ("1e4", 1e4), ("1e6", 1e6), ("1e8", 1e8)] {
        let needles: Vec<f64> = corners(&scene(&format!("needles-{power}"))).map(aspect).collect();
        let least = if wished > 1e6 { 1e6 } else { 0.5 * wished };
        let thin = needles.iter().filter(|aspect| **aspect > least).count();
        assert!(2 * thin > needles.len(), "{power}: {thin} of {} needles", needles.len());
        let slivers: Vec<f64> = corners(&scene(&format!("slivers-{power}"))).map(aspect).collect();
        // Beyond f32's 24 bits the point is on the side, or a rounding beside it.
        let least = if wished > 1e6 { 1e5 } else { 0.1 * wished };
        let thin = slivers.iter().filter(|aspect| **aspect > least).count();
        assert!(4 * thin > slivers.len(), "{power}: {thin} of {} slivers", slivers.len());
    }
}

#[test]
fn scales_and_positions_are_those_named() {
    let largest = |name: &str| scene(name).positions.iter().flatten().fold(0.0_f32, |most, c| most.max(c.abs()));
    for (name, scale) in [("scale-1e-30", 1e-30), ("scale-1e0", 1.0), ("scale-1e30", 1e30), ("subnormal-body", 1e-39)] {
        let largest = largest(name);
        assert!((0.6 * scale..1.4 * scale).contains(&largest), "{name}: {largest}");
    }
    for name in ["subnormal-thickness", "subnormal-body", "subnormal-last-bits"] {
        let scene = scene(name);
        let subnormal = scene.positions.iter().filter(|p| p[1].is_subnormal()).count();
        assert!(5 * subnormal > 4 * scene.positions.len(), "{name}: {subnormal}");
    }
    for (name, by) in [("translation-1e3", 1e3_f32), ("translation-1e6", 1e6)] {
        assert!(scene(name).positions.iter().flatten().all(|c| (c - by).abs() < 12.0), "{name}");
    }
    // A limb bent by half a turn lies on itself: above the joint heights are negated.
    let height = |name: &str| scene(name).positions.iter().map(|p| p[1]).fold(f32::NEG_INFINITY, f32::max);
    assert!(height("bent-60") > 1.0 && height("bent-179") < 0.6);
    // The distance from the plate's plane must fit the scene's name.
    let off = |name: &str| {
        let distance = |[x, y, z]: [f32; 3]| {
            let [x, y, z] = [x, y, z].map(f64::from);
            // Solved for the plate's own coordinates, of which the tilt makes y.
            let (u, v) = ((x - 0.1 * z) / 1.02, (z + 0.2 * x) / 1.02);
            (y - (0.3 * u - 0.7 * v)).abs()
        };
        scene(name).positions.into_iter().map(distance).fold(0.0, f64::max)
    };
    for (name, amplitude) in [("noise-1e-2", 1e-2), ("noise-1e-4", 1e-4), ("noise-1e-6", 1e-6)] {
        assert!((0.5..2.0).contains(&(off(name) / amplitude)), "{name}: {}", off(name));
    }
}

#[test]
fn degenerate_and_doubled_faces_are_there() {
    let scene = scene("degenerate-faces");
    let mesh = scene.mesh().expect("a mesh");
    assert!(mesh.degenerate_faces() > 50);
    let mut sorted: Vec<_> = mesh
        .faces()
        .iter()
        .map(|face| {
            let mut face = *face;
            face.sort_unstable();
            face
        })
        .collect();
    sorted.sort_unstable();
    assert!(sorted.windows(2).filter(|pair| pair[0] == pair[1]).count() > 100);
    // Corners on a line, at different positions.
    let lines = mesh.faces().iter().filter(|[a, b, c]| a != b && b != c && c != a);
    let lines = lines.filter(|face| aspect(face.map(|v| scene.positions[v as usize].map(f64::from))).is_infinite());
    assert!(lines.count() > 40);
}

#[test]
fn scores_count_what_is_wrong() {
    let scene = scene("moebius-strip");
    let mesh = scene.mesh().expect("a mesh");
    let lights = scene.lights(33);
    let exact = exactly(&scene, &lights);
    let of = |facing: &[u32], masks: &[rimline::internals::layout::EdgeMasks]| {
        let found = cpu::Extraction { facing: facing.to_vec(), masks: masks.to_vec(), ..Default::default() };
        Score::of(&mesh, 33, &exact, &found)
    };
    let (faces, edges) = (mesh.faces().len(), mesh.edges().len());
    let clean = Score::default();
    assert_eq!(of(&exact.facing, &exact.masks), Some(clean));
    assert_eq!(of(&[], &exact.masks), Some(clean), "edges tell the facing bits");

    // A face decided wrongly for the last light: its edges follow, and loops close.
    let mut facing = exact.facing.clone();
    facing[faces + 9] ^= 1;
    let masks = cpu::edges(mesh.edges(), &facing, faces, 33, Threads::ONE);
    let inner = mesh.edges().iter().filter(|e| e.face_1.is_some() && (e.face_0 == 9 || e.face_1 == Some(9))).count();
    let one = Score { wrong_facing_bits: 1, wrong_silhouette_bits: inner, ..clean };
    assert_eq!(of(&facing, &masks), Some(one));
    assert_eq!(of(&[], &masks), Some(one));

    // The same decision at one edge alone: both its ends open.
    let at = mesh.edges().iter().position(|e| e.face_0 == 9 && e.face_1.is_some()).expect("an inner edge");
    let mut masks = exact.masks.clone();
    masks[edges + at].winding ^= 1;
    masks[edges + at].silhouette ^= 1;
    let open = Score { wrong_facing_bits: 1, wrong_silhouette_bits: 1, unclosed_vertices: 2 };
    assert_eq!(of(&[], &masks), Some(open));
    assert_eq!(of(&[], &masks[..edges]), None, "masks of too few lights");
}

#[test]
fn loops_of_a_closed_and_of_an_open_mesh_close_and_a_flipped_bit_opens_them() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let lights = [Light::point([3.0, 3.0, 3.0]), Light::directional([0.0, 0.0, -1.0])];
    for (faces, expected) in [(vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], [3, 3]), (vec![[0, 1, 2]], [3, 3])] {
        let mesh = Mesh::from_faces(4, faces).expect("a mesh");
        let facing = cpu::facing(&positions, mesh.faces(), &lights, Predicate::Exact, Threads::ONE);
        let mut masks = cpu::edges(mesh.edges(), &facing, mesh.faces().len(), 2, Threads::ONE);
        let counts = light_counts(&mesh, &masks, &[], 2);
        assert_eq!(counts.iter().map(|of| of.silhouette_edges).collect::<Vec<_>>(), expected);
        assert!(counts.iter().all(|of| of.unclosed_vertices == 0), "{counts:?}");
        masks[0].silhouette ^= 1;
        let counts = light_counts(&mesh, &masks, &[], 2);
        assert_eq!(counts.iter().map(|of| of.unclosed_vertices).collect::<Vec<_>>(), [2, 0]);
    }
}
