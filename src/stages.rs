//! The one list of stages: name, WGSL, entry points. Pipelines, labels, twins and tests go by it.

/// A stage: its WGSL file, pipeline labels, CPU twin and test carry its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// The name, also of `wgsl/SUBJECT/NAME.wgsl` and `src/cpu/SUBJECT/NAME.rs`.
    pub name: &'static str,
    /// WGSL files that make its module, in order.
    pub files: &'static [(&'static str, &'static str)],
    /// Compute entry points, which are the pipelines' labels.
    pub entry_points: &'static [&'static str],
}

macro_rules! files {
    ($($name:literal),*) => { &[$(($name, include_str!(concat!("../wgsl/", $name, ".wgsl")))),*] };
}

/// Morph, skin, displace: mesh space to world space.
pub const DEFORM: Stage =
    Stage { name: "deform", files: files!["common/common", "deform/deform"], entry_points: &["deform"] };
/// Facing masks.
pub const FACING: Stage = Stage {
    name: "facing",
    files: files!["common/common", "common/positions", "common/determinant", "common/filter", "extract/facing"],
    entry_points: &["facing"],
};
/// Exact facing of what the facing stage left undecided.
pub const EXACT_FACING: Stage = Stage {
    name: "exact_facing",
    files: files![
        "common/common",
        "common/positions",
        "common/determinant",
        "common/filter",
        "common/exact_sign",
        "common/fixed_sign",
        "extract/exact_facing"
    ],
    entry_points: &["exact_facing"],
};
/// Silhouette and winding masks from facing masks, and unordered lists.
pub const EDGES: Stage =
    Stage { name: "edges", files: files!["common/common", "extract/emit", "extract/edges"], entry_points: &["edges"] };
/// The same from positions, as published in 2003.
pub const PER_EDGE: Stage = Stage {
    name: "per_edge",
    files: files!["common/common", "common/positions", "common/determinant", "extract/emit", "extract/per_edge"],
    entry_points: &["per_edge"],
};
/// Ordered lists from masks.
pub const COMPACT: Stage = Stage {
    name: "compact",
    files: files!["common/common", "extract/compact"],
    entry_points: &["compact_count", "compact_scan", "compact_scatter"],
};
/// Indirect draw arguments from counts.
pub const ARGUMENTS: Stage =
    Stage { name: "arguments", files: files!["common/common", "extract/arguments"], entry_points: &["arguments"] };
/// The box of a caster.
pub const BOUNDS: Stage = Stage {
    name: "bounds",
    files: files!["common/common", "shadow/shadow", "shadow/caster", "shadow/bounds"],
    entry_points: &["bounds"],
};
/// Which faces cast, and how is counted.
pub const CHOOSE: Stage = Stage {
    name: "choose",
    files: files!["common/common", "shadow/shadow", "shadow/pyramid", "shadow/choose"],
    entry_points: &["choose"],
};
/// Where ZP+ as published goes over to z-fail.
pub const ZP_PLUS_2005_CASES: Stage = Stage {
    name: "zp_plus_2005_cases",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/zp_plus_2005",
        "shadow/caster",
        "shadow/zp_plus_2005_cases"
    ],
    entry_points: &["zp_plus_2005_cases"],
};
/// What no stencil count exceeds.
pub const STENCIL_BOUND: Stage = Stage {
    name: "stencil_bound",
    files: files!["common/common", "shadow/shadow", "shadow/caster", "shadow/stencil_bound"],
    entry_points: &["stencil_bound"],
};
/// Lists of the faces that caps are drawn from.
pub const CAPS: Stage = Stage {
    name: "caps",
    files: files!["common/common", "shadow/shadow", "shadow/pyramid", "shadow/casting", "shadow/caster", "shadow/caps"],
    entry_points: &["caps"],
};
/// Indirect draw arguments of shadow volumes.
pub const SHADOW_ARGUMENTS: Stage = Stage {
    name: "shadow_arguments",
    files: files!["common/common", "shadow/shadow", "shadow/casting", "shadow/shadow_arguments"],
    entry_points: &["shadow_arguments"],
};

/// Boxes around clusters of faces, for the shadow depth query.
pub const SHADOW_BOXES: Stage = Stage {
    name: "shadow_boxes",
    files: files!["common/common", "common/positions", "query/shadow_boxes"],
    entry_points: &["shadow_boxes"],
};
/// Faces strictly between points and lights.
pub const SHADOW_DEPTH: Stage = Stage {
    name: "shadow_depth",
    files: files![
        "common/common",
        "common/positions",
        "common/determinant",
        "common/filter",
        "query/shadow_segments",
        "query/shadow_pairs",
        "query/shadow_depth"
    ],
    entry_points: &["shadow_depth"],
};
/// The faces that the shadow depth stage left undecided.
pub const EXACT_SHADOW_DEPTH: Stage = Stage {
    name: "exact_shadow_depth",
    files: files![
        "common/common",
        "common/positions",
        "common/determinant",
        "common/filter",
        "common/exact_sign",
        "common/fixed_sign",
        "query/shadow_segments",
        "query/shadow_pairs",
        "query/exact_shadow_depth"
    ],
    entry_points: &["exact_shadow_depth", "exact_shadow_depth_recount"],
};
/// The indirect dispatch of what is counted anew.
pub const DEPTH_ARGUMENTS: Stage = Stage {
    name: "depth_arguments",
    files: files!["common/common", "query/depth_arguments"],
    entry_points: &["depth_arguments"],
};

/// Every stage, in the order of the data flow.
pub const STAGES: [Stage; 17] = [
    DEFORM,
    FACING,
    EXACT_FACING,
    EDGES,
    PER_EDGE,
    COMPACT,
    ARGUMENTS,
    BOUNDS,
    CHOOSE,
    ZP_PLUS_2005_CASES,
    STENCIL_BOUND,
    CAPS,
    SHADOW_ARGUMENTS,
    SHADOW_BOXES,
    SHADOW_DEPTH,
    DEPTH_ARGUMENTS,
    EXACT_SHADOW_DEPTH,
];

/// Vertex shaders of the sides of shadow volumes; [`crate::gpu::include_wgsl`] on group 1 comes after.
pub const SIDES: Stage = Stage {
    name: "sides",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/polygon",
        "shadow/zp_plus_2005",
        "shadow/side_vertices",
        "shadow/sides"
    ],
    entry_points: &["side", "side_clipped", "zp_plus_2005_side"],
};
/// Vertex shaders of the caps of shadow volumes.
pub const CAP_FACES: Stage = Stage {
    name: "cap_faces",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/polygon",
        "shadow/zp_plus_2005",
        "shadow/side_vertices",
        "shadow/casting",
        "shadow/caster",
        "shadow/cap_faces"
    ],
    entry_points: &["light_cap", "dark_cap", "near_cap", "zp_plus_2005_cap", "hole_side", "hole_side_clipped"],
};

/// WGSL that is part of no stage by itself: what callers include or replace.
pub const INCLUDES: [(&str, &str); 2] = [
    ("deform/displace", include_str!("../wgsl/deform/displace.wgsl")),
    ("extract/results", include_str!("../wgsl/extract/results.wgsl")),
];

impl Stage {
    /// The stage's whole module. The deform stage lacks its `displace`; see [`crate::displace`].
    pub fn wgsl(&self) -> String {
        self.files.iter().map(|(_, source)| *source).collect::<Vec<_>>().join("\n")
    }
}
