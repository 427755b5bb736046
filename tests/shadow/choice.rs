//! Choices for shadow volumes, against truth in `f64`: no cap is missing, and no visible volume is skipped.
//!
//! The stage is `counting_methods`.

use glam::{DMat4, DVec3, DVec4};
use rimline::Light;
use rimline::internals::cpu;
use rimline::internals::layout::{ShadowLight, ShadowShape, ShadowView};
use rimline::internals::shadow::{CAST_BACK_FACING, CAST_EVERY, CAST_NOTHING, COUNT_AUTO, COUNT_Z_PASS, COUNT_ZP_PLUS};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::scenes::{Scene, scene};

use crate::margins::view::Eye;
use crate::sides::box_of;
use crate::stages::{LAYOUTS, Staged, shape};

pub(crate) const TESTS: &[Test] = &[("a_cap_is_never_missed_and_nothing_seen_is_skipped", never_missed)];

type Outcome = Result<(), String>;

/// Inside of a plane only by more than this part of its terms: what `f64` leaves no doubt about.
const CERTAIN: f64 = 1e-10;

/// A linear function of homogeneous points, negative outside.
struct Plane(DVec4);

impl Plane {
    fn value(&self, p: DVec4) -> f64 {
        self.beyond(p, CERTAIN)
    }

    /// 0 where not by more than a part of the terms.
    fn beyond(&self, p: DVec4, part: f64) -> f64 {
        let terms = self.0 * p;
        let value = terms.element_sum();
        if value.abs() <= part * terms.abs().element_sum() { 0.0 } else { value }
    }
}

/// The plane through three homogeneous points, turned so that `inside` is not outside.
fn plane_through([a, b, c]: [DVec4; 3], inside: DVec4) -> Plane {
    let [a, b, c] = [a, b, c].map(|p| p / p.abs().max_element());
    let minor = |axis: usize| {
        let rows = DMat4::from_cols(a, b, c, DVec4::AXES[axis]);
        rows.determinant()
    };
    let plane = DVec4::new(minor(0), minor(1), minor(2), minor(3));
    Plane(if plane.dot(inside) < 0.0 { -plane } else { plane })
}

/// Whether the part of a polygon of homogeneous points inside of all planes is more than its boundary.
fn meets(polygon: &[DVec4], planes: &[Plane]) -> bool {
    let mut polygon = polygon.to_vec();
    for plane in planes {
        let mut kept = Vec::new();
        for (at, &p) in polygon.iter().enumerate() {
            let q = polygon[(at + 1) % polygon.len()];
            let (v, w) = (plane.value(p), plane.value(q));
            if v > 0.0 {
                kept.push(p);
            }
            if v * w < 0.0 {
                kept.push(p * (w / (w - v)) + q * (v / (v - w)));
            }
        }
        polygon = kept;
    }
    !polygon.is_empty()
}

impl Eye {
    fn homogeneous(&self, position: [f32; 3]) -> DVec4 {
        (DVec3::from_array(position.map(f64::from)) - self.origin).extend(1.0)
    }

    fn light(&self, light: Light) -> DVec4 {
        let [x, y, z, w] = light.to_array().map(f64::from);
        (DVec3::new(x, y, z) - w * self.origin).extend(w)
    }

    /// Planes of the pyramid between light and near rectangle.
    fn pyramid(&self, light: DVec4) -> [Plane; 5] {
        let (corners, middle) = (self.corners(), self.near_point([0.0; 2]));
        let side = |at: usize| plane_through([light, corners[at], corners[(at + 1) % 4]], middle);
        let near = if self.plane.dot(light) < 0.0 { -self.plane } else { self.plane };
        [side(0), side(1), side(2), side(3), Plane(near)]
    }

    fn frustum(&self) -> [Plane; 5] {
        let row = |axis| self.matrix.row(axis);
        let [x, y, w] = [row(0), row(1), row(3)];
        [Plane(w + x), Plane(w - x), Plane(w + y), Plane(w - y), Plane(self.plane)]
    }
}

/// A polygon between the light and the near rectangle.
fn is_needed(eye: &Eye, light: DVec4, triangle: [DVec4; 3]) -> bool {
    let planes = eye.pyramid(light);
    // A flat pyramid has no inside: the light is on the near plane.
    planes.iter().all(|plane| plane.value(eye.near_point([0.0; 2])) > 0.0 || plane.0 == planes[4].0)
        && planes[4].value(light) > 0.0
        && meets(&triangle, &planes)
}

