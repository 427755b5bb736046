//! The bound on stencil counts: never below a count that is found by trying every face, never below half of what a half
//! plane of its pencil crosses, and not much above that.
//!
//! The stages are `stencil_pencil`, `stencil_crossings` and `stencil_bound`.

use glam::DVec3;
use rimline::gpu::{Capacities, Caster, FrameInputs, Measuring, Scene, SceneOptions, ShadowStatistics, StencilCounts};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::internals::shadow::{CAST_BACK_FACING, CAST_EVERY};
use rimline::mesh::EdgeKind;
use rimline::{Light, Predicate};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{IDENTITY, is_long, must_fail};

use crate::scene::{Eye, vector};
use crate::sides::box_of;

pub(super) const TESTS: &[Test] = &[
    ("bounds_hold_for_stacks_below_lights_near_a_long_box", stacks),
    ("a_light_near_the_end_of_a_long_box", near_the_end),
    ("bounds_hold_for_lights_among_casters", among_casters),
    ("opposite_piles_do_not_add_up", opposite_piles),
];

/// Closed blocks and balls below each other, about a line from the light, in a box that is long.
fn stack(random: &mut Random, light: DVec3, towards: DVec3) -> Shape {
    let mut parts = Vec::new();
    let sideways = [-1.0, 1.0][random.below(2)];
    for number in 0..4 + random.below(20) {
        let one = if random.below(3) == 0 { shapes::blob(2, 0.1, number as u32) } else { shapes::cube() };
        let down = 1.0 + 0.1 * number as f64;
        // Some of them reach far to one side.
        let half = f64::from(random.between(0.02, 0.2)) * [1.0, 10.0][random.below(2)];
        let middle = light + towards * down + DVec3::X * (sideways * half * f64::from(random.between(0.0, 0.9)));
        parts.push(placed(one, middle, DVec3::new(half, 0.02, half.min(0.3))));
    }
    // So the box is long, on the other side or on both.
    for side in [-1.0, 1.0] {
        let length = f64::from(random.between(1.0, 60.0));
        if side == sideways || random.below(2) == 0 {
            let middle = light + towards * 1.5 + DVec3::X * (side * length);
            parts.push(placed(shapes::cube(), middle, DVec3::splat(0.1)));
        }
    }
    Shape::joined(&parts)
}

/// A shape that is scaled and moved.
fn placed(shape: Shape, middle: DVec3, scale: DVec3) -> Shape {
    shape.placed(|p| (middle + DVec3::from(p.map(f64::from)) * scale).as_vec3().to_array())
}

/// A silhouette edge with its weight.
type Weighed = ([[f32; 3]; 2], f64);

struct Case {
    shape: Shape,
    light: Light,
    casting: u32,
    edges: Vec<([[f32; 3]; 2], bool)>,
    facing: Vec<bool>,
    corners: [[f32; 3]; 2],
}

impl Case {
    fn new(shape: Shape, light: Light) -> Self {
        let mesh = shape.mesh().expect("a good mesh");
        let lights = [light];
        let found = cpu::extract(&shape.positions, &mesh, &lights, Predicate::Exact, Threads::ONE).expect("good");
        let silhouettes = mesh.edges().iter().zip(&found.masks).filter(|(_, masks)| masks.silhouette & 1 != 0);
        let edges = silhouettes.map(|(edge, _)| {
            (edge.vertices.map(|vertex| shape.positions[vertex as usize]), edge.kind == EdgeKind::Boundary)
        });
        let facing = cpu::facing(&shape.positions, &shape.faces, &lights, Predicate::Exact, Threads::ONE);
        let facing = facing.into_iter().map(|mask| mask & 1 != 0).collect();
        let edges = edges.collect();
        Self { edges, facing, corners: box_of(shape.positions.iter().copied()), shape, light, casting: CAST_EVERY }
    }

    /// Casting faces that a ray meets which begins at the light, or comes from it.
    fn count(&self, through: DVec3) -> u32 {
        let [x, y, z, w] = self.light.to_array().map(f64::from);
        let (from, along) = if w > 0.0 {
            let light_position = DVec3::new(x, y, z) / w;
            (light_position, through - light_position)
        } else {
            (through + DVec3::new(x, y, z) * 1e3, -DVec3::new(x, y, z))
        };
        let crosses = |(&face, &facing): (&[u32; 3], &bool)| {
            let [a, b, c] = face.map(|v| DVec3::from(self.shape.positions[v as usize].map(f64::from)) - from);
            let inside = [a.cross(b), b.cross(c), c.cross(a)].map(|normal| normal.dot(along));
            let normal = (b - a).cross(c - a);
            let before = normal.dot(a) * normal.dot(along) > 0.0;
            let is_met = inside.iter().all(|&side| side > 0.0) || inside.iter().all(|&side| side < 0.0);
            before && is_met && (self.casting == CAST_EVERY || !facing)
        };
        self.shape.faces.iter().zip(&self.facing).filter(|&face| crosses(face)).count() as u32
    }

