//! Wrong changes to volumes from depth maps, in shader and twin alike where both have it.

use super::list::Mutation;

const LISTS: &[&str] = &["--test depth_map_cpu"];
const MERGES: &[&str] = &["--test depth_map_gpu merge"];
const CUBES: &[&str] = &["--test depth_map_gpu cube"];
const OBJECTS: &[&str] = &["--test depth_map_gpu objects"];
const DETECTORS: &[&str] = &["--test depth_map_gpu lists_of_detectors"];
const MIXED: &[&str] = &["--test shadow_gpu counts_"];
const PICTURES: &[&str] = &["--test depth_map_gpu parity", "--test depth_map_gpu shadows"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "depth maps: a difference as large as the threshold is marked",
        changes: &[
            (
                "wgsl/depth_map/edge_code.wgsl",
                "(mantissa(large) > high)",
                "((mantissa(large) > high) | ((mantissa(large) == high) & (low == 0u)))",
            ),
            ("src/cpu/depth_map/edge_code.rs", "units(large) > units(small)", "units(large) >= units(small)"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: NaN casts",
        changes: &[
            ("wgsl/depth_map/samples.wgsl", "is_far | (size > 0x7f800000u)", "is_far | (size > 0xff800000u)"),
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
                "wgsl/depth_map/depth_cells.wgsl",
                "let first = top | (splits & left)",
                "let first = (splits & top) | (splits & left)",
            ),
            (
                "wgsl/depth_map/depth_cells.wgsl",
                "(splits & right) | (~splits & left);",
                "(splits & right) | (~splits & (left | top));",
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
            ("wgsl/depth_map/edge_code.wgsl", "a != b, max(a, b) == FAR_KEY", "false, max(a, b) == FAR_KEY"),
            ("src/cpu/depth_map/edge_code.rs", "        _ => true,\n", "        _ => false,\n"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: merged maps have the farther depth",
        changes: &[
            ("wgsl/depth_map/depth_merge.wgsl", "bits_of_key(min(first, second))", "bits_of_key(max(first, second))"),
            ("src/cpu/depth_map/depth_merge.rs", ".min().unwrap_or(Key::Far)", ".max().unwrap_or(Key::Far)"),
        ],
        tests: MERGES,
    },
    Mutation {
        name: "depth maps: far texels of merged maps are at the near end",
        changes: &[(
            "wgsl/depth_map/samples.wgsl",
            "select(ONE, 0u, depth_map.is_reversed != 0u)",
            "select(0u, ONE, depth_map.is_reversed != 0u)",
        )],
        tests: MERGES,
    },
    Mutation {
        name: "depth maps: samples that maps of a cube share keep their own depths",
        changes: &[(
            "wgsl/depth_map/depth_cube.wgsl",
            "if (has_direction(face, direction)) {",
            "if (face == at.x / side + 3u * (at.y / side)) {",
        )],
        tests: CUBES,
    },
    Mutation {
        name: "depth maps: samples that maps of a cube share move with the slopes of one map",
        changes: &[(
            "wgsl/depth_map/surface.wgsl",
            "    if (is_on_border(own.at)) {\n      let direction = direction_of(own.face, own.at);\n      var most",
            "    if (own.at.x > 0x10000u) {\n      let direction = direction_of(own.face, own.at);\n      var most",
        )],
        tests: CUBES,
    },
    Mutation {
        name: "depth maps: near caps of a cube take the map that a place is nearest to",
        changes: &[("wgsl/depth_map/surface.wgsl", "if (there.w > point.w) {", "if (there.w < point.w) {")],
        tests: CUBES,
    },
    Mutation {
        name: "depth maps: cameras of a cube may see another angle",
        changes: &[(
            "src/gpu/depth_map/meeting.rs",
            "if lengths != [false; 2] {",
            "if lengths == [true; 2] && face > 6 {",
        )],
        tests: CUBES,
    },
    Mutation {
        name: "depth maps: edges of objects are not marked at the left of a cell",
        changes: &[(
            "wgsl/depth_map/depth_cells.wgsl",
            "(own.corner, far, before) & vec4<u32>(2u))",
            "(own.corner, far, before) & vec4<u32>(0u))",
        )],
        tests: OBJECTS,
    },
    Mutation {
        name: "depth maps of second differences: steps the other way are slopes",
        changes: &[
            (
                "wgsl/depth_map/edge_rule.wgsl",
                "(beside.x < beside.y) == (keys.y < keys.z)",
                "(beside.x < beside.y) != (keys.y < keys.z)",
            ),
            ("src/cpu/depth_map/edge_rule.rs", "p.cmp(&q) == a.cmp(&b)", "p.cmp(&q) != a.cmp(&b)"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps of second differences: one side is enough for both",
        changes: &[
            (
                "wgsl/depth_map/edge_rule.wgsl",
                "select(max(before, after), min(before, after), SECOND == 2u)",
                "min(before, after)",
            ),
            ("wgsl/depth_map/edge_rule.wgsl", "select(1u, 2u, SECOND == 1u)", "1u"),
            ("src/cpu/depth_map/edge_rule.rs", "bends(before) && bends(after)", "bends(before) || bends(after)"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps of second differences: floats decide what is nearly met",
        changes: &[(
            "wgsl/depth_map/edge_rule.wgsl",
            "return select(2u, select(0u, 1u, step > most), is_told);",
            "return select(0u, 1u, step > most && is_told);",
        )],
        tests: DETECTORS,
    },
    Mutation {
        name: "depth maps: thresholds are not lower next to edges that dangle",
        changes: &[
            (
                "wgsl/depth_map/edge_rule.wgsl",
                "exceeds(large, small, edge_rule.low[level])",
                "exceeds(large, small, edge_rule.low[0])",
            ),
            ("src/cpu/depth_map/edge_rule.rs", "is_above(rule.low[level])", "is_above(rule.low[0])"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: edges that dangle are continued by one cell",
        changes: &[
            ("src/gpu/depth_map/edges.rs", "(1..=continued)", "(1..=continued.min(1))"),
            ("src/gpu/depth_map/edges.rs", "1 - continued % 2", "1 - continued.min(1) % 2"),
        ],
        tests: DETECTORS,
    },
    Mutation {
        name: "depth maps of second differences: triangles beside marked edges are left out",
        changes: &[("src/gpu/depth_map/edges.rs", "u32::from(second > 0) + ", "")],
        tests: DETECTORS,
    },
    Mutation {
        name: "depth maps: shared samples of a cube have the object of the last map",
        changes: &[(
            "wgsl/depth_map/depth_cube.wgsl",
            "select(nearest, face, own < key)",
            "select(nearest, face, own != FAR_KEY)",
        )],
        tests: &["--test depth_map_gpu cube_samples"],
    },
    Mutation {
        name: "depth maps: exact sums lose what is carried twice",
        changes: &[(
            "wgsl/depth_map/edge_rule.wgsl",
            "carry = select(0u, 1u, once < digit) | select(0u, 1u, twice < once);",
            "carry = select(0u, 1u, once < digit);",
        )],
        tests: DETECTORS,
    },
    Mutation {
        name: "depth maps of second differences: samples of the next map of a cube are slopes",
        changes: &[(
            "wgsl/depth_map/depth_edges.wgsl",
            "far, rows + 2u >= vec4<u32>(side.y)",
            "far, rows > vec4<u32>(side.y)",
        )],
        tests: CUBES,
    },
    Mutation {
        name: "depth maps: strips at the bottom that are not whole are left out",
        changes: &[
            ("wgsl/depth_map/cell_words.wgsl", "in_map.y < cells.y;", "in_map.y + 3u < cells.y;"),
            ("src/cpu/depth_map/depth_cells.rs", "(0..down).step_by(4)", "(0..down / 4 * 4).step_by(4)"),
        ],
        tests: LISTS,
    },
    Mutation {
        name: "depth maps: marks take splits of other cells",
        changes: &[(
            "wgsl/depth_map/depth_edges.wgsl",
            "is_split(vec4<u32>(here.own.y, next.own.y, below.y, next_below.y))",
            "is_split(vec4<u32>(here.own.x, next.own.x, below.x, next_below.x))",
        )],
        tests: CUBES,
    },
    Mutation {
        name: "depth maps: far samples are at the far plane",
        changes: &[(
            "wgsl/depth_map/surface.wgsl",
            "  if (key == FAR_KEY) {\n    return view.far_across",
            "  if (key == FAR_KEY && view.infinity.w > 1.0) {\n    return view.far_across",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: no near cap",
        changes: &[(
            "src/gpu/depth_map/frame.rs",
            "self.near_cap.draw(pass, &own.near_cap);\n        }\n        Ok",
            "DepthMapNearCap::Lit.draw(pass, &own.near_cap);\n        }\n        Ok",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: near caps are left out where a sample is as near as a near rectangle",
        changes: &[
            ("wgsl/depth_map/depth_near.wgsl", "if (nearest <= near.key) {", "if (nearest < near.key / 2u) {"),
            ("src/cpu/depth_map/depth_near.rs", "steps <= near.key", "steps < near.key / 2"),
        ],
        tests: &["--test depth_map_gpu near_caps", "--test depth_map_gpu parity_with"],
    },
    Mutation {
        name: "depth maps: near caps are left out whatever samples away from their middle say",
        changes: &[(
            "src/gpu/depth_map/near.rs",
            "let size = range.map(|[_, count]| count);",
            "let size = range.map(|[_, count]| count.min(1));",
        )],
        tests: &["--test depth_map_gpu near_caps", "--test depth_map_gpu parity_with"],
    },
    Mutation {
        name: "depth maps: near caps are left out where the near rectangle begins before the light's near plane",
        changes: &[(
            "src/gpu/depth_map/near.rs",
            "let farthest = if depth == DepthDirection::Reversed { low[2] } else { high[2] };",
            "let farthest = if depth == DepthDirection::Reversed { high[2] } else { low[2] };",
        )],
        tests: &["--test depth_map_gpu near_caps", "--test depth_map_gpu parity_with"],
    },
    Mutation {
        name: "depth maps: near caps take the other triangle of a cell",
        changes: &[(
            "wgsl/depth_map/surface.wgsl",
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
            "wgsl/depth_map/surface.wgsl",
            "return depth + select(offset, -offset, is_reversed);",
            "return depth - select(offset, -offset, is_reversed);",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: the boundary is not moved with its slope",
        changes: &[(
            "src/gpu/depth_map/view.rs",
            "bias: [placing.slope_bias as f32,",
            "bias: [0.0 * placing.slope_bias as f32,",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps: the boundary is not moved for the map's precision",
        changes: &[("src/gpu/depth_map/view.rs", "share, constant, 0.0],", "0.0 * share, 0.0 * constant, 0.0],")],
        tests: PICTURES,
    },
    Mutation {
        name: "depth maps of bits: the boundary moves the other way",
        changes: &[(
            "src/gpu/depth_map/view.rs",
            "DMat4::from_translation(-jitter) * matrix(light)",
            "DMat4::from_translation(jitter) * matrix(light)",
        )],
        tests: &["--test depth_map_gpu parity_of_each_bit"],
    },
    Mutation {
        name: "depth maps of bits: edges beyond the cell do not matter",
        changes: &[
            ("wgsl/depth_map/edge_code.wgsl", "(0x30u << (2u * number))", "(0x0u << (2u * number))"),
            (
                "src/cpu/depth_map/edge_code.rs",
                "let beside = [[x + 1, y], [x, y + 1], [x.wrapping_sub(1), y], [x, y.wrapping_sub(1)]];",
                "let beside = [[x + 1, y], [x, y + 1]];",
            ),
        ],
        tests: &["--test depth_map_cpu cells", "--test depth_map_gpu lists_of_cells"],
    },
    Mutation {
        name: "depth maps of bits: the slope is that of one bit",
        changes: &[(
            "wgsl/depth_map/surface.wgsl",
            "  if (depth_map.spread != 0u) {\n    return max(",
            "  if (depth_map.spread > 1u) {\n    return max(",
        )],
        tests: &["--test depth_map_gpu borders_of_more"],
    },
    Mutation {
        name: "mesh depth: positions are not relative to the light's origin",
        changes: &[(
            "src/gpu/depth_map/mesh_depth.rs",
            "[x, y, z, shift - light.origin[axis]]",
            "[x, y, z, shift - 0.0 * light.origin[axis]]",
        )],
        tests: &["--test depth_map_gpu the_depth_of_a_mesh"],
    },
    Mutation {
        name: "bits of counts: volumes of meshes write every bit",
        changes: &[(
            "src/gpu/shadow/pipelines.rs",
            "stencil(count, turned, casters.most_count(format.count_bits))",
            "stencil(count, turned, casters.most_count(8))",
        )],
        tests: MIXED,
    },
    Mutation {
        name: "bits of counts: the bound is that of eight",
        changes: &[(
            "src/gpu/shadow/sizes.rs",
            "casters.most_count(self.count_bits)",
            "casters.most_count(self.count_bits.max(8))",
        )],
        tests: MIXED,
    },
    Mutation {
        name: "bits of counts: batches are resolved into every bit",
        changes: &[("src/gpu/shadow/scene_pipelines.rs", "write_mask: format.count_mask() }", "write_mask: 0xff }")],
        tests: MIXED,
    },
];
