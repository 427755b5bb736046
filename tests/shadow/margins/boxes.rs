//! Boxes that just touch: the caster's with the near rectangle's, and with the light.

use glam::DVec3;
use rimline::Light;
use rimline::reference::layout::ShadowShape;
use rimline::reference::shadow::{CAST_AVERTED, CAST_EVERY, COUNT_AUTO};
use rimline_testkit::shapes::{self, Shape};

use crate::view::{Eye, around, chosen, stepped};
use rimline_testkit::is_long;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{PROJECTIONS, Pose, direction};

const CLOSED: ShadowShape = ShadowShape {
    casters: 1,
    lights: 1,
    batches: 1,
    faces: 0,
    edges: 0,
    capacity: 0,
    side_capacity: 0,
    near_capacity: 0,
    far_capacity: 0,
    averted: 1,
    counting: COUNT_AUTO,
    skip_unseen: 0,
    skip_unreached: 1,
    end_at_range: 0,
    choices_at: 0,
    measures_at: 0,
    lights_at: 0,
    face_chunks_at: 0,
    edge_chunks_at: 0,
    views: 1,
    count_batches: 1,
    proxies: 0,
    part: 0,
    first_caster: 0,
    lists_at: 0,
    keeps: 0,
    needs_boxes: 0,
    used_lights: 0,
    has_receivers: 0,
    most_count: 255,
};

/// A closed cube's faces with these lowest and highest corners.
fn block(low: [f32; 3], high: [f32; 3]) -> Shape {
    let mut shape = shapes::cube();
    for position in &mut shape.positions {
        *position = std::array::from_fn(|axis| if position[axis] < 0.0 { low[axis] } else { high[axis] });
    }
    shape
}

/// Or miss it by a few ulps: what is seen is decided by the rasteriser's near plane, which rounding moves that far.
#[test]
fn casters_that_touch_the_near_rectangle_cast_with_every_face() {
    let seed = 201;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut touching, mut apart) = (0, 0);
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let scale = [1.0, 0.01, 1e3][number % 3];
        let middle = direction(&mut random) * scale * [0.0, 10.0, 1e3][number / 3 % 3];
        let pose = Pose::random(&mut random, middle, scale);
        let camera = pose.camera(number % PROJECTIONS, random.below(2) == 0);
        let [near_low, near_high] = Eye::new(&camera).near_box();
        // Its near side is at the rectangle's, or some ulps off; along the other axes it is all around it.
        let (axis, is_below) = (random.below(3), random.below(2) == 0);
        let size = f64::from(random.between(0.5, 3.0)) * scale;
        let (mut low, mut high) = ((near_low - size).as_vec3().to_array(), (near_high + size).as_vec3().to_array());
        let touches = random.below(4) > 0;
        let coordinates = near_low.abs().max(near_high.abs());
        let ulps = f64::from(random.between(0.0, 4.0)) / 8_388_608.0;
        let distance = if touches { ulps * coordinates[axis] } else { 1e-3 * (scale + coordinates.max_element()) };
        if is_below {
            let [_, above] = around(near_low[axis] - distance);
            (low[axis], high[axis]) = (above - size as f32, above);
        } else {
            let [below, _] = around(near_high[axis] + distance);
            (low[axis], high[axis]) = (below, below + size as f32);
        }
        let Shape { positions, faces } = block(low, high);
        let light = Light::point((near_high + DVec3::splat(10.0 * scale + size)).as_vec3().to_array());
        let (_, light) = chosen(&camera, light, CLOSED, &positions, &faces);
        if touches {
            touching += 1;
            assert_eq!(light.casting, CAST_EVERY, "{number}: {low:?} to {high:?}, near {near_low} to {near_high}");
        } else {
            apart += usize::from(light.casting == CAST_AVERTED);
        }
    }
    println!("{touching} touch; {apart} are apart and cast with their averted faces");
    assert!(touching > 1000 && apart > 500, "not vacuous");
}

