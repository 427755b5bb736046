//! Maps of one texel, without anything, with NaN alone, of one lone texel, and large ones; and what one missed edge does.

use glam::{DVec2, DVec3};
use rimline::DepthDirection;
use rimline::gpu::depth_map::{DepthMapMethod, DepthMapOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use wgpu::TextureFormat;

use crate::boundary::Boundary;
use crate::maps::Map;
use crate::parity::{device_depth, middle};
use crate::picture::Picture;
use crate::scene::{Eye, Rays};
use crate::textures::texture;

pub(crate) const TESTS: &[Test] =
    &[("maps_of_little_cast_what_they_have", little), ("one_missed_edge_turns_parity_along_a_streak", missed)];

const SIDE: u32 = 48;

/// A light above the origin that looks down, and what it sees 5 below it.
fn light(depth: DepthDirection) -> Eye {
    let (place, forward) = (DVec3::new(0.0, 8.0, 0.0), DVec3::NEG_Y);
    Eye { place, forward, near: 0.5, is_relative: true, depth, far: None, half_width: None }
}

/// Eyes within the light's frustum, outside it, behind the light, and before the light's near plane.
fn eyes() -> [Eye; 5] {
    let depth = DepthDirection::Reversed;
    let eye = |place: DVec3, forward: DVec3, near: f64| {
        let forward = forward - place;
        Eye { place, forward, near, is_relative: true, depth, far: None, half_width: None }
    };
    [
        eye(DVec3::new(0.3, 5.0, 0.2), DVec3::new(0.1, 0.0, 0.3), 0.1),
        eye(DVec3::new(0.2, 1.5, 0.1), DVec3::new(1.0, -3.0, 0.0), 0.1),
        eye(DVec3::new(9.0, 3.0, 1.0), DVec3::ZERO, 0.1),
        eye(DVec3::new(1.0, 12.0, 0.5), DVec3::ZERO, 0.1),
        eye(DVec3::new(0.02, 7.8, 0.03), DVec3::new(0.0, 0.0, 0.4), 0.05),
    ]
}

/// The stencil of a ground at a height, and the truth of each pixel: whether it is dark, `None` near borders.
fn drawn(
    gpu: &Gpu,
    map: &Map,
    options: DepthMapOptions,
    eye: &Eye,
    height: f64,
) -> Result<Vec<(u8, Option<bool>)>, String> {
    let light = light(if map.is_reversed { DepthDirection::Reversed } else { DepthDirection::Standard });
    let (place, light, eye) = (light.place, light.camera(), eye.camera());
    let rays = Rays::new(&eye, SIDE);
    let ground = |at: DVec2| {
        let (near, ray) = rays.at(at);
        let t = (height - near.y) / ray.y;
        (t > 0.0 && t.is_finite()).then(|| (near, near + t * ray))
    };
    let centre = |pixel: u32| middle(pixel, SIDE);
    let depth = |pixel| ground(centre(pixel)).map_or(0.0, |(_, point)| device_depth(&eye, point));
    let depths: Vec<_> = (0..SIDE * SIDE).map(depth).collect();
    let texture = texture(gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let picture =
        Picture { map: &texture, objects: None, light, eye, depths: &depths, side: SIDE, options, bits: 0..1 };
    let stencil = picture.stencil(gpu)?;
    let boundary = Boundary::new(map, &light, place.extend(1.0), -1.0);
    let truth = |pixel: u32| {
        let around = [(0.0, 0.0), (0.08, 0.07), (-0.08, 0.07), (0.07, -0.08), (-0.07, -0.08)];
        let dark =
            around.map(|(x, y)| ground(centre(pixel) + DVec2::new(x, y)).map(|(_, point)| boundary.is_dark(point)));
        dark[0].filter(|_| dark == [dark[0]; 5])
    };
    Ok((0..SIDE * SIDE).zip(stencil).map(|(pixel, value)| (value, truth(pixel))).collect())
}

fn little() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
    let mut tally = [0; 2];
    for is_reversed in [false, true] {
        let depth = if is_reversed { DepthDirection::Reversed } else { DepthDirection::Standard };
        let far = if is_reversed { 0.0 } else { 1.0 };
        let seen = device_depth(&light(depth).camera(), DVec3::new(0.0, 3.0, 0.0));
        let maps = [
            Map::new([1, 1], is_reversed, |_| seen),
            Map::new([1, 1], is_reversed, |_| f32::NAN),
            Map::new([5, 5], is_reversed, |_| far),
            Map::new([5, 4], is_reversed, |_| f32::NAN),
            Map::new([7, 7], is_reversed, |texel| if texel == 24 { seen } else { far }),
            Map::new([7, 7], is_reversed, |texel| if texel == 24 { seen } else { f32::NAN }),
        ];
        for (number, map) in maps.iter().enumerate() {
            for (eye_number, eye) in eyes().iter().enumerate() {
                // Beyond the caster, at it nearly, between near plane and caster, and far beyond.
                for height in [[0.0, 4.0], [2.5, -400.0]][(number + eye_number) % 2] {
                    let is_nothing = (1..4).contains(&number);
                    for (pixel, (value, truth)) in drawn(&gpu, map, options, eye, height)?.into_iter().enumerate() {
                        let Some(dark) = truth else { continue };
                        tally[usize::from(dark)] += 1;
                        if (value != 0) != dark || (is_nothing && value != 0) {
                            return Err(format!("map {number}, eye {eye_number}, {height}, pixel {pixel}: {value}"));
                        }
                    }
                }
            }
        }
    }
    println!("{tally:?} lit and dark");
    if tally.iter().all(|&count| count > 5000) { Ok(()) } else { Err(format!("{tally:?}")) }
}

/// A plate over a ground, as near to it at one edge as the threshold: the edge is missed. Every cell has no wrong pixel, and the
/// detector that misses it has.
fn missed() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let camera = light(DepthDirection::Standard).camera();
    let at = |height: f64| device_depth(&camera, DVec3::new(0.0, height, 0.0));
    // The plate hangs at 3, its left column is at 0.4 over the ground, at 0.
    let map = Map::new([9, 9], false, |texel| match (texel % 9, texel / 9) {
        (3, 3..6) => at(0.4),
        (4..6, 3..6) => at(3.0),
        _ => at(0.0),
    });
    let threshold = (at(0.0) - at(0.4)) * 1.5;
    let eye = &eyes()[2];
    let mut wrong = [0; 2];
    for (number, edges) in
        [DepthMapMethod::EveryCell, DepthMapMethod::Differences { threshold, dangling: None }].into_iter().enumerate()
    {
        let options = DepthMapOptions { method: edges, slope_bias: 0.0, ..Default::default() };
        let pixels = drawn(&gpu, &map, options, eye, -0.5)?;
        wrong[number] = pixels.iter().filter(|(value, truth)| truth.is_some_and(|dark| dark != (*value != 0))).count();
    }
    println!("{wrong:?} wrong with every cell and with a missed edge");
    if wrong[0] == 0 && wrong[1] > 0 { Ok(()) } else { Err(format!("{wrong:?}")) }
}
