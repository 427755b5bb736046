//! The vertices of dark caps that orthographic cameras see: docs/numerics/rasterisers.md, "Dark caps of orthographic
//! cameras".

use glam::{DMat4, DVec2, DVec3, DVec4};
use rimline::internals::cpu;
use rimline::internals::layout::ShadowShape;
use rimline::internals::shadow::{self, CAST_NOTHING, COUNT_Z_FAIL};
use rimline::{DepthDirection, Light};
use rimline_testkit::shapes;

use crate::clipped::{Drawn, NOTHING, Shapes};
use crate::stages::{LAYOUTS, Staged, shape};
use rimline_testkit::cases::case;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Pose, Scene, scene};
use rimline_testkit::{is_long, must_fail};

pub(crate) const TESTS: &[Test] = &[("dark_caps_of_orthographic_cameras", dark)];

const LIGHTS: usize = 36;

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
    /// So close to an edge of the face that rounding decides.
    doubtful: usize,
}

/// Parts of the terms by which something is on one side.
const CERTAIN: f64 = 1e-5;

/// Whether the camera's direction leads from the light through a face; `None` if it is too close to an edge to say.
fn is_hit(scene: &Scene, light: [f32; 4], face: [[f32; 3]; 3]) -> Option<bool> {
    let matrix = DMat4::from_cols_array_2d(&scene.camera.view_projection.map(|column| column.map(f64::from)));
    let [x, y, z, w] = light.map(f64::from);
    let away = face.map(|corner| w * DVec3::from(corner.map(f64::from)) - DVec3::new(x, y, z));
    // A light at infinity has one direction for the whole face.
    if w == 0.0 {
        return Some(false);
    }
    let [p, q, r] = away.map(|away| (matrix * away.extend(0.0)).truncate().truncate());
    let columns = [matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs()];
    let error =
        away.map(|away| 1e-6 * (columns[0] * away.x.abs() + columns[1] * away.y.abs() + columns[2] * away.z.abs()));
    let side = |a: usize, b: usize, p: DVec2, q: DVec2| {
        let value = p.perp_dot(q);
        let terms = (p.x * q.y).abs() + (p.y * q.x).abs();
        let moved = error[a].x.max(error[a].y) * q.length() * 2.0 + error[b].x.max(error[b].y) * p.length() * 2.0;
        (value.abs() > CERTAIN * terms + moved).then_some(value > 0.0)
    };
    let sides = [side(0, 1, p, q), side(1, 2, q, r), side(2, 0, r, p)];
    if sides.contains(&Some(true)) && sides.contains(&Some(false)) {
        return Some(false);
    }
    let [Some(left), Some(_), Some(_)] = sides else { return None };
    // With reversed depth z falls, else it grows, along the camera's direction.
    let along = away[0] * q.perp_dot(r) + away[1] * r.perp_dot(p) + away[2] * p.perp_dot(q);
    let forward =
        (matrix * along.extend(0.0)).z * if scene.camera.depth == DepthDirection::Reversed { -1.0 } else { 1.0 };
    Some((forward > 0.0) == left)
}

/// All of the picture at the farthest depth, turned as the face is on the screen.
fn fills(found: &[[f32; 4]], far_z: f32) -> bool {
    let corner = |x, y| [x, y, far_z, 1.0];
    let (second, third) = (corner(3.0, -1.0), corner(-1.0, 3.0));
    found[0] == corner(-1.0, -1.0) && (found[1..] == [second, third] || found[1..] == [third, second])
}

