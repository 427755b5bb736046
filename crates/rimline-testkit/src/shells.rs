//! Closed casters in one mesh of several components: wound inwards, nested, through each other.

use glam::Vec3;
use rimline::Light;

use crate::frames::{Body, Eye, Frame};
use crate::random::Random;
use crate::shapes::{self, Shape};

/// A component's shape, turned inside out or not.
pub fn component(mut shape: Shape, [x, y, z]: [f32; 3], scale: f32, is_inwards: bool) -> Shape {
    for position in &mut shape.positions {
        let [a, b, c] = *position;
        *position = [x + scale * a, y + scale * b, z + scale * c];
    }
    if is_inwards {
        shape.faces.iter_mut().for_each(|face| face.swap(1, 2));
    }
    shape
}

fn any_shape(random: &mut Random) -> Shape {
    match random.below(3) {
        0 => shapes::cube(),
        1 => shapes::blob(8, 0.3, random.below(1000) as u32),
        _ => shapes::blob(3, 0.3, random.below(1000) as u32),
    }
}

pub fn somewhere(random: &mut Random, most: f32) -> [f32; 3] {
    random.direction().map(|c| c * most * random.between(0.0, 1.0))
}

/// Shells in shells, beside each other or through each other; each wound either way.
fn shells(random: &mut Random) -> Shape {
    let mut components = Vec::new();
    for _ in 0..=random.below(2) {
        // Cubes reach to 1.7, so neighbours are through each other more often than not.
        let (middle, scale) = (somewhere(random, 1.5), random.between(0.7, 1.1));
        components.push(component(any_shape(random), middle, scale, random.below(2) == 0));
        // Within it: shapes have everything from 0.7 to 1.7.
        let mut inner = scale;
        for _ in 0..random.below(3) {
            inner *= random.between(0.25, 0.4);
            components.push(component(any_shape(random), middle, inner, random.below(2) == 0));
        }
    }
    Shape::joined(&components)
}

/// A light within the box of the shells, at it, or far from it; and an eye within or without.
pub fn nested(random: &mut Random) -> Frame {
    let kind = random.below(6);
    let shape = shells(random);
    let corners = shape.positions.iter().map(|&position| Vec3::from(position));
    let (low, high) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let within = |random: &mut Random| {
        let part = Vec3::from(std::array::from_fn(|_| random.between(0.0, 1.0)));
        low + (high - low) * part
    };
    let vertex = |random: &mut Random| Vec3::from(shape.positions[random.below(shape.positions.len())]);
    let light = match kind {
        0 | 1 => within(random),
        // Next to a vertex of any of the shells, inside of it or outside.
        2 => vertex(random) + Vec3::from(somewhere(random, 0.1)),
        // On the box, to the bit, at one of its corners or edges.
        3 => {
            let mut at = within(random);
            at.x = [low, high][random.below(2)].x;
            at.y = [low, high][random.below(2)].y;
            at
        }
        // On a side of it.
        4 => Vec3 { z: [low, high][random.below(2)].z, ..within(random) },
        _ => Vec3::from(random.direction()) * random.between(3.0, 7.0),
    };
    let is_within = random.below(3) == 0;
    let position = if is_within { within(random) } else { Vec3::from(random.direction()) * random.between(3.0, 7.0) };
    let forward =
        if is_within { Vec3::from(random.direction()) } else { Vec3::from(somewhere(random, 1.0)) - position };
    let near = f64::from(0.02 * 25_f32.powf(random.between(0.0, 1.0)));
    let eye = Eye::new(position.as_dvec3(), forward.as_dvec3(), near);
    let lights = vec![Light::point(light.to_array())];
    Frame { bodies: vec![Body::caster(shape), Body::room([0.0; 3], 8.0)], eye, lights, size: 96 }
}
