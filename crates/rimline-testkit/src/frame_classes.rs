//! Classes of frames, by where eye, light and casters are to each other.

use glam::{DVec3, Vec3};
use rimline::Light;

use crate::frames::{Body, Eye, Frame, vector};
use crate::random::Random;
use crate::shapes::{self, Shape};
use crate::shells;

/// A class of frames.
pub struct Class {
    pub name: &'static str,
    pub frame: fn(&mut Random) -> Frame,
    /// Whether casters touch. Faces between point and light then do not predict the stencil's count.
    pub touches: bool,
}

const fn class(name: &'static str, frame: fn(&mut Random) -> Frame) -> Class {
    Class { name, frame, touches: false }
}

pub const CLASSES: &[Class] = &[
    class("random cameras", random),
    class("camera outside the shadow", outside),
    class("near rectangle partly in shadow, light behind", |random| inside(random, true, true)),
    class("near rectangle partly in shadow, light in front", |random| inside(random, true, false)),
    class("near rectangle in shadow, light behind", |random| inside(random, false, true)),
    class("near rectangle in shadow, light in front", |random| inside(random, false, false)),
    class("near plane through caster and almost the light", |random| along_near_plane(random, 0.05)),
    class("light on the near plane", |random| along_near_plane(random, 1e-7)),
    class("directional lights", directional),
    class("near rectangle inside a caster", within),
    class("light inside a caster", light_within),
    class("near rectangle and light inside a caster", both_within),
    class("nested and inverted bodies", shells::nested),
    class("coordinates near 1,000", |random| far(random, 1e3, false)),
    class("coordinates near 1,000, from the eye", |random| far(random, 1e3, true)),
    class("coordinates near 100,000, from the eye", |random| far(random, 1e5, true)),
    class("ten overlapping casters", overlapping),
    class("open sheet", sheet),
    class("moebius strip", |random| with_caster(random, shapes::moebius(48, 4))),
    class("three sheets on an edge", |random| with_caster(random, shapes::three_sheets(8))),
    class("faces that are not finite", |random| {
        let kinds: [fn(&mut Random) -> Frame; 3] = [self::random, within, light_within];
        let frame = kinds[random.below(3)](random);
        spoiled(random, frame)
    }),
    class("sheet with faces that are not finite", |random| {
        let frame = sheet(random);
        spoiled(random, frame)
    }),
    Class { touches: true, ..class("two touching boxes", boxes) },
    class("mirrored instance", mirrored),
];

fn between(random: &mut Random, low: f32, high: f32) -> f64 {
    f64::from(random.between(low, high))
}

fn point(position: DVec3) -> Light {
    Light::point(position.as_vec3().to_array())
}

fn near(random: &mut Random) -> f64 {
    0.02 * 25_f64.powf(between(random, 0.0, 1.0))
}

/// Two tori through each other's holes, in a room.
fn tori() -> Vec<Body> {
    let torus = shapes::torus(48, 24, 1.0, 0.35);
    let other = torus.clone().placed(|[x, y, z]| [x + 1.0, z, -y]);
    vec![Body::caster(torus), Body::caster(other), Body::room([0.0; 3], 8.0)]
}

fn frame(bodies: Vec<Body>, eye: Eye, light: Light) -> Frame {
    Frame { bodies, eye, lights: vec![light], size: 96 }
}

/// A point in the room that is not in the tori's way.
fn room_point(random: &mut Random, low: f32, high: f32) -> DVec3 {
    vector(random) * between(random, low, high)
}

fn random(random: &mut Random) -> Frame {
    let from = room_point(random, 2.0, 7.0);
    let towards = room_point(random, 0.0, 2.0) - from;
    let near = near(random);
    let light = room_point(random, 2.6, 7.0);
    frame(tori(), Eye::new(from, towards, near), point(light))
}

/// The eye is nearer to the light than the casters are.
fn outside(random: &mut Random) -> Frame {
    let light = room_point(random, 5.0, 6.5);
    let from = light + room_point(random, 0.2, 1.0);
    let towards = room_point(random, 0.0, 1.0) - from;
    frame(tori(), Eye::new(from, towards, 0.05), point(light))
}

/// A point of the casters' surface, or of an edge between a lit and a back-facing face.
fn surface(random: &mut Random, bodies: &[Body], light: DVec3, on_edge: bool) -> DVec3 {
    let shape = &bodies[random.below(2)].shape;
    let corners = |face: usize| shape.faces[face].map(|v| DVec3::from(shape.positions[v as usize].map(f64::from)));
    let side = |face: usize| {
        let [a, b, c] = corners(face);
        (b - a).cross(c - a).dot(light - a) > 0.0
    };
    for _ in 0..100_000 {
        let face = random.below(shape.faces.len());
        let [a, b, c] = corners(face);
        if !on_edge {
            return (a + b + c) / 3.0;
        }
        // Faces of a quad follow each other, and so do quads round a ring.
        let other = (face + 1) % shape.faces.len();
        if side(face) != side(other) {
            let shared: Vec<_> = corners(other).into_iter().filter(|p| [a, b, c].contains(p)).collect();
            if let [p, q] = shared[..] {
                return (p + q) / 2.0;
            }
        }
    }
    DVec3::ZERO
}

/// The near rectangle in or on the border of a shadow.
fn inside(random: &mut Random, partly: bool, light_behind: bool) -> Frame {
    let bodies = tori();
    let light = room_point(random, 3.0, 6.0);
    let through = surface(random, &bodies, light, partly);
    let near = near(random);
    let middle = light + (through - light) * between(random, 1.3, 1.9);
    let away = (middle - light).normalize();
    let forward = (if light_behind { away } else { -away } + room_point(random, 0.0, 0.7)).normalize();
    frame(bodies, Eye::new(middle - forward * near, forward, near), point(light))
}

