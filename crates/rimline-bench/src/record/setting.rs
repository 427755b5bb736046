//! Settings, which benchmarks record: casters, lights, a camera, the ground, and how they move from frame to frame.

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
    /// The angle by which lights turn about the y axis of the world in each frame, in radians.
    pub turn: f32,
    /// In every other frame rigid casters are moved by this along each axis. The surfaces that receive shadows stay.
    pub drift: f32,
    /// The index of a shape, and polygons on its faces. They are occluders of each caster of the shape: casters behind
    /// them, as seen from a light, are culled.
    pub occluders: Option<(usize, Vec<[[f32; 3]; 4]>)>,
    /// The number of pairs of a caster and a light whose range reaches it, in the first frame.
    pub pairs_in_range: usize,
}

impl Setting {
    /// Each light's range reaches every caster. There is no ground and no occluder, and nothing moves.
    pub fn new(casters: Casters, lights: Vec<Light>, camera: ShadowCamera) -> Self {
        let pairs_in_range = casters.count() * lights.len();
        Self { casters, lights, camera, ground: None, turn: 0.0, drift: 0.0, occluders: None, pairs_in_range }
    }

    /// [`Self::new`] of rigid casters.
    pub fn rigid(shapes: Vec<Shape>, placed: Vec<(usize, Matrix3x4)>, lights: Vec<Light>, camera: &Camera) -> Self {
        Self::new(Casters::Rigid { shapes, placed }, lights, camera.shadow())
    }

    /// [`Self::new`] of shapes in buffers, with the lights and the camera of this setting.
    #[must_use]
    pub fn in_buffers(&self, shapes: Vec<Shape>) -> Self {
        Self::new(Casters::InBuffers(shapes), self.lights.clone(), self.camera)
    }
}

pub enum Casters {
    /// Shapes, and for each caster the index of its shape, and the matrix from the shape to the world.
    Rigid { shapes: Vec<Shape>, placed: Vec<(usize, Matrix3x4)> },
    /// Shapes whose positions lie in buffers of the caller, in world space.
    InBuffers(Vec<Shape>),
    /// Skinned casters that walk: the model, and its pose in a frame.
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

    /// A shape in world space for each rigid caster. None for other casters.
    pub fn world_shapes(&self) -> Vec<Shape> {
        let Self::Rigid { shapes, placed } = self else { return Vec::new() };
        let shape = |(shape, matrix): &(usize, Matrix3x4)| {
            let at = |[x, y, z]: [f32; 3]| matrix.map(|row| row[0] * x + row[1] * y + row[2] * z + row[3]);
            shapes[*shape].clone().placed(at)
        };
        placed.iter().map(shape).collect()
    }

    /// Rigid casters as one mesh. Their vertices are not welded.
    pub fn merged(&self) -> Shape {
        Shape::joined(&self.world_shapes())
    }
}
