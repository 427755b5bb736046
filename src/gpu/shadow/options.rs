//! How a caster casts.

/// How a caster casts.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct ShadowOptions {
    /// Every face casts, also of a closed mesh with light and near rectangle outside of its box, whose faces averted from
    /// the light suffice. Right, too, and slower. Needed for a closed caster that is not itself in the depth buffer, if
    /// surfaces within it are seen. NUMERICS.md, "Which faces cast".
    pub every_face: bool,
    /// Entries that each of a light's two lists of cap faces has room for. `None`: with z-fail, ZP+ as published and
    /// [`Self::end_at_range`] every face, else 1,024 and sixteen times the square root of the faces; but never more than
    /// fit one binding (8 bytes an entry for each of up to 32 lights, and 4 KiB a light for excluded faces) and [`Self::memory_limit`]. A list that overflows
    /// loses nothing: its draw goes over all faces.
    pub cap_capacity: Option<u32>,
    /// Skip the caster for lights whose shadow of it the camera cannot see.
    pub skip_unseen: bool,
    /// Volumes end beyond their light's range, at a sphere around the light (Bergeron 1986), instead of at infinity, but
    /// where ZP+ counts them or the light may be within the caster's box. Receivers out of range hold any count then: they
    /// must not be lit by that light. Less to fill; z-pass then draws dark caps, too.
    pub end_at_range: bool,
    /// Find what no stencil count of the caster exceeds, for [`ShadowStatistics::count_bound`] and
    /// [`ShadowStatistics::may_wrap`]: a pass over the silhouettes. Counts wrap exactly at 256, so a point in a multiple of
    /// 256 volumes at once appears lit. The casters' bounds add up.
    ///
    /// [`ShadowStatistics::count_bound`]: crate::layout::ShadowStatistics::count_bound
    /// [`ShadowStatistics::may_wrap`]: crate::layout::ShadowStatistics::may_wrap
    pub bound_counts: bool,
    /// As of [`crate::gpu::ExtractorOptions`].
    pub memory_limit: Option<u64>,
}

impl Default for ShadowOptions {
    /// Averted faces where they suffice, lists by the mesh, unseen shadows skipped, infinite volumes, no bound on counts, no memory
    /// limit.
    fn default() -> Self {
        Self {
            every_face: false,
            cap_capacity: None,
            skip_unseen: true,
            end_at_range: false,
            bound_counts: false,
            memory_limit: None,
        }
    }
}
