//! Options of an extractor.

use crate::method::{Method, Predicate};

/// The largest number of edges of a polygon's boundary that extractors take. The work grows with its square.
pub const MAX_BOUNDARY_EDGES: usize = 1024;

/// The size of an [`Extractor`](crate::gpu::Extractor), and the results that it finds and keeps.
#[derive(Clone, Copy, Debug)]
pub struct ExtractorOptions {
    /// The largest number of lights in one encode, 1 to [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    pub max_lights: usize,
    /// The method that finds silhouettes.
    #[doc(hidden)]
    pub method: Method,
    /// How the facing of a face is decided: exactly, or in `f32` alone.
    pub predicate: Predicate,
    /// Faces that the list of undecided faces has room for. `None`: all faces, at 4 bytes each. An overflow loses
    /// nothing: every face then goes through the exact stage, which is slow.
    pub undecided_capacity: Option<u32>,
    /// Keep the silhouette and winding masks of every edge record. They take 8 bytes for each edge and batch of 32
    /// lights. Facing masks do not depend on it.
    pub masks: bool,
    /// The lists of silhouette edges. `None`: no lists.
    pub lists: Option<ListOptions>,
    /// The largest device memory for the extractor, in bytes, checked before anything is allocated. Default: `None`, no
    /// limit: a mesh that is too large fails only when the device refuses a buffer, and buffers allocated before are
    /// freed. Set it if you know the memory of the device, which wgpu cannot ask.
    pub memory_limit: Option<u64>,
    /// With lists, also find which faces have a light in their plane, and the pieces of twisted polygons. Only shadow
    /// volumes read these. Scenes find them in buffers of their own, so only tests and measurements set it. It may change in any
    /// release.
    #[doc(hidden)]
    pub for_volumes: bool,
}

impl Default for ExtractorOptions {
    /// One light, the exact predicate, room for all undecided faces, unordered lists, no masks of edges, no memory limit.
    fn default() -> Self {
        Self {
            max_lights: 1,
            method: Method::FaceMask,
            predicate: Predicate::Exact,
            undecided_capacity: None,
            masks: false,
            lists: Some(ListOptions::default()),
            memory_limit: None,
            for_volumes: false,
        }
    }
}

impl ExtractorOptions {
    /// Whether the extractor finds what only shadow volumes read.
    pub(crate) const fn is_for_volumes(&self) -> bool {
        self.for_volumes && self.lists.is_some()
    }

    /// Whether lists have the order of the edges.
    pub(crate) fn is_ordered(&self) -> bool {
        self.lists.is_some_and(|lists| lists.ordered)
    }
}

/// Options of the lists of silhouette edges.
#[derive(Clone, Copy, Debug)]
pub struct ListOptions {
    /// Entries that the list of each light has room for, clamped to 1 … edge records. Default: `None`, room for all
    /// boundary and inconsistent edges, and of `n` consistent ones for the largest of `4n / max_lights`, `16 √n` and
    /// 1,024, as far as one binding holds them. After an overflow, which
    /// [`ExtractionStatistics`](crate::gpu::ExtractionStatistics) counts, the draw goes over all edges, and the WGSL of
    /// [`include_wgsl`](crate::gpu::include_wgsl) rejects by the facing masks those that are no silhouette. The per-edge
    /// method has no facing masks, so there only [`ExtractorOptions::masks`] tell.
    pub capacity: Option<u32>,
    /// Whether lists have the order of the edges, which is the same in every run. Such lists are made from
    /// silhouette and winding masks: they cost the memory traffic of the masks, and 8 bytes for each edge if masks are not
    /// kept.
    pub ordered: bool,
    /// The primitives of each edge in the light's draw.
    pub topology: EdgeTopology,
}

/// The primitives that draw an edge: a quad or a line. It sets the `vertex_count` of the draw arguments, and
/// [`Self::primitive_topology`] is for the pipeline that draws them. The include's `rimline_corner` and
/// `rimline_edge_vertex` take the vertices of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EdgeTopology {
    /// A quad, as a strip of four vertices.
    #[default]
    TriangleStrip,
    /// A quad, as two triangles of six vertices.
    TriangleList,
    /// A line of two vertices.
    LineList,
}

impl EdgeTopology {
    /// The vertices of each edge.
    pub const fn vertices(self) -> u32 {
        match self {
            Self::TriangleStrip => 4,
            Self::TriangleList => 6,
            Self::LineList => 2,
        }
    }

    /// The topology of a pipeline that draws the edges.
    pub const fn primitive_topology(self) -> wgpu::PrimitiveTopology {
        match self {
            Self::TriangleStrip => wgpu::PrimitiveTopology::TriangleStrip,
            Self::TriangleList => wgpu::PrimitiveTopology::TriangleList,
            Self::LineList => wgpu::PrimitiveTopology::LineList,
        }
    }
}

impl Default for ListOptions {
    /// Capacity from the mesh, unordered, a strip of four vertices for each edge.
    fn default() -> Self {
        Self { capacity: None, ordered: false, topology: EdgeTopology::TriangleStrip }
    }
}
