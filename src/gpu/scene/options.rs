//! Options of a scene.

use crate::method::Predicate;

/// The room that a [`Scene`](crate::gpu::Scene) has for lights and results.
#[derive(Clone, Copy, Debug)]
pub struct SceneOptions {
    /// The largest number of lights at a time, 1 to [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    pub max_lights: usize,
    /// How a face's side is decided.
    pub predicate: Predicate,
    /// Entries that the list of each light has room for, in each group of casters. `None`: room for all boundary and
    /// inconsistent edges, and for a share of the others. An overflow loses nothing: the draw then goes over all edges.
    pub list_capacity: Option<u32>,
    /// Faces that the list of undecided faces has room for, in each group of casters and batch of 32 lights. `None`: a
    /// quarter of them, and at least 4,096. An overflow loses nothing: every face then goes through the exact stage.
    pub undecided_capacity: Option<u32>,
    /// The largest device memory for the scene, in bytes. It is checked before anything is allocated. `None`: no limit.
    pub memory_limit: Option<u64>,
}

impl Default for SceneOptions {
    /// Up to 32 lights, the exact predicate, capacities from the meshes, no memory limit.
    fn default() -> Self {
        Self {
            max_lights: 32,
            predicate: Predicate::Exact,
            list_capacity: None,
            undecided_capacity: None,
            memory_limit: None,
        }
    }
}
