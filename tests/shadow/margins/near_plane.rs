//! Vertices next to the near plane, and seen from the light on it.

use glam::{DVec2, DVec3};
use rimline::Light;
use rimline::internals::shadow;
use rimline::internals::stages::{CAPS, SIDES};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::scenes::{PROJECTIONS, Pose, direction};

use super::view::{Eye, stepped};
use crate::vertices::{ExactView, OfEdge, Star};
use rimline_testkit::stage_probe::Probe;

pub(super) const TESTS: &[Test] = &[
    ("sides_from_vertices_a_few_ulps_behind_the_near_plane_begin_behind_it", sides_begin_behind),
    ("near_caps_are_as_exact_as_the_better_of_two_forms", exact_near_caps),
    ("faces_that_graze_the_pyramid_have_their_caps", grazing_faces),
];

/// A vertex of a side that is behind the near plane by its height is not before it by its depth.
fn sides_begin_behind() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(221)?;
    let (mut near, mut would_be_cut) = (0, 0);
    let (mut seen, mut edges) = (Vec::new(), Vec::new());
    for number in 0..if is_long() { 200_000 } else { 6000 } {
        let scale = [1.0, 0.1, 1e3][number % 3];
        let middle = direction(&mut random) * scale * [0.0, 30.0][number / 3 % 2];
        let pose = Pose::random(&mut random, middle, scale);
        let camera = pose.camera(number % PROJECTIONS, random.below(2) == 0);
        let eye = Eye::new(&camera);
        let at = [0, 1].map(|_: i32| f64::from(random.between(-1.0, 1.0)));
        let mut first = eye.on_near_plane(at).as_vec3().to_array();
        let axis = random.below(3);
        first[axis] = stepped(first[axis], random.below(9) as i32 - 4);
        let second = (pose.eye + direction(&mut random) * scale * 3.0).as_vec3().to_array();
        let view = shadow::view(&camera).expect("a good camera");
        let light = Light::point((pose.eye + direction(&mut random) * scale * 5.0).as_vec3().to_array());
        let light = shadow::light(&camera, &view, light);
        edges.push((seen.len() as u32, [first, second]));
        seen.push((view, light));
    }
    let of_edges = OfEdge::of(&gpu, &seen, &edges)?;
    // The strip in both directions.
    let probe = Probe::of(
        &gpu,
        &SIDES,
        [2, 10],
        "for (var vertex = 0u; vertex < 5u; vertex++) {
      out[vertex] = clipped_side_vertex(pair.view, pair.light, input_position(0u), input_position(1u), true, vertex);
      out[vertex + 5u] = clipped_side_vertex(pair.view, pair.light, input_position(1u), input_position(0u), false, vertex);
    }",
    )?;
    for (number, (of_edge, strips)) in of_edges.iter().zip(probe.run(&gpu, &[], &seen, &edges)?).enumerate() {
        let (view, _) = seen[number];
        let (corner, height) = (of_edge.near()[0], of_edge.heights()[0]);
        if height < 0.0 {
            continue;
        }
        near += 1;
        let is_before = |[_, _, z, w]: [f32; 4]| if view.near_z == 0.0 { z < 0.0 } else { z > w };
        would_be_cut += usize::from(is_before(corner));
        for strip in strips.chunks(5) {
            let is_first = |clip: &&[f32; 4]| [clip[0], clip[1], clip[3]] == [corner[0], corner[1], corner[3]];
            let found = strip.iter().find(is_first).expect("the vertex itself");
            assert!(!is_before(*found), "{number}: {found:?} for a height of {height}");
        }
    }
    println!("{near} vertices, {would_be_cut} of them before the near plane by the depth of `to_clip`");
    assert!(near > 1000 && would_be_cut > 30, "not vacuous");
    Ok(())
}