/// The near plane goes through a caster and, but for `distance`, through the light.
fn along_near_plane(random: &mut Random, distance: f32) -> Frame {
    let bodies = tori();
    let through = surface(random, &bodies, DVec3::ZERO, false);
    let light = through + room_point(random, 0.5, 3.0);
    let forward = (through - light).cross(vector(random)).normalize();
    let near = near(random);
    let offset = forward * f64::from(random.between(-distance, distance));
    // The near rectangle's middle is beyond the caster as seen from the light.
    let middle = light + (through - light) * between(random, 1.1, 2.0) + offset;
    frame(bodies, Eye::new(middle - forward * near, forward, near), point(light))
}

fn directional(random: &mut Random) -> Frame {
    let bodies = tori();
    let towards = vector(random);
    let on_edge = random.below(2) == 0;
    let through = surface(random, &bodies, towards * 1e6, on_edge);
    let near = near(random);
    let forward = vector(random);
    let middle = through - towards * between(random, 0.2, 2.0);
    let light = Light::directional((towards * between(random, 0.1, 9.0)).as_vec3().to_array());
    frame(bodies, Eye::new(middle - forward * near, forward, near), light)
}

/// In the tube of a torus.
fn in_tube(random: &mut Random) -> DVec3 {
    let angle = between(random, 0.0, std::f32::consts::TAU);
    DVec3::new(angle.cos(), 0.0, angle.sin()) + room_point(random, 0.0, 0.2)
}

fn within(random: &mut Random) -> Frame {
    let light = room_point(random, 3.0, 6.0);
    let forward = vector(random);
    frame(tori(), Eye::new(in_tube(random) - forward * 0.05, forward, 0.05), point(light))
}

fn light_within(random: &mut Random) -> Frame {
    let from = room_point(random, 3.0, 6.0);
    let light = in_tube(random);
    frame(tori(), Eye::new(from, -from + room_point(random, 0.0, 1.0), near(random)), point(light))
}

fn both_within(random: &mut Random) -> Frame {
    let forward = vector(random);
    let light = in_tube(random);
    frame(tori(), Eye::new(in_tube(random) - forward * 0.05, forward, 0.05), point(light))
}

fn far(random: &mut Random, distance: f64, is_relative: bool) -> Frame {
    let frame = match random.below(3) {
        0 => self::random(random),
        1 => inside(random, true, true),
        _ => inside(random, false, false),
    };
    let by = DVec3::new(1.0, -0.5, 0.7) * distance;
    let bodies = frame.bodies.into_iter().map(|body| body.moved(by.as_vec3().to_array())).collect();
    let eye = Eye { position: frame.eye.position + by, is_relative, ..frame.eye };
    let lights = frame.lights.iter().map(|light| point(DVec3::from(light.xyz.map(f64::from)) + by)).collect();
    Frame { bodies, eye, lights, ..frame }
}

fn overlapping(random: &mut Random) -> Frame {
    let blob = |seed| {
        let at = room_point(random, 0.0, 1.5).as_vec3().to_array();
        Body::caster(shapes::blob(8, 0.4, seed)).scaled(random.between(0.3, 0.9)).moved(at)
    };
    let bodies = (0..10).map(blob).chain([Body::room([0.0; 3], 8.0)]).collect();
    Frame { bodies, ..self::random(random) }
}

/// The second caster is an instance whose transform has a negative determinant.
fn mirrored(random: &mut Random) -> Frame {
    let mut frame = match random.below(5) {
        0 => self::random(random),
        1 => outside(random),
        2 => inside(random, true, true),
        3 => inside(random, false, false),
        _ => within(random),
    };
    let mirrors = [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, -1.0, 1.0), Vec3::new(1.0, 1.0, -1.0), Vec3::NEG_ONE];
    frame.bodies[1].mirror = Some(mirrors[random.below(4)]);
    frame
}

fn with_caster(random: &mut Random, shape: Shape) -> Frame {
    let bodies = vec![Body::caster(shape.clone()), Body::caster(shape), Body::room([0.0; 3], 8.0)];
    let mut frame = match random.below(3) {
        0 => self::random(random),
        1 => {
            let light = room_point(random, 3.0, 6.0);
            let through = surface(random, &bodies, light, false);
            let middle = light + (through - light) * between(random, 1.05, 1.9);
            let forward = vector(random);
            let near = near(random);
            frame(bodies.clone(), Eye::new(middle - forward * near, forward, near), point(light))
        }
        _ => outside(random),
    };
    frame.bodies = bodies;
    frame.bodies.remove(0);
    frame
}

fn sheet(random: &mut Random) -> Frame {
    let seed = random.below(1000) as u32;
    let wave = |[x, y, z]: [f32; 3]| [x, y + (x * 5.0 + seed as f32).sin() * 0.3, z];
    with_caster(random, shapes::plane_grid(12, 12).placed(wave))
}

/// A few vertices of casters are infinite or NaN, so that closed casters have holes.
fn spoiled(random: &mut Random, mut frame: Frame) -> Frame {
    for body in frame.bodies.iter_mut().filter(|body| body.casts) {
        for _ in 0..=random.below(6) {
            let vertex = random.below(body.shape.positions.len());
            let coordinate = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][random.below(3)];
            body.shape.positions[vertex][random.below(3)] = coordinate;
        }
    }
    frame
}

fn boxes(random: &mut Random) -> Frame {
    let half = |x: f32| Body::caster(shapes::cube()).scaled(0.5).moved([x, 0.0, 0.0]);
    Frame { bodies: vec![half(-0.5), half(0.5), Body::room([0.0; 3], 8.0)], ..self::random(random) }
}
