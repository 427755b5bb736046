//! Wrong changes to where volumes from depth maps are: their vertices, moves and near places.

use super::list::Mutation;

const VERTICES: &[&str] = &["--test depth_map_gpu vertices_of"];
const SAMPLES: &[&str] = &["--test depth_map_gpu of_each_sample"];
const NEAR: &[&str] = &["--test depth_map_gpu near_places", "--test depth_map_gpu near_rectangles"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "depth maps: the move by the precision of 16 bits is half of it",
        changes: &[("src/gpu/depth_map/view.rs", "[0.0, 4.0 / 65_536.0]", "[0.0, 2.0 / 65_536.0]")],
        tests: VERTICES,
    },
    Mutation {
        name: "depth maps: a move may reach the far plane",
        changes: &[
            ("wgsl/depth_map/surface.wgsl", "bias.z, 0.5 * to_far);", "bias.z, to_far);"),
            ("src/cpu/depth_map/depth_surface.rs", "constant).min(0.5 * to_far)", "constant).min(to_far)"),
        ],
        tests: VERTICES,
    },
    Mutation {
        name: "depth maps: with several bits the smaller slope counts",
        changes: &[
            ("wgsl/depth_map/surface.wgsl", "return max(slope_to(", "return min(slope_to("),
            ("src/cpu/depth_map/depth_surface.rs", "side(before).max(side(after))", "side(before).min(side(after))"),
        ],
        tests: VERTICES,
    },
    Mutation {
        name: "depth maps: walls of reversed maps are as far as those of others",
        changes: &[
            (
                "wgsl/depth_map/depth_walls.wgsl",
                "let depth = f32(select(distance, RANGE - distance, depth_map.is_reversed != 0u)) / f32(RANGE);",
                "let depth = f32(distance) / f32(RANGE);",
            ),
            (
                "src/cpu/depth_map/depth_walls.rs",
                "if map.samples.shape.is_reversed == 1 { RANGE - distance } else { distance }",
                "distance",
            ),
        ],
        tests: VERTICES,
    },
    Mutation {
        name: "depth maps: the near rectangle is looked up in the middle of a pixel of several samples",
        changes: &[("src/gpu/depth_map/pipelines.rs", "if samples > 1 { wgsl }", "if samples > 16 { wgsl }")],
        tests: SAMPLES,
    },
    Mutation {
        name: "depth maps: places on the near rectangle are looked up in the other triangle of a cell",
        changes: &[
            (
                "wgsl/depth_map/surface.wgsl",
                "select((part.x < part.y), (part.x + part.y > 1.0), is_split)",
                "select((part.x > part.y), (part.x + part.y < 1.0), is_split)",
            ),
            (
                "src/cpu/depth_map/depth_surface.rs",
                "if cell.is_split { x + y > 1.0 } else { x < y }",
                "if cell.is_split { x + y < 1.0 } else { x > y }",
            ),
        ],
        tests: NEAR,
    },
];
