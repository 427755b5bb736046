//! How many turns loops may have.

use std::collections::BTreeMap;

use rimline::internals::turns::{
    BOUND_CHUNKS, DEFORM_TERMS, ITEMS, LISTED_ITEMS, NEEDS_BOXES, POLYGON_TRIANGLES, QUERY_GROUPS, SCENE_ITEMS,
};

use super::Limits;

/// The turns after which llvmpipe ends the loops of an invocation.
pub const MOST_TURNS: u32 = 65_535;

/// The names that the comments above loops use, except constants of the WGSL. The first are shares: the CPU makes as many
/// workgroups as it takes that no invocation has more items, for any input. The others follow from the most that one binding of
/// llvmpipe holds, 128 MiB, and from its largest texture, 16,384 texels a side. Tests have such shares and bindings.
pub fn limits(lights: u32, exact_items: u32) -> Limits<'static> {
    BTreeMap::from([
        ("LIGHTS", lights.into()),
        ("EXACT_ITEMS", exact_items.into()),
        ("QUERY_GROUPS", QUERY_GROUPS.into()),
        ("ITEMS", ITEMS.into()),
        ("SCENE_ITEMS", SCENE_ITEMS.into()),
        ("LISTED_ITEMS", LISTED_ITEMS.into()),
        ("BOUND_CHUNKS", BOUND_CHUNKS.into()),
        ("DEFORM_TERMS", DEFORM_TERMS.into()),
        ("NEEDS_BOXES", NEEDS_BOXES as u64),
        ("POLYGON_TRIANGLES", POLYGON_TRIANGLES as u64),
        // Two thousand million edges in blocks of 256, which 256 invocations share.
        ("SCAN_BLOCKS", 32_000),
        // A light of a view has 512 bytes, and 32 of them share a word: half of this.
        ("BOUND_CHOICES", 1 << 14),
        // A caster has 128 bytes of the table, and 256 invocations share them.
        ("PENCIL_CASTERS", 1 << 12),
        // Each has half planes of 4 KiB.
        ("COUNT_BATCHES", 1 << 15),
        // From tiles of 8 pixels to one cell; all but the first, which 256 invocations share.
        ("RECEIVER_LEVELS", 12),
        ("RECEIVER_CELLS", 5500),
        // Tiles of 16 cells, and blocks of 2,048 cells.
        ("MAP_TILES", 1025 * 1025),
        ("MAP_BLOCKS", 1 << 17),
        ("NEAR_SAMPLES", 1 << 16),
        ("WALKER_TILES", 2),
        // Cells that the walks of a subgroup go over in all, for two tiles. They are each cell through which a contour goes,
        // once, and both ends of 16 walks that the lanes begin together.
        ("TILE_NODES", 2 * (256 + 32)),
        // Twelve for each cell: in a junction of four edges, a wall and a flap over the half segment to each edge, and four more
        // walls where surfaces end within walls.
        ("TILE_WALLS", 12 * 256),
        ("BOUNDARY_EDGES", 1024),
        // An invocation takes all edges and triangles of a small boundary, 32 of each, and 64 of them share those of a
        // large one: of 1,024 edges with 2,048 triangles 16 and 32. An edge has four turns and a triangle seven.
        ("CUT_ITEMS", 32 + 32),
        ("CUT_TESTS", 4 * 32 + 7 * 32),
    ])
}