/// Fails where a face is drawn that the camera's direction from the light misses, or the other way round; or where the
/// end of a volume lies elsewhere.
fn check(
    gpu: &Gpu,
    cap: &Shapes,
    scene: &Scene,
    end_at_range: u32,
    indices: &[usize],
    seen: &mut Seen,
) -> Result<(), String> {
    let (_, positions, mesh) = &scene.caster;
    let excluded = cpu::excluded(positions, mesh.faces(), &scene.lights);
    let options = ShadowShape { counting: COUNT_Z_FAIL, end_at_range, cull_by_view: 0, ..shape(mesh, LIGHTS) };
    let staged = Staged::new(gpu, scene, LAYOUTS[0], options, excluded)?;
    let (lights, _) = staged.choose(gpu, 0)?;
    let far_z = 1.0 - staged.view.near_z;
    for &index in indices {
        let drawn = Drawn::of(&staged, &lights, &[false; LIGHTS], index);
        let light = drawn.light();
        if light.casting == CAST_NOTHING {
            continue;
        }
        let what = format!("{}, light {index} {light:?}", scene.name);
        // Every face of three vertices, whether it casts or not; and those of a list that overflowed.
        let is_face = |face: &u32| {
            let [a, b, c] = mesh.faces()[*face as usize];
            a != b && b != c && c != a
        };
        let all: Vec<u32> = (0..mesh.faces().len() as u32).filter(is_face).collect();
        let found = drawn.listed_caps(gpu, cap, &all, all.len())?;
        drawn.caps(gpu, cap, true)?;
        for (&face, found) in all.iter().zip(found.chunks(3)) {
            let corners = mesh.faces()[face as usize].map(|vertex| positions[vertex as usize]);
            seen.faces += 1;
            if light.end != 0.0 {
                ends(scene, (light.light, light.end), corners, found).map_err(|error| format!("{what}: {error}"))?;
                seen.ended += 1;
                continue;
            }
            let is_drawn = found.iter().any(|vertex| *vertex != NOTHING);
            let compare = |is_drawn: bool| match is_hit(scene, light.light, corners) {
                Some(is_hit) if is_hit != is_drawn || (is_hit && !fills(found, far_z)) => {
                    Err(format!("{what}: {corners:?} is {found:?}, and the direction meets it: {is_hit}"))
                }
                is_hit => Ok(is_hit.is_none()),
            };
            let is_doubtful = compare(is_drawn)?;
            seen.doubtful += usize::from(is_doubtful);
            seen.filled += usize::from(is_drawn);
            if is_drawn && !is_doubtful {
                must_fail("a face that is not drawn", &compare(false))?;
            }
        }
    }
    Ok(())
}

/// The far face of a volume that ends is where the light has the face, so many times as far away.
fn ends(scene: &Scene, (light, end): ([f32; 4], f32), face: [[f32; 3]; 3], found: &[[f32; 4]]) -> Result<(), String> {
    let matrix = DMat4::from_cols_array_2d(&scene.camera.view_projection.map(|column| column.map(f64::from)));
    let [x, y, z, w] = light.map(f64::from);
    let at = DVec3::new(x, y, z) / w;
    for (corner, found) in face.into_iter().zip(found) {
        let away = (DVec3::from(corner.map(f64::from)) - at) / f64::from(end);
        let origin = DVec3::from(scene.camera.origin.map(f64::from));
        let expected = (matrix * (at + away - origin).extend(1.0)).truncate();
        let found = DVec4::from(found.map(f64::from));
        let found = found.truncate() / found.w;
        let size = (away.length() + (at - origin).length())
            * matrix.to_cols_array().iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        if (found - expected).abs().max_element() > 1e-5 * (1.0 + size) / f64::from(end).min(1.0) {
            return Err(format!("{found} for {expected}"));
        }
    }
    Ok(())
}

fn dark() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(106)?;
    let cap = Shapes::caps(&gpu, "dark_cap", 2, 3);
    let mut seen = Seen::default();
    for number in 0..if is_long() { 600 } else { 48 } {
        let scene = ordinary(&mut random, number)?;
        let indices = [0; 6].map(|_| random.below(LIGHTS));
        check(&gpu, &cap, &scene, u32::from(number % 3 == 0), &indices, &mut seen)?;
    }
    println!("{seen:?}");
    if seen.filled.min(seen.ended) < 100 || seen.doubtful * 8 > seen.faces {
        return Err("too few".to_owned());
    }
    // One face has the direction, although it is on an edge or vertex of several.
    let mut seen = Seen::default();
    for number in 0..2 {
        let all: Vec<usize> = (0..LIGHTS).collect();
        check(&gpu, &cap, &ties(&mut random, number), 0, &all, &mut seen)?;
    }
    println!("with ties {seen:?}");
    if seen.filled == 2 * LIGHTS && seen.doubtful > 4 * LIGHTS { Ok(()) } else { Err(format!("{seen:?}")) }
}
