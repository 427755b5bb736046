//! Lights that affect a part of the image: masks are right in a rectangle around it, and 0 outside.

use glam::{DVec3, DVec4, Mat4};
use rimline::DepthDirection;
use rimline::gpu::{SceneOptions, ShadowMasks};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::rays::Tracer;
use rimline_testkit::scenes::PROJECTIONS;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat::{Depth32Float, R8Uint};

use crate::drawn::Picture;
use crate::world::{SIZE, World};

pub(crate) const TESTS: &[Test] = &[("lights_that_affect_a_part_of_the_image", parts)];

/// Where the ray through the middle of each pixel first meets a surface of a world. `None`: nowhere.
fn surfaces(world: &World) -> Vec<Option<DVec3>> {
    let corners = world.corners();
    let (triangles, _) = corners.as_chunks::<3>();
    let faces = triangles.iter().map(|face| (face.map(|corner| DVec3::from(corner.map(f64::from))), ()));
    let tracer = Tracer::build(faces);
    let inverse = Mat4::from_cols_array_2d(&world.camera.view_projection).as_dmat4().inverse();
    let near_z = f64::from(u8::from(world.camera.depth == DepthDirection::Reversed));
    let origin = DVec3::from(world.camera.origin.map(f64::from));
    let [width, height] = SIZE.map(f64::from);
    let at = |pixel: u32| {
        let [x, y] = [pixel % SIZE[0], pixel / SIZE[0]].map(|c| f64::from(c) + 0.5);
        let [near, beyond] = [near_z, 0.5].map(|z| {
            let point = inverse * DVec4::new(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height, z, 1.0);
            point.truncate() / point.w + origin
        });
        tracer.first((near, (beyond - near).normalize())).map(|(point, _)| point)
    };
    (0..SIZE[0] * SIZE[1]).map(at).collect()
}

/// Whether a point is within the range and the cone of a light.
fn affects(light: &rimline::Light, point: DVec3) -> bool {
    if light.w == 0.0 {
        return true;
    }
    let from = point - DVec3::from(light.xyz.map(f64::from)) / f64::from(light.w);
    let is_in = |cone: rimline::Cone| {
        let axis = DVec3::from(cone.axis.map(f64::from)).normalize();
        from.normalize().dot(axis) >= f64::from(cone.cosine)
    };
    from.length() <= f64::from(light.range) && light.cone.is_none_or(is_in)
}

/// Compares a mask with the stencil in the least rectangle around the pixels that the light affects and those where the
/// mask is not 0.
fn compare(mask: &[u8], stencil: &[u8], is_affected: &[bool]) -> Result<(), String> {
    let pixel = |at: usize| [at % SIZE[0] as usize, at / SIZE[0] as usize];
    let (mut low, mut high) = ([usize::MAX; 2], [0_usize; 2]);
    for at in (0..mask.len()).filter(|&at| is_affected[at] || mask[at] != 0) {
        for (axis, c) in pixel(at).into_iter().enumerate() {
            (low[axis], high[axis]) = (low[axis].min(c), high[axis].max(c));
        }
    }
    let is_within = |[x, y]: [usize; 2]| (low[0]..=high[0]).contains(&x) && (low[1]..=high[1]).contains(&y);
    let is_wrong = |&at: &usize| is_within(pixel(at)) && (mask[at] != 0) != (stencil[at] != 0);
    (0..mask.len())
        .find(is_wrong)
        .map_or(Ok(()), |at| Err(format!("pixel {at} is {}, stencil {}", mask[at], stencil[at])))
}

/// Some pixels out of the rectangles must be in shadow, or else nothing was cut.
fn parts() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let [mut affected, mut dark, mut cut, mut none] = [0; 4];
    let mut noticed = [0; 2];
    for number in 0..if is_long() { 500 } else { 40 } {
        let world = World::new(2000 + number as u64, number % PROJECTIONS, 8).with_ranges(number as u64);
        let picture = Picture { size: SIZE, depth: Depth32Float, samples: 1, target: R8Uint };
        let [found, stencils] = picture.both(gpu, &world, &SceneOptions::default(), masks)?;
        let points = surfaces(&world);
        for (light, (mask, stencil)) in world.lights.iter().zip(found.iter().zip(&stencils)) {
            let is_affected: Vec<bool> =
                points.iter().map(|point| point.is_some_and(|point| affects(light, point))).collect();
            compare(mask, stencil, &is_affected).map_err(|error| format!("world {number}, {light:?}: {error}"))?;
            for at in 0..mask.len() {
                let is_dark = stencil[at] != 0;
                affected += usize::from(is_affected[at]);
                dark += usize::from(is_affected[at] && is_dark);
                cut += usize::from(!is_affected[at] && is_dark && mask[at] == 0);
            }
            none += usize::from(!is_affected.contains(&true));
            // Negative controls: another bit where the light is, and one where neither it nor its shadow is.
            let last = (0..mask.len()).rfind(|&at| is_affected[at]);
            let lit = (0..mask.len()).rfind(|&at| !is_affected[at] && stencil[at] == 0);
            for at in last.into_iter().chain(lit) {
                let mut changed = mask.clone();
                changed[at] = u8::from(mask[at] == 0);
                must_fail("a bit that is changed", &compare(&changed, stencil, &is_affected))?;
                noticed[usize::from(is_affected[at])] += 1;
            }
        }
    }
    println!("{affected} pixels affected, {dark} of them in shadow; {cut} cut; {none} lights without a pixel");
    if dark > 50_000 && cut > 50_000 && none > 3 && noticed.iter().all(|&count| count > 3) {
        Ok(())
    } else {
        Err("too little of a kind".to_owned())
    }
}
