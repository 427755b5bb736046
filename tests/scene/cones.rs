//! Cones of spot lights: what is left out is outside of the cone, and little else is kept.

use glam::{DAffine3, DMat3, DVec3};
use rimline::gpu::{SceneFrame, SceneOptions, ShadowError};
use rimline::internals::cpu;
use rimline::internals::layout::LightCone;
use rimline::internals::stages::NEEDS;
use rimline::{Cone, Light, LightError, Matrix3x4};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::probe::Probe;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};

use crate::random_scene::{Content, Own, Placed, RandomScene};

pub(crate) const TESTS: &[Test] = &[
    ("boxes_that_touch_a_cone_are_kept", touching),
    ("boxes_beside_a_cone_are_left_out", beside),
    ("cones_in_scenes_hide_nothing", scenes),
];

/// How far a place is inside of a cone: positive inside, by more for a place farther in. Relative to its distance.
fn inside(cone: Cone, apex: DVec3, place: DVec3) -> f64 {
    let axis = DVec3::from(cone.axis.map(f64::from)).normalize();
    let away = place - apex;
    if away.length() == 0.0 { 1.0 } else { away.normalize().dot(axis) - f64::from(cone.cosine) }
}

/// The cone in the scene's layout.
fn packed(cone: Cone, apex: [f32; 3]) -> LightCone {
    let axis = DVec3::from(cone.axis.map(f64::from)).normalize().as_vec3();
    LightCone { apex: [apex[0], apex[1], apex[2], 1.0], axis: [axis.x, axis.y, axis.z, cone.cosine] }
}

fn random_cone(random: &mut Random) -> Cone {
    let cosine = match random.below(8) {
        0 => 0.0,
        1 => 1.0,
        2 => -1.0,
        3 => random.between(0.99, 1.0),
        _ => random.between(-1.0, 1.0),
    };
    let length = 10.0_f32.powf(random.between(-3.0, 3.0));
    let axis = match random.below(3) {
        0 => [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]][random.below(3)],
        _ => random.direction(),
    };
    Cone { axis: axis.map(|c| c * length), cosine }
}

/// A direction at this angle from the axis, in radians.
fn direction(random: &mut Random, axis: [f32; 3], angle: f64) -> DVec3 {
    let axis = DVec3::from(axis.map(f64::from)).normalize();
    let any = DVec3::from(random.direction().map(f64::from));
    let across = (any - any.dot(axis) * axis).normalize_or_zero();
    angle.cos() * axis + angle.sin() * across
}

/// A box with a place at a corner, on a side, or within.
fn box_around(random: &mut Random, place: [f32; 3], size: f32) -> [[f32; 3]; 2] {
    let mut ends = [place; 2];
    for axis in 0..3 {
        let which = random.below(3);
        if which != 1 {
            ends[0][axis] = place[axis] - random.between(0.0, size);
        }
        if which != 2 {
            ends[1][axis] = place[axis] + random.between(0.0, size);
        }
    }
    ends
}

/// A cone and the ends of a box.
type Boxed = (LightCone, [[f32; 3]; 2]);

/// Whether the boxes may have a point in their cones, by the WGSL. No term of their ends is larger than the ends.
fn may_be_in_cone(gpu: &Gpu, boxes: &[Boxed]) -> Result<Vec<bool>, String> {
    let part = |at: u32| format!("probe_inputs[4u * index + {at}u]");
    let [apex, axis, low, high] = [0, 1, 2, 3].map(part);
    let call = format!("may_be_in_cone(LightCone({apex}, {axis}), {low}.xyz, {high}.xyz, 0.0)");
    let probe = Probe::new(gpu, &NEEDS.wgsl(), ("vec4<u32>", &format!("vec4<u32>(u32({call}))")), &[]);
    let mut all = Vec::new();
    for boxes in boxes.chunks(100_000) {
        let four = |&(cone, ends): &Boxed| {
            let [low, high] = ends.map(|[x, y, z]| [x, y, z, 0.0]);
            [cone.apex, cone.axis, low, high]
        };
        let inputs: Vec<_> = boxes.iter().flat_map(four).collect();
        all.extend(probe.run(gpu, &[], &inputs)?[..boxes.len()].iter().map(|found| found[0] != 0));
    }
    Ok(all)
}

