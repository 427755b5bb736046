//! A stencil count is not zero exactly where the shadow depth query is not, at what the pixels see.

use glam::DVec3;
use rimline::internals::cpu::{self, Threads};
use rimline::{Counting, Light, Mesh};
use rimline_testkit::shapes::Shape;

use crate::classes::CLASSES;
use crate::compare::{Compared, Wrong};
use crate::rays::{Between, MOST_CASTERS, Tracer, Triangle, Truth};
use crate::render::{Counted, Renderer};
use crate::scene::{Frame, Rays};
use crate::trials::{Test, Traced, every};
use rimline_testkit::device::Gpu;
use rimline_testkit::{is_long, oracle};

pub(crate) const TESTS: &[Test] = &[("stencil_and_shadow_depth_query_agree", agree)];

/// A point in `f32` on the light's side of the face that it is on, by exact arithmetic, since rounding alone may put it
/// behind that face, which then lies between.
fn lit_side(point: DVec3, face: &Triangle, light: usize) -> [f32; 3] {
    let [a, b, c] = face.corners;
    let corners = face.corners.map(|corner| corner.as_vec3().to_array());
    let exact = oracle::ExactFace::new(&corners, [0, 1, 2]);
    let towards = (b - a).cross(c - a).normalize() * f64::from(face.of.sides[light]);
    let unit = point.abs().max_element() * f64::from(f32::EPSILON);
    let mut steps = (0..10).map(|step| if step == 0 { 0.0 } else { f64::from(1 << (step - 1)) });
    let moved = |step: f64| (point + towards * unit * step).as_vec3().to_array();
    let is_right =
        |&step: &f64| exact.as_ref().is_some_and(|f| f.sign(Light::point(moved(step))) == face.of.sides[light]);
    moved(steps.find(is_right).unwrap_or(0.0))
}

/// Points that pixels see on surfaces on the light's side, in `f32`. `None` where rounding moves the point by more than a
/// quarter of a pixel, or past other faces.
fn points(traced: &Traced) -> Vec<Option<[f32; 3]>> {
    let frame = &traced.frame;
    let (tracer, rays) = (Tracer::new(frame), Rays::new(&frame.eye.camera(), frame.size));
    let point = |(at, truths): (usize, &Vec<Truth>)| {
        let (x, y) = (at as u32 % frame.size, at as u32 / frame.size);
        let ray = rays.ray(x, y);
        let (point, face) = tracer.first(ray).filter(|_| matches!(truths[0], Truth::Surface(_)))?;
        let beside = rays.ray(x + 1, y);
        let pixel = (beside.0 + beside.1 * point.distance(ray.0)).distance(point);
        let moved = lit_side(point, face, 0);
        let exact = DVec3::from(moved.map(f64::from));
        let is_same = Truth::Surface(tracer.towards(exact, face, 0, &frame.lights[0])) == truths[0];
        (is_same && exact.distance(point) < pixel / 4.0).then_some(moved)
    };
    traced.truths.iter().enumerate().map(point).collect()
}

/// The casters in one mesh.
fn casters(frame: &Frame) -> Shape {
    let mut all = Shape::default();
    for body in frame.bodies.iter().filter(|body| body.casts) {
        let first = all.positions.len() as u32;
        all.positions.extend(&body.shape.positions);
        all.faces.extend(body.shape.faces.iter().map(|face| face.map(|vertex| vertex + first)));
    }
    all
}

/// Depths of those points, nothing elsewhere.
fn depths(shape: &Shape, light: Light, points: &[Option<[f32; 3]>]) -> Result<Vec<Option<i32>>, String> {
    let asked: Vec<_> = points.iter().copied().flatten().collect();
    let mesh = Mesh::from_faces(shape.positions.len(), shape.faces.clone()).map_err(|error| error.to_string())?;
    let found = cpu::shadow_depth(&shape.positions, &mesh, &asked, &[light], Threads::all())
        .map_err(|error| error.to_string())?;
    let mut found = found.into_iter();
    Ok(points.iter().map(|point| point.and_then(|_| found.next())).collect())
}

