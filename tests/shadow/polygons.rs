//! Shadows of polygons, twisted ones among them, against the parity of their triangles between light and receivers.
//! Pieces of twisted ones are drawn by `piece_arguments` and `piece_volumes`.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rimline::Light;
use rimline::gpu::{Capacities, Measuring};
use rimline::mesh::Weld;
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Body, CENTRE, Eye, Frame, Rays, vector};
use rimline_testkit::on_gpu::text;
use rimline_testkit::polygons::{PolygonSet, folded_polygon, quad_torus, random_polygon};
use rimline_testkit::random::Random;
use rimline_testkit::rays::Tracer;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{is_long, must_fail};

use crate::hairlines::{HALF_STEP, picture};
use crate::in_scene::movable;
use crate::render::{Placing, Renderer};
use crate::trials::{RIGHT, Test, rotated};

pub(crate) const TESTS: &[Test] = &[("polygons_darken_what_is_behind_them", darken)];

/// Result of the rays on a receiver: the number of polygons that have an odd number of triangles between it and the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Truth {
    /// Nothing, or the polygons themselves.
    NoReceiver,
    Odd(u32),
}

/// The rays of a frame, for a light of this number.
pub(crate) struct Rig {
    tracer: Tracer<Of>,
    rays: Rays,
    frame: Frame,
    light: usize,
    /// Edges of triangles in the picture, and how far off the GPU's may be along either axis. Sides begin at some of
    /// them, and the polygons that are seen end at some.
    edges: Vec<([DVec2; 2], f64)>,
    pub(crate) truths: Vec<Truth>,
}

/// Properties of a triangle: its polygon, whether that casts for the light, and whether it receives.
struct Of {
    polygon: usize,
    casts: bool,
    receives: bool,
}

/// Pixels that are looked at one by one.
const MOST_WRONG: usize = 5;

impl Rig {
    pub(crate) fn new(frame: &Frame, light: usize) -> Result<Self, String> {
        let Eye { position, forward, near, .. } = frame.eye;
        let height = |p: DVec3| (p - position).dot(forward.normalize()) - 0.5 * near;
        let seen = |[mut a, mut b]: [DVec3; 2]| {
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
        let (mut triangles, mut edges, mut first) = (Vec::new(), Vec::new(), 0);
        for body in &frame.bodies {
            let faces = &body.shape.faces;
            // Each triangle of other casters counts by itself.
            let mut of_triangles: Vec<u32> = (0..faces.len() as u32).collect();
            if let Some(set) = &body.polygons {
                let mesh = set.mesh(Weld::Position).map_err(text)?;
                of_triangles = mesh.polygons().ok_or("no polygons")?.triangle_polygons();
            }
            for (face, polygon) in faces.iter().zip(of_triangles) {
                let [a, b, c] = face.map(|v| DVec3::from(body.shape.positions[v as usize].map(f64::from)));
                let casts = body.casts && body.lacks != Some(light);
                triangles.push(([a, b, c], Of { polygon: first + polygon as usize, casts, receives: !body.casts }));
                if body.casts {
                    edges.extend([[a, b], [b, c], [c, a]].into_iter().filter_map(seen));
                }
            }
            first += faces.len();
        }
        let (tracer, rays) = (Tracer::build(triangles), Rays::new(&frame.eye.camera(), frame.size));
        let mut rig = Self { tracer, rays, frame: frame.clone(), light, edges, truths: Vec::new() };
        rig.truths = rig.pixels().map(|(x, y)| rig.at(Self::pixel(x, y))).collect();
        Ok(rig)
    }

    fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let size = self.frame.size;
        (0..size).flat_map(move |y| (0..size).map(move |x| (x, y)))
    }

    /// The largest count.
    pub(crate) fn most(&self) -> u32 {
        self.truths.iter().map(|truth| if let Truth::Odd(count) = truth { *count } else { 0 }).max().unwrap_or(0)
    }