/// A place in the cone or on its surface, at any distance and scale, and the apex itself.
fn touching() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seeds = 4601..if is_long() { 2_004_601 } else { 104_601 };
    println!("seeds {seeds:?}");
    let (mut on_surface, mut boxes, mut names) = (0, Vec::new(), Vec::new());
    for seed in seeds {
        let mut random = Random::new(seed);
        let cone = random_cone(&mut random);
        let scale = 10.0_f32.powf(random.between(-4.0, 4.0));
        let far = [0.0, 1.0, 100.0][random.below(3)];
        let apex = [(); 3].map(|()| scale * random.between(-far, far));
        let half_angle = f64::from(cone.cosine).acos();
        let angle = half_angle
            * [1.0, f64::from(random.between(0.99, 1.0)), f64::from(random.between(0.0, 1.0))][random.below(3)];
        let distance = f64::from(scale) * [0.0, 1.0, f64::from(random.between(0.0, 3.0))][random.below(3)];
        let from = DVec3::from(apex.map(f64::from));
        let place = (from + distance * direction(&mut random, cone.axis, angle)).as_vec3().to_array();
        // Rounding may have moved it out.
        if inside(cone, from, DVec3::from(place.map(f64::from))) >= 0.0 {
            on_surface += usize::from(angle == half_angle);
            boxes.push((packed(cone, apex), box_around(&mut random, place, scale)));
            names.push((seed, cone, apex, place));
        }
    }
    let found = may_be_in_cone(gpu, &boxes)?;
    if let Some(at) = found.iter().position(|is_kept| !is_kept) {
        let ((seed, cone, apex, place), ends) = (names[at], boxes[at].1);
        return Err(format!("seed {seed}: {cone:?} at {apex:?} has {place:?}, not {ends:?}"));
    }
    let mut cases = Vec::new();
    // Exactly on the surface: 3, 4 and 5.
    for (cosine, corner, y) in
        [(0.6_f32, [3.0_f32, 4.0, 0.0], 1.0), (-0.6, [-3.0, 4.0, 0.0], -1.0), (0.0, [0.0, 1.0, 2.0], 1.0)]
    {
        let cone = packed(Cone { axis: [1.0, 0.0, 0.0], cosine }, [0.0; 3]);
        // Away from the cone, with the place at a corner. Then beside it.
        let ends = [corner[1].min(corner[1] + y), corner[1].max(corner[1] + y)];
        let ends = [[corner[0] - 1.0, ends[0], corner[2]], [corner[0], ends[1], corner[2]]];
        cases.extend([(cone, ends, true), (cone, ends.map(|[x, y, z]| [x - 0.01, y, z]), false)]);
    }
    // No cone, no box, and what is too large or no number.
    let down = packed(Cone { axis: [0.0, -1.0, 0.0], cosine: 0.9 }, [0.0; 3]);
    let up = [[-1.0, 2.0, -1.0], [1.0, 3.0, 1.0]];
    let none = LightCone { apex: [0.0; 4], ..down };
    cases.extend([
        (down, up, false),
        (none, up, true),
        (down, [up[1], up[0]], true),
        (down, [up[0], [1.0, f32::NAN, 1.0]], true),
        (down, up.map(|c| c.map(|c| 1e25 * c)), true),
        (down, up.map(|c| c.map(|c| 1e-12 * c)), true),
    ]);
    let found = may_be_in_cone(gpu, &cases.iter().map(|&(cone, ends, _)| (cone, ends)).collect::<Vec<_>>())?;
    for (&(cone, ends, expected), found) in cases.iter().zip(found) {
        same(&format!("{cone:?} {ends:?}"), &[found], &[expected])?;
    }
    println!("{on_surface} places on surfaces");
    if on_surface < 10_000 { Err("too few on surfaces".to_owned()) } else { Ok(()) }
}

