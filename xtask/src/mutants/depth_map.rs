//! Wrong changes to volumes from depth maps, in shader and twin alike where both have it.

use super::list::Mutation;

const LISTS: &[&str] = &["--test depth_map_cpu"];
const PICTURES: &[&str] = &["--test depth_map_gpu parity", "--test depth_map_gpu shadows"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "depth maps: a difference as large as the threshold is marked",
        changes: &[
            ("wgsl/depth_map/edge_code.wgsl", "return own > high;", "return own > high || (own == high && low == 0u);"),
            ("src/cpu/depth_map/edge_code.rs", "units(large) > units(small)", "units(large) >= units(small)"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: NaN casts",
        changes: &[
            ("wgsl/depth_map/samples.wgsl", "if (size > 0x7f800000u) {", "if (size > 0xff800000u) {"),
            (
                "src/cpu/depth_map/samples.rs",
                "depth if depth.is_nan() => return Key::Far,",
                "depth if depth.is_nan() => 0.0,",
            ),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: a triangle at one marked edge is left out",
        changes: &[
            (
                "wgsl/depth_map/edge_code.wgsl",
                "let first = select(3u, 9u, is_split);",
                "let first = select(2u, 9u, is_split);",
            ),
            ("src/cpu/depth_map/edge_code.rs", "[top || right, bottom || left]", "[right, bottom || left || top]"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: cells are split across the smaller difference",
        changes: &[
            (
                "wgsl/depth_map/edge_code.wgsl",
                "key_distance(keys.x, keys.w) > key_distance(keys.y, keys.z)",
                "key_distance(keys.x, keys.w) < key_distance(keys.y, keys.z)",
            ),
            ("src/cpu/depth_map/edge_code.rs", "distance(a, d) > distance(b, c)", "distance(a, d) < distance(b, c)"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: an edge of nothing is compared like others",
        changes: &[
            ("wgsl/depth_map/edge_code.wgsl", "    return a != b;", "    return false;"),
            ("src/cpu/depth_map/edge_code.rs", "        _ => true,\n", "        _ => false,\n"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: far samples are at the far plane",
        changes: &[(
            "wgsl/depth_map/depth_surface.wgsl",
            "  if (key == FAR_KEY) {\n    return views[0].far_across",
            "  if (key == FAR_KEY && views[0].infinity.w > 1.0) {\n    return views[0].far_across",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: no near cap",
        changes: &[("src/gpu/depth_map/frame.rs", "pass.draw(0..3, 0..1);", "pass.draw(0..0, 0..1);")],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: near caps take the other triangle of a cell",
        changes: &[(
            "wgsl/depth_map/depth_surface.wgsl",
            "let is_split = (entry & SPLIT) != 0u;",
            "let is_split = (entry & SPLIT) == 0u;",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: a list that overflows is drawn as it is",
        changes: &[("wgsl/depth_map/depth_surface.wgsl", "if (cells[0] > depth_map.capacity) {", "if (false) {")],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: the boundary moves towards the light",
        changes: &[(
            "wgsl/depth_map/depth_surface.wgsl",
            "return depth + select(offset, -offset, is_reversed);",
            "return depth - select(offset, -offset, is_reversed);",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: the boundary is not moved with its slope",
        changes: &[("src/gpu/depth_map/view.rs", "bias: [0.5 * slope_bias,", "bias: [0.0 * slope_bias,")],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: the boundary is not moved for the map's precision",
        changes: &[("src/gpu/depth_map/view.rs", "share, constant, 0.0],", "0.0 * share, 0.0 * constant, 0.0],")],
        tests: PICTURES,
    },
];
