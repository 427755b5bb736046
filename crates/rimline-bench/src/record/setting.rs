//! Casters, lights, a camera, and the ground.

use glam::{Mat4, Vec3, Vec4};
use rimline::{DepthDirection, Light, Matrix3x4, Model, ModelError, Pose, ShadowCamera};

use crate::shapes::Shape;

pub const IDENTITY: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A right-handed perspective camera with an infinite far plane and reversed depth, `near / distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    pub eye: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    pub forward: Vec3,
    /// Clip units per unit of view space at distance 1, of a picture as high as wide.
    pub scale: f32,
    pub near: f32,
}

impl Camera {
    /// A camera whose right is level.
    pub fn level(eye: Vec3, forward: Vec3, scale: f32, near: f32) -> Self {
        let forward = forward.normalize();
        let right = forward.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X);
        Self { eye, right, up: right.cross(forward), forward, scale, near }
    }

    pub fn shadow(&self) -> ShadowCamera {
        let x = (self.scale * self.right).extend(0.0);
        let y = (self.scale * self.up).extend(0.0);
        let z = Vec4::new(0.0, 0.0, 0.0, self.near);
        ShadowCamera {
            view_projection: Mat4::from_cols(x, y, z, self.forward.extend(0.0)).transpose().to_cols_array_2d(),
            origin: self.eye.into(),
            depth: DepthDirection::Reversed,
        }
    }
}

pub struct Setting {
    pub casters: Casters,
    pub lights: Vec<Light>,
    pub camera: ShadowCamera,
    /// Height of the ground, a wide plane that receives and does not cast. `None`: there is none.
    pub ground: Option<f32>,
    /// By how much lights turn about the y axis from frame to frame, in radians.
    pub turn: f32,
    /// How far rigid casters move to and fro from frame to frame. Receivers stay where they are.
    pub drift: f32,
    /// Polygons of a shape, by its number, behind which its casters hide others from lights.
    pub occluders: Option<(usize, Vec<[[f32; 3]; 4]>)>,
    /// Pairs of caster and light of which the light's range reaches the caster, where casters begin.
    pub pairs_in_range: usize,
}

impl Setting {
    /// Casters in the range of all lights, over no ground.
    pub fn new(casters: Casters, lights: Vec<Light>, camera: ShadowCamera) -> Self {
        let pairs_in_range = casters.count() * lights.len();
        Self { casters, lights, camera, ground: None, turn: 0.0, drift: 0.0, occluders: None, pairs_in_range }
    }

    /// Rigid casters that stay.
    pub fn rigid(shapes: Vec<Shape>, placed: Vec<(usize, Matrix3x4)>, lights: Vec<Light>, camera: &Camera) -> Self {
        Self::new(Casters::Rigid { shapes, placed }, lights, camera.shadow())
    }

    /// Shapes in the same light, seen by the same camera.
    #[must_use]
    pub fn in_buffers(&self, shapes: Vec<Shape>) -> Self {
        Self::new(Casters::InBuffers(shapes), self.lights.clone(), self.camera)
    }
}

pub enum Casters {
    /// Shapes, and for each caster its shape and where it stands.
    Rigid { shapes: Vec<Shape>, placed: Vec<(usize, Matrix3x4)> },
    /// Shapes whose positions lie in buffers of the caller, in world space.
    InBuffers(Vec<Shape>),
    /// Skinned casters that walk: the model, and its pose after so many frames.
    Walking { model: Model, pose: Box<dyn Fn(usize) -> Result<Pose, ModelError>> },
}

impl Casters {
    pub fn count(&self) -> usize {
        match self {
            Self::Rigid { placed, .. } => placed.len(),
            Self::InBuffers(shapes) => shapes.len(),
            Self::Walking { model, .. } => model.instances().len(),
        }
    }

    pub fn faces(&self) -> usize {
        match self {
            Self::Rigid { shapes, placed } => placed.iter().map(|(shape, _)| shapes[*shape].faces.len()).sum(),
            Self::InBuffers(shapes) => shapes.iter().map(|shape| shape.faces.len()).sum(),
            Self::Walking { model, .. } => model.placed_geometries().map(|geometry| geometry.faces().len()).sum(),
        }
    }

    /// Rigid casters in world space, a shape each.
    pub fn placed(&self) -> Vec<Shape> {
        let Self::Rigid { shapes, placed } = self else { return Vec::new() };
        let shape = |(shape, matrix): &(usize, Matrix3x4)| {
            let at = |[x, y, z]: [f32; 3]| matrix.map(|row| row[0] * x + row[1] * y + row[2] * z + row[3]);
            shapes[*shape].clone().placed(at)
        };
        placed.iter().map(shape).collect()
    }

    /// Rigid casters as one mesh. Their vertices are not welded.
    pub fn merged(&self) -> Shape {
        Shape::joined(&self.placed())
    }
}