    fn at(&self, point: DVec2) -> Truth {
        let ray = self.rays.at(point);
        let seen = self.tracer.meetings(ray).filter(|(t, _)| *t > 0.0).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((t, _)) = seen.filter(|(_, triangle)| triangle.of.receives) else { return Truth::NoReceiver };
        let point = ray.0 + ray.1 * t;
        let [x, y, z, w] = self.frame.lights[self.light].to_array().map(f64::from);
        let towards = DVec3::new(x, y, z) - w * point;
        let end = if w == 0.0 { f64::INFINITY } else { 1.0 / w };
        let mut odd = BTreeMap::<usize, bool>::new();
        for (t, triangle) in self.tracer.meetings((point, towards)) {
            if t > 1e-9 && t < end && triangle.of.casts {
                *odd.entry(triangle.of.polygon).or_default() ^= true;
            }
        }
        Truth::Odd(odd.values().filter(|&&odd| odd).count() as u32)
    }

    fn pixel(x: u32, y: u32) -> DVec2 {
        DVec2::new(f64::from(x), f64::from(y)) + CENTRE
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
    pub(crate) fn wrong(&self, stencil: &[u8], compared: Compared) -> Vec<(u32, u32)> {
        let fits = |truth: Truth, value: u8| match (truth, compared) {
            (Truth::Odd(count), Compared::Counts) => count as u8 == value,
            (Truth::Odd(count), Compared::Darkness) => (count == 0) == (value == 0),
            (Truth::NoReceiver, _) => false,
        };
        let is_wrong = |&((x, y), (&truth, &value)): &((u32, u32), (&Truth, &u8))| {
            let pixel = Self::pixel(x, y);
            truth != Truth::NoReceiver
                && !fits(truth, value)
                && !self.is_near(pixel, |truth| fits(truth, value))
                && !self.is_hairline(pixel)
        };
        let wrong = self.pixels().zip(self.truths.iter().zip(stencil)).filter(is_wrong);
        wrong.map(|(at, _)| at).take(MOST_WRONG).collect()
    }
}

/// How closely a stencil must agree with the rays.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Compared {
    Counts,
    /// Whether a count is 0.
    Darkness,
}

