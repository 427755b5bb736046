//! Shadows of polygons, twisted ones among them, against the parity of their triangles between light and receivers.
//! Pieces of twisted ones are drawn by `piece_arguments` and `piece_volumes`.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rimline::mesh::Weld;
use rimline::{Counting, Light, Mesh};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::polygons::{PolygonSet, folded_polygon, quad_torus, random_polygon};
use rimline_testkit::random::Random;
use rimline_testkit::rays::Tracer;
use rimline_testkit::shapes::Shape;
use rimline_testkit::{is_long, must_fail, same, shapes};

use crate::hairlines::{HALF_STEP, picture};
use crate::in_scene::movable;
use crate::render::{Counted, Placing, Renderer};
use crate::scene::{Body, CENTRE, Eye, Frame, Rays, vector};
use crate::trials::{RIGHT, Test, rotated};

pub(crate) const TESTS: &[Test] = &[
    ("polygons_darken_what_is_behind_them", darken),
    ("polygons_in_a_scene_count_as_each_caster_by_itself", alike),
    ("rigid_polygons_far_away_and_at_any_scale", far_away),
];

/// Result of the rays on a receiver: the number of polygons that have an odd number of triangles between it and the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Truth {
    /// Nothing, or the polygons themselves.
    NoReceiver,
    Odd(u32),
}

pub(crate) struct Rig {
    tracer: Tracer<(usize, bool)>,
    rays: Rays,
    frame: Frame,
    light: Light,
    size: u32,
    /// Edges of triangles in the picture, and how far off the GPU's may be along either axis. Sides begin at some of
    /// them, and the polygons that are seen end at some.
    edges: Vec<([DVec2; 2], f64)>,
}

/// Pixels that are looked at one by one.
const MOST_WRONG: usize = 5;

impl Rig {
    pub(crate) fn new(frame: &Frame, mesh: &Mesh) -> Self {
        let of_triangle = mesh.polygons().expect("polygons").triangle_polygons();
        let corners =
            |body: &Body, face: [u32; 3]| face.map(|v| DVec3::from(body.shape.positions[v as usize].map(f64::from)));
        let [caster, room] = &frame.bodies[..] else { panic!("two bodies") };
        let polygons = caster.shape.faces.iter().zip(of_triangle);
        let polygons = polygons.map(|(&face, polygon)| (corners(caster, face), (polygon as usize, true)));
        let walls = room.shape.faces.iter().map(|&face| (corners(room, face), (0, false)));
        let edges = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let Eye { position, forward, near, .. } = frame.eye;
        let height = |p: DVec3| (p - position).dot(forward.normalize()) - 0.5 * near;
        let seen = |edge: [u32; 2]| {
            let [mut a, mut b] = edge.map(|v| DVec3::from(caster.shape.positions[v as usize].map(f64::from)));
            let (of_a, of_b) = (height(a), height(b));
            // The part of the edge before the eye.
            let meeting = a + (b - a) * (of_a / (of_a - of_b));
            match (of_a > 0.0, of_b > 0.0) {
                (false, false) => return None,
                (false, true) => a = meeting,
                (true, false) => b = meeting,
                (true, true) => {}
            }
            let [(a, a_off), (b, b_off)] = [picture(frame, a)?, picture(frame, b)?];
            Some(([a, b], HALF_STEP + a_off.max(b_off)))
        };
        Self {
            edges: edges.filter_map(seen).collect(),
            tracer: Tracer::build(polygons.chain(walls)),
            rays: Rays::new(&frame.eye.camera(), frame.size),
            frame: frame.clone(),
            light: frame.lights[0],
            size: frame.size,
        }
    }

