//! Lights that reach only so far: casters out of range, and volumes that end there.

use glam::DVec3;
use rimline::{Cone, Counting, Light};
use rimline_testkit::OneCasterOptions;

use crate::classes::{CLASSES, Class};
use crate::rays::{self, Truth};
use crate::render::{Placing, Renderer};
use crate::scene::{Body, Frame};
use crate::trials::{Test, Traced, class};
use rimline_testkit::device::Gpu;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, shapes};

pub(crate) const TESTS: &[Test] = &[
    ("volumes_end_at_the_range", ended),
    ("receivers_just_within_the_range_are_in_shadow", just_within),
    ("casters_out_of_range_are_skipped", skipped),
    ("casters_out_of_the_cone_throw_no_shadow_into_it", cones),
];

fn place(light: Light) -> DVec3 {
    DVec3::from(light.xyz.map(f64::from)) / f64::from(light.w)
}

/// A frame, of which rays see nothing out of the light's range; and what they see there.
pub(crate) fn in_range(class: &Class, number: u64) -> (Traced, Vec<Vec<Truth>>, f32) {
    let mut traced = Traced::new(class, number);
    let light = place(traced.frame.lights[0]);
    let casters = traced.frame.bodies.iter().filter(|body| body.casts);
    let corners = casters
        .flat_map(|body| body.finite_faces().into_iter().flatten().map(|vertex| body.shape.positions[vertex as usize]));
    let distances: Vec<f64> = corners.map(|p| DVec3::from(p.map(f64::from)).distance(light)).collect();
    let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
    let farthest = distances.iter().copied().fold(0.0, f64::max);
    // From some of the casters to a good way behind them.
    let range = (nearest + (farthest - nearest) * f64::from(Random::new(traced.seed).between(0.3, 3.0))) as f32;
    let mut beyond = traced.truths.clone();
    for ((truth, beyond), point) in traced.truths.iter_mut().zip(&mut beyond).zip(rays::points(&traced.frame)) {
        let is_in = point.is_some_and(|point| point.distance(light) <= f64::from(range));
        let outside = if is_in { beyond } else { truth };
        outside[0] = Truth::Background;
    }
    (traced, beyond, range)
}

/// Within the range all is as ever, by every method; out of it shadows are gone.
fn ended() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let options = OneCasterOptions { end_at_range: true, ..OneCasterOptions::default() };
    let methods = [Counting::Auto, Counting::ZpPlus, Counting::ZFail, Counting::ZpPlus2005];
    let (mut volumes, mut shadowed, mut gone) = ([0; 4], 0, [0; 4]);
    for class in CLASSES.iter().filter(|class| class.name != "directional lights") {
        for number in 50..if is_long() { 70 } else { 51 } {
            let (traced, beyond, range) = in_range(class, number);
            let renderer = Renderer { options, range, ..Renderer::new(&gpu) };
            shadowed += traced.shadowed();
            for (method, counting) in methods.into_iter().enumerate() {
                // Their volumes never end, and the published one is not right everywhere.
                let is_endless = matches!(counting, Counting::ZpPlus | Counting::ZpPlus2005);
                if is_endless && class.name != "camera outside the shadow" {
                    continue;
                }
                let (_, counted) = traced
                    .check(&renderer, counting, !class.touches)
                    .map_err(|error| format!("{}, range {range}: {error}", class.name))?;
                volumes[method] += counted.statistics.iter().map(|statistics| statistics.ended).sum::<u32>();
                let stencil = counted.stencils[0].iter();
                gone[method] +=
                    stencil.zip(&beyond).filter(|(count, truth)| **count == 0 && truth[0].is_shadowed()).count();
            }
        }
    }
    println!("{shadowed} pixels in shadow; by auto, ZP+, z-fail, ZP+ as published:");
    println!("{volumes:?} volumes ended, {gone:?} pixels out of range not in shadow any more");
    let is_right = volumes[0] > 0 && volumes[1] == 0 && volumes[2] > 0 && volumes[3] == 0;
    if is_right && shadowed > 0 && gone[0] > 0 && gone[2] > 0 {
        return control(&gpu);
    }
    Err("volumes ended where they should not, or did not where they should".to_owned())
}

/// A range that is said to be smaller than it is leaves shadows out that the rays see.
fn control(gpu: &Gpu) -> Result<(), String> {
    let options = OneCasterOptions { end_at_range: true, ..OneCasterOptions::default() };
    let class = class("camera outside the shadow")?;
    let traced = Traced::new(class, 50);
    let distance = place(traced.frame.lights[0]).length() as f32;
    for counting in [Counting::Auto, Counting::ZPass, Counting::ZFail] {
        let renderer = Renderer { options, range: distance, ..Renderer::new(gpu) };
        must_fail("a range too small", &traced.check(&renderer, counting, false))?;
        let renderer = Renderer { range: 30.0, ..renderer };
        let (_, counted) = traced.check(&renderer, counting, true)?;
        if counted.statistics.iter().all(|statistics| statistics.ended == 0) {
            return Err(format!("{counting:?}: no volume ended"));
        }
    }
    Ok(())
}

