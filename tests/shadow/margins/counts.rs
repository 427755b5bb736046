//! The bound on stencil counts: never below a count that is found by trying every face, and sharp for piles.
//!
//! The stages are `stencil_pencil`, `stencil_crossings` and `stencil_bound`.

use glam::DVec3;
use rimline::gpu::{Capacities, Caster, FrameInputs, Measuring, Scene, SceneOptions, ShadowStatistics, StencilCounts};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::internals::shadow::{CAST_BACK_FACING, CAST_EVERY};
use rimline::{Light, Predicate};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Eye, vector};
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{IDENTITY, is_long, must_fail, same};

pub(super) const TESTS: &[Test] = &[
    ("bounds_hold_for_piles_of_casters", piles),
    ("opposite_piles_do_not_add_up", opposite_piles),
    ("bounds_hold_where_lists_overflow", overflow),
];

/// A shape that is scaled and moved.
fn placed(shape: Shape, middle: DVec3, scale: DVec3) -> Shape {
    shape.placed(|p| (middle + DVec3::from(p.map(f64::from)) * scale).as_vec3().to_array())
}

struct Case {
    shape: Shape,
    light: Light,
    casting: u32,
    facing: Vec<u32>,
}

impl Case {
    fn new(shape: Shape, light: Light) -> Self {
        let facing = cpu::facing(&shape.positions, &shape.faces, &[light], Predicate::Exact, Threads::ONE);
        Self { facing, shape, light, casting: CAST_EVERY }
    }

    fn corners(&self, face: [u32; 3]) -> [DVec3; 3] {
        face.map(|vertex| DVec3::from(self.shape.positions[vertex as usize].map(f64::from)))
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
        let crosses = |(&face, &facing): (&[u32; 3], &u32)| {
            let [a, b, c] = self.corners(face).map(|corner| corner - from);
            let inside = [a.cross(b), b.cross(c), c.cross(a)].map(|normal| normal.dot(along));
            let normal = (b - a).cross(c - a);
            let before = normal.dot(a) * normal.dot(along) > 0.0;
            let is_met = inside.iter().all(|&side| side > 0.0) || inside.iter().all(|&side| side < 0.0);
            before && is_met && (self.casting == CAST_EVERY || facing == 0)
        };
        self.shape.faces.iter().zip(&self.facing).filter(|&face| crosses(face)).count() as u32
    }
}