    fn at(&self, point: DVec2) -> Truth {
        let ray = self.rays.at(point);
        let seen = self.tracer.meetings(ray).filter(|(t, _)| *t > 0.0).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((t, _)) = seen.filter(|(_, triangle)| !triangle.of.1) else { return Truth::NoReceiver };
        let point = ray.0 + ray.1 * t;
        let [x, y, z, w] = self.light.to_array().map(f64::from);
        let towards = DVec3::new(x, y, z) - w * point;
        let end = if w == 0.0 { f64::INFINITY } else { 1.0 / w };
        let mut odd = BTreeMap::<usize, bool>::new();
        for (t, triangle) in self.tracer.meetings((point, towards)) {
            // Walls cast nothing.
            if t > 1e-9 && t < end && triangle.of.1 {
                *odd.entry(triangle.of.0).or_default() ^= true;
            }
        }
        Truth::Odd(odd.values().filter(|&&odd| odd).count() as u32)
    }

    fn pixel(x: u32, y: u32) -> DVec2 {
        DVec2::new(f64::from(x), f64::from(y)) + CENTRE
    }

    pub(crate) fn truths(&self) -> Vec<Truth> {
        let pixels = (0..self.size).flat_map(|y| (0..self.size).map(move |x| (x, y)));
        pixels.map(|(x, y)| self.at(Self::pixel(x, y))).collect()
    }

    /// Whether a position that the GPU may see instead of the pixel's centre has this truth: vertices move on the
    /// rasteriser's grid, and depths that are compared are rounded.
    fn is_near(&self, pixel: DVec2, fits: impl Fn(Truth) -> bool) -> bool {
        let (from, direction) = self.rays.at(pixel);
        let nearest = self.tracer.meetings((from, direction)).filter(|(t, _)| *t > 0.0).map(|(t, _)| t);
        let point = from + direction * nearest.fold(f64::INFINITY, f64::min);
        let moved = 2.0 * (HALF_STEP + picture(&self.frame, point).map_or(0.0, |(_, off)| off));
        let steps = || (-6..=6).map(|step| f64::from(step) / 6.0 * moved);
        steps().any(|dx| steps().any(|dy| fits(self.at(pixel + DVec2::new(dx, dy)))))
    }

    /// Whether an edge is so close to the pixel's centre that a GPU may see it on the other side:
    /// docs/numerics/rasterisers.md, "Hairlines".
    fn is_hairline(&self, at: DVec2) -> bool {
        self.edges.iter().any(|&([a, b], off)| {
            let along = b - a;
            let part = ((at - a).dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0);
            (a + part * along - at).abs().max_element() <= 2.0 * off
        })
    }

    /// Pixels where the stencil differs from the pixel's own ray, and neither a ray next to it nor a hairline explains
    /// the value: the first ones. A hairline may explain any value, since a polygon that is seen may end there.
    pub(crate) fn wrong(&self, truths: &[Truth], stencil: &[u8], compared: Compared) -> Vec<(u32, u32)> {
        let fits = |truth: Truth, value: u8| match (truth, compared) {
            (Truth::Odd(count), Compared::Counts) => count as u8 == value,
            (Truth::Odd(count), Compared::Darkness) => (count == 0) == (value == 0),
            (Truth::NoReceiver, _) => false,
        };
        let pixels = (0..self.size).flat_map(|y| (0..self.size).map(move |x| (x, y)));
        let is_wrong = |(&(x, y), (&truth, &value)): (&(u32, u32), (&Truth, &u8))| {
            if truth == Truth::NoReceiver {
                return false;
            }
            let pixel = Self::pixel(x, y);
            !fits(truth, value) && !self.is_near(pixel, |truth| fits(truth, value)) && !self.is_hairline(pixel)
        };
        let pixels: Vec<_> = pixels.collect();
        let wrong = pixels.iter().zip(truths.iter().zip(stencil)).filter(|&pixel| is_wrong(pixel));
        wrong.map(|(&at, _)| at).take(MOST_WRONG).collect()
    }
}

/// How closely a stencil must agree with the rays.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Compared {
    Counts,
    /// Whether a count is 0.
    Darkness,
}

