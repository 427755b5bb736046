//! Rimline.
#![forbid(unsafe_code)]

pub mod light;
pub mod mesh;
pub mod model;
pub mod shapes;

pub use light::{Light, LightError, MAX_LIGHTS};
pub use mesh::{Mesh, MeshError};
pub use model::{Geometry, Influences, Instance, InstancePose, Model, Pose};

pub use {glam, wgpu};
