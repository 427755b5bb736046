//! Lights that affect a part of the image: masks are right there, and 0 outside a rectangle around it.

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};
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

/// The surfaces of a world, for rays from its eye.
struct Surfaces<'a> {
    tracer: Tracer<()>,
    world: &'a World,
    inverse: DMat4,
    size: [u32; 2],
}

impl<'a> Surfaces<'a> {
    fn new(world: &'a World, size: [u32; 2]) -> Self {
        let corners = world.corners();
        let (triangles, _) = corners.as_chunks::<3>();
        let faces = triangles.iter().map(|face| (face.map(|corner| DVec3::from(corner.map(f64::from))), ()));
        let inverse = Mat4::from_cols_array_2d(&world.camera.view_projection).as_dmat4().inverse();
        Self { tracer: Tracer::build(faces), world, inverse, size }
    }

    /// The nearest surface at a position of the image, in pixels.
    fn at(&self, pixel: DVec2) -> Option<DVec3> {
        let [width, height] = self.size.map(f64::from);
        let ndc = [2.0 * pixel.x / width - 1.0, 1.0 - 2.0 * pixel.y / height];
        let near_z = f64::from(u8::from(self.world.camera.depth == DepthDirection::Reversed));
        let origin = DVec3::from(self.world.camera.origin.map(f64::from));
        let [near, beyond] = [near_z, 0.5].map(|z| {
            let point = self.inverse * DVec4::new(ndc[0], ndc[1], z, 1.0);
            point.truncate() / point.w + origin
        });
        self.tracer.first((near, (beyond - near).normalize())).map(|(point, _)| point)
    }
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

/// Compares all pixels that a light affects with the stencil. At some of the others the mask must be 0 where the
/// stencil is not, or else nothing was cut.
fn parts() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let [mut affected, mut dark, mut cut, mut none, mut noticed] = [0; 5];
    for number in 0..if is_long() { 500 } else { 40 } {
        let world = World::new(2000 + number as u64, number % PROJECTIONS, 8).with_ranges(number as u64);
        let picture = Picture { size: SIZE, depth: Depth32Float, samples: 1, target: R8Uint };
        let [found, stencils] = picture.both(gpu, &world, &SceneOptions::default(), masks)?;
        let surfaces = Surfaces::new(&world, SIZE);
        let pixels = (0..SIZE[0] * SIZE[1]).map(|at| DVec2::new(f64::from(at % SIZE[0]), f64::from(at / SIZE[0])));
        let points: Vec<_> = pixels.map(|pixel| surfaces.at(pixel + 0.5)).collect();
        for (light, (mask, stencil)) in world.lights.iter().zip(found.iter().zip(&stencils)) {
            let is_affected: Vec<bool> =
                points.iter().map(|point| point.is_some_and(|point| affects(light, point))).collect();
            let compare = |mask: &[u8]| {
                let wrong = |&at: &usize| is_affected[at] && (mask[at] != 0) != (stencil[at] != 0);
                (0..mask.len()).find(wrong).map_or(Ok(()), |at| {
                    Err(format!("world {number}, {light:?}: pixel {at} is {}, stencil {}", mask[at], stencil[at]))
                })
            };
            compare(mask)?;
            for at in 0..mask.len() {
                let is_dark = stencil[at] != 0;
                affected += usize::from(is_affected[at]);
                dark += usize::from(is_affected[at] && is_dark);
                cut += usize::from(!is_affected[at] && is_dark && mask[at] == 0);
            }
            if let Some(last) = is_affected.iter().rposition(|is_affected| *is_affected) {
                let mut changed = mask.clone();
                changed[last] = u8::from(mask[last] == 0);
                must_fail("a bit that is changed", &compare(&changed))?;
                noticed += 1;
            } else {
                none += 1;
            }
        }
    }
    println!("{affected} pixels affected, {dark} of them in shadow; {cut} cut; {none} lights without a pixel");
    if dark > 50_000 && cut > 50_000 && none > 3 && noticed > 3 {
        Ok(())
    } else {
        Err("too little of a kind".to_owned())
    }
}
