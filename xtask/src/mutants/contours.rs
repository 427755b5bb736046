//! Wrong changes to walls over the contours of depth maps, in shader and twin alike.

use super::list::Mutation;

const WALLS: &[&str] = &["--test depth_map_gpu walls_are"];
const PLACES: &[&str] = &["--test depth_map_cpu contours_lie", "--test depth_map_gpu volumes_have"];
/// What asks for near caps of contours.
const NEAR: &[&str] = &["--test depth_map_gpu near_rectangles_behind", "--test depth_map_gpu flaps_change"];
const PICTURES: &[&str] = &["--test depth_map_gpu contours_", "--test depth_map_gpu volumes_have"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "contours: a jump as large as the threshold is marked",
        changes: &[
            (
                "wgsl/depth_map/contour_marks.wgsl",
                "return select(0u, 2u, abs(b - a) > contour.threshold);",
                "return select(0u, 2u, abs(b - a) >= contour.threshold);",
            ),
            (
                "wgsl/depth_map/contour_marks.wgsl",
                "jump - slopes > contour.threshold;",
                "jump - slopes >= contour.threshold;",
            ),
            ("src/cpu/depth_map/contour.rs", "if (b - a).abs() <= threshold {", "if (b - a).abs() < threshold {"),
            ("src/cpu/depth_map/contour.rs", "jump - slopes > threshold", "jump - slopes >= threshold"),
        ],
        tests: WALLS,
    },
    Mutation {
        name: "contours: three samples of a plane are at a jump",
        changes: &[
            (
                "wgsl/depth_map/contour_marks.wgsl",
                "if (min(abs(jump - before), abs(jump - after)) <= contour.threshold) {",
                "if (min(abs(jump - before), abs(jump - after)) < 0) {",
            ),
            ("src/cpu/depth_map/contour.rs", "(jump - beside).abs() <= threshold)", "(jump - beside).abs() < 0)"),
        ],
        tests: WALLS,
    },
    Mutation {
        name: "contours: the slope of the farther surface does not explain a difference",
        changes: &[
            (
                "wgsl/depth_map/contour_marks.wgsl",
                "max(slope_to_step(near, away), -slope_to_step(near + away, -away))",
                "max(slope_to_step(near, away), 0)",
            ),
            (
                "src/cpu/depth_map/contour.rs",
                "self.slope(near, away).max(-self.slope(far, back))",
                "self.slope(near, away).max(0)",
            ),
        ],
        tests: WALLS,
    },
    Mutation {
        name: "contours: an invocation has too many tiles for software Vulkan",
        changes: &[(
            "wgsl/depth_map/contour_tiles.wgsl",
            "const TILES_OF_WALKERS: u32 = 2u;",
            "const TILES_OF_WALKERS: u32 = 16u;",
        )],
        tests: &["--test depth_map_gpu contours_through_every_cell"],
    },
    Mutation {
        name: "contours: segments may pass a sample",
        changes: &[
            (
                "wgsl/depth_map/contour_walls.wgsl",
                "let far = clamp(of_left + contour.sideways, LEAST, TEXEL - LEAST);",
                "let far = clamp(of_left + contour.sideways, LEAST, 2 * TEXEL);",
            ),
            (
                "src/cpu/depth_map/contour_walls.rs",
                "limit(of_left + sideways)];",
                "{ let place = (of_left + sideways).clamp(LEAST, 2 * TEXEL); [left[0] * TEXEL + step[0] * place, left[1] * TEXEL + step[1] * place] }];",
            ),
        ],
        tests: WALLS,
    },
    Mutation {
        name: "contours: flaps of walks to both sides end at other samples",
        changes: &[
            (
                "wgsl/depth_map/contour_walls.wgsl",
                "distances.y < distances.x || (distances.y == distances.x && all(right == first))",
                "distances.y < distances.x",
            ),
            (
                "src/cpu/depth_map/contour_walls.rs",
                "own_right < own_left || own_right == own_left && right == edge.at",
                "own_right < own_left",
            ),
        ],
        tests: WALLS,
    },
    Mutation {
        name: "contours: flaps begin at the last sample at one end",
        changes: &[
            (
                "wgsl/depth_map/contour_walls.wgsl",
                "    sample = before;\n",
                "    sample = select(before, sample, axis == 1u && is_right);\n",
            ),
            (
                "src/cpu/depth_map/contour_walls.rs",
                "if is_marked(self.map, self.marks, between) { sample } else { before }",
                "if is_marked(self.map, self.marks, between) || edge.axis == 1 && side == 1 { sample } else { before }",
            ),
        ],
        tests: WALLS,
    },
    Mutation {
        name: "contours: parabolas are not as bent as the contour",
        changes: &[
            (
                "wgsl/depth_map/contour_places.wgsl",
                "middle = (fourths * sums - squares * seconds) * (TEXEL / 2) / whole;",
                "middle = (fourths * sums - squares * seconds) * (TEXEL / 4) / whole;",
            ),
            (
                "src/cpu/depth_map/contour_places.rs",
                "(fourths * sums[c] - squares * seconds[c]) * (TEXEL / 2) / whole",
                "(fourths * sums[c] - squares * seconds[c]) * (TEXEL / 4) / whole",
            ),
        ],
        tests: PLACES,
    },
    Mutation {
        name: "contours: lines are not tried",
        changes: &[
            ("wgsl/depth_map/contour_places.wgsl", "const LINE: i32 = 5;", "const LINE: i32 = 50;"),
            ("src/cpu/depth_map/contour_places.rs", "const LINE: usize = 5;", "const LINE: usize = 50;"),
        ],
        tests: PLACES,
    },
    Mutation {
        name: "contours: rims are sought beyond the other side of the sample",
        changes: &[
            (
                "wgsl/depth_map/contour_rim.wgsl",
                "let slope = (conic.first + (conic.first - conic.second) / 2) >> 12u;",
                "let slope = (conic.first - (conic.first - conic.second) / 2) >> 12u;",
            ),
            (
                "src/cpu/depth_map/contour_rim.rs",
                "let slope = (conic.first + (conic.first - conic.second) / 2) >> 12;",
                "let slope = (conic.first - (conic.first - conic.second) / 2) >> 12;",
            ),
        ],
        tests: PLACES,
    },
    Mutation {
        name: "contours: the fifth sample need not lie on the conic",
        changes: &[
            (
                "wgsl/depth_map/contour.wgsl",
                "if (abs(fourth - 2 * third + second) > u * u / off) {",
                "if (abs(fourth - 2 * third + second) > 100 * u * u / off) {",
            ),
            (
                "src/cpu/depth_map/contour.rs",
                "(fourth - 2 * third + second).abs() <= u * u / off",
                "(fourth - 2 * third + second).abs() <= 100 * u * u / off",
            ),
        ],
        tests: WALLS,
    },
    Mutation {
        name: "contours: round surfaces have jumps before their rims",
        changes: &[
            ("wgsl/depth_map/contour_marks.wgsl", "const NEAR_CONIC: i32 = 8;", "const NEAR_CONIC: i32 = 100000;"),
            ("src/cpu/depth_map/contour.rs", "const NEAR_CONIC: i32 = 8;", "const NEAR_CONIC: i32 = 100_000;"),
        ],
        tests: WALLS,
    },
    Mutation {
        name: "contours: sides that are narrower than a texel are in the surface's own shadow",
        changes: &[
            ("wgsl/depth_map/contour_walls.wgsl", "const STEEP: i32 = 4;", "const STEEP: i32 = 0;"),
            ("src/cpu/depth_map/contour_walls.rs", "const STEEP: i32 = 4;", "const STEEP: i32 = 0;"),
        ],
        tests: &["--test depth_map_gpu volumes_have_no_acne"],
    },
    Mutation {
        name: "contours: a nearer surface goes on behind the other one",
        changes: &[
            (
                "wgsl/depth_map/contour_walls.wgsl",
                "own[nearer] = min(own[nearer], own[1u - nearer]);",
                "own[nearer] = min(own[nearer], own[nearer]);",
            ),
            (
                "src/cpu/depth_map/contour_walls.rs",
                "depths[side] = depths[0].min(depths[1]);",
                "depths[side] = depths[side].min(depths[side]);",
            ),
        ],
        tests: &["--test depth_map_gpu steep_surfaces"],
    },
    Mutation {
        name: "contours: surfaces end at their last sample",
        changes: &[
            (
                "wgsl/depth_map/contour_rim.wgsl",
                "  var way = way_on(at, step, place);",
                "  var way = 0 * way_on(at, step, place);",
            ),
            (
                "src/cpu/depth_map/contour_rim.rs",
                "let way = if texels > 0 { way",
                "let way = 0 * way;\n    let way = if texels > 0 { way",
            ),
        ],
        tests: PICTURES,
    },
    Mutation {
        name: "contours: no near cap",
        changes: &[(
            "src/gpu/depth_map/frame.rs",
            "self.near_cap.draw(pass, &own.near_cap);\n            return",
            "DepthMapNearCap::Lit.draw(pass, &own.near_cap);\n            return",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "contours: near caps take the surface on the other side",
        changes: &[
            ("wgsl/depth_map/depth_walls.wgsl", "place - start) < 0.0;", "place - start) >= 0.0;"),
            ("src/cpu/depth_map/contour_side.rs", ".perp_dot(place - from) < 0.0;", ".perp_dot(place - from) >= 0.0;"),
        ],
        tests: PICTURES,
    },
    Mutation {
        name: "contours: near caps leave flaps out",
        changes: &[(
            "wgsl/depth_map/depth_walls.wgsl",
            "is_behind != flaps_change(cell, found.lattice - corner, found.depth, is_behind);",
            "is_behind;",
        )],
        tests: NEAR,
    },
    Mutation {
        name: "contours: near caps look for flaps in the tile of a place alone",
        changes: &[("wgsl/depth_map/depth_walls.wgsl", "const REACH: i32 = 2;", "const REACH: i32 = 0;")],
        tests: NEAR,
    },
    Mutation {
        name: "contours: flaps take the depths of each other's vertices",
        changes: &[
            (
                "wgsl/depth_map/depth_walls.wgsl",
                "(of_b * f32(b.depth - a.depth) + of_c * f32(c.depth - a.depth))",
                "(of_c * f32(b.depth - a.depth) + of_b * f32(c.depth - a.depth))",
            ),
            (
                "src/cpu/depth_map/contour_flaps.rs",
                "of_b * (depth_b - depth) as f32 + of_c * (depth_c - depth) as f32",
                "of_c * (depth_b - depth) as f32 + of_b * (depth_c - depth) as f32",
            ),
        ],
        tests: NEAR,
    },
    Mutation {
        name: "contours: near caps take surfaces as they go on between samples, too",
        changes: &[
            (
                "wgsl/depth_map/depth_walls.wgsl",
                "if (is_marked_before(at + step, step)) {",
                "if (any(step != vec2<i32>())) {",
            ),
            (
                "src/cpu/depth_map/contour_side.rs",
                "if is_marked_before(map, marks, beside, step) {",
                "if is_marked_before(map, marks, beside, step) || true {",
            ),
        ],
        tests: &["--test depth_map_gpu join_those"],
    },
    Mutation {
        name: "contours: near caps are left out whatever flaps reach into a tile",
        changes: &[(
            "src/gpu/depth_map/near.rs",
            "if has_walls { rectangle.with_tiles() }",
            "if false { rectangle.with_tiles() }",
        )],
        tests: NEAR,
    },
];
