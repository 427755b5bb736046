//! Rimline.
#![forbid(unsafe_code)]

pub mod cpu;
pub mod displace;
#[cfg(feature = "gltf")]
pub mod gltf;
pub mod gpu;
pub mod layout;
pub mod light;
pub mod mesh;
pub mod method;
pub mod model;
pub mod stages;

pub use displace::{DisplaceError, Displacement};
pub use light::{Light, LightError, MAX_LIGHTS};
pub use mesh::{Mesh, MeshError};
pub use method::Method;
pub use model::{Geometry, Influences, Instance, InstancePose, Model, Pose, PoseError};

pub use {glam, wgpu};
