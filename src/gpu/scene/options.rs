//! Options of a scene.

use crate::method::Predicate;
use crate::shadow::Counting;

/// The room that a [`Scene`](crate::gpu::Scene) has for lights and results.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct SceneOptions {
    /// The largest number of lights at a time, 1 to [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    pub max_lights: usize,
    /// Entries that the list of each light has room for, in each group of casters. `None`: room for all boundary and
    /// inconsistent edges, and for a share of the others. An overflow loses nothing: the draw then goes over all edges.
    pub list_capacity: Option<u32>,
    /// Faces that the list of undecided faces has room for, in each group of casters and batch of 32 lights. `None`: a
    /// quarter of them, and at least 4,096. An overflow loses nothing: every face then goes through the exact stage.
    pub undecided_capacity: Option<u32>,
    /// How shadow volumes are counted. The [`ScenePipelines`](crate::gpu::ScenePipelines) that draw them must have the same.
    pub counting: Counting,
    /// Neither deform nor compute anything of a figure that a frame does not need. It takes effect where the caller asks
    /// ([`Scene::encode_needs`](crate::gpu::Scene::encode_needs)).
    pub skip_unneeded: bool,
    /// Skip a caster for a light where its box is proven to be hidden from the light by another caster's occluder
    /// ([`Scene::set_occluders`](crate::gpu::Scene::set_occluders)). Off by default: without occluders it does nothing, and they
    /// are promises.
    pub skip_occluded: bool,
    /// Leave out faces that other faces hide from a light ([`Scene::set_hidden_faces`](crate::gpu::Scene::set_hidden_faces)).
    pub skip_hidden_faces: bool,
    /// Volumes end beyond their light's range, instead of at infinity. See
    /// [`ShadowOptions::end_at_range`](crate::gpu::ShadowOptions::end_at_range).
    pub end_at_range: bool,
    /// The low bits of the stencil that counts own: [`ShadowFormat::count_bits`](crate::gpu::ShadowFormat::count_bits) of the
    /// pipelines that draw the scene. 1 to 8, and at least 2 with several [`Self::count_batches`]. The bits above are left as
    /// they are.
    pub count_bits: u32,
    /// Casters are counted in so many batches, each of which is then one bit of darkness. 0 is taken as 1. With several, 127
    /// casters of a batch may lie behind each other, instead of 255 in all, before a count wraps and a shadow looks lit; with b
    /// [`Self::count_bits`] these are 2 to the power of b − 1, and of b, less 1. Each batch takes a draw of all lists and a
    /// full-screen draw. Draw with [`ScenePipelines::in_batches`].
    ///
    /// [`ScenePipelines::in_batches`]: crate::gpu::ScenePipelines::in_batches
    pub count_batches: u32,
    /// Compute an upper bound of the stencil counts of all casters together, for
    /// [`ShadowStatistics::count_bound`](crate::gpu::ShadowStatistics::count_bound) and
    /// [`ShadowStatistics::may_wrap`](crate::gpu::ShadowStatistics::may_wrap). It takes three stages, and 4 KiB for each view,
    /// light and batch of casters.
    pub bound_counts: bool,
    /// Entries that the lists of near caps, and of other caps, of each light have room for, in each group of casters.
    /// `None`: room for every face where every face may have a cap, else for a share. An overflow loses nothing: the draw
    /// then goes over all faces.
    pub cap_capacity: Option<u32>,
    /// Meshes of at least so many faces are put in clusters of 128 faces that lie together. For a rigid caster, a cluster of
    /// which all faces are on one side of a light is decided as a whole. So on a smooth mesh about the root of all faces is
    /// tested. It takes about the time and a half of [`Mesh::new`](crate::Mesh::new) once more to add such a mesh, less than a
    /// byte a face of the device's memory, and 4 bytes a face of the host's. `None`: no mesh is. Clusters need
    /// [`Predicate::Exact`].
    pub clusters_from: Option<u32>,
    /// The largest device memory for the scene, in bytes. It is checked before anything is allocated. `None`: no limit.
    pub memory_limit: Option<u64>,
    /// Work that no picture needs, for measuring.
    #[doc(hidden)]
    pub measuring: Measuring,
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

    /// All levels of skipping are off.
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
    /// Up to 32 lights, capacities from the meshes, z-pass or ZP+ as the GPU chooses, unneeded deforming casters skipped, clusters
    /// from 4,096 faces on, infinite volumes, one batch of casters that is counted in all bits of the stencil, no bound on counts,
    /// no memory limit.
    fn default() -> Self {
        Self {
            max_lights: 32,
            list_capacity: None,
            undecided_capacity: None,
            counting: Counting::Auto,
            skip_unneeded: true,
            skip_occluded: false,
            skip_hidden_faces: true,
            end_at_range: false,
            count_bits: 8,
            count_batches: 1,
            bound_counts: false,
            cap_capacity: None,
            clusters_from: Some(4096),
            memory_limit: None,
            measuring: Measuring::default(),
        }
    }
}
