//! Options of a query of occluder counts.

/// The size and behaviour of a [`ShadowQuery`](crate::gpu::ShadowQuery).
#[derive(Clone, Copy, Debug)]
pub struct ShadowQueryOptions {
    /// The largest number of points in one encode.
    pub max_points: u32,
    /// The largest number of lights in one encode, 1 to [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    pub max_lights: usize,
    /// Skip ranges of 32 and of 1,024 faces if the segment from point to light misses their box. It never changes a
    /// depth. It makes the query faster if neighbours in the list of faces are neighbours in space.
    pub skip_by_boxes: bool,
    /// The approximate product of faces, points and lights in one dispatch. It bounds the time of a dispatch, because
    /// some systems reset a GPU that one dispatch keeps busy for seconds. The caller chooses how many dispatches one
    /// submission has.
    pub work_per_dispatch: u64,
    /// The largest device memory for the query, in bytes. `None`: no limit. It is checked before anything is allocated.
    pub memory_limit: Option<u64>,
}

impl Default for ShadowQueryOptions {
    /// 65,536 points, one light, skipping, 2²⁸ triples in a dispatch, no memory limit.
    fn default() -> Self {
        Self { max_points: 1 << 16, max_lights: 1, skip_by_boxes: true, work_per_dispatch: 1 << 28, memory_limit: None }
    }
}
