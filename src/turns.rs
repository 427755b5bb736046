//! Most items that an invocation takes in turn, so that its loops end. llvmpipe silently ends all loops of an
//! invocation after 65,535 turns together, and drivers stop what runs long. docs/numerics/loops.md says how turns
//! count. The head of a loop says how many it has, or a comment above it, and a test adds them up: a new loop without
//! either, or one above the bound, fails it.

/// Groups of 1,024 faces that one dispatch of a query goes over at most. With 31, a word also has a bit for each and one more.
pub const QUERY_GROUPS: u32 = 31;
/// Items that an invocation takes in turn at most, where each takes few turns.
pub const ITEMS: u32 = 128;
/// The same for chunks of the casters of a scene, where masks are put together light by light.
pub const SCENE_ITEMS: u32 = 96;
/// Sides, edges or pieces that an invocation takes in turn at most.
pub const LISTED_ITEMS: u32 = 4096;
/// Chunks of faces that an invocation of `bounds` takes in turn at most.
pub const BOUND_CHUNKS: u32 = 128;
/// Undecided faces that an invocation of exact facing takes in turn at most, of a single mesh with 32 lights.
pub const EXACT_ITEMS: u32 = 44;
/// Morph targets and influences of a vertex together. The displacement has the remaining turns.
pub const DEFORM_TERMS: u32 = 60_000;
/// Boxes that an invocation of `needs` tests at most: for each view the caster's, and for each of its lights the volume's.
pub const NEEDS_BOXES: usize = 2500;
/// Triangles of a polygon that is extracted on the GPU.
pub const POLYGON_TRIANGLES: usize = 2048;

/// Undecided faces that an invocation of exact facing takes in turn at most, of a scene with `lights` lights in a batch.
/// Each has about 42 turns for each light, and 40 others.
pub fn scene_exact_items(lights: u32) -> u32 {
    (60_000 / (50 + 45 * lights.clamp(1, 32))).min(400)
}
