//! Closed casters in one mesh of several components: wound inwards, nested, through each other. The light is anywhere,
//! also within their box, and so is the eye. Which faces cast there is argued in docs/numerics/casting-faces.md, "Which
//! faces cast". Lights on faces, edges and vertices, and next to them.

use glam::{DVec3, Vec3};
use rimline::{Counting, Light};
use rimline_testkit::must_fail;
use rimline_testkit::shapes::{self, Shape};

use crate::rays::Truth;
use crate::render::{Placing, Renderer};
use crate::scene::{Body, Eye, Frame};
use crate::shells::{component, nested, somewhere};
use crate::trials::{RIGHT, Test, Traced, rotated};
use rimline_testkit::device::Gpu;
use rimline_testkit::is_long;
use rimline_testkit::random::Random;

pub(crate) const TESTS: &[Test] = &[
    ("nothing_outside_an_inwards_cube_is_lit_from_within", inwards),
    ("lights_at_the_edge_of_the_box", at_the_box),
    ("lights_on_a_surface", on_surface),
    ("lights_in_the_plane_of_many_faces", many_in_a_plane),
    ("lights_next_to_a_surface", off_surface),
    ("a_light_that_passes_through_a_caster_of_a_scene", passing),
];

/// A cube that is wound inwards, above the ground.
fn inwards_cube(light: Light) -> Frame {
    let cube = component(shapes::cube(), [0.0; 3], 1.0, true);
    let ground = Shape {
        positions: vec![[-300.0, -1.1, -300.0], [-300.0, -1.1, 300.0], [300.0, -1.1, 300.0], [300.0, -1.1, -300.0]],
        faces: vec![[0, 1, 2], [0, 2, 3]],
    };
    let position = DVec3::new(5.0, 4.0, 6.0);
    let eye = Eye::new(position, -position, 0.05);
    let bodies = vec![Body::caster(cube), Body { casts: false, ..Body::caster(ground) }];
    Frame { bodies, eye, lights: vec![light], size: 240 }
}

/// With the light inside, its walls are all that there is between the light and the world.
fn inwards() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let light = [0.2, 0.3, 0.1];
    // Another w is the same position.
    for w in [1.0, 0.3] {
        let traced = Traced::of(inwards_cube(Light::homogeneous([light[0] * w, light[1] * w, light[2] * w, w])), 0);
        let surface = |truths: &Vec<Truth>| matches!(truths[0], Truth::Surface(_));
        let outside = traced.truths.iter().filter(|truths| surface(truths)).count();
        if outside < 20_000 || traced.truths.iter().any(|truths| truths[0].is_lit()) {
            return Err(format!("{outside} pixels of ground, and by rays some are lit"));
        }
        for counting in RIGHT {
            let counted = Renderer::new(&gpu).count(&traced.frame, counting)?;
            let lit = traced.truths.iter().zip(&counted.stencils[0]);
            let lit = lit.filter(|(truths, count)| surface(truths) && **count == 0).count();
            if lit > 0 {
                return Err(format!("{counting:?}, w {w}: {lit} of {outside} pixels outside are lit"));
            }
            traced.check(&Renderer::new(&gpu), counting, true)?;
        }
    }
    Ok(())
}

/// Lights an ulp within, on and an ulp beyond a side, an edge and a corner of the box, where the body is not: no face is
/// left out of the count that has to be in it.
fn at_the_box() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    // Two balls at opposite corners of their box, wound either way.
    let ball = |at: f32, is_inwards| component(shapes::blob(6, 0.2, 7), [at; 3], 0.8, is_inwards);
    for windings in [[true, true], [false, true], [false, false]] {
        let shape = Shape::joined(&[ball(-1.2, windings[0]), ball(1.2, windings[1])]);
        let high: [f32; 3] = std::array::from_fn(|axis| {
            shape.positions.iter().map(|position| position[axis]).fold(f32::NEG_INFINITY, f32::max)
        });
        for axes in [1, 2, 3] {
            for step in [-1, 0, 1_i32] {
                let bits = |at: f32| f32::from_bits(at.to_bits().wrapping_add_signed(step));
                let mut at = [-0.9, high[1] * 0.3, -high[2] * 0.8];
                for axis in 0..axes {
                    at[axis] = bits(high[axis]);
                }
                let mut frame = nested(&mut Random::new(5));
                frame.bodies[0] = Body::caster(shape.clone());
                frame.eye =
                    Eye { position: DVec3::new(-4.0, 3.0, 5.0), forward: DVec3::new(4.0, -3.5, -5.0), ..frame.eye };
                frame.lights = vec![Light::point(at)];
                let traced = Traced::of(frame, 0);
                for counting in RIGHT {
                    let (_, counted) = traced
                        .check(&Renderer::new(&gpu), counting, true)
                        .map_err(|error| format!("{windings:?}, light {at:?}: {error}"))?;
                    if step < 1 && counted.chosen[0][0].casting == 1 {
                        return Err(format!("{windings:?}, light {at:?}: back-facing faces alone cast"));
                    }
                }
            }
        }
    }
    Ok(())
}

