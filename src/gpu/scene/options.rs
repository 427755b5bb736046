//! Options of a scene.

use crate::shadow::Counting;

/// Counting method and capacities of a [`Scene`](crate::gpu::Scene).
#[derive(Clone, Copy, Debug)]
pub struct SceneOptions {
    /// The largest number of lights at a time, 1 to [`MAX_LIGHTS`](crate::MAX_LIGHTS). Default: 32.
    pub max_lights: usize,
    /// The counting method. The [`ShadowPipelines`](crate::gpu::ShadowPipelines) that draw volumes must have the same.
    /// Default: [`Counting::Auto`].
    pub counting: Counting,
    /// The use of the stencil. Default: one batch of casters, all 8 bits, no bound.
    pub stencil: StencilCounts,
    /// Room for the entries of lists. Default: from the meshes.
    pub capacities: Capacities,
    /// Whether volumes, but those that ZP+ counts, end beyond their light's range instead of at infinity. Set it if ranges are
    /// short against the view: fewer pixels are counted. Default: false. See docs/numerics/shadow-volumes.md, "Volumes that
    /// end".
    pub end_at_range: bool,
    /// Meshes of triangles with at least this many faces get clusters of 128 neighbouring faces. Default: 4,096; `None`:
    /// never. A rigid caster decides a cluster as a whole if all its faces have one side to a light, so a smooth mesh tests
    /// about the root of its faces. Adding such a mesh takes another 1.5 times as long as
    /// [`Mesh::new`](crate::Mesh::new), less than a byte a face of device memory, and 4 bytes a face of host memory.
    pub clusters_from: Option<u32>,
    /// The largest device memory for the scene, in bytes, checked before each allocation. Removed meshes of polygons, and the
    /// positions of removed models, count until the next encode. The room of other removed meshes always counts, and later
    /// meshes take it. Default: `None`, no limit.
    pub memory_limit: Option<u64>,
    /// Work that no picture needs, for measuring.
    #[doc(hidden)]
    pub measuring: Measuring,
}

/// Room for the entries of lists. After an overflow a stage or draw processes all edges or faces, so nothing is lost,
/// except for [`Self::pieces`].
///
/// A polygon is twisted if, as seen from a light, its boundary crosses itself or goes around the light, or a hole is
/// outside. It is then drawn in pieces of 36 bytes each: 6 of a quadrilateral, and at most n(n − 2) of a polygon with n
/// edges. By default 131,072 twisted quadrilaterals lose none with one light, and 4,096 with 32 lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capacities {
    /// Entries of the edge list of each light, in each group of casters. `None`: all boundary and inconsistent edges, and a
    /// share of the others.
    pub lists: Option<u32>,
    /// Entries of the list of undecided faces, in each group of casters and batch of 32 lights. `None`: a quarter of the
    /// faces, and at least 4,096 or all. Casters of polygons ignore it.
    pub undecided: Option<u32>,
    /// Entries of the list of near caps, and of that of other caps, of each light, in each group of casters and view. `None`:
    /// every face if every face may have a cap, else a share, and fewer where memory is short.
    pub caps: Option<u32>,
    /// Pieces of twisted polygons of each light, in each caster of polygons: never more than there can be, or than fit
    /// one binding. Default: `None`, the lights of a batch share 1,048,576, and each has one more for each sixteenth
    /// edge. **Pieces without room are not drawn, and shadows are wrong.** If [`ShadowStatistics::lost_pieces`] is not
    /// 0, give [`ShadowStatistics::most_pieces`] to [`Scene::set_capacities`](crate::gpu::Scene::set_capacities): it
    /// loses none.
    ///
    /// [`ShadowStatistics::lost_pieces`]: crate::gpu::ShadowStatistics::lost_pieces
    /// [`ShadowStatistics::most_pieces`]: crate::gpu::ShadowStatistics::most_pieces
    pub pieces: Option<u32>,
}

/// The use of the stencil by the counts of a scene's shadow volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StencilCounts {
    /// The number of low stencil bits for counts, as in [`ShadowFormat::count_bits`](crate::gpu::ShadowFormat::count_bits)
    /// of the pipelines that draw the scene: 1 to 8, and at least 2 with several [`Self::count_batches`]. The other bits do
    /// not change. Default: 8.
    pub count_bits: u32,
    /// The number of batches in which casters are counted, one after the other, for
    /// [`ShadowPipelines::in_batches`](crate::gpu::ShadowPipelines::in_batches). Default: 1; 0 means 1. A count wraps,
    /// and a shadow may look lit, if more than 2 to the power of b, less 1, casting faces lie behind each other, with b
    /// [`Self::count_bits`]; with several batches, more than 2 to the power of b − 1, less 1, of one batch.
    /// Each batch takes a draw of all lists and each but the first a full-screen draw.
    pub count_batches: u32,
    /// Whether to compute an upper bound of the stencil counts of all casters of a batch together, for
    /// [`ShadowStatistics::count_bound`](crate::gpu::ShadowStatistics::count_bound) and
    /// [`ShadowStatistics::may_wrap`](crate::gpu::ShadowStatistics::may_wrap). It takes three or four stages, and 4 KiB for
    /// each view, light and batch of casters. Default: false.
    pub bound_counts: bool,
}

impl Default for StencilCounts {
    fn default() -> Self {
        Self { count_bits: 8, count_batches: 1, bound_counts: false }
    }
}

/// Work that a scene does although no image needs it: for measuring and tests. It may change in any release.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measuring(u32);

impl Measuring {
    /// Every face casts, even if the back-facing ones suffice.
    pub const EVERY_FACE: Self = Self(1);
    /// Casters out of a light's range or cone.
    pub const CULLED_BY_RANGE: Self = Self(1 << 1);
    /// Volumes whose shadow the camera cannot see.
    pub const CULLED_BY_VIEW: Self = Self(1 << 2);
    /// Volumes without a receiver.
    pub const CULLED_BY_RECEIVERS: Self = Self(1 << 3);
    /// Facing bits and lists that did not change.
    pub const CACHED_BITS: Self = Self(1 << 4);
    /// Lists of views that did not change.
    pub const CACHED_LISTS: Self = Self(1 << 5);
    /// Casters behind an occluder.
    pub const CULLED_BY_OCCLUDERS: Self = Self(1 << 6);
    /// Deforming casters that the frame does not need.
    pub const CULLED_CASTERS: Self = Self(1 << 7);

    /// Everything that is culled or cached without a call of the caller, but for [`Self::CULLED_CASTERS`].
    pub const CULL_NOTHING: Self = Self(
        Self::CULLED_BY_RANGE.0
            | Self::CULLED_BY_VIEW.0
            | Self::CULLED_BY_RECEIVERS.0
            | Self::CACHED_BITS.0
            | Self::CACHED_LISTS.0,
    );

    /// Sets or clears one of these.
    pub const fn set(&mut self, what: Self, on: bool) {
        self.0 = if on { self.0 | what.0 } else { self.0 & !what.0 };
    }

    pub(crate) const fn has(self, what: Self) -> bool {
        self.0 & what.0 != 0
    }
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            max_lights: 32,
            counting: Counting::Auto,
            stencil: StencilCounts::default(),
            capacities: Capacities::default(),
            end_at_range: false,
            clusters_from: Some(4096),
            memory_limit: None,
            measuring: Measuring::default(),
        }
    }
}
