//! The input of shadow volumes: the results of an extraction, of a scene or of a single mesh.

use wgpu::BindingResource;

/// The extraction of some casters. Sizes are those of [`VolumeSizes`](super::sizes::VolumeSizes).
pub(crate) struct VolumeSource<'a> {
    /// Casters, and room for a copy of what is chosen for them.
    pub(crate) table: &'a wgpu::Buffer,
    /// For each batch and caster the lights that matter. A single caster has none.
    pub(crate) lit: Option<&'a wgpu::Buffer>,
    /// The inputs of the extraction. A single caster has none.
    pub(crate) kept: Option<&'a wgpu::Buffer>,
    /// [`ExtractionStatistics`](crate::layout::ExtractionStatistics) of all casters, if there is one for all.
    pub(crate) statistics: Option<BindingResource<'a>>,
    pub(crate) groups: Vec<GroupSource<'a>>,
}

/// Casters of one page of topology and one source of positions.
pub(crate) struct GroupSource<'a> {
    pub(crate) faces: &'a wgpu::Buffer,
    pub(crate) edge_vertices: &'a wgpu::Buffer,
    pub(crate) edge_faces: &'a wgpu::Buffer,
    pub(crate) positions: BindingResource<'a>,
    /// The boxes of the casters are known, with their rest positions.
    pub(crate) has_boxes: bool,
    pub(crate) batches: Vec<BatchSource<'a>>,
}

/// The results of an extraction for a batch of lights.
pub(crate) struct BatchSource<'a> {
    pub(crate) facing: BindingResource<'a>,
    pub(crate) excluded: BindingResource<'a>,
    pub(crate) silhouette_counts: BindingResource<'a>,
    pub(crate) silhouettes: BindingResource<'a>,
    /// [`ExtractionStatistics`](crate::layout::ExtractionStatistics) of these silhouettes.
    pub(crate) statistics: BindingResource<'a>,
    /// Pieces of L-twisted polygons, if there are polygons.
    pub(crate) pieces: Option<BindingResource<'a>>,
}