/// A cube, wound either way, with the light on it or next to it, seen from before the face that the light is at and from
/// behind it, by each method.
fn at_a_cube(light: [f32; 3], methods: &[Counting]) -> Result<(), String> {
    let gpu = Gpu::shared()?;
    for is_inwards in [false, true] {
        for position in [DVec3::new(3.0, 4.0, 5.0), DVec3::new(3.0, -3.0, 5.0)] {
            let mut frame = nested(&mut Random::new(5));
            frame.bodies[0] = Body::caster(component(shapes::cube(), [0.0; 3], 1.0, is_inwards));
            frame.eye = Eye { position, forward: -position, near: 0.05, ..frame.eye };
            frame.lights = vec![Light::point(light)];
            let traced = Traced::of(frame, 0);
            for &counting in methods {
                let what = |error| format!("light {light:?}, inwards {is_inwards}, eye {position}: {error}");
                traced.check(&Renderer::new(&gpu), counting, true).map_err(what)?;
            }
        }
    }
    Ok(())
}

/// Within a face, on its diagonal, at an edge and at a vertex.
const ON_A_CUBE: [[f32; 3]; 4] = [[0.3, 1.0, 0.2], [0.25, 1.0, 0.25], [1.0, 1.0, 0.2], [1.0; 3]];

/// Before or behind each of the faces there: within a face by an ulp, where only z-fail suffers, whose dark cap is
/// nearly half of infinity then and turned either way by rounding; everywhere by a ten-thousandth, as far as rounding
/// of a side's vertices turns it by a pixel. By an ulp, near caps reach so far out of the picture that an NVIDIA GPU
/// draws half of one only (docs/measured.md), so that is asked of software devices.
fn off_surface() -> Result<(), String> {
    let is_software = Gpu::shared()?.device.adapter_info().device_type == wgpu::DeviceType::Cpu;
    let next = [(f32::EPSILON, &ON_A_CUBE[..2], &RIGHT[..2]), (1e-4, &ON_A_CUBE[..], &RIGHT[..])];
    for &(off, lights, methods) in next.iter().filter(|(off, ..)| is_software || *off > 1e-6) {
        for &on in lights {
            let sides: Vec<usize> = (0..3).filter(|&axis| on[axis] == 1.0).collect();
            for steps in 0..1 << sides.len() {
                let mut light = on;
                for (bit, &axis) in sides.iter().enumerate() {
                    light[axis] = if steps >> bit & 1 == 0 { 1.0 - off / 2.0 } else { 1.0 + off };
                }
                at_a_cube(light, methods)?;
            }
        }
    }
    Ok(())
}

/// A light exactly on a face, an edge or a vertex: the faces that contain it are excluded. On a cube; then on vertices of
/// bodies in each other and through each other, on edges of cubes of any size, and on vertices of open sheets.
fn on_surface() -> Result<(), String> {
    ON_A_CUBE.into_iter().try_for_each(|light| at_a_cube(light, &RIGHT))?;
    let (gpu, mut random) = Gpu::seeded(71)?;
    for number in 0..if is_long() { 300 } else { 18 } {
        let mut frame = nested(&mut random);
        match number % 3 {
            1 => {
                let (middle, scale) = (somewhere(&mut random, 1.5), random.between(0.7, 1.1));
                frame.bodies[0] = Body::caster(component(shapes::cube(), middle, scale, random.below(2) == 0));
            }
            2 => frame.bodies[0] = Body::caster([shapes::three_sheets(5), shapes::moebius(12, 2)][number % 2].clone()),
            _ => {}
        }
        let positions = &frame.bodies[0].shape.positions;
        let mut at = positions[random.below(positions.len())];
        if number % 3 == 1 {
            // Along the edge, which is parallel to an axis.
            let [axis, other] = [random.below(3), random.below(positions.len())];
            let end = positions[other][axis];
            at[axis] += (end - at[axis]) * random.between(0.1, 0.9);
        }
        // Another w is the same position.
        let w = [1.0, 0.25][number % 2];
        let [x, y, z] = at.map(|coordinate| coordinate * w);
        frame.lights = vec![Light::homogeneous([x, y, z, w])];
        let traced = Traced::of(frame, number as u64);
        for counting in RIGHT {
            traced.check(&Renderer::new(&gpu), counting, true).map_err(|error| format!("frame {number}: {error}"))?;
        }
    }
    Ok(())
}

