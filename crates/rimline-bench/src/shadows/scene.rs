//! Scenes of the shadow bench, after section 6 of Hornus, Hoberock, Lefebvre and Hart (2005). One caster stands in the
//! middle of a closed room with a point light; cameras follow paths.

use std::f32::consts::TAU;

use glam::Vec3;
use rimline::Light;

use crate::extraction::subject::extent;
use crate::record::Camera;
use crate::shapes::{self, Shape};

/// A caster's name and shape.
type Model = (&'static str, fn() -> Shape);

/// Casters within 1.85 of the middle, of about the sizes of the paper's three.
pub(crate) const MODELS: [Model; 3] = [
    ("twisted torus", twisted_torus),
    ("lumpy sphere", || shapes::blob(50, 0.5, 3)),
    ("fine lumpy sphere", || shapes::blob(102, 0.7, 11)),
];

/// A torus whose section has four lobes that turn on their way round.
fn twisted_torus() -> Shape {
    const RINGS: u32 = 120;
    const SEGMENTS: u32 = 50;
    let mut shape = shapes::torus(RINGS, SEGMENTS, 1.0, 0.4);
    for (vertex, position) in (0..).zip(&mut shape.positions) {
        let [u, v] =
            [(vertex / SEGMENTS, RINGS), (vertex % SEGMENTS, SEGMENTS)].map(|(k, n)| TAU * k as f32 / n as f32);
        let lobes = 1.0 + 0.3 * (4.0 * v + 3.0 * u).cos();
        let axis = Vec3::new(u.cos(), 0.0, u.sin());
        *position = (axis + lobes * (Vec3::from(*position) - axis)).to_array();
    }
    shape
}

const ROOM: f32 = 24.0;

pub(crate) fn room() -> Shape {
    let mut shape = shapes::cube().placed(|position| position.map(|c| c * ROOM));
    shape.faces.iter_mut().for_each(|face| face.swap(1, 2));
    shape
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    pub(crate) id: &'static str,
    pub(crate) name: &'static str,
    light: Vec3,
    /// Eye and direction at a part of the way, with what is behind the caster as seen from the light.
    at: fn(f32, Vec3) -> [Vec3; 2],
}

pub(crate) const PATHS: [Path; 4] = [
    // In the caster's shadow, away from it, and towards it.
    Path {
        id: "looks-away",
        name: "in shadow, looks away",
        light: Vec3::new(-5.0, 1.2, 0.6),
        at: |t, behind| [in_shadow(t, behind), behind + sway(t)],
    },
    Path {
        id: "looks-at-occluder",
        name: "in shadow, looks at occluder",
        light: Vec3::new(-5.0, 1.2, 0.6),
        at: |t, behind| [in_shadow(t, behind), 0.5 * sway(t) - behind],
    },
    // From where the caster is small to where it fills the picture; its shadow falls to the left.
    Path {
        id: "zoom",
        name: "zoom",
        light: Vec3::new(6.0, 3.0, 2.0),
        at: |t, _| {
            let from = Vec3::new(0.15 * (TAU * t).sin(), 0.3, 1.0).normalize();
            [from * 23.0 * (2.0_f32 / 23.0).powf(t), -from]
        },
    },
    // All around, in and out of the shadow.
    Path {
        id: "random",
        name: "random",
        light: Vec3::new(-3.0, 5.0, 2.0),
        at: |t, _| {
            let angle = TAU * t;
            let wander = |[a, b, c]: [f32; 3]| {
                Vec3::new((2.0 * angle + a).sin(), (3.0 * angle + b).sin(), (5.0 * angle + c).cos())
            };
            let from = wander([0.0, 1.0, 2.0]).normalize() * (4.0 + 2.0 * (4.0 * angle).sin());
            [from, 1.2 * wander([3.0, 5.0, 1.0]) - from]
        },
    },
];

const NEAR: f32 = 0.05;
/// Clip units per unit at distance 1, of a picture as high as wide: 60°.
const SCALE: f32 = 1.732;

fn in_shadow(t: f32, behind: Vec3) -> Vec3 {
    behind * (2.0 + 1.5 * t) + 0.05 * Vec3::new(0.0, (TAU * t).sin(), (TAU * t).cos())
}

fn sway(t: f32) -> Vec3 {
    Vec3::new(0.0, 0.25 * (2.0 * TAU * t).sin(), 0.35 * (TAU * t).sin())
}

impl Path {
    pub(crate) fn light(self) -> Light {
        Light::point(self.light.to_array())
    }

    /// The camera at `t`, from 0 at the path's beginning to 1 at its end.
    pub(crate) fn camera(self, t: f32) -> Camera {
        let [eye, forward] = (self.at)(t, -self.light.normalize());
        Camera::level(eye, forward, SCALE, NEAR)
    }
}

/// A shape of the user, as large as the other models.
pub(crate) fn fitted(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Shape {
    let (middle, size) = extent(positions);
    let shape = Shape { positions: positions.to_vec(), faces: faces.to_vec() };
    shape.placed(|p| std::array::from_fn(|axis| (p[axis] - middle[axis]) / size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_closed_and_no_camera_is_in_them_or_outside_the_room() {
        for (name, make) in MODELS {
            let shape = make();
            let mesh = shape.mesh().expect("shapes are meshes");
            assert!(mesh.is_closed(), "{name}");
            let reach = shape.positions.iter().map(|&p| Vec3::from(p).length()).fold(0.0, f32::max);
            assert!(reach < 1.85, "{name}: {reach}");
        }
        for path in PATHS {
            for step in 0..=1000 {
                let eye = path.camera(step as f32 / 1000.0).eye;
                assert!(eye.length() > 1.85 + NEAR && eye.abs().max_element() < ROOM, "{path:?} {step}: {eye}");
            }
        }
    }
}
