//! Wrong changes to the stages of polygons, in shader and twin alike where both decide it.

use super::list::Mutation;

const STAGES: &[&str] = &["--test polygon_gpu", "--test polygon_cpu"];
const PICTURES: &[&str] = &["--test shadow_gpu polygons"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "polygon stages: two turns that are alike make a quadrilateral simple",
        changes: &[(
            "wgsl/polygon/polygon_turns.wgsl",
            "let facing = certain & ((up_0 & up_1 & (up_2 | up_3))",
            "let facing = certain & ((up_0 & up_1)",
        )],
        tests: STAGES,
    },
    Mutation {
        name: "polygon stages: outlines around the light are cut as if they crossed",
        changes: &[(
            "wgsl/polygon/polygon_turns.wgsl",
            "let around = (up_0 & up_2) | (down_0 & down_2);",
            "let around = 0u * ((up_0 & up_2) | (down_0 & down_2));",
        )],
        tests: STAGES,
    },
    Mutation {
        name: "polygon stages: the rightmost corner is that of the first invocation",
        changes: &[(
            "wgsl/polygon/outline.wgsl",
            "if (is_pairs || (!is_check && lane < half)) {",
            "if (is_pairs || (!is_check && lane > half)) {",
        )],
        tests: STAGES,
    },
    Mutation {
        name: "polygon stages: a corner on the right does not speak against a half-space",
        changes: &[
            ("wgsl/polygon/outline.wgsl", "&& (seen & IS_ANY_RIGHT) == 0u", "&& (seen & IS_ANY_RIGHT) != 77u"),
            ("src/cpu/polygon/half_space.rs", "..0 => return false,", "..0 => {}"),
        ],
        tests: STAGES,
    },
    Mutation {
        name: "polygon stages: twisted faces do not make boundaries of their neighbours",
        changes: &[(
            "wgsl/extract/edges.wgsl",
            "let silhouette = (counts_0 ^ counts_1) | (",
            "let silhouette = (0u & counts_0 ^ 0u & counts_1) | (",
        )],
        tests: STAGES,
    },
    Mutation {
        name: "polygon stages: the order of cuts is that of the rounded places",
        changes: &[(
            "wgsl/polygon/cut_edges.wgsl",
            "let by_turns = !is_tangled(own.row);",
            "let by_turns = own.row.cuts > 7777u && !is_tangled(own.row);",
        )],
        tests: STAGES,
    },
    Mutation {
        name: "polygon stages: invocations that share the orders of a cut do not add up what is before it",
        changes: &[("wgsl/polygon/cut_edges.wgsl", "atomicAdd(&ranks[slot], rank);", "atomicMax(&ranks[slot], rank);")],
        tests: STAGES,
    },
    Mutation {
        name: "polygon stages: an invocation takes all triangles of a polygon of few edges, on llvmpipe",
        changes: &[(
            "wgsl/polygon/outlines.wgsl",
            "return max(outline.count, outline.end_triangle - outline.first_triangle) > SMALL_OUTLINE;",
            "return outline.count > SMALL_OUTLINE;",
        )],
        tests: STAGES,
    },
    Mutation {
        name: "polygon stages: both edges of a crossing take a point of their own",
        changes: &[(
            "wgsl/polygon/list_pieces.wgsl",
            "let e = edge_at(outline.first + min(i, j));\n  let f = edge_at(outline.first + max(i, j));",
            "let e = edge_at(outline.first + i);\n  let f = edge_at(outline.first + j);",
        )],
        tests: STAGES,
    },
    Mutation {
        name: "polygon touches: ends on an edge are on its right however that runs",
        changes: &[
            (
                "wgsl/polygon/cut_edges.wgsl",
                "vec2<bool>(signs[2] > 0, signs[3] > 0), is_up)",
                "vec2<bool>(signs[2] > 0, signs[3] > 0), is_up || true)",
            ),
            (
                "src/cpu/polygon/cut_edges.rs",
                "if is_below(a, b) { side > 0 } else { side >= 0 };",
                "if is_below(a, b) || true { side > 0 } else { side >= 0 };",
            ),
        ],
        tests: STAGES,
    },
    Mutation {
        name: "polygon touches: edges in line do not cut each other where one ends",
        changes: &[
            ("wgsl/polygon/cut_edges.wgsl", "let cuts = is_before && ", "let cuts = is_before && index > 99999u && "),
            ("src/cpu/polygon/cut_edges.rs", "(is_within && precedes(", "(e > 99999 && is_within && precedes("),
        ],
        tests: STAGES,
    },
    Mutation {
        name: "polygon touches: an edge beside the end of another does not count there",
        changes: &[
            (
                "wgsl/polygon/cut_edges.wgsl",
                "if (found.is_left_at_end) {",
                "if (found.is_left_at_end && item > 99999u) {",
            ),
            ("src/cpu/polygon/cut_edges.rs", "(beyond + between) % 2 != 0", "(beyond + 2 * between) % 2 != 0"),
        ],
        tests: STAGES,
    },
    Mutation {
        name: "polygon touches: edges in line cut others in the contrary order",
        changes: &[
            (
                "wgsl/polygon/cut_order.wgsl",
                "select(is_first == (signs[0] == right_of(f)),",
                "select(is_first != (signs[0] == right_of(f)),",
            ),
            (
                "src/cpu/polygon/cut_edges.rs",
                "precedes(edges, j, i) == (of_end ==",
                "precedes(edges, j, i) != (of_end ==",
            ),
        ],
        tests: STAGES,
    },
    Mutation {
        name: "polygon touches: ends at one point are in any order",
        changes: &[
            ("wgsl/polygon/cut_order.wgsl", "return select(of_g.x + of_g.y != signs[0],", "return select(j < i,"),
            ("src/cpu/polygon/cut_edges.rs", "return of_j[0] + of_j[1] != of_end,", "return j < i && of_end != 7,"),
        ],
        tests: STAGES,
    },
    Mutation {
        name: "polygon touches: three edges never cross in one point",
        changes: &[
            (
                "wgsl/polygon/cut_order.wgsl",
                "any(abs(apart) <= vec3<f32>(ONE_POINT))",
                "any(abs(apart) <= vec3<f32>(-ONE_POINT))",
            ),
            ("src/cpu/polygon/cut_edges.rs", ".abs() <= ONE_POINT;", ".abs() <= -ONE_POINT;"),
        ],
        tests: STAGES,
    },
    Mutation {
        name: "pieces: the eye does not see through the faces that they make",
        changes: &[(
            "wgsl/shadow/piece_arguments.wgsl",
            "draws.light_cap = arguments(4u, count, true);",
            "draws.light_cap = arguments(4u, count, is_fail);",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "pieces: sides are wound the other way",
        changes: &[(
            "wgsl/shadow/pieces.wgsl",
            "drawn_side(own.view, own.light, own.face.c, own.face.b, vertex)",
            "drawn_side(own.view, own.light, own.face.b, own.face.c, vertex)",
        )],
        tests: PICTURES,
    },
    Mutation {
        name: "pieces: they have no near caps",
        changes: &[("wgsl/shadow/piece_arguments.wgsl", "let kind = near_kind(light, true, false);", "let kind = 7u;")],
        tests: PICTURES,
    },
    Mutation {
        name: "polygon depths: the first triangle of a cluster begins a polygon",
        changes: &[
            (
                "wgsl/query/shadow_pairs.wgsl",
                "let begins = ~clusters[cluster].continues &",
                "let begins = (~clusters[cluster].continues | 1u) &",
            ),
            (
                "src/cpu/query/shadow_depth.rs",
                "let begins = !cluster.continues &",
                "let begins = (!cluster.continues | 1) &",
            ),
        ],
        tests: &["--test polygon_gpu depths", "--test polygon_cpu query"],
    },
    Mutation {
        name: "polygon depths: an undecided triangle comes before all others of its polygon",
        changes: &[("wgsl/query/shadow_depth.wgsl", "!noted_odd, noted_heads ==", "noted_odd, noted_heads ==")],
        tests: &["--test polygon_gpu depths"],
    },
    Mutation {
        name: "polygon depths: a polygon begins anew with each dispatch",
        changes: &[("wgsl/query/shadow_depth.wgsl", "select(state & ODD_AT_END, bits", "select(0u, bits")],
        tests: &["--test polygon_gpu depths"],
    },
    Mutation {
        name: "polygon depths: what is counted anew does not know the dispatch before",
        changes: &[("wgsl/query/shadow_depth.wgsl", "noted.x = select(0u, 1u, begins_odd);", "noted.x = 0u;")],
        tests: &["--test polygon_gpu depths"],
    },
    Mutation {
        name: "pieces: the bound on counts leaves out those of odd numbers",
        changes: &[(
            "wgsl/shadow/piece_crossings.wgsl",
            "row, place_at(at), place_at(at + 3u), 1u);",
            "row, place_at(at), place_at(at + 3u), 1u - piece % 2u);",
        )],
        tests: &["--test shadow_gpu twist"],
    },
];