/// Casters in a room, which begins beyond their hull.
fn frame(random: &mut Random, mut bodies: Vec<Body>, lights: usize) -> Frame {
    bodies.push(Body::room([0.0; 3], 4.0));
    let from = vector(random) * f64::from(random.between(1.8, 3.6));
    let towards = vector(random) * f64::from(random.between(0.0, 1.5)) - from;
    let near = 0.02 * 25_f64.powf(f64::from(random.between(0.0, 1.0)));
    let light = match random.below(3) {
        0 => Light::directional(random.direction()),
        1 => Light::point((vector(random) * f64::from(random.between(1.8, 3.5))).as_vec3().to_array()),
        // Right behind the polygons as the eye sees them, or before them: so the near rectangle is in shadow.
        _ => Light::point((from * f64::from(random.between(-0.8, -0.5))).as_vec3().to_array()),
    };
    let beside = |_| {
        let off = random.direction();
        Light { xyz: std::array::from_fn(|axis| light.xyz[axis] + 0.5 * off[axis]), ..light }
    };
    let lights = std::iter::once(light).chain((1..lights).map(beside)).collect();
    Frame { bodies, eye: Eye::new(from, towards, near), lights, size: 96 }
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

/// Casters of polygons that are not all triangles.
fn casters(random: &mut Random, count: usize) -> Result<(String, Vec<Body>), String> {
    let (mut names, mut bodies) = (String::new(), Vec::new());
    while bodies.len() < count {
        let (name, set) = polygons(random);
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        if mesh.polygons().is_some() {
            names = format!("{names}{name}, ");
            let shape = Shape { positions: set.positions.clone(), faces: mesh.faces().to_vec() };
            bodies.push(Body { polygons: Some(set), ..Body::caster(shape) });
        }
    }
    Ok((names, bodies))
}

/// Alone, in a scene with a past, and far away with matrices that turn, scale and mirror. Some are beside others and beside
/// triangles, with several batches of lights and short lists; in a scene the first of these do not cast for a light.
fn darken() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let first = 71_000;
    println!("seeds from {first}");
    let (mut compared, mut dark, mut failures) = (0, 0, Vec::new());
    for seed in first..first + if is_long() { 900 } else { 130 } {
        let mut random = Random::new(seed);
        let placing = [Placing::Alone, Placing::Alone, Placing::Busy(seed), Placing::Moved(seed)][seed as usize % 4];
        let mut renderer = Renderer { placing, ..Renderer::new(&gpu) };
        let is_one = seed % 5 > 0;
        let (names, mut bodies) = casters(&mut random, if is_one { 1 } else { 2 })?;
        if !is_one {
            bodies[0].lacks = (placing != Placing::Alone).then_some(0);
            bodies.insert(random.below(3), Body::caster(shapes::sphere(2)));
            let lists = [None, Some(7)][random.below(2)];
            renderer.options.end_at_range = random.below(2) == 0;
            let caps = [None, Some(9)][random.below(2)];
            renderer.options.capacities = Capacities { lists, caps, ..Capacities::default() };
            renderer.range = 30.0;
        }
        let mut frame = frame(&mut random, bodies, if is_one { 1 } else { [2, 33][seed as usize / 5 % 2] });
        if matches!(placing, Placing::Moved(_)) {
            frame = movable(frame);
        }
        for light in [0, frame.lights.len() - 1].into_iter().take(if is_one { 1 } else { 2 }) {
            let rig = Rig::new(&frame, light)?;
            compared += rig.truths.iter().filter(|&&truth| truth != Truth::NoReceiver).count();
            let is_dark = |truth: &&Truth| !matches!(truth, Truth::NoReceiver | Truth::Odd(0));
            dark += rig.truths.iter().filter(is_dark).count();
            for counting in rotated(&RIGHT, seed as usize / 4) {
                let what = format!("seed {seed}, {names}{placing:?}, {counting:?}, {:?}", frame.lights[light]);
                // Every face, then back-facing ones where they suffice.
                renderer.options.measuring.set(Measuring::EVERY_FACE, true);
                renderer.options.stencil.bound_counts = true;
                let mut counted = renderer.count(&frame, counting)?;
                let stencil = &mut counted.stencils[light];
                let wrong = rig.wrong(stencil, Compared::Counts);
                // The bound of a caster that is alone is its own.
                let bounds = counted.statistics.iter().map(|statistics| statistics.count_bound);
                if !wrong.is_empty() || bounds.sum::<u32>() < rig.most() {
                    failures.push(format!("{what}: wrong at {wrong:?}, or a bound below {}", rig.most()));
                }
                if let Some(at) = rig.truths.iter().position(|&truth| truth != Truth::NoReceiver) {
                    stencil[at] = stencil[at].wrapping_add(100);
                    let wrong = rig.wrong(stencil, Compared::Counts);
                    must_fail("other counts", &if wrong.is_empty() { Ok(()) } else { Err(String::new()) })?;
                }
                renderer.options.measuring.set(Measuring::EVERY_FACE, false);
                let counted = renderer.count(&frame, counting)?;
                let wrong = rig.wrong(&counted.stencils[light], Compared::Darkness);
                if !wrong.is_empty() {
                    failures.push(format!("{what}, back-facing: wrong at {wrong:?}"));
                }
            }
        }
        if failures.len() > 9 {
            break;
        }
    }
    println!("{compared} receivers, {dark} of them dark");
    if failures.is_empty() && dark > 10_000 { Ok(()) } else { Err(failures.join("\n")) }
}
