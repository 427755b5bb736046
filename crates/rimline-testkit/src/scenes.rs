//! Cameras, casters and lights for shadow volumes: every projection, and lights where the near plane is critical.

use glam::{DMat4, DQuat, DVec3, DVec4, Vec3};
use rimline::{DepthDirection, Light, ShadowCamera};

use super::cases::{Case, topologies};
use super::random::Random;

/// A camera, a caster and lights.
#[derive(Clone)]
pub struct Scene {
    pub name: String,
    pub camera: ShadowCamera,
    pub caster: Case,
    pub lights: Vec<Light>,
}

/// Perspective with an infinite or a finite far plane, or orthographic; each with either depth.
pub const PROJECTIONS: usize = 6;

/// Where a camera stands.
#[derive(Clone, Copy)]
pub struct Pose {
    pub eye: DVec3,
    pub forward: DVec3,
    pub right: DVec3,
    pub up: DVec3,
    pub near: f64,
    /// Distances over which the scene spreads.
    pub scale: f64,
}

impl Pose {
    pub fn random(random: &mut Random, middle: DVec3, scale: f64) -> Self {
        let forward = direction(random);
        let right = forward.cross(direction(random)).normalize();
        Self {
            eye: middle + direction(random) * scale * f64::from(random.between(0.0, 3.0)),
            forward,
            right,
            up: right.cross(forward),
            near: scale * f64::from(random.between(0.02, 0.5)),
            scale,
        }
    }

    /// The point at these distances to the right, up, and before the near plane.
    pub fn at(self, right: f64, up: f64, height: f64) -> DVec3 {
        self.eye + self.right * right + self.up * up + self.forward * (self.near + height)
    }

    /// The camera; `relative`: positions are taken relative to the eye.
    pub fn camera(self, projection: usize, relative: bool) -> ShadowCamera {
        let (near, far, zoom) = (self.near, 40.0 * self.scale, 1.3);
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][projection % 2];
        let is_reversed = depth == DepthDirection::Reversed;
        let depth_row = |slope: f64, constant: f64| (self.forward * slope).extend(constant);
        let row = |axis: DVec3, scale: f64| (axis * scale).extend(0.0);
        let finite = far / (far - near);
        let [x, y, z, w] = match (projection / 2, is_reversed) {
            (2, _) => {
                let size = 0.7 * self.scale;
                let slope = 1.0 / (far - near);
                let z = if is_reversed { depth_row(-slope, far * slope) } else { depth_row(slope, -near * slope) };
                [row(self.right, 1.0 / size), row(self.up, 1.0 / size), z, DVec4::W]
            }
            (kind, _) => {
                let z = match (kind, is_reversed) {
                    (0, true) => depth_row(0.0, near),
                    (0, false) => depth_row(1.0, -near),
                    (_, true) => depth_row(-near / (far - near), finite * near),
                    (_, false) => depth_row(finite, -finite * near),
                };
                [row(self.right, zoom), row(self.up, 1.3 * zoom), z, depth_row(1.0, 0.0)]
            }
        };
        let mut matrix = DMat4::from_cols(x, y, z, w).transpose();
        if !relative {
            matrix *= DMat4::from_translation(-self.eye);
        }
        let origin = if relative { self.eye.as_vec3() } else { Vec3::ZERO };
        ShadowCamera { view_projection: matrix.as_mat4().to_cols_array_2d(), origin: origin.to_array(), depth }
    }
}

pub fn direction(random: &mut Random) -> DVec3 {
    DVec3::from_array(random.direction().map(f64::from)).normalize()
}

/// `count` lights about a camera: anywhere, at infinity, of any weight, on the near plane and close to it on either
/// side, far away, at the eye, at infinity along the near plane. One in four has a range.
pub fn lights(random: &mut Random, pose: Pose, count: usize) -> Vec<Light> {
    let light = |index: usize| {
        let unit = |random: &mut Random| f64::from(random.between(-1.0, 1.0));
        let anywhere = pose.eye + direction(random) * pose.scale * f64::from(random.between(0.1, 6.0));
        let (a, b) = (unit(random) * pose.scale, unit(random) * pose.scale);
        let point = |p: DVec3| Light::point(p.as_vec3().to_array());
        let light = match index % 12 {
            0 | 1 => point(anywhere),
            2 => Light::directional(random.direction()),
            3 => {
                let w = f64::from(random.between(0.2, 3.0));
                Light::homogeneous((anywhere * w).extend(w).as_vec4().to_array())
            }
            4 => point(pose.at(a, b, 0.0)),
            5 => point(pose.at(a, b, [1e-7, -1e-7, 1e-5, -1e-5][index / 12 % 4] * pose.scale)),
            6 => point(pose.at(a * 0.3, b * 0.3, unit(random) * 0.01 * pose.scale)),
            7 => point(pose.eye + direction(random) * 1e6 * pose.scale),
            8 => point(pose.eye),
            9 => Light::directional((pose.right * a + pose.up * b).as_vec3().to_array()),
            10 => point(pose.at(a, b, unit(random) * pose.scale)),
            _ => point(pose.eye + direction(random) * pose.scale * f64::from(random.between(8.0, 40.0))),
        };
        let range = if random.below(4) == 0 { random.between(0.1, 4.0) * pose.scale as f32 } else { f32::INFINITY };
        light.with_range(range)
    };
    (0..count).map(light).collect()
}

/// A scene: caster and camera near each other, so that the near rectangle is often inside, cut, or in the shadow.
pub fn scene(random: &mut Random, number: usize, light_count: usize) -> Scene {
    let mut cases = topologies();
    let (name, positions, mesh) = cases.swap_remove(random.below(cases.len()));
    let scale = [1.0, 1.0, 8.0, 0.05][random.below(4)];
    let offset = [0.0, 0.0, 1e3, 1e5][number % 4];
    let middle = direction(random) * offset;
    let pose = Pose::random(random, middle, scale);
    let projection = number / 4 % PROJECTIONS;
    let is_relative = offset > 2e3 || random.below(2) == 0;
    let turn = DQuat::from_axis_angle(direction(random), f64::from(random.between(0.0, 6.0)));
    let size = scale * f64::from(random.between(0.2, 1.2));
    let moved = |p: [f32; 3]| (middle + turn * (DVec3::from_array(p.map(f64::from)) * size)).as_vec3().to_array();
    let positions = positions.into_iter().map(moved).collect();
    Scene {
        name: format!("{name}, projection {projection}, at {offset}, relative {is_relative}, scale {scale}"),
        camera: pose.camera(projection, is_relative),
        caster: (name, positions, mesh),
        lights: lights(random, pose, light_count),
    }
}
