//! Wrong changes to what comes into depth maps: distances, and the casters of scenes.

use super::list::Mutation;

const DEPTHS: &[&str] = &["--test depth_map_gpu distances_become"];
const SPECIAL: &[&str] = &["--test depth_map_gpu distances_that"];
const GROUND: &[&str] = &["--test depth_map_gpu flat_ground"];
const SCENES: &[&str] = &["--test depth_map_gpu the_depth_of_a_scene"];
const CHOSEN: &[&str] = &["--test depth_map_gpu casters_of_a_scene"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "maps of distances: those along rays are taken for those along the axis",
        changes: &[
            ("wgsl/depth_map/depth_metric.wgsl", "metric_view.metric == 2u", "metric_view.metric == 3u"),
            ("src/cpu/depth_map/depth_metric.rs", "view.metric == 2", "view.metric == 3"),
        ],
        tests: DEPTHS,
    },
    Mutation {
        name: "maps of distances: rays go through the corners of texels",
        changes: &[
            ("wgsl/depth_map/depth_metric.wgsl", "2 * vec2<i32>(at) + 1 -", "2 * vec2<i32>(at) -"),
            ("src/cpu/depth_map/depth_metric.rs", "f64::from(2 * index + 1)", "f64::from(2 * index)"),
        ],
        tests: DEPTHS,
    },
    Mutation {
        name: "maps of distances: depth of parallel rays is not linear",
        changes: &[
            ("wgsl/depth_map/depth_metric.wgsl", "metric_view.is_parallel != 0u", "metric_view.is_parallel != 1u"),
            ("src/cpu/depth_map/depth_metric.rs", "view.is_parallel == 1", "view.is_parallel == 0"),
        ],
        tests: DEPTHS,
    },
    Mutation {
        name: "maps of distances: askew parallel rays are as long as their way from the near plane",
        changes: &[(
            "src/gpu/depth_map/metric.rs",
            "inverse.z_axis.truncate().length() * clip_w",
            "clip_w / matrix.row(2).truncate().length()",
        )],
        tests: DEPTHS,
    },
    Mutation {
        name: "maps of distances: the light is at the origin of its positions",
        changes: &[(
            "src/gpu/depth_map/metric.rs",
            "let place = inverse.z_axis.truncate() / inverse.z_axis.w;",
            "let place = DVec3::ZERO;",
        )],
        tests: DEPTHS,
    },
    Mutation {
        name: "maps of distances: NaN casts",
        changes: &[
            ("wgsl/depth_map/depth_metric.wgsl", "(size > INFINITE) |", "(size > 0x7fffffffu) |"),
            ("src/cpu/depth_map/depth_metric.rs", "given.is_nan() || distance", "distance"),
        ],
        tests: SPECIAL,
    },
    Mutation {
        name: "maps of distances: what is negative is as far before the light as behind it",
        changes: &[
            ("wgsl/depth_map/depth_metric.wgsl", "(bits >> 31u) == 1u", "(bits >> 31u) == 2u"),
            ("src/cpu/depth_map/depth_metric.rs", "if given.is_sign_negative() { 0.0 } else { given }", "given.abs()"),
        ],
        tests: SPECIAL,
    },
    Mutation {
        name: "maps of distances: the boundary stays where rounding puts it",
        changes: &[("src/gpu/depth_map/view.rs", "(most[at] + off[at]) as f32", "most[at] as f32")],
        tests: GROUND,
    },
    Mutation {
        name: "depth of scenes: every chunk has the first faces of its caster",
        changes: &[
            ("wgsl/depth_map/mesh_depth.wgsl", "let face = chunk.y + corner / 3u;", "let face = corner / 3u;"),
            ("src/cpu/depth_map/mesh_depth.rs", "let face = chunk[1] + corner / 3;", "let face = corner / 3;"),
        ],
        tests: SCENES,
    },
    Mutation {
        name: "depth of scenes: transforms are left out",
        changes: &[("src/gpu/depth_map/scene_depth.rs", "caster.rows.unwrap_or(UNMOVED), light", "UNMOVED, light")],
        tests: SCENES,
    },
    Mutation {
        name: "depth of scenes: casters are left out if a corner is outside",
        changes: &[("src/gpu/depth_map/scene_depth.rs", "corners.iter().all(", "corners.iter().any(")],
        tests: &["--test depth_map_gpu light_does_not_see"],
    },
    Mutation {
        name: "depth of scenes: casters that are listed to be left out are drawn",
        changes: &[(
            "src/gpu/scene/depths.rs",
            "keys.contains(&key) != is_left_out",
            "keys.contains(&key) || is_left_out",
        )],
        tests: CHOSEN,
    },
    Mutation {
        name: "depth of scenes: casters of the light are drawn, and others are not",
        changes: &[("src/gpu/scene/depths.rs", "!caster.lights.contains(light)", "caster.lights.contains(light)")],
        tests: CHOSEN,
    },
    Mutation {
        name: "depth of scenes: singular transforms are drawn",
        changes: &[("src/gpu/scene/depths.rs", "                rigid.space?;\n", "")],
        tests: CHOSEN,
    },
];
