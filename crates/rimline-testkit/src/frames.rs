//! Content of a frame: casters, receivers, camera, lights.

use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4, Mat4, Vec3};
use rimline::{DepthDirection, Light, ShadowCamera};

use crate::polygons::PolygonSet;
use crate::random::Random;
use crate::shapes::Shape;

/// Triangles of one caster or receiver.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// In world space.
    pub shape: Shape,
    pub casts: bool,
    /// Whether it is in the depth buffer. A proxy is not.
    pub is_drawn: bool,
    /// The field of the same name of the scene's caster. Others have none.
    pub in_depth: bool,
    /// The GPU gets a mesh in its own space, which is placed by a scale of 1 or -1 along each axis, of a negative
    /// determinant. So nothing is rounded.
    pub mirror: Option<Vec3>,
    /// Faces that a scene excludes for the first light.
    pub left_out: Vec<u32>,
    /// The faces of the shape are the triangles of these polygons, and the mesh is one of polygons.
    pub polygons: Option<PolygonSet>,
    /// A light of a scene that it does not cast for.
    pub lacks: Option<usize>,
}

/// A caster as the GPU gets it, with camera and lights in its space.
pub struct Placed {
    pub shape: Shape,
    pub camera: ShadowCamera,
    pub lights: Vec<Light>,
}

impl Body {
    pub fn caster(shape: Shape) -> Self {
        Self { shape, casts: true, is_drawn: true, in_depth: true, ..Self::default() }
    }

    #[must_use]
    pub fn moved(mut self, by: [f32; 3]) -> Self {
        self.shape.positions.iter_mut().for_each(|p| *p = std::array::from_fn(|axis| p[axis] + by[axis]));
        self
    }

    #[must_use]
    pub fn scaled(mut self, by: f32) -> Self {
        self.shape.positions.iter_mut().for_each(|p| *p = p.map(|c| c * by));
        self
    }

    /// Faces whose corners are all finite; the others are holes.
    pub fn finite_faces(&self) -> Vec<[u32; 3]> {
        let is_finite = |v: u32| self.shape.positions[v as usize].iter().all(|c| c.is_finite());
        self.shape.faces.iter().filter(|face| face.iter().all(|&v| is_finite(v))).copied().collect()
    }

    /// A closed room around what casts, seen from inside.
    pub fn room(centre: [f32; 3], half: f32) -> Self {
        let mut shape = crate::shapes::cube();
        for face in &mut shape.faces {
            face.swap(1, 2);
        }
        Self { casts: false, ..Self::caster(shape) }.scaled(half).moved(centre)
    }
}

/// Eye, direction and near distance; 60° high and wide, or orthographic.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    pub position: DVec3,
    pub forward: DVec3,
    pub near: f64,
    /// Positions are taken relative to the eye.
    pub is_relative: bool,
    pub depth: DepthDirection,
    /// The distance of the far plane, if there is one.
    pub far: Option<f64>,
    /// Half the width of the view of an orthographic camera, which has a far plane.
    pub half_width: Option<f64>,
}

impl Eye {
    /// A perspective camera with reversed depth, without a far plane.
    pub fn new(position: DVec3, forward: DVec3, near: f64) -> Self {
        let depth = DepthDirection::Reversed;
        Self { position, forward, near, is_relative: false, depth, far: None, half_width: None }
    }

    fn basis(&self) -> [DVec3; 3] {
        let forward = self.forward.normalize();
        let aside = if forward.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
        let right = forward.cross(aside).normalize();
        [right, right.cross(forward), forward]
    }

    /// The matrix that the GPU gets, rounded once, and the camera it makes.
    pub fn camera(&self) -> ShadowCamera {
        let [right, up, forward] = self.basis();
        let origin = if self.is_relative { self.position.as_vec3() } else { Vec3::ZERO };
        let from = self.position - origin.as_dvec3();
        let scale = 1.0 / self.half_width.unwrap_or(30_f64.to_radians().tan());
        let row = |axis: DVec3| axis.extend(-axis.dot(from));
        let [x, y, distance] = [row(right) * scale, row(up) * scale, row(forward)];
        let unit = DVec4::W;
        let w = if self.half_width.is_none() { distance } else { unit };
        let near = unit * self.near;
        let z = match (self.depth, self.far, self.half_width) {
            (DepthDirection::Reversed, Some(far), Some(_)) => (unit * far - distance) / (far - self.near),
            (DepthDirection::Standard, Some(far), Some(_)) => (distance - near) / (far - self.near),
            (DepthDirection::Reversed, None, _) => near,
            (DepthDirection::Reversed, Some(far), None) => (unit * far - w) * (self.near / (far - self.near)),
            (DepthDirection::Standard, None, _) => w - near,
            (DepthDirection::Standard, Some(far), None) => (w - near) * (far / (far - self.near)),
        };
        let matrix = DMat4::from_cols(x, y, z, w).transpose();
        ShadowCamera {
            view_projection: matrix.as_mat4().to_cols_array_2d(),
            origin: origin.to_array(),
            depth: self.depth,
        }
    }
}