/// A cube whose sides are squares of two triangles each, so many along an edge.
fn fine_cube(squares: u32) -> Shape {
    let mut shape = Shape::default();
    for side in 0..6 {
        let (axis, is_high) = (side % 3, side < 3);
        for square in 0..squares * squares {
            let corner = |right: u32, up: u32| {
                let at = |step: u32| 2.0 * step as f32 / squares as f32 - 1.0;
                let mut corner = [0.0; 3];
                corner[axis] = if is_high { 1.0 } else { -1.0 };
                corner[(axis + 1) % 3] = at(square % squares + right);
                corner[(axis + 2) % 3] = at(square / squares + up);
                corner
            };
            let first = shape.positions.len() as u32;
            shape.positions.extend([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
            let halves = [[first, first + 1, first + 2], [first, first + 2, first + 3]];
            shape.faces.extend(halves.map(|[a, b, c]| if is_high { [a, b, c] } else { [a, c, b] }));
        }
    }
    shape
}

/// Hundreds of faces in a light's plane, for several lights, with lists of sides that fit and that overflow.
fn many_in_a_plane() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    // Excluded faces of a light: 2 for each square of one, two and no sides.
    let squares = 20;
    for list_capacity in [None, Some(200)] {
        for position in [DVec3::new(3.0, 4.0, 5.0), DVec3::new(3.0, -3.0, 5.0)] {
            let mut frame = nested(&mut Random::new(5));
            frame.bodies[0] = Body::caster(fine_cube(squares));
            frame.eye = Eye { position, forward: -position, near: 0.05, ..frame.eye };
            frame.lights = [[0.31, 1.0, 0.23], [2.0, 3.0, 1.5], [0.2, 0.31, -1.0]].map(Light::point).to_vec();
            let traced = Traced::of(frame, u64::from(squares));
            for counting in RIGHT {
                let what = |error| format!("room for {list_capacity:?}, eye {position}: {error}");
                let renderer = Renderer { list_capacity, ..Renderer::new(&gpu) };
                let (_, counted) = traced.check(&renderer, counting, true).map_err(what)?;
                let excludes: Vec<u32> = counted.chosen[0].iter().map(|light| light.excludes).collect();
                if excludes != [1, 0, 1] {
                    return Err(what(format!("{excludes:?}")));
                }
                // Two lights have the border of a side of the cube for a silhouette, of 80 edges and their doubles.
                if (counted.statistics[0].overflowed_sides > 0) != list_capacity.is_some() {
                    return Err(what(format!("{:?}", counted.statistics[0])));
                }
            }
        }
    }
    Ok(())
}

/// Where a cube is met: in faces, in edges, in vertices.
const PATHS: [fn(f32) -> [f32; 3]; 3] = [|t| [0.3, t, 0.2], |t| [t, t, 0.2], |t| [t; 3]];

/// In faces, edges and vertices of a cube of a scene, step by step.
fn passing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut shadowed, mut in_planes) = (0, 0);
    // In world space, and with a matrix.
    for mirror in [None, Some(Vec3::new(-1.0, 1.0, 1.0))] {
        for path in PATHS {
            for step in -6..=6_i8 {
                let light = path(0.25 * f32::from(step));
                for position in [DVec3::new(3.0, 4.0, 5.0), DVec3::new(-0.2, 0.1, 0.3)] {
                    let forward = DVec3::new(0.3, -0.2, 0.1) - position;
                    let eye = Eye { is_relative: true, ..Eye::new(position, forward, 0.05) };
                    let cube = Body { mirror, ..Body::caster(shapes::cube()) };
                    let beside = Body::caster(shapes::torus(24, 12, 1.0, 0.35)).moved([2.75, 0.5, 0.0]);
                    let bodies = vec![cube, beside, Body::room([0.0; 3], 8.0)];
                    let traced = Traced::of(Frame { bodies, eye, lights: vec![Light::point(light)], size: 48 }, 0);
                    shadowed += traced.shadowed();
                    in_planes += usize::from(step == 4 || step == -4);
                    let what = |error| format!("light {light:?}, eye {position}, mirror {mirror:?}: {error}");
                    let renderer = Renderer { placing: Placing::Scene, ..Renderer::new(gpu) };
                    for counting in rotated(&RIGHT, (step + 6) as usize) {
                        traced.check(&renderer, counting, true).map_err(what)?;
                    }
                    if step == 6 && position.x > 1.0 {
                        let mut moved = Traced { frame: traced.frame.clone(), ..traced };
                        moved.frame.lights = vec![Light::point(path(-1.5))];
                        must_fail("the light on the other side", &moved.check(&renderer, RIGHT[0], false).map(drop))?;
                    }
                }
            }
        }
    }
    println!("{shadowed} pixels in shadow, {in_planes} pictures with the light in planes of faces");
    if shadowed < 10_000 { Err("too few pixels in shadow".to_owned()) } else { Ok(()) }
}
