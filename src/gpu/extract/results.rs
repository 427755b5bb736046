//! The buffers of the results.

/// The buffers that hold the results of an extraction. All have usages `STORAGE`, `COPY_SRC` and `COPY_DST`. Light `l`
/// is bit `l mod 32`, least significant bit first, of batch `l div 32`. Each batch of lights has its own buffers.
#[derive(Clone, Copy, Debug)]
pub struct ExtractionResults<'a> {
    /// The vertices `(a, b)` of each edge record: two `u32`.
    pub edge_vertices: &'a wgpu::Buffer,
    /// The faces of each edge record: two `u32`. See [`crate::mesh::EdgeRecords::packed_faces`]. In a mesh of polygons, the
    /// first triangle of a polygon stands for it.
    pub edge_faces: &'a wgpu::Buffer,
    /// One buffer for each batch, with a facing mask for each face: one `u32`. Empty for the per-edge method. A mesh of
    /// polygons has one for each triangle, the same for all of a polygon. After these come as many masks of the lights for
    /// which the polygon is twisted. [`Polygons::masks_of`](crate::mesh::Polygons::masks_of) makes one a polygon of them.
    pub facing: &'a [wgpu::Buffer],
    /// One buffer for each batch, with an [`EdgeMasks`](crate::gpu::EdgeMasks) for each edge record. Empty unless
    /// requested.
    pub masks: &'a [wgpu::Buffer],
    /// One buffer for each batch, with [`Self::capacity`] entries for each of its lights. An entry is one `u32`: the
    /// index of an edge record, with the winding bit as bit 31. Entries past the light's count have no meaning. Empty
    /// without lists.
    pub lists: &'a [wgpu::Buffer],
    /// Entries that the list of each light has room for.
    pub capacity: u32,
    /// One `u32` for each light of all batches: the number of its silhouette edges. The list overflowed if it is more
    /// than the capacity.
    pub counts: &'a wgpu::Buffer,
    /// A [`DrawArguments`](crate::gpu::DrawArguments) for each light of all batches. Usage `INDIRECT`, too. The draw of
    /// a list that overflowed goes over all edge records, see [`crate::gpu::include_wgsl`].
    pub draw_arguments: &'a wgpu::Buffer,
    /// One [`ExtractionStatistics`](crate::gpu::ExtractionStatistics).
    pub statistics: &'a wgpu::Buffer,
}
