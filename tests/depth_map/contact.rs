//! How far from its contact with the ground the shadow of a body begins: the boundary is moved away from surfaces, so it may
//! begin late.

use std::collections::BTreeMap;

use glam::DVec3;
use rimline::DepthDirection;
use rimline::gpu::depth_map::{DepthMap, DepthMapMethod, DepthMapOptions, DepthMapVolumes};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::parity::{device_depth, middle};
use crate::picture::{pipelines, stencil_of};
use crate::scene::{Eye, Rays};
use crate::textures::{depth_view, texture};
use crate::views::Sun;
use crate::worlds::World;

pub(crate) const TESTS: &[Test] = &[("contact_shadows_begin_within_the_bound", contacts)];

/// Texels of the map, which is ten units wide, and pixels of the picture, along a side.
const TEXELS: u32 = 96;
const TEXEL: f64 = 10.0 / TEXELS as f64;
const PIXELS: u32 = 128;
/// Half of what the eyes see from side to side.
const HALF_WIDTH: f64 = 0.4;
/// A low eye looks in under a ball, so it must look closely.
const CLOSE: f64 = 0.12;
/// The move of the ground: half a texel in both directions. And a pixel.
const BOUND: f64 = std::f64::consts::FRAC_1_SQRT_2 + 2.0 * HALF_WIDTH / PIXELS as f64 / TEXEL;

/// A body that touches the ground, an eye that looks at the contact, and the place of a point of the ground along the contact
/// and away from it.
struct Contact {
    name: &'static str,
    world: World,
    eye: Eye,
    place: fn(DVec3) -> (i64, f64),
}

fn contacts_of() -> [Contact; 4] {
    let eye = |target: DVec3, forward: DVec3, half_width: f64| Eye {
        place: target - 5.0 * forward.normalize(),
        forward,
        near: 0.1,
        is_relative: true,
        depth: DepthDirection::Reversed,
        far: Some(20.0),
        half_width: Some(half_width),
    };
    [
        Contact {
            name: "box",
            world: World::Cuboid { centre: DVec3::new(0.0, 1.0, 0.0), half: DVec3::new(0.7, 1.0, 1.2) },
            eye: eye(DVec3::new(-0.7 - HALF_WIDTH, 0.0, 0.0), DVec3::NEG_Y, HALF_WIDTH),
            place: |at| ((at.z / HALF_WIDTH * 64.0).floor() as i64, -0.7 - at.x),
        },
        Contact {
            name: "wall, a quarter of a texel thick",
            world: World::Cuboid { centre: DVec3::new(0.0, 1.0, 0.0), half: DVec3::new(TEXEL / 8.0, 1.0, 1.2) },
            eye: eye(DVec3::new(-TEXEL / 8.0 - HALF_WIDTH, 0.0, 0.0), DVec3::NEG_Y, HALF_WIDTH),
            place: |at| ((at.z / HALF_WIDTH * 64.0).floor() as i64, -TEXEL / 8.0 - at.x),
        },
        Contact {
            name: "kerb, three texels high",
            world: World::Cuboid { centre: DVec3::new(0.0, 1.5 * TEXEL, 0.0), half: DVec3::new(0.7, 1.5 * TEXEL, 1.2) },
            eye: eye(DVec3::new(-0.7 - HALF_WIDTH, 0.0, 0.0), DVec3::NEG_Y, HALF_WIDTH),
            place: |at| ((at.z / HALF_WIDTH * 64.0).floor() as i64, -0.7 - at.x),
        },
        Contact {
            name: "ball",
            world: World::Sphere { centre: DVec3::new(0.0, 1.0, 0.0), radius: 1.0 },
            eye: eye(DVec3::new(-0.03, 0.0, 0.0), DVec3::new(0.1, -0.05, 1.0), CLOSE),
            place: |at| ((at.z.atan2(at.x).to_degrees() / 4.0).floor() as i64, at.x.hypot(at.z)),
        },
    ]
}

