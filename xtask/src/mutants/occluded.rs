//! Wrong changes to what hides casters from lights, each in shader and twin alike.

use super::list::Mutation;

const TESTS: &[&str] = &["--test scene_gpu occlu", "--test scene_gpu cracks", "--test shadow_gpu occluded"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "occluded: a box may reach through the plane",
        changes: &[
            ("wgsl/scene/reach.wgsl", "if (!(behind > error)) {", "if (!(behind > error - 2.0 * abs(behind))) {"),
            (
                "src/cpu/scene/occluded.rs",
                "self.least(times(-side, cross(u, v)), first) > error",
                "self.least(times(-side, cross(u, v)), first).abs() > 0.5 * error",
            ),
        ],
        tests: TESTS,
    },
    Mutation {
        name: "occluded: only the middle of a box is looked at",
        changes: &[
            (
                "wgsl/scene/reach.wgsl",
                "return dot_3(normal, box.middle - on) - abs(dot_3(normal, box.half_x))",
                "return dot_3(normal, box.middle - on) - 0.0 * abs(dot_3(normal, box.half_x))",
            ),
            (
                "src/cpu/scene/occluded.rs",
                "let halves: [Vector; 3] = std::array::from_fn(|axis| times(half[axis],",
                "let halves: [Vector; 3] = std::array::from_fn(|axis| times(if axis == 0 { 0.0 } else { half[axis] },",
            ),
        ],
        tests: TESTS,
    },
    Mutation {
        name: "occluded: one edge does not bound",
        changes: &[
            ("wgsl/scene/reach.wgsl", "if (!(within > error) ||", "if ((number > 0u && !(within > error)) ||"),
            ("src/cpu/scene/occluded.rs", "let is_within = self.least(", "let is_within = number == 0 || self.least("),
        ],
        tests: TESTS,
    },
    Mutation {
        name: "occluded: faces of closed casters hide that do not cast",
        changes: &[("src/gpu/scene/occluders.rs", "(!is_closed || is_averted)", "(!is_closed || is_averted || true)")],
        tests: TESTS,
    },
    Mutation {
        name: "occluded: casters with excluded faces hide",
        changes: &[(
            "src/gpu/scene/occluders.rs",
            "if !caster.is_excluding() && rigid.space.is_some() {",
            "if rigid.space.is_some() {",
        )],
        tests: TESTS,
    },
    Mutation {
        name: "occluded: occluders stay where they were",
        changes: &[(
            "src/gpu/scene/encode.rs",
            "if !moved.is_empty() || !lights_moved.is_empty() {",
            "if !lights_moved.is_empty() {",
        )],
        tests: TESTS,
    },
];
