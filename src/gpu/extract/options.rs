//! What an extractor finds and keeps.

use crate::method::{Method, Predicate};

/// What an [`Extractor`](crate::gpu::Extractor) finds and keeps.
#[derive(Clone, Copy, Debug)]
pub struct ExtractorOptions {
    /// The most lights of one encode, 1 to [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    pub max_lights: usize,
    /// How silhouettes are found; with the feature `reference` alone.
    #[cfg(feature = "reference")]
    pub method: Method,
    /// How a face's side is decided. The per-edge method of the feature `reference` is never exact.
    pub predicate: Predicate,
    /// Faces that the list of those the filter leaves undecided has room for. `None`: all of them, 4 bytes a face. A
    /// list that overflows loses nothing: every face then goes through the exact stage, which is slow.
    pub undecided_capacity: Option<u32>,
    /// Keep silhouette and winding masks of every edge record: 8 bytes an edge and batch of 32 lights.
    pub masks: bool,
    /// Make lists of silhouette edges; `None` for none.
    pub lists: Option<ListOptions>,
    /// Refuse, before anything is allocated, to take more bytes of device memory than this. wgpu tells no device's
    /// memory, so without it a mesh too large is found out by the device, and what was allocated is given back.
    pub memory_limit: Option<u64>,
}

impl Default for ExtractorOptions {
    /// One light, face masks, exact, lists, no edge masks, no memory limit.
    fn default() -> Self {
        Self {
            max_lights: 1,
            #[cfg(feature = "reference")]
            method: Method::FaceMask,
            predicate: Predicate::Exact,
            undecided_capacity: None,
            masks: false,
            lists: Some(ListOptions::default()),
            memory_limit: None,
        }
    }
}

impl ExtractorOptions {
    /// Face masks, unless the feature `reference` asks for something else.
    pub(crate) const fn method(&self) -> Method {
        #[cfg(feature = "reference")]
        return self.method;
        #[cfg(not(feature = "reference"))]
        Method::FaceMask
    }
}

/// How lists of silhouette edges are made.
#[derive(Clone, Copy, Debug)]
pub struct ListOptions {
    /// Entries that each light's list has room for, clamped to 1 … edge records. `None`: boundary and inconsistent
    /// edges, and of the others a share of four lists of all edges, at least sixteen times their square root. A list
    /// that overflows loses nothing: its draw goes over all edges, of which the include rejects what is no silhouette
    /// (by the facing masks; of the per-edge method, which has none, only the edge masks know), and
    /// [`crate::layout::Statistics`] counts it.
    pub capacity: Option<u32>,
    /// Lists in the order of the edges, the same in every run; costs the masks' memory traffic.
    pub ordered: bool,
    /// `vertex_count` of the draw arguments: 4 for a quad as a strip, 6 as two triangles, 2 for a line.
    pub vertices_per_edge: u32,
}

impl Default for ListOptions {
    /// Capacity by the mesh, unordered, 4 vertices an edge.
    fn default() -> Self {
        Self { capacity: None, ordered: false, vertices_per_edge: 4 }
    }
}