/// Texels by which shadows begin late, one for each place along the contact.
fn late(
    gpu: &Gpu,
    contact: &Contact,
    towards: DVec3,
    format: TextureFormat,
    (edges, slope_bias): (DepthMapMethod, f32),
) -> Result<Vec<f64>, String> {
    let depth = DepthDirection::Reversed;
    let half_width = Some(TEXEL * f64::from(TEXELS) / 2.0);
    let light = Eye {
        place: 9.0 * towards,
        forward: -towards,
        near: 1.0,
        is_relative: true,
        depth,
        far: Some(20.0),
        half_width,
    };
    let sun = Sun::new(towards, true, light.camera());
    let world = &contact.world;
    let seen = |rays: &Rays, side: u32, at: u32| {
        let (from, ray) = rays.at(middle(at, side));
        world.first(from, ray).map(|(t, normal)| (from + t * ray, normal))
    };
    let rays = Rays::new(&sun.camera, TEXELS);
    let map = Map::new([TEXELS; 2], true, |at| {
        seen(&rays, TEXELS, at).map_or(0.0, |(place, _)| device_depth(&sun.camera, place))
    });
    let map = texture(gpu, map.size, format, &map.depths)?;
    let eye = contact.eye.camera();
    let rays = Rays::new(&eye, PIXELS);
    let seen: Vec<_> = (0..PIXELS * PIXELS).map(|pixel| seen(&rays, PIXELS, pixel)).collect();
    let depths: Vec<_> = seen.iter().map(|seen| seen.map_or(0.0, |(place, _)| device_depth(&eye, place))).collect();
    let pipelines = pipelines(gpu, depth, 0..1)?;
    let options = DepthMapOptions { method: edges, slope_bias, ..Default::default() };
    let mut volumes = DepthMapVolumes::new(&pipelines, [TEXELS; 2], options).map_err(text)?;
    let stencil = stencil_of(gpu, &pipelines, (PIXELS, &depths), |encoder| {
        let map = DepthMap { texture: &depth_view(&map), light: sun.camera, objects: None };
        volumes.encode(encoder, &map, &eye).map_err(text)
    })?;
    // Along the contact: where the shadow begins by rays, and in the picture.
    let mut begins: BTreeMap<i64, [f64; 2]> = BTreeMap::new();
    for (seen, value) in seen.iter().zip(stencil) {
        let Some((place, normal)) = *seen else { continue };
        if place.y > 1e-7 || sun.is_lit(world, place, normal) {
            continue;
        }
        let (along, away) = (contact.place)(place);
        let begin = begins.entry(along).or_insert([f64::INFINITY; 2]);
        begin[0] = begin[0].min(away);
        if value != 0 {
            begin[1] = begin[1].min(away);
        }
    }
    // Only where the ground is in sight from the contact on.
    let begun = begins.values().filter(|begin| begin[0] < TEXEL / 2.0);
    Ok(begun.map(|begin| (begin[1] - begin[0]) / TEXEL).collect())
}

fn contacts() -> Result<(), String> {
    const SEED: u64 = 16_701;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let lights: Vec<_> = (0..if is_long() { 40 } else { 5 })
        .map(|_| {
            let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
            DVec3::new(between(0.4, 1.0), 1.0, between(-0.3, 0.3)).normalize()
        })
        .collect();
    println!("| body | edges | places | mean | most |\n|---|---|---:|---:|---:|");
    for contact in contacts_of() {
        for edges in [DepthMapMethod::EveryCell, DepthMapMethod::Automatic { dangling: None }] {
            let mut all = Vec::new();
            for (number, &towards) in lights.iter().enumerate() {
                let format = [TextureFormat::Depth32Float, TextureFormat::Depth24Plus][number % 2];
                all.extend(late(&gpu, &contact, towards, format, (edges, 1.0))?);
            }
            let (mean, most) = (all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(0.0, f64::max));
            println!("| {} | {edges:?} | {} | {mean:.3} | {most:.3} |", contact.name, all.len());
            if all.len() < 50 || most > BOUND {
                return Err(format!("{}, {edges:?}: {most} texels of {} places", contact.name, all.len()));
            }
        }
    }
    // Negative control: surfaces that move too far leave a thin wall behind.
    let [_, wall, ..] = contacts_of();
    let far = late(&gpu, &wall, lights[0], TextureFormat::Depth32Float, (DepthMapMethod::EveryCell, 20.0))?;
    let most = far.iter().copied().fold(0.0, f64::max);
    println!("{most} texels late with twenty times the move");
    if most > BOUND { Ok(()) } else { Err("a shadow that begins late goes unnoticed".to_owned()) }
}
