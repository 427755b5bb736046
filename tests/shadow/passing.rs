//! A light that passes through a caster of a scene, by its faces, edges and vertices.

use glam::{DVec3, Vec3};
use rimline::Light;
use rimline_testkit::device::Gpu;
use rimline_testkit::{must_fail, shapes};

use crate::render::{Placing, Renderer};
use crate::scene::{Body, Eye, Frame};
use crate::trials::{RIGHT, Test, Traced, rotated};

pub(crate) const TESTS: &[Test] = &[("a_light_that_passes_through_a_caster_of_a_scene", passing)];

/// Where a cube is met: in faces, in edges, in vertices.
const PATHS: [fn(f32) -> [f32; 3]; 3] = [|t| [0.3, t, 0.2], |t| [t, t, 0.2], |t| [t; 3]];

fn passing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut shadowed, mut in_planes) = (0, 0);
    // In world space, and with a matrix.
    for mirror in [None, Some(Vec3::new(-1.0, 1.0, 1.0))] {
        for path in PATHS {
            for step in -6..=6_i8 {
                let light = path(0.25 * f32::from(step));
                for place in [DVec3::new(3.0, 4.0, 5.0), DVec3::new(-0.2, 0.1, 0.3)] {
                    let forward = DVec3::new(0.3, -0.2, 0.1) - place;
                    let eye = Eye { is_relative: true, ..Eye::new(place, forward, 0.05) };
                    let cube = Body { mirror, ..Body::caster(shapes::cube()) };
                    let beside = Body::caster(shapes::torus(24, 12, 1.0, 0.35)).moved([2.75, 0.5, 0.0]);
                    let bodies = vec![cube, beside, Body::room([0.0; 3], 8.0)];
                    let traced = Traced::of(Frame { bodies, eye, lights: vec![Light::point(light)], size: 48 }, 0);
                    shadowed += traced.shadowed();
                    in_planes += usize::from(step == 4 || step == -4);
                    let what = |error| format!("light {light:?}, eye {place}, mirror {mirror:?}: {error}");
                    let renderer = Renderer { placing: Placing::Scene, ..Renderer::new(gpu) };
                    for counting in rotated(&RIGHT, (step + 6) as usize) {
                        traced.check(&renderer, counting, true).map_err(what)?;
                    }
                    if step == 6 && place.x > 1.0 {
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