/// Where the stencil says shadow and the query does not, or the other way round; and where the query differs from the
/// rays, a pixel or more away from where either changes.
fn differences(traced: &Traced, stencil: &[u8], depths: &[Option<i32>]) -> [Wrong; 2] {
    let all = [true; MOST_CASTERS];
    let shadow = |(truths, depth): (&Vec<Truth>, &Option<i32>)| match (truths[0], depth) {
        (Truth::Surface(_), Some(0)) => vec![Truth::Surface(Between::default())],
        (Truth::Surface(_), Some(_)) => vec![Truth::Surface(Between::some())],
        _ => vec![Truth::Background],
    };
    let truths: Vec<_> = traced.truths.iter().zip(depths).map(shadow).collect();
    let by_query = Compared { truths: &truths, explains: false, ..traced.compared() };
    let counted = |(truths, depth): (&Vec<Truth>, &Option<i32>)| match (truths[0], depth) {
        (Truth::Surface(between), None) => between.count(&all) as u8,
        (_, depth) => depth.unwrap_or(0) as u8,
    };
    let as_stencil: Vec<u8> = traced.truths.iter().zip(depths).map(counted).collect();
    let by_rays = Compared { explains: false, ..traced.compared() };
    [by_query.lit(stencil, &all), by_rays.counts(&as_stencil, &all)]
}

/// Fails where they differ, but for pixels where the stencil differs from the rays for a known reason; returns the
/// depths that were compared with the rays' and how many such pixels there are.
fn check(traced: &Traced, counted: &Counted, depths: &[Option<i32>]) -> Result<[usize; 2], String> {
    let stencil = &counted.stencils[0];
    let [mut by_stencil, by_rays] = differences(traced, stencil, depths);
    let known = traced.compared().lit(stencil, &every(counted, 0));
    by_stencil.pixels.retain(|pixel| !known.hairlines.contains(pixel) && !known.slivers.contains(pixel));
    for (what, wrong) in [("stencil", &by_stencil), ("rays", &by_rays)] {
        if let Some(pixel) = wrong.pixels.first() {
            let count = wrong.pixels.len();
            return Err(format!("seed {}: {what} and query differ at {count} pixels, first {pixel:?}", traced.seed));
        }
    }
    Ok([by_rays.compared, known.hairlines.len() + known.slivers.len()])
}

fn agree() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    println!("pixels in shadow, lit, too far from what is seen for f32; depths equal to the rays'; explained:");
    for class in CLASSES.iter().step_by(if is_long() { 1 } else { 2 }) {
        let [mut deep, mut lit, mut left_out, mut equal, mut known] = [0; 5];
        for number in 40..if is_long() { 60 } else { 41 } {
            let traced = Traced::new(class, number);
            let depths = depths(&casters(&traced.frame), traced.frame.lights[0], &points(&traced))?;
            let counted = Renderer::new(&gpu).count(&traced.frame, Counting::Auto)?;
            let [compared, unsure] =
                check(&traced, &counted, &depths).map_err(|error| format!("{}: {error}", class.name))?;
            let turned: Vec<_> = depths.iter().map(|depth| depth.map(|depth| i32::from(depth == 0))).collect();
            let wrong = differences(&traced, &counted.stencils[0], &turned);
            if wrong.iter().any(|wrong| wrong.compared > 100 && wrong.pixels.is_empty()) {
                return Err(format!("negative control: {}, shadow for light went unnoticed", class.name));
            }
            let surfaces = traced.truths.iter().filter(|truths| matches!(truths[0], Truth::Surface(_))).count();
            let asked = depths.iter().flatten().count();
            let shadowed = depths.iter().flatten().filter(|&&depth| depth > 0).count();
            deep += shadowed;
            lit += asked - shadowed;
            left_out += surfaces - asked;
            equal += compared;
            known += unsure;
        }
        println!("  {}: {deep}, {lit}, {left_out}; {equal}; {known}", class.name);
    }
    Ok(())
}
