//! Rimline.
#![forbid(unsafe_code)]

#[cfg(feature = "gltf")]
pub mod gltf;
pub mod light;
pub mod mesh;
pub mod model;

pub use light::{Light, LightError, MAX_LIGHTS};
pub use mesh::{Mesh, MeshError};
pub use model::{Geometry, Influences, Instance, InstancePose, Model, Pose};

pub use {glam, wgpu};
