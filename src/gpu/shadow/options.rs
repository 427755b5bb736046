//! Options of a caster's shadow volumes.

use super::pipelines::Convention;
use crate::gpu::scene::options::{Capacities, Measuring, SceneOptions, StencilCounts};

/// Options of a caster's shadow volumes.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct ShadowOptions {
    /// Every face casts, always. Without this option a closed mesh casts only by its averted faces if light and near
    /// rectangle are outside its box, which is faster and right, too. See docs/numerics/casting-faces.md, "Which faces cast".
    pub every_face: bool,
    /// Whether the caster's surface is in the depth buffer that shadows are drawn against. False for a proxy, a simpler mesh
    /// in place of what is drawn: every face of it casts, and z-pass and ZP+ draw light caps, too. Receivers that lie
    /// in its faces exactly may be lit or not.
    pub in_depth: bool,
    /// Entries that each of the two lists of cap faces of a light has room for. `None`: every face with z-fail, ZP+ as
    /// published, [`Self::end_at_range`] or without [`Self::in_depth`]; else 1,024 and sixteen times the square root of the
    /// faces. The lists always fit one binding (8 bytes an entry for each of up to 32 lights, and up to 4 KiB a light for
    /// excluded faces) and [`Self::memory_limit`]. An overflow loses nothing: the draw then goes over all faces.
    pub cap_capacity: Option<u32>,
    /// Skip the caster for a light if the camera cannot see its shadow.
    pub skip_unseen: bool,
    /// Volumes end beyond their light's range, at a sphere around the light (Bergeron 1986), instead of at infinity.
    /// This does not apply to volumes that ZP+ counts, nor where the light may be in the caster's box. Receivers out of
    /// range may have any count; do not light them by this light. There are fewer pixels to fill, but z-pass also draws
    /// dark caps.
    pub end_at_range: bool,
    /// Compute an upper bound of the caster's stencil counts, for [`ShadowStatistics::count_bound`] and
    /// [`ShadowStatistics::may_wrap`]. It takes a pass over the silhouettes. Counts wrap at 256, or earlier with fewer
    /// [`ShadowFormat::count_bits`](crate::gpu::ShadowFormat::count_bits), so a point in a multiple of 256 volumes looks lit. Add
    /// the bounds of all casters; a [`Scene`](crate::gpu::Scene) bounds their sum.
    ///
    /// [`ShadowStatistics::count_bound`]: crate::layout::ShadowStatistics::count_bound
    /// [`ShadowStatistics::may_wrap`]: crate::layout::ShadowStatistics::may_wrap
    pub bound_counts: bool,
    /// The largest device memory for the volumes, in bytes. `None`: no limit. See [`crate::gpu::ExtractorOptions`].
    pub memory_limit: Option<u64>,
}

impl Default for ShadowOptions {
    /// Averted faces where they suffice, a caster in the depth buffer, list sizes from the mesh, unseen shadows skipped, infinite
    /// volumes, no bound on counts, no memory limit.
    fn default() -> Self {
        Self {
            every_face: false,
            in_depth: true,
            cap_capacity: None,
            skip_unseen: true,
            end_at_range: false,
            bound_counts: false,
            memory_limit: None,
        }
    }
}

impl ShadowOptions {
    /// The options of a scene of one caster, which makes its lists anew for each camera.
    pub(super) fn of_scene(&self, pipelines: Convention) -> SceneOptions {
        let &Self { every_face, in_depth: _, cap_capacity, skip_unseen, end_at_range, bound_counts, memory_limit } =
            self;
        let Convention { counting, count_bits, .. } = pipelines;
        let mut measuring = Measuring::LISTS;
        measuring.set(Measuring::EVERY_FACE, every_face);
        measuring.set(Measuring::UNSEEN, !skip_unseen);
        SceneOptions {
            counting,
            end_at_range,
            stencil: StencilCounts { count_bits, bound_counts, ..StencilCounts::default() },
            capacities: Capacities { caps: cap_capacity, ..Capacities::default() },
            memory_limit,
            measuring,
            ..SceneOptions::default()
        }
    }
}
