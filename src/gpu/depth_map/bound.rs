//! Bindings of a map.

use crate::gpu::common::bindings::{Resource, texture, uniform};
use crate::layout::{ContourShape, DepthMapShape};

/// The resources of a map that stages and draws bind.
pub(super) struct Bound<'a> {
    /// The map, and its objects.
    pub(super) textures: [&'a wgpu::TextureView; 2],
    pub(super) shape: DepthMapShape,
    pub(super) map: wgpu::Buffer,
    pub(super) contour: Option<wgpu::Buffer>,
}

impl Bound<'_> {
    pub(super) fn has_objects(&self) -> bool {
        self.shape.has_objects == 1
    }

    pub(super) fn get(&self, name: &str) -> Option<Resource<'_>> {
        Some(match name {
            "depth_map" => uniform::<DepthMapShape>(&self.map, 0),
            "depth_texture" => texture(self.textures[0]),
            "object_texture" => texture(self.textures[1]),
            "contour" => uniform::<ContourShape>(self.contour.as_ref()?, 0),
            _ => return None,
        })
    }
}
