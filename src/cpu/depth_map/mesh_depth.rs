//! Mesh depth: the vertices of meshes, as the light of a depth map sees them.

use glam::{Vec3, Vec4};

use crate::layout::{MeshDepthCaster, MeshDepthView};

/// A vertex at `position`, in the light's clip space.
pub fn mesh_depth(view: &MeshDepthView, caster: &MeshDepthCaster, position: [f32; 3]) -> Vec4 {
    let own = Vec3::from_array(position);
    let [x, y, z] =
        [caster.row_0, caster.row_1, caster.row_2].map(|row| row[0] * own.x + row[1] * own.y + row[2] * own.z + row[3]);
    let [of_x, of_y, of_z, constant] = view.columns.map(Vec4::from_array);
    of_x * x + of_y * y + of_z * z + constant
}

/// A corner of a face of a chunk of a scene, from 0 on, three a face. `None` behind the last face. `faces` are those of the page,
/// and `position` reads a position whose x is in a word.
pub fn scene_depth(
    view: &MeshDepthView,
    (casters, faces): (&[MeshDepthCaster], &[[u32; 3]]),
    position: impl Fn(u32) -> [f32; 3],
    (chunk, corner): ([u32; 2], u32),
) -> Option<Vec4> {
    let caster = casters.get(chunk[0] as usize)?;
    let [first_word, stride, first_face, count] = caster.place;
    let face = chunk[1] + corner / 3;
    let vertex = faces.get((first_face + face) as usize).filter(|_| face < count)?[corner as usize % 3];
    Some(mesh_depth(view, caster, position(first_word + vertex * stride)))
}