fn exact_near_caps() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(222)?;
    let (mut by_vertex, mut by_light) = (0, 0);
    let (mut seen, mut positions, mut cameras) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..if is_long() { 200_000 } else { 12_000 } {
        // Positions relative to the eye; light and vertex far from it and near each other, or the vertex near the eye and
        // the light far away.
        let middle = direction(&mut random) * 1e3;
        let pose = Pose::random(&mut random, middle, 1.0);
        let camera = pose.camera(number % 4, true);
        let eye = Eye::new(&camera);
        let far = 10_f64.powf(f64::from(random.between(0.0, 6.0)));
        let at = eye.on_near_plane([0, 1].map(|_: i32| f64::from(random.between(-1.0, 1.0))));
        // Beyond the near plane, so that the vertex is between.
        let away = (pose.forward + direction(&mut random) * 0.7).normalize();
        let light = (at + away * far).as_vec3();
        let part = 10_f64.powf(-f64::from(random.between(0.0, 6.0)));
        let part = if random.below(2) == 0 { part } else { 1.0 - part };
        let position = (light.as_dvec3() + (at - light.as_dvec3()) * part).as_vec3().to_array();
        let view = shadow::view(&camera).expect("a good camera");
        let light = shadow::light(&camera, &view, Light::point(light.to_array()));
        positions.push((seen.len() as u32, [position; 2]));
        seen.push((view, light));
        cameras.push((camera, far, part));
    }
    let of_edges = OfEdge::of(&gpu, &seen, &positions)?;
    for (number, (of_edge, (camera, far, part))) in of_edges.iter().zip(cameras).enumerate() {
        let ((view, light), (_, [position, _])) = (&seen[number], positions[number]);
        if (of_edge.heights()[0] >= 0.0) == (of_edge.far_heights()[0] >= 0.0) {
            continue;
        }
        let exact_view = ExactView::new(&camera, view, light);
        let Star { exact, by_vertex: vertex, by_light: nearer } = exact_view.star(&exact_view.vertex(position));
        let [vertex, nearer] = [vertex, nearer].map(DVec2::max_element);
        let near_w = f64::from(view.near_w);
        let [x, y, _, w] = of_edge.stars()[0].map(f64::from);
        let found = DVec2::new(x, y) * (near_w / w);
        // The choice is by the largest coordinates, so it may miss the better form by a small factor.
        let bound = 8.0 * vertex.min(nearer);
        if !bound.is_finite() || bound > 0.5 * near_w {
            continue;
        }
        by_vertex += usize::from(100.0 * vertex < nearer);
        by_light += usize::from(100.0 * nearer < vertex);
        let error = (found - exact).abs().max_element();
        assert!(error <= bound, "{number}: {found}, exact {exact}, bound {bound}, light {far} away, {part} of the way");
    }
    println!("{by_vertex} where the vertex's own form is much better, {by_light} where the light's is");
    assert!(by_vertex > 100 && by_light > 100, "not vacuous");
    Ok(())
}

/// A face that reaches into the pyramid of light and near rectangle by next to nothing has its cap.
fn grazing_faces() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(223)?;
    let (mut grazing, mut listed) = (0, [0; 2]);
    let (mut seen, mut faces, mut expected) = (Vec::new(), Vec::new(), Vec::new());
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
        let is_clear = number % 4 == 0;
        let corners = [corner(if is_clear { 0.01 } else { -1e-9 }), corner(0.1), corner(0.2)];
        let [inside, part] = {
            let (at, part) = eye.seen_from_light(given, DVec3::from(corners[0].map(f64::from)));
            [at[0].abs().max(at[1].abs()), part]
        };
        let view = shadow::view(&camera).map_err(text)?;
        faces.push((seen.len() as u32, corners));
        seen.push((view, shadow::light(&camera, &view, Light::point(light.to_array()))));
        expected.push((inside, part));
    }
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
        } else if inside > 1.005 {
            listed[usize::from(is_listed)] += 1;
        }
    }
    println!("{grazing} faces graze the pyramid; of those beside it {listed:?} are out and listed");
    assert!(grazing > 2000 && listed[0] > 500, "not vacuous");
    Ok(())
}