    /// The largest count behind any face's middle, or next to it.
    fn deepest(&self, random: &mut Random) -> u32 {
        let middles = self.shape.faces.iter().map(|face| {
            let [a, b, c] = face.map(|v| DVec3::from(self.shape.positions[v as usize].map(f64::from)));
            let mut weights = DVec3::from([0, 1, 2].map(|_: i32| f64::from(random.between(0.1, 1.0))));
            weights /= weights.element_sum();
            a * weights.x + b * weights.y + c * weights.z
        });
        middles.map(|middle| self.count(middle)).max().unwrap_or(0)
    }

    fn weighed(&self) -> Vec<Weighed> {
        let weight = |is_boundary: bool| if self.casting == CAST_EVERY && !is_boundary { 2.0 } else { 1.0 };
        self.edges.iter().map(|&(ends, is_boundary)| (ends, weight(is_boundary))).collect()
    }

    /// Where edges begin and end in the pencil, in parts of what the box spans: half planes about an axis through the
    /// light at right angles to the shortest way to the box and to the coordinate axis that is farthest from that.
    fn spans(&self) -> Vec<([f64; 2], f64)> {
        let [x, y, z, w] = self.light.to_array().map(f64::from);
        let [low, high] = self.corners.map(|corner| DVec3::from(corner.map(f64::from)));
        let (light_position, forward) = if w > 0.0 {
            let light_position = DVec3::new(x, y, z) / w;
            (light_position, light_position.clamp(low, high) - light_position)
        } else {
            (DVec3::ZERO, -DVec3::new(x, y, z))
        };
        let size = forward.abs();
        let axis = if size.y <= size.x && size.y <= size.z {
            DVec3::Y
        } else if size.z <= size.x {
            DVec3::Z
        } else {
            DVec3::X
        };
        let aside = forward.cross(axis);
        let at = |p: DVec3| {
            let d = p - light_position;
            aside.dot(d) / if w > 0.0 { forward.dot(d) } else { 1.0 }
        };
        let corner = |number: usize| DVec3::from([0, 1, 2].map(|axis| [low, high][number >> axis & 1][axis]));
        let keys: Vec<f64> = (0..8).map(|number| at(corner(number))).collect();
        let first = keys.iter().copied().fold(f64::INFINITY, f64::min);
        let last = keys.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let part = |p: [f32; 3]| (at(DVec3::from(p.map(f64::from))) - first) / (last - first);
        self.weighed()
            .iter()
            .map(|&(ends, weight)| {
                let [p, q] = ends.map(part);
                ([p.min(q), p.max(q)], weight)
            })
            .collect()
    }

    /// Half the weights that a stripe of half planes crosses at most, about each of many.
    fn crossed(&self, half_width: f64) -> f64 {
        let spans = self.spans();
        let sum = |at: f64| {
            let crossed = spans.iter().filter(|([first, last], _)| first - half_width <= at && at <= last + half_width);
            crossed.map(|(_, weight)| weight).sum::<f64>()
        };
        (0..=16_000).map(|number| sum(f64::from(number) / 16_000.0)).fold(0.0, f64::max) / 2.0
    }

    fn check(&self, bound: u32, random: &mut Random) -> Result<u32, String> {
        let deepest = self.deepest(random);
        if bound < deepest {
            return Err(format!("a count of {deepest}, the bound is {bound}"));
        }
        let least = self.crossed(0.0);
        if f64::from(bound) < least.floor() {
            return Err(format!("a half plane crosses {least}, the bound is {bound}"));
        }
        // A bin's own width, and rounding.
        let most = self.crossed(1.2 / 1024.0).ceil().min(self.shape.faces.len() as f64);
        if f64::from(bound) > most {
            return Err(format!("the bound is {bound}, stripes of bins cross {most}"));
        }
        Ok(deepest)
    }
}

