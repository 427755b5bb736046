//! A stylised human figure, 1.76 m tall, facing +Z with +Y up: a mannequin in one smooth closed surface.
//!
//! The body is a smooth union of tapered capsules (`body`), each of which belongs to a joint ([`skeleton`]);
//! `surface` turns it into triangles, `skin` ties them to the joints and [`walk`] moves those.

mod body;
pub mod glb;
pub mod skeleton;
mod skin;
mod surface;
pub mod walk;

use glam::Vec3;

/// The figure at rest; arms and legs a little apart.
pub struct Figure {
    /// Vertex positions in metres.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Counter-clockwise triangles.
    pub faces: Vec<[u32; 3]>,
    /// Four indices into [`skeleton::JOINTS`] a vertex.
    pub joints: Vec<[u8; 4]>,
    /// Their weights, which sum to 1.
    pub weights: Vec<[f32; 4]>,
}

impl Default for Figure {
    fn default() -> Self {
        Self::new()
    }
}

impl Figure {
    /// Makes it.
    pub fn new() -> Self {
        let parts = body::parts();
        let (positions, faces) = surface::polygonise(|point| body::field(&parts, point));
        let normals = positions
            .iter()
            .map(|&point| surface::gradient(&|p| body::field(&parts, p), point).normalize_or(Vec3::Y))
            .collect();
        let (joints, weights) = skin::bind(&parts, &positions, &faces);
        Self { positions, normals, faces, joints, weights }
    }
}
