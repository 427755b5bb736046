//! Cones of spot lights: no box is culled that touches a cone. `found.rs` checks that casters beside one are.

use glam::DVec3;
use rimline::Cone;
use rimline::internals::layout::LightCone;
use rimline::internals::stages::NEEDS;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::probe::Probe;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::direction;
use rimline_testkit::{is_long, same};

pub(crate) const TESTS: &[Test] = &[("boxes_that_touch_a_cone_are_kept", touching)];

/// How far a point is inside a cone, as a cosine: positive inside.
pub(crate) fn inside(cone: Cone, apex: DVec3, point: DVec3) -> f64 {
    let axis = DVec3::from(cone.axis.map(f64::from)).normalize();
    let away = point - apex;
    if away.length() == 0.0 { 1.0 } else { away.normalize().dot(axis) - f64::from(cone.cosine) }
}

/// The cone in the scene's layout.
fn packed(cone: Cone, apex: [f32; 3]) -> LightCone {
    let axis = DVec3::from(cone.axis.map(f64::from)).normalize().as_vec3();
    LightCone { apex: [apex[0], apex[1], apex[2], 1.0], axis: [axis.x, axis.y, axis.z, cone.cosine] }
}

pub(crate) fn random_cone(random: &mut Random) -> Cone {
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
fn at_angle(random: &mut Random, axis: [f32; 3], angle: f64) -> DVec3 {
    let axis = DVec3::from(axis.map(f64::from)).normalize();
    let any = direction(random);
    let across = (any - any.dot(axis) * axis).normalize_or_zero();
    angle.cos() * axis + angle.sin() * across
}

/// A box with a point at a corner, on a side, or within.
fn box_around(random: &mut Random, point: [f32; 3], size: f32) -> [[f32; 3]; 2] {
    let [mut low, mut high] = [point; 2];
    for (low, high) in low.iter_mut().zip(&mut high) {
        let sides = [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]][random.below(3)];
        *low -= sides[0] * random.between(0.0, size);
        *high += sides[1] * random.between(0.0, size);
    }
    [low, high]
}

/// A cone and the ends of a box.
type Boxed = (LightCone, [[f32; 3]; 2]);

/// Whether the boxes may have a point in their cones, by the WGSL. No term of their ends is larger than the ends.
fn may_be_in_cone(gpu: &Gpu, boxes: &[Boxed]) -> Result<Vec<bool>, String> {
    let [apex, axis, low, high] = [0, 1, 2, 3].map(|at| format!("probe_inputs[4u * index + {at}u]"));
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

/// A point in the cone or on its surface, at any distance and scale, and the apex itself.
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
        let angle = half_angle * f64::from([1.0, random.between(0.99, 1.0), random.between(0.0, 1.0)][random.below(3)]);
        let distance = f64::from(scale * [0.0, 1.0, random.between(0.0, 3.0)][random.below(3)]);
        let from = DVec3::from(apex.map(f64::from));
        let point = (from + distance * at_angle(&mut random, cone.axis, angle)).as_vec3().to_array();
        // Rounding may have moved it out.
        if inside(cone, from, DVec3::from(point.map(f64::from))) >= 0.0 {
            on_surface += usize::from(angle == half_angle);
            boxes.push((packed(cone, apex), box_around(&mut random, point, scale)));
            names.push((seed, cone, apex, point));
        }
    }
    let found = may_be_in_cone(gpu, &boxes)?;
    if let Some(at) = found.iter().position(|is_kept| !is_kept) {
        let ((seed, cone, apex, point), ends) = (names[at], boxes[at].1);
        return Err(format!("seed {seed}: {cone:?} at {apex:?} has {point:?}, not {ends:?}"));
    }
    let mut cases = Vec::new();
    // Exactly on the surface: 3, 4 and 5.
    for (cosine, corner, y) in
        [(0.6_f32, [3.0_f32, 4.0, 0.0], 1.0), (-0.6, [-3.0, 4.0, 0.0], -1.0), (0.0, [0.0, 1.0, 2.0], 1.0)]
    {
        let cone = packed(Cone { axis: [1.0, 0.0, 0.0], cosine }, [0.0; 3]);
        // Away from the cone, with the point at a corner. Then beside it.
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
