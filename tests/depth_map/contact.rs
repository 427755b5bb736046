//! How far from its contact with the ground the shadow of a body begins: the boundary is moved away from surfaces, so it may
//! begin late.

use std::collections::BTreeMap;

use glam::DVec3;
use rimline::gpu::depth_map::{DepthMapMethod, DepthMapOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use wgpu::TextureFormat;

use crate::picture::{AUTOMATIC, EVERY_CELL, Target, by, look};
use crate::scene::Eye;
use crate::views::{Sun, View};
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

/// A body that touches the ground, an eye that looks at the contact, and the position of a point of the ground along
/// the contact and away from it.
struct Contact {
    name: &'static str,
    world: World,
    eye: Eye,
    position: Box<dyn Fn(DVec3) -> (i64, f64)>,
}

fn contacts_of() -> [Contact; 4] {
    let eye = |target: DVec3, forward: DVec3, half_width: f64| Eye {
        far: Some(20.0),
        half_width: Some(half_width),
        ..look(target - 5.0 * forward.normalize(), forward, 0.1)
    };
    // A cuboid, whose side at −x is seen from above.
    let cuboid = |name, half: DVec3| Contact {
        name,
        world: World::Cuboid { centre: half.y * DVec3::Y, half },
        eye: eye(DVec3::new(-half.x - HALF_WIDTH, 0.0, 0.0), DVec3::NEG_Y, HALF_WIDTH),
        position: Box::new(move |at| ((at.z / HALF_WIDTH * 64.0).floor() as i64, -half.x - at.x)),
    };
    [
        cuboid("wall, a quarter of a texel thick", DVec3::new(TEXEL / 8.0, 1.0, 1.2)),
        cuboid("box", DVec3::new(0.7, 1.0, 1.2)),
        cuboid("kerb, three texels high", DVec3::new(0.7, 1.5 * TEXEL, 1.2)),
        Contact {
            name: "ball",
            world: World::Sphere { centre: DVec3::Y, radius: 1.0 },
            eye: eye(DVec3::new(-0.03, 0.0, 0.0), DVec3::new(0.1, -0.05, 1.0), CLOSE),
            position: Box::new(|at| ((at.z.atan2(at.x).to_degrees() / 4.0).floor() as i64, at.x.hypot(at.z))),
        },
    ]
}

/// Texels by which shadows begin late, one for each position along the contact.
fn late(
    gpu: &Gpu,
    contact: &Contact,
    towards: DVec3,
    format: TextureFormat,
    (method, slope_bias): (DepthMapMethod, f32),
) -> Result<Vec<f64>, String> {
    let half_width = Some(TEXEL * f64::from(TEXELS) / 2.0);
    let light = Eye { far: Some(20.0), half_width, ..look(9.0 * towards, -towards, 1.0) }.camera();
    let sun = Sun::new(towards, true, vec![light], TEXELS);
    let view = View::new((&contact.world, &contact.world), sun, contact.eye.camera(), PIXELS);
    let options = DepthMapOptions { slope_bias, ..by(method) };
    let stencil = Target::new(view.eye, &view.eye_depths()).stencil(gpu, &view.maps(gpu, format)?, options)?;
    // Along the contact: where the shadow begins by rays, and in the picture.
    let mut begins: BTreeMap<i64, [f64; 2]> = BTreeMap::new();
    for receiver in view.receivers.iter().filter(|receiver| receiver.seen.0.y < 1e-7 && !receiver.is_lit) {
        let (along, away) = (contact.position)(receiver.seen.0);
        let begin = begins.entry(along).or_insert([f64::INFINITY; 2]);
        begin[0] = begin[0].min(away);
        if stencil[receiver.pixel] != 0 {
            begin[1] = begin[1].min(away);
        }
    }
    // Only where the ground is in sight from the contact on.
    let begun = begins.values().filter(|begin| begin[0] < TEXEL / 2.0);
    Ok(begun.map(|begin| (begin[1] - begin[0]) / TEXEL).collect())
}

fn contacts() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_701)?;
    let lights: Vec<_> = (0..if is_long() { 40 } else { 5 })
        .map(|_| {
            let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
            DVec3::new(between(0.4, 1.0), 1.0, between(-0.3, 0.3)).normalize()
        })
        .collect();
    let most = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    println!("| body | edges | positions | mean | most |\n|---|---|---:|---:|---:|");
    let contacts = contacts_of();
    for contact in &contacts {
        for method in [EVERY_CELL, AUTOMATIC] {
            let mut all = Vec::new();
            for (number, &towards) in lights.iter().enumerate() {
                let format = [TextureFormat::Depth32Float, TextureFormat::Depth24Plus][number % 2];
                all.extend(late(&gpu, contact, towards, format, (method, 1.0))?);
            }
            let (mean, most) = (all.iter().sum::<f64>() / all.len() as f64, most(&all));
            println!("| {} | {method:?} | {} | {mean:.3} | {most:.3} |", contact.name, all.len());
            if all.len() < 50 || most > BOUND {
                return Err(format!("{}, {method:?}: {most} texels of {} positions", contact.name, all.len()));
            }
        }
    }
    // Negative control: surfaces that move too far leave a thin wall behind.
    let far = most(&late(&gpu, &contacts[0], lights[0], TextureFormat::Depth32Float, (EVERY_CELL, 20.0))?);
    println!("{far} texels late with twenty times the move");
    if far > BOUND { Ok(()) } else { Err("a shadow that begins late goes unnoticed".to_owned()) }
}