/// By products of two `f32`, which `f64` holds exactly.
#[test]
fn lights_in_the_casters_box_make_every_face_cast() {
    let seed = 202;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut within, mut at_the_edge, mut apart) = (0, 0, 0);
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let scale = [1.0, 1e-3, 1e4][number % 3];
        let middle = direction(&mut random) * f64::from(scale) * [0.0, 1e3][number / 3 % 2];
        let corner = |random: &mut Random| middle + direction(random) * f64::from(scale);
        let (p, q) = (corner(&mut random), corner(&mut random));
        let [low, high] = [p.min(q), p.max(q)].map(|corner| corner.as_vec3().to_array());
        // From outside the box, far away.
        let pose = Pose::random(&mut random, middle + DVec3::splat(50.0 * f64::from(scale)), f64::from(scale));
        let camera = pose.camera(number % PROJECTIONS, random.below(2) == 0);
        let w = [1.0, 0.5, random.between(0.1, 5.0), 0.0][random.below(4)];
        // On a side, an edge or a corner, or an ulp off; of another w, what rounding makes of it.
        let mut at: [f32; 3] =
            std::array::from_fn(|axis| low[axis] + (high[axis] - low[axis]) * random.between(0.0, 1.0));
        let is_free = random.below(4) == 0;
        for (axis, at) in at.iter_mut().enumerate().take(1 + random.below(3)) {
            let side = [low, high][random.below(2)][axis];
            *at = if is_free {
                side + random.between(-1.0, 1.0) * scale
            } else {
                stepped(side, random.below(3) as i32 - 1)
            };
        }
        let weight = if w == 0.0 { 1.0 } else { w };
        let light = Light::homogeneous([at[0] * weight, at[1] * weight, at[2] * weight, w]);
        let product = |at: f32| f64::from(at) * f64::from(w);
        let xyz = light.xyz.map(f64::from);
        let is_within =
            w > 0.0 && (0..3).all(|axis| product(low[axis]) <= xyz[axis] && xyz[axis] <= product(high[axis]));
        let Shape { positions, faces } = block(low, high);
        let (_, light) = chosen(&camera, light, CLOSED, &positions, &faces);
        if is_within {
            within += 1;
            at_the_edge += usize::from(!is_free);
            assert_eq!(light.casting, CAST_EVERY, "{number}: {at:?} and {w}, {low:?} to {high:?}");
        } else {
            apart += usize::from(light.casting == CAST_AVERTED);
        }
        if w == 0.0 {
            assert_eq!(light.casting, CAST_AVERTED, "{number}: a light at infinity is in no box");
        }
    }
    println!("{within} within the box, {at_the_edge} of them at its edge; {apart} apart");
    assert!(at_the_edge > 300 && apart > 500, "not vacuous");
}

/// The published ZP+ clips nothing of the caster: the near end of the light's frustum is before it.
#[test]
fn the_published_frustum_begins_before_the_caster() {
    let seed = 203;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut seen, mut near) = (0, 0);
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let pose = Pose::random(&mut random, DVec3::ZERO, 1.0);
        // Perspective, as the paper has it.
        let camera = pose.camera(number % 4, random.below(2) == 0);
        let eye = Eye::new(&camera);
        let light = (pose.eye + direction(&mut random) * f64::from(random.between(1.0, 9.0))).as_vec3();
        let given = light.as_dvec3();
        if eye.height(given).abs() < 0.05 {
            continue;
        }
        let through = eye.on_near_plane([0, 0].map(|_: i32| f64::from(random.between(-0.99, 0.99))));
        let part = 0.01 * 95_f64.powf(f64::from(random.between(0.0, 1.0)));
        let place = given + (through - given) * part;
        let size = 1e-3 * part;
        let corners = [0, 1, 2].map(|_: i32| (place + direction(&mut random) * size).as_vec3().to_array());
        let shape = ShadowShape { counting: rimline::reference::shadow::COUNT_ZP_PLUS_2005, averted: 0, ..CLOSED };
        let ranged = Light::point(light.to_array());
        let (view, light) = chosen(&camera, ranged, shape, &corners, &[[0, 1, 2]]);
        let cap =
            rimline::reference::cpu::zp_plus_2005_cap(&view, &light, [0, 1, 2].map(|at| (at as u32, corners[at])));
        for (corner, clip) in corners.into_iter().zip(cap) {
            let ([x, y], part) = eye.seen_from_light(given, DVec3::from(corner.map(f64::from)));
            if x.abs().max(y.abs()) < 0.999 && part > 0.005 && part < 0.99 {
                seen += 1;
                near += usize::from(part < 0.2);
                let rounding = 1e-4 * clip.w;
                assert!(
                    clip.w > 0.0 && clip.z >= -rounding && clip.z <= clip.w + rounding,
                    "{number}: {clip} at {part} of the way, the frustum begins at {}",
                    light.frustum_near
                );
            }
        }
    }
    println!("{seen} corners between light and near rectangle, {near} of them near the light");
    assert!(near > 500, "not vacuous");
}
