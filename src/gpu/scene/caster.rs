//! Casters: the caller's description, and the scene's records.

use std::ops::Range;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use slotmap::{DefaultKey, SlotMap};

use super::handles::{LightHandle, MeshHandle};
use super::lights::Lights;
use super::mask::LightMask;
use super::pages::{Pages, Region};
use crate::gpu::common::positions::PositionBuffer;
use crate::gpu::extract::of_scene::PolygonMesh;
use crate::light::MeshSpace;
use crate::mesh::{EdgeCounts, is_degenerate};
use crate::{Light, Matrix3x4, Mesh, Transform};

/// A mesh instance that throws shadows, for [`Scene::insert`](crate::gpu::Scene::insert).
#[derive(Clone, Debug)]
pub struct Caster {
    /// The mesh. Many casters may share it.
    pub mesh: MeshHandle,
    /// The positions of its vertices.
    pub positions: CasterPositions,
    /// The lights for which it throws shadows.
    pub lights: LightMask,
    /// Whether the surface is in the depth buffer that shadows are drawn against, an open surface from both sides. Set it
    /// to false for a proxy, a simpler mesh instead of the drawn one. Then every face casts, and z-pass and ZP+ draw light
    /// caps, too, because the eye may see through its faces. Receivers exactly in its faces may be lit or not.
    pub in_depth: bool,
}

impl Caster {
    /// A rigid caster in the depth buffer, for all lights.
    pub fn rigid(mesh: MeshHandle, mesh_to_world: impl Into<Transform>) -> Self {
        let positions = CasterPositions::Rigid(mesh_to_world.into());
        Self { mesh, positions, lights: LightMask::ALL, in_depth: true }
    }

    /// A caster in the depth buffer, for all lights, whose vertices lie in a buffer in world space.
    pub fn in_buffer(mesh: MeshHandle, positions: PositionBuffer<'_>) -> Self {
        Self { mesh, positions: positions.into(), lights: LightMask::ALL, in_depth: true }
    }
}

impl From<PositionBuffer<'_>> for CasterPositions {
    fn from(PositionBuffer { buffer, offset, stride }: PositionBuffer<'_>) -> Self {
        Self::Buffer { buffer: buffer.clone(), offset, stride }
    }
}

/// The positions of the vertices of a caster.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum CasterPositions {
    /// The positions of the mesh, moved to world space by this transform. A caster with a singular transform, or one
    /// that is not finite, casts nothing. Silhouettes are found in mesh space, to which lights are moved as by
    /// [`Light::to_mesh_space`](crate::Light::to_mesh_space). Volumes compute a vertex less the camera's origin as
    /// `row.xyz · position + (row.w − origin)` for each axis, by [`Transform::rows`], with products added from x to z,
    /// and with z-fail a depth pass must compute the same bits (see [`Counting`](crate::Counting)).
    Rigid(Transform),
    /// Positions in the caller's buffer, in world space, for each source vertex of the mesh. Each encode reads them, unless
    /// [`Scene::set_position_version`](crate::gpu::Scene::set_position_version) says that nothing changed. The draws of its
    /// frame always read them again, so write no others before. Casters with the same buffer are drawn together, so keep
    /// many in one buffer. [`Scene::insert_model`](crate::gpu::Scene::insert_model) is easier for a model with poses.
    Buffer {
        /// The buffer, with usage `STORAGE`. Each encode refuses one that was destroyed. A draw of an earlier frame does not
        /// check it, and wgpu then refuses the submission.
        buffer: wgpu::Buffer,
        /// Bytes from the start of the buffer to the x of vertex 0. A multiple of 4.
        offset: u64,
        /// Bytes from one vertex to the next. A multiple of 4, at least 12.
        stride: u64,
    },
}

