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
    /// How a face's side is decided.
    pub predicate: Predicate,
    /// Faces that the list of undecided faces has room for. `None`: all faces, at 4 bytes each. An overflow loses
    /// nothing: every face then goes through the exact stage, which is slow.
    pub undecided_capacity: Option<u32>,
    /// Keep the silhouette and winding masks of every edge record. They take 8 bytes for each edge and batch of 32
    /// lights.
    pub masks: bool,
    /// The lists of silhouette edges. `None`: no lists.
    pub lists: Option<ListOptions>,
    /// The largest device memory for the extractor, in bytes. It is checked before anything is allocated. `None`: no limit.
    /// wgpu has no function for the memory of a device, so only the device detects then that a mesh is too large. Buffers
    /// allocated before that are freed.
    pub memory_limit: Option<u64>,
    /// With lists, find what only the shadow volumes of a scene read, too: which faces have a light in their plane, and the
    /// pieces of twisted polygons. For tests. It is not covered by the promise of stability.
    #[doc(hidden)]
    pub for_volumes: bool,
}

impl Default for ExtractorOptions {
    /// One light, face masks, the exact predicate, lists, no edge masks, no memory limit.
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
    /// Whether it finds what volumes read.
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
    /// Entries that the list of each light has room for, from 1 to the number of edge records. `None`: room for all
    /// boundary and inconsistent edges, and for a share of the others. All lights together have room for four times the
    /// others, and each light for at least sixteen times their square root.
    ///
    /// An overflow loses nothing: the draw then goes over all edges, and the include rejects those that are no
    /// silhouette. It uses the facing masks for this. The per-edge method has none, so only the edge masks decide there.
    /// [`ExtractionStatistics`](crate::gpu::ExtractionStatistics) counts overflows.
    pub capacity: Option<u32>,
    /// Whether lists have the order of the edges, which is the same in every run. It costs the memory traffic of the
    /// masks.
    pub ordered: bool,
    /// The primitives of each edge in the light's draw.
    pub topology: EdgeTopology,
}

/// The primitives that draw an edge: a quad or a line. It sets the `vertex_count` of the draw arguments, and
/// [`Self::primitive_topology`] is for the pipeline that draws them. The include's `rimline_corner` and `rimline_edge_vertex`
/// take the vertices of each.
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