/// The bound for casters with one light, in a scene that skips nothing, seen from far away. Which faces cast is chosen
/// there.
fn bound(gpu: &Gpu, cases: &mut [Case], every_face: bool) -> Result<u32, String> {
    let mut measuring = Measuring::CULLED_BY_VIEW;
    measuring.set(Measuring::EVERY_FACE, every_face);
    let stencil = StencilCounts { bound_counts: true, ..StencilCounts::default() };
    let capacities = Capacities { lists: Some(1 << 14), ..Capacities::default() };
    let options = SceneOptions { max_lights: 1, stencil, capacities, measuring, ..SceneOptions::default() };
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let insert = |case: &Case| {
        let mesh = case.shape.mesh().map_err(text)?;
        let mesh = scene.add_mesh(&mesh, &case.shape.positions).map_err(text)?;
        scene.insert(Caster::rigid(mesh, IDENTITY)).map_err(text)
    };
    let casters = cases.iter().map(insert).collect::<Result<Vec<_>, String>>()?;
    scene.add_light(cases[0].light).map_err(text)?;
    let position = DVec3::splat(5000.0);
    let eye = Eye { is_relative: true, ..Eye::new(position, position, 0.1) };
    let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::new(&[eye.camera().into()])).map_err(text))?;
    let words: Vec<u32> = gpu.read(frame.results().map_err(text)?.choices.ok_or("no view")?, usize::MAX)?;
    for (case, caster) in cases.iter_mut().zip(casters) {
        let (index, _) = frame.locate(caster).ok_or("the caster is not in the frame")?;
        let [casts, every] = [0, 1].map(|kind| words[CHOICE_WORDS * index as usize + kind] & 1);
        if casts == 0 {
            return Err("a caster is skipped".to_owned());
        }
        case.casting = if every == 1 { CAST_EVERY } else { CAST_BACK_FACING };
    }
    let statistics: Vec<ShadowStatistics> = gpu.read(frame.shadow_statistics().ok_or("no view")?, 1)?;
    Ok(statistics[0].count_bound)
}

fn stacks() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(231)?;
    let (mut deepest, mut back_facing) = (0, 0);
    let rounds = if is_long() { 6000 } else { 300 };
    for number in 0..rounds {
        let down = DVec3::new(f64::from(random.between(-0.3, 0.3)), -1.0, f64::from(random.between(-0.2, 0.2)));
        let light_position = vector(&mut random) * 4.0;
        let shape = stack(&mut random, light_position, down.normalize());
        let w = [1.0, 0.5, 1.0, 0.0][number % 4];
        let light = match w {
            0.0 => Light::directional((-down).as_vec3().to_array()),
            _ => Light::homogeneous((light_position * w).extend(w).as_vec4().to_array()),
        };
        let every_face = random.below(3) < 2;
        let mut case = [Case::new(shape, light)];
        let bound = bound(&gpu, &mut case, every_face)?;
        let [case] = case;
        back_facing += usize::from(case.casting == CAST_BACK_FACING);
        let what = |error: String| format!("number {number}, w {w}, casting {}: {error}", case.casting);
        let found = case.check(bound, &mut random).map_err(what)?;
        deepest = deepest.max(found);
        must_fail("a bound of less", &case.check(found.saturating_sub(1), &mut random))?;
        must_fail("a bound of too much", &case.check(2 * bound + 2, &mut random))?;
    }
    println!("{rounds} stacks, {back_facing} of back-facing faces, counts up to {deepest}");
    if deepest > 20 && back_facing > rounds / 5 { Ok(()) } else { Err("no stack is deep".to_owned()) }
}

/// Worked by hand: blocks in a row below the light, which stands near the end of a long box and off its middle. Some are
/// small, to one side of the light; the others reach from there to its other side. A ray meets them all.
fn near_the_end() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let block = |low: [f32; 3], high: [f32; 3]| {
        shapes::cube().placed(|p| std::array::from_fn(|axis| if p[axis] < 0.0 { low[axis] } else { high[axis] }))
    };
    let mut blocks = vec![block([-40.0, -1.9, -0.1], [-39.0, -1.8, 0.1])];
    for number in 0..10 {
        let y = -1.0 - 0.1 * number as f32;
        blocks.push(block([0.02, y, -0.1], [0.08, y + 0.02, 0.1]));
        blocks.push(block([-0.3, y + 0.04, -0.1], [0.3, y + 0.06, 0.1]));
    }
    let mut case = [Case::new(Shape::joined(&blocks), Light::point([0.0; 3]))];
    let bound = bound(gpu, &mut case, true)?;
    let [case] = case;
    let at = DVec3::new(0.0475, -1.0, 0.001);
    let count = case.count(at * 3.0);
    println!("{count} faces below each other, the bound is {bound}");
    if count >= 30 && bound >= count { Ok(()) } else { Err(format!("a count of {count}, the bound is {bound}")) }
}