/// The content of a scene: meshes with the pages that hold them, casters, and lights.
#[derive(Debug)]
pub(crate) struct Content {
    /// Each caster of a mesh has it, too.
    pub(crate) meshes: SlotMap<DefaultKey, Arc<MeshEntry>>,
    pub(crate) pages: Pages,
    pub(crate) casters: SlotMap<DefaultKey, CasterEntry>,
    pub(crate) lights: Lights,
}

/// The scene's record of a mesh.
#[derive(Debug)]
pub(crate) struct MeshEntry {
    pub(crate) region: Region,
    pub(crate) vertices: u32,
    pub(crate) faces: u32,
    pub(crate) counts: EdgeCounts,
    pub(crate) is_closed: bool,
    /// The box of the faces whose corners are finite. Low is above high if there is none.
    pub(crate) low: [f32; 3],
    pub(crate) high: [f32; 3],
    /// Whether a face of three different vertices has one that is not finite.
    pub(crate) is_holed: bool,
    /// The faces of its slots. `None`: the order of the mesh, without clusters.
    pub(crate) order: Option<Arc<[u32]>>,
    /// `None`: it has only triangles.
    pub(crate) polygons: Option<PolygonMesh>,
}

impl MeshEntry {
    pub(crate) fn new(
        region: Region,
        mesh: &Mesh,
        positions: &[[f32; 3]],
        order: Option<Arc<[u32]>>,
        polygons: Option<PolygonMesh>,
    ) -> Self {
        let (mut low, mut high, mut is_holed) = ([f32::MAX; 3], [f32::MIN; 3], false);
        for &face in mesh.faces() {
            let corners = face.map(|vertex| positions.get(vertex as usize).copied().unwrap_or([f32::NAN; 3]));
            if corners.iter().flatten().all(|c| c.is_finite()) {
                for corner in corners {
                    low = std::array::from_fn(|axis| low[axis].min(corner[axis]));
                    high = std::array::from_fn(|axis| high[axis].max(corner[axis]));
                }
            } else {
                is_holed |= !is_degenerate(face);
            }
        }
        let (vertices, faces, counts) = (mesh.vertex_count(), mesh.faces().len() as u32, mesh.edges().counts());
        let is_closed = mesh.is_closed();
        Self { region, vertices, faces, counts, is_closed, low, high, is_holed, order, polygons }
    }

    /// The slots of some of its faces.
    pub(crate) fn slots(&self, faces: &[u32]) -> Arc<[u32]> {
        let Some(order) = &self.order else { return faces.into() };
        let mut slots = vec![0; order.len()];
        for (slot, &face) in (0..).zip(order.iter()) {
            if let Some(slot_of_face) = slots.get_mut(face as usize) {
                *slot_of_face = slot;
            }
        }
        faces.iter().filter_map(|&face| slots.get(face as usize).copied()).collect()
    }

    /// The number of faces, which are polygons or triangles.
    pub(crate) fn face_count(&self) -> usize {
        self.polygons.as_ref().map_or(self.faces as usize, |polygons| polygons.counts.polygons)
    }

    pub(crate) fn edges(&self) -> u32 {
        let EdgeCounts { consistent, inconsistent, boundary } = self.counts;
        (consistent + inconsistent + boundary) as u32
    }
}

/// The scene's record of a caster.
#[derive(Debug)]
pub(crate) struct CasterEntry {
    pub(crate) mesh: Arc<MeshEntry>,
    pub(crate) lights: LightMask,
    pub(crate) in_depth: bool,
    /// For each light the slots of faces that the caller excludes, counted from the caster's first slot.
    pub(crate) excluded: Vec<(LightHandle, Arc<[u32]>)>,
    /// Occluders, in mesh space.
    pub(crate) occluders: Vec<Arc<[[f32; 3]]>>,
    /// For each light the slots of occluded faces, likewise.
    pub(crate) occluded: Vec<(LightHandle, Arc<[u32]>)>,
    pub(crate) placement: Placement,
    /// Whether `Scene::moved` has it: the table lacks a change that needs no new layout.
    pub(crate) is_moved: bool,
    /// The first encode with the caster as it is, in this layout.
    pub(crate) version: u32,
    /// The stated box of the positions in its buffer, in world space.
    pub(crate) bounds: Option<[[f32; 3]; 2]>,
    /// The version of the positions in its buffer, of the caller or of the model. `None`: they may change in each encode.
    pub(crate) positions_version: Option<u64>,
    /// Whether it is an instance of a model.
    pub(crate) is_of_model: bool,
    /// Its index among the instances of all models, from 1. 0: it is no instance.
    pub(crate) deforming_index: u32,
    /// Its index in the table, from the layout on.
    pub(crate) index: u32,
    /// The offset of its lights in the table.
    pub(crate) first_light: u32,
}