/// The bound for casters with one light, in a scene that skips nothing, seen from far away. Which faces cast is chosen
/// there. Lists have room for so many `sides`.
fn bound(gpu: &Gpu, cases: &mut [Case], every_face: bool, sides: u32) -> Result<u32, String> {
    let mut measuring = Measuring::CULLED_BY_VIEW;
    measuring.set(Measuring::EVERY_FACE, every_face);
    let stencil = StencilCounts { bound_counts: true, ..StencilCounts::default() };
    let capacities = Capacities { lists: Some(sides), ..Capacities::default() };
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

/// Rays from a light: piles of blocks and balls in directions at random or along coordinate axes, about the line from the
/// light, some reaching far to one side; beside them a block far off, so that the box is long; blocks around the light, one
/// that it is in, and blocks that its axes pass.
fn piles() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(232)?;
    let (mut deepest, mut sharp, mut back_facing) = (0, 0, 0);
    let rounds = if is_long() { 6000 } else { 320 };
    for number in 0..rounds {
        let w = [1.0, 0.5, 2.0, 0.0][number % 4];
        let pile = match random.below(3) {
            0 => DVec3::from([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]][random.below(3)]),
            _ => vector(&mut random),
        };
        let light_position = vector(&mut random) * [0.0, 1.0, 100.0][random.below(3)];
        let light = match w {
            0.0 => Light::directional((-pile).as_vec3().to_array()),
            _ => Light::homogeneous((light_position * w).extend(w).as_vec4().to_array()),
        };
        // Position of the light in the stages, after rounding.
        let light_position = if w == 0.0 { DVec3::ZERO } else { DVec3::from(light.xyz.map(f64::from)) / w };
        let (mut cases, mut blocks) = (Vec::new(), Vec::new());
        let mut add = |middle: DVec3, scale: DVec3, random: &mut Random| {
            let one = if random.below(3) == 0 { shapes::blob(2, 0.1, number as u32) } else { shapes::cube() };
            blocks.push(placed(one, middle, scale));
        };
        let aside = pile.cross(vector(&mut random)).normalize();
        for step in 0..5 + random.below(30) {
            let size = f64::from(random.between(0.02, 0.1)) * [1.0, 1.0, 10.0][random.below(3)];
            let off = aside * (size * f64::from(random.between(0.0, 0.9)));
            let flat = DVec3::splat(size) * (DVec3::ONE - 0.9 * pile.abs());
            add(light_position + pile * (0.5 + 0.25 * step as f64) + off, flat, &mut random);
        }
        if random.below(2) == 0 {
            let away = aside * f64::from(random.between(-60.0, 60.0));
            add(light_position + pile * 1.5 + away, DVec3::splat(0.1), &mut random);
        }
        for _ in 0..random.below(60) * random.below(2) {
            let middle = light_position + DVec3::from([(); 3].map(|()| f64::from(random.between(-4.0, 4.0))));
            let scale = DVec3::from([(); 3].map(|()| f64::from(random.between(0.02, 0.4))));
            add(middle, scale, &mut random);
        }
        if random.below(4) == 0 {
            add(light_position, DVec3::splat(6.0), &mut random);
        }
        // A caster for each, or one of all.
        match number / 4 % 2 {
            0 => cases.extend(blocks.into_iter().map(|block| Case::new(block, light))),
            _ => cases.push(Case::new(Shape::joined(&blocks), light)),
        }
        let bound = bound(&gpu, &mut cases, random.below(2) == 0, 1 << 14)?;
        back_facing += usize::from(cases.iter().all(|case| case.casting == CAST_BACK_FACING));
        let mut count = 0;
        for case in &cases {
            for face in &case.shape.faces {
                let [a, b, c] = case.corners(*face);
                let (s, t) = (f64::from(random.between(0.05, 0.45)), f64::from(random.between(0.05, 0.45)));
                let through = a + (b - a) * s + (c - a) * t;
                count = count.max(cases.iter().map(|case| case.count(through)).sum::<u32>());
            }
        }
        at_least(bound, count).map_err(|error| format!("number {number}: {error}"))?;
        must_fail("a bound of less", &at_least(count.saturating_sub(1), count))?;
        deepest = deepest.max(count);
        let faces: usize = cases.iter().map(|case| case.shape.faces.len()).sum();
        sharp += usize::from((bound as usize) < faces / 4);
    }
    println!("{rounds} lights, {back_facing} of back-facing faces, counts up to {deepest}, {sharp} bounds are sharp");
    let is_meant = deepest > 20 && sharp > rounds / 2 && back_facing > rounds / 10;
    if is_meant { Ok(()) } else { Err("no pile is deep, or bounds are loose".to_owned()) }
}

fn at_least(bound: u32, count: u32) -> Result<(), String> {
    if bound < count { Err(format!("a count of {count}, the bound is {bound}")) } else { Ok(()) }
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
            bound(gpu, &mut casters.collect::<Vec<_>>(), true, 1 << 14)
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

/// A strip of triangles that winds like a stair, all on one ray. Half of the edges that a half plane crosses are folds, where
/// the count changes by 2, so a bound that counted each edge once would be too small.
fn overflow() -> Result<(), String> {
    const FACES: u32 = 60;
    let corner = |at: u32| {
        // Corners lie in different half planes.
        let angle = f64::from(120 * at + 7 * at % 11 * 3 + 345).to_radians();
        DVec3::new(angle.cos(), angle.sin(), 0.05 * f64::from(at)).as_vec3().to_array()
    };
    let shape = Shape {
        positions: (0..FACES + 2).map(corner).collect(),
        faces: (0..FACES).map(|face| [face, face + 1, face + 2]).collect(),
    };
    let mut cases = [Case::new(shape, Light::point([0.01, 0.02, 100.0]))];
    let gpu = &*Gpu::shared()?;
    for sides in [1 << 14, 1] {
        let bound = bound(gpu, &mut cases, true, sides)?;
        let count = cases[0].count(DVec3::new(0.05, 0.03, -1.0));
        println!("{count} faces, bound {bound}, with room for {sides} sides");
        same("faces between", &[count], &[FACES])?;
        at_least(bound, count)?;
    }
    Ok(())
}