/// A direction at random, of length 1 but for rounding.
pub fn vector(random: &mut Random) -> DVec3 {
    DVec3::from(random.direction().map(f64::from))
}

/// A frame to be drawn and traced.
#[derive(Clone, Debug)]
pub struct Frame {
    pub bodies: Vec<Body>,
    pub eye: Eye,
    pub lights: Vec<Light>,
    pub size: u32,
}

impl Frame {
    /// A mirrored instance's mesh stays in its own space, with its faces as they are there; camera and lights go there.
    pub fn placed(&self, body: &Body) -> Placed {
        let (mut shape, mut camera, mut lights) = (body.shape.clone(), self.eye.camera(), self.lights.clone());
        if let Some(mirror) = body.mirror {
            for position in &mut shape.positions {
                *position = (Vec3::from(*position) * mirror).to_array();
            }
            for face in &mut shape.faces {
                face.swap(1, 2);
            }
            let matrix = Mat4::from_cols_array_2d(&camera.view_projection) * Mat4::from_scale(mirror);
            camera.view_projection = matrix.to_cols_array_2d();
            camera.origin = (Vec3::from(camera.origin) * mirror).to_array();
            let to_world = DAffine3::from_scale(mirror.as_dvec3()).to_cols_array_2d();
            lights = lights.iter().filter_map(|light| light.to_mesh_space(&to_world)).collect();
        }
        Placed { shape, camera, lights }
    }
}

/// The middle of a pixel, in pixels from its upper left corner, right and down.
pub const CENTRE: DVec2 = DVec2::splat(0.5);

/// Where four samples of a pixel are: WebGPU's standard pattern.
pub const SAMPLES: [DVec2; 4] =
    [DVec2::new(0.375, 0.125), DVec2::new(0.875, 0.375), DVec2::new(0.125, 0.625), DVec2::new(0.625, 0.875)];

/// The camera's rays as the GPU's matrix has them: from a point of the near plane on, in f64.
pub struct Rays {
    inverse: DMat4,
    origin: DVec3,
    size: f64,
    near_z: f64,
    within_pixel: DVec2,
}

impl Rays {
    /// Rays through the centres of a picture's pixels.
    pub fn new(camera: &ShadowCamera, size: u32) -> Self {
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection);
        Self {
            inverse: matrix.as_dmat4().inverse(),
            origin: DVec3::from_array(camera.origin.map(f64::from)),
            size: f64::from(size),
            near_z: f64::from(u8::from(camera.depth == DepthDirection::Reversed)),
            within_pixel: CENTRE,
        }
    }

    /// Rays through another point of each pixel.
    #[must_use]
    pub fn through(self, within_pixel: DVec2) -> Self {
        Self { within_pixel, ..self }
    }

    /// Where a pixel's ray begins, on the near plane, and its direction.
    pub fn ray(&self, x: u32, y: u32) -> (DVec3, DVec3) {
        self.at(DVec2::new(f64::from(x), f64::from(y)) + self.within_pixel)
    }

    /// The same for any point of the picture, in pixels.
    pub fn at(&self, point: DVec2) -> (DVec3, DVec3) {
        let ndc = point / self.size * 2.0 - 1.0;
        let (x, y) = (ndc.x, -ndc.y);
        let near = self.inverse * DVec4::new(x, y, self.near_z, 1.0);
        // Depth 0.5 is beyond the near plane.
        let beyond = self.inverse * DVec4::new(x, y, 0.5, 1.0);
        let [near, beyond] = [near, beyond].map(|p| p.truncate() / p.w);
        (near + self.origin, (beyond - near).normalize())
    }
}
