//! The table of files that load.

use super::{Good, moving, still};
use crate::maker::Maker;

/// All of them. Results of real models lie beside theirs, so no name is that of a real one.
pub const GOOD: &[Good] = &[
    good("cube.glb", still::cube, [12, 36, 8, 0, 0, 0, 0, 0, 1, 1], [1, 0, 0, 0]),
    good("colours_and_modes.glb", still::modes, [14, 24, 24, 24, 0, 0, 0, 0, 0, 3], [3, 0, 0, 0]),
    good("one_sided.glb", still::moebius, [192, 120, 120, 48, 0, 4, 0, 0, 0, 1], [1, 0, 0, 0]),
    good("sheets.glb", still::sheets, [45, 118, 35, 24, 8, 5, 0, 1, 1, 2], [2, 0, 0, 0]),
    good("parts.glb", still::parts, [3020, 2463, 1585, 140, 0, 0, 0, 0, 3, 4], [4, 0, 0, 0]),
    good("sparse.gltf", still::sparse, [24, 20, 20, 14, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0]),
    good("mirrored_scenes.gltf", still::scenes, [126, 72, 72, 16, 0, 1, 2, 0, 2, 3], [4, 0, 0, 0]),
    good("far.glb", still::far, [12, 8, 8, 0, 0, 0, 0, 0, 1, 1], [2, 0, 0, 0]),
    good("large.glb", still::large, [131_072, 65_538, 65_538, 0, 0, 0, 0, 0, 1, 1], [1, 0, 0, 0]),
    good("quantized.glb", moving::quantized, [840, 422, 422, 0, 0, 0, 0, 0, 2, 2], [4, 0, 0, 1]),
    good("interpolations.glb", moving::interpolations, [108, 72, 72, 0, 0, 0, 0, 0, 9, 9], [9, 0, 0, 9]),
    good("morphed.gltf", moving::morphed, [84, 46, 46, 0, 0, 0, 0, 0, 1, 1], [1, 0, 8, 3]),
    good("skinned.glb", moving::skinned, [324, 166, 166, 0, 0, 0, 0, 0, 2, 2], [2, 5, 0, 2]),
    good(
        "skinned_twice_morphed.glb",
        moving::skinned_twice_morphed,
        [312, 158, 158, 0, 0, 0, 0, 0, 1, 1],
        [1, 5, 1, 2],
    ),
    good("skinned_without_indices.glb", moving::without_indices, [312, 936, 158, 0, 0, 0, 0, 0, 1, 1], [1, 5, 0, 3]),
    good("skinned_instances.glb", moving::skinned_instances, [312, 158, 158, 0, 0, 0, 0, 0, 1, 1], [4, 20, 0, 1]),
];

const fn good(name: &'static str, make: fn() -> Maker, counts: [usize; 10], parts: [usize; 4]) -> Good {
    Good { name, make, counts, parts }
}
