//! Wrong changes to the stages of clusters in scenes, each in shader and twin alike.

use super::list::Mutation;

const TESTS: &[&str] = &["--test scene_gpu clusters", "--test mesh arranged"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "scene clusters: the spread of planes is forgotten",
        changes: &[
            (
                "wgsl/scene/clusters.wgsl",
                "let is_facing = height > spread &&",
                "let is_facing = height > 0.0 * spread &&",
            ),
            ("src/cpu/scene/clusters.rs", "if height > spread &&", "if height > 0.0 * spread &&"),
        ],
        tests: TESTS,
    },
    Mutation {
        name: "scene clusters: a cluster that turns is not written",
        changes: &[
            (
                "wgsl/scene/clusters.wgsl",
                "((decision.facing ^ before.facing) & matter) == 0u;",
                "((decision.facing ^ before.facing) & matter & 0u) == 0u;",
            ),
            (
                "src/cpu/scene/clusters.rs",
                "bits[0] == 1 && bits[1] == 1 && bits[2] == bits[3]",
                "bits[0] == 1 && bits[1] == 1",
            ),
        ],
        tests: TESTS,
    },
    Mutation {
        name: "scene clusters: faces that are tested stay known",
        changes: &[
            (
                "wgsl/scene/clusters.wgsl",
                "kept[at] = (before.decided & ~matter) | decision.decided;",
                "kept[at] = before.decided | decision.decided;",
            ),
            ("src/cpu/scene/clusters.rs", "*decided = *decided & !taken | decision[0];", "*decided |= decision[0];"),
        ],
        tests: TESTS,
    },
    Mutation {
        name: "scene clusters: bounds at rest hold for positions in buffers",
        changes: &[
            (
                "wgsl/scene/table.wgsl",
                "return caster_part(caster, 7u).w != NO_CLUSTERS && (caster_part(caster, 4u).w & RIGID) != 0u;",
                "return caster_part(caster, 7u).w != NO_CLUSTERS;",
            ),
            (
                "src/cpu/scene/clusters.rs",
                "caster.clusters_or_figure != u32::MAX && caster.flags & 4 != 0",
                "caster.clusters_or_figure != u32::MAX",
            ),
        ],
        tests: TESTS,
    },
    Mutation {
        name: "scene clusters: what an older layout knew holds",
        changes: &[("wgsl/scene/clusters.wgsl", "if (kept[0] == group.structure) {", "if (kept[0] != 0u) {")],
        tests: TESTS,
    },
    Mutation {
        name: "scene clusters: edges between clusters that differ are spared",
        changes: &[
            ("wgsl/scene/chunks.wgsl", "(wanted & facing & averted) == 0u;", "(wanted & facing & averted & 0u) == 0u;"),
            (
                "src/cpu/scene/chunks.rs",
                "sides.windows(2).all(|pair| pair[0] == pair[1])",
                "sides.windows(2).all(|pair| pair[0] < 2)",
            ),
        ],
        tests: TESTS,
    },
    Mutation {
        name: "scene clusters: boundary edges are spared",
        changes: &[("src/mesh/clusters/arranged.rs", "return Spared::Never;", "return Spared::Decided;")],
        tests: TESTS,
    },
    Mutation {
        name: "scene clusters: faces that callers exclude have the numbers of the mesh",
        changes: &[(
            "src/gpu/scene/scene.rs",
            "order.map_or_else(|| faces.into(), |order| order.slots(faces).into())",
            "order.map_or_else(|| faces.into(), |_| faces.into())",
        )],
        tests: &["--test scene_gpu"],
    },
    Mutation {
        name: "scene clusters: decided bits are not written",
        changes: &[(
            "wgsl/scene/many_casters.wgsl",
            "(bits & ~decided) | decided_facing;",
            "bits | (decided_facing & 0u);",
        )],
        tests: TESTS,
    },
];