/// Small boxes two degrees beside the cone, behind the light among them.
fn beside() -> Result<(), String> {
    let seeds = 4701..24_701;
    println!("seeds {seeds:?}");
    let (mut boxes, mut names) = (Vec::new(), Vec::new());
    for seed in seeds {
        let mut random = Random::new(seed);
        let cone = random_cone(&mut random);
        let half_angle = f64::from(cone.cosine).acos();
        let least = half_angle + 0.035;
        if least >= std::f64::consts::PI {
            continue;
        }
        let angle = match random.below(3) {
            0 => std::f64::consts::PI,
            _ => least + (std::f64::consts::PI - least) * f64::from(random.between(0.0, 1.0)),
        };
        let apex = random.direction();
        let place = DVec3::from(apex.map(f64::from)) + 3.0 * direction(&mut random, cone.axis, angle);
        let place = place.as_vec3().to_array();
        boxes.push((packed(cone, apex), [place.map(|c| c - 0.03), place.map(|c| c + 0.03)]));
        names.push((seed, cone, apex, place));
    }
    if let Some(at) = may_be_in_cone(&*Gpu::shared()?, &boxes)?.iter().position(|&is_kept| is_kept) {
        let (seed, cone, apex, place) = names[at];
        return Err(format!("seed {seed}: {cone:?} at {apex:?} keeps {place:?}"));
    }
    if boxes.len() < 10_000 { Err(format!("{} boxes", boxes.len())) } else { Ok(()) }
}

/// Whether some corner of a finite face is inside the light's cone, in `f64`.
fn certainly_in_cone(content: &Content, own: &Own, light: Light) -> bool {
    let Some(cone) = light.cone else { return true };
    let (_, rest, mesh) = &*content.meshes[own.mesh].0;
    let transform = |rows: &Matrix3x4| {
        let column = |c: usize| DVec3::from(rows.map(|row| f64::from(row[c])));
        DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
    };
    let apex = DVec3::from(light.xyz.map(f64::from)) / f64::from(light.w);
    mesh.faces().iter().filter(|face| face.iter().all(|&vertex| cpu::is_finite(rest[vertex as usize]))).flatten().any(
        |&vertex| {
            let place = match &own.placed {
                Placed::World(world) => DVec3::from(world[vertex as usize].map(f64::from)),
                Placed::Rigid(rows) => {
                    transform(rows).transform_point3(DVec3::from(rest[vertex as usize].map(f64::from)))
                }
            };
            inside(cone, apex, place) > 0.0
        },
    )
}

/// Whether a ball around the box of a rigid caster is beside the light's cone, by more than rounding may move it.
fn certainly_beside(content: &Content, own: &Own, light: Light) -> bool {
    let (Some(cone), Placed::Rigid(rows)) = (light.cone, &own.placed) else { return false };
    let (_, rest, mesh) = &*content.meshes[own.mesh].0;
    let finite = mesh.faces().iter().filter(|face| face.iter().all(|&vertex| cpu::is_finite(rest[vertex as usize])));
    let corners = finite.flatten().map(|&vertex| DVec3::from(rest[vertex as usize].map(f64::from)));
    let (low, high) =
        corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let apex = DVec3::from(light.xyz.map(f64::from)) / f64::from(light.w);
    // The box around the box that the matrix moves, and the largest number on the way.
    let (mut middle, mut half, mut size) = (DVec3::ZERO, DVec3::ZERO, apex.abs().max_element());
    for axis in 0..3 {
        let [x, y, z, by] = rows[axis].map(f64::from);
        let row = DVec3::new(x, y, z);
        middle[axis] = row.dot(0.5 * (low + high)) + by;
        half[axis] = row.abs().dot(0.5 * (high - low));
        size = size.max(row.abs().dot(low.abs().max(high.abs())) + by.abs());
    }
    let away = middle - apex;
    let cosine = away.normalize().dot(DVec3::from(cone.axis.map(f64::from)).normalize());
    let angle = cosine.clamp(-1.0, 1.0).acos() - f64::from(cone.cosine).acos();
    let beyond = away.length() * angle.clamp(0.0, std::f64::consts::FRAC_PI_2).sin();
    (1e-6..1e15).contains(&size) && beyond > half.length() + 1e-3 * size
}

/// The lights that matter, with changed lights, and the frame.
fn lights_of(
    gpu: &Gpu,
    scene: &mut RandomScene,
    mut change: impl FnMut(&mut Random, &mut Light),
) -> Result<(Vec<u32>, SceneFrame), String> {
    for index in 0..scene.content.lights.len() {
        let (handle, light) = &mut scene.content.lights[index];
        change(&mut scene.random, light);
        scene.scene.set_light(*handle, *light).map_err(text)?;
    }
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    let pairs = scene.content.casters.len() * frame.batches();
    let lit = gpu.read(frame.results().map_err(text)?.relevant_lights, pairs)?;
    Ok((lit, frame))
}

