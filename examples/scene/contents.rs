//! Where everything is at a time: figures that walk around boxes, and the lights.

use std::f32::consts::TAU;
use std::ops::Range;

use glam::{Affine3A, Quat, Vec3};
use rimline::{
    Geometry, GeometryOptions, Influences, Instance, InstancePose, Light, Model, ModelError, Pose, Transform,
};

use super::stage::{Camera, Lamp, Placed};
use rimline_models::figure::{Figure, walk};

/// Rings of figures: how many, the radius in metres, and the speed in metres a second, counter-clockwise.
const RINGS: [(usize, f32, f32); 2] = [(16, 3.3, 1.25), (24, 6.2, -1.25)];
pub(crate) const WALKERS: usize = 40;
/// The boxes that move.
pub(crate) const FLOATING: Range<usize> = 40..60;

pub(crate) fn camera() -> Camera {
    Camera::new([6.0, 8.2, 14.0], [0.15, 0.35, 0.2], 35.0).wide(1.5)
}

/// How bright the light is that comes from everywhere.
pub(crate) const AMBIENT: f32 = 0.10;

pub(crate) const LAMPS: [Lamp; 4] = [
    // The sun, low in the west.
    Lamp { light: Light::directional([-0.85, 0.6, 0.42]), color: [0.80, 0.56, 0.30] },
    // A lamp over the middle.
    Lamp { light: Light::point([0.3, 5.4, -0.2]), color: [0.13, 0.16, 0.28] },
    // Two lamps among the figures.
    Lamp { light: Light::point([-4.3, 1.6, 2.6]).with_range(6.5), color: [0.95, 0.30, 0.08] },
    Lamp { light: Light::point([4.9, 1.5, 1.2]).with_range(6.5), color: [0.06, 0.42, 0.85] },
];

/// All figures: one skinned mesh, many times.
pub(crate) fn walkers() -> Result<Model, ModelError> {
    let Figure { positions, faces, joints, weights, .. } = Figure::new();
    let offsets = (0..=positions.len() as u32).map(|vertex| 4 * vertex).collect();
    let joints = joints.as_flattened().iter().map(|&joint| joint.into()).collect();
    let influences = Some(Influences::new(offsets, joints, weights.as_flattened().to_vec())?);
    let positions = positions.iter().map(Vec3::to_array).collect();
    let walker = Geometry::new(positions, faces, GeometryOptions { influences, ..GeometryOptions::default() })?;
    Model::new(vec![walker], vec![Instance::new(0, None); WALKERS])
}

/// Each figure walks along its ring, out of step with the others.
pub(crate) fn pose(seconds: f32) -> Result<Pose, ModelError> {
    let ring = |(count, radius, speed): (usize, f32, f32)| {
        (0..count).map(move |number| {
            let steps = seconds / walk::DURATION + spread(number);
            let along = TAU * number as f32 / count as f32 + speed * seconds / radius;
            // A figure faces +Z. At +X that is clockwise, seen from above.
            let turn = Quat::from_rotation_y(along + if speed < 0.0 { 0.0 } else { TAU / 2.0 });
            let at = Quat::from_rotation_y(along) * Vec3::X * (radius + 0.6 * spread(number));
            let transform = Affine3A::from_rotation_translation(turn, at);
            let palette = walk::from_rest(&walk::pose(steps.fract())).map(|joint| transform * joint);
            InstancePose::new(palette, Vec::new())
        })
    };
    Ok(Pose::new(RINGS.into_iter().flat_map(ring).collect::<Result<_, _>>()?))
}

/// How the renderer finds each figure in the deformer's buffer.
pub(crate) fn dressed(vertices: u32) -> Vec<Placed> {
    let colors = [[0.66, 0.60, 0.52], [0.62, 0.34, 0.24], [0.36, 0.42, 0.50], [0.70, 0.58, 0.34]];
    let dress = |number: usize| {
        let first_vertex = number as u32 * vertices;
        Placed { albedo: colors[number % colors.len()], first_vertex, ..Placed::default() }
    };
    (0..WALKERS).map(dress).collect()
}

/// Standing stones, crates, a stepped plinth, and boxes that float around it: all the same cube.
pub(crate) fn boxes(seconds: f32) -> Vec<Placed> {
    let standing = |half: Vec3, at: Vec3, turn: f32, albedo| {
        // A little of it is in the ground.
        let at = at + Vec3::Y * (half.y - 0.02);
        placed(half, Quat::from_rotation_y(turn), at, albedo)
    };
    let around = |angle: f32, radius: f32| Quat::from_rotation_y(angle) * Vec3::X * radius;
    let stones = (0..24).map(|n| {
        // An arc that is open towards the camera.
        let (angle, half) = (-0.25 + 0.195 * n as f32, Vec3::new(0.22, 0.5 + 0.7 * spread(n), 0.42));
        standing(half, around(angle, 8.7), angle, [0.60, 0.58, 0.55])
    });
    let crates = (0..12).map(|n| {
        let (angle, half) = (TAU * (n as f32 + 0.4 * spread(n)) / 12.0, 0.2 + 0.16 * spread(n));
        standing(Vec3::splat(half), around(angle, 5.0), 9.0 * angle, [0.58, 0.40, 0.24])
    });
    let steps = (0..4).map(|n| {
        let breadth = 1.8 - 0.45 * n as f32;
        let half = Vec3::new(breadth, 0.16, breadth);
        standing(half, Vec3::Y * 0.3 * n as f32, 0.3 * n as f32, [0.66, 0.64, 0.60])
    });
    let floating = (0..FLOATING.len()).map(|n| {
        let (share, angle) = (n as f32 / FLOATING.len() as f32, TAU * n as f32 / 8.0 + 0.5 * seconds);
        let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 1.3 * seconds + n as f32);
        let at = around(angle, 1.6 - 0.7 * share) + Vec3::Y * (1.7 + 2.6 * share);
        placed(Vec3::splat(0.2 - 0.06 * share), turn * Quat::from_rotation_y(angle), at, [0.82, 0.66, 0.36])
    });
    stones.chain(crates).chain(steps).chain(floating).collect()
}

fn placed(half: Vec3, turn: Quat, at: Vec3, albedo: [f32; 3]) -> Placed {
    Placed {
        rows: Transform::from(Affine3A::from_scale_rotation_translation(half, turn, at)).rows(),
        albedo,
        first_vertex: 0,
    }
}

/// Numbers from 0 to 1, evenly spread by the golden ratio.
fn spread(number: usize) -> f32 {
    (0.618_034 * number as f32).fract()
}
