//! Mesh depth: the vertices of a mesh, as the light of a depth map sees them.

use glam::{Vec3, Vec4};

use crate::layout::MeshDepthView;

/// A vertex at `position`, in the light's clip space.
pub fn mesh_depth(view: &MeshDepthView, position: [f32; 3]) -> Vec4 {
    let from = Vec3::from_array(position) - Vec4::from_array(view.origin).truncate();
    let [x, y, z, constant] = view.columns.map(Vec4::from_array);
    x * from.x + y * from.y + z * from.z + constant
}
