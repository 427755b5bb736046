//! Maps of one texel, without anything, with NaN alone, of one lone texel, and cubes without a map; lists that have
//! room for nothing.

use glam::DVec3;
use rimline::DepthDirection;
use rimline::gpu::depth_map::{DepthMapCube, DepthMapOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::same;
use wgpu::TextureFormat;

use crate::boundary::Boundary;
use crate::maps::Map;
use crate::parity::{SIDE, Tally, device_depth, middle, truth};
use crate::picture::{AUTOMATIC, EVERY_CELL, Maps, REVERSED, STANDARD, Target, by, contours, look};
use crate::scene::{Eye, Rays};

pub(crate) const TESTS: &[Test] = &[("maps_of_little_cast_what_they_have", little)];

/// A light above the origin that looks down, and what it sees 5 below it.
fn light(depth: DepthDirection) -> Eye {
    Eye { depth, ..look(DVec3::new(0.0, 8.0, 0.0), DVec3::NEG_Y, 0.5) }
}

fn little() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let none = DepthMapOptions { capacity: Some(0), slope_bias: 0.0, ..Default::default() };
    let plain = DepthMapOptions { slope_bias: 0.0, ..by(EVERY_CELL) };
    // Contours lie between samples, not at the outer ones: only their maps of nothing are looked at.
    let walls = by(contours([1.0, 0.0, 0.0]));
    // Eyes within the light's frustum, outside it, behind the light, and before the light's near plane.
    let eye = |position: DVec3, at: DVec3, near: f64| look(position, at - position, near).camera();
    let eyes = [
        eye(DVec3::new(0.3, 5.0, 0.2), DVec3::new(0.1, 0.0, 0.3), 0.1),
        eye(DVec3::new(0.2, 1.5, 0.1), DVec3::new(1.0, -3.0, 0.0), 0.1),
        eye(DVec3::new(9.0, 3.0, 1.0), DVec3::ZERO, 0.1),
        eye(DVec3::new(1.0, 12.0, 0.5), DVec3::ZERO, 0.1),
        eye(DVec3::new(0.02, 7.8, 0.03), DVec3::new(0.0, 0.0, 0.4), 0.05),
    ];
    let mut tally = Tally::default();
    for depth in [REVERSED, STANDARD] {
        let is_reversed = depth == REVERSED;
        let far = f32::from(!is_reversed);
        let light = light(depth).camera();
        let near = device_depth(&light, DVec3::new(0.0, 3.0, 0.0));
        let maps = [
            Map::new([1, 1], is_reversed, |_| near),
            Map::new([1, 1], is_reversed, |_| f32::NAN),
            Map::new([5, 5], is_reversed, |_| far),
            Map::new([5, 4], is_reversed, |_| f32::NAN),
            Map::new([7, 7], is_reversed, |texel| if texel == 24 { near } else { far }),
            Map::new([7, 7], is_reversed, |texel| if texel == 24 { near } else { f32::NAN }),
        ];
        let cameras = DepthMapCube::cameras([0.0, 8.0, 0.0], 0.1, None, depth, 3).map_err(text)?;
        let cube = Maps::all(&gpu, (&[const { None }; 6], 3), TextureFormat::R32Float, &cameras)?;
        for (number, map) in maps.iter().enumerate() {
            let given = Maps::of(&gpu, map, TextureFormat::R32Float, light)?;
            let boundary = Boundary::edited(map, &light, DVec3::new(0.0, 8.0, 0.0).extend(1.0), -1.0, None);
            let is_nothing = (1..4).contains(&number);
            for (eye_number, &eye) in eyes.iter().enumerate() {
                // Beyond the caster, at it nearly, between near plane and caster, and far beyond.
                for height in [[0.0, 4.0], [2.5, -400.0]][(number + eye_number) % 2] {
                    let rays = Rays::new(&eye, SIDE);
                    let seen = |at| {
                        let (near, ray) = rays.at(at);
                        (near, near + (height - near.y) / ray.y * ray)
                    };
                    let is_seen = |at| (seen(at).1 - seen(at).0).dot(rays.at(at).1) > 0.0;
                    let positions: Vec<_> = (0..SIDE * SIDE).map(|pixel| middle(pixel, SIDE)).collect();
                    let depth = |&at| if is_seen(at) { device_depth(&eye, seen(at).1) } else { 0.0 };
                    let depths: Vec<_> = positions.iter().map(depth).collect();
                    let target = Target::new(eye, &depths);
                    for options in [plain, none] {
                        let stencil = target.stencil(&gpu, &given, options)?;
                        for (&at, value) in positions.iter().zip(stencil).filter(|(at, _)| is_seen(**at)) {
                            tally.add(truth(&boundary, &seen, at, (1.5, true)), value != 0);
                            tally.wrong += usize::from(is_nothing && value != 0);
                        }
                    }
                    let lit = vec![0; depths.len()];
                    if is_nothing {
                        same("walls of nothing", &target.stencil(&gpu, &given, walls)?, &lit)?;
                    }
                    if number == 2 {
                        for options in [by(AUTOMATIC), none] {
                            same("a cube without maps", &target.stencil(&gpu, &cube, options)?, &lit)?;
                        }
                    }
                }
            }
        }
    }
    println!("{tally:?}");
    if tally.wrong == 0 && tally.dark.min(tally.lit) > 5000 { Ok(()) } else { Err(format!("{tally:?}")) }
}
