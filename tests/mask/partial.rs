//! Lights that affect a part of the image: masks are right there, and 0 outside a rectangle around it.

use glam::{DVec2, DVec3};
use rimline::gpu::{SceneOptions, ShadowMasks};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::scenes::PROJECTIONS;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat::{Depth32Float, R8Uint};

use crate::drawn::Picture;
use crate::rays::Truth;
use crate::world::{SIZE, World};

pub(crate) const TESTS: &[Test] = &[("lights_that_reach_a_part_of_the_picture", parts)];

/// Whether a light reaches a place.
fn reaches(light: &rimline::Light, place: DVec3) -> bool {
    if light.w == 0.0 {
        return true;
    }
    let from = place - DVec3::from(light.xyz.map(f64::from)) / f64::from(light.w);
    let is_in = |cone: rimline::Cone| {
        let axis = DVec3::from(cone.axis.map(f64::from)).normalize();
        from.normalize().dot(axis) >= f64::from(cone.cosine)
    };
    from.length() <= f64::from(light.range) && light.cone.is_none_or(is_in)
}

/// Against the whole stencil. Pixels that a light reaches are compared one and all; beyond its reach some masks must be 0 where
/// the stencil is not, or else nothing was cut.
fn parts() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let [mut reached, mut dark, mut cut, mut none, mut noticed] = [0; 5];
    for number in 0..if is_long() { 500 } else { 40 } {
        let world = World::new(2000 + number as u64, number % PROJECTIONS, 8).with_reach(number as u64);
        let picture = Picture { size: SIZE, depth: Depth32Float, samples: 1, target: R8Uint };
        let [found, stencils] = picture.both(gpu, &world, &SceneOptions::default(), masks)?;
        let truth = Truth::new(&world, SIZE);
        let pixels = (0..SIZE[0] * SIZE[1]).map(|at| DVec2::new(f64::from(at % SIZE[0]), f64::from(at / SIZE[0])));
        let places: Vec<_> = pixels.map(|pixel| truth.at(pixel + 0.5).map(|seen| seen.place)).collect();
        for (light, (mask, stencil)) in world.lights.iter().zip(found.iter().zip(&stencils)) {
            let is_reached: Vec<bool> =
                places.iter().map(|place| place.is_some_and(|place| reaches(light, place))).collect();
            let compare = |mask: &[u8]| {
                let wrong = |&at: &usize| is_reached[at] && (mask[at] != 0) != (stencil[at] != 0);
                (0..mask.len()).find(wrong).map_or(Ok(()), |at| {
                    Err(format!("world {number}, {light:?}: pixel {at} is {}, stencil {}", mask[at], stencil[at]))
                })
            };
            compare(mask)?;
            for at in 0..mask.len() {
                let is_dark = stencil[at] != 0;
                reached += usize::from(is_reached[at]);
                dark += usize::from(is_reached[at] && is_dark);
                cut += usize::from(!is_reached[at] && is_dark && mask[at] == 0);
            }
            if let Some(last) = is_reached.iter().rposition(|is_reached| *is_reached) {
                let mut changed = mask.clone();
                changed[last] = u8::from(mask[last] == 0);
                must_fail("a bit that is changed", &compare(&changed))?;
                noticed += 1;
            } else {
                none += 1;
            }
        }
    }
    println!("{reached} pixels reached, {dark} of them in shadow; {cut} cut; {none} lights reach nothing");
    if dark > 50_000 && cut > 50_000 && none > 3 && noticed > 3 {
        Ok(())
    } else {
        Err("too little of a kind".to_owned())
    }
}
