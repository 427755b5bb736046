//! The vertices of dark caps that orthographic cameras see, on the GPU and by the CPU twin: docs/numerics/rasterisers.md, "Dark
//! caps of orthographic cameras".

use glam::DVec3;
use rimline::reference::cpu::{self, End, Threads};
use rimline::reference::layout::{ShadowLight, ShadowShape, ShadowView};
use rimline::reference::shadow::{self, CAST_NOTHING, COUNT_Z_FAIL};
use rimline::{Light, Predicate};
use rimline_testkit::shapes;

use crate::clipped::{Cap, Drawn, Twin, bits};
use rimline_testkit::cases::case;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Pose, Scene, scene};
use rimline_testkit::{is_long, must_fail, same};

pub(crate) const TESTS: &[Test] = &[("dark_caps_equal_their_twin", dark)];

const LIGHTS: usize = 36;

fn twin(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> Vec<[u32; 4]> {
    let triangle = cpu::dark_cap(view, light, face);
    (0..3).map(|vertex| bits(triangle.as_ref().map(|triangle| &triangle[vertex]))).collect()
}

/// The twin with the highest index first, so that another face has a direction that is on an edge.
fn other_ties(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> Vec<[u32; 4]> {
    twin(view, light, face.map(|(index, position)| (u32::MAX - index, position)))
}

/// The point of a face of random weights, of which none, one or two are zero.
fn on_face(random: &mut Random, scene: &Scene) -> DVec3 {
    let (_, positions, mesh) = &scene.caster;
    let face = mesh.faces()[random.below(mesh.faces().len())];
    let corners = face.map(|vertex| DVec3::from(positions[vertex as usize].map(f64::from)));
    let kept = 1 + random.below(3);
    let weights: [f64; 3] = std::array::from_fn(|at| if at < kept { f64::from(random.between(0.1, 1.0)) } else { 0.0 });
    let sum: f64 = weights.iter().sum();
    (0..3).map(|at| corners[at] * (weights[at] / sum)).sum()
}

/// A scene as elsewhere with an orthographic camera, half of its lights so that the camera's direction, or the opposite,
/// leads from the light to the caster.
fn ordinary(random: &mut Random, number: usize) -> Result<Scene, String> {
    // Every 24 numbers go through all projections and distances; the last eight are orthographic.
    let mut scene = scene(random, number / 8 * 24 + 16 + number % 8, LIGHTS);
    let [x, y, z, _] = shadow::view(&scene.camera).map_err(|error| error.to_string())?.near_plane.map(f64::from);
    let forward = DVec3::new(x, y, z);
    for index in (0..LIGHTS).step_by(2) {
        let away = f64::from(random.between(-0.3, 1.5));
        let at = on_face(random, &scene) - forward * away;
        let range = if index % 4 == 0 { f32::INFINITY } else { random.between(1.0, 4.0) };
        scene.lights[index] = Light::point(at.as_vec3().to_array()).with_range(range);
    }
    Ok(scene)
}

/// The camera's direction leads from each light to a vertex of a grid or to the middle of an edge, without rounding:
/// products are zero, and the order of the indices decides which one of the faces there has it.
fn ties(random: &mut Random, number: usize) -> Scene {
    let mut grid = shapes::plane_grid(8, 8);
    for position in &mut grid.positions {
        *position = [position[0], position[2], -2.0];
    }
    let pose = Pose { eye: DVec3::ZERO, forward: DVec3::NEG_Z, right: DVec3::X, up: DVec3::Y, near: 0.125, scale: 1.0 };
    let mut eighths = || random.below(15) as f32 / 8.0 - 0.875;
    let light = |_| Light::point([eighths(), eighths(), -1.0]);
    let lights = (0..LIGHTS).map(light).collect();
    Scene { name: "ties".to_owned(), camera: pose.camera(4 + number % 2, false), caster: case("grid", grid), lights }
}

/// Numbers of faces and lights compared.
#[derive(Debug, Default)]
struct Seen {
    faces: usize,
    /// At infinity, as all of the picture.
    filled: usize,
    /// At the end of a volume that has one.
    ended: usize,
    /// Lights for which another order of indices gives other faces.
    tied: usize,
}

/// Fails where GPU and twin differ, for these lights.
fn compare(
    gpu: &Gpu,
    [cap, turned]: &[Cap; 2],
    scene: &Scene,
    end_at_range: u32,
    indices: &[usize],
    seen: &mut Seen,
) -> Result<(), String> {
    let (_, positions, mesh) = &scene.caster;
    let view = shadow::view(&scene.camera).map_err(|error| error.to_string())?;
    let counts = mesh.edges().counts();
    let shape = ShadowShape {
        lights: LIGHTS as u32,
        faces: mesh.faces().len() as u32,
        edges: mesh.edges().len() as u32,
        averted: u32::from(counts.boundary == 0 && counts.inconsistent == 0),
        counting: COUNT_Z_FAIL,
        end_at_range,
        skip_unreached: 1,
        ..bytemuck::Zeroable::zeroed()
    };
    let mut lights: Vec<_> = scene.lights.iter().map(|&light| shadow::light(&scene.camera, &view, light)).collect();
    let excluded = cpu::excluded(positions, mesh.faces(), &scene.lights);
    let has_excluded = excluded.iter().any(|&mask| mask != 0);
    cpu::choose(&shape, &view, cpu::bounds(positions, mesh.faces()), has_excluded, &mut lights);
    let plain = &scene.lights;
    let facing = cpu::facing(positions, mesh.faces(), plain, Predicate::Exact, Threads::ONE);
    let lists = cpu::caps(&view, positions, mesh.faces(), &facing, &excluded, &lights, true);
    for &index in indices {
        let plane = index / 32 * mesh.faces().len()..(index / 32 + 1) * mesh.faces().len();
        let (facing, excluded) = (&facing[plane.clone()], &excluded[plane]);
        let capped = &vec![false; lights.len()];
        let drawn = Drawn { scene, view, shape, lights: &lights, index, facing, excluded, capped };
        if drawn.light().casting == CAST_NOTHING {
            continue;
        }
        let what = format!("{}, light {index} {:?}", scene.name, drawn.light());
        // Every face, whether it casts or not; and those of a list that overflowed.
        let all: Vec<u32> = (0..mesh.faces().len() as u32).collect();
        for (listed, overflows) in [(&all, false), (&lists[index][2], true)] {
            if listed.is_empty() {
                continue;
            }
            let [mut found, expected] = drawn.caps(gpu, cap, listed, overflows)?;
            same(&what, &found, &expected)?;
            seen.faces += found.len() / 3;
            if drawn.light().end != 0.0 {
                seen.ended += found.len() / 3;
                continue;
            }
            let nothing = bits(None);
            // The second list is a part of the first.
            seen.filled += usize::from(!overflows) * found.chunks(3).filter(|face| face[0] != nothing).count();
            if let Some(at) = found.iter().position(|vertex| *vertex != nothing) {
                found[at][0] ^= 1;
                must_fail("a moved vertex", &same(&what, &found, &expected))?;
                found[at] = nothing;
                must_fail("a face that is not drawn", &same(&what, &found, &expected))?;
            }
        }
        let [found, expected] = drawn.caps(gpu, turned, &all, false)?;
        seen.tied += usize::from(found != expected);
    }
    Ok(())
}

fn dark() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 106;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let caps = [twin as Twin, other_ties].map(|twin| Cap::new(gpu, "dark_cap", 2, 3, twin));
    let mut seen = Seen::default();
    for number in 0..if is_long() { 600 } else { 48 } {
        let scene = ordinary(&mut random, number)?;
        let indices = [0; 6].map(|_| random.below(LIGHTS));
        let end_at_range = u32::from(number % 3 == 0);
        compare(gpu, &caps, &scene, end_at_range, &indices, &mut seen)?;
    }
    println!("{seen:?}");
    if seen.filled.min(seen.ended) < 100 {
        return Err("too few".to_owned());
    }
    let mut seen = Seen::default();
    for number in 0..2 {
        let all: Vec<usize> = (0..LIGHTS).collect();
        compare(gpu, &caps, &ties(&mut random, number), 0, &all, &mut seen)?;
    }
    println!("with ties {seen:?}");
    if seen.filled != 2 * LIGHTS {
        return Err(format!("{} faces have one of {} directions", seen.filled, 2 * LIGHTS));
    }
    if seen.tied < LIGHTS { Err("negative control: the order of indices went unnoticed".to_owned()) } else { Ok(()) }
}
