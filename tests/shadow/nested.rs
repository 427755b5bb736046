//! Closed casters in one mesh of several components: wound inwards, nested, through each other. The light is anywhere,
//! also within their box, and so is the eye. Which faces cast there is argued in docs/numerics/casting-faces.md, "Which
//! faces cast". Lights on faces, edges and vertices, and next to them.

use glam::{DVec3, Vec3};
use rimline::{Counting, Light};
use rimline_testkit::shapes::{self, Shape};

use crate::render::{Placing, Renderer};
use crate::trials::{RIGHT, Test, Traced};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Body, Eye, Frame};
use rimline_testkit::is_long;
use rimline_testkit::shells::{component, nested, somewhere};

pub(crate) const TESTS: &[Test] = &[("lights_on_a_surface", on_surface), ("lights_next_to_a_surface", off_surface)];

/// A cube, wound either way, with the light on it or next to it, seen from before the face that the light is at and from
/// behind it, by each method. With the light on it also in a scene, with a matrix, and seen from within.
fn at_a_cube(light: [f32; 3], methods: &[Counting], is_on: bool) -> Result<usize, String> {
    let gpu = Gpu::shared()?;
    let mut shadowed = 0;
    let placing = if is_on { Placing::Scene } else { Placing::Alone };
    let mirror = Some(Vec3::new(-1.0, 1.0, 1.0));
    let ways = [(false, Placing::Alone, None), (true, placing, None), (false, placing, mirror)];
    let eyes = [DVec3::new(3.0, 4.0, 5.0), DVec3::new(3.0, -3.0, 5.0), DVec3::new(-0.2, 0.1, 0.3)];
    let count = if is_on { 3 } else { 2 };
    for (is_inwards, placing, mirror) in ways.into_iter().take(count) {
        for position in eyes.into_iter().take(count) {
            let cube = Body { mirror, ..Body::caster(component(shapes::cube(), [0.0; 3], 1.0, is_inwards)) };
            let beside = Body::caster(shapes::torus(24, 12, 1.0, 0.35)).moved([2.75, 0.5, 0.0]);
            let room = Body::room([0.0; 3], 8.0);
            // Beside it, the light would be off by less than positions relative to the eye are rounded by.
            let eye = if is_on {
                Eye { is_relative: true, ..Eye::new(position, DVec3::new(0.3, -0.2, 0.1) - position, 0.05) }
            } else {
                Eye::new(position, -position, 0.05)
            };
            let (bodies, size) = if is_on { (vec![cube, beside, room], 64) } else { (vec![cube, room], 96) };
            let traced = Traced::of(Frame { bodies, eye, lights: vec![Light::point(light)], size }, 0);
            shadowed += traced.shadowed();
            let renderer = Renderer { placing, ..Renderer::new(&gpu) };
            for &counting in methods {
                let what =
                    |error| format!("light {light:?}, inwards {is_inwards}, {mirror:?}, eye {position}: {error}");
                traced.check(&renderer, counting, true).map_err(what)?;
            }
        }
    }
    Ok(shadowed)
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
                at_a_cube(light, methods, false)?;
            }
        }
    }
    Ok(())
}

/// A light exactly on a face, an edge or a vertex: the faces that contain it are excluded. On and within a cube; then on
/// vertices of bodies in each other and through each other, on edges of cubes of any size, on vertices of open sheets, and
/// in the plane of all 800 faces of a caster, with lists of sides that fit and that overflow.
fn on_surface() -> Result<(), String> {
    let mut shadowed = 0;
    for light in ON_A_CUBE.into_iter().chain([[0.3, 0.25, 0.2], [-1.5, 0.25, 0.2]]) {
        shadowed += at_a_cube(light, &RIGHT, true)?;
    }
    let (gpu, mut random) = Gpu::seeded(71)?;
    let mut overflowed = 0;
    for number in 0..if is_long() { 300 } else { 24 } {
        let mut frame = nested(&mut random);
        let open = || match number / 4 % 3 {
            0 => shapes::three_sheets(5),
            1 => shapes::moebius(12, 2),
            _ => shapes::plane_grid(20, 20),
        };
        match number % 4 {
            1 => {
                let (middle, scale) = (somewhere(&mut random, 1.5), random.between(0.7, 1.1));
                frame.bodies[0] = Body::caster(component(shapes::cube(), middle, scale, random.below(2) == 0));
            }
            2 => frame.bodies[0] = Body::caster(open()),
            3 => frame.bodies[0] = Body::caster(Shape::joined(&[open(), shapes::blob(6, 0.3, 5)])),
            _ => {}
        }
        let positions = &frame.bodies[0].shape.positions;
        let mut at = positions[random.below(positions.len())];
        if number % 4 == 1 {
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
        let mut renderer = Renderer::new(&gpu);
        renderer.options.capacities.lists = [None, Some(10)][number / 2 % 2];
        for counting in RIGHT {
            let (_, counted) =
                traced.check(&renderer, counting, true).map_err(|error| format!("frame {number}: {error}"))?;
            let light = &counted.chosen[0][0];
            if light.casting != 0 && light.excludes != 1 {
                return Err(format!("frame {number}: excluded faces are not heeded"));
            }
            overflowed += counted.statistics[0].overflowed_sides;
        }
    }
    println!("{shadowed} pixels in shadow, {overflowed} lists of sides that overflow");
    if shadowed > 10_000 && overflowed > 5 { Ok(()) } else { Err("too few of a kind".to_owned()) }
}
