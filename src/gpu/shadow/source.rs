//! The input of shadow volumes: the results of a scene's extraction.

use crate::gpu::common::bindings::Resource;

/// Resources by the names that stages and draws bind them by.
pub(crate) type Named<'a> = Vec<(&'static str, Resource<'a>)>;

/// The extraction of some casters. Sizes are those of [`VolumeSizes`](super::sizes::VolumeSizes).
pub(crate) struct VolumeSource<'a> {
    /// Casters, and room for a copy of what is chosen for them.
    pub(crate) table: &'a wgpu::Buffer,
    /// `relevant_lights`: for each batch and caster its relevant lights. `cache`: the inputs of the extraction.
    pub(crate) named: Named<'a>,
    pub(crate) groups: Vec<GroupSource<'a>>,
}

/// Casters of one page of topology and one source of positions.
pub(crate) struct GroupSource<'a> {
    /// `positions`, `faces`, `edge_vertices`, `edge_faces`.
    pub(crate) named: Named<'a>,
    /// The boxes of the casters are known, with their rest positions.
    pub(crate) has_boxes: bool,
    /// For each batch of lights the results: `facing_masks`, `excluded_masks`, `silhouette_counts`, `silhouettes`,
    /// `extraction_statistics`, and `pieces` if there are polygons.
    pub(crate) batches: Vec<Named<'a>>,
}

/// The resource of a name.
pub(crate) fn named<'a>(resources: &Named<'a>, name: &str) -> Option<Resource<'a>> {
    resources.iter().find(|(resource_name, _)| *resource_name == name).map(|(_, resource)| resource.clone())
}