/// Pairs of a frame with cones.
#[derive(Default)]
struct Pairs {
    /// Casters that only the cone culls.
    left_out: usize,
    kept: usize,
    /// Words and bits of those that are left out and certainly beside the cone.
    beside: Vec<(usize, u32)>,
    /// Words and bits of those that are kept, with a corner in the cone.
    inside: Vec<(usize, u32)>,
}

/// Casters that only the cone culls have no corner in it, and those that are certainly beside it are culled. No other pair
/// changes.
fn check_cones(content: &Content, frame: &SceneFrame, lit: &[u32], uncut: &[u32]) -> Result<Pairs, String> {
    let mut pairs = Pairs::default();
    if let Some(at) = (0..lit.len()).find(|&at| lit[at] & !uncut[at] != 0) {
        return Err(format!("pair {at}: {:b}, without cones {:b}", lit[at], uncut[at]));
    }
    for own in &content.casters {
        let (index, _) = frame.locate(own.handle).ok_or("the frame lacks a caster")?;
        for (handle, light) in &content.lights {
            let (batch, bit) = (handle.bit() / 32, handle.bit() % 32);
            let at = batch as usize * content.casters.len() + index as usize;
            if uncut[at] >> bit & 1 == 0 {
                continue;
            }
            let is_in = certainly_in_cone(content, own, *light);
            let is_beside = certainly_beside(content, own, *light);
            match (lit[at] >> bit & 1 != 0, is_in) {
                (false, true) => return Err(format!("caster {index} has a corner in the cone of {light:?}")),
                (false, false) => {
                    pairs.left_out += 1;
                    pairs.beside.extend(is_beside.then_some((at, bit)));
                }
                (true, _) if is_beside => return Err(format!("caster {index} is kept beside the cone of {light:?}")),
                (true, _) => {
                    pairs.kept += 1;
                    pairs.inside.extend(is_in.then_some((at, bit)));
                }
            }
        }
    }
    Ok(pairs)
}

fn scenes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut left_out, mut kept, mut noticed, mut beside) = (0, 0, 0, 0);
    for seed in 4801..if is_long() { 4951 } else { 4831 } {
        println!("seed {seed}");
        let options = SceneOptions { max_lights: 40, ..Default::default() };
        let mut scene = RandomScene::new(gpu, seed, options)?;
        for _ in 0..=scene.random.below(40) {
            scene.add_light()?;
        }
        for _ in 0..=scene.random.below(20) {
            scene.insert(gpu)?;
        }
        for step in 0..2 {
            let uncut = lights_of(gpu, &mut scene, |_, light| light.cone = None)?.0;
            let (lit, frame) = lights_of(gpu, &mut scene, |random, light| {
                let cone = random_cone(random);
                light.cone = (step == 0 || random.below(2) == 0).then_some(cone);
            })?;
            let pairs = check_cones(&scene.content, &frame, &lit, &uncut)?;
            (left_out, kept, noticed) = (left_out + pairs.left_out, kept + pairs.kept, noticed + pairs.inside.len());
            beside += pairs.beside.len();
            if let Some(&(at, bit)) = pairs.inside.first() {
                let mut wrong = lit.clone();
                wrong[at] &= !(1 << bit);
                must_fail("a light that is left out", &check_cones(&scene.content, &frame, &wrong, &uncut).map(drop))?;
            }
            if let Some(&(at, bit)) = pairs.beside.first() {
                let mut wrong = lit.clone();
                wrong[at] |= 1 << bit;
                must_fail("a caster that is kept", &check_cones(&scene.content, &frame, &wrong, &uncut).map(drop))?;
            }
        }
        let refused =
            scene.scene.add_light(Light::point([0.0; 3]).with_cone(Cone { axis: [0.0; 3], cosine: 0.5 })).err();
        let error = LightError::Cone { index: 0, axis: [0.0; 3], cosine: 0.5 };
        same("a cone without an axis", &[refused], &[Some(ShadowError::Light(error))])?;
    }
    println!(
        "{left_out} pairs left out by cones, {beside} certainly beside; {noticed} of {kept} others with a corner inside"
    );
    if beside < 500 || noticed < 500 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}