/// A caster of polygons in a room, which begins beyond its hull.
pub(crate) fn frame(random: &mut Random, set: PolygonSet, mesh: &Mesh) -> Frame {
    let shape = Shape { positions: set.positions.clone(), faces: mesh.faces().to_vec() };
    let caster = Body { polygons: Some(set), ..Body::caster(shape) };
    let from = vector(random) * f64::from(random.between(1.8, 3.6));
    let towards = vector(random) * f64::from(random.between(0.0, 1.5)) - from;
    let near = 0.02 * 25_f64.powf(f64::from(random.between(0.0, 1.0)));
    let light = match random.below(3) {
        0 => Light::directional(random.direction()),
        1 => Light::point((vector(random) * f64::from(random.between(1.8, 3.5))).as_vec3().to_array()),
        // Right behind the polygons as the eye sees them, or before them: so the near rectangle is in shadow.
        _ => Light::point((from * f64::from(random.between(-0.8, -0.5))).as_vec3().to_array()),
    };
    let eye = Eye::new(from, towards, near);
    Frame { bodies: vec![caster, Body::room([0.0; 3], 4.0)], eye, lights: vec![light], size: 96 }
}

/// Polygons around the origin, up to 1.6 away.
fn polygons(random: &mut Random) -> (&'static str, PolygonSet) {
    let mut set = PolygonSet::default();
    let name = match random.below(5) {
        0 => {
            let bump = [0.05, 0.2, 0.4][random.below(3)];
            set = quad_torus(random, 10, 7, bump);
            "torus"
        }
        1 => {
            for _ in 0..40 {
                let centre = random.direction();
                let points = (0..4).map(|_| {
                    let off = random.direction();
                    [0, 1, 2].map(|axis| 0.8 * centre[axis] + 0.5 * off[axis])
                });
                set.push_points(&[points.collect()]);
            }
            "forty quadrilaterals"
        }
        2 => {
            let (_, one) = random_polygon(random, 14);
            let most = one.positions.iter().flatten().fold(1.0_f32, |most, c| most.max(c.abs()));
            set = one;
            set.positions.iter_mut().for_each(|p| *p = p.map(|c| c / most));
            "one"
        }
        3 => {
            // A power of two keeps what is in line there.
            for _ in 0..3 {
                let points = folded_polygon(random);
                let most = points.iter().flatten().fold(1.0_f32, |most, c| most.max(c.abs()));
                let scale = most.log2().ceil().exp2().recip();
                set.push_points(&[points.into_iter().map(|p| p.map(|c| c * scale)).collect()]);
            }
            "three folded ones"
        }
        _ => {
            for _ in 0..6 {
                let corners = 4 + random.below(6);
                set.push_points(&[(0..corners).map(|_| random.direction()).collect()]);
            }
            "six of any points"
        }
    };
    (name, set)
}

fn darken() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let first = 71_000;
    println!("seeds from {first}");
    let (mut compared, mut dark, mut frames, mut failures) = (0, 0, 0, Vec::new());
    for seed in first..first + if is_long() { 900 } else { 130 } {
        let mut random = Random::new(seed);
        let (name, set) = polygons(&mut random);
        let mesh = set.mesh(Weld::Position).map_err(|error| error.to_string())?;
        if mesh.polygons().is_none() {
            continue;
        }
        let frame = frame(&mut random, set, &mesh);
        let rig = Rig::new(&frame, &mesh);
        let truths = rig.truths();
        frames += 1;
        compared += truths.iter().filter(|&&truth| truth != Truth::NoReceiver).count();
        dark += truths.iter().filter(|&&truth| !matches!(truth, Truth::NoReceiver | Truth::Odd(0))).count();
        let wrong = compare(&gpu, &frame, &rig, &truths, &rotated(&RIGHT, seed as usize))?;
        failures.extend(wrong.into_iter().map(|error| format!("seed {seed}, {name}, {error}")));
        if failures.len() > 9 {
            break;
        }
    }
    println!("{frames} frames, {compared} receivers, {dark} of them dark");
    if failures.is_empty() && dark > 10_000 { Ok(()) } else { Err(failures.join("\n")) }
}

