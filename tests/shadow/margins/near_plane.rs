//! Vertices seen from the light on the near plane, and faces next to the pyramid of both.

use glam::{DVec2, DVec3};
use rimline::Light;
use rimline::internals::shadow::{self, COUNT_AUTO, COUNT_ZP_PLUS};
use rimline::internals::stages::CAPS;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::scenes::{PROJECTIONS, Pose, direction};

use super::view::{Eye, chosen, options};
use crate::vertices::{ExactView, OfEdge, Star};
use rimline_testkit::stage_probe::Probe;

pub(super) const TESTS: &[Test] = &[
    ("near_caps_are_as_exact_as_the_better_of_two_forms", exact_near_caps),
    ("faces_that_graze_the_pyramid_have_their_caps", grazing_faces),
];

/// Positions relative to the eye; light and vertex far from it and near each other, or the vertex near the eye and the light
/// far away.
fn exact_near_caps() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(222)?;
    let (mut by_vertex, mut by_light) = (0, 0);
    let (mut seen, mut positions, mut cameras) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..if is_long() { 200_000 } else { 12_000 } {
        let middle = direction(&mut random) * 1e3;
        let pose = Pose::random(&mut random, middle, 1.0);
        let camera = pose.camera(number % 4, true);
        let at = Eye::new(&camera).on_picture(&mut random);
        // Beyond the near plane, so that the vertex is between.
        let away = (pose.forward + direction(&mut random) * 0.7).normalize();
        let light = (at + away * 10_f64.powf(f64::from(random.between(0.0, 6.0)))).as_vec3();
        let part = 10_f64.powf(-f64::from(random.between(0.0, 6.0)));
        let part = if random.below(2) == 0 { part } else { 1.0 - part };
        let position = (light.as_dvec3() + (at - light.as_dvec3()) * part).as_vec3().to_array();
        let view = shadow::view(&camera).expect("a good camera");
        positions.push((seen.len() as u32, [position; 2]));
        seen.push((view, shadow::light(&camera, &view, Light::point(light.to_array()))));
        cameras.push(camera);
    }
    for (number, of_edge) in OfEdge::of(&gpu, &seen, &positions)?.iter().enumerate() {
        let ((view, light), (_, [position, _])) = (&seen[number], positions[number]);
        if (of_edge.heights[0] >= 0.0) == (of_edge.far_heights[0] >= 0.0) {
            continue;
        }
        let exact_view = ExactView::new(&cameras[number], view, light);
        let Star { exact, by_vertex: vertex, by_light: nearer } = exact_view.star(&exact_view.vertex(position));
        let [vertex, nearer] = [vertex, nearer].map(DVec2::max_element);
        let near_w = f64::from(view.near_w);
        let [x, y, _, w] = of_edge.stars[0].map(f64::from);
        let found = DVec2::new(x, y) * (near_w / w);
        // The choice is by the largest coordinates, so it may miss the better form by a small factor.
        let bound = 8.0 * vertex.min(nearer);
        if !bound.is_finite() || bound > 0.5 * near_w {
            continue;
        }
        by_vertex += usize::from(100.0 * vertex < nearer);
        by_light += usize::from(100.0 * nearer < vertex);
        let error = (found - exact).abs().max_element();
        assert!(error <= bound, "{number}: {found}, exact {exact}, bound {bound}, {position:?}, {light:?}");
    }
    println!("{by_vertex} where the vertex's own form is much better, {by_light} where the light's is");
    assert!(by_vertex > 100 && by_light > 100, "not vacuous");
    Ok(())
}

/// A face that reaches into the pyramid of light and near rectangle by next to nothing has its cap, and a caster with that
/// face alone is counted by ZP+.
fn grazing_faces() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(223)?;
    let (mut grazing, mut listed) = (0, [0; 2]);
    let (mut cases, mut expected) = (Vec::new(), Vec::new());
    for number in 0..if is_long() { 200_000 } else { 12_000 } {
        let scale = [1.0, 1e3][number % 2];
        let middle = direction(&mut random) * scale * [0.0, 20.0][number / 2 % 2];
        let pose = Pose::random(&mut random, middle, scale);
        let camera = pose.camera(number % PROJECTIONS, random.below(2) == 0);
        let eye = Eye::new(&camera);
        let light = (pose.eye + direction(&mut random) * scale * f64::from(random.between(1.0, 9.0))).as_vec3();
        let given = light.as_dvec3();
        if eye.height(given).abs() < 0.05 {
            continue;
        }
        // A corner at a plane of the pyramid, the others outside of that plane.
        let (side, sign) = (random.below(2), [-1.0, 1.0][random.below(2)]);
        let mut corner = |beyond: f64| {
            let mut at = [0, 1].map(|_: i32| f64::from(random.between(-0.9, 0.9)));
            at[side] = sign * (1.0 + beyond);
            (given + (eye.on_near_plane(at) - given) * f64::from(random.between(0.2, 0.8))).as_vec3().to_array()
        };
        let corners = [corner(if number % 4 == 0 { 0.01 } else { -1e-9 }), corner(0.1), corner(0.2)];
        let ([x, y], part) = eye.seen_from_light(given, DVec3::from(corners[0].map(f64::from)));
        cases.push((camera, Light::point(light.to_array()), corners.to_vec()));
        expected.push((x.abs().max(y.abs()), part));
    }
    let seen = chosen(&gpu, options(COUNT_AUTO, false), &cases)?;
    let faces: Vec<_> = (0..).zip(&cases).map(|(number, case)| (number, [0, 1, 2].map(|at| case.2[at]))).collect();
    let probe = Probe::of(
        &gpu,
        &CAPS,
        [3, 1],
        "out[0].x = select(1.0, 0.0, is_outside_pyramid(pair.view, pair.light, input_position(0u), input_position(1u), input_position(2u)));",
    )?;
    for (number, (found, (inside, part))) in probe.run(&gpu, &[], &seen, &faces)?.iter().zip(expected).enumerate() {
        let is_listed = found[0][0] == 1.0;
        if inside < 1.0 - 1e-12 && part > 0.0 && part < 1.0 {
            grazing += 1;
            assert!(is_listed, "{number}: a corner at {inside} of the near rectangle is left out");
            assert_eq!(seen[number].1.counting, COUNT_ZP_PLUS, "{number}: a corner at {inside} of the near rectangle");
        } else if inside > 1.005 {
            listed[usize::from(is_listed)] += 1;
        }
    }
    println!("{grazing} faces graze the pyramid; of those beside it {listed:?} are out and listed");
    assert!(grazing > 2000 && listed[0] > 500, "not vacuous");
    Ok(())
}