impl CasterEntry {
    /// Slots of faces that the caller excludes, and of occluded faces.
    pub(crate) fn all_excluded(&self) -> impl Iterator<Item = &(LightHandle, Arc<[u32]>)> {
        self.excluded.iter().chain(&self.occluded)
    }

    /// Whether a face is excluded for any light.
    pub(crate) fn is_excluding(&self) -> bool {
        self.all_excluded().next().is_some()
    }

    /// A light in the space of its positions, if it casts for that light. `None` also for a moved direction too small for
    /// `f32`.
    pub(crate) fn light(&self, lights: &Lights, bit: u32) -> Option<Light> {
        let light = lights.get(bit).filter(|_| self.lights.has(bit))?;
        let moved = match &self.placement {
            Placement::World { .. } => light,
            Placement::Rigid(rigid) => rigid.space?.light(light)?,
        };
        Some(moved).filter(|light| light.to_array() != [0.0; 4])
    }

    /// The word of its first vertex in the bound positions, and the words from vertex to vertex.
    pub(crate) fn position_words(&self) -> [u32; 2] {
        match self.placement {
            Placement::Rigid(_) => [3 * self.mesh.region.ranges[2].start, 3],
            Placement::World { offset, stride, .. } => [offset, stride],
        }
    }

    /// Whether each encode computes its bits: its positions may have changed, or it has polygons. A group with excluded faces
    /// caches nothing, either.
    pub(crate) fn is_uncached(&self) -> bool {
        self.mesh.polygons.is_some()
            || matches!(self.placement, Placement::World { .. }) && self.positions_version.is_none()
    }
}

/// The occluded faces for a light, and their casters.
#[derive(Debug)]
pub(super) struct OccludedFacesOfLight {
    pub(super) light: LightHandle,
    /// The bits of the light that was searched.
    pub(super) bits: [u32; 4],
    pub(super) casters: Vec<OcclusionCaster>,
    /// Occluded faces of all casters.
    pub(super) count: usize,
    /// Whether the scene leaves these faces out.
    pub(super) is_used: bool,
}

#[derive(Debug)]
pub(super) struct OcclusionCaster {
    pub(super) key: DefaultKey,
    pub(super) version: Option<u64>,
    /// Slots of occluded faces.
    pub(super) slots: Arc<[u32]>,
}

/// The space and the location of a caster's positions.
#[derive(Debug)]
pub(crate) enum Placement {
    /// Mesh space, in the page.
    Rigid(Rigid),
    /// World space, in the bound part of a caller's buffer: the word of vertex 0, and the words from vertex to vertex.
    World { bound: BoundBuffer, offset: u32, stride: u32 },
}

/// The part of a caller's buffer that is bound.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct BoundBuffer {
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) range: Range<u64>,
}

/// A transform, with derived values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rigid {
    pub(crate) rows: Matrix3x4,
    /// `None`: the transform is singular or not finite.
    pub(crate) space: Option<MeshSpace>,
    /// At most the smallest factor by which the transform scales a length.
    pub(crate) scale: f32,
    pub(crate) is_mirrored: bool,
}