/// Rays from a light among many casters: piles of blocks in directions at random or along coordinate axes, blocks around it,
/// one that it is in, and blocks that its axes pass.
fn among_casters() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(232)?;
    let (mut deepest, mut sharp) = (0, 0);
    let rounds = if is_long() { 3000 } else { 150 };
    for number in 0..rounds {
        let w = [1.0, 0.5, 2.0][number % 3];
        let light_position = vector(&mut random) * [0.0, 1.0, 100.0][random.below(3)];
        let light = Light::homogeneous((light_position * w).extend(w).as_vec4().to_array());
        // Position of the light in the stages, after rounding.
        let light_position = DVec3::from(light.xyz.map(f64::from)) / w;
        let every_face = random.below(2) == 0;
        let mut cases = Vec::new();
        let mut add = |middle: DVec3, scale: DVec3, random: &mut Random| {
            let one = if random.below(3) == 0 { shapes::blob(2, 0.1, number as u32) } else { shapes::cube() };
            cases.push(Case::new(placed(one, middle, scale), light));
        };
        let pile = match random.below(3) {
            0 => DVec3::from([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]][random.below(3)]),
            _ => vector(&mut random),
        };
        for step in 0..5 + random.below(30) {
            let size = f64::from(random.between(0.02, 0.1));
            add(light_position + pile * (0.5 + 0.25 * step as f64), DVec3::splat(size), &mut random);
        }
        for _ in 0..random.below(60) {
            let middle = light_position + DVec3::from([(); 3].map(|()| f64::from(random.between(-4.0, 4.0))));
            let scale = DVec3::from([(); 3].map(|()| f64::from(random.between(0.02, 0.4))));
            add(middle, scale, &mut random);
        }
        if random.below(4) == 0 {
            add(light_position, DVec3::splat(6.0), &mut random);
        }
        let bound = bound(&gpu, &mut cases, every_face)?;
        let mut count = 0;
        for case in &cases {
            for face in &case.shape.faces {
                let [a, b, c] = face.map(|v| DVec3::from(case.shape.positions[v as usize].map(f64::from)));
                let (s, t) = (f64::from(random.between(0.05, 0.45)), f64::from(random.between(0.05, 0.45)));
                let through = a + (b - a) * s + (c - a) * t;
                // Beyond everything.
                let far = light_position + (through - light_position).normalize() * 30.0;
                count = count.max(cases.iter().map(|case| case.count(far)).sum::<u32>());
            }
        }
        let within = |bound: u32| {
            if bound < count {
                Err(format!("number {number}: a count of {count}, the bound is {bound}"))
            } else {
                Ok(())
            }
        };
        within(bound)?;
        must_fail("a bound of less", &within(count.saturating_sub(1)))?;
        deepest = deepest.max(count);
        let faces: usize = cases.iter().map(|case| case.shape.faces.len()).sum();
        sharp += u32::from((bound as usize) < faces / 4);
    }
    println!("{rounds} lights, counts up to {deepest}, {sharp} bounds below a quarter of the faces");
    if deepest > 20 && sharp as usize > rounds / 2 {
        Ok(())
    } else {
        Err("no pile is deep, or bounds are loose".to_owned())
    }
}

/// Piles in opposite directions cross no half plane together, also where one of them lies across the half plane that the
/// bins begin at.
fn opposite_piles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let light = Light::point([0.0; 3]);
    for (along, others) in [
        (DVec3::Z, None),
        // These lie on the axis that is taken if nothing lies on any.
        (DVec3::X, Some(DVec3::Y)),
        (DVec3::Y, Some(DVec3::Z)),
    ] {
        let cube = |middle: DVec3| Case::new(placed(shapes::cube(), middle, DVec3::splat(0.05)), light);
        let pile = |direction: DVec3, cubes: u32| (1..=cubes).map(move |step| cube(direction * f64::from(step)));
        let others = || others.into_iter().map(|direction| cube(direction * 3.0));
        let bound = |ahead: u32, behind: u32| {
            let casters = pile(along, ahead).chain(pile(-along, behind)).chain(others());
            bound(gpu, &mut casters.collect::<Vec<_>>(), true)
        };
        // The light is always between two casters, so that the half planes are the same.
        let (one, other, both) = (bound(40, 1)?, bound(1, 40)?, bound(40, 40)?);
        println!("along {along}: {one} and {other}, together {both}");
        let sharp = |both: u32| {
            if 4 * both <= 5 * one.max(other) { Ok(()) } else { Err(format!("{along}: {both}")) }
        };
        sharp(both)?;
        must_fail("the sum", &sharp(one + other))?;
    }
    Ok(())
}
