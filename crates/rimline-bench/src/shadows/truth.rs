//! Ground truth: rays in `f64` from the centres of pixels, and on to the light.

use glam::{DMat4, DVec3, DVec4};
use rimline::Light;
use rimline::internals::cpu::{self, Threads};

use super::Stage;
use crate::extraction::share;
use crate::rays::Tracer;
use crate::record::Camera;
use crate::shapes::Shape;

/// The caster and its room for rays, in one light.
pub(super) struct Truth {
    tracer: Tracer<Face>,
    light: DVec3,
    size: u32,
}

struct Face {
    /// It faces the light, exactly.
    faces_light: bool,
    casts: bool,
}

/// Whether light reaches the surface at each pixel, row by row. `None` where the visible side is back-facing to the
/// light, so that it needs no shadow, and where no surface is visible.
pub(super) struct Seen {
    pixels: Vec<Option<bool>>,
    size: u32,
}

impl Truth {
    /// `light` must be a point.
    pub(super) fn new(stage: &Stage, light: Light) -> Self {
        let triangles = |shape: &Shape, casts: bool| {
            let corners = shape.faces.iter().map(|face| face.map(|vertex| shape.positions[vertex as usize]));
            // Others cast nothing, and no ray meets them.
            let finite = corners.filter(|corners| corners.as_flattened().iter().all(|c| c.is_finite()));
            let triangle = |[a, b, c]: [[f32; 3]; 3]| {
                let faces_light = cpu::exact_facing(a, b, c, light.to_array()) > 0;
                ([a, b, c].map(|p| DVec3::from(p.map(f64::from))), Face { faces_light, casts })
            };
            finite.map(triangle).collect::<Vec<_>>()
        };
        Self {
            tracer: Tracer::build(triangles(&stage.caster, true).into_iter().chain(triangles(&stage.room, false))),
            light: DVec3::from(light.xyz.map(f64::from)),
            size: stage.size,
        }
    }

    pub(super) fn seen(&self, camera: &Camera) -> Seen {
        let view = camera.shadow();
        let inverse = DMat4::from_cols_array_2d(&view.view_projection.map(|column| column.map(f64::from))).inverse();
        let origin = DVec3::from_array(view.origin.map(f64::from));
        let numbers: Vec<u32> = (0..self.size * self.size).collect();
        let mut pixels = vec![None; numbers.len()];
        share(Threads::all().count(), &mut pixels, &numbers, |pixels, numbers| {
            for (pixel, number) in pixels.iter_mut().zip(numbers) {
                *pixel = self.pixel(self.ray(&inverse, origin, [number % self.size, number / self.size]));
            }
        });
        Seen { pixels, size: self.size }
    }

    fn ray(&self, inverse: &DMat4, origin: DVec3, [x, y]: [u32; 2]) -> (DVec3, DVec3) {
        let ndc = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(self.size) * 2.0 - 1.0;
        // Depth is 1 on the near plane, 0.5 twice as far.
        let [near, beyond] = [1.0, 0.5].map(|depth| {
            let p = *inverse * DVec4::new(ndc(x), -ndc(y), depth, 1.0);
            p.truncate() / p.w
        });
        (origin + near, beyond - near)
    }

    fn pixel(&self, ray: (DVec3, DVec3)) -> Option<bool> {
        let (point, receiver) = self.tracer.first(ray)?;
        if receiver.of.faces_light != receiver.is_front(ray.1) {
            return None;
        }
        // The light is at 1; the point's own face is not between.
        let mut faces = self.tracer.meetings((point, self.light - point));
        Some(!faces.any(|(t, face)| face.of.casts && !std::ptr::eq(face, receiver) && t > 1e-9 && t < 1.0))
    }
}

impl Seen {
    /// Pixels that `counts` shows lit or shadowed wrongly, but for those beside a pixel where that would be right.
    pub(super) fn wrong(&self, counts: &[u8]) -> usize {
        let size = i64::from(self.size);
        let at = |x: i64, y: i64| (0..size).contains(&x).then(|| self.pixels.get((y * size + x) as usize)).flatten();
        let is_near =
            |x: i64, y: i64, lit: bool| (-1..=1).any(|dy| (-1..=1).any(|dx| at(x + dx, y + dy) == Some(&Some(lit))));
        let pixels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
        let wrong = |((&seen, &count), (x, y)): ((&Option<bool>, &u8), (i64, i64))| {
            let lit = count == 0;
            seen.is_some_and(|right| right != lit) && !is_near(x, y, lit)
        };
        self.pixels.iter().zip(counts).zip(pixels).filter(|&item| wrong(item)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shadows::scene::{MODELS, PATHS, room};

    #[test]
    fn there_is_shadow_and_a_wrong_count_is_seen() {
        let stage = Stage { caster: MODELS[0].1(), room: room(), size: 40 };
        for path in PATHS {
            let seen = Truth::new(&stage, path.light()).seen(&path.camera(0.3));
            let right: Vec<u8> = seen.pixels.iter().map(|pixel| u8::from(*pixel == Some(false))).collect();
            assert_eq!(seen.wrong(&right), 0);
            // Looking at the occluder from its shadow, only its back-facing side is dark.
            let dark = seen.pixels.iter().filter(|pixel| **pixel != Some(true)).count();
            assert!(dark > 10, "{path:?}: {dark}");
            let inverse: Vec<u8> = right.iter().map(|count| 1 - count).collect();
            assert!(seen.wrong(&inverse) > 300, "{path:?}: {}", seen.wrong(&inverse));
        }
    }

    /// A model of the user may have vertices that are infinite or NaN.
    #[test]
    fn casters_need_not_be_finite() {
        let mut caster = MODELS[0].1();
        caster.positions[0] = [f32::NAN, 0.0, f32::INFINITY];
        let stage = Stage { caster, room: room(), size: 8 };
        let seen = Truth::new(&stage, PATHS[0].light()).seen(&PATHS[0].camera(0.3));
        assert!(seen.pixels.iter().any(Option::is_some));
    }
}
