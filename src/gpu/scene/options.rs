//! Options of a scene.

use crate::method::Predicate;
use crate::shadow::Counting;

/// How a [`Scene`](crate::gpu::Scene) counts shadows, and its room for lights and results.
#[derive(Clone, Copy, Debug)]
pub struct SceneOptions {
    /// The largest number of lights at a time, 1 to [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    pub max_lights: usize,
    /// How shadow volumes are counted. The [`ShadowPipelines`](crate::gpu::ShadowPipelines) that draw them must have the same.
    pub counting: Counting,
    /// How counts use the stencil.
    pub stencil: StencilCounts,
    /// The room of lists.
    pub capacities: Capacities,
    /// Volumes end beyond their light's range, instead of at infinity. See
    /// docs/numerics/shadow-volumes.md, "Volumes that end".
    pub end_at_range: bool,
    /// Meshes of at least so many faces are put in clusters of 128 faces that lie together. For a rigid caster, a cluster of
    /// which all faces are on one side of a light is decided as a whole. So on a smooth mesh about the root of all faces is
    /// tested. It takes about the time and a half of [`Mesh::new`](crate::Mesh::new) once more to add such a mesh, less than a
    /// byte a face of the device's memory, and 4 bytes a face of the host's. `None`: no mesh is.
    pub clusters_from: Option<u32>,
    /// The largest device memory for the scene, in bytes. It is checked before anything is allocated. `None`: no limit.
    pub memory_limit: Option<u64>,
    /// Work that no picture needs, for measuring.
    #[doc(hidden)]
    pub measuring: Measuring,
}

/// Room for the entries of lists. Too little loses nothing, except for [`Self::pieces`]: the work then goes over all edges or
/// faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capacities {
    /// Entries that the list of each light has room for, in each group of casters. `None`: room for all boundary and
    /// inconsistent edges, and for a share of the others. After an overflow the draw goes over all edges.
    pub lists: Option<u32>,
    /// Faces that the list of undecided faces has room for, in each group of casters and batch of 32 lights. `None`: a
    /// quarter of them, and at least 4,096. After an overflow every face goes through the exact stage.
    pub undecided: Option<u32>,
    /// Entries that the lists of near caps, and of other caps, of each light have room for, in each group of casters.
    /// `None`: room for every face where every face may have a cap, else for a share. After an overflow the draw goes over
    /// all faces.
    pub caps: Option<u32>,
    /// Pieces of twisted polygons that the list of each light has room for, in each caster of polygons; each takes 36 bytes. A
    /// polygon is twisted if its loops cross themselves as seen from a light. A quadrilateral then has 6 pieces, a polygon with n
    /// edges at most n(n − 2). Room for more than there can be, or for more than one binding holds, is not made.
    ///
    /// `None`: the lights of a batch share room for 1,048,576, and each has one for each sixteenth edge besides. **Pieces
    /// without room are not drawn, and shadows are wrong.** [`ShadowStatistics::lost_pieces`] says whether there are any, and
    /// [`ShadowStatistics::most_pieces`] the room that loses none: give it to
    /// [`Scene::set_capacities`](crate::gpu::Scene::set_capacities).
    ///
    /// [`ShadowStatistics::lost_pieces`]: crate::gpu::ShadowStatistics::lost_pieces
    /// [`ShadowStatistics::most_pieces`]: crate::gpu::ShadowStatistics::most_pieces
    pub pieces: Option<u32>,
}

/// How the counts of a scene's shadow volumes use the stencil.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StencilCounts {
    /// The low bits of the stencil that counts own: [`ShadowFormat::count_bits`](crate::gpu::ShadowFormat::count_bits) of the
    /// pipelines that draw the scene. 1 to 8, and at least 2 with several [`Self::count_batches`]. The bits above are left as
    /// they are.
    pub count_bits: u32,
    /// Casters are counted in so many batches, each of which is then one bit of darkness. 0 is taken as 1. With several, 127
    /// casters of a batch may lie behind each other, instead of 255 in all, before a count wraps and a shadow looks lit; with b
    /// [`Self::count_bits`] these are 2 to the power of b − 1, and of b, less 1. Each batch takes a draw of all lists and a
    /// full-screen draw. Draw with [`ShadowPipelines::in_batches`].
    ///
    /// [`ShadowPipelines::in_batches`]: crate::gpu::ShadowPipelines::in_batches
    pub count_batches: u32,
    /// Compute an upper bound of the stencil counts of all casters together, for
    /// [`ShadowStatistics::count_bound`](crate::gpu::ShadowStatistics::count_bound) and
    /// [`ShadowStatistics::may_wrap`](crate::gpu::ShadowStatistics::may_wrap). It takes three stages, and 4 KiB for each view,
    /// light and batch of casters.
    pub bound_counts: bool,
}

impl Default for StencilCounts {
    /// One batch of casters that is counted in all bits of the stencil, no bound on counts.
    fn default() -> Self {
        Self { count_bits: 8, count_batches: 1, bound_counts: false }
    }
}

/// Work that a scene does although no picture needs it, and the predicate that it takes: for measuring and tests. It is not
/// covered by the promise of stability.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measuring(u32);

impl Measuring {
    /// Every face casts, also where back-facing ones suffice.
    pub const EVERY_FACE: Self = Self(1);
    /// Casters that a light's range or cone does not reach are computed and drawn.
    pub const UNREACHED: Self = Self(1 << 1);
    /// Volumes are drawn where the camera cannot see the shadow.
    pub const UNSEEN: Self = Self(1 << 2);
    /// Volumes are drawn where no receiver is in them.
    pub const WITHOUT_RECEIVERS: Self = Self(1 << 3);
    /// Facing bits and lists that did not change are computed again.
    pub const BITS: Self = Self(1 << 4);
    /// Lists for a view are made again, although nothing that they depend on changed.
    pub const LISTS: Self = Self(1 << 5);
    /// [`Predicate::Fast`] decides. Clusters need the exact one.
    pub const FAST: Self = Self(1 << 6);

    /// Casters that an occluder hides from a light are computed and drawn.
    pub const OCCLUDED: Self = Self(1 << 7);
    /// Hidden faces cast.
    pub const HIDDEN_FACES: Self = Self(1 << 8);
    /// Deforming casters that no view and no light needs are deformed and computed.
    pub const UNNEEDED: Self = Self(1 << 9);

    /// The levels of skipping that need nothing of the caller are off.
    pub const SKIP_NOTHING: Self =
        Self(Self::UNREACHED.0 | Self::UNSEEN.0 | Self::WITHOUT_RECEIVERS.0 | Self::BITS.0 | Self::LISTS.0);

    /// Sets or clears one of these.
    pub const fn set(&mut self, what: Self, on: bool) {
        self.0 = if on { self.0 | what.0 } else { self.0 & !what.0 };
    }

    pub(crate) const fn has(self, what: Self) -> bool {
        self.0 & what.0 != 0
    }
}

impl SceneOptions {
    /// How a face's side is decided.
    pub(crate) const fn predicate(&self) -> Predicate {
        if self.measuring.has(Measuring::FAST) { Predicate::Fast } else { Predicate::Exact }
    }
}

impl Default for SceneOptions {
    /// Up to 32 lights, z-pass or ZP+ as the GPU chooses, one batch of casters that is counted in all bits of the stencil,
    /// capacities from the meshes, infinite volumes, clusters from 4,096 faces on, no memory limit.
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
