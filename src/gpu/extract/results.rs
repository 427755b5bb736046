//! Where the results lie.

/// The buffers that hold an extraction's results, all with usages `STORAGE`, `COPY_SRC` and `COPY_DST`. Light `l` is
/// bit `l mod 32` of word `l div 32`, least significant bit first; a batch of lights has buffers of its own.
#[derive(Clone, Copy, Debug)]
pub struct Results<'a> {
    /// `(a, b)` of each edge record: two `u32`.
    pub edge_vertices: &'a wgpu::Buffer,
    /// The faces of each edge record: two `u32`, see [`crate::mesh::EdgeRecords::packed_faces`].
    pub edge_faces: &'a wgpu::Buffer,
    /// A buffer a word: one `u32` facing mask a face. Empty for the per-edge method.
    pub facing: &'a [wgpu::Buffer],
    /// A buffer a word: a [`crate::layout::Masks`] an edge record. Empty unless asked for.
    pub masks: &'a [wgpu::Buffer],
    /// A buffer a word: for each of its lights [`Self::capacity`] entries of one `u32`, an edge record's index with the
    /// winding bit at bit 31. Entries from the light's count on hold nothing. Empty without lists.
    pub lists: &'a [wgpu::Buffer],
    /// Entries that each light's list has room for.
    pub capacity: u32,
    /// One `u32` a light, over all words: its silhouette edges. More than the capacity: the list overflowed.
    pub counts: &'a wgpu::Buffer,
    /// A [`crate::layout::DrawArguments`] a light, over all words; usage `INDIRECT` too. A list that overflowed is
    /// drawn over all edge records, see [`crate::gpu::include_wgsl`].
    pub draw_arguments: &'a wgpu::Buffer,
    /// One [`crate::layout::Statistics`].
    pub statistics: &'a wgpu::Buffer,
}