/// Faults in the stencil counts of a frame, with every face and with back-facing ones only.
pub(crate) fn compare(
    gpu: &Gpu,
    frame: &Frame,
    rig: &Rig,
    truths: &[Truth],
    methods: &[Counting],
) -> Result<Vec<String>, String> {
    let mut failures = Vec::new();
    let most = truths.iter().map(|truth| if let Truth::Odd(count) = truth { *count } else { 0 }).max().unwrap_or(0);
    for &counting in methods {
        let mut renderer = Renderer::new(gpu);
        renderer.options = OneCasterOptions { every_face: true, bound_counts: true, ..renderer.options };
        let counted = renderer.count(frame, counting)?;
        let bound = counted.statistics[0].count_bound;
        if bound < most {
            failures.push(format!("{counting:?}: counts up to {most}, and a bound of {bound}"));
        }
        let wrong = rig.wrong(truths, &counted.stencils[0], Compared::Counts);
        if let Some(&(x, y)) = wrong.first() {
            let at = (y * frame.size + x) as usize;
            let (value, truth) = (counted.stencils[0][at], truths[at]);
            failures.push(format!(
                "{counting:?}, {:?}: {} wrong, first ({x}, {y}): {value}, {truth:?}",
                frame.lights[0],
                wrong.len()
            ));
        }
        let mut stencil = counted.stencils[0].clone();
        if let Some(at) = truths.iter().position(|&truth| truth != Truth::NoReceiver) {
            stencil[at] = stencil[at].wrapping_add(100);
            let wrong = rig.wrong(truths, &stencil, Compared::Counts);
            must_fail("other counts", &if wrong.is_empty() { Ok(()) } else { Err(String::new()) })?;
        }
        renderer.options = OneCasterOptions { every_face: false, ..renderer.options };
        let counted = renderer.count(frame, counting)?;
        let wrong = rig.wrong(truths, &counted.stencils[0], Compared::Darkness);
        if !wrong.is_empty() {
            failures.push(format!("{counting:?}, back-facing: {} wrong {wrong:?}", wrong.len()));
        }
    }
    Ok(failures)
}

/// A frame with two casters of polygons and one of triangles, for so many lights.
fn mixed(random: &mut Random, lights: usize) -> Result<(String, Frame), String> {
    let (mut names, mut frame) = (String::new(), None::<Frame>);
    while names.matches(' ').count() < 2 {
        let (name, set) = polygons(random);
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        if mesh.polygons().is_none() {
            continue;
        }
        names = format!("{names}{} ", name.replace(' ', "_"));
        let of_set = self::frame(random, set, &mesh);
        match &mut frame {
            Some(frame) => frame.bodies.insert(0, of_set.bodies[0].clone()),
            None => frame = Some(of_set),
        }
    }
    let mut frame = frame.ok_or("no frame")?;
    frame.bodies.insert(random.below(3), Body::caster(shapes::sphere(2)));
    let first = frame.lights[0];
    while frame.lights.len() < lights {
        let off = random.direction();
        let xyz = std::array::from_fn(|axis| first.xyz[axis] + 0.5 * off[axis]);
        frame.lights.push(Light { xyz, ..first });
    }
    frame.size = 48;
    Ok((names, frame))
}

const METHODS: [Counting; 4] = [Counting::Auto, Counting::ZpPlus, Counting::ZFail, Counting::ZPass];

/// Whether two ways of drawing a frame count the same in every pixel and choose the same faces.
fn compare_counts(what: &str, alone: &Counted, together: &Counted) -> Result<(), String> {
    let casting = |counted: &Counted| counted.chosen.iter().flatten().map(|light| light.casting).collect::<Vec<_>>();
    same(&format!("{what}, faces that cast"), &casting(together), &casting(alone))?;
    for (light, (together, alone)) in together.stencils.iter().zip(&alone.stencils).enumerate() {
        same(&format!("{what}, light {light}"), together, alone)?;
    }
    Ok(())
}

