//! The truth: rays in f64 through a bounding volume hierarchy, from each pixel's centre and on to the lights.

use std::collections::HashSet;

use glam::{DVec2, DVec3};
use rimline::Light;

use rimline_testkit::frames::{Frame, Rays};
use rimline_testkit::oracle;

pub(crate) type Triangle = rimline_testkit::rays::Triangle<Face>;

/// The frame's triangles in a tree of boxes.
pub(crate) struct Tracer(rimline_testkit::rays::Tracer<Face>);

/// Properties of a triangle.
pub(crate) struct Face {
    /// The exact sides of the lights: 1 in front, -1 behind, 0 in the plane, or if the face is left out.
    pub(crate) sides: Vec<i32>,
    /// The body's number among the casters.
    pub(crate) caster: Option<usize>,
    /// Whether eyes see it.
    pub(crate) is_drawn: bool,
}

/// Casters that a frame may have.
pub(crate) const MOST_CASTERS: usize = 12;

/// Surface seen through a pixel, for one light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Truth {
    /// Nothing.
    Background,
    /// The light is on the other side of the surface.
    BackFacing,
    /// A surface on the light's side.
    Surface(Between),
}

/// Faces strictly between a point and a light: of each caster those that are back-facing, and those that face it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Between(pub(crate) [[u16; 2]; MOST_CASTERS]);

impl Between {
    /// Expected stencil value. `every` says for which casters every face casts.
    pub(crate) fn count(&self, every: &[bool]) -> u16 {
        let faces = self.0.iter().zip(every);
        faces.map(|(&[back_facing, facing], &every)| if every { back_facing + facing } else { back_facing }).sum()
    }
}

impl Truth {
    pub(crate) fn is_lit(self) -> bool {
        matches!(self, Self::Surface(between) if between == Between::default())
    }

    pub(crate) fn is_shadowed(self) -> bool {
        matches!(self, Self::Surface(between) if between != Between::default())
    }
}

impl Tracer {
    pub(crate) fn new(frame: &Frame) -> Self {
        let mut triangles = Vec::new();
        let mut casters = 0;
        for body in &frame.bodies {
            let caster = body.casts.then_some(casters);
            casters += usize::from(body.casts);
            let left_out: HashSet<[u32; 3]> = body.left_out.iter().map(|&at| body.shape.faces[at as usize]).collect();
            for face in body.finite_faces() {
                let corners = face.map(|v| DVec3::from(body.shape.positions[v as usize].map(f64::from)));
                let exact = oracle::ExactFace::new(&body.shape.positions, face);
                let side = |light: &Light| exact.as_ref().map_or(0, |face| face.sign(*light));
                let mut sides: Vec<i32> = frame.lights.iter().map(side).collect();
                if left_out.contains(&face) {
                    sides[0] = 0;
                }
                triangles.push((corners, Face { sides, caster, is_drawn: body.is_drawn }));
            }
        }
        Self(rimline_testkit::rays::Tracer::build(triangles))
    }

    /// Where a ray first meets a triangle, and which.
    pub(crate) fn first(&self, ray: (DVec3, DVec3)) -> Option<(DVec3, &Triangle)> {
        let seen = self.0.meetings(ray).filter(|(t, triangle)| *t > 0.0 && triangle.of.is_drawn);
        let (t, triangle) = seen.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((ray.0 + ray.1 * t, triangle))
    }

    /// Casting faces but `own` on a part of a ray, by how they are turned to a light.
    pub(crate) fn between(
        &self,
        ray: (DVec3, DVec3),
        [begin, end]: [f64; 2],
        start: Option<&Triangle>,
        light: usize,
    ) -> Between {
        let mut between = Between::default();
        for (t, triangle) in self.0.meetings(ray) {
            let is_start = start.is_some_and(|start| std::ptr::eq(triangle, start));
            let Some(caster) = triangle.of.caster.filter(|_| !is_start) else { continue };
            // A face with the light in its plane is strictly between it and nothing.
            if triangle.of.sides[light] == 0 {
                continue;
            }
            if t > begin && t < end {
                between.0[caster][usize::from(triangle.of.sides[light] > 0)] += 1;
            }
        }
        between
    }

    /// Casting faces strictly between a point of a face and a light.
    pub(crate) fn towards(&self, point: DVec3, start: &Triangle, number: usize, light: &Light) -> Between {
        let [x, y, z] = light.xyz.map(f64::from);
        let w = f64::from(light.w);
        let to_light = DVec3::new(x, y, z) - w * point;
        // At t = 1 / w the ray is at the light.
        let end = if w == 0.0 { f64::INFINITY } else { 1.0 / w };
        // Faces that coincide with the point's own are not strictly between.
        let begin = 1e-9 * (1.0 + point.abs().max_element()) / to_light.length();
        self.between((point, to_light), [begin, end], Some(start), number)
    }

    /// Surface that a pixel's ray sees, for each light.
    pub(crate) fn pixel(&self, ray: (DVec3, DVec3), lights: &[Light]) -> Vec<Truth> {
        let Some((point, start)) = self.first(ray) else { return vec![Truth::Background; lights.len()] };
        let is_front = start.is_front(ray.1);
        let truth = |(number, light): (usize, &Light)| {
            let side = start.of.sides[number];
            if side == 0 || (side > 0) != is_front {
                return Truth::BackFacing;
            }
            Truth::Surface(self.towards(point, start, number, light))
        };
        lights.iter().enumerate().map(truth).collect()
    }
}

/// Where each pixel's ray first meets a surface, row by row.
pub(crate) fn points(frame: &Frame) -> Vec<Option<DVec3>> {
    let tracer = Tracer::new(frame);
    let rays = Rays::new(&frame.eye.camera(), frame.size);
    let pixels = (0..frame.size).flat_map(|y| (0..frame.size).map(move |x| (x, y)));
    pixels.map(|(x, y)| tracer.first(rays.ray(x, y)).map(|(point, _)| point)).collect()
}

/// Surfaces seen through a point of each pixel, row by row, for each light.
pub(crate) fn trace(frame: &Frame, within_pixel: DVec2) -> Vec<Vec<Truth>> {
    let tracer = Tracer::new(frame);
    let rays = Rays::new(&frame.eye.camera(), frame.size).through(within_pixel);
    let rows: Vec<u32> = (0..frame.size).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = rows.len().div_ceil(threads);
    std::thread::scope(|scope| {
        let run = |rows: Vec<u32>| {
            let (tracer, rays) = (&tracer, &rays);
            scope.spawn(move || {
                let pixels = rows.iter().flat_map(|&y| (0..frame.size).map(move |x| (x, y)));
                pixels.map(|(x, y)| tracer.pixel(rays.ray(x, y), &frame.lights)).collect::<Vec<_>>()
            })
        };
        let runs: Vec<_> = rows.chunks(share).map(|rows| run(rows.to_vec())).collect();
        runs.into_iter().flat_map(|run| run.join().expect("tracing does not panic")).collect()
    })
}
