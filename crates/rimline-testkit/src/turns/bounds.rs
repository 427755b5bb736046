//! How many turns the loops of each entry point may have.

use std::collections::BTreeMap;

use rimline::internals::turns::{
    BOUND_CHUNKS, DEFORM_TERMS, ITEMS, LISTED_ITEMS, NEEDS_BOXES, POLYGON_TRIANGLES, QUERY_GROUPS, SCENE_ITEMS,
};

use super::Limits;

/// The turns after which llvmpipe ends the loops of an invocation.
pub const MOST_TURNS: u32 = 65_535;

/// The names that the comments above loops use, except constants of the WGSL. The names of sizes follow from the most that
/// one binding of llvmpipe holds, 128 MiB, and from its largest texture, 16,384 texels a side.
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
        // A light of a view has 64 bytes at least, and 32 of them share a place.
        ("BOUND_PLACES", 1 << 14),
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
        ("TILE_WALLS", 2048),
        ("BOUNDARY_EDGES", 1024),
        // An invocation takes all edges and triangles of a small boundary, 32 of each, and 64 of them share those of a
        // large one: of 1,024 edges with 2,048 triangles 16 and 32. An edge has four turns and a triangle seven.
        ("CUT_ITEMS", 32 + 32),
        ("CUT_TESTS", 4 * 32 + 7 * 32),
    ])
}

