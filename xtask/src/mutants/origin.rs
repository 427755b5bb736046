//! Wrong changes to origins of models with large coordinates, and to what cameras are refused.

use super::list::Mutation;

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "origin: lights move whatever their weight",
        changes: &[("src/origin.rs", "self.0.map(|c| w * c);", "self.0.map(|c| if w == 0.0 { 0.0 } else { c });")],
        tests: &["--lib origin"],
    },
    Mutation {
        name: "origin: vertices without faces count",
        changes: &[("src/gltf/origin.rs", ".filter(|(_, used)| *used);", ".filter(|(_, used)| *used || true);")],
        tests: &["--test gltf origin"],
    },
    Mutation {
        name: "origin: the grid is finer than numbers are",
        changes: &[("src/origin.rs", ".max(2.0 * half_step(farthest));", ".max(0.01 * half_step(farthest));")],
        tests: &["--lib origin"],
    },
    Mutation {
        name: "origin: the center of a glTF is forgotten",
        changes: &[("src/gltf/pose.rs", "self.document.center - DVec3", "DVec3::ZERO - DVec3")],
        tests: &["--test gltf origin"],
    },
    Mutation {
        name: "camera: mirror images pass",
        changes: &[("src/shadow.rs", "(true, false) => Err(CameraError::Mirrored),", "(true, false) => Ok(()),")],
        tests: &["--lib mirror", "--test shadow_gpu mirror"],
    },
    Mutation {
        name: "camera: a near plane may be as near as numbers are",
        changes: &[("src/shadow.rs", "(1023 - 110) << 52", "(1023 - 150) << 52")],
        tests: &["--lib near_planes"],
    },
];