impl Rigid {
    pub(crate) fn new(rows: Matrix3x4) -> Self {
        let transform = Transform::from(rows).to_f64();
        let is_finite = rows.iter().flatten().all(|c| c.is_finite());
        let space = MeshSpace::new(transform).filter(|_| is_finite);
        let scale = space.map_or(0.0, |space| least_scale(transform.matrix3, space.inverse));
        Self { rows, space, scale, is_mirrored: transform.matrix3.determinant() < 0.0 }
    }
}

/// A lower bound of the smallest singular value of a matrix, or 0 where rounding may spoil the inverse.
fn least_scale(matrix: DMat3, inverse: DMat3) -> f32 {
    let squares = |matrix: DMat3| matrix.to_cols_array().iter().map(|c| c * c).sum::<f64>();
    let (whole, of_inverse) = (squares(matrix), squares(inverse));
    // The condition number is at most the root of this.
    let condition = whole * of_inverse;
    if condition.is_nan() || condition > 1e16 {
        return 0.0;
    }
    // The Frobenius norm of the inverse is at least its largest singular value. It is √3 too large for equal scales, so
    // the eigenvalue is computed, too.
    let bound = of_inverse.sqrt().recip().max(least_eigenvalue(matrix.transpose() * matrix).sqrt());
    let rounded = (bound * (1.0 - 1e-9)) as f32;
    // Rounding to f32 may have gone up, and may have left the finite numbers.
    if rounded.is_finite() { rounded.next_down().max(0.0) } else { f32::MAX }
}

/// A lower bound of the smallest eigenvalue of a symmetric matrix without negative ones, by the cosine formula.
fn least_eigenvalue(matrix: DMat3) -> f64 {
    let mean = (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z) / 3.0;
    let apart = matrix - DMat3::from_diagonal(DVec3::splat(mean));
    let spread = (apart.to_cols_array().iter().map(|c| c * c).sum::<f64>() / 6.0).sqrt();
    let angle = if spread > 0.0 { ((apart * spread.recip()).determinant() / 2.0).clamp(-1.0, 1.0).acos() } else { 0.0 };
    let least = mean + 2.0 * spread * (angle / 3.0 + 2.0 * std::f64::consts::FRAC_PI_3).cos();
    // Near its ends the arc cosine loses half of the digits.
    (least - 1e-7 * spread - 1e-12 * mean).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_scales_are_lower_bounds_and_close() {
        let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
        let other = DMat3::from_axis_angle(DVec3::new(0.0, 0.8, -0.6), 2.3);
        for scales in [[1.0, 1.0, 1.0], [2.0, 3.0, 5.0], [1e-3, 1e-3, 1e3], [-0.5, 7.0, 7.0], [1e3, 1e3, 1e3]] {
            let matrix = turn * DMat3::from_diagonal(DVec3::from(scales)) * other;
            let scale = f64::from(least_scale(matrix, matrix.inverse()));
            let least = scales.iter().fold(f64::MAX, |least, c| least.min(c.abs()));
            assert!(scale <= least && scale > 0.57 * least, "{scales:?}: {scale}");
            if scales[0].abs() * 10.0 > scales[2].abs() {
                assert!(scale > 0.9999 * least, "{scales:?}: {scale}");
            }
        }
        let flat = turn * DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1e-12)) * other;
        assert_eq!(least_scale(flat, flat.inverse()), 0.0);
    }

    #[test]
    fn singular_and_non_finite_transforms_have_no_space() {
        let rows = |x: f32, shift: f32| [[x, 0.0, 0.0, shift], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        assert!(Rigid::new(rows(2.0, 1.0)).space.is_some());
        assert!(Rigid::new(rows(-2.0, 1.0)).is_mirrored);
        for (x, shift) in [(0.0, 1.0), (f32::NAN, 1.0), (f32::INFINITY, 1.0), (1.0, f32::NAN), (1.0, f32::INFINITY)] {
            assert_eq!(Rigid::new(rows(x, shift)).space, None, "{x} {shift}");
        }
    }
}