/// For each entry point with loops, by its module, the turns that these have at most.
///
/// Why no input has more. "By shares": the CPU makes as many workgroups as it takes that no invocation has more items than
/// the constant says, for any input; all other loops have their bounds in their heads. "By a binding": the items lie
/// in one binding, of 128 MiB with llvmpipe.
///
/// * `compact_count`, `compact_scatter`: 356 at most, 1/184 of the limit: an invocation has one edge, and a block has 256.
/// * `compact_scan`: by a binding. Edges of 8 bytes in the largest buffer of WebGPU's default limits, 256 MiB, are 512
///   blocks an invocation and 1,044 turns, 1/62 of the limit. The bound is for 2³¹ edges. A test has as many blocks.
/// * `cull_lights`: one pair of caster and light batch an invocation; 128 occluders, of 8 corners, are tried for 32
///   lights. A test has a caster that the last of them hides.
/// * `clusters`, `chunks`: by shares of 96 chunks, 1/5 of the limit.
/// * `bounds`: by shares of 128 chunks of 64 faces, and by a binding: 8,192 views and batches of `ViewLight`. Tests have
///   both, and twice as many views.
/// * `counting_methods`: by shares of 128 pairs, 1/4 of the limit. No pair goes beyond the most workgroups along an
///   axis: these would take 537 million, and a table in one binding has no more than 84 million.
/// * `caps`: by shares of 128 faces, or of 128 runs of 8, with 32 lights.
/// * `list_sides`, `stencil_crossings`: by shares of 4,096 edges or sides. No list of sides has more entries than there are
///   edges.
/// * `stencil_pencil`: by a binding: 838,860 casters with their choices, 3,277 an invocation.
/// * `stencil_bound`: by a binding: 32,640 rows, of all lights and views. Scenes have 32 lights or more, so 16 batches an
///   invocation and 1,100 turns, 1/59 of the limit. A test has one light.
/// * `depth_metric`, `depth_merge`, `depth_cube`, `depth_edges_continue`, `depth_surface`, `contour_marks`: one texel, word
///   or vertex an invocation, 1/282 of the limit or less. `depth_near`, `depth_near_walls`: a box of 65,536 samples that 256
///   invocations share, 1/255.
/// * `depth_edges_mark`: one strip of 64 samples an invocation, with 128 edges that integers decide at two levels.
///   `depth_cells_count`: by shares of 4 blocks, with 100 such edges each, or of 128 blocks where floats decide. Tests have
///   maps all of whose edges are open.
/// * `depth_edges_count`, `depth_cells_list`: by shares of 128 blocks, 1/42 and 1/4 of the limit. `depth_cells_scan`: by the
///   largest texture, of 16,384² texels: 513 blocks an invocation, 1/63.
/// * `contour_tiles_find`: one tile of 16 rows an invocation, 1/3,276 of the limit. `contour_crossings`: one row of a
///   tile, 1/3. `contour_walls_trace`: two tiles, which a test fills with spirals. `contour_tiles_list`,
///   `contour_walls_scan`: by a binding. Places of 4 bytes are those of 5,790² texels: 513 tiles an invocation, 1/57
///   and 1/11.
pub const TURNS: &[(&str, &str, u32)] = &[
    ("needs", "needs", 63_755),
    ("deform", "deform", 60_002),
    ("facing", "facing", 9),
    ("exact_facing", "exact_facing", 59_406),
    ("polygon_facing", "polygon_facing", 2_058),
    ("polygon_turns", "polygon_turns", 43_625),
    ("polygon_pairs", "polygon_pairs", 32_876),
    ("polygon_masks", "polygon_masks", 34_898),
    ("edges", "edges", 66),
    ("cut_edges", "cut_edges", 58_408),
    ("cut_edges", "cut_edges_rank", 59_530),
    ("cut_edges", "cut_edges_before", 1_315),
    ("cut_edges", "cut_edges_list", 46),
    ("cut_quads", "cut_quads", 1_328),
    ("per_edge", "per_edge", 60),
    ("compact", "compact_count", 42),
    ("compact", "compact_scan", 64_016),
    ("compact", "compact_scatter", 355),
    ("arguments", "arguments", 17),
    ("cull_lights", "cull_lights", 41_715),
    ("clusters", "clusters", 13_157),
    ("chunks", "chunks", 12_482),
    ("scene_facing", "facing", 58_085),
    ("scene_exact_facing", "exact_facing", 59_476),
    ("scene_edges", "edges", 51_844),
    ("receiver_depth", "receiver_depth", 4_251),
    ("receiver_samples", "receiver_depth", 4_251),
    ("receiver_pyramid", "receiver_pyramid", 5_661),
    ("relist", "relist", 5),
    ("bounds", "bounds", 37_770),
    ("counting_methods", "counting_methods", 14_734),
    ("zp_plus_2005_cases", "zp_plus_2005_cases", 4_097),
    ("caps", "caps", 40_074),
    ("list_sides", "list_sides", 16_386),
    ("stencil_pencil", "stencil_pencil", 61_454),
    ("stencil_crossings", "stencil_crossings", 53_252),
    ("piece_crossings", "piece_crossings", 36_871),
    ("stencil_bound", "stencil_bound", 33_794),
    ("sides", "side", 85),
    ("sides", "side_clipped", 86),
    ("cap_faces", "seen_light_cap", 86),
    ("cap_faces", "dark_cap", 84),
    ("cap_faces", "near_cap", 86),
    ("piece_volumes", "piece_side", 85),
    ("piece_volumes", "piece_side_clipped", 86),
    ("piece_volumes", "piece_near_cap", 86),
    ("piece_volumes", "piece_light_cap", 86),
    ("piece_volumes", "piece_dark_cap", 84),
    ("outline_edges", "outline_silhouette", 6),
    ("outline_edges", "outline_feature", 12),
    ("outline_edges", "outline_ink", 3),
    ("scene_outline_edges", "outline_silhouette", 6),
    ("scene_outline_edges", "outline_feature", 12),
    ("scene_outline_edges", "outline_ink", 3),
    ("shadow_masks", "mask_share", 65),
    ("shadow_boxes", "shadow_boxes", 65),
    ("shadow_depth", "shadow_depth", 33_824),
    ("exact_shadow_depth", "exact_shadow_depth", 2_480),
    ("exact_shadow_depth", "exact_shadow_depth_recount", 13_205),
    ("depth_near", "depth_near", 257),
    ("depth_near_walls", "depth_near_walls", 257),
    ("depth_metric", "depth_metric", 2),
    ("depth_merge", "depth_merge", 2),
    ("depth_cube", "depth_cube", 10),
    ("depth_edges", "depth_edges_mark", 60_747),
    ("depth_edges", "depth_edges_continue", 40),
    ("depth_edges", "depth_edges_count", 1_539),
    ("depth_cells", "depth_cells_count", 55_069),
    ("depth_cells", "depth_cells_scan", 1_035),
    ("depth_cells", "depth_cells_list", 16_134),
    ("contour_marks", "contour_marks", 232),
    ("contour_tiles", "contour_tiles_find", 20),
    ("contour_tiles", "contour_tiles_list", 8_222),
    ("contour_crossings", "contour_crossings", 17_012),
    ("contour_walls", "contour_walls_trace", 49_935),
    ("contour_walls", "contour_walls_scan", 45_156),
    ("depth_surface", "depth_surface", 31),
    ("depth_surface", "depth_near_cap_fragment", 83),
    ("depth_walls", "depth_walls_near_cap_fragment", 8_477),
];