/// Whether the volume of a triangle meets the frustum.
fn is_seen(eye: &Eye, light: DVec4, [a, b, c]: [DVec4; 3]) -> bool {
    let far = |p: DVec4| (light.w * p.truncate() - light.truncate()).extend(0.0);
    let polygons = [vec![a, b, c], vec![far(a), far(b), far(c)]];
    let sides = [[a, b], [b, c], [c, a]].map(|[p, q]| vec![p, q, far(q), far(p)]);
    let frustum = eye.frustum();
    polygons.iter().chain(&sides).any(|polygon| meets(polygon, &frustum)) || is_needed(eye, light, [a, b, c])
}

/// A scene as the stages see it.
#[derive(Clone)]
struct Chosen {
    view: ShadowView,
    lights: Vec<ShadowLight>,
    facing: Vec<u32>,
    caps: Vec<[Vec<u32>; 2]>,
    is_closed: bool,
}

fn choose(gpu: &Gpu, scene: &Scene) -> Result<Chosen, String> {
    let (_, positions, mesh) = &scene.caster;
    let counts = mesh.edges().counts();
    let excluded = cpu::excluded(positions, mesh.faces(), &scene.lights);
    let shape = ShadowShape { counting: COUNT_AUTO, ..shape(mesh, scene.lights.len()) };
    let staged = Staged::new(gpu, scene, LAYOUTS[0], shape, excluded)?;
    let (lights, _) = staged.choose(gpu, 0)?;
    let listed = staged.caps(gpu, &lights, shape.faces)?;
    let caps = listed.lists.chunks(4).map(|lists| [0, 1].map(|kind| [&lists[kind][..], &lists[kind + 2]].concat()));
    let is_closed = counts.boundary == 0 && counts.inconsistent == 0;
    Ok(Chosen { view: staged.view, lights, facing: staged.facing.clone(), caps: caps.collect(), is_closed })
}

/// Lights that are skipped, and that need caps.
#[derive(Debug, Default)]
struct Tally {
    skipped: usize,
    caps_needed: usize,
}

/// The box of a caster's faces.
fn caster_box(scene: &Scene) -> [DVec3; 2] {
    let (_, positions, mesh) = &scene.caster;
    let corners = mesh.faces().iter().flatten().map(|&v| positions[v as usize]);
    box_of(corners).map(|corner| DVec3::from_array(corner.map(f64::from)))
}

fn triangles(scene: &Scene, eye: &Eye) -> Vec<Option<[DVec4; 3]>> {
    let (_, positions, mesh) = &scene.caster;
    let triangle = |&[a, b, c]: &[u32; 3]| {
        (a != b && b != c && c != a).then(|| [a, b, c].map(|v| eye.homogeneous(positions[v as usize])))
    };
    mesh.faces().iter().map(triangle).collect()
}

/// No face between light and near rectangle is missing, and none that does not cast is there.
fn check_caps(scene: &Scene, chosen: &Chosen, tally: &mut Tally) -> Outcome {
    let eye = Eye::new(&scene.camera);
    let triangles = triangles(scene, &eye);
    let faces = triangles.len();
    for (index, (light, lists)) in chosen.lights.iter().zip(&chosen.caps).enumerate() {
        if light.casting == CAST_NOTHING {
            continue;
        }
        // The light in the stages' form. Any w other than 0 and powers of two moves it by a unit in its last place.
        let given = eye.light(Light::homogeneous(light.light));
        let plane = &chosen.facing[index / 32 * faces..][..faces];
        let mut is_any_needed = false;
        for (face, triangle) in triangles.iter().enumerate() {
            let faces_light = plane[face] >> (index % 32) & 1 != 0;
            let casts = light.casting == CAST_EVERY || !faces_light;
            let listed = lists.iter().map(|list| list.binary_search(&(face as u32)).is_ok()).collect::<Vec<_>>();
            if (!casts || triangle.is_none()) && listed.contains(&true) {
                return Err(format!("{}: light {index}, face {face} does not cast and is listed", scene.name));
            }
            let Some(triangle) = triangle.filter(|_| casts) else { continue };
            if is_needed(&eye, given, triangle) {
                is_any_needed = true;
                if light.counting != COUNT_ZP_PLUS || !listed.contains(&true) {
                    return Err(format!("{}: light {index} ({light:?}) lacks the cap of face {face}", scene.name));
                }
                // Fronts of faces that face the light are seen from the light, and so from behind the near plane
                // where the light is on the eye's side; the stages see the near plane rounded to `f32`.
                let height = Plane(eye.plane).beyond(given, 1e-6);
                let front = faces_light == (height < 0.0);
                if height != 0.0 && listed[usize::from(front)] {
                    return Err(format!("{}: light {index}, face {face} is in the wrong list", scene.name));
                }
            }
        }
        tally.caps_needed += usize::from(is_any_needed);
    }
    Ok(())
}