/// Casters of polygons and of triangles in one scene, in callers' buffers, also with a past, several batches of lights
/// and lists of any room.
fn alike() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let (mut shadowed, mut lost, mut runs, mut controls) = (0, 0, 0, 0);
    for seed in 72_000..72_000 + if is_long() { 60 } else { 9 } {
        let mut random = Random::new(seed);
        let lights = [1, 5, 33][seed as usize % 3];
        let (names, frame) = mixed(&mut random, lights)?;
        for counting in rotated(&METHODS, seed as usize) {
            let options = OneCasterOptions {
                end_at_range: seed % 2 == 1,
                cap_capacity: [None, Some(9)][seed as usize / 2 % 2],
                ..OneCasterOptions::default()
            };
            let list_capacity = [None, None, Some(7)][seed as usize / 3 % 3];
            let renderer = |placing| Renderer { options, list_capacity, range: 12.0, placing, ..Renderer::new(gpu) };
            let what = format!("seed {seed}, {names}{lights} lights, {counting:?}");
            let alone = renderer(Placing::Alone).count(&frame, counting)?;
            let mut together = renderer(Placing::Scene).count(&frame, counting)?;
            compare_counts(&what, &alone, &together)?;
            let busy = renderer(Placing::Busy(seed)).count(&frame, counting)?;
            compare_counts(&format!("{what}, busy"), &alone, &busy)?;
            // The first polygons do not cast for a light.
            let mut without = frame.clone();
            let body = without.bodies.iter_mut().find(|body| body.polygons.is_some()).ok_or("no polygons")?;
            body.lacks = Some(0);
            let lacking = renderer(Placing::Scene).count(&without, counting)?;
            without.bodies.iter_mut().find(|body| body.lacks.is_some()).ok_or("no polygons")?.casts = false;
            let none = renderer(Placing::Scene).count(&without, counting)?;
            same(&format!("{what}, a light less"), &lacking.stencils[0], &none.stencils[0])?;
            if lights > 1 {
                same(&format!("{what}, the others"), &lacking.stencils[1..], &together.stencils[1..])?;
            }
            shadowed += alone.stencils.iter().flatten().filter(|count| **count > 0).count();
            lost += together.statistics[0].lost_pieces;
            together.stencils[0][7] ^= 1;
            controls += usize::from(compare_counts("another", &alone, &together).is_err());
            runs += 1;
        }
    }
    println!("{shadowed} pixels in shadow, {lost} pieces lost, {controls} controls");
    if shadowed > 10_000 && controls == runs { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// Polygons with matrices that turn, scale and mirror, far from the origin, against rays.
fn far_away() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let (mut dark, mut failures) = (0, Vec::new());
    for seed in 73_000..73_000 + if is_long() { 200 } else { 24 } {
        let mut random = Random::new(seed);
        let (name, set) = polygons(&mut random);
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        if mesh.polygons().is_none() {
            continue;
        }
        let frame = movable(frame(&mut random, set, &mesh));
        let rig = Rig::new(&frame, &mesh);
        let truths = rig.truths();
        dark += truths.iter().filter(|&&truth| !matches!(truth, Truth::NoReceiver | Truth::Odd(0))).count();
        for counting in rotated(&RIGHT, seed as usize) {
            let mut renderer = Renderer { placing: Placing::Moved(seed), ..Renderer::new(gpu) };
            renderer.options.every_face = true;
            let counted = renderer.count(&frame, counting)?;
            let wrong = rig.wrong(&truths, &counted.stencils[0], Compared::Counts);
            if !wrong.is_empty() {
                failures.push(format!("seed {seed}, {name}, {counting:?}: {} wrong {wrong:?}", wrong.len()));
            }
        }
    }
    println!("{dark} dark receivers");
    if failures.is_empty() && dark > 2_000 { Ok(()) } else { Err(failures.join("\n")) }
}