/// A plate right below the light, and a floor that the range hardly reaches: the volume ends just below it. Volumes that
/// ended early would leave the spot in the middle of the shadow lit.
fn just_within() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let options = OneCasterOptions { end_at_range: true, ..OneCasterOptions::default() };
    let class = CLASSES.first().ok_or("no classes")?;
    for (height, floor) in [(1.0_f32, 4.0_f32), (0.5, 6.0), (2.0, 4.5)] {
        let plate = shapes::cube().placed(|[x, y, z]| [x, 0.05 * y - 0.05 - height, z]);
        let mut frame: Frame = (class.frame)(&mut Random::new(1));
        frame.bodies = vec![Body::caster(plate), Body::room([0.0, 8.0 - floor, 0.0], 8.0)];
        frame.lights = vec![Light::point([0.0; 3])];
        // Looking past the plate, from outside of the shadow.
        let spot = DVec3::new(0.0, -f64::from(floor), 0.0);
        let place = DVec3::new(2.5, -0.3 * f64::from(height), 0.4);
        (frame.eye.place, frame.eye.forward, frame.eye.near) = (place, spot - place, 0.05);
        let range = floor * 1.02;
        let mut traced = Traced::of(frame, 0);
        for (truth, point) in traced.truths.iter_mut().zip(rays::points(&traced.frame)) {
            if point.is_none_or(|point| point.length() > f64::from(range)) {
                truth[0] = Truth::Background;
            }
        }
        let in_shadow = traced.shadowed();
        for counting in [Counting::Auto, Counting::ZPass, Counting::ZFail] {
            let renderer = Renderer { options, range, ..Renderer::new(&gpu) };
            let what = |error| format!("plate at {height}, floor at {floor}: {error}");
            let (_, counted) = traced.check(&renderer, counting, true).map_err(what)?;
            if counted.statistics[0].ended != 1 || in_shadow < 100 {
                return Err(what(format!("{in_shadow} pixels in shadow, {:?}", counted.statistics)));
            }
            // The negative control: a range that is a fifth less.
            let early = Renderer { range: 0.8 * range, ..renderer };
            must_fail("a volume that ends early", &traced.check(&early, counting, false))?;
        }
    }
    Ok(())
}

/// Chosen or not, by the caster's nearest corner, edge or side.
fn skipped() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let class = CLASSES.first().ok_or("no classes")?;
    // A cube from -0.5 to 0.5, and lights off its sides, edges and corners.
    for (light, distance) in [([3.5, 0.1, -0.2], 3.0_f32), ([-0.1, 4.5, -3.5], 5.0), ([1.5, -2.5, 2.5], 3.0)] {
        for (range, casts) in [(distance * 0.999, false), (distance * 1.001, true), (distance * 1.3, true)] {
            let mut frame: Frame = (class.frame)(&mut Random::new(1));
            frame.bodies = vec![Body::caster(shapes::cube()).scaled(0.5), Body::room([0.0; 3], 8.0)];
            // Another w is the same place.
            for w in [1.0, 0.3] {
                let [x, y, z] = light;
                frame.lights = vec![Light::homogeneous([x * w, y * w, z * w, w])];
                let options = OneCasterOptions { cull_by_view: false, ..OneCasterOptions::default() };
                let counted = Renderer { options, range, ..Renderer::new(&gpu) }.count(&frame, Counting::Auto)?;
                let got = (counted.chosen[0][0].casting != 0, counted.statistics[0].skipped == 0);
                if got != (casts, casts) {
                    return Err(format!("light {light:?}, w {w}, range {range}: {got:?}, expected {casts}"));
                }
            }
        }
    }
    Ok(())
}

/// Rigid casters of a scene, some of them outside of the light's cone: what is seen within the cone is as without one.
fn cones() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let (mut compared, mut shadowed, mut gone, mut noticed) = (0, 0, 0, 0);
    for class in CLASSES.iter().filter(|class| class.name != "directional lights") {
        for number in 60..if is_long() { 80 } else { 63 } {
            let seed = crate::trials::seed(class, number);
            let mut random = Random::new(seed);
            let mut frame = (class.frame)(&mut random);
            frame.size = 48;
            // A matrix makes a caster rigid, so its box is known.
            frame
                .bodies
                .iter_mut()
                .filter(|body| body.casts)
                .for_each(|body| body.mirror = Some(glam::Vec3::NEG_X + glam::Vec3::Y + glam::Vec3::Z));
            frame.lights.truncate(1);
            let light = place(frame.lights[0]);
            let axis = random.direction();
            let cone = Cone { axis, cosine: random.between(-0.5, 0.95) };
            let renderer = Renderer { placing: Placing::Scene, ..Renderer::new(&gpu) };
            let whole = renderer.count(&frame, Counting::Auto)?;
            frame.lights[0] = frame.lights[0].with_cone(cone);
            let found = renderer.count(&frame, Counting::Auto)?;
            let within = |point: &Option<DVec3>| {
                point.is_some_and(|point| {
                    let axis = DVec3::from(axis.map(f64::from)).normalize();
                    (point - light).normalize().dot(axis) > f64::from(cone.cosine)
                })
            };
            let pixels = found.stencils[0].iter().zip(&whole.stencils[0]).zip(rays::points(&frame));
            for ((found, whole), point) in pixels {
                if within(&point) {
                    if found != whole {
                        return Err(format!("{}, seed {seed}, {cone:?}: {found}, not {whole}", class.name));
                    }
                    compared += 1;
                    shadowed += usize::from(*whole > 0);
                } else {
                    gone += usize::from(found != whole);
                }
            }
            // The negative control: a cone that points away.
            frame.lights[0] = frame.lights[0].with_cone(Cone { axis: axis.map(|c| -c), cosine: 0.99 });
            let turned = renderer.count(&frame, Counting::Auto)?;
            let pixels = turned.stencils[0].iter().zip(&whole.stencils[0]).zip(rays::points(&frame));
            noticed +=
                usize::from(pixels.into_iter().any(|((turned, whole), point)| within(&point) && turned != whole));
        }
    }
    println!(
        "{compared} pixels in cones, {shadowed} of them in shadow, {gone} others not in shadow any more, {noticed} controls"
    );
    if shadowed < 1000 || gone < 1000 || noticed < 3 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}