/// Skipped lights are out of range or out of sight. Lights that are clearly out of range are skipped.
fn check_skipped(scene: &Scene, chosen: &Chosen, tally: &mut Tally) -> Outcome {
    let eye = Eye::new(&scene.camera);
    let triangles = triangles(scene, &eye);
    let [low, high] = caster_box(scene);
    for (index, light) in chosen.lights.iter().enumerate() {
        let given = scene.lights[index];
        let [x, y, z, w] = given.to_array().map(f64::from);
        let light_position = DVec3::new(x, y, z) / w;
        let distance = (low - light_position).max(light_position - high).max(DVec3::ZERO).length();
        let range = f64::from(given.range);
        let rounding = 1e-5 * range + 1e-6 * light_position.length().max(low.length());
        let (in_range, out_of_range) =
            (w == 0.0 || distance < range - rounding, w != 0.0 && distance > range + rounding);
        let is_skipped = light.casting == CAST_NOTHING;
        if out_of_range && !is_skipped {
            return Err(format!("{}: light {index}, {distance} away, reaches beyond its {range}", scene.name));
        }
        tally.skipped += usize::from(is_skipped);
        let at = eye.light(Light::homogeneous(light.light));
        let is_seen = || triangles.iter().flatten().any(|&triangle| is_seen(&eye, at, triangle));
        if in_range && is_skipped && is_seen() {
            return Err(format!("{}: light {index} is skipped and its shadow seen", scene.name));
        }
    }
    Ok(())
}

/// Back-facing faces serve only where the near rectangle and the light are outside of the caster's box.
fn check_casting(scene: &Scene, chosen: &Chosen) -> Outcome {
    let eye = Eye::new(&scene.camera);
    let [low, high] = caster_box(scene);
    let [near_low, near_high] = eye.near_box();
    let meet = low.cmple(near_high).all() && high.cmpge(near_low).all();
    for (index, light) in chosen.lights.iter().enumerate() {
        if light.casting == CAST_BACK_FACING && (meet || !chosen.is_closed) {
            return Err(format!("{}: light {index} has back-facing faces alone", scene.name));
        }
        let [x, y, z, w] = light.light.map(f64::from);
        let weighted = DVec3::new(x, y, z);
        let is_within = w > 0.0 && (w * low).cmple(weighted).all() && weighted.cmple(w * high).all();
        if light.casting == CAST_BACK_FACING && is_within {
            return Err(format!(
                "{}: light {index} is in the caster's box, and back-facing faces alone cast",
                scene.name
            ));
        }
    }
    Ok(())
}

fn never_missed() -> Outcome {
    let (gpu, mut random) = Gpu::seeded(91)?;
    // By distance from the origin: none (twice), 1e3, 1e5.
    let mut tallies: [Tally; 4] = Default::default();
    let (mut control, mut scenes) = (0, 0);
    for number in 0..if is_long() { 3000 } else { 48 } {
        let scene = scene(&mut random, number, 36);
        let chosen = choose(&gpu, &scene)?;
        let tally = &mut tallies[number % 4];
        check_skipped(&scene, &chosen, tally)?;
        check_casting(&scene, &chosen)?;
        check_caps(&scene, &chosen, tally)?;
        scenes += 1;
        // Negative controls: a choice of z-pass, and a cap's list short of a face that is needed.
        let mut wrong = chosen.clone();
        for (light, lists) in wrong.lights.iter_mut().zip(&mut wrong.caps) {
            light.counting = COUNT_Z_PASS;
            lists.iter_mut().for_each(Vec::clear);
        }
        let mut unused = Tally::default();
        control += usize::from(check_caps(&scene, &wrong, &mut unused).is_err());
        if chosen.is_closed && chosen.lights.iter().any(|light| light.casting == CAST_EVERY) {
            wrong.lights.iter_mut().for_each(|light| light.casting = CAST_BACK_FACING);
            let outcome = check_casting(&scene, &wrong);
            if chosen.view.near_min != chosen.view.near_max {
                control += usize::from(outcome.is_err());
            }
        }
        wrong.lights.iter_mut().for_each(|light| light.casting = CAST_NOTHING);
        let outcome = check_skipped(&scene, &wrong, &mut unused);
        control += usize::from(outcome.is_err());
    }
    for tally in &tallies {
        println!("{tally:?}");
    }
    assert!(control > scenes, "negative controls fail: {control} of {scenes} scenes");
    assert!(tallies.iter().all(|tally| tally.caps_needed > 20 && tally.skipped > 20), "not vacuous");
    Ok(())
}
