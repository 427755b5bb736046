//! Masks against rays in `f64`, from each pixel's centre and on to the lights.

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};
use rimline::gpu::ShadowMasks;
use rimline::{Counting, DepthDirection};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::rays::{Tracer, Triangle};
use rimline_testkit::scenes::PROJECTIONS;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat::{Depth24Plus, Depth32Float, R8Unorm, R32Uint};

use crate::drawn::Picture;
use crate::world::{SIZE, World, counted_by};

pub(crate) const TESTS: &[Test] = &[("masks_are_what_rays_see", seen)];

/// The end of a ray.
pub(crate) struct Seen<'a> {
    pub(crate) place: DVec3,
    normal: DVec3,
    direction: DVec3,
    triangle: &'a Triangle<bool>,
}

pub(crate) struct Truth<'a> {
    /// Whether a face casts.
    tracer: Tracer<bool>,
    world: &'a World,
    inverse: DMat4,
    size: [u32; 2],
}

impl<'a> Truth<'a> {
    pub(crate) fn new(world: &'a World, size: [u32; 2]) -> Self {
        let bodies = world.casters.iter().map(|body| (body, true)).chain([(&world.room, false)]);
        let faces = bodies.flat_map(|(body, casts)| {
            body.faces
                .iter()
                .map(move |face| (face.map(|v| DVec3::from(body.positions[v as usize].map(f64::from))), casts))
        });
        let inverse = Mat4::from_cols_array_2d(&world.camera.view_projection).as_dmat4().inverse();
        Self { tracer: Tracer::build(faces), world, inverse, size }
    }

    /// The thing seen at a place of the picture, in pixels.
    pub(crate) fn at(&self, place: DVec2) -> Option<Seen<'_>> {
        let [width, height] = self.size.map(f64::from);
        let ndc = [2.0 * place.x / width - 1.0, 1.0 - 2.0 * place.y / height];
        let near_z = f64::from(u8::from(self.world.camera.depth == DepthDirection::Reversed));
        let origin = DVec3::from(self.world.camera.origin.map(f64::from));
        let [near, beyond] = [near_z, 0.5].map(|z| {
            let point = self.inverse * DVec4::new(ndc[0], ndc[1], z, 1.0);
            point.truncate() / point.w + origin
        });
        let ray = (near, (beyond - near).normalize());
        let (point, triangle) = self.tracer.first(ray)?;
        let [a, b, c] = triangle.corners;
        let normal = (b - a).cross(c - a).normalize();
        Some(Seen { place: point, normal, direction: ray.1, triangle })
    }

    /// Whether a light is in shadow there. `None`: the surface is turned away from it, or almost.
    fn is_dark(&self, seen: &Seen<'_>, light: usize) -> Option<bool> {
        let light = self.world.lights[light];
        let xyz = DVec3::from(light.xyz.map(f64::from));
        let towards = xyz - f64::from(light.w) * seen.place;
        if seen.normal.dot(towards.normalize()) * seen.normal.dot(seen.direction) > -1e-3 {
            return None;
        }
        let is_between = |t: f64| t > 1e-6 && (light.w == 0.0 || t < 1.0);
        let mut meetings = self.tracer.meetings((seen.place, towards));
        Some(meetings.any(|(t, other)| other.of && is_between(t) && !std::ptr::eq(other, seen.triangle)))
    }

    /// The thing seen in a pixel that has no border near it: for a light the places around are all in shadow, or none is. They are a
    /// grid of so many places each way.
    pub(crate) fn steady(&self, pixel: [u32; 2], light: usize, places: i32) -> Option<bool> {
        let middle = DVec2::from(pixel.map(|at| f64::from(at) + 0.5));
        let first = self.at(middle)?;
        let dark = self.is_dark(&first, light)?;
        let step = |at: i32| 2.4 * f64::from(at) / f64::from(places - 1) - 1.2;
        let mut around = (0..places * places).map(|at| DVec2::new(step(at % places), step(at / places)));
        // A corner of a body may hide between the places; its surfaces have other normals.
        let is_same = |seen: Seen<'_>| self.is_dark(&seen, light) == Some(dark) && seen.normal.dot(first.normal) > 0.7;
        around.all(|by| self.at(middle + by).is_some_and(is_same)).then_some(dark)
    }
}

/// Wrong pixels of masks that were compared, and how many were, in shadow and not.
fn compare(truth: &Truth<'_>, masks: &[Vec<u8>]) -> Result<[usize; 2], String> {
    let (mut counts, mut wrong) = ([0, 0], Vec::new());
    let [width, height] = truth.size;
    for (light, mask) in masks.iter().enumerate() {
        for pixel in (0..width * height).step_by(13).map(|at| [at % width, at / width]) {
            let Some(dark) = truth.steady(pixel, light, 3) else { continue };
            counts[usize::from(dark)] += 1;
            let found = mask[(pixel[1] * width + pixel[0]) as usize];
            // A shadow may be as thin as a line, so another value is looked for in a finer grid.
            if found != if dark { 255 } else { 0 } && truth.steady(pixel, light, 33).is_some() {
                wrong.push((light, pixel, found));
            }
        }
    }
    if wrong.is_empty() { Ok(counts) } else { Err(format!("{} wrong, first {:?}", wrong.len(), wrong[0])) }
}

fn seen() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let mut all = [0, 0];
    for number in 0..if is_long() { 200 } else { 16 } {
        let picture = Picture {
            size: SIZE,
            depth: [Depth32Float, Depth24Plus][number % 2],
            samples: [1, 4][number / 2 % 2],
            target: [R32Uint, R8Unorm][number / 4 % 2],
        };
        let world = World::closed(1000 + number as u64, number % PROJECTIONS, 3);
        let options = counted_by([Counting::Auto, Counting::ZpPlus][number / 3 % 2]);
        masks.trim = number == 3;
        let [mut found, _] = picture.both(gpu, &world, &options, masks)?;
        let truth = Truth::new(&world, SIZE);
        let counts = compare(&truth, &found).map_err(|error| format!("world {number}: {error}"))?;
        all = [all[0] + counts[0], all[1] + counts[1]];
        if number < 4 {
            found.rotate_left(1);
            must_fail("masks of other lights", &compare(&truth, &found))?;
        }
    }
    println!("{} pixels lit, {} in shadow", all[0], all[1]);
    if all.iter().all(|&count| count > 1000) { Ok(()) } else { Err("too few of a kind".to_owned()) }
}
